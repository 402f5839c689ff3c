//! The three models against each other.

use crate::experiment::m::{AtFrequency, Comparison, Recipe, Results, Score, Scores};
use crate::report::{Axis, Cell, Plot, Section, Series, Style, format_number};

use super::bimorph::{Period, closed, loop_plot, traces};

type Model = fn(&Comparison) -> &Scores;

const MODELS: [(&str, Model); 3] = [
    ("proposed", |models| &models.proposed),
    ("without g", |models| &models.truncated),
    ("Bouc-Wen", |models| &models.bouc_wen),
];

/// Frequencies in the table, Hz.
const TABLE_HZ: [f64; 16] = [
    1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 70.0, 74.0, 80.0, 90.0, 95.0, 110.0,
];

fn column(results: &Results, of: impl Fn(&AtFrequency) -> f64) -> Vec<f64> {
    results.frequencies.iter().map(of).collect()
}

fn plot(results: &Results, title: &str, y: Axis, of: impl Fn(&Scores) -> Option<f64>) -> Plot {
    let frequencies = column(results, |at| at.frequency_hz);
    let mut plot = Plot::new(title, Axis::linear("Frequency", "Hz"), y);
    for (label, model) in MODELS {
        let values = column(results, |at| of(model(&at.models)).unwrap_or(f64::NAN));
        if values.iter().any(|value| value.is_finite()) {
            plot = plot.series(Series::new(label, Style::Line, &frequencies, &values));
        }
    }
    plot
}

/// All of it.
pub fn fill(section: &mut Section, results: &Results) {
    let best = &results.summary.best_in_free_run;
    let step = &results.summary.best_in_one_step;
    section.paragraph(
        "The paper does not say whether the outputs before each sample, which all models contain, are \
         measured or the model's own. So there are three readings. Free run: the model's own outputs, \
         in identification too (few nonlinear parameters by Levenberg-Marquardt from many starts, \
         all others linear; the same effort for each model). One step: measured outputs in both. \
         Recursive: identified with measured outputs as in the paper, scored in free run. All scored \
         over the third second of a sine of 5 V.",
    );
    let rmse =
        |of: fn(&Scores) -> Option<Score>| move |s: &Scores| of(s).map(|score| score.rmse_mm);
    section.plot(
        plot(
            results,
            "Figure 13: RMSE (40) in free run",
            Axis::log("RMSE", "mm"),
            rmse(|scores| Some(scores.free_run)),
        )
        .caption(format!(
            "Published: the proposed model is the best at all 110 frequencies, and its RMSE grows \
             between 70 and 80 Hz. Here it is the best at {}, Bouc-Wen at {}; the RMSE grows alike.",
            best.proposed, best.bouc_wen,
        )),
    );
    section.plot(
        plot(
            results,
            "Figure 14: Fitting (41) in free run",
            Axis::linear("Fitting", "%"),
            |scores| Some(scores.free_run.fitting_percent),
        )
        .caption("Published: the proposed model fits best, with a loss of at most 3 % near 70 Hz."),
    );
    section.plot(
        plot(
            results,
            "Fitting of the models identified recursively, in free run",
            Axis::linear("Fitting", "%"),
            |scores| Some(scores.recursive_free_run?.fitting_percent),
        )
        .caption(format!(
            "Initial covariance {}. Bouc-Wen is not linear in its parameters. This is nearest to what \
             the paper describes, and so is the loss near the resonance.",
            format_number(Recipe::COVARIANCE),
        )),
    );
    section.plot(
        plot(
            results,
            "RMSE one step ahead",
            Axis::log("RMSE", "mm"),
            rmse(|scores| Some(scores.one_step)),
        )
        .caption(format!(
            "Initial covariance {}. From three measured outputs any of the models predicts the next \
             one to within the sensor's noise; the proposed one is the best at {}, the one without g \
             at {}, Bouc-Wen at {}, by a few percent at most.",
            format_number(Recipe::WEAK_COVARIANCE),
            step.proposed,
            step.truncated,
            step.bouc_wen,
        )),
    );
    table(section, results);
    section.paragraph(
        "Figure 15. Published: the model follows the loops, those near the resonance and the \
         interleaved one included. Here the same, identified recursively or for the free run.",
    );
    for hz in [25.0, 50.0, 80.0, 95.0] {
        if let Some(traces) = traces(results, hz) {
            let signals = [
                &traces.drive[..],
                &traces.displacement_mm,
                &traces.recursive_mm,
                &traces.free_run_mm,
            ];
            let period = Period::new(hz, &signals);
            section.plot(
                loop_plot(format!("Figure 15: {} Hz", format_number(hz)))
                    .series(closed("simulated bimorph", &period, 0, 1))
                    .series(closed("model, recursive", &period, 0, 2))
                    .series(closed("model, free run", &period, 0, 3)),
            );
        }
    }
}

fn table(section: &mut Section, results: &Results) {
    section.paragraph("RMSE in µm.");
    let um = |score: Score| Cell::Number(1e3 * score.rmse_mm);
    section.table(
        [
            "Hz",
            "Free run: proposed",
            "without g",
            "Bouc-Wen",
            "Recursive: proposed",
            "without g",
            "One step: proposed",
            "without g",
            "Bouc-Wen",
        ],
        results
            .frequencies
            .iter()
            .filter(|at| TABLE_HZ.contains(&at.frequency_hz))
            .map(|at| {
                let models = MODELS.map(|(_, model)| model(&at.models));
                let recursive = models.iter().filter_map(|scores| scores.recursive_free_run);
                std::iter::once(Cell::Number(at.frequency_hz))
                    .chain(models.iter().map(|scores| um(scores.free_run)))
                    .chain(recursive.map(um))
                    .chain(models.iter().map(|scores| um(scores.one_step)))
                    .collect()
            }),
    );
}
