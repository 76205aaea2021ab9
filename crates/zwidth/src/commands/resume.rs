//! The command that goes on with a session: with every option that it was begun with and needs
//! again, as a shell reads it.

use crate::commands::acquire::AcquireArgs;
use crate::devices::DeviceSpec;
use std::path::Path;
use zwidth_store::{shell_line, shell_option};

/// The command. A blinded session needs no seed to go on, so its seed is not shown.
pub(super) fn resume(root: &Path, command: &AcquireArgs, blinded: bool) -> String {
    let AcquireArgs {
        study,
        participant,
        session,
        device,
        plain,
        ascii,
        auto,
        rate,
        seed,
        fast,
        ..
    } = command;
    let mut words = vec!["zwidth".to_owned(), "acquire".to_owned()];
    // What looks like an option comes last, where nothing is taken for one.
    let last = study.as_str().starts_with('-');
    words.extend((!last).then(|| study.to_string()));
    words.extend(shell_option("-p", "--participant", participant.as_str()));
    words.extend(shell_option("-s", "--session", session.as_str()));
    let mut with = |name: &str, value: Option<String>| {
        words.extend(value.into_iter().flat_map(|value| shell_option(name, name, &value)));
    };
    with("--device", (*device != DeviceSpec::Twin).then(|| device.to_string()));
    with("--rate", rate.map(|hz| hz.to_string()));
    with("--seed", seed.filter(|_| !blinded).map(|seed| seed.to_string()));
    let markers: Vec<String> = command.markers.iter().map(ToString::to_string).collect();
    with("--markers", (!markers.is_empty()).then(|| markers.join(",")));
    with("--by", command.by.as_ref().map(ToString::to_string));
    with("--key", command.keys.folder.as_ref().map(|folder| folder.display().to_string()));
    with("--root", (root != Path::new("")).then(|| root.display().to_string()));
    let switches = [
        ("--plain", *plain),
        ("--ascii", *ascii),
        ("--auto", *auto),
        ("--fast", *fast),
        ("--no-watchdog", command.no_watchdog),
    ];
    words.extend(switches.into_iter().filter(|(_, on)| *on).map(|(name, _)| name.to_owned()));
    words.extend(last.then(|| ["--".to_owned(), study.to_string()]).into_iter().flatten());
    shell_line(words)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use crate::args::{Args, Command};
    use crate::commands::device::Keys;
    use clap::Parser as _;

    /// The words that a shell makes of a line.
    fn words(line: &str) -> Vec<String> {
        let output = std::process::Command::new("sh")
            .args(["-c", &format!("printf '%s\\0' {line}")])
            .output()
            .unwrap();
        assert!(output.status.success(), "{line}");
        let mut words: Vec<String> =
            String::from_utf8(output.stdout).unwrap().split('\0').map(str::to_owned).collect();
        words.pop();
        words
    }

    /// What the suggested command is read back as.
    fn read_back(root: &str, command: &AcquireArgs, blinded: bool) -> (String, AcquireArgs) {
        let line = resume(Path::new(root), command, blinded);
        let args = Args::try_parse_from(words(&line)).unwrap_or_else(|e| panic!("{line}: {e}"));
        let Command::Acquire(read) = args.command else { panic!("{line}") };
        (args.root.display().to_string(), read)
    }

    fn plain(study: &str) -> AcquireArgs {
        let typed = ["zwidth", "acquire", "-p", "P01", "-s", "S01", "--", study];
        let Command::Acquire(command) = Args::parse_from(typed).command else { panic!() };
        command
    }

    #[test]
    fn the_suggested_command_is_read_back_as_the_one_that_was_given() {
        let paths = ["a", "a b", "it's", "-x", "~/x", "$HOME`id`\"\\", "ä/new\nline", "*?[x]", "-"];
        let ids = ["P01", "-p", "--root", "_"];
        let ways = |command: &AcquireArgs, i: usize| {
            let path = paths[i % paths.len()];
            let id = ids[i % ids.len()];
            AcquireArgs {
                participant: id.parse().unwrap(),
                session: ids[(i / 2) % ids.len()].parse().unwrap(),
                device: match i % 3 {
                    0 => DeviceSpec::Twin,
                    _ => DeviceSpec::Playback(path.into()),
                },
                rate: [None, Some(120.0), Some(100.1 + 0.2), Some(1.0), Some(1e5)][i % 5],
                seed: [None, Some(u64::MAX), Some(0)][(i / 3) % 3],
                keys: Keys {
                    folder: (!i.is_multiple_of(4)).then(|| paths[(i / 4) % paths.len()].into()),
                },
                markers: ["tcp:[::1]:9000", "osc:localhost:57120", "board"][..i % 4]
                    .iter()
                    .map(|to| to.parse().unwrap())
                    .collect(),
                by: [None, Some("E1".parse().unwrap()), Some("-e".parse().unwrap())][(i / 4) % 3]
                    .clone(),
                plain: i & 1 > 0,
                ascii: i & 2 > 0,
                auto: i & 4 > 0,
                fast: i & 8 > 0,
                no_watchdog: i & 16 > 0,
                ..command.clone()
            }
        };
        for i in 0..96 {
            let command = ways(&plain(ids[(i / 5) % ids.len()]), i);
            let root = paths[(i / 7) % paths.len()];
            assert_eq!(read_back(root, &command, false), (root.to_owned(), command.clone()), "{i}");
            let unseeded = AcquireArgs { seed: None, ..command.clone() };
            assert_eq!(
                read_back(root, &command, true).1,
                unseeded,
                "a blinded session's seed is not shown"
            );
        }
    }

    #[test]
    fn what_was_not_given_is_not_suggested() {
        assert_eq!(
            resume(Path::new(""), &plain("small"), false),
            "zwidth acquire small -p P01 -s S01"
        );
        let accepts = AcquireArgs { accept_study_change: true, ..plain("small") };
        assert_eq!(
            resume(Path::new(""), &accepts, false),
            "zwidth acquire small -p P01 -s S01",
            "accepted once"
        );
    }
}
