//! Parts of a study that an engine makes elsewhere: which parts are due, and how the returned
//! results become a shard that can be merged.

use crate::hashes::Hashes;
use crate::manifest::Manifest;
use crate::shard::{ready, up_to_date};
use crate::{HashesRead, Job, Records, Results, Shard};
use std::collections::BTreeMap;
use zwidth_store::StoreError;

/// The results of a part that were made elsewhere.
#[derive(Debug, Clone, Default)]
pub struct Sent {
    /// The records of its jobs.
    pub records: Records,
    /// Each file, by its path relative to the root, and its content.
    pub files: Vec<(String, Vec<u8>)>,
}

/// The jobs of each part ([`Job::part`]) that are not up to date and can be made now by making this
/// part alone: their inputs are raw, up to date, or made by another of them. `known` are hashes of
/// files that were read already.
///
/// # Errors
/// A link on the way to the study's records.
pub fn due<'j>(
    jobs: &'j [Job],
    results: &Results,
    known: &HashesRead,
) -> Result<BTreeMap<&'j str, Vec<&'j Job>>, StoreError> {
    let (records, _) = Records::read(results)?;
    let root = results.root();
    let hashes = Hashes::seen(known, Default::default());
    let current = up_to_date(jobs, |job| job.part.is_some(), root, &records, &hashes);
    let ready = ready(jobs, |job| job.part.clone(), &current);
    let mut due: BTreeMap<&str, Vec<&Job>> = BTreeMap::new();
    for ((job, ready), current) in jobs.iter().zip(ready).zip(current) {
        if let (Some(part), true, false) = (&job.part, ready.is_some(), current) {
            due.entry(part).or_default().push(job);
        }
    }
    Ok(due)
}

/// Writes the results of a part that were made elsewhere: its files, then the manifest of its
/// shard, which also has the shard's earlier parts. Nothing of it is trusted until it is merged.
///
/// # Errors
/// A file that is not a result of the study; a write that failed.
pub fn lay_down(sent: Sent, shard: Shard, results: &Results) -> Result<(), StoreError> {
    for (path, bytes) in &sent.files {
        let file = Results::named(results.layout(), path).map_err(|why| {
            let what = format!("{path:?} is no result of the study: {why}");
            StoreError::new(results.root(), what, "make this part on this machine")
        })?;
        results.write(&file, bytes)?;
    }
    // After the files: a manifest must not name what is not there yet.
    let before = Manifest::read(results, shard)?.and_then(|existing| existing.manifest.ok());
    let mut records = before.map(|manifest| manifest.records).unwrap_or_default();
    records.0.extend(sent.records.0);
    Manifest::new(results.layout(), shard, records).write(results)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Made, Options, Stage, merge, run};
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::sync::Arc;
    use zwidth_store::{Layout, RealFiles};

    fn layout(folder: &Path) -> Layout {
        let layout = Layout::new(folder, "s".parse().unwrap());
        fs::create_dir_all(layout.raw()).unwrap();
        ["a", "b"].iter().for_each(|part| fs::write(layout.raw().join(part), part).unwrap());
        layout
    }

    /// Two parts with two jobs each, of which the second reads the first's output and another
    /// part's.
    fn jobs(layout: &Layout) -> Vec<Job> {
        let (raw, derived) = (layout.raw(), layout.derived());
        let job = |name: String, part: &str, inputs: Vec<PathBuf>, output: String| {
            let (stage, outputs) = (Stage { name: "s", version: 1 }, vec![derived.join(output)]);
            let job = Job::new(stage, name, (), inputs, outputs, |(), inputs, _| {
                let texts: Result<Vec<_>, _> = inputs.iter().map(fs::read).collect();
                Ok(Made::of(vec![texts?.concat()]))
            });
            job.of_part(part)
        };
        let own = |p: &str| job(format!("own {p}"), p, vec![raw.join(p)], p.to_owned());
        let copy =
            |p: &str| job(format!("copy {p}"), p, vec![derived.join(p)], format!("{p}.copy"));
        let both = ["a.copy", "b.copy"].map(|name| derived.join(name)).to_vec();
        let last = job("both".to_owned(), "a", both, "both".to_owned());
        vec![last, own("a"), own("b"), copy("a"), copy("b")]
    }

    fn names<'j>(due: &BTreeMap<&'j str, Vec<&'j Job>>) -> Vec<(&'j str, Vec<&'j str>)> {
        let of = |jobs: &Vec<&'j Job>| jobs.iter().map(|job| job.name.as_str()).collect();
        due.iter().map(|(part, jobs)| (*part, of(jobs))).collect()
    }

    #[test]
    fn a_part_is_due_as_far_as_it_needs_no_other_and_what_was_laid_down_of_it_is_merged() {
        let [home, away, between] = [(); 3].map(|()| tempfile::tempdir().unwrap());
        let [home, away, between] = [&home, &away, &between].map(|folder| layout(folder.path()));
        let planned = jobs(&home);
        let own = Results::new(&home, &RealFiles);
        let first = due(&planned, &own, &HashesRead::default()).unwrap();
        assert_eq!(names(&first), [("a", vec!["own a", "copy a"]), ("b", vec!["own b", "copy b"])]);
        // Both parts are one shard's, and are sent one by one.
        let shard = Shard::new(1, 1).unwrap();
        let laid = [Results::new(&between, &RealFiles)];
        for part in ["a", "b"] {
            let work: Vec<Job> = jobs(&away)
                .into_iter()
                .filter(|job| job.part.as_deref() == Some(part) && job.name != "both")
                .collect();
            let results = Results::new(&away, &RealFiles);
            run(&work, &results, &Options::default(), &|_| {}).unwrap();
            let records = Records::read(&results).unwrap().0;
            let paths: Vec<String> = records.outputs().map(|(path, _)| path).collect();
            let read = |path: String| (path.clone(), fs::read(away.root().join(path)).unwrap());
            lay_down(
                Sent { records, files: paths.into_iter().map(read).collect() },
                shard,
                &laid[0],
            )
            .unwrap();
        }
        let merged =
            merge(&planned, &own, &laid, &HashesRead::default(), &Arc::default(), &|_| {}).unwrap();
        assert_eq!((merged.shards, merged.jobs), (BTreeSet::from([shard]), 4));
        assert_eq!(
            names(&due(&planned, &own, &HashesRead::default()).unwrap()),
            [("a", vec!["both"])]
        );
    }

    #[test]
    fn a_file_elsewhere_is_not_laid_down() {
        let folder = tempfile::tempdir().unwrap();
        let layout = layout(folder.path());
        let files = vec![("raw/s/a".to_owned(), b"other".to_vec())];
        let sent = Sent { files, ..Sent::default() };
        let error = lay_down(sent, Shard::new(1, 1).unwrap(), &Results::new(&layout, &RealFiles));
        assert!(error.unwrap_err().to_string().contains("is no result of the study"));
        assert_eq!(fs::read_to_string(layout.raw().join("a")).unwrap(), "a");
    }
}
