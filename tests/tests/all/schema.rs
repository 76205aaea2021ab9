//! A study's schema from the outside: channels of its own.

use crate::binary::{Ran, zwidth, zwidth_line};
use crate::folders::{append, edit};
use std::fs;
use std::path::Path;
use zwidth_store::{Layout, Signal, read_channels, read_trial};
use zwidth_study::ChannelId;
use zwidth_tables::Table;

const CHANNELS: &str = "
[[channels]]
id = \"theta_true_rad\"
unit = \"rad\"
description = \"lever angle without its sensor\"
[[channels]]
id = \"skin_c\"
unit = \"°C\"
description = \"temperature of the finger\"
";

/// A study of 7 trials at 120 Hz, with this text changed and that added.
fn study(root: &Path, from: &str, to: &str, more: &str) -> Layout {
    zwidth(root, &["new", "own"]).exits(0);
    let layout = Layout::new(root, "own".parse().unwrap());
    for (from, to) in [
        (from, to),
        ("\nrepeats = 6\n", "\nrepeats = 1\n"),
        ("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n"),
        ("\nrate_hz = 1000.0\n", "\nrate_hz = 120.0\n"),
    ] {
        edit(&layout.study_toml(), from, to);
    }
    append(&layout.study_toml(), more);
    layout
}

/// Its simulated session.
fn twin(root: &Path) -> Ran {
    zwidth_line(root, "twin own --participants 1 --sessions 1 --seed 1")
}

/// Its metrics.
fn metrics(layout: &Layout) -> Table {
    Table::from_parquet(&layout.derived().join("metrics.parquet")).unwrap()
}

#[test]
fn a_channel_that_the_device_gives_is_recorded_by_its_name_and_another_is_null() {
    let root = tempfile::tempdir().unwrap();
    let layout = study(root.path(), "schema = 2", "schema = 2", CHANNELS);
    twin(root.path()).exits(0);
    let found = zwidth(root.path(), &["verify", "own"]).exits(0);
    assert_eq!(found.out, "own: no findings (schema 2)\n");
    let path = layout.trial(&"P01".parse().unwrap(), &"S01".parse().unwrap(), 2);
    let ids = ["theta_true_rad", "skin_c"].map(|id| ChannelId::new(id).unwrap());
    let channels = read_channels(&path, &ids).unwrap().samples;
    let trial = read_trial(&path, [Signal::Theta]).unwrap().samples;
    let (seen, true_rad) = (trial.get(Signal::Theta).unwrap(), channels.channel(&ids[0]).unwrap());
    // A count of the sensor, and as far as the lever goes in one of its periods.
    let apart = seen.iter().zip(true_rad).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart > 0.0 && apart < 0.05, "{apart}");
    assert_eq!(channels.channel(&ids[1]), None);
    zwidth(root.path(), &["list", "own"])
        .exits(0)
        .prints(&["channel skin_c (°C): temperature of the finger"]);
    // What comes later has the form of what is there.
    edit(&layout.study_toml(), CHANNELS, "");
    zwidth(root.path(), &["verify", "own"]).exits(1).prints(&["7 of 7 have others"]);
    let acquire = zwidth_line(root.path(), "acquire own -p P02 -s S01 --plain --fast --auto");
    acquire.exits(1).one_error().says(&["keeps the form it began with"]);
}

const CURRENT: &str = "
[[channels]]
id = \"current_motor_a\"
unit = \"A\"
description = \"current in the winding\"
";

/// The twin's winding, recorded: of the motor alone there is an energy, below the bound that needs
/// no current; of what uses the brake, whose current nobody knows, there is the bound or nothing.
#[test]
fn a_recorded_current_gives_trials_their_electrical_energy_and_others_keep_none() {
    let root = tempfile::tempdir().unwrap();
    let layout = study(root.path(), "# brake_ohm = 20.0", "brake_ohm = 20.0", CURRENT);
    twin(root.path()).exits(0);
    zwidth(root.path(), &["run", "own", "--only", "metrics of the study"]).exits(0);
    let table = metrics(&layout);
    let modes = table.texts("mode").unwrap();
    let taken = table.floats("electrical_energy_j").unwrap();
    let bound = table.floats("electrical_energy_max_j").unwrap();
    for ((mode, taken), bound) in modes.iter().zip(taken).zip(bound) {
        let bound = bound.unwrap();
        match mode.as_deref() {
            Some("active") => {
                let taken = taken.unwrap();
                assert!(0.5 * bound < taken && taken < bound, "{taken} J, at most {bound} J");
            }
            _ => assert_eq!(taken, None, "{mode:?}"),
        }
    }
}

const MAP: &str = r#"
kind = "trials"
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = "active"
[time]
from = "t"
unit = "s"
[[column]]
to = "theta_rad"
from = "angle"
unit = "deg"
[[column]]
to = "voltage_motor_v"
from = "u"
unit = "V"
[[channel]]
to = "current_motor_a"
from = "i_ma"
unit = "A"
scale = 0.001
"#;

/// 10 V and 400 mA for a second are 4 J.
#[test]
fn an_imported_current_gives_a_trial_its_electrical_energy() {
    let root = tempfile::tempdir().unwrap();
    let layout = study(root.path(), "schema = 2", "schema = 2", CURRENT);
    let row =
        |i: u32| format!("{},{},-10,-400\n", f64::from(i) / 100.0, f64::from(i) / 10.0 - 45.0);
    let rows: String = (0..=100).map(row).collect();
    let [map, csv] = ["map.toml", "one.csv"].map(|name| root.path().join(name));
    fs::write(&map, MAP).unwrap();
    fs::write(&csv, format!("t,angle,u,i_ma\n{rows}")).unwrap();
    let [map, csv] = [&map, &csv].map(|path| path.to_str().unwrap());
    zwidth(root.path(), &["import", "own", "--map", map, csv]).exits(0);
    zwidth(root.path(), &["run", "own", "--only", "metrics of the study"]);
    let taken = metrics(&layout).floats("electrical_energy_j").unwrap();
    assert!((taken[0].unwrap() - 4.0).abs() < 1e-9, "{taken:?}");
}

#[test]
fn a_channel_in_another_unit_than_the_devices_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let layout =
        study(root.path(), "schema = 2", "schema = 2", &CHANNELS.replace("\"rad\"", "\"deg\""));
    twin(root.path()).exits(1).says(&["'theta_true_rad' is in 'deg' in study.toml"]);
    assert!(!layout.trials().exists());
}
