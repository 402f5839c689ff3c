//! What to save.

use hysteron::record::{
    AsymmetryRecord, ChainRecord, DEAD_ZONES, EFFECTS, Effect, Inverse, ModelRecord, PLAYS,
    Preview, Zones,
};
use hysteron::settings::Settings;
use hysteron::store::Saved;
use rand::Rng;
use rand::rngs::SmallRng;

use crate::firmware_rig::{bipolar, modified_play};
use hysteron::dim::Law;
use hysteron::hysteresis::modified_play::Harmonics;
use hysteron::hysteresis::preview::PlantRate;

/// Valid settings, and no model or one of any shape; no two are the same.
pub fn anything(random: &mut SmallRng) -> Saved {
    let settings = Settings {
        slew_v_per_s: random.random_range(2e3..1e6),
        miss_limit: random.random(),
        ..bipolar()
    };
    let model = match random.random_range(0..4) {
        0 => None,
        1 => Some(modified_play(
            random.random_range(2..=PLAYS),
            Law::Exact,
            Harmonics::Printed,
        )),
        _ => {
            let plays = random.random_range(1..=PLAYS);
            let effects = random.random_range(0..=EFFECTS);
            Some(chain(plays, random.random_range(1..=DEAD_ZONES), effects))
        }
    };
    Saved { settings, model }
}

/// Those that take the most room.
pub fn fullest() -> [Saved; 2] {
    let settings = Settings {
        miss_limit: u16::MAX,
        ..bipolar()
    };
    [
        chain(PLAYS, DEAD_ZONES, EFFECTS),
        modified_play(PLAYS, Law::Exact, Harmonics::Corrected),
    ]
    .map(|model| Saved {
        settings,
        model: Some(model),
    })
}

fn chain(plays: usize, zones: usize, effects: usize) -> ModelRecord {
    let falling = |len: usize| (0..len).map(|i| 1.0 / (1.0 + i as f32));
    let side = Zones {
        thresholds: (1..=zones).map(|i| i as f32).collect(),
        slopes: falling(zones + 1).collect(),
    };
    let creep = Effect::Creep {
        gain_per_decade: 0.01,
        tau_min_s: 1e-2,
        tau_max_s: 1e5,
    };
    ModelRecord::Chain(ChainRecord {
        thresholds_v: (1..=plays).map(|i| 1.5 * i as f32).collect(),
        weights: falling(plays + 1).collect(),
        beta_s: 1e-4,
        asymmetry: Some(AsymmetryRecord {
            positive: side.clone(),
            negative: side,
        }),
        effects: (0..effects).map(|_| creep).collect(),
        gain_um_per_v: 1.0,
        offset_um: 0.5,
        inverse: Inverse::Preview(Preview {
            window: 26,
            plant_rate: PlantRate::Midpoint,
        }),
    })
}
