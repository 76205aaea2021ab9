//! Completions and the manual page.

use crate::args::Args;
use crate::exit::Exit;
use crate::screen::Screen;
use clap::CommandFactory as _;

pub(crate) fn completions(shell: clap_complete::Shell, screen: &Screen) -> anyhow::Result<Exit> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Args::command(), "zwidth", &mut text);
    screen.file(&String::from_utf8(text)?);
    Ok(Exit::Fine)
}

pub(crate) fn man(screen: &Screen) -> anyhow::Result<Exit> {
    let mut text = Vec::new();
    clap_mangen::Man::new(Args::command()).render(&mut text)?;
    screen.result(String::from_utf8(text)?);
    Ok(Exit::Fine)
}
