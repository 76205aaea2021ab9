//! What MATLAB saves that is not an array of numbers, and what to type in MATLAB to save it
//! readably.

/// What a variable of a class of MATLAB's is, with the line that makes numbers of it; `None` where the class
/// is one of real numbers.
pub(super) fn other_class(class: &str, variable: &str) -> Option<String> {
    // As it is typed there, and the last part of it, which is the name of what is saved.
    let from = variable.replace('/', ".");
    let x = from.rsplit('.').next().unwrap_or(&from);
    let save = "save('OUT.mat', '-struct', 's', '-v7')";
    let alone = |value: &str| format!("{x} = {value}; save('OUT.mat', '{x}', '-v7')");
    let as_csv = format!("writetable(table({from}), 'OUT.csv')");
    let (what, typed) = match class {
        "double" | "single" | "logical" | "int8" | "int16" | "int32" | "int64" | "uint8"
        | "uint16" | "uint32" | "uint64" => return None,
        "table" => {
            ("a MATLAB table", format!("s = table2struct({from}, 'ToScalar', true); {save}"))
        }
        "timetable" => (
            "a MATLAB timetable",
            format!(
                "T = timetable2table({from}); T.(1) = seconds(T.(1) - T.(1)(1)); s = table2struct(T, 'ToScalar', true); {save}"
            ),
        ),
        "timeseries" => (
            "a MATLAB timeseries",
            format!("s = struct('time', {from}.Time, 'data', {from}.Data); {save}"),
        ),
        "datetime" => ("a MATLAB datetime", alone(&format!("seconds({from} - {from}(1))"))),
        "duration" => ("a MATLAB duration", alone(&format!("seconds({from})"))),
        "sparse" => ("a sparse matrix", alone(&format!("full({from})"))),
        "cell" => ("a cell array", alone(&format!("cell2mat({from})"))),
        "string" => ("an array of strings", as_csv),
        "categorical" => ("a categorical array", as_csv),
        "char" => ("text", as_csv),
        "struct" => return Some("a struct; name its fields by their path".to_owned()),
        "function_handle" => {
            return Some("a function handle, which has no values; save what it returns".to_owned());
        }
        _ => {
            let class = super::spelling::shown(class);
            return Some(format!(
                "an object of the class {class}; in MATLAB, save what is wanted of it as numeric variables"
            ));
        }
    };
    Some(format!("{what}; in MATLAB, type {typed}"))
}

/// Whether what [`other_class`] says is of an object, which may have columns of its own.
pub(super) fn is_object(class: &str) -> bool {
    class.starts_with("a MATLAB") || class.starts_with("an object")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_numbers_and_the_rest_has_its_name_and_a_line() {
        assert_eq!(other_class("double", "x"), None);
        for (class, words) in [
            ("table", "a MATLAB table; in MATLAB, type s = table2struct(rig.x, 'ToScalar', true)"),
            ("datetime", "x = seconds(rig.x - rig.x(1))"),
            ("function_handle", "a function handle"),
            ("Simulink.SimulationData.Dataset", "an object of the class Simulink."),
        ] {
            let found = other_class(class, "rig/x").unwrap();
            assert!(found.contains(words), "{found}");
        }
    }
}
