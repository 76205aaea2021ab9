//! Whether recordings confirm a choice: a model is fitted to some repeats and predicts the others.

use crate::model::{Loop, model};
use crate::ranges::Point;
use crate::run::{Course, Frame, run};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use zwidth_dynamics::{DynamicsError, ModelScene};
use zwidth_numerics::series::interpolate;
use zwidth_results::{LadderTerm, TermSet, TriedModel};

/// A recorded trial: its scene with the recorded force as input, and the angle that was seen.
#[derive(Debug, Clone)]
pub struct Recorded {
    /// The scene.
    pub scene: ModelScene,
    /// Times, s, from 0 on.
    pub t_s: Vec<f64>,
    /// θ, rad.
    pub theta_rad: Vec<f64>,
}

/// The numbers that a fit may change, each as a factor of the twin's default or, if it has none, of
/// the middle of the range: inertia, friction at rest and in motion, viscous friction, both lags of
/// the brake, the weight of the lever.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Knobs {
    /// Factor of the moment of inertia.
    pub inertia: f64,
    /// Factor of dry friction.
    pub dry: f64,
    /// Factor of viscous friction.
    pub viscous: f64,
    /// Factor of the brake's lags.
    pub brake_lag: f64,
    /// Factor of the lever's weight.
    pub weight: f64,
}

/// Number of factors.
const KNOBS: usize = 5;

impl Knobs {
    /// The twin's defaults.
    pub const USUAL: Self =
        Self { inertia: 1.0, dry: 1.0, viscous: 1.0, brake_lag: 1.0, weight: 1.0 };

    fn of([inertia, dry, viscous, brake_lag, weight]: [f64; KNOBS]) -> Self {
        Self { inertia, dry, viscous, brake_lag, weight }
    }

    /// The numbers with these factors.
    fn point(self) -> Point {
        let mut point = Point::usual();
        let twin = &mut point.twin;
        twin.rotor_kg_m2 *= self.inertia;
        twin.lever_kg_m2 *= self.inertia;
        twin.brake_kg_m2 *= self.inertia;
        twin.friction_static_n *= self.dry;
        twin.friction_viscous_ns_per_rad *= self.viscous;
        twin.brake_on_s *= self.brake_lag;
        twin.brake_off_s *= self.brake_lag;
        point.weight_kg *= self.weight;
        point
    }
}

/// A model's course of a scene with given numbers, at the recording's times up to where the loop's
/// whole periods end.
///
/// # Errors
/// A model that does not run.
pub fn predict(
    scene: &ModelScene,
    set: TermSet,
    looped: &Loop,
    knobs: Knobs,
) -> Result<Course, DynamicsError> {
    let model = model(scene, set, &knobs.point(), looped.period_s);
    let frame = Frame::of(scene.duration_s, looped.period_s);
    run(&model, looped, &frame).map(|(course, _)| course)
}

/// Root mean square error of θ over some trials, rad; infinite where a model does not run.
pub fn rmse_rad(trials: &[&Recorded], set: TermSet, looped: &Loop, knobs: Knobs) -> f64 {
    let squares: Vec<(f64, usize)> = trials
        .par_iter()
        .map(|trial| {
            let Ok(course) = predict(&trial.scene, set, looped, knobs) else {
                return (f64::INFINITY, 1);
            };
            let seen = course.t_s.iter().map(|t| interpolate(&trial.t_s, &trial.theta_rad, *t));
            let errors = course.theta_rad.iter().zip(seen).filter_map(|(a, b)| Some(a - b?));
            errors.fold((0.0, 0), |(sum, n), off| (sum + off * off, n + 1))
        })
        .collect();
    // In the order of the trials: rayon's own sum would depend on the number of threads.
    let (sum, n) = squares.iter().fold((0.0, 0), |(sum, n), (s, m)| (sum + s, n + m));
    if n > 0 { (sum / n as f64).sqrt() } else { f64::INFINITY }
}

/// The numbers that fit trials best, within an eighth and eight times the twin's: a pattern search
/// along each number's logarithm (R. Hooke & T. A. Jeeves, J. ACM 8 (1961) 212–229). What the
/// model has no term for stays.
pub fn fit(trials: &[&Recorded], set: TermSet, looped: &Loop) -> Knobs {
    /// First and last step, powers of two.
    const STEPS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];
    /// Largest power of two to either side: an eighth, and eight times.
    const MOST: f64 = 3.0;
    let friction = set.has(LadderTerm::Friction);
    let is_used =
        [true, friction, friction, set.has(LadderTerm::BrakeLag), set.has(LadderTerm::Gravity)];
    let cost = |x: &[f64; KNOBS]| rmse_rad(trials, set, looped, Knobs::of(x.map(libm::exp2)));
    let mut best = [0.0; KNOBS];
    let mut least = cost(&best);
    for step in STEPS {
        // A pass that finds nothing better ends a step; ten are more than a valley needs.
        for _ in 0..10 {
            let before = least;
            for i in (0..KNOBS).filter(|i| is_used[*i]) {
                for way in [step, -step] {
                    let mut next = best;
                    next[i] = (next[i] + way).clamp(-MOST, MOST);
                    let next_cost = cost(&next);
                    if next_cost < least {
                        (best, least) = (next, next_cost);
                        break;
                    }
                }
            }
            if least >= before {
                break;
            }
        }
    }
    Knobs::of(best.map(libm::exp2))
}

/// A model fitted to some trials and judged on others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOut {
    /// Its terms.
    pub set: TermSet,
    /// The fitted factors.
    pub knobs: Knobs,
    /// Error on the trials it was fitted to, rad.
    pub fitted_rad: f64,
    /// Error on the others, rad.
    pub held_out_rad: f64,
}

/// Fits a model to every second trial, from the first on, and judges it on the others, where
/// the error of none is infinite; `None` without trials.
pub fn held_out(trials: &[Recorded], set: TermSet, looped: &Loop) -> Option<HeldOut> {
    let [own, others] =
        [0, 1].map(|first| trials.iter().skip(first).step_by(2).collect::<Vec<_>>());
    if own.is_empty() {
        return None;
    }
    let knobs = fit(&own, set, looped);
    Some(HeldOut {
        set,
        knobs,
        fitted_rad: rmse_rad(&own, set, looped, knobs),
        held_out_rad: rmse_rad(&others, set, looped, knobs),
    })
}

/// A model that was compared with recordings, and its relation to the choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    /// Its relation to the choice.
    pub role: TriedModel,
    /// How well it predicts.
    pub held_out: HeldOut,
}

/// The choice, the choice without each of its terms in turn, and the fullest model, each fitted
/// again and judged on the other trials; none without trials.
pub fn tried(trials: &[Recorded], choice: TermSet, fullest: TermSet, looped: &Loop) -> Vec<Tried> {
    let mut sets = vec![(TriedModel::Choice, choice)];
    sets.extend(choice.terms().map(|term| (TriedModel::Without(term), choice.without(term))));
    sets.push((TriedModel::Fullest, fullest));
    sets.par_iter()
        .filter_map(|(role, set)| {
            Some(Tried { role: *role, held_out: held_out(trials, *set, looped)? })
        })
        .collect()
}

/// The numbers of a fitted model as a replay's table has them; what it has no term for is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    /// Mass at the lever's end, kg, with the twin's lever.
    pub mass_kg: f64,
    /// Viscous friction there, N s/rad.
    pub viscous_ns_per_rad: f64,
    /// Dry friction there in motion, N.
    pub dry_n: f64,
    /// The motor's lag, s.
    pub motor_lag_s: f64,
    /// The brake's lags, s.
    pub brake_lag_s: [f64; 2],
}

/// The plant for fitted factors.
pub fn plant(set: TermSet, knobs: Knobs) -> Plant {
    let twin = knobs.point().twin;
    let driven = twin.plant(None);
    let friction = driven.friction.filter(|_| set.has(LadderTerm::Friction));
    // The family's friction includes what the closed winding damps (`model::friction`).
    let winding = driven.back_emf_ns_per_rad.unwrap_or(0.0);
    Plant {
        mass_kg: driven.inertia_kg_m2 / (driven.lever_m * driven.lever_m),
        viscous_ns_per_rad: friction.map_or(0.0, |f| f.viscous_ns_per_rad + winding),
        dry_n: friction.map_or(0.0, |f| f.kinetic_n),
        motor_lag_s: driven
            .motor_lag_s
            .filter(|_| set.has(LadderTerm::MotorLag))
            .unwrap_or_default(),
        brake_lag_s: driven
            .brake_lag_on_off_s
            .filter(|_| set.has(LadderTerm::BrakeLag))
            .unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_device::Velocity;
    use zwidth_dynamics::{DriveMode, Input, table3};
    use zwidth_study::VelocityFilter;

    const FRICTION: TermSet = TermSet::NONE.with(LadderTerm::Friction);

    fn looped() -> Loop {
        let velocity = Velocity::new(VelocityFilter::Difference).unwrap();
        Loop { period_s: 0.0083, velocity }
    }

    /// What a lever of known numbers does under pushes of different sizes.
    fn trials(knobs: Knobs) -> Vec<Recorded> {
        let one = |magnitude: f64| {
            let mut scene = table3::scene(DriveMode::Active, Input::sine(magnitude));
            scene.plant.mass_kg = 0.0973;
            scene.plant.lever_m = 0.045;
            let course = predict(&scene, FRICTION, &looped(), knobs).unwrap();
            Recorded { scene, t_s: course.t_s, theta_rad: course.theta_rad }
        };
        [0.8, 1.0, 1.2, 1.4].map(one).to_vec()
    }

    #[test]
    fn a_fit_finds_the_friction_that_made_the_recordings_and_predicts_the_others() {
        let truth = Knobs { dry: 2.0, ..Knobs::USUAL };
        let found = held_out(&trials(truth), FRICTION, &looped()).unwrap();
        assert!((found.knobs.dry - 2.0).abs() < 0.15, "{:?}", found.knobs);
        assert!(found.held_out_rad < 2e-3, "{}", found.held_out_rad);
    }

    #[test]
    fn a_model_that_lacks_the_term_predicts_worse_than_one_that_has_it() {
        let trials = trials(Knobs { dry: 2.0, ..Knobs::USUAL });
        let [with, without] =
            [FRICTION, TermSet::NONE].map(|set| held_out(&trials, set, &looped()).unwrap());
        assert!(without.held_out_rad > 5.0 * with.held_out_rad);
        assert!((without.knobs.dry - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_weight_that_the_recordings_do_not_have_is_fitted_away_and_not_missed() {
        let choice = FRICTION.with(LadderTerm::Gravity);
        let rows = tried(&trials(Knobs::USUAL), choice, choice, &looped());
        let roles: Vec<String> = rows.iter().map(|row| row.role.to_string()).collect();
        assert_eq!(roles, ["choice", "without gravity", "without friction", "fullest"]);
        let rmse = |i: usize| rows[i].held_out.held_out_rad;
        assert!(rows[0].held_out.knobs.weight < 0.13, "{:?}", rows[0].held_out.knobs);
        assert!(rmse(1) < rmse(0) && rmse(2) > 5.0 * rmse(0), "{rows:?}");
    }

    #[test]
    fn one_trial_leaves_nothing_to_predict_and_none_nothing_to_fit() {
        let found = held_out(&trials(Knobs::USUAL)[..1], FRICTION, &looped()).unwrap();
        assert!(found.held_out_rad.is_infinite() && found.fitted_rad < 1e-9);
        assert_eq!(held_out(&[], FRICTION, &looped()), None);
    }
}
