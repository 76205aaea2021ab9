//! Sentences on whom the data are about and where they come from.

use std::collections::BTreeMap;
use zwidth_study::{Source, counted};
use zwidth_tables::Measured;

/// Participants, sessions, trials that count and sweeps in words, as far as there are any.
pub(crate) fn amounts(counts: [usize; 4], sweeps: &str) -> Vec<String> {
    let trials = "trials that count";
    let units = ["participants", "sessions", trials, sweeps];
    let present = counts.into_iter().zip(units).filter(|(n, _)| *n > 0);
    let words = present.map(|(n, units)| match n {
        1 if units == trials => "1 trial that counts".to_owned(),
        _ => counted(n, units),
    });
    words.collect()
}

/// A text whose first letter is large.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// With one participant, nothing is known of anybody else.
pub(crate) fn participants(n: usize) -> Option<String> {
    (n == 1).then(|| "Every number here describes this one participant and nobody else.".to_owned())
}

/// Where the data come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Origins {
    /// What must stand out: that all or some of them are simulated.
    pub(crate) mark: Option<&'static str>,
    /// The rest.
    pub(crate) text: String,
}

/// Where the data come from; `None` where there are none.
pub(crate) fn sources(sources: &BTreeMap<Source, usize>) -> Option<Origins> {
    let present: Vec<(Source, usize)> =
        sources.iter().map(|(s, n)| (*s, *n)).filter(|(_, n)| *n > 0).collect();
    let (mark, text) = match present.as_slice() {
        [] => return None,
        [(source, _)] if source.is_simulated() => {
            (Some("All data are simulated: nothing here was measured."), String::new())
        }
        [(source, _)] => (None, format!("All data were {}.", origin(*source))),
        several => {
            let total: usize = several.iter().map(|(_, n)| n).sum();
            let parts: Vec<String> =
                several.iter().map(|(s, n)| format!("{n} {}", origin(*s))).collect();
            let simulated = several.iter().any(|(s, _)| s.is_simulated());
            let mark = simulated.then_some("Some data are simulated.");
            (mark, format!("Of {total} recordings: {}.", parts.join(", ")))
        }
    };
    Some(Origins { mark, text })
}

/// Whether any of the trials is simulated.
pub(crate) fn simulated(metrics: &Measured) -> bool {
    metrics.trials().iter().any(|trial| trial.source.is_simulated())
}

fn origin(source: Source) -> &'static str {
    match source {
        Source::Recorded => "recorded on the device",
        Source::Twin => "simulated",
        Source::Imported => "recorded by another program and imported",
        Source::Simulated => "simulated by another program and imported",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_not_many_and_nothing_is_not_told() {
        assert_eq!(amounts([1, 0, 1, 0], "sweeps"), ["1 participant", "1 trial that counts"]);
        let words = amounts([0, 2, 2, 1], "sweeps");
        assert_eq!(words, ["2 sessions", "2 trials that count", "1 sweep"]);
    }

    #[test]
    fn the_sources_of_mixed_data_are_counted() {
        let told = sources(&BTreeMap::from([
            (Source::Recorded, 30),
            (Source::Twin, 10),
            (Source::Imported, 0),
        ]));
        let text = "Of 40 recordings: 30 recorded on the device, 10 simulated.".to_owned();
        assert_eq!(told, Some(Origins { mark: Some("Some data are simulated."), text }));
        let text = "All data were recorded by another program and imported.".to_owned();
        let told = sources(&BTreeMap::from([(Source::Imported, 3)]));
        assert_eq!(told, Some(Origins { mark: None, text }));
    }
}
