//! The cascade on the simulated bimorph of paper M: Preisach relays, a mode, an even part behind it,
//! a held drive, noise. Its parameters come from `identify` on ten seconds of records, once; direct
//! inverse multiplication is identified at each frequency.

use hysteron_host::experiment::beyond::against_dim::{Comparison, run};
use hysteron_host::experiment::beyond::compensators::cascade;
use hysteron_host::experiment::beyond::plants::Plant;

#[test]
fn the_reference_is_followed_from_1_to_110_hz_and_better_than_by_dim() {
    let file = cascade(Plant::Bimorph).unwrap();
    println!("{:?}", file.parameters());
    // Its worst and DIM's best among them.
    let frequencies_hz = [
        1.0, 5.0, 7.0, 10.0, 15.0, 20.0, 23.0, 24.0, 25.0, 26.0, 27.0, 30.0, 37.0, 45.0, 50.0,
        60.0, 65.0, 70.0, 74.0, 75.0, 80.0, 85.0, 90.0, 95.0, 100.0, 110.0,
    ];
    let rows = run(&file, &frequencies_hz, &|| {}).unwrap();
    for at in &rows {
        println!(
            "{:5} Hz: DIM {:.2e} mm, cascade {:.2e}, third harmonic {:.1e}, drive up to {:.2} V, leap {:?}",
            at.frequency_hz,
            at.dim.rmse_mm,
            at.cascade.rmse_mm,
            at.cascade.third_harmonic,
            at.cascade.largest_v,
            at.cascade.leap,
        );
    }
    let found = Comparison::new(&rows).unwrap();
    assert_eq!(found.frequencies, 25);
    assert_eq!(found.cascade_better, 25);
    assert!(found.median_ratio > 10.0, "{}", found.median_ratio);
    assert!(found.worst_mm < 2e-3, "{} mm", found.worst_mm);
    assert!(found.third_25_hz_cascade < 0.02);
    // What DIM is held to fail at, it fails at here.
    assert!(found.third_25_hz_dim > 1.0);
    // No jump at start and stop: the drive steps no farther than twice what the sine itself asks for.
    assert!(found.largest_leap < 2.0, "{}", found.largest_leap);
}
