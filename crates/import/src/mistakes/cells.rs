//! Cells as other programs write them: missing values, numbers, truth values, ids.

use super::super::world::{FORCE, ONE, trials_map};
use super::{LIKERT, PLAIN, Row, csv, file, mapped_csv, plain};

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
        plain("`None` for a missing value", "", "-2", "None"),
        plain(
            "a missing value as R, Excel or C write it, to be left out",
            "missing = \"drop\"",
            "-2",
            "-nan(ind)",
        ),
        plain(
            "a number for a missing value, said",
            "missing = \"drop\"\nmissing_words = [\"-2\"]",
            "-2",
            "-2.0",
        ),
        csv("quotes of Windows-1252, not said", "", quotes),
        csv("quotes of Windows-1252, called Latin-1", "encoding = \"latin-1\"", quotes),
        csv("quotes of Windows-1252, said", "encoding = \"windows-1252\"", quotes),
        mapped_csv(
            "a participant called as a missing value",
            with("\"P01\"", "who", ""),
            column("who", "NA"),
        ),
        mapped_csv(
            "whole numbers that pandas made decimal ones",
            with("\"P01\"", "who", ", prefix = \"P\", digits = 2"),
            column("who", "1.0"),
        ),
        mapped_csv(
            "`True` and `TRUE` for one mode",
            with("\"hybrid\"", "on", ", translate = { true = \"active\" }"),
            column("on", "TRUE").replacen("TRUE", "True", 1),
        ),
        mapped_csv(
            "trials counted from 0",
            trials_map(&[ONE, "trial = { column = \"n\" }\n", FORCE]),
            column("n", "0"),
        ),
        mapped_csv(
            "a UUID as the id of a session",
            with("\"S01\"", "run", ""),
            column("run", "5bc8fbbc-bde5-4099-8164-d8399f767c45"),
        ),
        mapped_csv(
            "two conditions in a row of a table of answers",
            TWO.to_owned(),
            "who,m1,q1,m2,q2\nP01,active,5,passive,3\n",
        ),
        mapped_csv(
            "answers as JSON in a cell, counted from 0",
            LIKERT
                .replace("\"q\"", "{ column = \"q\", key = \"Q0\" }")
                .replace("[questions.", "[questions]\nlowest = 0\n[questions."),
            "who,mode,q\nP01,active,\"{\"\"Q0\"\":4}\"\n",
        ),
        mapped_csv(
            "a header that comes again in a table of answers",
            LIKERT.to_owned(),
            "who,mode,q\nP01,active,5\nwho,mode,q\nP02,active,4\n",
        ),
        file(
            "a MAT file of version 4",
            "a.mat",
            b"\0\0\0\0\x03\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0t\0",
        ),
    ]
}

/// A mapping of a table with two conditions in a row.
const TWO: &str = "kind = \"likert\"\n[trial]\nparticipant = { column = \"who\" }\nsession = \"S01\"\nenvironment = \"spring\"\n\
                   [[condition]]\nmode = { column = \"m1\" }\ncolumns = { felt_spring = \"q1\" }\n\
                   [[condition]]\nmode = { column = \"m2\" }\ncolumns = { felt_spring = \"q2\" }\n";
