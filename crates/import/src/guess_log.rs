//! A log beside recordings, guessed: which of its columns numbers the trials, and which says what they were.

use super::guess_answers::{LOOP, TOOK};
use super::guess_names::Names;
use super::guess_read::{Looked, first_numbers, look, quoted};
use super::guess_words::{are_answers, label_of};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Component, Path};

/// Writes `[log]` for the files that stand apart from the recordings and look like answers, as lines to be uncommented:
/// that a log belongs to these recordings only a person knows. Nothing if there is none.
pub(super) fn write(text: &mut String, recording: &Path, apart: &[&Path], names: &Names) {
    let Some((path, looked)) = apart.iter().find_map(|path| Some((*path, log(path)?))) else {
        return;
    };
    let columns: &[String] = looked.table.names.as_deref().unwrap_or_default();
    let comma = looked.written.is_some_and(|written| written.decimal_comma);
    let place = seen_from(recording, path);
    let _ = writeln!(
        text,
        "\n# If {} says of these recordings what they were, join it (docs/import.md, \"A log beside recordings\"):\n\
         # [log]\n# path = {}          # seen from each recording; {{group}} stands for a group of the pattern in [name]",
        path.file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, " "),
        quoted(&place)
    );
    let numbers = columns.iter().enumerate().filter(|(_, name)| {
        name.ends_with(LOOP) || matches!(label_of(name), Some("trial" | "repeat"))
    });
    // The loop that numbers most rows, each once.
    let numbers = numbers.map(|(place, name)| {
        let found = first_numbers(&looked.table.columns[place], comma);
        let found: Vec<u64> = found.into_iter().flatten().map(f64::to_bits).collect();
        let different: BTreeSet<&u64> = found.iter().collect();
        let is_once = different.len() == found.len();
        (is_once, found.len(), name, found.contains(&0_f64.to_bits()))
    });
    let number = numbers.max_by_key(|(is_once, count, ..)| (*is_once, *count));
    let label = if names.labels.contains_key("trial") { "trial" } else { "repeat" };
    match number {
        Some((_, _, name, from_zero)) => {
            let _ = writeln!(text, "# trial = {}          # its number of the trial, …", quoted(name));
            if names.labels.contains_key(label) {
                let _ = writeln!(text, "# number = {{ name = \"{label}\" }}          # … and the recording's");
            }
            if from_zero {
                text.push_str("# add = 1          # if the recordings count from 1: the log counts from 0\n");
            }
        }
        None => text.push_str(
            "# time = \"TODO\"          # the column of when each trial began; or trial = …, that of its number\n\
             # unit = \"s\"\n# offset_s = 0.0          # TODO: added to its times to have those of the recording\n",
        ),
    }
    text.push_str("# [log.file]\n# missing = \"drop\"\n# Then its columns are NAME@log, as labels and as answers:\n");
    for name in columns {
        if let Some(label @ ("mode" | "environment" | "kind")) = label_of(name) {
            let _ = writeln!(
                text,
                "# {label} = {{ column = {} }}          # in [trial]",
                quoted(&format!("{name}@log"))
            );
        }
    }
    let times: Vec<&String> = columns.iter().filter(|name| name.ends_with(TOOK)).collect();
    text.push_str("# [questions.columns]\n# TODO = \"TODO@log\"          # a question of study.toml, and the column of its answers\n");
    if let [time] = times[..] {
        let _ = writeln!(text, "# [questions.times]\n# TODO = {}", quoted(&format!("{time}@log")));
    }
}

/// A table that looks like answers.
fn log(path: &Path) -> Option<Looked> {
    let looked = look(path).ok()?;
    let names = looked.table.names.as_ref()?;
    let is_log = are_answers(names) || names.iter().any(|name| name.ends_with(LOOP));
    is_log.then_some(looked)
}

/// The path of a file from the folder of another.
fn seen_from(recording: &Path, path: &Path) -> String {
    let parts = |path: &Path| -> Vec<String> {
        let parts = path.components().filter(|part| *part != Component::CurDir);
        parts.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let folder = recording.parent().map(parts).unwrap_or_default();
    let path = parts(path);
    let shared = folder.iter().zip(&path).take_while(|(a, b)| a == b).count();
    let up = folder[shared..].iter().map(|_| "..".to_owned());
    up.chain(path[shared..].iter().cloned()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::super::guess::guess;
    use super::super::mapping::Mapping;
    use super::super::world::World;
    use std::path::Path;

    #[test]
    fn a_log_beside_recordings_is_proposed_and_becomes_a_mapping_when_uncommented() {
        let world = World::new();
        let files = [1, 2].map(|n| {
            let name = format!("rig/P07_active_trial{n}.csv");
            world.file(&name, format!("t_s,force_N\n0,{n}\n1,2\n"))
        });
        let log = world.file(
            "log/P07.csv",
            "mode,practice.thisN,trials.thisN,slider.response,slider.rt,participant,\nactive,,0,4,1.5,7,\nactive,,1,2,0.5,7,\n",
        );
        let guessed = guess(&files[0], &[files[1].clone(), log]).unwrap();
        let text = guessed.mapping;
        for line in [
            "# path = \"../log/P07.csv\"",
            "# trial = \"trials.thisN\"",
            "# add = 1 ",
            "# mode = { column = \"mode@log\" }",
            "# TODO = \"slider.rt@log\"",
        ] {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
        assert!(guessed.apart[0].remedy.contains("[log]"), "{:?}", guessed.apart);
        let log: Vec<&str> = text.lines().skip_while(|line| !line.starts_with("# [log]")).collect();
        let log = log.into_iter().take_while(|line| !line.contains("NAME@log"));
        let log: String = log.map(|line| format!("{}\n", line.trim_start_matches("# "))).collect();
        let labels = "[trial]\nparticipant = \"P01\"\nsession = \"S01\"\nenvironment = \"spring\"\nmode = { column = \"mode@log\" }\n";
        let time = "[time]\nfrom = \"t_s\"\nunit = \"s\"\n[[column]]\nto = \"force_ex_n\"\nfrom = \"force_N\"\nunit = \"N\"\n";
        let name = "[name]\npattern = '(?<trial>\\d+)\\.csv$'\n";
        let map = format!("kind = \"trials\"\n{name}{log}{labels}{time}");
        Mapping::from_toml(&map, Path::new("map.toml")).unwrap();
        let report = world.import(&map, &files).unwrap();
        assert_eq!(report.trials, 2);
    }
}
