//! `zwidth power`: how many participants a study needs to find a difference, by simulating studies
//! and testing them as `compare` does; and a plan to deposit before data are taken.

use super::recover::lock;
use crate::exit::Exit;
use crate::limits::{MOST_PARTICIPANTS, positive};
use crate::screen::Screen;
use crate::text::read_beside;
use anyhow::{Context as _, bail};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use zwidth_plan as plan;
use zwidth_plan::CurveSpread;
use zwidth_results::{EffectLevels, GroupEffect, ModeDifference, Model, Sides, UnitOfAnalysis};
use zwidth_stats::Unestimable;
use zwidth_stats::curve::LEAST_FOR_A_CLAIM as LEAST_OF_CURVES;
use zwidth_stats::curve_power::{CurvePlan, curve_power};
use zwidth_stats::groups::LEAST_FOR_A_CLAIM;
use zwidth_stats::power::{
    self, DifferenceSearch, HALVINGS, ParticipantSearch, Plan, PlannedTest, Power, Searched,
    Simulation,
};
use zwidth_store::{Raw, RealFiles, StudyData, hex_blake3, write_new};
use zwidth_study::{
    Curve, Effect, LevelContrast, Study, StudyId, Term, contrast_label, counted, curve_label,
};
use zwidth_tables::{Amounts, number, shown_unit, with_unit};

#[derive(Debug, clap::Args)]
pub(crate) struct PowerArgs {
    /// The study: its repeats, modes, alpha and contrasts are planned with
    pub(crate) study: StudyId,
    /// The true difference between two modes, or the true effect, in the metric's SI unit; of ln_jnd_TASK the natural
    /// logarithm of a ratio, 0.336 for one of 1.4
    #[arg(long, value_name = "D", value_parser = positive)]
    pub(crate) difference: f64,
    /// The effect of a factor, an interaction (`motor:brake`) or a weighted contrast in place of a difference
    /// between two modes
    #[arg(long, value_name = "EFFECT")]
    pub(crate) effect: Option<Term>,
    /// Number of participants
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=MOST_PARTICIPANTS))]
    pub(crate) participants: Option<u32>,
    /// Participants of two groups: then the difference is that of the groups in what is compared between modes, or in
    /// the effect
    #[arg(long, value_name = "N,N", value_delimiter = ',', conflicts_with = "participants", value_parser = clap::value_parser!(u32).range(2..=MOST_PARTICIPANTS))]
    pub(crate) groups: Vec<u32>,
    /// The metric's column in the table of metrics [default: the primary one, the first of several]
    #[arg(long, value_name = "METRIC")]
    pub(crate) metric: Option<String>,
    /// A whole curve in place of a metric: the difference is along it, or between two places of it, and people's curves
    /// scatter as those of the study's own trials
    #[arg(long, value_name = "CURVE", value_parser = curves(), conflicts_with_all = ["metric", "groups", "participant_sd", "participant_mode_sd", "residual_sd"])]
    pub(crate) curve: Option<Curve>,
    /// Where along the curve the difference is, from and to, in degrees, millimetres or seconds [default: everywhere]
    #[arg(
        long,
        value_name = "FROM,TO",
        value_delimiter = ',',
        requires = "curve",
        allow_negative_numbers = true
    )]
    pub(crate) between: Vec<f64>,
    /// Standard deviation of participants' levels [default: that of the study's own trials]
    #[arg(long, value_name = "SD", value_parser = positive)]
    pub(crate) participant_sd: Option<f64>,
    /// Standard deviation of participants' own effects of a mode [default: likewise]
    #[arg(long, value_name = "SD", value_parser = positive)]
    pub(crate) participant_mode_sd: Option<f64>,
    /// Standard deviation of repeats [default: likewise]
    #[arg(long, value_name = "SD", value_parser = positive)]
    pub(crate) residual_sd: Option<f64>,
    /// Number of studies that are simulated [default: 2000, of whole curves 500]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=100_000))]
    pub(crate) studies: Option<u32>,
    /// Seed of the simulated studies
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the plan to raw/STUDY/plan.json, to deposit before data are taken: `compare` then says
    /// whether the analysis is that one
    #[arg(long)]
    pub(crate) plan: bool,
}

fn curves() -> impl TypedValueParser<Value = Curve> {
    let words = Curve::ALL.map(Curve::as_str);
    PossibleValuesParser::new(words).try_map(|word| Curve::from_word(&word).ok_or("no such curve"))
}

/// The power that a study is planned with.
const TARGET: f64 = 0.8;
/// Participants where none are named: as many as the smallest studies have.
const PARTICIPANTS: usize = 12;
/// Studies that are simulated where no number is named; each of whole curves takes as long as a hundred others.
const STUDIES: usize = 2000;
const STUDIES_OF_CURVES: usize = 500;
/// No study of whole curves is simulated with more participants: each takes a tenth of a second.
const MOST_OF_CURVES: usize = 200;
/// Halvings of a searched difference of whole curves: to a hundredth, as near as so few studies tell.
const HALVINGS_OF_CURVES: usize = 7;

/// What was planned and found, as printed with `--json` and written as a plan.
#[derive(Debug, Serialize)]
struct Planned {
    study: String,
    /// The study.toml that says contrasts, metrics, alpha and bounds, as it is now, and its BLAKE3.
    study_toml: String,
    study_blake3: String,
    /// What is compared, and in which design.
    analysis: Value,
    /// Trials that were there already.
    trials_before: usize,
    metric: String,
    /// What of factors is planned for; none of a difference between two modes.
    #[serde(skip_serializing_if = "Option::is_none")]
    effect: Option<Term>,
    /// In the metric's SI unit, as the SDs.
    difference: f64,
    /// Where along a whole curve, in radians or seconds; none everywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    between: Option<[f64; 2]>,
    /// None of these of a whole curve, which scatters as people's own curves.
    #[serde(flatten)]
    spread: Option<Deviations>,
    /// Where the SDs come from.
    source: String,
    repeats: usize,
    participants: usize,
    /// Of these in each of two groups; none where modes are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    groups: Option<[usize; 2]>,
    alpha: f64,
    seed: u64,
    studies: usize,
    power: f64,
    power_ci_low: f64,
    power_ci_high: f64,
    /// The fewest participants with a power of 80 %; none if 10,000 do not have it.
    participants_needed: Option<usize>,
    /// The smallest difference that the participants named find with a power of 80 %; none if none is.
    smallest_difference: Option<f64>,
}

/// The standard deviations that are simulated, in the metric's SI unit.
#[derive(Debug, Clone, Copy, Serialize)]
struct Deviations {
    participant_sd: f64,
    participant_mode_sd: f64,
    residual_sd: f64,
}

/// What is simulated, and how it is tested.
enum Planning {
    Values(Plan, PlannedTest),
    Curves(CurvePlan),
}

impl Planning {
    fn participants(&self) -> usize {
        match self {
            Self::Values(plan, _) => plan.participants,
            Self::Curves(plan) => plan.participants,
        }
    }

    /// The power of so many participants with that difference.
    fn power(
        &self,
        participants: usize,
        difference: f64,
        simulation: &Simulation,
    ) -> Result<Power, Unestimable> {
        match self {
            Self::Values(plan, _) => {
                power::power(&Plan { participants, difference, ..*plan }, simulation)
            }
            Self::Curves(plan) => {
                let Simulation { alpha, studies, seed, .. } = *simulation;
                let plan = CurvePlan { participants, difference, ..plan.clone() };
                curve_power(&plan, alpha, studies, seed)
            }
        }
    }

    /// The search for the smallest difference that these studies find.
    fn search(&self, studies: usize) -> DifferenceSearch {
        let (start, halvings) = match self {
            Self::Values(plan, _) => (plan.difference_std_error(), HALVINGS),
            Self::Curves(plan) => (plan.difference_std_error(), HALVINGS_OF_CURVES),
        };
        DifferenceSearch {
            target: TARGET,
            start,
            halvings,
            participants: self.participants() * studies,
        }
    }
}

/// The SDs that a plan rests on.
struct Spread {
    participant: f64,
    participant_mode: f64,
    residual: f64,
    source: String,
}

pub(crate) fn power(root: &Path, command: &PowerArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let data = super::load(root, &command.study)?;
    let layout = &data.layout;
    let compare = &data.study.compare;
    let repeats = usize::try_from(data.study.design.repeats)?;
    let groups = match *command.groups.as_slice() {
        [first, second] => {
            if compare.groups.is_none() {
                bail!(
                    "--groups: {} compares no groups; name them in [compare] groups",
                    layout.study()
                );
            }
            let groups = [usize::try_from(first)?, usize::try_from(second)?];
            if groups.iter().any(|people| *people < LEAST_FOR_A_CLAIM) {
                bail!("--groups: a claim takes {LEAST_FOR_A_CLAIM} participants in each group");
            }
            Some(groups)
        }
        [] => None,
        _ => bail!("--groups: give the participants of two groups, such as 8,8"),
    };
    let participants = match groups {
        Some([first, second]) => first + second,
        None => command.participants.map_or(Ok(PARTICIPANTS), usize::try_from)?,
    };
    if command.curve.is_some() && participants > MOST_OF_CURVES {
        bail!("--participants: of whole curves at most {MOST_OF_CURVES} are simulated");
    }
    let between = between(command, &data.study)?;
    let (metric, planning, source, claims) = match command.curve {
        Some(curve) => {
            let (spread, source) = spread_of_curve(&data, command, curve, screen)?;
            let is_there = |place: &f64| {
                between.is_none_or(|[from, to]: [f64; 2]| from <= *place && *place <= to)
            };
            let differs: Vec<bool> = spread.places.iter().map(is_there).collect();
            if !differs.contains(&true) {
                bail!("--between: no place that all participants reach lies between these");
            }
            let plan = CurvePlan {
                known: spread.differences,
                lengths: spread.lengths,
                differs,
                difference: command.difference,
                participants,
            };
            if plan.difference_std_error() <= 0.0 {
                bail!(
                    "people's curves do not scatter there, so that nothing tells how many it takes"
                );
            }
            let claims = plan::claims(&data.study, curve.as_str());
            (curve.as_str().to_owned(), Planning::Curves(plan), source, claims)
        }
        None => {
            let metric = match &command.metric {
                Some(metric) => metric.clone(),
                None => {
                    let first = compare.primary.metrics().next();
                    first
                        .context(
                            "no metric is primary; name one with --metric, or a curve with --curve",
                        )?
                        .to_string()
                }
            };
            let spread = match &command.effect {
                None => spread(&data, command, &metric, screen)?,
                Some(effect) => spread_of_effect(&data, command, &metric, effect, screen)?,
            };
            let plan = Plan {
                participant_sd: spread.participant,
                interaction_sd: spread.participant_mode,
                residual_sd: spread.residual,
                repeats,
                modes: data.study.modes.len(),
                difference: command.difference,
                participants,
            };
            let test = groups.map_or(PlannedTest::PairedT, PlannedTest::Welch);
            let claims = plan::claims(&data.study, &metric);
            (metric, Planning::Values(plan, test), spread.source, claims)
        }
    };
    let (test, studies, most) = match &planning {
        Planning::Values(_, test) => (*test, STUDIES, power::MOST_PARTICIPANTS),
        Planning::Curves(_) => (PlannedTest::PairedT, STUDIES_OF_CURVES, MOST_OF_CURVES),
    };
    let simulation = Simulation {
        test,
        // Bonferroni: each claim of a family is tested at its share of alpha.
        alpha: compare.alpha / claims.max(1) as f64,
        studies: command.studies.map_or(Ok(studies), usize::try_from)?,
        seed: command.seed,
    };
    // In participants of all simulated studies.
    let bar = screen.bar(0);
    let search = planning.search(simulation.studies);
    let each = search.participants;
    let at = |participants, difference| planning.power(participants, difference, &simulation);
    let estimated = at(participants, command.difference)?;
    let needed = power::participants_for(
        &ParticipantSearch { target: TARGET, studies: simulation.studies, most },
        &|participants| at(participants, command.difference),
        &|searched| advance(&bar, searched, each, (search.halvings + 1) * each),
    )?;
    let before = usize::try_from(bar.position())?;
    let smallest = power::smallest_difference(
        &search,
        &|difference| at(participants, difference),
        &|searched| {
            advance(&bar, searched, before, 0);
        },
    )?;
    bar.finish_and_clear();
    let study_toml =
        read_beside(&layout.study_toml())?.context("there is no study.toml any more")?;
    let result = Planned {
        study: layout.study().to_string(),
        study_blake3: hex_blake3(study_toml.as_bytes()),
        study_toml,
        analysis: plan::analysis(&data.study),
        trials_before: data.counting().count(),
        metric,
        effect: command.effect.clone(),
        difference: command.difference,
        between,
        spread: match &planning {
            Planning::Values(plan, _) => Some(Deviations {
                participant_sd: plan.participant_sd,
                participant_mode_sd: plan.interaction_sd,
                residual_sd: plan.residual_sd,
            }),
            Planning::Curves(_) => None,
        },
        source,
        repeats,
        participants,
        groups,
        alpha: simulation.alpha,
        seed: simulation.seed,
        studies: simulation.studies,
        power: estimated.estimate,
        power_ci_low: estimated.ci_low,
        power_ci_high: estimated.ci_high,
        participants_needed: needed.map(|(participants, _)| participants),
        smallest_difference: smallest,
    };
    if command.plan {
        // The plan says how many trials there were before it.
        if let Some(unread) = data.problems.iter().find(|problem| problem.by_system) {
            bail!("{unread}; no plan was written");
        }
        let lock = lock(layout, "zwidth power")?;
        let raw = Raw::adds(&RealFiles, layout, &lock);
        let path = plan::plan_file(layout);
        if path.exists() {
            bail!("{} exists already; move it elsewhere to write a new plan", path.display());
        }
        write_new(&raw, &path, plan::plan_text(&result)?.as_bytes())?;
        screen.say(format!("{}: deposit a copy before data are taken", path.display()));
    }
    screen.give(&result, || screen.result(sentences(&data.study, &result).join("\n")))?;
    Ok(Exit::Fine)
}

/// How far the searches are: this one, after what was simulated `before` it, and with what the next
/// will simulate at least.
fn advance(bar: &ProgressBar, searched: Searched, before: usize, next: usize) {
    let done = before + searched.simulated;
    bar.set_length((done + searched.to_come + next) as u64);
    bar.set_position(done as u64);
}

/// Where along a curve the difference is, in radians or seconds; none everywhere.
fn between(command: &PowerArgs, study: &Study) -> anyhow::Result<Option<[f64; 2]>> {
    let (Some(curve), [_, ..]) = (command.curve, command.between.as_slice()) else {
        return Ok(None);
    };
    let (_, factor) = match curve.is_over_angle() {
        true => shown_unit("rad", study.coordinate),
        false => shown_unit("s", study.coordinate),
    };
    match *command.between.as_slice() {
        [from, to] if from < to => Ok(Some([from / factor, to / factor])),
        _ => bail!("--between: give two places of the curve, the smaller one first, such as 10,25"),
    }
}

/// People's curves in the comparison in which they differ most, and where they come from.
fn spread_of_curve(
    data: &StudyData,
    command: &PowerArgs,
    curve: Curve,
    screen: &Screen,
) -> anyhow::Result<(CurveSpread, String)> {
    let study = data.layout.study();
    let compared = &data.study.compare.curves;
    if !compared.contains(&curve) {
        bail!("--curve: {study} does not compare {}; name it in [compare] curves", curve.as_str());
    }
    if let Some(effect) = &command.effect {
        squared_weights(data, effect)?;
    }
    super::compare::make(data, screen)?;
    let mut spreads = plan::spreads_of_curve(data, curve)?;
    // Two modes differ in a contrast between them; effects are of other sizes.
    let has_contrasts = spreads.iter().any(|spread| matches!(spread.effect, GroupEffect::Of(_)));
    spreads.retain(|spread| match (&command.effect, &spread.effect) {
        (None, effect) => matches!(effect, GroupEffect::Of(_)) || !has_contrasts,
        (Some(asked), GroupEffect::OfFactors(effect)) => {
            let is_bend = |levels: &EffectLevels| levels.0.iter().any(LevelContrast::is_bend);
            effect.term == *asked && !effect.levels.as_ref().is_some_and(is_bend)
        }
        (Some(_), _) => false,
    });
    let most = spreads.iter().map(|spread| spread.differences.len()).max().unwrap_or(0);
    spreads.retain(|spread| spread.differences.len() >= LEAST_OF_CURVES);
    // The mean over nodes of the variance of people's differences.
    let variance = |spread: &CurveSpread| {
        let n = spread.differences.len() as f64;
        let nodes = spread.places.len();
        let of_node = |node: usize| {
            let mean = spread.differences.iter().map(|row| row[node]).sum::<f64>() / n;
            let squares = spread.differences.iter().map(|row| (row[node] - mean).powi(2));
            squares.sum::<f64>() / (n - 1.0)
        };
        (0..nodes).map(of_node).sum::<f64>() / nodes.max(1) as f64
    };
    let widest = spreads.into_iter().max_by(|a, b| variance(a).total_cmp(&variance(b)));
    let widest = widest.with_context(|| {
        format!(
            "{study} has the curves of {} in such a comparison, and it takes those of {LEAST_OF_CURVES} to tell how \
             people's curves scatter",
            counted(most, "participants")
        )
    })?;
    let simulated = data.counting().any(|trial| trial.meta.source.is_simulated());
    let mark = if simulated { "; SYNTHETIC: simulated data" } else { "" };
    let effect = match &widest.effect {
        GroupEffect::Of(contrast) => contrast_label(&data.study.modes, contrast),
        other => other.to_string(),
    };
    let place = widest.environment.as_ref().map(|id| {
        let environment = data.study.environment(id);
        format!("{}, ", environment.map_or(id.as_str(), |environment| &environment.label))
    });
    let source = format!(
        "from the study's own trials, {}{effect}: what {} differ in most{mark}",
        place.unwrap_or_default(),
        counted(widest.differences.len(), "participants")
    );
    Ok((widest, source))
}

/// The SDs of the command, or those of the study's own trials.
fn spread(
    data: &StudyData,
    command: &PowerArgs,
    metric: &str,
    screen: &Screen,
) -> anyhow::Result<Spread> {
    if let (Some(participant_mode), Some(residual)) =
        (command.participant_mode_sd, command.residual_sd)
    {
        let participant = command.participant_sd.unwrap_or(0.0);
        let source = "assumed".to_owned();
        return Ok(Spread { participant, participant_mode, residual, source });
    }
    if !plan::compared(data).iter().any(|compared| compared == metric) {
        bail!(
            "{} has no trials from which the spread of {metric} could be taken: \
             give --participant-mode-sd and --residual-sd",
            data.layout.study()
        );
    }
    super::compare::make(data, screen)?;
    let (contrasts, models) = plan::spreads(data, &metric.parse()?)?;
    let repeats = f64::from(data.study.design.repeats);
    let inflated = plan::inflation_by_groups(data);
    let widest = widest(&contrasts, &models, repeats, inflated, &data.study);
    let simulated = data.counting().any(|trial| trial.meta.source.is_simulated());
    let mark = if simulated { "; SYNTHETIC: simulated data" } else { "" };
    let widest = widest.with_context(|| {
        format!(
            "the trials of {} do not tell the spread of {metric} (one participant, or no mixed model): \
             give --participant-mode-sd and --residual-sd",
            data.layout.study()
        )
    })?;
    Ok(Spread { source: format!("from the study's own trials, {}{mark}", widest.source), ..widest })
}

/// The largest sum of squared weights of an effect that the study claims, but for bends over a dose.
fn squared_weights(data: &StudyData, effect: &Term) -> anyhow::Result<f64> {
    let is_it = |own: &&Effect| own.is_claimed && !own.levels.iter().any(LevelContrast::is_bend);
    let all = data.study.effects();
    let all: Vec<&Effect> = all.iter().filter(is_it).collect();
    let known: Vec<&&Effect> = all.iter().filter(|own| own.term == *effect).collect();
    let squares = |own: &Effect| own.weights.iter().map(|w| w.weight * w.weight).sum::<f64>();
    let widest = known.iter().map(|own| squares(own)).fold(0.0, f64::max);
    if widest > 0.0 {
        return Ok(widest);
    }
    if let Some(why) = known.iter().find_map(|own| own.lacks.as_deref()) {
        bail!("--effect {effect}: {why}");
    }
    let names: BTreeSet<String> = all.iter().map(|own| own.term.to_string()).collect();
    let names: Vec<String> = names.into_iter().collect();
    let names = if names.is_empty() { "no effects".to_owned() } else { names.join(", ") };
    bail!("--effect {effect}: {} compares {names}", data.layout.study())
}

/// The SDs of an effect, as those of a difference between two modes that scatters as much: those of the command
/// times √(Σw² / 2), w the effect's weights, or that of everybody's effects in the study's own trials.
fn spread_of_effect(
    data: &StudyData,
    command: &PowerArgs,
    metric: &str,
    effect: &Term,
    screen: &Screen,
) -> anyhow::Result<Spread> {
    let widest = squared_weights(data, effect)?;
    if command.participant_mode_sd.is_some() && command.residual_sd.is_some() {
        let scale = (widest / 2.0).sqrt();
        let Spread { participant, participant_mode, residual, source } =
            spread(data, command, metric, screen)?;
        let source = format!("{source}, times √(Σw² / 2) = {} of {effect}", number(scale, None));
        let (participant_mode, residual) = (scale * participant_mode, scale * residual);
        return Ok(Spread { participant, participant_mode, residual, source });
    }
    super::compare::make(data, screen)?;
    let found = match plan::compared(data).iter().any(|compared| compared == metric) {
        true => plan::effects(data, &metric.parse()?)?,
        false => Vec::new(),
    };
    let is_bend = |levels: &EffectLevels| levels.0.iter().any(LevelContrast::is_bend);
    let of_effect = found
        .into_iter()
        .filter(|row| row.effect == *effect && !row.levels.as_ref().is_some_and(is_bend));
    let inflated = plan::inflation_by_groups(data);
    let widest = of_effect.filter_map(|row| {
        let variance = row.difference_std_error?.powi(2) * row.n as f64 / inflated;
        let of = row.levels.map(|levels| format!(" ({levels})")).unwrap_or_default();
        Some((variance, of))
    });
    let widest = widest.max_by(|(a, _), (b, _)| a.total_cmp(b));
    let (variance, of) = widest.with_context(|| {
        format!(
            "the trials of {} do not tell the spread of {effect} on {metric}: \
             give --participant-mode-sd and --residual-sd",
            data.layout.study()
        )
    })?;
    let simulated = data.counting().any(|trial| trial.meta.source.is_simulated());
    let mark = if simulated { "; SYNTHETIC: simulated data" } else { "" };
    let source = format!(
        "from the study's own trials, {effect}{of}, in which participants differ most, with what their repeats add{mark}"
    );
    Ok(Spread {
        participant: 0.0,
        participant_mode: (variance / 2.0).sqrt(),
        residual: 0.0,
        source,
    })
}

/// The spread of the contrast in which participants differ most. Their differences scatter with
/// 2 (σ² of their own mode effects + σ² of repeats / repeats): each contrast has its own, where a
/// model of all modes would pool those in which people differ little with those in which they
/// differ much. None where the claims are not about participants. `inflated` is
/// [`plan::inflation_by_groups`].
fn widest(
    contrasts: &[ModeDifference],
    models: &[Model],
    repeats: f64,
    inflated: f64,
    study: &Study,
) -> Option<Spread> {
    let spreads = contrasts.iter().filter_map(|row| {
        let model = models.iter().find(|model| model.environment == row.environment)?;
        let is_of_people = row.unit_of_analysis == UnitOfAnalysis::Participants;
        let residual = model.residual_sd.filter(|_| is_of_people)?;
        let variance = row.difference_std_error?.powi(2) * row.n as f64 / inflated;
        let of_repeats = 2.0 * residual.powi(2) / (repeats * row.sessions?.max(1) as f64);
        // An estimated variance can come out below that of the repeats alone.
        let own = ((variance - of_repeats).max(0.0) / 2.0).sqrt();
        let environment = study.environments.iter().find(|e| e.id == row.environment);
        let source = format!(
            "{}, {}: the contrast in which participants differ most",
            environment.map_or(row.environment.as_str(), |e| e.label.as_str()),
            contrast_label(&study.modes, &row.contrast)
        );
        let participant = model.participant_sd?;
        Some((variance, Spread { participant, participant_mode: own, residual, source }))
    });
    spreads.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, spread)| spread)
}

/// How differences of a metric of logarithms are read, and what they are between; none of another metric.
fn ratio(study: &Study, result: &Planned) -> Option<(Amounts, Sides)> {
    let (task, quantity) = study.task_metric(&result.metric)?;
    let is_between_differences =
        result.groups.is_some() || result.effect.as_ref().is_some_and(|effect| effect.0.len() > 1);
    let sides = if is_between_differences { Sides::Differences } else { Sides::Values };
    let amounts = Amounts::of(&task.metric_unit(quantity), study.coordinate);
    amounts.are_logarithms().then_some((amounts, sides))
}

/// A difference as a text of it, and behind that of logarithms the ratio.
fn told(text: String, difference: f64, ratio: Option<&(Amounts, Sides)>) -> String {
    match ratio {
        None => text,
        Some((amounts, sides)) => {
            format!("{text} ({})", amounts.told(difference, None, None, *sides).text)
        }
    }
}

/// The result in sentences.
fn sentences(study: &Study, result: &Planned) -> [String; 4] {
    let Planned { metric, difference, participants, studies, alpha, source, .. } = result;
    let curve = Curve::from_word(metric).filter(|_| result.spread.is_none());
    let named = match curve {
        Some(curve) => Some(curve_label(curve, study.coordinate)),
        None => plan::metric_in_words(study, metric),
    };
    let named = named.map(|words| format!("{words} ({metric})"));
    let effect = result.effect.as_ref().map(|effect| effect.to_string().replace(':', " × "));
    let what = match (effect, result.groups) {
        (None, None) => "two modes differ by".to_owned(),
        (Some(effect), None) => format!("the effect of {effect} is"),
        (None, Some(_)) => "the difference between two modes differs between groups by".to_owned(),
        (Some(effect), Some(_)) => format!("the effect of {effect} differs between groups by"),
    };
    let place = curve.map(|curve| match result.between {
        None => " along the whole curve".to_owned(),
        Some(ends) => {
            let unit = if curve.is_over_angle() { "rad" } else { "s" };
            let (unit, factor) = shown_unit(unit, study.coordinate);
            let [from, to] = ends.map(|end| with_unit(&number(end * factor, None), &unit));
            format!(" between {from} and {to}")
        }
    });
    let place = place.unwrap_or_default();
    let people = match result.groups {
        Some([first, second]) => format!("{first} and {second}"),
        None => participants.to_string(),
    };
    let [power, low, high] =
        [result.power, result.power_ci_low, result.power_ci_high].map(|share| 100.0 * share);
    let alpha = number(*alpha, None);
    let ratio = ratio(study, result);
    let ratio = ratio.as_ref();
    let units = match ratio {
        Some(_) => "natural logarithms: e to the power of a difference is a ratio",
        None => "in the metric's SI unit",
    };
    [
        format!(
            "{}: if {what} {}{place}, a study of {people} participants finds it with a \
             probability (power) of {power:.1} % ({low:.1} to {high:.1} %, from {studies} simulated studies).",
            named.unwrap_or_else(|| metric.clone()),
            told(difference.to_string(), *difference, ratio),
        ),
        match result.participants_needed {
            Some(needed) if result.groups.is_some() => format!(
                "For a power of 80 % it takes {needed} participants, in groups of such a ratio."
            ),
            Some(needed) => format!("For a power of 80 % it takes {needed} participants."),
            None if curve.is_some() => {
                format!("Even {MOST_OF_CURVES} participants do not reach a power of 80 %.")
            }
            None => "Even 10,000 participants do not reach a power of 80 %.".to_owned(),
        },
        match result.smallest_difference {
            Some(smallest) => format!(
                "The smallest difference that {people} participants find with a power of 80 % is {}.",
                told(format!("{smallest:.4}"), smallest, ratio)
            ),
            None => format!(
                "{people} participants find no difference with a power of 80 %, however large: the signs of so few \
                 reach no p value that is small enough."
            ),
        },
        match &result.spread {
            Some(spread) => format!(
                "This rests on these standard deviations ({source}): {:.4} between participants, {:.4} between \
                 participants in how they respond to a mode, {:.4} between repeats. Each contrast is tested at a level \
                 of {alpha}. All differences and deviations are {units}.",
                spread.participant_sd, spread.participant_mode_sd, spread.residual_sd,
            ),
            None => format!(
                "Simulated people's curves scatter as those known ({source}). The largest t along the curve is tested by \
                 flipped signs at a level of {alpha}. Differences are in the curve's SI unit."
            ),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::Verdict;

    fn found(unit: UnitOfAnalysis) -> (Vec<ModeDifference>, Vec<Model>) {
        let contrast = |against: &str, error: f64| ModeDifference {
            metric: "step_n".parse().unwrap(),
            unit: "N".into(),
            environment: "spring".parse().unwrap(),
            contrast: format!("hybrid − {against}").parse().unwrap(),
            unit_of_analysis: unit.clone(),
            n: 4,
            sessions: Some(1),
            mean_first: 0.1,
            mean_second: 0.2,
            difference: -0.1,
            difference_std_error: Some(error),
            difference_ci_low: Some(-0.15),
            difference_ci_high: Some(-0.05),
            statistic: None,
            df: Some(5.0),
            p_value: None,
            p_adjusted: Some(0.0123),
            smallest_p_adjusted: None,
            g_av: None,
            d_av: None,
            d_av_ci_low: None,
            d_av_ci_high: None,
            g_z: None,
            d_z: None,
            d_z_ci_low: None,
            d_z_ci_high: None,
            p_sign_flip: None,
            p_signed_rank: None,
            p_sharp_null: None,
            commanded: None,
            jnd: None,
            difference_jnd: None,
            difference_jnd_ci_low: None,
            difference_jnd_ci_high: None,
            size: None,
            bound: None,
            p_not_equivalent: None,
            verdict: Verdict::Undecided,
            remark: None,
        };
        let model = Model {
            metric: "step_n".parse().unwrap(),
            unit: "N".into(),
            environment: "spring".parse().unwrap(),
            contrast: "hybrid − active".parse().unwrap(),
            n: Some(4),
            trials: 8,
            difference: None,
            difference_std_error: None,
            difference_ci_low: None,
            difference_ci_high: None,
            df: None,
            p_value: None,
            df_satterthwaite: None,
            p_satterthwaite: None,
            participant_sd: Some(0.3),
            participant_mode_sd: None,
            residual_sd: Some(0.2),
            random_terms: None,
            singular: None,
            remark: None,
        };
        (vec![contrast("active", 0.1), contrast("passive", 0.2)], vec![model])
    }

    #[test]
    fn groups_are_two_numbers_with_a_comma() {
        use crate::args::{Args, Command};
        use clap::Parser as _;
        let of = |groups: &[&str]| {
            let line = ["zwidth", "power", "--difference", "1"];
            match Args::try_parse_from([&line[..], groups, &["study"]].concat()) {
                Ok(Args { command: Command::Power(command), .. }) => Some(command.groups),
                _ => None,
            }
        };
        assert_eq!(of(&["--groups", "8,10"]), Some(vec![8, 10]));
        assert_eq!(of(&[]), Some(Vec::new()));
        assert_eq!(of(&["--groups", "8,8", "--participants", "16"]), None);
        assert_eq!(of(&["--groups", "8,x"]), None);
    }

    /// Differences have variances 4 · 0.1² and 4 · 0.2², of which two repeats explain 2 · 0.2² / 2.
    #[test]
    fn the_spread_is_that_of_the_contrast_in_which_participants_differ_most() {
        let (contrasts, models) = found(UnitOfAnalysis::Participants);
        let found = widest(&contrasts, &models, 2.0, 1.0, &zwidth_testing::study()).unwrap();
        assert!((found.participant_mode - (0.12_f64 / 2.0).sqrt()).abs() < 1e-12);
        assert!((found.participant - 0.3).abs() < 1e-12 && (found.residual - 0.2).abs() < 1e-12);
        assert!(found.source.starts_with("Spring, Hybrid − Passive"), "{}", found.source);
    }

    #[test]
    fn a_difference_of_logarithms_is_told_as_a_ratio_too() {
        let amounts = Amounts::of("ln N/rad", zwidth_study::Coordinate::Rotational);
        let read = |sides| told(0.336.to_string(), 0.336, Some(&(amounts.clone(), sides)));
        assert_eq!(told(0.336.to_string(), 0.336, None), "0.336");
        assert_eq!(read(Sides::Values), "0.336 (1.399 times)");
        assert_eq!(read(Sides::Differences), "0.336 (1.399 times as large a ratio)");
    }

    #[test]
    fn trials_of_one_participant_tell_no_spread_of_people() {
        let (contrasts, models) = found(UnitOfAnalysis::TrialsOf("P01".parse().unwrap()));
        assert!(widest(&contrasts, &models, 2.0, 1.0, &zwidth_testing::study()).is_none());
    }
}
