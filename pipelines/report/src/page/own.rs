//! The page's own script and style sheet. Colours, dashes and markers of modes are those of the
//! figures.

use std::fmt::Write as _;
use std::sync::LazyLock;
use zwidth_draw::style::{self, MODE_COLOURS};

/// Its style sheet.
pub(super) static STYLE: LazyLock<String> = LazyLock::new(|| {
    let mut light = String::new();
    let mut dark = String::new();
    let mut classes = String::new();
    for mode in 0..MODE_COLOURS {
        // Writing into a string does not fail.
        let _ = write!(light, " --mode-{mode}: {};", style::mode_colour(mode).css());
        let _ = write!(dark, " --mode-{mode}: {};", style::mode_colour_on_dark(mode).css());
        let _ = writeln!(classes, ".mode-{mode} {{ --mode: var(--mode-{mode}); }}");
    }
    format!(
        "{}:root, .light {{{light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{{dark} }} }}\n{classes}",
        include_str!("page.css")
    )
});

/// Its script.
static SCRIPT: LazyLock<String> = LazyLock::new(|| behind_dashes(""));

/// The same where effects or groups are claimed.
static SCRIPT_WITH_CLAIMS: LazyLock<String> =
    LazyLock::new(|| behind_dashes(include_str!("script/claims.js")));

/// The script of a page on which effects or groups are claimed, or not.
pub(super) fn script(has_claims: bool) -> &'static str {
    if has_claims { &SCRIPT_WITH_CLAIMS } else { &SCRIPT }
}

/// The parts, and more of them before what builds the page, behind the dashes of modes in widths of a line.
fn behind_dashes(more: &str) -> String {
    let dashes: Vec<&[f64]> = (0..style::DASHES).map(|mode| style::dash(mode).widths()).collect();
    format!(
        "\"use strict\";\n(() => {{\nconst MODE_COLOURS = {MODE_COLOURS}, WIDTHS = {dashes:?};\n{PARTS}{more}{BUILDS}}})();\n"
    )
}

/// One classic script, because a page opened from disk may load neither modules nor anything by
/// fetch: its parts share one scope, and stand in the order in which they need each other's
/// constants. Text from the study is only ever set as text in it, never as markup.
const PARTS: &str = concat!(
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
    include_str!("script/amounts.js"),
    include_str!("script/dots.js"),
    include_str!("script/estimates.js"),
    include_str!("script/verdicts.js"),
    include_str!("script/answers.js"),
    include_str!("script/sliders.js"),
);

/// What builds the page of these parts.
const BUILDS: &str = include_str!("script/page.js");
