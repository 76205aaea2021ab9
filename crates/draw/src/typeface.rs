//! Faces: those of the bundled font, and those of the user's own font, which is read from files.

use std::fmt::{Debug, Formatter};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use krilla::Document;
use krilla::geom::Point;
use krilla::text::KrillaGlyph;
use rustybuzz::Face;
use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder, name_id};

use crate::error::Error;

/// Which face of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Style {
    Regular,
    Italic,
    Bold,
}

impl Style {
    pub(crate) const ALL: [Style; 3] = [Style::Regular, Style::Italic, Style::Bold];

    /// The bundled face's file.
    pub(crate) fn bundled(self) -> &'static [u8] {
        match self {
            Style::Regular => notosans::REGULAR_TTF,
            Style::Italic => notosans::ITALIC_TTF,
            Style::Bold => notosans::BOLD_TTF,
        }
    }

    fn as_str(self) -> &'static str {
        match self {
            Style::Regular => "upright",
            Style::Italic => "italic",
            Style::Bold => "bold",
        }
    }
}

/// A face of the bundled font, or of a font of one's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Typeface {
    pub(crate) is_own: bool,
    pub(crate) style: Style,
}

/// A font file's content, with what errors call the file.
#[derive(Clone, PartialEq, Eq)]
pub struct FontFile {
    /// Its path or name.
    pub name: String,
    /// Its content.
    pub bytes: Arc<Vec<u8>>,
}

impl Debug for FontFile {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} bytes)", self.name, self.bytes.len())
    }
}

/// A font of one's own, in which a figure is set in place of Noto Sans. What italic and bold faces
/// it lacks are replaced by its upright one, and single letters that it lacks by those of Noto
/// Sans.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Font {
    faces: [Option<FontFile>; 3],
    family: Option<String>,
}

impl Font {
    /// How many files a font may have: upright, italic and bold.
    pub const MOST_FILES: usize = 3;
    /// Bytes that each may have (32 MiB): the largest fonts of one face, with all Chinese letters,
    /// have 20.
    pub const MOST_BYTES: u64 = 1 << 25;

    /// A font of TrueType or OpenType files in any order: each says itself whether it is upright,
    /// italic or bold. If none is upright, the first takes this place.
    ///
    /// # Errors
    /// [`Error::FontFile`] for a file that is no font, that is damaged, whose letters have no
    /// outlines, that cannot be embedded, and for two files of one style.
    pub fn new(files: &[FontFile]) -> Result<Self, Error> {
        let mut faces: [Option<FontFile>; 3] = [None, None, None];
        let mut family = None;
        for file in files {
            let checked = guarded(|| check(file)).unwrap_or_else(|| Err(DAMAGED.to_owned()));
            let (style, own_family) = checked.map_err(|reason| fault(&file.name, reason))?;
            if let Some(other) = &faces[style as usize] {
                let reason = format!(
                    "it is {} as {} is; name one file for each of upright, italic and bold",
                    style.as_str(),
                    other.name
                );
                return Err(fault(&file.name, reason));
            }
            faces[style as usize] = Some(file.clone());
            // The first file that names a family names it for all.
            family = family.or(own_family);
        }
        if faces[Style::Regular as usize].is_none() {
            faces[Style::Regular as usize] = files.first().cloned();
        }
        Ok(Self { faces, family })
    }

    /// The family's name, by which programs know the font where it is installed.
    pub(crate) fn family(&self) -> Option<&str> {
        self.family.as_deref()
    }

    /// The file of a style, or of the upright one where it has none.
    pub(crate) fn file(&self, style: Style) -> Option<&FontFile> {
        self.faces[style as usize].as_ref().or(self.faces[Style::Regular as usize].as_ref())
    }

    /// The names of its files.
    pub fn name(&self) -> String {
        let names: Vec<&str> = self.faces.iter().flatten().map(|file| file.name.as_str()).collect();
        names.join(", ")
    }
}

pub(crate) const DAMAGED: &str = "it is damaged";

pub(crate) fn fault(file: &str, reason: impl Into<String>) -> Error {
    Error::FontFile { file: file.to_owned(), reason: reason.into() }
}

/// What a reader of fonts gives, or `None` where it panics.
pub(crate) fn guarded<T>(read: impl FnOnce() -> T) -> Option<T> {
    // Of what `read` touches only the caches of shaped words live on, and their entries are whole.
    catch_unwind(AssertUnwindSafe(read)).ok()
}

/// Style and family of a file that can be drawn with: its plain letters are outlined and embedded
/// once, so that a damaged file is refused before anything is made.
fn check(file: &FontFile) -> Result<(Style, Option<String>), String> {
    let face = Face::from_slice(&file.bytes, 0)
        .ok_or("it is damaged, or no TrueType or OpenType font (.ttf, .otf)")?;
    let glyphs: Vec<(char, GlyphId)> =
        ('!'..='~').filter_map(|letter| Some((letter, face.glyph_index(letter)?))).collect();
    let mut outlines = glyphs.iter().map(|(_, id)| face.outline_glyph(*id, &mut NoPen));
    if !glyphs.is_empty() && !outlines.any(|outline| outline.is_some()) {
        return Err("its letters are pictures without outlines".to_owned());
    }
    embed(file, &glyphs)?;
    let style = match (face.is_bold(), face.is_italic() || face.is_oblique()) {
        (true, _) => Style::Bold,
        (false, true) => Style::Italic,
        (false, false) => Style::Regular,
    };
    // Some fonts name their weights families of their own, and the family of all of them beside.
    let family = [name_id::TYPOGRAPHIC_FAMILY, name_id::FAMILY]
        .into_iter()
        .find_map(|id| face.names().into_iter().find(|n| n.name_id == id && n.is_unicode()));
    Ok((style, family.and_then(|name| name.to_string())))
}

/// Embeds these letters, of one byte each, in a PDF that nobody reads.
fn embed(file: &FontFile, glyphs: &[(char, GlyphId)]) -> Result<(), String> {
    let font = krilla::text::Font::new(file.bytes.clone().into(), 0)
        .ok_or("its letters cannot be embedded in a PDF")?;
    let letters: String = glyphs.iter().map(|(letter, _)| letter).collect();
    let mut placed = Vec::new();
    for (at, (_, id)) in glyphs.iter().enumerate() {
        let id = krilla::text::GlyphId::new(u32::from(id.0));
        placed.push(KrillaGlyph::new(id, 1.0, 0.0, 0.0, 0.0, at..at + 1, None));
    }
    let mut document = Document::new();
    let mut page = document.start_page();
    let mut surface = page.surface();
    surface.draw_glyphs(Point::from_xy(0.0, 0.0), &placed, font, &letters, 10.0, false);
    surface.finish();
    page.finish();
    let embedded = document.finish();
    embedded.map(drop).map_err(|error| format!("it cannot be embedded in a PDF ({error:?})"))
}

/// Follows an outline and draws nothing.
struct NoPen;

impl OutlineBuilder for NoPen {
    fn move_to(&mut self, _: f32, _: f32) {}
    fn line_to(&mut self, _: f32, _: f32) {}
    fn quad_to(&mut self, _: f32, _: f32, _: f32, _: f32) {}
    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, _: f32, _: f32) {}
    fn close(&mut self) {}
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A bundled face as a file of one's own.
    pub(crate) fn file(style: Style) -> FontFile {
        let name = format!("{}.ttf", style.as_str());
        FontFile { name, bytes: Arc::new(style.bundled().to_vec()) }
    }

    /// The same file with these letters alone: its table of letters is another, at its end.
    pub(crate) fn file_with_letters(style: Style, letters: &str) -> FontFile {
        let mut bytes = style.bundled().to_vec();
        let face = Face::from_slice(style.bundled(), 0).unwrap();
        // Format 12 of the table `cmap`, one group per letter, for Unicode.
        let count = letters.chars().count() as u32;
        let mut table = [1, 3 << 16 | 10, 12, 12 << 16, 16 + 12 * count, 0, count]
            .map(u32::to_be_bytes)
            .concat();
        for letter in letters.chars() {
            let (code, glyph) = (u32::from(letter), face.glyph_index(letter).unwrap());
            table.extend([code, code, u32::from(glyph.0)].map(u32::to_be_bytes).concat());
        }
        let entry = bytes.windows(4).position(|tag| tag == b"cmap").unwrap();
        let (start, length) = (bytes.len() as u32, table.len() as u32);
        bytes[entry + 8..entry + 12].copy_from_slice(&start.to_be_bytes());
        bytes[entry + 12..entry + 16].copy_from_slice(&length.to_be_bytes());
        bytes.extend(table);
        FontFile { name: "few-letters.ttf".to_owned(), bytes: Arc::new(bytes) }
    }

    #[test]
    fn a_file_says_itself_which_face_it_is_and_what_is_lacking_is_upright() {
        let [regular, italic, bold] = Style::ALL.map(file);
        let font = Font::new(&[bold.clone(), italic.clone(), regular.clone()]).unwrap();
        let names = |font: &Font| Style::ALL.map(|style| font.file(style).unwrap().name.clone());
        assert_eq!(names(&font), ["upright.ttf", "italic.ttf", "bold.ttf"]);
        assert_eq!(font.family(), Some("Noto Sans"));
        let alone = Font::new(&[bold, italic]).unwrap();
        assert_eq!(names(&alone), ["bold.ttf", "italic.ttf", "bold.ttf"]);
        assert_eq!(names(&Font::new(&[regular]).unwrap())[1], "upright.ttf");
    }

    #[test]
    fn a_file_that_is_no_font_or_stands_beside_one_of_its_kind_is_an_error_with_its_name() {
        let error = |files: &[FontFile]| Font::new(files).unwrap_err().to_string();
        let letter =
            FontFile { name: "letter.ttf".into(), bytes: Arc::new(b"Dear reader".to_vec()) };
        assert!(
            error(&[letter])
                .starts_with("letter.ttf cannot be the font of a figure: it is damaged, or no")
        );
        let twice =
            error(&[file(Style::Bold), FontFile { name: "b.ttf".into(), ..file(Style::Bold) }]);
        assert!(
            twice.starts_with("b.ttf") && twice.contains("it is bold as bold.ttf is"),
            "{twice}"
        );
        let bytes = Arc::new(Style::Regular.bundled()[..100_000].to_vec());
        let cut_off = error(&[FontFile { name: "cut.ttf".into(), bytes }]);
        assert!(cut_off.starts_with("cut.ttf cannot be the font of a figure"), "{cut_off}");
    }

    #[test]
    fn a_file_whose_letters_have_no_outlines_is_refused() {
        let mut bytes = Style::Regular.bundled().to_vec();
        let entry = bytes.windows(4).position(|tag| tag == b"glyf").unwrap();
        bytes[entry..entry + 4].copy_from_slice(b"none");
        let dots = FontFile { name: "dots.ttf".into(), bytes: Arc::new(bytes) };
        let error = Font::new(&[dots]).unwrap_err().to_string();
        assert!(error.contains("without outlines"), "{error}");
    }
}
