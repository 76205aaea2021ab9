//! What can be typed. Parsed here, resolved into work by the commands.

use crate::devices::{DEVICES, DeviceSpec};
use crate::limits::{
    MOST_CELLS, MOST_PARTICIPANTS, MOST_SCALE, MOST_SESSIONS, MOST_SWEEPS, MOST_THREADS, positive,
    rate, setting, size, span, tolerance,
};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use zwidth_acquire::Target;
use zwidth_report::MethodsForm;
use zwidth_results::WallQuantity;
use zwidth_runner::{MOST_SHARDS, Shard};
use zwidth_simulate::{DEFAULT_SOLVER, SOLVERS};
use zwidth_study::{AnswerValue, ExperimenterId, ParticipantId, QuestionId, SessionId, StudyId};
use zwidth_tables::Format;

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
    Run(Run),
    /// Which shards of a study have made their share (`run --shard`), and what is missing
    #[command(after_help = "Example:\n  zwidth shards thesis-twin --missing")]
    Shards(Shards),
    /// Put the results of a study's shards together; then `run` makes the rest
    #[command(after_help = "Example:\n  zwidth merge thesis-twin")]
    Merge(Merge),
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
    Acquire(Acquire),
    /// The participant's own screen beside a session that is being recorded: what to do, and the
    /// question
    #[command(after_help = "Example:\n  zwidth participant mystudy")]
    Participant(Participant),
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
    Check(Check),
    /// Record characterisation sweeps of an actuator, or the Z-width of the device
    #[command(after_help = "Example:\n  zwidth characterise mystudy motor --sweeps 3")]
    Characterise(Characterise),
    /// A whole study on the simulated device, at once
    #[command(after_help = "Example:\n  zwidth twin mytwin --participants 4 --sessions 1")]
    Twin(Twin),
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth exclude mystudy -p P01 -s S01 --trial 7 \"the phone rang\""
    ))]
    /// Exclude a recorded trial, with a reason: it is missing until it is done again
    Exclude(Exclude),
    #[command(after_help = "Example:\n  zwidth note mystudy -p P01 -s S01 left-handed")]
    /// Add a remark to a session, or to one of its trials
    Note(Note),
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth answer mystudy -p P01 -s S01 --trial 7 4\n",
        "  zwidth answer mystudy --from ratings.csv"
    ))]
    /// Give answers after the session, one or a table of them; each counts in place of an earlier
    /// one, which is kept
    Answer(Answer),
    /// Open a blinded session's seal: its modes are known from then on
    #[command(after_help = "Example:\n  zwidth unseal mystudy -p P01 -s S01")]
    Unseal(Unseal),
    /// After a kill or a power cut: journals become trials, half-written files go
    #[command(after_help = "Example:\n  zwidth recover mystudy")]
    Recover(Recover),
    /// Bring in recordings of other rigs, as a mapping file says
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth import --guess recordings/P01.csv --map map.toml\n",
        "  zwidth import mystudy --map map.toml recordings/P01.csv"
    ))]
    Import(Import),
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
    Simulate(Simulate),
    /// Speed against accuracy: every solver and step on scenes, and the cheapest that is good
    /// enough
    #[command(after_help = "Example:\n  zwidth trade scenes/sine.toml")]
    Trade(Trade),
    /// Which terms of the model a scene needs: all sets of eight against the fullest
    #[command(after_help = "Example:\n  zwidth ladder scenes/sine.toml")]
    Ladder(Ladder),
    /// Which virtual walls a device bears: limits of a sampled wall, kept apart, over pairs of
    /// quantities; whether what swung in a recorded trial was real
    #[command(after_help = "Example:\n  zwidth stability --at delay=0.0083")]
    Stability(Stability),
    /// Modes, participants, sessions or repeats of a study compared, one metric at a time
    #[command(after_help = "Example:\n  zwidth compare thesis-twin --by participant")]
    Compare(Compare),
    /// How many participants a study needs to find a difference; a plan to deposit
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth power thesis-twin --difference 0.2 --participant-mode-sd 0.1 --residual-sd 0.2"
    ))]
    Power(Power),
    /// Show a study's page in the browser, or write it as one file
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth open thesis-twin\n",
        "  zwidth open thesis-twin --single-file thesis-twin.html"
    ))]
    Open(Open),
    /// Make one figure of a study again, in another size or form, or list its figures
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth figure thesis-twin\n",
        "  zwidth figure thesis-twin modes.P01.S01.spring --size 120 --format png"
    ))]
    Figure(Figure),
    /// Print a table of a study, or list its tables
    #[command(after_help = concat!(
        "Examples:\n",
        "  zwidth table thesis-twin\n",
        "  zwidth table thesis-twin conditions --format tex"
    ))]
    Table(Table),
    /// Print what was done in words, with its sources: for a thesis' methods chapter
    #[command(after_help = "Example:\n  zwidth methods thesis-twin --format tex")]
    Methods(Methods),
    /// What a result was last made from, and why a run would make it again
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth why reports/thesis-twin/figures/modes.P01.S01.spring.png"
    ))]
    Why(Traced),
    /// The raw files behind a result, and the jobs between; also of a copy that lies elsewhere
    #[command(after_help = concat!(
        "Example:\n",
        "  zwidth trace reports/thesis-twin/figures/modes.P01.S01.spring.png"
    ))]
    Trace(Traced),
    /// Completions for a shell
    #[command(after_help = "Example:\n  zwidth completions bash")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// The manual page
    #[command(after_help = "Example:\n  zwidth man")]
    Man,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Run {
    /// Studies to run [default: all under raw/]
    pub(crate) studies: Vec<StudyId>,
    /// Make everything again
    #[arg(long)]
    pub(crate) fresh: bool,
    /// Only this stage, figure or table, and what it needs
    #[arg(long, value_name = "STAGE|FIGURE|TABLE")]
    pub(crate) only: Option<String>,
    /// Only the share I of N of what is derived from trials, to be merged later: 3/7
    #[arg(long, value_name = "I/N", conflicts_with = "only")]
    pub(crate) shard: Option<Shard>,
    /// Have what is derived from trials made on a Ballista cluster, by its scheduler's address; the
    /// program `zwidth-cluster` must be on the path
    #[arg(long, value_name = "HOST:PORT", conflicts_with_all = ["fresh", "only", "shard", "dry_run", "without_origin"])]
    pub(crate) cluster: Option<String>,
    /// Where the cluster's executors find raw/: a folder that all machines share, or an object store
    /// [default: the same folder as here]
    #[arg(long, value_name = "DIR|s3://BUCKET/PREFIX", requires = "cluster")]
    pub(crate) raw: Option<String>,
    /// Say what would be made, and why; make nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Files say nothing of their making, so that two programs' bytes can be compared
    #[arg(long, hide = true)]
    pub(crate) without_origin: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Shards {
    /// The study
    pub(crate) study: StudyId,
    /// Only shards that something is missing of
    #[arg(long)]
    pub(crate) missing: bool,
    /// How many shards there are [default: as many as the manifests say]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SHARDS)))]
    pub(crate) of: Option<u32>,
    /// Other data folders in which shards were made
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub(crate) from: Vec<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Merge {
    /// The study
    pub(crate) study: StudyId,
    /// Other data folders in which shards were made; nothing there is changed
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub(crate) from: Vec<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Open {
    /// The study
    pub(crate) study: StudyId,
    /// Write the page with its figures and samples into this one file, to send or to keep, and open
    /// nothing
    #[arg(long, value_name = "FILE.html")]
    pub(crate) single_file: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Recover {
    /// The study
    pub(crate) study: StudyId,
    /// Accept a study.toml that has changed since sessions began: `verify` notes it then, and
    /// warns no more
    #[arg(long)]
    pub(crate) accept_study_change: bool,
    /// Of this participant's session alone
    #[arg(long, short, value_name = "P01", requires_all = ["session", "accept_study_change"])]
    pub(crate) participant: Option<ParticipantId>,
    /// Of this session alone
    #[arg(long, short, value_name = "S01", requires_all = ["participant", "accept_study_change"])]
    pub(crate) session: Option<SessionId>,
}

#[derive(Debug, Clone, PartialEq, clap::Args)]
pub(crate) struct Acquire {
    /// The study
    pub(crate) study: StudyId,
    /// The participant's code; the number at its end says which order, without one it is that of
    /// appearance
    #[arg(long, short, value_name = "P01")]
    pub(crate) participant: ParticipantId,
    /// The session
    #[arg(long, short, value_name = "S01")]
    pub(crate) session: SessionId,
    /// The device
    #[arg(long, default_value = "twin", value_name = DEVICES)]
    pub(crate) device: DeviceSpec,
    /// Lines in and out instead of the screen
    #[arg(long)]
    pub(crate) plain: bool,
    /// The screen in ASCII alone
    #[arg(long)]
    pub(crate) ascii: bool,
    /// Run without an experimenter: trials start by themselves, the simulated participant answers
    #[arg(long)]
    pub(crate) auto: bool,
    /// Rate of the control loop, Hz [default: the study's]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// Seed of the order and of the simulated device [default: from the study's id; secret if it
    /// is blinded]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// A simulated clock: as fast as the machine can (simulated devices only)
    #[arg(long)]
    pub(crate) fast: bool,
    /// Go through the whole device check: each step waits for what a hand must do, and what moves
    /// the lever for a yes
    #[arg(long, conflicts_with = "auto")]
    pub(crate) ask: bool,
    /// A known mass for the load cell, kg; asked for after the tare
    #[arg(long, value_name = "KG", value_parser = positive, requires = "ask")]
    pub(crate) mass: Option<f64>,
    #[command(flatten)]
    pub(crate) keys: Keys,
    /// Use the motor of a device without a watchdog; every trial is marked
    #[arg(long)]
    pub(crate) no_watchdog: bool,
    /// Your code, which stands beside everything that is kept in the session's log; no name
    #[arg(long, value_name = "E1")]
    pub(crate) by: Option<ExperimenterId>,
    /// Who is told of each trial's start, contact, end and answer: programs, or the pins of the board
    /// (docs/acquire.md)
    #[arg(long, value_name = "tcp:HOST:PORT,osc:HOST:PORT,board", value_delimiter = ',')]
    pub(crate) markers: Vec<Target>,
    /// Go on with a session although study.toml has changed in what it records: by the session's
    /// own copy; its log says so
    #[arg(long)]
    pub(crate) accept_study_change: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Participant {
    /// The study
    pub(crate) study: StudyId,
    /// Lines in and out instead of the screen
    #[arg(long)]
    pub(crate) plain: bool,
    /// The screen in ASCII alone
    #[arg(long)]
    pub(crate) ascii: bool,
}

/// Where seals lie.
#[derive(Debug, Clone, PartialEq, Eq, clap::Args)]
pub(crate) struct Keys {
    /// Folder of the seals of blinded sessions [default: zwidth/ in the user's state folder]
    #[arg(long = "key", value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Check {
    /// The study, whose work space, rate and calibration the device is to fit
    pub(crate) study: StudyId,
    /// The device
    #[arg(long, default_value = "twin", value_name = DEVICES)]
    pub(crate) device: DeviceSpec,
    /// Rate of the control loop, Hz [default: the study's]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// A simulated clock: as fast as the machine can (simulated devices only)
    #[arg(long)]
    pub(crate) fast: bool,
    /// Ask for what a hand must do before each step; without it only steps that need none are done
    #[arg(long)]
    pub(crate) ask: bool,
    /// A known mass for the load cell, kg; asked for after the tare
    #[arg(long, value_name = "KG", value_parser = positive, requires = "ask")]
    pub(crate) mass: Option<f64>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Characterise {
    /// The study
    pub(crate) study: StudyId,
    /// The actuator, or the impedance of the whole device
    pub(crate) actuator: Subject,
    /// The device: the simulated one alone can be characterised
    #[arg(long, default_value = "twin", value_name = "twin")]
    pub(crate) device: DeviceSpec,
    /// Number of sweeps
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=MOST_SWEEPS))]
    pub(crate) sweeps: u32,
    /// Seed of the simulated device
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// What can be characterised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Subject {
    /// The motor, at a held lever
    Motor,
    /// The brake, at a lever that is driven
    Brake,
    /// The Z-width: which stiffness and damping of a virtual wall the device renders; goes on where
    /// it was left
    Impedance,
}

/// An actuator that can be swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Actuator {
    /// The motor.
    Motor,
    /// The brake.
    Brake,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Twin {
    /// The study; it is made with `zwidth new` if it is not there
    pub(crate) study: StudyId,
    /// Number of participants
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=MOST_PARTICIPANTS))]
    pub(crate) participants: u32,
    /// Sessions of each
    #[arg(long, value_name = "M", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=MOST_SESSIONS))]
    pub(crate) sessions: u32,
    /// Seed of participants, devices and order: one seed, the same bytes
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Rate of the control loop, Hz [default: the study's]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// So many times the repeats of the design, in a study that is made: for data of any size
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=MOST_SCALE))]
    pub(crate) scale: u32,
    /// Participants now and then give a trial up, which is then done again, or leave a question
    /// open
    #[arg(long)]
    pub(crate) untidy: bool,
    #[command(flatten)]
    pub(crate) keys: Keys,
}

/// A session that was recorded, and who says something of it.
#[derive(Debug, clap::Args)]
pub(crate) struct Said {
    /// The study
    pub(crate) study: StudyId,
    /// The participant
    #[arg(long, short, value_name = "P01")]
    pub(crate) participant: ParticipantId,
    /// The session
    #[arg(long, short, value_name = "S01")]
    pub(crate) session: SessionId,
    /// Your code, which is kept with it; no name
    #[arg(long, value_name = "E1")]
    pub(crate) by: Option<ExperimenterId>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Exclude {
    #[command(flatten)]
    pub(crate) said: Said,
    /// The trial's number, or several, separated by commas: all are excluded, or none
    #[arg(long, value_name = "N[,N…]", required = true, value_delimiter = ',')]
    pub(crate) trial: Vec<u32>,
    /// Why they do not count
    pub(crate) reason: String,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Note {
    #[command(flatten)]
    pub(crate) said: Said,
    /// The trial's number [default: a remark on the session]
    #[arg(long, value_name = "N")]
    pub(crate) trial: Option<u32>,
    /// The remark
    pub(crate) text: String,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Answer {
    /// The study
    pub(crate) study: StudyId,
    /// The participant
    #[arg(long, short, value_name = "P01", required_unless_present = "from")]
    pub(crate) participant: Option<ParticipantId>,
    /// The session; with --from, that of a table without a column of sessions
    #[arg(long, short, value_name = "S01", required_unless_present = "from")]
    pub(crate) session: Option<SessionId>,
    /// Your code, which is kept with it; no name
    #[arg(long, value_name = "E1")]
    pub(crate) by: Option<ExperimenterId>,
    /// The trial's number
    #[arg(long, value_name = "N", required_unless_present = "from")]
    pub(crate) trial: Option<u32>,
    /// The question [default: the only one that is asked after that trial]; with --from, that of a
    /// table without a column of questions
    #[arg(long, value_name = "ID")]
    pub(crate) question: Option<QuestionId>,
    /// The answer, a number of the question's scale
    #[arg(allow_negative_numbers = true, required_unless_present = "from")]
    pub(crate) value: Option<AnswerValue>,
    /// A table of answers (CSV, Excel), one row each, with the columns participant, session, trial
    /// (or environment, mode and repeat), question and answer: all are given, or none
    #[arg(long, value_name = "FILE", conflicts_with_all = ["participant", "trial", "value"])]
    pub(crate) from: Option<PathBuf>,
    /// Check the table and say what would be given; nothing is written
    #[arg(long, requires = "from")]
    pub(crate) dry_run: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Unseal {
    /// The study
    pub(crate) study: StudyId,
    /// The participant
    #[arg(long, short, value_name = "P01")]
    pub(crate) participant: ParticipantId,
    /// The session
    #[arg(long, short, value_name = "S01")]
    pub(crate) session: SessionId,
    /// Even if trials are still to come, which are not blind then
    #[arg(long)]
    pub(crate) unfinished: bool,
    #[command(flatten)]
    pub(crate) keys: Keys,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Import {
    /// The study the recordings belong to; its study.toml must exist
    #[arg(required_unless_present = "guess")]
    pub(crate) study: Option<StudyId>,
    /// The mapping file: their columns to ours; with --guess, where the guess is written
    #[arg(long, value_name = "MAP.toml", required_unless_present = "guess")]
    pub(crate) map: Option<PathBuf>,
    /// The recordings
    #[arg(required_unless_present = "guess")]
    pub(crate) files: Vec<PathBuf>,
    /// Guess a mapping file from recordings (their columns from the first, whose they are from all
    /// names) and print it, to be edited; nothing is imported
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["study", "files"])]
    pub(crate) guess: Vec<PathBuf>,
}

/// What --tolerance is unless told otherwise: [`zwidth_simulate::DEFAULT_TOLERANCE`] as people
/// write it.
const DEFAULT_TOLERANCE: &str = "1e-9";

#[derive(Debug, clap::Args)]
pub(crate) struct Simulate {
    /// Scenes; of two or more the inputs are drawn beside each other too
    #[arg(required = true, value_name = "SCENE.toml")]
    pub(crate) scenes: Vec<PathBuf>,
    /// The solver
    #[arg(long, value_name = "NAME", default_value = DEFAULT_SOLVER, value_parser = PossibleValuesParser::new(SOLVERS))]
    pub(crate) solver: String,
    /// Time between samples in s, which is the step of solvers of a fixed step [default: the
    /// scene's]
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) step: Option<f64>,
    /// Relative error a step that dormand_prince and tr_bdf2 aim for
    #[arg(long, value_name = "X", value_parser = tolerance, default_value = DEFAULT_TOLERANCE)]
    pub(crate) tolerance: f64,
    /// Folder to write to [default: reports/simulate]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Every solver at steps from 8.3 ms down: which oscillation is the method's, and which the
    /// model's
    #[arg(long)]
    pub(crate) chattering: bool,
    /// Instead of pushing the lever, move it from stop to stop and back: force against angle
    #[arg(long, conflicts_with = "chattering")]
    pub(crate) bow_tie: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Trade {
    /// Scenes, files that end in .toml, or studies, of which every condition is one, and whose
    /// trials are simulated with another loop and other sensors [default: all studies under raw/]
    #[arg(value_name = "SCENE.toml|STUDY")]
    pub(crate) scenes: Vec<PathBuf>,
    /// A study, as above
    #[arg(long, value_name = "STUDY")]
    pub(crate) study: Vec<StudyId>,
    /// Folder to write to [default: reports/trade; for a study reports/STUDY/timing]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Do everything again, whether it changed or not
    #[arg(long)]
    pub(crate) fresh: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Stability {
    /// A scene, whose device, spring and step are taken [default: the simulated device of
    /// docs/twin.md]
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: Option<PathBuf>,
    /// Another value of a quantity, in SI units: delay=0.0083, wall_damping=2; each may be given.
    /// Quantities: step, mass, damping, wall_damping, stiffness, lever, finger, delay, rate
    #[arg(long, value_name = "QUANTITY=VALUE", value_parser = setting)]
    pub(crate) at: Vec<(WallQuantity, f64)>,
    /// What runs along x, with its ends in SI units; with --y one map in place of six
    #[arg(long, value_name = "QUANTITY[=FROM..TO]", value_parser = span, requires = "y")]
    pub(crate) x: Option<(WallQuantity, Option<[f64; 2]>)>,
    /// What runs along y
    #[arg(long, value_name = "QUANTITY[=FROM..TO]", value_parser = span, requires = "x")]
    pub(crate) y: Option<(WallQuantity, Option<[f64; 2]>)>,
    /// Cells a side of a map
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=MOST_CELLS))]
    pub(crate) cells: u32,
    /// Boundaries that others measured, drawn too: files with the columns K and B
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) beside: Vec<PathBuf>,
    /// Instead of maps: was what swings in this study's recorded trials real? Each trial's loop is
    /// run again
    #[arg(long, value_name = "STUDY", conflicts_with_all = ["scene", "at", "x", "y", "beside"])]
    pub(crate) study: Option<StudyId>,
    /// Of this participant's trials alone
    #[arg(long, short, value_name = "P01", requires = "study")]
    pub(crate) participant: Option<ParticipantId>,
    /// Of this session's trials alone
    #[arg(long, short, value_name = "S01", requires = "study")]
    pub(crate) session: Option<SessionId>,
    /// Of this trial alone
    #[arg(long, value_name = "N", requires_all = ["participant", "session"])]
    pub(crate) trial: Option<u32>,
    /// Folder to write to [default: reports/stability; of a study reports/STUDY/stability]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Ladder {
    /// Scenes, files that end in .toml, or studies, of which every condition with a recording is
    /// one [default: all studies under raw/]
    #[arg(value_name = "SCENE.toml|STUDY")]
    pub(crate) scenes: Vec<PathBuf>,
    /// Points of the simulated device's parameters
    #[arg(long, value_name = "N", default_value_t = zwidth_ladder::DEFAULT_POINTS)]
    pub(crate) points: usize,
    /// Rate of the control loop in Hz [default: a scene's is the thesis' 120.5, one sample in 8.3
    /// ms; a study's its own]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(crate) rate: Option<f64>,
    /// Folder to write to [default: reports/ladder]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Compare {
    /// The study
    pub(crate) study: StudyId,
    /// What is compared [default: the modes; by the answers in a study without a metric]
    #[arg(long, value_enum)]
    pub(crate) by: Option<By>,
    /// The metric's column in the table of metrics [default: the primary one]
    #[arg(long, value_name = "METRIC")]
    pub(crate) metric: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Power {
    /// The study: its repeats, modes, alpha and contrasts are planned with
    pub(crate) study: StudyId,
    /// The true difference between two modes, in the metric's SI unit
    #[arg(long, value_name = "D", value_parser = positive)]
    pub(crate) difference: f64,
    /// Number of participants
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=MOST_PARTICIPANTS))]
    pub(crate) participants: Option<u32>,
    /// The metric's column in the table of metrics [default: the primary one]
    #[arg(long, value_name = "METRIC")]
    pub(crate) metric: Option<String>,
    /// Standard deviation of participants' levels [default: that of the study's own trials]
    #[arg(long, value_name = "SD", value_parser = positive)]
    pub(crate) participant_sd: Option<f64>,
    /// Standard deviation of participants' own effects of a mode [default: likewise]
    #[arg(long, value_name = "SD", value_parser = positive)]
    pub(crate) participant_mode_sd: Option<f64>,
    /// Standard deviation of repeats [default: likewise]
    #[arg(long, value_name = "SD", value_parser = positive)]
    pub(crate) residual_sd: Option<f64>,
    /// Number of studies that are simulated
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(100..=100_000))]
    pub(crate) studies: u32,
    /// Seed of the simulated studies
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the plan to raw/STUDY/plan.json, to deposit before data are taken: `compare` then says
    /// whether the analysis is that one
    #[arg(long)]
    pub(crate) plan: bool,
}

/// What can be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum By {
    /// The modes: means, and differences with their intervals
    Mode,
    /// The participants: each one's differences between modes
    Participant,
    /// The sessions: changes from the first to each later one
    Session,
    /// The repeats: the change from one to the next
    Repeat,
    /// The modes by the answers: effects over participants, odds ratios for one person
    Answer,
}

impl From<By> for zwidth_plan::By {
    fn from(by: By) -> Self {
        match by {
            By::Mode => Self::Mode,
            By::Participant => Self::Participant,
            By::Session => Self::Session,
            By::Repeat => Self::Repeat,
            By::Answer => Self::Answer,
        }
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct Figure {
    /// The study
    pub(crate) study: StudyId,
    /// The figure; omit it to list the figures
    pub(crate) name: Option<String>,
    /// Its width on paper in mm, or its width and height: 85 (one column), 175x120 [default: as a
    /// run makes it]
    #[arg(long, value_name = "MM[xMM]", value_parser = size)]
    pub(crate) size: Option<(f64, Option<f64>)>,
    /// File formats, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "svg,pdf,png")]
    pub(crate) format: Vec<FigureFormat>,
    /// Without heading and small print, which stand in its caption's file; the mark of simulated
    /// data stays
    #[arg(long)]
    pub(crate) bare: bool,
    /// Words of an SVG as text, to be edited and searched, in place of outlines
    #[arg(long)]
    pub(crate) text: bool,
    /// Font of these words, such as the document's, by its name; each keeps the width that it has
    /// in the font by which the figure is laid out
    #[arg(long, value_name = "NAME", requires = "text")]
    pub(crate) font: Option<String>,
    /// Font file (.ttf, .otf) in which the figure is laid out and set, in every format; give it up
    /// to three times, for upright, italic and bold [default: that of study.toml, else Noto Sans]
    #[arg(long, value_name = "FILE")]
    pub(crate) font_file: Vec<PathBuf>,
    /// Dots per inch of a PNG
    #[arg(long, value_name = "DPI", default_value_t = zwidth_draw::DEFAULT_DPI, value_parser = positive)]
    pub(crate) dpi: f64,
    /// Folder to write to [default: reports/STUDY/remade]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

/// The form of a figure's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FigureFormat {
    /// For the web and for editing
    Svg,
    /// For print
    Pdf,
    /// For screens
    Png,
}

impl FigureFormat {
    /// Of its files' names.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Pdf => "pdf",
            Self::Png => "png",
        }
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct Table {
    /// The study
    pub(crate) study: StudyId,
    /// The table; omit it to list the tables
    pub(crate) name: Option<String>,
    /// The form in which to print it
    #[arg(long, default_value = Format::Markdown.extension(), value_parser = text_formats())]
    pub(crate) format: Format,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Methods {
    /// The study
    pub(crate) study: StudyId,
    /// The form in which to print them: Markdown, LaTeX or Typst
    #[arg(long, default_value = MethodsForm::ALL[0].0, value_parser = methods_forms())]
    pub(crate) format: MethodsForm,
}

/// A result asked about.
#[derive(Debug, clap::Args)]
pub(crate) struct Traced {
    /// A file under derived/ or reports/, relative to the current folder or --root; or a copy of
    /// one, anywhere
    pub(crate) path: PathBuf,
}

/// The formats of a table that are text, by the extensions of their files.
fn text_formats() -> impl TypedValueParser<Value = Format> {
    let text = || Format::ALL.into_iter().filter(|format| format.is_text());
    let values = text().map(|f| PossibleValue::new(f.extension()).help(f.about()));
    PossibleValuesParser::new(values).try_map(move |word| {
        let of_word = text().find(|format| format.extension() == word);
        of_word.ok_or_else(|| format!("'{word}' is not a format"))
    })
}

/// The forms of the methods, by the extensions of their files.
fn methods_forms() -> impl TypedValueParser<Value = MethodsForm> {
    PossibleValuesParser::new(MethodsForm::ALL.map(|(word, _)| word)).try_map(|word| {
        let found = MethodsForm::ALL.into_iter().find(|(known, _)| *known == word);
        found.map(|(_, form)| form).ok_or_else(|| format!("'{word}' is not a format"))
    })
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

    #[test]
    fn the_default_tolerance_is_the_stage_s_own() {
        assert_eq!(positive(DEFAULT_TOLERANCE), Ok(zwidth_simulate::DEFAULT_TOLERANCE));
    }

    #[test]
    fn what_is_not_above_zero_is_refused() {
        for text in ["0", "-1", "nan", "inf", "much"] {
            assert!(positive(text).is_err(), "{text}");
        }
    }
}
