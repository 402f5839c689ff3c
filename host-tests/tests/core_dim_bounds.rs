//! DIM with coefficients and references of any size: no drive and no state that is no number.

use hysteron::dim::Dim;
use hysteron::hysteresis::modified_play::{
    Basis, BasisParameters, Harmonics, LinearPlane, ModifiedPlay, Terms,
};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Whatever the coefficients and the reference, in single precision.
    #[test]
    fn no_coefficients_make_a_drive_that_is_no_number(
        exponents in prop::array::uniform16((-38.0f64..38.0, any::<bool>())),
        references in prop::collection::vec((-38.0f64..38.0, any::<bool>()), 1..60),
    ) {
        let number = |(exponent, negative): (f64, bool)| {
            let size = 10f64.powf(exponent) as f32;
            if negative { -size } else { size }
        };
        let values = exponents.map(number);
        let basis: Basis<f32, 4> = BasisParameters {
            u_max: values[0].abs().clamp(1e-30, 1e30),
            divisions: 4,
            alpha: values[1].abs().min(1e30),
            beta: values[2].abs().min(1e30),
            harmonics: Harmonics::Printed,
            frequency: 50.0,
        }
        .build(1e-4)
        .unwrap();
        let list: [f32; 10] = std::array::from_fn(|i| values[6 + i]);
        let slopes = [values[3], values[4], values[5], 0.5 * values[3]];
        // What is refused cannot do harm.
        let plane = LinearPlane::new(basis.grid(), &slopes, 0.0);
        let model = plane.and_then(|plane| ModifiedPlay::new(&basis, plane, Terms::from_list(&list)));
        let Ok(model) = model else { return Ok(()) };
        for dim in [Dim::printed(model), Dim::exact(model)].into_iter().flatten() {
            let mut state = dim.start();
            for &reference in &references {
                let u = dim.step(&mut state, number(reference)).unwrap();
                prop_assert!(u.abs() <= basis.grid().u_max(), "{u}");
                prop_assert!(state.model().outputs().iter().all(|y| y.is_finite()));
            }
        }
    }
}
