//! Words of columns: the names of a recording's columns, and what they mean.

use super::unit::{find, find_in_any_case, may_become};
use zwidth_store::Signal;

/// What columns are called, and what they then are. The words stand in small letters, the first
/// line that has one of a name's words wins.
const NAMES: [(Signal, &[&str]); 7] = [
    (Signal::Time, &["t", "time", "zeit", "timestamp", "elapsed", "seconds", "millis", "temps"]),
    (Signal::ThetaDdot, &["accel", "acceleration", "beschleunigung", "thetaddot", "ddot"]),
    (
        Signal::ThetaDot,
        &["v", "vel", "velocity", "speed", "geschwindigkeit", "omega", "thetadot", "dot"],
    ),
    (Signal::ForceEx, &["f", "fx", "force", "kraft", "fex", "load"]),
    (Signal::TorqueEx, &["torque", "tau", "moment", "drehmoment"]),
    (Signal::Theta, &["theta", "angle", "winkel", "pos", "position", "x", "phi", "encoder", "weg"]),
    (Signal::VoltageMotor, &["voltage", "spannung"]),
];

/// Words of a column that says which trial it is, and the key under `[trial]`.
pub(super) const LABELS: [(&str, &[&str]); 5] = [
    ("participant", &["participant", "subject", "subj", "vp", "proband", "user", "pid"]),
    ("session", &["session", "day", "visit"]),
    ("mode", &["controller", "condition", "mode", "group", "treatment", "regler"]),
    ("repeat", &["repetition", "repeat", "rep", "wdh"]),
    ("trial", &["trial", "run"]),
];
/// Words of a column of answers.
pub(super) const ANSWERS: [&str; 6] =
    ["likert", "rating", "answer", "score", "response", "bewertung"];
/// Words of a column of a winding's current.
pub(super) const CURRENTS: [&str; 3] = ["current", "strom", "courant"];

/// Words of a column that was asked for, not measured.
pub(super) const COMMANDED: [&str; 11] = [
    "desired",
    "commanded",
    "cmd",
    "command",
    "target",
    "set",
    "setpoint",
    "reference",
    "ref",
    "demand",
    "soll",
];

/// Words of a column that names a question.
pub(super) const QUESTIONS: [&str; 5] = ["question", "item", "frage", "tlx", "sus"];

/// A column's name, parsed.
#[derive(Debug, Default)]
pub(super) struct ColumnName {
    /// The words of the name in small letters, without its unit.
    pub(super) words: Vec<String>,
    /// The signal that the words mean.
    pub(super) signal: Option<Signal>,
    /// The unit, as a mapping spells it.
    pub(super) unit: Option<String>,
}

/// The name of a column within groups (`rig/force_n`) or structures (`rig.force_n`), and of one within a
/// variable of Octave's (`t/value`).
fn own_name(name: &str) -> &str {
    let mut parts = name.rsplit(['/', '.']);
    let last = parts.next().unwrap_or(name);
    let own = match last {
        "value" | "values" | "data" | "Data" => parts.next().unwrap_or(last),
        _ => last,
    };
    // A dot may be that of a unit, or of a number.
    let is_path = name.chars().all(|letter| letter.is_alphanumeric() || "_./".contains(letter))
        && own.starts_with(char::is_alphabetic);
    if is_path { own } else { name }
}

/// Parses a name: its words, what they mean, and the unit among them: `Force (mN)` → `force`, `mN`;
/// `velocity_m_s` → `velocity`, `m/s`. Of several units the longest, and of these the last, that
/// fits what the words mean; a unit in other letters (`force_mn`) is one only where it fits.
pub(super) fn parse_name(name: &str) -> ColumnName {
    let name = own_name(name);
    let parts = name.split([' ', '_', '(', ')', '[', ']', ',', ':']);
    let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    // The first part is the quantity, and never a unit.
    let places = (1..=MOST_PARTS).rev().flat_map(|length| {
        (1..(parts.len() + 1).saturating_sub(length)).rev().map(move |begin| (begin, length))
    });
    let parsed = places.flat_map(|(begin, length)| {
        let words = parts.iter().enumerate().filter(|(i, _)| !(begin..begin + length).contains(i));
        let words: Vec<String> = words.map(|(_, part)| part.to_lowercase()).collect();
        let signal = signal_of(&words);
        let spelled: Vec<String> = match &parts[begin..begin + length] {
            [one] => vec![(*one).to_owned()],
            [first, second] => vec![format!("{first}/{second}"), format!("{first} {second}")],
            [first, per, second] if per.eq_ignore_ascii_case("per") => {
                vec![format!("{first}/{second}")]
            }
            _ => Vec::new(),
        };
        let exact = spelled.iter().find(|text| {
            find(text).is_some_and(|unit| signal.is_none_or(|signal| may_become(unit, signal)))
        });
        let unit = exact.cloned().or_else(|| {
            let signal = signal?;
            spelled.iter().find_map(|text| find_in_any_case(text, signal)).map(str::to_owned)
        });
        unit.map(|unit| ColumnName { words, signal, unit: Some(unit) })
    });
    // A unit of no known quantity may be a part of its name: only where nothing else fits.
    let (with_signal, without): (Vec<ColumnName>, Vec<ColumnName>) =
        parsed.partition(|name| name.signal.is_some());
    with_signal.into_iter().chain(without).next().unwrap_or_else(|| {
        // A unit that does not fit is no word of the name either.
        let unit = (1..parts.len()).rev().find(|i| find(parts[*i]).is_some());
        let words = parts.iter().enumerate().filter(|(i, _)| Some(*i) != unit);
        let words: Vec<String> = words.map(|(_, part)| part.to_lowercase()).collect();
        ColumnName { signal: signal_of(&words), words, unit: None }
    })
}

/// Parts of a name that a unit has at most: `m`, `per`, `s`.
const MOST_PARTS: usize = 3;

/// Whether one of a name's words is listed.
pub(super) fn has_word(words: &[String], listed: &[&str]) -> bool {
    words.iter().any(|word| listed.contains(&word.as_str()))
}

/// The signal that a column of these words holds.
pub(super) fn signal_of(words: &[String]) -> Option<Signal> {
    let signal = NAMES.iter().find(|(_, listed)| has_word(words, listed))?.0;
    match (has_word(words, &COMMANDED), signal) {
        (false, signal) => Some(signal),
        (true, Signal::ForceEx) => Some(Signal::ForceCmd),
        (true, _) => None,
    }
}

/// Words beside the axis in the name of a position.
const PLACES: [&str; 16] = [
    "p",
    "pos",
    "position",
    "coord",
    "tip",
    "tcp",
    "hand",
    "tool",
    "instrument",
    "ee",
    "effector",
    "end",
    "stylus",
    "marker",
    "right",
    "left",
];
/// Words beside the axis in the name of a force.
const FORCES: [&str; 6] = ["f", "force", "kraft", "contact", "sensor", "user"];

/// The axis of a position or a force that a column of these words holds, if the file has several of them:
/// `x`, `px`, `pos_x`, `PosX`, `fy`, `force_y`.
pub(super) fn axis_of(words: &[String]) -> Option<Signal> {
    let axes = ["x", "y", "z"];
    let positions = [Signal::X, Signal::Y, Signal::Z];
    let forces = [Signal::ForceX, Signal::ForceY, Signal::ForceZ];
    // An axis is a word of its own, or the last letter of a word that says what it is of.
    let split = words.iter().enumerate().find_map(|(i, word)| {
        let axis = axes.iter().position(|axis| word.ends_with(axis))?;
        let before = &word[..word.len() - 1];
        let is_known = before.is_empty() || PLACES.contains(&before) || FORCES.contains(&before);
        is_known.then_some((i, axis, before))
    });
    let (place, axis, before) = split?;
    let others =
        words.iter().enumerate().filter(|(i, _)| *i != place).map(|(_, word)| word.as_str());
    let rest: Vec<&str> = others.chain(Some(before).filter(|before| !before.is_empty())).collect();
    if rest.iter().any(|word| ["f", "force", "kraft"].contains(word)) {
        return rest
            .iter()
            .all(|word| FORCES.contains(word) || PLACES.contains(word))
            .then(|| forces[axis]);
    }
    rest.iter().all(|word| PLACES.contains(word)).then(|| positions[axis])
}

/// The key under `[trial]` of a label that a column's name says, by its words without the numbers at
/// their ends: `Condition1` is a mode.
pub(super) fn label_of(name: &str) -> Option<&'static str> {
    let lower = name.to_lowercase();
    let words = lower.split(|letter: char| !letter.is_alphabetic()).filter(|word| !word.is_empty());
    let words: Vec<&str> = words.collect();
    let (key, _) =
        LABELS.iter().find(|(_, listed)| words.iter().any(|word| listed.contains(word)))?;
    Some(key)
}

/// Whether columns of these names look like answers: some column is one, and none is a time or
/// what a device measures.
pub(super) fn are_answers(names: &[String]) -> bool {
    let names: Vec<ColumnName> = names.iter().map(|name| parse_name(name)).collect();
    names.iter().any(|name| has_word(&name.words, &ANSWERS) || has_word(&name.words, &QUESTIONS))
        && names.iter().all(|name| matches!(name.signal, None | Some(Signal::Time)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(name: &str, signal: Option<Signal>, unit: Option<&str>) {
        let parsed = parse_name(name);
        assert_eq!((parsed.signal, parsed.unit.as_deref()), (signal, unit), "{name}: {parsed:?}");
    }

    #[test]
    fn a_unit_is_recognised_however_a_name_spells_it() {
        check("time_ms", Some(Signal::Time), Some("ms"));
        check("t_sec", Some(Signal::Time), Some("sec"));
        check("angle_deg", Some(Signal::Theta), Some("deg"));
        check("pos_mm", Some(Signal::Theta), Some("mm"));
        check("force_mN", Some(Signal::ForceEx), Some("mN"));
        check("force_ex_n", Some(Signal::ForceEx), Some("N"));
        check("velocity_m_s", Some(Signal::ThetaDot), Some("m/s"));
        check("velocity_mm_per_s", Some(Signal::ThetaDot), Some("mm/s"));
        check("theta_dot_rad_s", Some(Signal::ThetaDot), Some("rad/s"));
        check("omega_deg_s", Some(Signal::ThetaDot), Some("deg/s"));
        check("accel_m_s2", Some(Signal::ThetaDdot), Some("m/s2"));
        check("torque_N_m", Some(Signal::TorqueEx), Some("N m"));
        check("torque_nm", Some(Signal::TorqueEx), Some("Nm"));
        check("voltage_v", Some(Signal::VoltageMotor), Some("V"));
    }

    #[test]
    fn an_axis_is_known_by_its_letter_and_by_what_it_is_of() {
        for (name, axis) in [
            ("x", Some(Signal::X)),
            ("y_mm", Some(Signal::Y)),
            ("pz", Some(Signal::Z)),
            ("Pos_X (mm)", Some(Signal::X)),
            ("PositionY", Some(Signal::Y)),
            ("tip_z_m", Some(Signal::Z)),
            ("Fx", Some(Signal::ForceX)),
            ("ForceY (N)", Some(Signal::ForceY)),
            ("force_z_lbf", Some(Signal::ForceZ)),
            ("tip force x", Some(Signal::ForceX)),
            ("vx", None),
            ("vel_x", None),
            ("x desired", None),
            ("Tx", None),
            ("torque_z", None),
            ("qx", None),
            ("index", None),
            ("mode", None),
        ] {
            assert_eq!(axis_of(&parse_name(name).words), axis, "{name}");
        }
    }

    #[test]
    fn a_unit_that_does_not_fit_its_quantity_is_none() {
        check("velocity_s", Some(Signal::ThetaDot), None);
        check("force_ms", Some(Signal::ForceEx), None);
        check("grip_N", None, Some("N"));
        check("note", None, None);
        check("", None, None);
    }

    #[test]
    fn answers_are_told_from_recordings_by_their_names() {
        let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        for (name, own) in [
            ("rig/force_n", "force_n"),
            ("rig.t", "t"),
            ("simout.signals.values", "signals"),
            ("t/value", "t"),
            ("F (m.s-1)", "F (m.s-1)"),
            ("v0.1", "v0.1"),
        ] {
            assert_eq!(own_name(name), own);
        }
        assert_eq!(parse_name("rig.t").signal, Some(Signal::Time));
        assert!(are_answers(&names(&["Timestamp", "participant", "rating"])));
        assert!(!are_answers(&names(&["t_s", "theta_rad", "rating"])));
        assert!(!are_answers(&names(&["participant", "age"])));
    }
}
