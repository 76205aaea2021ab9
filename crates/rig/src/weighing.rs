//! The load cell's part of a characterisation: nothing on it, then each known mass in turn.

use crate::cell::{GRAVITY_M_S2, SCALE_ERROR};
use crate::step::{Action, Ask, Remark};
use crate::{Load, LoadCell, Still, load_cell, still};
use zwidth_device::Weighed;

/// A load is looked at for so long, s.
pub(crate) const LOAD_S: f64 = 2.0;

/// Values that come this soon may still be those of the load before, s: they were on their way, or
/// the cell was settling.
const SETTLES_S: f64 = 0.25;

/// The loads so far.
#[derive(Debug, Clone)]
pub(crate) struct Weighing {
    masses_kg: Vec<f64>,
    newtons_per_count: f64,
    zero: Option<Still>,
    loads: Vec<Load>,
    /// Weight and force shown of every value, N.
    values: Vec<[f64; 2]>,
}

impl Weighing {
    pub(crate) fn new(masses_kg: Vec<f64>, newtons_per_count: f64) -> Self {
        Self { masses_kg, newtons_per_count, zero: None, loads: Vec::new(), values: Vec::new() }
    }

    /// From the beginning.
    pub(crate) fn begin(&mut self) -> Vec<Action> {
        self.zero = None;
        self.loads.clear();
        self.values.clear();
        vec![Action::Ask(Ask::Zero)]
    }

    /// Takes the values of the load that was asked for; what is to be done next, and the cell once it
    /// is known. A load that does not count is asked for again, and masses that do not agree from
    /// the beginning.
    pub(crate) fn take(&mut self, values: &[Weighed]) -> (Vec<Action>, Option<LoadCell>) {
        let next_kg = self.masses_kg.get(self.loads.len()).copied().filter(|_| self.zero.is_some());
        let settled: Vec<Weighed> =
            values.iter().copied().filter(|value| value.t_s >= SETTLES_S).collect();
        let seen = match still(&settled) {
            Ok(seen) => seen,
            Err(fault) => {
                let ask = next_kg.map_or(Ask::Zero, Ask::Mass);
                return (vec![Action::Tell(Remark::CellFault(fault)), Action::Ask(ask)], None);
            }
        };
        match next_kg {
            None => self.zero = Some(seen),
            Some(mass_kg) => self.loads.push(Load { mass_kg, seen }),
        }
        let weight_n = next_kg.unwrap_or(0.0) * GRAVITY_M_S2;
        self.values.extend(settled.iter().map(|value| [weight_n, value.force_n]));
        match self.masses_kg.get(self.loads.len()) {
            Some(mass_kg) => (vec![Action::Ask(Ask::Mass(*mass_kg))], None),
            None => self.known(seen),
        }
    }

    fn known(&mut self, last: Still) -> (Vec<Action>, Option<LoadCell>) {
        match load_cell(self.zero.unwrap_or(last), &self.loads, self.newtons_per_count) {
            Ok(cell) => {
                let is_off = (cell.scale - 1.0).abs() > SCALE_ERROR;
                let newtons_per_count = is_off.then_some(self.newtons_per_count / cell.scale);
                let actions = vec![
                    Action::KeepLoads(std::mem::take(&mut self.values)),
                    Action::Tell(Remark::Cell { cell, newtons_per_count }),
                ];
                (actions, Some(cell))
            }
            Err(fault) => {
                let mut actions = vec![Action::Tell(Remark::CellFault(fault))];
                actions.extend(self.begin());
                (actions, None)
            }
        }
    }
}
