//! A figure's caption, ready to be set beside it: the words of its own metadata.

use zwidth_draw::{Figure, markup};

/// What the figure shows, in plain text (`F_ex` for subscripts): title, what it shows, the notes
/// under it, and the mark of simulated data; one paragraph each. A figure drawn bare leaves title
/// and notes to it.
pub fn caption_text(figure: &Figure) -> String {
    let title = figure.title.as_deref().map(markup::typed);
    let notes = figure.footnotes.iter().map(|note| markup::typed(note));
    let mark = figure.mark.as_deref().map(markup::typed);
    let parts = title.into_iter().chain([figure.description.clone()]).chain(notes).chain(mark);
    parts
        .map(|part| sentence(&part))
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join("\n\n")
        + "\n"
}

/// A paragraph on one line that ends as a sentence does. Control characters become spaces.
fn sentence(text: &str) -> String {
    let words: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let words = words.trim();
    match words.ends_with(['.', '!', '?', '”', '"']) || words.is_empty() {
        true => words.to_owned(),
        false => format!("{words}."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_is_title_description_notes_and_mark_without_markup() {
        let figure = Figure {
            title: Some("*F*_{ex} of a\\*b".to_owned()),
            description: "One force.".to_owned(),
            footnotes: vec!["Dotted: at the wall\u{7}or past it".to_owned(), String::new()],
            mark: Some("SYNTHETIC: simulated, not measured".to_owned()),
            ..Figure::default()
        };
        assert_eq!(
            caption_text(&figure),
            "F_ex of a*b.\n\nOne force.\n\nDotted: at the wall or past it.\n\n\
             SYNTHETIC: simulated, not measured.\n"
        );
    }
}
