//! BIDS, its part on motion ("Motion", BIDS 1.10): a dataset in a folder of its own, with three files for
//! each trial.
//!
//! It has no type for a force: forces, voltages and the study's own channels are `MISC`. The lever's angle
//! is `ORNT`, positions `POS`, the time `LATENCY`. Labels have letters and digits only.

use crate::ascii::ascii;
use crate::contents::{Contents, described};
use crate::folder::Folder;
use crate::samples::{about, number, recorded};
use crate::{Asked, ExportError, ExportedTrial};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_store::Signal;
use zwidth_tables::Table;

/// The version of the specification that is followed.
const VERSION: &str = "1.10.0";
/// The system that tracked the motion, and what it tracked.
const SYSTEM: &str = "device";
const POINT: &str = "handle";

pub(crate) fn write(
    folder: &mut Folder,
    contents: &Contents,
    asked: &Asked,
) -> Result<(), ExportError> {
    let labels = Labels::of(contents);
    let description = json!({
        "Name": format!("{}{}", contents.title, contents.mark()),
        "BIDSVersion": VERSION,
        "DatasetType": "raw",
        "License": asked.licence.as_deref().unwrap_or("TODO"),
        "Authors": ["TODO"],
        "GeneratedBy": [{ "Name": "zwidth", "Description": asked.software }],
    });
    folder.json("bids/dataset_description.json", "what the BIDS dataset is", &description)?;
    let readme = format!(
        "{}{}\n\nSamples of the trials of a force-feedback study. Forces are channels of type MISC, in N; the angle of the lever is \
         ORNT, in rad; LATENCY is the time since the trial's start. Tables of trials, metrics and answers lie beside this folder. \
         Source of the numbers: {}.\n",
        contents.title,
        contents.mark(),
        contents.source
    );
    folder.text("bids/README", "what the BIDS dataset holds", &readme)?;
    if let Some(own) = contents.tables.iter().find(|own| own.table.name() == "participants") {
        let tsv = people(&own.table, &labels)?;
        folder.text("bids/participants.tsv", "participants of the BIDS dataset", &tsv)?;
        let columns = described(&own.table).into_iter();
        let columns = columns.map(|column| {
            let mut about = json!({ "Description": column.about });
            // A column with a unit has to hold numbers.
            if column.kind != "string" && column.unit != "1" {
                about["Units"] = json!(ascii(&column.unit));
            }
            (column.name, about)
        });
        let columns: Map<String, Value> = columns.collect();
        folder.json("bids/participants.json", "columns of participants.tsv", &columns.into())?;
    }
    contents.trials.iter().try_for_each(|trial| write_trial(folder, trial, contents, &labels))
}

/// The label of each id.
struct Labels {
    participants: BTreeMap<String, String>,
    sessions: BTreeMap<String, String>,
    environments: BTreeMap<String, String>,
    modes: BTreeMap<String, String>,
}

impl Labels {
    fn of(contents: &Contents) -> Self {
        let of = |id: &dyn Fn(&ExportedTrial) -> String| labels(contents.trials.iter().map(id));
        Self {
            participants: of(&|trial| trial.meta.participant.to_string()),
            sessions: of(&|trial| trial.meta.session.to_string()),
            environments: of(&|trial| trial.meta.environment.to_string()),
            modes: of(&|trial| trial.meta.mode.to_string()),
        }
    }
}

/// A label for each id: its letters and digits, with a number behind them if another has the same.
fn labels(ids: impl Iterator<Item = String>) -> BTreeMap<String, String> {
    let mut taken = BTreeSet::new();
    let mut labels = BTreeMap::new();
    for id in ids.collect::<BTreeSet<String>>() {
        let plain: String = id.chars().filter(char::is_ascii_alphanumeric).collect();
        let plain = if plain.is_empty() { "x".to_owned() } else { plain };
        let mut label = plain.clone();
        let mut number = 2;
        // Some disks do not tell capital letters from small ones.
        while !taken.insert(label.to_lowercase()) {
            label = format!("{plain}{number}");
            number += 1;
        }
        labels.insert(id, label);
    }
    labels
}

fn people(table: &Table, labels: &Labels) -> Result<String, ExportError> {
    let own = table.words("participant")?.map(Option::unwrap_or_default);
    let ids = own.map(|id| labels.participants.get(id).map(|label| format!("sub-{label}")));
    let ids: Vec<Option<String>> = ids.collect();
    let names: Vec<&str> = table.fields().map(|field| field.name.as_ref()).collect();
    let mut tsv = format!("participant_id\t{}\n", names.join("\t"));
    for (row, id) in ids.iter().enumerate() {
        // Who has answers alone is in no file of the dataset.
        let Some(id) = id else { continue };
        let cells = table.columns().iter().map(|column| match &column.values {
            zwidth_results::Values::Text(v) => v[row].as_deref().map(str::to_owned),
            zwidth_results::Values::Float(v) => v[row].map(number),
            zwidth_results::Values::Integer(v) => v[row].map(|v| v.to_string()),
            zwidth_results::Values::Flag(v) => v[row].map(|v| v.to_string()),
        });
        let cells: Vec<String> =
            cells.map(|cell| cell.unwrap_or_else(|| "n/a".to_owned())).collect();
        tsv += &format!("{id}\t{}\n", cells.join("\t"));
    }
    Ok(tsv)
}

fn write_trial(
    folder: &mut Folder,
    trial: &ExportedTrial,
    contents: &Contents,
    labels: &Labels,
) -> Result<(), ExportError> {
    let of =
        |labels: &BTreeMap<String, String>, id: &str| labels.get(id).cloned().unwrap_or_default();
    let subject = of(&labels.participants, trial.meta.participant.as_str());
    let session = of(&labels.sessions, trial.meta.session.as_str());
    let task = of(&labels.environments, trial.meta.environment.as_str());
    let mode = of(&labels.modes, trial.meta.mode.as_str());
    let stem = format!(
        "bids/sub-{subject}/ses-{session}/motion/sub-{subject}_ses-{session}_task-{task}_tracksys-{SYSTEM}_acq-{mode}_run-{:03}",
        trial.meta.trial
    );
    // Read once for its three files; nothing is read where files are only listed.
    let read = if folder.is_listed() { None } else { Some(trial.read()?.samples) };
    let samples = read.unwrap_or_default();
    let columns: Vec<_> = recorded(&samples, contents).collect();
    folder.write(&format!("{stem}_motion.tsv"), "samples of a trial, as BIDS", |out| {
        for row in 0..samples.len() {
            let cells = columns.iter().map(|(_, _, values)| number(values[row]));
            writeln!(out, "{}", cells.collect::<Vec<_>>().join("\t"))?;
        }
        Ok(())
    })?;
    let mut channels = "name\tcomponent\ttype\ttracked_point\tunits\n".to_owned();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (name, unit, _) in &columns {
        let (kind, component) = role(name);
        *counts.entry(kind).or_default() += 1;
        channels += &format!("{name}\t{component}\t{kind}\t{POINT}\t{}\n", ascii(unit));
    }
    folder.text(&format!("{stem}_channels.tsv"), "columns of a trial, as BIDS", &channels)?;
    let t_s = samples.get(Signal::Time).unwrap_or_default();
    let lasted_s = t_s.last().zip(t_s.first()).map_or(0.0, |(last, first)| last - first);
    let rate_hz = if lasted_s > 0.0 { (t_s.len() - 1) as f64 / lasted_s } else { 0.0 };
    let mut said = Map::from_iter([
        ("TaskName".to_owned(), json!(task)),
        ("SamplingFrequency".to_owned(), json!(rate_hz)),
        ("SamplingFrequencyEffective".to_owned(), json!(rate_hz)),
        ("TrackingSystemName".to_owned(), json!(SYSTEM)),
        ("RecordingDuration".to_owned(), json!(lasted_s)),
        ("MotionChannelCount".to_owned(), json!(columns.len())),
        ("TrackedPointsCount".to_owned(), json!(1)),
    ]);
    said.extend(counts.into_iter().map(|(kind, n)| (format!("{kind}ChannelCount"), json!(n))));
    said.insert(
        "Zwidth".to_owned(),
        about(trial).into_iter().map(|(key, value)| (key.to_owned(), json!(value))).collect(),
    );
    folder.json(&format!("{stem}_motion.json"), "what a trial is, as BIDS", &said.into())
}

/// What a column is in BIDS: its type and its component.
fn role(column: &str) -> (&'static str, &'static str) {
    match Signal::from_name(column) {
        Some(Signal::Time) => ("LATENCY", "n/a"),
        Some(Signal::Theta) => ("ORNT", "x"),
        Some(Signal::ThetaDot) => ("VEL", "x"),
        Some(Signal::ThetaDdot) => ("ANGACCEL", "x"),
        Some(Signal::X) => ("POS", "x"),
        Some(Signal::Y) => ("POS", "y"),
        Some(Signal::Z) => ("POS", "z"),
        _ => ("MISC", "n/a"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_letters_and_digits_and_no_two_ids_share_one() {
        let ids = ["P_1", "P1", "p-1", "__"].map(str::to_owned);
        let labels = labels(ids.into_iter());
        let found: Vec<&str> = labels.values().map(String::as_str).collect();
        assert_eq!(labels.keys().collect::<Vec<_>>(), ["P1", "P_1", "__", "p-1"]);
        assert_eq!(found, ["P1", "P12", "x", "p13"]);
    }
}
