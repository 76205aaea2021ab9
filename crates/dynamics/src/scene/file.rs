//! Reads and writes a scene: its keys are its own fields or the names of terms, and errors point at
//! the line.

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::ModelScene;
use super::terms::{self, Terms};

/// The fields' own reading and writing are derived as `ModelScene::deserialize` and
/// `ModelScene::serialize` (serde's `remote = "Self"`), to which the terms are added here.
impl<'de> Deserialize<'de> for ModelScene {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Whole)
    }
}

impl Serialize for ModelScene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        ModelScene::serialize(self, serializer)
    }
}

struct Whole;

impl<'de> Visitor<'de> for Whole {
    type Value = ModelScene;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a scene")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ModelScene, A::Error> {
        let mut terms = Terms::default();
        let scene =
            ModelScene::deserialize(MapAccessDeserializer::new(Fields { map, terms: &mut terms }))?;
        Ok(ModelScene { terms, ..scene })
    }
}

/// A map without the keys that name terms: these are read as they are met.
struct Fields<'a, A> {
    map: A,
    terms: &'a mut Terms,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Fields<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        let mut key = Key(seed);
        loop {
            match self.map.next_key_seed(key)? {
                None => return Ok(None),
                Some(MapKey::Field(field)) => return Ok(Some(field)),
                Some(MapKey::Term(number, seed)) => {
                    self.map.next_value_seed(self.terms.reader(number))?;
                    key = Key(seed);
                }
            }
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

/// Reads a key; fields by a seed of their own.
struct Key<K>(K);

/// A key of the map.
enum MapKey<V, K> {
    /// A field of the scene's own.
    Field(V),
    /// A term's number, and the seed for the next key.
    Term(usize, K),
}

impl<'de, K: DeserializeSeed<'de>> DeserializeSeed<'de> for Key<K> {
    type Value = MapKey<K::Value, K>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        let key = String::deserialize(deserializer)?;
        if let Some(number) = terms::names().position(|name| name == key) {
            return Ok(MapKey::Term(number, self.0));
        }
        // Only the field's own seed can tell which names it takes: its error lists them, without
        // the terms, which are added.
        let field: Result<_, D::Error> = self.0.deserialize(key.into_deserializer());
        field.map(MapKey::Field).map_err(|e| {
            let names: Vec<_> = terms::names().map(|name| format!("`{name}`")).collect();
            Error::custom(format_args!(
                "{}, or a term: {}",
                e.to_string().trim_end(),
                names.join(", ")
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::actuators::DriveMode;
    use crate::scene::input::Input;
    use crate::scene::table3;
    use crate::{ModelScene, Pull};

    /// A scene's text with a line more on top, and the error it gives.
    fn error(line: &str) -> String {
        let text = table3::scene(DriveMode::Active, Input::step(1.0)).to_toml().unwrap();
        ModelScene::from_toml(&format!("{line}\n{text}")).unwrap_err().to_string()
    }

    #[test]
    fn a_term_is_written_and_read_under_its_name() {
        let mut scene = table3::scene(DriveMode::Active, Input::step(1.0));
        scene.terms.set(Pull { stiffness_n_per_rad: 0.1, displacement: Input::constant(0.3) });
        let text = scene.to_toml().unwrap();
        assert!(text.contains("[pull]"), "{text}");
        assert_eq!(ModelScene::from_toml(&text).unwrap(), scene);
    }

    #[test]
    fn a_word_that_is_neither_field_nor_term_is_an_error_with_its_line_and_what_there_is() {
        let error = error("\ngravty = { mass_kg = 0.02, radius_m = 0.04 }");
        for part in ["line 2, column 1", "`gravty`", "`friction`, or a term: `gravity`, `pull`"] {
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn a_word_that_a_term_lacks_is_an_error_with_its_line() {
        let error = error("gravity = { mass_kg = 0.02, radius_mm = 40 }");
        assert!(error.contains("line 1, column 11") && error.contains("`radius_mm`"), "{error}");
    }
}
