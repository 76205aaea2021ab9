//! The Z-width as tables.

use super::region::{Bound, Region};
use zwidth_tables::{Column, Table, TableError};

/// A row a mode, push and damping: the stiffest wall with its interval.
///
/// # Errors
/// None that regions can cause.
pub fn bounds_table(name: &str, regions: &[Region]) -> Result<Table, TableError> {
    let rows: Vec<(&Region, &Bound)> =
        regions.iter().flat_map(|region| region.bounds.iter().map(move |b| (region, b))).collect();
    let float = |name, unit, about, get: fn(&(&Region, &Bound)) -> f64| {
        Column::float(name, unit, about, rows.iter().map(|row| Some(get(row))))
    };
    let columns = vec![
        Column::text(
            "mode",
            "which actuators render",
            rows.iter().map(|row| Some(row.0.mode.as_str().to_owned())),
        ),
        float("push_m", "m", "how deep the lever was let go of", |row| row.0.push_m),
        float("damping_ns_per_m", "N s/m", "damping of the wall", |row| row.1.damping_ns_per_m),
        float("stiffness_n_per_m", "N/m", "the stiffest wall that came to rest", |row| {
            row.1.stiffness_n_per_m
        }),
        float("ci_low", "N/m", "stiffest that came to rest in every repeat", |row| {
            row.1.interval_n_per_m[0]
        }),
        float("ci_high", "N/m", "softest that swung in every repeat", |row| {
            row.1.interval_n_per_m[1]
        }),
        Column::flag(
            "is_censored",
            "an actuator saturated before it swung: at least so stiff",
            rows.iter().map(|row| Some(row.1.is_censored)),
        ),
        Column::integer(
            "repeats",
            "1",
            "searches",
            rows.iter().map(|row| Some(row.1.repeats as i64)),
        ),
    ];
    Table::new(name, "Stiffest wall without oscillation", columns)
}

/// A row a mode and push: area, K_max(0), the largest K.
///
/// # Errors
/// None that regions can cause.
pub fn regions_table(name: &str, regions: &[Region]) -> Result<Table, TableError> {
    let float = |name, unit, about, get: fn(&Region) -> Option<f64>| {
        Column::float(name, unit, about, regions.iter().map(get))
    };
    let columns = vec![
        Column::text(
            "mode",
            "which actuators render",
            regions.iter().map(|region| Some(region.mode.as_str().to_owned())),
        ),
        float("push_m", "m", "how deep the lever was let go of", |r| Some(r.push_m)),
        float("stiffness_undamped_n_per_m", "N/m", "stiffest wall without damping", |r| {
            r.undamped().map(|bound| bound.stiffness_n_per_m)
        }),
        float("stiffness_largest_n_per_m", "N/m", "stiffest wall", |r| {
            r.stiffest().map(|bound| bound.stiffness_n_per_m)
        }),
        float("damping_of_largest_ns_per_m", "N s/m", "its damping", |r| {
            r.stiffest().map(|bound| bound.damping_ns_per_m)
        }),
        float("damping_end_ns_per_m", "N s/m", "areas are from 0 to this damping", |r| {
            Some(r.end_ns_per_m())
        }),
        float("area_n2_s_per_m2", "N²·s/m²", "integral of stiffness over damping", |r| {
            Some(r.area()[0])
        }),
        float("area_low_n2_s_per_m2", "N²·s/m²", "of the intervals' lower ends", |r| {
            Some(r.area()[1])
        }),
        float("area_high_n2_s_per_m2", "N²·s/m²", "of their upper ends", |r| Some(r.area()[2])),
        Column::flag(
            "is_censored",
            "areas and stiffnesses are at least so large",
            regions.iter().map(|region| Some(region.is_censored())),
        ),
    ];
    let table = Table::new(name, "Z-width", columns)?;
    Ok(table.with_note(
        "Walls without oscillation that goes on; Colgate & Brown (1994) ask for passive ones. Areas compare over the \
         same dampings and push alone.",
    ))
}
