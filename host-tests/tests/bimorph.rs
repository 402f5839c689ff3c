//! The simulated bimorph against relays one by one, closed forms and the published facts.

use std::f64::consts::TAU;

use hysteron_host::metrics::line;
use hysteron_host::plant::StageError;
use hysteron_host::plant::bimorph::{Asymmetry, Bimorph, Mode, RelayDensity, Relays};
use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};

const H: f64 = Bimorph::SAMPLE_TIME_S;
/// Samples in a second, which holds whole periods of every whole frequency.
const SECOND: usize = 5_000;

fn density() -> RelayDensity {
    Bimorph::pzba().relays
}

/// Preisach's plane as a grid of relays, each switched by itself.
struct Grid {
    /// Up and down threshold in V, weight in um, up or not.
    relays: Vec<(f64, f64, f64, bool)>,
}

impl Grid {
    const RANGE_V: f64 = 6.0;

    fn new(density: RelayDensity, cells: usize) -> Self {
        let side = 2.0 * Self::RANGE_V / cells as f64;
        let centre = |i: usize| -Self::RANGE_V + (i as f64 + 0.5) * side;
        let mut relays = Vec::new();
        for a in 0..cells {
            for b in 0..=a {
                let (alpha, beta) = (centre(a), centre(b));
                // Cells on the diagonal are cut in half by it.
                let area = if a == b { 0.5 } else { 1.0 } * side * side;
                let weight = density.at(alpha, beta) * area;
                relays.push((alpha, beta, weight, alpha + beta < 0.0));
            }
        }
        Self { relays }
    }

    fn advance(&mut self, drive_v: f64) -> f64 {
        let mut sum = 0.0;
        for (alpha, beta, weight, up) in &mut self.relays {
            *up = drive_v >= *alpha || (*up && drive_v > *beta);
            sum += if *up { *weight } else { -*weight };
        }
        sum
    }
}

#[test]
fn equals_relays_switched_one_by_one() {
    let mut random = SmallRng::seed_from_u64(4);
    let mut grid = Grid::new(density(), 400);
    let mut relays = Relays::new(density());
    // The virgin state of the grid is not balanced on its line of symmetry.
    let offset = grid.advance(0.0);
    let full = density().everett_um(5.0, -5.0);
    let mut drive = 0.0_f64;
    let mut turns = 0;
    for _ in 0..400 {
        // Nested and widening swings, in steps that skip thresholds.
        let target: f64 = random.random_range(-5.0..5.0) * random.random_range(0.1..1.0);
        while (drive - target).abs() > 1e-9 {
            drive += (target - drive).clamp(-0.37, 0.37);
            let (ours, theirs) = (relays.advance(drive), grid.advance(drive) - offset);
            assert!(
                (ours - theirs).abs() < 0.02 * full,
                "{drive} V: {ours} against {theirs} of {full}"
            );
        }
        turns = turns.max(relays.remembered());
    }
    assert!(
        turns >= 4,
        "only {turns} turning points were ever remembered"
    );
}

#[test]
fn a_finer_grid_comes_closer() {
    let worst = |cells| {
        let (mut grid, mut relays) = (Grid::new(density(), cells), Relays::new(density()));
        let offset = grid.advance(0.0);
        (0..300)
            .map(|k| {
                let t = f64::from(k) / 300.0;
                // On the edges of the coarse cells' grid, so that no cell is half passed.
                let v = (4.8 * (1.0 - 0.5 * t) * (TAU * 6.0 * t).sin() / 0.12).round() * 0.12;
                (relays.advance(v) - (grid.advance(v) - offset)).abs()
            })
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst(100), worst(400));
    assert!(fine < 0.4 * coarse, "{coarse} um, then {fine} um");
    assert!(fine < 0.01, "{fine} um");
}

#[test]
fn everett_is_the_integral_of_the_density() {
    let density = density();
    for (high, low) in [(5.0, -5.0), (3.0, 1.0), (-0.5, -4.0), (12.0, -2.0)] {
        let cells = 2_000;
        let side = (high - low) / f64::from(cells);
        let mut sum = 0.0;
        for a in 0..cells {
            for b in 0..=a {
                let (alpha, beta) = (
                    low + (f64::from(a) + 0.5) * side,
                    low + (f64::from(b) + 0.5) * side,
                );
                sum += density.at(alpha, beta) * if a == b { 0.5 } else { 1.0 };
            }
        }
        let (closed, summed) = (density.everett_um(high, low), sum * side * side);
        assert!(
            (closed / summed - 1.0).abs() < 1e-5,
            "{closed} against {summed}"
        );
    }
}

#[test]
fn a_larger_swing_wipes_out_smaller_ones() {
    let mut with = Relays::new(density());
    let mut without = Relays::new(density());
    for v in [4.0, -3.0, 2.0, -1.0, 0.5, 2.5] {
        with.advance(v);
    }
    for v in [4.0, -3.0, 2.5] {
        without.advance(v);
    }
    for v in [1.0, -2.0, 3.0, -4.5, 5.0] {
        assert_eq!(with.advance(v), without.advance(v), "{v} V");
    }
    assert!(with.remembered() <= 1);
}

#[test]
fn minor_loops_between_the_same_drives_are_congruent() {
    let ladder: Vec<f64> = (0..=20).map(|k| -1.0 + 0.15 * f64::from(k)).collect();
    let minor = |before: &[f64]| -> Vec<f64> {
        let mut relays = Relays::new(density());
        for &v in before {
            relays.advance(v);
        }
        let round = ladder.iter().chain(ladder.iter().rev());
        let loops: Vec<f64> = round.map(|&v| relays.advance(v)).collect();
        loops.iter().map(|um| um - loops[0]).collect()
    };
    let from_above = minor(&[5.0, -1.0]);
    let from_below = minor(&[-5.0, 3.0, -1.0]);
    for (a, b) in from_above.iter().zip(&from_below) {
        assert!((a - b).abs() < 1e-12);
    }
    // The loop closes and is open inside.
    assert!(from_above[41].abs() < 1e-12);
    assert!(from_above[31] > from_above[10] + 0.1);
}

#[test]
fn loops_depend_on_where_they_lie() {
    // Any weighted sum of plays has the same loop of 2 V everywhere.
    let height = |middle: f64| density().everett_um(middle + 1.0, middle - 1.0);
    assert!(height(0.0) > 1.1 * height(4.0));
    assert!((height(4.0) - height(-4.0)).abs() < 1e-12);
}

/// Only the mode: no relays, no asymmetry, no lag, no noise.
fn bare() -> Bimorph {
    let mut bimorph = Bimorph::pzba();
    bimorph.amplifier_tau_s = 0.0;
    bimorph.relays.density_um_per_v2 = 0.0;
    bimorph.asymmetry.share = 0.0;
    bimorph.sensor.noise_um = 0.0;
    bimorph.dac.bits = 32;
    bimorph
}

#[test]
fn the_mode_rings_as_in_the_textbook() {
    let bimorph = bare();
    let Mode {
        frequency_hz,
        damping,
    } = bimorph.mode;
    let drive = vec![2.0; SECOND];
    let output = bimorph.run(&drive, H).unwrap();
    let (w, root) = (TAU * frequency_hz, (1.0 - damping * damping).sqrt());
    for (k, y) in output.iter().enumerate() {
        let t = (k + 1) as f64 * H;
        let turn = w * root * t;
        let ring = (-damping * w * t).exp() * (turn.cos() + damping / root * turn.sin());
        let expected = bimorph.gain_um_per_v * 2.0 * (1.0 - ring);
        // The step enters the mode as a ramp over one fine step.
        assert!((y - expected).abs() < 0.2, "{t} s: {y} against {expected}");
    }
}

#[test]
fn fine_steps_are_fine_enough() {
    let drive = sine(74.0, 2 * SECOND);
    let run = |oversample| {
        let mut bimorph = Bimorph::pzba();
        bimorph.sensor.noise_um = 0.0;
        bimorph.oversample = oversample;
        bimorph.run(&drive, H).unwrap()
    };
    let (coarse, fine) = (run(10), run(80));
    let apart = coarse.iter().zip(&fine).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 3.0, "of 2800 um");
}

fn sine(frequency_hz: f64, samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|k| Bimorph::FULL_DRIVE_V * (TAU * frequency_hz * k as f64 * H).sin())
        .collect()
}

/// Drive and displacement of a steady second at full drive.
fn steady(frequency_hz: f64) -> (Vec<f64>, Vec<f64>) {
    let drive = sine(frequency_hz, 3 * SECOND);
    let output = Bimorph::pzba().run(&drive, H).unwrap();
    (drive[..SECOND].to_vec(), output[2 * SECOND..].to_vec())
}

fn harmonics<const M: usize>(frequency_hz: f64) -> [f64; M] {
    let (_, output) = steady(frequency_hz);
    std::array::from_fn(|m| {
        line(&output, H, (m + 1) as f64 * frequency_hz)
            .unwrap()
            .amplitude
    })
}

#[test]
fn harmonics_are_the_published_ones() {
    let [first, _, third] = harmonics(25.0);
    let ratio = third / first;
    assert!((0.10..=0.16).contains(&ratio), "25 Hz: {ratio}");
    let [first, _, third] = harmonics(35.0);
    let ratio = third / first;
    assert!(ratio < 0.012, "35 Hz: {ratio}");
    let [_, _, third, _, fifth] = harmonics(15.0);
    let ratio = fifth / third;
    assert!((1.5..=2.5).contains(&ratio), "15 Hz: {ratio}");
}

#[test]
fn the_resonance_lies_where_it_was_measured() {
    let largest = |hz: u32| {
        let (_, output) = steady(f64::from(hz));
        output.iter().fold(0.0_f64, |most, y| most.max(y.abs()))
    };
    let peak = (60..=90).max_by(|&a, &b| largest(a).total_cmp(&largest(b)));
    assert!(matches!(peak, Some(70..=75)), "{peak:?} Hz");
    // 50 um in either direction are within reach from 1 to 110 Hz.
    assert!([1, 30, 95, 110].into_iter().all(|hz| largest(hz) > 60.0));
}

/// Rising less falling branch where the drive is `5 V sin(x)`, x from -pi/2 to pi/2, over the
/// largest displacement; negative where the loop is run counterclockwise.
fn gaps(frequency_hz: f64) -> Vec<f64> {
    let (_, output) = steady(frequency_hz);
    let largest = output.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    // Sampling phases of all periods together make one finely sampled period.
    let mut period: Vec<(f64, f64)> = output
        .iter()
        .enumerate()
        .map(|(k, &y)| ((k as f64 * H * frequency_hz).fract(), y))
        .collect();
    period.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |turn: f64| {
        let after = period.partition_point(|point| point.0 < turn.rem_euclid(1.0));
        period[after % period.len()].1
    };
    (1..100)
        .map(|k| {
            let turn = (f64::from(k) / 100.0 - 0.5) / 2.0;
            (at(turn) - at(0.5 - turn)) / largest
        })
        .collect()
}

#[test]
fn the_loop_crosses_itself_at_80_hz_and_is_clockwise_at_95() {
    let range = |hz| {
        let gaps = gaps(hz);
        (
            gaps.iter().copied().fold(f64::INFINITY, f64::min),
            gaps.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (least, most) = range(80.0);
    assert!(least < -0.03 && most > 0.03, "80 Hz: {least} to {most}");
    let (least, most) = range(95.0);
    assert!(least > -0.01 && most > 0.3, "95 Hz: {least} to {most}");
    let (least, most) = range(74.0);
    assert!(least < -0.3 && most < 0.01, "74 Hz: {least} to {most}");
}

#[test]
fn the_even_part_at_95_hz_is_above_three_percent() {
    let lines: [f64; 8] = harmonics(95.0);
    let rms = |first: usize| -> f64 {
        let every_other = lines.iter().skip(first).step_by(2);
        every_other.map(|a| a * a).sum::<f64>().sqrt()
    };
    // Lines only: the mean, which a sensor's zero hides, is not counted.
    let ratio = rms(1) / rms(0);
    assert!((0.03..0.06).contains(&ratio), "{ratio}");
}

#[test]
fn drives_and_parameters_out_of_range_are_refused() {
    let mut simulation = Bimorph::pzba().start(H).unwrap();
    assert!(matches!(
        simulation.step(f64::NAN),
        Err(StageError::Drive { index: 0, .. })
    ));
    // The refused sample left no trace, noise included.
    let fresh = Bimorph::pzba().start(H).unwrap().step(1.0);
    assert_eq!(simulation.step(1.0), fresh);
    // The converter holds the drive within its range.
    let mut other = Bimorph::pzba().start(H).unwrap();
    let mut limited = Bimorph::pzba().start(H).unwrap();
    assert_eq!(other.step(1e5), limited.step(5.0));

    let mut cases = Vec::new();
    let mut case = |field: &'static str, change: &dyn Fn(&mut Bimorph)| {
        let mut bimorph = Bimorph::pzba();
        change(&mut bimorph);
        cases.push((field, bimorph));
    };
    case("amplifier_tau_s", &|b| b.amplifier_tau_s = -1.0);
    case("gain_um_per_v", &|b| b.gain_um_per_v = f64::NAN);
    case("relays.density_um_per_v2", &|b| {
        b.relays.density_um_per_v2 = -1.0
    });
    case("relays.widening_per_v", &|b| {
        b.relays.widening_per_v = f64::INFINITY
    });
    case("relays.reach_v", &|b| b.relays.reach_v = 0.0);
    case("mode.frequency_hz", &|b| b.mode.frequency_hz = 0.0);
    case("mode.damping", &|b| b.mode.damping = 0.0);
    case("asymmetry.share", &|b| {
        b.asymmetry = Asymmetry {
            share: 1.0,
            ..b.asymmetry
        }
    });
    case("asymmetry.knee_um", &|b| b.asymmetry.knee_um = -1.0);
    case("asymmetry.relaxation_s", &|b| {
        b.asymmetry.relaxation_s = f64::NAN
    });
    case("oversample", &|b| b.oversample = 0);
    for (wrong, bimorph) in cases {
        let refused = bimorph.start(H).map(|_| ());
        assert!(
            matches!(&refused, Err(StageError::Parameter { field, .. }) if field == wrong),
            "{wrong}: {refused:?}"
        );
    }
    assert!(Bimorph::pzba().start(0.0).is_err());
}
