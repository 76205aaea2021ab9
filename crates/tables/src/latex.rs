//! LaTeX: tables with booktabs rules and siunitx columns, to be `\input` into a document.

use crate::Table;
use crate::latex_escape::escape;
use crate::layout::{Layout, Placed, Sections, has_page, lines};
use crate::shown::{Cell, MISSING, Seen, rows};
use crate::typst::label;

/// What the document must load, said in the file's first line, and what stands above a column in
/// several lines.
// Provided, not defined, here and below: a document may take in several tables.
const PREAMBLE: &str = r"% needs \usepackage{booktabs,longtable,siunitx}; under pdflatex also \usepackage[T1]{fontenc}
\providecommand*\zwidthhead[2]{\begin{tabular}[b]{@{}#1@{}}#2\end{tabular}}
";
/// What a table needs besides that is wider than a column of a page with two: there it floats over
/// both, or, where it needs more than a page, has pages of one column, as `longtable` asks for.
const WIDE: &str = r"\makeatletter
\providecommand*\zwidthtable{\if@twocolumn table*\else table\fi}
\providecommand*\zwidthwide{\if@twocolumn\onecolumn\let\zwidthback\twocolumn\else\let\zwidthback\relax\fi}
\makeatother
";
/// The caption stands above the table, where LaTeX' own classes leave no space below it.
const CAPTION: &str = r"\setlength{\abovecaptionskip}{0pt}\setlength{\belowcaptionskip}{6pt}";
/// A table that is small: its size and gaps.
const DENSE: &str = r"\footnotesize\setlength{\tabcolsep}{4pt}";

/// The table in LaTeX with caption and label `tab:name`, the notes below. Rounded for people;
/// columns of numbers are aligned at the point (siunitx `S`). Compiles with pdflatex, lualatex and
/// xelatex.
///
/// It fits a text block of 345 pt (`article` at 10 pt) and any wider one: what is wide is set
/// small, long texts wrap, and columns that still do not fit stand in further tables below, which
/// repeat the columns that say what a row is about. A `table` floats; one that needs more than a
/// page is a `longtable` with its headings on each. On pages of two columns (252 pt) a table that is
/// wider than one stands over both.
pub(crate) fn latex(&Seen { table, layout, .. }: &Seen) -> String {
    let mut notes = String::new();
    for note in layout.notes.iter().chain(table.notes()).map(|note| escape(note)) {
        notes += &format!("  \\par\\smallskip\n  {{\\footnotesize\\raggedright {note}\\par}}\n");
    }
    let tables = match layout.long {
        true => long(table, layout, &notes),
        false => floating(table, layout, &notes),
    };
    let wide = if layout.long || !layout.fits_a_column() { WIDE } else { "" };
    format!("{PREAMBLE}{wide}{tables}")
}

/// One float, with one `tabular` below the other.
fn floating(table: &Table, layout: &Layout, notes: &str) -> String {
    let tabulars = layout.groups.iter().map(|group| {
        format!(
            "  \\begin{{tabular}}{{{}}}\n    \\toprule\n{}    \\midrule\n{}    \\bottomrule\n  \\end{{tabular}}\n",
            column_types(group),
            head(group),
            body(group, &layout.sections)
        )
    });
    let tabulars: Vec<String> = tabulars.collect();
    let size = if layout.dense { format!("  {DENSE}\n") } else { String::new() };
    let float = if layout.fits_a_column() { "table" } else { r"\zwidthtable" };
    format!(
        "\\begin{{{float}}}\n  \\centering\n  {CAPTION}\n  \\caption{{{}}}\n  \\label{{tab:{}}}\n{size}{}{notes}\\end{{{float}}}\n",
        escape(table.title()),
        label(table.name()),
        tabulars.join("  \\par\\medskip\n")
    )
}

/// A `longtable` after the other under one number: the first has the caption, the others and all
/// further pages say that they continue it.
fn long(table: &Table, layout: &Layout, notes: &str) -> String {
    let label = label(table.name());
    let caption = format!("  \\caption{{{}}}\\label{{tab:{label}}}\\\\\n", escape(table.title()));
    let mut tables = String::new();
    for (i, group) in layout.groups.iter().enumerate() {
        let caption = (i == 0).then_some(caption.as_str());
        tables += &longtable(&label, caption, group, &layout.sections);
    }
    // Within a group, so that the size ends with the tables.
    let size = if layout.dense { DENSE } else { "" };
    format!("\\zwidthwide\\begingroup{size}\n{tables}{notes}\\endgroup\\zwidthback\n")
}

/// One of the tables under a number: the first has the caption, any other goes on.
fn longtable(label: &str, caption: Option<&str>, group: &[Placed], sections: &Sections) -> String {
    let types = column_types(group);
    let head = head(group);
    let width = group.len();
    let again = format!(
        "  \\multicolumn{{{width}}}{{@{{}}l@{{}}}}{{\\tablename~\\ref{{tab:{label}}}, continued}}\\\\\n"
    );
    let mut before = String::new();
    if caption.is_none() {
        // A new page, if the table has room there and not on this one.
        if has_page(group) {
            before += &format!(
                "\\par\\ifdim\\dimexpr\\pagegoal-\\pagetotal\\relax<{}\\baselineskip\\newpage\\fi\n",
                lines(group)
            );
        }
        // `longtable` counts a table each time it begins, with a caption or without.
        before += "\\addtocounter{table}{-1}\n";
    }
    let head = format!("    \\toprule\n{head}    \\midrule\n");
    format!(
        "{before}\\begin{{longtable}}{{{types}}}\n{}{head}  \\endfirsthead\n{again}{head}  \\endhead\n    \
         \\bottomrule\n  \\endfoot\n{}\\end{{longtable}}\n",
        caption.unwrap_or(&again),
        body(group, sections)
    )
}

fn column_types(group: &[Placed]) -> String {
    let types: Vec<String> = group.iter().map(column_type).collect();
    format!("@{{}}{}@{{}}", types.join(" "))
}

fn head(group: &[Placed]) -> String {
    let cells: Vec<String> = group.iter().map(heading).collect();
    format!("    {} \\\\\n", cells.join(" & "))
}

/// The heading in braces, which keep siunitx from reading it as a number.
fn heading(placed: &Placed) -> String {
    let lines: Vec<String> = placed.head.iter().map(|line| escape(line)).collect();
    match lines.as_slice() {
        [line] => format!("{{{line}}}"),
        lines => {
            let align = if placed.column.numeric { "c" } else { "l" };
            format!(r"{{\zwidthhead{{{align}}}{{{}}}}}", lines.join(r"\\"))
        }
    }
}

fn body(group: &[Placed], sections: &Sections) -> String {
    // Rows of several lines need room between them, or they read as one.
    let wraps = group.iter().any(|c| c.share.is_some());
    let end = if wraps { r"\\ \addlinespace[2pt]" } else { r"\\" };
    let mut body = String::new();
    let rows = rows(group.iter().map(|p| p.column), |k, cell| set(&group[k], cell));
    for (i, cells) in rows.iter().enumerate() {
        if let Some(title) = sections.get(&i) {
            let space = if i > 0 { "    \\addlinespace\n" } else { "" };
            let (width, title) = (group.len(), escape(title));
            // No page ends below a heading: `\\*`.
            body += &format!(
                "{space}    \\multicolumn{{{width}}}{{@{{}}l@{{}}}}{{\\itshape {title}}} \\\\* \\addlinespace[2pt]\n"
            );
        }
        body += &format!("    {} {end}\n", cells.join(" & "));
    }
    body
}

/// A cell; in a column of numbers, what is not a number stands in braces.
fn set(placed: &Placed, cell: &Cell) -> String {
    match cell {
        Cell::Number(number) => number.ascii(),
        Cell::Text(text) => escape(text),
        Cell::Joined(text) => format!("{{{}}}", escape(text)),
        Cell::Missing if placed.column.numeric => format!("{{{}}}", escape(MISSING)),
        Cell::Missing => escape(MISSING),
    }
}

/// `l`, a paragraph, or siunitx' `S` with room for the longest of `<`, sign, whole part, decimals
/// and power.
fn column_type(placed: &Placed) -> String {
    if let Some(share) = placed.share {
        // Rounded down, so that the shares do not come to more than the line.
        return format!(
            r">{{\raggedright\arraybackslash}}p{{{:.3}\linewidth}}",
            (share * 1e3).floor() / 1e3
        );
    }
    if !placed.column.numeric {
        return "l".to_owned();
    }
    // siunitx reads `[3.9, 4.2]` as no number: such cells are text, at the right.
    if placed.column.cells.iter().any(|cell| matches!(cell, Cell::Joined(_))) {
        return "r".to_owned();
    }
    let room = placed.column.room;
    let below = if room.below { "<" } else { "" };
    let sign = if room.sign { "-" } else { "" };
    let decimals = if room.decimals > 0 { format!(".{}", room.decimals) } else { String::new() };
    let power_sign = if room.power_sign { "-" } else { "" };
    let power = if room.power > 0 { format!("e{power_sign}{}", room.power) } else { String::new() };
    format!("S[table-format={below}{sign}{}{decimals}{power}]", room.whole.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Column;
    use crate::shown::tests::sample;

    #[test]
    fn the_sample_is_a_table_with_aligned_numbers() {
        let expect = r"% needs \usepackage{booktabs,longtable,siunitx}; under pdflatex also \usepackage[T1]{fontenc}
\providecommand*\zwidthhead[2]{\begin{tabular}[b]{@{}#1@{}}#2\end{tabular}}
\begin{table}
  \centering
  \setlength{\abovecaptionskip}{0pt}\setlength{\belowcaptionskip}{6pt}
  \caption{Slope, 100 \%}
  \label{tab:spring-rendering}
  \begin{tabular}{@{}l S[table-format=-2] S[table-format=-1.3] S[table-format=1.3] l@{}}
    \toprule
    {mode} & {trial} & {\zwidthhead{c}{slope\\(N/rad)}} & {\zwidthhead{c}{slope std.\\error (N/rad)}} & {\zwidthhead{l}{wall\\reached}} \\
    \midrule
    a\textbar{}b \& \textless{}c\textgreater{} & -3 & -4.123 & 0.032 & yes \\
    -- & 12 & 5 & {--} & -- \\
    \bottomrule
  \end{tabular}
  \par\smallskip
  {\footnotesize\raggedright Unit: one\_trial.\par}
\end{table}
";
        assert_eq!(Seen::of(&sample(), None, latex), expect);
    }

    /// A page of two columns has 252 pt a column.
    #[test]
    fn a_table_that_is_wider_than_a_column_stands_over_both() {
        let number = |name| Column::float(name, "N", "", [Some(1234.5), Some(-2345.25)]);
        let set = |names: &[&'static str]| {
            let columns = names.iter().map(|name| number(name)).collect();
            Seen::of(&Table::new("t", "", columns).unwrap(), None, latex)
        };
        let narrow = set(&["force_n", "peak_n"]);
        assert!(narrow.contains(r"\begin{table}") && !narrow.contains("zwidthtable"), "{narrow}");
        let wide = set(&["force_n", "peak_n", "mean_force_n", "largest_n", "smallest_n", "last_n"]);
        assert!(wide.contains(r"\begin{\zwidthtable}") && wide.contains(r"\end{\zwidthtable}"));
        assert!(wide.contains(r"\if@twocolumn table*\else table\fi"), "{wide}");
        let rows = (0..90).map(|row| Some(f64::from(row)));
        let long = Table::new("t", "", vec![Column::float("force_n", "N", "", rows)]).unwrap();
        let long = Seen::of(&long, None, latex);
        let at = |words: &str| long.find(words).unwrap();
        assert!(at(r"\zwidthwide\begingroup") < at(r"\begin{longtable}"), "{long}");
        assert!(at(r"\endgroup\zwidthback") > at(r"\end{longtable}"), "{long}");
    }

    #[test]
    fn a_power_of_ten_has_room_in_its_column() {
        let column = Column::float("area_j", "J", "", [Some(-1.234_5e-12), Some(25.0), None]);
        let table = Table::new("t", "", vec![column]).unwrap();
        assert!(Seen::of(&table, None, latex).contains("{@{}S[table-format=-2.3e-2]@{}}"));
    }

    #[test]
    fn a_small_p_value_is_a_number_with_room_for_its_sign() {
        let column = Column::float("p_value", "1", "", [Some(0.0), Some(0.0942)]);
        let text = Seen::of(&Table::new("t", "", vec![column]).unwrap(), None, latex);
        assert!(text.contains("{@{}S[table-format=<1.4]@{}}"), "{text}");
        assert!(text.contains("    <0.001 \\\\\n    0.0942 \\\\\n"), "{text}");
    }

    #[test]
    fn a_table_of_several_pages_repeats_its_headings_and_keeps_its_number() {
        let numbers = |i: i32| (0..60).map(move |row| Some(f64::from(row + i) * 1000.5));
        let names =
            ["velocity_forward", "velocity_backward", "discrepancy", "stiffness", "duration"];
        let names = names.into_iter().chain(["impulse", "dwell"]);
        let mut columns = vec![Column::integer("trial", "1", "", (0..60).map(Some))];
        columns.push(Column::text("mode", "", (0..60).map(|_| Some("hybrid".to_owned()))));
        columns.extend(names.zip(0..).map(|(name, i)| Column::float(name, "1", "", numbers(i))));
        let text = Seen::of(&Table::new("t", "T", columns).unwrap(), None, latex);
        assert_eq!(text.matches(r"\begin{longtable}").count(), 1, "{text}");
        assert_eq!(text.matches(r"\caption{T}\label{tab:t}").count(), 1);
        assert_eq!(text.matches("{trial} & ").count(), 2, "on the first page and on all others");
        assert!(text.contains(r"{\tablename~\ref{tab:t}, continued}"));
    }

    #[test]
    fn a_table_in_parts_on_several_pages_counts_as_one() {
        let numbers = || (0..30).map(|row| Some(f64::from(row) * 1000.5));
        let mut columns = vec![Column::integer("trial", "1", "", (0..30).map(Some))];
        let names = [
            "velocity_a",
            "discrepancy_b",
            "stiffness_c",
            "penetration_d",
            "oscillation_e",
            "acceleration_f",
            "compliance_g",
            "smoothness_h",
        ];
        columns.extend(names.into_iter().map(|name| Column::float(name, "1", "", numbers())));
        let text = Seen::of(&Table::new("t", "T", columns).unwrap(), None, latex);
        assert_eq!(text.matches(r"\begin{longtable}").count(), 2, "{text}");
        assert_eq!(text.matches(r"\addtocounter{table}{-1}").count(), 1);
        assert_eq!(text.matches(r"\caption").count(), 1);
    }
}
