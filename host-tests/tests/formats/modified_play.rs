//! The stage that is a whole model.

use hysteron_host::model_file::{Law, parse};

use crate::model_file::MODEL;

const MODIFIED_PLAY: &str = r#"
[[stage]]
name = "modified-play"
sample_time_s = 0.0002
u_max_v = 5.0
slopes_um_per_v = [4.0, 0.5]
offset_um = 0.0
alpha_s = 0.0001
beta_s = 0.0002
interleaving_per_v = 0.001
feedback = [0.3, 0.1, 0.0]
frequency_hz = 25.0
harmonics = "corrected"
sine = [0.1, 0.0, 0.0]
cosine = [0.0, 0.0, 0.0]
law = "exact"
"#;

#[test]
fn a_modified_play_model_stands_alone() {
    let (head, stages) = MODEL.split_at(MODEL.find("\n[[stage]]").unwrap());
    let text = format!("{head}{MODIFIED_PLAY}");
    let model = parse(&text, "m.toml").unwrap();
    assert_eq!(model.to_toml_string(), text);
    assert_eq!(model.hysteresis(), None);
    let stage = model.modified_play().unwrap();
    assert_eq!((stage.law, stage.feedback), (Law::Exact, [0.3, 0.1, 0.0]));
    assert_eq!(model.parameters()["law"], "exact");
    let flat = model.clone().rate_independent();
    let flat = flat.modified_play().unwrap();
    assert_eq!((flat.alpha_s, flat.beta_s), (0.0, 0.0));

    let refused = |text: &str| parse(text, "m.toml").unwrap_err().to_string();
    let both = format!("{head}{stages}{MODIFIED_PLAY}");
    let alone = "stage modified-play is a whole model; leave the other stages out";
    assert_eq!(refused(&both), format!("m.toml:26: {alone}"));
    let twice = format!("{head}{MODIFIED_PLAY}{MODIFIED_PLAY}");
    assert_eq!(refused(&twice), format!("m.toml:10: {alone}"));
    for (from, to, message) in [
        (
            "25.0",
            "inf",
            "m.toml:20: modified-play.frequency_hz: inf is not a finite number; write one",
        ),
        (
            "[0.1, 0.0, 0.0]",
            "[0.1, nan, 0.0]",
            "m.toml:22: modified-play.sine[1]: NaN is not a finite number; write one",
        ),
        (
            "\"exact\"",
            "\"good\"",
            "m.toml:24: stage[0].law: unknown variant `good`, expected `printed` or `exact`",
        ),
    ] {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        assert_eq!(refused(&text.replace(from, to)), message);
    }
}
