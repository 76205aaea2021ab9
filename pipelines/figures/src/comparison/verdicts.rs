//! The answer in one glance: every difference between modes over what a person can feel, with everybody's
//! own, its verdict and its value.

use super::compared::{EQUAL_WEIGHTS, MetricResults, Shown, or_note, stacked, zero};
use super::effects::effect_name;
use super::groups::effect_label;
use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::BTreeSet;
use zwidth_draw::style;
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Intervals, Layer, ONE_COLUMN_MM, Panel, Points,
    TWO_COLUMNS_MM, Text, TextPlace,
};
use zwidth_results::{
    EffectDifference, GroupDifference, Mean, ModeDifference, Role, Sides, UnitOfAnalysis,
};
use zwidth_study::{Better, Environment, EnvironmentId, ModeId, Source, counted, in_a_sentence};

/// The figure [`verdicts`].
pub const VERDICTS: FigureKind = FigureKind::new(
    "verdicts",
    "the answer in one glance: every difference between modes over what a person can feel",
    "trial",
);

/// The figure [`verdicts`] in one column, whose subject this is.
pub const IN_ONE_COLUMN: &str = "column";

/// Height of a row, mm: with two lines of words beside it, or in one column with three under its name.
const ROW_MM: f64 = 8.0;
const NARROW_ROW_MM: f64 = 11.0;
/// How far dots stand beside the mean of them, in rows.
const ASIDE: f64 = 0.2;
/// Width of the plot against that of the words beside it.
const WEIGHTS: [f64; 2] = [1.0, 0.95];
/// From this many dots in a row on each is fainter.
const MANY: usize = 40;

/// What a difference is measured by, so that different metrics share an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MeasuredBy {
    /// The difference that a person just notices (JND).
    Jnd,
    /// The standard deviation of a mode, the root mean of both modes' variances (s_av): where no JND is
    /// known.
    Deviation,
}

/// A difference between two modes in one metric and one environment, as the figure and a terminal show it.
#[derive(Debug, Clone, PartialEq)]
pub struct VerdictRow {
    /// The metric in words.
    pub metric: String,
    /// Whether claims rest on it.
    pub role: Role,
    /// Environment and contrast: `Spring: Hybrid − Active`.
    pub place: String,
    /// What the numbers below are measured by.
    pub by: MeasuredBy,
    /// The difference.
    pub estimate: f64,
    /// The ends of its interval, where it has one that speaks of people.
    pub ends: Option<[f64; 2]>,
    /// Each participant's own difference; of one participant the difference at each repeat.
    pub dots: Vec<f64>,
    /// The differences in other orders of one participant's trials, had none depended on mode.
    pub redrawn: Vec<f64>,
    /// The difference in the metric's unit, with its interval: `−0.12 N (−0.20 to −0.05)`.
    pub value: String,
    /// What the tests show and whether it is felt: `different, felt`.
    pub verdict: String,
    /// How many people, or trials of the only one: `8 people`.
    pub who: String,
    /// Which values are better.
    pub better: Better,
    /// The mode that is better, where there is a difference and one way is better.
    pub best: Option<String>,
}

impl VerdictRow {
    /// Which values are better, behind the metric: ` (lower is better)`.
    pub fn direction(&self) -> String {
        match self.better {
            Better::Neither => String::new(),
            better => format!(" ({} is better)", better.as_str()),
        }
    }

    /// Verdict, size, which mode is better, and how many: `different, felt: hybrid is better (8 people)`.
    pub fn judged(&self) -> String {
        let best = self.best.as_ref().map(|mode| format!(": {mode} is better"));
        format!("{}{} ({})", self.verdict, best.unwrap_or_default(), self.who)
    }
}

/// Every difference of the metrics, in their order; those without a difference that is noticed last.
/// Left out are those of which no size can be told: nothing varies.
pub fn verdict_rows(
    about: &About,
    environments: &[Environment],
    found: &[MetricResults],
) -> Vec<VerdictRow> {
    let mut rows = Vec::new();
    for metric in found {
        for environment in environments {
            let contrasts = metric.contrasts.iter().filter(|c| c.environment == environment.id);
            rows.extend(contrasts.filter_map(|c| row(about, environment, metric, c)));
            let groups = metric.groups.iter();
            let groups = groups.filter(|g| g.environment.as_ref() == Some(&environment.id));
            rows.extend(groups.filter_map(|g| group_row(about, environments, metric, g)));
        }
        rows.extend(
            metric.effects.iter().filter_map(|e| effect_row(about, environments, metric, e)),
        );
        let groups = metric.groups.iter().filter(|g| g.environment.is_none());
        rows.extend(groups.filter_map(|g| group_row(about, environments, metric, g)));
    }
    rows.sort_by_key(|row| row.by);
    rows
}

fn row(
    about: &About,
    environment: &Environment,
    found: &MetricResults,
    contrast: &ModeDifference,
) -> Option<VerdictRow> {
    let (by, unit) = match contrast.jnd {
        Some(jnd) => (MeasuredBy::Jnd, jnd),
        None => (MeasuredBy::Deviation, deviation(&found.means, contrast)?),
    };
    let shown = Shown::of(about, &found.metric);
    let key = (&contrast.environment, &contrast.contrast);
    let of_one = matches!(contrast.unit_of_analysis, UnitOfAnalysis::TrialsOf(_));
    let dots: Vec<f64> = match of_one {
        true => differences_of_repeats(found, contrast),
        false => {
            let own = found.participants.iter().filter(|p| (&p.environment, &p.contrast) == key);
            own.map(|person| person.difference).collect()
        }
    };
    let redrawn = found.redrawn.iter().filter(|r| of_one && (&r.environment, &r.contrast) == key);
    let ends = contrast.difference_ci_low.zip(contrast.difference_ci_high).filter(|_| !of_one);
    let best = contrast.best(found.metric.better).map(|id| {
        let mode = about.modes.iter().find(|mode| mode.id == *id);
        mode.map_or_else(|| id.to_string(), |mode| in_a_sentence(&mode.label))
    });
    let size = contrast.size.map(|size| format!(", {}", size.as_str()));
    let label = shown.contrast(&about.modes, &contrast.contrast);
    let whose = if of_one { "trials" } else { "people" };
    Some(VerdictRow {
        metric: shown.words.clone(),
        role: found.metric.role,
        place: format!("{}: {label}", environment.label),
        by,
        estimate: contrast.difference / unit,
        ends: ends.map(|(low, high)| [low / unit, high / unit]),
        dots: dots.into_iter().map(|dot| dot / unit).collect(),
        redrawn: redrawn.map(|r| r.difference / unit).collect(),
        value: amount(
            &shown,
            contrast.difference,
            ends,
            contrast.difference_std_error,
            Sides::Values,
        ),
        verdict: format!("{}{}", contrast.verdict.as_str(), size.unwrap_or_default()),
        who: format!("{} {whose}", contrast.n),
        better: found.metric.better,
        best,
    })
}

/// A claim about an effect of factors.
fn effect_row(
    about: &About,
    environments: &[Environment],
    found: &MetricResults,
    row: &EffectDifference,
) -> Option<VerdictRow> {
    let difference = row.difference?;
    let (by, unit) = match row.jnd {
        Some(jnd) => (MeasuredBy::Jnd, jnd),
        None => (MeasuredBy::Deviation, row.deviation()?),
    };
    let shown = Shown::of(about, &found.metric);
    let ends = row.difference_ci_low.zip(row.difference_ci_high);
    let size = row.size.map(|size| format!(", {}", size.as_str()));
    Some(VerdictRow {
        metric: shown.words.clone(),
        role: found.metric.role,
        place: before(environments, row.environment.as_ref()) + &effect_name(row, &shown),
        by,
        estimate: difference / unit,
        ends: ends.map(|(low, high)| [low / unit, high / unit]),
        dots: Vec::new(),
        redrawn: Vec::new(),
        value: amount(&shown, difference, ends, row.difference_std_error, row.sides()),
        verdict: format!("{}{}", row.verdict.as_str(), size.unwrap_or_default()),
        who: counted(row.n, "participants"),
        better: found.metric.better,
        best: None,
    })
}

/// A claim about two groups; nobody's own difference stands behind it.
fn group_row(
    about: &About,
    environments: &[Environment],
    found: &MetricResults,
    row: &GroupDifference,
) -> Option<VerdictRow> {
    let (verdict, difference) = (row.verdict?, row.difference?);
    let (by, unit) = match row.jnd {
        Some(jnd) => (MeasuredBy::Jnd, jnd),
        None => (MeasuredBy::Deviation, row.deviation()?),
    };
    let shown = Shown::of(about, &found.metric);
    let ends = row.difference_ci_low.zip(row.difference_ci_high);
    let size = row.size.map(|size| format!(", {}", size.as_str()));
    let effect = effect_label(&about.modes, &row.effect, &shown.amounts);
    let groups = shown.amounts.compared(&row.groups.to_string());
    Some(VerdictRow {
        metric: shown.words.clone(),
        role: found.metric.role,
        place: format!("{}{groups}, {effect}", before(environments, row.environment.as_ref()),),
        by,
        estimate: difference / unit,
        ends: ends.map(|(low, high)| [low / unit, high / unit]),
        dots: Vec::new(),
        redrawn: Vec::new(),
        value: amount(&shown, difference, ends, row.difference_std_error, row.sides()),
        verdict: format!("{}{}", verdict.as_str(), size.unwrap_or_default()),
        who: format!("{} and {} people", row.n_first, row.n_second),
        better: found.metric.better,
        best: None,
    })
}

/// A difference with the ends of its interval, its standard error setting the digits: `0.94 N (0.89 to 0.99)`; of
/// logarithms as a ratio, `1.40 times (1.24 to 1.57)`.
fn amount(
    shown: &Shown,
    difference: f64,
    ends: Option<(f64, f64)>,
    std_error: Option<f64>,
    sides: Sides,
) -> String {
    let amount = shown.amounts.told(difference, ends, std_error, sides);
    amount.text + &amount.ends.map(|ends| format!(" ({ends})")).unwrap_or_default()
}

/// The environment before what is compared there: `Spring: `; nothing over several.
fn before(environments: &[Environment], id: Option<&EnvironmentId>) -> String {
    let environment = environments.iter().find(|own| Some(&own.id) == id);
    environment.map_or_else(String::new, |own| format!("{}: ", own.label))
}

/// s_av: the root mean of the variances of both modes (Cumming, Understanding the New Statistics, 2012); none
/// where nothing varies.
fn deviation(means: &[Mean], contrast: &ModeDifference) -> Option<f64> {
    let sd = |mode: &ModeId| {
        let key = (&contrast.environment, mode);
        means.iter().find(|mean| (&mean.environment, &mean.mode) == key)?.sd
    };
    let (first, second) = sd(&contrast.contrast.mode).zip(sd(&contrast.contrast.against))?;
    let deviation = ((first * first + second * second) / 2.0).sqrt();
    (deviation > 0.0).then_some(deviation)
}

/// The difference between both modes at each repeat that has both, of one participant.
fn differences_of_repeats(found: &MetricResults, contrast: &ModeDifference) -> Vec<f64> {
    let mean_at = |mode: &ModeId, repeat: u32| {
        let key = (&contrast.environment, mode, repeat);
        let mut rows = found.repeats.iter();
        rows.find(|row| (&row.environment, &row.mode, row.repeat) == key)?.mean
    };
    let repeats: BTreeSet<u32> = found.repeats.iter().map(|row| row.repeat).collect();
    let modes = &contrast.contrast;
    repeats
        .into_iter()
        .filter_map(|repeat| Some(mean_at(&modes.mode, repeat)? - mean_at(&modes.against, repeat)?))
        .collect()
}

/// Every difference between modes, a row each: dots, interval and the band of what is not felt on one
/// axis, and beside them the value in its unit and the verdict. Metrics without a known just noticeable
/// difference have an axis of their own, in standard deviations. In one column the words stand under the
/// row's name.
pub fn verdicts(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    found: &[MetricResults],
    is_narrow: bool,
) -> Figure {
    let rows = verdict_rows(about, environments, found);
    let mut panels = Vec::new();
    let mut beside = Vec::new();
    for by in [MeasuredBy::Jnd, MeasuredBy::Deviation] {
        let measured: Vec<&VerdictRow> = rows.iter().filter(|row| row.by == by).collect();
        if !measured.is_empty() {
            let [plot, words] = both_panels(panels.len(), by, &measured, is_narrow);
            panels.push(plot);
            beside.push(words);
        }
    }
    if !is_narrow {
        panels.extend(beside);
    }
    let level = percent(about.confidence);
    let mut footnotes = vec![match found.first().map(|metric| &metric.metric.unit_of_analysis) {
        Some(UnitOfAnalysis::TrialsOf(who)) => format!(
            "Dots: repeats of {who}, of whom alone this speaks; disc: the mean difference. Above it, grey: the \
             differences in other orders of the trials, had none depended on mode."
        ),
        _ => {
            let dots = rows.iter().any(|row| !row.dots.is_empty());
            let dots = if dots { "Dots: people. " } else { "" };
            format!("{dots}Disc and whiskers: mean and {level} interval, not adjusted.")
        }
    }];
    let has_groups = found.iter().any(|metric| !metric.groups.is_empty());
    if has_groups {
        footnotes.push(EQUAL_WEIGHTS.to_owned());
    }
    if rows.iter().any(|row| row.by == MeasuredBy::Jnd) {
        let note = "Band: within ± 1 just noticeable difference (JND), below what is felt.";
        footnotes.push(note.to_owned());
    }
    if rows.iter().any(|row| row.by == MeasuredBy::Deviation) {
        let of_effects = found.iter().any(|metric| !metric.effects.is_empty());
        let of = if of_effects {
            "of a mode, or of everybody's effects"
        } else {
            "of a mode, between dots"
        };
        footnotes.push(format!(
            "Of metrics in standard deviations ({of}) it is not known what is felt."
        ));
    }
    if rows.iter().any(|row| row.role != Role::Primary) {
        let metrics = if about.has_several_primary { "metrics" } else { "metric" };
        footnotes.push(format!("Bold: the primary {metrics}; all others are exploratory."));
    }
    let of_contrasts = found.iter().any(|metric| !metric.contrasts.is_empty());
    let of_effects = found.iter().any(|metric| !metric.effects.is_empty());
    let what = match (of_contrasts, of_effects, has_groups) {
        (false, true, _) => "effects of factors",
        (true, true, _) => "differences between modes and effects of factors",
        (_, false, true) => "differences between modes and groups",
        (_, false, false) => "differences between modes",
    };
    Figure {
        title: Some(plain(&format!("{}: {what}", about.title))),
        description:
            "Every difference between modes over what a person can feel, with its verdict."
                .to_owned(),
        width_mm: if is_narrow { ONE_COLUMN_MM } else { TWO_COLUMNS_MM },
        column_weights: if is_narrow { Vec::new() } else { WEIGHTS.to_vec() },
        panels: or_note(panels),
        footnotes: footnotes.iter().map(|note| plain(note)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// The plot of rows that are measured by the same, and the words beside it; a heading over the rows of
/// each metric.
fn both_panels(line: usize, by: MeasuredBy, rows: &[&VerdictRow], is_narrow: bool) -> [Panel; 2] {
    let mut names: Vec<String> = Vec::new();
    let mut places: Vec<f64> = Vec::new();
    for of_metric in rows.chunk_by(|a, b| a.metric == b.metric) {
        let heading = plain(&of_metric[0].metric);
        let heading = match of_metric[0].role {
            Role::Primary => format!("**{heading}**"),
            Role::Exploratory => heading,
            Role::ChosenAfter => format!("{heading}, chosen after the data"),
        };
        names.push(heading + &of_metric[0].direction());
        for row in of_metric {
            places.push(names.len() as f64);
            names.push(plain(&match is_narrow {
                true => format!("{}: {}", row.place, row.judged()),
                false => row.place.clone(),
            }));
        }
    }
    let height = names.len();
    let row_mm = if is_narrow { NARROW_ROW_MM } else { ROW_MM };
    let height_mm = row_mm * height as f64;
    let mut layers = Vec::new();
    if by == MeasuredBy::Jnd {
        layers.push(Layer::Band(Band {
            x: vec![-1.0, 1.0],
            low: vec![-0.5; 2],
            high: vec![height as f64 - 0.5; 2],
            colour: style::GREY,
            name: None,
        }));
    }
    layers.push(zero(Direction::Vertical));
    for (row, place) in rows.iter().zip(&places) {
        if !row.redrawn.is_empty() {
            layers.push(turned(stacked(0.0, &row.redrawn), place - ASIDE / 2.0));
        }
        layers.push(Layer::Points(Points {
            x: row.dots.clone(),
            y: vec![place + ASIDE; row.dots.len()],
            colour: style::GREY,
            opacity: if row.dots.len() < MANY { 0.55 } else { 0.2 },
            ..Points::default()
        }));
    }
    let estimates = rows.iter().map(|row| row.estimate).collect();
    let end = |i: usize| rows.iter().map(|row| row.ends.map_or(f64::NAN, |e| e[i])).collect();
    let estimates = [estimates, end(0), end(1)];
    layers.push(Layer::Intervals(Intervals::new(Direction::Horizontal, places.clone(), estimates)));
    let label = match by {
        MeasuredBy::Jnd => "difference, in just noticeable differences",
        MeasuredBy::Deviation => "difference, in standard deviations",
    };
    let x = Axis::new(label, "");
    let plot = Panel::new(Cell::at(line, 0), x, Axis::categories(names), layers);
    // Unseen: words alone are no data, and rows stand where those of the plot do.
    let rows_of_plot = Layer::Points(Points {
        x: vec![0.0; height],
        y: (0..height).map(|place| place as f64).collect(),
        opacity: 0.0,
        ..Points::default()
    });
    let words = rows.iter().zip(&places).map(|(row, place)| {
        Layer::Text(Text {
            lines: vec![plain(&row.value), plain(&row.judged())],
            place: TextPlace::RightOf(0.0, *place),
        })
    });
    let layers = std::iter::once(rows_of_plot).chain(words).collect();
    let blank = Axis::categories(vec![String::new(); height]);
    let beside = Panel::new(Cell::at(line, 1), Axis::bare(0.0, 1.0), blank, layers);
    [plot, beside].map(|panel| panel.tall(height_mm))
}

/// Discs that stand beside a place of x, as discs above a place of y.
fn turned(layer: Layer, place: f64) -> Layer {
    match layer {
        Layer::Points(points) => Layer::Points(Points {
            y: points.x.iter().map(|x| place + x).collect(),
            x: points.y,
            ..points
        }),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::{Compared, PersonDifference, RepeatMean, Size, Verdict};
    use zwidth_study::Study;

    fn study() -> Study {
        zwidth_testing::study()
    }

    fn mean(mode: &str, mean: f64, sd: f64) -> Mean {
        Mean {
            metric: "wall_past_max_rad".parse().unwrap(),
            unit: "N".into(),
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
            unit_of_analysis: UnitOfAnalysis::Participants,
            n: 2,
            trials: 12,
            trials_with_value: 12,
            mean,
            sd: Some(sd),
            ci_low: None,
            ci_high: None,
        }
    }

    /// Hybrid − active is −2 N (−3 to −1), of two people −2.5 and −1.5, where 0.5 N are noticed.
    fn found(jnd: Option<f64>, verdict: Verdict) -> MetricResults {
        let [metric, environment] = ["wall_past_max_rad", "spring"];
        let contrast: zwidth_study::Contrast = "hybrid − active".parse().unwrap();
        let person = |participant: &str, difference| PersonDifference {
            metric: metric.parse().unwrap(),
            unit: "N".into(),
            environment: environment.parse().unwrap(),
            contrast: contrast.clone(),
            participant: participant.parse().unwrap(),
            sessions: 1,
            trials_first: 6,
            trials_second: 6,
            difference,
            difference_std_error: None,
            difference_ci_low: None,
            difference_ci_high: None,
        };
        let difference = ModeDifference {
            metric: metric.parse().unwrap(),
            unit: "N".into(),
            environment: environment.parse().unwrap(),
            contrast: contrast.clone(),
            unit_of_analysis: UnitOfAnalysis::Participants,
            n: 2,
            difference: -2.0,
            difference_std_error: Some(0.1),
            difference_ci_low: Some(-3.0),
            difference_ci_high: Some(-1.0),
            jnd,
            size: jnd.map(|_| Size::Felt),
            verdict,
            sessions: Some(1),
            mean_first: 1.0,
            mean_second: 3.0,
            statistic: None,
            df: None,
            p_value: None,
            p_adjusted: None,
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
            difference_jnd: None,
            difference_jnd_ci_low: None,
            difference_jnd_ci_high: None,
            bound: None,
            p_not_equivalent: None,
            remark: None,
        };
        MetricResults {
            metric: Compared {
                metric: metric.parse().unwrap(),
                unit: "N".into(),
                words: "force".to_owned(),
                role: Role::Primary,
                better: Better::Lower,
                unit_of_analysis: UnitOfAnalysis::Participants,
            },
            cells: Vec::new(),
            means: vec![mean("hybrid", 1.0, 3.0), mean("active", 3.0, 4.0)],
            contrasts: vec![difference],
            participants: vec![person("P01", -2.5), person("P02", -1.5)],
            groups: Vec::new(),
            trend_curves: Vec::new(),
            effects: Vec::new(),
            group_means: Vec::new(),
            group_members: Vec::new(),
            sessions: Vec::new(),
            repeats: Vec::new(),
            redrawn: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn rows(found: &MetricResults) -> Vec<VerdictRow> {
        let study = study();
        verdict_rows(&About::of(&study), &study.environments, std::slice::from_ref(found))
    }

    #[test]
    fn a_difference_is_measured_by_what_is_noticed_and_says_which_mode_is_better() {
        let [row] = &rows(&found(Some(0.5), Verdict::Different))[..] else { panic!() };
        assert_eq!((row.by, row.estimate, row.ends), (MeasuredBy::Jnd, -4.0, Some([-6.0, -2.0])));
        assert_eq!(row.dots, [-5.0, -3.0]);
        assert_eq!(row.place, "Spring: Hybrid − Active");
        assert_eq!(row.judged(), "different, felt: hybrid is better (2 people)");
        assert_eq!(row.value, "−2.00\u{a0}N (−3.00 to −1.00)");
    }

    #[test]
    fn lower_is_nearer_to_zero_and_of_two_signs_neither_mode_is_better() {
        let best_of = |mean_first: f64, mean_second: f64, better| {
            let mut found = found(None, Verdict::Different);
            found.metric.better = better;
            let contrast = &mut found.contrasts[0];
            contrast.difference = mean_first - mean_second;
            (contrast.mean_first, contrast.mean_second) = (mean_first, mean_second);
            rows(&found)[0].best.clone()
        };
        let [hybrid, active] = ["hybrid", "active"].map(|mode| Some(mode.to_owned()));
        assert_eq!(best_of(1.0, 3.0, Better::Lower), hybrid);
        assert_eq!(best_of(-3.0, -1.0, Better::Lower), active);
        assert_eq!(best_of(-3.0, 1.0, Better::Lower), None);
        assert_eq!(best_of(-3.0, -1.0, Better::Higher), active);
        assert_eq!(best_of(1.0, 3.0, Better::Neither), None);
    }

    #[test]
    fn without_a_just_noticeable_difference_the_root_mean_variance_of_both_modes_measures_it() {
        let [row] = &rows(&found(None, Verdict::Undecided))[..] else { panic!() };
        let s_av = ((9.0 + 16.0) / 2.0_f64).sqrt();
        assert_eq!((row.by, row.estimate), (MeasuredBy::Deviation, -2.0 / s_av));
        assert_eq!(row.judged(), "undecided (2 people)");
        let mut still = found(None, Verdict::Undecided);
        still.means.iter_mut().for_each(|mean| mean.sd = Some(0.0));
        assert_eq!(rows(&still), [], "nothing varies");
    }

    #[test]
    fn of_one_person_the_dots_are_repeats_that_both_modes_have() {
        let who = || UnitOfAnalysis::TrialsOf("P01".parse().unwrap());
        let mut found = found(Some(0.5), Verdict::Undecided);
        found.contrasts[0].unit_of_analysis = who();
        let repeat = |mode: &str, repeat, mean| RepeatMean {
            metric: found.metric.metric.clone(),
            unit: "N".into(),
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
            repeat,
            n: 1,
            mean,
            ci_low: None,
            ci_high: None,
        };
        let repeats = vec![
            repeat("hybrid", 1, Some(1.0)),
            repeat("active", 1, Some(2.0)),
            repeat("hybrid", 2, Some(1.0)),
            repeat("active", 2, None),
        ];
        found.repeats = repeats;
        let [row] = &rows(&found)[..] else { panic!() };
        assert_eq!((row.dots.as_slice(), row.ends), ([-2.0].as_slice(), None));
        assert_eq!(row.who, "2 trials");
    }

    #[test]
    fn the_figure_has_a_panel_for_each_measure_and_words_beside_it_in_two_columns_alone() {
        let study = study();
        let both = [found(Some(0.5), Verdict::Different), found(None, Verdict::Undecided)];
        let figure = |narrow| {
            verdicts(&About::of(&study), &study.environments, &[Source::Imported], &both, narrow)
        };
        assert_eq!(figure(false).panels.len(), 4);
        assert_eq!(figure(true).panels.len(), 2);
        for narrow in [false, true] {
            zwidth_draw::draw(&figure(narrow)).unwrap();
        }
    }
}
