//! The scheduler and an executor: Ballista's own, which know our function and have our limits.

use crate::args::{Executor, Scheduler};
use crate::function::function;
use crate::part::Means;
use crate::say::Say;
use crate::task::{FUNCTION, MOST_MESSAGE};
use crate::watch::{Address, State, host_of, state};
use anyhow::{Context as _, anyhow};
use ballista_core::config::TaskSchedulingPolicy;
use ballista_core::registry::BallistaFunctionRegistry;
use ballista_core::utils::{GrpcServerConfig, default_session_builder};
use ballista_executor::executor_process::{ExecutorProcessConfig, start_executor_process};
use ballista_scheduler::cluster::BallistaCluster;
use ballista_scheduler::config::SchedulerConfig;
use ballista_scheduler::scheduler_process::{create_scheduler, start_grpc_service_with_listener};
use datafusion::execution::{FunctionRegistry as _, SessionState};
use datafusion::prelude::SessionConfig;
use datafusion_proto::protobuf::{LogicalPlanNode, PhysicalPlanNode};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::time::{Instant, sleep};

/// How long results of finished tasks are kept, s, by the executors that could be asked for them
/// again.
const KEPT_S: u64 = 600;

/// How long the scheduler remembers a finished task, s: with it what the task was given, a megabyte
/// or more. A client asks twenty times a second.
const REMEMBERED_S: u64 = 120;

/// Longest that one request to an executor may take, s: it may be for an answer of
/// [`crate::task::MOST_PACKED`] bytes.
const REQUEST_S: u64 = 120;

/// Serves as a scheduler until the process is ended.
///
/// # Errors
/// An address that it cannot listen at.
pub(crate) async fn scheduler(args: &Scheduler, say: Say) -> anyhow::Result<()> {
    let failed = || format!("the scheduler at {} cannot go on", args.bind);
    let listener = TcpListener::bind(args.bind).await.with_context(failed)?;
    let address = listener.local_addr().with_context(failed)?;
    let config = SchedulerConfig {
        bind_host: host_of(args.bind.ip()),
        bind_port: address.port(),
        external_host: args.host.clone().unwrap_or_else(|| host_of(args.bind.ip())),
        scheduling_policy: TaskSchedulingPolicy::PullStaged,
        grpc_server_max_decoding_message_size: MOST_MESSAGE,
        grpc_server_max_encoding_message_size: MOST_MESSAGE,
        grpc_client_max_message_size: MOST_MESSAGE,
        executor_timeout_seconds: args.executor_timeout,
        expire_dead_executor_interval_seconds: (args.executor_timeout / 4).max(1),
        no_executors_grace_period_seconds: args.executor_timeout,
        finished_job_data_clean_up_interval_seconds: KEPT_S,
        finished_job_state_clean_up_interval_seconds: REMEMBERED_S,
        override_session_builder: Some(Arc::new(session)),
        ..SchedulerConfig::default()
    };
    let cluster = BallistaCluster::new_from_config(&config).await?;
    let server = create_scheduler::<LogicalPlanNode, PhysicalPlanNode>(cluster, Arc::new(config));
    let server = server.await.with_context(failed)?;
    // Whoever reads it can connect from now on.
    say.result(format!("the scheduler listens at {address}"));
    start_grpc_service_with_listener(listener, server).await.with_context(failed)
}

/// A session of the scheduler, which plans queries that call our function.
fn session(config: SessionConfig) -> datafusion::error::Result<SessionState> {
    let mut session = default_session_builder(config)?;
    session.register_udf(Arc::new(function(None)))?;
    Ok(session)
}

/// Serves as an executor until the process is ended.
///
/// # Errors
/// No scheduler in time; an address that it cannot listen at; no folder for scratch.
pub(crate) async fn executor(args: &Executor) -> anyhow::Result<()> {
    until_scheduler(&args.scheduler, Duration::from_secs(args.patience)).await?;
    // Removed when the process ends by itself.
    let scratch = match &args.scratch {
        Some(folder) => tempfile::tempdir_in(folder),
        None => tempfile::tempdir(),
    };
    let scratch = scratch.context("there is no folder for scratch; name one with --scratch")?;
    let work = scratch.path().to_str().context("the path of the scratch folder is not UTF-8")?;
    let mut functions = BallistaFunctionRegistry::default();
    let means = Means { scratch: scratch.path().to_owned(), store_timeout: args.store.timeout() };
    let ours = function(Some(means));
    functions.scalar_functions.insert(FUNCTION.to_owned(), Arc::new(ours));
    let config = ExecutorProcessConfig {
        bind_host: host_of(args.bind.ip()),
        port: args.bind.port(),
        external_host: Some(args.host.clone().unwrap_or_else(|| host_of(args.bind.ip()))),
        scheduler_host: args.scheduler.host.clone(),
        scheduler_port: args.scheduler.port,
        vcores: args.cores.get().into(),
        task_scheduling_policy: TaskSchedulingPolicy::PullStaged,
        work_dir: Some(work.to_owned()),
        job_data_ttl_seconds: KEPT_S,
        job_data_clean_up_interval_seconds: KEPT_S,
        grpc_max_decoding_message_size: MOST_MESSAGE,
        grpc_max_encoding_message_size: MOST_MESSAGE,
        grpc_server_config: GrpcServerConfig { timeout_seconds: REQUEST_S, ..Default::default() },
        // Our jobs do not take their memory from the engine.
        memory_pool_size: Some(0),
        override_function_registry: Some(Arc::new(functions)),
        ..ExecutorProcessConfig::default()
    };
    let failed = || format!("the executor at {} cannot go on", args.bind);
    start_executor_process(Arc::new(config)).await.with_context(failed)
}

/// Waits for a scheduler, for so long at most.
async fn until_scheduler(at: &Address, patience: Duration) -> anyhow::Result<()> {
    let begun = Instant::now();
    loop {
        match state(at).await {
            State::Ready | State::NoExecutor => return Ok(()),
            silent if begun.elapsed() >= patience => {
                let complaint = silent.complaint(at).unwrap_or_else(|| anyhow!("no scheduler"));
                return Err(complaint);
            }
            State::NoScheduler(_) => sleep(Duration::from_millis(200)).await,
        }
    }
}
