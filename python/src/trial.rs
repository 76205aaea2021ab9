//! The samples of a trial, and of many.

use crate::arrow;
use crate::calling::{Fault, call};
use crate::table::{Column, Table};
use arrow_array::{RecordBatch, RecordBatchReader};
use arrow_schema::{ArrowError, SchemaRef};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_metrics::{Parameters, table as metrics_table, trial_metrics};
use zwidth_store::{
    SampleColumns, Signal, Trial as Recorded, read_footer, read_trial_and_channels,
};
use zwidth_study::{Channel, ChannelId, TrialMeta};

/// A trial whose samples are read when they are asked for.
#[derive(Debug, Clone)]
pub(crate) struct File {
    pub(crate) path: Arc<Path>,
    /// As the session says them now.
    pub(crate) meta: TrialMeta,
}

impl File {
    /// Its samples, with those of these columns that its file has.
    fn read(&self, columns: &SampleColumns) -> Result<RecordBatch, Fault> {
        let channels: Vec<ChannelId> = columns.channels().iter().map(|c| c.id.clone()).collect();
        let recorded = recorded(&self.path, columns.signals())?;
        let trial = read_trial_and_channels(&self.path, recorded, &channels)?;
        // Time is read in any case, because every check needs it.
        Ok(columns.batch(&self.meta, &trial.samples, &self.path)?)
    }
}

/// Those of these signals that a trial's file has.
fn recorded(path: &Path, wanted: &[Signal]) -> Result<Vec<Signal>, Fault> {
    let has = read_footer(path)?.signals;
    Ok(wanted.iter().copied().filter(|signal| has.contains(signal)).collect())
}

/// The signals and channels that are asked for by name: all of these, if none is.
pub(crate) fn columns(
    asked: Option<Vec<String>>,
    signals: &[Signal],
    channels: &[Channel],
    tasks: bool,
) -> Result<SampleColumns, Fault> {
    let Some(asked) = asked else { return Ok(SampleColumns::new(signals, channels, tasks)) };
    let (mut some_signals, mut some_channels) = (Vec::new(), Vec::new());
    for name in &asked {
        let signal = Signal::from_name(name).filter(|signal| signals.contains(signal));
        let channel = channels.iter().find(|channel| channel.id.as_str() == name);
        match (signal, channel) {
            (Some(signal), _) => some_signals.push(signal),
            (None, Some(channel)) => some_channels.push(channel.clone()),
            (None, None) => {
                let signals = signals.iter().map(|signal| signal.name());
                let names: Vec<&str> =
                    signals.chain(channels.iter().map(|c| c.id.as_str())).collect();
                let what = "no trial has such a column";
                return Err(
                    Fault::new(what, &format!("choose among {}", names.join(", "))).in_column(name)
                );
            }
        }
    }
    some_signals.sort();
    some_signals.dedup();
    some_channels.dedup_by(|a, b| a.id == b.id);
    Ok(SampleColumns::new(&some_signals, &some_channels, tasks))
}

/// The samples of many trials: keys of the trial, then signals, one batch for each trial. Files are read as a reader asks
/// for batches, so a study of any length can be read; each reader begins anew. `for batch in samples` gives a trial at a
/// time.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Samples {
    files: Arc<[File]>,
    columns: SampleColumns,
}

impl Samples {
    pub(crate) fn new(files: Arc<[File]>, columns: SampleColumns) -> Self {
        Self { files, columns }
    }
}

#[pymethods]
impl Samples {
    /// The names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.columns.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    /// How many trials there are.
    fn __len__(&self) -> usize {
        self.files.len()
    }

    fn __repr__(&self) -> String {
        format!("<zwidth.Samples: {} trials, {}>", self.files.len(), self.columns().join(", "))
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema; // left to the reader, as the interface allows
        arrow::stream(
            py,
            Batches { files: self.files.clone(), next: 0, columns: self.columns.clone() },
        )
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema(py, self.columns.schema())
    }
}

/// The batches of a reader.
struct Batches {
    files: Arc<[File]>,
    next: usize,
    columns: SampleColumns,
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        let file = self.files.get(self.next)?;
        self.next += 1;
        Some(
            file.read(&self.columns)
                .map_err(|fault| ArrowError::ExternalError(fault.text().into())),
        )
    }
}

impl RecordBatchReader for Batches {
    fn schema(&self) -> SchemaRef {
        self.columns.schema().clone()
    }
}

/// A trial: what is known of it, and its samples by name (`trial["theta_rad"]`).
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Trial {
    file: File,
    batch: RecordBatch,
    /// What its metrics depend on; none of a file that is read without its study.
    parameters: Option<Parameters>,
}

impl Trial {
    /// Reads a trial's file with all signals and channels that it has.
    pub(crate) fn read(
        path: &Path,
        meta: Option<TrialMeta>,
        parameters: Option<Parameters>,
    ) -> Result<Self, Fault> {
        let footer = read_footer(path)?;
        let meta = meta.unwrap_or(footer.meta);
        let tasks = meta.presented.is_some();
        let columns = SampleColumns::new(&footer.signals, &footer.form.channels, tasks);
        let file = File { path: path.into(), meta };
        let batch = file.read(&columns)?;
        Ok(Self { file, batch, parameters })
    }
}

#[pymethods]
impl Trial {
    /// Who.
    #[getter]
    fn participant(&self) -> &str {
        self.file.meta.participant.as_str()
    }

    /// In which session.
    #[getter]
    fn session(&self) -> &str {
        self.file.meta.session.as_str()
    }

    /// Its number in the session, from 1.
    #[getter]
    fn number(&self) -> u32 {
        self.file.meta.trial
    }

    /// Which repeat of its condition, from 1.
    #[getter]
    fn repeat(&self) -> u32 {
        self.file.meta.repeat
    }

    /// What was rendered.
    #[getter]
    fn environment(&self) -> &str {
        self.file.meta.environment.as_str()
    }

    /// How it was rendered; a code in the file of a sealed session.
    #[getter]
    fn mode(&self) -> &str {
        self.file.meta.mode.as_str()
    }

    /// Where its numbers come from: recorded, twin, imported or simulated. Of twin and simulated nothing was measured.
    #[getter]
    fn source(&self) -> &'static str {
        self.file.meta.source.as_str()
    }

    /// The names of its columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.batch.schema_ref().fields().iter().map(|field| field.name().clone()).collect()
    }

    /// Its metrics, as a run computes them, without those that rest on the identified plant or come from outside: a table of
    /// one row.
    fn metrics(&self, py: Python<'_>) -> PyResult<Table> {
        let Some(parameters) = self.parameters.clone() else {
            let remedy = "read it by read_study(root, study).trial(participant, session, number), or give its arrays to trial_metrics";
            return Err(Fault::new("a file alone does not say what was rendered", remedy)
                .in_file(self.file.path.to_string_lossy())
                .into());
        };
        let file = self.file.clone();
        call(py, move |_| {
            let signals = recorded(&file.path, &parameters.signals())?;
            let read = read_trial_and_channels(&file.path, signals, &parameters.channels())?;
            let trial = Recorded { meta: file.meta, ..read };
            let row = trial_metrics(&trial, &parameters).map_err(Fault::said)?;
            let in_space = parameters.axes.is_some();
            Table::new(metrics_table(&[row], &parameters.own, in_space).map_err(Fault::said)?)
        })
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __getitem__(&self, column: &str) -> PyResult<Column> {
        Column::of(&self.batch, column)
    }

    fn __repr__(&self) -> String {
        let TrialMeta { participant, session, trial, environment, mode, .. } = &self.file.meta;
        let samples = self.batch.num_rows();
        format!(
            "<zwidth.Trial {participant} {session} {trial}: {environment}, {mode}, {samples} samples>"
        )
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema; // left to the reader, as the interface allows
        let schema = self.batch.schema();
        arrow::stream(py, arrow_array::RecordBatchIterator::new([Ok(self.batch.clone())], schema))
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema(py, self.batch.schema_ref())
    }
}

/// Reads a trial's file, all of its columns, and checks them as `zwidth verify` does. SI units.
#[pyfunction]
pub(crate) fn read_trial(py: Python<'_>, path: PathBuf) -> PyResult<Trial> {
    call(py, move |_| Trial::read(&path, None, None))
}
