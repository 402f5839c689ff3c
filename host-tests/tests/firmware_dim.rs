//! DIM in the tick: its drive, what begins anew with a motion, records that are refused.

mod firmware_rig;
mod paper_m;

use firmware_rig::{Rig, bipolar, modified_play, published, sine};
use hysteron::control::Path;
use hysteron::dim::Law;
use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::modified_play::{Harmonics, Terms};
use hysteron::link::{Answer, Command, Refusal};
use hysteron::record::{ModelRecord, ModifiedPlayRecord, RecordError};
use hysteron::safety::State;
use hysteron::settings::Settings;
use paper_m::{DT, Textbook};
use std::f64::consts::TAU;

/// Wide, and at paper M's sample rate.
fn settings() -> Settings {
    Settings {
        sample_rate_hz: 5_000.0,
        drive_min_v: -50.0,
        drive_max_v: 50.0,
        slew_v_per_s: 1e6,
        ..bipolar()
    }
}

/// The rig's model at that rate, without offset.
fn at_5_khz(law: Law, harmonics: Harmonics) -> ModelRecord {
    let mut record = modified_play(10, law, harmonics);
    if let ModelRecord::ModifiedPlay(model) = &mut record {
        (model.sample_time_s, model.offset_um) = (2e-4, 0.0);
    }
    record
}

/// The equations of the paper with the numbers of a record.
fn textbook(record: &ModelRecord) -> Textbook {
    let ModelRecord::ModifiedPlay(ModifiedPlayRecord {
        u_max_v,
        slopes_um_per_v,
        alpha_s,
        beta_s,
        interleaving_per_v,
        feedback,
        frequency_hz,
        sine,
        cosine,
        ..
    }) = record
    else {
        panic!("no modified play model")
    };
    let n = slopes_um_per_v.len();
    let u_max = f64::from(*u_max_v);
    let wide = |list: &[f32; 3]| list.map(f64::from);
    let omega = slopes_um_per_v.iter().enumerate().map(|(i, &slope)| {
        let reach = u_max * (1.0 - i as f64 / n as f64);
        vec![f64::from(slope) * reach / (n - i) as f64; n - i]
    });
    Textbook {
        n,
        u_max,
        alpha: f64::from(*alpha_s),
        beta: f64::from(*beta_s),
        frequency: f64::from(*frequency_hz),
        clamped: false,
        gain: f64::from(slopes_um_per_v[0]),
        omega: omega.collect(),
        terms: Terms {
            interleaving: f64::from(*interleaving_per_v),
            feedback: wide(feedback),
            sine: wide(sine),
            cosine: wide(cosine),
        },
        q: vec![0.0; n],
        u: vec![],
        y: vec![],
    }
}

/// The drive of a code of the 16-bit converter, +-5 V, behind an amplifier.
fn drive(code: u16, settings: &Settings) -> f64 {
    let converter = f64::from(code) / 65_536.0 * 10.0 - 5.0;
    converter * f64::from(settings.amplifier_gain) + f64::from(settings.amplifier_offset_v)
}

/// The codes that come out, put into the paper's equations, give the reference back.
#[test]
fn the_drive_of_the_exact_law_makes_the_reference() {
    let settings = settings();
    let record = at_5_khz(Law::Exact, Harmonics::Printed);
    let mut book = textbook(&record);
    let mut rig = Rig::new(settings);
    rig.tell(Command::SetModel(Some(record)));
    // The sample after a swap obeys no order.
    rig.tick();
    rig.start(Path::Compensated, sine(20.0, 50.0));
    let mut drives = [0.0; 2];
    let mut worst = 0.0f64;
    for k in 0..5_000 {
        let reference = 20.0 * (TAU * 50.0 * f64::from(k) * DT).sin();
        let u = drive(rig.tick().code, &settings);
        let y = book.step(u, (drives[0] - drives[1]) / DT);
        drives = [u, drives[0]];
        worst = worst.max((y - reference).abs());
    }
    println!("largest error {worst:e} um");
    // A code is 1.5 mV, and the steepest slope 2.2 um/V before the feedback.
    assert!(worst < 5e-3, "{worst}");
}

#[test]
fn the_angle_begins_with_the_motion() {
    let mut record = at_5_khz(Law::Exact, Harmonics::Corrected);
    if let ModelRecord::ModifiedPlay(model) = &mut record {
        // No memory but the angle.
        let plays = model.slopes_um_per_v.iter_mut().skip(1);
        plays.for_each(|slope| *slope = 0.0);
        (model.interleaving_per_v, model.feedback) = (0.0, [0.0; 3]);
        (model.sine, model.cosine) = ([5.0, 0.0, 0.0], [0.0; 3]);
    }
    let settings = settings();
    let mut rig = Rig::new(settings);
    rig.tell(Command::SetModel(Some(record)));
    rig.tick();
    let mut motions = vec![];
    for _ in 0..2 {
        rig.start(Path::Compensated, sine(0.0, 10.0));
        let codes: Vec<u16> = rig.ticks(137).iter().map(|output| output.code).collect();
        motions.push(codes);
        rig.tell(Command::Stop);
        while rig.statistics().state != State::Off || rig.last.driver_enabled {
            rig.tick();
        }
    }
    assert_eq!(motions[0], motions[1]);
    // It is the sine of the harmonic term over 2A = 0.7 um/V.
    for (k, &code) in motions[0].iter().enumerate() {
        let expected = -5.0 / 0.7 * (TAU * 50.0 * k as f64 * DT).sin();
        assert!((drive(code, &settings) - expected).abs() < 2e-3, "{k}");
    }
}

/// The rig watches every step.
#[test]
fn models_of_both_kinds_are_swapped_without_a_jump() {
    let mut rig = Rig::new(bipolar());
    let models = [
        published(),
        modified_play(10, Law::Exact, Harmonics::Corrected),
        modified_play(16, Law::Printed, Harmonics::Printed),
    ];
    rig.tell(Command::SetModel(Some(models[0].clone())));
    rig.start(Path::Compensated, sine(20.0, 20.0));
    for (pause, model) in [131, 97, 61, 89, 113]
        .into_iter()
        .zip(models.iter().cycle())
    {
        rig.ticks(pause);
        rig.tell(Command::SetModel(Some(model.clone())));
    }
    rig.ticks(500);
    assert_eq!(rig.statistics().state, State::Run);
}

#[test]
fn records_that_cannot_be_inverted_are_refused() {
    let mut rig = Rig::new(bipolar());
    let mut refused = |record: ModelRecord, error: RecordError| {
        let answer = rig.ask(Command::SetModel(Some(record)));
        assert_eq!(answer, Answer::Refused(Refusal::Model(error)));
    };
    // 5 kHz where the settings have 10.
    refused(
        at_5_khz(Law::Exact, Harmonics::Printed),
        RecordError::SampleTime,
    );
    let with_slope = |slope: f32, law: Law| {
        let mut record = modified_play(10, law, Harmonics::Printed);
        if let ModelRecord::ModifiedPlay(model) = &mut record {
            model.slopes_um_per_v[0] = slope;
        }
        record
    };
    let parameter = |error| RecordError::Parameter(error);
    let bent = ParameterError::NotMonotone(Field::Slopes, 1);
    refused(with_slope(-0.2, Law::Exact), parameter(bent));
    let zero = ParameterError::Zero(Field::Slopes);
    refused(with_slope(0.0, Law::Printed), parameter(zero));
    let nan = ParameterError::NotFinite(Field::Slopes, 0);
    refused(with_slope(f32::NAN, Law::Exact), parameter(nan));
    rig.tell(Command::SetModel(Some(with_slope(-0.2, Law::Printed))));

    // The largest one fits into a frame and comes back.
    let largest = modified_play(16, Law::Exact, Harmonics::Corrected);
    rig.tell(Command::SetModel(Some(largest.clone())));
    assert_eq!(rig.ask(Command::GetModel), Answer::Model(Some(largest)));
}
