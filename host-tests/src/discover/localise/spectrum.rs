//! The axis of frequencies: where, and on lines of which kind.

use super::super::diagnosis::RecordResiduals;
use super::lines::{KINDS, ODD, Spectrum};
use super::tally::{Class, Tally, richest};
use super::{Place, percent_in, short, stretch};

/// Frequency bins.
const BINS: usize = 20;
/// Share that lines of one kind must have of a stretch to be named with it.
const MOSTLY: f64 = 0.6;
/// How near a multiple of the drive has to come to a mode, relative.
const NEAR: f64 = 0.1;

/// By frequency and by kind of line. Without preference, a gap lies where the motion does.
pub(super) fn frequency(
    records: &[&RecordResiduals],
    noise_um: f64,
    modes: &[f64],
) -> Option<Place> {
    let spectra: Vec<(&RecordResiduals, Spectrum)> = records
        .iter()
        .filter_map(|record| Some((*record, Spectrum::new(record)?)))
        .collect();
    let low = spectra.iter().map(|(_, s)| s.step_hz);
    let low = low.fold(f64::INFINITY, f64::min);
    let highest = |s: &Spectrum| s.step_hz * s.power.len() as f64;
    let high = spectra.iter().map(|(_, s)| highest(s)).fold(0.0, f64::max);
    if low >= high || !high.is_finite() {
        return None;
    }
    let edges: Vec<f64> = (0..=BINS)
        .map(|i| low * (high / low).powf(i as f64 / BINS as f64))
        .collect();
    let joint = tallied(&spectra, &edges, BINS * KINDS.len(), |bin, kind| {
        bin * KINDS.len() + kind
    });
    let plain = tallied(&spectra, &edges, BINS, |bin, _| bin);
    let classes = plain.classes(noise_um, true);
    // All lines, or those of one kind alone, whichever tells more.
    let cells = joint.classes(noise_um, true);
    let of_kind = |kind: usize| -> Vec<Class> {
        (0..BINS)
            .map(|bin| cells[bin * KINDS.len() + kind])
            .collect()
    };
    let (mut from, mut to, telling) = richest(&classes)?;
    let mut chosen: Option<(usize, f64)> = None;
    let mut most = telling;
    for kind in 0..KINDS.len() {
        let own = of_kind(kind);
        if let Some((a, b, telling)) = richest(&own) {
            let within: f64 = own[a..=b].iter().map(|c| c.share).sum();
            if telling > MOSTLY.max(most) || (telling > 0.9 * most && within > MOSTLY) {
                (from, to) = (a, b);
                most = most.max(telling);
                chosen = Some((kind, within));
            }
        }
    }
    let (share, band, kind) = match chosen {
        Some((kind, share)) => {
            let band = joint.share_band(noise_um, |i| {
                i % KINDS.len() == kind && (from..=to).contains(&(i / KINDS.len()))
            });
            (share, band, format!(" {}", KINDS[kind]))
        }
        None => {
            let share: f64 = classes[from..=to].iter().map(|c| c.share).sum();
            let band = plain.share_band(noise_um, |i| (from..=to).contains(&i));
            (share, band, String::new())
        }
    };
    let motion: f64 = classes[from..=to].iter().map(|c| c.expected).sum();
    let mut summary = if most < 0.1 {
        "The gap lies at the frequencies of the motion itself.".to_owned()
    } else {
        format!(
            "{} of the gap lies {}{kind}, where {} of the motion lies.",
            percent_in(share.min(1.0), band),
            stretch(&edges, from, to, "Hz"),
            super::percent(motion)
        )
    };
    if let Some(met) = odd_multiples(&spectra, noise_um, modes) {
        summary = format!("{summary} {met}");
    }
    let positions = edges
        .windows(2)
        .map(|e| {
            let label = format!("{} to {} Hz", short(e[0]), short(e[1]));
            (label, (e[0] * e[1]).sqrt())
        })
        .collect();
    Some(Place {
        axis: "frequency",
        summary,
        share: share.min(1.0),
        telling: most,
        along: ("frequency", "Hz"),
        log: true,
        bins: super::bins(&classes, positions),
    })
}

fn tallied(
    spectra: &[(&RecordResiduals, Spectrum)],
    edges: &[f64],
    classes: usize,
    class: impl Fn(usize, usize) -> usize,
) -> Tally {
    let mut tally = Tally::new(classes);
    for (_, spectrum) in spectra {
        tally.record();
        let count = spectrum.power.len();
        let motion: f64 = spectrum.motion.iter().sum();
        for line in 0..count {
            let hz = (line + 1) as f64 * spectrum.step_hz;
            let bin = edges[1..edges.len() - 1].partition_point(|&edge| edge <= hz);
            let moved = spectrum.motion[line] / motion.max(f64::MIN_POSITIVE);
            // Lines are nearly independent of each other, so they are dealt to the blocks in turn.
            let turn = line % super::tally::BLOCKS;
            tally.add(
                (turn, super::tally::BLOCKS),
                class(bin, spectrum.kinds[line]),
                (1.0 / count as f64, spectrum.power[line], moved),
            );
        }
    }
    tally
}

/// Says where an odd multiple of a single-line drive that stands out of the noise meets a mode.
fn odd_multiples(
    spectra: &[(&RecordResiduals, Spectrum)],
    noise_um: f64,
    modes: &[f64],
) -> Option<String> {
    let mut best: Option<(f64, String)> = None;
    for (record, spectrum) in spectra {
        let Some((periods, true)) = spectrum.periods else {
            continue;
        };
        let fundamental = periods as f64 * spectrum.step_hz;
        let noise = noise_um * noise_um / spectrum.power.len() as f64;
        for multiple in (3..40).step_by(2) {
            let line = periods * multiple;
            let Some(&power) = spectrum.power.get(line - 1) else {
                break;
            };
            let hz = line as f64 * spectrum.step_hz;
            let met = modes.iter().find(|&&mode| (hz / mode - 1.0).abs() < NEAR);
            let clear = spectrum.kinds[line - 1] == ODD && power > 20.0 * noise;
            let (Some(mode), true) = (met, clear) else {
                continue;
            };
            if best.as_ref().is_none_or(|(most, _)| power > *most) {
                let said = format!(
                    "In {} the {multiple}{} multiple of the drive's {} Hz meets the mode at {} Hz, \
                     which magnifies the odd part of the hysteresis there.",
                    record.name,
                    if multiple % 10 == 3 && multiple != 13 {
                        "rd"
                    } else if multiple % 10 == 1 && multiple != 11 {
                        "st"
                    } else {
                        "th"
                    },
                    short(fundamental),
                    short(*mode)
                );
                best = Some((power, said));
            }
        }
    }
    best.map(|(_, said)| said)
}
