//! Curves over doses: the mean of everybody's own line, or parabola, from the lowest dose to the highest.

use crate::Parameters;
use crate::cells::Cells;
use crate::measure::Measure;
use crate::split::Split;
use crate::weighed::{Placed, averaged, levels_of, of_people, weighed};
use std::collections::BTreeMap;
use zwidth_results::{DosePoint, UnitOfAnalysis};
use zwidth_stats::curve;
use zwidth_stats::null::Sampling;
use zwidth_stats::student_t::critical_value;
use zwidth_study::{Effect, LevelId, OverDose, Term};

/// Points of a curve.
const POINTS: usize = 61;

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// Everybody's means of all levels of a dose, by participant; of who lacks a level a curve would go beyond what they felt.
fn means_of_levels(
    over: &OverDose,
    cells: &Cells,
    parameters: &Parameters,
) -> BTreeMap<usize, Vec<f64>> {
    let levels: Vec<Vec<Placed>> = levels_of(over, cells, parameters);
    let are_sessions = over.levels.iter().flatten().any(|weight| weight.session.is_some());
    averaged(&of_people(cells, are_sessions), |own| {
        levels.iter().map(|level| weighed(level, own)).collect()
    })
}

/// The sum of a person's means of levels with these weights.
fn at(weights: &[f64], means: &[f64]) -> f64 {
    weights.iter().zip(means).map(|(weight, mean)| weight * mean).sum()
}

/// The curves of a metric over doses, each by group of people where groups are compared; none of one participant.
pub(crate) fn curves(
    cells: &Cells,
    unit: &UnitOfAnalysis,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<DosePoint> {
    if *unit != UnitOfAnalysis::Participants {
        return Vec::new();
    }
    let mut rows = Vec::new();
    for curve in &parameters.dose_curves {
        let people = means_of_levels(&curve.over, cells, parameters);
        let groups: Vec<(Option<&LevelId>, Vec<Vec<f64>>)> = match split {
            None => vec![(None, people.into_values().collect())],
            Some(split) => {
                let ids = split.groups.compared.levels.iter().map(Some);
                ids.zip(split.by_level(people.into_iter())).collect()
            }
        };
        let along = |point| curve.over.along(point as f64 / (POINTS - 1) as f64);
        let doses: Vec<f64> = (0..POINTS).map(along).collect();
        let weights: Vec<Vec<f64>> = doses.iter().map(|dose| curve.over.at(*dose)).collect();
        for (group, people) in groups {
            let curves: Vec<Vec<f64>> = people
                .iter()
                .map(|means| weights.iter().map(|weights| at(weights, means)).collect())
                .collect();
            let tested = curve::differences(&curves, &[POINTS], parameters.level, SAMPLING);
            let pointwise = critical_value(parameters.level, people.len() as f64 - 1.0);
            let (Ok(tested), Ok(pointwise)) = (tested, pointwise) else { continue };
            rows.extend(doses.iter().zip(&tested.nodes).map(|(dose, node)| {
                let band = node.ends.filter(|_| tested.band.is_some());
                DosePoint {
                    metric: measure.parameters.metric.clone(),
                    unit: measure.unit.clone(),
                    environment: curve.environment.clone(),
                    effect: Term(vec![curve.dose.clone()]),
                    factor: curve.within.as_ref().map(|within| within.factor.clone()),
                    level: curve.within.as_ref().map(|within| within.level.clone()),
                    group: group.cloned(),
                    dose: *dose,
                    dose_unit: curve.over.unit.clone(),
                    n: people.len(),
                    mean: node.mean,
                    std_error: node.std_error,
                    ci_low: node.mean - pointwise * node.std_error,
                    ci_high: node.mean + pointwise * node.std_error,
                    band_low: band.map(|ends| ends[0]),
                    band_high: band.map(|ends| ends[1]),
                }
            }));
        }
    }
    rows
}

/// Where the mean parabola turns, in the unit of the dose; only between the lowest and the highest, and if all `n` whose
/// bend was tested have every level.
pub(crate) fn turns_at(
    effect: &Effect,
    n: usize,
    cells: &Cells,
    parameters: &Parameters,
) -> Option<f64> {
    let over = effect.over.as_ref()?;
    let people = means_of_levels(over, cells, parameters);
    if people.len() != n {
        return None;
    }
    let mean = |share: f64| {
        let weights = over.at(over.along(share));
        people.values().map(|means| at(&weights, means)).sum::<f64>() / people.len() as f64
    };
    // Three points of a parabola say where it turns.
    let [low, middle, high] = [mean(0.0), mean(0.5), mean(1.0)];
    let share = 0.5 + 0.25 * (low - high) / (low - 2.0 * middle + high);
    (0.0..=1.0).contains(&share).then(|| over.along(share))
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{near, u};
    use crate::tests::{measured, parameters};
    use crate::{Groups, compare};
    use zwidth_results::{DosePoint, EffectDifference, TrialKey};
    use zwidth_study::{
        DoseScale, Factor, FactorId, FactorOf, GroupsCompared, LevelId, Mode, Source, Term, Trend,
    };

    /// Eight people at four doses, three repeats. R (`lm` of each participant, `t.test`, `anova.mlm`) and SciPy have
    /// these: effect, standard error, t, p; 7 degrees of freedom.
    #[test]
    fn the_slope_and_the_bend_over_a_dose_are_those_of_everybodys_own_line_and_parabola() {
        const DOSES: [f64; 4] = [100.0, 150.0, 250.0, 400.0];
        let mut study = zwidth_testing::study();
        let more = Mode { id: "more".parse().unwrap(), ..study.modes[0].clone() };
        study.modes.push(more);
        let dose: FactorId = "stiffness".parse().unwrap();
        let levels = DOSES.map(|dose| dose.to_string().parse().unwrap()).to_vec();
        for (mode, level) in study.modes.iter_mut().zip(&levels) {
            mode.factors.insert(dose.clone(), LevelId::clone(level));
        }
        study.environments.truncate(1);
        let unit = Some("N/m".to_owned());
        study.factors = vec![Factor { id: dose.clone(), levels, unit, of: FactorOf::Modes }];
        study.compare.effects = vec![Term(vec![dose.clone()])];
        study.compare.trend.insert(dose.clone(), Trend { degree: 2, scale: DoseScale::Linear });
        let (mut keys, mut values) = (Vec::new(), Vec::new());
        for person in 1..=8_u64 {
            for (l, (mode, x)) in (1..).zip(study.modes.iter().zip(DOSES)) {
                for repeat in 1..=3_u64 {
                    let y = 0.5 + 0.004 * x - 0.000_003 * x * x
                        + 0.6 * u([person, 0, 0, 0])
                        + 0.003 * u([person, 7, 0, 0]) * x
                        + 0.3 * u([person, l, 0, 0])
                        + 0.3 * u([person, l, repeat, 0]);
                    keys.push(TrialKey {
                        participant: format!("P{person:02}").parse().unwrap(),
                        session: "S01".parse().unwrap(),
                        trial: (3 * l + repeat) as u32,
                        repeat: repeat as u32,
                        environment: study.environments[0].id.clone(),
                        mode: mode.id.clone(),
                        source: Source::Recorded,
                    });
                    values.push(Some((y * 1000.0).round() / 1000.0));
                }
            }
        }
        let mut parameters = parameters();
        parameters.environments = vec![study.environments[0].id.clone()];
        parameters.modes = study.modes.iter().map(|mode| mode.id.clone()).collect();
        parameters.contrasts = Vec::new();
        let mut found = |degree, scale| {
            study.compare.trend.insert(dose.clone(), Trend { degree, scale });
            parameters.effects = study.effects();
            parameters.dose_curves = study.dose_curves();
            compare(&measured(&keys, values.iter().copied()), &parameters).unwrap()
        };
        let linear = found(2, DoseScale::Linear);
        let [slope, bend] = &linear.effects[..] else { panic!("{:?}", linear.effects) };
        let per = |row: &EffectDifference| row.levels.as_ref().unwrap().to_string();
        assert_eq!([per(slope), per(bend)], ["per 100 N/m", "bend per (100 N/m)²"]);
        near(slope.difference, 0.265515873);
        near(slope.difference_std_error, 0.0291889763);
        near(slope.statistic, 9.09644347);
        near(slope.p_value, 3.97978153e-5);
        near(bend.difference, -0.0291212121);
        near(bend.difference_std_error, 0.0177948185);
        near(bend.p_value, 0.145748125);
        // All levels together, whatever their spacing.
        let [line] = &linear.factor_tests[..] else { panic!("{:?}", linear.factor_tests) };
        near(Some(line.f), 57.8715542);
        near(Some(line.epsilon_gg), 0.606297844);
        near(Some(line.p_gg), 5.58186273e-7);
        // Beyond the parabola one contrast is left: the t of everybody's cubic, squared.
        assert_eq!((line.df_lack_of_fit, line.df_lack_of_fit_error), (Some(1.0), Some(7.0)));
        // NumPy: T² of the quadratic and the cubic over the true spacing.
        let straight = found(1, DoseScale::Linear);
        let [line_alone] = &straight.factor_tests[..] else { panic!() };
        near(line_alone.f_lack_of_fit, 1.25454713);
        near(line_alone.p_lack_of_fit, 0.350593408);
        assert_eq!(
            (line_alone.df_lack_of_fit, line_alone.df_lack_of_fit_error),
            (Some(2.0), Some(6.0))
        );
        // SciPy: everybody's own parabola at 300 N/m, its mean and standard error; the curve has every fifth.
        let at = |dose: f64| linear.trend_curves.iter().find(|p| (p.dose - dose).abs() < 1e-9);
        let point = at(300.0).unwrap();
        near(Some(point.mean), 1.414125);
        near(Some(point.std_error), 0.0866365604);
        near(Some(point.ci_low), 1.20926209);
        near(Some(point.ci_high), 1.61898791);
        assert!(point.band_low.unwrap() < point.ci_low && point.ci_high < point.band_high.unwrap());
        let ends = [&linear.trend_curves[0], linear.trend_curves.last().unwrap()];
        ends.iter().zip([100.0, 400.0]).for_each(|(point, dose)| near(Some(point.dose), dose));
        assert_eq!((linear.trend_curves.len(), bend.turns_at), (61, None), "no bend was found");
        // lme4 1.1-31 and pbkrtest 0.5.2: y ~ x + (1 + x | participant) + (1 | participant:level).
        let [model] = &straight.trend_models[..] else { panic!("{:?}", straight.trend_models) };
        near(model.slope, 0.265515873);
        let [error, df] = [model.slope_std_error, model.df].map(Option::unwrap);
        assert!((error / 0.0291889759 - 1.0).abs() < 1e-5 && (df - 7.0).abs() < 1e-4, "{model:?}");
        let doubled = found(2, DoseScale::Log2);
        assert_eq!(per(&doubled.effects[0]), "per doubling");
        near(doubled.effects[0].difference, 0.403832306);
        near(doubled.effects[0].difference_std_error, 0.0431339221);
        near(doubled.effects[0].difference_ci_low, 0.301836788);
        near(doubled.effects[0].difference_ci_high, 0.505827825);
    }

    /// Six people at doses whose values are a parabola about 2, each with a slope and a bend of their own.
    fn of_doses(
        doses: &[f64],
        trend: Trend,
        lacks: &[(u64, f64)],
        value: fn(f64, f64) -> f64,
    ) -> crate::Comparison {
        let mut study = zwidth_testing::study();
        let mode = study.modes[0].clone();
        let dose: FactorId = "gain".parse().unwrap();
        let levels: Vec<LevelId> =
            doses.iter().map(|dose| dose.to_string().parse().unwrap()).collect();
        study.modes = levels
            .iter()
            .map(|level| Mode {
                id: format!("g{level}").parse().unwrap(),
                factors: [(dose.clone(), level.clone())].into(),
                ..mode.clone()
            })
            .collect();
        study.environments.truncate(1);
        study.factors = vec![Factor {
            id: dose.clone(),
            levels,
            unit: Some("1".to_owned()),
            of: FactorOf::Modes,
        }];
        study.compare.effects = vec![Term(vec![dose.clone()])];
        study.compare.trend.insert(dose, trend);
        let (mut keys, mut values) = (Vec::new(), Vec::new());
        for person in 1..=6_u64 {
            for (trial, (x, mode)) in (1..).zip(doses.iter().zip(&study.modes)) {
                if lacks.contains(&(person, *x)) {
                    continue;
                }
                keys.push(TrialKey {
                    participant: format!("P{person:02}").parse().unwrap(),
                    session: "S01".parse().unwrap(),
                    trial,
                    repeat: 1,
                    environment: study.environments[0].id.clone(),
                    mode: mode.id.clone(),
                    source: Source::Recorded,
                });
                values.push(Some(value(*x, u([person, 0, 0, 0]))));
            }
        }
        let mut parameters = parameters();
        parameters.environments = vec![study.environments[0].id.clone()];
        parameters.modes = study.modes.iter().map(|mode| mode.id.clone()).collect();
        parameters.contrasts = Vec::new();
        parameters.effects = study.effects();
        parameters.dose_curves = study.dose_curves();
        compare(&measured(&keys, values.into_iter()), &parameters).unwrap()
    }

    #[test]
    fn who_lacks_a_dose_has_a_line_over_the_others_if_it_could_leave_something() {
        // Straight lines: whoever has three of the doses has the same slope as with all.
        let value = |x: f64, own: f64| 1.0 + (0.5 + own) * x;
        let line = Trend { degree: 1, scale: DoseScale::Linear };
        let doses = [1.0, 2.0, 4.0, 8.0];
        let whole = of_doses(&doses, line, &[], value);
        let lacking = of_doses(&doses, line, &[(2, 4.0), (3, 1.0)], value);
        let [one, other] = [&whole, &lacking].map(|found| &found.effects[0]);
        near(other.difference, one.difference.unwrap());
        near(other.difference_std_error, one.difference_std_error.unwrap());
        assert_eq!((other.n, one.remark.as_ref()), (6, None));
        let remark = other.remark.as_ref().unwrap().to_string();
        assert_eq!(
            remark,
            "2 participants without every level: their line is over those that they have"
        );
        assert_eq!(lacking.trend_curves[0].n, 4, "beyond what they felt nobody's curve goes");
        // Two levels leave nothing, and without the highest the others lie too near each other.
        for lacks in [&[(2, 4.0), (2, 1.0)][..], &[(2, 8.0)]] {
            let left_out = of_doses(&doses, line, lacks, value);
            assert_eq!((left_out.effects[0].n, left_out.effects[0].remark.as_ref()), (5, None));
        }
        // Where the line bends, a slope over some of the levels is another one.
        let parabola = Trend { degree: 2, scale: DoseScale::Linear };
        let bent =
            of_doses(&[1.0, 2.0, 3.0, 4.0, 5.0], parabola, &[(2, 3.0)], |x, own| x * x + own * x);
        assert_eq!(bent.effects.iter().map(|row| row.n).collect::<Vec<_>>(), [5, 6]);
    }

    #[test]
    fn a_parabola_turns_where_its_bend_is_shown_and_never_beyond_the_doses() {
        let parabola = Trend { degree: 2, scale: DoseScale::Linear };
        let turns = |value| {
            let found = of_doses(&[1.0, 2.0, 3.0, 4.0], parabola, &[], value);
            found.effects[1].turns_at
        };
        near(turns(|x, own| (1.0 + 0.2 * own) * (x - 2.0).powi(2)), 2.0);
        assert_eq!(turns(|x, own| (1.0 + 0.2 * own) * (x - 6.0).powi(2)), None);
        assert_eq!(turns(|x, own| own * (x - 2.0).powi(2)), None, "no bend is shown");
        let doubled = Trend { degree: 2, scale: DoseScale::Log2 };
        let value = |x: f64, own: f64| (1.0 + 0.2 * own) * (x.log2() - 1.5).powi(2);
        let found = of_doses(&[1.0, 2.0, 4.0, 8.0], doubled, &[], value);
        near(found.effects[1].turns_at, 8_f64.sqrt());
    }

    /// Eight people at three doses × motor, of whom the first three are novices.
    fn crossed(terms: &[&str], groups: bool, lacks: &[(u64, &str)]) -> crate::Comparison {
        const DOSES: [u64; 3] = [1, 2, 4];
        let mut study = zwidth_testing::study();
        let mode = study.modes[0].clone();
        let [gain, motor]: [FactorId; 2] = ["gain", "motor"].map(|id| id.parse().unwrap());
        let level = |text: &str| -> LevelId { text.parse().unwrap() };
        let numbers: Vec<LevelId> = DOSES.iter().map(|dose| level(&dose.to_string())).collect();
        study.modes.clear();
        for (number, dose) in numbers.iter().zip(DOSES) {
            for with in ["no", "yes"] {
                study.modes.push(Mode {
                    id: format!("{with}{dose}").parse().unwrap(),
                    factors: [(gain.clone(), number.clone()), (motor.clone(), level(with))].into(),
                    ..mode.clone()
                });
            }
        }
        study.environments.truncate(1);
        let of = FactorOf::Modes;
        study.factors = vec![
            Factor { id: motor, levels: vec![level("no"), level("yes")], unit: None, of },
            Factor { id: gain, levels: numbers, unit: Some("1".to_owned()), of },
        ];
        study.compare.effects = terms.iter().map(|term| term.parse().unwrap()).collect();
        let (mut keys, mut values) = (Vec::new(), Vec::new());
        for person in 1..=8_u64 {
            for (trial, mode) in (1..).zip(&study.modes) {
                let (with, dose) = mode.id.as_str().split_at(mode.id.as_str().len() - 1);
                if lacks.contains(&(person, mode.id.as_str())) {
                    continue;
                }
                let (x, with) = (dose.parse::<u64>().unwrap(), u64::from(with == "yes"));
                keys.push(TrialKey {
                    participant: format!("P{person:02}").parse().unwrap(),
                    session: "S01".parse().unwrap(),
                    trial,
                    repeat: 1,
                    environment: study.environments[0].id.clone(),
                    mode: mode.id.clone(),
                    source: Source::Recorded,
                });
                let slope = 0.5 + 0.3 * with as f64 + 0.2 * u([person, with, 0, 0]);
                values.push(Some(slope * x as f64 + u([person, with, x, 1])));
            }
        }
        let mut parameters = parameters();
        parameters.environments = vec![study.environments[0].id.clone()];
        parameters.modes = study.modes.iter().map(|mode| mode.id.clone()).collect();
        parameters.contrasts = Vec::new();
        parameters.effects = study.effects();
        parameters.dose_curves = study.dose_curves();
        parameters.groups = groups.then(|| Groups {
            compared: GroupsCompared {
                column: "group".parse().unwrap(),
                levels: vec![level("novice"), level("expert")],
                assigned: false,
                contrasts: Vec::new(),
            },
            levels_of: (1..=8_usize)
                .map(|person| (format!("P{person:02}").parse().unwrap(), usize::from(person > 3)))
                .collect(),
            blocks: [].into(),
        });
        compare(&measured(&keys, values.into_iter()), &parameters).unwrap()
    }

    /// The first and the last point of each curve, with its level and its group.
    fn ends(found: &crate::Comparison) -> Vec<(String, [&DosePoint; 2])> {
        let curves = found.trend_curves.chunks(super::POINTS).map(|curve| {
            let [first, last] = [&curve[0], &curve[curve.len() - 1]];
            let name = [first.level.as_ref(), first.group.as_ref()];
            assert!(curve.iter().all(|point| [point.level.as_ref(), point.group.as_ref()] == name));
            let name: Vec<String> = name.into_iter().flatten().map(ToString::to_string).collect();
            (name.join(" "), [first, last])
        });
        curves.collect()
    }

    #[test]
    fn the_slopes_of_curves_are_those_of_the_effect_and_of_the_interaction() {
        let found = crossed(&["gain", "motor:gain"], false, &[]);
        let [slope, interaction] = &found.effects[..] else { panic!("{:?}", found.effects) };
        let curves = ends(&found);
        let names: Vec<&str> = curves.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["", "no", "yes"]);
        // From the dose 1 to the dose 4.
        let rise = |curve: usize| {
            let [first, last] = curves[curve].1;
            Some((last.mean - first.mean) / 3.0)
        };
        near(rise(0), slope.difference.unwrap());
        near(rise(2).zip(rise(1)).map(|(yes, no)| yes - no), interaction.difference.unwrap());
        // R's `lm` of everybody's means of the levels, and `predict` at both ends: mean and standard error.
        const MEANS: [[[f64; 2]; 2]; 3] = [
            [[0.645073254, 0.0647556376], [2.50376336, 0.0985863792]],
            [[0.520759265, 0.0983521139], [1.95251699, 0.126049061]],
            [[0.769387242, 0.114146363], [3.05500974, 0.128309578]],
        ];
        for (curve, [low, high]) in MEANS.into_iter().enumerate() {
            let [first, last] = curves[curve].1;
            near(Some(first.mean), low[0]);
            near(Some(first.std_error), low[1]);
            near(Some(last.mean), high[0]);
            near(Some(last.std_error), high[1]);
        }
        // Without the interaction no curve of a level is asked for; without the slope none of the mean.
        let of = |terms| ends(&crossed(terms, false, &[])).len();
        assert_eq!([of(&["gain", "motor"]), of(&["gain:motor"]), of(&["motor"])], [1, 2, 0]);
    }

    #[test]
    fn who_lacks_a_dose_at_one_level_is_in_the_curve_of_the_other_level_alone() {
        let found = crossed(&["gain", "gain:motor"], false, &[(2, "yes4")]);
        let numbers: Vec<usize> = ends(&found).iter().map(|(_, [first, _])| first.n).collect();
        assert_eq!(numbers, [7, 8, 7]);
    }

    #[test]
    fn of_groups_each_has_its_curves_and_one_of_few_people_no_band() {
        let found = crossed(&["gain", "gain:motor"], true, &[]);
        let curves = ends(&found);
        let names: Vec<&str> = curves.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            ["novice", "expert", "no novice", "no expert", "yes novice", "yes expert"]
        );
        // An effect has the same weight for each group.
        let rise = |curve: usize| (curves[curve].1[1].mean - curves[curve].1[0].mean) / 3.0;
        near(found.effects[0].difference, (rise(0) + rise(1)) / 2.0);
        assert_eq!([curves[0].1[0].n, curves[1].1[0].n], [3, 5]);
        assert!(curves.iter().all(|(_, [first, _])| first.band_low.is_none()));
    }
}
