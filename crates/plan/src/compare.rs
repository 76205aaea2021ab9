//! Stage `compare`: modes, participants and sessions compared, one job per metric; its figures.

use crate::figures::drawing::{Drawing, Figured};
use crate::likert::figures as likert_figures;
use crate::page::preregistered::preregistered;
use crate::shared::handle::{Derived, Written};
use crate::shared::making::derived;
use crate::tables::printed::Printed;
use crate::{likert, metrics};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_compare::{
    AnswerParameters, DrawnOrder, MetricParameters, Noticed, Parameters, SessionOrder,
};
use zwidth_figures::{
    ANSWERS_COMPARED, About, AnswersPage, FigureKind, IN_ONE_COLUMN, MODES_COMPARED, MetricResults,
    PARTICIPANTS_COMPARED, REPEATS_COMPARED, SESSIONS_COMPARED, VERDICTS, VerdictRow,
    answers_compared, verdict_rows,
};
use zwidth_results::{
    AnswerDifference, Cell, Compared, GivenAnswer, Learning, Mean, MetricNote, ModeDifference,
    Model, Omnibus, OrderTest, PersonDifference, PersonSuperiority, PrintedDifference,
    RedrawnDifference, RepeatMean, SessionChange,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, SessionLog, StudyData};
use zwidth_study::order::Rules;
use zwidth_study::{
    Better, Bound, Coordinate, Environment, Event, IdError, MetricId, Source, Study, is_felt,
};
use zwidth_tables::{Measured, TableError};

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

/// What the stage finds of the metrics, a table for each kind of row.
#[derive(Clone)]
pub(crate) struct Comparison {
    pub(crate) metrics: Derived<Compared>,
    pub(crate) cells: Derived<Cell>,
    pub(crate) means: Derived<Mean>,
    pub(crate) contrasts: Derived<ModeDifference>,
    pub(crate) printed: Derived<PrintedDifference>,
    pub(crate) omnibus: Derived<Omnibus>,
    pub(crate) models: Derived<Model>,
    pub(crate) participants: Derived<PersonDifference>,
    pub(crate) sessions: Derived<SessionChange>,
    pub(crate) learning: Derived<Learning>,
    pub(crate) repeats: Derived<RepeatMean>,
    pub(crate) orders: Derived<OrderTest>,
    pub(crate) redrawn: Derived<RedrawnDifference>,
    pub(crate) notes: Derived<MetricNote>,
}

impl Comparison {
    fn of(layout: &Layout) -> Self {
        let folder = derived(layout, "compare");
        Self {
            metrics: Derived::within(&folder),
            cells: Derived::within(&folder),
            means: Derived::within(&folder),
            contrasts: Derived::within(&folder),
            printed: Derived::within(&folder),
            omnibus: Derived::within(&folder),
            models: Derived::within(&folder),
            participants: Derived::within(&folder),
            sessions: Derived::within(&folder),
            learning: Derived::within(&folder),
            repeats: Derived::within(&folder),
            orders: Derived::within(&folder),
            redrawn: Derived::within(&folder),
            notes: Derived::within(&folder),
        }
    }

    /// What was found of one metric.
    fn read(&self, metric: &MetricId) -> Result<MetricResults, JobError> {
        let all = self.metrics.read_of(metric)?;
        let none = || format!("the metric {metric} was not compared");
        Ok(MetricResults {
            metric: all.into_iter().next().ok_or_else(none)?,
            cells: self.cells.read_of(metric)?,
            means: self.means.read_of(metric)?,
            contrasts: self.contrasts.read_of(metric)?,
            participants: self.participants.read_of(metric)?,
            sessions: self.sessions.read_of(metric)?,
            repeats: self.repeats.read_of(metric)?,
            redrawn: self.redrawn.read_of(metric)?,
            notes: self.notes.read_of(metric)?,
        })
    }
}

impl Inputs for Comparison {
    fn files(&self) -> Vec<PathBuf> {
        let Self { metrics, cells, means, contrasts, printed, omnibus, models, .. } = self;
        let Self { participants, sessions, learning, repeats, orders, redrawn, notes, .. } = self;
        [
            metrics.path(),
            cells.path(),
            means.path(),
            contrasts.path(),
            printed.path(),
            omnibus.path(),
            models.path(),
            participants.path(),
            sessions.path(),
            learning.path(),
            repeats.path(),
            orders.path(),
            redrawn.path(),
            notes.path(),
        ]
        .map(Path::to_owned)
        .to_vec()
    }
}

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

/// The tables that answer by what a study is compared, as they are printed, in the order in which
/// they are read.
pub fn comparison(data: &StudyData, by: By, metric: &str) -> Vec<Printed> {
    let found = Comparison::of(&data.layout);
    let of =
        |tables: &[&Path]| tables.iter().map(|table| Printed::of_metric(table, metric)).collect();
    match by {
        By::Answer => vec![Printed::without_empty_columns(answers_of(&data.layout).0.path())],
        By::Mode => of(&[
            found.means.path(),
            found.contrasts.path(),
            found.omnibus.path(),
            found.orders.path(),
        ]),
        By::Participant => of(&[found.participants.path()]),
        By::Session => of(&[found.sessions.path()]),
        By::Repeat => of(&[found.learning.path()]),
    }
}

/// How participants differ in a metric: the contrasts, and the mixed models.
///
/// # Errors
/// Tables that are not there.
pub fn spreads(
    data: &StudyData,
    metric: &MetricId,
) -> Result<(Vec<ModeDifference>, Vec<Model>), TableError> {
    let found = Comparison::of(&data.layout);
    Ok((found.contrasts.read_of(metric)?, found.models.read_of(metric)?))
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

/// Remarks on metrics in study.toml that do not exist, and on bounds that have no effect.
pub fn asked_in_vain(study: &Study) -> Vec<String> {
    let unknown = wanted(study).into_iter().filter(|metric| !zwidth_metrics::is_number(metric));
    let mut unknown: Vec<String> = unknown
        .map(|metric| {
            let on_a_lever = metric.replace("_per_mm", "_per_rad").replace("_mm", "_rad");
            let meant = zwidth_metrics::is_number(&on_a_lever)
                .then(|| format!(": write {on_a_lever}, also on a slide"));
            let meant = meant.unwrap_or_default();
            format!(
                "[compare] of study.toml: there is no metric '{metric}' that is a number{meant}; \
                 it is left out"
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

/// What is compared of the study's metrics, where any is.
pub(crate) fn of_study(data: &StudyData) -> Option<Comparison> {
    (!compared(data).is_empty()).then(|| Comparison::of(&data.layout))
}

/// Whether several people took part, and somebody of them came again.
pub(crate) fn are_sessions_told(data: &StudyData) -> bool {
    let (several, again) = who(data);
    several && again
}

/// Whether several people took part, and whether somebody came again.
fn who(data: &StudyData) -> (bool, bool) {
    let metas = data.counting().map(|trial| &trial.meta);
    let sessions: BTreeSet<_> = metas.map(|meta| (&meta.participant, &meta.session)).collect();
    let people: BTreeSet<_> = sessions.iter().map(|(participant, _)| participant).collect();
    (people.len() > 1, sessions.len() > people.len())
}

/// The tables that people read: that of all metrics; of every metric its means, its contrasts and its
/// changes; those of participants and sessions where there are several.
pub(crate) fn tables(data: &StudyData) -> Vec<Printed> {
    let (several, again) = who(data);
    let mut tables = Vec::new();
    if let Some(found) = of_study(data) {
        tables.push(Printed::whole(found.printed.path()));
        let kinds = [
            (true, found.means.path()),
            (true, found.contrasts.path()),
            (several, found.omnibus.path()),
            (several, found.models.path()),
            (several, found.participants.path()),
            (several && again, found.sessions.path()),
            (true, found.learning.path()),
            (true, found.orders.path()),
        ];
        for metric in compared(data) {
            let wanted = kinds.iter().filter(|(is_wanted, _)| *is_wanted);
            tables.extend(wanted.map(|(_, table)| Printed::of_metric(table, &metric)));
        }
    }
    tables.extend(answers(data).map(|table| Printed::without_empty_columns(&table)));
    tables
}

/// The answers compared, if there are some after several modes.
pub fn answers(data: &StudyData) -> Option<PathBuf> {
    let several = are_several(likert::ratings(data).map(|answer| &answer.condition.mode));
    likert::answers(data).filter(|_| several).map(|_| answers_of(&data.layout).0.path().to_owned())
}

/// The answers compared, and each participant's effects.
type AnswersOf = (Derived<AnswerDifference>, Derived<PersonSuperiority>);

fn answers_of(layout: &Layout) -> AnswersOf {
    let folder = derived(layout, "compare");
    (Derived::within(&folder), Derived::within(&folder))
}

/// What the comparison of a study depends on.
#[derive(Serialize)]
struct Comparing {
    stage: Parameters,
    /// Whether any of the data are simulated.
    simulated: bool,
}

impl Comparing {
    fn of(data: &StudyData) -> Result<Self, IdError> {
        let (study, compare) = (&data.study, &data.study.compare);
        let compared = compared(data);
        let metrics = compared.iter().map(|metric| {
            let mut bounds = compare.bounds.iter();
            let given = bounds.find(|(of, _)| of.as_str() == metric).map(|(_, bound)| bound);
            let bound = |environment: &Environment| match given? {
                Bound::Absolute(bound) => Some(*bound),
                Bound::Weber(share) => {
                    let commanded = zwidth_metrics::commanded(metric, &environment.scene)?;
                    Some(share * commanded)
                }
            };
            let primary = metric == compare.primary.as_str();
            Ok(MetricParameters {
                metric: metric.parse()?,
                primary,
                better: better(study, metric),
                preregistered: if primary { preregistered(data, &compared) } else { None },
                bounds: study.environments.iter().map(bound).collect(),
                noticed: noticed(study, metric),
            })
        });
        let stage = Parameters {
            metrics: metrics.collect::<Result<_, IdError>>()?,
            environments: study.environments.iter().map(|e| e.id.clone()).collect(),
            modes: study.modes.iter().map(|m| m.id.clone()).collect(),
            contrasts: compare.contrasts.clone(),
            families: compare.families,
            alpha: compare.alpha,
            level: compare.level,
            effect_sizes: compare.effect_sizes.clone(),
            orders: data.sessions.iter().map(|log| order(log, study)).collect(),
        };
        let simulated = data.counting().any(|trial| trial.meta.source.is_simulated());
        Ok(Self { stage, simulated })
    }
}

/// Which values of a metric are better: as the study says, else as is usual.
fn better(study: &Study, metric: &str) -> Better {
    let chosen = study.compare.better.iter().find(|(of, _)| of.as_str() == metric);
    chosen.map_or_else(|| zwidth_metrics::better(metric), |(_, better)| *better)
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
    let participant = log.record.participant.clone();
    let session = log.record.session.clone();
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
    metrics_job(data).into_iter().chain(answers).collect()
}

/// The comparison of all metrics, from those of all trials.
fn metrics_job(data: &StudyData) -> Option<Job> {
    let metrics = metrics::of_study(data)?;
    let found = of_study(data)?;
    // Every metric that there is has a name that is an id.
    let parameters = Comparing::of(data).ok()?;
    Some(Job::new(STAGE, "compare metrics", parameters, metrics, found.files(), make))
}

fn make(of: &Comparing, metrics: &PathBuf, making: &Making) -> Result<Made, JobError> {
    let compared: Vec<&str> = of.stage.metrics.iter().map(|of| of.metric.as_str()).collect();
    let metrics = Measured::read(metrics, &compared)?;
    let found = zwidth_compare::compare(&metrics, &of.stage)?;
    let printed = zwidth_compare::together(&found.metrics, &found.contrasts)?;
    Written::begin(making, of.simulated)
        .rows(&found.metrics)?
        .rows(&found.cells)?
        .rows(&found.means)?
        .rows(&found.contrasts)?
        .table(printed)?
        .rows(&found.omnibus)?
        .rows(&found.models)?
        .rows(&found.participants)?
        .rows(&found.sessions)?
        .rows(&found.learning)?
        .rows(&found.repeats)?
        .rows(&found.orders)?
        .rows(&found.redrawn)?
        .rows(&found.notes)?
        .end()
}

/// What the comparison of a study's answers depends on.
#[derive(Serialize)]
struct ComparingAnswers {
    stage: AnswerParameters,
    /// Whether any of the answers are simulated.
    simulated: bool,
}

fn answers_job(data: &StudyData) -> Job {
    let study = &data.study;
    let stage = AnswerParameters {
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        questions: study.questions.iter().filter(|q| q.is_rating()).cloned().collect(),
        contrasts: study.compare.contrasts.clone(),
        level: study.compare.level,
    };
    let simulated = data.sessions.iter().any(|session| session.record.source.is_simulated());
    let of = ComparingAnswers { stage, simulated };
    let outputs = answers_of(&data.layout).files();
    Job::new(STAGE, "compare answers", of, likert::answers(data), outputs, make_answers)
}

fn make_answers(
    of: &ComparingAnswers,
    answers: &Option<Derived<GivenAnswer>>,
    making: &Making,
) -> Result<Made, JobError> {
    let answers = likert::read_counting(answers.as_ref().ok_or("there is no answer")?)?;
    let found = zwidth_compare::compare_answers(&answers, &of.stage)?;
    Written::begin(making, of.simulated)
        .table(zwidth_compare::answers_table(&found.contrasts)?)?
        .rows(&found.participants)?
        .end()
}

/// What a figure of the stage depends on besides tables.
#[derive(Clone, Serialize)]
struct Drawn {
    about: About,
    environments: Vec<Environment>,
    sources: BTreeSet<Source>,
    metric: String,
}

/// What the figure of all metrics depends on besides tables.
#[derive(Clone, Serialize)]
struct AllDrawn {
    about: About,
    environments: Vec<Environment>,
    sources: BTreeSet<Source>,
    metrics: Vec<String>,
    is_narrow: bool,
}

fn draw_verdicts(of: &AllDrawn, found: &Comparison) -> Figured {
    let read = of.metrics.iter().map(|metric| found.read(&metric.parse()?));
    let metrics = read.collect::<Result<Vec<_>, _>>()?;
    let sources: Vec<Source> = of.sources.iter().copied().collect();
    let AllDrawn { about, environments, is_narrow, .. } = of;
    Ok((zwidth_figures::verdicts(about, environments, &sources, &metrics, *is_narrow), Vec::new()))
}

/// What describes a figure of a metric.
type Draw = fn(&Drawn, &Comparison) -> Figured;

/// The figure of every difference between modes, over two columns and in one.
pub(crate) fn verdict_figures(data: &StudyData) -> Vec<Drawing> {
    let metrics = compared(data);
    let forms = if metrics.is_empty() { Vec::new() } else { vec![None, Some(IN_ONE_COLUMN)] };
    let figure = |column: Option<&str>| {
        let of = AllDrawn {
            about: About::of(&data.study),
            environments: data.study.environments.clone(),
            sources: data.counting().map(|trial| trial.meta.source).collect(),
            metrics: metrics.clone(),
            is_narrow: column.is_some(),
        };
        let found = Comparison::of(&data.layout);
        Drawing::new(data, VERDICTS, column, of, found, draw_verdicts).of(data.counting().count())
    };
    forms.into_iter().map(figure).collect()
}

/// Every difference between modes, as a terminal shows it.
///
/// # Errors
/// Tables that are not there.
pub fn verdicts(data: &StudyData) -> Result<Vec<VerdictRow>, JobError> {
    let found = Comparison::of(&data.layout);
    let read = compared(data).into_iter().map(|metric| found.read(&metric.parse()?));
    let metrics = read.collect::<Result<Vec<_>, JobError>>()?;
    Ok(verdict_rows(&About::of(&data.study), &data.study.environments, &metrics))
}

/// The figures of every metric.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let (several, again) = who(data);
    let trials = data.counting().count();
    let found = Comparison::of(&data.layout);
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
        let of = Drawn {
            about: About::of(&data.study),
            environments: data.study.environments.clone(),
            sources: data.counting().map(|trial| trial.meta.source).collect(),
            metric,
        };
        for (_, kind, draw) in kinds.into_iter().filter(|(is_shown, ..)| *is_shown) {
            let of = of.clone();
            let found = found.clone();
            let drawing = Drawing::new(data, kind, [of.metric.clone()], of, found, draw);
            drawings.push(drawing.of(trials));
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
    let answers =
        data.answers.iter().filter(|a| page.shows(&a.condition.environment, &a.question)).count();
    let sources = data.sessions.iter().map(|s| s.record.source).collect();
    let of = AnswersDrawn { about: About::of(&data.study), page, sources };
    let found = answers_of(&data.layout);
    Drawing::new(data, ANSWERS_COMPARED, number, of, found, draw_answers).of(answers)
}

fn draw_answers(of: &AnswersDrawn, (contrasts, participants): &AnswersOf) -> Figured {
    let sources: Vec<Source> = of.sources.iter().copied().collect();
    let contrasts = contrasts.read()?;
    let participants = participants.read()?;
    let about = &of.about;
    Ok((answers_compared(about, &of.page, &contrasts, &participants, &sources), Vec::new()))
}

fn draw_modes(of: &Drawn, found: &Comparison) -> Figured {
    draw(zwidth_figures::modes_compared, of, found)
}

fn draw_participants(of: &Drawn, found: &Comparison) -> Figured {
    draw(zwidth_figures::participants_compared, of, found)
}

fn draw_sessions(of: &Drawn, found: &Comparison) -> Figured {
    draw(zwidth_figures::sessions_compared, of, found)
}

fn draw_repeats(of: &Drawn, found: &Comparison) -> Figured {
    draw(zwidth_figures::repeats_compared, of, found)
}

/// A figure of a metric.
type Figure = fn(&About, &[Environment], &[Source], &MetricResults) -> zwidth_draw::Figure;

fn draw(figure: Figure, of: &Drawn, found: &Comparison) -> Figured {
    let found = found.read(&of.metric.parse()?)?;
    let sources: Vec<Source> = of.sources.iter().copied().collect();
    Ok((figure(&of.about, &of.environments, &sources, &found), Vec::new()))
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
