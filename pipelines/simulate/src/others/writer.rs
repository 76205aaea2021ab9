//! How a format is written: plain values, one for each format.

/// How a format is written.
pub(super) struct Writer {
    /// Its files, the model first.
    pub(super) files: &'static [Form],
    /// A remark a line.
    pub(super) remarks: &'static str,
    /// Parts of a scene that the format has no way to say, with what to do.
    pub(super) refused: &'static [(&'static str, &'static str)],
}

/// A file of a format.
pub(super) struct Form {
    /// What its name ends with, behind the scene's.
    pub(super) ending: &'static str,
    /// How its head is written.
    pub(super) comment: Comment,
    /// Its templates in order, each behind the parts of a scene for which it is there.
    pub(super) templates: &'static [(&'static str, &'static str)],
}

/// How a language writes a comment of several lines.
#[derive(Clone, Copy)]
pub(super) enum Comment {
    /// `# …`
    Hash,
    /// `// …`
    Slashes,
    /// `<!-- … -->`
    Xml,
}
