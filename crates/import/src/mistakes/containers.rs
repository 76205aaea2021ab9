//! Files in the field's container formats: packed numbers, times of their own type, structures,
//! objects.

use super::super::feather::tests as feather;
use super::super::hdf5::tests as hdf5;
use super::super::mat::tests as mat;
use super::super::parquet::tests as parquet;
use super::super::world::{FORCE, ONE, trials_map};
use super::super::xdf::tests as xdf;
use super::{PLAIN, Row, mapped, mapped_csv};
use arrow::array::{
    ArrayRef, DurationMicrosecondArray, Float64Array, RecordBatch, Time64MicrosecondArray,
    TimestampNanosecondArray,
};
use hdf5_pure::{AttrValue, FileBuilder};
use std::sync::Arc;

/// HDF5 of the usual times, and forces as whole numbers with these attributes.
fn packed(what: &'static str, stored: &[i16], attributes: &[(&str, AttrValue)]) -> Row {
    let mut file = FileBuilder::new();
    file.create_dataset("t").with_f64_data(&[0.0, 0.5, 1.0]).with_shape(&[3]);
    let force = file.create_dataset("f").with_i16_data(stored).with_shape(&[3]);
    for (name, value) in attributes {
        force.set_attr(name, value.clone());
    }
    mapped(what, trials_map(&[ONE, FORCE]), "a.h5", file.finish().unwrap())
}

/// HDF5 with a matrix of this shape.
fn matrix(shape: &[u64], values: &[f64]) -> Vec<u8> {
    let mut file = FileBuilder::new();
    file.create_dataset("ans").with_f64_data(values).with_shape(shape);
    file.finish().unwrap()
}

/// Columns of these times and the usual forces.
fn timed(times: ArrayRef) -> RecordBatch {
    let forces: ArrayRef = Arc::new(Float64Array::from(vec![1.5, -2.0, 4.0]));
    RecordBatch::try_from_iter([("t", times), ("f", forces)]).unwrap()
}

pub(super) fn containers() -> Vec<Row> {
    let usual = trials_map(&[ONE, FORCE]);
    let in_unit = |unit: &str| usual.replace("unit = \"s\"", &format!("unit = \"{unit}\""));
    let renamed = |time: &str, force: &str| {
        usual.replace("\"t\"", &format!("\"{time}\"")).replace("\"f\"", &format!("\"{force}\""))
    };
    let simout = renamed("simout.time", "simout.signals.values(2)");
    let hundredths = ("scale_factor", AttrValue::F64(0.01));
    let from_xdf = |unit: &str| {
        let force = FORCE.replace("\"t\"", "\"time_s\"").replace("\"f\"", "\"load\"");
        let force = force.replace("\"N\"", &format!("\"{unit}\""));
        trials_map(&[ONE, &force.replace("unit = \"s\"", "unit = \"s\"\nzero = \"first\"")])
    };
    let in_newtons = || {
        let channel = "<channel><label>load</label><unit>newtons</unit></channel>";
        let times = (0..300).map(|i| 0.01 * f64::from(i));
        xdf::steady_of(channel, times, &[(0.0, 5.0), (1.0, 5.0), (2.0, 5.0)])
    };
    let values: Vec<f64> = (0..375).map(f64::from).collect();
    let by_place = FORCE.replace("\"t\"", "1").replace("\"f\"", "2");
    let durations: ArrayRef = Arc::new(DurationMicrosecondArray::from(vec![0, 500_000, 1_000_000]));
    let noon = 12 * 3_600_000_000_i64;
    let of_day = [0, 500_000, 1_000_000].map(|us| noon + us);
    let of_day: ArrayRef = Arc::new(Time64MicrosecondArray::from(of_day.to_vec()));
    let epoch = 1_700_000_000_123_456_789_i64;
    let moments = [0, 500_000_000, 1_000_000_000].map(|ns| epoch + ns);
    let moments: ArrayRef = Arc::new(TimestampNanosecondArray::from(moments.to_vec()));
    let from_first =
        |unit: &str| usual.replace("unit = \"s\"", &format!("unit = \"{unit}\"\nzero = \"first\""));
    vec![
        packed(
            "HDF5 of whole numbers with a scale_factor",
            &[150, -200, 400],
            std::slice::from_ref(&hundredths),
        ),
        packed(
            "NWB with conversion and offset",
            &[5, -2, 10],
            &[("conversion", AttrValue::F32(0.5)), ("offset", AttrValue::I32(-1))],
        ),
        packed(
            "HDF5 whose scale_factor is a text",
            &[150, -200, 400],
            &[("scale_factor", AttrValue::String("0.01".to_owned()))],
        ),
        packed(
            "HDF5 with scale_factor and conversion",
            &[150, -200, 400],
            &[hundredths, ("conversion", AttrValue::F64(0.5))],
        ),
        packed(
            "HDF5 with a number that stands for a missing one",
            &[150, -999, 400],
            &[("_FillValue", AttrValue::I16(-999))],
        ),
        packed(
            "HDF5 whose unit is not that of the mapping",
            &[150, -200, 400],
            &[("units", AttrValue::String("millinewtons".to_owned()))],
        ),
        mapped(
            "durations of pandas in Parquet",
            in_unit("us"),
            "a.parquet",
            parquet::encode(&timed(durations.clone())),
        ),
        mapped(
            "durations in Parquet, in another unit",
            usual.clone(),
            "a.parquet",
            parquet::encode(&timed(durations.clone())),
        ),
        mapped(
            "durations in an Arrow file",
            in_unit("us"),
            "a.arrow",
            feather::encode(&[timed(durations)]),
        ),
        mapped(
            "times of day in Parquet",
            from_first("us"),
            "a.parquet",
            parquet::encode(&timed(of_day)),
        ),
        mapped(
            "moments to a nanosecond in Parquet",
            from_first("ns"),
            "a.parquet",
            parquet::encode(&timed(moments.clone())),
        ),
        mapped(
            "moments to a nanosecond in an Arrow file",
            from_first("ns"),
            "a.arrow",
            feather::encode(&[timed(moments)]),
        ),
        mapped("a structure with time of Simulink", simout.clone(), "a.mat", mat::simulink()),
        mapped(
            "structures of Simulink in an array",
            renamed("scope.time", "scope.signals(2).values"),
            "a.mat",
            mat::simulink(),
        ),
        mapped(
            "a structure with time, saved with -v7.3",
            simout.clone(),
            "a.mat",
            hdf5::matlab_7_3(),
        ),
        mapped(
            "a MAT file of version 7.3 without its first text",
            simout,
            "a.mat",
            &hdf5::matlab_7_3()[512..],
        ),
        mapped(
            "an XDF channel whose unit is that of the mapping, in words",
            from_xdf("N"),
            "a.xdf",
            in_newtons(),
        ),
        mapped(
            "an XDF channel whose unit is not that of the mapping",
            from_xdf("mN"),
            "a.xdf",
            in_newtons(),
        ),
        mapped(
            "times of XDF taken for milliseconds",
            from_xdf("N").replace("unit = \"s\"", "unit = \"ms\""),
            "a.xdf",
            in_newtons(),
        ),
        mapped(
            "a matrix whose rows are the signals",
            trials_map(&["[file]\nmatrix = \"ans\"\n", ONE, &by_place]),
            "a.h5",
            matrix(&[3, 125], &values),
        ),
        mapped(
            "a matrix whose rows are the signals, said",
            trials_map(&["[file]\nmatrix = \"ans\"\nsignals = \"rows\"\n", ONE, &by_place]),
            "a.h5",
            matrix(&[2, 3], &[0.0, 0.5, 1.0, 1.5, -2.0, 4.0]),
        ),
        mapped_csv(
            "columns of a text that are said to be rows of a matrix",
            trials_map(&["[file]\nsignals = \"rows\"\n", ONE, FORCE]),
            PLAIN,
        ),
        mapped("a range of Octave", renamed("t/value", "f/value(2)"), "a.h5", hdf5::octave()),
        mapped(
            "a table of HDF5 of several fields",
            renamed("data/t", "data"),
            "a.h5",
            hdf5::compound(),
        ),
        mapped("a MATLAB table", usual.clone(), "a.mat", mat::object("table")),
        mapped("a MATLAB timetable", usual.clone(), "a.mat", mat::object("timetable")),
        mapped("a MATLAB table, saved with -v7.3", usual.clone(), "a.mat", hdf5::matlab_7_3()),
    ]
}
