//! What happens when the program itself fails: the converter goes to the safe code before anything
//! else, then the driver is disabled, then the watchdog resets the board into Off.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::{ExceptionFrame, exception};

use super::Board;
use crate::control::Output;
use crate::dac::Kind;

/// Code, and 1 << 16 for the bipolar converter. Before the first settings the internal one at zero.
static SAFE: AtomicU32 = AtomicU32::new(0);

/// Keeps what to put out after a fault.
pub fn set_safe(output: Output) {
    let bipolar = u32::from(output.dac == Kind::Bipolar16) << 16;
    SAFE.store(u32::from(output.code) | bipolar, Ordering::Relaxed);
}

/// Puts the converter to the safe code and the driver-enable pin low, whatever state anything is in.
fn make_safe() {
    let safe = SAFE.load(Ordering::Relaxed);
    let code = safe as u16;
    cortex_m::interrupt::disable();
    super::Hardware::make_safe(Output {
        dac: if safe >> 16 == 0 {
            Kind::Internal12
        } else {
            Kind::Bipolar16
        },
        code,
        driver_enabled: false,
    });
    #[cfg(feature = "qemu")]
    super::pil::report_fault(code);
}

/// Waits, but not for ever: a stuck bus must not keep the driver enabled.
pub fn wait(done: impl Fn() -> bool) {
    for _ in 0..1_000 {
        if done() {
            return;
        }
    }
}

/// Ends here: the watchdog is no longer fed.
fn end(_what: core::fmt::Arguments<'_>) -> ! {
    #[cfg(feature = "qemu")]
    {
        semihosting::eprintln!("{_what}");
        semihosting::process::exit(101);
    }
    #[cfg(not(feature = "qemu"))]
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    make_safe();
    end(format_args!("{info}"))
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    make_safe();
    end(format_args!("hard fault at {:#x}", frame.pc()))
}

/// An interrupt that nobody asked for.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    make_safe();
    end(format_args!("interrupt {number} has no handler"));
}
