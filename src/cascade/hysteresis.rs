//! How a cascade inverts the hysteresis of its chain.

use crate::chain::Effects;
use crate::effect::congruency::Congruency;
use crate::effect::rate_power::RatePower;
use crate::error::{Field, ParameterError, SampleError};
use crate::hysteresis::elements::{Elements, ElementsState};
use crate::hysteresis::preview::{PreviewInverse, PreviewSettings, PreviewState};
use crate::hysteresis::{RateDependentPi, State};
use crate::math::Real;

/// How the hysteresis is inverted.
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub(super) enum Hysteresis<T, const N: usize, const WINDOW: usize> {
    Explicit(RateDependentPi<T, N>),
    Preview(PreviewInverse<T, N, WINDOW>),
    /// The operator itself, solved.
    Congruent(RateDependentPi<T, N>, Congruency<T>),
    /// The operator with its elements, searched.
    Searched(RateDependentPi<T, N>, Elements<T>, Option<Congruency<T>>),
}

/// State of a [`Hysteresis`].
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub(super) enum HysteresisState<T, const N: usize, const WINDOW: usize> {
    Explicit(State<T, N>),
    Preview(PreviewState<T, N, WINDOW>),
    Congruent {
        plays: [T; N],
        previous: T,
    },
    Searched {
        plays: [T; N],
        elements: ElementsState<T>,
        previous: T,
    },
}

impl<T: Real, const N: usize, const WINDOW: usize> Hysteresis<T, N, WINDOW> {
    /// For the hysteresis of `chain`, with a preview where `preview` says how and nothing stands against
    /// it.
    ///
    /// # Errors
    /// Those of [`PreviewInverse::new`], [`Congruency::check`] and [`Elements::check`]; an inverse that
    /// leaves the range of `T`; a rate law, a congruency or elements without `WITH_LAWS`.
    pub(super) fn new<const WITH_LAWS: bool>(
        operator: &RateDependentPi<T, N>,
        effects: &Effects<T>,
        preview: Option<PreviewSettings>,
    ) -> Result<Self, ParameterError> {
        let laws = [
            (effects.rate_law.is_some(), Field::Exponent),
            (effects.congruency.is_some(), Field::Kappa),
            (!effects.elements.is_empty(), Field::Elements),
        ];
        for (there, field) in laws {
            if there && !WITH_LAWS {
                return Err(ParameterError::NotSupported(field));
            }
        }
        if WITH_LAWS && !effects.elements.is_empty() {
            let congruency = effects.congruency;
            effects.elements.check(operator, congruency.as_ref())?;
            return Ok(Self::Searched(*operator, effects.elements, congruency));
        }
        let preview = preview.filter(|_| effects.rate_law.is_none());
        Ok(match (&effects.congruency, preview) {
            (Some(congruency), _) if WITH_LAWS => {
                congruency.check(operator)?;
                Self::Congruent(*operator, *congruency)
            }
            (_, None) => Self::Explicit(operator.inverse()?),
            (_, Some(settings)) => Self::Preview(PreviewInverse::new(operator, settings)?),
        })
    }

    /// Samples that it looks ahead.
    pub(super) fn latency(&self) -> usize {
        match self {
            Self::Explicit(_) | Self::Congruent(..) | Self::Searched(..) => 0,
            Self::Preview(preview) => preview.latency(),
        }
    }

    /// The operator whose plays [`Hysteresis::plays`] are.
    pub(super) fn operator(&self) -> &RateDependentPi<T, N> {
        match self {
            Self::Explicit(inverse) => inverse,
            Self::Preview(preview) => preview.inverse(),
            Self::Congruent(operator, _) | Self::Searched(operator, ..) => operator,
        }
    }

    /// Where the plays stand.
    pub(super) fn plays(&self, state: &mut HysteresisState<T, N, WINDOW>) -> [T; N] {
        match state {
            HysteresisState::Explicit(at) => at.plays().outputs(self.operator().bank()),
            HysteresisState::Preview(at) => *at.plays(),
            HysteresisState::Congruent { plays, .. } | HysteresisState::Searched { plays, .. } => {
                *plays
            }
        }
    }

    /// Puts the plays elsewhere.
    ///
    /// # Errors
    /// Outputs that no input can have led to (J 8); the state is unchanged.
    pub(super) fn put_plays(
        &self,
        state: &mut HysteresisState<T, N, WINDOW>,
        outputs: &[T],
    ) -> Result<(), ParameterError> {
        let operator = self.operator();
        let plays = match state {
            HysteresisState::Explicit(at) => {
                *at = operator.start_from(T::ZERO, outputs)?;
                return Ok(());
            }
            HysteresisState::Preview(at) => at.plays(),
            HysteresisState::Congruent { plays, .. } | HysteresisState::Searched { plays, .. } => {
                plays
            }
        };
        operator.bank().check_outputs(outputs)?;
        for (to, &from) in plays.iter_mut().zip(outputs) {
            *to = from;
        }
        Ok(())
    }

    /// State before the output `w`, the drive having rested there.
    pub(super) fn start(&self, w: T) -> HysteresisState<T, N, WINDOW> {
        match self {
            Self::Explicit(inverse) => HysteresisState::Explicit(inverse.start(w)),
            Self::Preview(preview) => HysteresisState::Preview(preview.start(w)),
            Self::Congruent(..) => HysteresisState::Congruent {
                plays: [T::ZERO; N],
                previous: w,
            },
            Self::Searched(_, elements, _) => HysteresisState::Searched {
                plays: [T::ZERO; N],
                elements: elements.start(),
                previous: w,
            },
        }
    }

    /// The drive for the next input, `at_rest` if it has rested there until now.
    // Not inlined, nor are the maps: each is met in several places, and large.
    #[inline(never)]
    pub(super) fn step<const WITH_LAWS: bool>(
        &self,
        state: &mut HysteresisState<T, N, WINDOW>,
        law: Option<&RatePower<T>>,
        w: T,
        at_rest: bool,
    ) -> Result<T, SampleError> {
        match (self, state) {
            (Self::Explicit(inverse), HysteresisState::Explicit(at)) => {
                if at_rest {
                    at.rest_at(w);
                }
                Ok(match law {
                    Some(law) if WITH_LAWS => {
                        let rate = (w - at.previous()) / inverse.sample_time();
                        inverse.step_with_rate(at, w, law.step(rate))
                    }
                    _ => inverse.step(at, w),
                })
            }
            (Self::Preview(inverse), HysteresisState::Preview(at)) => {
                Ok(look_ahead(inverse, at, w, at_rest))
            }
            (
                Self::Congruent(operator, congruency),
                HysteresisState::Congruent { plays, previous },
            ) if WITH_LAWS => {
                let half_width = opened(operator, law, previous, w, at_rest);
                Ok(congruency.step_inverse(operator, plays, w, half_width))
            }
            (
                Self::Searched(operator, elements, congruency),
                HysteresisState::Searched {
                    plays,
                    elements: at,
                    previous,
                },
            ) if WITH_LAWS => {
                let half_width = opened(operator, law, previous, w, at_rest);
                let congruency = congruency.as_ref();
                Ok(elements.step_inverse(operator, congruency, (plays, at), (w, half_width)))
            }
            // A state of another cascade: there is no drive to give.
            _ => Err(SampleError::NotFinite),
        }
    }
}

/// How far the rate of the output opens the envelope.
fn opened<T: Real, const N: usize>(
    operator: &RateDependentPi<T, N>,
    law: Option<&RatePower<T>>,
    previous: &mut T,
    w: T,
    at_rest: bool,
) -> T {
    let way = if at_rest { T::ZERO } else { w - *previous };
    *previous = w;
    let rate = (way / operator.sample_time()).abs();
    operator.beta() * law.map_or(rate, |law| law.step(rate))
}

// By itself it keeps its registers.
#[inline(never)]
fn look_ahead<T: Real, const N: usize, const WINDOW: usize>(
    inverse: &PreviewInverse<T, N, WINDOW>,
    state: &mut PreviewState<T, N, WINDOW>,
    w: T,
    at_rest: bool,
) -> T {
    if at_rest {
        inverse.rest_at(state, w)
    } else {
        inverse.step(state, w)
    }
}
