//! How text is written, and what its cells contain.

use super::super::world::{FORCE, ONE, trials_map};
use super::{PLAIN, Row, csv, file, mapped_csv, plain};

/// How text is written.
pub(super) fn texts() -> Vec<Row> {
    let utf_16: Vec<u8> =
        format!("\u{feff}{PLAIN}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    let german = "t;f\n0;1,5\n0,5;-2\n1;4\n";
    let latin = b"t,f,gr\xf6\xdfe\n0,1.5,1\n0.5,-2,1\n1,4,1\n";
    let comma = "delimiter = \";\"\ndecimal = \",\"";
    vec![
        csv(
            "a byte-order mark and Windows line ends",
            "",
            format!("\u{feff}{}", PLAIN.replace('\n', "\r\n")),
        ),
        csv("UTF-16, as Excel calls Unicode text", "", utf_16),
        csv("Latin-1, not said", "", latin),
        csv("Latin-1, said", "encoding = \"latin-1\"", latin),
        csv("semicolons and decimal commas, said", comma, german),
        csv("semicolons, not said", "", german),
        csv("decimal commas, not said", "delimiter = \";\"", german),
        csv("tabs in a .csv, not said", "", PLAIN.replace(',', "\t")),
        file("columns apart by blanks in a .txt", "a.txt", PLAIN.replace(',', "   ")),
        plain("thousands separators", "", "1.5", "\"1,234.5\""),
        plain("a minus sign from a word processor", "", "-2", "−2"),
        csv(
            "a header one cell short, as R writes row names",
            "",
            "t,f\na,0,1.5\nb,0.5,-2\nc,1,4\n",
        ),
        csv(
            "a delimiter at the end of each line but the header",
            "",
            "t,f\n0,1.5,\n0.5,-2,\n1,4,\n",
        ),
        csv("a delimiter at the end of every line", "", PLAIN.replace('\n', ",\n")),
        csv("a line of units below the header", "", PLAIN.replace("t,f\n", "t,f\ns,N\n")),
        csv("a line of units, passed by", "bad_lines = 1", PLAIN.replace("t,f\n", "t,f\ns,N\n")),
        csv(
            "lines before the header",
            "",
            format!("Rig 2\n2026-01-01\n{}", PLAIN.replace(',', ";")),
        ),
        csv("lines before the header, said", "skip = 1", format!("Rig 2, upstairs\n{PLAIN}")),
        csv("remarks behind #, said", "comment = \"#\"", format!("# upstairs\n{PLAIN}")),
        csv("blank lines", "", PLAIN.replace('\n', "\n\n")),
        csv("blank lines at the end", "", PLAIN.to_owned() + "\n,\n\n"),
        mapped_csv(
            "blank lines, where samples come at a rate",
            trials_map(&[ONE, &FORCE.replace("from = \"t\"\nunit = \"s\"", "rate_hz = 2.0")]),
            PLAIN.replace('\n', "\n\n"),
        ),
        csv("no header, not said", "", PLAIN.replace("t,f\n", "")),
        csv("a line cut off", "", PLAIN.replace("1,4\n", "1")),
        csv("an empty file", "", ""),
        csv("a header alone", "", "t,f\n"),
        csv("one row alone", "", "t,f\n0,1.5\n"),
    ]
}

/// What stands in cells.
pub(super) fn cells() -> Vec<Row> {
    let usual = trials_map(&[ONE, FORCE]);
    let by_column = || usual.replace("\"P01\"", "{ column = \"who\" }");
    vec![
        plain("a column by another name", "", "t,f", "time,f"),
        plain("two columns of one name", "", "t,f\n0,1.5\n0.5,-2\n1,4\n", "t,f,f\n0,1,2\n"),
        plain("n/a for a missing value", "", "-2", "n/a"),
        plain("an empty cell", "", "-2", ""),
        plain("NaN", "", "-2", "NaN"),
        plain("NaN, left out", "missing = \"drop\"", "-2", "NaN"),
        plain("an infinity", "", "-2", "inf"),
        plain("true and false for a number", "", "-2", "TRUE"),
        plain("a date for one of the times", "", "\n0,", "\n2026-01-01 10:00:00,"),
        plain("a time that starts over", "", "\n1,4", "\n0,4"),
        plain("a time that starts over, said", "split = \"time\"", "\n1,4", "\n0,4"),
        plain("a time of too few digits, so that two samples have one", "", "0.5", "0"),
        plain(
            "milliseconds since 1970 taken for seconds",
            "",
            "\n0,1.5\n0.5,-2\n1,4",
            "\n1767225600000,1.5\n1767225600500,-2\n1767225601000,4",
        ),
        plain("a number that stands for a missing one", "", "-2", "-9999"),
        plain("a number beyond all measure", "", "-2", "1e300"),
        mapped_csv("a name for a participant", by_column(), "who,t,f\nAnn Smith,0,1.5\n"),
        mapped_csv("a participant missing", by_column(), "who,t,f\n,0,1.5\n"),
        mapped_csv("p01 and P01", by_column(), "who,t,f\nP01,0,1.5\np01,0,2\n"),
        mapped_csv(
            "a mode that the study does not have",
            usual.replace("\"hybrid\"", "\"actve\""),
            PLAIN,
        ),
    ]
}
