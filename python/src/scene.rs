//! A scene as it is given: a file, or a dict of what the file holds, with other values for some of its keys.

use crate::calling::Fault;
use crate::given::numbers;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyString};
use std::path::PathBuf;
use toml::Value;
use zwidth_simulate::{DynamicsError, ModelScene, SimulateError};

/// Largest scene that is read, bytes: a long series of forces.
const MOST_SCENE: u64 = 1 << 26;

/// A scene, and where it came from.
#[derive(Clone)]
pub(crate) struct Given {
    file: Option<String>,
    value: Value,
}

/// A key of a scene with one value for each run.
pub(crate) struct Varied {
    /// As in the scene's file, with dots: `plant.mass_kg`.
    pub(crate) key: String,
    pub(crate) values: Vec<f64>,
}

impl Given {
    /// The scene of a file or a dict.
    pub(crate) fn new(scene: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = scene.py();
        if scene.is_instance_of::<PyDict>() {
            let json: String = py.import("json")?.call_method1("dumps", (scene,))?.extract()?;
            let value = serde_json::from_str(&json);
            let value = value.map_err(|e| {
                Fault::new(
                    format!("this is not a scene: {e}"),
                    "give what tomllib reads from a scene's file",
                )
            })?;
            return Ok(Self { file: None, value });
        }
        let path: PathBuf = scene.extract().map_err(|_| {
            Fault::new(
                "the scene is neither a path nor a dict",
                "give the path of a scene's file, or what tomllib reads from one",
            )
        })?;
        let file = path.to_string_lossy().into_owned();
        let bytes = zwidth_store::read_named(&path, MOST_SCENE)
            .map_err(|e| Fault::new(e.to_string(), "check the path").in_file(&file))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| Fault::new("its text is not UTF-8", "save it as UTF-8").in_file(&file))?;
        let value = toml::from_str(&text).map_err(|e| Fault::said(e).in_file(&file))?;
        Ok(Self { file: Some(file), value })
    }

    /// The scene with the values of one run.
    pub(crate) fn with(&self, varied: &[Varied], run: usize) -> Result<ModelScene, Fault> {
        let mut value = self.value.clone();
        for Varied { key, values } in varied {
            // A number for all runs stands once.
            let of_run = if values.len() == 1 { values[0] } else { values[run] };
            *self.place(&mut value, key)? = Value::Float(of_run);
        }
        let scene = value.try_into::<ModelScene>();
        scene.map_err(|e| {
            self.at(Fault::new(
                format!("this is not a scene: {e}"),
                "see docs/methods.md for the keys of a scene",
            ))
        })
    }

    /// The scene as it is.
    pub(crate) fn scene(&self) -> Result<ModelScene, Fault> {
        self.with(&[], 0)
    }

    /// Where a key stands.
    fn place<'v>(&self, value: &'v mut Value, key: &str) -> Result<&'v mut Value, Fault> {
        let mut place = value;
        for part in key.split('.') {
            let next = match place {
                Value::Table(table) => table.get_mut(part),
                Value::Array(list) => part.parse::<usize>().ok().and_then(|at| list.get_mut(at)),
                _ => None,
            };
            let remedy = "name a number that the scene's file has, its sections by two underscores: plant__mass_kg, environment__zones__0__from_rad";
            place = next.ok_or_else(|| {
                self.at(Fault::new("the scene has no such key", remedy).in_column(key))
            })?;
        }
        match place {
            Value::Float(_) | Value::Integer(_) => Ok(place),
            _ => {
                Err(self.at(Fault::new("this key of the scene is no number", "vary numbers alone")
                    .in_column(key)))
            }
        }
    }

    /// A fault of this scene.
    pub(crate) fn at(&self, fault: Fault) -> Fault {
        match &self.file {
            Some(file) => fault.in_file(file),
            None => fault,
        }
    }

    /// An error of a run of it.
    pub(crate) fn error(&self, error: &SimulateError) -> Fault {
        let fault = Fault::said(error);
        self.at(match error {
            SimulateError::Dynamics(DynamicsError::Parameter { name, .. }) => fault.in_column(name),
            _ => fault,
        })
    }
}

/// The keyword arguments that name keys of a scene: numbers for all runs, or arrays of one length with a number for each.
pub(crate) fn varied(given: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<Varied>> {
    let mut varied: Vec<Varied> = Vec::new();
    for (key, value) in given.into_iter().flatten() {
        let key: String = key.cast::<PyString>()?.extract()?;
        let key = key.replace("__", ".");
        let values = if value.is_instance_of::<PyFloat>() || value.is_instance_of::<PyInt>() {
            let value: f64 = value.extract()?;
            if !value.is_finite() {
                return Err(Fault::new(format!("{value} is no number"), "give a number")
                    .in_column(key)
                    .into());
            }
            vec![value]
        } else {
            let values = numbers(&key, &value)?;
            if values.is_empty() {
                return Err(Fault::new("an array without values", "give a value for each run")
                    .in_column(key)
                    .into());
            }
            values
        };
        varied.push(Varied { key, values });
    }
    let longest = runs(&varied);
    if let Some(short) = varied.iter().find(|v| v.values.len() != 1 && v.values.len() != longest) {
        let what = format!("{} values, where another key has {longest}", short.values.len());
        return Err(Fault::new(what, "give numbers, or arrays of one length")
            .in_column(&short.key)
            .into());
    }
    Ok(varied)
}

/// How many runs these make.
pub(crate) fn runs(varied: &[Varied]) -> usize {
    varied.iter().map(|varied| varied.values.len()).max().unwrap_or(1)
}
