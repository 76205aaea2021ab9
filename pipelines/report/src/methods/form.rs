//! The methods as Markdown, LaTeX and Typst.

use super::MethodsPart;
use zwidth_tables::{escape_latex, escape_markdown, typst_expression};

/// A form of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MethodsForm {
    /// Markdown.
    #[default]
    Markdown,
    /// LaTeX, to be put into a document.
    Latex,
    /// Typst, to be included.
    Typst,
}

impl MethodsForm {
    /// Every form, with the word for it.
    pub const ALL: [(&'static str, Self); 3] =
        [("md", Self::Markdown), ("tex", Self::Latex), ("typ", Self::Typst)];

    /// The text in this form.
    pub fn written(self, parts: &[MethodsPart]) -> String {
        let mut blocks = Vec::new();
        for part in parts {
            blocks.push(self.heading(part.heading));
            blocks.extend(part.paragraphs.iter().map(|text| self.paragraph(text)));
        }
        blocks.join("\n\n") + "\n"
    }

    fn heading(self, text: &str) -> String {
        match self {
            Self::Markdown => format!("## {}", escape_markdown(text)),
            Self::Latex => format!("\\subsection{{{}}}", escape_latex(text)),
            // Headings are this program's own, without a sign that Typst would read.
            Self::Typst => format!("== {text}"),
        }
    }

    fn paragraph(self, text: &str) -> String {
        match self {
            Self::Markdown => escape_markdown(text),
            Self::Latex => escape_latex(text),
            Self::Typst => format!("#({})", typst_expression(text)),
        }
    }
}
