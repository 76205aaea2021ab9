//! The honest fast peer: Dormand–Prince 5(4) by hand for two or four states, with the dense output
//! of Hairer, Nørsett & Wanner (Solving Ordinary Differential Equations I, II.6) and events on it.
//! Nothing generic, nothing allocated.

use crate::scene::{END_S, Full, Numbers, Phase, START, Samples, State};

/// What a run aims for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Aim {
    pub(crate) tolerance: f64,
    pub(crate) largest_step_s: f64,
    /// Whether the sine joins the state ([`Full`]).
    pub(crate) sine_joins: bool,
}

/// y + h Σ weight · slope.
macro_rules! along {
    ($y:expr, $h:expr, $($weight:expr, $slope:expr);+) => {
        std::array::from_fn(|i| $y[i] + $h * (0.0 $(+ $weight * $slope[i])+))
    };
}

/// One attempted step: its end, the slope there, the error in units of the tolerance, and the dense
/// output.
struct Step<const N: usize> {
    end: Full<N>,
    slope: Full<N>,
    error: f64,
    dense: [State; 5],
}

#[inline]
fn attempt<const N: usize>(
    numbers: &Numbers,
    phase: Phase,
    t: f64,
    h: f64,
    y: &Full<N>,
    k1: &Full<N>,
    tolerance: f64,
) -> Step<N> {
    let k2 = phase.slope::<N>(numbers, t + 0.2 * h, &along!(y, h, 0.2, k1));
    let k3 = phase.slope::<N>(numbers, t + 0.3 * h, &along!(y, h, 3.0 / 40.0, k1; 9.0 / 40.0, k2));
    let at = along!(y, h, 44.0 / 45.0, k1; -56.0 / 15.0, k2; 32.0 / 9.0, k3);
    let k4 = phase.slope::<N>(numbers, t + 0.8 * h, &at);
    let at = along!(y, h, 19372.0 / 6561.0, k1; -25360.0 / 2187.0, k2; 64448.0 / 6561.0, k3; -212.0 / 729.0, k4);
    let k5 = phase.slope::<N>(numbers, t + 8.0 / 9.0 * h, &at);
    let at = along!(y, h, 9017.0 / 3168.0, k1; -355.0 / 33.0, k2; 46732.0 / 5247.0, k3; 49.0 / 176.0, k4;
        -5103.0 / 18656.0, k5);
    let k6 = phase.slope::<N>(numbers, t + h, &at);
    let end = along!(y, h, 35.0 / 384.0, k1; 500.0 / 1113.0, k3; 125.0 / 192.0, k4; -2187.0 / 6784.0, k5;
        11.0 / 84.0, k6);
    let k7 = phase.slope::<N>(numbers, t + h, &end);
    let error: State = along!([0.0, 0.0], h, 71.0 / 57600.0, k1; -71.0 / 16695.0, k3; 71.0 / 1920.0, k4;
        -17253.0 / 339200.0, k5; 22.0 / 525.0, k6; -1.0 / 40.0, k7);
    let share = |i: usize| error[i] / (tolerance * (1.0 + y[i].abs().max(end[i].abs())));
    let last: State = along!([0.0, 0.0], h, -12715105075.0 / 11282082432.0, k1; 87487479700.0 / 32700410799.0, k3;
        -10690763975.0 / 1880347072.0, k4; 701980252875.0 / 199316789632.0, k5;
        -1453857185.0 / 822651844.0, k6; 69997945.0 / 29380423.0, k7);
    let change = [end[0] - y[0], end[1] - y[1]];
    let bend = [h * k1[0] - change[0], h * k1[1] - change[1]];
    let fourth = [change[0] - h * k7[0] - bend[0], change[1] - h * k7[1] - bend[1]];
    let squares = share(0) * share(0) + share(1) * share(1);
    Step {
        end,
        slope: k7,
        error: (0.5 * squares).sqrt(),
        dense: [[y[0], y[1]], change, bend, fourth, last],
    }
}

impl<const N: usize> Step<N> {
    /// The state at a share of the step.
    #[inline]
    fn at(&self, s: f64) -> State {
        let [a, b, c, d, e] = &self.dense;
        let r = 1.0 - s;
        std::array::from_fn(|i| a[i] + s * (b[i] + r * (c[i] + s * (d[i] + r * e[i]))))
    }

    /// The first guard that is below 0 at the step's end, and the share at which it falls through
    /// 0.
    #[inline]
    fn event(&self, numbers: &Numbers, phase: Phase) -> Option<(f64, usize)> {
        let below = phase.guards(numbers, [self.end[0], self.end[1]]);
        if below[0] >= 0.0 && below[1] >= 0.0 {
            return None;
        }
        let root = |i: usize| {
            if below[i] < 0.0 {
                crossing(|s| phase.guards(numbers, self.at(s))[i])
            } else {
                f64::INFINITY
            }
        };
        let shares = [root(0), root(1)];
        let first = usize::from(shares[1] < shares[0]);
        Some((shares[first], first))
    }
}

/// Where a function that ends below 0 falls through it on (0, 1): false position, Illinois variant.
pub(crate) fn crossing(f: impl Fn(f64) -> f64) -> f64 {
    /// Enough for the last bit of a simple root.
    const MOST: usize = 60;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut f_low, mut f_high) = (f(low), f(high));
    if f_low <= 0.0 {
        // A guard that starts at 0 first rises: go back from the end to where it is positive.
        low = 0.5;
        while f(low) <= 0.0 && low > f64::EPSILON {
            (high, low) = (low, 0.5 * low);
        }
        (f_low, f_high) = (f(low), f(high));
    }
    for _ in 0..MOST {
        let middle = high - f_high * (high - low) / (f_high - f_low);
        let value = f(middle);
        if value.abs() < f64::MIN_POSITIVE || high - low < 4.0 * f64::EPSILON {
            return middle;
        }
        if value < 0.0 {
            (high, f_high, f_low) = (middle, value, 0.5 * f_low);
        } else {
            (low, f_low, f_high) = (middle, value, 0.5 * f_high);
        }
    }
    high
}

/// Runs the scene; returns the number of evaluations.
pub(crate) fn run(numbers: &Numbers, aim: Aim, out: &mut Samples) -> u64 {
    out.clear();
    let (mut t, mut y, mut phase) = START;
    let mut evaluations = 0;
    while t < END_S {
        if phase == Phase::Stick {
            let (until, next) = numbers.release(t, y[0]);
            out.hold(y[0], until);
            (t, phase) = (until, next);
        } else {
            let smooth = if aim.sine_joins { smooth::<4> } else { smooth::<2> };
            evaluations += smooth(numbers, aim, &mut t, &mut y, &mut phase, out);
        }
    }
    // The last step may end a rounding before the last sample.
    out.hold(y[0], f64::MAX);
    evaluations
}

/// One phase, to its end.
fn smooth<const N: usize>(
    numbers: &Numbers,
    aim: Aim,
    t: &mut f64,
    y: &mut State,
    phase: &mut Phase,
    out: &mut Samples,
) -> u64 {
    /// First step after a change of phase, s; a tenth of the fast time constant, and rejected if
    /// too long.
    const FIRST_S: f64 = 5e-4;
    let mut h = FIRST_S.min(aim.largest_step_s);
    let mut z = numbers.full::<N>(*t, *y);
    let mut slope = phase.slope(numbers, *t, &z);
    let mut evaluations = 1;
    while *t < END_S {
        let step = attempt(numbers, *phase, *t, h, &z, &slope, aim.tolerance);
        evaluations += 6;
        let factor = (0.9 * step.error.max(1e-10).powf(-0.2)).clamp(0.2, 5.0);
        if step.error > 1.0 {
            h *= factor.min(1.0);
            continue;
        }
        let event = step.event(numbers, *phase);
        let until = *t + event.map_or(1.0, |(share, _)| share) * h;
        while out.next_s() <= until {
            out.push(step.at((out.next_s() - *t) / h));
        }
        if let Some((share, guard)) = event {
            (*t, *y) = (until, step.at(share));
            *phase = phase.next(numbers, guard, *t, y);
            return evaluations;
        }
        (*t, z, slope) = (until, step.end, step.slope);
        h = (h * factor).min(aim.largest_step_s);
    }
    evaluations
}
