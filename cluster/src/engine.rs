//! The engine as a client sees it: it takes a task, and some executor answers.

use crate::function::function;
use crate::pack::unpack;
use crate::task::{Answer, FUNCTION, MOST_MESSAGE, MOST_PACKED};
use crate::watch::{Address, until_answered};
use anyhow::{Context as _, anyhow, bail, ensure};
use ballista::prelude::{SessionConfigExt as _, SessionContextExt as _};
use ballista_core::execution_plans::DistributedQueryExec;
use ballista_core::serde::protobuf::job_status::Status;
use ballista_core::serde::protobuf::scheduler_grpc_client::SchedulerGrpcClient;
use ballista_core::serde::protobuf::{CancelJobParams, GetJobStatusParams};
use datafusion::arrow::array::{Array as _, cast::AsArray as _};
use datafusion::common::ScalarValue;
use datafusion::execution::SessionStateBuilder;
use datafusion::logical_expr::{ScalarUDF, lit};
use datafusion::physical_plan::{ExecutionPlan, collect};
use datafusion::prelude::{SessionConfig, SessionContext};
use datafusion_proto::protobuf::LogicalPlanNode;
use futures::future::join_all;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::time::{sleep, timeout};

/// How often a task is given to the engine before it is given up: an answer is lost if its executor
/// dies before the client has fetched it.
const ATTEMPTS: usize = 3;

/// Longest wait for the scheduler to take back what it was asked.
const TAKING_BACK: Duration = Duration::from_secs(10);

/// How often it is asked to.
const EVERY: Duration = Duration::from_millis(50);

/// A session with a scheduler.
pub(crate) struct Engine {
    context: SessionContext,
    function: ScalarUDF,
    at: Address,
    deadline: Duration,
    /// What the scheduler was asked and has not answered.
    open: Mutex<Vec<Arc<dyn ExecutionPlan>>>,
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
        let open = Mutex::default();
        Ok(Self { context, function: function(None), at: at.clone(), deadline, open })
    }

    /// Gives a task to the engine and waits for its answer.
    ///
    /// # Errors
    /// The engine failed, or there was no answer in time.
    pub(crate) async fn answer(&self, part: &str, task: &[u8]) -> anyhow::Result<Answered> {
        let Ok(answer) = timeout(self.deadline, self.attempts(part, task)).await else {
            bail!(
                "{part}: the cluster at {} gave no answer within {} s; look into the executors' logs, or allow more \
                 time with `zwidth-cluster run --deadline`",
                self.at,
                self.deadline.as_secs()
            )
        };
        answer
    }

    async fn attempts(&self, part: &str, task: &[u8]) -> anyhow::Result<Answered> {
        let mut failures = Vec::new();
        for _ in 0..ATTEMPTS {
            match self.ask(task).await {
                Ok(answer) => return Ok(answer),
                Err(error) => {
                    // Without a scheduler every attempt fails, whatever the error says.
                    until_answered(&self.at).await;
                    failures.push(error);
                }
            }
        }
        let last = failures.pop().unwrap_or_else(|| anyhow!("it was not tried"));
        // An executor that does not have the function says its name.
        let remedy = match format!("{last:#}").contains(FUNCTION) {
            true => "every executor must be a `zwidth-cluster executor` of this version",
            false => "look into the logs of the scheduler and its executors",
        };
        Err(last.context(format!(
            "{part}: the cluster at {} failed {ATTEMPTS} times; {remedy}",
            self.at
        )))
    }

    /// Takes back what was asked and is not answered. Executors go on with what they have begun, and
    /// begin nothing more.
    pub(crate) async fn take_back(&self) {
        let open = std::mem::take(&mut *self.open());
        // If this fails there is no scheduler, and so nothing to take back.
        let _ = timeout(TAKING_BACK, join_all(open.iter().map(|query| self.cancel(query)))).await;
    }

    /// Whether something was asked and is not answered.
    pub(crate) fn is_asking(&self) -> bool {
        !self.open().is_empty()
    }

    /// Cancels a query until it is over: one that is just being sent has no name yet, and one that is
    /// being planned is not cancelled by the scheduler.
    async fn cancel(&self, query: &Arc<dyn ExecutionPlan>) -> anyhow::Result<()> {
        let mut scheduler = SchedulerGrpcClient::connect(format!("http://{}", self.at)).await?;
        loop {
            if let Some(job_id) = job_of(query) {
                scheduler.cancel_job(CancelJobParams { job_id: job_id.clone() }).await?;
                let job = scheduler.get_job_status(GetJobStatusParams { job_id }).await?;
                let status = job.into_inner().status.and_then(|job| job.status);
                if matches!(status, Some(Status::Failed(_) | Status::Successful(_))) {
                    return Ok(());
                }
            }
            sleep(EVERY).await;
        }
    }

    fn open(&self) -> MutexGuard<'_, Vec<Arc<dyn ExecutionPlan>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn ask(&self, task: &[u8]) -> anyhow::Result<Answered> {
        let task = lit(ScalarValue::Binary(Some(task.to_vec())));
        let query = self.context.read_empty()?.select(vec![self.function.call(vec![task])])?;
        let query = query.create_physical_plan().await?;
        self.open().push(Arc::clone(&query));
        // By itself, so that it is sent as a whole or not at all. If nobody waits for it any more it
        // stays open.
        let answer = tokio::spawn(collect(Arc::clone(&query), self.context.task_ctx())).await;
        self.open().retain(|other| !Arc::ptr_eq(other, &query));
        let batches = answer??;
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

/// The scheduler's name for a query, once it has one.
fn job_of(query: &Arc<dyn ExecutionPlan>) -> Option<String> {
    let query = query.downcast_ref::<DistributedQueryExec<LogicalPlanNode>>()?;
    query.job_id().map(Into::into)
}
