//! A session recorded from a program of the study's own: nobody starts it unasked.
#![cfg(unix)]

use crate::acquire::{Desk, Live};
use crate::binary::{Ran, binary, ran};
use std::fs;
use std::process::Command;

/// It says that it was started.
const LEVER: &str = "echo $$ >pid\n";

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

fn begin(desk: &Desk) -> Ran {
    let live = Live::of(as_user(desk, desk.command(&["--device", "rig"])));
    ran(&live.child.wait_with_output().unwrap())
}

#[test]
fn a_program_that_nobody_allowed_or_that_changed_is_not_started() {
    let desk = with_lever();
    let pid = desk.root().join("analysis/small/pid");
    let refused = || {
        let told = begin(&desk);
        told.exits(1).says(&["you have not allowed", "sh lever.sh", "`zwidth allow small`"]);
        assert!(!pid.exists(), "it was started");
    };
    refused();
    allow(&desk).exits(0).prints(&["device: sh lever.sh", "analysis/small/lever.sh"]);
    fs::write(desk.root().join("analysis/small/lever.sh"), format!("{LEVER}\n# other")).unwrap();
    refused();
    fs::write(desk.root().join("analysis/small/lever.sh"), LEVER).unwrap();
    begin(&desk).exits(1).one_error().says(&["rig: lost"]);
    assert!(pid.exists(), "it was not started");
}
