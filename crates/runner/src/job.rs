//! A job: what it needs, what it makes, and the function that makes it.

use crate::hashes::show_path;
use crate::provenance::input_key;
use crate::{Provenance, Scripts};
use serde::Serialize;
use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_store::{Lately, hex_blake3};

/// The error of a job's function.
pub type JobError = Box<dyn Error + Send + Sync>;

/// The content of a file that a job made.
pub enum Output {
    /// These bytes.
    Whole(Vec<u8>),
    /// What this writes, part by part: more than should be in memory.
    Long(WriteLong),
}

/// Writes the content of a long file.
pub type WriteLong = Box<dyn FnOnce(&mut (dyn Write + Send)) -> Result<(), JobError> + Send>;

/// The result of a job.
#[derive(Default)]
pub struct Made {
    /// The content of each output, in the order of [`Job::outputs`].
    pub outputs: Vec<Output>,
    /// What had to be left out, and why: remembered, and reported at every run.
    pub problems: Vec<String>,
    /// What in the outputs is to be read with care, and why: also remembered and reported at every
    /// run.
    pub care: Vec<String>,
}

impl Made {
    /// Whole files without remarks.
    pub fn of(outputs: Vec<Vec<u8>>) -> Self {
        let outputs = outputs.into_iter().map(Output::Whole).collect();
        Self { outputs, ..Self::default() }
    }
}

/// A stage: its name, and the version of its algorithm, which is raised whenever the stage makes
/// something else of the same inputs and parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// Its name: `metrics`.
    pub name: &'static str,
    /// The version of its algorithm.
    pub version: u32,
}

/// The files that a job reads, each in its role.
pub trait Inputs: Send + Sync + 'static {
    /// All of them.
    fn files(&self) -> Vec<PathBuf>;
}

impl Inputs for () {
    fn files(&self) -> Vec<PathBuf> {
        Vec::new()
    }
}

impl Inputs for PathBuf {
    fn files(&self) -> Vec<PathBuf> {
        vec![self.clone()]
    }
}

impl Inputs for Path {
    fn files(&self) -> Vec<PathBuf> {
        vec![self.to_path_buf()]
    }
}

impl<I: Inputs + ?Sized> Inputs for Arc<I> {
    fn files(&self) -> Vec<PathBuf> {
        (**self).files()
    }
}

impl<I: Inputs> Inputs for Option<I> {
    fn files(&self) -> Vec<PathBuf> {
        self.iter().flat_map(Inputs::files).collect()
    }
}

impl<I: Inputs> Inputs for Vec<I> {
    fn files(&self) -> Vec<PathBuf> {
        self.iter().flat_map(Inputs::files).collect()
    }
}

impl<I: Inputs, const N: usize> Inputs for [I; N] {
    fn files(&self) -> Vec<PathBuf> {
        self.iter().flat_map(Inputs::files).collect()
    }
}

impl<A: Inputs, B: Inputs> Inputs for (A, B) {
    fn files(&self) -> Vec<PathBuf> {
        [self.0.files(), self.1.files()].concat()
    }
}

impl<A: Inputs, B: Inputs, C: Inputs> Inputs for (A, B, C) {
    fn files(&self) -> Vec<PathBuf> {
        [self.0.files(), self.1.files(), self.2.files()].concat()
    }
}

/// Where a job's outputs go, and what they say about their origin. Nothing else in them depends on
/// it.
pub struct Making<'m> {
    /// What the outputs say about their origin.
    pub from: &'m Provenance,
    /// The outputs' paths, in order.
    pub outputs: &'m [PathBuf],
    /// The folder that holds the data: results do not depend on its place.
    pub root: &'m Path,
    /// Trials that other jobs of the run read last.
    pub trials: &'m Lately,
    /// Which programs of the study's own may be started.
    pub scripts: &'m Scripts,
}

impl Making<'_> {
    /// The hash of an input, as the outputs give it; `None` if they give none.
    pub fn hash_of(&self, input: &Path) -> Option<&str> {
        self.from.get(&input_key(&self.shown(input))).map(String::as_str)
    }

    /// A path from the folder that holds the data, with `/` on every system.
    pub fn shown(&self, path: &Path) -> String {
        show_path(self.root, path)
    }
}

/// A text without the path of the data folder, so that results have the same bytes wherever the
/// folder is.
pub fn strip_root(root: &Path, text: &str) -> String {
    let root = root.join("").to_string_lossy().into_owned();
    if root.is_empty() { text.to_owned() } else { text.replace(&root, "") }
}

/// What a job is made from, and the function that does it. A plan has tens of thousands of jobs, so
/// the text of the parameters and the list of the inputs are made only when they are needed.
trait Work: Send + Sync {
    fn parameters(&self) -> Result<String, String>;
    fn files(&self) -> Vec<PathBuf>;
    fn make(&self, making: &Making) -> Result<Made, JobError>;
}

/// The work of a plain function on its parameters and inputs.
struct FunctionWork<P, I> {
    parameters: P,
    inputs: I,
    make: fn(&P, &I, &Making) -> Result<Made, JobError>,
}

impl<P: Serialize + Send + Sync, I: Inputs> Work for FunctionWork<P, I> {
    fn parameters(&self) -> Result<String, String> {
        let text = serde_json::to_string(&self.parameters).map_err(|e| e.to_string())?;
        Ok(match text.len() {
            // Records keep the text: the answers of a large study would fill them.
            length if length > MOST_PARAMETERS => {
                format!("\"{length} bytes, BLAKE3 {}\"", hex_blake3(text.as_bytes()))
            }
            _ => text,
        })
    }

    fn files(&self) -> Vec<PathBuf> {
        self.inputs.files()
    }

    fn make(&self, making: &Making) -> Result<Made, JobError> {
        (self.make)(&self.parameters, &self.inputs, making)
    }
}

/// One unit of work.
pub struct Job {
    /// The stage it belongs to.
    pub stage: Stage,
    /// Its name within the study, unique: `metrics P01_S01`.
    pub name: String,
    /// The part of the study whose trials it takes, `P01.S01.spring.hybrid`: all jobs of a part are
    /// one shard's ([`crate::Shard`]). `None` for a job of the whole study.
    pub part: Option<String>,
    /// Files from which its parameters come. The record names them; a change of one of them is not
    /// a reason to make the job again.
    pub origins: Vec<Arc<Path>>,
    /// Files it makes.
    pub outputs: Vec<PathBuf>,
    /// Whether it is made even when some of its inputs could not be: they are then missing files.
    pub tolerant: bool,
    work: Box<dyn Work>,
}

/// Longest text of parameters that is kept as it is, bytes.
const MOST_PARAMETERS: usize = 1 << 16;

impl Job {
    /// The job of that name. Its function gets its parameters, its inputs and where its outputs
    /// go, and nothing else: it is a plain function, which can hold nothing back from its key.
    pub fn new<P, I>(
        stage: Stage,
        name: impl Into<String>,
        parameters: P,
        inputs: I,
        outputs: Vec<PathBuf>,
        make: fn(&P, &I, &Making) -> Result<Made, JobError>,
    ) -> Self
    where
        P: Serialize + Send + Sync + 'static,
        I: Inputs,
    {
        Self {
            stage,
            name: name.into(),
            part: None,
            origins: Vec::new(),
            outputs,
            tolerant: false,
            work: Box::new(FunctionWork { parameters, inputs, make }),
        }
    }

    /// Everything but files that the outputs depend on, as canonical text: JSON in the order of the
    /// declaration, or its hash if that is long. Empty if they cannot be written: then the job
    /// fails when it is made.
    pub fn parameters(&self) -> String {
        self.work.parameters().unwrap_or_default()
    }

    /// Files it reads, each once.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let mut files = self.work.files();
        // By their bytes: that is quicker than name by name, and any order will do.
        files.sort_unstable_by(|a, b| a.as_os_str().cmp(b.as_os_str()));
        files.dedup_by(|a, b| a.as_os_str() == b.as_os_str());
        files
    }

    /// Makes its outputs.
    pub(crate) fn make(&self, making: &Making) -> Result<Made, JobError> {
        // `parameters` gives an empty text for these, which would be the key of all such jobs.
        if let Err(why) = self.work.parameters() {
            return Err(format!("its parameters cannot be written: {why}").into());
        }
        self.work.make(making)
    }

    /// The same, made even when some of its inputs could not be.
    #[must_use]
    pub fn tolerant(self) -> Self {
        Self { tolerant: true, ..self }
    }

    /// The same, of a part of the study.
    #[must_use]
    pub fn of_part(self, part: impl Into<String>) -> Self {
        Self { part: Some(part.into()), ..self }
    }

    /// The same, with the files from which its parameters come.
    #[must_use]
    pub fn told_by(self, origins: Vec<Arc<Path>>) -> Self {
        Self { origins, ..self }
    }

    /// What its first output is called, without folder and extension.
    pub fn stem(&self) -> Option<&str> {
        self.outputs.first()?.file_stem()?.to_str()
    }

    /// Whether a person who says `name` means this job: its stage, its name, with or without its
    /// stage's, or the file stem of an output.
    pub fn is_called(&self, name: &str) -> bool {
        let mut stems = self.outputs.iter().filter_map(|output| output.file_stem());
        let own = self.name.strip_prefix(self.stage.name).map(str::trim_start);
        self.stage.name == name
            || self.name == name
            || own == Some(name)
            || stems.any(|stem| stem == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job<P: Serialize + Send + Sync + 'static>(parameters: P) -> Job {
        let stage = Stage { name: "s", version: 1 };
        Job::new(stage, "j", parameters, (), Vec::new(), |_, (), _| Ok(Made::default()))
    }

    #[test]
    fn parameters_are_json_and_a_hash_where_they_are_long() {
        #[derive(Serialize)]
        struct Parameters {
            level: f64,
            who: &'static str,
        }
        let short = job(Parameters { level: 0.95, who: "P01" });
        assert_eq!(short.parameters(), r#"{"level":0.95,"who":"P01"}"#);
        let [a, b] = ["a", "b"].map(|text| job(text.repeat(MOST_PARAMETERS)).parameters());
        assert!(a.len() < 100 && a != b, "{a}");
    }

    #[test]
    fn parameters_that_cannot_be_written_are_the_jobs_failure_and_no_key() {
        let map: std::collections::BTreeMap<(u8, u8), u8> = [((1, 2), 3)].into();
        let job = job(map);
        let (from, root, scripts) = (Provenance::new(), Path::new(""), Scripts::None);
        let trials = &Lately::default();
        let making = Making { from: &from, outputs: &[], root, trials, scripts: &scripts };
        let error = job.make(&making).err().unwrap();
        assert!(error.to_string().contains("its parameters cannot be written"), "{error}");
    }

    #[test]
    fn inputs_are_listed_once_whatever_their_roles() {
        let path = |name: &str| PathBuf::from(name);
        let inputs = (vec![path("b"), path("a")], Some(path("a")), [path("c")]);
        let stage = Stage { name: "s", version: 1 };
        let job = Job::new(stage, "j", (), inputs, Vec::new(), |(), _, _| Ok(Made::default()));
        assert_eq!(job.inputs(), [path("a"), path("b"), path("c")]);
    }
}
