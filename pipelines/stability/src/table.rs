//! The stage's rows, and their tables.

use crate::curves::Curve;
use crate::map::Map;
use crate::others::Boundary;
use zwidth_results::{BoundaryExtent, LimitPoint, Row, StiffestWall, WallCell};
use zwidth_tables::{Table, TableError};

const MODEL: &str = "Model runs, not measurements.";

/// One row per cell of a map: its place, and how far each limit is exceeded (above 1).
pub fn cells(map: &Map) -> Vec<WallCell> {
    let x = map.x;
    let y = map.y;
    let rows = map.cells.iter().enumerate().map(|(number, cell)| {
        let [
            lifted_map,
            passivity,
            rk4_per_step,
            symplectic_euler,
            colgate_schenkel,
            hulin,
            abbott_okamura,
            diolaiti,
        ] = *cell;
        WallCell {
            x: x.at(x.share(number % x.cells)),
            y: y.at(y.share(number / x.cells)),
            lifted_map,
            passivity,
            rk4_per_step,
            symplectic_euler,
            colgate_schenkel,
            hulin,
            abbott_okamura,
            diolaiti,
        }
    });
    rows.collect()
}

/// The table of [`cells`]: the places are called after the quantities that run along the axes.
///
/// # Errors
/// None that a map can cause.
pub fn cells_table(map: &Map) -> Result<Table, TableError> {
    let quantities = [map.x.quantity, map.y.quantity];
    let mut columns = WallCell::columns(&cells(map));
    for (column, quantity) in columns.iter_mut().zip(quantities) {
        column.field.name = quantity.as_str().into();
        column.field.unit = quantity.si_unit().into();
    }
    let [x, y] = quantities.map(|quantity| quantity.as_str());
    Ok(Table::new(WallCell::NAME, &format!("{y} against {x}"), columns)?.with_note(MODEL))
}

/// One row per point of every limit of a map.
pub fn limit_points(map: &Map, curves: &[Curve]) -> Vec<LimitPoint> {
    let mut rows = Vec::new();
    for curve in curves {
        for (piece, points) in curve.pieces.iter().enumerate() {
            rows.extend(points.iter().map(|[x, y]| LimitPoint {
                x_quantity: map.x.quantity,
                y_quantity: map.y.quantity,
                limit: curve.limit.clone(),
                kind: curve.kind,
                piece,
                x: *x,
                y: *y,
            }));
        }
    }
    rows
}

/// The table of [`limit_points`].
///
/// # Errors
/// None that curves can cause.
pub fn curves_table(rows: &[LimitPoint]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?.with_note(MODEL))
}

/// The table of [`crate::limits`].
///
/// # Errors
/// None that limits can cause.
pub fn limits_table(rows: &[StiffestWall]) -> Result<Table, TableError> {
    let table = Table::of_rows(rows)?.with_note(MODEL);
    Ok(table.with_note("Formulas of textbooks are approximations."))
}

/// The extent of a boundary that others measured.
pub fn extent(name: &str, boundary: &Boundary) -> BoundaryExtent {
    let extent = boundary.extent();
    let [damping_from, damping_to] = extent.damping;
    BoundaryExtent {
        boundary: name.to_owned(),
        stiffness_undamped: extent.undamped,
        stiffness_largest: extent.largest,
        damping_of_largest: extent.largest_at,
        damping_from,
        damping_to,
        area: extent.area,
        fullness: extent.fullness(),
        is_si: boundary.is_si,
    }
}

/// The table of each [`extent`].
///
/// # Errors
/// None that extents can cause.
pub fn extents_table(rows: &[BoundaryExtent]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?.with_note(
        "Measured by others. Where is_si says so, in N/m and N s/m at the lever's end; else their files state no \
         units.",
    ))
}
