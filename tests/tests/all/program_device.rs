//! A session recorded from a program of the study's own: nobody starts it unasked, and one that is
//! killed in a trial stops it, with the reason, and is started again.
#![cfg(unix)]

use crate::acquire::{Desk, Live};
use crate::binary::{Ran, binary, ran};
use crate::folders::files;
use std::fs;
use std::process::Command;
use zwidth_store::{Signal, read_trial};

/// A lever that goes forward by 1 rad and back in each trial; its numbers are whole milliradians.
const LEVER: &str = r#"
echo $$ >pid
t=0; i=0; moves=0
while read -r line; do
    n=${line#*:}; n=${n%%,*}
    case $line in
    *'"who"'*) echo "{\"n\":$n,\"protocol\":1,\"name\":\"shell\",\"rate_hz\":30,\"force_rate_hz\":80,\"motor_max_v\":16,\"brake_max_v\":24,\"watchdog_s\":0.05,\"simulated\":true}" ;;
    *'"homing"'*) i=0; moves=0 ;;
    *'"what":"trial"'*) i=0; moves=1 ;;
    *'"see"'*)
        t=$((t + 1)); i=$((i + moves))
        a=$((i < 5 ? 0 : i < 30 ? (i - 5) * 40 : i < 55 ? (55 - i) * 40 : 0))
        echo "{\"n\":$n,\"t_s\":${t}e-3,\"angle_rad\":${a}e-3,\"force_n\":0.5}" ;;
    esac
done
"#;

const RIG: &str =
    "link = \"process\"\n[process]\ncommand = [\"sh\", \"lever.sh\"]\nfiles = [\"lever.sh\"]\n";

fn with_lever() -> Desk {
    let desk = Desk::slow();
    let folder = desk.root().join("analysis/small");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("lever.sh"), LEVER).unwrap();
    fs::write(desk.root().join("raw/small/rig.toml"), RIG).unwrap();
    desk
}

/// Consent is kept below the study's folder, as a folder of the user's is.
fn as_user(desk: &Desk, mut command: Command) -> Command {
    command.env("XDG_STATE_HOME", desk.root().join("state"));
    command
}

fn allow(desk: &Desk) -> Ran {
    let mut command = Command::new(binary());
    command.arg("--root").arg(desk.root()).args(["allow", "small"]).env_remove("ZWIDTH_ROOT");
    ran(&as_user(desk, command).output().unwrap())
}

fn begin(desk: &Desk, more: &[&str]) -> Live {
    Live::of(as_user(desk, desk.command(&[&["--device", "rig"], more].concat())))
}

#[test]
fn a_program_that_nobody_allowed_or_that_changed_is_not_started() {
    let desk = with_lever();
    let pid = desk.root().join("analysis/small/pid");
    let refused = || {
        let live = begin(&desk, &[]);
        let told = ran(&live.child.wait_with_output().unwrap());
        told.exits(1).says(&["you have not allowed", "sh lever.sh", "`zwidth allow small`"]);
        assert!(!pid.exists(), "it was started");
    };
    refused();
    allow(&desk).exits(0).prints(&["device: sh lever.sh", "analysis/small/lever.sh"]);
    fs::write(desk.root().join("analysis/small/lever.sh"), format!("{LEVER}\n# other")).unwrap();
    refused();
}

#[test]
fn a_program_that_is_killed_in_a_trial_stops_it_and_is_started_again() {
    let desk = with_lever();
    allow(&desk).exits(0);
    let pid = || fs::read_to_string(desk.root().join("analysis/small/pid")).unwrap();
    let mut live = begin(&desk, &[]);
    live.on_to("ready 1 ");
    live.say("start");
    live.until("trial 1 ");
    let first = pid();
    let killed = Command::new("kill").args(["-KILL", first.trim()]).status().unwrap();
    assert!(killed.success());
    let stopped = live.until("stopped ");
    assert!(stopped.contains("it was ended by signal 9"), "{stopped}");
    live.say("start");
    live.on_to("question ");
    assert_ne!(pid(), first);
    live.say("4");
    live.until("pause ");
    live.say("quit");
    assert_eq!(live.child.wait().unwrap().code(), Some(3));
    // Nothing of it goes on.
    let alive = Command::new("kill").args(["-0", pid().trim()]).output().unwrap();
    assert!(!alive.status.success());
    desk.verify();
    let trials = files(&desk.root().join("raw/small/trials"), "parquet");
    let trial = read_trial(trials.last().unwrap(), Signal::all()).unwrap();
    assert_eq!(trial.meta.source.as_str(), "twin", "a simulated device's data are simulated");
    let angles = trial.samples.get(Signal::Theta).unwrap();
    let most = angles.iter().copied().fold(f64::MIN, f64::max);
    let least = angles.iter().copied().fold(f64::MAX, f64::min);
    assert!(most - least > 0.9, "{least} to {most}");
}
