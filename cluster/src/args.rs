//! The command line.

use crate::watch::Address;
use clap::{Parser, Subcommand};
use std::net::SocketAddr;
use std::num::NonZeroU16;
use std::path::PathBuf;
use std::time::Duration;
use zwidth_study::StudyId;

/// The jobs of a study's trials on the executors of a Ballista cluster
#[derive(Debug, Parser)]
#[command(name = "zwidth-cluster", version, about)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Say what goes on inside, too
    #[arg(long, short, global = true)]
    pub(crate) verbose: bool,
    /// Say only what went wrong
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Be the scheduler, until this process is ended
    #[command(
        after_help = "Example:\n  zwidth-cluster scheduler --bind 0.0.0.0:50050 --host node1"
    )]
    Scheduler(Scheduler),
    /// Be an executor, until this process is ended
    #[command(
        after_help = "Example:\n  zwidth-cluster executor --scheduler node1:50050 --bind 0.0.0.0:50051 --host node2"
    )]
    Executor(Executor),
    /// Make what is derived from trials on the cluster; `zwidth run STUDY --cluster` calls it
    #[command(after_help = "Example:\n  zwidth-cluster run thesis-twin --scheduler node1:50050")]
    Run(Run),
    /// Copy the recordings of a study from an object store into a data folder that does not have it
    #[command(after_help = "Example:\n  zwidth-cluster fetch thesis-twin --raw s3://bucket/prefix")]
    Fetch(Fetch),
}

#[derive(Debug, clap::Args)]
pub(crate) struct Scheduler {
    /// Where to listen. Whoever can reach this address can use the executors
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:50050")]
    pub(crate) bind: SocketAddr,
    /// The name by which others reach this machine [default: the address]
    #[arg(long, value_name = "HOST")]
    pub(crate) host: Option<String>,
    /// After so many seconds without a word an executor is given up, and others do its tasks. One
    /// that is busy says a word every 5 s
    #[arg(long, value_name = "SECONDS", default_value_t = 30, value_parser = clap::value_parser!(u64).range(10..=3600))]
    pub(crate) executor_timeout: u64,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Executor {
    /// The scheduler's address
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) scheduler: Address,
    /// Where to listen for clients that fetch results
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:50051")]
    pub(crate) bind: SocketAddr,
    /// The name by which clients reach this machine [default: the address]
    #[arg(long, value_name = "HOST")]
    pub(crate) host: Option<String>,
    /// How many tasks it does at a time
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) cores: NonZeroU16,
    /// Where it may write [default: the system's folder for temporary files]
    #[arg(long, value_name = "DIR")]
    pub(crate) scratch: Option<PathBuf>,
    /// How long to wait for the scheduler
    #[arg(long, value_name = "SECONDS", default_value_t = 60)]
    pub(crate) patience: u64,
    #[command(flatten)]
    pub(crate) store: Store,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Run {
    /// The study
    pub(crate) study: StudyId,
    /// The scheduler's address
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) scheduler: Address,
    /// The folder that holds raw/, derived/ and reports/
    #[arg(long, value_name = "DIR", env = "ZWIDTH_ROOT", default_value = ".")]
    pub(crate) root: PathBuf,
    /// Where executors find raw/: a folder that all machines share, or an object store
    /// [default: the same folder as here]
    #[arg(long, value_name = "DIR|s3://BUCKET/PREFIX")]
    pub(crate) raw: Option<String>,
    /// How long one part may take, with its waiting and all attempts at it
    #[arg(long, value_name = "SECONDS", default_value_t = 1800, value_parser = clap::value_parser!(u64).range(1..=604_800))]
    pub(crate) deadline: u64,
    /// How long the cluster may be without scheduler or executors
    #[arg(long, value_name = "SECONDS", default_value_t = 60)]
    pub(crate) patience: u64,
    /// How many parts are with the scheduler at a time
    #[arg(long, value_name = "N", default_value = "32")]
    pub(crate) at_once: NonZeroU16,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Fetch {
    /// The study
    pub(crate) study: StudyId,
    /// Where its recordings lie: raw/STUDY/ is below
    #[arg(long, value_name = "DIR|s3://BUCKET/PREFIX")]
    pub(crate) raw: String,
    /// The folder that is to hold raw/STUDY
    #[arg(long, value_name = "DIR", env = "ZWIDTH_ROOT", default_value = ".")]
    pub(crate) root: PathBuf,
    #[command(flatten)]
    pub(crate) store: Store,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Store {
    /// How long the place where recordings lie may be silent
    #[arg(long = "store-timeout", value_name = "SECONDS", default_value_t = 30, value_parser = clap::value_parser!(u64).range(1..=3600))]
    timeout: u64,
}

impl Store {
    pub(crate) fn timeout(&self) -> Duration {
        Duration::from_secs(self.timeout)
    }
}
