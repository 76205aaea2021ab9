//! What MATLAB saves that is no array of numbers, and what to type there to save it readably.

/// What a variable of a class of MATLAB's is, with the line that makes numbers of it; `None` where the class
/// is one of real numbers.
pub(super) fn other_class(class: &str, variable: &str) -> Option<String> {
    // The last part of a path.
    let x = variable.rsplit(['/', '.']).next().unwrap_or(variable);
    let save = "save('OUT.mat', '-struct', 's', '-v7')";
    let typed = match class {
        "double" | "single" | "logical" | "int8" | "int16" | "int32" | "int64" | "uint8"
        | "uint16" | "uint32" | "uint64" => return None,
        "table" => format!("s = table2struct({x}, 'ToScalar', true); {save}"),
        "timetable" => format!(
            "T = timetable2table({x}); T.(1) = seconds(T.(1) - T.(1)(1)); s = table2struct(T, 'ToScalar', true); {save}"
        ),
        "timeseries" => format!("s = struct('time', {x}.Time, 'data', {x}.Data); {save}"),
        "datetime" => format!("{x} = seconds({x} - {x}(1)); save('OUT.mat', '{x}', '-v7')"),
        "duration" => format!("{x} = seconds({x}); save('OUT.mat', '{x}', '-v7')"),
        "sparse" => format!("{x} = full({x}); save('OUT.mat', '{x}', '-v7')"),
        "string" | "categorical" | "char" => format!("writetable(table({x}), 'OUT.csv')"),
        "cell" => format!("{x} = cell2mat({x}); save('OUT.mat', '{x}', '-v7')"),
        "struct" => return Some("a struct; name its fields by their path".to_owned()),
        "function_handle" => {
            return Some("a function handle, which has no values; save what it returns".to_owned());
        }
        _ => {
            let class = super::limits::shown(class);
            return Some(format!(
                "an object of the class {class}; in MATLAB, save what is wanted of it as numeric variables"
            ));
        }
    };
    let what = match class {
        "string" => "an array of strings",
        "categorical" => "a categorical array",
        "char" => "text",
        "cell" => "a cell array",
        "sparse" => "a sparse matrix",
        "table" => "a MATLAB table",
        "timetable" => "a MATLAB timetable",
        "timeseries" => "a MATLAB timeseries",
        "datetime" => "a MATLAB datetime",
        _ => "a MATLAB duration",
    };
    Some(format!("{what}; in MATLAB, type {typed}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_numbers_and_the_rest_has_its_name_and_a_line() {
        assert_eq!(other_class("double", "x"), None);
        for (class, words) in [
            ("table", "a MATLAB table; in MATLAB, type s = table2struct(x, 'ToScalar', true)"),
            ("datetime", "x = seconds(x - x(1))"),
            ("function_handle", "a function handle"),
            ("Simulink.SimulationData.Dataset", "an object of the class Simulink."),
        ] {
            let found = other_class(class, "rig/x").unwrap();
            assert!(found.contains(words), "{found}");
        }
    }
}
