//! Ready-made stages.

use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::amplifier::Reconstruction;
use super::dac::Dac;
use super::hysteresis::{Band, Hysteresis};
use super::sensor::Sensor;
use super::stage::Stage;

/// Spacing zeta of the published thresholds, V.
const SPACING_V: f64 = 9.715;
/// Published widening beta, V per V/s.
const RATE_WIDENING_S: f64 = 8.572e-4;
/// Weight a_0 of the published model that agrees with its published inverse, um/V.
const GAIN_UM_PER_V: f64 = 0.7236;
/// Weights a_1 to a_3 of that model, um/V.
const WEIGHTS_UM_PER_V: [f64; 3] = [0.2906, 0.0416, 0.1512];

/// The amplifier was reported to lag 0.5 degrees at 50 Hz and 1.5 degrees at 100 Hz. A first-order
/// lag is close to proportional to frequency there and cannot do both; the least-squares fit in
/// degrees, tau = sum(f phase) / (360 sum(f^2)), gives 0.7 and 1.4 degrees.
const AMPLIFIER_TAU_S: f64 = 63_000.0 / (18_000.0 * 18_000.0 + 36_000.0 * 36_000.0);

impl Stage {
    /// A stage like the PI P-753.31C of Al Janaideh and Krejci (IEEE/ASME T-Mech 18(5), 2013),
    /// 100 um, driven with +-40 V at 10 kHz.
    ///
    /// The weights of the published three plays, in the set that agrees with the published
    /// inverse, are each spread evenly over thresholds half a spacing to both sides: a real
    /// stage's plays are not three. The actuator alone then has 13.1, 21.0 and 26.3 % hysteresis
    /// at 1, 50 and 100 Hz, against 13.03, 20.28 and 26.18 % measured. The amplifier lag is fitted to the published phases (0.7
    /// degrees at 50 Hz, 1.4 at 100 Hz). The paper does not describe its converter and sensor;
    /// 16 bits over +-100 V, 10 nm rms noise and steps of 100 um / 2^16 are assumed.
    pub fn p753() -> Self {
        let half = SPACING_V / 2.0;
        let bands = p753_plays()
            .map(|play| Band {
                from_v: play.from_v - half,
                to_v: play.to_v + half,
                ..play
            })
            .to_vec();
        Self {
            dac: Some(Dac {
                bits: 16,
                min_v: -100.0,
                max_v: 100.0,
            }),
            reconstruction: Reconstruction::Ramp,
            amplifier_tau_s: AMPLIFIER_TAU_S,
            sensor: Sensor {
                noise_um: 0.01,
                step_um: 100.0 / 65_536.0,
                seed: 753,
            },
            ..Self::ideal(p753_hysteresis(bands))
        }
    }

    /// The published three-play model itself as a stage, without converter, lag and noise: the
    /// model's own plant. With `oversample = 1` it is sample for sample the published recursion,
    /// with 13.3, 21.0 and 27.5 % hysteresis at 1, 50 and 100 Hz and 10 kHz.
    pub fn p753_three_plays() -> Self {
        Self::ideal(p753_hysteresis(p753_plays().to_vec()))
    }

    /// [`p753`](Self::p753) with gain, thresholds, weights, rate term and amplifier lag all wrong
    /// by the relative error `relative`, 0 to below 1, each up or down as drawn from `seed`; the
    /// seed also chooses the sensor noise.
    ///
    /// A band's range is scaled as a whole. A `relative` outside its range is not refused here but
    /// leads to values that [`validate`](Self::validate) may refuse.
    pub fn p753_perturbed(relative: f64, seed: u64) -> Self {
        let mut stage = Self::p753();
        stage.sensor.seed = seed;
        let mut generator = Pcg64::seed_from_u64(seed);
        let mut factor = || {
            let up: bool = StandardUniform.sample(&mut generator);
            if up { 1.0 + relative } else { 1.0 - relative }
        };
        stage.amplifier_tau_s *= factor();
        stage.hysteresis.gain_um_per_v *= factor();
        stage.hysteresis.rate_widening_s *= factor();
        for band in &mut stage.hysteresis.bands {
            let range = factor();
            band.from_v *= range;
            band.to_v *= range;
            band.weight_um_per_v *= factor();
        }
        stage
    }
}

fn p753_plays() -> [Band; 3] {
    let [first, second, third] = WEIGHTS_UM_PER_V;
    [(1.0, first), (2.0, second), (3.0, third)].map(|(i, a)| Band::play(SPACING_V * i, a))
}

fn p753_hysteresis(bands: Vec<Band>) -> Hysteresis {
    Hysteresis {
        gain_um_per_v: GAIN_UM_PER_V,
        bands,
        rate_widening_s: RATE_WIDENING_S,
    }
}
