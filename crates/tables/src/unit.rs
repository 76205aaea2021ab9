//! Units as texts: their suffix in a column's name, and their form on a screen.

use zwidth_study::{Coordinate, unit_in_names};

/// Millimetres in a metre, and any other thousandth in a unit.
const MILLI: f64 = 1000.0;

/// Numerators of a stiffness, a damping and a mass: per radian in files, per millimetre of x = L θ
/// in a linear study. A numerator with a torque in it has no such reading and stays per radian.
const PER_ANGLE: [&str; 3] = ["N", "N·s", "N·s²"];

/// Another unit, and what a value must be multiplied by to be in it.
pub(crate) type Conversion = (String, f64);

/// The unit in which people read `unit`, where it is another one. Metres are read in millimetres.
///
/// Rotational: rad… → °…; N/rad stays (the study's own word for stiffness). Linear, with x = L θ:
/// rad… → mm…, factor 1000 L; N/rad → N/mm, factor 1 / (1000 L); so too N·s/rad and N·s²/rad.
pub(crate) fn for_people(unit: &str, coordinate: Coordinate) -> Option<Conversion> {
    let rest = unit.strip_prefix("rad").filter(|rest| rest.is_empty() || rest.starts_with('/'));
    let per_angle = unit.strip_suffix("/rad").filter(|numerator| PER_ANGLE.contains(numerator));
    if unit == "m" {
        return Some(("mm".to_owned(), MILLI));
    }
    match (coordinate, rest, per_angle) {
        (Coordinate::Rotational, Some(rest), _) => Some((format!("°{rest}"), 1_f64.to_degrees())),
        (Coordinate::Linear { lever_m }, Some(rest), _) => {
            Some((format!("mm{rest}"), MILLI * lever_m))
        }
        (Coordinate::Linear { lever_m }, _, Some(numerator)) => {
            Some((format!("{numerator}/mm"), 1.0 / (MILLI * lever_m)))
        }
        _ => None,
    }
}

/// The unit in which people read `unit`, and what a value is multiplied by to be in it:
/// `("°", 57.3)` for `rad`; `unit` itself and 1 where nothing changes.
pub fn shown_unit(unit: &str, coordinate: Coordinate) -> (String, f64) {
    for_people(unit, coordinate).unwrap_or_else(|| (unit.to_owned(), 1.0))
}

/// N·m as mN·m.
pub(crate) fn small_torque() -> Conversion {
    ("mN·m".to_owned(), MILLI)
}

/// The suffixes by which a name may carry its unit, the longest first; empty for the unit `1`. The
/// product sign may be left out or be an underscore: `N·m·s/rad` is `nms_per_rad` or
/// `nm_s_per_rad`.
pub(crate) fn suffixes(unit: &str) -> Vec<String> {
    if unit == "1" || unit.is_empty() {
        return Vec::new();
    }
    let mut suffixes: Vec<String> = Vec::new();
    for (solidus, dot) in [("_per_", "_"), ("_per_", ""), ("_", "_"), ("_", "")] {
        suffixes.push(format!("_{}", unit_in_names(unit, solidus, dot)));
    }
    // Newton metres are one word in every compound.
    let metres: Vec<String> = suffixes.iter().map(|s| s.replace("_n_m", "_nm")).collect();
    suffixes.extend(metres);
    suffixes.sort_by_key(|s| std::cmp::Reverse(s.len()));
    suffixes.dedup();
    suffixes
}

/// A column's name without its unit, and the suffix that is the unit: `("wall_past_max", "_rad")`.
/// The suffix is empty if the name has no unit.
pub fn split_unit<'a>(name: &'a str, unit: &str) -> (&'a str, &'a str) {
    name.split_at(stem(name, unit).0.len())
}

/// `name` without the suffix of `unit`, and that suffix's place in [`suffixes`]; the whole name
/// if it has no suffix.
pub(crate) fn stem<'a>(name: &'a str, unit: &str) -> (&'a str, Option<usize>) {
    let suffixes = suffixes(unit);
    let stem = |i: usize| Some((name.strip_suffix(suffixes[i].as_str())?, Some(i)));
    (0..suffixes.len()).find_map(stem).unwrap_or((name, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_split_before_its_unit() {
        assert_eq!(split_unit("stiffness_n_per_rad", "N/rad"), ("stiffness", "_n_per_rad"));
        assert_eq!(split_unit("wall_past_max_rad", "rad"), ("wall_past_max", "_rad"));
        assert_eq!(split_unit("returned_energy_share", "1"), ("returned_energy_share", ""));
        assert_eq!(split_unit("force", "N"), ("force", ""));
    }

    #[test]
    fn a_name_ends_in_its_unit() {
        for (name, unit, expect) in [
            ("theta_max_rad", "rad", "theta_max"),
            ("theta_dot_rad_s", "rad/s", "theta_dot"),
            ("theta_ddot_rad_s2", "rad/s²", "theta_ddot"),
            ("slope_std_error_n_per_rad", "N/rad", "slope_std_error"),
            ("damping_ns_per_rad", "N·s/rad", "damping"),
            ("torque_ex_nm", "N·m", "torque_ex"),
            ("inertia_kg_m2", "kg·m²", "inertia"),
            ("damping_std_error_nm_s_per_rad", "N·m·s/rad", "damping_std_error"),
            ("wall_impulse_n_s", "N·s", "wall_impulse"),
            ("x_mm", "mm", "x"),
            ("share_percent", "%", "share"),
            ("r2", "1", "r2"),
            ("command", "V", "command"),
            ("n", "N", "n"),
        ] {
            assert_eq!(stem(name, unit).0, expect, "{name} {unit}");
        }
    }

    #[test]
    fn units_without_an_angle_are_left_alone() {
        for unit in ["1", "N", "J", "s", "N·m", "kg·m²", "radius"] {
            for coordinate in [Coordinate::Rotational, Coordinate::Linear { lever_m: 0.1 }] {
                assert_eq!(for_people(unit, coordinate), None, "{unit}");
            }
        }
        assert_eq!(for_people("N·m/rad", Coordinate::Linear { lever_m: 0.1 }), None);
        assert_eq!(for_people("N/rad", Coordinate::Rotational), None);
    }
}
