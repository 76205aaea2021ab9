//! `zwidth-cluster`: Ballista beside the shards (docs/scale.md). What a shard makes of a study's
//! trials, executors of a cluster can make too: the same plan, the same jobs, and so the same bytes.
//!
//! A query has one row and calls one function ([`function`]), from a task to its answer ([`task`]).
//! An executor fetches the raw files that the task names ([`source`]) and runs the task's jobs
//! ([`part`]). The client says which jobs those are ([`slice`]), gives the tasks to the engine
//! ([`engine`]), keeps an eye on the cluster ([`watch`]), and merges what comes back ([`run`]).

mod args;
mod engine;
mod fetch;
mod function;
mod pack;
mod part;
mod run;
mod say;
mod serve;
mod slice;
mod source;
mod task;
mod watch;

use args::{Args, Command};
use clap::Parser as _;
use say::{Say, log_engine};
use std::process::ExitCode;
use tokio::runtime::{Builder, Runtime};
use zwidth_store::StoreError;

/// How the program ends, as `zwidth` does. Bad arguments give 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Exit {
    /// All was done.
    Fine = 0,
    /// Done, but something is missing; it was listed.
    Partly = 3,
}

/// Stack of the engine's threads, bytes: plans are walked recursively.
const STACK: usize = 1 << 25;

fn main() -> ExitCode {
    let args = Args::parse();
    let say = Say { quiet: args.quiet };
    let serves = matches!(args.command, Command::Scheduler(_) | Command::Executor(_));
    log_engine(args.verbose, serves);
    let runtime = Builder::new_multi_thread().enable_all().thread_stack_size(STACK).build();
    let done = runtime.map_err(Into::into).and_then(|runtime| {
        let done = obey(&args.command, &runtime, say);
        // A disk that is silent is not waited for.
        runtime.shutdown_background();
        done
    });
    match done {
        Ok(exit) => ExitCode::from(exit as u8),
        Err(error) => {
            say.error(&error);
            ExitCode::FAILURE
        }
    }
}

fn obey(command: &Command, runtime: &Runtime, say: Say) -> anyhow::Result<Exit> {
    match command {
        Command::Scheduler(args) => {
            runtime.block_on(serve::scheduler(args, say)).map(|()| Exit::Fine)
        }
        Command::Executor(args) => runtime.block_on(serve::executor(args)).map(|()| Exit::Fine),
        Command::Run(args) => run::run(args, runtime, say),
        Command::Fetch(args) => fetch::fetch(args, runtime, say),
    }
}

/// Several findings as one error, a line each.
fn joined(findings: &[StoreError]) -> anyhow::Error {
    let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
    anyhow::anyhow!("{}", lines.join("\n       "))
}
