//! Merging: the union of the records of shards whose keys are those of the study as it is, and of
//! their files if these are elsewhere.

use crate::manifest::folder;
use crate::survey::{Share, Survey, content, survey};
use crate::{HashesRead, Job, Results, Shard};
use std::collections::BTreeSet;
use std::sync::Arc;
use zwidth_store::{Seen, StoreError, hex_blake3};

/// The outcome of a merge.
pub struct Merged<'r, 'j> {
    /// The present shards, and which were refused, and why.
    pub survey: Survey<'r>,
    /// The shards that were merged.
    pub shards: BTreeSet<Shard>,
    /// How many jobs were merged.
    pub jobs: usize,
    /// How many files were copied from other roots.
    pub copied: usize,
    /// What the shards were to make.
    pub shares: Vec<Share<'j>>,
}

/// Merges the shards whose results are in the study's own folder or in those of other roots.
///
/// First files of other roots are copied, then the records are written, and only then are the
/// manifests in the study's own folder removed, because the records now say the same. So a merge
/// that was killed at any point can be done again. Nothing is changed in other roots.
///
/// `progress` is called after each job that was compared with its results and each file that was
/// copied, with the number of both.
///
/// # Errors
/// A run of the study is still going on in its folder; a file that cannot be copied; records that
/// cannot be written.
pub fn merge<'r, 'j>(
    jobs: &'j [Job],
    own: &'r Results<'r>,
    others: &'r [Results<'r>],
    known: &HashesRead,
    seen: &Arc<Seen>,
    progress: &dyn Fn(usize),
) -> Result<Merged<'r, 'j>, StoreError> {
    let _lock = own.hold_alone()?;
    let mut survey = survey(jobs, own, others, known, seen, progress)?;
    let steps = survey.steps;
    // Before files are copied that other jobs wait for.
    let shares = survey.shares(jobs, None);
    let mut shards = BTreeSet::new();
    let mut jobs = BTreeSet::new();
    let mut copied = 0;
    for offer in &survey.accepted {
        let records = &offer.manifest.records;
        // What lies here already is not copied, and its records are not read for that.
        let to_copy = (!offer.is_own).then(|| records.outputs()).into_iter().flatten();
        for (path, hash) in to_copy {
            // Hashed again: minutes may lie between the survey and the copy.
            let bytes = match content(offer.results, &path) {
                Ok(bytes) if hex_blake3(&bytes) == hash => Ok(bytes),
                Ok(_) => Err("it has changed since the merge began".to_owned()),
                Err(why) => Err(why),
            };
            let bytes = bytes.map_err(|what| {
                StoreError::new(&offer.results.root().join(&path), what, "merge again")
            })?;
            own.write(&own.root().join(&path), &bytes)?;
            copied += 1;
            progress(steps);
        }
        survey.records.0.extend(records.0.clone());
        shards.insert(offer.manifest.shard);
        jobs.extend(records.0.keys().cloned());
    }
    if !shards.is_empty() {
        survey.records.write(own)?;
    }
    for offer in survey.accepted.iter().filter(|offer| offer.is_own) {
        // One that stays is merged again the next time.
        survey.remarks.extend(own.remove_made(&offer.path, &offer.blake3).err());
    }
    own.remove_empty(&folder(own.layout()));
    Ok(Merged { survey, shards, jobs: jobs.len(), copied, shares })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JobEnd, Made, Options, Records, Stage, run};
    use std::cell::RefCell;
    use std::fs;
    use std::path::PathBuf;
    use tempfile::TempDir;
    use zwidth_store::{Layout, RealFiles};

    fn none() -> HashesRead {
        HashesRead::default()
    }

    /// A study of three parts: each has a job of its own, and one that reads besides what all give.
    struct World {
        _folder: TempDir,
        layout: Layout,
    }

    impl World {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let layout = Layout::new(folder.path(), "s".parse().unwrap());
            fs::create_dir_all(layout.raw()).unwrap();
            for part in ["a", "b", "c"] {
                fs::write(layout.raw().join(part), part).unwrap();
            }
            Self { _folder: folder, layout }
        }

        fn jobs(&self) -> Vec<Job> {
            let (raw, derived) = (self.layout.raw(), self.layout.derived());
            let job = |name: String, inputs: Vec<PathBuf>, output: &str| {
                let stage = Stage { name: "s", version: 1 };
                Job::new(stage, name, (), inputs, vec![derived.join(output)], |(), inputs, _| {
                    let texts: Result<Vec<_>, _> = inputs.iter().map(fs::read).collect();
                    Ok(Made::of(vec![texts?.concat()]))
                })
            };
            let parts = ["a", "b", "c"];
            let own = |p: &str| job(format!("own {p}"), vec![raw.join(p)], p).of_part(p);
            let all = parts.iter().map(|p| derived.join(p)).collect();
            let after = |p: &str| {
                let inputs = vec![derived.join(p), derived.join("all")];
                job(format!("after {p}"), inputs, &format!("after {p}")).of_part(p)
            };
            let mut jobs: Vec<Job> = parts.iter().map(|p| after(p)).collect();
            jobs.push(job("all".to_owned(), all, "all"));
            jobs.extend(parts.iter().map(|p| own(p)));
            jobs
        }

        fn results(&self) -> Results<'_> {
            Results::new(&self.layout, &RealFiles)
        }

        /// Names of what a run makes, of a shard or of the whole.
        fn run(&self, shard: Option<&str>) -> Vec<String> {
            let shard = shard.map(|shard| shard.parse().unwrap());
            let options = Options { shard, ..Options::default() };
            let done = run(&self.jobs(), &self.results(), &options, &|_| {}).unwrap();
            let made = done.reports.into_iter().filter(|r| matches!(r.verdict, JobEnd::Made(_)));
            let mut names: Vec<String> = made.map(|report| report.name).collect();
            names.sort();
            names
        }

        fn merge(&self, others: &[Results]) -> (usize, Vec<String>) {
            let (jobs, own) = (self.jobs(), self.results());
            let merged = merge(&jobs, &own, others, &none(), &Arc::default(), &|_| {}).unwrap();
            let refused = merged.survey.refused.iter().map(ToString::to_string).collect();
            (merged.jobs, refused)
        }

        fn shards(&self) -> PathBuf {
            folder(&self.layout)
        }
    }

    #[test]
    fn a_shard_leaves_the_records_alone_and_merged_shards_leave_nothing_but_them() {
        let world = World::new();
        let mut made: Vec<String> =
            (1..=3).flat_map(|i| world.run(Some(&format!("{i}/3")))).collect();
        made.sort();
        assert_eq!(made, ["own a", "own b", "own c"]);
        assert!(!Results::records_file(&world.layout).exists());
        assert!(world.run(Some("1/3")).is_empty(), "by its manifest");
        assert_eq!(world.merge(&[]), (3, Vec::new()));
        assert!(!world.shards().exists());
        assert_eq!(world.run(None), ["after a", "after b", "after c", "all"]);
        let (whole, other) = (World::new(), Records::read(&world.results()).unwrap().0);
        whole.run(None);
        assert_eq!(Records::read(&whole.results()).unwrap().0, other, "as after one run");
    }

    #[test]
    fn in_a_second_round_shards_make_what_needed_all_of_the_first() {
        let world = World::new();
        world.run(Some("1/1"));
        world.merge(&[]);
        let options = Options { only: Some("all".to_owned()), ..Options::default() };
        run(&world.jobs(), &world.results(), &options, &|_| {}).unwrap();
        assert_eq!(world.run(Some("1/1")), ["after a", "after b", "after c"]);
        assert_eq!(world.merge(&[]), (6, Vec::new()));
        assert!(world.run(None).is_empty());
    }

    #[test]
    fn after_a_change_shards_make_what_it_changed_and_are_not_refused_for_what_rests_on_it() {
        let world = World::new();
        world.run(None);
        fs::write(world.layout.raw().join("a"), "A").unwrap();
        let made: Vec<String> = (1..=3).flat_map(|i| world.run(Some(&format!("{i}/3")))).collect();
        assert_eq!(made, ["own a"]);
        assert_eq!(world.merge(&[]), (3, Vec::new()));
        assert_eq!(world.run(None), ["after a", "after b", "after c", "all"]);
    }

    /// Somebody took part back: the shard is refused, made again, and then nothing of it is left.
    #[test]
    fn what_a_shard_made_of_a_part_that_is_gone_goes_when_it_is_run_again() {
        let world = World::new();
        world.run(Some("1/1"));
        let fewer: Vec<Job> = world.jobs().into_iter().filter(|job| job.name != "own a").collect();
        let results = world.results();
        let refused =
            merge(&fewer, &results, &[], &none(), &Arc::default(), &|_| {}).unwrap().survey.refused;
        let why = refused[0].to_string();
        assert!(why.contains("the study has no job \"own a\" now"), "{why}");
        assert!(why.contains(&format!("--root {} run s", world.layout.root().display())), "{why}");
        let shard = Options { shard: Some("1/1".parse().unwrap()), ..Options::default() };
        run(&fewer, &results, &Options { dry_run: true, ..shard.clone() }, &|_| {}).unwrap();
        assert!(world.layout.derived().join("a").exists());
        run(&fewer, &results, &shard, &|_| {}).unwrap();
        assert!(!world.layout.derived().join("a").exists());
        assert!(world.layout.derived().join("b").exists());
        let merged = merge(&fewer, &results, &[], &none(), &Arc::default(), &|_| {}).unwrap();
        assert_eq!((merged.jobs, merged.survey.refused), (2, Vec::new()));
    }

    #[test]
    fn a_shard_elsewhere_is_copied_and_one_that_made_something_else_of_the_same_is_refused() {
        let (world, other, liar) = (World::new(), World::new(), World::new());
        other.run(Some("1/1"));
        liar.run(Some("1/1"));
        let manifest = liar.shards().join("1-of-1.json");
        let text = fs::read_to_string(&manifest).unwrap();
        let hash = hex_blake3(b"a");
        let outputs = format!("\"outputs\":{{\"derived/s/a\":\"{hash}\"");
        assert!(text.contains(&outputs), "{text}");
        let lie = outputs.replace(&hash, &hex_blake3(b"lie"));
        fs::write(&manifest, text.replace(&outputs, &lie)).unwrap();
        fs::write(liar.layout.derived().join("a"), "lie").unwrap();
        let (jobs, refused) = world.merge(&[other.results(), liar.results()]);
        assert_eq!(jobs, 3);
        assert!(
            matches!(refused.as_slice(), [one] if one.contains("another shard made something else")),
            "{refused:?}"
        );
        assert_eq!(fs::read_to_string(world.layout.derived().join("a")).unwrap(), "a");
        assert!(other.shards().exists(), "nothing elsewhere is changed");
    }

    /// Three jobs of parts are held against the study; of those, the shard elsewhere has three files.
    #[test]
    fn progress_counts_jobs_and_copied_files_up_to_their_number() {
        let (world, other) = (World::new(), World::new());
        other.run(Some("1/1"));
        let steps = RefCell::new(Vec::new());
        let keep = |all| steps.borrow_mut().push(all);
        let (jobs, own, others) = (world.jobs(), world.results(), [other.results()]);
        let merged = merge(&jobs, &own, &others, &none(), &Arc::default(), &keep).unwrap();
        let counted = steps.take();
        assert!(counted.iter().all(|all| *all == counted.len()), "{counted:?}");
        assert_eq!((merged.copied, counted.len()), (3, jobs.len() + 3));
    }

    #[test]
    fn a_merge_waits_for_runs_and_one_that_was_cut_off_is_done_again() {
        let world = World::new();
        world.run(Some("1/1"));
        let manifest = world.shards().join("1-of-1.json");
        let text = fs::read(&manifest).unwrap();
        let (jobs, results) = (world.jobs(), world.results());
        let running = results.hold_beside_shards().unwrap();
        let error = merge(&jobs, &results, &[], &none(), &Arc::default(), &|_| {}).err().unwrap();
        assert!(
            error.to_string().contains("a run, a merge or a shard of the study goes on"),
            "{error}"
        );
        drop(running);
        assert_eq!(world.merge(&[]), (3, Vec::new()));
        // Cut off before the manifest went.
        fs::create_dir_all(world.shards()).unwrap();
        fs::write(&manifest, text).unwrap();
        assert_eq!(world.merge(&[]), (3, Vec::new()));
        assert_eq!(world.merge(&[]), (0, Vec::new()));
    }

    #[test]
    fn what_is_missing_is_told_by_shard_as_far_as_it_can_be_made() {
        let world = World::new();
        let b = Shard::of_part("b", 3).unwrap();
        for shard in Shard::all(3).filter(|shard| *shard != b) {
            world.run(Some(&shard.to_string()));
        }
        let (jobs, own) = (world.jobs(), world.results());
        let missing = |of| {
            let found = survey(&jobs, &own, &[], &none(), &Arc::default(), &|_| {}).unwrap();
            let shares = found.shares(&jobs, of).into_iter().filter(|s| !s.missing.is_empty());
            shares.map(|s| (s.shard, s.missing)).collect::<Vec<_>>()
        };
        assert!(missing(None).iter().any(|(shard, jobs)| *shard == b && jobs.contains(&"own b")));
        assert_eq!(missing(Some(1)), [(Shard::new(1, 1).unwrap(), vec!["own b"])]);
        world.run(Some(&b.to_string()));
        assert!(missing(None).is_empty());
    }
}
