//! What a note below a table is about.

use crate::value::words;

words! {
    /// What a note below a table is about.
    NoteKind {
        /// The table and its numbers.
        General = "general",
        /// How far the numbers reach: no limit of the study, and no fault.
        Extent = "extent",
        /// What the repeats behind its means were aligned by.
        Alignment = "alignment",
        /// Something that is not in the table.
        LeftOut = "left_out",
        /// Something in the table that is to be read with care.
        Care = "care",
        /// What the study's design cannot show.
        Limit = "limit",
        /// The difference that is just noticed, and whose finding that is.
        Jnd = "jnd",
    }
}

#[expect(clippy::derivable_impls, reason = "the macro derives for all alike")]
impl Default for NoteKind {
    fn default() -> Self {
        Self::General
    }
}
