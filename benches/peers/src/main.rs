//! One scene, solved by zwidth and by Rust peers: `zwidth-peers reference` writes θ of the exact
//! solution, one sample a line; `zwidth-peers measure` tunes, times and writes one row a peer. See
//! `run.sh`.

mod diffsol_peer;
mod dopri;
mod ode_solvers_peer;
mod ours;
mod scene;
mod swept;
mod tune;

use std::process::ExitCode;

fn main() -> ExitCode {
    let done = match std::env::args().nth(1).as_deref() {
        Some("reference") => {
            ours::reference().map(|theta| theta.iter().map(|x| format!("{x:e}\n")).collect())
        }
        Some("measure") => tune::measure(),
        Some("sweep") => tune::sweep(),
        _ => Err("usage: zwidth-peers reference | measure | sweep".to_owned()),
    };
    match done {
        Ok(text) => {
            let text: String = text;
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
