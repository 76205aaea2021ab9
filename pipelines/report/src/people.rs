//! Sentences on whom the data are about and where they come from.

use std::collections::BTreeMap;
use zwidth_study::Source;
use zwidth_tables::Measured;

/// `1 sweep`, `3 sweeps`.
pub(crate) fn count(n: usize, noun: &str) -> String {
    counted(n, noun, &format!("{noun}s"))
}

/// `1 trial that counts`, `3 trials that count`.
pub(crate) fn counting(trials: usize) -> String {
    counted(trials, "trial that counts", "trials that count")
}

/// A number with the words for one or for several.
pub(crate) fn counted(n: usize, one: &str, several: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { several })
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
    match present.as_slice() {
        [] => None,
        [(source, _)] if source.is_simulated() => {
            let mark = Some("All data are simulated: nothing here was measured.");
            Some(Origins { mark, text: String::new() })
        }
        [(source, _)] => {
            Some(Origins { mark: None, text: format!("All data were {}.", origin(*source)) })
        }
        several => {
            let total: usize = several.iter().map(|(_, n)| n).sum();
            let parts: Vec<String> =
                several.iter().map(|(s, n)| format!("{n} {}", origin(*s))).collect();
            let text = format!("Of {total} recordings: {}.", parts.join(", "));
            let simulated = several.iter().any(|(s, _)| s.is_simulated());
            Some(Origins { mark: simulated.then_some("Some data are simulated."), text })
        }
    }
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
    fn one_thing_is_not_many() {
        assert_eq!(count(1, "session"), "1 session");
        assert_eq!(count(0, "session"), "0 sessions");
        assert_eq!(counting(1), "1 trial that counts");
        assert_eq!(counting(2), "2 trials that count");
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
