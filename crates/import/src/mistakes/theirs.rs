//! Mappings and commands, and files of other kinds.

use super::super::feather::tests as feather;
use super::super::hdf5;
use super::super::workbook::tests as workbook;
use super::super::world::{FORCE, ONE, trials_map};
use super::super::xdf::tests as xdf;
use super::{PLAIN, Row, csv, file, mapped, mapped_csv};
use arrow::array::{ArrayRef, Float64Array, RecordBatch, StructArray};
use std::sync::Arc;

/// Mappings and commands.
pub(super) fn mappings() -> Vec<Row> {
    let usual = trials_map(&[ONE, FORCE]);
    let again = |what, is_twice, second: &str| Row {
        what,
        map: usual.clone(),
        files: vec![("a.csv", PLAIN.into()), ("b.csv", second.into())],
        is_twice,
        has_axes: false,
    };
    vec![
        mapped_csv(
            "a key that there is not",
            trials_map(&["[file]\ndelimeter = \";\"\n", ONE, FORCE]),
            PLAIN,
        ),
        mapped_csv("a unit that there is not", usual.replace("\"N\"", "\"Newtons\""), PLAIN),
        mapped_csv("a unit that does not fit", usual.replace("\"N\"", "\"mV\""), PLAIN),
        mapped_csv(
            "a pattern that the path does not match",
            usual.clone() + "[name]\npattern = 'P\\d+/(?<mode>[a-z]+)\\.csv$'\n",
            PLAIN,
        ),
        mapped_csv(
            "a sheet of a file that has none",
            trials_map(&["[file]\nsheet = \"data\"\n", ONE, FORCE]),
            PLAIN,
        ),
        again("a file given twice under two names", false, PLAIN),
        again("two trials of one number", true, "t,f\n0,2\n1,2\n"),
        Row {
            what: "a file that was imported before, as somebody else's",
            map: usual.replace("\"P01\"", "{ name = \"who\" }")
                + "[name]\npattern = '(?<who>P\\d+)\\.csv$'\n",
            files: vec![("P01.csv", PLAIN.into()), ("P02.csv", PLAIN.into())],
            is_twice: true,
            has_axes: false,
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
        file("an Excel workbook", "a.xlsx", &book),
        csv("an Excel workbook called .csv", "", &book),
        file("a CSV called .xlsx", "a.xlsx", PLAIN),
        file("a workbook of two sheets", "a.xlsx", two),
        file("a formula that was never calculated", "a.xlsx", formula),
        file("a division by zero in a workbook", "a.xlsx", wrong),
        file(
            "an old workbook (.xls), or a locked one",
            "a.xlsx",
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        ),
        file("a ZIP", "a.zip", &book),
        file("a CSV packed with gzip", "a.csv.gz", b"\x1f\x8b\x08\0\0\0\0\0"),
        mapped("HDF5", from_hdf5.clone(), "a.h5", hdf5),
        mapped(
            "an HDF5 file with soft links, one of them named",
            from_hdf5.replace("rig/f", "again"),
            "a.h5",
            hdf5::tests::with_links(),
        ),
        mapped(
            "an HDF5 file whose link leads to nothing",
            from_hdf5.replace("rig/f", "gone"),
            "a.h5",
            hdf5::tests::with_links(),
        ),
        mapped("an HDF5 file that is cut off", from_hdf5.clone(), "a.h5", cut_hdf5),
        mapped("a MAT file of version 7.3", from_hdf5, "a.mat", mat),
        file("a Python pickle", "a.pkl", b"\x80\x04\x95\0"),
        file("a Parquet file of nested columns", "a.parquet", nested),
        csv(
            "a Parquet file called .csv",
            "",
            crate::parquet::tests::encode(&columns(inner.clone())),
        ),
        file("an Arrow or Feather file", "a.feather", feather::encode(&[columns(inner)])),
        file("an Arrow stream", "a.arrow", [0xff; 16]),
        file("JSON that is no lines", "a.json", "[{\"t\":0,\"f\":1}]"),
        file("NumPy's array of Python objects", "a.npy", OBJECTS),
        mapped("an XDF file of two streams", from_xdf(""), "a.xdf", stream.concat()),
        mapped(
            "an XDF file that is cut off",
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
