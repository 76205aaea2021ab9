//! Effects of factors, one metric per figure.

use super::compared::{
    MetricResults, PANEL_MM, Shown, WEIGHTS, chosen_after, intervals, mean, or_note,
};
use super::groups::{Across, across};
use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::BTreeMap;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Axis, Band, Cell, Direction, Figure, Intervals, Layer, Line, Panel, dodge};
use zwidth_results::{DosePoint, EffectDifference};
use zwidth_study::{
    DoseCurve, Environment, EnvironmentId, Factor, FactorId, FactorOf, LevelId, ModeId,
    ParticipantId, SessionId, Source, counted,
};
use zwidth_tables::p_value;

/// The figure [`effects_compared`].
pub const EFFECTS_COMPARED: FigureKind = FigureKind::new(
    "effects",
    "effects of factors: means by their levels, and effects with their intervals",
    "trial",
);

/// Effects compared: at the left the means by the levels of the first factor, a line for each level of the
/// second, in a panel for each level of any other; below them the curves over doses, of each level of another factor or of each
/// group of people, which take the place of these means where they show the same; at the right the effects with their intervals.
pub fn effects_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let over_all = about.factors.iter().any(|factor| factor.of == FactorOf::Environments);
    // Weighted contrasts over several environments stand after those of each.
    let each = environments.iter().filter(|_| !over_all).map(Some);
    let mut panels: Vec<Panel> = Vec::new();
    let mut verdicts = Vec::new();
    let mut drawn: Vec<&DosePoint> = Vec::new();
    // Panels have one legend: each name has its colour.
    let mut names: Vec<Option<String>> = Vec::new();
    let mut row = 0;
    for place in each.chain([None]) {
        let id = place.map(|environment| &environment.id);
        let is_here = |row: &&EffectDifference| over_all || row.environment.as_ref() == id;
        let effects: Vec<&EffectDifference> = compared.effects.iter().filter(is_here).collect();
        // Where nobody has the metric, as wall penetration without a wall, there is nothing to draw: no means, no effects.
        let mut cells = compared.cells.iter();
        let has_cells =
            cells.any(|cell| cell.n > 0 && place.is_none_or(|own| own.id == cell.environment));
        let has_none = !has_cells && effects.iter().all(|row| row.difference.is_none());
        if effects.is_empty() || has_none {
            continue;
        }
        let first_row = row;
        let mut by_levels = Vec::new();
        if place.is_some() || over_all {
            let curves = over_doses(about, id, compared);
            if !curves.iter().any(|panel| panel.shows_all) {
                by_levels = conditions(about, environments, place);
            }
            by_levels.extend(curves);
        }
        for panel in by_levels {
            let title = [place.map(|e| plain(&e.label)), panel.title].into_iter().flatten();
            let title = title.collect::<Vec<_>>().join(", ");
            let x = panel.factor.map(|factor| {
                let label = plain(factor.id.as_str());
                match &factor.unit {
                    Some(unit) => Axis::new(label, unit.as_str()),
                    None => Axis {
                        label,
                        ..Axis::categories(factor.levels.iter().map(|level| plain(level.as_str())))
                    },
                }
            });
            let x = x.unwrap_or_else(|| Axis::new("", ""));
            for series in &panel.series {
                drawn.extend(&series.curve);
                if !names.contains(&series.name) {
                    names.push(series.name.clone());
                }
            }
            let layers = lines(panel.factor, &panel.series, &names, &shown, compared);
            let panel = Panel::new(Cell::at(row, 0), x, shown.axis("mean"), layers);
            panels.push(panel.titled(title).tall(PANEL_MM));
            row += 1;
        }
        let names = Axis::categories(effects.iter().map(|row| plain(&effect_name(row, &shown))));
        let rows = effects.iter().map(|row| Across {
            jnd: row.jnd,
            estimate: [row.difference, row.difference_ci_low, row.difference_ci_high],
        });
        let layers = across(&rows.collect::<Vec<_>>(), &shown);
        let panel =
            Panel::new(Cell::at(first_row, 1), shown.differences_axis("effect"), names, layers);
        panels.push(panel.tall(PANEL_MM));
        row = row.max(first_row + 1);
        let claims: Vec<String> = effects.iter().map(|row| claim(row, &shown)).collect();
        let label =
            place.map_or_else(String::new, |environment| format!("{}: ", environment.label));
        verdicts.push(format!("{label}{}.", claims.join("; ")));
    }
    let level = percent(about.confidence);
    let footnotes = [format!(
        "Left, grey: participants; discs: their mean. Whiskers: {level} intervals, not adjusted. Right: a later level \
         of a factor less the first (of a dose its slope), the others averaged; grey: ± 1 just noticeable difference, where it is known. \
         p: after Holm."
    )];
    let people = drawn.iter().map(|point| point.n);
    let curve = people.clone().min().zip(people.max()).map(|(fewest, most)| {
        let people = match fewest == most {
            true => counted(most, "participants"),
            false => format!("{fewest} to {}", counted(most, "participants")),
        };
        let alone = format!("{level} intervals at each dose alone");
        let banded = drawn.iter().filter(|point| point.band_low.is_some()).count();
        let with = match banded {
            0 => alone,
            all if all == drawn.len() => format!("the {level} band of the whole curve"),
            _ => {
                format!(
                    "the {level} band of the whole curve (of fewer than 6 participants {alone})"
                )
            }
        };
        let lines = "mean of the own lines or parabolas";
        format!("Curve: {lines} of {people} with every dose, with {with}.")
    });
    Figure {
        title: Some(plain(&format!("{}: effects of factors, {}", about.title, shown.words))),
        description: format!("{}: effects of factors, with {level} intervals.", shown.words),
        panels: or_note(panels),
        column_weights: WEIGHTS.to_vec(),
        footnotes: verdicts
            .iter()
            .chain(&footnotes)
            .chain(&curve)
            .chain(&chosen_after(compared))
            .map(|note| plain(note))
            .collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// `motor: yes − no`, of logarithms `motor: yes / no`; a weighted contrast by its name.
pub(super) fn effect_name(row: &EffectDifference, shown: &Shown) -> String {
    let factors = row.effect.to_string().replace(':', " × ");
    match &row.levels {
        Some(levels) => {
            format!("{factors}: {}", shown.amounts.compared(&levels.to_string()))
        }
        None => factors,
    }
}

/// What came out: `motor: yes − no: different, p = 0.003, 8 participants`.
fn claim(row: &EffectDifference, shown: &Shown) -> String {
    let size = row.size.map(|size| size.as_str().to_owned());
    let p = row.p_adjusted.map(|p| format!("p {}", p_value(p)).replace(' ', "\u{a0}"));
    let people = (row.n > 0).then(|| counted(row.n, "participants").replace(' ', "\u{a0}"));
    let remark = row.remark.as_ref().map(ToString::to_string);
    let verdict = Some(row.verdict.as_str().to_owned());
    let parts: Vec<String> = [verdict, size, p, people, remark].into_iter().flatten().collect();
    format!("{}: {}", effect_name(row, shown), parts.join(", "))
}

/// A panel of means by the levels of a factor.
struct ByLevels<'a> {
    /// What it is of, besides the environment.
    title: Option<String>,
    /// The factor; none of weighted contrasts alone.
    factor: Option<&'a Factor>,
    /// Its lines.
    series: Vec<Series<'a>>,
    /// Whether it has curves, and by every factor and group.
    shows_all: bool,
}

/// A line of a panel.
struct Series<'a> {
    /// What the legend calls it.
    name: Option<String>,
    /// Its conditions.
    conditions: Vec<Placed<'a>>,
    /// Whose means; everybody's if none is named.
    group: Option<&'a LevelId>,
    /// Its curve over the dose; without one the means are joined.
    curve: Vec<&'a DosePoint>,
}

/// A condition by the place of its level.
#[derive(Clone, Copy, PartialEq)]
struct Placed<'a> {
    /// Its session, where that is a level.
    session: Option<&'a str>,
    environment: &'a EnvironmentId,
    mode: &'a ModeId,
    at: usize,
}

/// The conditions of a place by their levels of the first two factors, in a panel for each level of any other, in the study's
/// order.
fn conditions<'a>(
    about: &'a About,
    environments: &'a [Environment],
    place: Option<&Environment>,
) -> Vec<ByLevels<'a>> {
    let second = about.factors.get(1);
    let number = second.map_or(1, |factor| factor.levels.len());
    let mut by_rest: BTreeMap<Option<String>, Vec<Vec<Placed>>> = BTreeMap::new();
    let of_sessions = about.factors.iter().find(|factor| factor.of == FactorOf::Sessions);
    let sessions: Vec<Option<&LevelId>> = match of_sessions {
        Some(factor) => factor.levels.iter().map(Some).collect(),
        None => vec![None],
    };
    let here = environments.iter().filter(|e| place.is_none_or(|place| place.id == e.id));
    let pairs = here.flat_map(|e| about.modes.iter().map(move |mode| (e, mode)));
    for (environment, mode) in pairs {
        for session in &sessions {
            let level = |factor: &Factor| match factor.of {
                FactorOf::Sessions => *session,
                FactorOf::Modes => mode.factors.get(&factor.id),
                FactorOf::Environments => environment.factors.get(&factor.id),
            };
            let at = |index: usize| -> Option<usize> {
                let Some(factor) = about.factors.get(index) else { return Some(0) };
                factor.levels.iter().position(|own| Some(own) == level(factor))
            };
            let (Some(first), Some(second)) = (at(0), at(1)) else { continue };
            let rest = about.factors.iter().skip(2);
            let rest =
                rest.filter_map(|factor| Some(format!("{} = {}", factor.id, level(factor)?)));
            let rest: Vec<String> = rest.collect();
            let rest = (!rest.is_empty()).then(|| rest.join(", "));
            by_rest.entry(rest).or_insert_with(|| vec![Vec::new(); number])[second].push(Placed {
                session: session.map(LevelId::as_str),
                environment: &environment.id,
                mode: &mode.id,
                at: first,
            });
        }
    }
    let panels = by_rest.into_iter().map(|(title, lines)| {
        let series = lines.into_iter().enumerate().map(|(index, conditions)| Series {
            name: second.map(|factor| format!("{} = {}", factor.id, factor.levels[index])),
            conditions,
            group: None,
            curve: Vec::new(),
        });
        let (factor, series) = (about.factors.first(), series.collect());
        ByLevels { title, factor, series, shows_all: false }
    });
    panels.collect()
}

/// The curves over doses in an environment, or over all: of each dose by the levels of every factor that may change its curve,
/// or else alone; of groups of people by group.
fn over_doses<'a>(
    about: &'a About,
    place: Option<&EnvironmentId>,
    compared: &'a MetricResults,
) -> Vec<ByLevels<'a>> {
    let mut panels: Vec<ByLevels> = Vec::new();
    let here = about.dose_curves.iter().filter(|curve| curve.environment.as_ref() == place);
    let here: Vec<&DoseCurve> = here.collect();
    let mut groups: Vec<Option<&LevelId>> = Vec::new();
    for mean in &compared.group_means {
        if !groups.contains(&Some(&mean.group)) {
            groups.push(Some(&mean.group));
        }
    }
    let has_groups = !groups.is_empty();
    if !has_groups {
        groups.push(None);
    }
    for dose in about.factors.iter().filter(|factor| factor.unit.is_some()) {
        let own = here.iter().filter(|curve| curve.dose == dose.id);
        let mut others: Vec<Option<&FactorId>> = Vec::new();
        for curve in own.clone() {
            let other = curve.within.as_ref().map(|within| &within.factor);
            if !others.contains(&other) {
                others.push(other);
            }
        }
        // Where a curve may depend on a factor its mean over the levels need not look like any of them; groups are compared in
        // it.
        let depends = others.iter().any(Option::is_some);
        let is_by_level = depends && !has_groups;
        others.retain(|other| other.is_some() == is_by_level);
        for other in others {
            let mut series: Vec<Series> = Vec::new();
            for curve in own.clone() {
                if curve.within.as_ref().map(|within| &within.factor) != other {
                    continue;
                }
                let levels = curve.over.levels.iter().enumerate();
                let conditions = levels.flat_map(|(at, level)| {
                    level.iter().map(move |weight| Placed {
                        session: weight.session.as_ref().map(SessionId::as_str),
                        environment: &weight.environment,
                        mode: &weight.mode,
                        at,
                    })
                });
                let conditions: Vec<Placed> = conditions.collect();
                for group in &groups {
                    let points = compared.trend_curves.iter().filter(|point| {
                        let within = curve.within.as_ref();
                        point.environment == curve.environment
                            && point.effect.0 == [curve.dose.clone()]
                            && point.factor.as_ref() == within.map(|within| &within.factor)
                            && point.level.as_ref() == within.map(|within| &within.level)
                            && point.group.as_ref() == *group
                    });
                    let within = curve
                        .within
                        .as_ref()
                        .map(|within| format!("{} = {}", within.factor, within.level));
                    series.push(Series {
                        name: within.or(group.map(ToString::to_string)),
                        conditions: conditions.clone(),
                        group: *group,
                        curve: points.collect(),
                    });
                }
            }
            if series.iter().all(|series| series.curve.is_empty()) {
                continue;
            }
            let averaged = about.factors.iter().map(|factor| &factor.id);
            let averaged = averaged.filter(|id| **id != dose.id && Some(*id) != other);
            let averaged: Vec<&str> = averaged.map(|id| id.as_str()).collect();
            panels.push(ByLevels {
                title: (!averaged.is_empty()).then(|| format!("{} averaged", averaged.join(", "))),
                factor: Some(dose),
                series,
                shows_all: averaged.is_empty(),
            });
        }
    }
    panels
}

/// A line through the means of each series, or its curve, and everybody's behind them; `names` are those of the figure, in the
/// order of their colours.
fn lines(
    factor: Option<&Factor>,
    series: &[Series],
    names: &[Option<String>],
    shown: &Shown,
    compared: &MetricResults,
) -> Vec<Layer> {
    let doses = factor.and_then(Factor::doses);
    let members: BTreeMap<&ParticipantId, &LevelId> =
        compared.group_members.iter().map(|row| (&row.participant, &row.group)).collect();
    let (mut people, mut means) = (Vec::new(), Vec::new());
    for (index, Series { name, conditions, group, curve }) in series.iter().enumerate() {
        let look = names.iter().position(|own| own == name).unwrap_or(index);
        let colour = style::environment_colour(look);
        let dash = style::dash(look);
        // Everybody's means of the conditions at each level.
        let mut own: BTreeMap<&ParticipantId, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
        let mut line: BTreeMap<usize, [Option<f64>; 3]> = BTreeMap::new();
        for Placed { session, environment, mode, at } in conditions {
            // A person's sessions come together: the mean is over all of them.
            let mut here: BTreeMap<&ParticipantId, Vec<f64>> = BTreeMap::new();
            for cell in &compared.cells {
                let is_here = (&cell.environment, &cell.mode) == (*environment, *mode)
                    && session.is_none_or(|id| cell.session.as_str() == id)
                    && group.is_none_or(|id| members.get(&cell.participant) == Some(&id));
                if let Some(mean) = cell.mean.filter(|_| is_here) {
                    here.entry(&cell.participant).or_default().push(shown.value(mean));
                }
            }
            for (who, values) in here {
                own.entry(who).or_default().entry(*at).or_default().push(mean(&values));
            }
            let found = match group {
                None => compared
                    .means
                    .iter()
                    .find(|row| (&row.environment, &row.mode) == (*environment, *mode))
                    .map(|row| [Some(row.mean), row.ci_low, row.ci_high]),
                Some(group) => compared
                    .group_means
                    .iter()
                    .find(|row| {
                        (&row.environment, &row.mode, &row.group) == (*environment, *mode, *group)
                    })
                    .map(|row| [Some(row.mean), row.ci_low, row.ci_high]),
            };
            line.extend(found.filter(|_| session.is_none()).map(|row| (*at, row)));
        }
        // Several conditions share a place where they are averaged, and so do those of one session: the mean is that of the
        // people who have all of them.
        for at in 0..factor.map_or(1, |factor| factor.levels.len()) {
            let here = conditions.iter().filter(|condition| condition.at == at).count();
            own.values_mut().for_each(|own| {
                own.retain(|place, values| *place != at || values.len() == here);
            });
            let people: Vec<f64> =
                own.values().filter_map(|own| own.get(&at)).map(|values| mean(values)).collect();
            if here > 1 || conditions.iter().any(|condition| condition.session.is_some()) {
                line.remove(&at);
                if !people.is_empty() {
                    line.insert(at, [Some(shown.own(mean(&people))), None, None]);
                }
            }
        }
        let place = |at: usize| match &doses {
            Some(doses) => doses[at],
            None => at as f64 + dodge(index, series.len()),
        };
        for values in own.values() {
            people.push(Layer::Line(Line {
                x: values.keys().map(|at| place(*at)).collect(),
                y: values.values().map(|values| mean(values)).collect(),
                stroke: Stroke { opacity: 0.45, ..style::faint(style::GREY) },
                ..Line::default()
            }));
        }
        let at: Vec<f64> = line.keys().map(|at| place(*at)).collect();
        let of = |value: fn(&DosePoint) -> f64| -> Vec<f64> {
            curve.iter().map(|point| shown.value(value(point))).collect()
        };
        let doses: Vec<f64> = curve.iter().map(|point| point.dose).collect();
        if !curve.is_empty() {
            means.push(Layer::Band(Band {
                x: doses.clone(),
                low: of(|point| point.band_low.unwrap_or(point.ci_low)),
                high: of(|point| point.band_high.unwrap_or(point.ci_high)),
                colour,
                name: None,
            }));
        }
        means.push(Layer::Line(Line {
            x: if curve.is_empty() { at.clone() } else { doses },
            y: match curve.is_empty() {
                true => line
                    .values()
                    .map(|row| row[0].map_or(f64::NAN, |mean| shown.value(mean)))
                    .collect(),
                false => of(|point| point.mean),
            },
            stroke: Stroke { dash, ..style::mean(colour) },
            ..Line::default()
        }));
        let estimates: Vec<_> = line.into_values().collect();
        let marks = intervals(Direction::Vertical, at, &estimates, |own| shown.value(own));
        let marker = style::marker(look);
        let name = name.as_deref().map(plain);
        means.push(Layer::Intervals(Intervals { colour, marker, name, ..marks }));
    }
    people.into_iter().chain(means).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::verdicts::verdict_rows;
    use zwidth_results::{Cell as Found, Compared, GroupMean, Mean, Role, UnitOfAnalysis, Verdict};
    use zwidth_study::{Better, Mode, Study, Term};

    /// The template's study, whose modes are weak, strong, and strong with noise.
    fn study() -> Study {
        let mut study = zwidth_testing::study();
        let factor = |id: &str, levels: [&str; 2]| Factor {
            id: id.parse().unwrap(),
            levels: levels.map(|level| level.parse().unwrap()).to_vec(),
            unit: None,
            of: FactorOf::Modes,
        };
        study.factors = vec![factor("force", ["weak", "strong"]), factor("noise", ["off", "on"])];
        let levels = [["weak", "off"], ["strong", "off"], ["strong", "on"]];
        for (mode, [force, noise]) in study.modes.iter_mut().zip(levels) {
            mode.factors.insert("force".parse().unwrap(), force.parse().unwrap());
            mode.factors.insert("noise".parse().unwrap(), noise.parse().unwrap());
        }
        study
    }

    fn effect(term: &str, difference: Option<f64>) -> EffectDifference {
        EffectDifference {
            metric: "loop_area_j".parse().unwrap(),
            unit: "J".into(),
            environment: Some("spring".parse().unwrap()),
            effect: term.parse().unwrap(),
            levels: Some("strong − weak".parse().unwrap()),
            n: 4,
            difference,
            difference_std_error: difference.map(|_| 0.1),
            difference_ci_low: difference.map(|d| d - 0.25),
            difference_ci_high: difference.map(|d| d + 0.25),
            statistic: None,
            df: difference.map(|_| 3.0),
            p_value: None,
            p_adjusted: difference.map(|_| 0.04),
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
            verdict: if difference.is_some() { Verdict::Different } else { Verdict::NotTested },
            remark: None,
        }
    }

    fn found(study: &Study) -> MetricResults {
        let modes = study.modes.iter();
        let cells = modes.clone().zip([1.0, 2.0, 4.0]).map(|(mode, mean)| Found {
            metric: "loop_area_j".parse().unwrap(),
            unit: "J".into(),
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            environment: "spring".parse().unwrap(),
            mode: mode.id.clone(),
            trials: 1,
            n: 1,
            mean: Some(mean),
            sd: None,
        });
        let means = modes.zip([1.5, 2.5, 4.5]).map(|(mode, mean)| Mean {
            metric: "loop_area_j".parse().unwrap(),
            unit: "J".into(),
            environment: "spring".parse().unwrap(),
            mode: mode.id.clone(),
            unit_of_analysis: UnitOfAnalysis::Participants,
            n: 4,
            trials: 4,
            trials_with_value: 4,
            mean,
            sd: None,
            ci_low: None,
            ci_high: None,
        });
        MetricResults {
            metric: Compared {
                metric: "loop_area_j".parse().unwrap(),
                unit: "J".into(),
                words: "area".to_owned(),
                role: Role::Primary,
                better: Better::Neither,
                unit_of_analysis: UnitOfAnalysis::Participants,
            },
            cells: cells.collect(),
            means: means.collect(),
            contrasts: Vec::new(),
            participants: Vec::new(),
            groups: Vec::new(),
            effects: vec![effect("force", Some(0.5)), effect("force:noise", None)],
            trend_curves: Vec::new(),
            group_means: Vec::new(),
            group_members: Vec::new(),
            sessions: Vec::new(),
            repeats: Vec::new(),
            redrawn: Vec::new(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn means_stand_by_their_levels_and_effects_beside_them() {
        let study = study();
        let (about, found) = (About::of(&study), found(&study));
        let figure = effects_compared(&about, &study.environments, &[], &found);
        assert_eq!(figure.panels.len(), 2, "nothing is compared in the other environment");
        let mut other = found.clone();
        other.effects.retain(|row| row.difference.is_none());
        for row in &mut other.effects {
            row.environment = Some(study.environments[1].id.clone());
        }
        assert!(!other.effects.is_empty());
        let drawn = effects_compared(&about, &study.environments, &[], &other);
        assert_eq!(
            drawn.panels[0].note.as_deref(),
            Some("nothing to compare"),
            "nobody has it there"
        );
        let lines = figure.panels[0].layers.iter().filter_map(|layer| match layer {
            Layer::Line(line) => Some(line.y.clone()),
            _ => None,
        });
        // Without noise and with it: everybody's line, then that of the means.
        let lines: Vec<Vec<f64>> = lines.collect();
        assert_eq!(lines, [vec![1.0, 2.0], vec![4.0], vec![1.5, 2.5], vec![4.5]]);
        let note = &figure.footnotes[0];
        assert!(note.contains("force: strong − weak: different, p\u{a0}=\u{a0}0.04"), "{note}");
        assert!(note.contains("force × noise"), "{note}");
        // What was not estimated has no row among the verdicts; the other is in SDs of people's effects.
        let rows = verdict_rows(&about, &study.environments, std::slice::from_ref(&found));
        let [row] = rows.as_slice() else { panic!("{rows:?}") };
        assert!((row.estimate - 0.5 / 0.2).abs() < 1e-12);
        assert!(row.place.ends_with(": force: strong − weak"), "{}", row.place);
    }

    /// A dose and a motor, of which a curve at both ends is known at each level, of everybody or of a group.
    fn over_doses(third: bool, groups: &[&str]) -> Figure {
        let mut study = study();
        let level = |text: &str| -> LevelId { text.parse().unwrap() };
        let (gain, motor, side): (FactorId, FactorId, FactorId) =
            ("gain".parse().unwrap(), "motor".parse().unwrap(), "side".parse().unwrap());
        let mode = study.modes[0].clone();
        study.modes.clear();
        for dose in ["1", "2"] {
            for with in ["no", "yes"] {
                for left in ["left", "right"].into_iter().take(1 + usize::from(third)) {
                    let factors = [(&gain, dose), (&motor, with), (&side, left)];
                    let factors = factors.map(|(id, text)| (id.clone(), level(text)));
                    study.modes.push(Mode {
                        id: format!("{with}{dose}{left}").parse().unwrap(),
                        factors: factors.into(),
                        ..mode.clone()
                    });
                }
            }
        }
        let factor = |id: &FactorId, levels: [&str; 2], unit: Option<&str>| Factor {
            id: id.clone(),
            levels: levels.map(level).to_vec(),
            unit: unit.map(str::to_owned),
            of: FactorOf::Modes,
        };
        study.factors = vec![
            factor(&motor, ["no", "yes"], None),
            factor(&gain, ["1", "2"], Some("1")),
            factor(&side, ["left", "right"], None),
        ];
        study.factors.truncate(2 + usize::from(third));
        study.compare.effects = ["gain", "motor:gain"].map(|term| term.parse().unwrap()).to_vec();
        let mut found = found(&study);
        let of_groups = groups.iter().map(|group| Some(level(group)));
        let of_groups: Vec<Option<LevelId>> =
            if groups.is_empty() { vec![None] } else { of_groups.collect() };
        for (index, group) in of_groups.into_iter().enumerate() {
            for with in [None, Some("no"), Some("yes")] {
                found.trend_curves.extend([1.0, 2.0].map(|dose| DosePoint {
                    metric: "loop_area_j".parse().unwrap(),
                    unit: "J".into(),
                    environment: Some("spring".parse().unwrap()),
                    effect: Term(vec![gain.clone()]),
                    factor: with.map(|_| motor.clone()),
                    level: with.map(level),
                    group: group.clone(),
                    dose,
                    dose_unit: "1".to_owned(),
                    n: 4 + index,
                    mean: dose + if with == Some("yes") { 10.0 } else { 0.0 } + 20.0 * index as f64,
                    std_error: 0.1,
                    ci_low: dose - 0.2,
                    ci_high: dose + 0.2,
                    band_low: None,
                    band_high: None,
                }));
            }
        }
        found.group_means = groups
            .iter()
            .map(|group| GroupMean {
                metric: "loop_area_j".parse().unwrap(),
                unit: "J".into(),
                environment: "spring".parse().unwrap(),
                mode: study.modes[0].id.clone(),
                group: level(group),
                n: 4,
                mean: 1.0,
                sd: None,
                ci_low: None,
                ci_high: None,
            })
            .collect();
        effects_compared(&About::of(&study), &study.environments, &[], &found)
    }

    /// The names of a panel's lines, each with where its curve is at both ends, if it has one.
    fn curves(panel: &Panel) -> Vec<(String, [f64; 2])> {
        let bands = panel.layers.windows(3).filter_map(|layers| match layers {
            [Layer::Band(_), Layer::Line(line), Layer::Intervals(marks)] => {
                Some((marks.name.clone().unwrap_or_default(), [line.y[0], line.y[1]]))
            }
            _ => None,
        });
        bands.collect()
    }

    #[test]
    fn curves_over_a_dose_stand_by_the_levels_that_may_change_them_or_by_group() {
        let by_motor =
            [("motor = no".to_owned(), [1.0, 2.0]), ("motor = yes".to_owned(), [11.0, 12.0])];
        let two = over_doses(false, &[]);
        assert_eq!(two.panels.len(), 2, "means by the same levels are not drawn twice");
        assert_eq!(curves(&two.panels[0]), by_motor);
        let note = two.footnotes.last().unwrap();
        assert!(note.contains("of 4 participants with every dose, with 95"), "{note}");
        // Of three factors the means stand by all of them, and the curves below over the third.
        let three = over_doses(true, &[]);
        let titles: Vec<_> = three.panels.iter().filter_map(|panel| panel.title.clone()).collect();
        assert!(titles.len() == 3 && titles[2].ends_with("side averaged"), "{titles:?}");
        assert_eq!(curves(&three.panels[2]), by_motor);
        // Groups are compared in the curve over all levels.
        let groups = over_doses(false, &["novice", "expert"]);
        let of_groups = [("novice".to_owned(), [1.0, 2.0]), ("expert".to_owned(), [21.0, 22.0])];
        assert_eq!(curves(&groups.panels[1]), of_groups);
        let note = groups.footnotes.last().unwrap();
        assert!(note.contains("of 4 to 5 participants"), "{note}");
    }
}
