//! Letters to placed glyphs, glyphs to outlines.
//!
//! The font is Noto Sans (SIL Open Font Licence) in three faces, which is bundled, or one of the
//! user's own. Letters are shaped as a text engine would (kerning, and marks such as the dot of θ̇
//! set over their letter), so widths measured here are those on paper.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{LazyLock, Mutex, PoisonError};

use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder};
use rustybuzz::{BufferClusterLevel, Face, UnicodeBuffer};

use crate::error::Error;
use crate::markup::{self, Run, Script};
use crate::style::SMALL_PT;
use crate::typeface::{DAMAGED, Font, Style, Typeface, fault, guarded};

/// Size of lowered and raised letters, relative to the others.
const SCRIPT_SIZE: f64 = 0.7;
/// How far lowered letters go down, in em.
const SUB_EM: f64 = 0.18;
/// How far raised letters go up, in em.
const SUPER_EM: f64 = 0.36;

/// How high and deep the letters of a font are, in em.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Metrics {
    /// Height of capitals and figures over the base line.
    cap: f64,
    /// Height kept free over the base line: a dotted letter fits.
    ascent: f64,
    /// Depth kept free under the base line: descenders and subscripts fit.
    descent: f64,
}

impl Default for Metrics {
    /// Those of the bundled font.
    fn default() -> Self {
        Self { cap: 0.714, ascent: 0.97, descent: 0.28 }
    }
}

impl Metrics {
    /// Those of a font's upright face. The bundled font stands in for letters that it lacks, so
    /// lines are never closer than its own.
    fn new(face: &Face<'_>) -> Self {
        /// Letters are no higher or deeper than this, in em; a damaged file may claim more.
        const MOST: f64 = 2.0;
        let em = f64::from(face.units_per_em());
        let bounds = |letter| face.glyph_bounding_box(face.glyph_index(letter)?);
        let heights = "ÅÉlf".chars().filter_map(bounds).map(|b| f64::from(b.y_max) / em);
        let depths = "gjpqy,".chars().filter_map(bounds).map(|b| f64::from(-b.y_min) / em);
        let usual = Self::default();
        Self {
            cap: bounds('H').map_or(usual.cap, |b| (f64::from(b.y_max) / em).clamp(0.0, MOST)),
            ascent: heights.fold(usual.ascent, f64::max).min(MOST),
            descent: depths.fold(usual.descent, f64::max).min(MOST),
        }
    }
}

/// A glyph with its place in the line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Glyph {
    pub(crate) id: u16,
    /// Place relative to its piece's start, in font units.
    pub(crate) x: i32,
    pub(crate) y: i32,
    /// The letters it stands for, in bytes of its piece's text.
    pub(crate) letters: Range<usize>,
}

/// Letters of one face, placed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Piece {
    pub(crate) face: Typeface,
    pub(crate) text: String,
    /// Start relative to the line's start, y downwards.
    pub(crate) x_pt: f64,
    pub(crate) y_pt: f64,
    pub(crate) size_pt: f64,
    /// Size of its line, of which lowered and raised letters are a share.
    pub(crate) line_pt: f64,
    pub(crate) glyphs: Vec<Glyph>,
    /// From its start to what stands behind it, in font units.
    pub(crate) advance: i32,
}

/// A line of text, measured and ready to be drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Label {
    pub(crate) size_pt: f64,
    pub(crate) width_pt: f64,
    pub(crate) pieces: Vec<Piece>,
    metrics: Metrics,
}

impl Label {
    /// Height of capitals and figures over the base line.
    pub(crate) fn cap_pt(&self) -> f64 {
        self.metrics.cap * self.size_pt
    }

    /// Height kept free over the base line.
    pub(crate) fn ascent_pt(&self) -> f64 {
        self.metrics.ascent * self.size_pt
    }

    /// Depth kept free under the base line.
    pub(crate) fn descent_pt(&self) -> f64 {
        self.metrics.descent * self.size_pt
    }

    /// Height of a line of this size, without room between lines.
    pub(crate) fn height_pt(&self) -> f64 {
        (self.metrics.ascent + self.metrics.descent) * self.size_pt
    }

    /// The letters, without markup.
    #[cfg(test)]
    pub(crate) fn text(&self) -> String {
        self.pieces.iter().map(|piece| piece.text.as_str()).collect()
    }
}

/// Glyphs of a text and its whole advance, in font units.
type Shaped = (Vec<Glyph>, i32);

/// Texts that were shaped already: a page is laid out in rounds, and figures share words.
type Cache = Mutex<BTreeMap<(Style, String), Shaped>>;

/// The faces of a font, parsed.
struct Faces<'a> {
    faces: [Face<'a>; 3],
    shaped: Cache,
}

impl<'a> Faces<'a> {
    /// All or none.
    fn parsed(faces: [Option<Face<'a>>; 3]) -> Option<Self> {
        let [regular, italic, bold] = faces;
        Some(Self { faces: [regular?, italic?, bold?], shaped: Cache::default() })
    }
}

/// The faces in which a figure is set.
pub(crate) struct Fonts<'a> {
    /// A font of one's own, in whose place the bundled one stands where it lacks a letter.
    own: Option<Faces<'a>>,
    /// Parsed once per process.
    bundled: &'static Faces<'static>,
    metrics: Metrics,
}

impl<'a> Fonts<'a> {
    /// A font of one's own over the bundled one, or the bundled one alone.
    pub(crate) fn new(font: Option<&'a Font>) -> Result<Self, Error> {
        static BUNDLED: LazyLock<Option<Faces<'static>>> = LazyLock::new(|| {
            Faces::parsed(Style::ALL.map(|style| Face::from_slice(style.bundled(), 0)))
        });
        let bundled = BUNDLED.as_ref().ok_or(Error::Font)?;
        // A missing face has the upright one's file, and `Font::new` has tried each.
        let own = Style::ALL.map(|style| Face::from_slice(&font?.file(style)?.bytes, 0));
        let own = Faces::parsed(own);
        let metrics = own.as_ref().map_or(Metrics::default(), |own| Metrics::new(&own.faces[0]));
        Ok(Self { own, bundled, metrics })
    }

    #[cfg(test)]
    pub(crate) fn bundled() -> Result<&'static Fonts<'static>, Error> {
        static FONTS: LazyLock<Result<Fonts<'static>, Error>> = LazyLock::new(|| Fonts::new(None));
        FONTS.as_ref().map_err(Clone::clone)
    }

    fn faces(&self, is_own: bool) -> &Faces<'a> {
        self.own.as_ref().filter(|_| is_own).unwrap_or(self.bundled)
    }

    fn face(&self, Typeface { is_own, style }: Typeface) -> &Face<'a> {
        &self.faces(is_own).faces[style as usize]
    }

    /// Font units per em.
    pub(crate) fn units_per_em(&self, face: Typeface) -> f64 {
        f64::from(self.face(face).units_per_em())
    }

    /// Height of a line of letters of this size, without room between lines.
    pub(crate) fn line_height_pt(&self, size_pt: f64) -> f64 {
        (self.metrics.ascent + self.metrics.descent) * size_pt
    }

    /// Sets one line of markup.
    pub(crate) fn label(&self, markup: &str, size_pt: f64) -> Result<Label, Error> {
        self.line(&markup::parse(markup), size_pt, markup)
    }

    /// Sets runs one after the other; `markup` is where they come from, for errors.
    fn line(&self, runs: &[Run], size_pt: f64, markup: &str) -> Result<Label, Error> {
        let mut label = Label { size_pt, metrics: self.metrics, ..Label::default() };
        for run in runs {
            let (scale, raise_em) = match run.script {
                Script::Base => (1.0, 0.0),
                Script::Sub => (SCRIPT_SIZE, -SUB_EM),
                Script::Super => (SCRIPT_SIZE, SUPER_EM),
            };
            let piece_pt = scale * size_pt;
            for (text, is_own) in self.stretches(run) {
                let face = Typeface { is_own, style: style(run) };
                let (glyphs, advance) = self.shaped(text, face, markup)?;
                label.pieces.push(Piece {
                    face,
                    text: text.to_owned(),
                    x_pt: label.width_pt,
                    y_pt: -raise_em * size_pt,
                    size_pt: piece_pt,
                    line_pt: size_pt,
                    glyphs,
                    advance,
                });
                label.width_pt += f64::from(advance) * piece_pt / self.units_per_em(face);
            }
        }
        Ok(label)
    }

    /// A run cut where its letters go over from a font of one's own to the bundled one, or back; a
    /// letter stays with the accents over it.
    fn stretches<'r>(&self, run: &'r Run) -> Vec<(&'r str, bool)> {
        let style = style(run);
        let Some(own) = self.own.as_ref().map(|own| &own.faces[style as usize]) else {
            return vec![(&run.text, false)];
        };
        // Ends of stretches, each with whose letters are before it.
        let mut ends: Vec<(usize, bool)> = Vec::new();
        let mut rest = run.text.char_indices().peekable();
        while let Some((start, letter)) = rest.next() {
            let mut end = start + letter.len_utf8();
            let mut is_own = own.glyph_index(letter).is_some();
            while let Some((at, mark)) = rest.next_if(|(_, next)| markup::is_mark(*next)) {
                end = at + mark.len_utf8();
                is_own &= own.glyph_index(mark).is_some();
            }
            match ends.last_mut() {
                Some(last) if last.1 == is_own => last.0 = end,
                _ => ends.push((end, is_own)),
            }
        }
        let starts = std::iter::once(0).chain(ends.iter().map(|(end, _)| *end));
        starts.zip(&ends).map(|(start, (end, is_own))| (&run.text[start..*end], *is_own)).collect()
    }

    fn shaped(&self, text: &str, face: Typeface, markup: &str) -> Result<Shaped, Error> {
        let cache = &self.faces(face.is_own).shaped;
        let key = (face.style, text.to_owned());
        if let Some(shaped) = cache.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return Ok(shaped.clone());
        }
        // The lock is free while letters are shaped: another thread may draw meanwhile.
        let shaped = shape(self.face(face), text, markup)?;
        cache.lock().unwrap_or_else(PoisonError::into_inner).insert(key, shaped.clone());
        Ok(shaped)
    }

    /// A glyph's outline in font units, y upwards; a space has none.
    pub(crate) fn trace(&self, face: Typeface, id: u16, pen: &mut dyn OutlineBuilder) {
        self.face(face).outline_glyph(GlyphId(id), pen);
    }

    /// Breaks markup at its spaces so that no line is wider than `width_pt`; a single long word may
    /// still be.
    pub(crate) fn wrap(
        &self,
        markup: &str,
        size_pt: f64,
        width_pt: f64,
    ) -> Result<Vec<Label>, Error> {
        let mut lines: Vec<(Vec<Run>, Label)> = Vec::new();
        for word in markup::words(markup) {
            self.add(&mut lines, word, markup::join, size_pt, width_pt, markup)?;
        }
        Ok(lines.into_iter().map(|(_, label)| label).collect())
    }

    /// Puts what comes next to the last of what is set, where both have room, or behind it.
    fn add(
        &self,
        set: &mut Vec<(Vec<Run>, Label)>,
        next: Vec<Run>,
        join: fn(&[Run], &[Run]) -> Vec<Run>,
        size_pt: f64,
        width_pt: f64,
        markup: &str,
    ) -> Result<(), Error> {
        if let Some((last, label)) = set.last_mut() {
            let longer = join(last, &next);
            let both = self.line(&longer, size_pt, markup)?;
            if both.width_pt <= width_pt {
                (*last, *label) = (longer, both);
                return Ok(());
            }
        }
        let label = self.line(&next, size_pt, markup)?;
        set.push((next, label));
        Ok(())
    }

    /// Sets markup in lines no wider than `width_pt`: at `size_pt`, or smaller down to [`SMALL_PT`]
    /// where a word is too long.
    pub(crate) fn block(
        &self,
        markup: &str,
        size_pt: f64,
        width_pt: f64,
    ) -> Result<Vec<Label>, Error> {
        let mut widest = 0.0;
        for size_pt in [size_pt, (size_pt + SMALL_PT) / 2.0, SMALL_PT] {
            let lines = self.wrap(markup, size_pt, width_pt)?;
            widest = widest_pt(&lines);
            if widest <= width_pt {
                return Ok(lines);
            }
        }
        Err(Error::TextTooLong { text: markup.to_owned(), need_pt: widest, have_pt: width_pt })
    }

    /// Sets markup as [`block`](Self::block) does; where a word is too long even in the smallest
    /// letters, it is parted between two of them. Somebody's text is never the reason why there is
    /// no figure.
    pub(crate) fn parted(
        &self,
        markup: &str,
        size_pt: f64,
        width_pt: f64,
    ) -> Result<Vec<Label>, Error> {
        match self.block(markup, size_pt, width_pt) {
            Err(Error::TextTooLong { .. }) => {}
            set => return set,
        }
        let mut lines: Vec<(Vec<Run>, Label)> = Vec::new();
        for word in markup::words(markup) {
            let mut parts: Vec<(Vec<Run>, Label)> = Vec::new();
            for letter in markup::letters(&word) {
                self.add(&mut parts, letter, markup::append, SMALL_PT, width_pt, markup)?;
            }
            // A word that was parted begins a line; what comes after may join its last part.
            match &parts[..] {
                [(whole, _)] => {
                    let whole = whole.clone();
                    self.add(&mut lines, whole, markup::join, SMALL_PT, width_pt, markup)?;
                }
                _ => lines.extend(parts),
            }
        }
        let lines: Vec<Label> = lines.into_iter().map(|(_, label)| label).collect();
        let widest = widest_pt(&lines);
        if widest > width_pt {
            let text = markup.to_owned();
            return Err(Error::TextTooLong { text, need_pt: widest, have_pt: width_pt });
        }
        Ok(lines)
    }
}

/// The style of a run.
fn style(run: &Run) -> Style {
    match run {
        Run { bold: true, .. } => Style::Bold,
        Run { italic: true, .. } => Style::Italic,
        _ => Style::Regular,
    }
}

fn shape(face: &Face<'_>, text: &str, markup: &str) -> Result<Shaped, Error> {
    if let Some(letter) = text.chars().find(|&c| face.glyph_index(c).is_none()) {
        return Err(Error::Letter { text: markup.to_owned(), letter });
    }
    let mut buffer = UnicodeBuffer::new();
    buffer.push_str(text);
    buffer.guess_segment_properties();
    // The usual level counts a mark to its letter, so that nothing would tell the two apart below.
    buffer.set_cluster_level(BufferClusterLevel::Characters);
    let shaped = rustybuzz::shape(face, &[], buffer);
    let mut pen: i32 = 0;
    let mut glyphs: Vec<Glyph> = Vec::new();
    let mut base = None;
    for (info, place) in shaped.glyph_infos().iter().zip(shaped.glyph_positions()) {
        let start = info.cluster as usize;
        // A damaged file may claim any advance.
        let x = pen.saturating_add(place.x_offset);
        let y = place.y_offset;
        // the shaper may have moved marks past each other: what follows in the text need not
        // come next
        let next = shaped
            .glyph_infos()
            .iter()
            .map(|i| i.cluster as usize)
            .filter(|next| *next > start)
            .min();
        let glyph =
            Glyph { id: info.glyph_id as u16, x, y, letters: start..next.unwrap_or(text.len()) };
        let letter = text.get(start..).and_then(|rest| rest.chars().next());
        match &base {
            Some(base) if letter.is_some_and(markup::is_mark) => {
                glyphs.push(over(face, base, glyph))
            }
            _ => {
                base = Some(glyph.clone());
                glyphs.push(glyph);
            }
        }
        pen = pen.saturating_add(place.x_advance);
    }
    Ok((glyphs, pen))
}

/// A mark moved to stand over its letter: the font knows where for Latin letters, not for Greek
/// ones.
fn over(face: &Face<'_>, base: &Glyph, mark: Glyph) -> Glyph {
    /// Between a letter and its mark, in em.
    const GAP_EM: f64 = 0.0342;
    /// A letter is upright at this height under its mark, in em: above it an italic one leans.
    const LEANS_EM: f64 = 0.195;
    /// No letter leans further; a damaged file may claim more.
    const MOST_LEAN_DEG: f64 = 45.0;
    let bounds = [base, &mark].map(|glyph| face.glyph_bounding_box(GlyphId(glyph.id)));
    let [Some(under), Some(dot)] = bounds else { return mark };
    let [under_x, dot_x] =
        [under, dot].map(|ink| (i32::from(ink.x_min) + i32::from(ink.x_max)) / 2);
    let em = f64::from(face.units_per_em());
    let angle_deg = f64::from(-face.italic_angle()).clamp(-MOST_LEAN_DEG, MOST_LEAN_DEG);
    let lean = (LEANS_EM * libm::tan(angle_deg.to_radians()) * em).round() as i32;
    let x = base.x + under_x + lean - dot_x;
    let y = base.y + i32::from(under.y_max) + (GAP_EM * em).round() as i32 - i32::from(dot.y_min);
    Glyph { x, y, ..mark }
}

/// Width of the widest line.
pub(crate) fn widest_pt(lines: &[Label]) -> f64 {
    lines.iter().map(|line| line.width_pt).fold(0.0, f64::max)
}

/// Height of lines set one under the other.
pub(crate) fn height_pt(lines: &[Label]) -> f64 {
    lines.iter().map(Label::height_pt).sum()
}

/// Draws with a font of one's own, or with the bundled one. The libraries that read fonts are not
/// ours: if one gives up on a damaged file, this is an error that names the font.
// Fonts are parsed anew for each file: faces borrow the font's bytes, so a `Drawing` cannot hold them.
pub(crate) fn with_fonts<T>(
    font: Option<&Font>,
    draw: impl FnOnce(&Fonts) -> Result<T, Error>,
) -> Result<T, Error> {
    let draw = || draw(&Fonts::new(font)?);
    let Some(font) = font else { return draw() };
    // A font that passed its check may still break at a letter that the check does not draw.
    match guarded(draw) {
        Some(Err(Error::Encode { format: "PDF", reason })) => {
            Err(fault(&font.name(), format!("it cannot be embedded in a PDF ({reason})")))
        }
        Some(result) => result,
        None => Err(fault(&font.name(), DAMAGED)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width(markup: &str) -> f64 {
        Fonts::bundled().unwrap().label(markup, 10.0).unwrap().width_pt
    }

    #[test]
    fn the_dot_of_theta_dot_takes_no_room_and_sits_over_its_letter() {
        assert_eq!(width("θ̇"), width("θ"));
        let fonts = Fonts::bundled().unwrap();
        let label = fonts.label("*θ̇*", 10.0).unwrap();
        let [theta, dot] = &label.pieces[0].glyphs[..] else { panic!("two glyphs") };
        let face = fonts.face(Typeface { is_own: false, style: Style::Italic });
        let bounds = |glyph: &Glyph| face.glyph_bounding_box(GlyphId(glyph.id)).unwrap();
        let (under, over) = (bounds(theta), bounds(dot));
        assert!(dot.y + i32::from(over.y_min) > i32::from(under.y_max), "clear of the letter");
        assert!(dot.x + i32::from(over.x_min) > i32::from(under.x_min), "not left of the letter");
        assert!(
            dot.x + i32::from(over.x_max) < i32::from(under.x_max) + 40,
            "not right of the letter"
        );
    }

    #[test]
    fn every_glyph_stands_for_letters_of_its_text_though_marks_change_places() {
        let fonts = Fonts::bundled().unwrap();
        for text in ["c\u{30c}\u{323}", "x\u{301}\u{323}", "θ\u{307}", "office"] {
            let label = fonts.label(text, 10.0).unwrap();
            for glyph in &label.pieces[0].glyphs {
                assert!(
                    text.get(glyph.letters.clone()).is_some_and(|letters| !letters.is_empty()),
                    "{glyph:?}"
                );
            }
        }
    }

    #[test]
    fn every_digit_is_equally_wide_so_ticks_line_up() {
        for digit in "123456789".chars() {
            assert_eq!(width(&digit.to_string()), width("0"));
        }
    }

    #[test]
    fn subscripts_are_smaller_than_the_letters_before_them() {
        assert!(width("_{ex}") < width("ex"));
        assert!((width("_{ex}") - SCRIPT_SIZE * width("ex")).abs() < 1e-9);
    }

    #[test]
    fn a_letter_the_font_lacks_is_named() {
        let error = Fonts::bundled().unwrap().label("mode 中", 8.0).unwrap_err();
        assert!(error.to_string().contains("U+4E2D"), "{error}");
    }

    #[test]
    fn wrapped_lines_fit_and_lose_no_word() {
        let fonts = Fonts::bundled().unwrap();
        let text = "within this participant, mean of six repeats with a 95 % band";
        let lines = fonts.wrap(text, 7.0, 80.0).unwrap();
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| line.width_pt <= 80.0));
        let texts: Vec<String> = lines.iter().map(Label::text).collect();
        assert_eq!(texts.join(" "), text);
    }

    #[test]
    fn a_text_that_cannot_fit_says_how_long_it_is() {
        let fonts = Fonts::bundled().unwrap();
        assert!(fonts.block("short", 8.0, 100.0).is_ok());
        assert!(matches!(fonts.block("interminable", 8.0, 20.0), Err(Error::TextTooLong { .. })));
        let text = |width_pt: f64| {
            let lines = fonts.parted("an *interminable* \\*θ̇* end", 8.0, width_pt).unwrap();
            assert!(widest_pt(&lines) <= width_pt);
            lines.iter().map(Label::text).collect::<Vec<_>>().join("/")
        };
        assert_eq!(text(20.0).replace('/', ""), "aninterminable*θ̇*end");
        assert!(text(20.0).starts_with("an/inter"), "{}", text(20.0));
        assert_eq!(text(200.0), "an interminable *θ̇* end");
        assert!(matches!(fonts.parted("in", 8.0, 1.0), Err(Error::TextTooLong { .. })));
    }
}
