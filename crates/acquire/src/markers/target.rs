//! Where markers go.

use std::fmt;
use std::str::FromStr;

/// A receiver of markers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// A line of JSON over TCP, to whoever listens at `host:port`.
    Tcp(String),
    /// A message of Open Sound Control in a UDP packet, to `host:port`.
    Osc(String),
    /// The pins of the board that the lever is at.
    Board,
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, address) = text.split_once(':').unwrap_or((text, ""));
        let port = address.rsplit_once(':').filter(|(host, _)| !host.is_empty());
        let has_port = port.is_some_and(|(_, port)| port.parse::<u16>().is_ok_and(|port| port > 0));
        match kind {
            "tcp" if has_port => Ok(Self::Tcp(address.to_owned())),
            "osc" if has_port => Ok(Self::Osc(address.to_owned())),
            _ if text == "board" => Ok(Self::Board),
            _ => Err("write tcp:HOST:PORT, osc:HOST:PORT or board".to_owned()),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Osc(address) => write!(f, "osc:{address}"),
            Self::Board => f.write_str("board"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_written_as_it_is_read_and_needs_a_host_and_a_port() {
        for good in ["tcp:localhost:9000", "osc:127.0.0.1:57120", "tcp:[::1]:9000", "board"] {
            assert_eq!(good.parse::<Target>().unwrap().to_string(), good);
        }
        let bad =
            ["", "tcp", "tcp:", "tcp:host", "tcp::9", "udp:h:9", "osc:h:0", "osc:h:x", "board:1"];
        for bad in bad {
            assert!(bad.parse::<Target>().unwrap_err().contains("HOST:PORT"), "{bad}");
        }
    }
}
