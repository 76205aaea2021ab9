//! The device check as a person would say it: what to do before a step, and what was found.

use zwidth_device::check::Step;
use zwidth_study::Check;

/// What the person must do, and whether the lever will then move by itself: that needs a consent.
pub fn step_words(step: Step) -> (String, bool) {
    let what = match step {
        Step::Rest => "Lever against its lower stop, hands off.".to_owned(),
        Step::Load(mass_kg) => {
            format!("Hang {mass_kg} kg from the load cell so that it pulls towards the wall, and let it hang still.")
        }
        Step::Hand => {
            "Lever against its lower stop. Once this begins, move it all the way to the upper stop and back, within 4 s.".to_owned()
        }
        Step::Actuators => {
            "Lever against its lower stop, hands off: motor and brake are switched on for a moment, and the lever moves.".to_owned()
        }
    };
    (what, step == Step::Actuators)
}

/// A value in the unit that a person would name it in, no finer than one would; the record holds
/// all its digits.
pub fn check_value(check: &Check) -> String {
    let Check { value, unit, .. } = check;
    let size = value.abs();
    match unit.as_str() {
        "s" if (1e-9..1e-3).contains(&size) => format!("{} µs", digits(value * 1e6, 0)),
        "s" if (1e-3..1.0).contains(&size) => format!("{} ms", digits(value * 1e3, 1)),
        "N" if (1e-9..0.1).contains(&size) => format!("{} mN", digits(value * 1e3, 1)),
        "rad" => format!("{}°", digits(value.to_degrees(), 2)),
        "1" if size > 0.0 && size < 1.0 => format!("{} %", digits(value * 100.0, 1)),
        "1" => digits(*value, 2),
        "Hz" => format!("{} Hz", digits(*value, 1)),
        unit => format!("{} {unit}", digits(*value, 2)),
    }
}

/// A number with so many places behind the point at most; one that would be nothing by that keeps
/// its first digit.
fn digits(value: f64, places: usize) -> String {
    const MOST_PLACES: usize = 6;
    // The place of the first digit behind the point; 0 where one stands before it. The cast of what
    // no number has (of 0: without end) is held to the highest.
    let first = (-value.abs().log10()).ceil().max(0.0) as usize;
    let places = if value == 0.0 { 0 } else { places.max(first).min(MOST_PLACES) };
    let text = format!("{value:.places$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_of_the_device_check_is_told_in_the_unit_that_a_person_would_name() {
        for (value_si, unit, words) in [
            (9.472e-6, "s", "9 µs"),
            (2e-7, "s", "0.2 µs"),
            (0.0123, "s", "12.3 ms"),
            (2.5, "s", "2.5 s"),
            (993.0001, "Hz", "993 Hz"),
            (1.5034e-4, "N", "0.2 mN"),
            (0.5, "N", "0.5 N"),
            (1.2901, "rad", "73.92°"),
            (1e-5, "rad", "0.0006°"),
            (0.0, "rad", "0°"),
            (0.007, "1", "0.7 %"),
            (972.0, "1", "972"),
            (0.0, "1", "0"),
            (1.021, "1", "1.02"),
            (1000.0, "1", "1000"),
            (-0.2, "N", "-0.2 N"),
        ] {
            let check =
                Check { name: String::new(), value: value_si, unit: unit.to_owned(), ok: true };
            assert_eq!(check_value(&check), words, "{value_si} {unit}");
        }
    }
}
