//! The lifted map: it takes everything that is remembered at one tick to the next tick.
//!
//! x_{k+1} = A x_k on (x, ẋ, x2, ẋ2, motor force; x before, filtered velocity; the commands that
//! have not acted yet). With d whole periods of delay and a rest δ, the plant feels u_{k−d−1} for δ
//! and u_{k−d} for T − δ. Stable if ρ(A) < 1 (Colgate & Schenkel 1997 lift the same loop).

use super::plant::{U, X, flow};
use super::{MOST_DELAY, SampledWall};
use crate::error::{LARGEST, Result};
use zwidth_numerics::expm::{Matrix, spectral_radius};

/// Most entries of a lifted state: the plant's five, two of the velocity, the commands on their
/// way.
const MOST: usize = 5 + 2 + MOST_DELAY + 1;

/// Where each part of a lifted state begins.
struct Places {
    plant: Vec<usize>,
    before: usize,
    filtered: usize,
    waiting: usize,
    entries: usize,
}

impl Places {
    fn of(wall: &SampledWall) -> Self {
        let (whole, rest_s) = wall.delay();
        let plant = wall.entries();
        let before = plant.len();
        // Without damping the controller takes no difference, and remembers no position.
        let differs = wall.wall_damping_ns_per_m.abs() > 0.0;
        let filtered = before + usize::from(differs);
        let waiting = filtered + usize::from(differs && wall.velocity_lag_s.is_some());
        let entries = waiting + whole + usize::from(rest_s > 0.0);
        Self { plant, before, filtered, waiting, entries }
    }
}

impl SampledWall {
    /// ρ(A) of the lifted map, to about 1e-9 of itself; stable if below 1. The wall must have been
    /// checked.
    pub fn spectral_radius(&self) -> f64 {
        let rows = self.lifted();
        // A few lengths that others are filled up to: each is compiled on its own.
        match rows.len() {
            0..=3 => radius::<3>(&rows),
            4 => radius::<4>(&rows),
            5..=6 => radius::<6>(&rows),
            7..=8 => radius::<8>(&rows),
            9..=14 => radius::<14>(&rows),
            _ => radius::<MOST>(&rows),
        }
    }

    /// The stiffness K, N/m, up to which from 0 on the loop is stable, to 1e-10 of itself; 0 if it
    /// is not stable with the softest wall either, none if it is with the stiffest, 1e30.
    ///
    /// # Errors
    /// A parameter that makes no sense.
    pub fn stiffest_stable(&self) -> Result<Option<f64>> {
        self.check()?;
        Ok(stiffest(*self, 1e-10, |wall| wall.spectral_radius() < 1.0))
    }

    /// What the controller commands as a row over the lifted state.
    fn command(&self, places: &Places) -> Vec<f64> {
        let mut row = vec![0.0; places.entries];
        let alpha = self.filter();
        row[0] = self.stiffness_n_per_m;
        if places.filtered > places.before {
            let now = self.wall_damping_ns_per_m * (1.0 - alpha) / self.period_s;
            row[0] += now;
            row[places.before] = -now;
        }
        if places.waiting > places.filtered {
            row[places.filtered] = self.wall_damping_ns_per_m * alpha;
        }
        row
    }

    /// The rows of A, of as many entries as are needed.
    fn lifted(&self) -> Vec<Vec<f64>> {
        let places = Places::of(self);
        let command = self.command(&places);
        let (whole, rest_s) = self.delay();
        let plant = self.plant();
        let n = places.entries;
        let late = flow(plant, self.period_s - rest_s);
        let early = flow(plant, rest_s);
        let whole_flow = late.product(&early);
        let mut rows = vec![vec![0.0; n]; n];
        // Each command that acts within the period: how many ticks old it is, and what it does to
        // each entry of the plant by the period's end.
        let mut acting = vec![(whole, late.columns[U])];
        if rest_s > 0.0 {
            // Held during the early part, and carried on by the late one under another command.
            let gains =
                std::array::from_fn(|i| (0..U).map(|j| late.at(i, j) * early.at(j, U)).sum());
            acting.push((whole + 1, gains));
        }
        for (back, gains) in acting {
            for (row, entry) in rows.iter_mut().zip(&places.plant) {
                match back {
                    0 => row.iter_mut().zip(&command).for_each(|(x, c)| *x += gains[*entry] * c),
                    _ => row[places.waiting + back - 1] += gains[*entry],
                }
            }
        }
        for (i, row) in places.plant.iter().enumerate() {
            for (j, column) in places.plant.iter().enumerate() {
                rows[i][j] += whole_flow.at(*row, *column);
            }
        }
        // What the controller takes along to the next tick.
        if places.filtered > places.before {
            rows[places.before][X] = 1.0;
        }
        if places.waiting > places.filtered {
            let alpha = self.filter();
            let now = (1.0 - alpha) / self.period_s;
            (rows[places.filtered][X], rows[places.filtered][places.before]) = (now, -now);
            rows[places.filtered][places.filtered] = alpha;
        }
        if places.entries > places.waiting {
            rows[places.waiting].copy_from_slice(&command);
        }
        for i in places.waiting + 1..places.entries {
            rows[i][i - 1] = 1.0;
        }
        rows
    }
}

fn radius<const N: usize>(rows: &[Vec<f64>]) -> f64 {
    // Rows and columns of zeros beyond the map's own add eigenvalues of 0 alone.
    spectral_radius(&Matrix::<N>::from_fn(|i, j| {
        rows.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0)
    }))
}

/// The stiffness up to which from 0 on something holds, to a share of itself: raised from a soft
/// wall until it no longer holds, then bisected.
pub(super) fn stiffest(
    wall: SampledWall,
    share: f64,
    holds: impl Fn(&SampledWall) -> bool,
) -> Option<f64> {
    /// The softest wall tried, as a share of (b + m/T)/T: slower than any tick, and stiff enough
    /// that a radius can be distinguished from 1.
    const SOFT: f64 = 1e-5;
    /// From one stiffness to the next on the way up.
    const RAISE: f64 = 1.5;
    let speed = wall.damping_ns_per_m + wall.mass_kg / wall.period_s;
    let mut low = SOFT * speed / wall.period_s;
    if !holds(&wall.with_stiffness(low)) {
        return Some(0.0);
    }
    // In small steps: large ones could pass over a gap and end in a second range that holds.
    let mut high = RAISE * low;
    while holds(&wall.with_stiffness(high)) {
        if high > LARGEST {
            return None;
        }
        (low, high) = (high, RAISE * high);
    }
    while high - low > share * high {
        let middle = 0.5 * (low + high);
        if holds(&wall.with_stiffness(middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}
