//! Triangles and two amplitudes: traces and errors.

use crate::experiment::j::{Plant, Results, Traces};
use crate::report::{Axis, Plot, Section, Series, Style, format_number};

/// Traces of each input, and the largest errors.
pub fn fill(section: &mut Section, results: &Results) {
    section.paragraph(
        "Six periods from rest on the simulated stage, lag removed. The frequencies are ours: \
         those of the paper stand only in its figures. The minor loops of the two-amplitude \
         reference hang on the rising branch of the major one.",
    );
    for traces in &results.traces {
        if traces.frequency_hz <= 10.0 {
            section.plot(displacement(traces));
        }
        section.plot(errors(traces));
    }
    section.table(
        [
            "Reference",
            "Frequency (Hz)",
            "Stage",
            "No inverse (µm)",
            "Rate-independent (µm)",
            "Rate-dependent (µm)",
        ],
        results
            .inputs
            .iter()
            .filter(|row| {
                matches!(
                    row.errors.plant,
                    Plant::ModelOwnRate
                        | Plant::StageLagRemoved
                        | Plant::StageWrongLagRemovedMedian
                )
            })
            .map(|row| {
                let um = row.errors.largest_um;
                vec![
                    row.input.describe().into(),
                    row.frequency_hz.into(),
                    row.errors.plant.describe().into(),
                    um.none.into(),
                    um.rate_independent.into(),
                    um.rate_dependent.into(),
                ]
            }),
    );
    section.paragraph(
        "At the corner of a fast triangle the rate-dependent inverse is no better than the \
         rate-independent one on the simulated stage. The rate of a real drive passes through zero \
         there, so the widened thresholds of the stage close for a moment and its plays catch up; \
         the sampled model, whose rate keeps its magnitude from one sample to the next, does not \
         know of it.",
    );
}

fn displacement(traces: &Traces) -> Plot {
    let line =
        |label: &str, values: &[f64]| Series::new(label, Style::Line, &traces.time_s, values);
    Plot::new(
        format!("Displacement, {}", title(traces)),
        Axis::linear("Time", "s"),
        Axis::linear("Displacement", "um"),
    )
    .series(line("reference", &traces.reference))
    .series(line("no inverse", &traces.displacement.none))
    .series(line(
        "rate-dependent inverse",
        &traces.displacement.rate_dependent,
    ))
}

fn errors(traces: &Traces) -> Plot {
    let line = |label: &str, values: &[f64]| {
        let error: Vec<f64> = traces
            .reference
            .iter()
            .zip(values)
            .map(|(wanted, y)| wanted - y)
            .collect();
        Series::new(label, Style::Line, &traces.time_s, &error)
    };
    Plot::new(
        format!("Error, {}", title(traces)),
        Axis::linear("Time", "s"),
        Axis::linear("Reference − displacement", "um"),
    )
    .series(line("no inverse", &traces.displacement.none))
    .series(line(
        "rate-independent inverse",
        &traces.displacement.rate_independent,
    ))
    .series(line(
        "rate-dependent inverse",
        &traces.displacement.rate_dependent,
    ))
}

fn title(traces: &Traces) -> String {
    format!(
        "{} at {} Hz",
        traces.input.describe(),
        format_number(traces.frequency_hz)
    )
}
