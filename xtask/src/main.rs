//! Chores of the workspace: `cargo xtask NAME`.
#![allow(clippy::print_stdout)] // a chore tells what it did

mod bench;
mod bits;
#[cfg(unix)]
mod board;
mod emulator;
mod encodings;
mod firmware;
mod fuzz;
mod hx711;
mod licences;
mod messages;
mod pictures;
mod played;
mod room;
mod sheet;
mod shell;
mod soak;
mod stale;
mod tried;
mod twin;

use anyhow::{Context as _, bail};
use soak::compared::{From, compared};
use soak::simulate::{With, simulate};
use soak::{
    coverage, extremes, faults, judge, kill, kill_tasks, live, loops, mistakes, properties,
    statistics, thesis, wire,
};
#[cfg(unix)]
use soak::{terminals, watchdog};
use std::path::Path;

const CHORES: &str =
    "cargo xtask thesis-twin                write raw/thesis-twin anew (the same bytes every time)
cargo xtask board STUDY.TOML [LINK [SEED]] a board with the simulated device at the end of a serial line, to record from; it speaks
    framed, firmata, firmata-uno, firmata-i2c or text [framed, seed 1]
cargo xtask firmware-sessions N COMMAND… two whole sessions of N × 3 trials at that firmware, one with its cable pulled under voltage
cargo xtask firmware COMMAND…          our host at our firmware, which COMMAND runs in an emulator: readings, voltages, noise, the watchdog
cargo xtask hx711 COMMAND…             our reader at the load cell's sketch, which COMMAND runs in an emulator with an HX711 at its pins
cargo xtask soak kill [KILLS [SEED]]   kill -9 a running acquisition at random instants [1000, seed 1]
cargo xtask soak kill-tasks [KILLS [SEED]] the same of sessions whose levels follow from their answers [100, seed 1]
cargo xtask soak faults [EVERY [NAME…]] each call of every command to the file system (or one in EVERY, or of the commands named) fails: full disk, errors, kill [1]
cargo xtask soak mistakes [STUDIES [FIRST]] recordings of others with one mistake each, and clean ones, through the import [10000, from 0]
cargo xtask soak live [MINUTES [LINK]] record at 1 kHz in real time, from the simulated device or from a board with it over a link, and count what is lost [10]
cargo xtask soak watchdog [CUTS [SEED]] kill hosts and pull cables under voltage: the board goes to 0 V [100, seed 1]
cargo xtask soak terminals [TRIES [SEED]] close windows and end readers at random instants of a session: the program ends in order [100, seed 1]
cargo xtask soak wire [EVERY]          a session over each link with one message gone wrong, for every (or every so-manieth) message and trouble [1]
cargo xtask soak wire-sessions         sessions of 36 trials over each link at its rate, in simulated time: no reading is lost
cargo xtask bench [read|short] [NAME…] every bench beside its peers, or those named; writes benches/RESULTS.md, and fails where a committed ratio is 10 % worse (read: as measured last, nothing is run; short: each once on little, only to see that it runs)
cargo xtask bits                       the main job's bytes: one thread, many, other processors (qemu-user), as written down
cargo xtask bits --without-origin      only their content, without what files say of their making, against what is written down
cargo xtask bits renew                 writes that content down
cargo xtask sheet [FOLDER]             every figure at print size, in grey and as without green cones, beside its caption [reports/thesis-twin/figures]
cargo xtask room [FOLDER STUDY]        no two words of any figure of three studies, or of one, lie on each other or are below 7 pt, in one column and in two
cargo xtask pictures [renew]           the figures in README and docs are what the program makes of the study that comes along; or makes them anew
cargo xtask stale [ONE_IN]             each field of study.toml (or one in so many), a session and each stage's parameters changed: no stale result
cargo xtask soak coverage [SEEDS]      how often intervals of identified parameters hold the twin's truth [400]
cargo xtask soak loops [SESSIONS]      every mean of force against position lies between its repeats [1000]
cargo xtask soak thesis [SEEDS]        how often the thesis' statements hold for the twin over its ranges; writes docs/twin.md [200]
cargo xtask soak compared [SEEDS [PEOPLE|FILE]] how often comparisons of studies drawn from simulated people (or from their metrics in FILE) are right [1000, of 1000]
cargo xtask soak simulate [SEEDS [FIRST]] whole sessions in memory with faults drawn from a seed each [100000, from 0]
cargo xtask soak simulate-twin [SEEDS [FIRST]] the same with the simulated device and participant [1000, from 0]
cargo xtask soak properties [CASES [SEED]] fresh cases for every random property [1000000, a new seed]
cargo xtask soak judge [SCENES]         right and wrong trajectories of random scenes: none may be misjudged [10000]
cargo xtask soak extremes [SCENES]      scenes, answers and paths at the extremes; writes docs/extremes.md [1000000]
cargo xtask soak r [SETS [SEED]]       statistics against R, SciPy and statsmodels on so many random data sets [1000]
cargo xtask soak null [STUDIES [PART]] tests, intervals and power on studies without an effect, or those tests of null_studies whose names have PART [40000, all]
cargo xtask fuzz TARGET|all|seeds [RUNS] any bytes for a reader, or for all of them; or the files they begin from, anew [10000000 or 1000000]
cargo xtask licences                   the notices of what is linked into the program, anew, for `zwidth licences`
cargo xtask messages                   every text that a person can be told, with its file and line
cargo xtask reliability                write what was tried into docs/reliability.md
cargo xtask encodings STUDY            measure column encodings on a study under raw/: size and speed";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["thesis-twin"] => twin::write(Path::new(".")),
        #[cfg(unix)]
        ["board", study, rest @ ..] => {
            let link = rest.first().copied().unwrap_or("framed");
            board::run(Path::new(study), link, number(rest, 1, 1)?)
        }
        ["firmware", command @ ..] => firmware::run(command),
        ["firmware-sessions", _, command @ ..] => {
            firmware::sessions(number(&words, 1, 1)?, command)
        }
        ["hx711", command @ ..] => hx711::run(command),
        ["soak", chore, rest @ ..] => soak_by_word(chore, rest),
        ["bench", rest @ ..] => bench::bench(rest),
        ["bits"] => bits::compare(bits::How::AllWays),
        ["bits", "--without-origin"] => bits::compare(bits::How::WithoutOrigin),
        ["bits", "renew"] => bits::compare(bits::How::Renew),
        ["sheet", rest @ ..] => {
            let figures = rest.first().copied().unwrap_or("reports/thesis-twin/figures");
            sheet::write(Path::new(figures), Path::new("reports/sheet"))
        }
        ["room"] => room::room(),
        ["room", folder, study] => room::look(Path::new(folder), study),
        ["pictures"] => pictures::pictures(false),
        ["pictures", "renew"] => pictures::pictures(true),
        ["stale", rest @ ..] => stale::stale(number(rest, 0, 1)?),
        ["fuzz", which, rest @ ..] => {
            let runs = rest.first().map(|_| number(rest, 0, 0)).transpose()?;
            fuzz::fuzz(which, runs)
        }
        ["licences"] => licences::write(),
        ["messages"] => messages::list(Path::new(".")),
        ["reliability"] => tried::reliability(),
        ["encodings", study] => encodings::measure(Path::new("."), study),
        _ => bail!("the chores are\n{CHORES}"),
    }
}

/// A soak by its word and what is said of it: two numbers, as a rule.
fn soak_by_word(chore: &str, rest: &[&str]) -> anyhow::Result<()> {
    match chore {
        "kill" => kill::kill(number(rest, 0, 1000)?, number(rest, 1, 1)?),
        "kill-tasks" => kill_tasks::kill_tasks(number(rest, 0, 100)?, number(rest, 1, 1)?),
        "faults" => faults::faults(number(rest, 0, 1)?, rest.get(1..).unwrap_or_default()),
        "mistakes" => mistakes::mistakes(number(rest, 0, 10_000)?, number(rest, 1, 0)?),
        "live" => live::live(number(rest, 0, 10.0)?, rest.get(1).copied()),
        #[cfg(unix)]
        "watchdog" => watchdog::watchdog(number(rest, 0, 100)?, number(rest, 1, 1)?),
        #[cfg(unix)]
        "terminals" => terminals::terminals(number(rest, 0, 100)?, number(rest, 1, 1)?),
        "wire" => wire::wire(number(rest, 0, 1)?),
        "wire-sessions" => wire::whole(),
        // What `soak watchdog` runs and cuts off.
        #[cfg(unix)]
        "host" => watchdog::host(Path::new(rest.first().copied().unwrap_or_default())),
        "coverage" => coverage::coverage(number(rest, 0, 400)?),
        "loops" => loops::loops(number(rest, 0, 1000)?),
        "thesis" => thesis::thesis(number(rest, 0, thesis::SEEDS)?),
        "compared" => {
            let from = match rest.get(1) {
                Some(file) if Path::new(file).is_file() => From::Table(file.into()),
                _ => From::Simulated(number(rest, 1, 1000)?),
            };
            compared(number(rest, 0, 1000)?, &from)
        }
        "simulate" => simulate(With::Mock, number(rest, 0, 100_000)?, number(rest, 1, 0)?),
        "simulate-twin" => simulate(With::Twin, number(rest, 0, 1000)?, number(rest, 1, 0)?),
        "properties" => {
            let fresh = jiff::Timestamp::now().as_microsecond().unsigned_abs();
            properties::properties(number(rest, 0, 1_000_000)?, number(rest, 1, fresh)?)
        }
        "extremes" => extremes::extremes(number(rest, 0, extremes::SCENES)?),
        "judge" => judge::judge(number(rest, 0, judge::SCENES)?),
        "r" => {
            let seed = rest.get(1).map(|_| number(rest, 1, 0)).transpose()?;
            statistics::against_r(number(rest, 0, statistics::SETS)?, seed)
        }
        "null" => statistics::null(number(rest, 0, statistics::STUDIES)?, rest.get(1).copied()),
        _ => bail!("the chores are\n{CHORES}"),
    }
}

/// The number at a place among words, or what stands for it.
fn number<T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>>(
    words: &[&str],
    at: usize,
    default: T,
) -> anyhow::Result<T> {
    words.get(at).map_or(Ok(default), |word| {
        word.parse().with_context(|| format!("'{word}' is not a number"))
    })
}
