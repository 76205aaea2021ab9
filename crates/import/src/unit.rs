//! Units of other people's recordings: the known ones, and how they are converted to ours.

use zwidth_store::Signal;
use zwidth_study::{Coordinate, Schema, Study};

/// The quantity that a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    Time,
    Angle,
    AngularVelocity,
    AngularAcceleration,
    Length,
    Velocity,
    Acceleration,
    Mass,
    Force,
    Torque,
    Voltage,
    Counts,
    Bits,
    Stiffness,
    AngularStiffness,
}

use Dimension::{
    Acceleration, Angle, AngularAcceleration, AngularStiffness, AngularVelocity, Bits, Counts,
    Force, Length, Mass, Stiffness, Time, Torque, Velocity, Voltage,
};

/// A unit: its spellings, and the factor to SI.
#[derive(Debug)]
pub(super) struct Unit {
    spellings: &'static [&'static str],
    pub(super) dimension: Dimension,
    pub(super) to_si: f64,
}

const fn unit(spellings: &'static [&'static str], dimension: Dimension, to_si: f64) -> Unit {
    Unit { spellings, dimension, to_si }
}

/// Radians in a degree.
const DEG: f64 = std::f64::consts::PI / 180.0;
/// Radians in a turn.
const TURN: f64 = std::f64::consts::TAU;
/// Newtons in a pound-force (0.45359237 kg at standard gravity).
const LBF: f64 = 4.448_221_615_260_5;
/// Newtons in a kilogram-force (standard gravity).
const KGF: f64 = 9.806_65;
/// Metres in an inch.
const INCH: f64 = 0.0254;
/// Ounces in a pound.
const OUNCES: f64 = 16.0;
/// Seconds in a minute.
const MINUTE: f64 = 60.0;
/// Seconds in a day, as spreadsheets count durations.
const DAY: f64 = 86_400.0;

// Two letters look like µ, the sign of micro and the Greek letter: both are typed.
const UNITS: [Unit; 46] = [
    unit(&["s", "sec"], Time, 1.0),
    unit(&["ms", "msec"], Time, 1e-3),
    unit(&["µs", "μs", "us"], Time, 1e-6),
    unit(&["ns"], Time, 1e-9),
    unit(&["min"], Time, MINUTE),
    unit(&["h", "hr", "hour", "hours"], Time, 60.0 * MINUTE),
    unit(&["d", "day", "days"], Time, DAY),
    unit(&["rad"], Angle, 1.0),
    unit(&["mrad"], Angle, 1e-3),
    // "Grad" is German for degree; a gradian is written gon there.
    unit(&["deg", "°", "degree", "degrees", "Grad"], Angle, DEG),
    unit(&["turn", "rev"], Angle, TURN),
    unit(&["rad/s"], AngularVelocity, 1.0),
    unit(&["deg/s", "°/s", "degrees/s", "Grad/s"], AngularVelocity, DEG),
    unit(&["rpm"], AngularVelocity, TURN / MINUTE),
    unit(&["rad/s²", "rad/s^2", "rad/s2"], AngularAcceleration, 1.0),
    unit(&["deg/s²", "deg/s^2", "deg/s2", "°/s²"], AngularAcceleration, DEG),
    unit(&["m"], Length, 1.0),
    unit(&["cm"], Length, 1e-2),
    unit(&["mm"], Length, 1e-3),
    unit(&["µm", "μm", "um"], Length, 1e-6),
    unit(&["in"], Length, INCH),
    unit(&["m/s"], Velocity, 1.0),
    unit(&["cm/s"], Velocity, 1e-2),
    unit(&["mm/s"], Velocity, 1e-3),
    unit(&["m/s²", "m/s^2", "m/s2"], Acceleration, 1.0),
    unit(&["mm/s²", "mm/s^2", "mm/s2"], Acceleration, 1e-3),
    unit(&["N"], Force, 1.0),
    unit(&["mN"], Force, 1e-3),
    unit(&["kN"], Force, 1e3),
    unit(&["lbf"], Force, LBF),
    unit(&["kgf"], Force, KGF),
    unit(&["gf"], Force, KGF * 1e-3),
    unit(&["N·m", "Nm", "N*m", "N.m", "N m"], Torque, 1.0),
    unit(&["mN·m", "mNm", "mN*m", "mN.m", "mN m"], Torque, 1e-3),
    unit(&["µN·m", "μN·m", "uN·m", "uNm"], Torque, 1e-6),
    unit(&["N·mm", "Nmm", "N*mm"], Torque, 1e-3),
    unit(&["N·cm", "Ncm", "N*cm"], Torque, 1e-2),
    unit(&["oz·in", "oz-in", "oz*in", "ozf·in"], Torque, LBF / OUNCES * INCH),
    unit(&["lbf·in", "lb-in", "lbf*in"], Torque, LBF * INCH),
    unit(&["kgf·cm", "kg·cm", "kgf*cm"], Torque, KGF * 1e-2),
    unit(&["V"], Voltage, 1.0),
    unit(&["mV"], Voltage, 1e-3),
    unit(&["kV"], Voltage, 1e3),
    unit(&["µV", "μV", "uV"], Voltage, 1e-6),
    unit(&["counts", "count"], Counts, 1.0),
    unit(&["bits"], Bits, 1.0),
];

/// Seconds in a year of 365.25 days.
const YEAR: f64 = 365.25 * DAY;
/// Kilograms in a pound (exactly, by the agreement of 1959).
const POUND: f64 = 0.453_592_37;

/// Units of what is known of people; no recording is in them.
const OF_PEOPLE: [Unit; 9] = [
    unit(&["years", "year", "yr", "y"], Time, YEAR),
    unit(&["months", "month", "mo"], Time, YEAR / 12.0),
    unit(&["weeks", "week", "wk"], Time, 7.0 * DAY),
    unit(&["ft", "foot", "feet"], Length, 12.0 * INCH),
    unit(&["kg", "kilogram", "kilograms"], Mass, 1.0),
    unit(&["g", "gram", "grams"], Mass, 1e-3),
    unit(&["lb", "lbs", "pound", "pounds"], Mass, POUND),
    unit(&["st", "stone", "stones"], Mass, 14.0 * POUND),
    unit(&["oz", "ounce", "ounces"], Mass, POUND / OUNCES),
];

/// Units of what a task varies; no recording is in them.
const OF_LEVELS: [Unit; 7] = [
    unit(&["N/rad"], AngularStiffness, 1.0),
    unit(&["N/deg", "N/°"], AngularStiffness, 1.0 / DEG),
    unit(&["N/m"], Stiffness, 1.0),
    unit(&["N/cm"], Stiffness, 1e2),
    unit(&["N/mm"], Stiffness, 1e3),
    unit(&["mN/mm"], Stiffness, 1.0),
    unit(&["kN/m"], Stiffness, 1e3),
];

/// What a level in a unit is multiplied with to be in that of `varies`, a key that ends in its unit such as
/// `stiffness_n_per_mm`; `None` if the one does not become the other.
pub(super) fn factor_of_level(text: &str, varies: &str) -> Option<f64> {
    // As keys are spelled: `N/mm` ends `stiffness_n_per_mm`.
    let spelled = |unit: &str| {
        let small = unit.trim().to_lowercase();
        small
            .replace('/', "_per_")
            .replace('°', "deg")
            .replace(['µ', 'μ'], "u")
            .replace('%', "percent")
    };
    let ends_in = |unit: &str| varies.to_lowercase().ends_with(&format!("_{}", spelled(unit)));
    let all = || OF_LEVELS.iter().chain(&UNITS);
    // The longest unit that the key ends in is its own: N/m, and not m.
    let own = all().flat_map(|unit| unit.spellings.iter().map(move |spelling| (spelling, unit)));
    let own = own.filter(|(spelling, _)| ends_in(spelling));
    let own = own.max_by_key(|(spelling, _)| spelled(spelling).len());
    let Some((spelling, own)) = own else {
        // A unit that is not known here, such as dB, is the same or another.
        return ends_in(text).then_some(1.0);
    };
    if spelled(spelling) == spelled(text) {
        return Some(1.0);
    }
    let unit =
        all().find(|unit| unit.spellings.contains(&text.trim())).or_else(|| declared(text))?;
    (unit.dimension == own.dimension).then(|| unit.to_si / own.to_si)
}

/// The unit of a number of people, as people spell units.
pub(super) fn of_people(text: &str) -> Option<&'static Unit> {
    let small = text.trim().to_lowercase();
    OF_PEOPLE.iter().find(|unit| unit.spellings.contains(&&*small)).or_else(|| declared(text))
}

/// The first spelling of every unit that a number of people in `dimension`, or in any, may have.
pub(super) fn choices_of_people(dimension: Option<Dimension>) -> String {
    let all = OF_PEOPLE.iter().chain(&UNITS);
    let fitting = all.filter(|unit| dimension.is_none_or(|own| own == unit.dimension));
    fitting.map(|unit| unit.spellings[0]).collect::<Vec<_>>().join(", ")
}

/// The unit of that spelling, where it is one we know.
pub(super) fn find(text: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|u| u.spellings.contains(&text))
}

/// Units in words, as files and people name them; each also with an s at its end.
const WORDS: [(&str, &str); 22] = [
    ("second", "s"),
    ("millisecond", "ms"),
    ("microsecond", "us"),
    ("nanosecond", "ns"),
    ("minute", "min"),
    ("radian", "rad"),
    ("degree", "deg"),
    ("revolution", "rev"),
    ("metre", "m"),
    ("centimetre", "cm"),
    ("millimetre", "mm"),
    ("micrometre", "um"),
    ("inch", "in"),
    ("inche", "in"),
    ("newton", "N"),
    ("millinewton", "mN"),
    ("kilonewton", "kN"),
    ("newton metre", "N·m"),
    ("volt", "V"),
    ("millivolt", "mV"),
    ("microvolt", "uV"),
    ("kilovolt", "kV"),
];

/// The spelling of the unit of this name: `Newtons` is N.
pub(super) fn word_of(name: &str) -> Option<&'static str> {
    // Americans write the metre with the other ending.
    let small = name.trim().to_lowercase().replace("meter", "metre").replace('-', " ");
    let singular = small.strip_suffix('s').filter(|_| small.len() > 2).unwrap_or(&small);
    WORDS
        .iter()
        .find(|(word, _)| *word == singular || *word == small)
        .map(|(_, spelling)| *spelling)
}

/// The unit that a file names, as people spell units: `N`, `newtons`, `Volts`.
pub(super) fn declared(text: &str) -> Option<&'static Unit> {
    let small = text.trim().to_lowercase();
    // Case matters where a letter is all that parts two units: mN is no MN.
    find(text.trim())
        .or_else(|| find(word_of(text)?))
        .or_else(|| find(&small).filter(|unit| unit.dimension != Force && small.len() > 2))
}

/// The spelling of the one unit of `signal` that is written so in other letters: `mn` of a force is
/// mN.
pub(super) fn find_in_any_case(text: &str, signal: Signal) -> Option<&'static str> {
    let spelled = UNITS.iter().filter(|unit| may_become(unit, signal)).flat_map(|u| u.spellings);
    let mut same = spelled.filter(|spelling| spelling.to_lowercase() == text.to_lowercase());
    // Of two that differ only by case nobody knows which is meant.
    same.next().copied().filter(|_| same.next().is_none())
}

/// The first spelling of every unit that can become `signal`, for error messages.
pub(super) fn choices(signal: Signal) -> String {
    let fitting = UNITS.iter().filter(|u| may_become(u, signal));
    fitting.map(|u| u.spellings[0]).collect::<Vec<_>>().join(", ")
}

/// The dimension of a signal of ours.
pub(super) fn dimension(signal: Signal) -> Option<Dimension> {
    find(signal.column().unit).map(|u| u.dimension)
}

/// Whether `unit` can become `signal` in some study.
pub(super) fn may_become(unit: &Unit, signal: Signal) -> bool {
    let Some(target) = dimension(signal) else { return false };
    match (unit.dimension, target) {
        // By a linear coordinate x = L θ.
        (Length, Angle) | (Velocity, AngularVelocity) | (Acceleration, AngularAcceleration) => true,
        // By a lever, which the axes of space do not have.
        (Torque, Force) => signal.schema() < Schema::Three,
        (own, target) => own == target,
    }
}

/// The factor that turns a value in `unit` into `signal`'s SI unit, and the length that was used.
///
/// Lengths become angles by the linear coordinate θ = x / L; a torque becomes a force by the lever,
/// F = τ / L. `Err` says what the study lacks.
pub(super) fn factor(
    unit: &Unit,
    signal: Signal,
    study: &Study,
) -> Result<(f64, Option<f64>), &'static str> {
    if dimension(signal) == Some(unit.dimension) {
        return Ok((unit.to_si, None));
    }
    let lever_m = match (unit.dimension, study.coordinate) {
        (Torque, _) => study.device.lever_m.ok_or("device.lever_m (F = τ / L)")?,
        (_, Coordinate::Linear { lever_m }) => lever_m,
        (_, Coordinate::Rotational) => return Err("coordinate.kind = \"linear\" (x = L θ)"),
    };
    Ok((unit.to_si / lever_m, Some(lever_m)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_becomes_one_in_the_unit_in_which_its_key_ends() {
        for (text, varies, expect) in [
            ("N/m", "stiffness_n_per_mm", Some(1e-3)),
            ("N/mm", "stiffness_n_per_mm", Some(1.0)),
            ("N/rad", "stiffness_n_per_rad", Some(1.0)),
            ("N/deg", "stiffness_n_per_rad", Some(1.0 / DEG)),
            ("N/m", "stiffness_n_per_rad", None),
            ("mm", "stiffness_n_per_mm", None),
            ("s", "delay_ms", Some(1e3)),
            ("Newton", "force_n", Some(1.0)),
            ("mN", "force_n", Some(1e-3)),
            ("rad", "rest_deg", Some(1.0 / DEG)),
            // Of what nothing renders, the name alone says the unit.
            ("dB", "contrast_db", Some(1.0)),
            ("%", "contrast_percent", Some(1.0)),
            ("dB", "contrast_percent", None),
            ("kg", "contrast_db", None),
        ] {
            let found = factor_of_level(text, varies);
            let is_same = match (found, expect) {
                (Some(found), Some(expect)) => (found / expect - 1.0).abs() < 1e-12,
                (found, expect) => found == expect,
            };
            assert!(is_same, "{text} of {varies}: {found:?}");
        }
    }

    fn check(unit: &str, signal: Signal, expect: f64) {
        let (found, _) = factor(find(unit).unwrap(), signal, &zwidth_testing::study()).unwrap();
        assert!((found / expect - 1.0).abs() < 1e-12, "{unit}: {found}");
    }

    #[test]
    fn every_unit_of_ours_is_known_and_is_si() {
        for signal in Signal::all() {
            check(signal.column().unit, signal, 1.0);
        }
    }

    #[test]
    fn no_spelling_stands_twice() {
        let mut all: Vec<_> = UNITS.iter().chain(&OF_PEOPLE).flat_map(|u| u.spellings).collect();
        let n = all.len();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), n);
    }

    #[test]
    fn units_that_files_name_are_known_by_letter_and_by_word() {
        for (text, unit) in [
            ("N", "N"),
            ("newtons", "N"),
            ("Newton", "N"),
            ("mN", "mN"),
            (" seconds ", "s"),
            ("Milliseconds", "ms"),
            ("microvolts", "uV"),
            ("µV", "uV"),
            ("Volts", "V"),
            ("Degrees", "deg"),
            ("inches", "in"),
            ("Newton meters", "N·m"),
        ] {
            let found = declared(text).unwrap_or_else(|| panic!("{text}"));
            let unit = find(unit).unwrap();
            let same = found.to_si.to_bits() == unit.to_si.to_bits();
            assert!(found.dimension == unit.dimension && same, "{text}");
        }
        for text in ["", "MN", "a.u.", "S", "none", "%"] {
            assert!(declared(text).is_none(), "{text}");
        }
    }

    #[test]
    fn units_become_si() {
        check("deg", Signal::Theta, 0.017_453_292_519_943_295);
        check("rpm", Signal::ThetaDot, 0.104_719_755_119_659_77);
        check("ms", Signal::Time, 1e-3);
        check("oz·in", Signal::TorqueEx, 0.028_349_523_125 * 9.806_65 * 0.0254);
        check("mN·m", Signal::TorqueEx, 1e-3);
    }

    #[test]
    fn what_does_not_fit_does_not_fit_in_any_study() {
        for (unit, signal) in [
            ("mV", Signal::Theta),
            ("N", Signal::TorqueEx),
            ("deg", Signal::ThetaDot),
            ("s", Signal::ForceEx),
            ("counts", Signal::StateBits),
            ("m/s", Signal::Theta),
        ] {
            assert!(!may_become(find(unit).unwrap(), signal), "{unit}");
        }
    }
}
