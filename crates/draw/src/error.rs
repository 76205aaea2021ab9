//! What can be wrong with a figure's description.

/// Why a figure could not be drawn. `panel` is the panel's row and column in the grid, counted from
/// 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The figure holds no panel.
    #[error("the figure has no panels; give it at least one")]
    NoPanels,
    /// A panel has neither data nor a note.
    #[error(
        "panel {panel} has nothing to draw; give it data, or a note that says why there are none"
    )]
    NoData {
        /// Row and column.
        panel: String,
    },
    /// Two arrays that belong together differ in length.
    #[error(
        "panel {panel}: {first} has {first_len} values but {second} has {second_len}; they go in pairs"
    )]
    Lengths {
        /// Row and column.
        panel: String,
        /// Name of one array.
        first: &'static str,
        /// Its length.
        first_len: usize,
        /// Name of the other.
        second: &'static str,
        /// Its length.
        second_len: usize,
    },
    /// A value is infinite.
    #[error(
        "panel {panel}: {what}[{index}] is {value}; a missing value is NaN, anything else must be finite"
    )]
    Infinite {
        /// Row and column.
        panel: String,
        /// Name of the array.
        what: &'static str,
        /// Where in it.
        index: usize,
        /// The value.
        value: f64,
    },
    /// A reference line or a text has no place.
    #[error(
        "panel {panel}: {what} stands at {value}; it needs a finite place, or is to be left out"
    )]
    Place {
        /// Row and column.
        panel: String,
        /// What it is.
        what: &'static str,
        /// Where it was to stand.
        value: f64,
    },
    /// An axis cannot run between these ends.
    #[error(
        "panel {panel}: an axis cannot run from {low} to {high}; the first must be clearly smaller and both below 1e300"
    )]
    Range {
        /// Row and column.
        panel: String,
        /// Asked-for lower end.
        low: f64,
        /// Asked-for upper end.
        high: f64,
    },
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
    /// Two panels cover the same cell, or one covers none.
    #[error("panel {panel} covers no cell of the grid, or one that another panel covers too")]
    Grid {
        /// Row and column.
        panel: String,
    },
    /// The page leaves no room for the data.
    #[error(
        "panel {panel} has {have_pt:.0} pt of room for its data and needs {need_pt:.0}; make the figure larger or its labels shorter"
    )]
    NoRoom {
        /// Row and column.
        panel: String,
        /// What is left.
        have_pt: f64,
        /// What is needed.
        need_pt: f64,
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
