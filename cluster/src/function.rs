//! The function by which an engine of queries calls [`crate::part::answer`]: from the bytes of a
//! task to those of its answer.

use crate::part::{Means, answer};
use crate::task::FUNCTION;
use datafusion::arrow::array::{Array as _, BinaryArray, cast::AsArray as _};
use datafusion::arrow::datatypes::DataType;
use datafusion::common::exec_err;
use datafusion::error::Result;
use datafusion::logical_expr::{
    ColumnarValue, ScalarFunctionArgs, ScalarUDF, ScalarUDFImpl, Signature, Volatility,
};
use std::sync::Arc;

/// The function.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Part {
    signature: Signature,
    /// What executors have for it; `None` on a client and on the scheduler, which only need to know
    /// that there is such a function.
    means: Option<Means>,
}

/// The function for an executor with these means, or for a client or scheduler.
pub(crate) fn function(means: Option<Means>) -> ScalarUDF {
    // Volatile: otherwise whoever plans the query would compute it right away, as a constant.
    let signature = Signature::exact(vec![DataType::Binary], Volatility::Volatile);
    ScalarUDF::new_from_impl(Part { signature, means })
}

impl ScalarUDFImpl for Part {
    fn name(&self) -> &str {
        FUNCTION
    }

    fn signature(&self) -> &Signature {
        &self.signature
    }

    fn return_type(&self, _: &[DataType]) -> Result<DataType> {
        Ok(DataType::Binary)
    }

    fn invoke_with_args(&self, args: ScalarFunctionArgs) -> Result<ColumnarValue> {
        let Some(means) = self.means.clone() else {
            return exec_err!("{FUNCTION} is computed by executors alone");
        };
        let arrays = ColumnarValue::values_to_arrays(&args.args)?;
        let [tasks] = arrays.as_slice() else {
            return exec_err!("{FUNCTION} takes one task");
        };
        let tasks = tasks.as_binary::<i32>();
        let tasks: Vec<Vec<u8>> = (0..tasks.len()).map(|i| tasks.value(i).to_vec()).collect();
        // On a thread of its own: this one belongs to the engine's runtime, which must not wait for
        // another one.
        let work = std::thread::Builder::new()
            .name(FUNCTION.to_owned())
            .spawn(move || tasks.iter().map(|task| answer(task, &means)).collect::<Vec<_>>());
        match work.map(std::thread::JoinHandle::join) {
            Ok(Ok(answers)) => {
                let answers = BinaryArray::from_iter_values(answers);
                Ok(ColumnarValue::Array(Arc::new(answers)))
            }
            _ => exec_err!("{FUNCTION}: no thread could be started"),
        }
    }
}
