//! Solvers: one file each, behind one trait. They know systems and grids, never scenes.

pub(crate) mod adaptive;
pub(crate) mod dormand_prince;
pub(crate) mod embedded;
pub(crate) mod exact;
mod fixed;
pub(crate) mod moreau_jean;
pub(crate) mod named;
pub(crate) mod rk4;
pub(crate) mod symplectic_euler;
pub(crate) mod tr_bdf2;

use crate::error::{Result, check, finite, positive};
use crate::system::System;
use crate::system::linear::LinearPart;
use crate::system::row::MOST;
use crate::trajectory::Trajectory;
use zwidth_numerics::expm::Matrix;

/// When a law that depends on the sign of θ̇ looks at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switching {
    /// At every stage of a step.
    PerStage,
    /// Once, at the step's start.
    PerStep,
}

/// The times at which a run is sampled.
#[derive(Debug, Clone, PartialEq)]
pub enum Grid {
    /// 0, h, 2 h, …, `steps` · h.
    Even {
        /// h, s.
        step_s: f64,
        /// Number of steps.
        steps: usize,
    },
    /// 0, h, 2 h, …, `steps` · h, and one shorter step to the end.
    Ending {
        /// h, s.
        step_s: f64,
        /// Number of steps of h.
        steps: usize,
        /// The last sample, s; after `steps` · h by less than h.
        end_s: f64,
    },
    /// The first is the start; increasing.
    Times(Vec<f64>),
}

impl Grid {
    /// Even steps of `step_s` that fill `duration_s`, with a shorter one at the end where they do
    /// not add up to it.
    pub fn filling(duration_s: f64, step_s: f64) -> Self {
        /// Steps that miss the duration by this share of it end with it: rounding.
        const ROUNDING: f64 = 1e-9;
        let steps = (duration_s / step_s * (1.0 + ROUNDING)).max(0.0) as usize;
        if duration_s - steps as f64 * step_s > ROUNDING * duration_s {
            return Self::Ending { step_s, steps, end_s: duration_s };
        }
        Self::Even { step_s, steps }
    }

    /// The grid a system's scene asks for.
    pub fn of(system: &System) -> Self {
        Self::filling(system.scene.duration_s, system.scene.step_s)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        match self {
            Self::Even { steps, .. } => steps + 1,
            Self::Ending { steps, .. } => steps + 2,
            Self::Times(times) => times.len(),
        }
    }

    /// The step and the number of the even steps it begins with, if it does.
    #[inline]
    pub(crate) fn even_part(&self) -> Option<(f64, usize)> {
        match *self {
            Self::Even { step_s, steps } | Self::Ending { step_s, steps, .. } => {
                Some((step_s, steps))
            }
            Self::Times(_) => None,
        }
    }

    /// Time of sample `i`, s.
    #[inline]
    pub(crate) fn time(&self, i: usize) -> f64 {
        match self {
            Self::Ending { steps, end_s, .. } if i > *steps => *end_s,
            Self::Even { step_s, .. } | Self::Ending { step_s, .. } => i as f64 * step_s,
            Self::Times(times) => times[i],
        }
    }

    /// Time from sample `i` to the next, s.
    #[inline]
    pub(crate) fn step(&self, i: usize) -> f64 {
        match self {
            Self::Ending { step_s, steps, end_s } if i == *steps => end_s - i as f64 * step_s,
            Self::Even { step_s, .. } | Self::Ending { step_s, .. } => *step_s,
            Self::Times(times) => times[i + 1] - times[i],
        }
    }

    /// The longest step, s.
    pub(crate) fn longest_step(&self) -> f64 {
        match self {
            Self::Even { step_s, .. } | Self::Ending { step_s, .. } => *step_s,
            Self::Times(times) => {
                times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
            }
        }
    }

    pub(crate) fn check(&self) -> Result<()> {
        match self {
            Self::Even { step_s, .. } => positive("grid.step_s", *step_s),
            Self::Ending { step_s, steps, end_s } => {
                positive("grid.step_s", *step_s)?;
                let over_s = end_s - *steps as f64 * step_s;
                let ok = over_s > 0.0 && over_s < *step_s;
                check("grid.end_s", *end_s, ok, "after the last whole step by less than a step")
            }
            Self::Times(times) => {
                for (i, pair) in times.windows(2).enumerate() {
                    if pair[0] < pair[1] && pair[1].is_finite() {
                        continue; // a fit checks its times at every run: names are made for what is wrong alone
                    }
                    let name = format!("grid.times[{}]", i + 1);
                    finite(&name, pair[1])?;
                    check(&name, pair[1], pair[0] < pair[1], "later than the time before it")?;
                }
                let first = times.first().copied().unwrap_or(f64::NAN);
                let ok = (0.0..f64::INFINITY).contains(&first);
                check("grid.times[0]", first, ok, "finite and not below 0")
            }
        }
    }
}

/// A method that moves a system along a grid.
pub trait Solver: Send + Sync {
    /// Its name in tables.
    fn name(&self) -> String;

    /// The map of one step of `h` on a linear system, R(h A); `None` if the method is stable at
    /// every step.
    fn amplification(&self, _linear: &LinearPart, _h: f64) -> Option<Matrix<MOST>> {
        None
    }

    /// Runs the system from its start over the grid.
    ///
    /// # Errors
    /// A bad grid, a model the method cannot run, a state that is no longer finite, or a work
    /// limit.
    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory>;
}

/// Calls a function that is generic over the length of the augmented state.
macro_rules! with_length {
    ($n:expr, $self:ident.$run:ident($($argument:expr),*)) => {
        match $n {
            5 => $self.$run::<5>($($argument),*),
            6 => $self.$run::<6>($($argument),*),
            7 => $self.$run::<7>($($argument),*),
            8 => $self.$run::<8>($($argument),*),
            9 => $self.$run::<9>($($argument),*),
            10 => $self.$run::<10>($($argument),*),
            _ => $self.$run::<11>($($argument),*),
        }
    };
}
pub(crate) use with_length;

/// The first entries of a full-length array.
pub(crate) fn shorten<const N: usize>(full: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| full[i])
}

#[cfg(test)]
mod tests;
