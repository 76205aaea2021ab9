//! Words of columns: the names of a recording's columns, and what they mean.

use super::unit::{Unit, find, find_in_any_case, may_become};
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

/// What a column's name says.
#[derive(Debug, Default)]
pub(super) struct Said {
    /// The words of the name in small letters, without its unit.
    pub(super) words: Vec<String>,
    /// What a column of these words is.
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

/// The words of a name, what they mean, and the unit among them: `Force (mN)` → `force`, `mN`;
/// `velocity_m_s` → `velocity`, `m/s`. Of several units the longest, and of these the last, that
/// fits what the words mean; a unit in other letters (`force_mn`) is one only where it fits.
pub(super) fn said(name: &str) -> Said {
    let name = own_name(name);
    let parts = name.split([' ', '_', '(', ')', '[', ']', ',', ':']);
    let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    // The first part is the quantity.
    let places = (1..=MOST_PARTS).rev().flat_map(|length| {
        (1..(parts.len() + 1).saturating_sub(length)).rev().map(move |begin| (begin, length))
    });
    let told = places.flat_map(|(begin, length)| {
        let words = parts.iter().enumerate().filter(|(i, _)| !(begin..begin + length).contains(i));
        let words: Vec<String> = words.map(|(_, part)| part.to_lowercase()).collect();
        let signal = signal_of(&words);
        let spelled = spellings(&parts[begin..begin + length]);
        let fits = |unit: &Unit| signal.is_none_or(|signal| may_become(unit, signal));
        let exact = spelled.iter().find(|text| find(text).is_some_and(fits)).cloned();
        let unit = exact.or_else(|| {
            let signal = signal?;
            spelled.iter().find_map(|text| find_in_any_case(text, signal)).map(str::to_owned)
        });
        unit.map(|unit| Said { words, signal, unit: Some(unit) })
    });
    // A unit of no known quantity may be a part of its name: only where nothing else fits.
    let (known, unknown): (Vec<Said>, Vec<Said>) = told.partition(|said| said.signal.is_some());
    known.into_iter().chain(unknown).next().unwrap_or_else(|| without_unit(&parts))
}

/// Parts of a name that a unit has at most: `m`, `per`, `s`.
const MOST_PARTS: usize = 3;

/// How these parts may spell a unit.
fn spellings(parts: &[&str]) -> Vec<String> {
    match parts {
        [one] => vec![(*one).to_owned()],
        [first, second] => vec![format!("{first}/{second}"), format!("{first} {second}")],
        [first, per, second] if per.eq_ignore_ascii_case("per") => {
            vec![format!("{first}/{second}")]
        }
        _ => Vec::new(),
    }
}

/// A name without a unit, or with one that does not fit: that is no word of it either.
fn without_unit(parts: &[&str]) -> Said {
    let unit = (1..parts.len()).rev().find(|i| find(parts[*i]).is_some());
    let words = parts.iter().enumerate().filter(|(i, _)| Some(*i) != unit);
    let words: Vec<String> = words.map(|(_, part)| part.to_lowercase()).collect();
    Said { signal: signal_of(&words), words, unit: None }
}

/// What a column of these words is.
pub(super) fn signal_of(words: &[String]) -> Option<Signal> {
    let is_called = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
    let signal = NAMES.iter().find(|(_, known)| is_called(known))?.0;
    match (is_called(&COMMANDED), signal) {
        (false, signal) => Some(signal),
        (true, Signal::ForceEx) => Some(Signal::ForceCmd),
        (true, _) => None,
    }
}

/// The key under `[trial]` of a label that a column's name says, by its words without the numbers at
/// their ends: `Condition1` is a mode.
pub(super) fn label_of(name: &str) -> Option<&'static str> {
    let lower = name.to_lowercase();
    let words = lower.split(|letter: char| !letter.is_alphabetic()).filter(|word| !word.is_empty());
    let words: Vec<&str> = words.collect();
    let (key, _) =
        LABELS.iter().find(|(_, known)| words.iter().any(|word| known.contains(word)))?;
    Some(key)
}

/// Whether columns of these names look like answers: some column is one, and none is a time or
/// what a device measures.
pub(super) fn are_answers(names: &[String]) -> bool {
    let said: Vec<Said> = names.iter().map(|name| said(name)).collect();
    said.iter().any(|said| {
        said.words
            .iter()
            .any(|word| ANSWERS.contains(&word.as_str()) || QUESTIONS.contains(&word.as_str()))
    }) && said.iter().all(|said| matches!(said.signal, None | Some(Signal::Time)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(name: &str, signal: Option<Signal>, unit: Option<&str>) {
        let said = said(name);
        assert_eq!((said.signal, said.unit.as_deref()), (signal, unit), "{name}: {said:?}");
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
        assert_eq!(said("rig.t").signal, Some(Signal::Time));
        assert!(are_answers(&names(&["Timestamp", "participant", "rating"])));
        assert!(!are_answers(&names(&["t_s", "theta_rad", "rating"])));
        assert!(!are_answers(&names(&["participant", "age"])));
    }
}
