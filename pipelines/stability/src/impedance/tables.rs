//! The Z-width as tables.

use super::frequency::{Response, ResponsePoint};
use super::region::{Bound, Region};
use zwidth_tables::{Column, Table, TableError};

/// One row per mode, push and damping: the stiffest wall with its interval.
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

/// One row per mode and push: area, K_max(0), the largest K.
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

/// One row per condition (environment, mode) and frequency: the impedance with its interval, and
/// coherence.
///
/// # Errors
/// None that responses can cause.
pub fn responses_table(
    name: &str,
    responses: &[([String; 2], Response)],
) -> Result<Table, TableError> {
    type Row<'a> = (&'a [String; 2], &'a Response, &'a ResponsePoint);
    let rows: Vec<Row> = responses
        .iter()
        .flat_map(|(of, all)| all.points.iter().map(move |point| (of, all, point)))
        .collect();
    let text = |name, about, at: usize| {
        Column::text(name, about, rows.iter().map(|row| Some(row.0[at].clone())))
    };
    let float = |name, unit, about, get: &dyn Fn(&Row) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(get))
    };
    let columns = vec![
        text("environment", "what was rendered", 0),
        text("mode", "how it was rendered", 1),
        float("frequency_hz", "Hz", "frequency", &|r| Some(r.2.frequency_hz)),
        float("magnitude_ns_per_m", "N s/m", "size of the impedance F/v", &|r| {
            Some(r.2.magnitude())
        }),
        float("ci_low", "N s/m", "lower end of its interval", &|r| r.2.interval().map(|i| i[0])),
        float("ci_high", "N s/m", "upper end", &|r| r.2.interval().map(|i| i[1])),
        float(
            "phase_rad",
            "rad",
            "its phase: a mass has a quarter turn, a spring minus that",
            &|r| Some(r.2.phase_rad()),
        ),
        float("phase_half_interval_rad", "rad", "half of the phase's interval", &|r| {
            r.2.half_interval
        }),
        float("real_ns_per_m", "N s/m", "real part: damping", &|r| Some(r.2.impedance_ns_per_m[0])),
        float("imaginary_ns_per_m", "N s/m", "imaginary part: mass less stiffness", &|r| {
            Some(r.2.impedance_ns_per_m[1])
        }),
        float(
            "coherence",
            "1",
            "share of the force that follows linearly from the velocity",
            &|r| Some(r.2.coherence),
        ),
        float(
            "chance",
            "1",
            "coherence that chance alone stays below, at the intervals' level",
            &|r| Some(r.1.chance),
        ),
        float("velocity_density", "(m/s)²/Hz", "spectral density of the velocity", &|r| {
            Some(r.2.velocity_density)
        }),
        float("force_density", "N²/Hz", "of the force", &|r| Some(r.2.force_density)),
        float("averages", "1", "independent segments", &|r| Some(r.1.averages)),
        Column::integer(
            "segments",
            "1",
            "segments, which overlap by half",
            rows.iter().map(|r| Some(r.1.segments as i64)),
        ),
        Column::integer(
            "segment_samples",
            "1",
            "samples of a segment",
            rows.iter().map(|r| Some(r.1.length as i64)),
        ),
        float("rate_hz", "Hz", "rate of the samples: the force sensor's", &|r| Some(r.1.rate_hz)),
    ];
    Table::new(name, "Impedance against frequency", columns)
}
