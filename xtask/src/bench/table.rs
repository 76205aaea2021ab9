//! Tables of a Markdown page, as benches write them.

/// A table: headings, and rows as wide.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    pub(super) headings: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Table {
    /// Where the column of that heading stands.
    pub(super) fn column(&self, heading: &str) -> Option<usize> {
        self.headings.iter().position(|h| h == heading)
    }
}

/// Every table of a page.
pub(super) fn tables(page: &str) -> Vec<Table> {
    let lines: Vec<&str> = page.lines().map(str::trim).collect();
    let blocks = lines.split(|line| !line.starts_with('|'));
    blocks.filter_map(table).collect()
}

fn table(lines: &[&str]) -> Option<Table> {
    let [headings, _, rows @ ..] = lines else { return None };
    let headings = cells(headings);
    let rows = rows.iter().map(|line| cells(line)).filter(|row| row.len() == headings.len());
    Some(Table { rows: rows.collect(), headings })
}

/// The cells of a line, without what makes them bold or code.
fn cells(line: &str) -> Vec<String> {
    let inner = line.trim_matches('|');
    inner.split('|').map(|cell| cell.trim().replace("**", "").replace('`', "")).collect()
}

/// The first number of a cell: `8.5 / 8.5`, `1,087,831.5`.
pub(super) fn number(cell: &str) -> Option<f64> {
    cell.split_whitespace().next()?.replace(',', "").parse().ok()
}

/// The lines of a page that say on which machine its parts were measured: `x86_64, 2 cores, …`.
pub(super) fn machines(page: &str) -> Vec<String> {
    let is_one = |line: &&str| {
        let mut parts = line.splitn(3, ", ");
        let is_word = parts.next().is_some_and(|word| !word.is_empty() && !word.contains(' '));
        let cores = parts.next().and_then(|cores| cores.strip_suffix(" cores"));
        is_word && cores.is_some_and(|n| n.parse::<u32>().is_ok())
    };
    page.lines().filter(is_one).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_found_between_paragraphs_and_their_cells_are_plain() {
        let page = "# A\n\nx86_64, 2 cores, rustc.\n\n\
                    | a | b |\n| --- | --- |\n| **c** | `1,5` |\n| d |\n\ntext\n";
        let found = tables(page);
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].column("b"), &found[0].rows),
            (Some(1), &vec![vec!["c".to_owned(), "1,5".to_owned()]])
        );
        assert_eq!(machines(page), ["x86_64, 2 cores, rustc."]);
        assert_eq!(
            (number("8.5 / 8.6"), number("1,087.5"), number("–")),
            (Some(8.5), Some(1087.5), None)
        );
    }
}
