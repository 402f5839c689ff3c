//! What the residual goes along with: drive, its rate, its acceleration, the square of the
//! displacement, and its own past.

use super::super::diagnosis::RecordResiduals;
use super::{Bin, Place, percent};

/// Candidates, as they are called in a sentence.
const NAMES: [&str; 5] = [
    "the drive",
    "its rate",
    "its acceleration",
    "the square of the displacement",
    "its own past",
];

/// Correlation coefficients, each with its record means taken out; the own past tells colour, not
/// cause, and is never the most telling.
pub(super) fn correlation(records: &[&RecordResiduals], noise_um: f64) -> Option<Place> {
    // Sums of products with the residual and of squares, every record with the same weight.
    let mut sums = [(0.0, 0.0, 0.0); NAMES.len()];
    let mut square = 0.0;
    for record in records {
        let e = &record.residual_um;
        square += super::mean_square(e) / records.len() as f64;
        for (sum, signal) in sums.iter_mut().zip(signals(record)) {
            let count = signal.len();
            if count < 3 {
                continue;
            }
            let late = &e[e.len() - count..];
            let mean = |v: &[f64]| v.iter().sum::<f64>() / count as f64;
            let (mx, my) = (mean(&signal), mean(late));
            for (x, y) in signal.iter().zip(late) {
                let (x, y) = (x - mx, y - my);
                sum.0 += x * y / count as f64;
                sum.1 += x * x / count as f64;
                sum.2 += y * y / count as f64;
            }
        }
    }
    let r: Vec<f64> = sums
        .iter()
        .map(|(xy, xx, yy)| xy / (xx * yy).sqrt().max(f64::MIN_POSITIVE))
        .collect();
    let gap = square - noise_um * noise_um;
    let explained = |i: usize| {
        let of_all = r[i] * r[i] * sums[i].2 / records.len() as f64;
        (of_all / gap.max(f64::MIN_POSITIVE)).min(1.0)
    };
    let best = (0..NAMES.len() - 1).max_by(|&a, &b| explained(a).total_cmp(&explained(b)))?;
    let share = explained(best);
    let past = r[NAMES.len() - 1];
    let summary = format!(
        "{} (correlation {:.2}) would explain {} of the gap; from sample to sample the residual \
         correlates by {past:.2}.",
        capital(NAMES[best]),
        r[best],
        percent(share)
    );
    let bins = (0..NAMES.len())
        .map(|i| Bin {
            label: capital(NAMES[i]),
            at: f64::NAN,
            rms_um: r[i],
            band_um: (f64::NAN, f64::NAN),
            share: explained(i),
            expected: 0.0,
        })
        .collect();
    Some(Place {
        axis: "correlation",
        summary,
        share,
        // One coefficient is fitted: no more telling than what it leaves unexplained.
        telling: share * share,
        along: ("signal", ""),
        log: false,
        bins,
    })
}

fn capital(text: &str) -> String {
    let mut rest = text.chars();
    let first = rest.next().map(|c| c.to_ascii_uppercase());
    first.into_iter().chain(rest).collect()
}

/// The candidates, aligned with the end of the residual.
fn signals(record: &RecordResiduals) -> [Vec<f64>; NAMES.len()] {
    let difference = |v: &[f64]| -> Vec<f64> { v.windows(2).map(|w| w[1] - w[0]).collect() };
    let rate = difference(&record.drive_v);
    let acceleration = difference(&rate);
    let e = &record.residual_um;
    [
        record.drive_v.clone(),
        rate,
        acceleration,
        record.displacement_um.iter().map(|y| y * y).collect(),
        e[..e.len() - 1].to_vec(),
    ]
}
