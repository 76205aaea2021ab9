//! Effects of factors, one metric per figure.

use super::compared::{MetricResults, PANEL_MM, Shown, WEIGHTS, intervals, mean, or_note};
use super::groups::{Across, across};
use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::BTreeMap;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Axis, Band, Cell, Direction, Figure, Intervals, Layer, Line, Panel, dodge};
use zwidth_results::{DosePoint, EffectDifference};
use zwidth_study::{
    Environment, EnvironmentId, Factor, FactorOf, LevelId, ModeId, ParticipantId, Source, counted,
};
use zwidth_tables::p_value;

/// The figure [`effects_compared`].
pub const EFFECTS_COMPARED: FigureKind = FigureKind::new(
    "effects",
    "effects of factors: means by their levels, and effects with their intervals",
    "trial",
);

/// Effects compared: at the left the means by the levels of the first factor, a line for each level of the
/// second, in a panel for each level of any other; at the right the effects with their intervals.
pub fn effects_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let over_all = about.factors.iter().any(|factor| factor.of == FactorOf::Environments);
    // Of several factors the lines are those of single levels.
    let is_drawn = about.factors.len() == 1;
    // Weighted contrasts over several environments stand after those of each.
    let each = environments.iter().filter(|_| !over_all).map(Some);
    let mut panels: Vec<Panel> = Vec::new();
    let mut verdicts = Vec::new();
    let mut row = 0;
    for place in each.chain([None]) {
        let id = place.map(|environment| &environment.id);
        let is_here = |row: &&EffectDifference| over_all || row.environment.as_ref() == id;
        let effects: Vec<&EffectDifference> = compared.effects.iter().filter(is_here).collect();
        if effects.is_empty() {
            continue;
        }
        let first_row = row;
        let with_means = place.is_some() || over_all;
        let by_levels = with_means.then(|| conditions(about, environments, place));
        for (levels, conditions) in by_levels.into_iter().flatten() {
            let title = [place.map(|e| plain(&e.label)), levels].into_iter().flatten();
            let title = title.collect::<Vec<_>>().join(", ");
            let x = about.factors.first().map(|factor| {
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
            let is_of_place =
                |point: &&DosePoint| is_drawn && point.environment.as_ref() == place.map(|e| &e.id);
            let curve: Vec<&DosePoint> = compared.trend_curves.iter().filter(is_of_place).collect();
            let layers = lines(about, &conditions, &curve, &shown, compared);
            let panel = Panel::new(Cell::at(row, 0), x, shown.axis("mean"), layers);
            panels.push(panel.titled(title).tall(PANEL_MM));
            row += 1;
        }
        let names = Axis::categories(effects.iter().map(|row| plain(&effect_name(row))));
        let rows = effects.iter().map(|row| Across {
            jnd: row.jnd,
            estimate: [row.difference, row.difference_ci_low, row.difference_ci_high],
        });
        let layers = across(&rows.collect::<Vec<_>>(), &shown);
        let panel = Panel::new(Cell::at(first_row, 1), shown.axis("effect"), names, layers);
        panels.push(panel.tall(PANEL_MM));
        row = row.max(first_row + 1);
        let claims: Vec<String> = effects.iter().map(|row| claim(row)).collect();
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
    let banded = compared.trend_curves.iter().any(|point| point.band_low.is_some());
    let curve = compared.trend_curves.first().filter(|_| is_drawn).map(|point| match banded {
        true => format!("Line: mean of the own lines or parabolas of {} with every level, with the {level} band of the whole curve.", counted(point.n, "participants")),
        false => format!("Line: mean of the own lines or parabolas of {} with every level, with {level} intervals at each dose alone.", counted(point.n, "participants")),
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
            .map(|note| plain(note))
            .collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// `motor: yes − no`; a weighted contrast by its name.
pub(super) fn effect_name(row: &EffectDifference) -> String {
    let factors = row.effect.to_string().replace(':', " × ");
    match &row.levels {
        Some(levels) => format!("{factors}: {levels}"),
        None => factors,
    }
}

/// What came out: `motor: yes − no: different, p = 0.003, 8 participants`.
fn claim(row: &EffectDifference) -> String {
    let size = row.size.map(|size| size.as_str().to_owned());
    let p = row.p_adjusted.map(|p| format!("p {}", p_value(p)).replace(' ', "\u{a0}"));
    let people = (row.n > 0).then(|| counted(row.n, "participants").replace(' ', "\u{a0}"));
    let remark = row.remark.as_ref().map(ToString::to_string);
    let verdict = Some(row.verdict.as_str().to_owned());
    let parts: Vec<String> = [verdict, size, p, people, remark].into_iter().flatten().collect();
    format!("{}: {}", effect_name(row), parts.join(", "))
}

/// A condition by the places of its levels of the first two factors.
struct Crossed<'a> {
    /// Its session, where that is a level.
    session: Option<&'a LevelId>,
    environment: &'a EnvironmentId,
    mode: &'a ModeId,
    at: [usize; 2],
}

/// The conditions of a place, by their levels of every factor after the second, in the study's order.
fn conditions<'a>(
    about: &'a About,
    environments: &'a [Environment],
    place: Option<&Environment>,
) -> BTreeMap<Option<String>, Vec<Crossed<'a>>> {
    let mut by_rest: BTreeMap<Option<String>, Vec<Crossed>> = BTreeMap::new();
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
            by_rest.entry((!rest.is_empty()).then(|| rest.join(", "))).or_default().push(Crossed {
                session: *session,
                environment: &environment.id,
                mode: &mode.id,
                at: [first, second],
            });
        }
    }
    by_rest
}

/// A line through the means for each level of the second factor, and everybody's behind them.
fn lines(
    about: &About,
    conditions: &[Crossed],
    curve: &[&DosePoint],
    shown: &Shown,
    compared: &MetricResults,
) -> Vec<Layer> {
    let second = about.factors.get(1);
    let doses = about.factors.first().and_then(Factor::doses);
    let number = second.map_or(1, |factor| factor.levels.len());
    let (mut people, mut means) = (Vec::new(), Vec::new());
    for index in 0..number {
        let colour = style::environment_colour(index);
        let dash = style::dash(index);
        let mut own: BTreeMap<&ParticipantId, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
        let mut line: BTreeMap<usize, [Option<f64>; 3]> = BTreeMap::new();
        for condition in conditions.iter().filter(|condition| condition.at[1] == index) {
            let Crossed { session, environment, mode, at: [at, _] } = condition;
            let cells = compared.cells.iter().filter(|cell| {
                (&cell.environment, &cell.mode) == (*environment, *mode)
                    && session.is_none_or(|id| cell.session.as_str() == id.as_str())
            });
            for cell in cells {
                // A person's sessions come together: the mean is over all of them.
                let values = own.entry(&cell.participant).or_default().entry(*at).or_default();
                values.extend(cell.mean.map(|mean| mean * shown.factor));
            }
            let mut means = compared.means.iter();
            let found = means.find(|row| (&row.environment, &row.mode) == (*environment, *mode));
            let found = found.map(|row| [Some(row.mean), row.ci_low, row.ci_high]);
            line.extend(found.filter(|_| session.is_none()).map(|row| (*at, row)));
        }
        // Several conditions share a place where no factor tells them apart, and so do those of one session:
        // the mean is that of the people.
        for at in 0..about.factors.first().map_or(1, |factor| factor.levels.len()) {
            let here = conditions.iter().filter(|condition| condition.at == [at, index]).count();
            let people: Vec<f64> =
                own.values().filter_map(|own| own.get(&at)).map(|values| mean(values)).collect();
            let is_of_people = here > 1 || conditions.iter().any(|c| c.session.is_some());
            if is_of_people && !people.is_empty() {
                line.insert(at, [Some(mean(&people) / shown.factor), None, None]);
            }
        }
        let place = |at: usize| match &doses {
            Some(doses) => doses[at],
            None => at as f64 + dodge(index, number),
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
        let name = second.map(|factor| plain(&format!("{} = {}", factor.id, factor.levels[index])));
        let of = |value: fn(&DosePoint) -> f64| -> Vec<f64> {
            curve.iter().map(|point| value(point) * shown.factor).collect()
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
                    .map(|row| row[0].map_or(f64::NAN, |mean| mean * shown.factor))
                    .collect(),
                false => of(|point| point.mean),
            },
            stroke: Stroke { dash, ..style::mean(colour) },
            ..Line::default()
        }));
        let estimates: Vec<_> = line.into_values().collect();
        let marks = intervals(Direction::Vertical, at, &estimates, shown);
        let marker = style::marker(index);
        means.push(Layer::Intervals(Intervals { colour, marker, name, ..marks }));
    }
    people.into_iter().chain(means).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::verdicts::verdict_rows;
    use zwidth_results::{Cell as Found, Compared, Mean, Role, UnitOfAnalysis, Verdict};
    use zwidth_study::{Better, Study};

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
}
