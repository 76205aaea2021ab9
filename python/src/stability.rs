//! Which walls a device renders stably.

use crate::calling::{Fault, call};
use crate::scene::Given;
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use zwidth_results::WallQuantity;
use zwidth_stability::{Point, Span, cells_table, limits, limits_table, map, of_scene};

/// T of the thesis' controller, s (Table 3), as `zwidth stability` takes it.
const PERIOD_S: f64 = 0.0083;

/// A map of every limit over two quantities, as `zwidth stability` draws it: a row for each cell, with how far each limit is
/// exceeded there (above 1).
///
/// `scene` has the device and its spring. `x` and `y` are quantities: step, mass, damping, wall_damping, stiffness, lever,
/// finger, delay, rate; `x_ends` and `y_ends` the ends of their axes in SI units. Keyword arguments set quantities of the
/// device: `delay=0.002`, `rate=1000`.
#[pyfunction]
#[pyo3(signature = (scene, x = "wall_damping", y = "stiffness", *, x_ends = None, y_ends = None, cells = 100, **quantities))]
#[expect(clippy::too_many_arguments, reason = "they are keyword arguments of Python")]
pub(crate) fn stability_map(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    x: &str,
    y: &str,
    x_ends: Option<(f64, f64)>,
    y_ends: Option<(f64, f64)>,
    cells: usize,
    quantities: Option<&Bound<'_, PyDict>>,
) -> PyResult<Table> {
    let point = point(scene, quantities)?;
    let axes = [span(x, x_ends, cells)?, span(y, y_ends, cells)?];
    call(py, move |_| {
        let [x, y] = axes;
        let map = map(&point, x, y).map_err(Fault::said)?;
        Table::new(cells_table(&map).map_err(Fault::said)?)
    })
}

/// The stiffest wall that a device renders stably, by every limit, as `zwidth stability` tells it.
///
/// `scene` has the device; keyword arguments set its quantities, as for `stability_map`.
#[pyfunction]
#[pyo3(signature = (scene, **quantities))]
pub(crate) fn stability_limits(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    quantities: Option<&Bound<'_, PyDict>>,
) -> PyResult<Table> {
    let point = point(scene, quantities)?;
    call(py, move |_| {
        let limits = limits(&point).map_err(Fault::said)?;
        Table::new(limits_table(&limits).map_err(Fault::said)?)
    })
}

fn point(scene: &Bound<'_, PyAny>, quantities: Option<&Bound<'_, PyDict>>) -> PyResult<Point> {
    let mut point = of_scene(&Given::new(scene)?.scene()?, PERIOD_S);
    for (name, value) in quantities.into_iter().flatten() {
        let name: String = name.extract()?;
        let value: f64 = value
            .extract()
            .map_err(|_| Fault::new("a quantity is one number", "give a float").in_column(&name))?;
        if !(value.is_finite() && value >= 0.0) {
            let what = format!("{value} is no value of a quantity");
            return Err(Fault::new(what, "give a number from 0 on, in SI units")
                .in_column(name)
                .into());
        }
        point = point.with(quantity(&name)?, value);
    }
    Ok(point)
}

fn quantity(name: &str) -> Result<WallQuantity, Fault> {
    WallQuantity::from_word(name).ok_or_else(|| {
        let names: Vec<&str> = WallQuantity::ALL.iter().map(|quantity| quantity.as_str()).collect();
        Fault::new(
            format!("there is no quantity {name:?}"),
            &format!("choose one of {}", names.join(", ")),
        )
    })
}

fn span(name: &str, ends: Option<(f64, f64)>, cells: usize) -> Result<Span, Fault> {
    let usual = Span::usual(quantity(name)?, cells);
    Ok(Span { ends: ends.map_or(usual.ends, |(from, to)| [from, to]), ..usual })
}
