//! The page of the experiment: what came out, beside what the paper says.

mod bimorph;
mod compensation;
mod models;
mod studies;

use crate::report::{KeyFigure, Page, Tone, format_number};

use super::{HIGHEST_HZ, Results, Summary, published};

/// Frequencies at which the proposed model is to be the best for the aim to be met.
const AIM: usize = 105;

/// The page.
pub fn page(results: &Results) -> Page {
    let mut page = Page::new("Paper M: modified play model and direct inverse multiplication");
    page.lead(
        "Morita, Fujii & Hosoda, Actuators 9(2), 2020, computed from code. The authors measured a \
         piezo bimorph PZBA-00030; here a simulated one is driven with a sine of 5 V at 5 kHz from 1 \
         to 110 Hz, with 20 nm of sensor noise, identified at each frequency and then asked for \
         0.05 mm.",
    );
    let (tone, text) = verdict(&results.summary);
    page.verdict(tone, text);
    page.figures(figures(&results.summary));
    page.section("The bimorph (figures 4 and 6 to 9)", |section| {
        bimorph::fill(section, results)
    });
    page.section("Three models (figures 13 to 15)", |section| {
        models::fill(section, results)
    });
    page.section("Compensation (figures 16 to 20)", |section| {
        compensation::fill(section, results)
    });
    page.section("Harmonic terms, printed and corrected", |section| {
        studies::harmonic_terms(section, results)
    });
    page.section("The plane, printed and clamped", |section| {
        studies::planes(section, results)
    });
    page.section("Initial covariance and envelopes", |section| {
        studies::tuning(section, results)
    });
    page.section("Where this differs from the paper, and why", |section| {
        section.list(differences(results));
    });
    page
}

fn verdict(summary: &Summary) -> (Tone, String) {
    let best = summary.best_in_free_run.proposed;
    let tone = if best >= AIM { Tone::Good } else { Tone::Bad };
    let [before, after] = summary.third_over_first_25_hz;
    let text = format!(
        "The proposed model has the smallest RMSE of the three at {best} of {HIGHEST_HZ} frequencies \
         (published: all). Direct inverse multiplication leaves more than a third of the reference \
         at {} Hz (published: 23–27 Hz, around and beyond the resonance): at 25 Hz the 75 Hz line \
         grows from {before:.2} to {after:.1} times the 25 Hz line (published: {}).",
        spans(&summary.degraded_hz),
        format_number(published::THIRD_AFTER),
    );
    (tone, text)
}

/// Runs of whole frequencies, as in `1–3, 7`.
fn spans(frequencies_hz: &[f64]) -> String {
    let runs = frequencies_hz.chunk_by(|a, b| b - a < 1.5);
    let spans: Vec<String> = runs
        .filter_map(|run| match run {
            [] => None,
            [only] => Some(format_number(*only)),
            [first, .., last] => Some(format!(
                "{}–{}",
                format_number(*first),
                format_number(*last)
            )),
        })
        .collect();
    spans.join(", ")
}

fn figures(summary: &Summary) -> Vec<KeyFigure> {
    let facts = &summary.facts;
    let [lowest, lowest_recursive] = summary.lowest_fitting_percent;
    let [before, after] = summary.third_over_first_25_hz;
    let of_all = |key: &str, label: &str, count: usize| {
        KeyFigure::new(format!("summary.{key}"), label, count, "")
    };
    let ratio = |key: &str, label: &str, value: f64, note: String| {
        KeyFigure::new(format!("summary.{key}"), label, value, "").note(note)
    };
    vec![
        KeyFigure::new(
            "summary.facts.resonance_hz",
            "Bimorph: resonance",
            facts.resonance_hz,
            "Hz",
        )
        .note("published: around 70 Hz"),
        ratio(
            "facts.third_at_25_hz",
            "Bimorph: third over first harmonic at 25 Hz",
            facts.third_at_25_hz,
            format!(
                "published: about {}",
                format_number(published::THIRD_AT_25_HZ)
            ),
        ),
        ratio(
            "facts.third_at_35_hz",
            "Bimorph: third over first harmonic at 35 Hz",
            facts.third_at_35_hz,
            format!(
                "published: below {}",
                format_number(published::THIRD_AT_35_HZ)
            ),
        ),
        ratio(
            "facts.fifth_at_15_hz",
            "Bimorph: fifth over third harmonic at 15 Hz",
            facts.fifth_at_15_hz,
            format!(
                "published: almost {}",
                format_number(published::FIFTH_AT_15_HZ)
            ),
        ),
        of_all(
            "best_in_free_run.proposed",
            "Of 110 frequencies, proposed model best in free run",
            summary.best_in_free_run.proposed,
        )
        .note(format!("published: {}", published::PROPOSED_BEST)),
        of_all(
            "best_in_one_step.proposed",
            "Of 110 frequencies, proposed model best one step ahead",
            summary.best_in_one_step.proposed,
        )
        .note("all three at the sensor's noise"),
        ratio(
            "bouc_wen_over_proposed",
            "RMSE of Bouc-Wen over that of the proposed model, median",
            summary.bouc_wen_over_proposed,
            "free run".into(),
        ),
        ratio(
            "truncated_over_proposed",
            "RMSE without g over that of the proposed model, median",
            summary.truncated_over_proposed,
            format!(
                "free run; {:.3} % more",
                100.0 * (summary.truncated_over_proposed - 1.0)
            ),
        ),
        KeyFigure::new(
            "summary.lowest_fitting_percent.1",
            "Lowest Fitting of the proposed model, identified recursively",
            lowest_recursive,
            "%",
        )
        .note(format!(
            "published: a loss of at most {} near the resonance",
            published::FITTING_LOSS_PERCENT
        )),
        KeyFigure::new(
            "summary.lowest_fitting_percent.0",
            "The same, identified for the free run",
            lowest,
            "%",
        )
        .note("not in the paper"),
        ratio(
            "third_over_first_25_hz.0",
            "75 Hz over 25 Hz line without compensation",
            before,
            "0.05 mm".into(),
        ),
        ratio(
            "third_over_first_25_hz.1",
            "75 Hz over 25 Hz line with compensation",
            after,
            format!("published: {}", format_number(published::THIRD_AFTER)),
        ),
    ]
}

fn differences(results: &Results) -> Vec<String> {
    let summary = &results.summary;
    vec![
        format!(
            "The term g. Published: without it the model is much worse at and above the resonance. \
             Here it changes the RMSE by {:.3} % (median). Under a sine the printed harmonic terms \
             already hold every even harmonic up to the sixth in either phase, so g, which makes even \
             harmonics out of y times u, has nothing left to do.",
            100.0 * (summary.truncated_over_proposed - 1.0),
        ),
        format!(
            "Bouc-Wen. Published: worse everywhere, with very large errors around the resonance. \
             Here its RMSE is {:.2} times that of the proposed model (median) and smaller at {} \
             frequencies. The equations of the rival are not in the paper; it was given the same \
             output feedback and harmonic terms, and the same search from many starts. With that, it \
             resonates as well as the plays do. Where its line has a spike, the search ended in a \
             local minimum.",
            summary.bouc_wen_over_proposed, summary.best_in_free_run.bouc_wen,
        ),
        "RMSE around the resonance. All three models meet one floor there: the eighth and higher even \
         harmonics of the simulated bend, which none of them has terms for."
            .into(),
        "37 Hz. Not in the paper: the second harmonic of the drive meets the resonance at 74 Hz. The \
         simulated bimorph bends a little more to one side at every frequency; of the measured one \
         this is reported above the resonance only."
            .into(),
        "From 54 Hz on. As published, compensation is poor around and beyond the resonance; here this \
         begins earlier. The bimorph moves so far that a drive below the first threshold, a tenth of \
         5 V, would do for 0.05 mm. No play of the model moves there, and a sine of 5 V determines \
         only what all plays do together."
            .into(),
        "Why it fails at 24 to 26 Hz. As the authors say: the coefficients hold under the sine they \
         were identified with, not under the drive they make. A 75 Hz part of 4 % of full drive is \
         enough, because the resonance multiplies it by 28. The law that is solved within the sample \
         fails alike where it exists, so the hidden delay of the printed law is not the reason."
            .into(),
    ]
}
