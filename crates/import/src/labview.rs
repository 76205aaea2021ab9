//! LabVIEW's measurement files (`.lvm`): text after two headers of keys, which say what the columns
//! are.
//!
//! Source of the format: National Instruments, "Specification for the LabVIEW Measurement File (.lvm)".

/// What each of the two heads ends with.
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

/// What the heads say.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LabView {
    /// Lines before the names of the columns.
    pub(super) lines: usize,
    /// What stands between cells.
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

/// What the heads of a text say, if it is such a file.
pub(super) fn heads(text: &str) -> Option<LabView> {
    if !text.starts_with("LabVIEW Measurement") {
        return None;
    }
    let is_comma = text.lines().any(|line| line.starts_with("Separator,"));
    let delimiter = if is_comma { b',' } else { b'\t' };
    let cells = |line: &str| -> Vec<String> {
        line.split(char::from(delimiter)).map(|cell| cell.trim().to_owned()).collect()
    };
    let ends = text.lines().enumerate().filter(|(_, line)| line.starts_with(END));
    let lines = ends.map(|(line, _)| line + 1).nth(1)?;
    let value = |key: &str| {
        let heads = text.lines().take(lines).map(cells);
        heads.filter(|cells| cells[0] == key).map(|cells| cells[1..].to_vec()).last()
    };
    let first = |key: &str| value(key)?.into_iter().next().filter(|text| !text.is_empty());
    let is =
        |text: Option<String>, word: &str| text.is_some_and(|text| text.eq_ignore_ascii_case(word));
    // Of files that do not say it, the first column is a time.
    let is_time =
        first("X_Dimension").is_none_or(|dimension| dimension.eq_ignore_ascii_case("time"));
    let step = first("Delta_X").and_then(|step| step.replace(',', ".").parse().ok());
    Some(LabView {
        lines,
        delimiter,
        has_many_times: is(first("X_Columns"), "multi"),
        is_time: (!is(first("X_Columns"), "no")).then_some(is_time),
        step_s: step.filter(|step| is_time && *step > 0.0),
        units: value("Y_Unit_Label").unwrap_or_default(),
    })
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
