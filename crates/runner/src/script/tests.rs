use super::*;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// What a shell does with this text, in a folder of its own, within that many seconds.
fn run(text: &str, timeout_s: u64) -> (Result<(), ScriptError>, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let work = folder.path().join("work");
    fs::create_dir(&work).unwrap();
    let command = ["sh", "-c", text].map(str::to_owned);
    let printed = folder.path().join("printed");
    let script = Script {
        command: &command,
        folder: &work,
        printed: &printed,
        timeout: Duration::from_secs(timeout_s),
    };
    let result = run_script(&script, &HeldSignals::hold().unwrap());
    (result, folder)
}

fn printed(folder: &TempDir) -> String {
    last_printed(&folder.path().join("printed")).unwrap().0
}

/// The process with the number that a script left in a file, if it goes on.
fn left(folder: &TempDir) -> Option<PathBuf> {
    let number = fs::read_to_string(folder.path().join("work/number")).unwrap();
    let process = PathBuf::from("/proc").join(number.trim());
    // A process that was killed and is not yet waited for has no command any more.
    fs::read(process.join("cmdline")).is_ok_and(|command| !command.is_empty()).then_some(process)
}

/// Waits for the end of what was killed: the system takes a moment.
fn check_ended(folder: &TempDir) {
    for _ in 0..1_000_000 {
        if left(folder).is_none() {
            return;
        }
        std::thread::yield_now();
    }
    panic!("{:?} goes on", left(folder));
}

#[test]
fn a_program_gets_a_fixed_environment_and_nothing_else() {
    let (result, folder) = run("env; pwd; cat; ls -a", 60);
    assert_eq!(result, Ok(()));
    let text = printed(&folder);
    let mut names: Vec<&str> =
        text.lines().filter_map(|line| Some(line.split_once('=')?.0)).collect();
    // A shell sets these by itself.
    names.retain(|name| !["PWD", "SHLVL", "OLDPWD", "_"].contains(name));
    names.sort_unstable();
    let mut expect = vec!["LC_ALL", "PATH", "PYTHONHASHSEED", "SOURCE_DATE_EPOCH", "TZ"];
    if std::env::var_os("HOME").is_some() {
        expect.insert(0, "HOME");
    }
    assert_eq!(names, expect, "{text}");
    for line in ["TZ=UTC", "LC_ALL=C.UTF-8", "SOURCE_DATE_EPOCH=0", "PYTHONHASHSEED=0"] {
        assert!(text.lines().any(|own| own == line), "{text}");
    }
    assert!(text.contains("/work\n"), "{text}");
}

#[test]
fn how_a_program_ended_is_told_with_what_it_printed() {
    let (result, folder) = run("echo one; echo two >&2; exit 7", 60);
    assert_eq!((result, printed(&folder).as_str()), (Err(ScriptError::ExitCode(7)), "one\ntwo\n"));
    assert_eq!(run("kill -9 $$", 60).0, Err(ScriptError::Signal(9)));
    let command = ["no-such-program-of-anybody".to_owned()];
    let folder = tempfile::tempdir().unwrap();
    let printed = folder.path().join("printed");
    let timeout = Duration::from_secs(60);
    let script = Script { command: &command, folder: folder.path(), printed: &printed, timeout };
    let error = run_script(&script, &HeldSignals::hold().unwrap()).unwrap_err();
    assert!(matches!(error, ScriptError::NotStarted(_)), "{error:?}");
}

#[test]
fn a_relative_program_is_one_of_the_folder_and_not_of_where_zwidth_works() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let work = folder.path().join("work");
    fs::create_dir(&work).unwrap();
    fs::write(work.join("run.sh"), "#!/bin/sh\necho of the folder\n").unwrap();
    fs::set_permissions(work.join("run.sh"), fs::Permissions::from_mode(0o700)).unwrap();
    let printed_file = folder.path().join("printed");
    let command = ["./run.sh".to_owned()];
    let timeout = Duration::from_secs(60);
    let script = Script { command: &command, folder: &work, printed: &printed_file, timeout };
    assert_eq!(run_script(&script, &HeldSignals::hold().unwrap()), Ok(()));
    assert_eq!(printed(&folder), "of the folder\n");
}

#[test]
fn only_the_last_that_was_printed_is_shown_and_too_much_ends_the_program() {
    let (result, folder) = run("head -c 70000 /dev/zero | tr '\\0' a; echo; echo end", 60);
    assert_eq!(result, Ok(()));
    let (text, has_more) = last_printed(&folder.path().join("printed")).unwrap();
    assert_eq!((text.len() as u64, has_more), (SHOWN, true));
    assert!(text.ends_with("a\nend\n"));
    assert_eq!(run("yes", 600).0, Err(ScriptError::PrintedTooMuch));
}

#[test]
fn after_its_time_a_program_is_ended_with_its_children() {
    let (result, folder) = run("sleep 1000 & echo $! > number; sleep 1000", 1);
    assert_eq!(result, Err(ScriptError::TooLong));
    check_ended(&folder);
}

#[test]
fn children_that_outlive_a_program_and_hold_what_it_prints_open_are_ended_and_not_waited_for() {
    let (result, folder) = run("sleep 1000 & echo $! > number", 600);
    assert_eq!(result, Ok(()));
    check_ended(&folder);
}
