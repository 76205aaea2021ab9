//! The sticking scene as the mode machine every peer is given: Table 3 of the thesis without
//! finger, a sine of 2.15 N, motor 3.25 N, brake 13 N, lever 1 m. The brake's own limits and the
//! lever's stops are never reached in this scene, so no peer has to look for them. Where the lever
//! sticks nothing is integrated: the time of its release follows from the sine in closed form.

use std::f64::consts::{E, FRAC_PI_2, FRAC_PI_4, LN_2, PI, SQRT_2, TAU};

/// θ, rad, and θ̇, rad/s.
pub(crate) type State = [f64; 2];

/// What a method integrates: N = 2, θ and θ̇ with the sine evaluated at every stage, or N = 4,
/// where the sine's swing and its rate join the state as an oscillator. The second spares the
/// sines, and a Runge–Kutta method keeps its order there: with a fast mode beside it, an evaluated
/// sine lowers the order (Prothero & Robinson 1974).
pub(crate) type Full<const N: usize> = [f64; N];

/// M_O, kg, at a lever of 1 m.
const MASS: f64 = 0.005;
/// θ_rest, rad; the lever starts there.
const REST: f64 = -FRAC_PI_4;
/// Largest motor force F_m, N.
const MOTOR: f64 = 3.25;
/// Its angular frequency, rad/s.
const OMEGA: f64 = FRAC_PI_2;

/// The numbers that a sweep changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Numbers {
    /// K_O, N/rad.
    pub(crate) stiffness: f64,
    /// B_O, N s/rad.
    pub(crate) damping: f64,
    /// Magnitude of the sine a, N.
    pub(crate) magnitude: f64,
}

/// Those of the one scene.
pub(crate) const STICKING: Numbers = Numbers { stiffness: 4.0, damping: 1.0, magnitude: 2.15 };

/// Number of scenes in the sweep.
pub(crate) const SWEPT: u32 = 1000;

/// The numbers of scene `i` of the sweep: multiples of irrational numbers fill the ranges evenly without
/// a random generator (Weyl 1916). In all of them the lever stays between its stops, and the brake below its limit.
pub(crate) fn swept(i: u32) -> Numbers {
    let spread = |irrational: f64, low: f64, high: f64| {
        low + (high - low) * (f64::from(i) * irrational).fract()
    };
    Numbers {
        stiffness: spread(SQRT_2, 3.5, 8.0),
        damping: spread(LN_2, 0.5, 2.0),
        magnitude: spread(E, 1.0, 2.5),
    }
}

/// Step of the output grid, s.
pub(crate) const STEP_S: f64 = 0.008_3;
/// Number of output samples in 4 s, the start included.
pub(crate) const SAMPLES: usize = 482;
/// Time of the last sample, s.
pub(crate) const END_S: f64 = (SAMPLES - 1) as f64 * STEP_S;

/// Time of a sample, s.
#[inline]
pub(crate) fn sample_s(i: usize) -> f64 {
    i as f64 * STEP_S
}

/// Which smooth law holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// θ̇ > 0 against the brake.
    Forward,
    /// θ̇ < 0, the motor at its limit.
    Saturated,
    /// θ̇ < 0, the motor below its limit.
    Backward,
    /// θ̇ = 0.
    Stick,
}

impl Numbers {
    /// u at rest, N.
    fn spring(&self, theta: f64) -> f64 {
        self.stiffness * (theta - REST)
    }

    /// F_ex(t) = a + a sin ωt, N.
    #[inline]
    fn push(&self, t: f64) -> f64 {
        self.magnitude + self.magnitude * (OMEGA * t).sin()
    }

    /// θ and θ̇ with the rest of what is integrated.
    pub(crate) fn full<const N: usize>(&self, t: f64, y: State) -> Full<N> {
        let a = self.magnitude;
        let swing = [a * (OMEGA * t).sin(), a * OMEGA * (OMEGA * t).cos()];
        std::array::from_fn(|i| if i < 2 { y[i] } else { swing[i - 2] })
    }

    /// The phase that follows from θ̇ = 0.
    fn at_rest(&self, t: f64, theta: f64) -> Phase {
        let force = self.push(t);
        if force > self.spring(theta) {
            Phase::Forward
        } else if force < self.spring(theta).min(MOTOR) {
            self.backward(theta)
        } else {
            Phase::Stick
        }
    }

    fn backward(&self, theta: f64) -> Phase {
        if self.spring(theta) > MOTOR { Phase::Saturated } else { Phase::Backward }
    }

    /// When a lever that sticks at `theta` since `t` is released, and into which phase.
    pub(crate) fn release(&self, t: f64, theta: f64) -> (f64, Phase) {
        let rises = self.next_time(t, self.spring(theta), false);
        let falls = self.next_time(t, self.spring(theta).min(MOTOR), true);
        if rises < falls { (rises, Phase::Forward) } else { (falls, self.backward(theta)) }
    }

    /// The next time after `t` at which the push rises or falls through a force; infinite if it never
    /// does.
    fn next_time(&self, t: f64, force: f64, falling: bool) -> f64 {
        let angle = (force / self.magnitude - 1.0).asin();
        let first = if falling { PI - angle } else { angle };
        if first.is_nan() { f64::INFINITY } else { t + (first - OMEGA * t).rem_euclid(TAU) / OMEGA }
    }
}

impl Phase {
    /// Stiffness, damping and constant part of the actuators' resisting force.
    #[inline]
    pub(crate) fn law(self, numbers: &Numbers) -> [f64; 3] {
        match self {
            Self::Forward | Self::Backward => {
                [numbers.stiffness, numbers.damping, -numbers.stiffness * REST]
            }
            Self::Saturated | Self::Stick => [0.0, 0.0, MOTOR],
        }
    }

    /// Rate of the state.
    #[inline]
    pub(crate) fn slope<const N: usize>(self, numbers: &Numbers, t: f64, y: &Full<N>) -> Full<N> {
        let [k, b, c] = self.law(numbers);
        let mut slope = [0.0; N];
        let force = if N == 4 { numbers.magnitude + y[2] } else { numbers.push(t) };
        slope[0] = y[1];
        slope[1] = (force - k * y[0] - b * y[1] - c) * (1.0 / MASS);
        if N == 4 {
            slope[2] = y[3];
            slope[3] = -OMEGA * OMEGA * y[2];
        }
        slope
    }

    /// Its derivative by the state, times v.
    pub(crate) fn jacobian_times<const N: usize>(self, numbers: &Numbers, v: &Full<N>) -> Full<N> {
        let [k, b, _] = self.law(numbers);
        let mut product = [0.0; N];
        product[0] = v[1];
        product[1] = (-k * v[0] - b * v[1]) / MASS;
        if N == 4 {
            product[1] += v[2] / MASS;
            product[2] = v[3];
            product[3] = -OMEGA * OMEGA * v[2];
        }
        product
    }

    /// Above 0 inside the phase: the distance to reversal and to the motor's limit.
    #[inline]
    pub(crate) fn guards(self, numbers: &Numbers, y: State) -> [f64; 2] {
        let below_limit = MOTOR - numbers.spring(y[0]) - numbers.damping * y[1];
        match self {
            Self::Forward | Self::Stick => [y[1], 1.0],
            Self::Saturated => [-y[1], -below_limit],
            Self::Backward => [-y[1], below_limit],
        }
    }

    /// The phase after a guard has reached 0; a reversal sets θ̇ to 0.
    pub(crate) fn next(self, numbers: &Numbers, guard: usize, t: f64, y: &mut State) -> Self {
        if guard == 0 {
            y[1] = 0.0;
            return numbers.at_rest(t, y[0]);
        }
        if self == Self::Saturated { Self::Backward } else { Self::Saturated }
    }
}

/// Where every peer starts.
pub(crate) const START: (f64, State, Phase) = (0.0, [REST, 0.0], Phase::Forward);

/// The output every peer writes.
#[derive(Debug, Default)]
pub(crate) struct Samples {
    pub(crate) theta: Vec<f64>,
    pub(crate) theta_dot: Vec<f64>,
}

impl Samples {
    /// Empties it, keeping its memory.
    pub(crate) fn clear(&mut self) {
        self.theta.clear();
        self.theta_dot.clear();
    }

    /// Time of the next sample, s; infinite when all are there.
    #[inline]
    pub(crate) fn next_s(&self) -> f64 {
        if self.theta.len() < SAMPLES { sample_s(self.theta.len()) } else { f64::INFINITY }
    }

    #[inline]
    pub(crate) fn push(&mut self, y: State) {
        self.theta.push(y[0]);
        self.theta_dot.push(y[1]);
    }

    /// The samples before `t` of a lever that sticks.
    pub(crate) fn hold(&mut self, theta: f64, t: f64) {
        while self.next_s() < t {
            self.push([theta, 0.0]);
        }
    }
}
