//! Operations on whole columns.

use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Decimal32Type, Decimal64Type, Decimal128Type, Decimal256Type, Float16Type,
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{Array, Float64Array};
use arrow_schema::{ArrowError, DataType};
pub use arrow_select::concat::concat_batches;
use arrow_select::take::take;
use num_traits::ToPrimitive;

/// The numbers of a column as `f64`, each the nearest one; a decimal's digits over its power of
/// ten. Null stays null.
///
/// # Errors
/// A column that holds no numbers.
pub fn floats(column: &dyn Array) -> Result<Float64Array, ArrowError> {
    match column.data_type() {
        DataType::Int8 => Ok(nearest::<Int8Type>(column)),
        DataType::Int16 => Ok(nearest::<Int16Type>(column)),
        DataType::Int32 => Ok(nearest::<Int32Type>(column)),
        DataType::Int64 => Ok(nearest::<Int64Type>(column)),
        DataType::UInt8 => Ok(nearest::<UInt8Type>(column)),
        DataType::UInt16 => Ok(nearest::<UInt16Type>(column)),
        DataType::UInt32 => Ok(nearest::<UInt32Type>(column)),
        DataType::UInt64 => Ok(nearest::<UInt64Type>(column)),
        DataType::Float16 => Ok(nearest::<Float16Type>(column)),
        DataType::Float32 => Ok(nearest::<Float32Type>(column)),
        DataType::Float64 => Ok(nearest::<Float64Type>(column)),
        DataType::Decimal32(_, scale) => Ok(scaled::<Decimal32Type>(column, *scale)),
        DataType::Decimal64(_, scale) => Ok(scaled::<Decimal64Type>(column, *scale)),
        DataType::Decimal128(_, scale) => Ok(scaled::<Decimal128Type>(column, *scale)),
        DataType::Decimal256(_, scale) => Ok(scaled::<Decimal256Type>(column, *scale)),
        DataType::Dictionary(_, _) => {
            let dictionary = column.as_any_dictionary();
            let values = floats(dictionary.values())?;
            Ok(take(&values, dictionary.keys(), None)?.as_primitive().clone())
        }
        other => Err(ArrowError::CastError(format!("{other} is not a type of numbers"))),
    }
}

fn nearest<T>(column: &dyn Array) -> Float64Array
where
    T: ArrowPrimitiveType<Native: ToPrimitive>,
{
    column.as_primitive::<T>().unary_opt(|number| number.to_f64())
}

fn scaled<T>(column: &dyn Array, scale: i8) -> Float64Array
where
    T: ArrowPrimitiveType<Native: ToPrimitive>,
{
    let power = 10_f64.powi(i32::from(scale));
    nearest::<T>(column).unary(|digits| digits / power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::{
        BooleanArray, Decimal128Array, DictionaryArray, Int8Array, StringArray, UInt64Array,
    };

    fn check(column: &dyn Array, expect: &[Option<f64>]) {
        let found: Vec<Option<f64>> = floats(column).unwrap().iter().collect();
        assert_eq!(found, expect, "{}", column.data_type());
    }

    #[test]
    fn numbers_of_any_type_become_the_nearest_f64_and_null_stays_null() {
        check(&Int8Array::from(vec![Some(-7), None]), &[Some(-7.0), None]);
        check(&UInt64Array::from(vec![u64::MAX]), &[Some(18_446_744_073_709_551_616.0)]);
        let digits = Decimal128Array::from(vec![Some(-1_250), None]);
        let decimal = digits.with_precision_and_scale(10, 3).unwrap();
        check(&decimal, &[Some(-1.25), None]);
        let words = Int8Array::from(vec![Some(1), None, Some(0)]);
        let dictionary =
            DictionaryArray::new(words, std::sync::Arc::new(Float64Array::from(vec![0.5, 2.5])));
        check(&dictionary, &[Some(2.5), None, Some(0.5)]);
    }

    #[test]
    fn words_are_refused() {
        let refused = floats(&StringArray::from(vec!["1"])).unwrap_err().to_string();
        assert!(refused.contains("Utf8 is not a type of numbers"), "{refused}");
        assert!(floats(&BooleanArray::from(vec![true])).is_err());
    }
}
