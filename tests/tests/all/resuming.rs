//! Going on with a session: by its own study.toml, only if it is whole, by the command that was
//! suggested; and what a blinded one leaves.

use crate::acquire::{Desk, TRIALS};
use crate::binary::{Ran, binary, ran, zwidth, zwidth_line};
use crate::folders::{files, listing};
use crate::said::log;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[test]
fn a_session_goes_on_by_its_own_study_toml_whatever_was_edited_meanwhile_and_says_so() {
    let desk = Desk::new(false);
    desk.acquire("start\n3\nquit\n", &[]).exits(3);
    let order = desk.record();
    desk.edit_study("# Practice trials", "# Trials to practise");
    desk.acquire("start\n3\nquit\n", &[]).exits(3).prints(&["comments or form alone"]);
    desk.edit_study("pause_s = 3.0", "pause_s = 2.0");
    desk.acquire("", &[]).exits(1).one_error().says(&[
        "design.pause_s was 3.0 and is 2.0",
        "put it back",
        "--accept-study-change",
    ]);
    desk.acquire("start\n3\nquit\n", &["--accept-study-change"])
        .exits(3)
        .prints(&["the changed study.toml was accepted"]);
    desk.finish().exits(0);
    assert_eq!(desk.record(), order);
    zwidth(desk.root(), &["verify", "small"]).exits(0).prints(&["note: ", "no findings"]);
}

#[test]
fn a_change_of_study_toml_after_a_session_is_a_warning_that_names_the_command_which_makes_it_a_note()
 {
    let desk = Desk::new(false);
    desk.finish().exits(0);
    desk.edit_study("pause_s = 3.0", "pause_s = 2.0");
    let found = zwidth(desk.root(), &["verify", "small"]).exits(1).out;
    let command = found.split('`').nth(1).unwrap_or_else(|| panic!("{found}")).to_owned();
    let words: Vec<&str> = command.split(' ').collect();
    assert_eq!(words[..2], ["zwidth", "recover"], "{found}");
    zwidth(desk.root(), &words[1..]).exits(0).prints(&["design.pause_s was 3.0 and is 2.0"]);
    let verified = zwidth(desk.root(), &["verify", "small"]).exits(0);
    verified.prints(&["note: study.toml has changed since P01 S01"]);
    let again = zwidth_line(desk.root(), "recover small --accept-study-change").exits(0);
    again.prints(&["no change waits"]);
    zwidth_line(desk.root(), "recover small --accept-study-change -p P01").exits(2);
    zwidth_line(desk.root(), "recover small -p P01 -s S01").exits(2);
    desk.verify();
}

#[test]
fn a_session_whose_record_is_gone_or_edited_is_refused_before_anything_is_recorded() {
    let desk = Desk::new(false);
    desk.acquire("start\n3\nquit\n", &[]).exits(3);
    let record = desk.root().join("raw/small/sessions/P01_S01.json");
    let text = fs::read_to_string(&record).unwrap();
    for (damage, words) in
        [(None, "its log is there"), (Some(text.replace("120.0", "121.0")), "not the one")]
    {
        fs::remove_file(&record).unwrap();
        if let Some(edited) = damage {
            fs::write(&record, edited).unwrap();
        }
        let before = listing(&desk.root().join("raw"));
        desk.finish().exits(1).one_error().says(&[
            "nothing more is recorded",
            "P01_S01.json",
            words,
        ]);
        assert_eq!(listing(&desk.root().join("raw")), before);
        fs::write(&record, &text).unwrap();
    }
    desk.finish().exits(0);
    desk.verify();
}

#[cfg(unix)]
#[test]
fn the_command_that_is_suggested_goes_on_with_the_session() {
    let desk = Desk::new(false);
    let begun = desk.acquire("start\n3\nquit\n", &["--rate", "60", "--seed", "9"]).exits(3);
    let suggested = begun.err.split('`').nth(1).unwrap_or_else(|| panic!("{begun:#?}"));
    for word in ["--rate 60", "--seed 9", "--plain", "--fast", "--key ", "--root "] {
        assert!(suggested.contains(word), "{suggested}");
    }
    let folder = binary().parent().unwrap().display().to_string();
    let path = format!("{folder}:{}", std::env::var("PATH").unwrap_or_default());
    let shell = Command::new("sh")
        .args(["-c", &format!("{suggested} --auto")])
        .env("PATH", path)
        .env_remove("ZWIDTH_ROOT")
        .stdin(Stdio::null())
        .output();
    ran(&shell.unwrap()).exits(0).prints(&["resumed: 1 of 7"]);
    desk.verify();
}

/// `zwidth acquire` of a blinded session that goes by itself, from this folder.
fn acquire_blinded(folder: &Path, root: &str, more: &[(&str, &Path)]) -> Ran {
    let mut command = Command::new(binary());
    command
        .current_dir(folder)
        .args(["--root", root, "acquire", "small", "-p", "P01", "-s", "S01"]);
    command.args(["--plain", "--fast", "--auto"]).stdin(Stdio::null());
    command.env_remove("ZWIDTH_ROOT").env_remove("XDG_STATE_HOME").env_remove("LOCALAPPDATA");
    for (name, path) in more {
        match name.strip_prefix("--") {
            Some(_) => command.arg(name).arg(path),
            None => command.env(name, path),
        };
    }
    ran(&command.output().unwrap())
}

#[test]
fn the_first_blinded_session_of_a_new_account_makes_the_folders_of_its_seals() {
    for new in [vec!["HOME"], vec!["HOME", "XDG_STATE_HOME"]] {
        let desk = Desk::new(true);
        let account = tempfile::tempdir().unwrap();
        let home = account.path().join("home/new");
        let state = account.path().join("state/of/the/user");
        let folders: Vec<(&str, &Path)> = new.iter().copied().zip([&*home, &*state]).collect();
        acquire_blinded(desk.root(), ".", &folders).exits(0);
        let vault = match new.len() {
            1 => home.join(".local/state/zwidth"),
            _ => state.join("zwidth"),
        };
        assert_eq!(files(&vault.join("small"), "json").len(), 1);
        desk.verify();
    }
}

#[test]
fn a_vault_is_made_in_new_folders_by_any_spelling_of_its_path_and_of_the_root() {
    for (root, key, leads_to) in [
        (".", "new/sub/folder", "new/sub/folder"),
        ("../desk", "./keys", "keys"),
        ("../desk", "../keys/new", "../keys/new"),
        (".", "raw/../keys/new", "keys/new"),
    ] {
        let desk = Desk::new(true);
        let folder = desk.root().join("desk");
        fs::create_dir(&folder).unwrap();
        fs::rename(desk.root().join("raw"), folder.join("raw")).unwrap();
        acquire_blinded(&folder, root, &[("--key", Path::new(key))]).exits(0);
        assert_eq!(files(&folder.join(leads_to).join("small"), "json").len(), 1, "{key}");
        acquire_blinded(&folder, root, &[("--key", Path::new(key))]).exits(0);
    }
}

#[cfg(unix)]
#[test]
fn a_vault_that_a_link_leads_into_the_data_is_refused_before_anything_is_written() {
    let desk = Desk::new(true);
    std::os::unix::fs::symlink("raw/small", desk.root().join("keys")).unwrap();
    let before = listing(&desk.root().join("raw"));
    desk.finish().exits(1).one_error().says(&["is inside", "raw", "--key"]);
    assert_eq!(listing(&desk.root().join("raw")), before);
}

#[cfg(unix)]
#[test]
fn a_blinded_study_leaves_its_seed_in_no_file_and_its_seals_to_their_owner_whatever_the_umask() {
    use std::os::unix::fs::PermissionsExt as _;
    const SEED: u64 = 9_876_543_210_987_654_321;
    let desk = Desk::new(true);
    let keys = desk.keys();
    let script = "umask 0; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script]).arg(binary()).arg("--root").arg(desk.root());
    let twin = format!("twin small --participants 1 --sessions 2 --seed {SEED}");
    command.args(twin.split(' '));
    ran(&command.arg("--key").arg(&keys).env_remove("ZWIDTH_ROOT").output().unwrap()).exits(0);
    let spellings = [
        SEED.to_string().into_bytes(),
        format!("{SEED:x}").into_bytes(),
        (SEED as f64).to_string().into_bytes(),
        SEED.to_le_bytes().to_vec(),
        SEED.to_be_bytes().to_vec(),
    ];
    let raw = desk.root().join("raw");
    let found: Vec<PathBuf> =
        listing(&raw).into_keys().map(|name| raw.join(name)).filter(|p| p.is_file()).collect();
    assert!(found.len() > 2 * TRIALS + 45, "{found:?}");
    for path in found {
        let bytes = fs::read(&path).unwrap();
        for spelling in &spellings {
            let stands = bytes.windows(spelling.len()).any(|window| window == spelling);
            assert!(!stands, "the seed stands in {}", path.display());
        }
    }
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
    assert_eq!((mode(&keys), mode(&keys.join("small"))), (0o700, 0o700));
    let seals = files(&keys, "json");
    assert!(seals.len() == 2 && seals.iter().all(|path| mode(path) == 0o600), "{seals:?}");
}

#[test]
fn by_the_studys_rule_trials_that_did_not_meet_the_protocol_are_done_again_and_told_in_its_methods()
{
    let desk = Desk::new(false);
    // No movement ends in so short a time.
    desk.edit_study("\ntrial_limit_s = 4.0\n", "\ntrial_limit_s = 0.6\nredo_unmet = 1\n");
    let told = "trial 2 does not count: it is done again after all others (1 of at most 1 times)";
    desk.finish().exits(0).prints(&["trial 1 did not meet the protocol: ", told]);
    let unmet = log(&desk).into_iter().filter(|line| line["what"]["event"] == "unmet");
    let trials: Vec<i64> = unmet.map(|line| line["what"]["trial"].as_i64().unwrap()).collect();
    // All but the one to practise, once each.
    assert_eq!(trials, (2..=TRIALS as i64).collect::<Vec<_>>());
    let methods = zwidth(desk.root(), &["methods", "small"]).exits(0);
    methods.prints(&["at most once; this befell 2 trials of 'Active'"]);
    desk.verify();
}
