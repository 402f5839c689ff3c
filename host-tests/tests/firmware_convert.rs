//! Codes, the driver of the bipolar converter, settings.

mod firmware_rig;

use std::convert::Infallible;

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use firmware_rig::{bipolar, exact_code};
use hysteron::dac::{Ad5761r, Kind, Scale};
use hysteron::sensor;
use hysteron::settings::{Settings, SettingsError};
use proptest::prelude::*;

fn scale(settings: &Settings) -> Option<Scale> {
    let range = (settings.drive_min_v, settings.drive_max_v);
    Scale::new(
        settings.dac,
        settings.amplifier_gain,
        settings.amplifier_offset_v,
        range,
    )
}

proptest! {
    #[test]
    fn a_code_is_the_nearest_one_within_the_range(
        bipolar_kind: bool, gain in prop_oneof![-40f32..-0.5, 0.5f32..40.0], offset in -20f32..20.0,
        ends in (0.0f32..1.0, 0.0f32..1.0), at in -0.5f32..1.5,
    ) {
        let dac = if bipolar_kind { Kind::Bipolar16 } else { Kind::Internal12 };
        let (low, span) = if bipolar_kind { (-5.0, 10.0) } else { (0.0, 3.3) };
        let drive = |share: f32| gain * (low + span * share) + offset;
        let (a, b) = (drive(ends.0), drive(ends.1));
        prop_assume!((ends.0 - ends.1).abs() > 0.01);
        let settings = Settings {
            dac, amplifier_gain: gain, amplifier_offset_v: offset,
            drive_min_v: a.min(b), drive_max_v: a.max(b), ..Settings::default()
        };
        let scale = scale(&settings).unwrap();
        let code = f64::from(scale.code(drive(at)));
        let (code_a, code_b) = (exact_code(&settings, a.into()), exact_code(&settings, b.into()));
        prop_assert!(code >= code_a.min(code_b) - 5e-3 && code <= code_a.max(code_b) + 5e-3);
        let wanted = exact_code(&settings, drive(at).into());
        if wanted > code_a.min(code_b) + 1.0 && wanted < code_a.max(code_b) - 1.0 {
            prop_assert!((code - wanted).abs() < 0.52, "{} for {}", code, wanted);
            let back = f64::from(scale.drive(code as u16));
            prop_assert!((exact_code(&settings, back) - code).abs() < 0.02);
        }
    }

    #[test]
    fn a_sensor_code_comes_back(um_per_v in prop_oneof![-50f32..-0.1, 0.1f32..50.0], offset in -99f32..99.0, code in 0u16..4096) {
        let scale = sensor::Scale::new(um_per_v, offset).unwrap();
        let exact = f64::from(um_per_v) * f64::from(code) * 3.3 / 4096.0 + f64::from(offset);
        prop_assert!((f64::from(scale.displacement(code)) - exact).abs() < 1e-4 * (1.0 + exact.abs()));
        // Where a float resolves a tenth of a code.
        if um_per_v.abs() > 0.5 {
            prop_assert_eq!(scale.code(scale.displacement(code)), code);
        }
    }
}

#[test]
fn codes_of_known_voltages() {
    let full = Settings {
        drive_min_v: -50.0,
        drive_max_v: 50.0,
        ..bipolar()
    };
    let scale = scale(&full).unwrap();
    assert_eq!(scale.code(0.0), 0x8000);
    assert_eq!(scale.code(-50.0), 0);
    assert_eq!(scale.code(25.0), 0xc000);
    assert_eq!(scale.code(1e9), 0xffff);
    assert_eq!(scale.code(f32::NEG_INFINITY), 0);
    let converter = sensor::Scale::new(10.0, 0.0).unwrap();
    assert_eq!(converter.code(f32::NAN), 0);
    assert_eq!(converter.code(1e9), 4095);
}

/// Writes down what is sent to it.
#[derive(Default)]
struct Listener(Vec<Vec<u8>>);

impl ErrorType for Listener {
    type Error = Infallible;
}

impl SpiDevice for Listener {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut sent = Vec::new();
        for operation in operations {
            match operation {
                Operation::Write(bytes) => sent.extend_from_slice(bytes),
                _ => panic!("only writes are expected"),
            }
        }
        self.0.push(sent);
        Ok(())
    }
}

#[test]
fn the_bipolar_converter_hears_what_its_data_sheet_asks_for() {
    let mut dac = Ad5761r::new(Listener::default());
    dac.start(0x8000).unwrap();
    dac.put(0x1234).unwrap();
    let sent = dac.release().0;
    let expected: [[u8; 3]; 4] = [
        [0xf, 0, 0],
        // CV = mid-scale, ETS, IRO, PV = mid-scale, RA = +-5 V; OVR and B2C zero.
        [0x4, 0b0000_0010, 0b0110_1010],
        [0x3, 0x80, 0x00],
        [0x3, 0x12, 0x34],
    ];
    assert_eq!(sent, expected);
}

#[test]
fn the_default_settings_hold() {
    Settings::default().validate().unwrap();
    bipolar().validate().unwrap();
}

#[test]
fn every_field_refuses_nan_and_its_own_nonsense() {
    use SettingsError as E;
    type Poke = fn(&mut Settings, f32);
    let fields: [(Poke, E, &[f32]); 11] = [
        (
            |s, v| s.sample_rate_hz = v,
            E::SampleRate,
            &[0.0, 99.0, 20_001.0, -1.0],
        ),
        (|s, v| s.amplifier_gain = v, E::Amplifier, &[0.0, 0.1]),
        (|s, v| s.amplifier_offset_v = v, E::Amplifier, &[1e3]),
        (|s, v| s.sensor_um_per_v = v, E::Sensor, &[0.0]),
        (|s, v| s.sensor_offset_um = v, E::Sensor, &[]),
        (|s, v| s.drive_min_v = v, E::DriveRange, &[46.0]),
        (|s, v| s.drive_max_v = v, E::DriveRange, &[-46.0]),
        (|s, v| s.drive_rest_v = v, E::Rest, &[45.1, -45.1]),
        (|s, v| s.slew_v_per_s = v, E::Slew, &[0.0, -1.0]),
        (
            |s, v| s.ramp_v_per_s = v,
            E::Ramp,
            &[0.0, -1.0, 30_001.0, 1e-6],
        ),
        (|s, v| s.stale_s = v, E::Stale, &[-0.1, 61.0]),
    ];
    for (index, (poke, error, nonsense)) in fields.into_iter().enumerate() {
        let always = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        for &value in always.iter().chain(nonsense) {
            let mut settings = bipolar();
            poke(&mut settings, value);
            assert_eq!(settings.validate(), Err(error), "field {index} at {value}");
        }
    }
    let other = Settings {
        version: 2,
        ..bipolar()
    };
    assert_eq!(other.validate(), Err(E::Version));
}
