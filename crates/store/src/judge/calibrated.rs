//! The calibration in a session's record must have the hash beside it.

use crate::{StoreError, hex_blake3};
use serde::Deserialize;
use serde_json::value::RawValue;
use std::path::Path;
use zwidth_study::{Calibration, Characteristic};

/// What of a record says with which calibration it was recorded. Numbers as they are written: the
/// reader of JSON may be off by their last bit.
#[derive(Deserialize)]
struct Calibrated {
    calibration: Option<Written>,
    calibration_blake3: Option<String>,
}

#[derive(Deserialize)]
struct Written {
    motor: Knots,
    brake: Knots,
}

#[derive(Deserialize)]
struct Knots {
    voltage_v: Vec<Box<RawValue>>,
    force_n: Vec<Box<RawValue>>,
}

/// Holds the calibration of a record against its hash, where the record has both.
///
/// # Errors
/// They are not of each other.
pub(crate) fn check_calibration(path: &Path, record: &str) -> Result<(), StoreError> {
    // What is no record is an error of whoever reads it.
    let Ok(Calibrated { calibration: Some(written), calibration_blake3: Some(hash) }) =
        serde_json::from_str(record)
    else {
        return Ok(());
    };
    let calibration = characteristic(&written.motor)
        .zip(characteristic(&written.brake))
        .map(|(motor, brake)| Calibration { motor, brake });
    let text = calibration.and_then(|calibration| calibration.to_toml().ok());
    if text.is_some_and(|text| hex_blake3(text.as_bytes()) == hash) {
        return Ok(());
    }
    let what = "its calibration is not the one whose hash it has: one of them was changed";
    Err(StoreError::new(path, what, "restore the session's record from a copy"))
}

fn characteristic(knots: &Knots) -> Option<Characteristic> {
    let [voltage_v, force_n] = [&knots.voltage_v, &knots.force_n]
        .map(|raw| raw.iter().map(|n| n.get().parse().ok()).collect::<Option<Vec<f64>>>());
    Some(Characteristic { voltage_v: voltage_v?, force_n: force_n? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{SessionRecord, Source};

    fn record(calibration: Calibration) -> SessionRecord {
        let hash = hex_blake3(calibration.to_toml().unwrap().as_bytes());
        let (participant, session) = ("P01".parse().unwrap(), "S01".parse().unwrap());
        SessionRecord {
            calibration: Some(calibration),
            calibration_blake3: Some(hash),
            ..SessionRecord::new(participant, session, Source::Twin, "tests", "", Vec::new())
        }
    }

    fn check(json: &str) -> Result<(), StoreError> {
        check_calibration(Path::new("x.json"), json)
    }

    #[test]
    fn a_calibration_of_any_digits_is_the_one_of_its_hash() {
        let mut calibration = Calibration::thesis();
        let mut x = 0.1_f64;
        for i in 0..1000 {
            x = (x * 1.37 + f64::from(i).sqrt() * 1e-3) % 16.0;
            (calibration.motor.voltage_v[1], calibration.motor.force_n[1]) = (x, x.next_up() / 3.0);
            assert_eq!(check(&record(calibration.clone()).to_json().unwrap()), Ok(()), "{x}");
        }
    }

    #[test]
    fn a_calibration_that_was_changed_and_a_hash_that_was_are_found() {
        let json = record(Calibration::thesis()).to_json().unwrap();
        for (from, to) in [
            ("4.16", "4.17"),
            ("4.16", "\"4.16\""),
            ("\"calibration_blake3\": \"", "\"calibration_blake3\": \"0"),
        ] {
            assert!(json.contains(from));
            let error = check(&json.replacen(from, to, 1)).unwrap_err();
            assert!(error.what.contains("not the one whose hash it has"), "{error}");
        }
        assert_eq!(check("{"), Ok(()), "told by whoever reads it");
    }
}
