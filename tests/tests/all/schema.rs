//! A study's schema from the outside: channels of its own, and studies that began with schema 1.

use crate::binary::zwidth;
use std::fs;
use std::path::Path;
use zwidth_store::{Layout, Signal, read_channels, read_footer, read_trial};
use zwidth_study::ChannelId;

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
    let mut text = fs::read_to_string(layout.study_toml()).unwrap();
    for (from, to) in [
        (from, to),
        ("\nrepeats = 6\n", "\nrepeats = 1\n"),
        ("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n"),
        ("\nrate_hz = 1000.0\n", "\nrate_hz = 120.0\n"),
    ] {
        assert!(text.contains(from), "the template lost '{from}'");
        text = text.replace(from, to);
    }
    fs::write(layout.study_toml(), text + more).unwrap();
    layout
}

const TWIN: [&str; 8] = ["twin", "own", "--participants", "1", "--sessions", "1", "--seed", "1"];

#[test]
fn a_channel_that_the_device_gives_is_recorded_by_its_name_and_another_is_null() {
    let root = tempfile::tempdir().unwrap();
    let layout = study(root.path(), "schema = 2", "schema = 2", CHANNELS);
    zwidth(root.path(), &TWIN).exits(0);
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
    let listed = zwidth(root.path(), &["list", "own"]).exits(0).out;
    assert!(listed.contains("channel skin_c (°C): temperature of the finger"), "{listed}");
    // What comes later has the form of what is there.
    let text = fs::read_to_string(layout.study_toml()).unwrap();
    fs::write(layout.study_toml(), text.replace(CHANNELS, "")).unwrap();
    let found = zwidth(root.path(), &["verify", "own"]).exits(1).out;
    assert!(found.contains("7 of 7 have others"), "{found}");
    let acquire = ["acquire", "own", "-p", "P02", "-s", "S01", "--plain", "--fast", "--auto"];
    zwidth(root.path(), &acquire).exits(1).one_error().says(&["keeps the form it began with"]);
}

#[test]
fn a_channel_in_another_unit_than_the_devices_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let layout =
        study(root.path(), "schema = 2", "schema = 2", &CHANNELS.replace("\"rad\"", "\"deg\""));
    zwidth(root.path(), &TWIN).exits(1).says(&["'theta_true_rad' is in 'deg' in study.toml"]);
    assert!(!layout.trials().exists());
}

#[test]
fn a_study_that_began_with_schema_1_goes_on_with_it_and_gives_the_same_answers() {
    let [one, two] = [("schema = 1", 1), ("schema = 2", 2)].map(|(schema, number)| {
        let root = tempfile::tempdir().unwrap();
        let layout = study(root.path(), "schema = 2", schema, "");
        zwidth(root.path(), &TWIN).exits(0);
        let found = zwidth(root.path(), &["verify", "own"]).exits(0).out;
        assert_eq!(found, format!("own: no findings (schema {number})\n"));
        let path = layout.trial(&"P01".parse().unwrap(), &"S01".parse().unwrap(), 2);
        assert_eq!(read_footer(&path).unwrap().form.schema.number(), number);
        zwidth(root.path(), &["run", "own", "--only", "likert tallies"]).exits(0);
        let derived =
            |name: &str| zwidth_tables::Table::from_parquet(&layout.derived().join(name)).unwrap();
        let (tally, answers) = (derived("likert.parquet"), derived("answers.parquet"));
        (read_trial(&path, Signal::all()).unwrap().samples, tally, answers)
    });
    assert!(one.0 == two.0, "the same samples");
    assert_eq!(one.1.columns(), two.1.columns());
    assert_eq!(one.2.columns(), two.2.columns());
    assert_eq!(one.2.height(), 6);
}
