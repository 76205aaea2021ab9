//! Chores of the workspace: `cargo xtask NAME`.
#![allow(clippy::print_stdout)] // a chore tells what it did

mod bench;
mod bits;
mod board;
mod emulator;
mod encodings;
mod firmware;
mod fuzz;
mod hx711;
mod messages;
mod pictures;
mod played;
mod room;
mod sheet;
mod soak;
mod stale;
mod tried;
mod twin;

use anyhow::{Context as _, bail};
use soak::compared::{From, compared};
use std::path::{Path, PathBuf};

const CHORES: &str =
    "cargo xtask thesis-twin                write raw/thesis-twin anew (the same bytes every time)
cargo xtask board STUDY.TOML [LINK [SEED]] a board with the simulated device at the end of a serial line, to record from; it speaks
    framed, firmata, firmata-uno, firmata-i2c or text [framed, seed 1]
cargo xtask firmware-sessions N COMMAND… two whole sessions of N × 3 trials at that firmware, one with its cable pulled under voltage
cargo xtask firmware COMMAND…          our host at our firmware, which COMMAND runs in an emulator: readings, voltages, noise, the watchdog
cargo xtask hx711 COMMAND…             our reader at the load cell's sketch, which COMMAND runs in an emulator with an HX711 at its pins
cargo xtask soak kill [KILLS [SEED]]   kill -9 a running acquisition at random instants [1000, seed 1]
cargo xtask soak faults [EVERY [NAME…]] each call of every command to the file system (or one in EVERY, or of the commands named) fails: full disk, errors, kill [1]
cargo xtask soak mistakes [STUDIES [FIRST]] recordings of others with one mistake each, and clean ones, through the import [10000, from 0]
cargo xtask soak live [MINUTES [LINK]] record at 1 kHz in real time, from the simulated device or from a board with it over a link, and count what is lost [10]
cargo xtask soak watchdog [CUTS [SEED]] kill hosts and pull cables under voltage: the board goes to 0 V [100, seed 1]
cargo xtask soak terminals [TRIES [SEED]] close windows and end readers at random instants of a session: the program ends in order [100, seed 1]
cargo xtask soak wire [EVERY]          a session over each link with one message gone wrong, for every (or every so-manieth) message and trouble [1]
cargo xtask soak wire-sessions         sessions of 36 trials over each link at its rate, in simulated time: no reading is lost
cargo xtask bench [read] [NAME…]       every bench beside its peers, or those named; writes benches/RESULTS.md, and fails where a committed ratio is 10 % worse (read: as measured last, nothing is run)
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
cargo xtask soak extremes [SCENES]      scenes at the extremes; writes docs/extremes.md [1000000]
cargo xtask soak r [SETS [SEED]]       statistics against R, SciPy and statsmodels on so many random data sets [1000]
cargo xtask soak null [STUDIES [PART]] tests, intervals and power on studies without an effect, or those tests of null_studies whose names have PART [40000, all]
cargo xtask fuzz TARGET|all|seeds [RUNS] any bytes for a reader, or for all of them; or the files they begin from, anew [10000000 or 1000000]
cargo xtask messages                   every text that a person can be told, with its file and line
cargo xtask reliability                write what was tried into docs/reliability.md
cargo xtask encodings STUDY            measure column encodings on a study under raw/: size and speed";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["thesis-twin"] => twin::write(Path::new(".")),
        ["board", study, rest @ ..] => {
            let link = rest.first().copied().unwrap_or("framed");
            board::run(Path::new(study), link, number(rest.get(1), 1)?)
        }
        ["firmware", command @ ..] => firmware::run(command),
        ["firmware-sessions", repeats, command @ ..] => {
            firmware::sessions(number(Some(repeats), 1)?, command)
        }
        ["hx711", command @ ..] => hx711::run(command),
        ["soak", "kill", rest @ ..] => {
            let kills = number(rest.first(), 1000)?;
            soak::kill::kill(&soak::program()?, &scratch("kill"), kills, number(rest.get(1), 1)?)
        }
        ["soak", "faults", rest @ ..] => {
            let every = number(rest.first(), 1)?;
            let named = rest.get(1..).unwrap_or_default();
            soak::faults::faults(&soak::program()?, &scratch("faults"), every, named)
        }
        ["soak", "mistakes", rest @ ..] => soak::mistakes::mistakes(
            &scratch("mistakes"),
            number(rest.first(), 10_000)?,
            number(rest.get(1), 0)?,
        ),
        ["soak", "live", rest @ ..] => {
            let minutes = number(rest.first(), 10.0)?;
            let link = rest.get(1).copied();
            soak::live::live(&soak::program()?, &scratch("live"), minutes, link)
        }
        ["soak", "watchdog", rest @ ..] => {
            let cuts = number(rest.first(), 100)?;
            soak::watchdog::watchdog(&scratch("watchdog"), cuts, number(rest.get(1), 1)?)
        }
        ["soak", "terminals", rest @ ..] => {
            let tries = number(rest.first(), 100)?;
            let seed = number(rest.get(1), 1)?;
            soak::terminals::terminals(&soak::program()?, &scratch("terminals"), tries, seed)
        }
        ["soak", "wire", rest @ ..] => soak::wire::wire(number(rest.first(), 1)?),
        ["soak", "wire-sessions"] => soak::wire::whole(),
        // What `soak watchdog` runs and cuts off.
        ["soak", "host", socket] => soak::watchdog::host(Path::new(socket)),
        ["bench", rest @ ..] => bench::bench(rest),
        ["bits", how @ ..] => {
            let how = match how {
                [] => bits::How::AllWays,
                ["--without-origin"] => bits::How::WithoutOrigin,
                ["renew"] => bits::How::Renew,
                _ => bail!("the chores are\n{CHORES}"),
            };
            bits::compare(&soak::program()?, &scratch("bits"), how)
        }
        ["sheet", rest @ ..] => {
            let figures = rest.first().copied().unwrap_or("reports/thesis-twin/figures");
            sheet::write(Path::new(figures), Path::new("reports/sheet"))
        }
        ["room"] => room::room(&soak::program()?, &scratch("room")),
        ["room", folder, study] => room::look(Path::new(folder), study),
        ["pictures"] => pictures::pictures(&soak::program()?, &scratch("pictures"), false),
        ["pictures", "renew"] => pictures::pictures(&soak::program()?, &scratch("pictures"), true),
        ["stale"] => stale::stale(&soak::program()?, &scratch("stale"), 1),
        ["stale", one_in] => stale::stale(&soak::program()?, &scratch("stale"), one_in.parse()?),
        ["soak", "coverage", rest @ ..] => soak::coverage::coverage(
            &soak::program()?,
            &scratch("coverage"),
            number(rest.first(), 400)?,
        ),
        ["soak", "loops", rest @ ..] => {
            soak::loops::loops(&soak::program()?, &scratch("loops"), number(rest.first(), 1000)?)
        }
        ["soak", "thesis", rest @ ..] => soak::thesis::thesis(
            &soak::program()?,
            &scratch("thesis"),
            number(rest.first(), soak::thesis::SEEDS)?,
        ),
        ["soak", "compared", rest @ ..] => {
            let from = match rest.get(1) {
                Some(file) if Path::new(file).is_file() => From::Table(file.into()),
                people => From::Simulated(number(people, 1000)?),
            };
            compared(&scratch("compared"), number(rest.first(), 1000)?, &from)
        }
        ["soak", "simulate", rest @ ..] => {
            let seeds = number(rest.first(), 100_000)?;
            soak::simulate::simulate(soak::simulate::With::Mock, seeds, number(rest.get(1), 0)?)
        }
        ["soak", "simulate-twin", rest @ ..] => {
            let seeds = number(rest.first(), 1000)?;
            soak::simulate::simulate(soak::simulate::With::Twin, seeds, number(rest.get(1), 0)?)
        }
        ["soak", "properties", rest @ ..] => {
            let fresh = jiff::Timestamp::now().as_microsecond().unsigned_abs();
            soak::properties::properties(
                number(rest.first(), 1_000_000)?,
                number(rest.get(1), fresh)?,
            )
        }
        ["soak", "extremes", rest @ ..] => {
            soak::extremes::extremes(number(rest.first(), soak::extremes::SCENES)?)
        }
        ["soak", "r", rest @ ..] => {
            let seed = rest.get(1).map(|seed| number(Some(seed), 0)).transpose()?;
            soak::statistics::against_r(
                &scratch("r"),
                number(rest.first(), soak::statistics::SETS)?,
                seed,
            )
        }
        ["soak", "null", rest @ ..] => soak::statistics::null(
            &scratch("null"),
            number(rest.first(), soak::statistics::STUDIES)?,
            rest.get(1).copied(),
        ),
        ["fuzz", which, rest @ ..] => {
            let runs = rest.first().map(|runs| number(Some(runs), 0)).transpose()?;
            fuzz::fuzz(which, runs)
        }
        ["messages"] => messages::list(Path::new(".")),
        ["reliability"] => tried::reliability(),
        ["encodings", study] => encodings::measure(Path::new("."), study),
        _ => bail!("the chores are\n{CHORES}"),
    }
}

/// A number, or what stands for it.
fn number<T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>>(
    word: Option<&&str>,
    default: T,
) -> anyhow::Result<T> {
    word.map_or(Ok(default), |word| {
        word.parse().with_context(|| format!("'{word}' is not a number"))
    })
}

/// A folder for what a chore makes, beside the system's other temporary ones.
fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("zwidth-soak-{name}-{}", std::process::id()))
}
