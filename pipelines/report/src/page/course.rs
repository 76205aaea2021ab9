//! The samples of a condition's trials, bit for bit, as a line of a script that the page loads on request.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use libdeflater::{CompressionLvl, Compressor};
use serde::Serialize;
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Columns of samples by their names, all of one length.
pub type Columns = Vec<(&'static str, Vec<f64>)>;

/// Something that happened in a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// `onset`, `reversal`, `end`, `contact` with the wall, `let_go` of the brake.
    pub kind: &'static str,
    /// When, as the trial's samples count time, s.
    pub t_s: f64,
}

/// One trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Its number.
    pub trial: u32,
    /// Its repeat.
    pub repeat: u32,
    /// How many samples were recorded: of a long trial fewer are shown, among them the extremes of
    /// each short stretch.
    pub recorded: usize,
    /// The samples that are shown.
    pub columns: Columns,
    /// What happened in it, in order.
    pub events: Vec<Event>,
}

/// Columns as the script has them: all in one text, for a browser takes some milliseconds to unpack
/// one, whatever its length.
#[derive(Serialize)]
struct Packed {
    n: usize,
    columns: Vec<&'static str>,
    samples: String,
}

#[derive(Serialize)]
struct PackedCourse<'a> {
    trial: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    repeat: Option<u32>,
    /// Where fewer are shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    recorded: Option<usize>,
    #[serde(flatten)]
    samples: Packed,
    #[serde(skip_serializing_if = "<[Event]>::is_empty")]
    events: &'a [Event],
}

#[derive(Serialize)]
struct Condition<'a> {
    trials: Vec<PackedCourse<'a>>,
    means: BTreeMap<&'static str, Packed>,
    replay: BTreeMap<&'static str, PackedCourse<'a>>,
}

/// A script's line for one condition: a call that gives `key` its trials, their means by alignment and
/// the models' runs of one of them.
///
/// # Errors
/// What cannot be packed or written as JSON.
pub fn condition_script(
    key: &str,
    trials: &[Course],
    means: &[(&'static str, Columns)],
    replays: &[(&'static str, u32, Columns)],
) -> std::io::Result<String> {
    let mut condition =
        Condition { trials: Vec::new(), means: BTreeMap::new(), replay: BTreeMap::new() };
    for Course { trial, repeat, recorded, columns, events } in trials {
        let samples = packed(columns)?;
        let repeat = Some(*repeat);
        let recorded = Some(*recorded).filter(|recorded| *recorded > samples.n);
        condition.trials.push(PackedCourse { trial: *trial, repeat, recorded, samples, events });
    }
    for (alignment, columns) in means {
        condition.means.insert(alignment, packed(columns)?);
    }
    for (model, trial, columns) in replays {
        let samples = packed(columns)?;
        let course =
            PackedCourse { trial: *trial, repeat: None, recorded: None, samples, events: &[] };
        condition.replay.insert(model, course);
    }
    let json = serde_json::to_string(&condition)?;
    Ok(format!("zwidthData({}, {json});\n", serde_json::to_string(key)?))
}

fn packed(columns: &Columns) -> std::io::Result<Packed> {
    let n = columns.first().map_or(0, |(_, values)| values.len());
    let samples = pack(columns.iter().map(|(_, values)| values.as_slice()))?;
    Ok(Packed { n, columns: columns.iter().map(|(name, _)| *name).collect(), samples })
}

/// Columns as one text, without loss, one after the other: each number's bits XOR those of the
/// number before, the bytes of one place in the number together; then deflate, base 64. What hardly
/// changes from sample to sample becomes runs of zeros.
pub(super) fn pack<'a>(columns: impl IntoIterator<Item = &'a [f64]>) -> std::io::Result<String> {
    thread_local! {
        // One a thread: each begins with much memory to be cleared. The default level saves 1.4 % more
        // of such planes, in half as much time again.
        static COMPRESSOR: RefCell<Compressor> =
            RefCell::new(Compressor::new(CompressionLvl::new(1).unwrap_or_default()));
    }
    let mut bytes = Vec::new();
    for values in columns {
        let begin = bytes.len();
        bytes.resize(begin + 8 * values.len(), 0);
        let mut before = 0;
        for (i, value) in values.iter().enumerate() {
            let change = value.to_bits() ^ std::mem::replace(&mut before, value.to_bits());
            for (place, byte) in change.to_le_bytes().into_iter().enumerate() {
                bytes[begin + place * values.len() + i] = byte;
            }
        }
    }
    COMPRESSOR.with_borrow_mut(|compressor| deflated(&bytes, compressor))
}

/// Bytes as a browser's `deflate-raw` unpacks them, in base 64.
pub(super) fn deflated(bytes: &[u8], compressor: &mut Compressor) -> std::io::Result<String> {
    let mut packed = vec![0; compressor.deflate_compress_bound(bytes.len())];
    let length = compressor.deflate_compress(bytes, &mut packed).map_err(std::io::Error::other)?;
    Ok(STANDARD.encode(&packed[..length]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::DeflateDecoder;
    use std::io::Read as _;

    fn unpack<const COLUMNS: usize>(text: &str) -> [Vec<f64>; COLUMNS] {
        let mut bytes = Vec::new();
        DeflateDecoder::new(&STANDARD.decode(text).unwrap()[..]).read_to_end(&mut bytes).unwrap();
        let n = bytes.len() / 8 / COLUMNS;
        std::array::from_fn(|column| {
            let bytes = &bytes[8 * n * column..8 * n * (column + 1)];
            let mut before = 0;
            let number = |i: usize| {
                let change: [u8; 8] = std::array::from_fn(|place| bytes[place * n + i]);
                before ^= u64::from_le_bytes(change);
                f64::from_bits(before)
            };
            (0..n).map(number).collect()
        })
    }

    #[test]
    fn what_is_packed_comes_back_bit_for_bit() {
        let values = [0.0, -0.0, 1e-310, f64::NAN, f64::MAX, 0.1, 0.1, -45.0_f64.to_radians()];
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let times: Vec<f64> = (0..values.len()).map(|i| i as f64 * 1e-3).collect();
        let [first, second] = unpack(&pack([&values[..], &times]).unwrap());
        assert_eq!((bits(&first), bits(&second)), (bits(&values), bits(&times)));
        let [none] = unpack(&pack([&[][..]]).unwrap());
        assert!(none.is_empty());
    }

    #[test]
    fn a_slow_motion_takes_less_than_half_of_its_bytes() {
        let values: Vec<f64> = (0..4000).map(|i| f64::from(i / 8) * 0.25).collect();
        assert!(pack([&values[..]]).unwrap().len() < 4000 * 4);
    }

    #[test]
    fn a_script_is_one_call_with_the_condition_and_what_it_has() {
        let columns = vec![("t_s", vec![0.0, 0.5])];
        let events = vec![Event { kind: "onset", t_s: 0.5 }];
        let course = Course {
            trial: 4,
            repeat: 1,
            recorded: columns[0].1.len(),
            columns: columns.clone(),
            events,
        };
        let text =
            condition_script("P01.S01.spring", &[course], &[("onset", columns)], &[]).unwrap();
        let json = text.strip_prefix("zwidthData(\"P01.S01.spring\", ").unwrap();
        let said: serde_json::Value =
            serde_json::from_str(json.trim_end().strip_suffix(");").unwrap()).unwrap();
        let trial = &said["trials"][0];
        assert_eq!((trial["trial"].as_u64(), trial["n"].as_u64()), (Some(4), Some(2)));
        assert_eq!(trial["columns"], serde_json::json!(["t_s"]));
        let [times] = unpack(trial["samples"].as_str().unwrap());
        assert_eq!(times, [0.0, 0.5]);
        assert_eq!(trial["events"][0]["kind"], "onset");
        assert_eq!(said["means"]["onset"]["n"], 2);
        assert_eq!(said["replay"], serde_json::json!({}));
    }
}
