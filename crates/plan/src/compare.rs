//! Stage `compare`: modes, participants and sessions compared, one job per metric; its figures.

use crate::drawing::{Drawing, Figured};
use crate::making::{derived, read_tables, write_tables};
use crate::preregistered::preregistered;
use crate::{likert, likert_figures, metrics};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_compare::{AnswerParameters, DrawnOrder, Noticed, Parameters, SessionOrder};
use zwidth_figures::{
    ANSWERS_COMPARED, About, AnswersPage, ComparedTables, FigureKind, MODES_COMPARED,
    PARTICIPANTS_COMPARED, REPEATS_COMPARED, SESSIONS_COMPARED,
};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, SessionLog, StudyData};
use zwidth_study::order::Rules;
use zwidth_study::{Bound, Coordinate, Environment, Event, MetricId, Source, Study, is_felt};
use zwidth_tables::Table;

const STAGE: Stage = Stage { name: "compare", version: zwidth_compare::VERSION };

/// The metrics that a study compares, where it does not say which, besides the primary one and the
/// one that is primary by default.
const OTHERS: [&str; 6] = [
    "wall_past_max_rad",
    "stiffness_n_per_rad",
    "loop_area_j",
    "force_rms_error_n",
    "returned_energy_share",
    "duration_s",
];

/// What a metric's tables are, by the beginning of their names, in the order of the job's outputs.
const TABLES: [&str; 11] = [
    "cells",
    "means",
    "contrasts",
    "omnibus",
    "models",
    "participants",
    "sessions",
    "learning",
    "repeats",
    "orders",
    "redrawn",
];

/// By what a study is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// Its modes: means, contrasts, and these against other orders of the trials.
    Mode,
    /// Its participants: everybody's differences between modes.
    Participant,
    /// Its sessions: changes between them.
    Session,
    /// Its repeats: changes from one to the next.
    Repeat,
    /// Its modes, by the answers.
    Answer,
}

/// The derived tables that answer by what a study is compared, in the order in which they are read.
pub fn comparison(layout: &Layout, by: By, metric: &str) -> Vec<PathBuf> {
    let names: &[&str] = match by {
        By::Answer => return vec![answers_file(layout)],
        By::Mode => &["means", "contrasts", "omnibus", "orders"],
        By::Participant => &["participants"],
        By::Session => &["sessions"],
        By::Repeat => &["learning"],
    };
    names.iter().map(|name| table_of(layout, name, metric)).collect()
}

/// The derived tables that tell how participants differ in a metric: the contrasts, and the mixed
/// models.
pub fn spreads(layout: &Layout, metric: &str) -> [PathBuf; 2] {
    ["contrasts", "models"].map(|table| table_of(layout, table, metric))
}

/// The metrics that are compared: those that trials of this study can have, the primary one first.
/// Empty in a study with one mode.
pub fn compared(data: &StudyData) -> Vec<String> {
    if !are_several(data.counting().map(|trial| &trial.meta.mode)) {
        return Vec::new();
    }
    wanted(&data.study).into_iter().filter(|metric| is_possible(data, metric)).collect()
}

/// Whether there are two that differ.
fn are_several<T: PartialEq>(mut all: impl Iterator<Item = T>) -> bool {
    all.next().is_some_and(|first| all.any(|other| other != first))
}

/// Whether some trial of the study can have a metric.
fn is_possible(data: &StudyData, metric: &str) -> bool {
    if data.study.device.lever_m.is_none() && zwidth_metrics::needs_lever(metric) {
        return false;
    }
    data.counting().any(|trial| {
        let environment = data.study.environment(&trial.meta.environment);
        let channels = &data.study.channels;
        environment.is_some_and(|e| {
            zwidth_metrics::is_possible(metric, &e.scene, &trial.said.signals, channels)
        })
    })
}

/// The metrics that a study asks for, the primary one first, each once.
fn wanted(study: &Study) -> Vec<String> {
    let primary = study.compare.primary.to_string();
    let others: Vec<String> = match &study.compare.metrics {
        Some(metrics) => metrics.iter().map(ToString::to_string).collect(),
        None => {
            let default = MetricId::primary().to_string();
            std::iter::once(default).chain(OTHERS.map(str::to_owned)).collect()
        }
    };
    let mut wanted = vec![primary];
    for metric in others {
        if !wanted.contains(&metric) {
            wanted.push(metric);
        }
    }
    wanted
}

/// What a metric measures, in words, if there is one of that name.
pub fn metric_in_words(name: &str) -> Option<&'static str> {
    zwidth_metrics::in_words(name)
}

/// Whether there is a metric of that name that can be compared: a number.
pub fn is_metric(name: &str) -> bool {
    zwidth_metrics::is_number(name)
}

/// What study.toml says of metrics that do not exist, and of bounds that have no effect.
pub fn asked_in_vain(study: &Study) -> Vec<String> {
    let unknown = wanted(study).into_iter().filter(|metric| !zwidth_metrics::is_number(metric));
    let mut unknown: Vec<String> = unknown
        .map(|metric| {
            let now = zwidth_metrics::renamed(&metric).map(|now| format!(": it is '{now}' now"));
            let on_a_lever = metric.replace("_per_mm", "_per_rad").replace("_mm", "_rad");
            let meant = zwidth_metrics::is_number(&on_a_lever)
                .then(|| format!(": write {on_a_lever}, also on a slide"));
            let now = now.or(meant).unwrap_or_default();
            format!(
                "[compare] of study.toml: there is no metric '{metric}' that is a number{now}; it \
                 is left out"
            )
        })
        .collect();
    if !unknown.is_empty() {
        unknown.push(format!(
            "[compare] of study.toml: the metrics are {}",
            zwidth_metrics::names().join(", ")
        ));
    }
    let fractions = study.compare.bounds.iter().filter(|(_, b)| matches!(b, Bound::Weber(_)));
    let of_nothing = fractions.filter(|(metric, _)| !is_commanded(study, metric));
    let of_nothing = of_nothing.map(|(metric, _)| {
        format!(
            "the bound of '{metric}' in study.toml is a Weber fraction, but no environment \
             commands a value of it: give a number in its unit"
        )
    });
    unknown.into_iter().chain(of_nothing).collect()
}

/// Whether some environment commands a value of a metric.
fn is_commanded(study: &Study, metric: &MetricId) -> bool {
    let mut scenes = study.environments.iter().map(|environment| &environment.scene);
    scenes.any(|scene| zwidth_metrics::commanded(metric.as_str(), scene).is_some())
}

/// A table of a metric.
fn table_of(layout: &Layout, table: &str, metric: &str) -> PathBuf {
    derived(layout, format!("compare/{table}_{metric}.parquet"))
}

/// The tables of a metric that the summary speaks of: its means and its contrasts.
pub(crate) fn summarised(layout: &Layout, metric: &str) -> [PathBuf; 2] {
    ["means", "contrasts"].map(|table| table_of(layout, table, metric))
}

/// The changes between sessions in a metric, where several people took part and somebody came
/// again.
pub(crate) fn changes(data: &StudyData, metric: &str) -> Option<PathBuf> {
    let (several, again) = who(data);
    (several && again).then(|| table_of(&data.layout, "sessions", metric))
}

/// Whether several people took part, and whether somebody came again.
fn who(data: &StudyData) -> (bool, bool) {
    let metas = data.counting().map(|trial| &trial.meta);
    let sessions: BTreeSet<_> = metas.map(|meta| (&meta.participant, &meta.session)).collect();
    let people: BTreeSet<_> = sessions.iter().map(|(participant, _)| participant).collect();
    (people.len() > 1, sessions.len() > people.len())
}

/// The contrasts of all metrics in one table, where any is compared.
fn together(data: &StudyData) -> Option<PathBuf> {
    (!compared(data).is_empty()).then(|| derived(&data.layout, "compare/comparison.parquet"))
}

/// The tables that people read: that of all metrics; of every metric its means, its contrasts and its changes; those of
/// participants and sessions where there are several.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    let (several, again) = who(data);
    let mut tables: Vec<PathBuf> = together(data).into_iter().collect();
    let mut names = TABLES.to_vec();
    names.retain(|table| match *table {
        "omnibus" | "models" | "participants" => several,
        "sessions" => several && again,
        "cells" | "repeats" | "redrawn" => false,
        _ => true,
    });
    for metric in compared(data) {
        tables.extend(names.iter().map(|table| table_of(&data.layout, table, &metric)));
    }
    tables.extend(answers(data));
    tables
}

/// The answers compared, if there are some after several modes.
pub fn answers(data: &StudyData) -> Option<PathBuf> {
    let several = are_several(likert::ratings(data).map(|answer| &answer.condition.mode));
    likert::long(data).filter(|_| several).map(|_| answers_file(&data.layout))
}

fn answers_file(layout: &Layout) -> PathBuf {
    let [contrasts, _] = answers_files(layout);
    contrasts
}

/// The answers compared, and each participant's effects.
fn answers_files(layout: &Layout) -> [PathBuf; 2] {
    ["answers_compared", "answers_participants"]
        .map(|table| derived(layout, format!("compare/{table}.parquet")))
}

/// What the comparison of a metric depends on.
fn parameters(data: &StudyData, metric: &str) -> Parameters {
    let study = &data.study;
    let compare = &study.compare;
    let given = compare.bounds.iter().find(|(of, _)| of.as_str() == metric).map(|(_, bound)| bound);
    let bound = |environment: &Environment| match given? {
        Bound::Absolute(bound) => Some(*bound),
        Bound::Weber(share) => {
            let commanded = zwidth_metrics::commanded(metric, &environment.scene)?;
            Some(share * commanded)
        }
    };
    let primary = metric == compare.primary.as_str();
    Parameters {
        metric: metric.to_owned(),
        primary,
        preregistered: if primary { preregistered(data, &compared(data)) } else { None },
        simulated: data.counting().any(|trial| trial.meta.source.is_simulated()),
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        bounds: study.environments.iter().map(bound).collect(),
        noticed: noticed(study, metric),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        contrasts: compare.contrasts.clone(),
        families: compare.families,
        alpha: compare.alpha,
        level: compare.level,
        effect_sizes: compare.effect_sizes.clone(),
        orders: data.sessions.iter().map(|log| order(log, study)).collect(),
    }
}

/// From which difference on a metric is noticed, if anybody feels it.
fn noticed(study: &Study, metric: &str) -> Option<Noticed> {
    is_felt(metric).then(|| Noticed {
        perception: study.perception.clone(),
        lever_m: study.device.lever_m.unwrap_or(0.0),
        is_slide: matches!(study.coordinate, Coordinate::Linear { .. }),
        commanded: study
            .environments
            .iter()
            .map(|environment| zwidth_metrics::commanded(metric, &environment.scene))
            .collect(),
    })
}

/// How the order of a session came about. It was drawn for the study as it was then.
fn order(log: &SessionLog, study: &Study) -> SessionOrder {
    let study = log.study.as_deref().unwrap_or(study);
    let drawn = log.record.order.map(|order| DrawnOrder {
        rules: Rules {
            scheme: order.scheme,
            ..Rules::of(study, order.participant_number, order.session_number)
        },
        seed: log.record.seed,
        familiarisation: study.design.familiarisation,
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        repeated: repeated(&log.events),
    });
    let (participant, session) = (log.record.participant.clone(), log.record.session.clone());
    SessionOrder { participant, session, drawn }
}

/// The trials that repeat another one, which may itself repeat a third: the number of each, and the
/// number of the trial that the order had in this place.
fn repeated(events: &[Event]) -> Vec<[u32; 2]> {
    let mut found: Vec<[u32; 2]> = Vec::new();
    for event in events {
        let Event::Superseded { trial, by } = event else { continue };
        let before = found.iter().find(|[number, _]| number == trial);
        let place = before.map_or(*trial, |[_, place]| *place);
        found.push([*by, place]);
    }
    found
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let answers = answers(data).map(|_| answers_job(data));
    let Some(metrics) = metrics::of_study(data) else { return answers.into_iter().collect() };
    let metric = |metric: &String| job(data, metric, metrics.clone());
    compared(data).iter().map(metric).chain(together_job(data)).chain(answers).collect()
}

/// What is said of all metrics in one table.
fn together_job(data: &StudyData) -> Option<Job> {
    let contrasts: Vec<PathBuf> =
        compared(data).iter().map(|metric| table_of(&data.layout, "contrasts", metric)).collect();
    let of = Together {
        primary: data.study.compare.primary.clone(),
        simulated: data.counting().any(|trial| trial.meta.source.is_simulated()),
    };
    let output = together(data)?;
    Some(Job::new(STAGE, "compare all metrics", of, contrasts, vec![output], make_together))
}

/// What the table of all metrics depends on besides their contrasts.
#[derive(Serialize)]
struct Together {
    primary: MetricId,
    simulated: bool,
}

fn make_together(
    of: &Together,
    contrasts: &Vec<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let contrasts = read_tables(contrasts)?;
    let table = zwidth_compare::together(&contrasts, of.primary.as_str())?;
    write_tables(&[table.with_mark(of.simulated)], making, Vec::new())
}

/// The comparison of one metric, from the metrics of all trials.
fn job(data: &StudyData, metric: &str, metrics: PathBuf) -> Job {
    let parameters = parameters(data, metric);
    let outputs = tables_of(&data.layout, metric);
    Job::new(STAGE, format!("compare {metric}"), parameters, metrics, outputs, make)
}

/// All tables of a metric.
fn tables_of(layout: &Layout, metric: &str) -> Vec<PathBuf> {
    TABLES.map(|table| table_of(layout, table, metric)).to_vec()
}

fn answers_job(data: &StudyData) -> Job {
    let study = &data.study;
    let parameters = AnswerParameters {
        simulated: data.sessions.iter().any(|session| session.record.source.is_simulated()),
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        questions: study.questions.iter().filter(|q| q.is_rating()).cloned().collect(),
        contrasts: study.compare.contrasts.clone(),
        level: study.compare.level,
    };
    let inputs = likert::long(data);
    let outputs = answers_files(&data.layout).to_vec();
    Job::new(STAGE, "compare answers", parameters, inputs, outputs, make_answers)
}

fn make_answers(
    parameters: &AnswerParameters,
    answers: &Option<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let answers = answers.as_deref().ok_or("there is no answer")?;
    let answers = Table::from_parquet(answers)?;
    let found = zwidth_compare::compare_answers(&answers, parameters)?;
    write_tables(&[found.contrasts, found.participants], making, Vec::new())
}

fn make(parameters: &Parameters, metrics: &PathBuf, making: &Making) -> Result<Made, JobError> {
    let columns = zwidth_compare::COLUMNS.into_iter().chain([parameters.metric.as_str()]);
    let metrics = Table::columns_from_parquet(metrics, &columns.collect::<Vec<_>>())?;
    let found = zwidth_compare::compare(&metrics, parameters)?;
    let tables = [
        found.cells,
        found.means,
        found.contrasts,
        found.omnibus,
        found.models,
        found.participants,
        found.sessions,
        found.learning,
        found.repeats,
        found.orders,
        found.redrawn,
    ];
    write_tables(&tables, making, Vec::new())
}

/// What a figure of the stage depends on besides tables.
#[derive(Clone, Serialize)]
struct Drawn {
    about: About,
    environments: Vec<Environment>,
    sources: BTreeSet<Source>,
}

/// What describes a figure of a metric.
type Draw = fn(&Drawn, &Vec<PathBuf>) -> Figured;

/// The figures of every metric.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let (several, again) = who(data);
    let trials = data.counting().count();
    let of = Drawn {
        about: About::of(&data.study),
        environments: data.study.environments.clone(),
        sources: data.counting().map(|trial| trial.meta.source).collect(),
    };
    // One repeat shows no learning.
    let repeated = data.study.design.repeats > 1;
    let kinds: [(bool, FigureKind, Draw); 4] = [
        (true, MODES_COMPARED, draw_modes),
        (several, PARTICIPANTS_COMPARED, draw_participants),
        (several && again, SESSIONS_COMPARED, draw_sessions),
        (repeated, REPEATS_COMPARED, draw_repeats),
    ];
    let mut drawings = Vec::new();
    for metric in compared(data) {
        for (_, kind, draw) in kinds.into_iter().filter(|(is_shown, ..)| *is_shown) {
            let (subject, files) = ([metric.as_str()], tables_of(&data.layout, &metric));
            drawings.push(Drawing::new(data, kind, subject, of.clone(), files, draw).of(trials));
        }
    }
    drawings.extend(answers_figures(data));
    drawings
}

/// What a page of answers compared depends on besides the tables.
#[derive(Serialize)]
struct AnswersDrawn {
    about: About,
    page: AnswersPage,
    sources: BTreeSet<Source>,
}

/// The figures of answers over several participants.
fn answers_figures(data: &StudyData) -> Vec<Drawing> {
    let people: BTreeSet<_> = data.sessions.iter().map(|s| &s.record.participant).collect();
    if people.len() < 2 || answers(data).is_none() {
        return Vec::new();
    }
    let pages = zwidth_figures::answers_pages(&likert_figures::list_asked(data));
    let numbers = likert_figures::number_pages(pages.len());
    pages
        .into_iter()
        .zip(numbers)
        .map(|(page, number)| answers_figure(data, page, number))
        .collect()
}

/// One page of answers compared.
fn answers_figure(data: &StudyData, page: AnswersPage, number: Option<String>) -> Drawing {
    let of_page = |a: &&zwidth_store::Answer| page.shows(&a.condition.environment, &a.question);
    let answers = data.answers.iter().filter(of_page).count();
    let sources = data.sessions.iter().map(|s| s.record.source).collect();
    let of = AnswersDrawn { about: About::of(&data.study), page, sources };
    let files = answers_files(&data.layout).to_vec();
    Drawing::new(data, ANSWERS_COMPARED, number, of, files, draw_answers).of(answers)
}

fn draw_answers(of: &AnswersDrawn, files: &Vec<PathBuf>) -> Figured {
    let [contrasts, participants] = files.as_slice() else {
        return Err("answers compared are two tables".into());
    };
    let (contrasts, participants) =
        (Table::from_parquet(contrasts)?, Table::from_parquet(participants)?);
    let sources: Vec<Source> = of.sources.iter().copied().collect();
    let tables = [&contrasts, &participants];
    let figure = zwidth_figures::answers_compared(&of.about, &of.page, tables, &sources)?;
    Ok((figure, Vec::new()))
}

/// A metric's tables as figures see them.
struct Read([Table; 7]);

impl Read {
    fn of(files: &[PathBuf]) -> Result<Self, JobError> {
        let [cells, means, contrasts, _, _, participants, sessions, _, repeats, _, redrawn] = files
        else {
            return Err("a metric has eleven tables".into());
        };
        let read = |file: &PathBuf| Table::from_parquet(file);
        Ok(Self([
            read(cells)?,
            read(means)?,
            read(contrasts)?,
            read(participants)?,
            read(sessions)?,
            read(repeats)?,
            read(redrawn)?,
        ]))
    }

    fn tables(&self) -> ComparedTables<'_> {
        let [cells, means, contrasts, participants, sessions, repeats, redrawn] = &self.0;
        ComparedTables { cells, means, contrasts, participants, sessions, repeats, redrawn }
    }
}

fn draw_modes(of: &Drawn, files: &Vec<PathBuf>) -> Figured {
    draw(zwidth_figures::modes_compared, of, files)
}

fn draw_participants(of: &Drawn, files: &Vec<PathBuf>) -> Figured {
    draw(zwidth_figures::participants_compared, of, files)
}

fn draw_sessions(of: &Drawn, files: &Vec<PathBuf>) -> Figured {
    draw(zwidth_figures::sessions_compared, of, files)
}

fn draw_repeats(of: &Drawn, files: &Vec<PathBuf>) -> Figured {
    draw(zwidth_figures::repeats_compared, of, files)
}

/// A figure of a metric's tables.
type Figure = fn(
    &About,
    &[Environment],
    &[Source],
    ComparedTables,
) -> Result<zwidth_draw::Figure, zwidth_tables::TableError>;

fn draw(figure: Figure, of: &Drawn, files: &[PathBuf]) -> Figured {
    let read = Read::of(files)?;
    let sources: Vec<Source> = of.sources.iter().copied().collect();
    Ok((figure(&of.about, &of.environments, &sources, read.tables())?, Vec::new()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_was_done_again_twice_has_the_place_of_the_first() {
        let again = |trial, by| Event::Superseded { trial, by };
        let note = Event::Note { trial: Some(40), text: "slipped".to_owned() };
        let events = [again(2, 40), note, again(40, 41), again(3, 42)];
        assert_eq!(repeated(&events), [[40, 2], [41, 2], [42, 3]]);
    }

    #[test]
    fn a_primary_metric_that_there_is_not_is_told_with_those_that_there_are() {
        let mut study = crate::tests::data().study;
        assert!(asked_in_vain(&study).is_empty());
        study.compare.primary = "softness_n".parse().unwrap();
        let told = asked_in_vain(&study);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("there is no metric 'softness_n'"), "{told:?}");
        assert!(told[1].contains("the metrics are ") && told[1].contains("wall_past_max_rad"));
    }
}
