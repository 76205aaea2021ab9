//! The calibration: the chosen curves of motor and brake as knots, read forward and backward.

use crate::error::CharacteriseError;
use crate::models::Model;
use crate::shape::Quantity;
use zwidth_numerics::branch::Branch;
use zwidth_study::Characteristic;

/// Places at which a curve is evaluated, evenly over its voltages; breaks and plateaus come on top.
const PLACES: usize = 1024;
/// Straight lines between knots stay this close to the curve, as a share of the largest force: 7 mN
/// of the brake's 13 N, less than any load cell here resolves.
const CLOSENESS: f64 = 5e-4;
/// A break or plateau within this share of the voltages from their end is at the end.
const AT_END: f64 = 0.01;
/// A curve that rises by less than this share of the largest force is taken as flat: its inverse
/// would be rounding error.
const RISE: f64 = 1e-9;

/// A curve that was chosen for an actuator.
#[derive(Clone)]
pub struct Chosen {
    /// The model.
    pub model: Model,
    /// Its parameters.
    pub parameters: Vec<f64>,
    /// Lowest and highest voltage it was fitted to, V.
    pub voltage_v: (f64, f64),
}

/// Force against voltage of `actuator` (`motor` or `brake`) by knots, made from its chosen curve (N
/// against V).
///
/// * **No force** is the response at the lowest voltage of the sweeps that is not negative: it
///   includes the load cell's zero and the friction of the lever without the actuator, and is
///   subtracted.
/// * **Hysteresis**: the mean of both branches, because a controller does not depend on the
///   direction of its voltage; where one of them has not turned yet, the mean's tangent. After each
///   turn of the voltage, dry friction holds the response for a while (a stretch that is flat on
///   one branch only): neither this nor the other branch's half of the friction belongs to the
///   actuator. A stretch that is flat on both is a dead zone, or an actuator that saturates, and
///   stays.
/// * **Knots** lie on that curve: where force begins (0 V, or the end of the dead zone), where it
///   stops rising, and in between as many as keep straight lines within 0.05 % of the largest force
///   (Douglas & Peucker 1973): a hinge has two. They rise strictly, so that forward and inverse
///   undo each other.
///
/// # Errors
/// A curve without a voltage above 0, or whose response does not rise.
pub fn calibrated(
    actuator: &'static str,
    chosen: &Chosen,
) -> Result<Characteristic, CharacteriseError> {
    // Forces of negative voltages are those of positive ones with the other sign.
    let low = chosen.voltage_v.0.max(0.0);
    let high = chosen.voltage_v.1;
    let refuse = |problem: String| Err(CharacteriseError::no_calibration(actuator, &problem));
    if high <= low {
        return refuse(format!(
            "its sweeps end at {high} V: record them up to the voltage that is to be used"
        ));
    }
    let met = chosen.met(low, high);
    let first = met.response(chosen, low);
    let last = met.response(chosen, high);
    if last <= first {
        return refuse(format!(
            "the response goes from {first:.3} N at {low} V to {last:.3} N at {high} V, yet force must rise with voltage: \
             turn its sign where it is recorded or imported"
        ));
    }
    // Where the tangents reach floor and cap.
    let corners = [
        met.from + (met.floor - chosen.response(met.from)) / met.slopes[0],
        met.to + (met.cap - chosen.response(met.to)) / met.slopes[1],
    ];
    let places = chosen.places(low, high, corners);
    let curve = places.into_iter().map(|v| (v, met.response(chosen, v) - first)).collect();
    let curve = rising(curve);
    let tolerance = CLOSENESS * curve.last().map_or(0.0, |(_, force)| *force);
    let (voltage_v, force_n) = knots(&curve, tolerance).into_iter().unzip();
    Ok(Characteristic { voltage_v, force_n })
}

/// Where both branches have turned, and how the mean goes on beyond.
struct Met {
    /// Lowest voltage at which both have left their flat start, V.
    from: f64,
    /// Highest voltage at which neither is flat yet, V.
    to: f64,
    /// Slopes of the mean there, N/V.
    slopes: [f64; 2],
    /// The response that the mean does not fall below: that of a dead zone.
    floor: f64,
    /// The response that it does not exceed: that of an actuator that can give no more.
    cap: f64,
}

impl Met {
    /// The mean response: within the common part the curve's, beyond it on the tangents.
    fn response(&self, chosen: &Chosen, voltage_v: f64) -> f64 {
        let mean = chosen.response(voltage_v.clamp(self.from, self.to));
        let below = self.slopes[0] * (voltage_v - self.from).min(0.0);
        let above = self.slopes[1] * (voltage_v - self.to).max(0.0);
        (mean + below + above).max(self.floor).min(self.cap)
    }
}

impl Chosen {
    /// The common part of both branches between `low` and `high`.
    fn met(&self, low: f64, high: f64) -> Met {
        // A break at the very beginning is no dead zone, a plateau at the very end no saturation.
        let end = AT_END * (high - low);
        let breaks = self.of_branches(Quantity::Break);
        let plateaus = self.of_branches(Quantity::Plateau);
        let from = breaks.iter().copied().fold(low, f64::max);
        let to = plateaus.iter().copied().fold(high, f64::min);
        // Branches that never rise together have no common part whose tangents could go on.
        let (from, to) = if from < to { (from, to) } else { (low, high) };
        let h = (to - from) / PLACES as f64;
        let is_dead = !breaks.is_empty() && breaks.iter().all(|x0| *x0 > low + end);
        let is_full = !plateaus.is_empty() && plateaus.iter().all(|x1| *x1 < high - end);
        Met {
            from,
            to,
            slopes: [from, to - h].map(|left| (self.response(left + h) - self.response(left)) / h),
            floor: if is_dead { self.response(low) } else { f64::NEG_INFINITY },
            cap: if is_full { self.response(high) } else { f64::INFINITY },
        }
    }

    /// A parameter of each branch, where the branches have their own.
    fn of_branches(&self, quantity: Quantity) -> Vec<f64> {
        let parameters = self.model.parameters().into_iter().zip(&self.parameters);
        let own = parameters.filter(|((branch, _, q), _)| branch.is_some() && *q == quantity);
        own.map(|(_, value)| *value).collect()
    }

    /// Mean response of both branches.
    fn response(&self, voltage_v: f64) -> f64 {
        let [up, down] =
            Branch::ALL.map(|branch| self.model.predict(&self.parameters, voltage_v, branch));
        0.5 * (up + down)
    }

    /// Voltages to look at, rising: an even grid with the curve's own kinks and other `corners`.
    fn places(&self, low: f64, high: f64, corners: [f64; 2]) -> Vec<f64> {
        let parameters = self.model.parameters().into_iter().zip(&self.parameters);
        let kinks = parameters
            .filter(|((_, _, q), _)| matches!(q, Quantity::Break | Quantity::Plateau))
            .map(|(_, x)| *x);
        let step = (high - low) / PLACES as f64;
        let even = (0..PLACES).map(|i| low + step * i as f64).chain([high]);
        let mut places: Vec<f64> =
            even.chain(kinks.chain(corners).filter(|x| *x > low && *x < high)).collect();
        places.sort_by(f64::total_cmp);
        places
    }
}

/// The part of a curve that rises, from the last place without force, strictly; forces below 0
/// count as 0.
fn rising(curve: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let largest = curve.iter().map(|(_, force)| *force).fold(0.0, f64::max);
    let mut kept: Vec<(f64, f64)> = Vec::with_capacity(curve.len());
    // The `0.0` of the second arm is the one that the last arm pushes: no force so far.
    for (voltage, force) in curve {
        match kept.last_mut() {
            Some((_, last)) if force > *last + RISE * largest => kept.push((voltage, force)),
            Some((begins, 0.0)) => *begins = voltage,
            Some(_) => {}
            None => kept.push((voltage, 0.0)),
        }
    }
    kept
}

/// The first and the last point, and recursively the one farthest from the straight line, while it
/// is farther than `tolerance` in force.
fn knots(curve: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let (Some(&first), Some(&last)) = (curve.first(), curve.last()) else { return Vec::new() };
    let slope = (last.1 - first.1) / (last.0 - first.0);
    let distance = |i: usize| (curve[i].1 - first.1 - slope * (curve[i].0 - first.0)).abs();
    let inner = 1..curve.len().saturating_sub(1);
    match inner.max_by(|&i, &j| distance(i).total_cmp(&distance(j))) {
        Some(farthest) if distance(farthest) > tolerance => {
            let mut all = knots(&curve[..=farthest], tolerance);
            all.pop(); // the point where both parts meet
            all.extend(knots(&curve[farthest..], tolerance));
            all
        }
        _ => vec![first, last],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::CurveModel;
    use zwidth_study::Calibration;

    fn chosen(name: &str, parameters: &[f64], voltage_v: (f64, f64)) -> Chosen {
        let model = Model::of(CurveModel::from_word(name).unwrap());
        Chosen { model, parameters: parameters.to_vec(), voltage_v }
    }

    fn made(name: &str, parameters: &[f64], voltage_v: (f64, f64)) -> Characteristic {
        calibrated("brake", &chosen(name, parameters, voltage_v)).unwrap()
    }

    fn check_knots(found: &Characteristic, expect: &[(f64, f64)]) {
        let knots: Vec<_> =
            found.voltage_v.iter().zip(&found.force_n).map(|(v, f)| (*v, *f)).collect();
        let near = |(a, b): (&(f64, f64), &(f64, f64))| {
            (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12
        };
        assert!(knots.len() == expect.len() && knots.iter().zip(expect).all(near), "{knots:?}");
    }

    #[test]
    fn straight_laws_have_their_corners_as_knots() {
        check_knots(&made("line", &[0.02, 0.26], (0.0, 16.0)), &[(0.0, 0.0), (16.0, 4.16)]);
        check_knots(&made("line", &[0.02, 0.26], (-16.0, 16.0)), &[(0.0, 0.0), (16.0, 4.16)]);
        check_knots(
            &made("hinge", &[-0.3, 13.0 / 7.0, 1.0], (0.0, 8.0)),
            &[(1.0, 0.0), (8.0, 13.0)],
        );
        check_knots(
            &made("saturation", &[0.1, 2.0, 1.3, 7.1], (0.0, 8.0)),
            &[(1.3, 0.0), (7.1, 11.6)],
        );
    }

    #[test]
    fn branches_are_met_in_the_middle() {
        let both = made("hinge_up_down", &[0.1, 2.0, 1.0, 0.1, 2.0, 0.5], (0.0, 8.0));
        check_knots(&both, &[(0.75, 0.0), (8.0, 14.5)]);
        let full = [0.0, 2.0, 1.0, 7.0, 0.0, 2.0, 0.5, 6.0];
        check_knots(&made("saturation_up_down", &full, (0.0, 8.0)), &[(0.75, 0.0), (6.5, 11.5)]);
    }

    /// A motor of 0.26 N/V that moves its load cell through ±0.078 N of friction, up to 16 V and
    /// back: friction turns round over the first 0.6 V of each way, and at 16 V the cell has
    /// 4.082 N where the motor has 4.16 N.
    #[test]
    fn what_friction_keeps_after_a_turn_is_not_the_motors() {
        let (up, down) = ([0.078, 0.26, 0.6, 16.0], [0.078, 0.26, 0.0, 15.4]);
        let motor = made("saturation_up_down", &[up, down].concat(), (0.0, 16.0));
        check_knots(&motor, &[(0.0, 0.0), (16.0, 4.16)]);
    }

    #[test]
    fn straight_lines_between_the_knots_of_a_curved_law_stay_close_to_it() {
        let (a, b, x0, p) = (0.08, 0.3, 0.7, 1.7);
        let found = made("power_law", &[a, b, x0, p], (0.0, 8.0));
        assert!(found.voltage_v.len() < 40, "{} knots", found.voltage_v.len());
        for i in 0..=8000 {
            let v = f64::from(i) * 1e-3;
            let law = b * libm::pow((v - x0).max(0.0), p);
            assert!(
                (found.force_n(v) - law).abs() < 6e-4 * found.force_n.last().unwrap(),
                "at {v} V"
            );
        }
    }

    /// Every law, through the file: forward(inverse(F)) = F, and inverse(forward(V)) = V where
    /// force is made.
    #[test]
    fn forward_and_inverse_undo_each_other_through_the_file() {
        let laws: [(&str, &[f64]); 5] = [
            ("line", &[0.02, 1.6]),
            ("hinge", &[0.1, 1.857, 0.99]),
            ("saturation", &[0.1, 1.857, 0.99, 7.3]),
            ("power_law", &[0.1, 0.4, 0.9, 1.71]),
            ("spline", &[0.1, 0.0, 8.0, 0.0, 0.3, 1.5, 2.5, 2.0, 0.9, 0.0]),
        ];
        for (name, parameters) in laws {
            let brake = made(name, parameters, (0.0, 8.0));
            let text = Calibration { motor: brake.clone(), brake }.to_toml().unwrap();
            let Calibration { motor, brake } = Calibration::from_toml(&text).unwrap();
            for i in 0..=1000 {
                let force = brake.force_n.last().unwrap() * f64::from(i) / 1000.0;
                assert!(
                    (brake.force_n(brake.voltage_v(force)) - force).abs() < 1e-9,
                    "{name}: {force} N"
                );
                assert!(
                    (motor.force_n(motor.voltage_v(-force)) + force).abs() < 1e-9,
                    "{name}: -{force} N"
                );
            }
        }
    }

    #[test]
    fn a_falling_response_and_sweeps_below_zero_are_refused_with_a_remedy() {
        let error = |parameters: &[f64], range| {
            calibrated("motor", &chosen("line", parameters, range)).unwrap_err().to_string()
        };
        let falls = error(&[0.0, -0.26], (0.0, 16.0));
        assert!(falls.contains("motor") && falls.contains("turn its sign"), "{falls}");
        assert!(error(&[0.0, 0.26], (-16.0, 0.0)).contains("end at 0 V"));
    }
}
