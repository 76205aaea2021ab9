//! Tables in other text formats, rewritten as delimited text, line for line, so that every row
//! keeps its line number in the file.

/// What LabChart's text export begins its blocks with (ADInstruments, "How can channel titles,
/// ranges, intervals, etc. for a text file be imported into LabChart?").
pub(super) const LABCHART: &str = "Interval=";
/// The line of a block that names its channels.
const TITLES: &str = "ChannelTitle=";
/// The beginning of a comment at the end of a line.
const COMMENT: &str = "#*";

/// Whether a text is LabChart's export.
pub(super) fn is_labchart(text: &str) -> bool {
    text.starts_with(LABCHART)
}

/// LabChart's export with tabs: the first block's channel titles are the header, with `Time` before
/// them; the other lines of a block's head, and comments, are blank. Blocks follow each other: the
/// time starts over with each, where it counts from the block's start.
pub(super) fn labchart(text: &str) -> String {
    let mut titled = false;
    let mut lines = String::with_capacity(text.len());
    for line in text.lines() {
        let line = line.split(COMMENT).next().unwrap_or_default().trim_end();
        // `Range=`, `UnitName=`, …: a line of the block's head.
        let word = line.split_once('=').map_or("", |(word, _)| word);
        let is_head = !word.is_empty() && word.chars().all(|c| c.is_ascii_alphabetic());
        if let Some(titles) = line.strip_prefix(TITLES) {
            if !titled {
                lines.push_str("Time\t");
                lines.push_str(titles.trim());
                titled = true;
            }
        } else if !is_head {
            lines.push_str(line);
        }
        lines.push('\n');
    }
    lines
}

/// The text with a tab for each run of blanks between cells, and without blanks at either end of a
/// line; a cell in double quotes keeps its own. Comments stay as they are.
pub(super) fn spaced(text: &str, comment: Option<u8>) -> String {
    let mut lines = String::with_capacity(text.len());
    for line in text.lines() {
        let cells = line.trim();
        let is_comment = comment.is_some() && cells.bytes().next() == comment;
        let mut quoted = false;
        let mut blank = false;
        for letter in cells.chars() {
            quoted ^= letter == '"';
            if letter.is_whitespace() && !quoted && !is_comment {
                blank = true;
                continue;
            }
            if std::mem::take(&mut blank) {
                lines.push('\t');
            }
            lines.push(letter);
        }
        lines.push('\n');
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_run_of_blanks_is_one_tab_but_for_those_in_quotes() {
        let text = "  t   \"F in N\"\n 0.0\t  1\n\n# a  pause\n1 2 \r\n";
        assert_eq!(spaced(text, Some(b'#')), "t\t\"F in N\"\n0.0\t1\n\n# a  pause\n1\t2\n");
    }

    #[test]
    fn a_labchart_export_keeps_its_lines_and_loses_its_heads_and_comments() {
        let text = "Interval=\t0.001 s\nExcelDateTime=\t4.1e4\t1/1/2015\nChannelTitle=\tForce\tAngle\n\
                    Range=\t10 V\t10 V\n0\t1\t2\n0.001\t3\t4\t#* begin\nInterval=\t0.001 s\n\
                    ChannelTitle=\tForce\tAngle\n0\t5\t6\n";
        assert!(is_labchart(text));
        let expect = "\n\nTime\tForce\tAngle\n\n0\t1\t2\n0.001\t3\t4\n\n\n0\t5\t6\n";
        assert_eq!(labchart(text), expect);
    }
}
