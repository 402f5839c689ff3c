//! The memory curve of a continuum of plays.
//!
//! A play with threshold r under the envelope (lo, hi) moves as
//! `z = max(lo - r, min(hi + r, z before))`. Taken over all r at once, z is a curve over r that
//! starts as z = 0 and is made of straight pieces of slope 0, +1 or -1, each the trace of one past
//! envelope value. A new envelope rewrites a stretch `[0, reach]` of it and leaves the rest alone: the
//! curve's slope never exceeds 1, so what `hi + r` or `lo - r` cuts off always begins at r = 0, and
//! with lo <= hi only one of the two can cut. The number of plays does not enter, and a density of
//! thresholds is integrated without being discretised.

/// One straight piece `z(r) = level + slope * r`, from the end of the piece inside it to `until`.
#[derive(Debug, Clone, Copy)]
struct Piece {
    until: f64,
    level: f64,
    slope: f64,
}

impl Piece {
    fn at(&self, r: f64) -> f64 {
        self.level + self.slope * r
    }
}

/// Play outputs in V as a function of the threshold in V, from 0 to a largest threshold.
#[derive(Debug, Clone)]
pub(super) struct MemoryCurve {
    /// Outermost piece first, so that the one at r = 0 is on top.
    pieces: Vec<Piece>,
    largest_v: f64,
}

impl MemoryCurve {
    /// The virgin curve z = 0 on `[0, largest_v]`.
    pub(super) fn new(largest_v: f64) -> Self {
        Self {
            pieces: vec![Piece {
                until: largest_v,
                level: 0.0,
                slope: 0.0,
            }],
            largest_v,
        }
    }

    /// Applies one envelope, V, `lo_v <= hi_v`.
    pub(super) fn apply(&mut self, lo_v: f64, hi_v: f64) {
        self.cut(hi_v, 1.0);
        self.cut(lo_v, -1.0);
    }

    /// Replaces the curve by `level + slope * r` wherever it lies outside that front.
    fn cut(&mut self, level: f64, slope: f64) {
        // How far the piece lies outside at r; inside where negative.
        let excess = |piece: &Piece, r: f64| slope * (piece.at(r) - level) - r;
        if !self
            .pieces
            .last()
            .is_some_and(|inner| excess(inner, 0.0) > 0.0)
        {
            return;
        }
        let mut reach = 0.0;
        while let Some(piece) = self.pieces.last() {
            if excess(piece, piece.until) < 0.0 {
                // A piece parallel to the front lies outside as a whole or not at all, so it can
                // only get here by rounding, at its very start.
                if piece.slope != slope {
                    let crossing = slope * (piece.level - level) / (1.0 - slope * piece.slope);
                    reach = crossing.max(reach).min(piece.until);
                }
                break;
            }
            reach = piece.until;
            self.pieces.pop();
        }
        if self.pieces.is_empty() {
            reach = self.largest_v;
        }
        self.pieces.push(Piece {
            until: reach,
            level,
            slope,
        });
    }

    /// The pieces from the inside out as (start, end, level, slope).
    pub(super) fn pieces(&self) -> impl Iterator<Item = (f64, f64, f64, f64)> {
        self.pieces.iter().rev().scan(0.0, |start, piece| {
            let from = *start;
            *start = piece.until;
            Some((from, piece.until, piece.level, piece.slope))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(curve: &MemoryCurve, r: f64) -> f64 {
        let (_, _, level, slope) = curve
            .pieces()
            .find(|&(_, end, ..)| r <= end)
            .expect("r within the curve");
        level + slope * r
    }

    proptest! {
        /// The curve at any threshold is the play with that threshold, computed one by one.
        #[test]
        fn equals_single_plays(
            envelopes in prop::collection::vec((-50.0..50.0_f64, 0.0..20.0_f64), 1..200),
        ) {
            let thresholds: Vec<f64> = (1..=60).map(|i| 0.73 * f64::from(i)).collect();
            let mut plays = vec![0.0_f64; thresholds.len()];
            let mut curve = MemoryCurve::new(45.0);
            for (centre, half) in envelopes {
                let (lo, hi) = (centre - half, centre + half);
                curve.apply(lo, hi);
                for (z, r) in plays.iter_mut().zip(&thresholds) {
                    *z = z.min(hi + r).max(lo - r);
                    prop_assert!((at(&curve, *r) - *z).abs() < 1e-12);
                }
            }
        }

        /// Pieces tile the range whatever came in, so no threshold is lost or counted twice.
        #[test]
        fn pieces_tile_the_range(inputs in prop::collection::vec(-40.0..40.0_f64, 1..300)) {
            let mut curve = MemoryCurve::new(33.0);
            for u in inputs {
                curve.apply(u, u);
                let mut expected_start = 0.0;
                for (start, end, _, slope) in curve.pieces() {
                    prop_assert_eq!(start, expected_start);
                    prop_assert!(end >= start && slope.abs() <= 1.0);
                    expected_start = end;
                }
                prop_assert_eq!(expected_start, 33.0);
            }
        }
    }

    #[test]
    fn a_sweep_leaves_one_piece_for_each_unforgotten_turning_point() {
        let mut curve = MemoryCurve::new(100.0);
        // Nested reversals are all remembered.
        for u in [40.0, -30.0, 20.0, -10.0] {
            curve.apply(u, u);
        }
        assert_eq!(curve.pieces().count(), 5);
        // Going past an earlier extreme wipes out everything inside it.
        curve.apply(50.0, 50.0);
        assert_eq!(curve.pieces().count(), 2);
    }

    #[test]
    fn repeated_cycles_do_not_grow_the_stack() {
        let mut curve = MemoryCurve::new(30.0);
        for k in 0..100_000 {
            let phase = f64::from(k) * 0.01;
            let u = 40.0 * phase.sin();
            let half = 5.0 * phase.cos().abs();
            curve.apply(u - half, u + half);
            assert!(
                curve.pieces.len() < 10,
                "{} pieces after {k} steps",
                curve.pieces.len()
            );
        }
    }
}
