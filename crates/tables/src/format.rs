//! The formats, by name.

use crate::html::html;
use crate::latex::latex;
use crate::markdown::markdown;
use crate::shown::Seen;
use crate::terminal::terminal;
use crate::typst::typst;
use crate::{Table, TableError, Wording, csv};
use std::collections::BTreeMap;
use std::path::Path;

/// A format a table can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// Comma-separated values, for programs: SI, every digit.
    Csv,
    /// GitHub Flavored Markdown.
    Markdown,
    /// LaTeX with booktabs and siunitx.
    Latex,
    /// Typst.
    Typst,
    /// An HTML `<table>`.
    Html,
    /// Parquet, for programs: SI, every bit, units and meanings in the schema.
    Parquet,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 6] =
        [Self::Csv, Self::Markdown, Self::Latex, Self::Typst, Self::Html, Self::Parquet];

    fn extension_and_about(self) -> [&'static str; 2] {
        match self {
            Self::Csv => ["csv", "CSV, full precision"],
            Self::Markdown => ["md", "Markdown"],
            Self::Latex => ["tex", "LaTeX (booktabs, siunitx)"],
            Self::Typst => ["typ", "Typst"],
            Self::Html => ["html", "HTML"],
            Self::Parquet => ["parquet", "Parquet, full precision"],
        }
    }

    /// The extension of its files, without a dot.
    pub fn extension(self) -> &'static str {
        self.extension_and_about()[0]
    }

    /// What it is, for a reader who chooses one.
    pub fn about(self) -> &'static str {
        self.extension_and_about()[1]
    }

    /// Whether its files are text.
    pub fn is_text(self) -> bool {
        self != Self::Parquet
    }

    /// Whether its files are for programs: SI, every digit, nothing laid out.
    pub fn is_for_programs(self) -> bool {
        matches!(self, Self::Csv | Self::Parquet)
    }

    /// The lines that, at the end of a file, hold its `origin` and are not shown; `None` where the
    /// format has no comments (CSV by RFC 4180; Parquet has its footer).
    pub fn comment(self, origin: &str) -> Option<String> {
        let text = format!("{origin} (`zwidth trace FILE` tells what it was made from)");
        match self {
            Self::Csv | Self::Parquet => None,
            Self::Markdown => Some(format!("\n<!-- {text} -->\n")),
            Self::Html => Some(format!("<!-- {text} -->\n")),
            Self::Latex => Some(format!("% {text}\n")),
            Self::Typst => Some(format!("// {text}\n")),
        }
    }
}

impl Table {
    /// The bytes of the table's files, one per format, with the path of each for errors: CSV and
    /// Parquet in SI units as the table is, the others [`Wording::tell`] of `narrow`, which is
    /// rounded and laid out once for all: the table itself, or a form of it that fits a page.
    ///
    /// `provenance` goes into the footer of a Parquet file, its entry `origin` as a comment below
    /// the others that can have one.
    ///
    /// # Errors
    /// Those of [`Wording::tell`] and [`Table::to_parquet`].
    pub fn to_bytes(
        &self,
        narrow: &Self,
        files: &[(Format, &Path)],
        wording: &Wording,
        provenance: &BTreeMap<String, String>,
    ) -> Result<Vec<Vec<u8>>, TableError> {
        // A long table as people would see it takes many times the memory of its numbers.
        if files.iter().all(|(format, _)| format.is_for_programs()) {
            return files
                .iter()
                .map(|(format, path)| self.in_format(*format, provenance, path))
                .collect();
        }
        Seen::of(&wording.tell(narrow)?, wording.digits, |seen| {
            let mut contents = Vec::new();
            for (format, path) in files {
                let text = match format {
                    Format::Csv | Format::Parquet => {
                        contents.push(self.in_format(*format, provenance, path)?);
                        continue;
                    }
                    Format::Markdown => markdown(seen),
                    Format::Latex => latex(seen),
                    Format::Typst => typst(seen),
                    Format::Html => html(seen),
                };
                let comment = provenance.get("origin").and_then(|origin| format.comment(origin));
                contents.push((text + &comment.unwrap_or_default()).into_bytes());
            }
            Ok(contents)
        })
    }

    /// The table for a terminal of this width in letters, by [`Wording::tell`]. If it is wider, it
    /// is printed in parts; columns with the words of `least` come last.
    ///
    /// # Errors
    /// Those of [`Wording::tell`].
    pub fn for_terminal(
        &self,
        wording: &Wording,
        width: usize,
        least: &[&str],
    ) -> Result<String, TableError> {
        Ok(Seen::of(&wording.tell(self)?, wording.digits, |seen| terminal(seen, width, least)))
    }

    /// The bytes of a file for programs.
    fn in_format(
        &self,
        format: Format,
        provenance: &BTreeMap<String, String>,
        path: &Path,
    ) -> Result<Vec<u8>, TableError> {
        match format {
            Format::Parquet => self.to_parquet(provenance, path),
            _ => Ok(csv(self).into_bytes()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Column;
    use zwidth_study::Coordinate;

    fn rotational() -> Wording {
        Wording::plain(Coordinate::Rotational)
    }

    #[test]
    fn the_origin_is_a_comment_in_every_format_that_has_comments_and_in_the_footer_of_parquet() {
        let column = Column::integer("n", "1", "number", [Some(1)]);
        let table = Table::new("t", "T", vec![column]).unwrap();
        let origin = BTreeMap::from([("origin".to_owned(), "zwidth:tables:2:0f".to_owned())]);
        for format in Format::ALL {
            let file = [(format, Path::new("t"))];
            let bytes =
                |from| table.to_bytes(&table, &file, &rotational(), from).unwrap().remove(0);
            let (with, without) = (bytes(&origin), bytes(&BTreeMap::new()));
            let carries = with.windows(18).any(|w| w == b"zwidth:tables:2:0f");
            let can = format == Format::Parquet || format.comment("origin").is_some();
            assert_eq!(carries, can, "{format:?}");
            if format != Format::Parquet {
                let comment = format.comment("zwidth:tables:2:0f").unwrap_or_default();
                assert_eq!(with, [without, comment.into_bytes()].concat(), "{format:?}");
            }
        }
    }

    #[test]
    fn programs_get_radians_and_people_degrees() {
        let column =
            Column::float("theta_rad", "rad", "angle", [Some(std::f64::consts::FRAC_PI_2)]);
        let table = Table::new("t", "T", vec![column]).unwrap();
        let text = |format| {
            let file = [(format, Path::new("t"))];
            let bytes = table.to_bytes(&table, &file, &rotational(), &BTreeMap::new()).unwrap();
            String::from_utf8_lossy(&bytes[0]).into_owned()
        };
        assert_eq!(text(Format::Csv), "theta_rad\r\n1.5707963267948966\r\n");
        for format in Format::ALL.into_iter().filter(|f| f.is_text() && *f != Format::Csv) {
            assert!(text(format).contains("90"), "{format:?}");
        }
        assert!(text(Format::Parquet).starts_with("PAR1"));
    }
}
