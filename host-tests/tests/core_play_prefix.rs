//! The prefix form of the bank against the plain one.

use hysteron::play::{Envelope, PlainState, PlayBank, PrefixState};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn plain_and_prefix_agree(
        rows in prop::collection::vec((0.05f64..3.0, -1.0f64..1.0), 1..=12),
        samples in prop::collection::vec((-20.0f64..20.0, 0.0f64..4.0, 0.0f64..4.0), 1..200),
    ) {
        let mut threshold = 0.0;
        let (thresholds, weights): (Vec<f64>, Vec<f64>) = rows
            .into_iter()
            .map(|(gap, weight)| {
                threshold += gap;
                (threshold, weight)
            })
            .unzip();
        // Both a full bank and one with room left, stepped with envelopes of any two widths.
        let full = PlayBank::<f64, 12>::new(&thresholds, &weights).unwrap();
        let roomy = PlayBank::<f64, 16>::new(&thresholds, &weights).unwrap();
        let mut plain = PlainState::zero();
        let (mut one, mut other) = (PrefixState::zero(), PrefixState::zero());
        for (u, below, above) in samples {
            let envelope = Envelope { lo: u - below, hi: u + above };
            let expected = plain.step(&full, envelope);
            let sum = one.step(&full, envelope);
            prop_assert!((sum - expected).abs() < 1e-12);
            prop_assert_eq!(sum, one.sum());
            prop_assert_eq!(sum, other.step(&roomy, envelope));
            prop_assert_eq!(one.outputs(), &plain.outputs());
            prop_assert_eq!(&one.outputs()[..], &other.outputs()[..12]);
            prop_assert!(other.outputs()[12..].iter().all(|&z| z == 0.0));
        }
    }
}
