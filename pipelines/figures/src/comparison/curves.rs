//! Whole curves compared, one environment per figure, or what is over several.

use super::compared::{or_note, zero};
use super::groups::effect_label;
use crate::course::panels::{axis, on_axis, wall_line};
use crate::words::{Words, mark, percent, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Axis, Band, Cell, Direction, Figure, Layer, Line, Panel};
use zwidth_results::{CurveDifference, CurveNode, CurveRun, GroupEffect, LoopBranch, Verdict};
use zwidth_store::Signal;
use zwidth_study::{Contrast, Curve, Environment, Source, counted, curve_label};
use zwidth_tables::{Amounts, p_value};

/// The figure [`curves_compared`].
pub const CURVES_COMPARED: FigureKind = FigureKind::new(
    "curves",
    "whole curves compared: both means, and their difference with its band",
    "trial",
);

/// How the figure of groups is named besides.
pub const IN_GROUPS: &str = "groups";

/// Height of a panel, mm: there are many.
const PANEL_MM: f64 = 40.0;

/// One curve's results in one environment, or over several.
#[derive(Debug, Clone, Copy)]
pub struct CurvesShown<'a> {
    /// The curve.
    pub curve: Curve,
    /// Its nodes.
    pub points: &'a [CurveNode],
    /// Its tests.
    pub tests: &'a [CurveDifference],
    /// Its runs.
    pub runs: &'a [CurveRun],
    /// Below which p runs count.
    pub alpha: f64,
    /// Level of the bands, as a fraction.
    pub level: f64,
}

/// A row of panels for each comparison: at the left the two means, then their difference with its band on each
/// way, with runs of large t along the axis.
pub fn curves_compared(
    about: &About,
    environment: Option<&Environment>,
    sources: &[Source],
    shown: &CurvesShown,
) -> Figure {
    let place_label = environment.map_or("several environments", |own| own.label.as_str());
    let words = Words::new(about.coordinate);
    let signal = match shown.curve {
        Curve::ForceOverAngle | Curve::ForceOverTime => Signal::ForceEx,
        Curve::ThetaOverTime => Signal::Theta,
        Curve::VelocityOverAngle => Signal::ThetaDot,
    };
    let is_angle = shown.curve.is_over_angle();
    let x_axis = || match is_angle {
        true => words.position_axis().linked("place"),
        false => Axis::new("*t*", "s").linked("place"),
    };
    let place = |theta_rad: Option<f64>, t_s: Option<f64>| match theta_rad {
        Some(theta_rad) => words.position(theta_rad),
        None => t_s.unwrap_or(f64::NAN),
    };
    let y = |values: &[f64]| on_axis(words, signal, values);
    let mut branches = match is_angle {
        true => vec![(Some(LoopBranch::In), "way there"), (Some(LoopBranch::Out), "way back")],
        false => vec![(None, "")],
    };
    // A way that no comparison has needs no panels: the notes say why.
    let has = |branch| shown.points.iter().any(|point| point.branch == branch);
    branches.retain(|(branch, _)| *branch != Some(LoopBranch::Out) || has(*branch));
    let mut panels = Vec::new();
    let mut verdicts = Vec::new();
    for (row, test) in shown.tests.iter().enumerate() {
        let own: Vec<&CurveNode> = shown
            .points
            .iter()
            .filter(|point| point.effect == test.effect && point.groups == test.groups)
            .collect();
        let label = label(about, test);
        verdicts.push(claim(&label, test));
        if own.is_empty() {
            let cell = Cell::at(row, 0);
            let panel = Panel::with_note(cell, x_axis(), axis(words, signal), "not tested");
            panels.push(panel.titled(plain(&label)).tall(PANEL_MM));
            continue;
        }
        let names = sides(about, test);
        let mut means = Vec::from_iter(
            environment
                .filter(|_| is_angle)
                .and_then(|environment| wall_line(environment, words, Direction::Vertical)),
        );
        for side in [1, 0] {
            let pen = match (&test.groups, &test.effect) {
                (None, GroupEffect::Of(contrast)) => {
                    let id = [&contrast.mode, &contrast.against][side];
                    let index = about.modes.iter().position(|mode| mode.id == *id).unwrap_or(0);
                    style::mean(style::mode_colour(index)).dashed(style::dash(index))
                }
                _ => style::mean(style::environment_colour(side)).dashed(style::dash(side)),
            };
            for (place_of_branch, (branch, _)) in branches.iter().enumerate() {
                let nodes = own.iter().filter(|point| point.branch == *branch);
                let (x, values): (Vec<f64>, Vec<f64>) = nodes
                    .map(|point| {
                        let value = [point.mean_first, point.mean_second][side];
                        (place(point.theta_rad, point.t_s), value)
                    })
                    .unzip();
                // A name once, for both ways.
                let name = (place_of_branch == 0).then(|| plain(&names[side]));
                means.push(Layer::Line(Line {
                    x,
                    y: y(&values),
                    stroke: pen,
                    name,
                    ..Line::default()
                }));
            }
        }
        let left =
            Panel::new(Cell::at(row, 0), x_axis(), axis(words, signal).linked("mean"), means);
        panels.push(left.titled(plain(&label)).tall(PANEL_MM));
        for (column, (branch, way)) in branches.iter().enumerate() {
            let nodes: Vec<&&CurveNode> =
                own.iter().filter(|point| point.branch == *branch).collect();
            let x: Vec<f64> = nodes.iter().map(|p| place(p.theta_rad, p.t_s)).collect();
            let of = |value: fn(&CurveNode) -> Option<f64>| {
                let values = nodes.iter().map(|point| value(point).unwrap_or(f64::NAN));
                y(&values.collect::<Vec<f64>>())
            };
            let colour = style::GREY;
            let band = Band {
                x: x.clone(),
                low: of(|point| point.band_low),
                high: of(|point| point.band_high),
                colour,
                name: None,
            };
            let line = Line {
                x,
                y: of(|point| Some(point.difference)),
                stroke: style::mean(style::INK),
                ..Line::default()
            };
            let is_here = |run: &&CurveRun| {
                let is_large = run.p_value < shown.alpha;
                let is_found = test.verdict == Some(Verdict::Different);
                is_found && run.effect == test.effect && run.branch == *branch && is_large
            };
            let runs = shown.runs.iter().filter(is_here).map(|run| {
                let low = place(run.theta_low_rad, run.begins_s);
                let high = place(run.theta_high_rad, run.ends_s);
                // Along zero, to which the difference is compared.
                Layer::Line(Line {
                    x: vec![low, high],
                    y: vec![0.0, 0.0],
                    stroke: Stroke { width_pt: 3.0, ..style::mean(style::INK) },
                    ..Line::default()
                })
            });
            let layers = if nodes.is_empty() {
                Vec::new()
            } else {
                let under = [Layer::Band(band), zero(Direction::Horizontal)];
                under.into_iter().chain(runs).chain([Layer::Line(line)]).collect()
            };
            let difference = axis(words, signal);
            let difference =
                Axis { label: format!("difference of {}", difference.label), ..difference };
            let cell = Cell::at(row, column + 1);
            let panel = match layers.is_empty() {
                true => Panel::with_note(cell, x_axis(), difference, "left out: see below"),
                false => Panel::new(cell, x_axis(), difference.linked("difference"), layers),
            };
            panels.push(panel.titled(*way).tall(PANEL_MM));
        }
    }
    let level = percent(shown.level);
    let of_groups = shown.tests.iter().any(|test| test.groups.is_some());
    let within = shown.tests.iter().find_map(|test| test.within.as_ref());
    let note = match (within, of_groups) {
        (Some(who), _) => format!(
            "Left: means over trials of {who}. Right: their difference; grey: pointwise {level} intervals of trials, a \
             description. p: largest t in other orders that the design could have drawn, after Holm."
        ),
        (None, true) => format!(
            "Left: means of groups. Right: their difference; grey: pointwise {level} intervals. p: largest t, labels \
             permuted; described, not claimed."
        ),
        (None, false) => format!(
            "Left: means over people. Right: their difference; grey: its {level} band, which covers the whole curve (of \
             fewer than six people pointwise). Thick on zero, where there is a difference: runs of large t with p below {}: it is \
             somewhere in one, not where it begins. p: largest t, signs flipped, after Holm.",
            percent(shown.alpha)
        ),
    };
    Figure {
        title: Some(plain(&format!(
            "{}: {}, {place_label}",
            about.title,
            curve_label(shown.curve, about.coordinate),
        ))),
        description: format!(
            "{} in {place_label}: means and differences with {}.",
            curve_label(shown.curve, about.coordinate),
            match within.is_some() || of_groups {
                true => format!("pointwise {level} intervals"),
                false => format!("{level} bands"),
            },
        ),
        panels: or_note(panels),
        footnotes: verdicts.iter().chain([&note]).map(|note| plain(note)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// `Hybrid − Active`, `expert − novice: Hybrid − Active`.
fn label(about: &About, test: &CurveDifference) -> String {
    let amounts = Amounts::of(&test.unit, about.coordinate);
    let effect = effect_label(&about.modes, &test.effect, &amounts);
    match &test.groups {
        Some(groups) => format!("{groups}: {effect}"),
        None => effect,
    }
}

/// What stands at either side of the minus.
fn sides(about: &About, test: &CurveDifference) -> [String; 2] {
    if let Some(groups) = &test.groups {
        return [groups.group.to_string(), groups.against.to_string()];
    }
    let amounts = Amounts::of(&test.unit, about.coordinate);
    let effect = effect_label(&about.modes, &test.effect, &amounts);
    match effect.split_once(Contrast::MINUS) {
        Some((first, second)) if matches!(test.effect, GroupEffect::Of(_)) => {
            [first.to_owned(), second.to_owned()]
        }
        _ => ["added".to_owned(), "taken away".to_owned()],
    }
}

/// What came out: `Hybrid − Active: different, p = 0.008, 8 participants`.
fn claim(label: &str, test: &CurveDifference) -> String {
    let p = test.p_adjusted.or(test.p_value);
    let p = p.map(|p| format!("p {}", p_value(p)).replace(' ', "\u{a0}"));
    let people = match (test.n_second, &test.within) {
        (Some(second), _) => format!("{} + {second} participants", test.n),
        (None, Some(_)) => counted(test.n, "trials"),
        (None, None) => counted(test.n, "participants"),
    };
    let verdict = test.verdict.map(|verdict| verdict.as_str().to_owned());
    let remark = test.remark.as_ref().map(ToString::to_string);
    let parts = [verdict, p, Some(people.replace(' ', "\u{a0}")), remark];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!("{label}: {}.", parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::Layer;
    use zwidth_results::Role;

    fn test(contrast: &str) -> CurveDifference {
        CurveDifference {
            curve: Curve::ForceOverAngle,
            unit: "N".into(),
            role: Role::Exploratory,
            environment: Some("spring".parse().unwrap()),
            effect: contrast.parse().unwrap(),
            groups: None,
            within: None,
            n: 8,
            n_second: None,
            nodes: 2,
            left_out: 0,
            largest_t: Some(3.0),
            branch: Some(LoopBranch::In),
            theta_rad: Some(0.2),
            t_s: None,
            difference: Some(0.5),
            critical_t: Some(2.9),
            band_t: Some(3.1),
            p_value: Some(0.03),
            smallest_p: Some(0.0078),
            p_adjusted: Some(0.03),
            p_unstudentised: Some(0.04),
            skewness: Some(0.1),
            verdict: Some(Verdict::Different),
            remark: None,
        }
    }

    fn node(effect: &GroupEffect, theta_rad: f64) -> CurveNode {
        CurveNode {
            curve: Curve::ForceOverAngle,
            unit: "N".into(),
            environment: Some("spring".parse().unwrap()),
            effect: effect.clone(),
            groups: None,
            branch: Some(LoopBranch::In),
            theta_rad: Some(theta_rad),
            t_s: None,
            mean_first: 1.5,
            mean_second: 1.0,
            difference: 0.5,
            difference_std_error: 0.1,
            statistic: Some(5.0),
            band_low: Some(0.2),
            band_high: Some(0.8),
        }
    }

    #[test]
    fn a_row_has_both_means_and_the_difference_on_each_way_and_what_is_not_tested_says_so() {
        let study = zwidth_testing::study();
        let [first, second] = [&study.modes[0], &study.modes[1]].map(|mode| mode.id.clone());
        let tested = test(&format!("{first} − {second}"));
        let other = test(&format!("{second} − {first}"));
        let points = [0.1, 0.2].map(|theta| node(&tested.effect, theta));
        let run = CurveRun {
            curve: Curve::ForceOverAngle,
            environment: Some("spring".parse().unwrap()),
            effect: tested.effect.clone(),
            branch: Some(LoopBranch::In),
            theta_low_rad: Some(0.1),
            theta_high_rad: Some(0.2),
            begins_s: None,
            ends_s: None,
            nodes: 2,
            mass: 10.0,
            p_value: 0.01,
        };
        let tests = [tested, other];
        let shown = CurvesShown {
            curve: Curve::ForceOverAngle,
            points: &points,
            tests: &tests,
            runs: std::slice::from_ref(&run),
            alpha: 0.05,
            level: 0.95,
        };
        let figure = curves_compared(&About::of(&study), Some(&study.environments[0]), &[], &shown);
        let [means, there, untested] = figure.panels.as_slice() else {
            panic!("{:?}", figure.panels)
        };
        assert!(means.note.is_none() && means.title.as_ref().unwrap().contains(" − "));
        let lines = there.lines().filter(|line| line.y.iter().all(|y| y.abs() < 1e-12)).count();
        assert_eq!(lines, 1, "the run lies on zero");
        assert!(there.layers.iter().any(|layer| matches!(layer, Layer::Band(_))));
        assert_eq!(untested.note.as_deref(), Some("not tested"));
        assert!(figure.footnotes[0].contains("different, p\u{a0}=\u{a0}0.03"));
    }
}
