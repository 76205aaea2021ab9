//! The captions of all figures in one file, in the formats of documents.

use zwidth_tables::{Format, escape_latex, escape_markdown, typst_expression};

/// The formats that captions are written in.
pub const CAPTION_FORMATS: [Format; 3] = [Format::Latex, Format::Typst, Format::Markdown];

/// A figure's name and its caption, a paragraph a string: the first is its title.
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
        let told = paragraphs.filter(|p| !p.is_empty() && !p.starts_with("zwidth:"));
        Self { name: name.to_owned(), paragraphs: told.map(str::to_owned).collect() }
    }

    fn title(&self) -> &str {
        self.paragraphs.first().map_or("", String::as_str)
    }

    fn whole(&self) -> String {
        self.paragraphs.join(" ")
    }
}

/// Stands at the beginning of the file for LaTeX: how it is used, and the two commands.
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
    let one = |caption: &NamedCaption| {
        let define = |what: &str, text: &str| {
            format!("\\@namedef{{zwidth@{what}@{}}}{{{}}}\n", caption.name, escape_latex(text))
        };
        define("title", caption.title()) + &define("caption", &caption.whole())
    };
    let all: String = captions.iter().map(one).collect();
    format!("{LATEX_HEAD}{all}\\makeatother\n")
}

fn typst(captions: &[NamedCaption]) -> String {
    let dictionary = |name: &str, text: fn(&NamedCaption) -> String| {
        let entry = |caption: &NamedCaption| {
            // a name holds letters, digits, points and hyphens alone
            format!("  \"{}\": {},\n", caption.name, typst_expression(&text(caption)))
        };
        let entries: String = captions.iter().map(entry).collect();
        let entries = if entries.is_empty() { ":".to_owned() } else { format!("\n{entries}") };
        format!("#let {name} = ({entries})\n")
    };
    format!(
        "// The captions of all figures by their names: #import \"captions.typ\": captions, titles\n\
         // #figure(image(\"NAME.svg\"), caption: captions.at(\"NAME\"))\n{}{}",
        dictionary("titles", |caption| caption.title().to_owned()),
        dictionary("captions", NamedCaption::whole),
    )
}

fn markdown(captions: &[NamedCaption]) -> String {
    let one = |caption: &NamedCaption| {
        let heading = [format!("## {}", escape_markdown(&caption.name))];
        let paragraphs = caption.paragraphs.iter().map(|p| escape_markdown(p));
        heading.into_iter().chain(paragraphs).collect::<Vec<_>>().join("\n\n")
    };
    captions.iter().map(one).collect::<Vec<_>>().join("\n\n") + "\n"
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
