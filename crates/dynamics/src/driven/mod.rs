//! The plant under held commands, with a hand in one-sided contact: a simulated device moves it
//! from tick to tick.
//!
//! Unlike a [`crate::ModelScene`], nothing here knows an environment or a mode: between two calls
//! of [`Driven::advance`] the commanded motor force and brake level are constants, as a digital
//! controller holds them. Everything acts on the lever's end, in newtons:
//!
//! ```text
//! (J/L) θ̈ = F_m − (b + F_k) sgn θ̇ − (b_v + b_e) θ̇ + F_ex   lever in motion
//! |F_m + F_ex| ≤ b + F_s,  θ̇ = 0                           lever at rest (set-valued)
//! τ_m Ḟ_m = F_cmd − F_m                                    motor behind its winding, τ_m = L_m/R
//! τ_b ḃ   = b_cmd − b                                      brake behind its air gap, τ_b by direction
//! M v̇_h = K (p − s_h) + B (ṗ − v_h) − F_ex                 hand, pulled along by its intent p(t), ṗ(t)
//! F_ex = K_F δ + B_F δ̇ ≥ 0,  δ = s_h − L θ                 tissue in contact
//! F_ex = 0,  K_F δ + B_F δ̇ = 0                             tissue free: it springs back by itself
//! ```
//!
//! The tissue has no mass and can only push. It lifts off when its force reaches zero (still
//! pressed, because it is slow to spring back), relaxes in the air, and touches again when its
//! surface meets the lever. So F_ex is never negative and jumps only by B_F times the speed of the
//! touch.
//!
//! The equations are piecewise linear, and each piece is solved exactly: by the matrix exponential
//! over a ladder of spans made once, with events (reversal, departure, stop, touch, lift-off) as
//! roots of its Taylor polynomials. A span is passed over only if no event can lie inside it, so no
//! event is missed, however short. A lever at rest keeps its angle bit for bit. Of a lever without a
//! hand so little is left that a few powers of time do for most steps.

mod alone;
mod parameters;
mod plant;
mod region;

#[cfg(test)]
mod tests;

pub use parameters::{DrivenParameters, Hand, Tissue};
pub use plant::{Aim, Command, Driven, DrivenState};
