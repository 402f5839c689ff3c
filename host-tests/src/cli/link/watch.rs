//! How the target fares, again and again.

use std::time::Duration;

use clap::Args;
use serde_json::{Value, json};

use hysteron::settings::Settings;
use hysteron::telemetry::Statistics;
use hysteron_host::error::Error;
use hysteron_host::link::Client;

use crate::cli::say::{self, say};

#[derive(Debug, Args)]
pub struct Watch {
    /// Seconds between two lines.
    #[arg(long, value_name = "S", default_value_t = 0.5, value_parser = interval)]
    every: f64,
    /// Lines to print; without it until Ctrl-C, which leaves the output as it is.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

fn interval(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.01..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err("from 0.01 to 3600 seconds".to_owned()),
    }
}

impl Watch {
    pub fn run(&self, client: &mut Client<'_>) -> Result<(), Error> {
        let settings = client.settings()?;
        let mut next = client.now();
        for line in 0.. {
            if self.count.is_some_and(|count| line >= count) || !say::is_heard() {
                break;
            }
            while client.now() < next {
                client.wait(next.saturating_sub(client.now()))?;
            }
            next += Duration::from_secs_f64(self.every);
            let fields = fields(&client.statistics()?, &settings)?;
            let shown: Vec<_> = fields
                .iter()
                .map(|(name, value)| format!("{name} {}", text(value)))
                .collect();
            say!("{}", shown.join("  "));
            say::figures(&object(fields));
        }
        Ok(())
    }
}

/// Counters with codes in V and um.
pub fn fields(now: &Statistics, settings: &Settings) -> Result<Vec<(&'static str, Value)>, Error> {
    let valid = settings.validate().map_err(|error| {
        Error::request(format!("the target has settings out of bounds: {error:?}"))
    })?;
    Ok(vec![
        (
            "time_s",
            json!(f64::from(now.ticks) / f64::from(settings.sample_rate_hz)),
        ),
        ("state", json!(format!("{:?}", now.state))),
        ("cause", json!(now.cause.map(|cause| format!("{cause:?}")))),
        ("driver_enabled", json!(now.driver_enabled)),
        ("drive_v", json!(valid.dac.drive(now.codes.drive))),
        (
            "displacement_um",
            json!(valid.sensor.displacement(now.codes.sensor)),
        ),
        ("latency_samples", json!(now.latency)),
        ("played", json!(now.played)),
        ("misses", json!(now.misses)),
        ("underruns", json!(now.underruns)),
        ("limited", json!(now.limited)),
        ("dropped", json!(now.dropped)),
        ("bad_frames", json!(now.bad_frames)),
    ])
}

/// Named values as JSON.
pub fn object(fields: Vec<(&'static str, Value)>) -> Value {
    let named = fields.into_iter();
    Value::Object(
        named
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
    )
}

/// A value without quotes.
pub fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => "-".to_owned(),
        Value::Number(number) => match number.as_f64() {
            Some(float) if number.is_f64() => format!("{float:.4}"),
            _ => number.to_string(),
        },
        other => other.to_string(),
    }
}
