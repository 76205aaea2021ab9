//! `zwidth-cluster fetch`: the recordings of a study, from an object store into a data folder that
//! does not have them.

use crate::Exit;
use crate::args::Fetch;
use crate::say::Say;
use crate::source::{Source, url_of};
use anyhow::{Context as _, ensure};
use tokio::runtime::Runtime;
use zwidth_store::Layout;

/// Copies them beside, and gives the copy its name once it is whole.
///
/// # Errors
/// The study is here already, or not there; a file that cannot be read or written.
pub(crate) fn fetch(args: &Fetch, runtime: &Runtime, say: Say) -> anyhow::Result<Exit> {
    let layout = Layout::new(&args.root, args.study.clone());
    let (raw, folder) = (layout.raw(), args.root.join("raw"));
    ensure!(
        !raw.exists(),
        "{} is here already, and recordings are never overwritten; move it elsewhere to fetch it again",
        raw.display()
    );
    let source = Source::open(&url_of(&args.raw)?, args.store.timeout())?;
    let below = format!("raw/{}", args.study);
    let paths = runtime.block_on(source.list(&below))?;
    ensure!(
        paths.contains(&format!("{below}/study.toml")),
        "{} has no {below}/study.toml; name the folder or the prefix that has raw/ in it",
        args.raw
    );
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("{} cannot be made", folder.display()))?;
    let beside = tempfile::Builder::new().prefix(".fetched.").tempdir_in(&folder)?;
    let all = paths.iter().map(String::as_str);
    runtime.block_on(source.fetch(all, beside.path(), |_, _| Ok(())))?;
    std::fs::rename(beside.path().join(&below), &raw)
        .with_context(|| format!("{} cannot be given its name", raw.display()))?;
    say.progress(format!(
        "{}: {} files fetched; `zwidth verify {}` checks them",
        args.study,
        paths.len(),
        args.study
    ));
    Ok(Exit::Fine)
}
