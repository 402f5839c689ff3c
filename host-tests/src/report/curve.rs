//! Thinning of curves that return to themselves, such as hysteresis loops.

use super::decimate::{Point, drawable};

/// Longest stretch that line simplification treats at once: bounds its cost, which may grow with
/// the square of the length on a curve that returns to itself again and again.
const STRETCH: usize = 1024;

/// How far a simplified curve may run beside its points: too little to see.
const TOLERANCE: f64 = 0.2;

/// Ramer-Douglas-Peucker: drops every point within the tolerance of the chord that replaces it.
pub(super) fn simplify(points: &[Point], stroke: &[usize], fixed: &[usize]) -> Vec<usize> {
    let Some(last) = stroke.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut keep: Vec<bool> = (0..=last)
        .map(|k| k % STRETCH == 0 || k == last || fixed.binary_search(&stroke[k]).is_ok())
        .collect();
    let anchors: Vec<usize> = (0..=last).filter(|&k| keep[k]).collect();
    let mut open: Vec<(usize, usize)> = anchors.windows(2).map(|pair| (pair[0], pair[1])).collect();
    while let Some((from, to)) = open.pop() {
        let (a, b) = (points[stroke[from]], points[stroke[to]]);
        let (mut middle, mut farthest) = (from, TOLERANCE * TOLERANCE);
        for k in from + 1..to {
            let distance = off_segment(points[stroke[k]], a, b);
            if distance > farthest {
                (middle, farthest) = (k, distance);
            }
        }
        if middle > from {
            keep[middle] = true;
            open.push((from, middle));
            open.push((middle, to));
        }
    }
    (0..=last).filter(|&k| keep[k]).map(|k| stroke[k]).collect()
}

/// A grid of square cells that remembers where there is ink.
pub(super) struct Sheet {
    side: f64,
    corner: Point,
    columns: usize,
    inked: Vec<bool>,
}

impl Sheet {
    /// An empty sheet under all `points`; `side` grows where there would be too many cells.
    pub fn new(points: &[Point], side: f64) -> Self {
        let least = |of: fn(&Point) -> f64| {
            points
                .iter()
                .filter(|&&p| drawable(p))
                .map(of)
                .fold(f64::INFINITY, f64::min)
        };
        let corner = (least(|p| p.0), least(|p| p.1));
        let extent = (-least(|p| -p.0) - corner.0, -least(|p| -p.1) - corner.1);
        let side = side.max(extent.0.max(extent.1) / 4096.0);
        let cells = |length: f64| (length / side) as usize + 1;
        let columns = cells(extent.0);
        Self {
            side,
            corner,
            columns,
            inked: vec![false; columns * cells(extent.1)],
        }
    }

    /// Inks the segment; whether any cell under it was empty.
    fn ink(&mut self, (ax, ay): Point, (bx, by): Point) -> bool {
        // Steps of half a cell miss no more than corners that the segment cuts.
        let steps = (2.0 * (bx - ax).abs().max((by - ay).abs()) / self.side)
            .ceil()
            .max(1.0);
        let mut fresh = false;
        for step in 0..=steps as usize {
            let t = step as f64 / steps;
            let column = ((ax + t * (bx - ax) - self.corner.0) / self.side) as usize;
            let row = ((ay + t * (by - ay) - self.corner.1) / self.side) as usize;
            if let Some(cell) = self.inked.get_mut(row * self.columns + column) {
                fresh |= !std::mem::replace(cell, true);
            }
        }
        fresh
    }
}

/// Leaves out the segments that find no empty cell on the sheet, except at the points in `fixed`.
pub(super) fn sieve(
    points: &[Point],
    strokes: &[Vec<usize>],
    fixed: &[usize],
    mut sheet: Sheet,
) -> Vec<Vec<usize>> {
    let mut kept: Vec<Vec<usize>> = Vec::new();
    for stroke in strokes {
        // A stroke of one point counts as a segment without length.
        let alone = (stroke.len() == 1).then(|| (stroke[0], stroke[0]));
        let segments = stroke
            .windows(2)
            .map(|pair| (pair[0], pair[1]))
            .chain(alone);
        let mut pen_down = false;
        for (a, b) in segments {
            let fresh = sheet.ink(points[a], points[b]);
            let needed = fresh || [a, b].iter().any(|i| fixed.binary_search(i).is_ok());
            match kept.last_mut() {
                Some(current) if needed && pen_down => current.push(b),
                _ if needed && a == b => kept.push(vec![a]),
                _ if needed => kept.push(vec![a, b]),
                _ => {}
            }
            pen_down = needed;
        }
    }
    kept
}

/// Squared distance of the first point to the segment between the others.
fn off_segment((px, py): Point, (ax, ay): Point, (bx, by): Point) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 {
        ((px - ax) * dx + (py - ay) * dy) / length
    } else {
        0.0
    };
    let along = along.clamp(0.0, 1.0);
    let (ex, ey) = (px - ax - along * dx, py - ay - along * dy);
    ex * ex + ey * ey
}

#[cfg(test)]
mod tests {
    use super::super::decimate::thin_line;
    use super::*;
    use std::f64::consts::TAU;

    fn loops(samples: usize, cycles: f64) -> Vec<Point> {
        (0..samples)
            .map(|i| {
                let phase = TAU * cycles * i as f64 / samples as f64;
                (
                    200.0 + 190.0 * phase.sin(),
                    200.0 + 190.0 * (phase - 0.3).sin(),
                )
            })
            .collect()
    }

    fn total(strokes: &[Vec<usize>]) -> usize {
        strokes.iter().map(Vec::len).sum()
    }

    #[test]
    fn a_simplified_loop_stays_on_the_curve() {
        // One cycle fits the budget at the first resolution, hence the tolerance of 0.2 units.
        let points = loops(100_000, 1.0);
        let strokes = thin_line(&points, 4_000);
        assert!(total(&strokes) < 400, "{} points", total(&strokes));
        for &(x, y) in points.iter().step_by(7) {
            let nearest = strokes[0]
                .windows(2)
                .map(|ends| off_segment((x, y), points[ends[0]], points[ends[1]]))
                .fold(f64::INFINITY, f64::min);
            assert!(
                nearest.sqrt() <= 0.2 + 1e-9,
                "({x}, {y}) is {} away",
                nearest.sqrt()
            );
        }
    }

    #[test]
    fn noisy_cycles_are_drawn_by_true_segments_over_all_their_band() {
        let noise = |i: usize| (i.wrapping_mul(2_654_435_761) % 65_536) as f64 / 16_384.0;
        let mut points = loops(50_000, 250.0);
        for (i, point) in points.iter_mut().enumerate() {
            *point = (point.0 + noise(i), point.1 + noise(i + 7));
        }
        let strokes = thin_line(&points, 4_000);
        assert!((1_000..=4_000).contains(&total(&strokes)));
        let segments = || strokes.iter().flat_map(|stroke| stroke.windows(2));
        for pair in segments() {
            for i in pair[0] + 1..pair[1] {
                let off = off_segment(points[i], points[pair[0]], points[pair[1]]);
                assert!(off.sqrt() <= 0.2 + 1e-9, "the curve left a drawn segment");
            }
        }
        for &point in points.iter().step_by(97) {
            let nearest = segments()
                .map(|pair| off_segment(point, points[pair[0]], points[pair[1]]))
                .fold(f64::INFINITY, f64::min);
            assert!(
                nearest.sqrt() < 4.0,
                "{point:?} is {} from ink",
                nearest.sqrt()
            );
        }
    }

    #[test]
    fn many_cycles_meet_the_budget() {
        let points = loops(200_000, 1_000.0);
        let strokes = thin_line(&points, 4_000);
        assert!(total(&strokes) <= 4_000);
        let highest = points.iter().map(|p| p.1).fold(f64::MIN, f64::max);
        assert!(strokes.iter().flatten().any(|&i| points[i].1 == highest));
    }
}
