//! Loops: hysteresis percent, and the worked example.

use crate::experiment::j::{Example, Percent, Results};
use crate::report::{Axis, Cell, Plot, Section, Series, Style, format_number};

fn square(title: String, x: Axis, y: Axis) -> Plot {
    Plot::new(title, x, y).square()
}

/// One period of a loop, its last sample joined to its first.
fn closed(label: &str, x: &[f64], y: &[f64]) -> Series {
    let join = |signal: &[f64]| [signal, &signal[..1]].concat();
    Series::new(label, Style::Line, &join(x), &join(y))
}

fn column(results: &Results, of: fn(&Percent) -> f64) -> Vec<f64> {
    results.percents.iter().map(of).collect()
}

/// Loops and percentages at the published frequencies.
pub fn hysteresis(section: &mut Section, results: &Results) {
    section.paragraph(
        "Hysteresis percent is the largest width of the loop over the range of the displacement, \
         in the second period from rest, for a drive of 40 V.",
    );
    for percent in &results.percents {
        let loops = &percent.loops;
        section.plot(
            square(
                format!("Loop at {} Hz", format_number(percent.frequency_hz)),
                Axis::linear("Drive", "V"),
                Axis::linear("Displacement", "um"),
            )
            .series(closed("model", &loops.drive, &loops.model))
            .series(closed(
                "simulated stage, lag removed",
                &loops.drive,
                &loops.stage,
            )),
        );
    }
    let frequencies = column(results, |percent| percent.frequency_hz);
    let line =
        |label: &str, values: &[f64]| Series::new(label, Style::LinePoints, &frequencies, values);
    section.plot(
        square(
            "Hysteresis percent".into(),
            Axis::linear("Frequency", "Hz"),
            Axis::linear("Hysteresis", "%").including(0.0),
        )
        .series(line("model", &column(results, |percent| percent.model)))
        .series(line(
            "simulated stage, lag removed",
            &column(results, |percent| percent.stage_lag_removed),
        ))
        .series(line(
            "published",
            &column(results, |percent| percent.published),
        )),
    );
    section.table(
        [
            "Frequency (Hz)",
            "Model (%)",
            "Simulated stage (%)",
            "Simulated stage, lag removed (%)",
            "Published (%)",
        ],
        results.percents.iter().map(|percent| {
            vec![
                percent.frequency_hz.into(),
                percent.model.into(),
                percent.stage.into(),
                percent.stage_lag_removed.into(),
                percent.published.into(),
            ]
        }),
    );
    section.paragraph(
        "The authors fitted displacements, not loop widths, with one rate term for three \
         frequencies, so their model need not meet the percentages they measured. Left in, the lag \
         of the amplifier widens the loop of the stage by one to two points at 50 and 100 Hz.",
    );
}

/// Plays, model, inverse and compositions of section F.
pub fn worked_example(section: &mut Section, results: &Results) {
    section.paragraph(
        "u = 22 sin(2πft) + 25 sin(6πft); four plays, zeta = 3, beta = 7×10⁻⁴ s, a_0 = 0.5, \
         a_i = 0.5 exp(−0.31 i). Last two of three periods.",
    );
    for example in &results.examples {
        plots(section, example);
    }
    section.table(
        ["Largest error", "10 Hz", "60 Hz"],
        [
            (
                "Model after inverse, one rate (µm)",
                (|e| e.identity_error_um) as fn(&Example) -> f64,
            ),
            ("Inverse after model, one rate (V)", |e| {
                e.inverse_after_model_error_v
            }),
            (
                "Model after rate-independent inverse, rate of u, (41) (µm)",
                |e| e.rate_independent_error_um,
            ),
            (
                "Model after rate-independent inverse, rate of its own drive (µm)",
                |e| e.rate_independent_error_own_rate_um,
            ),
            (
                "Model after rate-dependent inverse, rate of its own drive (µm)",
                |e| e.rate_dependent_error_own_rate_um,
            ),
        ]
        .into_iter()
        .map(|(what, of)| {
            let mut row: Vec<Cell> = vec![what.into()];
            row.extend(
                results
                    .examples
                    .iter()
                    .map(|example| Cell::Number(of(example))),
            );
            row
        }),
    );
    section.paragraph(
        "The composition is an identity only as long as the model's thresholds move with the rate \
         of u, as the paper defines them. With the rate of its own drive the model is left with \
         the error in the last line, which grows with the frequency.",
    );
}

fn plots(section: &mut Section, example: &Example) {
    let hz = format_number(example.fundamental_hz);
    let signals = &example.signals;
    let settled = signals.input.len() / 3..;
    let input = &signals.input[settled.clone()];
    let against_input =
        |title: &str, y: Axis| square(format!("{title}, {hz} Hz"), Axis::linear("Input u", "V"), y);
    let series = |label: &str, signal: &[f64]| {
        Series::new(label, Style::Line, input, &signal[settled.clone()])
    };

    let mut plays = against_input("Plays", Axis::linear("Output of the play", "V"));
    for (i, play) in signals.plays.iter().enumerate() {
        plays = plays.series(series(&format!("play {}", i + 1), play));
    }
    section.plot(plays);
    section.plot(
        against_input("Model and inverse", Axis::linear("Output", ""))
            .series(series("model (µm)", &signals.model))
            .series(series("inverse (V for u in µm)", &signals.inverse)),
    );
    section.plot(
        against_input("Model after inverse", Axis::linear("Output", "um"))
            .series(series("rate-dependent inverse", &signals.composition))
            .series(series(
                "rate-independent inverse",
                &signals.rate_independent,
            )),
    );
    section.plot(
        square(
            format!("Error (41), {hz} Hz"),
            Axis::linear("Time", "s"),
            Axis::linear("Error", "um"),
        )
        .series(Series::new(
            "rate-independent inverse",
            Style::Line,
            &signals.time_s[settled.clone()],
            &signals.error[settled.clone()],
        )),
    );
}
