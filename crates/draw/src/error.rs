//! What can be wrong with a figure's description.

/// Why a figure could not be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The figure holds no panel.
    #[error("the figure has no panels; give it at least one")]
    NoPanels,
    /// A panel, named by its row and column in the grid, cannot be drawn: it has nothing to draw, arrays
    /// that belong together differ in length, a value is infinite, a thing has no place, an axis cannot
    /// run between its ends, its cells are not free, or there is no room.
    #[error("{0}")]
    Panel(String),
    /// A length, a weight or a resolution is not a positive number within reason.
    #[error("{what} is {value}; it must be more than 0 and at most {most}")]
    Size {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The most that is sensible.
        most: f64,
    },
    /// A text does not fit where it belongs, even when wrapped and set smaller.
    #[error(
        "\"{text}\" needs {need_pt:.0} pt and has {have_pt:.0}; shorten it or make the figure larger"
    )]
    TextTooLong {
        /// The markup.
        text: String,
        /// Its length.
        need_pt: f64,
        /// The room there is.
        have_pt: f64,
    },
    /// A text uses a letter that neither the bundled font nor one's own has.
    #[error("\"{text}\" holds U+{:04X}, which the bundled font (Latin, Greek, Cyrillic, common symbols) lacks; write it otherwise", u32::from(*.letter))]
    Letter {
        /// The markup.
        text: String,
        /// The letter.
        letter: char,
    },
    /// A font file cannot be drawn with.
    #[error("{file} cannot be the font of a figure: {reason}")]
    FontFile {
        /// The file, or the files of the font.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The bundled font cannot be read.
    #[error("the bundled font cannot be read; this is a fault of the build, not of the figure")]
    Font,
    /// The finished drawing could not be turned into a file's bytes.
    #[error("the drawing could not be written as {format}: {reason}")]
    Encode {
        /// SVG, PNG or PDF.
        format: &'static str,
        /// What the library said.
        reason: String,
    },
}
