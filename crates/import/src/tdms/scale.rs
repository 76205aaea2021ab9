//! The scales of a TDMS channel, which make quantities of counts.
//!
//! Source: National Instruments, LabVIEW Help, "TDMS Create Scaling Information"; names of properties and the
//! order of a subtraction as npTDMS 1.13 reads them.

use super::segments::{Properties, Property};

/// The scales of a channel that are followed.
const MOST_SCALES: usize = 32;
/// The coefficients of a polynomial, or the points of a table.
const MOST_POINTS: usize = 1 << 12;

/// Where a scale takes its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum From {
    Counts,
    Scale(usize),
}

#[derive(Debug, Clone, PartialEq)]
enum Scale {
    Same(From),
    /// Slope and intercept.
    Linear(From, f64, f64),
    /// The coefficient of x⁰ first.
    Polynomial(From, Vec<f64>),
    /// Points of a curve of straight lines, which goes on level at its ends.
    Table(From, Vec<(f64, f64)>),
    Sum(From, From),
    /// The first from the second.
    Difference(From, From),
}

/// Scales, each of which may take what those before it give; the last gives the quantity.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Scales(Vec<Scale>);

impl Scales {
    /// Those that properties name; none where the values are quantities as they are.
    ///
    /// # Errors
    /// A scale that is not computed here, or that makes no sense.
    pub(super) fn of(properties: &Properties) -> Result<Self, String> {
        if properties.get("NI_Scaling_Status") == Some(&Property::Text("scaled".to_owned())) {
            return Ok(Self::default());
        }
        let named = (0..=MOST_SCALES).rev();
        let last = named.into_iter().find(|i| properties.contains_key(&key(*i, "Scale_Type")));
        let count = match properties.get("NI_Number_Of_Scales") {
            Some(Property::Number(count)) => *count as usize,
            _ => last.map_or(0, |last| last + 1),
        };
        if count > MOST_SCALES {
            return Err(format!("it has {count} scales, and at most {MOST_SCALES} are followed"));
        }
        let scales = (0..count).map(|i| scale(properties, i));
        Ok(Self(scales.collect::<Result<_, _>>()?))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The quantity of a count.
    pub(super) fn apply(&self, count: f64) -> f64 {
        let mut given = [count; MOST_SCALES];
        for (i, scale) in self.0.iter().enumerate() {
            let from = |from: &From| match from {
                From::Counts => count,
                From::Scale(scale) => given[*scale],
            };
            given[i] = match scale {
                Scale::Same(x) => from(x),
                Scale::Linear(x, slope, intercept) => from(x) * slope + intercept,
                Scale::Polynomial(x, coefficients) => {
                    let x = from(x);
                    coefficients.iter().rev().fold(0.0, |sum, coefficient| coefficient + sum * x)
                }
                Scale::Table(x, points) => on_table(points, from(x)),
                Scale::Sum(left, right) => from(left) + from(right),
                Scale::Difference(left, right) => from(right) - from(left),
            };
        }
        self.0.len().checked_sub(1).map_or(count, |last| given[last])
    }
}

fn key(scale: usize, what: &str) -> String {
    format!("NI_Scale[{scale}]_{what}")
}

/// A scale by its number.
fn scale(properties: &Properties, i: usize) -> Result<Scale, String> {
    let number = |what: &str| match properties.get(&key(i, what)) {
        Some(Property::Number(value)) => Ok(*value),
        _ => Err(format!("its scale {i} lacks {}", key(i, what))),
    };
    let from = |what: &str| match number(what) {
        // Left out, and as all ones, it means the values themselves.
        Err(_) => Ok(From::Counts),
        Ok(source) if source >= f64::from(u32::MAX) => Ok(From::Counts),
        Ok(source) if source >= 0.0 && source < i as f64 => Ok(From::Scale(source as usize)),
        Ok(source) => {
            Err(format!("its scale {i} takes what scale {source} gives, which comes later"))
        }
    };
    let list = |size: &str, of: &str, usual: usize| {
        let size = number(size).map_or(usual, |size| size as usize);
        if size > MOST_POINTS {
            return Err(format!("its scale {i} has {size} numbers"));
        }
        (0..size).map(|at| number(&format!("{of}[{at}]"))).collect::<Result<Vec<f64>, String>>()
    };
    let kind = match properties.get(&key(i, "Scale_Type")) {
        Some(Property::Text(kind)) => kind.as_str(),
        _ => return Err(format!("its scale {i} has no type")),
    };
    Ok(match kind {
        "Linear" => Scale::Linear(
            from("Linear_Input_Source")?,
            number("Linear_Slope")?,
            number("Linear_Y_Intercept")?,
        ),
        "Polynomial" => Scale::Polynomial(
            from("Polynomial_Input_Source")?,
            list("Polynomial_Coefficients_Size", "Polynomial_Coefficients", 4)?,
        ),
        "Table" => {
            let counts = list("Table_Pre_Scaled_Values_Size", "Table_Pre_Scaled_Values", 0)?;
            let values = list("Table_Scaled_Values_Size", "Table_Scaled_Values", 0)?;
            let mut points: Vec<(f64, f64)> =
                counts.iter().copied().zip(values.iter().copied()).collect();
            if points.first().map(|first| first.0) > points.last().map(|last| last.0) {
                points.reverse();
            }
            let grows = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
            if points.is_empty() || !grows || counts.len() != values.len() {
                return Err(format!("the table of its scale {i} is no curve"));
            }
            Scale::Table(from("Table_Input_Source")?, points)
        }
        "Add" => Scale::Sum(
            from("Add_Left_Operand_Input_Source")?,
            from("Add_Right_Operand_Input_Source")?,
        ),
        "Subtract" => Scale::Difference(
            from("Subtract_Left_Operand_Input_Source")?,
            from("Subtract_Right_Operand_Input_Source")?,
        ),
        "AdvancedAPI" => Scale::Same(from("AdvancedAPI_Input_Source")?),
        other => {
            return Err(format!(
                "its values are counts, and their scale '{other}' is not computed here"
            ));
        }
    })
}

/// A curve of straight lines.
fn on_table(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|point| point.0 <= x);
    match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
        (Some(before), Some(after)) => {
            (after.1 - before.1) / (after.0 - before.0) * (x - before.0) + before.1
        }
        (Some(end), None) => end.1,
        (None, after) => after.map_or(f64::NAN, |first| first.1),
    }
}
