//! `hysteron hide`.

use std::path::Path;
use std::process::{Command, Output};

use hysteron_host::dataset::Dataset;
use hysteron_host::plant::hidden::{Choice, Effect, HiddenCase, Tier, Truth};

fn hide(out: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .arg("hide")
        .args(arguments)
        .arg("--out")
        .arg(out)
        .output()
        .unwrap()
}

#[test]
fn what_is_written_loads_as_what_was_made() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 1..=8 {
        let out = folder.path().join(format!("{seed}"));
        let seed_text = seed.to_string();
        let arguments = [
            "--effect",
            "creep,backlash",
            "--seed",
            &seed_text,
            "--tier",
            "2",
        ];
        let done = hide(&out, &arguments);
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        let made = HiddenCase {
            choice: Choice::Named(vec![Effect::Creep, Effect::Backlash]),
            seed,
            tier: Tier::Finer,
            ..HiddenCase::default()
        }
        .make()
        .unwrap();
        // Numbers are written with all their digits; a change of unit may cost the last of them.
        let loaded = Dataset::load(out.join("data")).unwrap();
        assert_eq!(loaded.records.len(), made.dataset.records.len());
        assert_eq!(loaded.zero, made.dataset.zero);
        assert_eq!(loaded.output_unit, made.dataset.output_unit);
        for (a, b) in loaded.records.iter().zip(&made.dataset.records) {
            assert_eq!((&a.name, a.role), (&b.name, b.role));
            let close = |a: &[f64], b: &[f64]| {
                let mut pairs = a.iter().zip(b);
                a.len() == b.len() && pairs.all(|(a, b)| (a - b).abs() <= 1e-14 * b.abs())
            };
            assert!(close(&a.time_s, &b.time_s));
            assert!(close(&a.drive_v, &b.drive_v));
            assert!(close(&a.displacement_um, &b.displacement_um));
            assert!((a.sample_time_s / b.sample_time_s - 1.0).abs() < 1e-12);
        }
        assert_eq!(Truth::load(out.join("truth.toml")).unwrap(), made.truth);
        // The truth is in its own file alone.
        let description = std::fs::read_to_string(out.join("data/dataset.toml")).unwrap();
        let printed = String::from_utf8_lossy(&done.stdout);
        for name in ["creep", "backlash"] {
            assert!(!description.contains(name) && !printed.contains(name));
        }
    }
}

#[test]
fn bad_input_says_so_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (arguments, said) in [
        (vec!["--effect", "crep"], "\"crep\" is no effect"),
        (
            vec!["--effect", "random,99"],
            "99 effects cannot be hidden together",
        ),
        (
            vec!["--effect", "random,x"],
            "\"x\" is no number of effects",
        ),
        (vec!["--effect", "creep,creep"], "creep is named twice"),
        (
            vec!["--effect", "rate-law,rate-dependence"],
            "hide one of the two",
        ),
        (
            vec!["--effect", "none", "--tier", "5"],
            "there is no tier 5",
        ),
        (
            vec!["--effect", "none", "--noise", "11"],
            "noise 11 is out of range",
        ),
        (
            vec!["--effect", "creep", "--strength", "NaN"],
            "strength NaN is out of range",
        ),
        (
            vec!["--effect", "none", "--protocol", "fast"],
            "\"fast\" is no protocol",
        ),
    ] {
        let refused = hide(&out, &arguments);
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{message}");
        let first = message.lines().next().unwrap_or_default();
        assert!(
            first.starts_with("error: ") && first.contains(said),
            "{message}"
        );
        assert!(!out.exists());
    }
    std::fs::write(&out, "a file").unwrap();
    let refused = hide(&out, &["--effect", "none"]);
    assert_eq!(refused.status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "a file");
}
