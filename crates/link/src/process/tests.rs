//! Programs that do what they must not: the reason is told, and nothing of them is left.

use super::{Process, Program};
use crate::{Settings, Wire as _, over};
use std::time::{Duration, Instant};
use zwidth_device::{AWAY_S, Clock as _, Device, DeviceError, Guard, Limits, RealClock};
use zwidth_study::{Source, Voltages};

/// A bound against a test that hangs.
const FOR_EVER: Duration = Duration::from_secs(300);

/// A program in the shell that answers each question; `$see` is what it does at the third reading.
const PROGRAM: &str = r#"
seen=0
while read -r line; do
    n=${line#*:}; n=${n%%,*}
    case $line in
    *'"who"'*) echo "{\"n\":$n,\"protocol\":1,\"name\":\"shell\",\"rate_hz\":500,\"force_rate_hz\":500,\"motor_max_v\":12,\"brake_max_v\":24,\"watchdog_s\":0.05,\"simulated\":true}" ;;
    *'"see"'*)
        seen=$((seen + 1))
        if [ -e "$1" ]; then rm "$1"; FAULT; fi
        echo "{\"n\":$n,\"t_s\":${seen}e-3,\"angle_rad\":0.25,\"force_n\":1.5}" ;;
    esac
done
"#;

/// Such a program, whose fault comes when its file is made.
struct Desk {
    folder: tempfile::TempDir,
    settings: Settings,
}

impl Desk {
    fn new(fault: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program.sh");
        std::fs::write(&program, PROGRAM.replace("FAULT", fault)).unwrap();
        let command = ["sh", "./program.sh", "./now"].map(str::to_owned).to_vec();
        let process = Process { command, folder: folder.path().to_owned(), ..Process::default() };
        let mut settings: Settings =
            toml::from_str("link = \"process\"\n[process]\ncommand = [\"\"]").unwrap();
        settings.process = Some(process);
        Self { folder, settings }
    }

    fn open(&self) -> Box<dyn Device> {
        let program = Program::start(self.settings.process.as_ref().unwrap()).unwrap();
        over(program, None, &self.settings, Vec::new()).unwrap()
    }

    fn begin_fault(&self) {
        std::fs::write(self.folder.path().join("now"), "").unwrap();
    }

    /// What a session is told of the fault: the first error of its loop.
    fn fault(&self, device_fault: &str) -> String {
        let mut device = self.open();
        let began = Instant::now();
        let mut clock = RealClock::new();
        device.home(clock.now_s()).unwrap();
        self.begin_fault();
        let mut now_s = clock.now_s();
        let told = loop {
            // As fast as the device, like the loop of a session: one that only asks would not let it answer.
            now_s = clock.wait_until(now_s + 1.0 / device.capabilities().rate_hz);
            if let Err(told) = device.read(now_s) {
                break told;
            }
            if let Err(told) = device.write(now_s, Voltages { motor_v: 1.0, brake_v: 0.0 }) {
                break told;
            }
            assert!(began.elapsed() < FOR_EVER, "no fault is told after {device_fault}");
        };
        assert!(matches!(told, DeviceError::Lost { .. }), "{told}");
        told.to_string()
    }
}

#[test]
fn a_program_is_a_device_in_newtons_and_radians() {
    let desk = Desk::new(":");
    let mut device = desk.open();
    let can = device.capabilities().clone();
    assert_eq!((can.name.as_str(), can.rate_hz, can.watchdog_s), ("shell", 500.0, Some(0.05)));
    assert_eq!((can.motor_max_v, can.brake_max_v, can.source), (12.0, 24.0, Source::Twin));
    let reading = device.home(0.0).unwrap();
    assert!((reading.force_n - 1.5).abs() < 1e-9);
    // 0.25 rad are 23,873 counts of 50,000 · 12 in a turn.
    assert_eq!((reading.raw(), can.counts_per_turn), (Some(23_873), Some(50_000)));
    assert!((can.shaft_per_lever - 12.0).abs() < 1e-9);
}

#[test]
fn the_lever_of_a_program_is_homed_where_it_rests() {
    let mut device = Desk::new(":").open();
    let limits = Limits { theta_min_rad: -0.5, theta_max_rad: 0.5, force_n: 10.0 };
    let mut guard = Guard::new(&device.capabilities().clone(), limits, false);
    guard.home(&mut *device, 0.0).unwrap();
}

#[test]
fn whatever_a_program_does_wrong_stops_the_loop_with_the_reason() {
    for (fault, why) in [
        ("kill -9 $$", "it was ended by signal 9"),
        ("echo oh dear >&2; exit 3", "it ended with exit code 3; it printed last: oh dear"),
        (r#"echo "{\"n\":$n,\"t_s\":1,\"angle_rad\":NaN,\"force_n\":0}""#, "not understood"),
        (
            r#"while :; do echo "{\"n\":1,\"t_s\":1,\"angle_rad\":0,\"force_n\":0}"; done"#,
            "nobody asked for",
        ),
        ("while :; do echo; done", "not understood"),
        ("seen=0; seen=1", "its clock went back"),
        ("exec 1>&-; cat >/dev/null", "it closed its standard output"),
        (r#"echo '{"error":"the handle is off"}'"#, "it says: the handle is off"),
    ] {
        let told = Desk::new(fault).fault(fault);
        assert!(told.contains(why), "{fault}: {told}");
    }
}

#[test]
fn a_silent_program_gives_an_old_reading_which_safety_refuses_and_is_started_anew() {
    let desk = Desk::new("while read -r line; do :; done");
    let mut device = desk.open();
    device.home(0.0).unwrap();
    desk.begin_fault();
    let ages =
        (0_i32..100).map(|tick| device.read(1.0 + f64::from(tick) * 2e-3).unwrap().angle_age_s);
    // Past what safety allows: `zwidth_device::Guard` ends the trial at 0 V by then.
    assert!(ages.last().unwrap() > AWAY_S);
    // Homing finds it silent; the next one starts it again.
    let homed = (0_i32..3).find_map(|again| device.home(2.0 + f64::from(again)).ok());
    assert!((homed.unwrap().force_n - 1.5).abs() < 1e-9);
}

#[test]
fn nothing_that_a_program_started_is_left() {
    let desk = Desk::new("sleep 1000 >/dev/null & echo $! >pid; exit 0");
    let told = desk.fault("exit");
    assert!(told.contains("exit code 0"), "{told}");
    let number = std::fs::read_to_string(desk.folder.path().join("pid")).unwrap();
    assert!(ends(number.trim().parse().unwrap()));
}

#[test]
fn a_device_that_is_dropped_leaves_no_program_even_one_that_does_not_end_by_itself() {
    let desk = Desk::new("trap '' TERM HUP; echo $$ >pid; exec <&-; while :; do sleep 100; done");
    let mut device = desk.open();
    device.home(0.0).unwrap();
    desk.begin_fault();
    let path = desk.folder.path().join("pid");
    let mut now_s = 1.0;
    let number = loop {
        now_s += 2e-3;
        let _ = device.read(now_s);
        match std::fs::read_to_string(&path) {
            Ok(number) if number.ends_with('\n') => break number,
            _ => {}
        }
    };
    drop(device);
    assert!(ends(number.trim().parse().unwrap()));
}

/// Whether a process ends, or has ended: a killed one of somebody else's stays for a moment.
fn ends(number: i32) -> bool {
    let began = Instant::now();
    while began.elapsed() < FOR_EVER {
        let state = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
        if state.is_empty() || state.contains(") Z ") {
            return true;
        }
        std::thread::yield_now();
    }
    false
}

#[test]
fn a_program_that_is_not_there_or_says_nothing_sensible_is_no_device() {
    let mut desk = Desk::new(":");
    let wrong = |desk: &Desk| match Program::start(desk.settings.process.as_ref().unwrap()) {
        Err(told) => told.to_string(),
        Ok(program) => over(program, None, &desk.settings, Vec::new()).err().unwrap().to_string(),
    };
    desk.settings.process.as_mut().unwrap().command = vec!["no-such-program".to_owned()];
    assert!(wrong(&desk).contains("it cannot be started"), "{}", wrong(&desk));
    desk.settings.process.as_mut().unwrap().command =
        ["sh", "-c", "echo hello; cat >/dev/null"].map(str::to_owned).to_vec();
    assert!(wrong(&desk).contains("not understood: expected value"), "{}", wrong(&desk));
    desk.settings.process.as_mut().unwrap().command = vec!["true".to_owned()];
    assert!(wrong(&desk).contains("it ended with exit code 0"), "{}", wrong(&desk));
}

#[test]
fn keys_of_a_board_are_refused_beside_a_program() {
    let check = |toml: &str| {
        let settings: Settings = toml::from_str(&format!("link = \"process\"\n{toml}")).unwrap();
        settings.check().err().map(|told| told.to_string())
    };
    assert_eq!(check("[process]\ncommand = [\"x\"]"), None);
    for (toml, why) in [
        ("", "no table [process]"),
        ("[process]\ncommand = []", "process.command is empty"),
        (
            "newtons_per_count = 1.0\n[process]\ncommand = [\"x\"]",
            "newtons_per_count is of a board",
        ),
        ("port = \"/dev/x\"\n[process]\ncommand = [\"x\"]", "port is of a board"),
    ] {
        let told = check(toml).unwrap();
        assert!(told.contains(why), "{toml}: {told}");
    }
}

#[test]
fn why_a_program_ended_is_told_again_whenever_it_is_asked() {
    let command = ["sh", "-c", "echo the handle is off >&2; exit 3"].map(str::to_owned).to_vec();
    let table = Process { command, folder: ".".into(), ..Process::default() };
    let mut program = Program::start(&table).unwrap();
    let first = loop {
        if let Err(why) = program.receive(&mut [0; 64], Duration::from_millis(10)) {
            break why.to_string();
        }
    };
    assert!(first.contains("exit code 3"), "{first}");
    assert_eq!(program.send(b"{}\n").unwrap_err().to_string(), first);
    assert_eq!(program.receive(&mut [0; 64], Duration::ZERO).unwrap_err().to_string(), first);
}
