//! Thinning of long series to what a drawing can show.
//!
//! All functions work on drawing coordinates, one unit being about a pixel. A point that is not
//! finite in both coordinates is a gap. The first and last drawable point and the extremes in both
//! directions always remain.

use super::curve::{Sheet, sieve, simplify};
use std::collections::HashSet;

/// A point in drawing coordinates.
pub(super) type Point = (f64, f64);

/// Indices of the points to draw as connected strokes, at most `budget` (at least 16) in all.
///
/// Where x never falls, each column keeps its lowest and its highest point, columns being half a
/// unit wide or, if the budget demands it, wider; a gap narrower than a column may be bridged.
///
/// Other curves are simplified after Ramer, Douglas and Peucker. If that is not enough, as for
/// hundreds of noisy cycles, segments that would only darken what is inked already are left out,
/// so that all segments drawn are true ones.
pub(super) fn thin_line(points: &[Point], budget: usize) -> Vec<Vec<usize>> {
    let budget = budget.max(16);
    let total = |strokes: &[Vec<usize>]| strokes.iter().map(Vec::len).sum::<usize>();
    let mut strokes = split_at_gaps(points);
    if total(&strokes) <= budget {
        return strokes;
    }
    if strokes
        .iter()
        .flatten()
        .is_sorted_by(|&&a, &&b| points[a].0 <= points[b].0)
    {
        let mut width = 0.5;
        while total(&strokes) > budget {
            strokes = bridge(points, strokes, width);
            strokes
                .iter_mut()
                .for_each(|stroke| *stroke = columns(points, stroke, width));
            width *= 2.0;
        }
    } else {
        let fixed = extremes(points);
        strokes
            .iter_mut()
            .for_each(|stroke| *stroke = simplify(points, stroke, &fixed));
        let mut side = 1.0;
        while total(&strokes) > budget {
            strokes = sieve(points, &strokes, &fixed, Sheet::new(points, side));
            side *= 2.0;
        }
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

/// Whether both coordinates are finite.
pub(super) fn drawable((x, y): Point) -> bool {
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

/// Both ends of the stroke and the lowest and highest point of every column `width` wide; x must
/// not fall.
fn columns(points: &[Point], stroke: &[usize], width: f64) -> Vec<usize> {
    let column = |i: usize| (points[i].0 / width).floor();
    let by_y = |a: &&usize, b: &&usize| points[**a].1.total_cmp(&points[**b].1);
    let mut kept: Vec<usize> = stroke.first().copied().into_iter().collect();
    for group in stroke.chunk_by(|&a, &b| column(a) == column(b)) {
        let mut corners = [
            group.iter().min_by(by_y).copied(),
            group.iter().max_by(by_y).copied(),
        ];
        corners.sort_unstable();
        kept.extend(corners.into_iter().flatten());
    }
    kept.extend(stroke.last());
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
        let mut points: Vec<Point> = (0..300_000)
            .map(|i| (i as f64 * 3e-3, (i as f64 * 0.01).sin()))
            .collect();
        points[123_456].1 = 40.0;
        points[234_567].1 = -40.0;
        let strokes = thin_line(&points, 4_000);
        assert_eq!(strokes.len(), 1);
        assert!(strokes[0].len() <= 4_000);
        for index in [0, 123_456, 234_567, 299_999] {
            assert!(strokes[0].contains(&index), "sample {index} is lost");
        }
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
