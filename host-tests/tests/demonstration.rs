//! The demonstration from records on disk to a compensated drive.

mod page_figures;

use std::sync::LazyLock;

use hysteron_host::dataset::{Dataset, Role};
use hysteron_host::experiment::demo::{self, Demonstration};
use hysteron_host::identify::{Options, identify};
use hysteron_host::output::OutputFolder;

static SHOWN: LazyLock<Demonstration> = LazyLock::new(|| {
    let place = tempfile::tempdir().unwrap();
    let measurements = demo::measure().unwrap();
    let mut folder = OutputFolder::create(place.path()).unwrap();
    folder
        .add("dataset.toml", demo::dataset_toml(&measurements))
        .unwrap();
    for one in &measurements {
        let columns = [
            ("time_s", &one.time_s[..]),
            ("drive_v", &one.drive_v),
            ("displacement_um", &one.displacement_um),
        ];
        folder.add_columns(one.file, &columns).unwrap();
    }
    folder.commit().unwrap();
    let dataset = Dataset::load(place.path()).unwrap();
    for (record, one) in dataset.records.iter().zip(&measurements) {
        assert_eq!(record.displacement_um, one.displacement_um);
        assert_eq!(record.role, one.role);
    }
    let found = identify(&dataset, &Options::default(), &|_| {}).unwrap();
    demo::drive(found).unwrap()
});

/// The truth is the configuration of the simulated stage, which the identification never sees.
#[test]
fn identification_finds_the_simulated_stage() {
    let model = &SHOWN.found.model;
    let (gain, offset) = model.output();
    let hysteresis = model.hysteresis().unwrap();
    let slope = gain * hysteresis.weights.iter().sum::<f64>();
    assert!((slope / 1.207 - 1.0).abs() < 0.01, "slope {slope}");
    assert!((hysteresis.beta_s / 8.572e-4 - 1.0).abs() < 0.05);
    assert!((offset - 50.0).abs() < 0.05);
    let (noise, _) = SHOWN.found.noise.unwrap();
    assert!((noise / 0.01 - 1.0).abs() < 0.1);
}

#[test]
fn held_out_record_is_explained() {
    let found = &SHOWN.found;
    let roles: Vec<Role> = found.records.iter().map(|record| record.role).collect();
    for role in [Role::Fit, Role::Select, Role::Report] {
        assert!(roles.contains(&role));
    }
    assert!(found.rms.report.unwrap() < 0.1);
    assert!(found.line_rms.report.unwrap() > 2.0);
}

#[test]
fn compensation_takes_most_of_the_error() {
    assert_eq!(SHOWN.tracking.len(), 2);
    for tracking in &SHOWN.tracking {
        for [without, with] in [tracking.largest_um, tracking.rms_um] {
            assert!(
                with < 0.2 * without,
                "{}: {with} of {without}",
                tracking.name
            );
        }
    }
}

#[test]
fn page_and_json_agree() {
    page_figures::assert_equal_json(&SHOWN.page().to_html(), &SHOWN.to_json(), 11);
}
