//! The limits in sentences.

use zwidth_results::{LimitKind, StiffestWall};
use zwidth_stability::{Boundary, Point};

/// The point, and one line per limit.
pub(super) fn limit_lines(point: &Point, limits: &[StiffestWall]) -> Vec<String> {
    let mut lines = vec![format!("Stiffest wall of a device of {}:", device(point))];
    lines.extend(limits.iter().map(line));
    lines
}

/// What stands under the figure.
pub(super) fn notes(point: &Point) -> Vec<String> {
    vec![
        format!("A device of {}, but for what runs along the axes.", device(point)),
        "Shaded: the wall is stable. Diamond, or dotted line where no wall is given: this device. \
         Black: bilateral linear wall, exact. Points: the same found by simulating the loop. Indigo: passive with any hand. \
         Dashed: textbook formulas, approximations. Thin, solid or dotted: above it a solver's step is unstable on the wall. Where lines lie on each other the last one is seen."
            .to_owned(),
    ]
}

fn device(point: &Point) -> String {
    let wall = &point.wall;
    let mut parts = vec![
        format!("{:.4} kg", wall.mass_kg),
        format!("b {:.3} N s/m", wall.damping_ns_per_m),
        format!("T {:.3} ms", 1e3 * wall.period_s),
        format!("delay {:.3} ms", 1e3 * wall.delay_s),
        format!("B {:.3} N s/m", wall.wall_damping_ns_per_m),
        format!("h {:.3} ms", 1e3 * point.step_s),
    ];
    parts.extend(wall.motor_lag_s.map(|lag| format!("motor lag {:.3} ms", 1e3 * lag)));
    parts.extend(wall.finger.map(|finger| format!("finger {:.1} N/m", finger.stiffness_n_per_m)));
    parts.join(", ")
}

fn line(limit: &StiffestWall) -> String {
    let name = limit.limit.as_str();
    let Some(stiffness) = limit.stiffness_n_per_m else {
        return format!("  {name:<17} says nothing here");
    };
    let error = limit.error_share.filter(|_| limit.kind != LimitKind::Exact);
    let error = error.map_or(String::new(), |error| format!("  {:+.1} %", 100.0 * error));
    let warning = if limit.is_unsafe == Some(true) && limit.kind == LimitKind::Textbook {
        "  UNSAFE: it allows unstable walls"
    } else {
        ""
    };
    format!("  {name:<17} {stiffness:8.1} N/m{error}{warning}  ({})", limit.equation)
}

/// What stands under the figure of boundaries that others measured.
pub(super) fn of_others(are_si: bool) -> &'static str {
    if are_si {
        "Measured by others, without oscillation that goes on; N/m and N s/m at the lever's end."
    } else {
        "Measured by others, without oscillation that goes on. A file states no units: they stand on axes of their own, \
         and beside this device in shares of their ends, which need none."
    }
}

/// The extent of a boundary that others measured.
pub(super) fn extent((name, boundary): &(String, Boundary)) -> String {
    let extent = boundary.extent();
    let undamped = extent.undamped.map_or(String::new(), |k| format!("K(0) {k}, "));
    let fullness = extent.fullness().map_or(String::new(), |share| {
        format!(", {:.1} % of the rectangle of K(0) and B", 100.0 * share)
    });
    let units = if boundary.is_si { "N/m and N s/m" } else { "their units" };
    format!(
        "{name}, measured by others: {undamped}largest K {} at B = {}, area {:.4} over B from {} to {} ({units}){fullness}",
        extent.largest, extent.largest_at, extent.area, extent.damping[0], extent.damping[1]
    )
}
