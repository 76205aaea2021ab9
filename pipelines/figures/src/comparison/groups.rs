//! Groups of people compared, one metric per figure.

use super::compared::{
    MetricResults, PANEL_MM, Shown, WEIGHTS, apart, chosen_after, compared_modes, intervals, mean,
    or_note, zero,
};
use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::BTreeMap;
use zwidth_draw::style;
use zwidth_draw::{Axis, Band, Cell, Direction, Figure, Intervals, Layer, Panel, Points, dodge};
use zwidth_results::{GroupDifference, GroupEffect};
use zwidth_study::{Environment, EnvironmentId, LevelId, Mode, ParticipantId, Source};
use zwidth_tables::{Amounts, p_value};

/// The figure [`groups_compared`].
pub const GROUPS_COMPARED: FigureKind = FigureKind::new(
    "groups",
    "groups of people compared: everybody's means, and differences between groups",
    "trial",
);

/// Height of a difference that has a panel to itself, mm.
const ROW_MM: f64 = 8.0;

/// How far a mean stands beside the people whose mean it is, in categories.
const ASIDE: f64 = 0.08;

/// Groups compared: for each environment, at the left everybody's mean in each mode, group beside group, with
/// the groups' means; at the right the differences between groups with their intervals. Those in effects over several
/// environments stand below, at the right alone.
pub fn groups_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let mut groups: Vec<&LevelId> = Vec::new();
    for mean in &compared.group_means {
        if !groups.contains(&&mean.group) {
            groups.push(&mean.group);
        }
    }
    let mut panels = Vec::new();
    let mut verdicts = Vec::new();
    // Effects over several environments stand after those of each.
    for place in environments.iter().map(Some).chain([None]) {
        let id = place.map(|environment| &environment.id);
        let of_here = |row: &&GroupDifference| row.environment.as_ref() == id;
        let differences: Vec<&GroupDifference> = compared.groups.iter().filter(of_here).collect();
        if differences.is_empty() {
            continue;
        }
        let row = verdicts.len();
        if let Some(environment) = place {
            let modes = Axis::categories(about.modes.iter().map(|mode| plain(&mode.label)));
            let layers = people(about, &environment.id, &groups, &shown, compared);
            let panel = Panel::new(Cell::at(row, 0), modes, shown.axis("mean"), layers);
            panels.push(panel.titled(plain(&environment.label)).tall(PANEL_MM));
        }
        let first = &differences[0].groups;
        let is_one_pair = differences.iter().all(|row| row.groups == *first);
        let names = differences.iter().map(|row| match is_one_pair {
            true => plain(&effect_label(&about.modes, &row.effect, &shown.amounts)),
            false => plain(&format!(
                "{}: {}",
                shown.amounts.compared(&row.groups.to_string()),
                effect_label(&about.modes, &row.effect, &shown.amounts)
            )),
        });
        let label = match is_one_pair {
            true => shown.amounts.compared(&first.to_string()),
            false => "difference".to_owned(),
        };
        let rows = differences.iter().map(|row| Across {
            jnd: row.jnd,
            estimate: [row.difference, row.difference_ci_low, row.difference_ci_high],
        });
        let layers = across(&rows.collect::<Vec<_>>(), &shown);
        let names = Axis::categories(names);
        let panel =
            Panel::new(Cell::at(row, 1), shown.differences_axis(&plain(&label)), names, layers);
        // With nothing beside them a few rows need no more than their height.
        let alone =
            if place.is_none() { ROW_MM * (differences.len() as f64 + 1.0) } else { PANEL_MM };
        panels.push(panel.tall(alone.min(PANEL_MM)));
        let claims =
            differences.iter().filter_map(|row| claim(about, row, &shown)).collect::<Vec<_>>();
        let label =
            place.map_or_else(String::new, |environment| format!("{}: ", environment.label));
        verdicts.push(format!("{label}{}.", claims.join("; ")));
    }
    let level = percent(about.confidence);
    let footnotes = [format!(
        "Left: a dot is a participant, beside them their group's mean. Whiskers: {level} intervals, not \
             adjusted. Right, grey: ± 1 just noticeable difference, where it is known. p: after Holm, of what is \
             claimed; what has none is a description."
    )];
    let footnotes = verdicts.into_iter().chain(footnotes).chain(chosen_after(compared));
    Figure {
        title: Some(plain(&format!("{}: groups, {}", about.title, shown.words))),
        description: format!("{}: groups of people compared, with {level} intervals.", shown.words),
        panels: or_note(panels),
        column_weights: WEIGHTS.to_vec(),
        footnotes: footnotes.map(|note| plain(&note)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// What of people is compared, by the modes' labels.
pub(super) fn effect_label(modes: &[Mode], effect: &GroupEffect, amounts: &Amounts) -> String {
    match effect {
        GroupEffect::OverModes | GroupEffect::OfFactors(_) => amounts.compared(&effect.to_string()),
        GroupEffect::In(id) => {
            let mode = modes.iter().find(|mode| mode.id == *id);
            mode.map_or_else(|| id.to_string(), |mode| mode.label.clone())
        }
        GroupEffect::Of(contrast) => compared_modes(modes, contrast, amounts),
    }
}

/// What came out of a claim: `expert − novice, mean over modes: different, p = 0.003`.
fn claim(about: &About, row: &GroupDifference, shown: &Shown) -> Option<String> {
    let verdict = Some(row.verdict?.as_str().to_owned());
    let size = row.size.map(|size| size.as_str().to_owned());
    let p = row.p_adjusted.map(|p| format!("p {}", p_value(p)).replace(' ', "\u{a0}"));
    let people =
        Some(format!("{} and {} people", row.n_first, row.n_second).replace(' ', "\u{a0}"));
    let parts: Vec<String> = [verdict, size, p, people].into_iter().flatten().collect();
    let of = effect_label(&about.modes, &row.effect, &shown.amounts);
    let groups = shown.amounts.compared(&row.groups.to_string());
    Some(format!("{groups}, {of}: {}", parts.join(", ")))
}

/// Everybody's mean in each mode, group beside group, and the groups' means.
fn people(
    about: &About,
    environment: &EnvironmentId,
    groups: &[&LevelId],
    shown: &Shown,
    compared: &MetricResults,
) -> Vec<Layer> {
    let members: BTreeMap<&ParticipantId, &LevelId> =
        compared.group_members.iter().map(|row| (&row.participant, &row.group)).collect();
    let mut layers = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        let colour = style::environment_colour(index);
        let [mut x, mut y] = [Vec::new(), Vec::new()];
        let mut at = Vec::new();
        let mut estimates = Vec::new();
        for (place, mode) in about.modes.iter().enumerate() {
            let place = place as f64 + dodge(index, groups.len());
            let mut own: BTreeMap<&ParticipantId, Vec<f64>> = BTreeMap::new();
            for cell in &compared.cells {
                let is_here = (&cell.environment, &cell.mode) == (environment, &mode.id);
                if is_here && members.get(&cell.participant) == Some(group) {
                    let values = own.entry(&cell.participant).or_default();
                    values.extend(cell.mean.map(|mean| shown.value(mean)));
                }
            }
            // A person's sessions come together: the mean is over all of them.
            let people: Vec<f64> = own.values().map(|values| mean(values)).collect();
            x.extend(apart(place - ASIDE, &people));
            y.extend(people);
            let means = compared.group_means.iter().filter(|row| {
                (&row.environment, &row.mode, &row.group) == (environment, &mode.id, *group)
            });
            for row in means {
                at.push(place + ASIDE);
                estimates.push([Some(row.mean), row.ci_low, row.ci_high]);
            }
        }
        layers.push(Layer::Points(Points { x, y, colour, opacity: 0.55, ..Points::default() }));
        let value = |own| shown.value(own);
        let marks = intervals(Direction::Vertical, at, &estimates, value);
        let name = Some(plain(group.as_str()));
        let marker = style::marker(index);
        layers.push(Layer::Intervals(Intervals { colour, marker, name, ..marks }));
    }
    layers
}

/// A difference among others below each other.
pub(super) struct Across {
    /// The just noticeable difference.
    pub(super) jnd: Option<f64>,
    /// The difference, and the ends of its interval.
    pub(super) estimate: [Option<f64>; 3],
}

/// Differences below each other with their intervals, zero, and what is not felt.
pub(super) fn across(rows: &[Across], shown: &Shown) -> Vec<Layer> {
    let mut layers = Vec::new();
    for (place, row) in rows.iter().enumerate() {
        let Some(jnd) = row.jnd.map(|jnd| shown.difference(jnd)) else { continue };
        let [low, high] = [-0.4, 0.4].map(|side| place as f64 + side);
        layers.push(Layer::Band(Band {
            x: vec![-jnd, jnd],
            low: vec![low; 2],
            high: vec![high; 2],
            colour: style::GREY,
            name: None,
        }));
    }
    layers.push(zero(Direction::Vertical));
    let at = (0..rows.len()).map(|place| place as f64).collect();
    let estimates: Vec<[Option<f64>; 3]> = rows.iter().map(|row| row.estimate).collect();
    let placed = |own| shown.difference(own);
    layers.push(Layer::Intervals(intervals(Direction::Horizontal, at, &estimates, placed)));
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::verdicts::verdict_rows;
    use zwidth_draw::Ticks;
    use zwidth_results::{
        Cell as Found, Compared, GroupMean, GroupMember, Role, UnitOfAnalysis, Verdict,
    };
    use zwidth_study::Better;

    fn difference(
        effect: &str,
        difference: Option<f64>,
        verdict: Option<Verdict>,
    ) -> GroupDifference {
        GroupDifference {
            metric: "loop_area_j".parse().unwrap(),
            unit: "J".into(),
            environment: Some("spring".parse().unwrap()),
            effect: effect.parse().unwrap(),
            groups: "expert − novice".parse().unwrap(),
            n_first: 4,
            n_second: 6,
            mean_first: difference,
            mean_second: Some(0.0),
            sd_first: difference.map(|_| 0.3),
            sd_second: Some(0.4),
            difference,
            difference_std_error: difference.map(|_| 0.1),
            difference_ci_low: difference.map(|d| d - 0.25),
            difference_ci_high: difference.map(|d| d + 0.25),
            statistic: None,
            df: None,
            p_value: None,
            p_adjusted: verdict.map(|_| 0.04),
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
            verdict,
            remark: None,
        }
    }

    fn found(groups: Vec<GroupDifference>) -> MetricResults {
        let mean = |group: &str, mean: f64| GroupMean {
            metric: "loop_area_j".parse().unwrap(),
            unit: "J".into(),
            environment: "spring".parse().unwrap(),
            mode: "hybrid".parse().unwrap(),
            group: group.parse().unwrap(),
            n: 4,
            mean,
            sd: None,
            ci_low: None,
            ci_high: None,
        };
        let cell = |who: &str, mean: f64| Found {
            metric: "loop_area_j".parse().unwrap(),
            unit: "J".into(),
            participant: who.parse().unwrap(),
            session: "S01".parse().unwrap(),
            environment: "spring".parse().unwrap(),
            mode: "hybrid".parse().unwrap(),
            trials: 1,
            n: 1,
            mean: Some(mean),
            sd: None,
        };
        let member = |who: &str, group: &str| GroupMember {
            participant: who.parse().unwrap(),
            group: group.parse().unwrap(),
        };
        MetricResults {
            metric: Compared {
                metric: "loop_area_j".parse().unwrap(),
                unit: "J".into(),
                words: "area".to_owned(),
                role: Role::Primary,
                better: Better::Neither,
                unit_of_analysis: UnitOfAnalysis::Participants,
            },
            cells: vec![cell("P01", 1.0), cell("P02", 2.0), cell("P03", 3.0)],
            means: Vec::new(),
            contrasts: Vec::new(),
            participants: Vec::new(),
            groups,
            effects: Vec::new(),
            trend_curves: Vec::new(),
            group_means: vec![mean("novice", 1.0), mean("expert", 2.0)],
            // The third has no group, and no dot.
            group_members: vec![member("P01", "novice"), member("P02", "expert")],
            sessions: Vec::new(),
            repeats: Vec::new(),
            redrawn: Vec::new(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn people_stand_in_their_group_and_claims_below_the_figure() {
        let study = zwidth_testing::study();
        let about = About::of(&study);
        let claim = difference("hybrid − active", Some(0.5), Some(Verdict::Different));
        let rows =
            vec![claim, difference("hybrid", Some(0.4), None), difference("active", None, None)];
        let found = found(rows);
        let figure = groups_compared(&about, &study.environments, &[], &found);
        assert_eq!(figure.panels.len(), 2);
        let dots = figure.panels[0].layers.iter().filter_map(|layer| match layer {
            Layer::Points(points) => Some(points.y.clone()),
            _ => None,
        });
        assert_eq!(dots.collect::<Vec<_>>(), [vec![1.0], vec![2.0]]);
        assert!(
            figure.footnotes[0].contains("different, p\u{a0}=\u{a0}0.04"),
            "{:?}",
            figure.footnotes
        );
        assert!(!figure.footnotes[0].contains("novice, Active"), "{:?}", figure.footnotes);
        // In the figure of all verdicts it is measured by the groups' scatter: √((0.3² + 0.4²) / 2).
        let rows = verdict_rows(&about, &study.environments, std::slice::from_ref(&found));
        let [row] = rows.as_slice() else { panic!("{rows:?}") };
        assert!((row.estimate - 0.5 / 0.125_f64.sqrt()).abs() < 1e-12);
        assert!(row.place.ends_with("expert − novice, Hybrid − Active"), "{}", row.place);
        assert_eq!(row.who, "4 and 6 people");
        let mut later = found;
        later.metric.role = Role::ChosenAfter;
        let figure = groups_compared(&about, &study.environments, &[], &later);
        let last = figure.footnotes.last().unwrap();
        assert!(last.contains("chosen after the data"), "{:?}", figure.footnotes);
    }

    #[test]
    fn jnds_stand_on_logarithmic_axes_their_differences_as_ratios_about_1() {
        let study = zwidth_testing::study();
        let about = About::of(&study);
        let claim = difference("hybrid − active", Some(0.5), Some(Verdict::Different));
        let mut found = found(vec![claim, difference("hybrid", Some(0.5), None)]);
        found.metric.unit = "ln N/rad".into();
        let figure = groups_compared(&about, &study.environments, &[], &found);
        let [means, ratios] = [&figure.panels[0].y, &figure.panels[1].x];
        assert_eq!([&means.ticks, &ratios.ticks], [&Ticks::Logarithms; 2]);
        assert_eq!((means.unit.as_str(), ratios.unit.as_str()), ("N/rad", ""));
        assert_eq!(ratios.label, "expert / novice, ratio");
        assert!(figure.footnotes[0].contains("expert / novice, Hybrid / Active: different"));
        let rows = verdict_rows(&about, &study.environments, std::slice::from_ref(&found));
        let [row] = rows.as_slice() else { panic!("{rows:?}") };
        assert_eq!(row.place, "Spring: expert / novice, Hybrid / Active");
        assert_eq!(row.value, "1.65 times as large a ratio (1.28 to 2.12)");
        zwidth_draw::draw(&figure).unwrap();
    }

    #[test]
    fn groups_in_an_effect_over_several_environments_stand_below_those_of_each() {
        let study = zwidth_testing::study();
        let about = About::of(&study);
        let claim = difference("hybrid − active", Some(0.5), Some(Verdict::Different));
        let over = difference("contrast wall_costs", Some(0.2), Some(Verdict::Undecided));
        let found = found(vec![claim, GroupDifference { environment: None, ..over }]);
        let figure = groups_compared(&about, &study.environments, &[], &found);
        assert_eq!(figure.panels.len(), 3);
        assert_eq!((figure.panels[2].cell.row, figure.panels[2].cell.column), (1, 1));
        let note = "expert − novice, contrast wall\\_costs: undecided";
        assert!(figure.footnotes[1].starts_with(note), "{:?}", figure.footnotes);
        let rows = verdict_rows(&about, &study.environments, std::slice::from_ref(&found));
        let places: Vec<&str> = rows.iter().map(|row| row.place.as_str()).collect();
        let both =
            ["Spring: expert − novice, Hybrid − Active", "expert − novice, contrast wall_costs"];
        assert_eq!(places, both);
        zwidth_draw::draw(&figure).unwrap();
    }
}
