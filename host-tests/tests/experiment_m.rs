//! Paper M computed from code, held against what is printed and against identities.

mod golden;

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use hysteron_host::experiment::m::{self, AtFrequency, Content, Plane, Results};
use serde_json::Value;

const HIGHEST_HZ: u32 = 110;

/// All frequencies, with `HYSTERON_WHOLE_SUITE=1`; otherwise those that tests ask for, those around the
/// resonance and every fifth.
static FREQUENCIES_HZ: LazyLock<Vec<u32>> = LazyLock::new(|| {
    let whole = std::env::var_os("HYSTERON_WHOLE_SUITE").is_some();
    let named = [1, 14, 21, 23, 24, 26, 27];
    let needed =
        |hz: &u32| whole || hz.is_multiple_of(5) || (70..=80).contains(hz) || named.contains(hz);
    (1..=HIGHEST_HZ).filter(needed).collect()
});

static PIECES: AtomicU64 = AtomicU64::new(0);
static RESULTS: LazyLock<Results> = LazyLock::new(|| {
    m::run_at(&FREQUENCIES_HZ, &|| {
        PIECES.fetch_add(1, Ordering::Relaxed);
    })
    .expect("the experiment is fixed")
});

/// Rms of the reference, mm.
const REFERENCE_MM: f64 = 0.05 * std::f64::consts::FRAC_1_SQRT_2;

fn at(hz: u32) -> &'static AtFrequency {
    let mut found = RESULTS.frequencies.iter();
    let found = found.find(|at| at.frequency_hz == f64::from(hz));
    found.expect("among those computed")
}

/// Rms error of the printed law with the proposed model, over that of the reference.
fn left(hz: u32) -> f64 {
    at(hz).proposed.printed.rms_error_mm / REFERENCE_MM
}

#[test]
fn progress_comes_as_announced() {
    LazyLock::force(&RESULTS);
    let left_out = HIGHEST_HZ as usize - FREQUENCIES_HZ.len();
    let announced = m::PIECES - left_out as u64;
    assert_eq!(PIECES.load(Ordering::Relaxed), announced);
    assert_eq!(RESULTS.frequencies.len(), FREQUENCIES_HZ.len());
}

#[test]
fn the_proposed_model_is_the_best_at_nearly_all_frequencies() {
    let best = RESULTS
        .frequencies
        .iter()
        .filter(|at| {
            let proposed = at.models.proposed.free_run.rmse_mm;
            proposed <= at.models.truncated.free_run.rmse_mm
                && proposed <= at.models.bouc_wen.free_run.rmse_mm
        })
        .count();
    let of = FREQUENCIES_HZ.len();
    assert!(best + 5 >= of, "{best} of {of}");
    // Of all frequencies, of which a usual run computes a third.
    let all = &golden::golden("m")["summary"]["best_in_free_run"]["proposed"];
    assert!(all.as_u64().unwrap() >= 105, "{all} of {HIGHEST_HZ}");
    assert_eq!(RESULTS.summary.best_in_free_run.proposed, best);
}

#[test]
fn the_rival_was_identified_in_earnest() {
    // Were it not, the comparison would say nothing: the same terms and the same search take it to
    // within a few percent of the proposed model at most frequencies, and never far off.
    assert!(RESULTS.summary.bouc_wen_over_proposed < 1.1);
    for at in &RESULTS.frequencies {
        let fitting = at.models.bouc_wen.free_run.fitting_percent;
        assert!(fitting > 98.0, "{} Hz: {fitting} %", at.frequency_hz);
    }
}

#[test]
fn one_step_errors_are_at_the_noise_of_the_sensor() {
    // With exact coefficients, white noise of 20 nm in four samples leaves 20 nm times the root of
    // 1 + c_1^2 + c_2^2 + c_3^2; at least the noise of the sample itself is left.
    for at in RESULTS
        .frequencies
        .iter()
        .filter(|at| at.frequency_hz < 50.0)
    {
        let rmse = at.models.proposed.one_step.rmse_mm;
        assert!(
            (1.9e-5..6e-5).contains(&rmse),
            "{}: {rmse}",
            at.frequency_hz
        );
    }
}

#[test]
fn the_fit_is_lost_only_a_little_near_the_resonance() {
    for at in &RESULTS.frequencies {
        let scores = at.models.proposed;
        let recursive = scores.recursive_free_run.expect("it is linear");
        // Published: at most 3 percent; one more here.
        assert!(recursive.fitting_percent > 95.5, "{}", at.frequency_hz);
        assert!(
            scores.free_run.fitting_percent > 99.8,
            "{}",
            at.frequency_hz
        );
        // What is fitted for the free run does not do worse in it.
        assert!(scores.free_run.rmse_mm <= recursive.rmse_mm);
    }
    let lowest = RESULTS
        .frequencies
        .iter()
        .min_by(|a, b| {
            let fitting = |at: &AtFrequency| {
                let recursive = at.models.proposed.recursive_free_run;
                recursive.map_or(f64::NAN, |score| score.fitting_percent)
            };
            fitting(a).total_cmp(&fitting(b))
        })
        .expect("there are frequencies");
    assert!((70.0..=80.0).contains(&lowest.frequency_hz));
}

#[test]
fn the_error_grows_around_the_resonance_as_published() {
    let rmse = |hz: u32| at(hz).models.proposed.free_run.rmse_mm;
    for hz in 70..=80 {
        assert!(
            rmse(hz) > 3.0 * rmse(50) && rmse(hz) > 3.0 * rmse(100),
            "{hz} Hz"
        );
    }
}

#[test]
fn compensation_fails_where_the_paper_says() {
    // Away from it: below a tenth.
    for hz in [1, 5, 10, 14, 20, 21] {
        assert!(left(hz) < 0.1, "{hz} Hz: {}", left(hz));
    }
    assert!(left(30) < 0.15 && left(45) < 0.15);
    // 23 to 27 Hz: worse than on either side, at 25 Hz worse than doing nothing.
    for hz in 23..=27 {
        assert!(
            left(hz) > 1.5 * left(21) && left(hz) > 1.3 * left(30),
            "{hz} Hz"
        );
    }
    assert!(left(25) > 1.0);
    // Around and beyond the resonance.
    for hz in (70..=80).chain([85, 90, 95]) {
        assert!(left(hz) > 0.3, "{hz} Hz: {}", left(hz));
    }
}

#[test]
fn at_25_hz_the_third_harmonic_takes_over() {
    let lines = &RESULTS.studies.response_25_hz;
    let ratio = |of: fn(&m::AtHarmonic) -> f64| of(&lines[2]) / of(&lines[0]);
    assert_eq!((lines[0].harmonic, lines[2].harmonic), (1, 3));
    let (before, after) = (ratio(|l| l.before_mm), ratio(|l| l.printed_mm));
    assert!(before < 0.1, "{before}");
    // Published: 2.
    assert!((1.2..2.5).contains(&after), "{after}");
    assert_eq!(RESULTS.summary.third_over_first_25_hz, [before, after]);
    // Its cause is in the drive: 75 Hz of it times the gain at the resonance is what is seen.
    let gain = at(75).largest_mm;
    let expected = lines[2].drive * gain;
    assert!((lines[2].printed_mm / expected - 1.0).abs() < 0.25);
}

#[test]
fn the_exact_law_solves_its_own_model() {
    let mut solved = 0;
    for at in &RESULTS.frequencies {
        for law in [&at.proposed, &at.truncated] {
            match (&law.exact, &law.refused) {
                (Some(exact), None) if exact.saturated == 0.0 => {
                    assert!(exact.model_rms_error_mm < 1e-12, "{} Hz", at.frequency_hz);
                    solved += 1;
                }
                (Some(_), None) => {}
                (None, Some(reason)) => assert!(!reason.is_empty()),
                other => panic!("{} Hz: {other:?}", at.frequency_hz),
            }
        }
    }
    assert!(
        solved * 110 >= 100 * FREQUENCIES_HZ.len(),
        "only {solved} runs"
    );
}

#[test]
fn no_output_of_a_compensated_bimorph_is_out_of_range() {
    for at in &RESULTS.frequencies {
        for law in [&at.proposed, &at.truncated] {
            for outcome in [Some(&law.printed), law.exact.as_ref()]
                .into_iter()
                .flatten()
            {
                assert!(outcome.rms_error_mm.is_finite());
                assert!((0.0..=1.0).contains(&outcome.saturated));
                // 5 V at the resonance give 2.2 mm.
                assert!(outcome.rms_error_mm < 2.5);
            }
        }
    }
}

#[test]
fn printed_harmonic_terms_hold_even_harmonics_and_corrected_ones_odd() {
    let contents = &RESULTS.studies.harmonic_terms;
    assert_eq!(contents.len(), 12);
    let parity = |content: &Content, first: usize| -> f64 {
        let every_other = content.amplitudes.iter().skip(first).step_by(2);
        every_other.fold(0.0, |most, &a| a.max(most))
    };
    for content in contents {
        let (even, odd) = (parity(content, 0), parity(content, 1));
        match content.form {
            "printed" => assert!(odd < 1e-12 && even > 0.1, "{content:?}"),
            _ => assert!(even < 1e-12 && odd > 0.1, "{content:?}"),
        }
    }
    // sin^2, sin^4: their textbook expansions.
    let amplitudes = |i: usize| contents[i].amplitudes;
    assert!((amplitudes(0)[2] - 0.5).abs() < 1e-3);
    assert!((amplitudes(2)[4] - 0.125).abs() < 1e-3);
}

#[test]
fn planes_are_compared_on_a_signal_that_was_not_fitted() {
    let planes = &RESULTS.studies.planes;
    assert_eq!(planes.len(), 4);
    for pair in planes.chunks(2) {
        let [printed, clamped] = pair else {
            panic!("planes come in pairs")
        };
        assert_eq!(
            (printed.plane, clamped.plane),
            (Plane::Printed, Plane::Clamped)
        );
        assert_eq!((printed.coefficients, clamped.coefficients), (14, 49));
        // More freedom shows on the fitted signal; on the other nothing is won by it for certain.
        assert!(clamped.fitted.rmse_mm < printed.fitted.rmse_mm);
        assert!(clamped.held_out.rmse_mm > clamped.fitted.rmse_mm);
        assert!(printed.held_out.fitting_percent > 80.0);
        assert!(clamped.held_out.fitting_percent > 80.0);
    }
}

#[test]
fn the_initial_covariance_decides() {
    let covariances = &RESULTS.studies.covariances;
    let fitting = |covariance: f64| {
        let found = covariances.iter().find(|at| at.covariance == covariance);
        found.expect("studied").outcome.lowest_fitting_percent
    };
    assert!(fitting(1.0) > 95.0);
    assert!(fitting(1e4) < 0.0 && fitting(1e6) < 0.0, "models run away");
}

#[test]
fn json_and_page_say_the_same() {
    let json = RESULTS.to_json();
    let page = RESULTS.page().to_html();
    let figures: Vec<_> = page.split("data-key=\"").skip(1).collect();
    assert_eq!(figures.len(), 12);
    for figure in figures {
        let mut parts = figure.split('"');
        let key = parts.next().expect("a key");
        let shown: f64 = parts.nth(1).expect("a value").parse().expect("a number");
        let pointer = format!("/{}", key.replace('.', "/"));
        let in_json = json.pointer(&pointer).and_then(Value::as_f64);
        assert_eq!(in_json, Some(shown), "{key}");
    }
    for figure in [4, 6, 7, 8, 9, 13, 14, 15, 16, 17, 18, 19, 20] {
        assert!(
            page.contains(&format!("Figure {figure}")),
            "figure {figure}"
        );
    }
    assert!(page.len() < 2_000_000);
}

#[test]
fn it_comes_out_the_same_again() {
    let again = m::Record::measure(25.0).expect("fixed");
    let traces = RESULTS.traces.iter().find(|t| t.frequency_hz == 25.0);
    let before = &traces.expect("shown").displacement_mm;
    assert_eq!(&again.displacement_mm[10_000..], &before[..]);
}

/// What the book quotes of it, at the frequencies computed here. Near the resonance recursive models hang on
/// the last digits of logarithms and sines.
#[test]
fn the_golden_output_is_what_it_says() {
    let (json, golden) = (RESULTS.to_json(), golden::golden("m"));
    let rows = json["frequencies"].as_array().unwrap();
    assert!(rows.len() >= 30);
    for row in rows {
        let hz = row["frequency_hz"].as_f64().unwrap();
        let tolerance = if (70.0..=80.0).contains(&hz) {
            0.1
        } else {
            0.01
        };
        let then = golden::entry(
            &golden["frequencies"],
            &[("frequency_hz", row["frequency_hz"].clone())],
        );
        golden::assert_near(row, then, tolerance);
    }
    for key in ["response_25_hz", "planes", "printed_and_corrected"] {
        golden::assert_near(&json["studies"][key], &golden["studies"][key], 0.1);
    }
    golden::assert_near(&json["summary"]["facts"], &golden["summary"]["facts"], 1e-3);
}
