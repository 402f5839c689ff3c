//! Records made ready for fitting: which samples are scored for which role, with what weight.

use std::ops::Range;

use crate::dataset::{Dataset, Role, Zero};
use crate::error::Error;

use super::catalogue::reading_step;
use super::cycles::{first_cycle, half_cycle_frequencies, is_closed, range, turning_points};
use super::noise;
use super::rounding::noise_before;
use super::spectrum::band;
use super::start::Start;

/// Share of every fit record that serves for selection where a data set names no `select` record.
const HELD_BACK: f64 = 0.25;
/// Turning points that a record must have for that: four cycles.
const LEAST_TURNS: usize = 8;

/// Consecutive samples of one role.
#[derive(Clone, Debug)]
pub struct Span {
    /// Index of the record in the data set.
    pub record: usize,
    /// What the samples serve for.
    pub role: Role,
    /// The scored samples, indices into the run.
    pub samples: Range<usize>,
}

/// Samples without a gap: a record, and the records that continue it.
#[derive(Clone, Debug)]
pub struct Run {
    /// Absolute time of the first sample in seconds.
    pub start_s: f64,
    /// Time between samples in seconds.
    pub sample_time_s: f64,
    /// Drive in volts.
    pub drive: Vec<f64>,
    /// Displacement in micrometres.
    pub displacement: Vec<f64>,
    /// Scored spans in the order of time.
    pub spans: Vec<Span>,
    /// Samples at the start that no span scores.
    pub left_out: usize,
    /// State of the plays before the first sample.
    pub start: Start,
    /// Whether the offset is the run's own, for want of knowing that state.
    pub loose: bool,
}

impl Run {
    /// Rate of the drive at sample `k` in V/s: backward difference (J 34), zero at the first sample
    /// unless the run is a steady loop, which goes on from its own end.
    pub fn rate(&self, k: usize) -> f64 {
        (self.drive[k] - self.before(k)).abs() / self.sample_time_s
    }

    /// The drive one sample before sample `k`, as [`Run::rate`] takes it.
    pub fn before(&self, k: usize) -> f64 {
        match (k, self.start) {
            (0, Start::Periodic) => self.drive[self.drive.len() - 1],
            (0, _) => self.drive[0],
            _ => self.drive[k - 1],
        }
    }

    /// Whether the drive moves over less than `volts`: wide plays then stay as they start, and are an
    /// offset.
    pub fn is_narrow(&self, volts: f64) -> bool {
        range(&self.drive) < volts
    }

    /// Each record's samples in the run, scored or not, with what is scored of it.
    pub fn whole_spans(&self) -> Vec<(Range<usize>, Span)> {
        let mut whole: Vec<(Range<usize>, Span)> = Vec::new();
        for span in &self.spans {
            match whole.last_mut() {
                // Two spans of one record: part of it was held back for selection.
                Some((at, joined)) if joined.record == span.record => {
                    at.end = span.samples.end;
                    joined.samples.end = span.samples.end;
                }
                last => {
                    let start = last.map_or(0, |(at, _)| at.end);
                    whole.push((start..span.samples.end, span.clone()));
                }
            }
        }
        whole
    }

    /// The scored samples of one role.
    pub fn scored(&self, role: Role) -> impl Iterator<Item = &Span> {
        self.spans.iter().filter(move |span| span.role == role)
    }
}

/// A data set as runs.
#[derive(Clone, Debug)]
pub struct Runs {
    /// The runs.
    pub runs: Vec<Run>,
    /// Step of the reading in um, where it matters beside the noise.
    pub step_um: Option<f64>,
    /// Noise before the reading was rounded to such steps, in um.
    pub noise_before_steps_um: f64,
    /// Whether each run has an offset of its own.
    pub own_offsets: bool,
    /// Whether part of the fit records was set aside because no record has the role `select`.
    pub held_back: bool,
    /// Range of the drive over the records for fitting, in volts.
    pub drive_range: f64,
    /// Ratio of the highest to the lowest frequency at which the fit records move.
    pub frequency_span: f64,
    /// Sign of the stage's gain. Displacements are multiplied by it, so that what is fitted rises
    /// with the drive.
    pub sign: f64,
    mean_gain: f64,
}

impl Runs {
    /// Joins records that continue each other, leaves first cycles out of the score, and sets a
    /// part of each fit record aside for selection when the data set names none.
    ///
    /// # Errors
    /// A drive or a displacement that does not move in the records for fitting.
    pub fn new(dataset: &Dataset) -> Result<Self, Error> {
        let mut runs: Vec<Run> = Vec::new();
        let mut run_of_record = Vec::new();
        for (index, record) in dataset.records.iter().enumerate() {
            let place = match record
                .continues
                .and_then(|before| run_of_record.get(before))
            {
                Some(&place) => place,
                None => {
                    let drive = &record.drive_v;
                    let turns = turning_points(drive, range(drive));
                    let left_out = first_cycle(&turns);
                    let one_loop = left_out == 0 && turns.len() >= 2 && is_closed(drive);
                    runs.push(Run {
                        start_s: record.start_s,
                        sample_time_s: record.sample_time_s,
                        drive: Vec::new(),
                        displacement: Vec::new(),
                        spans: Vec::new(),
                        left_out,
                        start: if one_loop {
                            Start::Periodic
                        } else {
                            Start::Excursion(0.0)
                        },
                        loose: false,
                    });
                    runs.len() - 1
                }
            };
            run_of_record.push(place);
            let run = &mut runs[place];
            let from = run.drive.len().max(run.left_out);
            run.drive.extend(&record.drive_v);
            run.displacement.extend(&record.displacement_um);
            let to = run.drive.len();
            run.spans.push(Span {
                record: index,
                role: record.role,
                samples: from.min(to)..to,
            });
        }
        let noise = noise::floor(&runs).map_or(0.0, |(rms, _)| rms);
        let step_um = reading_step(&runs, noise);
        let mut runs = Self {
            step_um,
            noise_before_steps_um: step_um.map_or(noise, |step| noise_before(step, noise)),
            runs,
            own_offsets: dataset.zero == Zero::PerRecord || dataset.input_zero == Zero::PerRecord,
            held_back: false,
            drive_range: 0.0,
            frequency_span: 1.0,
            sign: 1.0,
            mean_gain: 0.0,
        };
        let of_fit = || {
            runs.scored(Role::Fit)
                .flat_map(|(_, run, span)| &run.drive[span.samples.clone()])
        };
        runs.drive_range = of_fit().fold(f64::NEG_INFINITY, |a, &b| a.max(b))
            - of_fit().fold(f64::INFINITY, |a, &b| a.min(b));
        let moves = |what: &str| {
            Error::request(format!(
                "{}: the {what} does not move in the fit records; nothing can be identified",
                dataset.name
            ))
        };
        if !runs.drive_range.is_finite() || runs.drive_range <= 0.0 {
            return Err(moves("drive"));
        }
        runs.frequency_span = runs.measure_frequency_span();
        let gain = runs.line_gain();
        if gain == 0.0 || !gain.is_finite() {
            return Err(moves("displacement"));
        }
        runs.sign = gain.signum();
        runs.mean_gain = gain.abs();
        let sign = runs.sign;
        for y in runs.runs.iter_mut().flat_map(|run| &mut run.displacement) {
            *y *= sign;
        }
        if !dataset
            .records
            .iter()
            .any(|record| record.role == Role::Select)
        {
            for run in &mut runs.runs {
                runs.held_back |= hold_back(run);
            }
        }
        Ok(runs)
    }

    /// The larger of two views: half cycles see a fast motion that is small beside a slow one, the
    /// spectrum sees the lines of a multisine, whose half cycles are all alike.
    fn measure_frequency_span(&self) -> f64 {
        let mut half_cycles = Vec::new();
        let mut lines = (f64::INFINITY, 0.0f64);
        for (_, run, span) in self.scored(Role::Fit) {
            let drive = &run.drive[span.samples.clone()];
            let turns = turning_points(drive, range(drive));
            half_cycles.extend(half_cycle_frequencies(drive, &turns, run.sample_time_s));
            if let Some((low, high)) = band(drive, run.sample_time_s) {
                lines = (lines.0.min(low), lines.1.max(high));
            }
        }
        let spectral = if lines.1 > 0.0 {
            lines.1 / lines.0
        } else {
            1.0
        };
        spectral.max(super::cycles::span(half_cycles))
    }

    /// Slope of the best straight line in the drive over the records for fitting, in um/V, each
    /// record about its own mean.
    fn line_gain(&self) -> f64 {
        let (mut uy, mut uu) = (0.0, 0.0);
        for (_, run, span) in self.scored(Role::Fit) {
            let (u, y) = (
                &run.drive[span.samples.clone()],
                &run.displacement[span.samples.clone()],
            );
            let count = span.samples.len().max(1) as f64;
            let (mean_u, mean_y) = (u.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
            for (u, y) in u.iter().zip(y) {
                uy += (u - mean_u) * (y - mean_y) / count;
                uu += (u - mean_u) * (u - mean_u) / count;
            }
        }
        uy / uu
    }

    /// Magnitude of the slope of the best straight line in the drive, in um/V.
    pub fn mean_gain(&self) -> f64 {
        self.mean_gain
    }

    /// The widest threshold, in volts, at which a play still moves enough to show its weight: over a
    /// tenth of the drive's range.
    pub fn widest_threshold(&self) -> f64 {
        0.45 * self.drive_range
    }

    /// Whether each run goes on from the one before it, the first one from plays at zero.
    pub fn is_session(&self) -> bool {
        let mut starts = self.runs.iter().map(|run| run.start);
        starts.next() == Some(Start::Zero) && starts.all(|start| start == Start::Carried)
    }

    /// Highest rate of the drive in the records for fitting, in V/s.
    pub fn highest_rate(&self) -> f64 {
        self.scored(Role::Fit)
            .flat_map(|(_, run, span)| span.samples.clone().map(|k| run.rate(k)))
            .fold(0.0, f64::max)
    }

    /// The same runs with displacements as they were measured.
    pub fn measured(&self) -> Self {
        let mut measured = self.clone();
        for y in measured
            .runs
            .iter_mut()
            .flat_map(|run| &mut run.displacement)
        {
            *y *= self.sign;
        }
        measured.sign = 1.0;
        measured
    }

    /// The same runs with what was set aside for selection given back to the fit.
    pub fn give_back(&mut self) {
        if !self.held_back {
            return;
        }
        for span in self.runs.iter_mut().flat_map(|run| &mut run.spans) {
            if span.role == Role::Select {
                span.role = Role::Fit;
            }
        }
    }

    /// The state that each run starts in.
    pub fn starts(&self) -> impl Iterator<Item = Start> {
        self.runs.iter().map(|run| run.start)
    }

    /// Spans of one role with their runs.
    pub fn scored(&self, role: Role) -> impl Iterator<Item = (usize, &Run, &Span)> {
        self.runs
            .iter()
            .enumerate()
            .flat_map(move |(i, run)| run.scored(role).map(move |span| (i, run, span)))
    }
}

/// Sets the last part of each fit span of a run aside; `false` if there are too few cycles to share.
fn hold_back(run: &mut Run) -> bool {
    let mut any = false;
    for span in std::mem::take(&mut run.spans) {
        let drive = &run.drive[span.samples.clone()];
        if span.role != Role::Fit || turning_points(drive, range(drive)).len() < LEAST_TURNS {
            run.spans.push(span);
            continue;
        }
        let cut = span.samples.end - (HELD_BACK * span.samples.len() as f64) as usize;
        run.spans.push(Span {
            samples: span.samples.start..cut,
            ..span.clone()
        });
        run.spans.push(Span {
            role: Role::Select,
            samples: cut..span.samples.end,
            ..span
        });
        any = true;
    }
    any
}
