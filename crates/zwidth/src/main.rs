//! Force-feedback (haptics) studies: trials with a motor-and-brake device recorded as Parquet,
//! pipelines from these files to every figure and table, a simulator that solves the device's
//! hybrid dynamics exactly, and the statistics and the report of a study.
//!
//! This crate is the command line. `main.rs` is its table of contents: the arguments and the work
//! of each command are in one file of `commands`. The commands call the workspace below, floor by
//! floor; a crate knows those above it in this table, and none below:
//!
//! | crates | what they are | begin with |
//! |---|---|---|
//! | [`zwidth_study`] | the words of a study: trials, sessions, events, modes, environments | [`zwidth_study::Study`] |
//! | [`zwidth_numerics`] | series, dense systems, least squares, exponentials, spectra | [`zwidth_numerics::lsq`] |
//! | [`zwidth_store`] | files of trials and sweeps, journal, logs, recovery, `verify` | [`zwidth_store::StudyData`] |
//! | [`zwidth_stats`] | intervals, tests, mixed models, agreement, power | [`zwidth_stats::paired`] |
//! | [`zwidth_dynamics`] | scenes, models and their solvers, exact and stepped | [`zwidth_dynamics::Solver`] |
//! | [`zwidth_results`] | what the stages find: a row type for each derived table | [`zwidth_results::Row`] |
//! | [`zwidth_device`], [`zwidth_link`] | the device as a trait, its twin, its loop; boards behind a serial line | [`zwidth_device::Device`] |
//! | [`zwidth_draw`], [`zwidth_tables`], `zwidth_frames` | figures as SVG, PDF and PNG; tables in print; rows in groups | [`zwidth_draw::Figure`] |
//! | [`zwidth_import`] | recordings of other rigs, through a mapping file | [`zwidth_import::import`] |
//! | `pipelines/*`, as [`zwidth_metrics`], [`zwidth_replay`], [`zwidth_report`] | one stage each, from rows to rows | [`zwidth_metrics::by_condition`] |
//! | [`zwidth_runner`], [`zwidth_plan`] | jobs that are skipped when nothing changed; which stage reads and makes which files | [`zwidth_plan::jobs`] |
//! | [`zwidth_acquire`] | a session: its flow, its runner, its screens | [`zwidth_acquire::Session`] |
//!
//! `ARCHITECTURE.md` tells how they work together, `CONTRIBUTING.md` where the next metric,
//! figure, model or format goes, and `docs/` what users read.

mod args;
mod commands;
mod devices;
mod exit;
mod limits;
mod screen;
mod text;
mod workbook;

use anyhow::Context as _;
use args::{Args, Command};
use clap::Parser;
use clap::error::ErrorKind;
use exit::Exit;
use std::path::Path;
use std::process::ExitCode;

/// Tables of a hundred columns and the columns of trials come and go on every core: with the system's
/// allocator a run of a large study takes a seventh longer.
#[global_allocator]
static MEMORY: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    // A decoder's panic on a damaged file is caught and told as an error of that file; its own
    // words would only confuse.
    std::panic::set_hook(Box::new(|_| {}));
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => return refused(&error),
    };
    let screen = screen::Screen::new(args.quiet, args.verbose, args.json);
    let result = exit::guarded(|| {
        let exit = run(args, &screen)?;
        screen.check().map(|()| exit)
    });
    let exit = result.unwrap_or_else(|error| {
        screen.error(&error);
        Exit::Failed
    });
    ExitCode::from(exit as u8)
}

/// Prints what is wrong with the arguments, or the help (`--help`); where a study is
/// missing, which ones there are.
fn refused(error: &clap::Error) -> ExitCode {
    let _ = error.print();
    let lacks_study = error.kind() == ErrorKind::MissingRequiredArgument
        && error.to_string().lines().any(|line| line.trim() == "<STUDY>");
    if lacks_study {
        // The arguments could not be parsed, so that the root has to be looked up in them.
        let studies = commands::studies_of(std::env::args_os());
        if !studies.is_empty() {
            screen::Screen::new(false, false, false).say(format!("studies here: {studies}"));
        }
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

fn run(args: Args, screen: &screen::Screen) -> anyhow::Result<Exit> {
    if let Some(threads) = args.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().with_context(|| {
            format!("cannot start {threads} threads; choose fewer with --threads")
        })?;
    }
    // "./raw" reads as "raw" in everything that is printed.
    let root = if args.root == Path::new(".") { Path::new("") } else { &args.root };
    match args.command {
        Command::Run(command) => commands::run::run(root, &command, screen),
        Command::Allow(command) => commands::allow::allow(root, &command, screen),
        Command::Shards(command) => commands::shards::shards(root, &command, screen),
        Command::Merge(command) => commands::shards::merge(root, &command, screen),
        Command::New { study, imported } => commands::new::new(root, study, imported, screen),
        Command::Acquire(command) => commands::acquire::acquire(root, &command, screen),
        Command::Participant(command) => commands::participant::participant(root, &command, screen),
        Command::Ports { ports } => commands::ports::ports(&ports, screen),
        Command::Check(command) => commands::check::check(root, &command, screen),
        Command::Characterise(command) => {
            commands::characterise::characterise(root, &command, screen)
        }
        Command::Twin(command) => commands::twin::twin(root, &command, screen),
        Command::Exclude(command) => commands::said::exclude(root, &command, screen),
        Command::Note(command) => commands::said::note(root, &command, screen),
        Command::Answer(command) => commands::said::answer(root, &command, screen),
        Command::Beside(command) => commands::beside::beside(root, &command, screen),
        Command::Metric(command) => commands::metric::metric(root, &command, screen),
        Command::Unseal(command) => commands::unseal::unseal(root, &command, screen),
        Command::Recover(command) => commands::recover::recover(root, &command, screen),
        Command::Import(command) => commands::import::import(root, &command, screen),
        Command::Verify { studies } => commands::verify::verify(root, studies, screen),
        Command::List { study } => commands::list::list(root, study, screen),
        Command::Judge(command) => commands::judge::judge(&command, screen),
        Command::Simulate(command) => commands::simulate::simulate(root, &command, screen),
        Command::Trade(command) => commands::trade::trade(root, &command, screen),
        Command::Ladder(command) => commands::ladder::ladder(root, &command, screen),
        Command::Stability(command) => commands::stability::stability(root, &command, screen),
        Command::Compare(command) => commands::compare::compare(root, &command, screen),
        Command::Power(command) => commands::power::power(root, &command, screen),
        Command::Open(command) => commands::open::open(root, &command, screen),
        Command::Export(command) => commands::export::export(root, &command, screen),
        Command::Figure(command) => commands::figure::figure(root, &command, screen),
        Command::Table(command) => commands::table::table(root, &command, screen),
        Command::Methods(command) => commands::methods::methods(root, &command, screen),
        Command::Why(command) => commands::why::why(root, &command, screen),
        Command::Trace(command) => commands::trace::trace(root, &command, screen),
        Command::Completions { shell } => commands::shell::completions(shell, screen),
        Command::Man { out } => commands::shell::man(out.as_deref(), screen),
        Command::Licences => commands::shell::licences(screen),
    }
}
