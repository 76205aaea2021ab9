//! What the comparison of modes says, in a matrix and in sentences.

use crate::findings::Finding;
use crate::gallery::Shown;
use crate::people::capital;
use serde::Serialize;
use zwidth_results::{
    Compared, EffectDifference, FactorTest, GroupDifference, GroupMember, Mean, ModeDifference,
    PersonValue, RedrawnDifference, Role, Sentence, Sides, Size, UnitOfAnalysis, Verdict,
};
use zwidth_study::{
    Better, Coordinate, EnvironmentId, ModeId, Setup, Study, contrast_label, in_a_sentence,
    ratio_label,
};
use zwidth_tables::{Amounts, in_coordinate, number, p_value};

/// How study.toml names primary metrics. They may not be among those compared: trials of the study may
/// not have them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Primaries {
    /// Not at all: one is primary by default.
    ByDefault,
    /// By one name.
    Named,
    /// By several.
    Several,
    /// By whole curves alone: every metric is exploratory.
    Curves,
}

impl Primaries {
    /// Those of a study.
    pub fn of(study: &Study) -> Self {
        match &study.compare {
            compare if !compare.is_primary_named => Self::ByDefault,
            compare if compare.primary.metrics().next().is_none() => Self::Curves,
            compare if compare.primary.are_several() => Self::Several,
            _ => Self::Named,
        }
    }
}

/// The results for a metric.
#[derive(Debug, Clone, Copy)]
pub struct ComparedMetric<'a> {
    /// The metric.
    pub metric: &'a Compared,
    /// How study.toml names those that are primary.
    pub primary: Primaries,
    /// Means by condition.
    pub means: &'a [Mean],
    /// Differences between modes.
    pub contrasts: &'a [ModeDifference],
    /// Differences between groups, if there are groups.
    pub groups: &'a [GroupDifference],
    /// Who is of which group.
    pub group_members: &'a [GroupMember],
    /// Everybody's effects of factors, and values in which groups are compared.
    pub person_values: &'a [PersonValue],
    /// Effects of factors, if there are factors.
    pub effects: &'a [EffectDifference],
    /// Their analysis of variance.
    pub factor_tests: &'a [FactorTest],
    /// The differences in other orders of one participant's trials, had none depended on mode.
    pub redrawn: &'a [RedrawnDifference],
}

impl ComparedMetric<'_> {
    /// What it is, as people of the study say it.
    pub(crate) fn words(&self, coordinate: Coordinate) -> String {
        in_coordinate(&self.metric.words, coordinate)
    }

    /// How its numbers are read.
    pub(crate) fn amounts(&self, study: &Setup) -> Amounts {
        Amounts::of(&self.metric.unit, study.coordinate)
    }
}

/// Means by metric, environment and mode.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Matrix {
    /// The modes and their labels.
    pub modes: Vec<(ModeId, String)>,
    /// One row per metric and environment.
    pub rows: Vec<MatrixRow>,
    /// A sentence on the content of the cells.
    pub caption: String,
}

/// A metric in one environment.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MatrixRow {
    /// The metric in words, with its unit.
    pub metric: String,
    /// The environment.
    pub environment: EnvironmentId,
    /// Its label.
    pub label: String,
    /// One cell per mode, if it has a mean: `1.617 ± 0.029 (6)`.
    pub cells: Vec<Option<String>>,
}

/// The means of every metric, environment and mode, as people read them.
pub fn matrix(study: &Setup, metrics: &[ComparedMetric]) -> Matrix {
    let mut matrix = Matrix {
        modes: study.modes.iter().map(|mode| (mode.id.clone(), mode.label.clone())).collect(),
        ..Matrix::default()
    };
    for metric in metrics {
        let amounts = metric.amounts(study);
        let unit = match amounts.unit() {
            "1" => String::new(),
            unit => format!(" ({unit})"),
        };
        for environment in &study.environments {
            let cells = study.modes.iter().map(|mode| {
                let mut means = metric.means.iter();
                let mean =
                    means.find(|m| (&m.environment, &m.mode) == (&environment.id, &mode.id))?;
                Some(format!("{} ({})", amounts.mean(mean.mean, mean.sd), mean.n))
            });
            let cells: Vec<Option<String>> = cells.collect();
            // A metric that no mode of this environment has gets no row.
            if cells.iter().any(Option::is_some) {
                matrix.rows.push(MatrixRow {
                    metric: format!("{}{unit}", metric.words(study.coordinate)),
                    environment: environment.id.clone(),
                    label: environment.label.clone(),
                    cells,
                });
            }
        }
        if matrix.caption.is_empty() && !metric.means.is_empty() {
            matrix.caption = match &metric.metric.unit_of_analysis {
                UnitOfAnalysis::TrialsOf(who) => format!(
                    "Mean ± standard deviation within {who}; in brackets the number of trials. \
                     Nothing is said of anybody else."
                ),
                UnitOfAnalysis::Participants if !metric.groups.is_empty() => {
                    "Mean of the groups' means, each group with the same weight, ± standard deviation within \
                     groups; in brackets the number of participants."
                        .to_owned()
                }
                UnitOfAnalysis::Participants => {
                    "Mean ± standard deviation over participants; in brackets their number."
                        .to_owned()
                }
            };
        }
    }
    if metrics.iter().any(|own| !own.means.is_empty() && own.amounts(study).are_logarithms()) {
        matrix.caption += GEOMETRIC;
    }
    matrix
}

/// How means of a metric of logarithms stand in the matrix.
const GEOMETRIC: &str =
    " Means of JNDs are geometric; ×/÷ is the factor of one standard deviation.";

/// The metrics that claims rest on, before the others; without one the first, unless a whole curve is primary.
pub fn primary_first<'a, 'b>(metrics: &'a [ComparedMetric<'b>]) -> [&'a [ComparedMetric<'b>]; 2] {
    let primary = metrics.iter().take_while(|metric| metric.metric.role == Role::Primary).count();
    let least = usize::from(metrics.first().is_some_and(|one| one.primary != Primaries::Curves));
    <[_; 2]>::from(metrics.split_at(primary.max(least)))
}

/// What the contrasts of primary metrics say: first the answers, then every contrast in a sentence with
/// effect, interval, n and unit. For each other metric, one sentence with its differences.
pub fn contrasts(study: &Setup, metrics: &[ComparedMetric]) -> Vec<Finding> {
    let [primary, others] = primary_first(metrics);
    let Some(first) = primary.first() else { return others_in_brief(study, others).collect() };
    if primary.iter().all(|metric| metric.contrasts.is_empty()) {
        let mut modes: Vec<&ModeId> = first.means.iter().map(|mean| &mean.mode).collect();
        modes.dedup();
        let words = first.words(study.coordinate);
        let text = format!(
            "Nobody has trials in both modes of a contrast, so no difference between modes in {words} can be told."
        );
        let has_reason = modes.len() > 1 && first.effects.is_empty();
        return if has_reason { vec![finding(first, text)] } else { Vec::new() };
    }
    let compared = primary.iter().filter(|metric| !metric.contrasts.is_empty());
    let answers = compared.clone().map(|metric| finding(metric, answer(study, metric)));
    let mut findings: Vec<Finding> =
        answers.map(|answer| Finding { is_answer: true, ..answer }).collect();
    for metric in compared {
        let words = metric.words(study.coordinate);
        let rows = metric.contrasts.iter();
        findings
            .extend(rows.map(|row| finding(metric, difference(study, metric, row, Some(&words)))));
    }
    findings.extend(others_in_brief(study, others));
    findings
}

fn finding(metric: &ComparedMetric, text: String) -> Finding {
    Finding::new(text, Shown::Compared(metric.metric.metric.to_string()))
}

/// For each exploratory metric one sentence with its differences.
fn others_in_brief(study: &Setup, others: &[ComparedMetric]) -> impl Iterator<Item = Finding> {
    others.iter().filter(|metric| !metric.contrasts.is_empty()).map(|metric| {
        let rows = metric.contrasts.iter();
        let briefs: Vec<String> = rows.map(|row| difference(study, metric, row, None)).collect();
        let words = metric.words(study.coordinate);
        let role = metric.metric.role.of_findings();
        finding(metric, format!("{role}, {words}: {}.", briefs.join("; ")))
    })
}

/// The most differences that the answer names.
const NAMED: usize = 4;

/// Each contrast with direction, size, unit and verdict, and how many people; if no contrast has a
/// test, that nothing was tested.
fn answer(study: &Setup, metric: &ComparedMetric) -> String {
    let words = metric.words(study.coordinate);
    let contrasts = metric.contrasts;
    let within = match &metric.metric.unit_of_analysis {
        UnitOfAnalysis::TrialsOf(who) => format!("Within {who}, "),
        UnitOfAnalysis::Participants => String::new(),
    };
    let role = match (metric.metric.role, metric.primary) {
        (Role::Primary, Primaries::Named) => "the primary metric",
        (Role::Primary, Primaries::ByDefault) => "the primary metric by default",
        (Role::Primary, Primaries::Several | Primaries::Curves) => "a primary metric",
        (Role::Exploratory, Primaries::Several) => "exploratory: not a primary metric",
        (Role::Exploratory, _) => "exploratory: not the primary metric",
        (Role::ChosenAfter, _) => "exploratory: chosen after the data",
    };
    if contrasts.iter().all(|row| row.p_adjusted.is_none()) {
        return capital(&format!(
            "{within}it was not tested whether the modes differ in {words} ({role}): none of {} contrasts has a test.",
            contrasts.len()
        ));
    }
    let better = match metric.metric.better {
        Better::Neither => String::new(),
        better => format!(", {} is better", better.as_str()),
    };
    // `n = 4 participants`, `n = 3 to 4 participants`: over all contrasts.
    let sizes = contrasts.iter().map(|row| row.n);
    let least = sizes.clone().min().unwrap_or(0);
    let most = sizes.max().unwrap_or(0);
    let n = if least == most { least.to_string() } else { format!("{least} to {most}") };
    let unit = &metric.metric.unit_of_analysis;
    let mut text = capital(&format!("{within}{words} ({role}{better}; n = {n} {unit}): "));
    let directed: Vec<String> =
        contrasts.iter().take(NAMED).map(|row| directed(study, metric, row)).collect();
    text += &directed.join("; ");
    if contrasts.len() > NAMED {
        text += &format!("; and {} more", contrasts.len() - NAMED);
    }
    text += ".";
    let smallest = contrasts.iter().filter_map(|row| row.smallest_p_adjusted);
    match smallest.min_by(f64::total_cmp) {
        Some(p) => format!(
            "{text} The test compares the order of trials that was drawn with every other order that the design could \
             have drawn; with this design, no adjusted p can be below {}. The intervals only describe the trials.",
            number(p, None)
        ),
        None => text,
    }
}

/// A difference by its direction: `in Spring 0.94 N higher with Hybrid than with Active (0.89 to 0.99):
/// different, felt, 19 JND`; of logarithms `in Spring 1.40 times as large with Hybrid as with Active`.
fn directed(study: &Setup, metric: &ComparedMetric, row: &ModeDifference) -> String {
    let amounts = metric.amounts(study);
    let label = |id: &ModeId| {
        let mode = study.modes.iter().find(|mode| mode.id == *id);
        mode.map_or_else(|| id.to_string(), |mode| in_a_sentence(&mode.label))
    };
    let (mode, against) = (label(&row.contrast.mode), label(&row.contrast.against));
    let is_ratio = amounts.are_logarithms();
    let direction = match row.difference {
        _ if is_ratio => format!("as large with {mode} as with {against}"),
        d if d < 0.0 => format!("lower with {mode} than with {against}"),
        d if d > 0.0 => format!("higher with {mode} than with {against}"),
        _ => format!("between {mode} and {against}"),
    };
    let ends = row.difference_ci_low.zip(row.difference_ci_high);
    // Told as what is higher or lower, an interval has the sign of that.
    let (difference, ends) = match row.difference < 0.0 && !is_ratio {
        true => (-row.difference, ends.map(|(low, high)| (-high, -low))),
        false => (row.difference, ends),
    };
    let amount = amounts.told(difference, ends, row.difference_std_error, Sides::Values);
    let ends = amount.ends.map(|ends| format!(" ({ends})"));
    let felt = row.size.map(|size| {
        let jnds =
            row.difference_jnd.map(|jnds| format!(", {} JND", number(jnds.abs(), Some(1.0))));
        format!(", {}{}", size.as_str(), jnds.unwrap_or_default())
    });
    let best = row.best(metric.metric.better).map(|mode| format!(": {} is better", label(mode)));
    let remark = row.remark.as_ref().map(|why| format!(": {why}"));
    format!(
        "in {} {} {direction}{}, {}{}{}{}{}",
        environment_label(study, &row.environment),
        amount.text,
        ends.unwrap_or_default(),
        row.verdict.as_str(),
        row.p_adjusted.map(|p| format!(" (adjusted p {})", p_value(p))).unwrap_or_default(),
        felt.unwrap_or_default(),
        best.unwrap_or_default(),
        remark.unwrap_or_default(),
    )
}

pub(crate) fn environment_label(study: &Setup, id: &EnvironmentId) -> String {
    let environment = study.environments.iter().find(|environment| environment.id == *id);
    environment.map_or_else(|| id.to_string(), |environment| environment.label.clone())
}

/// The environment before what is compared in it; nothing over several environments.
pub(crate) fn before(study: &Setup, id: Option<&EnvironmentId>, separator: &str) -> String {
    id.map_or_else(String::new, |id| environment_label(study, id) + separator)
}

/// What came out of a comparison in a metric that is not primary.
pub(crate) struct Brief<'a> {
    /// What is compared, and where.
    pub(crate) place: String,
    /// In the metric's unit, with its standard error, the ends of its interval and what it is the difference of.
    pub(crate) difference: Option<f64>,
    pub(crate) error: Option<f64>,
    pub(crate) ends: Option<(f64, f64)>,
    pub(crate) sides: Sides,
    pub(crate) verdict: Verdict,
    pub(crate) size: Option<Size>,
    pub(crate) remark: Option<&'a Sentence>,
}

/// `Exploratory, the force: Spring, effect of motor (yes − no): 0.45 N (0.20 to 0.71, different, felt); …`; nothing of
/// none.
pub(crate) fn explored(
    study: &Setup,
    metric: &ComparedMetric,
    briefs: Vec<Brief>,
    shown: Shown,
) -> Option<Finding> {
    let amounts = metric.amounts(study);
    let texts = briefs.iter().map(|brief| {
        let size = brief.size.map(|size| format!(", {}", size.as_str())).unwrap_or_default();
        let why = brief.remark.map(|why| format!(": {why}")).unwrap_or_default();
        let verdict = brief.verdict.as_str();
        match brief.difference {
            Some(difference) => {
                let amount = amounts.told(difference, brief.ends, brief.error, brief.sides);
                let ends = amount.ends.map(|ends| format!("{ends}, ")).unwrap_or_default();
                format!("{}: {} ({ends}{verdict}{size}{why})", brief.place, amount.text)
            }
            None => format!("{}: {verdict}{why}", brief.place),
        }
    });
    let texts: Vec<String> = texts.collect();
    let words = metric.words(study.coordinate);
    let role = metric.metric.role.of_findings();
    (!texts.is_empty())
        .then(|| Finding::new(format!("{role}, {words}: {}.", texts.join("; ")), shown))
}

/// A difference between two modes in one environment: in a sentence of its own if the metric's
/// `words` are given, else in brief.
fn difference(
    study: &Setup,
    metric: &ComparedMetric,
    row: &ModeDifference,
    words: Option<&str>,
) -> String {
    let amounts = metric.amounts(study);
    let is_ratio = amounts.are_logarithms();
    let environment = environment_label(study, &row.environment);
    let compared = match is_ratio {
        true => ratio_label(&study.modes, &row.contrast),
        false => contrast_label(&study.modes, &row.contrast),
    };
    let place = format!("{environment}, {compared}");
    let ends = row.difference_ci_low.zip(row.difference_ci_high);
    let amount = amounts.told(row.difference, ends, row.difference_std_error, Sides::Values);
    let interval = amount.ends.map(|ends| format!("{ends}, "));
    let amount = amount.text;
    // The verdict, and why it is no claim.
    let why = row.remark.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
    let verdict = format!("{}{why}", row.verdict.as_str());
    // Where a difference that is just noticed is known: `below what is felt: −0.03 JND (−0.05 to −0.01)`.
    let size = row.size.map(|size| {
        let jnds = [row.difference_jnd, row.difference_jnd_ci_low, row.difference_jnd_ci_high];
        let [jnds, low, high] =
            jnds.map(|jnds| jnds.map_or_else(String::new, |jnds| number(jnds, None)));
        format!("{}: {jnds} JND ({low} to {high})", size.as_str())
    });
    let Some(words) = words else {
        let interval = interval.unwrap_or_default();
        let size = size.map(|size| format!(", {size}")).unwrap_or_default();
        return format!("{place}: {amount} ({interval}{verdict}{size})");
    };
    let interval = interval.map(|ends| format!("interval {ends}")).unwrap_or_default();
    // Of several effect sizes the first is reported.
    let effects = [("g_av", row.g_av), ("g_z", row.g_z), ("d_av", row.d_av), ("d_z", row.d_z)];
    let more = [
        row.statistic
            .zip(row.df)
            .map(|(t, df)| format!(", t({}) = {}", number(df, None), number(t, None))),
        row.p_adjusted.map(|p| format!(", adjusted p {}", p_value(p))),
        effects
            .into_iter()
            .find_map(|(name, effect)| Some(format!(", {name} = {}", number(effect?, None)))),
    ];
    let more: String = more.into_iter().flatten().collect();
    let is_open = row.verdict == Verdict::Undecided && row.remark.is_none();
    let why = if is_open { ", neither a difference nor its absence was shown" } else { "" };
    let size = size.map(|size| format!("; {size}")).unwrap_or_default();
    let what = match is_ratio {
        true => format!("the {words} is {amount} as large"),
        false => format!("the difference in {words} is {amount}"),
    };
    format!(
        "{place}: {what} ({interval}n = {} {}{more}): {verdict}{why}{size}.",
        row.n, row.unit_of_analysis,
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn study() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    /// A primary metric.
    pub(crate) fn metric(id: &str, unit: &str, words: &str, of: UnitOfAnalysis) -> Compared {
        Compared {
            metric: id.parse().unwrap(),
            unit: unit.into(),
            words: words.to_owned(),
            role: Role::Primary,
            better: zwidth_study::Better::Lower,
            unit_of_analysis: of,
        }
    }

    /// A metric's mean of six in a mode of `spring`.
    pub(crate) fn mean(metric: &Compared, mode: &str, mean: f64, sd: Option<f64>) -> Mean {
        Mean {
            metric: metric.metric.clone(),
            unit: metric.unit.clone(),
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
            unit_of_analysis: metric.unit_of_analysis.clone(),
            n: 6,
            trials: 6,
            trials_with_value: 6,
            mean,
            sd,
            ci_low: None,
            ci_high: None,
        }
    }

    /// The effect of a motor on a metric of four in `spring`, which cannot be estimated.
    pub(crate) fn unestimated(metric: &Compared) -> EffectDifference {
        EffectDifference {
            metric: metric.metric.clone(),
            unit: metric.unit.clone(),
            environment: Some("spring".parse().unwrap()),
            effect: "motor".parse().unwrap(),
            levels: None,
            n: 4,
            difference: None,
            difference_std_error: None,
            difference_ci_low: None,
            difference_ci_high: None,
            statistic: None,
            df: None,
            p_value: None,
            p_adjusted: None,
            g_av: None,
            d_av: None,
            g_z: None,
            d_z: None,
            p_sign_flip: None,
            jnd: None,
            difference_jnd: None,
            difference_jnd_ci_low: None,
            difference_jnd_ci_high: None,
            size: None,
            bound: None,
            p_not_equivalent: None,
            dose_unit: None,
            turns_at: None,
            verdict: Verdict::NotTested,
            remark: None,
        }
    }

    /// A metric's difference between five experts and seven novices, each with a standard deviation of 0.5.
    pub(crate) fn between_groups(metric: &Compared) -> GroupDifference {
        GroupDifference {
            metric: metric.metric.clone(),
            unit: metric.unit.clone(),
            environment: Some("spring".parse().unwrap()),
            effect: "mean over modes".parse().unwrap(),
            groups: "expert − novice".parse().unwrap(),
            n_first: 5,
            n_second: 7,
            mean_first: Some(1.25),
            mean_second: Some(1.0),
            sd_first: Some(0.5),
            sd_second: Some(0.5),
            difference: Some(0.25),
            difference_std_error: None,
            difference_ci_low: None,
            difference_ci_high: None,
            statistic: None,
            df: None,
            p_value: None,
            p_adjusted: Some(0.5),
            p_permuted: None,
            smallest_p_permuted: None,
            g_av: None,
            d_av: None,
            d_av_ci_low: None,
            d_av_ci_high: None,
            jnd: None,
            difference_jnd: None,
            difference_jnd_ci_low: None,
            difference_jnd_ci_high: None,
            size: None,
            bound: None,
            p_not_equivalent: None,
            verdict: Some(Verdict::Undecided),
            remark: None,
        }
    }

    /// A metric's difference between hybrid and active in `spring`: −0.1 [−0.15, −0.05].
    pub(crate) fn difference(metric: &Compared, verdict: Verdict) -> ModeDifference {
        let people = metric.unit_of_analysis == UnitOfAnalysis::Participants;
        let of_people = |value: f64| people.then_some(value);
        ModeDifference {
            metric: metric.metric.clone(),
            unit: metric.unit.clone(),
            environment: "spring".parse().unwrap(),
            contrast: "hybrid − active".parse().unwrap(),
            unit_of_analysis: metric.unit_of_analysis.clone(),
            n: 6,
            sessions: Some(1),
            mean_first: 0.1,
            mean_second: 0.2,
            difference: -0.1,
            difference_std_error: Some(0.02),
            difference_ci_low: Some(-0.15),
            difference_ci_high: Some(-0.05),
            statistic: of_people(-5.0),
            df: Some(5.0),
            p_value: None,
            p_adjusted: Some(0.0123),
            smallest_p_adjusted: None,
            g_av: None,
            d_av: of_people(-1.25),
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
            verdict,
            remark: None,
        }
    }

    /// A metric without any results.
    pub(crate) fn without_results(metric: &Compared) -> ComparedMetric<'_> {
        ComparedMetric {
            metric,
            primary: Primaries::Named,
            means: &[],
            contrasts: &[],
            groups: &[],
            group_members: &[],
            person_values: &[],
            effects: &[],
            factor_tests: &[],
            redrawn: &[],
        }
    }

    fn past(of: UnitOfAnalysis) -> Compared {
        metric("past_rad", "rad", "angle past the wall", of)
    }

    fn trials() -> UnitOfAnalysis {
        UnitOfAnalysis::TrialsOf("P01".parse().unwrap())
    }

    fn texts_of(metric: &Compared, primary: Primaries, row: ModeDifference) -> Vec<String> {
        let metric = ComparedMetric { primary, contrasts: &[row], ..without_results(metric) };
        contrasts(&study(), &[metric]).into_iter().map(|found| found.text.to_string()).collect()
    }

    fn texts(of: UnitOfAnalysis, verdict: Verdict) -> Vec<String> {
        let metric = past(of);
        texts_of(&metric, Primaries::Named, difference(&metric, verdict))
    }

    #[test]
    fn the_matrix_has_mean_deviation_and_number_in_degrees_and_a_dash_where_nothing_is() {
        let metric = past(UnitOfAnalysis::Participants);
        let hybrid = Mean { n: 5, ..mean(&metric, "hybrid", 0.1, Some(0.025)) };
        let means = [mean(&metric, "active", 0.2, Some(0.012)), hybrid];
        let metric = ComparedMetric { means: &means, ..without_results(&metric) };
        let matrix = matrix(&study(), &[metric]);
        let row = MatrixRow {
            metric: "angle past the wall (°)".to_owned(),
            environment: "spring".parse().unwrap(),
            label: "Spring".to_owned(),
            cells: [Some("11.46 ± 0.69 (6)"), None, Some("5.7 ± 1.4 (5)")]
                .map(|cell| cell.map(str::to_owned))
                .to_vec(),
        };
        assert_eq!(matrix.rows, [row]);
        assert!(matrix.caption.contains("over participants"), "{}", matrix.caption);
    }

    #[test]
    fn a_difference_is_told_with_its_interval_its_n_and_its_unit_after_the_answer() {
        let found = texts(UnitOfAnalysis::Participants, Verdict::Different);
        let answer = "Angle past the wall (the primary metric, lower is better; n = 6 participants): in Spring 5.7° lower with hybrid than with active (2.9 to 8.6), different (adjusted p = 0.0123): hybrid is better.";
        assert_eq!(found[0], answer);
        assert_eq!(
            found[1],
            "Spring, Hybrid − Active: the difference in angle past the wall is −5.7° (interval −8.6 to −2.9, \
             n = 6 participants, t(5) = −5, adjusted p = 0.0123, d_av = −1.25): different."
        );
    }

    /// The natural logarithm of a JND.
    pub(crate) fn ln_jnd() -> Compared {
        metric("ln_jnd_stiffer", "ln N/rad", "JND", UnitOfAnalysis::Participants)
    }

    #[test]
    fn a_jnd_is_told_as_a_ratio_and_the_smaller_one_is_better_below_1_too() {
        let metric = ln_jnd();
        // JNDs of 0.12 and 0.14 N/rad.
        let row = ModeDifference {
            mean_first: -2.1,
            mean_second: -2.0,
            ..difference(&metric, Verdict::Different)
        };
        let found = texts_of(&metric, Primaries::Named, row);
        let answer = "JND (the primary metric, lower is better; n = 6 participants): in Spring 0.905 times as large with hybrid as with active (0.861 to 0.951), different (adjusted p = 0.0123): hybrid is better.";
        let sentence = "Spring, Hybrid / Active: the JND is 0.905 times as large (interval 0.861 to 0.951, n = 6 participants, \
                        t(5) = −5, adjusted p = 0.0123, d_av = −1.25): different.";
        assert_eq!(found, [answer, sentence]);
        let metric = Compared { role: Role::Exploratory, ..metric };
        let contrasts = [difference(&metric, Verdict::Undecided)];
        let others = [ComparedMetric { contrasts: &contrasts, ..without_results(&metric) }];
        let study = study();
        let brief = others_in_brief(&study, &others).map(|found| found.text.to_string());
        let told =
            "Exploratory, JND: Spring, Hybrid / Active: 0.905 times (0.861 to 0.951, undecided).";
        assert_eq!(brief.collect::<Vec<_>>(), [told]);
    }

    #[test]
    fn the_matrix_has_geometric_means_of_jnds() {
        let metric = ln_jnd();
        let means = [mean(&metric, "active", libm::log(25.0), Some(libm::log(1.2)))];
        let metric = ComparedMetric { means: &means, ..without_results(&metric) };
        let matrix = matrix(&study(), &[metric]);
        assert_eq!(matrix.rows[0].metric, "JND (N/rad)");
        assert_eq!(matrix.rows[0].cells[0].as_deref(), Some("25.0 ×/÷ 1.20 (6)"));
        assert!(matrix.caption.ends_with(GEOMETRIC), "{}", matrix.caption);
    }

    #[test]
    fn effects_and_groups_of_jnds_are_ratios_and_where_ratios_are_compared_times_as_large_ones() {
        let metric = ln_jnd();
        let effect = |effect: &str, levels: &str| EffectDifference {
            effect: effect.parse().unwrap(),
            levels: Some(levels.parse().unwrap()),
            difference: Some(0.336_472),
            difference_std_error: Some(0.05),
            difference_ci_low: Some(0.215_111),
            difference_ci_high: Some(0.451_076),
            verdict: Verdict::Different,
            ..unestimated(&metric)
        };
        let group = |effect: &str| GroupDifference {
            effect: effect.parse().unwrap(),
            difference_std_error: Some(0.05),
            difference_ci_low: Some(0.15),
            difference_ci_high: Some(0.35),
            ..between_groups(&metric)
        };
        let effects = [
            effect("motor", "yes − no"),
            effect("motor:brake", "(yes − no) × (soft − stiff)"),
            effect("stiffness", "per 100 N/m"),
        ];
        let groups = ["mean over modes", "hybrid", "hybrid − active", "motor: yes − no"].map(group);
        let compared =
            ComparedMetric { effects: &effects, groups: &groups, ..without_results(&metric) };
        let study = study();
        let told = crate::factor_effects(&study, &compared)
            .into_iter()
            .chain(crate::group_differences(&study, &compared))
            .map(|finding| finding.text.to_string());
        let expected = [
            "Spring, effects of factors on JND (4 participants). Shown: motor (yes / no: 1.400 times), motor × brake ((yes / \
             no) × (soft / stiff): 1.400 times as large a ratio), stiffness (per 100 N/m: 1.400 times).",
            "Spring, effect of motor (yes / no) on JND: 1.400 times (interval 1.240 to 1.570, 4 participants): different.",
            "Spring, effect of motor × brake ((yes / no) × (soft / stiff)) on JND: 1.400 times as large a ratio (interval \
             1.240 to 1.570, 4 participants): different.",
            "Spring, effect of stiffness (per 100 N/m) on JND: 1.400 times (interval 1.240 to 1.570, 4 participants): \
             different.",
            "Spring, expert / novice in the geometric mean over modes: the JND is 1.284 times as large (interval 1.162 to 1.419, \
             5 and 7 people, adjusted p = 0.5): undecided, neither a difference nor its absence was shown.",
            "Spring, expert / novice in hybrid: the JND is 1.284 times as large (interval 1.162 to 1.419, 5 and 7 people, \
             adjusted p = 0.5): undecided, neither a difference nor its absence was shown.",
            "Spring, expert / novice in the ratio Hybrid / Active: the JND has 1.284 times as large a ratio (interval 1.162 to \
             1.419, 5 and 7 people, adjusted p = 0.5): undecided, neither a difference nor its absence was shown.",
            "Spring, expert / novice in the effect motor: yes / no: the JND has 1.284 times as large a ratio (interval 1.162 to \
             1.419, 5 and 7 people, adjusted p = 0.5): undecided, neither a difference nor its absence was shown.",
        ];
        assert_eq!(told.collect::<Vec<_>>(), expected);
        let brief = crate::explored_effects(&study, &compared).unwrap().text.to_string();
        assert!(
            brief.contains(
                "effect of motor × brake ((yes / no) × (soft / stiff)): 1.400 times as large a ratio (1.240 to 1.570, \
                 different)"
            ),
            "{brief}"
        );
    }

    #[test]
    fn effects_and_groups_of_a_metric_that_is_not_primary_are_told_in_brief() {
        let metric = Compared {
            role: Role::Exploratory,
            ..metric("force_n", "N", "force", UnitOfAnalysis::Participants)
        };
        let shown = EffectDifference {
            levels: Some("yes − no".parse().unwrap()),
            difference: Some(0.45),
            difference_std_error: Some(0.1),
            difference_ci_low: Some(0.2),
            difference_ci_high: Some(0.7),
            verdict: Verdict::Different,
            size: Some(Size::Felt),
            ..unestimated(&metric)
        };
        let over_both = EffectDifference {
            environment: None,
            effect: "wall_costs".parse().unwrap(),
            remark: Some("nobody has all conditions that it weighs".to_owned().into()),
            ..unestimated(&metric)
        };
        let effects = [shown, over_both];
        let claim = between_groups(&metric);
        let described = GroupDifference { verdict: None, ..claim.clone() };
        let groups = [claim, described];
        let compared =
            ComparedMetric { effects: &effects, groups: &groups, ..without_results(&metric) };
        let study = study();
        let told = [
            crate::explored_effects(&study, &compared),
            crate::explored_groups(&study, &compared),
            crate::explored_effects(&study, &without_results(&metric)),
        ];
        let told = told.map(|finding| finding.map(|finding| finding.text.to_string()));
        let of_effects = "Exploratory, force: Spring, effect of motor (yes − no): 0.45 N (0.20 to 0.70, different, felt); \
                          effect of wall_costs: not tested: nobody has all conditions that it weighs.";
        let of_groups = "Exploratory, force: Spring, expert − novice in the mean over modes: 0.25 N (undecided).";
        let nb = |text: &str| text.replace(" N (", "\u{a0}N (");
        assert_eq!(told, [Some(nb(of_effects)), Some(nb(of_groups)), None]);
    }

    #[test]
    fn no_p_is_told_to_be_nothing() {
        let metric = past(UnitOfAnalysis::Participants);
        let row = difference(&metric, Verdict::Different);
        let found =
            texts_of(&metric, Primaries::Named, ModeDifference { p_adjusted: Some(0.0), ..row });
        assert!(found[1].contains(", adjusted p < 0.001, "), "{}", found[1]);
    }

    #[test]
    fn a_metric_that_is_not_the_primary_one_is_not_called_so() {
        for (role, primary, words) in [
            (
                Role::Exploratory,
                Primaries::Named,
                "Angle past the wall (exploratory: not the primary metric, lower",
            ),
            (
                Role::Primary,
                Primaries::ByDefault,
                "Angle past the wall (the primary metric by default, lower",
            ),
            (
                Role::Exploratory,
                Primaries::Several,
                "Angle past the wall (exploratory: not a primary metric, lower",
            ),
            (Role::Primary, Primaries::Several, "Angle past the wall (a primary metric, lower"),
        ] {
            let metric = Compared { role, ..past(UnitOfAnalysis::Participants) };
            let found = texts_of(&metric, primary, difference(&metric, Verdict::Different));
            assert!(found[0].contains(words), "{}", found[0]);
        }
    }

    #[test]
    fn what_was_not_tested_is_not_told_as_a_difference_that_was_not_shown() {
        let metric = past(trials());
        let row = difference(&metric, Verdict::NotTested);
        let untested = ModeDifference { p_adjusted: None, ..row };
        let answer = "Within P01, it was not tested whether the modes differ in angle past the wall (the \
                      primary metric): none of 1 contrasts has a test.";
        assert_eq!(texts_of(&metric, Primaries::Named, untested)[0], answer);
    }

    #[test]
    fn with_one_participant_it_is_said_within_whom() {
        let found = texts(trials(), Verdict::Undecided);
        assert!(found[0].starts_with("Within P01, angle past the wall (the primary metric, lower is better; n = 6 trials of P01): in Spring"));
        assert!(found[1].contains("n = 6 trials of P01"), "{}", found[1]);
        assert!(found[1].contains("undecided, neither a difference nor"), "{}", found[1]);
    }
}
