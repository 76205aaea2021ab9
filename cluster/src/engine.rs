//! The engine as a client sees it: it takes a task, and some executor answers.

use crate::function::function;
use crate::pack::unpack;
use crate::task::{Answer, MOST_MESSAGE, MOST_PACKED};
use crate::watch::Address;
use anyhow::{Context as _, anyhow, bail, ensure};
use ballista::prelude::{SessionConfigExt as _, SessionContextExt as _};
use datafusion::arrow::array::{Array as _, cast::AsArray as _};
use datafusion::common::ScalarValue;
use datafusion::execution::SessionStateBuilder;
use datafusion::logical_expr::{ScalarUDF, lit};
use datafusion::prelude::{SessionConfig, SessionContext};
use std::time::Duration;
use tokio::time::timeout;

/// How often a task is given to the engine before it is given up. The engine itself tries each one
/// four times; but an answer is lost if its executor dies before the client has fetched it.
const ATTEMPTS: usize = 3;

/// A session with a scheduler.
pub(crate) struct Engine {
    context: SessionContext,
    function: ScalarUDF,
    at: Address,
    deadline: Duration,
}

/// What came of a task: its answer, and the contents of the answer's files.
pub(crate) type Answered = (Answer, Vec<Vec<u8>>);

impl Engine {
    /// A session with a scheduler; nothing is sent yet.
    ///
    /// # Errors
    /// An address that cannot be one.
    pub(crate) async fn new(at: &Address, deadline: Duration) -> anyhow::Result<Self> {
        // Asks for a job's state again and again, each time with a limit. The alternative is one
        // call that is open as long as the job takes.
        let config = SessionConfig::new_with_ballista()
            .with_ballista_grpc_client_max_message_size(MOST_MESSAGE as usize)
            .set_bool("ballista.client.pull", true);
        let state = SessionStateBuilder::new().with_config(config).with_default_features().build();
        let context = SessionContext::remote_with_state(&format!("df://{at}"), state).await?;
        // Only now: connecting drops the functions that the state had.
        context.register_udf(function(None));
        Ok(Self { context, function: function(None), at: at.clone(), deadline })
    }

    /// Gives a task to the engine and waits for its answer.
    ///
    /// # Errors
    /// The engine failed, or there was no answer in time.
    pub(crate) async fn answer(&self, part: &str, task: &[u8]) -> anyhow::Result<Answered> {
        let mut failures = Vec::new();
        for _ in 0..ATTEMPTS {
            let answer = timeout(self.deadline, self.ask(task)).await;
            match answer {
                Ok(Ok(answer)) => return Ok(answer),
                Ok(Err(error)) => failures.push(error),
                Err(_) => bail!(
                    "{part}: the cluster at {} gave no answer within {} s; look into the executors' logs, or allow \
                     more time with --deadline",
                    self.at,
                    self.deadline.as_secs()
                ),
            }
        }
        let last = failures.pop().unwrap_or_else(|| anyhow!("it was not tried"));
        Err(last.context(format!(
            "{part}: the cluster at {} failed {ATTEMPTS} times; every executor must be a `zwidth-cluster executor` of \
             this version",
            self.at
        )))
    }

    async fn ask(&self, task: &[u8]) -> anyhow::Result<Answered> {
        let task = lit(ScalarValue::Binary(Some(task.to_vec())));
        let query = self.context.read_empty()?.select(vec![self.function.call(vec![task])])?;
        let batches = query.collect().await?;
        let column =
            batches.iter().find(|batch| batch.num_rows() == 1).map(|batch| batch.column(0));
        let column = column.context("the answer has no row")?;
        let answers = column.as_binary_opt::<i32>().context("the answer is not bytes")?;
        ensure!(!answers.is_null(0), "the answer is empty");
        let packed = answers.value(0);
        ensure!(packed.len() <= MOST_PACKED, "the answer has {} bytes", packed.len());
        unpack(packed).context("the answer is damaged")
    }
}
