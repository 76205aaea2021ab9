//! LabVIEW's measurement files (`.lvm`): text after two headers of keys, which say what the columns
//! are.
//!
//! Source of the format: National Instruments, "Specification for the LabVIEW Measurement File (.lvm)".

/// The last line of each of the two heads.
const END: &str = "***End_of_Header***";
/// The first column and the last, which only some rows have.
const FIRST: &str = "X_Value";
const LAST: &str = "Comment";

/// Whether a header is that of such a file, whose rows end before the last column where they have no
/// comment.
pub(super) fn has_comments(names: &[String]) -> bool {
    names.first().is_some_and(|first| first == FIRST)
        && names.last().is_some_and(|last| last == LAST)
}

/// The content of the heads.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LabView {
    /// Lines before the names of the columns.
    pub(super) lines: usize,
    /// The delimiter.
    pub(super) delimiter: u8,
    /// Whether each channel has a column of its own before it, so that names come twice.
    pub(super) has_many_times: bool,
    /// Whether the first column is the time; `None` where it is empty.
    pub(super) is_time: Option<bool>,
    /// Time from a sample to the next one, s.
    pub(super) step_s: Option<f64>,
    /// The units of the channels, from the second column on.
    pub(super) units: Vec<String>,
}

/// Reads the heads of a text; `None` if it is no such file.
pub(super) fn heads(text: &str) -> Option<LabView> {
    if !text.starts_with("LabVIEW Measurement") {
        return None;
    }
    let is_comma = text.lines().any(|line| line.starts_with("Separator,"));
    let delimiter = if is_comma { b',' } else { b'\t' };
    let ends = text.lines().enumerate().filter(|(_, line)| line.starts_with(END));
    let lines = ends.map(|(line, _)| line + 1).nth(1)?;
    let [x_columns, dimension, step] = ["X_Columns", "X_Dimension", "Delta_X"].map(|key| {
        let first = values(text, lines, delimiter, key).into_iter().next();
        first.filter(|text| !text.is_empty())
    });
    let x_columns = x_columns.map(|word| word.to_ascii_lowercase());
    // Of files that do not say it, the first column is a time.
    let is_time = dimension.is_none_or(|dimension| dimension.eq_ignore_ascii_case("time"));
    let step = step.and_then(|step| step.replace(',', ".").parse().ok());
    Some(LabView {
        lines,
        delimiter,
        has_many_times: x_columns.as_deref() == Some("multi"),
        is_time: (x_columns.as_deref() != Some("no")).then_some(is_time),
        step_s: step.filter(|step| is_time && *step > 0.0),
        units: values(text, lines, delimiter, "Y_Unit_Label"),
    })
}

/// The cells behind a key in the heads. The second head is about the channels: its key counts where
/// both have it.
fn values(text: &str, lines: usize, delimiter: u8, key: &str) -> Vec<String> {
    let rows = text.lines().take(lines).filter_map(|line| {
        let mut cells = line.split(char::from(delimiter)).map(str::trim);
        (cells.next() == Some(key)).then_some(cells)
    });
    rows.last().map(|cells| cells.map(str::to_owned).collect()).unwrap_or_default()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A file of two channels, whose first head says how many columns of time there are.
    pub(in super::super) fn written(x_columns: &str, names: &str, rows: &str) -> String {
        let first = format!(
            "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t,\r\n\
             X_Columns\t{x_columns}\r\n{END}\t\r\n\t\r\n"
        );
        let second = format!(
            "Channels\t2\t\t\r\nSamples\t3\t3\t\r\nY_Unit_Label\tDegrees\tNewtons\t\r\nX_Dimension\tTime\tTime\t\r\n\
             X0\t0,0\t0,0\t\r\nDelta_X\t0,05\t0,05\t\r\n{END}\t\t\t\r\n"
        );
        format!("{first}{second}{names}\r\n{rows}")
    }

    #[test]
    fn the_heads_say_where_the_names_are_and_what_the_columns_mean() {
        let text = written("One", "X_Value\tangle\tF\tComment", "0,00\t1,0\t2,0\r\n");
        let found = heads(&text).unwrap();
        assert_eq!(text.lines().nth(found.lines), Some("X_Value\tangle\tF\tComment"));
        assert_eq!((found.is_time, found.step_s), (Some(true), Some(0.05)));
        assert_eq!(found.units[..2], ["Degrees", "Newtons"]);
        assert_eq!(heads(&written("No", "", "")).unwrap().is_time, None);
        assert!(heads(&written("Multi", "", "")).unwrap().has_many_times);
        assert_eq!(heads("t,f\n0,1\n"), None);
    }
}
