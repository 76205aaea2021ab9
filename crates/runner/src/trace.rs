//! What a file was made from, back to files that no job makes: what the records say, not what a
//! plan would guess.

use crate::Records;
use crate::record::Record;
use serde::Serialize;
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::sync::Arc;

/// A file as a job read it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Source {
    /// The file, relative to the root.
    pub path: String,
    /// BLAKE3 of its content then.
    pub blake3: String,
}

/// A job behind a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step<'r> {
    /// The job's name.
    pub job: &'r str,
    /// The record of its last success.
    pub record: Arc<Record>,
}

/// Everything behind a job's outputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trace<'r> {
    /// The job itself, then the jobs whose outputs it read, nearest first, each once.
    pub steps: Vec<Step<'r>>,
    /// The files in which the chain ends, because no job makes them, sorted.
    pub sources: Vec<Source>,
    /// Files read on the way whose job has made them with another content since: there is no longer
    /// a record of the contents that were read, and the chain ends there. Sorted.
    pub lost: Vec<Source>,
}

/// Everything behind the outputs of the job of that name; `None` if there is no record of it.
pub fn trace<'r>(records: &'r Records, job: &str) -> Option<Trace<'r>> {
    // The job that made each file, and with which content.
    let mut makers: HashMap<String, (&str, String)> = HashMap::new();
    for (job, record) in records.iter() {
        let outputs = Arc::unwrap_or_clone(record).outputs.into_iter();
        makers.extend(outputs.map(|(path, hash)| (path, (job, hash))));
    }
    let (first, _) = records.0.get_key_value(job)?;
    let mut waiting = VecDeque::from([first.as_str()]);
    let mut seen = BTreeSet::from([first.as_str()]);
    let mut steps = Vec::new();
    let mut sources = BTreeSet::new();
    let mut lost = BTreeSet::new();
    while let Some(job) = waiting.pop_front() {
        let step = Step { job, record: records.get(job)? };
        // What was missing when the job was made did not enter it.
        let read = step.record.inputs.iter().chain(&step.record.origins);
        for (path, blake3) in read.filter(|(_, hash)| !hash.is_empty()) {
            let maker = makers.get(path);
            match maker {
                Some((maker, output)) if output == blake3 => {
                    if seen.insert(*maker) {
                        waiting.push_back(*maker);
                    }
                }
                _ => {
                    let ends = if maker.is_some() { &mut lost } else { &mut sources };
                    ends.insert(Source { path: path.clone(), blake3: blake3.clone() });
                }
            }
        }
        steps.push(step);
    }
    Some(Trace { steps, sources: sources.into_iter().collect(), lost: lost.into_iter().collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::Kept;

    fn record(inputs: &[(&str, &str)], output: (&str, &str)) -> Record {
        let map = |files: &[(&str, &str)]| {
            files.iter().map(|(p, h)| ((*p).into(), (*h).into())).collect()
        };
        Record { inputs: map(inputs), outputs: map(&[output]), ..Record::default() }
    }

    /// raw a, b → mean; raw a, mean → figure → page, beside a file that was missing.
    fn records() -> Records {
        let jobs = [
            ("mean", record(&[("raw/a", "1"), ("raw/b", "2")], ("mean", "3"))),
            ("figure", record(&[("raw/a", "1"), ("mean", "3")], ("figure", "4"))),
            ("page", record(&[("figure", "4"), ("gone", "")], ("page", "5"))),
        ];
        Records(
            jobs.into_iter().map(|(name, record)| (name.to_owned(), Kept::here(record))).collect(),
        )
    }

    fn paths(sources: &[Source]) -> Vec<&str> {
        sources.iter().map(|s| s.path.as_str()).collect()
    }

    #[test]
    fn the_chain_goes_back_to_what_no_job_makes() {
        let records = records();
        let trace = trace(&records, "page").unwrap();
        let jobs: Vec<&str> = trace.steps.iter().map(|s| s.job).collect();
        assert_eq!(jobs, ["page", "figure", "mean"]);
        assert_eq!(paths(&trace.sources), ["raw/a", "raw/b"]);
        assert!(trace.lost.is_empty());
    }

    #[test]
    fn a_content_that_was_replaced_since_is_told_and_not_guessed() {
        let mut records = records();
        let other = record(&[("raw/c", "7")], ("mean", "8"));
        records.0.insert("mean".to_owned(), Kept::here(other));
        let trace = trace(&records, "figure").unwrap();
        assert_eq!(trace.lost, [Source { path: "mean".to_owned(), blake3: "3".to_owned() }]);
        assert_eq!(paths(&trace.sources), ["raw/a"], "not raw/c: the figure did not see it");
        assert_eq!(super::trace(&records, "nothing"), None);
    }
}
