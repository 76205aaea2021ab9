//! The command line: parsed here, resolved into work by the commands.

use crate::commands;
use crate::limits::MOST_THREADS;
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use zwidth_study::StudyId;

/// Force-feedback studies: from raw recordings to figures, tables and a summary.
///
/// Exit codes: 0 fine, 1 failed, 2 bad arguments, 3 done but something was skipped or lost, or is
/// to be read with care (and listed).
#[derive(Debug, Parser)]
#[command(name = "zwidth", version, max_term_width = 100)]
pub(crate) struct Args {
    /// Folder that holds raw/, derived/ and reports/
    #[arg(long, global = true, env = "ZWIDTH_ROOT", default_value = ".", value_name = "DIR")]
    pub(crate) root: PathBuf,
    /// Listings as JSON, for machines
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Number of threads, at most 1024 [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(crate) threads: Option<u16>,
    /// Only results, warnings and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Say why each thing is made again, how long it took, and every finding
    #[arg(long, short, global = true)]
    pub(crate) verbose: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// The main job: raw data to every figure, table and summary; does only what changed
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth run thesis-twin\n",
        "  zwidth run thesis-twin --only metrics\n",
        "  zwidth run thesis-twin --cluster node1:50050"
    ))]
    Run(commands::run::RunArgs),
    /// Let the study's own stages run here: says what they run, and keeps it in mind until it changes
    #[command(after_help = "Example:\n  zwidth allow mystudy")]
    Allow(commands::allow::AllowArgs),
    /// Which shards of a study have made their share (`run --shard`), and what is missing
    #[command(after_help = "Example:\n  zwidth shards thesis-twin --missing")]
    Shards(commands::shards::ShardsArgs),
    /// Put the results of a study's shards together; then `run` makes the rest
    #[command(after_help = "Example:\n  zwidth merge thesis-twin")]
    Merge(commands::shards::MergeArgs),
    /// Write a commented study.toml for a new study
    #[command(after_help = "Example:\n  zwidth new mystudy")]
    New {
        /// The study's id: a folder's name under raw/
        study: StudyId,
        /// A shorter study.toml, for recordings that another program made
        #[arg(long)]
        imported: bool,
    },
    /// Record a session: trials, questions, pauses; resumes where it was left
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth acquire mystudy -p P01 -s S01\n",
        "  zwidth acquire mystudy -p P01 -s S01 --device rig:/dev/ttyACM0"
    ))]
    Acquire(commands::acquire::AcquireArgs),
    /// The participant's own screen beside a session that is being recorded: what to do, and the
    /// question
    #[command(after_help = "Example:\n  zwidth participant mystudy")]
    Participant(commands::participant::ParticipantArgs),
    /// List the serial ports, or ask those that are named which board is there
    #[command(after_help = "Example:\n  zwidth ports /dev/ttyACM0")]
    Ports {
        /// Ports to be asked: 12 s at most for each. Only name one at which a board is: what is
        /// something else may take a question for a command
        #[arg(value_name = "PORT")]
        ports: Vec<PathBuf>,
    },
    /// The device check before a session
    #[command(after_help = "Example:\n  zwidth check mystudy --device rig:/dev/ttyACM0")]
    Check(commands::check::CheckArgs),
    /// Record characterisation sweeps of an actuator, or the Z-width of the device
    #[command(after_help = "Example:\n  zwidth characterise mystudy motor --sweeps 3")]
    Characterise(commands::characterise::CharacteriseArgs),
    /// A whole study on the simulated device, at once
    #[command(after_help = "Example:\n  zwidth twin mytwin --participants 4 --sessions 1")]
    Twin(commands::twin::TwinArgs),
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth exclude mystudy -p P01 -s S01 --trial 7 \"the phone rang\""
    ))]
    /// Exclude a recorded trial, with a reason: it is missing until it is done again
    Exclude(commands::said::ExcludeArgs),
    #[command(after_help = "Example:\n  zwidth note mystudy -p P01 -s S01 left-handed")]
    /// Add a remark to a session, or to one of its trials
    Note(commands::said::NoteArgs),
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth answer mystudy -p P01 -s S01 --trial 7 4\n",
        "  zwidth answer mystudy --from ratings.csv"
    ))]
    /// Give answers after the session, one or a table of them; each counts in place of an earlier
    /// one, which is kept
    Answer(commands::said::answers::AnswerArgs),
    /// Give values of a metric that another program computed, one per trial: a metric like any other from
    /// then on
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth metric mystudy --from grip.csv --id grip_peak --unit N --label \"largest grip\"\n",
        "  zwidth metric mystudy --list\n",
        "  zwidth metric mystudy --withdraw grip_peak \"wrong channel\""
    ))]
    Metric(commands::metric::MetricArgs),
    /// Keep streams that another program recorded beside a session (EMG, gaze), each sample with its trial and its
    /// time there
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth beside mystudy --from lab.xdf -p P01 -s S01\n",
        "  zwidth beside mystudy --from lab.xdf -p P01 -s S01 --stream \"EMG of the arm=emg\"\n",
        "  zwidth beside mystudy --list\n",
        "  zwidth beside mystudy -p P01 -s S01 --withdraw emg \"electrodes were off\""
    ))]
    Beside(commands::beside::BesideArgs),
    /// Open a blinded session's seal: its modes are known from then on
    #[command(after_help = "Example:\n  zwidth unseal mystudy -p P01 -s S01")]
    Unseal(commands::unseal::UnsealArgs),
    /// After a kill or a power cut: journals become trials, half-written files go
    #[command(after_help = "Example:\n  zwidth recover mystudy")]
    Recover(commands::recover::RecoverArgs),
    /// Bring in recordings of other rigs, as a mapping file says
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth import --guess recordings/P01.csv --map map.toml\n",
        "  zwidth import mystudy --map map.toml recordings/P01.csv"
    ))]
    Import(commands::import::ImportArgs),
    /// Check studies: every finding, with file, column, row and remedy
    #[command(after_help = "Example:\n  zwidth verify thesis-twin")]
    Verify {
        /// Studies to check [default: all under raw/]
        studies: Vec<StudyId>,
    },
    /// Studies, sessions and trials; what is missing
    #[command(after_help = "Example:\n  zwidth list thesis-twin")]
    List {
        /// A study [default: all]
        study: Option<StudyId>,
    },
    /// Run a model of the device: figures and tables of scenes
    #[command(after_help = "Example:\n  zwidth simulate scenes/sine.toml")]
    Simulate(commands::simulate::SimulateArgs),
    /// A trajectory that another program computed for a scene: what is wrong with it, and by how much
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth judge scenes/stick.toml --trajectory theirs.csv\n",
        "  zwidth judge scenes/stick.toml --trajectory theirs.csv --engine mujoco"
    ))]
    Judge(commands::judge::JudgeArgs),
    /// Speed against accuracy: every solver and step on scenes, and the cheapest that is good
    /// enough
    #[command(after_help = "Example:\n  zwidth trade scenes/sine.toml")]
    Trade(commands::trade::TradeArgs),
    /// Which terms of the model a scene needs: all sets of eight against the fullest
    #[command(after_help = "Example:\n  zwidth ladder scenes/sine.toml")]
    Ladder(commands::ladder::LadderArgs),
    /// Which virtual walls a device bears: limits of a sampled wall, kept apart, over pairs of
    /// quantities; whether what swung in a recorded trial was real
    #[command(after_help = "Example:\n  zwidth stability --at delay=0.0083")]
    Stability(commands::stability::StabilityArgs),
    /// Modes, participants, sessions or repeats of a study compared, one metric at a time
    #[command(after_help = "Example:\n  zwidth compare thesis-twin --by participant")]
    Compare(commands::compare::CompareArgs),
    /// How many participants a study needs to find a difference; a plan to deposit
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth power thesis-twin --difference 0.2 --participant-mode-sd 0.1 --residual-sd 0.2"
    ))]
    Power(commands::power::PowerArgs),
    /// Show a study's page in the browser, or write it as one file
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth open thesis-twin\n",
        "  zwidth open thesis-twin --single-file thesis-twin.html"
    ))]
    Open(commands::open::OpenArgs),
    /// What counts of a study as a folder for others: tables, samples, units, checksums, a licence
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth export thesis-twin --to data --dry-run\n",
        "  zwidth export thesis-twin --to data --with bids,mat --licence CC-BY-4.0\n",
        "  zwidth export thesis-twin --to data --rename --key key.csv"
    ))]
    Export(commands::export::ExportArgs),
    /// Make one figure of a study again, in another size or form, or list its figures
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth figure thesis-twin\n",
        "  zwidth figure thesis-twin modes.P01.S01.spring --size 120 --format png"
    ))]
    Figure(commands::figure::FigureArgs),
    /// Print a table of a study, or list its tables
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth table thesis-twin\n",
        "  zwidth table thesis-twin conditions --format tex\n",
        "  zwidth table thesis-twin comparison --columns contrast,difference,verdict --digits 3"
    ))]
    Table(commands::table::TableArgs),
    /// Print what was done in words, with its sources: for a thesis' methods chapter
    #[command(after_help = "Example:\n  zwidth methods thesis-twin --format tex")]
    Methods(commands::methods::MethodsArgs),
    /// What a result was last made from, and why a run would make it again
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth why reports/thesis-twin/figures/modes.P01.S01.spring.png"
    ))]
    Why(commands::locate::Traced),
    /// The raw files behind a result, and the jobs between; also of a copy that lies elsewhere
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth trace reports/thesis-twin/figures/modes.P01.S01.spring.png"
    ))]
    Trace(commands::locate::Traced),
    /// Completions for a shell
    #[command(after_help = "Example:\n  zwidth completions bash")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// The manual page, or a page for each command
    #[command(after_help = "Examples:\n  zwidth man\n  zwidth man --out ~/.local/share/man/man1")]
    Man {
        /// Write a page for each command into this folder, which is created if there is none
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// The licences of everything that this program is made of
    #[command(after_help = "Example:\n  zwidth licences")]
    Licences,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    /// The words of a line as a shell reads them: what stands in quotation marks is one.
    fn words(line: &str) -> Vec<String> {
        let parts = line.split('"').enumerate();
        let words = parts.flat_map(|(at, part)| match at % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect(),
            _ => vec![part.to_owned()],
        });
        words.collect()
    }

    /// The words of the examples that a command's help ends with.
    fn examples(command: &clap::Command) -> Vec<Vec<String>> {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let lines = help.lines().filter_map(|line| line.strip_prefix("  "));
        lines.map(words).collect()
    }

    #[test]
    fn the_help_of_every_command_ends_with_examples_that_can_be_typed() {
        for command in Args::command().get_subcommands() {
            let name = command.get_name();
            let examples = examples(command);
            assert!(!examples.is_empty(), "{name} has no example");
            for words in examples {
                assert_eq!(words[..2], ["zwidth", name], "another command's: {words:?}");
                Args::try_parse_from(&words).unwrap_or_else(|error| panic!("{words:?}: {error}"));
            }
        }
    }
}
