//! The verdict in words.

use crate::report::format_number;

use super::diagnosis::{Diagnosis, Verdict, excess};

impl Diagnosis {
    /// What was found, in a sentence or two for the report and the terminal.
    pub fn sentence(&self) -> String {
        let names: Vec<&str> = self.effects.iter().map(|f| f.effect.name()).collect();
        let names = listed(&names);
        let (noise, source) = self.noise;
        match self.verdict {
            Verdict::Named => format!("Missing: {names}. {}", self.shrinks()),
            Verdict::Partial => {
                format!(
                    "Missing: {names}, and something more that no effect of the library explains. {}",
                    self.shrinks()
                )
            }
            Verdict::Unknown => format!(
                "Something is missing that no effect of the library explains: on the select records the \
                 baseline leaves {} beyond a noise of {}.",
                self.length(excess(
                    self.fitted_baseline().select.unwrap_or(f64::NAN),
                    noise
                )),
                self.length(noise)
            ),
            Verdict::None if self.refitted.is_some() => format!(
                "No effect is missing: with its numbers fitted anew the model leaves no more than the \
                 noise of {} ({}). {}",
                self.length(noise),
                source.describe(),
                self.shrinks()
            ),
            Verdict::None => format!(
                "Nothing is missing: the baseline leaves {} and the noise is {} ({}).",
                self.length(self.held_out().1.0),
                self.length(noise),
                source.describe()
            ),
        }
    }

    /// The rms of baseline and extended model on the records that are held out furthest, and their
    /// role.
    fn held_out(&self) -> (&'static str, (f64, f64)) {
        let (a, b) = (&self.baseline, &self.extended);
        [
            ("report", a.report, b.report),
            ("select", a.select, b.select),
            ("fit", a.fit, b.fit),
        ]
        .into_iter()
        .find_map(|(role, a, b)| Some((role, (a?, b?))))
        .unwrap_or(("fit", (f64::NAN, f64::NAN)))
    }

    fn shrinks(&self) -> String {
        let (role, (before, after)) = self.held_out();
        let closed = match self.closed() {
            Some(closed) => format!(
                ": {:.0} % of the gap beyond the noise closed",
                100.0 * closed
            ),
            None => String::new(),
        };
        format!(
            "On the {role} records the rms goes from {} to {}{closed}.",
            self.length(before),
            self.length(after)
        )
    }

    /// A length in um with its unit, in the unit of the data set.
    pub(super) fn length(&self, um: f64) -> String {
        let unit = self.unit.symbol();
        format!("{} {unit}", format_number(self.unit.from_um(um)))
    }
}

/// "a", "a and b", "a, b and c".
pub(super) fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
