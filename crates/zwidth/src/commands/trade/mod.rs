//! `zwidth trade`: every solver and step on scenes, and the cheapest that is good enough.

mod others;
mod setups;
mod source;
mod timing;
mod words;

pub(crate) use source::TradeArgs;

use super::output::Output;
use crate::exit::Exit;
use crate::screen::Screen;
use serde::Serialize;
use setups::{Study, Written, is_made, setups};
use source::{Requested, Source, requested};
use std::path::{Path, PathBuf};
use zwidth_figures::Felt;
use zwidth_results::{RunTime, SolverCreep, TradeChoice};
use zwidth_trade::{
    Fan, Fineness, Parameters, Setting, Trade, choice, choices_table, courses, courses_table,
    creeps, creeps_table, metrics, metrics_table, models, recommended_scene, settings,
    settings_table, trade as trade_scene,
};

/// What `--json` prints of a scene.
#[derive(Serialize)]
struct Outcome {
    scene: String,
    yardstick: Option<&'static str>,
    recommended: Option<String>,
    up_to_date: bool,
    files: Vec<PathBuf>,
    error: Option<String>,
}

pub(crate) fn trade(root: &Path, command: &TradeArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let Requested { scenes, studies } = requested(root, command, screen)?;
    let mut outcomes = Vec::new();
    let settings: usize = scenes.iter().map(Source::settings).sum();
    let bar = screen.bar(settings + studies.iter().map(Study::trials).sum::<usize>());
    let mut done = |message: &str, steps: usize, make: &dyn Fn() -> Option<Account>| {
        bar.set_message(message.to_owned());
        // One that fails, or is up to date, does not take its steps by itself.
        let after = bar.position() + steps as u64;
        let account = make();
        bar.set_position(after);
        if let Some(account) = account {
            if !screen.json {
                // A line that is printed while the bar is drawn would run into it.
                bar.suspend(|| tell(&account, screen));
            }
            outcomes.push(account);
        }
    };
    for source in &scenes {
        done(&source.stem, source.settings(), &|| {
            let result = one(source, command, &|| bar.inc(1));
            Some(account(source.stem.clone(), &source.stem, result))
        });
    }
    for study in &studies {
        done(setups::STEM, study.trials(), &|| {
            // None where it has no trial to simulate.
            let result = setups(root, study, command.fresh, &|| bar.inc(1)).transpose()?;
            Some(account(format!("{} on the simulated device", study.name), setups::STEM, result))
        });
    }
    bar.finish_and_clear();
    let failed = outcomes.iter().filter(|outcome| outcome.0.error.is_some()).count();
    if failed == outcomes.len() {
        let errors = outcomes.into_iter().filter_map(|(outcome, _)| outcome.error);
        return Err(super::as_lines(errors.collect(), 0));
    }
    if screen.json {
        screen.listing(&outcomes.iter().map(|outcome| &outcome.0).collect::<Vec<_>>())?;
    }
    Ok(if failed == 0 { Exit::Fine } else { Exit::Partly })
}

/// What came of a scene or of a study's setups, and the lines about it.
type Account = (Outcome, Vec<String>);

fn account(scene: String, stem: &str, result: anyhow::Result<Written>) -> Account {
    let (written, error) = match result {
        Ok(written) => (written, None),
        Err(error) => (Written::default(), Some(format!("{stem}: {error:#}"))),
    };
    let Written { files, lines, yardstick, recommended } = written;
    let up_to_date = error.is_none() && files.is_empty();
    (Outcome { scene, yardstick, recommended, up_to_date, files, error }, lines)
}

fn tell((outcome, lines): &Account, screen: &Screen) {
    match &outcome.error {
        Some(error) => screen.warn(format!("skipped: {error}")),
        None if outcome.up_to_date => {
            screen.result(format!("{}: up to date", outcome.scene));
        }
        None => {
            screen.result(format!("{}:", outcome.scene));
            lines.iter().for_each(|line| screen.result(format!("  {line}")));
            screen.files(&outcome.files, &["png", "toml"], "  ");
        }
    }
}

/// Makes the trade of a scene, unless nothing changed since its files were written.
fn one(
    source: &Source,
    command: &TradeArgs,
    progress: &(dyn Fn() + Sync),
) -> anyhow::Result<Written> {
    let key = source.key()?;
    let name = format!("{}.trade", source.stem);
    // Other programs' files may be others, whatever the scene is.
    let theirs = command.trajectories.as_deref();
    if !command.fresh && theirs.is_none() && is_made(&source.folder, &name, &key) {
        return Ok(Written::default());
    }
    // Before the solvers run, which takes longer.
    let theirs = theirs.map(|table| others::judged(source, table)).transpose()?;
    let parameters = Parameters::full(&source.scene, &source.perception);
    let mut trades = Vec::new();
    for (number, model) in models(&source.scene).iter().enumerate() {
        // The recommendation is for the scene's own model, the first.
        let neighbours = if number == 0 { parameters.neighbours } else { 0 };
        let parameters = Parameters { neighbours, ..parameters.clone() };
        trades.push(match &source.traded {
            Some(traded) => traded.trade(model, &parameters, progress)?,
            None => trade_scene(model, &parameters, None, progress)?,
        });
    }
    let mut output = Output::new(&source.folder, [("scene", source.scene.to_toml()?)]);
    let creeps = write(source, &trades, &mut output)?;
    let trade = &trades[0];
    let timing = timing::table(trade)?;
    output.table(&format!("{}.timing", source.stem), &timing)?;
    let mut lines = [words::trade_lines(trade), words::creep_lines(&creeps)].concat();
    if let Some((judged, errors)) = theirs {
        let own = settings(std::slice::from_ref(trade));
        let times = timing.to_rows::<RunTime>()?;
        lines.extend(others::write(source, &judged, &own, &times, &mut output)?);
        lines.extend(errors.iter().map(|error| format!("Not judged: {error}")));
    }
    // Last: a run that is cut off before leaves no key, and is done again.
    output.text(&name, "json", &key)?;
    Ok(Written {
        files: output.files,
        lines,
        yardstick: Some(trade.proof.as_str()),
        recommended: trade.choice.as_ref().map(|choice| choice.setting.words()),
    })
}

fn write(
    source: &Source,
    trades: &[Trade],
    output: &mut Output,
) -> anyhow::Result<Vec<SolverCreep>> {
    let [trade, ..] = trades else { return Ok(Vec::new()) };
    let stem = &source.stem;
    let title = format!("{}: speed against accuracy", source.title);
    let choices: Vec<TradeChoice> = trades.iter().map(choice).collect();
    output.table(&format!("{stem}.trade"), &settings_table(&title, &settings(trades))?)?;
    let creeps = creeps(&trade.scene, &Fan::full(trade.scene.step_s))?;
    let creep_title = format!("{}: creep under half the friction", source.title);
    output.table(&format!("{stem}.trade.creep"), &creeps_table(&creep_title, &creeps)?)?;
    output.table(&format!("{stem}.trade.summary"), &choices_table(&title, &choices)?)?;
    if source.traded.is_some() {
        output
            .table(&format!("{stem}.trade.metrics"), &metrics_table(&title, &metrics(trades))?)?;
    }
    let own = settings(std::slice::from_ref(trade));
    let notes = words::notes(trade);
    let scene = &trade.scene.name;
    let choice = choices.first();
    let figure = zwidth_figures::work_precision(&title, scene, &own, choice, &notes);
    output.figure(&format!("{stem}.trade"), figure)?;
    if let Some(scene) = recommended_scene(trade)? {
        output.text(&format!("{stem}.recommended"), "toml", &scene)?;
    }
    // Pushed one way, a lever that should stand swings without a change of direction: it has none to draw.
    let turns = |solver: &str| {
        let mut own = own.iter().filter(|row| *row.solver == *solver);
        own.any(|row| row.swings.is_some_and(|n| n > 0) && row.reversals.is_some_and(|n| n > 0))
    };
    if let Some(solver) = words::chatters(trade).filter(|solver| turns(solver)) {
        // The scene's own step, a tenth of it, and events found.
        let step_s = trade.scene.step_s;
        let shown = [Fineness::StepS(step_s), Fineness::StepS(0.1 * step_s), Fineness::None];
        let shown = shown.map(|fineness| {
            let solver = if fineness == Fineness::None { "exact" } else { solver };
            Setting { solver, fineness }
        });
        let runs = courses(&trade.scene, &shown)?;
        let felt = Felt { solver, sentence: words::felt(trade, solver), title };
        output.table(&format!("{stem}.courses"), &courses_table(&trade.scene, &runs)?)?;
        let figure = zwidth_figures::finding(&runs, &own, &felt);
        output.figure(&format!("{stem}.chattering"), figure)?;
    }
    Ok(creeps)
}
