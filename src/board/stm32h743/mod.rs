//! STM32H743 at 400 MHz. Pins are those of the STM32F405; `docs/hardware.md` has the wiring.
//!
//! | pin | use |
//! |---|---|
//! | PA4 | internal converter, channel 1 |
//! | PA5, PA7, PB0 | SCK, SDI, SYNC of the bipolar converter |
//! | PA0 | displacement sensor, channel 16 of ADC1 |
//! | PB1 | driver enable, high when driven |
//! | PA9, PA10 | TX, RX of the link |
//!
//! TIM3 counts at 5 MHz. Its update is the sample interrupt; its channel 4 starts the sensor's
//! conversion 3 us earlier, so that the code is there when the interrupt comes.
//!
//! Variables are in DTCM, which needs no cache; that of the data stays off, that of instructions on.

mod flash;
mod ports;

use cortex_m::asm::delay;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
pub use stm32h7::stm32h743v as device;
use stm32h7::stm32h743v::{self as pac, Peripherals};

use self::ports::{Spi1, Usart1};
use super::spi::Spi;
use super::{Board, Sampled, Sampling, fault, watchdog};
use crate::control::Output;
use crate::dac::{self, Ad5761r, Kind};
use crate::settings::Valid;

/// Crystal of the board in MHz: 8 on most; an even number up to 50.
const CRYSTAL_MHZ: u8 = 8;

/// Clock of the sample timer in Hz: 200 MHz / 40.
const TIMER_HZ: f32 = 5_000_000.0;

/// Counts before the sample at which the sensor's conversion starts: 3 us.
const CONVERSION_LEAD: u16 = 15;

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
pub struct Stm32h743Sampling {
    timer: pac::TIM3,
    adc: pac::ADC1,
    dac: pac::DAC,
    bipolar: Bipolar,
    late: bool,
}

/// The rest of the board.
pub struct Hardware(());

impl Sampling for Stm32h743Sampling {
    #[inline(always)]
    fn begin(&mut self) -> Sampled {
        self.timer.sr().write(|w| w.uif().clear_bit());
        Sampled {
            sensor: self.adc.dr().read().bits() as u16,
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
    type Sampling = Stm32h743Sampling;
    type Uart = Usart1;
    type Flash = flash::Flash;

    fn flash() -> Option<Self::Flash> {
        flash::Flash::take()
    }

    fn start(settings: &Valid) -> (Self, Self::Sampling) {
        // SAFETY: called once, before anything else uses a peripheral; RTIC keeps the core's, of which
        // this touches the cache alone.
        let (parts, mut core) = unsafe { (Peripherals::steal(), cortex_m::Peripherals::steal()) };
        clocks(&parts);
        core.SCB.enable_icache();
        fault::set_safe(settings.at_rest());
        pins(&parts);
        let bus = ExclusiveDevice::new_no_delay(Spi(Spi1::new(parts.SPI1)), Sync);
        let bipolar = Ad5761r::new(bus.unwrap_or_else(|never| match never {}));
        converter(&parts.ADC1, &parts.ADC12_COMMON);
        let mut sampling = Stm32h743Sampling {
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
        parts.GPIOB.moder().modify(|_, w| w.moder1().output());
        timer(&sampling.timer);
        watchdog::start();
        (Self(()), sampling)
    }

    fn uart() -> Self::Uart {
        // SAFETY: only the port uses USART1.
        Usart1::new(unsafe { Peripherals::steal() }.USART1)
    }

    fn apply(&mut self, settings: &Valid) {
        fault::set_safe(settings.at_rest());
        // Outside the interrupt; 250 to 50,000 counts for 20,000 to 100 Hz.
        let counts = (TIMER_HZ * settings.sample_time + 0.5) as u16;
        // SAFETY: single writes to registers that the sample task does not touch; reload and compare
        // values are taken over together at the next sample.
        unsafe {
            let timer = &*pac::TIM3::ptr();
            timer
                .ccr4()
                .write(|w| w.bits((counts - CONVERSION_LEAD).into()));
            timer.arr().write(|w| w.bits((counts - 1).into()));
            timer.cr1().write(|w| w.cen().enabled().arpe().enabled());
        }
    }

    fn feed_watchdog(&mut self) {
        watchdog::feed();
    }

    fn make_safe(output: Output) {
        // SAFETY: nothing else runs any more, and every write is one that the registers allow.
        let (internal, spi) = unsafe { (&*pac::DAC::ptr(), &*pac::SPI1::ptr()) };
        match output.dac {
            Kind::Internal12 => {
                // SAFETY: codes have twelve bits.
                internal
                    .dhr12r1()
                    .write(|w| unsafe { w.bits(output.code.into()) });
            }
            Kind::Bipolar16 => {
                // A transfer under way is ended by deselecting: the converter ignores a part of one.
                set_port_b(1);
                fault::wait(|| spi.sr().read().txc().bit_is_set());
                set_port_b(1 << 16);
                for byte in dac::frame(output.code) {
                    fault::wait(|| spi.sr().read().txp().bit_is_set());
                    ports::give(spi, byte);
                }
                fault::wait(|| spi.sr().read().txc().bit_is_set());
                set_port_b(1);
            }
        }
        set_port_b(1 << (1 + 16));
    }
}

/// 400 MHz for the core, 200 MHz for memories, timers and SPI, 100 MHz for the rest.
fn clocks(parts: &Peripherals) {
    let (rcc, pwr, flash) = (&parts.RCC, &parts.PWR, &parts.FLASH);
    // The regulator as after reset, confirmed; then its highest scale but for overdrive.
    pwr.cr3()
        .modify(|_, w| w.bypass().clear_bit().ldoen().set_bit().scuen().set_bit());
    while pwr.csr1().read().actvosrdy().bit_is_clear() {}
    // SAFETY: scale 1.
    pwr.d3cr().modify(|_, w| unsafe { w.vos().bits(0b11) });
    while pwr.d3cr().read().vosrdy().bit_is_clear() {}
    rcc.cr().modify(|_, w| w.hseon().on());
    while rcc.cr().read().hserdy().is_not_ready() {}
    // SAFETY: crystal / M = 2 MHz, x 400 = 800 MHz, / 2 = 400 MHz, / 4 = 200 MHz: within the data sheet.
    unsafe {
        rcc.pllckselr()
            .modify(|_, w| w.pllsrc().hse().divm1().bits(CRYSTAL_MHZ / 2));
        rcc.pllcfgr().modify(|_, w| {
            w.pll1vcosel().wide_vco().pll1rge().range2();
            w.divp1en().enabled().divq1en().enabled()
        });
        rcc.pll1divr().write(|w| {
            w.divn1().bits(400 - 1).divp1().div2();
            w.divq1().bits(4 - 1).divr1().bits(4 - 1)
        });
    }
    rcc.cr().modify(|_, w| w.pll1on().on());
    while rcc.cr().read().pll1rdy().is_not_ready() {}
    // SAFETY: two wait states and the delay that go with 200 MHz at scale 1.
    flash
        .acr()
        .write(|w| unsafe { w.latency().bits(2).wrhighfreq().bits(2) });
    while flash.acr().read().latency().bits() != 2 {}
    rcc.d1cfgr()
        .modify(|_, w| w.d1cpre().div1().hpre().div2().d1ppre().div2());
    rcc.d2cfgr()
        .modify(|_, w| w.d2ppre1().div2().d2ppre2().div2());
    rcc.d3cfgr().modify(|_, w| w.d3ppre().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll1());
    while !rcc.cfgr().read().sws().is_pll1() {}
    // The sensor's converter has the internal oscillator's 64 MHz.
    rcc.d3ccipr().modify(|_, w| w.adcsel().per());
    rcc.ahb4enr()
        .modify(|_, w| w.gpioaen().enabled().gpioben().enabled());
    rcc.ahb1enr().modify(|_, w| w.adc12en().enabled());
    rcc.apb1lenr()
        .modify(|_, w| w.tim3en().enabled().dac12en().enabled());
    rcc.apb2enr()
        .modify(|_, w| w.usart1en().enabled().spi1en().enabled());
    // Two cycles of the slowest bus until a peripheral answers.
    delay(8);
}

fn pins(parts: &Peripherals) {
    set_port_b(1 | 1 << (1 + 16));
    parts.GPIOB.moder().modify(|_, w| w.moder0().output());
    parts
        .GPIOB
        .ospeedr()
        .modify(|_, w| w.ospeedr0().high_speed());
    parts
        .GPIOA
        .ospeedr()
        .modify(|_, w| w.ospeedr5().high_speed().ospeedr7().high_speed());
    parts
        .GPIOA
        .afrl()
        .modify(|_, w| w.afr5().af5().afr7().af5());
    parts
        .GPIOA
        .afrh()
        .modify(|_, w| w.afr9().af7().afr10().af7());
    parts.GPIOA.moder().modify(|_, w| {
        w.moder0().analog().moder4().analog();
        w.moder5().alternate().moder7().alternate();
        w.moder9().alternate().moder10().alternate()
    });
}

/// ADC1, channel 16, 12 bit, one conversion for each rising edge of TIM3's channel 4: 15 cycles at
/// 16 MHz, or at 8 MHz, for revision V halves its clock.
fn converter(adc: &pac::ADC1, common: &pac::ADC12_COMMON) {
    common
        .ccr()
        .write(|w| w.ckmode().asynchronous().presc().div4());
    adc.cr().write(|w| w.deeppwd().power_up());
    adc.cr().write(|w| w.advregen().enabled().boost().lt12_5());
    // Its regulator takes 10 us.
    delay(10 * 400);
    adc.cr().modify(|_, w| w.adcal().start_calibration());
    while adc.cr().read().adcal().bit_is_set() {}
    adc.isr().write(|w| w.adrdy().clear());
    // For four clocks of its own after a calibration the converter does not take this.
    while adc.isr().read().adrdy().bit_is_clear() {
        adc.cr().modify(|_, w| w.aden().enabled());
    }
    // SAFETY: channel numbers as the reference manual has them.
    unsafe {
        adc.pcsel().write(|w| w.bits(1 << 16));
        adc.sqr1().write(|w| w.l().bits(0).sq1().bits(16));
    }
    adc.smpr2().write(|w| w.smp16().cycles8_5());
    adc.cfgr().write(|w| {
        w.res().twelve_bit().ovrmod().overwrite();
        w.extsel().tim3_cc4().exten().rising_edge()
    });
    adc.cr().modify(|_, w| w.adstart().start_conversion());
}

/// TIM3: 5 MHz, update interrupt, channel 4 high from its compare value to the update. Stopped.
fn timer(timer: &pac::TIM3) {
    timer.psc().write(|w| w.psc().set(39));
    timer
        .ccmr2_output()
        .write(|w| w.oc4m().pwm_mode2().oc4pe().enabled());
    timer.ccer().write(|w| w.cc4e().set_bit());
    timer.egr().write(|w| w.ug().update());
    timer.sr().write(|w| w.uif().clear_bit());
    timer.dier().write(|w| w.uie().enabled());
}
