//! Numbers and units as a reader expects them.

const SIGNIFICANT: usize = 4;

/// `value` with at most four significant digits, as shown on a page.
///
/// Whole numbers below a million stand in full; from 0.001 to 99 999 the form is decimal without
/// trailing zeros, beyond that a power of ten. NaN reads `n/a`.
///
/// ```
/// use hysteron_host::report::format_number;
/// assert_eq!(format_number(0.451_26), "0.4513");
/// assert_eq!(format_number(-2.5e-6), "−2.5×10⁻⁶");
/// ```
pub fn format_number(value: f64) -> String {
    if value.is_nan() {
        return "n/a".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.into();
    }
    if value == value.trunc() && value.abs() < 1e6 {
        return minus(format!("{:.0}", value + 0.0));
    }
    // The exponent is read after rounding, so 9.99996 counts as ten.
    let scientific = format!("{value:.*e}", SIGNIFICANT - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..5).contains(&exponent) {
        let decimals = usize::try_from(SIGNIFICANT as i32 - 1 - exponent).unwrap_or(0);
        return minus(trim_zeros(&format!("{value:.decimals$}")).into());
    }
    minus(format!(
        "{}×{}",
        trim_zeros(mantissa),
        power_of_ten(exponent)
    ))
}

/// `10` with `exponent` as superscript.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let digits = exponent.to_string();
    let superscript = digits.chars().map(|digit| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // The remaining superscripts lie in one block, unlike 1 to 3.
        other => char::from_u32(0x2070 + other.to_digit(10).unwrap_or(0)).unwrap_or('⁰'),
    });
    std::iter::once("10".to_owned())
        .chain(superscript.map(String::from))
        .collect()
}

/// A number for a script or a test to read back: six significant digits, shortest form.
pub(super) fn machine(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    let (plain, scientific) = (format!("{rounded}"), format!("{rounded:e}"));
    if plain.len() <= scientific.len() {
        plain
    } else {
        scientific
    }
}

/// The unit as printed: files say `um` because they are plain ASCII.
pub(super) fn display_unit(unit: &str) -> String {
    unit.replace("um", "µm")
}

/// A text with the micrometre as a word, `um` in files, printed as in [`display_unit`].
pub(super) fn display_text(text: &str) -> String {
    let part_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("um") {
        let (before, after) = (&rest[..at], &rest[at + 2..]);
        let alone = !before.ends_with(part_of_word) && !after.starts_with(part_of_word);
        // What was cut off before ended in a word if it ended in `um`.
        let alone = alone && !(before.is_empty() && shown.ends_with(part_of_word));
        shown += before;
        shown += if alone { "µm" } else { "um" };
        rest = after;
    }
    shown + rest
}

/// The true minus sign, as wide as a digit.
pub(super) fn minus(text: String) -> String {
    text.replace('-', "−")
}

fn trim_zeros(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_in_a_paper() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (12.0, "12"),
            (100_000.0, "100000"),
            (0.451_26, "0.4513"),
            (0.5, "0.5"),
            (9.999_96, "10"),
            (-1_234.56, "−1235"),
            (0.001, "0.001"),
            (0.000_999_9, "9.999×10⁻⁴"),
            (6.022_14e23, "6.022×10²³"),
            (1.5e7, "1.5×10⁷"),
            (f64::NAN, "n/a"),
            (f64::NEG_INFINITY, "−∞"),
        ] {
            assert_eq!(format_number(value), text, "{value:e}");
        }
    }

    #[test]
    fn machine_numbers_parse_back_to_six_digits() {
        for value in [1.0 / 3.0, -1.234_567_89e-12, 98_765_432.1, 5e-324, f64::MAX] {
            let back: f64 = machine(value).parse().unwrap();
            assert!(
                (back / value - 1.0).abs() <= 5e-6,
                "{value:e} became {back:e}"
            );
        }
        assert_eq!(machine(0.05), "0.05");
        assert_eq!(machine(1e-9), "1e-9");
    }

    #[test]
    fn micrometres_are_shown_where_they_are_a_word() {
        for (text, shown) in [
            ("0.5 um rms; um", "0.5 µm rms; µm"),
            ("um/V (um)", "µm/V (µm)"),
            ("minimum sum, umbra", "minimum sum, umbra"),
            (
                "reference_um and gain_um_per_v",
                "reference_um and gain_um_per_v",
            ),
            ("umum um", "umum µm"),
        ] {
            assert_eq!(display_text(text), shown);
        }
    }

    #[test]
    fn superscripts_spell_every_digit() {
        assert_eq!(power_of_ten(-1_234_567_890), "10⁻¹²³⁴⁵⁶⁷⁸⁹⁰");
    }
}
