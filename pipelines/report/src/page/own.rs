//! The page's own script and style sheet, as they stand in it.

/// Its style sheet.
pub(super) const STYLE: &str = include_str!("page.css");
/// One classic script, because a page opened from disk may load neither modules nor anything by
/// fetch: its parts share one scope, and stand in the order in which they need each other's
/// constants. Text from the study is only ever set as text in it, never as markup.
pub(super) const SCRIPT: &str = concat!(
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
