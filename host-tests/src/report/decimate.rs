//! Thinning of long series to what a drawing can show.
//!
//! All functions work on drawing coordinates, one unit being about a pixel. A point that is not
//! finite in both coordinates is a gap. The first and last drawable point and the extremes in both
//! directions always remain.

use std::collections::HashSet;

/// A point in drawing coordinates.
pub(super) type Point = (f64, f64);

/// Longest stretch that line simplification treats at once: bounds its cost, which may grow with
/// the square of the length on a curve that returns to itself again and again.
const STRETCH: usize = 1024;

/// Share of the resolution by which a simplified curve may deviate.
const TOLERANCE: f64 = 0.2;

/// Indices of the points to draw as connected strokes, at most `budget` in all.
///
/// Where x never falls, each column of pixels keeps its first, lowest, highest and last point; else
/// the curve is simplified after Ramer, Douglas and Peucker. Both start at a resolution of one unit
/// and coarsen twofold until the budget (at least 16) is met; a gap narrower than the resolution
/// may be bridged.
pub(super) fn thin_line(points: &[Point], budget: usize) -> Vec<Vec<usize>> {
    let budget = budget.max(16);
    let fixed = extremes(points);
    let mut strokes = split_at_gaps(points);
    let mut resolution = 1.0;
    while strokes.iter().map(Vec::len).sum::<usize>() > budget {
        strokes = bridge(points, strokes, resolution)
            .into_iter()
            .map(|stroke| {
                if stroke
                    .windows(2)
                    .all(|pair| points[pair[0]].0 <= points[pair[1]].0)
                {
                    columns(points, &stroke, resolution)
                } else {
                    simplify(points, &stroke, &fixed, TOLERANCE * resolution)
                }
            })
            .collect();
        resolution *= 2.0;
    }
    strokes
}

/// Indices of the points to draw as separate marks, at most `budget` (at least 16).
///
/// Of the points in one square of a grid the first remains; the grid coarsens until the budget is
/// met.
pub(super) fn thin_scatter(points: &[Point], budget: usize) -> Vec<usize> {
    let budget = budget.max(16);
    let fixed = extremes(points);
    let mut kept: Vec<usize> = (0..points.len()).filter(|&i| drawable(points[i])).collect();
    let mut side = 0.5;
    while kept.len() > budget {
        let mut taken = HashSet::new();
        kept.retain(|&i| {
            let (x, y) = points[i];
            let free = taken.insert(((x / side).floor() as i64, (y / side).floor() as i64));
            free || fixed.contains(&i)
        });
        side *= 2.0;
    }
    kept
}

fn drawable((x, y): Point) -> bool {
    x.is_finite() && y.is_finite()
}

/// Indices of the leftmost, rightmost, lowest and highest drawable point, sorted.
fn extremes(points: &[Point]) -> Vec<usize> {
    let among = || (0..points.len()).filter(|&i| drawable(points[i]));
    let by_x = |a: &usize, b: &usize| points[*a].0.total_cmp(&points[*b].0);
    let by_y = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
    let mut indices: Vec<usize> = [
        among().min_by(by_x),
        among().max_by(by_x),
        among().min_by(by_y),
        among().max_by(by_y),
    ]
    .into_iter()
    .flatten()
    .collect();
    indices.sort_unstable();
    indices.dedup();
    indices
}

fn split_at_gaps(points: &[Point]) -> Vec<Vec<usize>> {
    let mut strokes = Vec::new();
    let mut current = Vec::new();
    for (i, &point) in points.iter().enumerate() {
        if drawable(point) {
            current.push(i);
        } else if !current.is_empty() {
            strokes.push(std::mem::take(&mut current));
        }
    }
    if !current.is_empty() {
        strokes.push(current);
    }
    strokes
}

/// Joins strokes whose facing ends lie within `resolution` of each other: a gap too small to see.
fn bridge(points: &[Point], strokes: Vec<Vec<usize>>, resolution: f64) -> Vec<Vec<usize>> {
    let mut joined: Vec<Vec<usize>> = Vec::new();
    for stroke in strokes {
        let near = |previous: &Vec<usize>| match (previous.last(), stroke.first()) {
            (Some(&a), Some(&b)) => {
                let ((ax, ay), (bx, by)) = (points[a], points[b]);
                (ax - bx).abs() <= resolution && (ay - by).abs() <= resolution
            }
            _ => true,
        };
        match joined.last_mut() {
            Some(previous) if near(previous) => previous.extend(stroke),
            _ => joined.push(stroke),
        }
    }
    joined
}

/// First, lowest, highest and last point of every column `width` wide; x must not fall.
fn columns(points: &[Point], stroke: &[usize], width: f64) -> Vec<usize> {
    let column = |i: usize| (points[i].0 / width).floor();
    let by_y = |a: &&usize, b: &&usize| points[**a].1.total_cmp(&points[**b].1);
    let mut kept = Vec::new();
    for group in stroke.chunk_by(|&a, &b| column(a) == column(b)) {
        let mut corners = [
            group.first().copied(),
            group.iter().min_by(by_y).copied(),
            group.iter().max_by(by_y).copied(),
            group.last().copied(),
        ];
        corners.sort_unstable();
        kept.extend(corners.into_iter().flatten());
    }
    kept.dedup();
    kept
}

/// Ramer-Douglas-Peucker: drops every point nearer than `tolerance` to the chord that replaces it.
fn simplify(points: &[Point], stroke: &[usize], fixed: &[usize], tolerance: f64) -> Vec<usize> {
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
        let farthest = (from + 1..to)
            .map(|k| (k, distance_to_segment(points[stroke[k]], a, b)))
            .max_by(|(_, p), (_, q)| p.total_cmp(q));
        if let Some((middle, distance)) = farthest
            && distance > tolerance
        {
            keep[middle] = true;
            open.push((from, middle));
            open.push((middle, to));
        }
    }
    (0..=last).filter(|&k| keep[k]).map(|k| stroke[k]).collect()
}

fn distance_to_segment((px, py): Point, (ax, ay): Point, (bx, by): Point) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 {
        ((px - ax) * dx + (py - ay) * dy) / length
    } else {
        0.0
    };
    let along = along.clamp(0.0, 1.0);
    (px - ax - along * dx).hypot(py - ay - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
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
    fn short_series_stay_whole_and_gaps_split_them() {
        let points = [
            (0.0, 1.0),
            (1.0, f64::NAN),
            (2.0, 3.0),
            (3.0, 4.0),
            (f64::INFINITY, 5.0),
        ];
        assert_eq!(thin_line(&points, 100), [vec![0], vec![2, 3]]);
        assert_eq!(thin_scatter(&points, 100), [0, 2, 3]);
    }

    #[test]
    fn a_spike_of_one_sample_survives() {
        let mut points: Vec<Point> = (0..1_000_000)
            .map(|i| (i as f64 * 1e-3, (i as f64 * 0.01).sin()))
            .collect();
        points[345_678].1 = 40.0;
        points[777_777].1 = -40.0;
        let strokes = thin_line(&points, 4_000);
        assert_eq!(strokes.len(), 1);
        assert!(strokes[0].len() <= 4_000);
        for index in [0, 345_678, 777_777, 999_999] {
            assert!(strokes[0].contains(&index), "sample {index} is lost");
        }
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
                .map(|ends| distance_to_segment((x, y), points[ends[0]], points[ends[1]]))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.2 + 1e-9, "({x}, {y}) is {nearest} away");
        }
    }

    #[test]
    fn many_cycles_meet_the_budget_without_leaving_the_band() {
        let points = loops(1_000_000, 5_000.0);
        let strokes = thin_line(&points, 4_000);
        assert!(total(&strokes) <= 4_000);
        let highest = points.iter().map(|p| p.1).fold(f64::MIN, f64::max);
        assert!(strokes[0].iter().any(|&i| points[i].1 == highest));
    }

    #[test]
    fn a_gap_wide_enough_to_see_stays_open() {
        let mut points: Vec<Point> = (0..100_000).map(|i| (i as f64 * 0.01, 5.0)).collect();
        for point in &mut points[40_000..41_000] {
            point.1 = f64::NAN;
        }
        points[70_000].1 = f64::NAN;
        let strokes = thin_line(&points, 4_000);
        assert_eq!(
            strokes.len(),
            2,
            "ten pixels of gap show, a hundredth does not"
        );
        assert_eq!(
            (strokes[0].last(), strokes[1].first()),
            (Some(&39_999), Some(&41_000))
        );
    }

    #[test]
    fn alternating_gaps_cannot_break_the_budget() {
        let points: Vec<Point> = (0..200_000_u64)
            .map(|i| {
                let y = if i % 2 == 0 {
                    f64::NAN
                } else {
                    ((i * 7919) % 400) as f64
                };
                (((i * 104_729) % 1000) as f64, y)
            })
            .collect();
        assert!(total(&thin_line(&points, 1_000)) <= 1_000);
        assert!(thin_scatter(&points, 1_000).len() <= 1_000);
    }

    proptest! {
        #[test]
        fn extremes_remain_and_order_is_kept(
            points in prop::collection::vec(
                (prop_oneof![9 => 0.0..1000.0, 1 => Just(f64::NAN)], 0.0..400.0), 0..600),
            sorted: bool,
        ) {
            let mut points = points;
            if sorted {
                points.sort_by(|a: &Point, b: &Point| a.0.total_cmp(&b.0));
            }
            let strokes = thin_line(&points, 64);
            let scatter = thin_scatter(&points, 64);
            let line: Vec<usize> = strokes.concat();
            for kept in [&line, &scatter] {
                prop_assert!(kept.len() <= 64);
                prop_assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
                prop_assert!(kept.iter().all(|&i| points[i].0.is_finite()));
                for value in [|p: Point| p.0, |p: Point| -p.0, |p: Point| p.1, |p: Point| -p.1] {
                    let drawn = kept.iter().map(|&i| value(points[i])).fold(f64::MIN, f64::max);
                    let all = points.iter().filter(|p| p.0.is_finite());
                    let truth = all.map(|&p| value(p)).fold(f64::MIN, f64::max);
                    prop_assert_eq!(drawn, truth);
                }
            }
        }
    }
}
