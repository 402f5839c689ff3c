//! Writes a page with every kind of plot, from made-up data: `report_page [FILE]`.

use hysteron_host::report::{Axis, Cell, KeyFigure, Page, Plot, Series, Style, Tone};
use std::f64::consts::TAU;
use std::path::PathBuf;

const SAMPLES: usize = 100_000;
const RATE: f64 = 10_000.0;
const THRESHOLDS: [f64; 5] = [0.0, 4.0, 9.0, 16.0, 27.0];
const WEIGHTS: [f64; 5] = [0.105, 0.022, 0.014, 0.009, 0.005];

fn main() -> std::io::Result<()> {
    let path = std::env::args_os()
        .nth(1)
        .map_or("out/report.html".into(), PathBuf::from);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let html = page().to_html();
    std::fs::write(&path, &html)?;
    println!("{} ({} kB)", path.display(), html.len() / 1000);
    Ok(())
}

fn page() -> Page {
    let time: Vec<f64> = (0..SAMPLES).map(|i| i as f64 / RATE).collect();
    let drive: Vec<f64> = time
        .iter()
        .map(|t| (t / 10.0) * (50.0 - 50.0 * (TAU * 1.1 * t).cos()) + 0.3 * (TAU * 50.0 * t).sin())
        .collect();
    let model = stage(&drive);
    let mut noise = Noise(1);
    let measured: Vec<f64> = model
        .iter()
        .zip(&time)
        .map(|(z, t)| z + 0.05 * noise.next() + 0.08 * (TAU * 0.4 * t).sin())
        .collect();
    let residual: Vec<f64> = measured.iter().zip(&model).map(|(a, b)| a - b).collect();
    let rms = (residual.iter().map(|e| e * e).sum::<f64>() / SAMPLES as f64).sqrt();
    let mut torn = measured.clone();
    torn[31_000..34_000].fill(f64::NAN);

    let mut page = Page::new("Identification of a simulated stage");
    page.lead("Made-up record of 10 s, 100 000 samples at 10 kHz; five play operators.")
        .verdict(Tone::Good, "The model follows the held-out record within the noise of the sensor.")
        .figures([
            KeyFigure::new("rms.report", "Error on the held-out record, rms", rms, "um")
                .note("aim: at most 0.45 µm"),
            KeyFigure::new("plays", "Play operators", THRESHOLDS.len(), ""),
            KeyFigure::new("noise_floor", "Noise floor", 0.028_9, "um"),
            KeyFigure::new("rate_term", "Rate term β", 3.1e-6, "s").note("fixed at zero below a decade"),
        ])
        .section("How well it fits", |section| {
            section.paragraph("Measured and modelled loops lie on each other; the residual is noise and a slow drift.");
            section.plot(
                Plot::new("Loops", Axis::linear("Drive", "V"), Axis::linear("Displacement", "um"))
                    .caption("Growing loops of the whole record.")
                    .square()
                    .series(Series::new("measured", Style::Solid, &drive, &measured))
                    .series(Series::new("model", Style::Line, &drive, &model)),
            );
            section.plot(
                Plot::new("Weights", Axis::linear("Threshold", "V"), Axis::linear("Weight", "um/V"))
                    .caption("What each play operator contributes.")
                    .square()
                    .series(Series::new("identified", Style::Bars, &THRESHOLDS, &WEIGHTS))
                    .series(Series::new("true", Style::Bars, &THRESHOLDS, &WEIGHTS.map(|w| 1.1 * w))),
            );
            section.plot(
                Plot::new("Displacement over time", Axis::linear("Time", "s"), Axis::linear("Displacement", "um"))
                    .caption("A stretch of 0.3 s without valid samples is left open.")
                    .series(Series::new("measured", Style::Solid, &time, &torn))
                    .series(Series::new("model", Style::Line, &time, &model)),
            );
            section.plot(
                Plot::new("Residual", Axis::linear("Time", "s"), Axis::linear("Measured − model", "um"))
                    .series(Series::new("residual", Style::Solid, &time, &residual))
                    .series(Series::level("noise floor, 3 σ", 0.0867)),
            );
        })
        .section("Error against frequency", |section| {
            section.plot(frequencies());
            section.table(
                ["Frequency (Hz)", "Without inverse", "Rate-independent", "Rate-dependent", "Published"],
                [0.05, 1.0, 100.0].map(|f: f64| {
                    vec![f.into(), (9.1 + f.ln()).into(), (0.4 + 0.1 * f).into(), 0.412.into(), Cell::from("–")]
                }),
            );
        })
        .section("Parameters and notes", |section| {
            let rows = THRESHOLDS.iter().zip(WEIGHTS).enumerate();
            section.table(
                ["Play", "Threshold (V)", "Weight (µm/V)"],
                rows.map(|(i, (&r, w))| vec![i.into(), r.into(), w.into()]),
            );
            section.list(["The first cycle is left out of the score.", "Plays start at rest."]);
        });
    page
}

fn frequencies() -> Plot {
    let hertz = [0.05, 0.1, 0.5, 1.0, 5.0, 10.0, 25.0, 50.0, 75.0, 100.0];
    let series = |label: &str, law: fn(f64) -> f64| {
        Series::new(label, Style::LinePoints, &hertz, &hertz.map(law))
    };
    Plot::new(
        "Largest error by frequency",
        Axis::log("Frequency", "Hz"),
        Axis::linear("Largest error", "um").including(0.0),
    )
    .caption("Three ways to drive the stage along the same sine.")
    .series(series("without inverse", |f| 6.0 + 0.9 * (1.0 + f).ln()))
    .series(series("rate-independent inverse", |f| {
        0.5 + 0.9 * (1.0 + f).ln()
    }))
    .series(series("rate-dependent inverse", |f| 0.45 + 0.003 * f))
    .series(Series::level("limit", 1.0))
}

/// Five plays on a common input, starting at rest.
fn stage(drive: &[f64]) -> Vec<f64> {
    let mut state = [0.0; 5];
    drive
        .iter()
        .map(|&u| {
            for (z, r) in state.iter_mut().zip(THRESHOLDS) {
                *z = (u - r).max((u + r).min(*z));
            }
            state.iter().zip(WEIGHTS).map(|(z, w)| z * w).sum()
        })
        .collect()
}

/// Uniform numbers between -1 and 1 from a linear congruential generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
