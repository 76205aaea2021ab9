//! The terms of a scene, and how a file names them.

use std::sync::Arc;

use serde::de::{DeserializeSeed, Deserializer, Error as _};
use serde::ser::{Error as _, SerializeMap};
use serde::{Deserialize, Serialize, Serializer};
use toml::Value;

use super::READERS;
use super::term::{Affine, Read, Term, Written};
use crate::error::{DynamicsError, LARGEST, Result, check};
use crate::scene::input::Input;
use crate::scene::numbers;
use crate::scene::plant::Plant;

/// The terms of a scene, at most one of each name, in order of their names.
#[derive(Debug, Clone, Default)]
pub struct Terms(Vec<Arc<dyn Written>>);

impl Terms {
    /// Adds a term, replacing the one with its name.
    pub fn set(&mut self, term: impl Term + Serialize + 'static) {
        self.put(Arc::new(term));
    }

    fn put(&mut self, term: Arc<dyn Written>) {
        match self.0.binary_search_by(|existing| existing.name().cmp(term.name())) {
            Ok(at) => self.0[at] = term,
            Err(at) => self.0.insert(at, term),
        }
    }

    /// Takes out the term of a name, if there is one.
    pub fn remove(&mut self, name: &str) {
        self.0.retain(|term| term.name() != name);
    }

    /// The terms, in order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Term> {
        self.0.iter().map(|term| &**term as &dyn Term)
    }

    /// The one signal of time that a term has.
    pub(crate) fn input(&self) -> Option<&Input> {
        self.iter().find_map(|term| term.input().map(|(_, input)| input))
    }

    /// Name, value and usual size of each parameter.
    pub(crate) fn list(&self) -> Vec<(String, f64, f64)> {
        /// A displacement's usual size, rad.
        const USUAL_RAD: f64 = numbers::HALF_STROKE_RAD;
        let mut list = Vec::new();
        for term in self.iter() {
            for p in term.parameters() {
                list.push((format!("{}.{}", term.name(), p.name), p.value, p.usual));
            }
            if let Some((field, input)) = term.input() {
                input.list(&format!("{}.{field}", term.name()), USUAL_RAD, &mut list);
            }
        }
        list
    }

    pub(crate) fn check(&self, plant: &Plant, duration_s: f64) -> Result<()> {
        for term in self.iter() {
            for p in term.parameters() {
                (p.check)(&format!("{}.{}", term.name(), p.name), p.value)?;
            }
            if let Some((field, input)) = term.input() {
                input.check(&format!("{}.{field}", term.name()), duration_s)?;
            }
            let Affine { constant_n, per_rad_n, per_rad_s_n, per_input_n } = term.affine(plant);
            let coefficients = [constant_n, per_rad_n, per_rad_s_n, per_input_n];
            // A coefficient may be a product of parameters; what can be named is the largest of
            // these.
            let parameters = term.parameters().into_iter();
            if let Some(p) = parameters.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs())) {
                let ok = coefficients.iter().all(|x| x.abs() <= LARGEST);
                let allowed = "such that the term's forces are at most 1e30 N per unit";
                check(format_args!("{}.{}", term.name(), p.name), p.value, ok, allowed)?;
            }
        }
        if self.iter().filter(|term| term.input().is_some()).count() > 1 {
            let what = "two terms have an input of their own";
            let remedy = "leave one of them out";
            return Err(DynamicsError::Combination { what, remedy });
        }
        Ok(())
    }

    /// Adds the term that a file has under one of the [`names`], by its number.
    pub(crate) fn reader(
        &mut self,
        number: usize,
    ) -> impl for<'de> DeserializeSeed<'de, Value = ()> {
        Reader { terms: self, read: READERS[number].1 }
    }
}

/// The keys a file can name a term by.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    READERS.iter().map(|(name, _)| *name)
}

/// Terms are equal if a file would have the same text for them.
impl PartialEq for Terms {
    fn eq(&self, other: &Self) -> bool {
        self.0.len() == other.0.len()
            && self.0.iter().zip(&other.0).all(|(a, b)| {
                a.name() == b.name() && a.value().is_ok_and(|value| b.value() == Ok(value))
            })
    }
}

impl Serialize for Terms {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for term in &self.0 {
            map.serialize_entry(term.name(), &term.value().map_err(S::Error::custom)?)?;
        }
        map.end()
    }
}

struct Reader<'a> {
    terms: &'a mut Terms,
    read: Read,
}

impl<'de> DeserializeSeed<'de> for Reader<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(
        self,
        deserializer: D,
    ) -> std::result::Result<(), D::Error> {
        let value = Value::deserialize(deserializer)?;
        self.terms.put((self.read)(value).map_err(|e| D::Error::custom(e.message()))?);
        Ok(())
    }
}
