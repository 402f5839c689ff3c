//! From converter samples to a continuous drive: reconstruction and amplifier lag.

/// How the drive goes from one converter sample to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reconstruction {
    /// Jumps at the start of the sample time and stays: the bare zero-order hold.
    Hold,
    /// Goes in a straight line from the previous sample and arrives at the end of the sample time.
    #[default]
    Ramp,
}

/// A first-order lag `tau x' + x = u`, stepped exactly for an input that is linear over a step.
#[derive(Debug, Clone)]
pub(super) struct Amplifier {
    tau_s: f64,
    /// exp(-step/tau); zero for tau = 0, which makes the lag an identity.
    decay: f64,
    step_s: f64,
    output_v: f64,
}

impl Amplifier {
    /// An amplifier at rest at `rest_v`, stepped by `step_s`.
    pub(super) fn new(tau_s: f64, step_s: f64, rest_v: f64) -> Self {
        Self {
            tau_s,
            decay: (-step_s / tau_s).exp(),
            step_s,
            output_v: rest_v,
        }
    }

    /// Advances one step while the input goes from `from_v` to `to_v`; returns the output at its
    /// end, V.
    pub(super) fn advance(&mut self, from_v: f64, to_v: f64) -> f64 {
        // Behind a ramp the lag trails by slope * tau once its transient has died out.
        let trail = (to_v - from_v) / self.step_s * self.tau_s;
        self.output_v = (to_v - trail) + (self.output_v - from_v + trail) * self.decay;
        self.output_v
    }

    /// Output now, V.
    pub(super) fn output_v(&self) -> f64 {
        self.output_v
    }
}
