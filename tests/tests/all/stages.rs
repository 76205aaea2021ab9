//! Stages of a study's own: consent, what they get and give, how they fail, and what is made again.

use crate::acquire::Desk;
use crate::binary::{Ran, binary, ran, zwidth_line};
use crate::folders::{append, copy, edit};
use crate::small::{Study, repeats};
use serde_json::Value;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::symlink;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;
use zwidth_tables::Table;

const STAGE: &str = "
[[stage]]
id = \"grip\"
command = [\"sh\", \"grip.sh\"]
files = [\"grip.sh\"]
inputs = [\"metrics\"]
format = \"csv\"
timeout_s = 60
gives = [{ id = \"grip_peak\", unit = \"N\", label = \"largest grip\" }]
";

/// A row for each trial, whose value is the place of its row.
const TABLE: &str = "awk -F, -v OFS=, 'NR==1 {print \"participant,session,trial,grip_peak\"} \
                     NR>1 {print $1, $2, $3, NR/8}' in/metrics.csv > out/table.csv\n";

/// A study with a stage, and a user's own state folder.
struct World {
    study: Study,
    state: TempDir,
}

impl World {
    /// Two people with three trials of two modes each, and a stage that runs this script.
    fn new(script: &str) -> Self {
        let study = Study::new("demo");
        for who in ["P01", "P02"] {
            let both = [repeats("spring", "hybrid", 1..=3), repeats("spring", "active", 4..=6)];
            study.session(who, &both.concat());
        }
        let world = Self { study, state: tempfile::tempdir().unwrap() };
        let toml = world.study.layout().study_toml();
        let text = fs::read_to_string(&toml).unwrap() + STAGE;
        fs::write(toml, text).unwrap();
        fs::create_dir_all(world.study.layout().analysis()).unwrap();
        world.write(script);
        world
    }

    fn script(&self) -> PathBuf {
        self.study.layout().analysis().join("grip.sh")
    }

    fn write(&self, script: &str) {
        fs::write(self.script(), script).unwrap();
    }

    fn edit(&self, from: &str, to: &str) {
        edit(&self.study.layout().study_toml(), from, to);
    }

    fn command(&self, root: &Path, line: &str) -> Command {
        let mut command = Command::new(binary());
        command.arg("--root").arg(root).args(line.split(' '));
        command.env_remove("ZWIDTH_ROOT").env("XDG_STATE_HOME", self.state.path());
        command
    }

    fn run_in(&self, root: &Path, line: &str) -> Ran {
        ran(&self.command(root, line).output().unwrap())
    }

    fn run(&self, line: &str) -> Ran {
        self.run_in(self.study.root(), line)
    }

    /// What a run says of a stage that gives nothing.
    fn fails(&self, words: &[&str]) {
        let ran = self.run("run demo --allow-scripts").exits(3);
        ran.says(&["stage grip could not be made: "]).says(words);
        assert!(!self.values().exists());
        assert!(self.study.layout().reports().join("index.html").exists());
    }

    fn values(&self) -> PathBuf {
        self.study.layout().derived().join("stages/grip.grip_peak.parquet")
    }

    /// The stage's column of the table of metrics.
    fn column(&self) -> Vec<Option<f64>> {
        self.study.derived("metrics").floats("own_grip_peak_n").unwrap()
    }
}

#[test]
fn a_stage_that_nobody_allowed_is_never_started_and_all_else_is_made() {
    let trace = tempfile::tempdir().unwrap();
    let left = trace.path().join("started");
    let world = World::new(&format!("touch {}\n{TABLE}", left.display()));
    let words = ["nobody has allowed it here", "`sh grip.sh`", "grip.sh of analysis/demo"];
    for line in ["run demo", "run demo --fresh", "run demo --only grip", "compare demo"] {
        let ran = world.run(line).exits(3).says(&words);
        ran.says(&["`zwidth allow demo`", "--allow-scripts"]);
        assert!(!left.exists(), "{line}");
    }
    assert!(world.study.layout().reports().join("index.html").exists());
    assert_eq!(world.column(), vec![None; 12]);
    world
        .run("allow demo --dry-run")
        .exits(0)
        .prints(&["grip: sh grip.sh", "analysis/demo/grip.sh"]);
    world.run("run demo").exits(3);
    assert!(!left.exists());
    // Nothing that a study can bring along allows it.
    assert!(fs::read_dir(world.state.path()).unwrap().next().is_none());
}

#[test]
fn a_stage_that_was_allowed_gives_a_metric_like_any_other_and_an_up_to_date_result_needs_no_consent()
 {
    let world = World::new(TABLE);
    world.run("allow demo").exits(0).prints(&["grip: sh grip.sh"]).says(&["your rights"]);
    world.run("run demo").exits(0);
    // In the order of people, sessions and trials.
    let expect: Vec<_> = (2..14).map(|row| Some(f64::from(row) / 8.0)).collect();
    assert_eq!(world.column(), expect);
    let methods = "largest grip: computed outside of zwidth by stage grip of the study: sh grip.sh";
    world.run("methods demo").exits(0).prints(&[methods]);
    let compared = world.study.derived("compare/compared").texts("metric").unwrap();
    assert!(compared.contains(&Some("own_grip_peak_n".to_owned())), "{compared:?}");
    let why = world.run("why derived/demo/stages/grip.grip_peak.parquet").exits(0);
    why.prints(&["stage grip", "analysis/demo/grip.sh", "Up to date"]);
    let trace = world.run("trace derived/demo/stages/grip.grip_peak.parquet").exits(0);
    trace.prints(&["analysis/demo/grip.sh"]);
    world.run("allow demo --withdraw").exits(0).prints(&["is allowed no more"]);
    world.run("run demo").exits(0).prints(&["0 made"]);
    world.run("run demo --fresh").exits(3).says(&["nobody has allowed it here"]);
    world.run("run demo --allow-scripts").exits(0);
    world.run("run demo --fresh").exits(3);
}

#[test]
fn another_script_another_command_and_a_copy_elsewhere_ask_again_and_another_way_there_does_not() {
    let world = World::new(TABLE);
    world.run("allow demo").exits(0);
    let asks = |root: &Path| {
        world.run_in(root, "run demo --fresh").exits(3).says(&["nobody has allowed it here"]);
    };
    let elsewhere = tempfile::tempdir().unwrap();
    let linked = elsewhere.path().join("linked");
    symlink(world.study.root(), &linked).unwrap();
    world.run_in(&linked, "run demo --fresh").exits(0);
    let clone = elsewhere.path().join("clone");
    copy(world.study.root(), &clone);
    asks(&clone);
    world.write(&format!("{TABLE}# changed"));
    asks(world.study.root());
    world.write(TABLE);
    world.run("run demo --fresh").exits(0);
    world.edit("\"grip.sh\"]\nfiles", "\"./grip.sh\"]\nfiles");
    asks(world.study.root());
}

#[test]
fn a_link_in_place_of_an_allowed_script_is_not_run() {
    let world = World::new(TABLE);
    world.run("allow demo").exits(0);
    let elsewhere = tempfile::tempdir().unwrap();
    let left = elsewhere.path().join("started");
    let other = elsewhere.path().join("grip.sh");
    fs::write(&other, format!("touch {}\n{TABLE}", left.display())).unwrap();
    fs::remove_file(world.script()).unwrap();
    symlink(&other, world.script()).unwrap();
    world.run("run demo").exits(3).says(&["analysis/demo/grip.sh", "it is a link"]);
    // Nor is the same content behind a link.
    fs::write(&other, TABLE).unwrap();
    world.run("run demo --allow-scripts").exits(3).says(&["it is a link"]);
    assert!(!left.exists());
}

#[test]
fn how_a_stage_fails_is_one_error_with_what_it_printed() {
    let world = World::new("echo to the point >&2; exit 9");
    world.fails(&["'sh' ended with exit code 9; it printed:\nto the point"]);
    for (script, words) in [
        ("exit 1", "ended with exit code 1; it printed nothing"),
        ("kill -SEGV $$", "was ended by signal 11"),
        ("true", "it wrote no table; let it write out/table.parquet"),
        ("touch out/table.csv out/table.parquet", "it wrote both"),
        ("ln -s /etc/passwd out/table.csv", "is not a regular file"),
        (
            "echo participant,session,trial,other,more > out/table.csv; echo P01,S01,1,2,3 >> out/table.csv",
            "there is no column 'grip_peak'",
        ),
        (
            "echo participant,session,trial,grip_peak > out/table.csv; echo P01,S01,1,nan >> out/table.csv",
            "'nan' is not a finite number",
        ),
        (
            "echo participant,session,trial,grip_peak > out/table.csv; echo P01,S01,9,1 >> out/table.csv",
            "no trial 9",
        ),
        ("echo PAR1 > out/table.parquet", "table.parquet"),
    ] {
        world.write(script);
        world.fails(&[words]);
    }
    world.edit("[\"sh\", \"grip.sh\"]", "[\"no-such-program\", \"grip.sh\"]");
    world.fails(&["'no-such-program' cannot be started"]);
    fs::remove_file(world.script()).unwrap();
    world.fails(&["analysis/demo/grip.sh"]);
}

/// The process with that number, if it goes on.
fn goes_on(number: &str) -> bool {
    fs::read(Path::new("/proc").join(number.trim()).join("cmdline"))
        .is_ok_and(|command| !command.is_empty())
}

/// Waits for the end of a process that was killed: the system takes a moment.
fn check_ended(number: &str) {
    for _ in 0..1_000_000 {
        if !goes_on(number) {
            return;
        }
        std::thread::yield_now();
    }
    panic!("process {number} goes on");
}

#[test]
fn a_stage_that_forks_and_hangs_is_ended_with_its_children() {
    let elsewhere = tempfile::tempdir().unwrap();
    let number = elsewhere.path().join("number");
    let script = format!("sleep 1000 & echo $! > {}; sleep 1000", number.display());
    let world = World::new(&script);
    world.edit("timeout_s = 60", "timeout_s = 1");
    world.fails(&["was ended after 1 s; give it more time with timeout_s"]);
    check_ended(&fs::read_to_string(number).unwrap());
}

#[test]
fn whoever_ends_zwidth_ends_a_stage_with_its_children_and_leaves_no_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let fifo = temporary.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let world = World::new(&format!("sleep 1000 & echo $! > {}; sleep 1000", fifo.display()));
    let mut command = world.command(world.study.root(), "run demo --allow-scripts --quiet");
    let mut run = command.env("TMPDIR", temporary.path()).stderr(Stdio::null()).spawn().unwrap();
    // The script opens it when it runs.
    let mut number = String::new();
    BufReader::new(fs::File::open(&fifo).unwrap()).read_line(&mut number).unwrap();
    assert!(goes_on(&number));
    // Not SIGINT: who runs tests in the background may have it ignored.
    let told = Command::new("kill").args(["-TERM", &run.id().to_string()]).status();
    assert!(told.unwrap().success());
    assert_eq!(run.wait().unwrap().signal(), Some(15));
    check_ended(&number);
    fs::remove_file(fifo).unwrap();
    assert!(fs::read_dir(temporary.path()).unwrap().next().is_none(), "its folder is left");
}

#[test]
fn figures_of_a_stage_are_kept_as_they_are_and_shown_as_images() {
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"><script>alert(1)</script></svg>";
    let script =
        format!("{TABLE}printf '%s' '{svg}' > out/figures/grip.svg\ntouch out/figures/more.png\n");
    let world = World::new(&script);
    let figures = "figures = [{ file = \"grip.svg\", caption = \"Grip & all.\" }]";
    world.edit(
        "gives = [{ id = \"grip_peak\"",
        &format!("{figures}\ngives = [{{ id = \"grip_peak\""),
    );
    let run = world.run("run demo --allow-scripts").exits(3);
    run.says(&["read with care: the stage grip left out/figures/more.png"]);
    let reports = world.study.layout().reports();
    assert_eq!(fs::read_to_string(reports.join("stages/grip/grip.svg")).unwrap(), svg);
    let beside = fs::read(reports.join("stages/grip/grip.svg.json")).unwrap();
    let beside: Value = serde_json::from_slice(&beside).unwrap();
    assert_eq!(beside["made_by"], "stage grip of the study: sh grip.sh");
    assert!(beside["provenance"]["origin"].as_str().unwrap().starts_with("zwidth:stage:"));
    let page = fs::read_to_string(reports.join("index.html")).unwrap();
    assert!(page.contains("<img src=\"stages/grip/grip.svg\"") && !page.contains("alert(1)"));
    assert!(page.contains("Grip &amp; all. Not drawn by zwidth, but by the stage grip"));
    let one = reports.join("one.html");
    world.run(&format!("open demo --single-file {}", one.display())).exits(0);
    let one = fs::read_to_string(one).unwrap();
    assert!(one.contains("<img src=\"data:image/svg+xml;base64,") && !one.contains("alert(1)"));
    world.write(&format!("{TABLE}echo no picture > out/figures/grip.svg"));
    world.fails(&["out/figures/grip.svg is not what its ending says"]);
    assert!(!reports.join("stages/grip/grip.svg").exists());
    world.write(TABLE);
    world.fails(&["out/figures/grip.svg cannot be taken"]);
}

#[test]
fn a_stage_made_twice_gives_the_same_bytes_or_what_differs_is_told() {
    let world = World::new(TABLE);
    let twice = "run demo --allow-scripts --twice grip";
    world.run(twice).exits(0).prints(&["stage grip: made twice, 1 file with the same bytes"]);
    world.write(
        &TABLE
            .replace("NR/8", "NR/8 + (NR == 4 ? rand_ns : 0)")
            .replace("-v OFS=,", "-v OFS=, -v rand_ns=$(date +%N)"),
    );
    let differs = world.run(twice).exits(3);
    differs.says(&["stage grip: made twice", "grip.grip_peak.parquet differs: value in row 3 is"]);
    world.run("run demo --twice no-such").exits(1).one_error().says(&["--twice no-such"]);
}

#[test]
fn a_trial_that_counts_no_more_makes_the_stage_again_and_nothing_of_other_sessions() {
    let world = World::new(TABLE);
    world.run("run demo --allow-scripts").exits(0);
    assert!(world.run("run demo --json").exits(0).made().is_empty());
    world.run("exclude demo -p P01 -s S01 --trial 2 sneezed").exits(0);
    let made = world.run("run demo --allow-scripts --json").made();
    for name in ["stage grip", "metrics P01 S01", "metrics of the study"] {
        assert!(made.iter().any(|own| own == name), "{name}: {made:?}");
    }
    assert!(!made.iter().any(|own| own.contains("P02")), "{made:?}");
    assert_eq!(Table::from_parquet(&world.values()).unwrap().height(), 11);
    // What is only shown of it needs no program.
    world.edit("title = ", "title = \"Another title\" # ");
    let made = world.run("run demo --json").exits(0).made();
    assert!(!made.is_empty() && !made.iter().any(|own| own == "stage grip"), "{made:?}");
}

#[test]
fn a_stage_reads_another_one_and_waits_for_it() {
    let world = World::new(TABLE);
    let second = STAGE
        .replace("\"grip\"", "\"twofold\"")
        .replace("grip.sh", "twofold.sh")
        .replace("[\"metrics\"]", "[\"grip\", \"samples\", \"answers\"]")
        .replace("grip_peak", "twofold");
    let toml = world.study.layout().study_toml();
    // The one that reads stands first.
    edit(&toml, STAGE, &format!("{second}{STAGE}"));
    let script = "test -s in/samples.csv || exit 4\ntest -s in/answers.csv || exit 5\n\
                  tr -d '\\r' < in/grip.csv | awk -F, -v OFS=, 'NR==1 {for (i=1;i<=NF;i++) at[$i]=i; \
                  print \"participant,session,trial,value\"} \
                  NR>1 {print $1, $2, $3, 2*$at[\"grip_peak\"]}' > out/table.csv\n";
    fs::write(world.study.layout().analysis().join("twofold.sh"), script).unwrap();
    world.run("run demo --allow-scripts").exits(0);
    let metrics = world.study.derived("metrics");
    let [one, two] = ["own_grip_peak_n", "own_twofold_n"].map(|name| metrics.floats(name).unwrap());
    let twofold: Vec<_> = one.iter().map(|value| value.map(|value| 2.0 * value)).collect();
    assert_eq!(two, twofold);
    world.write("exit 1");
    let ran = world.run("run demo --allow-scripts").exits(3);
    ran.says(&["stage twofold could not be made: it needs", "grip.grip_peak.parquet"]);
}

#[test]
fn a_sealed_session_reaches_no_stage_until_it_is_unsealed() {
    let desk = Desk::new(true);
    append(&desk.root().join("raw/small/study.toml"), STAGE);
    let folder = desk.root().join("analysis/small");
    fs::create_dir_all(&folder).unwrap();
    let got = desk.root().join("got");
    fs::write(folder.join("grip.sh"), format!("cat in/metrics.csv > {}\n{TABLE}", got.display()))
        .unwrap();
    desk.finish().exits(0);
    let sealed = zwidth_line(desk.root(), "run small --allow-scripts");
    assert!(sealed.code != Some(1) && !got.exists(), "{sealed:#?}");
    desk.unseal().exits(0);
    zwidth_line(desk.root(), "run small --allow-scripts --fresh");
    let got = fs::read_to_string(got).unwrap();
    assert!(got.contains(",hybrid,") && !got.contains("sealed-"), "{got}");
}
