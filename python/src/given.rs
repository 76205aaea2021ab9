//! Arrays that are given: float64, one dimension, numbers.

use crate::calling::Fault;
use crate::table::Column;
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::PyMemoryView;

const FLOATS: &str = "give a one-dimensional array of float64, such as numpy.asarray(values, dtype=float) or array.array('d', values)";

/// How buffers name a float64 of this machine.
const NATIVE: [&[u8]; 4] =
    [b"d", b"@d", b"=d", if cfg!(target_endian = "little") { b"<d" } else { b">d" }];

/// The numbers of an array: anything with a buffer of float64, or with `__array__` (a column of pandas, polars or pyarrow).
/// They are copied.
pub(crate) fn numbers(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let values = floats(name, given)?;
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(values),
        Some(row) => {
            let what = format!("{} is no number", values[row]);
            let remedy = "leave out samples without a value, in every array alike";
            Err(Fault::new(what, remedy).in_column(name).in_row0(row).into())
        }
    }
}

fn floats(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let py = given.py();
    // Without NumPy, which `__array__` would need.
    if let Some(values) = given.cast::<Column>().ok().and_then(|column| column.get().floats()) {
        return Ok(values);
    }
    let buffer = PyBuffer::<f64>::get(given).or_else(|error| {
        if let Some(unnamed) = without_named_order(given) {
            return PyBuffer::<f64>::get(&unnamed);
        }
        match given.getattr("__array__") {
            Ok(array) => PyBuffer::<f64>::get(&array.call0()?),
            Err(_) => Err(error),
        }
    });
    let Ok(buffer) = buffer else {
        // Nothing lies nowhere in particular, which no buffer of float64 may.
        if given.len().is_ok_and(|length| length == 0) {
            return Ok(Vec::new());
        }
        let what = format!("{} is no array of float64", kind(given));
        return Err(Fault::new(what, FLOATS).in_column(name).into());
    };
    let format = buffer.format().to_bytes();
    let what = if !NATIVE.contains(&format) {
        // pyo3 0.30 takes bytes of the other order as if they were of this one.
        Some(format!("{} in bytes of the other order", kind(given)))
    } else {
        Some(format!("an array of {} dimensions", buffer.dimensions()))
            .filter(|_| buffer.dimensions() != 1)
    };
    if let Some(what) = what {
        return Err(Fault::new(what, FLOATS).in_column(name).into());
    }
    buffer.to_vec(py)
}

/// A row of float64 whose format names this machine's byte order, as the arrays of ctypes do, in a view that names none:
/// pyo3 0.30 refuses the name.
fn without_named_order<'py>(given: &Bound<'py, PyAny>) -> Option<Bound<'py, PyAny>> {
    let named = if cfg!(target_endian = "little") { "<d" } else { ">d" };
    let view = PyMemoryView::from(given).ok()?;
    let is_row = view.getattr("ndim").ok()?.extract::<usize>().ok()? == 1;
    let is_named = view.getattr("format").ok()?.extract::<String>().ok()? == named;
    if !(is_row && is_named) {
        return None;
    }
    view.call_method1("cast", ("B",)).ok()?.call_method1("cast", ("d",)).ok()
}

/// What an object is: its type, and of an array what is in it.
fn kind(given: &Bound<'_, PyAny>) -> String {
    let name =
        given.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    match given.getattr("dtype") {
        Ok(dtype) => format!("{name} of {dtype}"),
        Err(_) => name,
    }
}

/// Times, s, that run forward.
pub(crate) fn times(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let times = numbers(name, given)?;
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(times),
        Some(before) => {
            let what =
                format!("the time {} s does not come after {} s", times[before + 1], times[before]);
            let remedy = "sort the samples by time, and leave out those that repeat one";
            Err(Fault::new(what, remedy).in_column(name).in_row0(before + 1).into())
        }
    }
}

/// The numbers of an array beside another of this length.
pub(crate) fn beside(
    name: &str,
    given: &Bound<'_, PyAny>,
    other: &str,
    length: usize,
) -> PyResult<Vec<f64>> {
    let values = numbers(name, given)?;
    if values.len() == length {
        return Ok(values);
    }
    let what = format!("{} values, where {other} has {length}", values.len());
    Err(Fault::new(what, "give arrays of one length").in_column(name).into())
}

/// Velocities beside times: those given, or the derivative of the angles by central differences.
pub(crate) fn velocities(
    t: &[f64],
    theta: &[f64],
    given: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<f64>> {
    match given {
        Some(velocity) => beside("velocity", velocity, "t", t.len()),
        None => Ok(zwidth_numerics::series::central_differences(t, theta).map_err(Fault::said)?),
    }
}
