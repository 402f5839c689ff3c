//! Model files: read, written, refused, built in.

use hysteron_host::model_file::{
    AmplifierLag, Asymmetry, BUILTIN_NAMES, Backlash, BoucWen, Congruency, Creep, Cubic, Drift,
    Harmonics, Hysteresis, Interleaving, Law, MainsHum, ModelFile, ModifiedPlay, Output, Quadratic,
    Quantisation, RateLaw, Resonance, Saturation, SensorLag, SlewLimit, Stage, TransportDelay,
    TwoSided, builtin, load, parse, resolve,
};
use proptest::prelude::*;

use crate::support::Folder;

pub const MODEL: &str = r#"format = "hysteron-model"
version = 1
name = "stage A"

[units]
time = "s"
drive = "V"
displacement = "um"

[[stage]]
name = "hysteresis"
thresholds_v = [9.715, 19.43]
weights = [0.7236, 0.2906, -0.0416]
beta_s = 0.0008572

[[stage]]
name = "asymmetry"
thresholds = { positive = [10.0], negative = [] }
slopes = { positive = [1.0, 0.125], negative = [0.5] }

[[stage]]
name = "output"
gain_um_per_v = 12.5
offset_um = -1e-7
"#;

fn expected() -> ModelFile {
    ModelFile::new(
        "stage A",
        vec![
            Stage::Hysteresis(Hysteresis {
                thresholds_v: vec![9.715, 19.43],
                weights: vec![0.7236, 0.2906, -0.0416],
                beta_s: 8.572e-4,
            }),
            Stage::Asymmetry(Asymmetry {
                thresholds: TwoSided {
                    positive: vec![10.0],
                    negative: vec![],
                },
                slopes: TwoSided {
                    positive: vec![1.0, 0.125],
                    negative: vec![0.5],
                },
            }),
            Stage::Output(Output {
                gain_um_per_v: 12.5,
                offset_um: -1e-7,
            }),
        ],
    )
}

#[test]
fn text_and_model_agree() {
    let model = parse(MODEL, "m.toml").unwrap();
    assert_eq!(model, expected());
    assert_eq!(model.to_toml_string(), MODEL);
    assert_eq!(model.output(), (12.5, -1e-7));
    assert_eq!(model.hysteresis().unwrap().thresholds_v, [9.715, 19.43]);
    assert_eq!(model.asymmetry().unwrap().slopes.negative, [0.5]);
    let folder = Folder::new(&[("m.toml", MODEL.as_bytes())]);
    assert_eq!(load(folder.path("m.toml")).unwrap(), model);
    assert_eq!(
        resolve(folder.path("m.toml").to_str().unwrap()).unwrap(),
        model
    );
}

#[test]
fn integers_windows_lines_and_a_byte_order_mark_are_read() {
    let text = MODEL.replace("[10.0]", "[10]").replace('\n', "\r\n");
    let folder = Folder::new(&[("m.toml", format!("\u{feff}{text}").as_bytes())]);
    assert_eq!(load(folder.path("m.toml")).unwrap(), expected());
}

#[test]
fn refusals() {
    let second = "[[stage]]\nname = \"hysteresis\"\nthresholds_v = []\nweights = [1.0]\nbeta_s = 0\n[[stage]]\nname = \"asymmetry\"";
    let cases = [
        (
            "format = \"hysteron-model\"\n",
            "",
            "m.toml:1: not a model file: there is no format = \"hysteron-model\"; add it or name another file",
        ),
        (
            "\"hysteron-model\"",
            "\"other\"",
            "m.toml:1: not a model file: format is not \"hysteron-model\"; name another file",
        ),
        (
            "version = 1",
            "version = 2\nfuture = true",
            "m.toml:2: model version 2 is newer than this program knows (1); use a newer program",
        ),
        (
            "version = 1",
            "version = 0",
            "m.toml:2: there is no model version 0; write version = 1",
        ),
        (
            "version = 1",
            "version = 99999999999999999999",
            "m.toml:2: model version 9223372036854775807 is newer than this program knows (1); use a newer program",
        ),
        (
            "version = 1",
            "version = \"1\"",
            "m.toml:2: version: invalid type: string \"1\", expected u32",
        ),
        ("version = 1\n", "", "m.toml:1: missing field `version`"),
        (
            "version = 1",
            "version = 1\nauthor = \"me\"",
            "m.toml:3: unknown field `author`, expected one of `format`, `version`, `name`, `units`",
        ),
        (
            "time = \"s\"",
            "time = \"ms\"",
            "m.toml:6: units.time: unknown variant `ms`, expected `s`",
        ),
        (
            "drive = \"V\"",
            "drive = \"mV\"",
            "m.toml:7: units.drive: unknown variant `mV`, expected `V`",
        ),
        (
            "displacement = \"um\"",
            "displacement = \"nm\"",
            "m.toml:8: units.displacement: unknown variant `nm`, expected `um`",
        ),
        (
            "displacement = \"um\"\n",
            "",
            "m.toml:5: units: missing field `displacement`",
        ),
        (
            "name = \"hysteresis\"\n",
            "",
            "m.toml:10: the stage has no name; give it one of saturation, slew-limit, amplifier-lag, transport-delay, hysteresis, bouc-wen, rate-law, congruency, asymmetry, quadratic, cubic, backlash, resonance, creep, output-quadratic, output, interleaving, sensor-lag, drift, mains-hum, quantisation, modified-play",
        ),
        (
            "\"hysteresis\"",
            "\"squeak\"",
            "m.toml:11: there is no stage \"squeak\"; the stages are saturation, slew-limit, amplifier-lag, transport-delay, hysteresis, bouc-wen, rate-law, congruency, asymmetry, quadratic, cubic, backlash, resonance, creep, output-quadratic, output, interleaving, sensor-lag, drift, mains-hum, quantisation, modified-play",
        ),
        (
            "\"hysteresis\"",
            "3",
            "m.toml:11: the stage's name is not a string; use one of saturation, slew-limit, amplifier-lag, transport-delay, hysteresis, bouc-wen, rate-law, congruency, asymmetry, quadratic, cubic, backlash, resonance, creep, output-quadratic, output, interleaving, sensor-lag, drift, mains-hum, quantisation, modified-play",
        ),
        (
            "beta_s = 0.0008572",
            "beta = 0.0008572",
            "m.toml:14: stage[0]: unknown field `beta`, expected one of `thresholds_v`, `weights`, `beta_s`",
        ),
        (
            "beta_s = 0.0008572\n",
            "",
            "m.toml:10: stage[0]: missing field `beta_s`",
        ),
        (
            "beta_s = 0.0008572",
            "beta_s = nan",
            "m.toml:14: hysteresis.beta_s: NaN is not a finite number; write one",
        ),
        (
            "0.2906, -0.0416]",
            "\n0.2906,\n-inf]",
            "m.toml:15: hysteresis.weights[2]: -inf is not a finite number; write one",
        ),
        (
            "0.2906, -0.0416",
            "\"0.3\", 1",
            "m.toml:13: stage[0].weights[1]: invalid type: string \"0.3\", expected f64",
        ),
        (
            "9.715, 19.43",
            "9.715",
            "m.toml:13: hysteresis.weights: holds 3, but must hold one more than there are thresholds: 2; add or remove some",
        ),
        (
            "negative = [0.5]",
            "negative = []",
            "m.toml:19: asymmetry.slopes.negative: holds 0, but must hold one more than there are thresholds: 1; add or remove some",
        ),
        (
            "positive = [10.0]",
            "positive = [inf]",
            "m.toml:18: asymmetry.thresholds.positive[0]: inf is not a finite number; write one",
        ),
        (
            "positive = [10.0], ",
            "",
            "m.toml:18: stage[1].thresholds: missing field `positive`",
        ),
        (
            "offset_um = -1e-7",
            "offset_um = nan",
            "m.toml:24: output.offset_um: NaN is not a finite number; write one",
        ),
        (
            "[[stage]]\nname = \"asymmetry\"",
            second,
            "m.toml:16: a second stage hysteresis; keep one",
        ),
        (
            "name = \"output\"\ngain_um_per_v = 12.5\noffset_um = -1e-7",
            "name = \"hysteresis\"\nthresholds_v = []\nweights = [1]\nbeta_s = 0",
            "m.toml:21: stage hysteresis stands after asymmetry; the order is saturation, slew-limit, amplifier-lag, transport-delay, hysteresis, bouc-wen, rate-law, congruency, asymmetry, quadratic, cubic, backlash, resonance, creep, output-quadratic, output, interleaving, sensor-lag, drift, mains-hum, quantisation",
        ),
        (
            "name = \"hysteresis\"\nthresholds_v = [9.715, 19.43]\nweights = [0.7236, 0.2906, -0.0416]\nbeta_s = 0.0008572",
            "name = \"output\"\ngain_um_per_v = 1\noffset_um = 1",
            "m.toml:15: stage asymmetry stands after output; the order is saturation, slew-limit, amplifier-lag, transport-delay, hysteresis, bouc-wen, rate-law, congruency, asymmetry, quadratic, cubic, backlash, resonance, creep, output-quadratic, output, interleaving, sensor-lag, drift, mains-hum, quantisation",
        ),
        (
            "[[stage]]\nname = \"hysteresis\"\nthresholds_v = [9.715, 19.43]\nweights = [0.7236, 0.2906, -0.0416]\nbeta_s = 0.0008572\n",
            "",
            "m.toml:11: there is no stage hysteresis; add it",
        ),
    ];
    for (from, to, message) in cases {
        assert_eq!(
            MODEL.matches(from).count(),
            1,
            "{from:?} must stand in the model once"
        );
        let error = parse(&MODEL.replace(from, to), "m.toml").unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    let head = &MODEL[..MODEL.find("[[stage]]").unwrap()];
    let cases = [
        (
            head.to_owned(),
            "m.toml:1: there is no [[stage]]; add a hysteresis stage",
        ),
        (
            format!("stage = 3\n{head}"),
            "m.toml:1: stage is not a list; write it as [[stage]]",
        ),
        (
            format!("stage = [3]\n{head}"),
            "m.toml:1: a stage is not a table; write it as [[stage]]",
        ),
        (
            format!("stage = []\n{head}"),
            "m.toml:1: there is no stage hysteresis; add it",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(parse(&text, "m.toml").unwrap_err().to_string(), message);
    }
}

#[test]
fn built_in_models_hold_the_published_constants() {
    for name in BUILTIN_NAMES {
        let model = builtin(name).unwrap();
        assert_eq!(parse(&model.to_toml_string(), name).unwrap(), model);
        assert_eq!(resolve(name).unwrap(), model);
    }
    let p753 = builtin("p753").unwrap().hysteresis().unwrap().clone();
    // The paper prints the inverse too: b_0 = 1/a_0 and b_i = 1/A_i - 1/A_{i-1}, with A_i the partial
    // sums. The corrected weights must give the printed b_1 .. b_3 to their digits (b_2 has three), the
    // printed weights must miss b_1 and b_2.
    let printed_b = [(1, -0.3961, 2e-4), (2, -0.038, 1e-3), (3, -0.1187, 1e-4)];
    let inverse = |weights: &[f64], i: usize| {
        let sum = |last: usize| weights[..=last].iter().sum::<f64>();
        1.0 / sum(i) - 1.0 / sum(i - 1)
    };
    for (i, b, digits) in printed_b {
        assert!((inverse(&p753.weights, i) - b).abs() <= digits, "b_{i}");
    }
    let printed = builtin("p753-printed")
        .unwrap()
        .hysteresis()
        .unwrap()
        .clone();
    for (i, b, digits) in &printed_b[..2] {
        assert!((inverse(&printed.weights, *i) - b).abs() > *digits, "b_{i}");
    }
    // s_1 = a_0 alpha_1 and s_1's rate term a_0 beta, as printed.
    assert!((p753.weights[0] * p753.thresholds_v[0] - 7.0293).abs() < 1e-3);
    assert!((p753.weights[0] * p753.beta_s - 6.2024e-4).abs() < 1e-7);
    assert_eq!(p753.thresholds_v.len(), 3);

    let example = builtin("example-f").unwrap().hysteresis().unwrap().clone();
    assert_eq!(example.thresholds_v, [3.0, 6.0, 9.0, 12.0]);
    assert_eq!((example.weights[0], example.beta_s), (0.5, 7e-4));
    for pair in example.weights.windows(2) {
        assert!((pair[1] / pair[0] - 0.733_446_956_224_289).abs() < 1e-14);
    }
}

#[test]
fn an_unknown_name_lists_the_built_in_ones() {
    assert_eq!(builtin("p754"), None);
    assert_eq!(
        resolve("p754").unwrap_err().to_string(),
        "there is no model file \"p754\"; name a model.toml or a built-in model: p753, p753-printed, example-f"
    );
}

fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    let finite = any::<u64>()
        .prop_map(f64::from_bits)
        .prop_filter("finite", |n| n.is_finite());
    prop::collection::vec(finite, count)
}

prop_compose! {
    fn two_sided()(positive in 0_usize..20, negative in 0_usize..20)(
        thresholds in (numbers(positive), numbers(negative)),
        slopes in (numbers(positive + 1), numbers(negative + 1)),
    ) -> Asymmetry {
        Asymmetry {
            thresholds: TwoSided { positive: thresholds.0, negative: thresholds.1 },
            slopes: TwoSided { positive: slopes.0, negative: slopes.1 },
        }
    }
}

prop_compose! {
    fn any_modified_play()(slopes in 0_usize..20)(
        name in any::<String>(),
        slopes_um_per_v in numbers(slopes),
        scalars in numbers(16),
        corrected in any::<bool>(),
        exact in any::<bool>(),
    ) -> ModelFile {
        ModelFile::new(name, vec![Stage::ModifiedPlay(ModifiedPlay {
            sample_time_s: scalars[0],
            u_max_v: scalars[1],
            slopes_um_per_v,
            offset_um: scalars[2],
            alpha_s: scalars[3],
            beta_s: scalars[4],
            interleaving_per_v: scalars[5],
            feedback: [scalars[6], scalars[7], scalars[8]],
            frequency_hz: scalars[9],
            harmonics: if corrected { Harmonics::Corrected } else { Harmonics::Printed },
            sine: [scalars[10], scalars[11], scalars[12]],
            cosine: [scalars[13], scalars[14], scalars[15]],
            law: if exact { Law::Exact } else { Law::Printed },
        })])
    }
}

/// A stage of each effect, in the order of the signal, in front of the hysteresis and behind it.
fn every_effect(numbers: &[f64]) -> [Vec<Stage>; 3] {
    let n = |i: usize| numbers[i];
    let before = vec![
        Stage::Saturation(Saturation { limit_v: n(0) }),
        Stage::SlewLimit(SlewLimit { slew_v_per_s: n(1) }),
        Stage::AmplifierLag(AmplifierLag { tau_s: n(2) }),
        Stage::TransportDelay(TransportDelay { delay_s: n(3) }),
    ];
    let mode = |f_n_hz, zeta| Stage::Resonance(Resonance { f_n_hz, zeta });
    let element = |weight, grow_per_v, shape_per_v| {
        Stage::BoucWen(BoucWen {
            weight,
            grow_per_v,
            shape_per_v,
        })
    };
    let core = vec![
        element(n(12), n(13), n(14)),
        element(n(14), n(15), n(16)),
        Stage::RateLaw(RateLaw { exponent: n(4) }),
        Stage::Congruency(Congruency { kappa: n(5) }),
    ];
    let behind = vec![
        Stage::Quadratic(Quadratic { q: n(6) }),
        Stage::Cubic(Cubic { c: n(7) }),
        Stage::Backlash(Backlash { width: n(8) }),
        mode(n(9), n(10)),
        mode(n(11), n(12)),
        Stage::Creep(Creep {
            gain_per_decade: n(13),
            tau_min_s: n(14),
            tau_max_s: n(15),
        }),
        Stage::OutputQuadratic(Quadratic { q: n(16) }),
    ];
    [before, core, behind]
}

/// A stage of each effect that the sensor sees, in the order of the signal.
fn every_effect_measured(numbers: &[f64]) -> Vec<Stage> {
    let n = |i: usize| numbers[i];
    vec![
        Stage::Interleaving(Interleaving { g: n(0) }),
        Stage::SensorLag(SensorLag { tau_s: n(1) }),
        Stage::Drift(Drift {
            amplitude: n(2),
            tau_s: n(3),
        }),
        Stage::MainsHum(MainsHum {
            frequency_hz: n(4),
            amplitude: n(5),
            phase_rad: n(6),
            third_amplitude: n(7),
            third_phase_rad: n(8),
        }),
        Stage::Quantisation(Quantisation { step: n(9) }),
    ]
}

prop_compose! {
    fn any_staged_model()(plays in 0_usize..30)(
        name in any::<String>(),
        thresholds_v in numbers(plays),
        weights in numbers(plays + 1),
        scalars in numbers(2),
        asymmetry in prop::option::of(two_sided()),
        output in any::<bool>(),
        effects in numbers(27),
        chosen in prop::collection::vec(any::<bool>(), 20),
    ) -> ModelFile {
        let hysteresis = Hysteresis { thresholds_v, weights, beta_s: scalars[0] };
        let mut stages = vec![Stage::Hysteresis(hysteresis)];
        let [before, core, behind] = every_effect(&effects);
        let mut chosen = chosen.into_iter();
        let mut some = |stages: Vec<Stage>| -> Vec<Stage> {
            stages.into_iter().filter(|_| chosen.next().unwrap()).collect()
        };
        stages.splice(0..0, some(before));
        stages.extend(some(core));
        stages.extend(asymmetry.map(Stage::Asymmetry));
        stages.extend(some(behind));
        stages.extend(output.then_some(Stage::Output(Output {
            gain_um_per_v: scalars[0],
            offset_um: scalars[1],
        })));
        stages.extend(some(every_effect_measured(&effects[17..])));
        ModelFile::new(name, stages)
    }
}

fn any_model() -> impl Strategy<Value = ModelFile> {
    prop_oneof![3 => any_staged_model(), 1 => any_modified_play()]
}

proptest! {
    /// Any name and any finite numbers survive, bit for bit, and the text is stable.
    #[test]
    fn a_round_trip_is_exact(model in any_model()) {
        let text = model.to_toml_string();
        prop_assert!(text.ends_with('\n'));
        let again = parse(&text, "m.toml").unwrap();
        prop_assert_eq!(&again, &model);
        // Equality takes 0.0 for -0.0; the text does not.
        prop_assert_eq!(again.to_toml_string(), text);
    }

    /// The sections of the text are those of the serialised form, which JSON results use.
    #[test]
    fn text_and_serialised_form_agree(model in any_model()) {
        let text: toml::Value = toml::from_str(&model.to_toml_string()).unwrap();
        prop_assert_eq!(toml::Value::try_from(&model).unwrap(), text);
    }

    /// Damaged text is refused in one line or read; it never panics.
    #[test]
    fn damage_is_survived(cut in 0..MODEL.len(), insert in "[\\[\\]{}=\",.0-9a-z\n]{0,4}", drop in 0_usize..20) {
        let end = (cut + drop).min(MODEL.len());
        let text = format!("{}{insert}{}", &MODEL[..cut], &MODEL[end..]);
        if let Err(error) = parse(&text, "m.toml") {
            let message = error.to_string();
            prop_assert!(message.starts_with("m.toml:"), "{}", message);
            prop_assert_eq!(message.lines().count(), 1);
        }
    }
}
