//! A table, and one column of it.

use crate::arrow;
use crate::calling::Fault;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int32Type, Int64Type, UInt16Type};
use arrow_array::{Array, ArrayRef, RecordBatch, RecordBatchIterator};
use arrow_schema::{DataType, FieldRef};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyDict, PyList};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_study::{Coordinate, Study};
use zwidth_tables::{Format, Table as Rows, Wording};

/// Rows that a notebook shows.
const MOST_SHOWN: usize = 50;

/// A table: columns that know their unit and what they mean.
///
/// pyarrow, polars and pandas read it by Arrow's interface: `pyarrow.table(t)`, `polars.DataFrame(t)`,
/// `pandas.DataFrame.from_arrow(t)`. Units and meanings come along as the metadata of fields. Without any of them,
/// `to_dict()` gives lists.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Table {
    rows: Rows,
    batch: RecordBatch,
    /// How people read it.
    wording: Wording,
}

impl Table {
    pub(crate) fn new(rows: Rows) -> Result<Self, Fault> {
        let batch = rows.batch(Path::new(rows.name())).map_err(Fault::said)?;
        Ok(Self { rows, batch, wording: Wording::plain(Coordinate::Rotational) })
    }

    /// A table of a study, whose labels and units of people a notebook shows.
    pub(crate) fn of_study(rows: Rows, study: &Study) -> Result<Self, Fault> {
        Ok(Self { wording: Wording::of(study), ..Self::new(rows)? })
    }

    /// The same table without these columns.
    pub(crate) fn without(rows: &Rows, columns: &[&str]) -> Result<Self, Fault> {
        let left = rows.columns().iter().filter(|c| !columns.contains(&&*c.field.name)).cloned();
        let table = Rows::new(rows.name(), rows.title(), left.collect()).map_err(Fault::said)?;
        let notes = rows.notes_by_kind();
        Self::new(notes.fold(table, |table, (kind, note)| table.with_note_of(kind, note)))
    }
}

#[pymethods]
impl Table {
    /// The title, a phrase.
    #[getter]
    fn title(&self) -> &str {
        self.rows.title()
    }

    /// What is to be read below the table.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.rows.notes().to_vec()
    }

    /// The names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.rows.fields().map(|field| field.name.to_string()).collect()
    }

    /// The unit of each column; "1" of a pure number or a word, "" where a column `unit` says it row by row.
    #[getter]
    fn units(&self) -> BTreeMap<String, String> {
        self.rows.fields().map(|field| (field.name.to_string(), field.unit.to_string())).collect()
    }

    /// What each column means.
    #[getter]
    fn meanings(&self) -> BTreeMap<String, String> {
        self.rows
            .fields()
            .map(|field| (field.name.to_string(), field.description.to_string()))
            .collect()
    }

    /// The columns as lists by name; None where a value is missing.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (field, array) in self.batch.schema_ref().fields().iter().zip(self.batch.columns()) {
            dict.set_item(field.name(), list(py, array)?)?;
        }
        Ok(dict)
    }

    fn __len__(&self) -> usize {
        self.rows.height()
    }

    fn __getitem__(&self, column: &str) -> PyResult<Column> {
        Column::of(&self.batch, column)
    }

    fn __repr__(&self) -> String {
        let columns = self.rows.columns().len();
        format!(
            "<zwidth.Table {:?}: {} rows, {columns} columns>",
            self.rows.title(),
            self.rows.height()
        )
    }

    /// The table as a notebook shows it, in the units of people.
    fn _repr_html_(&self) -> PyResult<String> {
        Ok(self.html()?)
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema; // what it may ask for is left to the reader, as the interface allows
        let schema = self.batch.schema();
        arrow::stream(py, RecordBatchIterator::new([Ok(self.batch.clone())], schema))
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema(py, self.batch.schema_ref())
    }
}

impl Table {
    /// As HTML, in the units of people: the first rows.
    pub(crate) fn html(&self) -> Result<String, Fault> {
        let shown: Vec<usize> = (0..self.rows.height().min(MOST_SHOWN)).collect();
        let rows = self.rows.rows(&shown);
        let file = [(Format::Html, Path::new("table.html"))];
        let bytes =
            rows.to_bytes(&rows, &file, &self.wording, &BTreeMap::new()).map_err(Fault::said)?;
        let html = String::from_utf8_lossy(&bytes.concat()).into_owned();
        Ok(match self.rows.height() - shown.len() {
            0 => html,
            more => format!("{html}\n<p>and {more} more rows</p>"),
        })
    }
}

/// One column: `numpy.asarray(c)`, `pyarrow.array(c)`, `polars.Series(c)`, or `c.to_list()`.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Column {
    field: FieldRef,
    array: ArrayRef,
}

impl Column {
    pub(crate) fn of(batch: &RecordBatch, name: &str) -> PyResult<Self> {
        let schema = batch.schema_ref();
        let Some((place, field)) = schema.fields().find(name) else {
            let names: Vec<&str> =
                schema.fields().iter().map(|field| field.name().as_str()).collect();
            return Err(PyKeyError::new_err(format!(
                "no column {name:?}; there are {}",
                names.join(", ")
            )));
        };
        Ok(Self { field: field.clone(), array: batch.column(place).clone() })
    }

    /// Its numbers as float64, NaN where one is missing; none of another type.
    pub(crate) fn floats(&self) -> Option<Vec<f64>> {
        let values = self.array.as_primitive_opt::<Float64Type>()?;
        Some(values.iter().map(|value| value.unwrap_or(f64::NAN)).collect())
    }

    fn said(&self, key: &str) -> &str {
        self.field.metadata().get(key).map_or("", String::as_str)
    }
}

#[pymethods]
impl Column {
    /// Its name, with its unit as suffix.
    #[getter]
    fn name(&self) -> &str {
        self.field.name()
    }

    /// Its unit.
    #[getter]
    fn unit(&self) -> &str {
        self.said("unit")
    }

    /// What it means.
    #[getter]
    fn meaning(&self) -> &str {
        self.said("description")
    }

    /// Its values; None where one is missing.
    fn to_list<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        list(py, &self.array)
    }

    fn __len__(&self) -> usize {
        self.array.len()
    }

    fn __repr__(&self) -> String {
        format!(
            "<zwidth.Column {}: {} values, {}>",
            self.field.name(),
            self.array.len(),
            self.said("unit")
        )
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_array__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyCapsule>, Bound<'py, PyCapsule>)> {
        let _ = requested_schema; // left to the reader, as the interface allows
        arrow::array(py, &self.field, &self.array)
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema(py, &arrow_schema::Schema::new([self.field.clone()]))
    }

    /// A copy for NumPy. Numbers that are missing are NaN, because NumPy knows no other way.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let _ = copy; // it always is one
        let numpy = py.import("numpy")?;
        let array = match self.floats() {
            Some(values) => {
                let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_ne_bytes).collect();
                numpy.call_method1("frombuffer", (PyBytes::new(py, &bytes), "f8"))?
            }
            None => numpy.call_method1("array", (list(py, &self.array)?,))?,
        };
        match dtype {
            Some(dtype) => array.call_method1("astype", (dtype,)),
            None => Ok(array),
        }
    }
}

/// The values of a column; None where one is missing.
fn list<'py>(py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyList>> {
    match array.data_type() {
        DataType::Float64 => {
            PyList::new(py, array.as_primitive::<Float64Type>().iter().collect::<Vec<_>>())
        }
        DataType::Float32 => {
            PyList::new(py, array.as_primitive::<Float32Type>().iter().collect::<Vec<_>>())
        }
        DataType::Int64 => {
            PyList::new(py, array.as_primitive::<Int64Type>().iter().collect::<Vec<_>>())
        }
        DataType::Int32 => {
            PyList::new(py, array.as_primitive::<Int32Type>().iter().collect::<Vec<_>>())
        }
        DataType::UInt16 => {
            PyList::new(py, array.as_primitive::<UInt16Type>().iter().collect::<Vec<_>>())
        }
        DataType::Utf8 => PyList::new(py, array.as_string::<i32>().iter().collect::<Vec<_>>()),
        DataType::Boolean => PyList::new(py, array.as_boolean().iter().collect::<Vec<_>>()),
        // Samples that a file lacks are of one of the types above, null throughout.
        _ => PyList::new(py, vec![None::<f64>; array.len()]),
    }
}
