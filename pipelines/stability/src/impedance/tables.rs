//! The Z-width as rows, and its tables.

use super::frequency::Response;
use super::region::Region;
use zwidth_results::{ImpedancePoint, WallBound, ZWidth};
use zwidth_tables::{Table, TableError};

/// One row per mode, push and damping: the stiffest wall with its interval.
pub fn bounds(regions: &[Region]) -> Vec<WallBound> {
    regions.iter().flat_map(|region| region.bounds.iter().cloned()).collect()
}

/// One row per mode and push: area, K_max(0), the largest K.
pub fn z_widths(regions: &[Region]) -> Vec<ZWidth> {
    let rows = regions.iter().map(|region| {
        let [area, area_low, area_high] = region.area();
        ZWidth {
            mode: region.mode.as_str().into(),
            push_m: region.push_m,
            stiffness_undamped_n_per_m: region.undamped().map(|bound| bound.stiffness_n_per_m),
            stiffness_largest_n_per_m: region.stiffest().map(|bound| bound.stiffness_n_per_m),
            damping_of_largest_ns_per_m: region.stiffest().map(|bound| bound.damping_ns_per_m),
            damping_end_ns_per_m: region.end_ns_per_m(),
            area_n2_s_per_m2: area,
            area_low_n2_s_per_m2: area_low,
            area_high_n2_s_per_m2: area_high,
            is_censored: region.is_censored(),
        }
    });
    rows.collect()
}

/// The table of [`z_widths`].
///
/// # Errors
/// None that regions can cause.
pub fn z_widths_table(rows: &[ZWidth]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?.with_note(
        "Walls without oscillation that goes on; Colgate & Brown (1994) ask for passive ones. Areas compare over the \
         same dampings and push alone.",
    ))
}

/// One row per frequency of a condition: the impedance with its interval, and coherence.
pub fn impedance_points(environment: &str, mode: &str, response: &Response) -> Vec<ImpedancePoint> {
    let points = response.points.iter().map(|point| {
        let [real_ns_per_m, imaginary_ns_per_m] = point.impedance_ns_per_m;
        ImpedancePoint {
            environment: environment.into(),
            mode: mode.into(),
            frequency_hz: point.frequency_hz,
            magnitude_ns_per_m: point.magnitude(),
            ci_low: point.interval().map(|[low, _]| low),
            ci_high: point.interval().map(|[_, high]| high),
            phase_rad: point.phase_rad(),
            phase_half_interval_rad: point.half_interval,
            real_ns_per_m,
            imaginary_ns_per_m,
            coherence: point.coherence,
            chance: response.chance,
            velocity_density: point.velocity_density,
            force_density: point.force_density,
            averages: response.averages,
            segments: response.segments,
            segment_samples: response.length,
            rate_hz: response.rate_hz,
        }
    });
    points.collect()
}
