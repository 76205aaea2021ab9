//! Mappings and commands, and files of other kinds.

use super::super::feather::tests as feather;
use super::super::hdf5;
use super::super::workbook::tests as workbook;
use super::super::world::{FORCE, ONE, trials_map};
use super::super::xdf::tests as xdf;
use super::Becomes::{Flagged, Read, Refused};
use super::{PLAIN, Row, file, mapped};
use arrow::array::{ArrayRef, Float64Array, RecordBatch, StructArray};
use std::sync::Arc;

/// Mappings and commands.
pub(super) fn mappings() -> Vec<Row> {
    let usual = trials_map(&[ONE, FORCE]);

    let again = |what, said, is_twice, second: &str| Row {
        what,
        becomes: Refused,
        said,
        map: usual.clone(),
        files: vec![("a.csv", PLAIN.into()), ("b.csv", second.into())],
        is_twice,
    };
    vec![
        mapped(
            "a key that there is not",
            (Refused, "unknown field `delimeter`"),
            trials_map(&["[file]\ndelimeter = \";\"\n", ONE, FORCE]),
            "a.csv",
            PLAIN,
        ),
        mapped(
            "a unit that there is not",
            (Refused, "the unit 'Newtons' is unknown; use one of N, mN"),
            usual.replace("\"N\"", "\"Newtons\""),
            "a.csv",
            PLAIN,
        ),
        mapped(
            "a unit that does not fit",
            (Refused, "the unit 'mV' does not fit force_ex_n"),
            usual.replace("\"N\"", "\"mV\""),
            "a.csv",
            PLAIN,
        ),
        mapped(
            "a pattern that the path does not match",
            (Refused, "the path does not match the pattern"),
            usual.clone() + "[name]\npattern = 'P\\d+/(?<mode>[a-z]+)\\.csv$'\n",
            "a.csv",
            PLAIN,
        ),
        mapped(
            "a sheet of a file that has none",
            (Refused, "'data' is named, and a CSV has no parts"),
            trials_map(&["[file]\nsheet = \"data\"\n", ONE, FORCE]),
            "a.csv",
            PLAIN,
        ),
        again("a file given twice under two names", "the recording is given twice", false, PLAIN),
        again("two trials of one number", "duplicate trial", true, "t,f\n0,2\n1,2\n"),
        Row {
            what: "a file that was imported before, as somebody else's",
            becomes: Refused,
            said: "this recording was imported before",
            map: usual.replace("\"P01\"", "{ name = \"who\" }")
                + "[name]\npattern = '(?<who>P\\d+)\\.csv$'\n",
            files: vec![("P01.csv", PLAIN.into()), ("P02.csv", PLAIN.into())],
            is_twice: true,
        },
    ]
}

/// Files of other kinds.
pub(super) fn kinds() -> Vec<Row> {
    let book = workbook::xlsx(&[("data", WORKBOOK)]);
    let two = workbook::xlsx(&[("first", WORKBOOK), ("second", WORKBOOK)]);
    let formula = workbook::xlsx(&[("data", &WORKBOOK.replace("<v>-2</v>", "<f>B2*2</f>"))]);
    let wrong =
        workbook::xlsx(&[("data", &WORKBOOK.replace("<c><v>-2</v>", "<c t=\"e\"><v>#DIV/0!</v>"))]);
    let hdf5 = hdf5::tests::written(b"");
    let mat = hdf5::tests::written(b"MATLAB 7.3 MAT-file, Platform: GLNXA64");
    let from_hdf5 = trials_map(&[ONE, &FORCE.replace("\"f\"", "\"rig/f\"")]);
    let cut_hdf5 = hdf5[..hdf5.len() / 2].to_vec();
    let inner: ArrayRef = Arc::new(Float64Array::from(vec![1.5, -2.0, 4.0]));
    let nested = StructArray::from(vec![(
        Arc::new(arrow::datatypes::Field::new("x", inner.data_type().clone(), true)),
        inner.clone(),
    )]);
    let t: ArrayRef = Arc::new(Float64Array::from(vec![0.0, 0.5, 1.0]));
    let columns = |f: ArrayRef| RecordBatch::try_from_iter([("t", t.clone()), ("f", f)]).unwrap();
    let nested = crate::parquet::tests::encode(&columns(Arc::new(nested)));
    let stream = xdf::parts();
    let force = FORCE.replace("from = \"t\"", "from = \"time_s\"").replace("\"f\"", "\"F & x\"");
    let from_xdf = |keys: &str| trials_map(&[&format!("[file]\n{keys}\n"), ONE, &force]);
    vec![
        file("an Excel workbook", (Read, ""), "", "a.xlsx", &book),
        file(
            "an Excel workbook called .csv",
            (Refused, "a packed file: an .xlsx or .ods workbook, or a ZIP; set format = \"xlsx\""),
            "",
            "a.csv",
            &book,
        ),
        file(
            "a CSV called .xlsx",
            (Refused, "not a workbook: it does not begin as an .xlsx or .ods does"),
            "",
            "a.xlsx",
            PLAIN,
        ),
        file(
            "a workbook of two sheets",
            (Refused, "2 sheets have values; the file has first, second; set sheet in [file]"),
            "",
            "a.xlsx",
            two,
        ),
        file(
            "a formula that was never calculated",
            (Refused, "'=B2*2' is not a number"),
            "",
            "a.xlsx",
            formula,
        ),
        file(
            "a division by zero in a workbook",
            (Refused, "'#DIV/0!' is not a number"),
            "",
            "a.xlsx",
            wrong,
        ),
        file(
            "an old workbook (.xls), or a locked one",
            (Refused, "an old Excel workbook (.xls), or one that a password locks"),
            "",
            "a.xlsx",
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        ),
        file("a ZIP", (Refused, "the extension 'zip' names no known format"), "", "a.zip", &book),
        file(
            "a CSV packed with gzip",
            (Refused, "compressed with gzip; unpack it with gunzip"),
            "",
            "a.csv.gz",
            b"\x1f\x8b\x08\0\0\0\0\0",
        ),
        mapped("HDF5", (Read, ""), from_hdf5.clone(), "a.h5", hdf5),
        mapped(
            "an HDF5 file with soft links, one of them named",
            (Read, ""),
            from_hdf5.replace("rig/f", "again"),
            "a.h5",
            hdf5::tests::with_links(),
        ),
        mapped(
            "an HDF5 file whose link leads to nothing",
            (Refused, "it is a link to 'nothing/there', which is no data set of the file"),
            from_hdf5.replace("rig/f", "gone"),
            "a.h5",
            hdf5::tests::with_links(),
        ),
        mapped(
            "an HDF5 file that is cut off",
            (Refused, "save it from MATLAB with -v7, or convert it: python -c"),
            from_hdf5.clone(),
            "a.h5",
            cut_hdf5,
        ),
        mapped("a MAT file of version 7.3", (Read, ""), from_hdf5, "a.mat", mat),
        file(
            "a Python pickle",
            (Refused, "a Python pickle; where it was made, write it as CSV"),
            "",
            "a.pkl",
            b"\x80\x04\x95\0",
        ),
        file(
            "a Parquet file of nested columns",
            (Refused, "is neither number nor text"),
            "",
            "a.parquet",
            nested,
        ),
        file(
            "a Parquet file called .csv",
            (Refused, "a Parquet file; set format = \"parquet\""),
            "",
            "a.csv",
            crate::parquet::tests::encode(&columns(inner.clone())),
        ),
        file(
            "an Arrow or Feather file",
            (Read, ""),
            "",
            "a.feather",
            feather::encode(&[columns(inner)]),
        ),
        file(
            "an Arrow stream",
            (Refused, "an Arrow stream, which is not the file format; convert it: python -c"),
            "",
            "a.arrow",
            [0xff; 16],
        ),
        file(
            "JSON that is no lines",
            (Refused, "one JSON array, and not JSON lines"),
            "",
            "a.json",
            "[{\"t\":0,\"f\":1}]",
        ),
        file(
            "NumPy's array of Python objects",
            (Refused, "it holds Python objects"),
            "",
            "a.npy",
            OBJECTS,
        ),
        mapped(
            "an XDF file of two streams",
            (Refused, "2 streams have samples: 1 'rig', 7 'marks'; set stream in [file]"),
            from_xdf(""),
            "a.xdf",
            stream.concat(),
        ),
        mapped(
            "an XDF file that is cut off",
            (Flagged, "1 samples of damaged chunks are lost"),
            from_xdf("stream = \"rig\""),
            "a.xdf",
            &stream.concat()[..stream[..5].concat().len() - 1],
        ),
    ]
}

/// [`PLAIN`] as rows of a sheet.
const WORKBOOK: &str = "<row><c t=\"s\"><v>0</v></c><c t=\"inlineStr\"><is><t>f</t></is></c></row><row><c><v>0</v></c><c><v>1.5</v></c></row>\
    <row><c><v>0.5</v></c><c><v>-2</v></c></row><row><c><v>1</v></c><c><v>4</v></c></row>";

const OBJECTS: &[u8] =
    b"\x93NUMPY\x01\x00\x3b\x00{'descr': '|O', 'fortran_order': False, 'shape': (3,), }    \n";
