//! Means and stretches of surveyed files, as records.

use std::ops::Range;

use super::survey::Survey;
use super::{Plan, Rows, Source, parts};
use crate::dataset::{MIN_SAMPLES, Record, Role};
use crate::error::{Error, Place};
use crate::time_grid::{most_stray, off_grid};

/// Half cycles that a stretch should have: its first cycle is not scored.
const HALF_CYCLES: u64 = 10;
/// Stretches of a record at most.
const STRETCHES: u64 = 8;
/// Share of the drive's range that stretches must run through to be enough.
const COVERED: f64 = 0.5;

/// Consecutive means that become one record.
struct Piece {
    name: String,
    role: Role,
    rows: Range<u64>,
    /// Samples of a mean: two to the power of it.
    scale: u32,
    /// The piece of the same file that it goes on from.
    continues: Option<usize>,
    sums: [f64; 3],
    summed: u64,
    columns: [Vec<f64>; 3],
}

impl Piece {
    fn new(name: String, role: Role, rows: Range<u64>, scale: u32) -> Self {
        Self {
            name,
            role,
            rows,
            scale,
            continues: None,
            sums: [0.0; 3],
            summed: 0,
            columns: Default::default(),
        }
    }

    /// Adds a row; a full mean becomes a sample.
    fn take(&mut self, row: [f64; 3]) {
        for (sum, value) in self.sums.iter_mut().zip(row) {
            *sum += value;
        }
        self.summed += 1;
        if self.summed == 1 << self.scale {
            for (column, sum) in self.columns.iter_mut().zip(&mut self.sums) {
                column.push(*sum / self.summed as f64);
                *sum = 0.0;
            }
            self.summed = 0;
        }
    }
}

/// The records, `most` samples in all or little more, and what was kept of each file.
pub fn records(
    plan: &Plan,
    surveys: &[Survey],
    most: usize,
    progress: &dyn Fn(&str),
) -> Result<(Vec<Record>, Vec<String>), Error> {
    let rows: u64 = surveys.iter().map(|survey| survey.rows).sum();
    let (mut records, mut notes) = (Vec::new(), Vec::new());
    for (source, survey) in plan.sources.iter().zip(surveys) {
        // A short record beside a long one is kept as it is.
        let share = (most as f64 * survey.rows as f64 / rows as f64) as u64;
        let share = share.max((most / (4 * plan.sources.len())) as u64);
        let (mut pieces, note) = pieces(source, survey, share);
        notes.push(note);
        read(source, survey, &mut pieces, progress)?;
        append(&mut records, pieces, survey.sample_time_s());
    }
    Ok((records, notes))
}

/// Adds the pieces of a file that are long enough; `sample_time_s` is that of the file.
fn append(records: &mut Vec<Record>, pieces: Vec<Piece>, sample_time_s: f64) {
    // Where each piece came to lie, if it did: one goes on from a piece, not from a record.
    let mut placed: Vec<Option<usize>> = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let [time_s, drive_v, displacement_um] = piece.columns;
        if time_s.len() < MIN_SAMPLES {
            placed.push(None);
            continue;
        }
        let continues = piece
            .continues
            .and_then(|before| placed.get(before).copied()?);
        placed.push(Some(records.len()));
        records.push(Record {
            name: piece.name,
            role: piece.role,
            start_s: time_s[0],
            sample_time_s: sample_time_s * (1u64 << piece.scale) as f64,
            time_s,
            drive_v,
            displacement_um,
            continues,
        });
    }
}

/// What to keep of a file with a share of so many samples.
fn pieces(source: &Source, survey: &Survey, share: u64) -> (Vec<Piece>, String) {
    let name = &source.name;
    let allowed = survey.scale();
    let needed = needed(survey.rows, share);
    if needed <= allowed {
        let note = format!("{name}: the whole record, in {}.", means(needed));
        return (overview(source, survey, needed, ""), note);
    }
    let (mut found, covered) = stretches(source, survey, share, allowed);
    let mut note = format!(
        "{name}: {} stretches in {}; they run through {:.0} % of the drive's range.",
        found.len(),
        means(allowed),
        100.0 * covered
    );
    if covered < COVERED {
        // Slow and wide beside fast and narrow: both are wanted.
        (found, _) = stretches(source, survey, share / 2, allowed);
        let scale = self::needed(survey.rows, share / 2);
        note = format!(
            "{note} What is slower is seen in {} over the whole, in which what is faster is lost.",
            means(scale)
        );
        found = joined(overview(source, survey, scale, ", overview"), found);
    }
    (found, note)
}

/// Pieces and others behind them, which go on from each other as before.
fn joined(mut pieces: Vec<Piece>, others: Vec<Piece>) -> Vec<Piece> {
    let first = pieces.len();
    pieces.extend(others.into_iter().map(|piece| Piece {
        continues: piece.continues.map(|before| first + before),
        ..piece
    }));
    pieces
}

fn needed(rows: u64, share: u64) -> u32 {
    rows.div_ceil(share.max(1))
        .max(1)
        .next_power_of_two()
        .ilog2()
}

fn means(scale: u32) -> String {
    match scale {
        0 => "single samples".to_owned(),
        _ => format!("means of {} samples", 1u64 << scale),
    }
}

/// The whole record in means, in the parts that its roles make.
fn overview(source: &Source, survey: &Survey, scale: u32, suffix: &str) -> Vec<Piece> {
    let parts = parts(source, survey.rows);
    let mut pieces: Vec<Piece> = Vec::with_capacity(parts.len());
    for (index, (role, label, rows)) in parts.into_iter().enumerate() {
        let label = label.map_or(String::new(), |label| format!(" ({label})"));
        // Parts begin and end where a mean does, so that they go on from each other.
        let whole = |row: u64| row >> scale << scale;
        let rows = whole(rows.start)..whole(rows.end);
        let mut piece = Piece::new(format!("{}{label}{suffix}", source.name), role, rows, scale);
        piece.continues = index.checked_sub(1);
        pieces.push(piece);
    }
    pieces
}

/// Stretches of the parts of a record, and the share of the drive's range that they run through.
fn stretches(source: &Source, survey: &Survey, share: u64, scale: u32) -> (Vec<Piece>, f64) {
    let mut pieces = Vec::new();
    let mut covered: f64 = 1.0;
    for (role, label, part) in parts(source, survey.rows) {
        let length = part.end - part.start;
        let budget = ((share as f64 * length as f64 / survey.rows as f64) as u64) << scale;
        let placed = if budget >= length {
            vec![part.clone()]
        } else {
            let cycles = HALF_CYCLES * survey.rows / survey.turns.max(1);
            let count = (budget / cycles.max(1)).clamp(1, STRETCHES);
            let starts = spread(&part, budget / count, count);
            with_extremes(survey, &part, starts, budget / count)
        };
        let range = |rows: Range<u64>| {
            let (low, high) = survey.drive_within(rows);
            high - low
        };
        let widest = placed.iter().cloned().map(range).fold(0.0, f64::max);
        if range(part.clone()) > 0.0 {
            covered = covered.min(widest / range(part.clone()));
        }
        let of = placed.len();
        for (index, rows) in placed.into_iter().enumerate() {
            let label = label.map_or(String::new(), |label| format!("{label}, "));
            let name = format!("{} ({label}{} of {of})", source.name, index + 1);
            pieces.push(Piece::new(name, role, rows, scale));
        }
    }
    (pieces, covered)
}

/// Starts of stretches from the beginning of a part to its end.
fn spread(part: &Range<u64>, length: u64, count: u64) -> Vec<u64> {
    let room = part.end - part.start - length;
    let step = |index: u64| match count {
        1 => room / 2,
        _ => (room as f64 * index as f64 / (count - 1) as f64) as u64,
    };
    (0..count).map(|index| part.start + step(index)).collect()
}

/// Moves the nearest stretch over the drive's lowest and over its highest value.
fn with_extremes(
    survey: &Survey,
    part: &Range<u64>,
    mut starts: Vec<u64>,
    length: u64,
) -> Vec<Range<u64>> {
    let mut moved = None;
    for wanted in survey.extremes_within(part.clone()) {
        if starts.iter().any(|&at| (at..at + length).contains(&wanted)) {
            continue;
        }
        let centred = wanted.saturating_sub(length / 2);
        let nearest = (0..starts.len())
            .filter(|&index| Some(index) != moved)
            .min_by_key(|&index| starts[index].abs_diff(centred));
        let Some(index) = nearest else { continue };
        let from = index
            .checked_sub(1)
            .map_or(part.start, |before| starts[before] + length);
        let to = starts.get(index + 1).map_or(part.end, |&after| after) - length;
        starts[index] = centred.clamp(from, to.max(from));
        moved = Some(index);
    }
    starts.into_iter().map(|at| at..at + length).collect()
}

/// The second pass: fills the pieces, and holds every time against the uniform grid.
fn read(
    source: &Source,
    survey: &Survey,
    pieces: &mut [Piece],
    progress: &dyn Fn(&str),
) -> Result<(), Error> {
    let mut rows = Rows::open(source, "condensing", progress)?;
    let column = rows.table.headers()[source.layout.time.0].clone();
    let mean = survey.sample_time_s();
    let most = most_stray(mean, survey.last_s - survey.first_s);
    let mut worst = (0.0, 0);
    let mut row = 0u64;
    while let Some((line, values)) = rows.next()? {
        let off = (values[0] - (survey.first_s + mean * row as f64)).abs();
        if off > worst.0 {
            worst = (off, line);
        }
        for piece in pieces.iter_mut().filter(|piece| piece.rows.contains(&row)) {
            piece.take(values);
        }
        row += 1;
    }
    let place = Place::file(&source.file);
    if row != survey.rows {
        return Err(place.error("the file has changed while it was worked on; begin again"));
    }
    if worst.0 > most {
        let place = place.line(worst.1).column(column);
        return Err(place.error(off_grid(worst.0, mean)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces of so many samples, each of which goes on from the one before.
    fn chained(lengths: &[usize]) -> Vec<Piece> {
        let piece = |(index, &length): (usize, &usize)| {
            let mut piece = Piece::new(index.to_string(), Role::Fit, 0..length as u64, 0);
            piece.continues = index.checked_sub(1);
            (0..length).for_each(|k| piece.take([k as f64, 0.0, 0.0]));
            piece
        };
        lengths.iter().enumerate().map(piece).collect()
    }

    fn continued(records: &[Record]) -> Vec<Option<usize>> {
        records.iter().map(|record| record.continues).collect()
    }

    #[test]
    fn a_piece_goes_on_from_the_record_that_the_one_before_became() {
        let (long, short) = (MIN_SAMPLES, MIN_SAMPLES - 1);
        let mut records = Vec::new();
        append(&mut records, chained(&[short, long, long]), 1.0);
        assert_eq!(continued(&records), [None, Some(0)]);
        append(&mut records, chained(&[long, short, long, long]), 1.0);
        assert_eq!(
            continued(&records[2..]),
            [None, None, Some(3)],
            "nothing is known of what was too short"
        );
        let both = joined(chained(&[long, short]), chained(&[long, long]));
        append(&mut records, both, 1.0);
        assert_eq!(continued(&records[5..]), [None, None, Some(6)]);
    }
}
