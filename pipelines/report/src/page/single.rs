//! The page as one file, with pictures and samples in it.

use super::course::deflated;
use super::own::script;
use super::policy::{Form, policy};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use libdeflater::{CompressionLvl, Compressor};
use std::collections::{BTreeMap, BTreeSet};
use std::io;

/// Where the page says that samples lie beside it, and what one file says instead.
const BESIDE: [&str; 2] = ["\"single_file\":false", "\"single_file\":true"];
/// How the page names a picture: all that it shows of another file. No text of a study can have this
/// quotation mark.
const SOURCE: &str = " src=\"";
/// How one file names it instead, where it is packed.
const PACKED: &str = " data-packed=\"";
/// What stands before the page's own script, where it knows nothing of a study.
const SCRIPT: &str = "<script>";
/// What stands before what the page's script knows of the study: samples are brought in before it, too.
pub(super) const DATA: &str = "<script id=\"study-data\" type=\"application/json\">";
/// How a trial names the script that holds its samples.
const KEY: &str = "\"data\":\"";

/// The kind of a picture that a stage of the study's own drew.
fn of_own_stage(path: &str) -> Option<&'static str> {
    let is_own = path.starts_with("stages/");
    let kinds = [(".svg", "svg+xml"), (".png", "png")];
    let kind = kinds.into_iter().find(|(ending, _)| path.ends_with(ending));
    kind.filter(|_| is_own).map(|(_, kind)| kind)
}

/// The page including everything that it shows: `read` gives the files beside it, by their paths
/// from its folder on. Links to tables and other forms of a figure stay links.
///
/// # Errors
/// Those of `read`; a page or a script of samples that is not one of ours; a picture that is not a
/// figure.
pub fn single_file(
    html: &str,
    mut read: impl FnMut(&str) -> io::Result<Vec<u8>>,
) -> io::Result<String> {
    let found = [script(false), script(true)].into_iter().find_map(|own| {
        let (head, body) = html.split_once(&policy(Form::Folder, own))?;
        Some((own, head, body))
    });
    let (own, head, body) = found.ok_or_else(|| {
        io::Error::other(
            "it is not as this version of zwidth writes it; make it again with `zwidth run STUDY`",
        )
    })?;
    let (mut shown, data) = body.split_once(DATA).unwrap_or((body, ""));
    let mut one = String::with_capacity(2 * html.len());
    one += head;
    one += &policy(Form::OneFile, own);
    let mut figures: BTreeMap<&str, String> = BTreeMap::new();
    let mut compressor = Compressor::new(CompressionLvl::default());
    let mut is_first = true;
    while let Some((before, rest)) = shown.split_once(SOURCE) {
        let (path, after) = rest.split_once('"').unwrap_or((rest, ""));
        // One that a stage of the study's own drew stays an image: its bytes are not the page's.
        if let Some(kind) = of_own_stage(path) {
            let picture = STANDARD.encode(read(path)?);
            one += &format!("{before}{SOURCE}data:image/{kind};base64,{picture}\"");
            shown = after;
            continue;
        }
        if !path.starts_with("figures/") || !path.ends_with(".svg") {
            return Err(io::Error::other(format!(
                "it shows '{path}', which is no figure of the study; make it again with `zwidth run STUDY`"
            )));
        }
        one += before;
        if std::mem::take(&mut is_first) {
            // The answer is there without the script, too.
            let picture = STANDARD.encode(read(path)?);
            one += &format!("{SOURCE}data:image/svg+xml;base64,{picture}\"");
        } else {
            if !figures.contains_key(path) {
                figures.insert(path, deflated(&read(path)?, &mut compressor)?);
            }
            one += &format!("{PACKED}{path}\"");
        }
        shown = after;
    }
    // The page's script unpacks a figure when it is about to be seen: drawings are most of the file.
    let (shown, end) = shown.rsplit_once(SCRIPT).unwrap_or((shown, ""));
    one += shown;
    for (path, figure) in figures {
        one += &format!(
            "<script type=\"text/plain\" class=\"figure-data\" data-key=\"{path}\">{figure}</script>"
        );
    }
    if !end.is_empty() {
        one += SCRIPT;
        one += end;
    }
    if data.is_empty() {
        return Ok(one);
    }
    let keys: BTreeSet<&str> =
        data.split(KEY).skip(1).filter_map(|rest| rest.split('"').next()).collect();
    // Keys of one script stand together.
    let (mut script, mut text) = (String::new(), String::new());
    for key in keys {
        // As the page's own script finds it: that of the condition's environment.
        let stem = key.rsplit_once('.').map_or(key, |(environment, _mode)| environment);
        let file = format!("report-data/{stem}.js");
        if script != file {
            text = String::from_utf8_lossy(&read(&file)?).into_owned();
            script = file;
        }
        let begin = format!("zwidthData(\"{key}\", ");
        let call = text.lines().find_map(|line| line.strip_prefix(&begin)?.strip_suffix(");"));
        let samples = call.ok_or_else(|| {
            io::Error::other(format!("{script} is not what `zwidth run` writes; run it again"))
        })?;
        one += &format!(
            "<script type=\"text/plain\" class=\"trial-data\" data-key=\"{key}\">{samples}</script>"
        );
    }
    Ok(one + DATA + &data.replacen(BESIDE[0], BESIDE[1], 1))
}
