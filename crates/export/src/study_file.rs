//! The study's file as others may have it.

use crate::ExportError;
use toml::Table;

/// A study.toml without comments, which are notes of its authors, and without names of files (scenes, a
/// font, programs of stages).
///
/// # Errors
/// A text that is no TOML.
pub(crate) fn study_file(text: &str) -> Result<String, ExportError> {
    let failed =
        |error: &dyn std::fmt::Display| ExportError::Refused(format!("study.toml: {error}"));
    let mut study: Table = text.parse().map_err(|error: toml::de::Error| failed(&error))?;
    study.remove("scenes");
    study.remove("stage");
    if let Some(figures) = study.get_mut("figures").and_then(toml::Value::as_table_mut) {
        figures.remove("font");
    }
    toml::to_string(&study).map_err(|error| failed(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_names_of_files_stay_behind() {
        let text = "# by Jane\n[design]\nrepeats = 2 # as P03 asked\n[[scenes]]\nfiles = [\"a.toml\"]\n\
                    [[stage]]\nid = \"a\"\ncommand = [\"/home/jane/python\"]\n[figures]\nfont = [\"fonts/x.ttf\"]\nalignment = \"onset\"\n";
        let open = study_file(text).unwrap();
        assert_eq!(open, "[design]\nrepeats = 2\n\n[figures]\nalignment = \"onset\"\n");
        assert!(study_file("[").is_err());
    }
}
