//! Stage `figures`: each figure as SVG, PDF and PNG, with its data beside it.

use super::{
    JobError, Repeats, Session, average, characterise, design, freemotion, likert_figures, metrics,
    paths, read_all, replay_figures, sessions,
};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_draw::{DEFAULT_DPI, Figure, draw};
use zwidth_figures::{Characterised, ModeData, Repeat, Scene};
use zwidth_runner::{Job, Made, Provenance};
use zwidth_store::{Layout, StudyData, Trial, TrialEntry};
use zwidth_study::{Alignment, Environment, Study};
use zwidth_tables::Table;

const STAGE: &str = "figures";

/// Files of a figure: SVG, PDF, PNG, and its data.
pub(crate) fn files_of(layout: &Layout, name: &str) -> Vec<PathBuf> {
    let folder = layout.reports().join("figures");
    ["svg", "pdf", "png", "parquet"].iter().map(|e| folder.join(format!("{name}.{e}"))).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        let mut scenes: Vec<&Environment> =
            data.study.environments.iter().filter(|e| !session.of(e).is_empty()).collect();
        for environment in &scenes {
            jobs.push(modes_job(data, &session, environment));
            jobs.extend(repeats_jobs(data, &session, environment));
        }
        scenes.retain(|e| e.scene.spring().is_some());
        if !scenes.is_empty() {
            jobs.push(loops_job(data, &session, &scenes));
        }
    }
    jobs.extend(characterise::actuators(data).into_iter().map(|(actuator, files)| {
        characteristic_job(
            data,
            actuator.as_str(),
            files,
            characterise::tables_of(&data.layout, actuator),
        )
    }));
    if freemotion::jobs(data)
        .iter()
        .any(|j| j.outputs.contains(&freemotion::planes_of(&data.layout)))
    {
        jobs.push(free_motion_job(data));
    }
    jobs.extend(replay_figures::jobs(data));
    jobs.extend(likert_figures::jobs(data));
    jobs.extend(design::jobs(data));
    jobs
}

/// A figure, and what had to be left out of it.
pub(super) type Described = Result<(Figure, Vec<String>), JobError>;

/// A job that draws one figure.
pub(super) fn figure_job<'a>(
    data: &'a StudyData,
    name: &str,
    inputs: Vec<PathBuf>,
    parameters: String,
    describe: impl Fn() -> Described + Send + Sync + 'a,
) -> Job<'a> {
    let outputs = files_of(&data.layout, name);
    let (out, stem) = (outputs.clone(), name.to_owned());
    Job {
        stage: STAGE,
        name: format!("figure {name}"),
        version: zwidth_figures::VERSION,
        parameters,
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (figure, problems) = describe()?;
            Ok(Made { outputs: rendered(&stem, figure, from, &out)?, problems, ..Made::default() })
        }),
    }
}

fn rendered(
    name: &str,
    figure: Figure,
    from: &Provenance,
    out: &[PathBuf],
) -> Result<Vec<Vec<u8>>, JobError> {
    let table = zwidth_figures::data_table(name, &figure)?;
    let drawing = draw(&Figure { provenance: Some(serde_json::to_string(from)?), ..figure })?;
    let others = || -> Result<_, JobError> {
        Ok((drawing.svg()?.into_bytes(), drawing.pdf()?, table.to_parquet(from, &out[3])?))
    };
    let (image, others) = rayon::join(|| drawing.png(DEFAULT_DPI), others);
    let (svg, pdf, table) = others?;
    Ok(vec![svg, pdf, image?, table])
}

/// The choices of study.toml for figures that the study does not have (of a kind that it lacks is
/// no mistake).
pub(crate) fn chosen_in_vain(study: &Study, planned: &[Job]) -> Vec<String> {
    let name = |job: &Job| job.name.trim_start_matches("figure ").to_owned();
    let names: Vec<String> = planned.iter().filter(|j| j.stage == STAGE).map(name).collect();
    let is_of = |name: &String, id: &str| {
        name.strip_prefix(id).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let vain = study
        .figures
        .choices()
        .filter(|(id, _)| id.contains('.') && !names.iter().any(|n| is_of(n, id)));
    vain.map(|(id, _)| {
        format!("the choice figures.{id} of study.toml: the study has no such figure")
    })
    .collect()
}

/// What figures of trials depend on besides files: names, scenes, coordinate.
fn parameters(study: &Study) -> String {
    let level = study.analysis.confidence;
    format!("{:?}", (&study.title, study.coordinate, &study.environments, &study.modes, level))
}

/// Everything read for one environment of one session; figures borrow from it.
struct Loaded<'a> {
    data: &'a StudyData,
    environment: &'a Environment,
    who: String,
    trials: Vec<Trial>,
    onsets: Vec<Option<f64>>,
    /// Times of the samples on the scale of the mean, s, where that is not since onset.
    warped_s: Vec<Option<Vec<f64>>>,
    alignment: Alignment,
    averages: Vec<Option<Table>>,
    notes: Vec<String>,
}

/// What one environment of one session is read from.
#[derive(Clone)]
struct Recorded<'a> {
    data: &'a StudyData,
    environment: &'a Environment,
    who: String,
    trials: Vec<&'a TrialEntry>,
    metrics: Vec<PathBuf>,
    alignment: Alignment,
    averages: Vec<Option<PathBuf>>,
}

impl<'a> Recorded<'a> {
    /// For the figure of that name, which decides how means are aligned.
    fn new(
        data: &'a StudyData,
        session: &Session<'a>,
        environment: &'a Environment,
        figure: &str,
    ) -> Self {
        let alignment = data.study.figures.alignment(figure);
        let conditions: Vec<_> =
            data.study.modes.iter().map(|m| session.repeats(environment, m)).collect();
        let average = |repeats: &Repeats| average::aligned(&data.layout, repeats, alignment);
        let metrics = |repeats: &Repeats| metrics::of_condition(&data.layout, repeats);
        Self {
            data,
            environment,
            who: session.who(),
            trials: session.of(environment),
            metrics: conditions.iter().flatten().map(metrics).collect(),
            alignment,
            averages: conditions.iter().map(|c| c.as_ref().map(average)).collect(),
        }
    }

    fn inputs(&self) -> Vec<PathBuf> {
        let beside = self.metrics.iter().chain(self.averages.iter().flatten());
        paths(&self.trials).into_iter().chain(beside.cloned()).collect()
    }

    /// Where means are aligned by landmarks, the times at which their repeats stand behind them; a
    /// repeat that is in no mean stays at its own.
    fn warped_s(&self, trials: &[Trial]) -> Vec<Option<Vec<f64>>> {
        let has_means =
            self.alignment == Alignment::Landmarks && self.averages.iter().any(Option::is_some);
        let study = &self.data.study;
        let of_mode = |of_mode: &[Trial]| {
            let times_s = || zwidth_average::times_s(of_mode, study, self.alignment).ok();
            has_means.then(times_s).flatten().unwrap_or_else(|| vec![None; of_mode.len()])
        };
        trials.chunk_by(|a, b| a.meta.mode == b.meta.mode).flat_map(of_mode).collect()
    }

    fn load(&self) -> Result<(Loaded<'a>, Vec<String>), JobError> {
        let (mut trials, problems) = read_all(&self.trials, zwidth_figures::SIGNALS.into_iter());
        trials
            .sort_by_key(|t| self.data.study.modes.iter().position(|mode| mode.id == t.meta.mode));
        let mut onsets = BTreeMap::new();
        for metrics in &self.metrics {
            let metrics = Table::columns_from_parquet(metrics, &["trial", "onset_s"])?;
            onsets.extend(metrics.integers("trial")?.into_iter().zip(metrics.floats("onset_s")?));
        }
        let onset = |t: &Trial| onsets.get(&Some(i64::from(t.meta.trial))).copied().flatten();
        let columns = zwidth_figures::average_columns();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let read = |path: &Option<PathBuf>| {
            path.as_deref().map(|path| Table::columns_from_parquet(path, &columns)).transpose()
        };
        let averages = self.averages.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let notes = footnotes(averages.iter().flatten())?;
        let averages = averages.into_iter().map(|t| t.filter(|t| t.height() > 0)).collect();
        let loaded = Loaded {
            data: self.data,
            environment: self.environment,
            who: self.who.clone(),
            onsets: trials.iter().map(onset).collect(),
            warped_s: self.warped_s(&trials),
            trials,
            alignment: self.alignment,
            averages,
            notes,
        };
        Ok((loaded, problems))
    }
}

/// Why there is no mean, each reason once; and where the earliest mean ends before all of its
/// repeats do.
fn footnotes<'t>(
    averages: impl Iterator<Item = &'t Table> + Clone,
) -> Result<Vec<String>, JobError> {
    let without =
        averages.clone().filter(|t| t.height() == 0).flat_map(|t| t.notes().iter().cloned());
    let mut notes: Vec<String> = without.collect();
    notes.sort();
    notes.dedup();
    let mut ends = Vec::new();
    for average in averages.filter(|t| t.height() > 0) {
        let (early, other): (Vec<_>, Vec<_>) = average.notes().iter().partition(|n| ends_early(n));
        notes.extend(other.into_iter().cloned());
        if !early.is_empty() {
            ends.extend(average.floats("t_s")?.into_iter().flatten().max_by(f64::total_cmp));
        }
    }
    if let Some(first) = ends.into_iter().min_by(f64::total_cmp) {
        notes.push(format!(
            "Each mean ends where fewer than half of its repeats remain (the first at {first:.2} s)."
        ));
    }
    Ok(notes)
}

/// Whether an average's note tells where it ends.
fn ends_early(note: &str) -> bool {
    note.contains(zwidth_average::ENDS_AT)
}

impl Loaded<'_> {
    fn scene(&self) -> Scene<'_> {
        let mode = |(index, mode): (usize, &'_ zwidth_study::Mode)| {
            let repeat = |i: usize| Repeat {
                trial: &self.trials[i],
                onset_s: self.onsets[i],
                warped_s: self.warped_s[i].as_deref(),
            };
            let mine = (0..self.trials.len()).filter(|i| self.trials[*i].meta.mode == mode.id);
            let repeats: Vec<_> = mine.map(repeat).collect();
            let data = ModeData {
                index,
                label: &self.data.study.modes[index].label,
                repeats,
                average: self.averages[index].as_ref(),
            };
            (!data.repeats.is_empty()).then_some(data)
        };
        Scene {
            study: &self.data.study,
            environment: self.environment,
            who: self.who.clone(),
            modes: self.data.study.modes.iter().enumerate().filter_map(mode).collect(),
            alignment: self.alignment,
            notes: self.notes.clone(),
        }
    }
}

fn modes_job<'a>(
    data: &'a StudyData,
    session: &Session<'a>,
    environment: &'a Environment,
) -> Job<'a> {
    let name = format!("modes.{}.{}", session.key(), environment.id);
    let source = Recorded::new(data, session, environment, &name);
    figure_job(data, &name, source.inputs(), parameters(&data.study), move || {
        let (loaded, problems) = source.load()?;
        Ok((zwidth_figures::modes(&loaded.scene())?, problems))
    })
}

fn repeats_jobs<'a>(
    data: &'a StudyData,
    session: &Session<'a>,
    environment: &'a Environment,
) -> Vec<Job<'a>> {
    let mut jobs = Vec::new();
    for mode in &data.study.modes {
        let Some(repeats) = session.repeats(environment, mode).filter(|r| r.trials.len() > 1)
        else {
            continue; // one recording is whole in the figure of the modes
        };
        let name = format!("repeats.{}", repeats.key);
        let mut source = Recorded::new(data, session, environment, &name);
        source.metrics = vec![metrics::of_condition(&data.layout, &repeats)];
        source.trials = repeats.trials;
        source.averages.iter_mut().for_each(|a| *a = None);
        jobs.push(figure_job(data, &name, source.inputs(), parameters(&data.study), move || {
            let (loaded, problems) = source.load()?;
            let scene = loaded.scene();
            let none = || format!("no trial could be read: {}", problems.join("; "));
            let first = scene.modes.first().ok_or_else(none)?;
            Ok((zwidth_figures::repeats(&scene, first), problems))
        }));
    }
    jobs
}

fn loops_job<'a>(
    data: &'a StudyData,
    session: &Session<'a>,
    environments: &[&'a Environment],
) -> Job<'a> {
    let name = format!("loops.{}", session.key());
    let sources: Vec<_> =
        environments.iter().map(|e| Recorded::new(data, session, e, &name)).collect();
    let mut inputs: Vec<PathBuf> = sources.iter().flat_map(Recorded::inputs).collect();
    inputs.sort();
    inputs.dedup();
    figure_job(data, &name, inputs, parameters(&data.study), move || {
        let mut problems = Vec::new();
        let mut all = Vec::new();
        for source in &sources {
            let (loaded, more) = source.load()?;
            problems.extend(more);
            all.push(loaded);
        }
        let scenes: Vec<Scene> = all.iter().map(Loaded::scene).collect();
        Ok((zwidth_figures::loops(&data.study, &scenes)?, problems))
    })
}

fn characteristic_job<'a>(
    data: &'a StudyData,
    actuator: &'a str,
    sweeps: Vec<PathBuf>,
    tables: Vec<PathBuf>,
) -> Job<'a> {
    let inputs = sweeps.iter().chain(&tables).cloned().collect();
    let parameters = format!("level {}", data.study.analysis.confidence);
    figure_job(data, &format!("characteristic.{actuator}"), inputs, parameters, move || {
        let (read, problems) = characterise::read_sweeps(&sweeps);
        let [models, parameters, curve] = [0, 1, 2].map(|i| Table::from_parquet(&tables[i]));
        let (models, parameters, curve) = (models?, parameters?, curve?);
        let level = data.study.analysis.confidence;
        let of = Characterised { models: &models, parameters: &parameters, curve: &curve, level };
        Ok((zwidth_figures::characteristic(actuator, &read, of)?, problems))
    })
}

fn free_motion_job(data: &StudyData) -> Job<'_> {
    let table = freemotion::planes_of(&data.layout);
    let inputs = vec![table.clone()];
    figure_job(data, "free_motion", inputs, parameters(&data.study), move || {
        let fits = Table::from_parquet(&table)?;
        Ok((zwidth_figures::free_motion(&data.study, &fits)?, Vec::new()))
    })
}
