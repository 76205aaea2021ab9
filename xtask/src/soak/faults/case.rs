//! The commands whose calls fail, each in a study that it changes.

use anyhow::ensure;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use zwidth_study::{StudyId, template};

/// The study of every case.
const STUDY: &str = "demo";

/// What an error leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The command does one thing: all of it or nothing.
    Whole,
    /// It does many things one after the other (sweeps, jobs of a run), each of them whole; given
    /// again, it does the rest.
    Steps,
    /// A session: trials that were said to be stored are, and it goes on to its end. What is asked
    /// and answered may differ.
    Session,
}

pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    /// Lays down what was there before the command.
    pub(super) prepare: fn(&Path, &Path) -> anyhow::Result<()>,
    /// Its words ([`words`]).
    pub(super) line: &'static str,
    /// What begins with these names is compared.
    pub(super) looked_at: &'static [&'static str],
    /// Whether `recover` brings the study in order after it.
    pub(super) recovers: bool,
    /// Whether `verify` then finds nothing.
    pub(super) verifies: bool,
    /// One call in so many is tried, of a command that makes thousands.
    pub(super) stride: u64,
}

const WHOLE: Case = Case {
    name: "",
    kind: Kind::Whole,
    prepare: study,
    line: "",
    looked_at: &["raw/"],
    recovers: true,
    verifies: true,
    stride: 1,
};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "new",
        prepare: |_, root| Ok(std::fs::create_dir_all(root)?),
        line: "new demo",
        recovers: false,
        verifies: false,
        ..WHOLE
    },
    Case {
        name: "import trials",
        prepare: empty,
        line: "import demo --map trials.toml P01.csv P02.csv",
        ..WHOLE
    },
    Case { name: "import sweeps", line: "import demo --map sweeps.toml more.csv", ..WHOLE },
    Case { name: "import answers", line: "import demo --map likert.toml likert.csv", ..WHOLE },
    Case {
        name: "exclude",
        line: "exclude demo -p P01 -s S01 --trial 1,2 the_phone_rang",
        ..WHOLE
    },
    Case { name: "note", line: "note demo -p P01 -s S01 left-handed", ..WHOLE },
    Case { name: "answer", line: "answer demo -p P01 -s S01 --trial 1 4", ..WHOLE },
    Case { name: "answer --from", line: "answer demo --from answers.csv", ..WHOLE },
    Case {
        name: "metric",
        line: "metric demo --from values.csv --id grip --unit N --label grip",
        ..WHOLE
    },
    Case {
        name: "metric --withdraw",
        prepare: given,
        line: "metric demo --withdraw grip wrong",
        ..WHOLE
    },
    Case {
        name: "accept a changed study.toml",
        prepare: changed,
        line: "recover demo --accept-study-change",
        verifies: false,
        ..WHOLE
    },
    Case {
        name: "unseal",
        prepare: sealed,
        line: "unseal demo -p P01 -s S01 --key keys --unfinished",
        ..WHOLE
    },
    Case {
        name: "characterise",
        kind: Kind::Steps,
        line: "characterise demo motor --device twin --sweeps 1",
        ..WHOLE
    },
    Case {
        name: "power --plan",
        line: "power demo --difference 0.5 --participants 6 --studies 100 --participant-sd 1 \
               --participant-mode-sd 0.5 --residual-sd 1 --plan",
        ..WHOLE
    },
    Case {
        name: "acquire",
        kind: Kind::Session,
        prepare: empty,
        line: "acquire demo -p P01 -s S01 --plain --auto --fast --seed 1",
        stride: 5,
        ..WHOLE
    },
    Case {
        name: "acquire, blinded",
        kind: Kind::Session,
        prepare: blinded,
        line: BLINDED,
        stride: 13,
        ..WHOLE
    },
    Case {
        name: "run",
        kind: Kind::Steps,
        prepare: simulated,
        line: "--threads 1 run demo --quiet",
        looked_at: &["derived/", "reports/"],
        recovers: false,
        verifies: false,
        stride: 397,
    },
    Case {
        name: "export",
        prepare: with_results,
        line: "export demo --to out --with bids,mcap,mat,samples-csv,xlsx",
        looked_at: &["out/"],
        recovers: false,
        verifies: false,
        stride: 97,
        ..WHOLE
    },
];

const BLINDED: &str = "acquire demo -p P01 -s S01 --plain --auto --fast --key keys";

/// The words of a line; `_` stands for a space within one.
pub(super) fn words(line: &str) -> impl Iterator<Item = String> {
    line.split(' ').map(|word| word.replace('_', " "))
}

/// Runs the program, which must not fail.
fn run(program: &Path, root: &Path, line: &str) -> anyhow::Result<()> {
    let mut command = Command::new(program);
    let output = command.current_dir(root).arg("--root").arg(root).args(words(line)).output()?;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{line}: {errors}");
    Ok(())
}

/// A study without a recording that plans one trial of each condition and one to get used to it, its
/// text changed so, and the files to import.
fn laid_down(root: &Path, changes: &[(&str, &str)]) -> anyhow::Result<()> {
    let text = crate::soak::changed(template(&StudyId::new(STUDY)?), &SHORT)?;
    let text = crate::soak::changed(text, changes)?;
    let raw = root.join("raw").join(STUDY);
    std::fs::create_dir_all(&raw)?;
    std::fs::write(raw.join("study.toml"), text)?;
    for person in ["P01", "P02"] {
        let mut rows = "who,mode,n,t,f\n".to_owned();
        for (trial, mode) in [(1, "active"), (2, "passive")] {
            for sample in 0..40 {
                let t_s = f64::from(sample) * 0.01;
                let force_n = (f64::from(sample) * 0.7).sin() + f64::from(trial);
                writeln!(rows, "{person},{mode},{trial},{t_s},{force_n}")?;
            }
        }
        std::fs::write(root.join(format!("{person}.csv")), rows)?;
    }
    std::fs::write(root.join("trials.toml"), TRIALS)?;
    std::fs::write(root.join("sweeps.toml"), SWEEPS)?;
    std::fs::write(root.join("likert.toml"), LIKERT)?;
    std::fs::write(root.join("first.csv"), "n,u,f\n1,0,1\n1,1,2\n")?;
    std::fs::write(root.join("more.csv"), "n,u,f\n2,0,1\n2,1,2\n3,0,1\n3,1,3\n")?;
    std::fs::write(root.join("likert.csv"), "who,mode,a\nP03,active,1\nP04,passive,3\n")?;
    let answers =
        "participant,session,trial,answer\nP01,S01,1,4\nP01,S01,2,2\nP02,S01,1,5\nP02,S01,2,1\n";
    std::fs::write(root.join("answers.csv"), answers)?;
    std::fs::write(root.join("values.csv"), answers.replace("answer", "value"))?;
    Ok(())
}

fn empty(_program: &Path, root: &Path) -> anyhow::Result<()> {
    laid_down(root, &[])
}

/// Two people, two trials each, and a sweep.
fn study(program: &Path, root: &Path) -> anyhow::Result<()> {
    laid_down(root, &[])?;
    run(program, root, "import demo --map trials.toml P01.csv P02.csv")?;
    run(program, root, "import demo --map sweeps.toml first.csv")
}

/// The same with values of a metric that another program computed.
fn given(program: &Path, root: &Path) -> anyhow::Result<()> {
    study(program, root)?;
    run(program, root, "metric demo --from values.csv --id grip --unit N --label grip")
}

/// A simulated session, of which every result can be made.
fn simulated(program: &Path, root: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(root)?;
    run(program, root, "twin demo --participants 1 --sessions 1 --rate 250")
}

/// A simulated study and its results.
fn with_results(program: &Path, root: &Path) -> anyhow::Result<()> {
    simulated(program, root)?;
    run(program, root, "run demo --quiet")
}

/// Two people and a sweep, with a `study.toml` that was changed since.
fn changed(program: &Path, root: &Path) -> anyhow::Result<()> {
    study(program, root)?;
    let path = root.join("raw").join(STUDY).join("study.toml");
    let text = std::fs::read_to_string(&path)?;
    Ok(std::fs::write(path, text.replace("pause_s = 5.0", "pause_s = 4.0"))?)
}

/// One trial of each condition and one to get used to it.
const SHORT: [(&str, &str); 2] = [
    ("\nrepeats = 6\n", "\nrepeats = 1\n"),
    ("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n"),
];

fn blinded(_program: &Path, root: &Path) -> anyhow::Result<()> {
    laid_down(root, &[("\nblinded = false\n", "\nblinded = true\n")])
}

/// A blinded session that was recorded.
fn sealed(program: &Path, root: &Path) -> anyhow::Result<()> {
    blinded(program, root)?;
    run(program, root, BLINDED)
}

const TRIALS: &str = r#"
kind = "trials"
[trial]
participant = { column = "who" }
session = "S01"
environment = "spring"
mode = { column = "mode" }
trial = { column = "n" }
[time]
from = "t"
unit = "s"
[[column]]
to = "force_ex_n"
from = "f"
unit = "N"
"#;

const SWEEPS: &str = r#"
kind = "sweeps"
[sweep]
actuator = "brake"
sweep = { column = "n" }
[command]
name = "u"
unit = "V"
from = "u"
[response]
name = "f"
unit = "N"
from = "f"
"#;

const LIKERT: &str = r#"
kind = "likert"
[trial]
participant = { column = "who" }
session = "S01"
environment = "spring"
mode = { column = "mode" }
[questions.columns]
felt_spring = "a"
"#;
