//! A sampled virtual wall on a lever, bilateral and linear: how stiff it may be.
//!
//! Three limits are kept apart, and formulas from the literature are given beside them:
//!
//! * **exact linear stability** ([`SampledWall::spectral_radius`]): x_{k+1} = A x_k on everything
//!   that is remembered from tick to tick; stable if ρ(A) < 1;
//! * **passivity** ([`SampledWall::damping_for_passivity`]): Colgate & Schenkel's condition, by its
//!   maximum over frequency;
//! * **method stability** ([`SampledWall::step_growth`]): |R(hλ)| of a solver that runs the same
//!   wall without sampling;
//! * [`Textbook`]: closed forms, which are approximations.
//!
//! [`SampledWall::stiffest_measured`] simulates the loop ([`crate::HeldScene`]) and looks for
//! growing swings; it shares no code with the map. [`PushedWall`] also has friction, counts and
//! limits. Lengths are those of the lever's end: x = L θ.

mod lifted;
mod measured;
mod passivity;
mod plant;
mod pushed;
mod step;
#[cfg(test)]
mod tests;
mod textbook;

pub use pushed::{Pushed, PushedWall};
pub use textbook::{DryLimits, Textbook};

use crate::error::{Result, finite, not_negative, positive};

/// Most whole periods of delay.
pub(crate) const MOST_DELAY: usize = 25;

/// A lever against a virtual spring and damper of a digital controller: at each tick, u = K x + B ẋ
/// with ẋ the backward difference of x, low-passed where there is a filter; the force −u acts after
/// the delay and is held for a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledWall {
    /// m: what moves, felt at the lever's end, kg.
    pub mass_kg: f64,
    /// b: viscous damping of the device, N s/m.
    pub damping_ns_per_m: f64,
    /// T: the controller's period, s.
    pub period_s: f64,
    /// From a measurement to its force, s.
    pub delay_s: f64,
    /// K: stiffness of the wall, N/m.
    pub stiffness_n_per_m: f64,
    /// B: damping of the wall, N s/m.
    pub wall_damping_ns_per_m: f64,
    /// τ_v: time constant of the velocity's filter, y_k = α y_{k−1} + (1 − α) Δx/T with α =
    /// e^(−T/τ_v), s.
    pub velocity_lag_s: Option<f64>,
    /// τ_m: electrical time constant of the motor, s.
    pub motor_lag_s: Option<f64>,
    /// A fingertip that rides on the lever.
    pub finger: Option<RidingFinger>,
}

/// A mass on tissue at the lever's end (the consistent law): M_F (ẍ2 + ẍ) = −K_F x2 − B_F ẋ2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RidingFinger {
    /// M_F, kg.
    pub mass_kg: f64,
    /// K_F, N/m.
    pub stiffness_n_per_m: f64,
    /// B_F, N s/m.
    pub damping_ns_per_m: f64,
}

impl SampledWall {
    /// A wall of stiffness and damping 0 on a bare lever, without delay, filter and lag.
    pub fn bare(mass_kg: f64, damping_ns_per_m: f64, period_s: f64) -> Self {
        Self {
            mass_kg,
            damping_ns_per_m,
            period_s,
            delay_s: 0.0,
            stiffness_n_per_m: 0.0,
            wall_damping_ns_per_m: 0.0,
            velocity_lag_s: None,
            motor_lag_s: None,
            finger: None,
        }
    }

    /// The same wall with another stiffness, N/m.
    #[must_use]
    pub fn with_stiffness(self, stiffness_n_per_m: f64) -> Self {
        Self { stiffness_n_per_m, ..self }
    }

    /// Every parameter checked.
    ///
    /// # Errors
    /// The first that makes no sense, by name and value; a delay of more than 25 periods.
    pub fn check(&self) -> Result<()> {
        positive("mass_kg", self.mass_kg)?;
        not_negative("damping_ns_per_m", self.damping_ns_per_m)?;
        positive("period_s", self.period_s)?;
        not_negative("delay_s", self.delay_s)?;
        not_negative("stiffness_n_per_m", self.stiffness_n_per_m)?;
        finite("wall_damping_ns_per_m", self.wall_damping_ns_per_m)?;
        self.velocity_lag_s.map_or(Ok(()), |lag| positive("velocity_lag_s", lag))?;
        self.motor_lag_s.map_or(Ok(()), |lag| positive("motor_lag_s", lag))?;
        self.finger.map_or(Ok(()), |finger| finger.check())?;
        let few = self.delay_s <= MOST_DELAY as f64 * self.period_s;
        crate::error::check("delay_s", self.delay_s, few, "at most 25 periods of the controller")
    }

    /// The delay in whole periods, and what is left, s.
    pub(crate) fn delay(&self) -> (usize, f64) {
        /// What is left of a delay below this share of a period is rounding.
        const ROUNDING: f64 = 1e-9;
        let periods = self.delay_s / self.period_s;
        let nearest = periods.round();
        if (periods - nearest).abs() < ROUNDING {
            return (nearest as usize, 0.0);
        }
        let whole = periods.floor();
        (whole as usize, self.delay_s - whole * self.period_s)
    }

    /// α of the velocity's filter; 0 without one.
    pub(crate) fn filter(&self) -> f64 {
        self.velocity_lag_s.map_or(0.0, |lag| libm::exp(-self.period_s / lag))
    }
}

impl RidingFinger {
    fn check(&self) -> Result<()> {
        positive("finger.mass_kg", self.mass_kg)?;
        not_negative("finger.stiffness_n_per_m", self.stiffness_n_per_m)?;
        not_negative("finger.damping_ns_per_m", self.damping_ns_per_m)
    }
}
