//! The kinds of faults, and what is required of a target in each.

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "each is described by `words`")]
pub enum Kind {
    BadChecksum,
    Truncation,
    Duplicate,
    Reordering,
    RandomFrame,
    RandomCommands,
    Noise,
    LostReply,
    LinkCut,
    Flood,
    StaleReference,
    StreamResets,
    StuckSensor,
    JumpingSensor,
    SensorNotFinite,
    BadSettings,
    BadModel,
    ReferenceNotFinite,
    ModelSwap,
    ModelRemoved,
    SettingsInMotion,
    Overrun,
    Reset,
}

impl Kind {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 23] = [
        Self::BadChecksum,
        Self::Truncation,
        Self::Duplicate,
        Self::Reordering,
        Self::RandomFrame,
        Self::RandomCommands,
        Self::Noise,
        Self::LostReply,
        Self::LinkCut,
        Self::Flood,
        Self::StaleReference,
        Self::StreamResets,
        Self::StuckSensor,
        Self::JumpingSensor,
        Self::SensorNotFinite,
        Self::BadSettings,
        Self::BadModel,
        Self::ReferenceNotFinite,
        Self::ModelSwap,
        Self::ModelRemoved,
        Self::SettingsInMotion,
        Self::Overrun,
        Self::Reset,
    ];

    /// Its key in JSON, its name, and what is required beyond what always holds.
    pub fn words(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::BadChecksum => (
                "bad_checksum",
                "frame with a bad CRC",
                "no reply, counted, the output goes on",
            ),
            Self::Truncation => (
                "truncation",
                "truncated frame",
                "no reply, counted, the output goes on",
            ),
            Self::Duplicate => (
                "duplicate",
                "frame that comes twice",
                "answered twice, carried out as if once",
            ),
            Self::Reordering => (
                "reordering",
                "frames of a stream out of order",
                "gaps refused; sent again, every acknowledged sample is played in its place",
            ),
            Self::RandomFrame => (
                "random_frame",
                "random body under a right CRC, random bytes",
                "refused or ignored, the link goes on",
            ),
            Self::RandomCommands => (
                "random_commands",
                "burst of valid commands with any values, in any state",
                "each answered once",
            ),
            Self::Noise => (
                "noise",
                "baud noise: bits turned, bytes lost, doubled, zeroed",
                "the command gets through within 60 tries, and what it acknowledged is in force",
            ),
            Self::LostReply => (
                "lost_reply",
                "replies lost, commands repeated",
                "what was acknowledged unheard is in force, no sample is played twice",
            ),
            Self::LinkCut => (
                "link_cut",
                "link cut in a frame while a stream is played",
                "all that was acknowledged is played, then stale time, then rest",
            ),
            Self::Flood => (
                "flood",
                "50 to 150 commands between two samples",
                "each answered once, in order",
            ),
            Self::StaleReference => (
                "stale_reference",
                "stream that pauses",
                "joined within stale time, rest beyond it",
            ),
            Self::StreamResets => (
                "stream_resets",
                "stream emptied again while it is being emptied, models swapped meanwhile",
                "every sample acknowledged after the last reset is played",
            ),
            Self::StuckSensor => (
                "stuck_sensor",
                "sensor stuck at any code, beyond 12 bit too",
                "the drive is that with a good sensor, code for code",
            ),
            Self::JumpingSensor => (
                "jumping_sensor",
                "sensor with any code in every sample",
                "the drive is that with a good sensor, code for code",
            ),
            Self::SensorNotFinite => (
                "sensor_not_finite",
                "NaN or infinity in the feedback of the core",
                "refused, state unchanged; as a target it is a fault that ramps to rest",
            ),
            Self::BadSettings => (
                "bad_settings",
                "settings with a field out of range",
                "refused, the field named",
            ),
            Self::BadModel => (
                "bad_model",
                "model with a value that is not finite or out of range",
                "refused as a model",
            ),
            Self::ReferenceNotFinite => (
                "reference_not_finite",
                "reference that is or becomes infinite or NaN",
                "refused, or a fault that ramps to rest and only Clear leaves",
            ),
            Self::ModelSwap => (
                "model_swap",
                "model swapped, at every phase of a cycle",
                "runs on, no sample of the reference is lost",
            ),
            Self::ModelRemoved => (
                "model_removed",
                "model removed in motion",
                "a fault that ramps to rest and only Clear leaves",
            ),
            Self::SettingsInMotion => (
                "settings_in_motion",
                "settings changed or saved in motion",
                "refused",
            ),
            Self::Overrun => (
                "overrun",
                "late samples, within and beyond the limit",
                "within it nothing, beyond it a fault that ramps to rest and only Clear leaves",
            ),
            Self::Reset => (
                "reset",
                "reset, as by the watchdog, in any state",
                "off and at rest in the first sample, what was saved in force",
            ),
        }
    }
}
