//! Fits of a thousand people in four conditions, beside psignifit.

use crate::ask;
use crate::people::{FIRST_TRIAL, comparing, uniform};
use anyhow::{Context as _, ensure};
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;
use zwidth_numerics::order::upper_median;
use zwidth_stats::psychometric::fit::{LAPSE, Model, fit};
use zwidth_stats::psychometric::grid::{Grid, posterior};
use zwidth_stats::psychometric::{Asks, LevelAnswers, Sigmoid};

const PEOPLE: u64 = 1000;
const CONDITIONS: u64 = 4;
/// psignifit takes the better part of a second for a fit: it makes these of all, evenly spread.
const OF_PEER: usize = 40;
const ROUNDS: usize = 3;
const CONFIDENCE: f64 = 0.95;
/// psignifit's grid is coarser than ours, its prior of λ counts twice, and its intervals end half a cell lower: both agree
/// to this share of an interval's length.
const OF_INTERVAL: f64 = 0.06;
/// The aim.
const AIM: f64 = 50.0;

/// Seven levels, 20 trials each.
fn answers(fit: u64) -> Vec<LevelAnswers> {
    let curve = comparing(fit);
    let of_level = |place: u64| {
        let level = 210.0 + 30.0 * place as f64;
        let share = curve.share(level);
        let is_positive = |trial: &u64| uniform(fit, FIRST_TRIAL + 20 * place + trial) < share;
        LevelAnswers { level, trials: 20, positive: (0..20).filter(is_positive).count() as u64 }
    };
    (0..7).map(of_level).collect()
}

pub(crate) fn measure(peer: [&str; 2], folder: &Path) -> anyhow::Result<()> {
    let all: Vec<Vec<LevelAnswers>> = (0..PEOPLE * CONDITIONS).map(answers).collect();
    let step = all.len() / OF_PEER;
    let file = folder.join("answers.csv");
    let mut text = String::new();
    for levels in all.iter().step_by(step) {
        let cells = levels.iter().map(|of| format!("{},{},{}", of.level, of.positive, of.trials));
        writeln!(text, "{}", cells.collect::<Vec<_>>().join(","))?;
    }
    std::fs::write(&file, text)?;
    let model =
        Model { asks: Asks::WhichWasMore, sigmoid: Sigmoid::Norm, lapse: LAPSE, is_constant: true };
    let grid = Grid { asks: Asks::WhichWasMore, sigmoid: Sigmoid::Norm, is_overdispersed: false };
    let mut rounds = Vec::new();
    let mut largest: f64 = 0.0;
    for _ in 0..ROUNDS {
        let began = Instant::now();
        let mut estimated = 0;
        for answers in &all {
            let found = fit(std::hint::black_box(answers), &model, CONFIDENCE)?;
            estimated += usize::from(found.fitted.is_some());
        }
        let fits_s = began.elapsed().as_secs_f64() / all.len() as f64;
        let began = Instant::now();
        let ours = all.iter().step_by(step).map(|answers| posterior(answers, &grid, CONFIDENCE));
        let ours = ours.collect::<Result<Vec<_>, _>>()?;
        let grid_s = began.elapsed().as_secs_f64() / ours.len() as f64;
        let said = ask(peer, &["fits", &file.to_string_lossy()])?;
        let (seconds, theirs) = said.split_first().context("the peer said nothing")?;
        let peer_s: f64 = seconds.first().context("no time")?.parse()?;
        ensure!(theirs.len() == ours.len(), "the peer fitted {} of {}", theirs.len(), ours.len());
        for (ours, line) in ours.iter().zip(theirs) {
            let numbers = line.iter().map(|number| number.parse::<f64>());
            let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
            let length = ours.threshold.ci_high - ours.threshold.ci_low;
            let own = [ours.threshold.mean, ours.threshold.ci_low, ours.threshold.ci_high];
            for (ours, theirs) in own.iter().zip(&numbers) {
                largest = largest.max((ours - theirs).abs() / length);
            }
        }
        ensure!(largest < OF_INTERVAL, "the two differ by {largest} of an interval");
        ensure!(estimated > all.len() / 2, "{estimated} of {} have an estimate", all.len());
        rounds.push([fits_s, grid_s, peer_s]);
    }
    let median = |of: fn(&[f64; 3]) -> f64| upper_median(rounds.iter().map(of)).unwrap_or(f64::NAN);
    let ratio = median(|[fits, _, peer]| peer / fits);
    println!("| what | s a fit | psignifit / this |");
    println!("| --- | --- | --- |");
    println!(
        "| zwidth, maximum likelihood with profile intervals, {} fits | {:.6} | **{ratio:.0}** |",
        all.len(),
        median(|[fits, _, _]| *fits)
    );
    println!(
        "| zwidth, `grid`, {OF_PEER} fits | {:.6} | {:.0} |",
        median(|[_, grid, _]| *grid),
        median(|[_, grid, peer]| peer / grid)
    );
    println!("| psignifit, {OF_PEER} fits | {:.4} | 1 |", median(|[_, _, peer]| *peer));
    println!(
        "\nThresholds of `grid` and their intervals differ from psignifit's by at most {:.1} % of an interval's length. Medians of \
         {ROUNDS} rounds. The aim is {AIM}: {}.",
        100.0 * largest,
        if ratio >= AIM { "reached" } else { "not reached" }
    );
    Ok(())
}
