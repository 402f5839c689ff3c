//! What a start takes from the store.

use super::{Keep, Saved, Unfit};
use crate::record::ModelRecord;
use crate::settings::{Settings, SettingsError, Valid};

/// What to start with.
#[derive(Clone, Debug, PartialEq)]
pub struct Boot {
    /// Settings to be in force.
    pub settings: Settings,
    /// The same in the form that the interrupt uses.
    pub valid: Valid,
    /// The model, still to be judged.
    pub model: Option<ModelRecord>,
    /// Why what was saved is not in force.
    pub unfit: Option<Unfit>,
}

impl Boot {
    /// Without anything saved.
    ///
    /// # Errors
    /// Settings that are out of their bounds.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            settings,
            valid: settings.validate()?,
            model: None,
            unfit: None,
        })
    }

    /// With what was saved; with the settings of [`Settings::default`] and no model where there is
    /// nothing, or nothing that fits.
    ///
    /// # Errors
    /// None: the default settings are valid.
    pub fn load(keep: &mut dyn Keep) -> Result<Self, SettingsError> {
        let unfit = match keep.load() {
            Ok(None) => None,
            Ok(Some(Saved { settings, model })) => match Self::new(settings) {
                Ok(boot) => return Ok(Self { model, ..boot }),
                Err(error) => Some(Unfit::Settings(error)),
            },
            Err(unfit) => Some(unfit),
        };
        Ok(Self {
            unfit,
            ..Self::new(Settings::default())?
        })
    }
}
