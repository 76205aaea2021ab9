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
            return Err(StabilityError::Refused(format!(
                "an axis cannot show {quantity} from {from} to {to}; give two numbers above 0, the smaller first"
            )));
        }
        let cells = self.cells;
        if !(2..=MOST).contains(&cells) {
            return Err(StabilityError::Refused(format!(
                "a map cannot have {cells} cells per side; take 2 to {MOST}"
            )));
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
///
/// In their order: ρ(A) of the lifted map; the damping that passivity needs, over what the device
/// has; |R(hλ)| of each of [`METHODS`] over the exact flow's growth; K over the stiffest wall by
/// each formula of [`Textbook::ALL`].
pub type Cell = [Option<f64>; 8];

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
            let column: Vec<bool> = (0..self.y.cells)
                .map(|j| self.cells[j * self.x.cells + i][0].is_some_and(|radius| radius < 1.0))
                .collect();
            let mut run = 0;
            let mut from = 0;
            for stretch in column.chunk_by(|a, b| a == b) {
                let next = from + stretch.len();
                if stretch[0] {
                    if run == areas.len() {
                        areas.push(Area {
                            x: (0..self.x.cells).map(|i| self.x.at(self.x.share(i))).collect(),
                            low: vec![f64::NAN; self.x.cells],
                            high: vec![f64::NAN; self.x.cells],
                        });
                    }
                    areas[run].low[i] = self.y.at(self.y.share(from));
                    areas[run].high[i] = self.y.at(self.y.share(next - 1));
                    run += 1;
                }
                from = next;
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
        return Err(StabilityError::Refused(format!(
            "both axes are {}; choose two quantities",
            x.quantity.as_str()
        )));
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
            return [None; 8];
        }
        let own = wall.damping_ns_per_m;
        // Not infinite for a device without damping: tables refuse what is not finite.
        let passivity = wall.damping_for_passivity().map(|needed| (needed / own).min(f64::MAX));
        let [rk4, euler] = [0, 1].map(|i| {
            let solver = self.0.get(i)?;
            wall.step_growth(solver.as_ref(), point.step_s).filter(|x| x.is_finite())
        });
        let [a, b, c, d] = Textbook::ALL.map(|formula| {
            let stiffest = formula.stiffest(wall, point.dry)?;
            Some((wall.stiffness_n_per_m / stiffest).min(f64::MAX))
        });
        let radius = Some(wall.spectral_radius()).filter(|radius| radius.is_finite());
        [radius, passivity, rk4, euler, a, b, c, d]
    }
}
