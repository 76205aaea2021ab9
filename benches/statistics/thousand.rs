//! A study of a thousand people with 36 trials each, compared by the stage's own code: what a job
//! does between reading the table of metrics and the bytes of its own tables.

use crate::draws::Draws;
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;
use zwidth_compare::{
    AnswerParameters, DrawnOrder, Groups, MetricParameters, Parameters, SessionOrder, compare,
    compare_answers,
};
use zwidth_results::{GivenAnswer, Row, TrialKey};
use zwidth_study::order::{Rules, draw};
use zwidth_study::{
    GroupContrast, GroupsCompared, Kind, ParticipantId, PlannedTrial, SessionId, Source, Study,
    template,
};
use zwidth_tables::{Column, Measured, Table};

const PARTICIPANTS: u32 = 1000;
const SEED: u64 = 1;
/// What it may take on two cores, s: all metrics; the answers with their mixed model besides.
const AIMS: [f64; 2] = [10.0, 60.0];
/// What a study compares that does not say what: primary metric, then the others. With their units,
/// and whether only a wall has them.
const METRICS: [(&str, &str, bool); 7] = [
    ("discrepancy_user_mean_n", "N", false),
    ("wall_past_max_rad", "rad", true),
    ("stiffness_n_per_rad", "N/rad", false),
    ("loop_area_j", "J", false),
    ("force_rms_error_n", "N", false),
    ("returned_energy_share", "1", false),
    ("duration_s", "s", false),
];
/// Standard deviations of a participant's level, of their own effect of a mode, of a repeat.
const SPREAD: [f64; 3] = [1.0, 0.5, 0.9];
/// What modes add.
const EFFECTS: [f64; 3] = [0.0, -0.1, 0.15];
/// Share of the trials without a metric.
const WITHOUT: f64 = 0.01;
/// Thresholds of the five-point scale, in logits.
const THRESHOLDS: [f64; 4] = [-1.6, -0.5, 0.6, 1.8];

/// A participant's session.
struct Sat {
    participant: ParticipantId,
    session: SessionId,
    number: u32,
    /// Without familiarisation.
    trials: Vec<PlannedTrial>,
}

pub(crate) fn measure(folder: &Path) -> anyhow::Result<()> {
    let study = Study::from_toml(&template(&"thousand".parse()?));
    let study = &study.map_err(|wrong| anyhow::anyhow!("the template: {wrong:?}"))?;
    let sat: Vec<Sat> =
        (1..=PARTICIPANTS).map(|number| sit(study, number)).collect::<Result<_, _>>()?;
    let metrics = folder.join("metrics.parquet");
    let answers = folder.join("answers.parquet");
    let none = BTreeMap::new();
    std::fs::write(&metrics, trials(study, &sat)?.to_parquet(&none, &metrics)?)?;
    std::fs::write(&answers, answered(study, &sat)?.to_parquet(&none, &answers)?)?;

    let began = Spent::now();
    std::hint::black_box(metrics_job(study, &sat, None, &metrics)?);
    let between = Spent::now();
    std::hint::black_box(answers_job(study, &answers)?);
    let end = Spent::now();
    std::hint::black_box(metrics_job(study, &sat, Some(halves(&sat)?), &metrics)?);
    let with_groups = Spent::now();
    let rows = sat.iter().map(|sat| sat.trials.len()).sum::<usize>();
    println!(
        "{} participants × {} trials ({rows} rows), {} metrics, {} threads.\n",
        sat.len(),
        rows / sat.len(),
        METRICS.len(),
        rayon::current_num_threads(),
    );
    println!("| what | s | of processor, s | aim |\n| --- | --- | --- | --- |");
    line("all metrics, tables read and written", began, between, Some(AIMS[0]));
    line("the answers, with their mixed models", between, end, None);
    line("both", began, end, Some(AIMS[1]));
    let aim = 2.0 * (between.at - began.at).as_secs_f64();
    line(
        "all metrics with two groups of people, within 2 × the time without",
        end,
        with_groups,
        Some(aim),
    );
    Ok(())
}

/// A moment, and what the processor had done for us until then.
#[derive(Clone, Copy)]
struct Spent {
    at: Instant,
    /// Of all threads, s; where the system tells it (Linux).
    processor_s: Option<f64>,
}

impl Spent {
    fn now() -> Self {
        Self { at: Instant::now(), processor_s: processor_s() }
    }
}

/// User and system time of this process: fields 14 and 15 of Linux's `/proc/self/stat`, in
/// hundredths of a second.
fn processor_s() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, fields) = stat.rsplit_once(") ")?;
    let ticks = |field: usize| fields.split(' ').nth(field - 3)?.parse::<f64>().ok();
    Some((ticks(14)? + ticks(15)?) / 100.0)
}

fn line(what: &str, from: Spent, to: Spent, aim: Option<f64>) {
    let seconds = (to.at - from.at).as_secs_f64();
    let processor =
        from.processor_s.zip(to.processor_s).map(|(from, to)| format!("{:.1}", to - from));
    let aim = aim.map_or_else(String::new, |aim| {
        let reached = if seconds < aim { "reached" } else { "missed" };
        format!("below {aim:.0} s: {reached}")
    });
    println!("| {what} | {seconds:.1} | {} | {aim} |", processor.unwrap_or_default());
}

fn sit(study: &Study, number: u32) -> anyhow::Result<Sat> {
    let trials = draw(study, number, 1, SEED).into_iter().filter(|trial| trial.kind == Kind::Trial);
    Ok(Sat {
        participant: format!("P{number:04}").parse()?,
        session: "S01".parse()?,
        number,
        trials: trials.collect(),
    })
}

/// Every trial with its sitting.
fn rows(sat: &[Sat]) -> impl Iterator<Item = (&Sat, &PlannedTrial)> + Clone {
    sat.iter().flat_map(|sat| sat.trials.iter().map(move |trial| (sat, trial)))
}

/// A participant's level in each mode, with what the mode adds.
fn levels(draws: &mut Draws) -> [f64; 3] {
    let own = SPREAD[0] * draws.normal();
    EFFECTS.map(|effect| own + effect + SPREAD[1] * draws.normal())
}

fn mode_of(study: &Study, trial: &PlannedTrial) -> usize {
    study.modes.iter().position(|mode| mode.id == trial.mode).unwrap_or_default()
}

/// The table of metrics.
fn trials(study: &Study, sat: &[Sat]) -> anyhow::Result<Table> {
    let key = |(sat, trial): (&Sat, &PlannedTrial)| TrialKey {
        participant: sat.participant.clone(),
        session: sat.session.clone(),
        trial: trial.trial,
        repeat: trial.repeat,
        environment: trial.environment.clone(),
        mode: trial.mode.clone(),
        source: Source::Twin,
    };
    let mut columns = TrialKey::columns(&rows(sat).map(key).collect::<Vec<_>>());
    for (number, (metric, unit, of_wall)) in (1..).zip(METRICS) {
        let mut values = Vec::new();
        for sat in sat {
            let mut draws = Draws::new(number, sat.number.into());
            let levels = levels(&mut draws);
            for trial in &sat.trials {
                let value = levels[mode_of(study, trial)] + SPREAD[2] * draws.normal();
                let has = draws.uniform() >= WITHOUT;
                let wall = study
                    .environment(&trial.environment)
                    .is_some_and(|environment| environment.scene.wall_rad().is_some());
                values.push((has && (wall || !of_wall)).then_some(value));
            }
        }
        columns.push(Column::float(metric, unit, "", values));
    }
    Ok(Table::new("metrics", "Metrics", columns)?)
}

/// The table of answers.
fn answered(study: &Study, sat: &[Sat]) -> anyhow::Result<Table> {
    let mut rows = Vec::new();
    for sat in sat {
        let mut draws = Draws::new(0, sat.number.into());
        let levels = levels(&mut draws);
        for trial in &sat.trials {
            let latent = levels[mode_of(study, trial)] + draws.logistic();
            let answer = 1 + THRESHOLDS.iter().filter(|t| latent > **t).count() as i16;
            let asked = study.environment(&trial.environment).and_then(|e| e.question.clone());
            rows.extend(asked.map(|question| GivenAnswer {
                participant: sat.participant.clone(),
                session: sat.session.clone(),
                trial: trial.trial,
                environment: trial.environment.clone(),
                mode: trial.mode.clone(),
                question,
                answer: answer.into(),
                answer_time_s: None,
                counts: true,
                why_not: None,
            }));
        }
    }
    Ok(Table::of_rows(&rows)?)
}

/// What the job of the metrics does; the number of bytes of its tables.
fn metrics_job(
    study: &Study,
    sat: &[Sat],
    groups: Option<Groups>,
    file: &Path,
) -> anyhow::Result<usize> {
    let metrics = Measured::read(file, &METRICS.map(|(metric, ..)| metric))?;
    let found = compare(&metrics, &Parameters { groups, ..parameters(study, sat)? })?;
    let written = [
        bytes(&found.metrics, file)?,
        bytes(&found.cells, file)?,
        bytes(&found.means, file)?,
        bytes(&found.contrasts, file)?,
        bytes(&found.omnibus, file)?,
        bytes(&found.models, file)?,
        bytes(&found.participants, file)?,
        bytes(&found.groups, file)?,
        bytes(&found.group_means, file)?,
        bytes(&found.group_contrasts, file)?,
        bytes(&found.group_members, file)?,
        bytes(&found.group_models, file)?,
        bytes(&found.group_model_tests, file)?,
        bytes(&found.sessions, file)?,
        bytes(&found.learning, file)?,
        bytes(&found.repeats, file)?,
        bytes(&found.orders, file)?,
        bytes(&found.redrawn, file)?,
        bytes(&found.notes, file)?,
    ];
    Ok(written.iter().sum())
}

/// The size of the table of some rows.
fn bytes<R: Row>(rows: &[R], file: &Path) -> anyhow::Result<usize> {
    Ok(Table::of_rows(rows)?.to_parquet(&BTreeMap::new(), file)?.len())
}

fn parameters(study: &Study, sat: &[Sat]) -> anyhow::Result<Parameters> {
    let ids = || study.environments.iter().map(|environment| environment.id.clone());
    let modes = || study.modes.iter().map(|mode| mode.id.clone());
    let order = |sat: &Sat| SessionOrder {
        participant: sat.participant.clone(),
        session: sat.session.clone(),
        drawn: Some(DrawnOrder {
            rules: Rules::of(study, sat.number, 1),
            seed: Some(SEED),
            familiarisation: study.design.familiarisation,
            environments: ids().collect(),
            modes: modes().collect(),
            repeated: Vec::new(),
        }),
    };
    let metric = |(metric, ..): &(&str, &str, bool)| -> anyhow::Result<MetricParameters> {
        Ok(MetricParameters {
            metric: metric.parse()?,
            chosen_after: None,
            primary: study.compare.primary.has(metric),
            better: zwidth_study::Better::Lower,
            preregistered: None,
            bounds: vec![None; study.environments.len()],
            noticed: None,
        })
    };
    Ok(Parameters {
        metrics: METRICS.iter().map(metric).collect::<Result<_, _>>()?,
        environments: ids().collect(),
        modes: modes().collect(),
        contrasts: study.compare.contrasts.clone(),
        families: study.compare.families,
        curve_claims: 0,
        alpha: study.compare.alpha,
        level: study.compare.level,
        effect_sizes: study.compare.effect_sizes.clone(),
        groups: None,
        covariates: Vec::new(),
        over: None,
        effects: Vec::new(),
        dose_curves: Vec::new(),
        orders: sat.iter().map(order).collect(),
    })
}

/// Everybody in one of two groups, in turns.
fn halves(sat: &[Sat]) -> anyhow::Result<Groups> {
    let levels = vec!["novice".parse()?, "expert".parse()?];
    let contrast = GroupContrast { group: "expert".parse()?, against: "novice".parse()? };
    let compared = GroupsCompared {
        column: "group".parse()?,
        levels,
        assigned: false,
        contrasts: vec![contrast],
    };
    let levels_of = sat.iter().enumerate().map(|(i, sat)| (sat.participant.clone(), i % 2));
    Ok(Groups { compared, levels_of: levels_of.collect(), blocks: BTreeMap::new() })
}

/// What the job of the answers does.
fn answers_job(study: &Study, file: &Path) -> anyhow::Result<usize> {
    let parameters = AnswerParameters {
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        questions: study.questions.clone(),
        contrasts: study.compare.contrasts.clone(),
        level: study.compare.level,
    };
    let answers = Table::from_parquet(file)?.to_rows::<GivenAnswer>()?;
    let found = compare_answers(&answers, &parameters)?;
    let ratios: Option<Vec<f64>> = found.contrasts.iter().map(|row| row.odds_ratio).collect();
    ratios.context("a model of the answers has no end")?;
    Ok(bytes(&found.contrasts, file)? + bytes(&found.participants, file)?)
}
