//! The page: the summary for a browser, with every trial to look at.
//!
//! All that is text stands in the page as it is, so that it reads and prints without its script;
//! the script (`script/`, ours, no library) adds the browser of trials and what can be clicked.
//! Nothing leaves the page: style and script stand in it, samples in scripts beside it
//! ([`condition_script`]) that are loaded when somebody asks for them.

mod contents;
mod course;
mod estimates;
mod given;
mod parts;
mod quality;
mod single;
mod turned;

pub use contents::Contents;
pub use course::{Columns, Course, Event, condition_script};
pub use given::Page;
pub use single::single_file;
pub use turned::{TURNED, Turn, TurnedError, turned_script};

use maud::{DOCTYPE, Markup, PreEscaped, html};
use parts::Part;

const STYLE: &str = include_str!("page.css");
/// One classic script, because a page opened from disk may load neither modules nor anything by
/// fetch: its parts share one scope, and stand in the order in which they need each other's
/// constants. Text from the study is only ever set as text in it, never as markup.
const SCRIPT: &str = concat!(
    "\"use strict\";\n(() => {\n",
    include_str!("script/words.js"),
    include_str!("script/data.js"),
    include_str!("script/pens.js"),
    include_str!("script/scales.js"),
    include_str!("script/view.js"),
    include_str!("script/curves.js"),
    include_str!("script/panels.js"),
    include_str!("script/browser.js"),
    include_str!("script/screen.js"),
    include_str!("script/cursor.js"),
    include_str!("script/exports.js"),
    include_str!("script/dots.js"),
    include_str!("script/answers.js"),
    include_str!("script/sliders.js"),
    include_str!("script/page.js"),
    "})();\n",
);

/// The page in HTML. Texts are shown as they stand, whatever is in them.
///
/// # Errors
/// None that the memory does not make.
pub fn page_html(page: &Page) -> Result<String, serde_json::Error> {
    let parts: Vec<Part> = parts::all(page);
    let contents = page.contents.map(serde_json::to_string).transpose()?;
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="referrer" content="no-referrer";
                title { (page.summary.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (parts::header(page))
                nav #contents aria-label="Contents" {
                    ul { @for part in &parts { li { a href={ "#" (part.id) } { (part.title) } } } }
                }
                main #main {
                    @for part in &parts {
                        section id=(part.id) aria-labelledby={ (part.id) "-title" } {
                            h2 id={ (part.id) "-title" } { (part.title) }
                            (part.body)
                        }
                    }
                }
                @if let Some(contents) = contents { (data_block(&contents)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    let origin = page
        .origin
        .map(|o| format!("<!-- {o} (`zwidth trace FILE` tells what it was made from) -->\n"));
    Ok(markup.into_string() + "\n" + &origin.unwrap_or_default())
}

/// JSON that no text in it can end: `<` as an escape.
fn data_block(json: &str) -> Markup {
    let json = json.replace('<', "\\u003c");
    html! { script #study-data type="application/json" { (PreEscaped(json)) } }
}

#[cfg(test)]
mod tests;
