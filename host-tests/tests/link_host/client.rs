//! Tries, refusals, silence.

use hysteron::control::Path;
use hysteron::link::Command;
use hysteron::record::{Effect, ModelRecord};
use hysteron::reference::{Tone, Waveform};
use hysteron::safety::State;
use hysteron_host::link::Client;
use hysteron_host::link::model::{self, Choice};
use hysteron_host::model_file::builtin;

use crate::support::{Fault, Line, bench, client, message};

fn start() -> Command {
    let tone = |amplitude| Tone {
        amplitude,
        frequency_hz: 10.0,
    };
    Command::Start {
        path: Path::Compensated,
        waveform: Waveform::Tones {
            offset: 0.0,
            tones: [tone(20.0), tone(0.0)],
        },
        samples: 0,
    }
}

#[test]
fn commands_come_through_a_bad_line() {
    for fault in [
        Fault::DamageRequests(2),
        Fault::DamageReplies(2),
        Fault::LoseReplies(2),
        Fault::DamageRequests(3),
        Fault::LoseReplies(3),
    ] {
        let mut line = Line::new(bench());
        client(&mut line);
        line.fault = Some(fault);
        let (mut client, _) = Client::connect(&mut line).unwrap();
        let settings = client.settings().unwrap();
        let record = model::record(&builtin("p753").unwrap(), &settings, Choice::Explicit)
            .unwrap()
            .record;
        client
            .tell(Command::SetModel(Some(record.clone())))
            .unwrap();
        assert_eq!(client.model().unwrap(), Some(record));
        // A start whose reply is lost is refused when it comes again, and yet it was carried out.
        for _ in 0..4 {
            client.tell(start()).unwrap();
            client.wait(std::time::Duration::from_millis(5)).unwrap();
            assert_eq!(client.statistics().unwrap().state, State::Run);
            client.stop().unwrap();
            client.wait(std::time::Duration::from_millis(5)).unwrap();
            assert_eq!(client.statistics().unwrap().state, State::Off);
        }
    }
}

#[test]
fn a_silent_target_is_told_as_such() {
    let mut line = Line::new(bench());
    line.fault = Some(Fault::DamageRequests(1));
    assert!(message(Client::connect(&mut line).map(|_| ())).contains("does not answer"));
}

#[test]
fn refusals_say_what_to_do() {
    let mut bench = bench();
    let mut client = client(&mut bench);
    let refused = message(client.tell(start()));
    assert!(refused.contains("no model"), "{refused}");
    let mut settings = client.settings().unwrap();
    settings.ramp_v_per_s = f32::NAN;
    let refused = message(client.tell(Command::SetSettings(settings)));
    assert!(refused.contains("ramp_v_per_s"), "{refused}");
    let mut record = model::record(&builtin("p753").unwrap(), &settings, Choice::Explicit)
        .unwrap()
        .record;
    if let ModelRecord::Chain(chain) = &mut record {
        let effects = [Effect::Cubic { c: 0.0 }, Effect::Quadratic { q: 0.0 }];
        chain.effects.extend(effects);
    }
    let refused = message(client.tell(Command::SetModel(Some(record))));
    assert!(refused.contains("effect 1"), "{refused}");
    assert_eq!(client.model().unwrap(), None);
}
