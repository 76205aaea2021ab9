//! The font in which a study has its figures set.

use std::path::PathBuf;
use std::sync::Arc;
use zwidth_draw::{Font, FontFile};
use zwidth_runner::JobError;
use zwidth_store::{StoreError, StudyData, read_regular};

/// The files that study.toml names; none where figures are set in the program's own font.
pub(crate) fn files(data: &StudyData) -> Vec<PathBuf> {
    data.study.figures.font.iter().map(|file| data.layout.raw().join(file)).collect()
}

/// The font of these files.
pub(crate) fn read(files: &[PathBuf]) -> Result<Option<Font>, JobError> {
    if files.is_empty() {
        return Ok(None);
    }
    let mut fonts = Vec::new();
    for path in files {
        let bytes = read_regular(path, Font::MOST_BYTES)
            .map_err(|error| StoreError::io(path, "read", &error))?;
        fonts.push(FontFile { name: path.display().to_string(), bytes: Arc::new(bytes) });
    }
    Ok(Some(Font::new(&fonts)?))
}

/// The font in which a study has its figures set; `None` for the program's own.
///
/// # Errors
/// A file that cannot be read, or that cannot be drawn with.
pub fn font(data: &StudyData) -> Result<Option<Font>, JobError> {
    read(&files(data))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::data;

    #[test]
    fn the_font_of_a_study_is_an_input_of_each_of_its_figures_and_of_nothing_else() {
        let mut data = data();
        data.study.figures.font = vec!["fonts/a.ttf".to_owned()];
        let jobs = crate::jobs(&data, &zwidth_store::Findings::default());
        let font = data.layout.raw().join("fonts/a.ttf");
        let mut figures = 0;
        for job in jobs {
            let is_figure = job.name.starts_with("figure ");
            figures += usize::from(is_figure);
            assert_eq!(job.inputs().contains(&font), is_figure, "{}", job.name);
        }
        assert!(figures > 3, "only {figures} figures");
    }

    #[test]
    fn a_font_that_is_missing_too_large_or_no_font_is_an_error_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ttf");
        let error = || read(std::slice::from_ref(&path)).unwrap_err().to_string();
        let check = |words: &str| {
            let error = error();
            assert!(error.contains("a.ttf") && error.contains(words), "{error}");
        };
        check("cannot read");
        std::fs::write(&path, "no font").unwrap();
        check("no TrueType or OpenType font");
        std::fs::File::create(&path).unwrap().set_len(Font::MOST_BYTES + 1).unwrap();
        check("cannot read");
        assert_eq!(read(&[]).unwrap(), None);
    }
}
