//! Compensation with a HAL of your own: a converter behind any `embedded_hal` SPI bus, and whatever
//! calls at the sample rate.
//!
//! [`Output`] is what goes into a firmware; it needs neither heap nor `std`. `main` runs it on a host
//! without a bus: `cargo run --example own_hal`.

use core::convert::Infallible;

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use hysteron::compensator::Compensator;
use hysteron::dac::{Ad5761r, Kind, Scale};
use hysteron::hysteresis::{Parameters, State};
use hysteron::model::Model;
use hysteron::safety::{Limits, Safety};

/// Samples a second.
const RATE_HZ: f64 = 10_000.0;
/// An amplifier of 10 V/V behind a converter of +-5 V.
const GAIN: f32 = 10.0;
const LIMITS: Limits = Limits {
    lowest: -20.0,
    highest: 45.0,
    rest: 0.0,
    slew: 0.5,
    ramp: 0.01,
    stale: 100,
};

/// One output: reference in, converter out.
struct Output<S> {
    compensator: Compensator<f32, 3, 0>,
    state: State<f32, 3>,
    safety: Safety,
    scale: Scale,
    dac: Ad5761r<S>,
}

impl<S: SpiDevice> Output<S> {
    /// Called by your timer, with the reference of this sample in um, or `None` where none came.
    fn sample(&mut self, reference_um: Option<f32>) -> Result<u16, S::Error> {
        // A sample that is not finite counts as one that did not come: the output waits, then rests.
        let drive = reference_um.and_then(|y| self.compensator.step(&mut self.state, y).ok());
        let code = self.scale.code(self.safety.step(&LIMITS, drive));
        self.dac.put(code)?;
        Ok(code)
    }
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // Your model: `hysteron identify` writes these numbers, `hysteron export` prints them as code.
    let hysteresis = Parameters {
        weights: &[0.7236, 0.2906, 0.0416, 0.1512],
        thresholds: &[9.715, 19.43, 29.145],
        beta: 8.572e-4,
    }
    .build::<3>(1.0 / RATE_HZ as f32)?;
    let stage = Model::<f32, 3, 0>::new(hysteresis, None, 1.0, 0.0)?;
    let compensator = stage.compensator()?;
    let range = (LIMITS.lowest, LIMITS.highest);
    let mut output = Output {
        state: compensator.start(0.0)?,
        compensator,
        safety: Safety::new(&LIMITS),
        scale: Scale::new(Kind::Bipolar16, GAIN, 0.0, range)
            .ok_or("a range beyond the converter")?,
        dac: Ad5761r::new(Bus),
    };
    output.dac.start(output.scale.code(LIMITS.rest))?;
    output.safety.run();
    let mut last = 0;
    for k in 0..400 {
        let reference_um =
            10.0 * (1.0 - (core::f64::consts::TAU * 50.0 * f64::from(k) / RATE_HZ).cos());
        last = output.sample(Some(reference_um as f32))?;
        if k % 50 == 0 {
            let drive = output.scale.drive(last);
            println!("{reference_um:7.3} um  {drive:7.3} V  code {last:5}");
        }
    }
    println!("and no reference any more: the output waits, then ramps to rest");
    for _ in 0..10_000 {
        last = output.sample(None)?;
    }
    println!("{:7.3} V  code {last:5}", output.scale.drive(last));
    Ok(())
}

/// Stands for the SPI device of a HAL.
struct Bus;

impl ErrorType for Bus {
    type Error = Infallible;
}

impl SpiDevice for Bus {
    fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        Ok(())
    }
}
