//! Sweeps: what an actuator or sensor did while its command was varied.

use crate::form::digest::column_digest;
use crate::form::footer::{from_path, required, rest_of};
use crate::form::opened::ParquetFile;
use crate::form::read::check_described;
use crate::form::values::floats;
use crate::form::write::{DIGEST, described};
use crate::{Files, Layout, RealFiles, Storage, StoreError, SweepEntry, write_parquet};
use arrow::array::{ArrayRef, Float64Array, Int32Array, RecordBatch, new_null_array};
use arrow::datatypes::{DataType, Field, Schema};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_study::{ActuatorId, Source};

/// The quantity in a column of a sweep, with its unit, which is part of the sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quantity {
    /// In words, for an axis: `voltage`, `brake torque`.
    pub name: String,
    /// The unit: `V`, `counts`, `N`, `mN·m`.
    pub unit: String,
}

/// One sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// What was characterised.
    pub actuator: ActuatorId,
    /// Number of the sweep, from 1.
    pub sweep: u32,
    /// Measured, simulated or imported.
    pub source: Source,
    /// What was commanded.
    pub command: Quantity,
    /// The measured result.
    pub response: Quantity,
    /// Time, s, where known.
    pub t_s: Option<Vec<f64>>,
    /// The command, in its unit.
    pub command_values: Vec<f64>,
    /// The response, in its unit.
    pub response_values: Vec<f64>,
    /// What else the file says about itself.
    pub file: BTreeMap<String, String>,
}

impl Sweep {
    /// Whether the sweep has the same quantities as another, so that both can be fitted together.
    pub fn is_like(&self, other: &Self) -> bool {
        self.command == other.command && self.response == other.response
    }

    /// Says in words that the sweep has other quantities than the first one.
    pub fn unlike(&self, first: &Self) -> String {
        let [own, other] = [self, first].map(|Self { command, response, .. }| {
            let Quantity { name, unit } = response;
            format!("{name} ({unit}) against {} ({})", command.name, command.unit)
        });
        format!(
            "sweep {} of the {}: {own} does not go with the first sweep's {other}",
            self.sweep, self.actuator
        )
    }
}

const COMMAND: &str = "command";
const RESPONSE: &str = "response";
const TIME: &str = "t_s";
const TIME_ABOUT: &str = "time since the sweep's start";
/// The keys of a footer that hold what a sweep is.
const OF_SWEEP: [&str; 7] =
    ["actuator", "source", COMMAND, "command_unit", RESPONSE, "response_unit", "sweep"];

/// The bytes of a sweep's file.
///
/// # Errors
/// Columns of unequal length, no sample, or a value that is not finite, with column and row.
pub fn sweep_bytes(sweep: &Sweep, path: &Path) -> Result<Vec<u8>, StoreError> {
    let n = sweep.command_values.len();
    if n == 0 {
        return Err(StoreError::new(path, "there is no sample", "record the sweep again"));
    }
    let number = i32::try_from(sweep.sweep).unwrap_or(i32::MAX);
    let mut footer = sweep.file.clone();
    let mut columns: Vec<(Field, ArrayRef)> = vec![
        (
            described("sweep", DataType::Int32, false, "1", "number of the sweep"),
            Arc::new(Int32Array::from(vec![number; n])),
        ),
        match &sweep.t_s {
            Some(t) => column(path, &mut footer, TIME, t, n, "s", TIME_ABOUT)?,
            None => (
                described(TIME, DataType::Float64, true, "s", TIME_ABOUT),
                new_null_array(&DataType::Float64, n),
            ),
        },
    ];
    for (name, values, quantity) in [
        (COMMAND, &sweep.command_values, &sweep.command),
        (RESPONSE, &sweep.response_values, &sweep.response),
    ] {
        columns.push(column(path, &mut footer, name, values, n, &quantity.unit, &quantity.name)?);
    }
    for (key, value) in [
        ("source", sweep.source.as_str()),
        ("command", &sweep.command.name),
        ("command_unit", &sweep.command.unit),
        ("response", &sweep.response.name),
        ("response_unit", &sweep.response.unit),
    ] {
        footer.insert(key.to_owned(), value.to_owned());
    }
    footer.insert("sweep".to_owned(), sweep.sweep.to_string());
    footer.insert("actuator".to_owned(), sweep.actuator.to_string());
    let (fields, arrays): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays).map_err(|e| {
        StoreError::new(path, e.to_string(), "this is a defect of zwidth; please report it")
    })?;
    write_parquet(&batch, footer, path)
}

fn column(
    path: &Path,
    footer: &mut BTreeMap<String, String>,
    name: &str,
    values: &[f64],
    n: usize,
    unit: &str,
    about: &str,
) -> Result<(Field, ArrayRef), StoreError> {
    if values.len() != n {
        let what = format!("it has {} values where the command has {n}", values.len());
        return Err(StoreError::new(path, what, "columns must be equally long").column(name));
    }
    if let Some(row) = values.iter().position(|v| !v.is_finite()) {
        let what = format!("{} is not a number", values[row]);
        return Err(StoreError::new(path, what, "mend or drop the row").column(name).row0(row));
    }
    footer.insert(format!("{DIGEST}{name}"), column_digest(values, Storage::F64));
    let field = described(name, DataType::Float64, true, unit, about);
    Ok((field, Arc::new(Float64Array::from(values.to_vec()))))
}

/// A sweep without its samples; it must lie where its footer says it belongs, so that none exists
/// twice.
pub(crate) fn entry(
    files: &dyn Files,
    layout: &Layout,
    path: PathBuf,
    actuator: ActuatorId,
) -> Result<SweepEntry, StoreError> {
    let file = ParquetFile::open_recording(files, &path)?;
    file.columns()?; // no log holds a sweep's hash that would tell of damage there
    let blake3 = file.blake3()?;
    let footer = file.footer;
    let [number, owner, source] = ["sweep", "actuator", "source"]
        .map(|key| footer.get(key).map(String::as_str).unwrap_or_default());
    let is_at_its_place = number.parse().is_ok_and(|n| layout.sweep(&actuator, n) == path);
    if owner == actuator.as_str() && is_at_its_place {
        let source = Source::from_word(source).ok_or_else(|| bad_key(&path, "source"))?;
        return Ok(SweepEntry { path, actuator, source, blake3 });
    }
    let what =
        format!("the file is sweep {number} of '{owner}' by its footer, but not by its name");
    Err(StoreError::new(&path, what, "give it its own name again; a sweep must not exist twice"))
}

const REMEDY: &str = "restore the file from a copy, or import the sweep again";

fn bad_key(path: &Path, name: &str) -> StoreError {
    StoreError::new(path, format!("its metadata '{name}' are not valid"), REMEDY)
}

/// Reads a sweep; the actuator comes from the path. Checks are those of a trial.
pub fn read_sweep(path: &Path) -> Result<Sweep, StoreError> {
    read_sweep_from(&RealFiles, path)
}

pub(crate) fn read_sweep_from(files: &dyn Files, path: &Path) -> Result<Sweep, StoreError> {
    let file = ParquetFile::open_recording(files, path)?;
    let [command, response] = [[COMMAND, "command_unit"], [RESPONSE, "response_unit"]].map(
        |[name, unit]| -> Result<Quantity, StoreError> {
            let name = required(path, &file.footer, name, REMEDY)?.to_owned();
            Ok(Quantity { name, unit: required(path, &file.footer, unit, REMEDY)?.to_owned() })
        },
    );
    let (command, response) = (command?, response?);
    let columns = file.columns()?;
    for (name, q) in [(COMMAND, &command), (RESPONSE, &response)] {
        check_described(path, columns.schema(), name, &DataType::Float64, &q.unit)?;
    }
    let batch = file.read(columns, &[TIME, COMMAND, RESPONSE])?;
    let [t_s, command_values, response_values] =
        [TIME, COMMAND, RESPONSE].map(|name| column_values(path, &batch, &file.footer, name));
    Ok(Sweep {
        actuator: from_path(path, "actuator")?,
        sweep: required(path, &file.footer, "sweep", REMEDY)?
            .parse()
            .map_err(|_| bad_key(path, "sweep"))?,
        source: Source::from_word(required(path, &file.footer, "source", REMEDY)?)
            .ok_or_else(|| bad_key(path, "source"))?,
        t_s: t_s?,
        command_values: command_values?.ok_or_else(|| no_digest(path, COMMAND))?,
        response_values: response_values?.ok_or_else(|| no_digest(path, RESPONSE))?,
        command,
        response,
        file: rest_of(&file.footer, &OF_SWEEP),
    })
}

/// The values of a column; `None` for one without a digest, which is null throughout.
fn column_values(
    path: &Path,
    batch: &RecordBatch,
    footer: &BTreeMap<String, String>,
    name: &str,
) -> Result<Option<Vec<f64>>, StoreError> {
    let array = batch
        .column_by_name(name)
        .ok_or_else(|| StoreError::new(path, "the column is missing", REMEDY).column(name))?;
    let Some(digest) = footer.get(&format!("{DIGEST}{name}")) else { return Ok(None) };
    let values = floats(array);
    if array.null_count() > 0 || *digest != column_digest(&values, Storage::F64) {
        let what = "the column is damaged: its values do not match their digest";
        return Err(StoreError::new(path, what, REMEDY).column(name));
    }
    Ok(Some(values))
}

fn no_digest(path: &Path, name: &str) -> StoreError {
    StoreError::new(path, "the column has no digest", REMEDY).column(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write_new;

    fn sample() -> Sweep {
        Sweep {
            actuator: "motor".parse().unwrap(),
            sweep: 3,
            source: Source::Imported,
            command: Quantity { name: "set point".into(), unit: "counts".into() },
            response: Quantity { name: "torque".into(), unit: "mN·m".into() },
            t_s: None,
            command_values: vec![0.0, 4.0, 8.0],
            response_values: vec![0.1, 0.2, 1e-321],
            file: BTreeMap::from([("made_by_import".to_owned(), "mean of 30".to_owned())]),
        }
    }

    #[test]
    fn a_sweep_comes_back_with_its_units() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("actuator=motor/sweep-03.parquet");
        write_new(&RealFiles, &path, &sweep_bytes(&sample(), &path).unwrap()).unwrap();
        assert_eq!(read_sweep(&path).unwrap(), sample());
    }

    #[test]
    fn a_sweep_with_a_value_that_is_no_number_is_refused_with_its_row() {
        let bad = Sweep { response_values: vec![0.1, f64::NAN, 0.0], ..sample() };
        let error = sweep_bytes(&bad, Path::new("x")).unwrap_err();
        assert_eq!((error.column.as_deref(), error.row), (Some("response"), Some(2)));
    }
}
