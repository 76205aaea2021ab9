//! How text is written, and what its cells contain.

use super::super::world::{FORCE, ONE, trials_map};
use super::Becomes::{Flagged, Read, Refused};
use super::{PLAIN, Row, file, mapped, plain};

/// How text is written.
pub(super) fn texts() -> Vec<Row> {
    let utf_16: Vec<u8> =
        format!("\u{feff}{PLAIN}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    let german = "t;f\n0;1,5\n0,5;-2\n1;4\n";
    let latin = b"t,f,gr\xf6\xdfe\n0,1.5,1\n0.5,-2,1\n1,4,1\n";
    let comma = "delimiter = \";\"\ndecimal = \",\"";
    vec![
        file(
            "a byte-order mark and Windows line ends",
            (Read, ""),
            "",
            "a.csv",
            format!("\u{feff}{}", PLAIN.replace('\n', "\r\n")),
        ),
        file("UTF-16, as Excel calls Unicode text", (Read, ""), "", "a.csv", utf_16),
        file(
            "Latin-1, not said",
            (Refused, "line 1 is not UTF-8 text; set encoding = \"latin-1\""),
            "",
            "a.csv",
            latin,
        ),
        file("Latin-1, said", (Read, ""), "encoding = \"latin-1\"", "a.csv", latin),
        file("semicolons and decimal commas, said", (Read, ""), comma, "a.csv", german),
        file(
            "semicolons, not said",
            (
                Refused,
                "line 4 has 1 cells where 2 belong; the file may be cut off or its delimiter another",
            ),
            "",
            "a.csv",
            german,
        ),
        file(
            "decimal commas, not said",
            (Refused, "'1,5' is not a number with '.' before its decimals"),
            "delimiter = \";\"",
            "a.csv",
            german,
        ),
        file(
            "tabs in a .csv, not said",
            (Refused, "column t: the column is missing"),
            "",
            "a.csv",
            PLAIN.replace(',', "\t"),
        ),
        file(
            "columns apart by blanks in a .txt",
            (Flagged, "cells are taken to stand between any blanks"),
            "",
            "a.txt",
            PLAIN.replace(',', "   "),
        ),
        plain(
            "thousands separators",
            (Refused, "'1,234.5' is not a number with '.' before its decimals"),
            "",
            "1.5",
            "\"1,234.5\"",
        ),
        plain(
            "a minus sign from a word processor",
            (Refused, "'−2' is not a number"),
            "",
            "-2",
            "−2",
        ),
        file(
            "a header one cell short, as R writes row names",
            (
                Flagged,
                "the header is one cell short: the first column is taken for one without a name",
            ),
            "",
            "a.csv",
            "t,f\na,0,1.5\nb,0.5,-2\nc,1,4\n",
        ),
        file(
            "a delimiter at the end of each line but the header",
            (Flagged, "the header is one cell short: lines end in a delimiter"),
            "",
            "a.csv",
            "t,f\n0,1.5,\n0.5,-2,\n1,4,\n",
        ),
        file(
            "a delimiter at the end of every line",
            (Read, ""),
            "",
            "a.csv",
            PLAIN.replace('\n', ",\n"),
        ),
        file(
            "a line of units below the header",
            (Refused, "'s' is not a number"),
            "",
            "a.csv",
            PLAIN.replace("t,f\n", "t,f\ns,N\n"),
        ),
        file(
            "a line of units, passed by",
            (Flagged, "'s' is not a number (line 2) (bad_lines)"),
            "bad_lines = 1",
            "a.csv",
            PLAIN.replace("t,f\n", "t,f\ns,N\n"),
        ),
        file(
            "lines before the header",
            (Refused, "the column is missing; the file has Rig 2"),
            "",
            "a.csv",
            format!("Rig 2\n2026-01-01\n{}", PLAIN.replace(',', ";")),
        ),
        file(
            "lines before the header, said",
            (Read, ""),
            "skip = 1",
            "a.csv",
            format!("Rig 2, upstairs\n{PLAIN}"),
        ),
        file(
            "remarks behind #, said",
            (Read, ""),
            "comment = \"#\"",
            "a.csv",
            format!("# upstairs\n{PLAIN}"),
        ),
        file("blank lines", (Flagged, "2 rows: empty"), "", "a.csv", PLAIN.replace('\n', "\n\n")),
        file("blank lines at the end", (Read, ""), "", "a.csv", PLAIN.to_owned() + "\n,\n\n"),
        mapped(
            "blank lines, where samples come at a rate",
            (
                Flagged,
                "2 rows: empty: within a trial no sample stands there, and later samples keep their time",
            ),
            trials_map(&[ONE, &FORCE.replace("from = \"t\"\nunit = \"s\"", "rate_hz = 2.0")]),
            "a.csv",
            PLAIN.replace('\n', "\n\n"),
        ),
        file(
            "no header, not said",
            (Refused, "column t: the column is missing"),
            "",
            "a.csv",
            PLAIN.replace("t,f\n", ""),
        ),
        file(
            "a line cut off",
            (Refused, "line 4 has 1 cells where 2 belong"),
            "",
            "a.csv",
            PLAIN.replace("1,4\n", "1"),
        ),
        file(
            "an empty file",
            (Refused, "the file is empty; leave it out of the import"),
            "",
            "a.csv",
            "",
        ),
        file("a header alone", (Refused, "the file has 0 rows"), "", "a.csv", "t,f\n"),
        file(
            "one row alone",
            (Flagged, "it has one sample: nothing can be computed from it"),
            "",
            "a.csv",
            "t,f\n0,1.5\n",
        ),
    ]
}

/// What stands in cells.
pub(super) fn cells() -> Vec<Row> {
    let map = |participant: &str| trials_map(&[&ONE.replace("\"P01\"", participant), FORCE]);
    vec![
        plain(
            "a column by another name",
            (Refused, "column t: the column is missing; the file has time, f"),
            "",
            "t,f",
            "time,f",
        ),
        plain(
            "two columns of one name",
            (Refused, "columns 2 and 3 have the same header; rename one of them"),
            "",
            "t,f\n0,1.5\n0.5,-2\n1,4\n",
            "t,f,f\n0,1,2\n",
        ),
        plain("n/a for a missing value", (Refused, "'n/a' is not a number"), "", "-2", "n/a"),
        plain("an empty cell", (Refused, "the cell is empty"), "", "-2", ""),
        plain("NaN", (Refused, "NaN is not a number"), "", "-2", "NaN"),
        plain(
            "NaN, left out",
            (Flagged, "a mapped cell is empty or NaN (missing = \"drop\")"),
            "missing = \"drop\"",
            "-2",
            "NaN",
        ),
        plain("an infinity", (Refused, "'inf' is not a finite number"), "", "-2", "inf"),
        plain("true and false for a number", (Refused, "'TRUE' is not a number"), "", "-2", "TRUE"),
        plain(
            "a date for one of the times",
            (Refused, "'0.5' is not a time as the first row has it"),
            "",
            "\n0,",
            "\n2026-01-01 10:00:00,",
        ),
        plain(
            "a time that starts over",
            (Refused, "time runs backwards or stands still"),
            "",
            "\n1,4",
            "\n0,4",
        ),
        plain(
            "a time that starts over, said",
            (Flagged, "trial 2"),
            "split = \"time\"",
            "\n1,4",
            "\n0,4",
        ),
        plain(
            "a time of too few digits, so that two samples have one",
            (Refused, "time runs backwards or stands still"),
            "",
            "0.5",
            "0",
        ),
        plain(
            "milliseconds since 1970 taken for seconds",
            (Refused, "is past 100000000000 s"),
            "",
            "\n0,1.5\n0.5,-2\n1,4",
            "\n1767225600000,1.5\n1767225600500,-2\n1767225601000,4",
        ),
        plain(
            "a number that stands for a missing one",
            (Flagged, "-9.999e3 N is more than a person weighs"),
            "",
            "-2",
            "-9999",
        ),
        plain(
            "a number beyond all measure",
            (Flagged, "1e300 N is more than a person weighs"),
            "",
            "-2",
            "1e300",
        ),
        mapped(
            "a name for a participant",
            (Refused, "'Ann Smith' is not a valid participant id"),
            map("{ column = \"who\" }"),
            "a.csv",
            "who,t,f\nAnn Smith,0,1.5\n",
        ),
        mapped(
            "a participant missing",
            (Refused, "there is no participant (line 2)"),
            map("{ column = \"who\" }"),
            "a.csv",
            "who,t,f\n,0,1.5\n",
        ),
        mapped(
            "p01 and P01",
            (Refused, "differs only by case"),
            map("{ column = \"who\" }"),
            "a.csv",
            "who,t,f\nP01,0,1.5\np01,0,2\n",
        ),
        mapped(
            "a mode that the study does not have",
            (Refused, "mode 'actve' is not in study.toml"),
            map("\"P01\"").replace("\"hybrid\"", "\"actve\""),
            "a.csv",
            PLAIN,
        ),
    ]
}
