//! Cells as other programs write them: missing values, numbers, truth values, ids.

use super::super::world::{FORCE, ONE, trials_map};
use super::Becomes::{Flagged, Read, Refused};
use super::{PLAIN, Row, file, mapped, plain};

/// Cells as other programs write them.
pub(super) fn cells_of_others() -> Vec<Row> {
    let with = |key: &str, column: &str, keys: &str| {
        let label = format!("{{ column = \"{column}\"{keys} }}");
        trials_map(&[&ONE.replace(key, &label), FORCE])
    };
    let column = |name: &str, cell: &str| {
        let mut lines = PLAIN.lines();
        let header = lines.next().unwrap_or_default();
        let rows: String = lines.map(|line| format!("{line},{cell}\n")).collect();
        format!("{header},{name}\n{rows}")
    };
    let quotes = b"t,f,the lever\x92s\n0,1.5,1\n0.5,-2,1\n1,4,1\n";
    vec![
        plain(
            "`None` for a missing value",
            (Refused, "'None' is not a number, and stands for a missing value"),
            "",
            "-2",
            "None",
        ),
        plain(
            "a missing value as R, Excel or C write it, to be left out",
            (Flagged, "a mapped cell is empty or NaN (missing = \"drop\")"),
            "missing = \"drop\"",
            "-2",
            "-nan(ind)",
        ),
        plain(
            "a number for a missing value, said",
            (Flagged, "a mapped cell is empty or NaN (missing = \"drop\")"),
            "missing = \"drop\"\nmissing_words = [\"-2\"]",
            "-2",
            "-2.0",
        ),
        file(
            "quotes of Windows-1252, not said",
            (Refused, "line 1 is not UTF-8 text; set encoding = \"windows-1252\""),
            "",
            "a.csv",
            quotes,
        ),
        file(
            "quotes of Windows-1252, called Latin-1",
            (Flagged, "it is read as Windows-1252: as Latin-1 it has control characters"),
            "encoding = \"latin-1\"",
            "a.csv",
            quotes,
        ),
        file(
            "quotes of Windows-1252, said",
            (Read, ""),
            "encoding = \"windows-1252\"",
            "a.csv",
            quotes,
        ),
        mapped(
            "a participant called as a missing value",
            (Flagged, "participant 'NA': this also stands for a missing value"),
            with("\"P01\"", "who", ""),
            "a.csv",
            column("who", "NA"),
        ),
        mapped(
            "whole numbers that pandas made decimal ones",
            (Read, ""),
            with("\"P01\"", "who", ", prefix = \"P\", digits = 2"),
            "a.csv",
            column("who", "1.0"),
        ),
        mapped(
            "`True` and `TRUE` for one mode",
            (Read, ""),
            with("\"hybrid\"", "on", ", translate = { true = \"active\" }"),
            "a.csv",
            column("on", "TRUE").replacen("TRUE", "True", 1),
        ),
        mapped(
            "trials counted from 0",
            (Flagged, "trials are counted from 0 there, and from 1 here"),
            trials_map(&[ONE, "trial = { column = \"n\" }\n", FORCE]),
            "a.csv",
            column("n", "0"),
        ),
        mapped(
            "a UUID as the id of a session",
            (Flagged, "a session is a UUID, which is kept without its hyphens"),
            with("\"S01\"", "run", ""),
            "a.csv",
            column("run", "5bc8fbbc-bde5-4099-8164-d8399f767c45"),
        ),
        mapped(
            "two conditions in a row of a table of answers",
            (Read, "2 trials without samples, 2 answers"),
            TWO.to_owned(),
            "a.csv",
            "who,m1,q1,m2,q2\nP01,active,5,passive,3\n",
        ),
        mapped(
            "answers as JSON in a cell, counted from 0",
            (Read, "1 trials without samples, 1 answers"),
            LIKERT
                .replace("\"q\"", "{ column = \"q\", key = \"Q0\" }")
                .replace("[questions.", "[questions]\nlowest = 0\n[questions."),
            "a.csv",
            "who,mode,q\nP01,active,\"{\"\"Q0\"\":4}\"\n",
        ),
        mapped(
            "a header that comes again in a table of answers",
            (Flagged, "1 row: the header, which comes again"),
            LIKERT.to_owned(),
            "a.csv",
            "who,mode,q\nP01,active,5\nwho,mode,q\nP02,active,4\n",
        ),
        file(
            "a TDMS file",
            (Refused, "this is a TDMS file of LabVIEW"),
            "",
            "a.tdms",
            b"TDSm\x0e\0\0\0",
        ),
        file(
            "a C3D file",
            (Refused, "this is a C3D file of a motion capture system"),
            "",
            "a.c3d",
            b"\x02\x50\0\x01",
        ),
        file(
            "a MAT file of version 4",
            (Refused, "this is a MAT file of version 4; save it again with -v7"),
            "",
            "a.mat",
            b"\0\0\0\0\x03\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0t\0",
        ),
    ]
}

/// A mapping of a table with two conditions in a row.
const TWO: &str = "kind = \"likert\"\n[trial]\nparticipant = { column = \"who\" }\nsession = \"S01\"\nenvironment = \"spring\"\n\
                   [[condition]]\nmode = { column = \"m1\" }\ncolumns = { felt_spring = \"q1\" }\n\
                   [[condition]]\nmode = { column = \"m2\" }\ncolumns = { felt_spring = \"q2\" }\n";
/// A mapping of a table with a column of answers.
const LIKERT: &str = "kind = \"likert\"\n[trial]\nparticipant = { column = \"who\" }\nsession = \"S01\"\nenvironment = \"spring\"\n\
                      mode = { column = \"mode\" }\n[questions.columns]\nfelt_spring = \"q\"\n";
