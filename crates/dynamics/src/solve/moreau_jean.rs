//! Moreau–Jean time stepping: a θ-method that is implicit in the set-valued forces, so it sticks
//! without chattering at any step and never looks for events.

use zwidth_numerics::expm::Matrix;

use super::fixed;
use super::{Grid, Solver, shorten, with_length};
use crate::error::{DynamicsError, Result, check};
use crate::system::region::{Contact, Motion, Region, Side};
use crate::system::{OMEGA, System};
use crate::trajectory::Trajectory;

/// Moreau–Jean with the grid's step. The law (forward, backward, rest; saturation; zone) is the one
/// that holds at the step's end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoreauJean {
    /// Implicitness in [1/2, 1]: 1/2 is of order 2 while the motion is smooth, 1 damps most.
    pub theta: f64,
}

impl Default for MoreauJean {
    fn default() -> Self {
        Self { theta: 0.5 }
    }
}

impl MoreauJean {
    fn run_n<const N: usize>(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        check("theta", self.theta, (0.5..=1.0).contains(&self.theta), "between 0.5 and 1")?;
        if let Some(term) = system.nonlinear_term() {
            return Err(DynamicsError::NotPiecewiseAffine { term });
        }
        let mut maps: Vec<Map<N>> = Vec::new();
        fixed::run::<N>(system, grid, 1, |reader, z, t, h| {
            let mut inputs = *z;
            reader.read(t + h, &mut inputs);
            *z = step(system, &mut maps, z, &inputs, h, self.theta);
        })
    }
}

impl Solver for MoreauJean {
    fn name(&self) -> String {
        "moreau_jean".to_owned()
    }

    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        with_length!(system.layout.n, self.run_n(system, grid))
    }
}

/// z' = old z + new (inputs of z'), made once for a region and step.
struct Map<const N: usize> {
    region: Region,
    h: f64,
    /// Acts on the old state.
    old: Matrix<N>,
    /// Acts on the new inputs.
    new: Matrix<N>,
}

impl<const N: usize> Map<N> {
    /// (1 − θ h A) z' = (1 + (1 − θ) h A) z, with the inputs of z' given.
    fn new(system: &System, region: &Region, h: f64, theta: f64) -> Self {
        let flow = system.flow(region);
        let dynamic = system.layout.dynamic;
        let a = Matrix::<N>::from_fn(|i, j| if i < dynamic { flow.rows[i].0[j] } else { 0.0 });
        let inner = Matrix::<N>::from_fn(|i, j| if j < dynamic { a.at(i, j) } else { 0.0 });
        let implicit = Matrix::<N>::identity().zip(&inner, |unit, x| unit - theta * h * x);
        // A singular matrix makes the state NaN, which ends the run in an error.
        let inverse = implicit.inverse().unwrap_or(Matrix::<N>::ZERO.map(|_| f64::NAN));
        let explicit = Matrix::<N>::from_fn(|i, j| {
            let unit = if i == j && i < dynamic { 1.0 } else { 0.0 };
            unit + (1.0 - theta) * h * a.at(i, j)
        });
        let inputs = Matrix::<N>::from_fn(|i, j| match (i < dynamic, j < dynamic) {
            (true, false) => theta * h * a.at(i, j),
            (false, false) if i == j => 1.0,
            _ => 0.0,
        });
        Self { region: *region, h, old: inverse.product(&explicit), new: inverse.product(&inputs) }
    }
}

/// Maps kept at a time: more than a scene has regions, and a bound where every step has another
/// length.
const MOST_MAPS: usize = 64;

/// The step whose end agrees with the law it was made with.
fn step<const N: usize>(
    system: &System,
    maps: &mut Vec<Map<N>>,
    z: &[f64; N],
    inputs: &[f64; N],
    h: f64,
    theta: f64,
) -> [f64; N] {
    let dynamic = system.layout.dynamic;
    let new_inputs: [f64; N] = std::array::from_fn(|i| if i < dynamic { 0.0 } else { inputs[i] });
    let mut attempt = |region: &Region| {
        let at =
            maps.iter().position(|map| map.region == *region && map.h.to_bits() == h.to_bits());
        let at = at.unwrap_or_else(|| {
            if maps.len() == MOST_MAPS {
                maps.clear();
            }
            maps.push(Map::new(system, region, h, theta));
            maps.len() - 1
        });
        let old = maps[at].old.apply(z);
        let new = maps[at].new.apply(&new_inputs);
        std::array::from_fn(|i| old[i] + new[i])
    };
    // The region the old state would be in with the new inputs.
    let state: [f64; N] = std::array::from_fn(|i| if i < dynamic { z[i] } else { inputs[i] });
    let ahead = system.settle(&state, system.direct_region(z).contact, None);
    for &side in sides(system, z, &ahead) {
        let end = settle(system, side, ahead.contact, z, &mut attempt);
        let turns = z[OMEGA] * side.sign() < 0.0;
        if end[OMEGA] * side.sign() > 0.0 && !(turns && is_held(system, &state, ahead.contact)) {
            return end;
        }
    }
    // No side agrees with the motion at its own end: the set-valued forces bring the lever to rest.
    let mut held = *z;
    held[OMEGA] = 0.0;
    let rest = Region { motion: Motion::Rest, ..system.rest_region(ahead.contact, None, &held) };
    let mut end: [f64; N] = attempt(&rest);
    end[OMEGA] = 0.0;
    end
}

/// Whether static friction above the kinetic one holds a lever that is about to turn: for an
/// instant it is at rest.
fn is_held<const N: usize>(system: &System, state: &[f64; N], contact: Contact) -> bool {
    if system.scene.friction.is_none_or(|friction| friction.static_n <= friction.kinetic_n) {
        return false;
    }
    let mut still = *state;
    still[OMEGA] = 0.0;
    system.settle(&still, contact, None).motion == Motion::Rest
}

/// The sides to which the lever may move: on as it moves, or back unless the let-go rule keeps the
/// brake on; from rest, where the forces let it.
fn sides<const N: usize>(system: &System, z: &[f64; N], ahead: &Region) -> &'static [Side] {
    let kept = system.let_go_n().is_some_and(|threshold| z[system.layout.force] >= threshold);
    match ahead.motion {
        Motion::Rest => &[],
        Motion::Forward if z[OMEGA] == 0.0 || kept => &[Side::Up],
        Motion::Backward if z[OMEGA] == 0.0 => &[Side::Down],
        Motion::Forward => &[Side::Up, Side::Down],
        Motion::Backward => &[Side::Down, Side::Up],
    }
}

/// The step for motion to a side, with saturation and zone as they are at its end.
fn settle<const N: usize>(
    system: &System,
    side: Side,
    contact: Contact,
    z: &[f64; N],
    attempt: &mut impl FnMut(&Region) -> [f64; N],
) -> [f64; N] {
    /// Saturation and zone rarely change twice in one step.
    const MOST: usize = 4;
    let mut region = system.moving_region(side, contact, &shorten::<N>(z));
    let mut end = attempt(&region);
    for _ in 0..MOST {
        let now = system.moving_region(side, contact, &end);
        if now == region {
            break;
        }
        region = now;
        end = attempt(&region);
    }
    end
}
