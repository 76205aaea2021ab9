//! What an executor does with a task: it fetches the raw files into a scratch folder, plans the
//! study as it finds it there, and runs the jobs asked for, as any run does.

use crate::pack::{pack, unpack};
use crate::source::Source;
use crate::task::{Answer, MOST_PACKED, Task};
use anyhow::{Context as _, anyhow, bail, ensure};
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Duration;
use zwidth_plan as plan;
use zwidth_runner::{Job, Options, PROGRAM, Records, Results, run};
use zwidth_store::{Findings, Layout, RealFiles, StudyData, hex_blake3};

/// What an executor has for its tasks.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Means {
    /// Where its scratch folders are.
    pub(crate) scratch: PathBuf,
    /// How long the place where recordings lie may be silent.
    pub(crate) store_timeout: Duration,
}

/// The answer to a packed task, packed. Whatever goes wrong is an answer too: an error would only
/// make the scheduler try the same again.
pub(crate) fn answer(task: &[u8], means: &Means) -> Vec<u8> {
    let made = catch_unwind(AssertUnwindSafe(|| made(task, means)));
    let made =
        made.unwrap_or_else(|_| Err(anyhow!("it has a defect and stopped; please report it")));
    made.unwrap_or_else(|error| {
        pack(&Answer::Refused(format!("{error:#}")), &[]).unwrap_or_default()
    })
}

fn made(task: &[u8], means: &Means) -> anyhow::Result<Vec<u8>> {
    let (task, given): (Task, _) = unpack(task).context("the task cannot be read")?;
    ensure!(
        task.zwidth == PROGRAM,
        "this executor is zwidth {PROGRAM} and the client zwidth {}; use the same version on all machines",
        task.zwidth
    );
    let folder = tempfile::tempdir_in(&means.scratch)
        .with_context(|| format!("there is no scratch folder in {}", means.scratch.display()))?;
    let layout = Layout::new(folder.path(), task.study.parse().map_err(|e| anyhow!("{e}"))?);
    fetch(&task, folder.path(), means.store_timeout)?;
    lay_given(&task, &given, &layout)?;
    let data = StudyData::load(&layout).map_err(|found| {
        anyhow!("{}", found.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
    })?;
    let jobs = asked(plan::jobs(&data, &Findings::default()), &task)?;
    let results = Results::new(&layout, &RealFiles);
    run(&jobs, &results, &Options::default(), &|_| {})?;
    let (records, _) = Records::read(&results)?;
    packed(&task, records, folder.path())
}

/// Fetches the raw files, and holds each against what the client has.
fn fetch(task: &Task, root: &Path, store_timeout: Duration) -> anyhow::Result<()> {
    let below = format!("raw/{}/", task.study);
    let outside = task.raw.iter().find(|file| !is_below(&file.path, &below));
    if let Some(file) = outside {
        bail!("{:?} is not a raw file of {}", file.path, task.study);
    }
    let source = Source::open(&task.source, store_timeout)?;
    let check = |path: &str, bytes: &[u8]| {
        let expected = task.raw.iter().find(|file| file.path == path).map(|file| &file.blake3);
        ensure!(
            expected == Some(&hex_blake3(bytes)),
            "{path} is another file in {} than on the client; give both the same recordings",
            task.source
        );
        Ok(())
    };
    let paths = task.raw.iter().map(|file| file.path.as_str());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let fetched = runtime.block_on(source.fetch(paths, root, check));
    // A disk that is silent is not waited for.
    runtime.shutdown_background();
    fetched
}

/// Writes the derived files that came with the task.
fn lay_given(task: &Task, given: &[Vec<u8>], layout: &Layout) -> anyhow::Result<()> {
    ensure!(task.given.len() == given.len(), "the task does not have the files that it names");
    let below = format!("derived/{}/", task.study);
    for (path, bytes) in task.given.iter().zip(given) {
        ensure!(is_below(path, &below), "{path:?} is not a result of {}", task.study);
        let to = layout.root().join(path);
        std::fs::create_dir_all(to.parent().unwrap_or(layout.root()))?;
        std::fs::write(&to, bytes)?;
    }
    Ok(())
}

/// Whether a path leads down from a folder, and stays below it.
fn is_below(path: &str, folder: &str) -> bool {
    let is_plain = |part: &str| !matches!(part, "" | "." | "..") && !part.contains(['\\', ':']);
    path.strip_prefix(folder).is_some_and(|rest| rest.split('/').all(is_plain))
}

/// The jobs of the plan that were asked for.
fn asked(jobs: Vec<Job>, task: &Task) -> anyhow::Result<Vec<Job>> {
    let names: BTreeSet<&str> = task.jobs.iter().map(String::as_str).collect();
    let jobs: Vec<Job> = jobs.into_iter().filter(|job| names.contains(job.name.as_str())).collect();
    ensure!(
        jobs.len() == names.len(),
        "the executor plans other jobs than the client: this is a defect of zwidth; please report it"
    );
    Ok(jobs)
}

fn packed(task: &Task, records: Records, root: &Path) -> anyhow::Result<Vec<u8>> {
    let files: Vec<String> = records.outputs().map(|(path, _)| path).collect();
    let read = |path: &String| {
        std::fs::read(root.join(path)).with_context(|| format!("{path} cannot be read"))
    };
    let contents = files.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let packed = pack(&Answer::Made { records, files }, &contents)?;
    ensure!(
        packed.len() <= MOST_PACKED,
        "the results of {} have {} bytes, and {MOST_PACKED} fit into a message; share this study out with \
         `zwidth run {} --shard I/N`",
        task.part,
        packed.len(),
        task.study
    );
    Ok(packed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(task: &[u8]) -> String {
        let scratch = tempfile::tempdir().unwrap();
        let store_timeout = Duration::from_secs(1);
        let means = Means { scratch: scratch.path().to_owned(), store_timeout };
        let (answer, _) = unpack(&answer(task, &means)).unwrap();
        match answer {
            Answer::Refused(why) => why,
            Answer::Made { .. } => panic!("something was made"),
        }
    }

    fn task() -> Task {
        Task {
            zwidth: PROGRAM.to_owned(),
            study: "s".to_owned(),
            part: "P01.S01.a.b".to_owned(),
            jobs: vec!["metrics P01 S01 a b".to_owned()],
            source: "file:///".to_owned(),
            raw: Vec::new(),
            given: Vec::new(),
        }
    }

    #[test]
    fn a_task_that_cannot_be_read_or_is_of_another_version_is_refused_in_words() {
        assert!(refusal(b"no task").contains("the task cannot be read"));
        assert!(refusal(b"").contains("the task cannot be read"));
        let other = Task { zwidth: "0.0.9".to_owned(), ..task() };
        assert!(refusal(&pack(&other, &[]).unwrap()).contains("the client zwidth 0.0.9"));
        assert!(refusal(&pack(&task(), &[]).unwrap()).contains("study.toml"));
    }

    #[test]
    fn nothing_is_read_or_written_outside_of_the_studys_folders() {
        let raw =
            |path: &str| crate::task::RawFile { path: path.to_owned(), blake3: String::new() };
        for path in ["etc/passwd", "raw/s/../../etc/passwd", "raw/t/study.toml", "/etc/passwd"] {
            let task = Task { raw: vec![raw(path)], ..task() };
            let why = refusal(&pack(&task, &[]).unwrap());
            assert!(why.contains("is not a raw file of s"), "{why}");
        }
        for path in ["raw/s/study.toml", "derived/s/../x", "derived/s/a:b", "derived/s/"] {
            let task = Task { given: vec![path.to_owned()], ..task() };
            let why = refusal(&pack(&task, &[Vec::new()]).unwrap());
            assert!(why.contains("is not a result of s"), "{why}");
        }
    }
}
