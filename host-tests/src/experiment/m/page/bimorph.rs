//! What the simulated bimorph does: gain, loops, spectra.

use crate::experiment::m::record::SAMPLE_TIME_S;
use crate::experiment::m::{Results, Traces};
use crate::metrics::line;
use crate::report::{Axis, Plot, Section, Series, Style, format_number};

/// Sampling phases of all periods of a second, put together to one finely sampled period.
pub struct Period {
    /// Position in the period, 0 to 1.
    turns: Vec<f64>,
    /// The signals at these positions.
    pub signals: Vec<Vec<f64>>,
}

impl Period {
    /// Signals of one steady second at a whole frequency.
    pub fn new(frequency_hz: f64, signals: &[&[f64]]) -> Self {
        let length = signals.first().map_or(0, |signal| signal.len());
        let turn = |k: usize| (k as f64 * SAMPLE_TIME_S * frequency_hz).fract();
        let mut order: Vec<usize> = (0..length).collect();
        order.sort_by(|&a, &b| turn(a).total_cmp(&turn(b)));
        Self {
            turns: order.iter().map(|&k| turn(k)).collect(),
            signals: signals
                .iter()
                .map(|signal| order.iter().map(|&k| signal[k]).collect())
                .collect(),
        }
    }

    /// A signal at a position.
    fn at(&self, signal: usize, turn: f64) -> f64 {
        let after = self.turns.partition_point(|&t| t < turn.rem_euclid(1.0));
        let samples = &self.signals[signal];
        samples[after % samples.len()]
    }
}

/// The traces of one frequency.
pub fn traces(results: &Results, frequency_hz: f64) -> Option<&Traces> {
    let mut all = results.traces.iter();
    all.find(|traces| traces.frequency_hz == frequency_hz)
}

/// An empty loop plot.
pub fn loop_plot(title: String) -> Plot {
    Plot::new(
        title,
        Axis::linear("Drive over 5 V", ""),
        Axis::linear("Displacement", "mm"),
    )
    .square()
}

/// A closed loop of two signals of one period.
pub fn closed(label: &str, period: &Period, x: usize, y: usize) -> Series {
    let join = |signal: &[f64]| [signal, &signal[..1]].concat();
    Series::new(
        label,
        Style::Line,
        &join(&period.signals[x]),
        &join(&period.signals[y]),
    )
}

/// All of it.
pub fn fill(section: &mut Section, results: &Results) {
    section.paragraph(
        "Preisach relays behind an amplifier drive one bending mode; the bend favours one side a \
         little. None of it shares code with the models. Harmonics, resonance, the crossing loop at \
         80 Hz and the asymmetric one at 95 Hz are set to the published facts; amplitudes, which are \
         published in drawings only, are assumed.",
    );
    let column = |of: fn(&crate::experiment::m::AtFrequency) -> f64| -> Vec<f64> {
        results.frequencies.iter().map(of).collect()
    };
    section.plot(
        Plot::new(
            "Figure 4: gain",
            Axis::linear("Frequency", "Hz"),
            Axis::log("Largest displacement at full drive", "mm"),
        )
        .caption(
            "Published: a resonance around 70 Hz. Here at 74 Hz, damping ratio 0.018 (assumed).",
        )
        .series(Series::new(
            "simulated bimorph",
            Style::Line,
            &column(|at| at.frequency_hz),
            &column(|at| at.largest_mm),
        )),
    );
    section.paragraph(
        "Figure 6. Published: four counterclockwise loops whose phase changes drastically over 3 Hz \
         around the resonance. Here the same, from 72 to 75 Hz.",
    );
    let mut around = loop_plot("Figure 6: loops around the resonance".into());
    for hz in [72.0, 73.0, 74.0, 75.0] {
        if let Some(traces) = traces(results, hz) {
            let period = Period::new(hz, &[&traces.drive, &traces.displacement_mm]);
            around = around.series(closed(&format!("{hz} Hz"), &period, 0, 1));
        }
    }
    section.plot(around);
    for hz in [15.0, 25.0] {
        if let Some(traces) = traces(results, hz) {
            let period = Period::new(hz, &[&traces.drive, &traces.displacement_mm]);
            section.plot(
                loop_plot(format!("Figure 7: twisted loop at {hz} Hz")).series(closed(
                    "simulated bimorph",
                    &period,
                    0,
                    1,
                )),
            );
        }
    }
    for (hz, published) in [
        (15.0, "Published: the fifth is almost twice the third."),
        (25.0, "Published: the third is about 1/8 of the first."),
        (35.0, "Published: the third is below 1/100 of the first."),
    ] {
        if let Some(traces) = traces(results, hz) {
            section.plot(spectrum(traces, published));
        }
    }
    section.paragraph(
        "Figure 9. Published: at 80 Hz the loop is run in both senses in one period; at 95 Hz it is \
         clockwise and so asymmetric that the chord between the peaks of the drive does not meet the \
         middle of the two branches. Here the same.",
    );
    for hz in [80.0, 95.0] {
        if let Some(traces) = traces(results, hz) {
            section.plot(with_middle(traces));
        }
    }
}

fn spectrum(traces: &Traces, published: &str) -> Plot {
    let hz = traces.frequency_hz;
    let (at, amplitudes): (Vec<f64>, Vec<f64>) = (1..=7)
        .filter_map(|harmonic| {
            let at = f64::from(harmonic) * hz;
            let found = line(&traces.displacement_mm, SAMPLE_TIME_S, at).ok()?;
            Some((at, found.amplitude))
        })
        .unzip();
    Plot::new(
        format!("Figure 8: harmonics at {} Hz", format_number(hz)),
        Axis::linear("Frequency", "Hz").including(0.0),
        Axis::log("Amplitude", "mm"),
    )
    .caption(published)
    .square()
    .series(Series::new(
        "simulated bimorph",
        Style::Bars,
        &at,
        &amplitudes,
    ))
}

/// A loop with the chord between the peaks of the drive and the middle of its branches.
fn with_middle(traces: &Traces) -> Plot {
    let hz = traces.frequency_hz;
    let period = Period::new(hz, &[&traces.drive, &traces.displacement_mm]);
    let (drive, middle): (Vec<f64>, Vec<f64>) = (0..=100)
        .map(|k| {
            let turn = (f64::from(k) / 100.0 - 0.5) / 2.0;
            let middle = 0.5 * (period.at(1, turn) + period.at(1, 0.5 - turn));
            ((std::f64::consts::TAU * turn).sin(), middle)
        })
        .unzip();
    let ends = [middle[0], middle[middle.len() - 1]];
    loop_plot(format!("Figure 9: loop at {} Hz", format_number(hz)))
        .series(closed("simulated bimorph", &period, 0, 1))
        .series(Series::new(
            "chord of the peaks",
            Style::Line,
            &[-1.0, 1.0],
            &ends,
        ))
        .series(Series::new(
            "middle of the branches",
            Style::Line,
            &drive,
            &middle,
        ))
}
