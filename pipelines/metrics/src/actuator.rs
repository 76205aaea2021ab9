//! The actuators' force discrepancy: the user's without the share of the plant (thesis, appendix
//! B).

use crate::branch::Branches;
use crate::energy::HALF_S;
use crate::gap::Gap;
use crate::signals::Signals;
use crate::{MetricsError, Plant};
use zwidth_numerics::local::Derivator;
use zwidth_stats::interval::{Estimate, t_interval};
use zwidth_study::Analysis;

/// The actuators' force discrepancy (thesis, appendix B, Fig. 31): by how much the force of motor
/// and brake in compression exceeds that in decompression, at the same angle,
///
/// D_A(θ) = D(θ) − M L (θ̈_c − θ̈_d) − B (θ̇_c − θ̇_d) − 2 F_C,
///
/// D the user's ([`Discrepancy`](crate::Discrepancy)), M, B and F_C as identified
/// ([`Plant`]), θ̇ and θ̈ of both branches those of parabolas through 25 ms of angles to either
/// side. 0 for a spring that one actuator renders both ways, K (θ − θ_rest) − F_m past the
/// weaker one's limit F_m for two.
///
/// **The angle** is that at which the force was commanded: a command is held from sample to sample,
/// so that each angle has the mean over the time to the next one. At the angle of the same instant
/// a motor on a spring K would differ by K θ̇ times the time between two samples, because it is
/// late.
///
/// **Intervals**: Newey–West over the angles as for the user's, and the plant's own covariance gᵀ V
/// g besides, g the slope of D_A by M, B and F_C; Student's t with the degrees of freedom of that
/// sum (Welch & Satterthwaite). Static friction and what a lever at rest is held by are not in it:
/// the branches are made of samples that lie farther along than any before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ActuatorDiscrepancy {
    /// Mean of D_A over the angle, ∫ D_A dθ / Δθ, N.
    pub mean_n: Option<f64>,
    /// Lower end of its interval, N.
    pub mean_ci_low_n: Option<f64>,
    /// Upper end of its interval, N.
    pub mean_ci_high_n: Option<f64>,
    /// Largest D_A, N.
    pub max_n: Option<f64>,
    /// D_A at the reversal, N: the line through it over the last tenth of the common angles.
    pub step_n: Option<f64>,
    /// Lower end of its interval, N.
    pub step_ci_low_n: Option<f64>,
    /// Upper end of its interval, N.
    pub step_ci_high_n: Option<f64>,
}

pub(crate) fn actuator_discrepancy(
    signals: &Signals,
    plant: &Plant,
    analysis: &Analysis,
) -> Result<ActuatorDiscrepancy, MetricsError> {
    let Some(((theta, force, phases), lever_m)) = signals.force_over_angle().zip(signals.lever_m)
    else {
        return Ok(ActuatorDiscrepancy::default());
    };
    let Some(branches) = Branches::of(&theta, phases, analysis.grid_points) else {
        return Ok(ActuatorDiscrepancy::default());
    };
    let [user] = branches.gaps(|i| while_held(|i| [force[i]], i, theta.len()));
    // No more than three columns at a time (`signals`).
    drop(force);
    let t = signals.t()?;
    let mut motion = Derivator::new(&t, &theta, HALF_S);
    let [slower, later] =
        branches.gaps(|i| while_held(|i| <[f64; 2]>::from(motion.at(i)), i, theta.len()));
    let inertia = plant.mass_kg * lever_m;
    let damping = plant.damping_ns_per_rad;
    let d = (0..user.len()).map(|i| {
        // Twice the friction: it is with the motion on one way and against it on the other.
        let of_plant = inertia * later[i] + damping * slower[i] + 2.0 * plant.friction_n;
        user[i] - of_plant
    });
    let d: Vec<f64> = d.collect();
    let [gap, slower, later] =
        [d, slower, later].map(|d| Gap::new(branches.grid.clone(), d, theta[phases.reversal]));
    let level = analysis.confidence;
    let mean = gap.mean()?;
    let felt = [lever_m * later.mean()?, slower.mean()?, 2.0];
    let mean_interval = carried(mean, gap.line_in_the_middle(level)?, felt, plant, level)?;
    let step = gap.step(level)?;
    let turning = later.step(level)?.zip(slower.step(level)?);
    let felt = turning.map(|(later, slower)| [lever_m * later.estimate, slower.estimate, 2.0]);
    let step = match step.zip(felt) {
        Some((step, felt)) => carried(step.estimate, Some(step), felt, plant, level)?,
        None => None,
    };
    Ok(ActuatorDiscrepancy {
        mean_n: Some(mean),
        mean_ci_low_n: mean_interval.map(|e| e.ci_low),
        mean_ci_high_n: mean_interval.map(|e| e.ci_high),
        max_n: gap.largest(),
        step_n: step.map(|e| e.estimate),
        step_ci_low_n: step.map(|e| e.ci_low),
        step_ci_high_n: step.map(|e| e.ci_high),
    })
}

/// A sample's mean over the time to the next, in which its command is held; of the last one its
/// own value.
fn while_held<const N: usize>(
    mut y: impl FnMut(usize) -> [f64; N],
    i: usize,
    samples: usize,
) -> [f64; N] {
    let now = y(i);
    let next = y((i + 1).min(samples - 1));
    std::array::from_fn(|j| (now[j] + next[j]) / 2.0)
}

/// The interval of `centre` by the scatter of its line and by the uncertainty of the plant; `felt`
/// is the slope of `centre` by the plant's parameters.
fn carried(
    centre: f64,
    line: Option<Estimate>,
    felt: [f64; 3],
    plant: &Plant,
    level: f64,
) -> Result<Option<Estimate>, MetricsError> {
    let Some(line) = line else { return Ok(None) };
    let of_plant = (0..3).map(|j| {
        let row = (0..3).map(|k| plant.covariance[j][k] * felt[k]).sum::<f64>();
        felt[j] * row
    });
    // A covariance that rounding has made indefinite must not shrink the interval.
    let of_plant = of_plant.sum::<f64>().max(0.0);
    let of_line = line.std_error * line.std_error;
    let variance = of_line + of_plant;
    if variance <= 0.0 {
        return Ok(Some(t_interval(centre, 0.0, line.df, level)?));
    }
    // Welch–Satterthwaite.
    let shares = of_line * of_line / line.df + of_plant * of_plant / plant.df;
    Ok(Some(t_interval(centre, variance.sqrt(), variance * variance / shares, level)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{LEVER_M, RATE_HZ, REST_RAD, check, in_spring, stroke, trial};
    use crate::{Parameters, plant_metrics, trial_metrics};
    use core::f64::consts::TAU;
    use zwidth_store::Trial;

    /// K = 4 N/rad from rest at −45°.
    const K: f64 = 4.0;
    const PERIOD_S: f64 = 2.0;

    fn plant(std_errors: [f64; 3]) -> Plant {
        let mut covariance = [[0.0; 3]; 3];
        (0..3).for_each(|j| covariance[j][j] = std_errors[j] * std_errors[j]);
        Plant { mass_kg: 0.4, damping_ns_per_rad: 0.15, friction_n: 0.2, covariance, df: 12.0 }
    }

    /// What a user of that plant feels over a raised cosine, whose θ̈ is −ω² (θ − its middle), with
    /// actuators that give no more than `strong` on the way in and `weak` on the way back, and
    /// whose commands are held from sample to sample: on average half of that time late.
    fn felt(stroke_rad: f64, strong_n: f64, weak_n: f64) -> Trial {
        let (omega, plant) = (TAU / PERIOD_S, plant([0.0; 3]));
        let force = move |theta: f64, velocity: f64| {
            let limit_n = if velocity > 0.0 { strong_n } else { weak_n };
            let bend = -omega * omega * (theta - REST_RAD - stroke_rad / 2.0);
            let commanded_at = theta - velocity / RATE_HZ / 2.0;
            (K * (commanded_at - REST_RAD)).min(limit_n)
                + plant.mass_kg * LEVER_M * bend
                + plant.damping_ns_per_rad * velocity
                + plant.friction_n * velocity.signum()
        };
        trial(&stroke(stroke_rad, PERIOD_S), force)
    }

    fn found(trial: &Trial, plant: &Plant) -> ActuatorDiscrepancy {
        plant_metrics(trial, &in_spring(K, REST_RAD), Some(plant)).unwrap().discrepancy
    }

    /// Appendix B: half a bow tie, (K X − F_m)² / 2 K X in the mean and K X − F_m at the reversal.
    #[test]
    fn two_actuators_differ_as_appendix_b_has_it_whatever_the_plant() {
        let stroke_rad = 77_f64.to_radians();
        let most = K * stroke_rad - 2.08;
        let trial = felt(stroke_rad, 13.0, 2.08);
        let found = found(&trial, &plant([0.01, 0.005, 0.01]));
        let mean = most * most / (2.0 * K * stroke_rad);
        check(found.mean_n, mean, 6e-3);
        check(found.step_n, most, 2e-3);
        check(found.max_n, most, 2e-3);
        assert!(found.mean_ci_low_n.unwrap() < mean && mean < found.mean_ci_high_n.unwrap());
        assert!(found.step_ci_low_n.unwrap() < most && most < found.step_ci_high_n.unwrap());
        let user = trial_metrics(&trial, &in_spring(K, REST_RAD)).unwrap().discrepancy;
        assert!(user.mean_n.unwrap() - mean > 0.5, "{user:?}");
    }

    #[test]
    fn one_actuator_differs_by_nothing_where_the_user_feels_the_plant() {
        for limit_n in [100.0, 4.16] {
            let trial = felt(1.3, limit_n, limit_n);
            let found = found(&trial, &plant([0.01, 0.005, 0.01]));
            check(found.mean_n, 0.0, 1e-3);
            check(found.step_n, 0.0, 2e-3);
            assert!(found.mean_ci_low_n.unwrap() < 0.0 && 0.0 < found.mean_ci_high_n.unwrap());
            let user = trial_metrics(&trial, &in_spring(K, REST_RAD)).unwrap().discrepancy;
            assert!(user.mean_ci_low_n.unwrap() > 0.2, "{user:?}");
        }
    }

    /// Friction of which no more is known than ±0.05 N leaves ±0.1 N twelve times out of its t.
    #[test]
    fn what_is_not_known_of_the_plant_is_in_the_interval() {
        let trial = felt(1.3, 100.0, 100.0);
        let of = |std_errors| found(&trial, &plant(std_errors));
        let half =
            |d: ActuatorDiscrepancy| (d.mean_ci_high_n.unwrap() - d.mean_ci_low_n.unwrap()) / 2.0;
        let t = zwidth_stats::student_t::critical_value(0.95, 12.0).unwrap();
        check(Some(half(of([0.0, 0.0, 0.05]))), t * 0.1, 1e-4);
        // the mean of θ̇ over the angles of a raised cosine, both ways: π/4 of its largest, twice
        let faster = 2.0 * core::f64::consts::FRAC_PI_4 * 1.3 * core::f64::consts::PI / PERIOD_S;
        check(Some(half(of([0.0, 0.02, 0.0]))), t * 0.02 * faster, 2e-3);
        // θ̈ is the same both ways
        assert!(half(of([0.1, 0.0, 0.0])) < 1e-3);
    }

    #[test]
    fn without_a_plant_or_a_lever_nothing_is_said_of_the_actuators() {
        let (trial, parameters) = (felt(1.3, 13.0, 2.08), in_spring(K, REST_RAD));
        let without = Parameters { lever_m: None, ..parameters.clone() };
        let known = plant([0.0; 3]);
        let of = |parameters, plant| plant_metrics(&trial, parameters, plant).unwrap().discrepancy;
        assert_eq!(of(&parameters, None), ActuatorDiscrepancy::default());
        assert_eq!(of(&without, Some(&known)), ActuatorDiscrepancy::default());
    }
}
