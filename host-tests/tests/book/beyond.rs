//! Experiment beyond: docs/beyond.md and what docs/which.md, docs/cascade.md and README.md quote of it.

use serde_json::{Value, json};

use crate::golden::{entry, golden};
use crate::page::{Cell, Page, words};

const COMPENSATORS: [(&str, &str); 7] = [
    ("none", "none"),
    ("rate_independent", "rate-independent"),
    ("explicit", "explicit"),
    ("dim_printed", "DIM printed"),
    ("dim_exact", "DIM exact (where it exists)"),
    ("preview", "preview"),
    ("cascade", "cascade"),
];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Rms error in um, as identified or, `wrong`, 10 % off; infinite where it is refused.
fn um(golden: &Value, at: (&str, &str, f64), compensator: &str, kind: &str) -> f64 {
    let (plant, shape, hz) = at;
    let key = [
        ("plant", plant.into()),
        ("shape", shape.into()),
        ("frequency_hz", json!(hz)),
    ];
    let row = entry(&golden["sweep"], &key);
    let entry = entry(&row["entries"], &[("compensator", compensator.into())]);
    entry[kind]["rms_um"].as_f64().unwrap_or(f64::INFINITY)
}

fn sine(golden: &Value, plant: &str, hz: f64, compensator: &str) -> f64 {
    um(golden, (plant, "sine", hz), compensator, "identified")
}

fn against_dim(golden: &Value, hz: f64) -> [f64; 2] {
    let row = entry(&golden["against_dim"], &[("frequency_hz", json!(hz))]);
    ["dim", "cascade"].map(|which| 1e3 * number(&row[which]["rmse_mm"]))
}

#[test]
fn the_tables_are_as_shown() {
    let (page, golden) = (Page::read("docs/beyond.md"), golden("beyond"));
    let rows = COMPENSATORS.map(|(key, name)| {
        let mut row = vec![words(name)];
        for plant in ["plays", "relays", "bimorph"] {
            let which = [("plant", plant.into()), ("compensator", key.into())];
            let standing = entry(&golden["standings"], &which);
            row.push(number(&standing["median_rms_um"]).into());
            row.push(number(&standing["median_rms_um_wrong"]).into());
        }
        row
    });
    page.table("| | plays | 10 % off |", &rows);

    let hz = [
        1.0, 5.0, 10.0, 15.0, 20.0, 23.0, 25.0, 27.0, 37.0, 50.0, 60.0, 74.0, 80.0, 95.0, 110.0,
    ];
    let line = |name: &str, which: usize, hz: &[f64]| -> Vec<Cell> {
        let errors = hz.iter().map(|&hz| against_dim(&golden, hz)[which].into());
        std::iter::once(words(name)).chain(errors).collect()
    };
    page.table(
        "| Hz | 1 | 5 |",
        &[line("DIM, µm rms", 0, &hz), line("cascade", 1, &hz)],
    );
    let hz = [
        1.0, 10.0, 15.0, 23.0, 25.0, 37.0, 50.0, 65.0, 74.0, 80.0, 95.0, 110.0,
    ];
    Page::read("docs/cascade.md").table(
        "| f in Hz | 1 | 10 |",
        &[
            line("cascade, 1e-3 mm", 1, &hz),
            line("DIM, 1e-3 mm", 0, &hz),
        ],
    );

    let mut rows = Vec::new();
    for (plant, hz) in [
        ("plays", 5.0),
        ("plays", 50.0),
        ("relays", 5.0),
        ("relays", 50.0),
        ("bimorph", 5.0),
    ] {
        for wrong in [false, true] {
            let key = [
                ("plant", plant.into()),
                ("frequency_hz", json!(hz)),
                ("wrong", wrong.into()),
            ];
            let row = entry(&golden["feedback"], &key);
            let ways = ["linear", "compensated", "feedback", "both"];
            let ways = ways.map(|way| number(&row[way]["rms_um"]));
            assert!(
                ways[..3].iter().all(|&other| ways[3] < other),
                "{plant} {hz}"
            );
            let (name, state) = if wrong {
                (String::new(), "10 % off")
            } else {
                (format!("{plant}, {hz} Hz"), "as identified")
            };
            rows.push(
                [words(name), words(state)]
                    .into_iter()
                    .chain(ways.map(Cell::from))
                    .collect(),
            );
        }
    }
    page.table("| plant, sine |", &rows);
}

#[test]
fn the_advice_is_as_computed() {
    let (page, golden) = (Page::read("docs/beyond.md"), golden("beyond"));
    let of = |plant, hz, compensator| sine(&golden, plant, hz, compensator);
    let best = |at: (&str, &str, f64), ours: &str| {
        let ours_um = um(&golden, at, ours, "identified");
        let others = COMPENSATORS.iter().filter(|(key, _)| *key != ours);
        others
            .clone()
            .all(|(key, _)| um(&golden, at, key, "identified") > ours_um)
    };
    let slow = |hz| of("bimorph", hz, "rate_independent");
    page.says(
        "best one at 1 and 5 Hz ({} and {} µm)",
        &[slow(1.0), slow(5.0)],
    );
    assert!(
        [1.0, 5.0]
            .iter()
            .all(|&hz| best(("bimorph", "sine", hz), "rate_independent"))
    );
    page.says(
        "it leaves {} times as much as the explicit one at 20 Hz",
        &[of("plays", 20.0, "rate_independent") / of("plays", 20.0, "explicit")],
    );
    let explicit = [1.0, 50.0, 100.0].map(|hz| of("plays", hz, "explicit"));
    page.says(
        "Stage of plays: {} µm at 1 Hz, {} at 50, {} at 100.",
        &explicit,
    );
    let relays = entry(&golden["identified"], &[("plant", "relays".into())]);
    page.says(
        "a rate term is found ({} ms)",
        &[1e3 * number(&relays["beta_s"])],
    );
    page.says(
        "costs {} instead of {} µm at 1 Hz",
        &[
            of("relays", 1.0, "explicit"),
            of("relays", 1.0, "rate_independent"),
        ],
    );
    let preview = [50.0, 100.0].map(|hz| of("plays", hz, "preview"));
    page.says("stage of plays {} µm at 50 Hz, {} at 100", &preview);
    let fast_triangle = ("bimorph", "triangle", 50.0);
    assert!(best(fast_triangle, "dim_exact"));
    let triangle = |which| um(&golden, fast_triangle, which, "identified");
    page.says(
        "50 Hz triangle: {} µm; cascade {}",
        &[triangle("dim_exact"), triangle("cascade")],
    );
    let dim = [25.0, 37.0].map(|hz| of("bimorph", hz, "dim_printed"));
    page.says("meets the mode: {} µm at 25 Hz, {} at 37 Hz", &dim);
    for hz in [60.0, 70.0, 80.0, 95.0, 110.0] {
        assert!(of("bimorph", hz, "dim_exact").is_infinite());
    }

    let standings = golden["standings"].as_array().unwrap().iter();
    let cascades = standings.filter(|one| one["compensator"] == "cascade");
    let sums = cascades.fold([0.0, 0.0], |[best, of], one| {
        [best + number(&one["best"]), of + number(&one["references"])]
    });
    page.says("the best one at {} of {} references", &sums);
    let jump = um(
        &golden,
        ("bimorph", "two_amplitudes", 50.0),
        "cascade",
        "identified",
    );
    page.says("50 Hz on the bimorph leave {} µm", &[jump]);
    let slow_triangle = |which| um(&golden, ("bimorph", "triangle", 10.0), which, "identified");
    let corners = [slow_triangle("cascade"), slow_triangle("none")];
    page.says("a 10 Hz triangle {}, the straight line {}", &corners);
    let at_60 = ["cascade", "dim_printed"]
        .map(|which| um(&golden, ("bimorph", "sine", 60.0), which, "wrong"));
    page.says("cascade {} µm at 60 Hz, DIM {}", &at_60);
    let cascade = Page::read("docs/cascade.md");
    cascade.says("leaves {} µm, more than a straight line ({})", &corners);

    let which = Page::read("docs/which.md");
    which.says("| {} at 1 Hz on the bimorph", &[slow(1.0)]);
    which.says("| {} at 1 Hz, {} at 50 Hz, {} at 100 Hz", &explicit);
    which.says("| {} at 50 Hz, {} at 100 Hz |", &preview);
}

#[test]
fn the_cascade_against_dim_is_as_shown() {
    let (page, golden) = (Page::read("docs/beyond.md"), golden("beyond"));
    let comparison = |key: &str| number(&golden["comparison"][key]);
    page.says(
        "leaves less at {} of {} frequencies, {} times less in the median, {} at the least ({} Hz); at most {} µm ({} Hz)",
        &[
            comparison("cascade_better"),
            comparison("frequencies"),
            comparison("median_ratio"),
            comparison("least_ratio"),
            comparison("least_ratio_hz"),
            1e3 * comparison("worst_mm"),
            comparison("worst_hz"),
        ],
    );
    let thirds = [
        comparison("third_25_hz_dim"),
        1.0 / comparison("third_25_hz_cascade"),
    ];
    page.says(
        "is {} times the fundamental under DIM (published: 2), 1/{} under the cascade",
        &thirds,
    );
    page.says(
        "by at most {} times what it steps by",
        &[comparison("largest_leap")],
    );
    let m = crate::golden::golden("m");
    let at_74 = entry(&m["frequencies"], &[("frequency_hz", json!(74.0))]);
    let abrupt = 1e3 * number(&at_74["proposed"]["printed"]["rms_error_mm"]);
    page.says(
        "it leaves {} instead of {} µm at 74 Hz",
        &[abrupt, against_dim(&golden, 74.0)[0]],
    );
    let largest_v = |hz: f64| {
        let row = entry(&golden["against_dim"], &[("frequency_hz", json!(hz))]);
        number(&row["cascade"]["largest_v"])
    };
    page.says("At 110 Hz it asks for {} V", &[largest_v(110.0)]);

    let cascade = Page::read("docs/cascade.md");
    cascade.says(
        "the cascade leaves less, {} times less in the median",
        &[comparison("median_ratio")],
    );
    cascade.says(
        "harmonic is 1/{} of the fundamental; under DIM it is {} times",
        &[thirds[1], thirds[0]],
    );
    cascade.says(
        "by at most {} times as much while",
        &[comparison("largest_leap")],
    );
    cascade.says(
        "the drive reaches {} V for 0.05 mm, where {} V suffice",
        &[largest_v(110.0), largest_v(1.0)],
    );
    let readme = Page::read("README.md");
    readme.says(
        "at most {} mm rms with one set of parameters, {} times less than DIM",
        &[comparison("worst_mm"), comparison("median_ratio")],
    );
    let which = Page::read("docs/which.md");
    which.says(
        "at most {} from 1 to 110 Hz",
        &[1e3 * comparison("worst_mm")],
    );
    let all = golden["against_dim"].as_array().unwrap().iter();
    let dim = all.map(|row| 1e3 * number(&row["dim"]["rmse_mm"]));
    let (least, most) = dim.fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), um| {
        (least.min(um), most.max(um))
    });
    which.says(
        "| {} to {}, worst at the mode and where a harmonic meets it |",
        &[least, most],
    );
}
