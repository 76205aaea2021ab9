//! The captions of all figures in one file, in the formats of documents.

use zwidth_tables::{Format, escape_latex, escape_markdown, typst_expression};

/// The formats that captions are written in.
pub const CAPTION_FORMATS: [Format; 3] = [Format::Latex, Format::Typst, Format::Markdown];

/// A figure's name and its caption, one string per paragraph: the first is its title.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedCaption {
    /// The stem of its files' names.
    pub name: String,
    /// Its text by [`crate::caption_text`].
    pub paragraphs: Vec<String>,
}

impl NamedCaption {
    /// From the text of a caption's file; the line that says what it was made from is left out.
    pub fn of(name: &str, text: &str) -> Self {
        let paragraphs = text.split("\n\n").map(str::trim);
        let own = paragraphs.filter(|p| !p.is_empty() && !p.starts_with("zwidth:"));
        Self { name: name.to_owned(), paragraphs: own.map(str::to_owned).collect() }
    }

    fn title(&self) -> &str {
        self.paragraphs.first().map_or("", String::as_str)
    }

    fn whole(&self) -> String {
        self.paragraphs.join(" ")
    }
}

/// Stands at the beginning of the file for LaTeX: how it is used, and the two commands.
// Robust commands, because LaTeX writes a caption to the list of figures as well.
const LATEX_HEAD: &str = r"% The captions of all figures by their names. \input this file in the preamble; then, in a figure,
% \caption[\zwidthtitle{NAME}]{\zwidthcaption{NAME}}
\makeatletter
\newcommand\zwidth@text[2]{\@ifundefined{zwidth@#1@#2}%
  {\PackageError{zwidth}{There is no figure '#2'}{captions.tex lists the names.}}{\@nameuse{zwidth@#1@#2}}}
\DeclareRobustCommand\zwidthtitle[1]{\zwidth@text{title}{#1}}
\DeclareRobustCommand\zwidthcaption[1]{\zwidth@text{caption}{#1}}
";

/// The captions in a format: commands for LaTeX, two dictionaries for Typst, sections for Markdown;
/// every text is set unchanged. None for a format that is not one of documents.
pub fn captions_text(format: Format, captions: &[NamedCaption]) -> String {
    match format {
        Format::Latex => latex(captions),
        Format::Typst => typst(captions),
        Format::Markdown => markdown(captions),
        Format::Csv | Format::Html | Format::Parquet => String::new(),
    }
}

fn latex(captions: &[NamedCaption]) -> String {
    let mut file = LATEX_HEAD.to_owned();
    for caption in captions {
        let texts = [("title", caption.title().to_owned()), ("caption", caption.whole())];
        for (what, text) in texts {
            let text = escape_latex(&text);
            file += &format!("\\@namedef{{zwidth@{what}@{}}}{{{text}}}\n", caption.name);
        }
    }
    file + "\\makeatother\n"
}

fn typst(captions: &[NamedCaption]) -> String {
    let mut file =
        "// The captions of all figures by their names: #import \"captions.typ\": captions, titles\n\
         // #figure(image(\"NAME.svg\"), caption: captions.at(\"NAME\"))\n"
            .to_owned();
    for (dictionary, are_whole) in [("titles", false), ("captions", true)] {
        let mut entries = String::new();
        for caption in captions {
            let text = if are_whole { caption.whole() } else { caption.title().to_owned() };
            // A name holds letters, digits, points and hyphens alone.
            entries += &format!("  \"{}\": {},\n", caption.name, typst_expression(&text));
        }
        // `()` would be an empty array.
        let entries = if entries.is_empty() { ":".to_owned() } else { format!("\n{entries}") };
        file += &format!("#let {dictionary} = ({entries})\n");
    }
    file
}

fn markdown(captions: &[NamedCaption]) -> String {
    let mut paragraphs = Vec::new();
    for caption in captions {
        paragraphs.push(format!("## {}", escape_markdown(&caption.name)));
        paragraphs.extend(caption.paragraphs.iter().map(|p| escape_markdown(p)));
    }
    paragraphs.join("\n\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> [NamedCaption; 1] {
        let text =
            "Spring & wall.\n\nF_ex \\input{x} #eval(\"y\") <script>.\n\nzwidth:figures:9:0f\n";
        [NamedCaption::of("modes.P01.spring_wall", text)]
    }

    #[test]
    fn a_caption_in_latex_is_a_command_and_its_words_are_no_commands() {
        let text = captions_text(Format::Latex, &sample());
        let title = r"\@namedef{zwidth@title@modes.P01.spring_wall}{Spring \& wall.}";
        assert!(text.contains(title), "{text}");
        assert!(text.contains(r"F\textsubscript{ex} \textbackslash{}input\{x\} \#eval("), "{text}");
        assert!(!text.contains("zwidth:figures"), "what it was made from is not for readers");
    }

    #[test]
    fn a_caption_in_typst_is_an_entry_of_a_dictionary_and_its_words_are_strings() {
        let text = captions_text(Format::Typst, &sample());
        assert!(text.contains("  \"modes.P01.spring_wall\": \"Spring & wall.\",\n"), "{text}");
        let words = r#""Spring & wall. F" + sub("ex") + " \\input{x} #eval(\"y\") <script>.""#;
        assert!(text.contains(words), "{text}");
        assert!(captions_text(Format::Typst, &[]).contains("#let titles = (:)"));
    }

    #[test]
    fn a_caption_in_markdown_is_a_section() {
        let text = captions_text(Format::Markdown, &sample());
        assert!(text.starts_with("## modes.P01.spring\\_wall\n\nSpring \\& wall.\n\n"), "{text}");
        assert!(text.contains("\\<script\\>"), "{text}");
    }
}
