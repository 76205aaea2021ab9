//! LaTeX: a `table` with booktabs rules and siunitx columns, to be `\input` into a document.

use crate::latex_escape::escape;
use crate::shown::{Cell, MISSING, Shown, rows, shown};
use crate::typst::label;
use crate::{Table, TableError};

/// What the document must load, said in the file's first lines.
const PREAMBLE: &str =
    "% needs \\usepackage{booktabs,siunitx}; under pdflatex also \\usepackage[T1]{fontenc}\n";

/// The table as a LaTeX `table` with caption and label `tab:name`, the notes below. Rounded for people;
/// columns of numbers are aligned at the point (siunitx `S`). Compiles with pdflatex and xelatex.
///
/// # Errors
/// Of polars, never in practice.
pub fn latex(table: &Table) -> Result<String, TableError> {
    let columns = shown(table)?;
    let formats: Vec<String> = columns.iter().map(column_type).collect();
    let headings: Vec<String> = columns.iter().map(|c| format!("{{{}}}", escape(&c.heading()))).collect();
    let body: String = rows(&columns).map(|cells| row(&columns, &cells)).collect();
    let notes: String = table
        .notes()
        .iter()
        .map(|n| format!("  \\par\\smallskip\n  {{\\footnotesize {}\\par}}\n", escape(n)))
        .collect();
    Ok(format!(
        "{PREAMBLE}\\begin{{table}}\n  \\centering\n  \\caption{{{}}}\n  \\label{{tab:{}}}\n  \
         \\begin{{tabular}}{{{}}}\n    \\toprule\n    {} \\\\\n    \\midrule\n{body}    \\bottomrule\n  \
         \\end{{tabular}}\n{notes}\\end{{table}}\n",
        escape(table.title()),
        label(table.name()),
        formats.join(" "),
        headings.join(" & "),
    ))
}

fn row(columns: &[Shown], cells: &[&Cell]) -> String {
    let cells: Vec<String> = columns.iter().zip(cells).map(|(column, cell)| set(column, cell)).collect();
    format!("    {} \\\\\n", cells.join(" & "))
}

/// A cell; in a column of numbers, what is not a number stands in braces.
fn set(column: &Shown, cell: &Cell) -> String {
    match cell {
        Cell::Number(number) => number.ascii(),
        Cell::Text(text) => escape(text),
        Cell::Missing if column.numeric => format!("{{{}}}", escape(MISSING)),
        Cell::Missing => escape(MISSING),
    }
}

/// `l`, or siunitx' `S` with room for the longest of sign, whole part, decimals and power.
fn column_type(column: &Shown) -> String {
    if !column.numeric {
        return "l".to_owned();
    }
    let numbers = || column.cells.iter().filter_map(|c| if let Cell::Number(n) = c { Some(n) } else { None });
    let sign = if numbers().any(|n| n.mantissa.starts_with('-')) { "-" } else { "" };
    let whole =
        numbers().map(|n| n.mantissa.trim_start_matches('-').split('.').next().map_or(0, str::len)).max();
    let decimals = numbers().filter_map(|n| n.mantissa.split_once('.')).map(|(_, d)| d.len()).max();
    let decimals = decimals.map(|d| format!(".{d}")).unwrap_or_default();
    let powers: Vec<i32> = numbers().filter_map(|n| n.exponent).collect();
    let power = powers.iter().map(|e| e.to_string().trim_start_matches('-').len()).max();
    let power_sign = if powers.iter().any(|e| *e < 0) { "-" } else { "" };
    let power = power.map(|digits| format!("e{power_sign}{digits}")).unwrap_or_default();
    format!("S[table-format={sign}{}{decimals}{power}]", whole.unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Column;
    use crate::shown::tests::sample;

    #[test]
    fn the_sample_is_a_table_with_aligned_numbers() {
        let expect = r"% needs \usepackage{booktabs,siunitx}; under pdflatex also \usepackage[T1]{fontenc}
\begin{table}
  \centering
  \caption{Slope, 100 \%}
  \label{tab:spring-rendering}
  \begin{tabular}{l S[table-format=-2] S[table-format=-1.3] S[table-format=1.3] l}
    \toprule
    {mode} & {trial} & {slope (N/rad)} & {slope std. error (N/rad)} & {wall reached} \\
    \midrule
    a\textbar{}b \& \textless{}c\textgreater{} & -3 & -4.123 & 0.032 & yes \\
    -- & 12 & 5 & {--} & -- \\
    \bottomrule
  \end{tabular}
  \par\smallskip
  {\footnotesize Unit: one\_trial.\par}
\end{table}
";
        assert_eq!(latex(&sample()).unwrap(), expect);
    }

    #[test]
    fn a_power_of_ten_has_room_in_its_column() {
        let column = Column::float("area_j", "J", "", [Some(-1.234_5e-12), Some(25.0), None]);
        let table = Table::new("t", "", vec![column]).unwrap();
        assert_eq!(column_type(&shown(&table).unwrap()[0]), "S[table-format=-2.3e-2]");
    }
}
