//! Whole curves of one participant's trials, by the orders in which the modes could have come.

use crate::claim::Claim;
use crate::curves::{CurveParameters, Row, SessionCurve, Shared, Test, mean};
use crate::orders::{Design, Joined, NoTest, Place, Redrawn, SAMPLING, redrawn};
use std::collections::BTreeMap;
use zwidth_results::GroupEffect;
use zwidth_stats::curve::{self, TrialCurves};
use zwidth_stats::null::Sampling;
use zwidth_study::{SessionId, counted};

/// Each contrast in each environment: whether no trial's curve depended on mode. As of single values (`crate::orders`)
/// a trial without a curve is left out of every order alike.
pub(crate) fn rows(own: &[&SessionCurve], parameters: &CurveParameters) -> Vec<Row> {
    let CurveParameters { environments, modes, contrasts, orders, .. } = parameters;
    let design = Design { environments, modes, orders };
    let mode_of = |curve: &SessionCurve| modes.iter().position(|mode| *mode == curve.mode);
    let mut rows = Vec::new();
    for (family, environment) in environments.iter().enumerate() {
        let here = || own.iter().copied().filter(|one| one.environment == *environment);
        let with: Vec<&SessionCurve> = here().filter(|one| !one.branches.is_empty()).collect();
        let Some(first) = here().next() else { continue };
        let shared = Shared::of(&with, parameters.nodes, "every trial");
        let lengths = shared.lengths();
        let nodes = lengths.iter().sum();
        let mut sessions: BTreeMap<&SessionId, Vec<Place<Vec<f64>>>> = BTreeMap::new();
        for one in here() {
            let (Some(mode), Some(number)) = (mode_of(one), one.trial) else { continue };
            let value = (!one.branches.is_empty()).then(|| shared.values(one).collect());
            sessions.entry(&one.session).or_default().push(Place { number, mode, value });
        }
        let drawn: Result<Vec<Redrawn<Vec<f64>>>, NoTest> = sessions
            .iter()
            .map(|(session, places)| redrawn(family, (&first.participant, session), places, design))
            .collect();
        let joined = drawn.as_ref().map(|sessions| Joined::of(sessions));
        // Without other orders the trials are described as they are.
        let (values, session, actual) = match &joined {
            Ok(joined) => (joined.values.clone(), joined.session.clone(), joined.actual.clone()),
            Err(_) => {
                let trials = sessions.values().enumerate().flat_map(|(session, places)| {
                    let with =
                        places.iter().filter_map(|place| Some((place, place.value.clone()?)));
                    with.map(move |(place, value)| (value, (session, place.mode)))
                });
                let (values, (session, actual)): (Vec<_>, (Vec<_>, Vec<_>)) = trials.unzip();
                (values, session, actual)
            }
        };
        // No trial has a mode that the study lacks.
        let place = |id| modes.iter().position(|mode| mode == id).unwrap_or(usize::MAX);
        let pairs: Vec<[usize; 2]> =
            contrasts.iter().map(|own| [place(&own.mode), place(&own.against)]).collect();
        let trials =
            TrialCurves { curves: &values, lengths: &lengths, modes: &actual, sessions: &session };
        let sampling = if joined.is_ok() { SAMPLING } else { Sampling { draws: 0, ..SAMPLING } };
        let tests = curve::trials(trials, &pairs, parameters.level, sampling, |seed| {
            let Ok(joined) = &joined else { return Vec::new() };
            let order = joined.redraw(seed);
            joined.places.iter().filter_map(|place| order.get(*place).copied()).collect()
        });
        let tests = tests.unwrap_or_else(|why| vec![Err(why); pairs.len()]);
        for ((contrast, pair), tested) in contrasts.iter().zip(pairs).zip(tests) {
            // The mean over the sessions that have both modes, as of single values.
            let strata = trials.strata(pair);
            let side = |side: usize| {
                let of_session = |sides: &[Vec<usize>; 2]| {
                    mean(
                        &sides[side].iter().map(|trial| &values[*trial]).collect::<Vec<_>>(),
                        nodes,
                    )
                };
                let each = strata.iter().map(of_session).collect::<Vec<_>>();
                mean(&each.iter().collect::<Vec<_>>(), nodes)
            };
            let tested = tested.map_err(|why| why.to_string());
            let mut remarks = shared.left_out.clone();
            let without = here().count() - with.len();
            if without > 0 {
                remarks.push(format!("{} without a curve", counted(without, "trials")));
            }
            remarks.extend(joined.as_ref().err().map(|why| (*why).to_string()));
            let tested = tested.map(|test| match &joined {
                Ok(_) => Test::Arranged(test),
                Err(_) => Test::Described(test),
            });
            let p = match &tested {
                Ok(Test::Arranged(test)) => Some(test.permuted),
                _ => None,
            };
            rows.push(Row {
                effect: GroupEffect::Of(contrast.clone()),
                environment: Some(environment.clone()),
                groups: None,
                within: Some(first.participant.clone()),
                n: strata.iter().flatten().map(Vec::len).sum(),
                n_second: None,
                places: shared.nodes().collect(),
                means: [side(0), side(1)],
                tested,
                remarks,
                claim: Claim::new(family, p.map(|p| p.p_value), p.map(|p| p.smallest_p), None),
            });
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare_curves;
    use crate::curves::{Course, Curves, tests::parameters};
    use crate::orders::tests::Demo;
    use zwidth_results::{LoopBranch, Verdict};
    use zwidth_study::{Curve, OrderScheme};

    /// The curves of a study of single values: a trial's value is the height of its middle.
    fn compared(demo: &Demo) -> Curves {
        let trials = demo.keys().into_iter().zip(&demo.trials).map(|(key, trial)| {
            let x: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0).collect();
            let y = |value: f64| x.iter().map(move |x| 5.0 * x + value * (3.0 * x).sin()).collect();
            let course = trial.value.map(|value| Course { x: x.clone(), y: y(value) });
            SessionCurve {
                curve: Curve::ForceOverAngle,
                participant: key.participant,
                session: key.session,
                environment: key.environment,
                mode: key.mode,
                trial: Some(key.trial),
                branches: course.map(|course| (Some(LoopBranch::In), course)).into_iter().collect(),
            }
        });
        let own = &demo.parameters;
        let parameters = CurveParameters {
            environments: own.environments.clone(),
            modes: own.modes.clone(),
            contrasts: own.contrasts.clone(),
            orders: own.orders.clone(),
            ..parameters()
        };
        compare_curves(&trials.collect::<Vec<_>>(), &parameters).unwrap()
    }

    /// As of single values: two of a block's 720 orders separate two modes as well as the actual one.
    #[test]
    fn a_strong_effect_reaches_the_smallest_p_of_the_design() {
        let found = compared(&Demo::of(OrderScheme::Williams, 1, 100.0));
        assert_eq!(found.tests.len(), 4, "two contrasts in two environments");
        for test in &found.tests {
            assert_eq!((test.n, test.left_out, test.verdict), (12, 1, Some(Verdict::Different)));
            assert_eq!(test.within.as_ref().unwrap().as_str(), "P01");
            let p = test.p_value.unwrap();
            // Three deviations of a count of 9,999 draws.
            let near = |share: f64| 3.0 * (share / 9999.0_f64).sqrt() + 1e-4;
            let smallest = test.smallest_p.unwrap();
            assert!(
                (smallest - 2.0 / 720.0).abs() < near(2.0 / 720.0) && smallest <= p,
                "{smallest}"
            );
            // Orders that part other two modes as well can have a larger t than two neighbours.
            let most = match test.effect.to_string().as_str() {
                "hybrid − active" => 2.0 / 720.0,
                _ => 6.0 / 720.0,
            };
            assert!(p < most + near(most), "{} {p}", test.effect);
        }
        let node = &found.points[5];
        assert!((node.mean_first - node.mean_second - node.difference).abs() < 1e-9);
        assert!(node.band_low < Some(node.difference) && found.runs.is_empty());
    }

    /// 150 sessions in which no trial depends on its mode: p < 0.1 has a probability of about 0.1; the count lies where
    /// the 99.9 % interval of Clopper and Pearson contains it.
    #[test]
    fn a_session_without_an_effect_is_found_different_no_more_often_than_promised() {
        let p = |seed| {
            let demo = Demo::new(OrderScheme::Constrained, 2, 1, seed, 0.0);
            compared(&demo).tests[0].p_value.unwrap()
        };
        let below = (0..150).map(p).filter(|p| *p < 0.1).count();
        assert!((4..=29).contains(&below), "{below} of 150 below 0.1");
    }

    #[test]
    fn a_trial_without_a_curve_is_left_out_and_an_order_that_nobody_drew_gives_no_p() {
        let mut demo = Demo::of(OrderScheme::Williams, 1, 100.0);
        demo.trials[0].value = None;
        let environment = demo.keys()[0].environment.clone();
        let found = compared(&demo);
        let here = found.tests.iter().find(|test| test.environment.as_ref() == Some(&environment));
        assert_eq!(here.unwrap().remark.as_ref().unwrap().to_string(), "1 trial without a curve");
        demo.parameters.orders[0].drawn = None;
        let found = compared(&demo);
        let test = &found.tests[0];
        assert_eq!((test.p_value, test.verdict), (None, Some(Verdict::NotTested)));
        let remark = test.remark.as_ref().unwrap().to_string();
        assert!(remark.ends_with("the order of P01 S01 was not drawn by this program"), "{remark}");
        assert_eq!(found.points.len(), 4 * 11, "what was measured is described all the same");
    }
}
