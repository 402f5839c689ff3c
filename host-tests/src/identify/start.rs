//! The unknown state of the plays where a record starts, as a short menu of histories.

/// What moved the drive before a record's first sample `u0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Nothing: every play at zero, then pushed by the first sample.
    Zero,
    /// The stage was at rest and depolarised at `u0`, the drive then went to `u0 + volts` and came
    /// back. Zero volts: depolarised; large ones: the last turning point was far above or below.
    Excursion(f64),
    /// The record itself: it is one or more periods of a steady loop.
    Periodic,
    /// The record before it in time, whose end it goes on from.
    Carried,
}

impl Start {
    /// Histories to choose from, for a drive of the given range (V).
    pub fn menu(range: f64) -> Vec<Self> {
        let sizes = [0.1, 0.25, 0.5, 0.75, 1.0, 2.0];
        [Self::Excursion(0.0), Self::Zero, Self::Periodic]
            .into_iter()
            .chain(
                sizes
                    .iter()
                    .flat_map(|s| [Self::Excursion(s * range), Self::Excursion(-s * range)]),
            )
            .collect()
    }

    /// Output of a play of threshold `r` before the first sample `u0`, and its derivative by `r`.
    ///
    /// [`Start::Periodic`] and [`Start::Carried`] have no closed form: what they yield is where the extra
    /// period starts from, and where nothing is known of the record before.
    pub fn play(self, u0: f64, r: f64) -> (f64, f64) {
        match self {
            Self::Zero if u0 > r => (u0 - r, -1.0),
            Self::Zero if u0 < -r => (u0 + r, 1.0),
            Self::Zero => (0.0, 0.0),
            Self::Periodic | Self::Carried => (u0, 0.0),
            Self::Excursion(volts) => {
                // Pushed out by |volts| - r, on the way back pulled in to r.
                let pushed = volts.abs() - r;
                let (distance, slope) = if pushed <= 0.0 {
                    (0.0, 0.0)
                } else if pushed < r {
                    (pushed, -1.0)
                } else {
                    (r, 1.0)
                };
                let sign = volts.signum();
                (u0 + sign * distance, sign * slope)
            }
        }
    }

    /// For the report.
    pub fn describe(self) -> String {
        match self {
            Self::Zero => "plays at zero".to_owned(),
            Self::Excursion(0.0) => "depolarised at the first drive value".to_owned(),
            Self::Excursion(volts) => format!(
                "last turning point {:.3} V {} the first drive value",
                volts.abs(),
                if volts > 0.0 { "above" } else { "below" }
            ),
            Self::Carried => "the end of the record before it".to_owned(),
            Self::Periodic => "steady loop: the record's own end".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron::play::{Envelope, play};

    #[test]
    fn excursions_are_what_a_play_does() {
        for volts in [0.0, 0.7, -0.7, 1.5, -1.5, 9.0, -9.0] {
            let (u0, r) = (3.0, 1.0);
            let out = play(u0, Envelope::closed(u0 + volts), r);
            let back = play(out, Envelope::closed(u0), r);
            assert!(
                (Start::Excursion(volts).play(u0, r).0 - back).abs() < 1e-12,
                "{volts}"
            );
        }
    }
}
