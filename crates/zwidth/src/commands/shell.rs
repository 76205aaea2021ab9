//! Completions, the manual pages and the licences.

use crate::args::Args;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::Context as _;
use clap::CommandFactory as _;
use flate2::read::GzDecoder;
use std::io::Read as _;
use std::path::Path;

/// What `cargo xtask licences` makes of the packages that are linked.
const NOTICES: &[u8] = include_bytes!("../../licences.gz");

pub(crate) fn completions(shell: clap_complete::Shell, screen: &Screen) -> anyhow::Result<Exit> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Args::command(), "zwidth", &mut text);
    screen.file(&String::from_utf8(text)?);
    Ok(Exit::Fine)
}

pub(crate) fn man(out: Option<&Path>, screen: &Screen) -> anyhow::Result<Exit> {
    let Some(folder) = out else {
        let mut text = Vec::new();
        clap_mangen::Man::new(Args::command()).render(&mut text)?;
        screen.result(String::from_utf8(text)?);
        return Ok(Exit::Fine);
    };
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Args::command(), folder));
    written.with_context(|| format!("cannot write manual pages into {}", folder.display()))?;
    screen.say(format!("{}: a page for each command", folder.display()));
    Ok(Exit::Fine)
}

pub(crate) fn licences(screen: &Screen) -> anyhow::Result<Exit> {
    let mut text = String::new();
    GzDecoder::new(NOTICES).read_to_string(&mut text)?;
    screen.file(&text);
    Ok(Exit::Fine)
}
