//! Blind trials: their scores on hand-made outcomes, and a small run from hiding to the page.

mod browser;

use hysteron_host::discover::Verdict;
use hysteron_host::discover::blind::{
    Answer, Named, Outcome, Plan, Range, Scores, Share, Spread, run,
};
use hysteron_host::experiment::demo;
use hysteron_host::plant::hidden::{HiddenCase, Protocol};

/// An answer to a hidden `truth` at a reach, its names with their look-alikes.
fn outcome(truth: &[&str], verdict: Verdict, named: &[(&str, &[&str])], reach: f64) -> Outcome {
    let owned = |names: &[&str]| {
        names
            .iter()
            .map(|&name| name.to_owned())
            .collect::<Vec<_>>()
    };
    Outcome {
        case: HiddenCase::default(),
        truth: owned(truth),
        bounded: false,
        answer: Ok(Answer {
            verdict,
            named: named
                .iter()
                .map(|(name, also)| Named {
                    name: (*name).to_owned(),
                    also_possible: owned(also),
                })
                .collect(),
            noise_ratio: 1.0,
            reach,
            closed: Some(0.9),
            left_out: None,
            seconds: 2.0,
        }),
    }
}

fn share(count: usize, of: usize) -> Share {
    Share { count, of }
}

#[test]
fn single_effects_are_scored() {
    let mut outcomes = vec![
        // Right.
        outcome(&["creep"], Verdict::Named, &[("creep", &[])], 5.0),
        // In the set only.
        outcome(
            &["sensor-lag"],
            Verdict::Named,
            &[("transport-delay", &["sensor-lag", "amplifier-lag"])],
            3.0,
        ),
        // The right name of a part.
        outcome(&["drift"], Verdict::Partial, &[("drift", &[])], 2.0),
        // Right with one too many.
        outcome(
            &["cubic"],
            Verdict::Named,
            &[("cubic", &[]), ("creep", &[])],
            40.0,
        ),
        // Wrong and small, right and small.
        outcome(&["backlash"], Verdict::Named, &[("cubic", &[])], 0.5),
        outcome(&["creep"], Verdict::Named, &[("creep", &[])], 0.9),
        // Nothing hidden: well, a false name, a false alarm.
        outcome(&[], Verdict::None, &[], 0.1),
        outcome(&[], Verdict::Named, &[("creep", &[])], 0.1),
        outcome(&[], Verdict::Unknown, &[], 0.1),
    ];
    for (at, verdict) in [
        (0, Verdict::Unknown),
        (1, Verdict::Named),
        (2, Verdict::Partial),
    ] {
        outcomes[at].answer.as_mut().unwrap().left_out = Some(verdict);
    }
    outcomes.push(Outcome {
        answer: Err("refused".to_owned()),
        ..outcomes[0].clone()
    });
    let scores = Scores::new(&outcomes);
    assert_eq!(scores.errors, share(1, 10));
    assert_eq!(scores.revealed, share(4, 7));
    assert_eq!(scores.top_1, share(2, 4));
    assert_eq!(scores.top_1_or_partial, share(3, 4));
    assert_eq!(scores.in_set, share(4, 4));
    assert_eq!(scores.mean_set_size, Some(1.5));
    assert_eq!(scores.exact, share(1, 4));
    assert_eq!(scores.surplus, share(1, 4));
    assert_eq!(scores.solved_below, share(1, 2));
    assert_eq!(scores.misnamed_below, share(1, 2));
    assert_eq!(scores.false_names, share(1, 3));
    assert_eq!(scores.false_alarms, share(1, 3));
    assert_eq!(scores.flagged, share(2, 3));

    let confusion = &scores.confusion;
    let count = |truth: &str, answer: &str| {
        let row = confusion.truths.iter().position(|t| t == truth).unwrap();
        let column = confusion.answers.iter().position(|a| a == answer).unwrap();
        confusion.counts[row][column]
    };
    assert_eq!(confusion.counts.iter().flatten().sum::<usize>(), 10);
    assert_eq!(count("creep", "creep"), 2);
    assert_eq!(count("creep", "error"), 1);
    assert_eq!(count("sensor-lag", "transport-delay"), 1);
    assert_eq!(count("drift", "partial"), 1);
    assert_eq!(count("none", "none"), 1);
    assert_eq!(count("none", "creep"), 1);
    assert_eq!(count("none", "unknown"), 1);
    assert_eq!(confusion.truths.last().unwrap(), "none");

    // 0.5 and 0.9 in one bin, 2 and 3 in another, then 5, then 40.
    let bins: Vec<(f64, Share)> = scores
        .detection
        .iter()
        .map(|b| (b.from, b.solved))
        .collect();
    assert_eq!(
        bins,
        [
            (0.5, share(1, 2)),
            (2.0, share(0, 2)),
            (4.0, share(1, 1)),
            (32.0, share(1, 1)),
        ]
    );
}

#[test]
fn several_effects_are_scored_together() {
    let truth = ["creep", "resonance"];
    let outcomes = [
        // In another order.
        outcome(
            &truth,
            Verdict::Named,
            &[("resonance", &[]), ("creep", &["drift"])],
            9.0,
        ),
        outcome(&truth, Verdict::Named, &[("resonance", &[])], 9.0),
        outcome(
            &truth,
            Verdict::Named,
            &[("resonance", &[]), ("drift", &["creep"])],
            9.0,
        ),
        outcome(
            &truth,
            Verdict::Named,
            &[("resonance", &[]), ("creep", &[]), ("cubic", &[])],
            9.0,
        ),
    ];
    let scores = Scores::new(&outcomes);
    assert_eq!(scores.exact, share(1, 4));
    assert_eq!(scores.in_set, share(3, 4));
    assert_eq!(scores.surplus, share(1, 4));
    assert_eq!(scores.top_1, share(0, 0));
    assert!(scores.confusion.truths.is_empty());
    let creep = &scores.by_effect[1];
    assert_eq!(
        (creep.effect.as_str(), creep.in_set),
        ("creep", share(3, 4))
    );
}

/// Wilson's interval of 8 of 10, and of none of ten, by the formula in Brown, Cai and DasGupta (2001).
#[test]
fn rates_come_with_wilsons_interval() {
    let near = |(low, high): (f64, f64), a: f64, b: f64| {
        assert!(
            (low - a).abs() < 5e-4 && (high - b).abs() < 5e-4,
            "{low} {high}"
        );
    };
    near(share(8, 10).interval().unwrap(), 0.4902, 0.9433);
    near(share(0, 10).interval().unwrap(), 0.0, 0.2775);
    assert_eq!(share(0, 0).interval(), None);
    let spread = Spread::new(vec![3.0, 1.0, 10.0, 2.0]).unwrap();
    assert_eq!(
        (spread.least, spread.median, spread.largest),
        (1.0, 2.5, 10.0)
    );
}

/// From hiding to JSON and page, on records without fast drives, which are short.
#[test]
fn a_small_run_is_scored_and_shown() {
    let plan = Plan {
        cases: 2,
        seed: 11,
        noise: Range {
            low: 0.05,
            high: 0.05,
        },
        protocol: Protocol::Slow,
        none_share: 0.5,
        ..Plan::default()
    };
    let done = std::sync::atomic::AtomicUsize::new(0);
    let tell = || {
        done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    };
    let found = run(&plan, &tell).unwrap();
    assert_eq!(done.into_inner(), 2);
    let hidden: Vec<String> = found.outcomes.iter().map(Outcome::hidden).collect();
    assert_eq!(hidden, ["saturation", "none"]);
    let saturated = found.outcomes[0].answer.as_ref().unwrap();
    assert!(saturated.seconds > 0.0);
    assert!((saturated.noise_ratio - 1.0).abs() < 0.2);
    assert_eq!(found.scores.false_names.of, 1);

    let json = found.to_json().unwrap();
    assert_eq!(json["cases"][0]["truth"][0], "saturation");
    assert_eq!(json["cases"][1]["seed"], 12);
    assert_eq!(json["scores"]["false_names"]["of"], 1);
    let html = found.page().to_html();
    for one in found.outcomes.iter().filter(|one| !one.solved()) {
        assert!(html.contains(&one.command()), "{}", one.command());
    }
    assert!(html.contains("<td") && html.contains("saturation"));
    browser::assert_renders(&html, &json);
}

/// The truth is the hidden stage's own, which the diagnosis does not see.
#[test]
fn demonstration_names_the_hidden_effect_and_tracks_better() {
    // Creep.
    let shown = demo::discover(8, Protocol::Slow, &|_| {}).unwrap();
    let [before, after] = shown.rms_um;
    println!("{:?}", shown.summary());
    assert!(shown.named().contains(&shown.truth.effects[0]));
    assert!(shown.found.closed().unwrap() > 0.8);
    assert!(after < 0.5 * before, "{after} of {before}");
}
