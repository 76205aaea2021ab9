//! `zwidth-cluster run`: makes what is derived from trials on the cluster, part by part, and merges
//! it into the study as shards are merged.

use crate::args::Run;
use crate::engine::Engine;
use crate::say::Say;
use crate::slice::Slices;
use crate::source::url_of;
use crate::task::Answer;
use crate::watch::{until_lost, until_ready};
use crate::{Exit, joined};
use anyhow::{Context as _, anyhow, bail, ensure};
use futures::StreamExt as _;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::Runtime;
use tokio::signal::ctrl_c;
use tokio::sync::Notify;
use zwidth_plan as plan;
use zwidth_runner::{
    HashesRead, Job, Options, Results, Sent, Shard, due, lay_down, merge, run as run_jobs,
};
use zwidth_store::{Layout, RealFiles, StudyData, findings};

/// Shards in which what came back is merged: a part that must be refused takes some others with it,
/// and not all.
const SHARDS: u32 = 64;

/// Refusals that people are shown.
const SHOWN: usize = 3;

/// The stage whose results the second round needs. It takes trials of the whole study, and is one
/// job, which is made here.
const PLANT: &str = "identify";

/// How the program ends if it is interrupted while it asks nothing, as a shell has it.
const INTERRUPTED: i32 = 130;

/// What a run has to do with.
struct World<'w> {
    args: &'w Run,
    runtime: &'w Runtime,
    say: Say,
    engine: &'w Engine,
    /// Tells a round to end.
    interrupted: &'w Notify,
    data: &'w StudyData,
    jobs: &'w [Job],
    /// Hashes of raw files.
    known: HashesRead,
    results: Results<'w>,
}

/// Runs it.
///
/// # Errors
/// There is no such study, or no cluster; the cluster was lost on the way, or gave nothing.
pub(crate) fn run(args: &Run, runtime: &Runtime, say: Say) -> anyhow::Result<Exit> {
    let layout = Layout::new(&args.root, args.study.clone());
    ensure!(
        layout.study_toml().is_file(),
        "there is no study '{}': {} is missing; name the data folder with --root, or copy the recordings from an \
         object store with `zwidth-cluster fetch {} --raw s3://BUCKET/PREFIX`",
        args.study,
        layout.study_toml().display(),
        args.study
    );
    // Before the study is read, which may take long.
    runtime.block_on(until_ready(&args.scheduler, Duration::from_secs(args.patience)))?;
    let data = StudyData::load(&layout).map_err(|found| joined(&found))?;
    let jobs = plan::jobs(&data, &findings(&RealFiles, &data));
    let known = data.trials.iter().map(|trial| (trial.path.clone(), trial.blake3.clone()));
    let (known, results) = (known.collect(), Results::new(&layout, &RealFiles));
    let deadline = Duration::from_secs(args.deadline);
    let engine = Arc::new(runtime.block_on(Engine::new(&args.scheduler, deadline))?);
    let interrupted = Arc::new(Notify::new());
    runtime.spawn(notice_interrupts(Arc::clone(&engine), Arc::clone(&interrupted)));
    let (engine, interrupted) = (engine.as_ref(), interrupted.as_ref());
    let (data, jobs) = (&data, jobs.as_slice());
    World { args, runtime, say, engine, interrupted, data, jobs, known, results }.rounds()
}

/// If the program is interrupted: ends it, or the round that is asking.
async fn notice_interrupts(engine: Arc<Engine>, interrupted: Arc<Notify>) {
    while ctrl_c().await.is_ok() {
        if !engine.is_asking() {
            std::process::exit(INTERRUPTED);
        }
        interrupted.notify_waiters();
    }
}

impl World<'_> {
    /// Rounds until nothing is due: after the first one the plant can be identified, and what needs
    /// it or other parts' results is due in the next.
    fn rounds(&self) -> anyhow::Result<Exit> {
        let (mut exit, mut tried, mut is_plant_tried) = (Exit::Fine, BTreeSet::new(), false);
        loop {
            let mut due = due(self.jobs, &self.results, &self.known)?;
            due.values_mut().for_each(|jobs| jobs.retain(|job| !tried.contains(&job.name)));
            due.retain(|_, jobs| !jobs.is_empty());
            if due.is_empty() && is_plant_tried {
                return Ok(exit);
            }
            if due.is_empty() {
                is_plant_tried = true;
                self.identify()?;
                continue;
            }
            tried.extend(due.values().flatten().map(|job| job.name.clone()));
            exit = exit.max(self.round(&due)?);
        }
    }

    /// Makes parts on the cluster, and merges what came back, also if not all did.
    fn round(&self, due: &BTreeMap<&str, Vec<&Job>>) -> anyhow::Result<Exit> {
        let study = &self.args.study;
        let jobs: usize = due.values().map(Vec::len).sum();
        self.say.progress(format!(
            "{study}: {jobs} jobs of {} parts on the cluster at {}",
            due.len(),
            self.args.scheduler
        ));
        let folder = tempfile::tempdir().context("there is no folder for temporary files")?;
        let layout = Layout::new(folder.path(), study.clone());
        let laid = [Results::new(&layout, &RealFiles)];
        let asked = self.runtime.block_on(async {
            let lost = until_lost(&self.args.scheduler, Duration::from_secs(self.args.patience));
            let asked = tokio::select! {
                asked = self.ask(due, &laid[0]) => asked,
                lost = lost => Err(lost),
                () = self.interrupted.notified() => Err(anyhow!("it was interrupted")),
            };
            self.engine.take_back().await;
            asked
        });
        let merged = merge(self.jobs, &self.results, &laid, &self.known, &Arc::default(), &|_| {});
        let merged = merged.map_err(|error| {
            // Not lost for a run that went on here meanwhile.
            let kept = folder.keep();
            asked.as_ref().err().iter().for_each(|error| self.say.warn(format!("{error:#}")));
            let kept = kept.display().to_string();
            let merges = self.data.layout.command(&["merge", study.as_str(), "--from", &kept]);
            anyhow!(error)
                .context(format!("what came back of {study} is kept: `{merges}` merges it"))
        })?;
        let survey = &merged.survey;
        survey.remarks.iter().for_each(|remark| self.say.warn(remark.to_string()));
        survey.refused.iter().for_each(|error| self.say.warn(error.to_string()));
        self.say
            .progress(format!("{study}: {} of {jobs} jobs came back and are merged", merged.jobs));
        let refused = asked.with_context(|| {
            format!("what came back of {study} is merged; run it again, or without the cluster")
        })?;
        if refused > SHOWN {
            self.say.warn(format!("and {} more parts were not made", refused - SHOWN));
        }
        if refused == due.len() {
            bail!(
                "{study}: the executors could make nothing; `zwidth run {study}` makes it without them"
            );
        }
        let is_whole = refused == 0 && survey.refused.is_empty() && survey.remarks.is_empty();
        Ok(if is_whole { Exit::Fine } else { Exit::Partly })
    }

    /// Gives the parts to the engine, some at a time, and lays down what comes back; says why the
    /// first parts are refused, and counts them.
    async fn ask(
        &self,
        due: &BTreeMap<&str, Vec<&Job>>,
        laid: &Results<'_>,
    ) -> anyhow::Result<usize> {
        let raw = self.args.raw.clone().unwrap_or_else(|| self.args.root.display().to_string());
        let slices = Slices::of(self.data, url_of(&raw)?)?;
        let (slices, engine) = (&slices, self.engine);
        let asking = due.iter().map(|(part, jobs)| async move {
            let task = slices.task(part, jobs)?;
            anyhow::Ok((*part, engine.answer(part, &task).await?))
        });
        let mut asking =
            futures::stream::iter(asking).buffer_unordered(self.args.at_once.get().into());
        let mut refused = 0;
        while let Some(answered) = asking.next().await {
            let (part, (answer, contents)) = answered?;
            match answer {
                Answer::Refused(why) => {
                    refused += 1;
                    if refused <= SHOWN {
                        self.say.warn(format!("{part}: {why}"));
                    }
                }
                Answer::Made { records, files } => {
                    ensure!(files.len() == contents.len(), "{part}: the answer lacks files");
                    let shard = Shard::of_part(part, SHARDS).context("no shard")?;
                    let files = files.into_iter().zip(contents).collect();
                    lay_down(Sent { records, files }, shard, laid)?;
                }
            }
        }
        Ok(refused)
    }

    /// Identifies the plant, which takes trials of the whole study.
    fn identify(&self) -> anyhow::Result<()> {
        if !self.jobs.iter().any(|job| job.stage.name == PLANT) {
            return Ok(());
        }
        let only = Some(PLANT.to_owned());
        let options = Options { only, known: self.known.clone(), ..Options::default() };
        // What fails is told by the run that follows.
        run_jobs(self.jobs, &self.results, &options, &|_| {})?;
        Ok(())
    }
}
