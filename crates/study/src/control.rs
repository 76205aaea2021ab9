//! Numbers of the control loop.

use serde::Serialize;

/// What the control loop needs besides the scene; each number has a default.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Control {
    /// Ticks per second, Hz. A device that gives fewer samples sets its own rate.
    pub rate_hz: f64,
    /// The brake lets go only below this user force, N (thesis §6.2.1).
    pub let_go_n: f64,
    /// Limit of the force on a finger, N: a motor that can give more is refused, and a larger
    /// measured force stops the trial.
    pub force_limit_n: f64,
    /// How velocity is made of angles.
    pub velocity: VelocityFilter,
}

impl Default for Control {
    fn default() -> Self {
        Self {
            rate_hz: 1000.0,
            let_go_n: 2.0,
            force_limit_n: 10.0, // Wang 2019, via the thesis
            velocity: VelocityFilter::SecondOrder { cutoff_hz: VelocityFilter::CUTOFF_HZ },
        }
    }
}

/// How velocity is made of angles. Both are causal, so both are late.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VelocityFilter {
    /// The difference of the last two angles over their time; late by half of it.
    Difference,
    /// A differentiator with a critically damped second-order low-pass, s ω² / (s + ω)² with ω = 2π
    /// `cutoff_hz`; a slow signal comes late by 2/ω = 1/(π `cutoff_hz`).
    SecondOrder {
        /// Cut-off frequency, Hz.
        cutoff_hz: f64,
    },
}

impl VelocityFilter {
    /// The default cut-off, Hz: four times what a hand can move at, and 8 ms late.
    pub(crate) const CUTOFF_HZ: f64 = 40.0;
}
