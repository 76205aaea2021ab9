//! What a run would find now: for each job, why it would be made again. Nothing is made.

use crate::change::{Change, How, changes};
use crate::hashes::Hashes;
use crate::plan::{levels, with_needs};
use crate::record::Record;
use crate::{Job, Records};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// Whether a run would make a job again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Again {
    /// Nothing that it depends on differs.
    No,
    /// A run would make it again.
    Yes,
    /// Only if an input that is made again first comes out with another content.
    IfInputsDiffer,
}

/// A job as a run would find it now.
pub struct State<'j> {
    /// The job.
    pub job: &'j Job,
    /// Everything that differs from the record of its last success.
    pub changes: Vec<Change>,
}

impl State<'_> {
    /// Whether a run would make the job again.
    pub fn again(&self) -> Again {
        match self.changes.as_slice() {
            [] => Again::No,
            changes if changes.iter().all(is_open) => Again::IfInputsDiffer,
            _ => Again::Yes,
        }
    }
}

/// Whether a change is known for certain only once an input was made again.
fn is_open(change: &Change) -> bool {
    matches!(change, Change::Input(file) if file.how == How::ToBeMade)
}

/// The chosen jobs, and those whose outputs they need, however far back, as a run would find them:
/// those that others need first.
pub fn states<'j>(
    jobs: &'j [Job],
    root: &Path,
    records: &Records,
    chosen: impl Fn(&Job) -> bool + Sync,
) -> Vec<State<'j>> {
    states_by(&Hashes::default(), jobs, root, records, chosen)
}

/// The same, with the hashes that are known already.
pub(crate) fn states_by<'j>(
    hashes: &Hashes,
    jobs: &'j [Job],
    root: &Path,
    records: &Records,
    chosen: impl Fn(&Job) -> bool + Sync,
) -> Vec<State<'j>> {
    let wanted = with_needs(jobs, chosen);
    let mut states = Vec::new();
    for level in levels(jobs, &wanted) {
        let of_level = level.into_par_iter().map(|i| {
            let job = &jobs[i];
            let now = Record::now(job, root, hashes);
            let before = records.get(&job.name);
            State { job, changes: changes(before.as_deref(), &now, &hashes.of(root, &job.outputs)) }
        });
        let of_level: Vec<State> = of_level.collect();
        // After the whole level and before the next, whose jobs read these outputs.
        for state in of_level.iter().filter(|s| !s.changes.is_empty()) {
            hashes.forget(&state.job.outputs);
        }
        states.extend(of_level);
    }
    states
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Made, Options, Results, Stage, run};
    use std::fs;
    use zwidth_store::{Layout, RealFiles};

    /// a → A → AA, each made from the one before in capitals.
    fn jobs(root: &Path) -> Vec<Job> {
        let job = |name: &'static str, input: &str, output: &str| {
            let (stage, outputs) = (Stage { name, version: 1 }, vec![root.join(output)]);
            Job::new(stage, name, (), root.join(input), outputs, |(), input, _| {
                let text = fs::read_to_string(input)?.to_uppercase();
                Ok(Made::of(vec![text.into_bytes()]))
            })
        };
        vec![job("second", "A", "AA"), job("first", "a", "A")]
    }

    fn again(layout: &Layout) -> Vec<(&'static str, Again)> {
        let jobs = jobs(&layout.derived());
        let (records, _) = Records::read(&Results::new(layout, &RealFiles)).unwrap();
        let found = states(&jobs, layout.root(), &records, |job| job.stage.name == "second");
        found.iter().map(|state| (state.job.stage.name, state.again())).collect()
    }

    #[test]
    fn a_state_tells_what_a_run_would_make_for_certain_and_what_perhaps() {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        let root = layout.derived();
        fs::create_dir_all(&root).unwrap();
        fs::write(root.join("a"), "x").unwrap();
        assert_eq!(again(&layout), [("first", Again::Yes), ("second", Again::Yes)]);
        run(&jobs(&root), &Results::new(&layout, &RealFiles), &Options::default(), &|_| {})
            .unwrap();
        assert_eq!(again(&layout), [("first", Again::No), ("second", Again::No)]);
        fs::write(root.join("a"), "X").unwrap();
        assert_eq!(again(&layout), [("first", Again::Yes), ("second", Again::IfInputsDiffer)]);
        fs::remove_file(root.join("AA")).unwrap();
        assert_eq!(again(&layout)[1], ("second", Again::Yes), "whatever comes out of the first");
        assert_eq!(fs::read_to_string(root.join("A")).unwrap(), "X", "nothing was made");
    }
}
