//! Every limit in every cell of a grid.

use crate::error::StabilityError;
use crate::quantity::Point;
use rayon::prelude::*;
use zwidth_dynamics::{NAMED_SOLVERS, Solver, Textbook};
use zwidth_results::WallQuantity;

/// The solvers whose step has a limit on the wall, one of those that share it.
pub const METHODS: [&str; 2] = ["rk4_per_step", "symplectic_euler"];
/// Most cells per side.
const MOST: usize = 2000;

/// An axis of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// What runs along it.
    pub quantity: WallQuantity,
    /// Its ends, SI.
    pub ends: [f64; 2],
    /// Its cells.
    pub cells: usize,
}

impl Span {
    /// The usual axis of a quantity.
    pub fn usual(quantity: WallQuantity, cells: usize) -> Self {
        Self { quantity, ends: quantity.usual(), cells }
    }

    fn check(&self) -> Result<(), StabilityError> {
        let [from, to] = self.ends;
        let quantity = self.quantity.as_str();
        let least = if self.quantity.is_logarithmic() { f64::MIN_POSITIVE } else { 0.0 };
        if !(from >= least && from < to && to <= 1e30) {
            return Err(StabilityError::Span { quantity, from, to });
        }
        if !(2..=MOST).contains(&self.cells) {
            return Err(StabilityError::Cells { cells: self.cells, most: MOST });
        }
        Ok(())
    }

    /// Where the axis stands at a share of its length.
    pub(crate) fn at(&self, share: f64) -> f64 {
        let [from, to] = self.ends;
        if !self.quantity.is_logarithmic() {
            return from + share * (to - from);
        }
        from * libm::exp(share * libm::log(to / from))
    }

    /// The middle of cell `i` as a share of the axis: the first and the last lie on its ends.
    pub(crate) fn share(&self, i: usize) -> f64 {
        i as f64 / (self.cells - 1) as f64
    }
}

/// The limits at a point; each is passed above 1. None where one says nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// ρ(A) of the lifted map.
    pub radius: Option<f64>,
    /// Damping that passivity needs, over what the device has.
    pub passivity: Option<f64>,
    /// |R(hλ)| of each of [`METHODS`] over the exact flow's growth.
    pub growth: [Option<f64>; 2],
    /// K over the stiffest wall by each formula.
    pub textbook: [Option<f64>; 4],
}

impl Cell {
    /// Each limit's value: exact, passivity, methods, formulas.
    pub(crate) fn values(&self) -> [Option<f64>; 8] {
        let [rk4, euler] = self.growth;
        let [a, b, c, d] = self.textbook;
        [self.radius, self.passivity, rk4, euler, a, b, c, d]
    }
}

/// A grid of cells: row by row, from the lower left.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The point that the quantities are put into.
    pub point: Point,
    /// Along x.
    pub x: Span,
    /// Along y.
    pub y: Span,
    /// `cells[j * x.cells + i]`.
    pub cells: Vec<Cell>,
}

/// An area of a map between two edges over x, SI; NaN where it has a gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Area {
    /// Places along x.
    pub x: Vec<f64>,
    /// The lower edge at each.
    pub low: Vec<f64>,
    /// The upper edge at each.
    pub high: Vec<f64>,
}

impl Map {
    /// Where the wall is stable by the lifted map: an area for the lowest stable cells of each
    /// column, a second one for those of a second run, and so on.
    pub fn stable(&self) -> Vec<Area> {
        let mut areas: Vec<Area> = Vec::new();
        for i in 0..self.x.cells {
            let column: Vec<Option<f64>> =
                (0..self.y.cells).map(|j| self.cells[j * self.x.cells + i].radius).collect();
            let mut run = 0;
            let mut j = 0;
            while j < self.y.cells {
                let from = j;
                while j < self.y.cells && column[j].is_some_and(|radius| radius < 1.0) {
                    j += 1;
                }
                if j == from {
                    j += 1;
                    continue;
                }
                if run == areas.len() {
                    areas.push(Area {
                        x: (0..self.x.cells).map(|i| self.x.at(self.x.share(i))).collect(),
                        low: vec![f64::NAN; self.x.cells],
                        high: vec![f64::NAN; self.x.cells],
                    });
                }
                areas[run].low[i] = self.y.at(self.y.share(from));
                areas[run].high[i] = self.y.at(self.y.share(j - 1));
                run += 1;
            }
        }
        areas
    }
}

/// Looks at every cell. The same bits on any number of threads.
///
/// # Errors
/// An axis that makes no sense, two of one quantity, or a point that makes no sense. A cell that
/// makes none (a delay of more than 25 periods) is empty.
pub fn map(point: &Point, x: Span, y: Span) -> Result<Map, StabilityError> {
    x.check()?;
    y.check()?;
    if x.quantity == y.quantity {
        return Err(StabilityError::SameQuantity { quantity: x.quantity.as_str() });
    }
    point.wall.check()?;
    let methods = Methods::new();
    let cells = (0..x.cells * y.cells).into_par_iter().map(|number| {
        let i = number % x.cells;
        let j = number / x.cells;
        methods.cell(&placed(point, [x, y], [x.share(i), y.share(j)]))
    });
    Ok(Map { point: *point, x, y, cells: cells.collect() })
}

/// The point at shares of both axes.
pub(crate) fn placed(point: &Point, [x, y]: [Span; 2], share: [f64; 2]) -> Point {
    // x before y: another lever length changes stiffnesses and dampings that are put in before it.
    let point = point.with(x.quantity, x.at(share[0]));
    point.with(y.quantity, y.at(share[1]))
}

/// The solvers, ready.
pub(crate) struct Methods(Vec<Box<dyn Solver>>);

impl Methods {
    pub(crate) fn new() -> Self {
        /// For solvers that are given a step, which do not look at it.
        const UNUSED_TOLERANCE: f64 = 1e-9;
        let solvers = METHODS.iter().filter_map(|name| {
            let named = NAMED_SOLVERS.into_iter().find(|solver| solver.name == *name)?;
            Some((named.make)(UNUSED_TOLERANCE))
        });
        Self(solvers.collect())
    }

    pub(crate) fn cell(&self, point: &Point) -> Cell {
        let wall = &point.wall;
        if wall.check().is_err() {
            return Cell { radius: None, passivity: None, growth: [None; 2], textbook: [None; 4] };
        }
        let b = wall.damping_ns_per_m;
        Cell {
            radius: Some(wall.spectral_radius()).filter(|radius| radius.is_finite()),
            // Not infinite for a device without damping: tables refuse what is not finite.
            passivity: wall.damping_for_passivity().map(|needed| (needed / b).min(f64::MAX)),
            growth: [0, 1].map(|i| {
                let solver = self.0.get(i)?;
                wall.step_growth(solver.as_ref(), point.step_s).filter(|x| x.is_finite())
            }),
            textbook: Textbook::ALL.map(|formula| {
                let stiffest = formula.stiffest(wall, point.dry)?;
                Some((wall.stiffness_n_per_m / stiffest).min(f64::MAX))
            }),
        }
    }
}
