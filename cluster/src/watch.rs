//! Whether there is a scheduler, and whether it has executors: asked beside the queries, because a
//! query whose executors are all gone may wait for ever.

use anyhow::{Context as _, anyhow};
use std::fmt;
use std::net::{IpAddr, Ipv6Addr};
use std::str::FromStr;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep, timeout};

/// Longest wait for the scheduler to say how it is.
const ANSWER: Duration = Duration::from_secs(5);

/// How often it is asked.
const EVERY: Duration = Duration::from_millis(500);

/// Longest first line of its answer, bytes.
const MOST_LINE: u64 = 1 << 10;

/// Where a scheduler listens: `HOST:PORT`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Address {
    /// A name, or an address as URLs have it: one of IPv6 in brackets.
    pub(crate) host: String,
    pub(crate) port: u16,
}

/// An address as URLs have it.
pub(crate) fn host_of(ip: IpAddr) -> String {
    match ip {
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = text.rsplit_once(':').and_then(|(host, port)| Some((host, port.parse().ok()?)));
        match found {
            Some((host, port)) if is_host(host) && port != 0 => {
                Ok(Self { host: host.to_owned(), port })
            }
            _ => Err("an address is a host and a port: node1:50050".to_owned()),
        }
    }
}

/// Whether a text may be a host: an address of IPv6 is in brackets.
fn is_host(text: &str) -> bool {
    let of_ipv6 = text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    match of_ipv6 {
        Some(ip) => ip.parse::<Ipv6Addr>().is_ok(),
        None => !text.is_empty() && !text.contains(['/', ':', '[', ']']),
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}", self.host, self.port)
    }
}

/// How a cluster is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum State {
    /// It has a scheduler and at least one executor.
    Ready,
    /// Its scheduler has no executor.
    NoExecutor,
    /// Nobody answers, or not as a scheduler does; why.
    NoScheduler(String),
}

impl State {
    /// What is wrong and what to do, if something is.
    pub(crate) fn complaint(&self, at: &Address) -> Option<anyhow::Error> {
        match self {
            Self::Ready => None,
            Self::NoExecutor => Some(anyhow!(
                "the scheduler at {at} has no executor; start some with `zwidth-cluster executor --scheduler {at}`, \
                 or look into their logs"
            )),
            Self::NoScheduler(why) => Some(anyhow!(
                "no scheduler answers at {at} ({why}); start one with `zwidth-cluster scheduler`, or name another \
                 address"
            )),
        }
    }
}

/// How the cluster is now.
pub(crate) async fn state(at: &Address) -> State {
    match timeout(ANSWER, ready(at)).await {
        Ok(Ok(true)) => State::Ready,
        Ok(Ok(false)) => State::NoExecutor,
        Ok(Err(error)) => State::NoScheduler(format!("{error:#}")),
        Err(_) => State::NoScheduler(format!("no answer within {} s", ANSWER.as_secs())),
    }
}

/// Asks the scheduler whether it is ready, that is, whether it has executors.
async fn ready(at: &Address) -> anyhow::Result<bool> {
    let mut stream = TcpStream::connect(at.to_string()).await?;
    let request = format!("GET /readyz HTTP/1.1\r\nHost: {at}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await?;
    // `HTTP/1.1 200 OK`: more is not needed, and whoever answers may keep the connection open.
    let mut line = String::new();
    BufReader::new(stream.take(MOST_LINE)).read_line(&mut line).await?;
    let code = line.strip_prefix("HTTP/").and_then(|rest| rest.split(' ').nth(1)?.parse().ok());
    match code.context("what answers there is no scheduler of Ballista")? {
        200_u16 => Ok(true),
        503 => Ok(false),
        code => Err(anyhow!("what answers there is no scheduler of Ballista: HTTP {code}")),
    }
}

/// Waits for a cluster that is ready, for so long at most. A scheduler that is not there is not
/// waited for.
///
/// # Errors
/// There is no scheduler, or it has no executor in time.
pub(crate) async fn until_ready(at: &Address, patience: Duration) -> anyhow::Result<()> {
    let begun = Instant::now();
    loop {
        let state = state(at).await;
        let is_over = begun.elapsed() >= patience || matches!(state, State::NoScheduler(_));
        match state.complaint(at) {
            None => return Ok(()),
            Some(complaint) if is_over => return Err(complaint),
            Some(_) => sleep(EVERY).await,
        }
    }
}

/// Waits until a scheduler answers; [`until_lost`] says when that takes too long.
pub(crate) async fn until_answered(at: &Address) {
    while matches!(state(at).await, State::NoScheduler(_)) {
        sleep(EVERY).await;
    }
}

/// Ends only once the cluster was not ready for so long; with what is wrong.
pub(crate) async fn until_lost(at: &Address, patience: Duration) -> anyhow::Error {
    let mut last_ready = Instant::now();
    loop {
        match state(at).await.complaint(at) {
            None => last_ready = Instant::now(),
            Some(complaint) if last_ready.elapsed() >= patience => {
                return complaint
                    .context(format!("the cluster was lost for {} s", patience.as_secs()));
            }
            Some(_) => {}
        }
        sleep(EVERY).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_a_host_and_a_port() {
        for good in ["node1:50050", "127.0.0.1:1", "[::1]:50050"] {
            assert_eq!(good.parse::<Address>().unwrap().to_string(), good);
        }
        for bad in
            ["node1", ":50050", "node1:0", "node1:x", "df://node1:50050", "", "::1:50050", "[x]:1"]
        {
            assert!(bad.parse::<Address>().is_err(), "{bad:?}");
        }
    }
}
