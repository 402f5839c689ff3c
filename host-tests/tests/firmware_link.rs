//! Frames and commands: hostile bytes, refusals, and that a refusal changes nothing.

mod firmware_rig;

use firmware_rig::{Rig, bipolar, model, published, sine, with};
use hysteron::control::Path;
use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::preview::PlantRate;
use hysteron::link::{
    Answer, BODY_LEN, CHUNK_LEN, Command, FRAME_LEN, FrameError, Message, Refusal, Request, decode,
    encode,
};
use hysteron::record::{AsymmetryRecord, EFFECTS, Effect, Inverse, Preview, RecordError};
use hysteron::safety::State;
use hysteron::settings::{Settings, SettingsError};
use proptest::prelude::*;
use rand::{Rng, SeedableRng, rngs::SmallRng};

/// What a host can read back, less the counters that only ever grow.
fn everything(rig: &mut Rig) -> (Answer, Answer, State, u32) {
    let statistics = rig.statistics();
    (
        rig.ask(Command::GetSettings),
        rig.ask(Command::GetModel),
        statistics.state,
        statistics.played,
    )
}

/// CRC-32 as its definition has it, bit by bit.
fn crc_32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 }
        })
    })
}

/// COBS as its definition has it: each zero becomes the distance to the next one.
fn cobs(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for block in bytes.split(|&byte| byte == 0) {
        let mut rest = block;
        while rest.len() >= 254 {
            out.push(255);
            out.extend_from_slice(&rest[..254]);
            rest = &rest[254..];
        }
        out.push(rest.len() as u8 + 1);
        out.extend_from_slice(rest);
    }
    out.push(0);
    out
}

fn framed(body: &[u8]) -> Vec<u8> {
    let mut plain = vec![2];
    plain.extend_from_slice(body);
    plain.extend_from_slice(&crc_32(&plain).to_le_bytes());
    cobs(&plain)
}

#[test]
fn a_frame_has_the_documented_bytes() {
    // Sequence 300 as a varint, command 12 (statistics).
    let request = Request {
        sequence: 300,
        command: Command::Statistics,
    };
    let mut frame = [0; FRAME_LEN];
    let len = encode(&request, &mut frame).unwrap();
    assert_eq!(frame[..len], framed(&[0xac, 0x02, 12]));
    // A stream: number 7 and the samples 1.0 and -2.0.
    let request = Request {
        sequence: 1,
        command: Command::Stream {
            first: 7,
            samples: heapless::Vec::from_slice(&[1.0, -2.0]).unwrap(),
        },
    };
    let len = encode(&request, &mut frame).unwrap();
    let body = [1, 10, 7, 2, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0];
    assert_eq!(frame[..len], framed(&body));
}

#[test]
fn a_million_hostile_frames_change_nothing() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(published())));
    let before = everything(&mut rig);
    let mut random = SmallRng::seed_from_u64(1);
    let good: Vec<Vec<u8>> = [
        Command::Start {
            path: Path::Direct,
            waveform: sine(40.0, 100.0),
            samples: 0,
        },
        Command::SetSettings(Settings::default()),
        Command::SetModel(None),
        Command::Hold,
        Command::ResetStream,
    ]
    .map(|command| rig.frame(command))
    .to_vec();
    let mut replies = 0;
    for round in 0..1_000_000 {
        let mut frame = match round % 4 {
            // Noise.
            0 => (0..random.random_range(0..40))
                .map(|_| random.random())
                .collect(),
            // A good frame with some bits turned.
            1 => {
                let mut frame = good[random.random_range(0..good.len())].clone();
                for _ in 0..random.random_range(1..4) {
                    let at = random.random_range(0..frame.len());
                    frame[at] ^= 1 << random.random_range(0..8);
                }
                if good.contains(&frame) {
                    continue; // the same bit, turned twice
                }
                frame
            }
            // One that was cut off.
            2 => {
                let mut frame = good[random.random_range(0..good.len())].clone();
                frame.truncate(random.random_range(0..frame.len() - 1));
                frame
            }
            // A whole frame around noise; a body that starts with a valid command is left out.
            _ => {
                let mut body: Vec<u8> = (0..random.random_range(0..30))
                    .map(|_| random.random())
                    .collect();
                if let Some(first) = body.get_mut(1) {
                    *first |= 0x10;
                }
                if let Some(first) = body.first_mut() {
                    *first &= 0x7f;
                }
                framed(&body)
            }
        };
        frame.push(0);
        for message in rig.feed(&frame) {
            replies += 1;
            assert!(
                matches!(
                    message,
                    Message::Reply {
                        answer: Answer::Refused(Refusal::Unknown),
                        ..
                    }
                ),
                "{message:?} to {frame:x?}"
            );
        }
        if round % 16 == 0 {
            rig.tick();
        }
    }
    assert!(replies > 100_000);
    assert_eq!(everything(&mut rig), before);
    assert!(rig.statistics().bad_frames > 700_000);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn no_whole_frame_panics(body in prop::collection::vec(any::<u8>(), 0..BODY_LEN)) {
        let mut frame = framed(&body);
        frame.pop();
        let decoded = decode::<Request>(&mut frame);
        prop_assert!(matches!(decoded, Ok(_) | Err(FrameError::Body)));
    }

    #[test]
    fn any_command_that_decodes_is_survived(
        // All but settings, after which the rig would have to watch other bounds.
        variant in prop_oneof![0u8..2, 3u8..13], body in prop::collection::vec(any::<u8>(), 0..80), ticks in 0usize..4,
    ) {
        let mut rig = Rig::new(bipolar());
        let mut whole = vec![5, variant];
        whole.extend(body);
        for cut in 2..=whole.len() {
            rig.feed(&framed(&whole[..cut]));
            rig.ticks(ticks);
        }
    }
}

#[test]
fn an_endless_frame_is_one_bad_frame() {
    let mut rig = Rig::new(bipolar());
    let mut bytes = vec![7; 3 * FRAME_LEN];
    bytes.push(0);
    assert_eq!(rig.feed(&bytes), []);
    assert_eq!(rig.statistics().bad_frames, 1);
}

#[test]
fn another_version_is_told_so() {
    let mut rig = Rig::new(bipolar());
    let mut plain = vec![1, 5, 0];
    plain.extend_from_slice(&crc_32(&plain).to_le_bytes());
    let reply = Message::Reply {
        sequence: 0,
        answer: Answer::Refused(Refusal::Unknown),
    };
    assert_eq!(rig.feed(&cobs(&plain)), [reply]);
}

#[test]
fn bad_settings_and_models_leave_the_old_ones_in_force() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(published())));
    let before = everything(&mut rig);
    let settings = Settings {
        slew_v_per_s: f32::NAN,
        ..bipolar()
    };
    assert_eq!(
        rig.ask(Command::SetSettings(settings)),
        Answer::Refused(Refusal::Settings(SettingsError::Slew))
    );
    let refused = |error| Answer::Refused(Refusal::Model(error));
    let falling = model(&[2.0, 1.0], &[1.0, 0.1, 0.1], 0.0, 1.0);
    assert_eq!(
        rig.ask(Command::SetModel(Some(falling))),
        refused(RecordError::Parameter(ParameterError::NotIncreasing(
            Field::Thresholds,
            1
        )))
    );
    let nan = model(&[1.0], &[1.0, f32::NAN], 0.0, 1.0);
    assert_eq!(
        rig.ask(Command::SetModel(Some(nan))),
        refused(RecordError::Parameter(ParameterError::NotFinite(
            Field::Weights,
            1
        )))
    );
    let effects = |effects: &[Effect]| {
        with(published(), |chain| {
            chain.effects = heapless::Vec::from_slice(effects).unwrap();
        })
    };
    let mode = Effect::Resonance {
        f_n_hz: 300.0,
        zeta: 0.02,
    };
    let lag = Effect::AmplifierLag { tau_s: 1e-4 };
    for (list, error) in [
        (&[mode, lag][..], RecordError::Order(1)),
        (&[lag, lag], RecordError::Order(1)),
        (
            &[mode, Effect::Backlash { width: 1.0 }],
            RecordError::Order(1),
        ),
        (
            &[Effect::Interleaving { g: 1e-3 }, mode],
            RecordError::Order(1),
        ),
        (
            &[Effect::Backlash { width: -1.0 }],
            RecordError::Parameter(ParameterError::Negative(Field::Width)),
        ),
        (
            &[mode, mode, mode, mode],
            RecordError::Parameter(ParameterError::TooLarge(Field::Modes)),
        ),
        (
            &[Effect::TransportDelay { delay_s: 3e-3 }],
            RecordError::Parameter(ParameterError::TooLarge(Field::Delay)),
        ),
    ] {
        assert_eq!(
            rig.ask(Command::SetModel(Some(effects(list)))),
            refused(error)
        );
    }
    for window in [0, 1, 27, 255] {
        let preview = Preview {
            window,
            plant_rate: PlantRate::Midpoint,
        };
        let record = with(published(), |chain| {
            chain.inverse = Inverse::Preview(preview);
        });
        assert_eq!(
            rig.ask(Command::SetModel(Some(record))),
            refused(RecordError::Window)
        );
    }
    assert_eq!(everything(&mut rig), before);
}

#[test]
fn the_largest_model_fits_into_a_frame_and_comes_back() {
    let thresholds: Vec<f32> = (1..=16).map(|i| i as f32).collect();
    let record = model(&thresholds, &[1.0; 17], 1e-3, 1.0);
    let zones = hysteron::record::Zones {
        thresholds: heapless::Vec::from_slice(&[1.0, 2.0, 3.0, 4.0]).unwrap(),
        slopes: heapless::Vec::from_slice(&[1.0; 5]).unwrap(),
    };
    let creep = Effect::Creep {
        gain_per_decade: 0.01,
        tau_min_s: 0.01,
        tau_max_s: 1e5,
    };
    let full = |chain: &mut hysteron::record::ChainRecord| {
        chain.asymmetry = Some(AsymmetryRecord {
            positive: zones.clone(),
            negative: zones,
        });
        chain.effects.push(creep).unwrap();
        chain.inverse = Inverse::Cascade(Preview {
            window: 26,
            plant_rate: PlantRate::Backward,
        });
    };
    let record = with(record, full);
    // As long as a record can be, though one with so much creep is refused.
    let longest = with(record.clone(), |chain| {
        chain.effects = heapless::Vec::from_slice(&[creep; EFFECTS]).unwrap();
    });
    let command = Command::SetModel(Some(longest));
    let request = Request {
        sequence: u16::MAX,
        command,
    };
    assert!(encode(&request, &mut [0; FRAME_LEN]).is_ok());
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(record.clone())));
    assert_eq!(rig.ask(Command::GetModel), Answer::Model(Some(record)));
}

#[test]
fn settings_change_only_at_rest() {
    let mut rig = Rig::new(bipolar());
    rig.start(Path::Direct, sine(40.0, 10.0));
    rig.ticks(300);
    let refused = Answer::Refused(Refusal::State);
    assert_eq!(rig.ask(Command::SetSettings(Settings::default())), refused);
    rig.tell(Command::Stop);
    rig.ticks(2);
    assert_eq!(rig.ask(Command::SetSettings(Settings::default())), refused);
    rig.ticks(2_000);
    let slower = Settings {
        sample_rate_hz: 5_000.0,
        ..bipolar()
    };
    rig.tell(Command::SetSettings(slower));
    assert_eq!(rig.ask(Command::GetSettings), Answer::Settings(slower));
}

#[test]
fn a_stream_is_numbered_and_throttled() {
    let mut rig = Rig::new(bipolar());
    let chunk = [1.0; CHUNK_LEN];
    let mut next = 0;
    // 1023 samples fit.
    for _ in 0..16 {
        match rig.stream(next, &chunk) {
            Answer::Stream { next: now, free } => {
                assert_eq!(u32::from(free), 1023 - now);
                next = now;
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(next, 1023);
    assert_eq!(rig.stream(1024, &chunk), Answer::Refused(Refusal::Gap));
    assert_eq!(
        rig.stream(1023, &[f32::NAN]),
        Answer::Refused(Refusal::NotFinite)
    );
    // A repeated chunk does no harm.
    assert_eq!(
        rig.stream(960, &chunk),
        Answer::Stream {
            next: 1023,
            free: 0
        }
    );
    rig.tell(Command::ResetStream);
    let busy = rig.ask(Command::Start {
        path: Path::Direct,
        waveform: hysteron::reference::Waveform::Stream,
        samples: 0,
    });
    assert_eq!(busy, Answer::Refused(Refusal::Busy));
    rig.ticks(128);
    assert_eq!(
        rig.stream(0, &[3.0]),
        Answer::Stream {
            next: 1,
            free: 1022
        }
    );
    rig.start(Path::Direct, hysteron::reference::Waveform::Stream);
    rig.tick();
    assert_eq!(rig.statistics().played, 1);
}
