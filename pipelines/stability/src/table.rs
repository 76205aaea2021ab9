//! The stage's tables.

use crate::curves::{Curve, names};
use crate::error::StabilityError;
use crate::limits::Limit;
use crate::map::{Cell, Map};
use crate::others::Extent;
use zwidth_tables::{Column, Table};

const MODEL: &str = "Model runs, not measurements.";

/// A row a cell of a map: where it is, and how far each limit is passed (above 1).
///
/// # Errors
/// None that a map can cause.
pub fn cells_table(name: &str, map: &Map) -> Result<Table, StabilityError> {
    let (x, y) = (map.x, map.y);
    let at = |number: usize| (number % x.cells, number / x.cells);
    let float = |name: &'static str, about: &'static str, get: &dyn Fn(&Cell) -> Option<f64>| {
        Column::float(name, "1", about, map.cells.iter().map(get))
    };
    let count = map.cells.len();
    let mut columns = vec![
        Column::float(
            x.quantity.as_str(),
            si_unit(&x),
            "place along x",
            (0..count).map(|n| Some(x.at(x.share(at(n).0)))),
        ),
        Column::float(
            y.quantity.as_str(),
            si_unit(&y),
            "place along y",
            (0..count).map(|n| Some(y.at(y.share(at(n).1)))),
        ),
    ];
    for (i, (limit, kind, _)) in names().into_iter().enumerate() {
        let about = match kind {
            "exact" => "spectral radius of the lifted map; stable below 1",
            "passivity" => "damping that passivity asks for over the device's; passive below 1",
            "method" => "growth of a step over the exact flow's; stable up to 1",
            _ => "stiffness over the stiffest by this formula, an approximation",
        };
        columns.push(float(limit, about, &|cell| cell.values()[i]));
    }
    let title = format!("{} against {}", y.quantity.as_str(), x.quantity.as_str());
    Ok(Table::new(name, &title, columns)?.with_note(MODEL))
}

/// The SI unit of an axis.
fn si_unit(span: &crate::map::Span) -> &'static str {
    match span.quantity.unit() {
        "ms" => "s",
        "mm" => "m",
        unit => unit,
    }
}

/// A row a point of every limit of every map.
///
/// # Errors
/// None that curves can cause.
pub fn curves_table(name: &str, maps: &[(&Map, Vec<Curve>)]) -> Result<Table, StabilityError> {
    struct Row<'a>(&'a Map, &'a Curve, usize, [f64; 2]);
    let mut rows = Vec::new();
    for (map, curves) in maps {
        for curve in curves {
            for (piece, points) in curve.pieces.iter().enumerate() {
                rows.extend(points.iter().map(|at| Row(map, curve, piece, *at)));
            }
        }
    }
    let text = |name, about, get: fn(&Row) -> String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let columns = vec![
        text("x_quantity", "what runs along x", |r| r.0.x.quantity.as_str().to_owned()),
        text("y_quantity", "what runs along y", |r| r.0.y.quantity.as_str().to_owned()),
        text("limit", "the limit", |r| r.1.limit.clone()),
        text(
            "kind",
            "exact, passivity, method, textbook, measured or others (their measurement)",
            |r| r.1.kind.to_owned(),
        ),
        Column::integer(
            "piece",
            "1",
            "number of the line, where a limit has several",
            rows.iter().map(|row| Some(row.2 as i64)),
        ),
        Column::float(
            "x",
            "SI",
            "place along x, in its SI unit",
            rows.iter().map(|r| Some(r.3[0])),
        ),
        Column::float(
            "y",
            "SI",
            "place along y, in its SI unit",
            rows.iter().map(|r| Some(r.3[1])),
        ),
    ];
    Ok(Table::new(name, "Limits of a sampled wall", columns)?.with_note(MODEL))
}

/// A row a limit: the stiffest wall, and its error against the exact one.
///
/// # Errors
/// None that limits can cause.
pub fn limits_table(name: &str, limits: &[Limit]) -> Result<Table, StabilityError> {
    let text = |name, about, get: fn(&Limit) -> String| {
        Column::text(name, about, limits.iter().map(|limit| Some(get(limit))))
    };
    let columns = vec![
        text("limit", "the limit", |l| l.limit.clone()),
        text("kind", "exact, passivity, textbook or measured", |l| l.kind.to_owned()),
        text("equation", "what it says", |l| l.equation.clone()),
        text("source", "where it comes from", |l| l.source.clone()),
        Column::float(
            "stiffness_n_per_m",
            "N/m",
            "the stiffest wall that it allows",
            limits.iter().map(|l| l.stiffness_n_per_m),
        ),
        Column::float(
            "error_share",
            "1",
            "its error against the exact one",
            limits.iter().map(|l| l.error_share),
        ),
        Column::flag(
            "is_unsafe",
            "it allows walls that are unstable",
            limits.iter().map(Limit::is_unsafe),
        ),
    ];
    let table = Table::new(name, "The stiffest wall by every limit", columns)?;
    Ok(table.with_note(MODEL).with_note("Formulas of textbooks are approximations."))
}

/// A row a boundary that others measured: its name, whether its units are SI, its extent.
///
/// # Errors
/// None that extents can cause.
pub fn extents_table(
    name: &str,
    extents: &[(String, bool, Extent)],
) -> Result<Table, StabilityError> {
    let float = |name, about, get: fn(&Extent) -> Option<f64>| {
        Column::float(name, "as measured", about, extents.iter().map(|(_, _, extent)| get(extent)))
    };
    let columns = vec![
        Column::text("boundary", "the file", extents.iter().map(|(name, ..)| Some(name.clone()))),
        float("stiffness_undamped", "largest stiffness at no damping", |e| e.undamped),
        float("stiffness_largest", "largest stiffness", |e| Some(e.largest)),
        float("damping_of_largest", "its damping", |e| Some(e.largest_at)),
        float("damping_from", "least damping", |e| Some(e.damping[0])),
        float("damping_to", "most damping", |e| Some(e.damping[1])),
        float("area", "integral of stiffness over damping, by trapezia", |e| Some(e.area)),
        float(
            "fullness",
            "area over that of the rectangle of undamped stiffness and most damping",
            |e| e.fullness(),
        ),
        Column::flag(
            "is_si",
            "whether units are N/m and N s/m",
            extents.iter().map(|(_, is_si, _)| Some(*is_si)),
        ),
    ];
    let table = Table::new(name, "Boundaries measured by others", columns)?;
    Ok(table.with_note(
        "Measured by others. Where is_si says so, in N/m and N s/m at the lever's end; else their files state no \
         units.",
    ))
}
