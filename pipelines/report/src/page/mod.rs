//! The page: the summary for a browser, with every trial to look at.
//!
//! All text is in the page itself, so the page reads and prints without its script. The script
//! (`script/`, ours, no library) adds the browser of trials and everything that can be clicked.
//! Nothing leaves the page: style and script are in it, and samples in scripts beside it
//! ([`condition_script`]), which are loaded on request. A policy in its head ([`policy`]) forbids
//! the browser everything else.

mod contents;
mod course;
mod estimates;
mod own;
mod parts;
mod policy;
mod quality;
mod single;
mod turned;

pub use contents::{Contents, Estimating, Page, TrialValues};
pub use course::{Columns, Course, Event, condition_script};
pub use single::single_file;
pub use turned::{TURNED, Turn, turned_script};

use maud::{DOCTYPE, PreEscaped, html};
use own::{STYLE, script};
use parts::Part;
use policy::{Form, policy};
use single::DATA;
use std::io::{self, BufWriter, Write};

/// The page in HTML, before and after the data that its script knows of the study: in a large study
/// these are far more than the rest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageHtml {
    before: String,
    /// None where it has no script that knows anything.
    after: Option<String>,
}

/// The page in HTML. Texts are shown unchanged, whatever they contain.
pub fn page_html(page: &Page) -> PageHtml {
    let parts: Vec<Part> = parts::all(page);
    let script = script(page.contents.is_some_and(Contents::has_claims));
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                // Before anything that it is about: what stands above it is not held to it.
                meta http-equiv="Content-Security-Policy" content=(PreEscaped(policy(Form::Folder, script)));
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="referrer" content="no-referrer";
                title { (page.summary.title) }
                style { (PreEscaped(STYLE.as_str())) }
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
                @if page.contents.is_some() { (PreEscaped(DATA)) (PreEscaped("</script>")) }
                script { (PreEscaped(script)) }
            }
        }
    };
    let origin = page
        .origin
        .map(|o| format!("<!-- {o} (`zwidth trace FILE` tells what it was made from) -->\n"));
    let mut before = markup.into_string() + "\n" + &origin.unwrap_or_default();
    // No text of a study can begin a tag.
    let place = before.find(DATA).filter(|_| page.contents.is_some());
    let after = place.map(|begin| before.split_off(begin + DATA.len()));
    PageHtml { before, after }
}

impl PageHtml {
    /// Writes the page, in it the contents that it was made for.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, contents: Option<&Contents>, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(self.before.as_bytes())?;
        let Some(after) = &self.after else { return Ok(()) };
        let mut json = BufWriter::new(NoTag(out));
        serde_json::to_writer(&mut json, &contents)?;
        json.flush()?;
        drop(json);
        out.write_all(after.as_bytes())
    }
}

/// Writes JSON that no text in it can end: `<` as an escape.
struct NoTag<'w>(&'w mut dyn Write);

impl Write for NoTag<'_> {
    fn write(&mut self, json: &[u8]) -> io::Result<usize> {
        for (i, part) in json.split(|byte| *byte == b'<').enumerate() {
            if i > 0 {
                self.0.write_all(b"\\u003c")?;
            }
            self.0.write_all(part)?;
        }
        Ok(json.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests;
