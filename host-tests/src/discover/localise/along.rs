//! Axes whose position every sample has: time, drive, rate, branch, distance from a turning point.

use crate::dataset::LengthUnit;
use crate::identify::cycles::{range, turning_points};

use super::super::diagnosis::RecordResiduals;
use super::tally::Tally;
use super::{BINS, Place, mean_square, short, stretch};

/// Decades of rate below the highest that are told apart.
const DECADES: f64 = 3.0;

/// Tallies the samples by a class; samples without one count nowhere.
fn tally(
    records: &[&RecordResiduals],
    classes: usize,
    class: impl Fn(&RecordResiduals) -> Vec<Option<usize>>,
) -> Tally {
    let mut tally = Tally::new(classes);
    for record in records {
        tally.record();
        let count = record.residual_um.len();
        let weight = 1.0 / count as f64;
        for (k, (class, e)) in class(record)
            .into_iter()
            .zip(&record.residual_um)
            .enumerate()
        {
            if let Some(class) = class {
                tally.add((k, count), class, (weight, weight * e * e, weight));
            }
        }
    }
    tally
}

fn even_edges(low: f64, high: f64) -> Vec<f64> {
    (0..=BINS)
        .map(|i| low + (high - low) * i as f64 / BINS as f64)
        .collect()
}

fn bin(edges: &[f64], value: f64) -> usize {
    edges[1..edges.len() - 1].partition_point(|&edge| edge <= value)
}

fn positions(edges: &[f64], unit: &str) -> Vec<(String, f64)> {
    edges
        .windows(2)
        .map(|e| {
            let label = format!("{} to {} {unit}", short(e[0]), short(e[1]));
            (label, 0.5 * (e[0] + e[1]))
        })
        .collect()
}

/// By the part of its record that has passed.
pub(super) fn within(records: &[&RecordResiduals], noise_um: f64) -> Option<Place> {
    let edges = even_edges(0.0, 100.0);
    let tally = tally(records, BINS, |record| {
        let count = record.residual_um.len() as f64;
        let part = |k| 100.0 * (k as f64 + 0.5) / count;
        (0..record.residual_um.len())
            .map(|k| Some(bin(&edges, part(k))))
            .collect()
    });
    Place::tallied(
        ("time", ("part of the record", "%"), false),
        (&tally, noise_um),
        positions(&edges, "%"),
        |from, to, lies| match (from, to + 1 == BINS) {
            (0, _) => format!(
                "{lies} in the first {} % of the records",
                short(edges[to + 1])
            ),
            (_, true) => format!(
                "{lies} in the last {} % of the records",
                short(100.0 - edges[from])
            ),
            _ => format!("{lies} {} of the records", stretch(&edges, from, to, "%")),
        },
    )
}

/// By record, in the order of time, with what the mean residual does from one to the next.
pub(super) fn over_records(
    records: &[&RecordResiduals],
    noise_um: f64,
    unit: LengthUnit,
) -> Option<Place> {
    let mut ordered = records.to_vec();
    ordered.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    if ordered.len() < 2 {
        return None;
    }
    let mut tally = Tally::new(ordered.len());
    for (class, record) in ordered.iter().enumerate() {
        tally.record();
        let count = record.residual_um.len();
        let weight = 1.0 / count as f64;
        let middle = record.displacement_um.iter().sum::<f64>() * weight;
        for (k, (e, y)) in record
            .residual_um
            .iter()
            .zip(&record.displacement_um)
            .enumerate()
        {
            // Without preference, a gap is as large as the motion.
            let moved = weight * (y - middle).powi(2);
            tally.add((k, count), class, (weight, weight * e * e, moved));
        }
    }
    let middle = |record: &RecordResiduals| {
        record.start_s + 0.5 * record.residual_um.len() as f64 * record.sample_time_s
    };
    let mut order: Vec<usize> = (0..ordered.len()).collect();
    let classes = tally.classes(noise_um, false);
    let over = |i: &usize| classes[*i].share - classes[*i].expected;
    order.sort_by(|a, b| over(b).total_cmp(&over(a)));
    // Records need not be neighbours to belong together: those that hold more than their part, the
    // most first, until they hold two thirds.
    let mut held = Vec::new();
    let mut share = 0.0;
    for i in order {
        if share > 2.0 / 3.0 || over(&i) <= 0.0 {
            break;
        }
        share += classes[i].share;
        held.push(i);
    }
    let telling: f64 = held.iter().map(over).sum();
    let names: Vec<&str> = held.iter().map(|&i| ordered[i].name.as_str()).collect();
    let band = tally.share_band(noise_um, |i| held.contains(&i));
    let means: Vec<(f64, f64)> = ordered
        .iter()
        .map(|r| {
            let mean = r.residual_um.iter().sum::<f64>() / r.residual_um.len() as f64;
            (middle(r), mean)
        })
        .collect();
    let (first, last) = (means[0], means[means.len() - 1]);
    let mut summary = if telling < 0.1 {
        "The gap is spread over the records as the motion is.".to_owned()
    } else {
        format!(
            "{} of the gap lies in {} of {} records, which hold {} of the motion: {}.",
            super::percent_in(share.min(1.0), band),
            held.len(),
            ordered.len(),
            super::percent(share - telling),
            names.join(", ")
        )
    };
    let total: f64 = ordered.iter().map(|r| mean_square(&r.residual_um)).sum();
    let of_means: f64 = means.iter().map(|(_, m)| m * m).sum();
    if of_means > 0.1 * total {
        summary += &format!(
            " The means of the records are {} of its square",
            super::percent(of_means / total)
        );
        // Records with an offset of their own have no mean but rounding.
        let drift = (last.1 - first.1).abs();
        summary += &if drift * drift > 1e-6 * of_means {
            format!(
                "; the mean goes from {} to {} {} in {} s.",
                short(unit.from_um(first.1)),
                short(unit.from_um(last.1)),
                unit.symbol(),
                short(last.0 - first.0)
            )
        } else {
            ".".to_owned()
        };
    }
    let positions = ordered
        .iter()
        .map(|r| (r.name.clone(), middle(r)))
        .collect();
    Some(Place {
        axis: "record",
        summary,
        share: share.min(1.0),
        telling,
        along: ("time at the middle of the record", "s"),
        log: false,
        bins: super::bins(&classes, positions),
    })
}

/// By the drive.
pub(super) fn drive(records: &[&RecordResiduals], noise_um: f64) -> Option<Place> {
    let all = || records.iter().flat_map(|r| &r.drive_v);
    let low = all().fold(f64::INFINITY, |a, &b| a.min(b));
    let high = all().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
    if high <= low {
        return None;
    }
    let edges = even_edges(low, high);
    let tally = tally(records, BINS, |record| {
        let classes = record.drive_v.iter().map(|&u| Some(bin(&edges, u)));
        classes.collect()
    });
    Place::tallied(
        ("amplitude", ("drive", "V"), false),
        (&tally, noise_um),
        positions(&edges, "V"),
        |from, to, lies| format!("{lies} at drives {}", stretch(&edges, from, to, "V")),
    )
}

/// Rate of each sample in V/s: the step that led to it.
fn rates(record: &RecordResiduals) -> Vec<f64> {
    let mut rates = vec![0.0];
    rates.extend(
        record
            .drive_v
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / record.sample_time_s),
    );
    if let [first, second, ..] = &mut rates[..] {
        *first = *second;
    }
    rates
}

/// By the size of the rate, the slowest class the resting samples too.
pub(super) fn rate(records: &[&RecordResiduals], noise_um: f64) -> Option<Place> {
    let all = records.iter().flat_map(|r| rates(r));
    let highest = all.fold(0.0, |a: f64, b| a.max(b.abs()));
    if highest <= 0.0 {
        return None;
    }
    let mut edges = vec![0.0];
    edges.extend(
        (0..BINS).map(|i| highest * 10f64.powf(-DECADES * (1.0 - i as f64 / (BINS - 1) as f64))),
    );
    let tally = tally(records, BINS, |record| {
        let rates = rates(record).into_iter();
        rates.map(|v| Some(bin(&edges, v.abs()))).collect()
    });
    let mut at = positions(&edges, "V/s");
    at.iter_mut()
        .zip(edges.windows(2))
        .skip(1)
        .for_each(|((_, at), e)| *at = (e[0] * e[1]).sqrt());
    at[0] = (
        format!("below {} V/s and at rest", short(edges[1])),
        0.7 * edges[1],
    );
    Place::tallied(
        ("rate", ("rate of the drive", "V/s"), true),
        (&tally, noise_um),
        at,
        |from, to, lies| format!("{lies} at rates {}", stretch(&edges, from, to, "V/s")),
    )
}

/// By the way the drive goes.
pub(super) fn branch(records: &[&RecordResiduals], noise_um: f64) -> Option<Place> {
    let tally = tally(records, 3, |record| {
        let rates = rates(record);
        let fastest = rates.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let still = 1e-3 * fastest;
        rates
            .iter()
            .map(|&v| {
                Some(match v {
                    v if v > still => 0,
                    v if v < -still => 2,
                    _ => 1,
                })
            })
            .collect()
    });
    let names = ["while the drive rises", "while it rests", "while it falls"];
    Place::tallied(
        ("branch", ("branches", ""), false),
        (&tally, noise_um),
        names.map(|name| (name.to_owned(), f64::NAN)).to_vec(),
        |from, to, lies| match (from, to) {
            (0, 1) => format!("{lies} while the drive rises or rests"),
            (1, 2) => format!("{lies} while the drive falls or rests"),
            _ => format!("{lies} {}", names[from].replace("it", "the drive")),
        },
    )
}

/// By how far the drive has come since it last turned, in percent of the whole range of the drive.
pub(super) fn turning(records: &[&RecordResiduals], noise_um: f64) -> Option<Place> {
    let widest = records
        .iter()
        .map(|r| range(&r.drive_v))
        .fold(0.0, f64::max);
    if widest <= 0.0 {
        return None;
    }
    let edges = even_edges(0.0, 100.0);
    let tally = tally(records, BINS, |record| {
        let drive = &record.drive_v;
        let turns = turning_points(drive, range(drive));
        let mut last = None;
        let mut next = turns.iter().peekable();
        drive
            .iter()
            .enumerate()
            .map(|(k, &u)| {
                last = next
                    .next_if(|&&turn| turn <= k)
                    .map(|&turn| drive[turn])
                    .or(last);
                last.map(|turn| bin(&edges, 100.0 * (u - turn).abs() / widest))
            })
            .collect()
    });
    Place::tallied(
        (
            "turning-point",
            (
                "distance from the last turning point, part of the range",
                "%",
            ),
            false,
        ),
        (&tally, noise_um),
        positions(&edges, "%"),
        |from, to, lies| {
            let stretch = stretch(&edges, from, to, "% of the range");
            format!("{lies} {stretch} from the last turning point")
        },
    )
}
