//! STM32F405 at 168 MHz. Pins, clocks and peripherals; `docs/hardware.md` has the wiring.
//!
//! | pin | use |
//! |---|---|
//! | PA4 | internal converter, channel 1 |
//! | PA5, PA7, PB0 | SCK, SDI, SYNC of the bipolar converter |
//! | PA0 | displacement sensor, channel 0 of ADC1 |
//! | PB1 | driver enable, high when driven |
//! | PA9, PA10 | TX, RX of the link |
//!
//! TIM3 counts at 6 MHz. Its update is the sample interrupt; its channel 1 starts the sensor's
//! conversion 3 us earlier, so that the code is there when the interrupt comes.

use cortex_m::asm::delay;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
pub use stm32f4::stm32f405 as device;
use stm32f4::stm32f405::{self as pac, Peripherals};

#[cfg(not(feature = "qemu"))]
mod flash;
mod ports;

use self::ports::{Spi1, Usart1};
use super::spi::Spi;
use super::{Board, Sampled, Sampling, fault, watchdog};
use crate::control::Output;
use crate::dac::{self, Ad5761r, Kind};
use crate::settings::Valid;

/// Crystal of the board in MHz: 8 on most; change it to what is soldered.
#[cfg(not(feature = "qemu"))]
const CRYSTAL_MHZ: u8 = 8;

/// Clock of the sample timer in Hz: 84 MHz / 14.
const TIMER_HZ: f32 = 6_000_000.0;

/// Counts before the sample at which the sensor's conversion starts: 3 us.
const CONVERSION_LEAD: u16 = 18;

/// SYNC of the bipolar converter, PB0.
struct Sync;

impl ErrorType for Sync {
    type Error = core::convert::Infallible;
}

impl OutputPin for Sync {
    #[inline(always)]
    fn set_low(&mut self) -> Result<(), Self::Error> {
        set_port_b(1 << 16);
        Ok(())
    }

    #[inline(always)]
    fn set_high(&mut self) -> Result<(), Self::Error> {
        set_port_b(1);
        Ok(())
    }
}

/// Sets (bits 0 to 15) and clears (bits 16 to 31) pins of port B, in one write.
#[inline(always)]
fn set_port_b(bits: u32) {
    // SAFETY: the register sets and clears single pins, so writers do not disturb one another.
    unsafe { (*pac::GPIOB::ptr()).bsrr().write(|w| w.bits(bits)) };
}

type Bipolar = Ad5761r<ExclusiveDevice<Spi<Spi1>, Sync, NoDelay>>;

/// The sample task's part.
pub struct Stm32f405Sampling {
    timer: pac::TIM3,
    adc: pac::ADC1,
    dac: pac::DAC,
    bipolar: Bipolar,
    late: bool,
}

/// The rest of the board.
pub struct Hardware(());

impl Sampling for Stm32f405Sampling {
    #[inline(always)]
    fn begin(&mut self) -> Sampled {
        self.timer.sr().write(|w| w.uif().clear_bit());
        Sampled {
            sensor: self.adc.dr().read().data().bits(),
            late: self.late,
        }
    }

    #[inline(always)]
    fn put(&mut self, output: Output) {
        match output.dac {
            Kind::Internal12 => {
                let code = output.code.into();
                // SAFETY: codes have twelve bits.
                self.dac.dhr12r1().write(|w| unsafe { w.bits(code) });
            }
            // The bus cannot fail.
            Kind::Bipolar16 => self.bipolar.put(output.code).unwrap_or(()),
        }
        set_port_b(if output.driver_enabled {
            1 << 1
        } else {
            1 << (1 + 16)
        });
        self.late = self.timer.sr().read().uif().bit_is_set();
    }
}

impl Board for Hardware {
    #[cfg(not(feature = "qemu"))]
    type Sampling = Stm32f405Sampling;
    #[cfg(feature = "qemu")]
    type Sampling = super::pil::Simulated;

    type Uart = Usart1;

    #[cfg(not(feature = "qemu"))]
    type Flash = flash::Flash;
    #[cfg(feature = "qemu")]
    type Flash = &'static mut crate::store::RamFlash;

    fn flash() -> Option<Self::Flash> {
        #[cfg(not(feature = "qemu"))]
        return flash::Flash::take();
        #[cfg(feature = "qemu")]
        super::pil::flash()
    }

    fn start(settings: &Valid) -> (Self, Self::Sampling) {
        // SAFETY: called once, before anything else uses a peripheral; RTIC keeps the core's.
        let parts = unsafe { Peripherals::steal() };
        clocks(&parts.RCC, &parts.FLASH);
        fault::set_safe(settings.at_rest());
        pins(&parts);
        let bus = ExclusiveDevice::new_no_delay(Spi(Spi1::new(parts.SPI1)), Sync);
        let bipolar = Ad5761r::new(bus.unwrap_or_else(|never| match never {}));
        converter(&parts.ADC1, &parts.ADC_COMMON);
        let mut sampling = Stm32f405Sampling {
            timer: parts.TIM3,
            adc: parts.ADC1,
            dac: parts.DAC,
            bipolar,
            late: false,
        };
        // Both converters stand at rest before either is connected; then the driver's pin is set.
        let rest = settings.at_rest();
        let bipolar_rest = if rest.dac == Kind::Bipolar16 {
            rest.code
        } else {
            0x8000
        };
        sampling.bipolar.start(bipolar_rest).unwrap_or(());
        sampling.put(rest);
        sampling.dac.cr().modify(|_, w| w.en1().enabled());
        // PB1 as an output, low since `put`.
        // SAFETY: as above.
        unsafe {
            (*pac::GPIOB::ptr())
                .moder()
                .modify(|_, w| w.moder1().output())
        };
        timer(&sampling.timer);
        if cfg!(not(feature = "qemu")) {
            watchdog::start();
        }
        #[cfg(feature = "qemu")]
        let sampling = super::pil::Simulated(sampling);
        (Self(()), sampling)
    }

    fn apply(&mut self, settings: &Valid) {
        fault::set_safe(settings.at_rest());
        // Outside the interrupt; 300 to 60,000 counts for 20,000 to 100 Hz.
        let counts = (TIMER_HZ * settings.sample_time + 0.5) as u16;
        // SAFETY: single writes to registers that the sample task does not touch; reload and compare
        // values are taken over together at the next sample.
        unsafe {
            let timer = &*pac::TIM3::ptr();
            timer
                .ccr1()
                .write(|w| w.bits((counts - CONVERSION_LEAD).into()));
            timer.arr().write(|w| w.bits((counts - 1).into()));
            if cfg!(not(feature = "qemu")) {
                timer.cr1().write(|w| w.cen().enabled().arpe().enabled());
            }
        }
    }

    fn uart() -> Self::Uart {
        // SAFETY: only the port uses USART1.
        Usart1::new(unsafe { Peripherals::steal() }.USART1)
    }

    fn feed_watchdog(&mut self) {
        watchdog::feed();
    }

    fn make_safe(output: Output) {
        // SAFETY: nothing else runs any more, and every write is one that the registers allow.
        unsafe {
            let (internal, spi) = (&*pac::DAC::ptr(), &*pac::SPI1::ptr());
            match output.dac {
                Kind::Internal12 => {
                    internal.dhr12r1().write(|w| w.bits(output.code.into()));
                }
                Kind::Bipolar16 => {
                    // A transfer under way is ended by deselecting: the converter ignores a part of one.
                    set_port_b(1 << 0);
                    fault::wait(|| spi.sr().read().bsy().bit_is_clear());
                    set_port_b(1 << 16);
                    for byte in dac::frame(output.code) {
                        fault::wait(|| spi.sr().read().txe().bit_is_set());
                        spi.dr().write(|w| w.bits(byte.into()));
                    }
                    fault::wait(|| spi.sr().read().txe().bit_is_set());
                    fault::wait(|| spi.sr().read().bsy().bit_is_clear());
                    set_port_b(1 << 0);
                }
            }
        }
        set_port_b(1 << (1 + 16));
    }
}

/// The clocks as the firmware has them and nothing else: for benchmarks.
pub fn full_speed() {
    // SAFETY: called once, before anything else uses a peripheral.
    let parts = unsafe { Peripherals::steal() };
    clocks(&parts.RCC, &parts.FLASH);
}

#[cfg(not(feature = "qemu"))]
fn clocks(rcc: &pac::RCC, flash: &pac::FLASH) {
    rcc.cr().modify(|_, w| w.hseon().on());
    while rcc.cr().read().hserdy().is_not_ready() {}
    // SAFETY: crystal / M = 1 MHz, x 336 / 2 = 168 MHz, / 7 = 48 MHz: within the data sheet.
    rcc.pllcfgr().write(|w| unsafe {
        w.pllsrc().hse().pllm().bits(CRYSTAL_MHZ).plln().bits(336);
        w.pllp().div2().pllq().bits(7)
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    while rcc.cr().read().pllrdy().is_not_ready() {}
    flash.acr().write(|w| {
        w.latency().ws5().prften().enabled();
        w.icen().enabled().dcen().enabled()
    });
    rcc.cfgr()
        .write(|w| w.ppre1().div4().ppre2().div2().sw().pll());
    while !rcc.cfgr().read().sws().is_pll() {}
    enable(rcc);
}

#[cfg(feature = "qemu")]
fn clocks(rcc: &pac::RCC, _flash: &pac::FLASH) {
    enable(rcc);
}

fn enable(rcc: &pac::RCC) {
    rcc.ahb1enr()
        .modify(|_, w| w.gpioaen().enabled().gpioben().enabled());
    rcc.apb1enr()
        .modify(|_, w| w.tim2en().enabled().tim3en().enabled().dacen().enabled());
    rcc.apb2enr().modify(|_, w| {
        w.usart1en().enabled();
        w.adc1en().enabled().spi1en().enabled()
    });
    // Two cycles until a peripheral answers.
    delay(4);
}

fn pins(parts: &Peripherals) {
    set_port_b(1 | 1 << (1 + 16));
    parts.GPIOB.moder().modify(|_, w| w.moder0().output());
    parts
        .GPIOB
        .ospeedr()
        .modify(|_, w| w.ospeedr0().high_speed());
    parts.GPIOA.moder().modify(|_, w| {
        w.moder0().analog().moder4().analog();
        w.moder5().alternate().moder7().alternate();
        w.moder9().alternate().moder10().alternate()
    });
    parts
        .GPIOA
        .ospeedr()
        .modify(|_, w| w.ospeedr5().high_speed().ospeedr7().high_speed());
    parts
        .GPIOA
        .afrl()
        .modify(|_, w| w.afrl5().af5().afrl7().af5());
    parts
        .GPIOA
        .afrh()
        .modify(|_, w| w.afrh9().af7().afrh10().af7());
}

/// ADC1, channel 0, one conversion for each rising edge of TIM3's channel 1: 27 cycles at 21 MHz.
fn converter(adc: &pac::ADC1, common: &pac::ADC_COMMON) {
    common.ccr().modify(|_, w| w.adcpre().div4());
    // SAFETY: channel numbers and times as the reference manual has them.
    unsafe {
        adc.sqr3().write(|w| w.sq1().bits(0));
        adc.smpr2().write(|w| w.smp0().cycles15());
    }
    adc.cr2()
        .write(|w| w.adon().enabled().extsel().tim3cc1().exten().rising_edge());
}

/// TIM3: 6 MHz, update interrupt, channel 1 high from its compare value to the update. Stopped.
fn timer(timer: &pac::TIM3) {
    timer.psc().write(|w| w.psc().set(13));
    timer.ccmr1_output().write(|w| {
        w.oc1m().pwm_mode2();
        w.oc1pe().enabled()
    });
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.egr().write(|w| w.ug().update());
    timer.sr().write(|w| w.uif().clear_bit());
    timer.dier().write(|w| w.uie().enabled());
}
