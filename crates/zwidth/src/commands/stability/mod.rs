//! `zwidth stability`: which virtual walls a device can render, each limit by itself; for a study,
//! whether the swings in its trials were the device's own.

mod args;
mod point;
mod recorded;
mod words;

pub(crate) use args::StabilityArgs;

use super::output::Output;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_figures::{BoundaryOf, Side, StabilityPanel, StableArea};
use zwidth_results::{BoundaryExtent, LimitKind, LimitName, StiffestWall, WallQuantity};
use zwidth_stability::{
    Boundary, Curve, Map, Point, Span, VERSION, cells_table, curves, curves_table, extent,
    extents_table, limit_points, limits, limits_table, map, measured,
};

/// What runs along x where the command names no axes; the stiffness runs along y.
const USUAL: [WallQuantity; 6] = [
    WallQuantity::WallDamping,
    WallQuantity::Delay,
    WallQuantity::Rate,
    WallQuantity::Mass,
    WallQuantity::Finger,
    WallQuantity::Step,
];

/// What `--json` prints of a limit.
#[derive(Serialize)]
struct LimitOut {
    limit: &'static str,
    kind: &'static str,
    stiffness_n_per_m: Option<f64>,
    error_share: Option<f64>,
    is_unsafe: Option<bool>,
}

/// And of all.
#[derive(Serialize)]
struct Outcome {
    name: String,
    maps: Vec<String>,
    limits: Vec<LimitOut>,
    told: Vec<String>,
    files: Vec<PathBuf>,
}

pub(crate) fn stability(
    root: &Path,
    command: &StabilityArgs,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    if let Some(study) = &command.study {
        return recorded::recorded(root, study, command, screen);
    }
    let (name, point) = point::from_args(command)?;
    let boundaries = boundaries(&command.beside, point.lever_m)?;
    let folder = command.out.clone().unwrap_or_else(|| root.join("reports").join("stability"));
    let scene = command
        .scene
        .as_ref()
        .map_or("the simulated device".to_owned(), |path| path.display().to_string());
    let made_from =
        [("of", scene), ("point", format!("{point:?}")), ("version", VERSION.to_string())];
    let mut output = Output::new(&folder, made_from);
    let limits = limits(&point)?;
    let spans = spans(command);
    let bar = screen.bar(spans.len());
    let mut maps = Vec::new();
    for [x, y] in spans {
        bar.set_message(format!("{} against {}", y.quantity.as_str(), x.quantity.as_str()));
        maps.push(map(&point, x, y)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let lines = words::limit_lines(&point, &limits);
    write(&name, &point, &maps, &boundaries, &limits, &mut output)?;
    write_boundaries(&boundaries, &point, &mut output)?;
    let outcome = Outcome {
        name,
        maps: maps.iter().map(pair).collect(),
        limits: limits.iter().map(limit_out).collect(),
        told: lines.into_iter().chain(boundaries.iter().map(words::extent)).collect(),
        files: output.files,
    };
    screen.give(&[&outcome], || {
        outcome.told.iter().for_each(|line| screen.result(line));
        screen.files(&outcome.files, &["png"], "");
    })?;
    Ok(Exit::Fine)
}

/// The pair of axes that the command names, or the usual ones.
fn spans(command: &StabilityArgs) -> Vec<[Span; 2]> {
    let cells = command.cells as usize;
    match (command.x, command.y) {
        (Some(x), Some(y)) => vec![[x, y].map(|(quantity, ends)| {
            let usual = Span::usual(quantity, cells);
            Span { ends: ends.unwrap_or(usual.ends), ..usual }
        })],
        _ => USUAL.map(|x| [x, WallQuantity::Stiffness].map(|q| Span::usual(q, cells))).to_vec(),
    }
}

fn write(
    name: &str,
    point: &Point,
    maps: &[Map],
    boundaries: &[(String, Boundary)],
    limits: &[StiffestWall],
    output: &mut Output,
) -> anyhow::Result<()> {
    let points = maps.iter().flat_map(|map| {
        let own = curves(map).into_iter().chain(measured(map));
        limit_points(map, &own.chain(of_others(map, boundaries)).collect::<Vec<_>>())
    });
    let points: Vec<_> = points.collect();
    let panels = maps.iter().map(|map| {
        let stable = map.stable().into_iter();
        let stable = stable.map(|area| StableArea { x: area.x, low: area.low, high: area.high });
        StabilityPanel {
            x: side(map.x),
            y: side(map.y),
            stable: stable.collect(),
            device: [map.x, map.y].map(|span| point.value(span.quantity)),
        }
    });
    let panels: Vec<StabilityPanel> = panels.collect();
    let notes = words::notes(point);
    output.figure(name, zwidth_figures::stability(&points, &panels, &notes))?;
    output.table(&format!("{name}.curves"), &curves_table(&points)?)?;
    output.table(&format!("{name}.limits"), &limits_table(limits)?)?;
    for map in maps {
        output.table(&format!("{name}.{}", pair(map)), &cells_table(map)?)?;
    }
    Ok(())
}

/// Boundaries whose units are known, on a map of stiffness against the wall's damping.
fn of_others(map: &Map, boundaries: &[(String, Boundary)]) -> Vec<Curve> {
    let is_map =
        (map.x.quantity, map.y.quantity) == (WallQuantity::WallDamping, WallQuantity::Stiffness);
    let drawable = boundaries.iter().filter(|(_, boundary)| is_map && boundary.is_si);
    let curves = drawable.map(|(name, boundary)| Curve {
        limit: LimitName::Others(name.as_str().into()),
        kind: LimitKind::Others,
        // A logarithmic axis has no place for a wall of no stiffness.
        pieces: vec![boundary.points.iter().copied().filter(|p| p[1] > 0.0).collect()],
    });
    curves.collect()
}

fn pair(map: &Map) -> String {
    format!("{}_{}", map.x.quantity.as_str(), map.y.quantity.as_str())
}

fn side(span: Span) -> Side {
    let quantity = span.quantity;
    Side {
        quantity,
        label: quantity.label(),
        unit: quantity.unit(),
        per_si: quantity.per_si(),
        ends: span.ends,
        is_logarithmic: quantity.is_logarithmic(),
    }
}

/// The boundaries that others measured, by the stems of their files.
fn boundaries(paths: &[PathBuf], lever_m: f64) -> anyhow::Result<Vec<(String, Boundary)>> {
    let mut boundaries: Vec<(String, Boundary)> = Vec::new();
    for path in paths {
        let text = crate::text::scene(path)?;
        let boundary = Boundary::from_csv(&text, lever_m)
            .with_context(|| format!("cannot use {}", path.display()))?;
        boundaries.push((super::simulate::stem(path), boundary));
    }
    // After all are read: a file that cannot be used is reported first.
    for (i, (name, _)) in boundaries.iter().enumerate() {
        if boundaries[..i].iter().any(|(other, _)| other == name) {
            bail!("two boundaries are called {name}; rename one of the files");
        }
    }
    Ok(boundaries)
}

fn write_boundaries(
    boundaries: &[(String, Boundary)],
    point: &Point,
    output: &mut Output,
) -> anyhow::Result<()> {
    if boundaries.is_empty() {
        return Ok(());
    }
    let drawn: Vec<BoundaryOf> = boundaries
        .iter()
        .map(|(name, boundary)| BoundaryOf {
            name: name.clone(),
            points: boundary.points.clone(),
            shares: boundary.shares(),
        })
        .collect();
    let linear = Boundary::of_lifted_map(&point.wall)?.and_then(|boundary| boundary.shares());
    let notes =
        [words::of_others(boundaries.iter().all(|(_, boundary)| boundary.is_si)).to_owned()];
    let figure = zwidth_figures::boundaries(&drawn, linear.as_deref(), &notes);
    output.figure("measured_by_others", figure)?;
    let extents: Vec<BoundaryExtent> =
        boundaries.iter().map(|(name, boundary)| extent(name, boundary)).collect();
    output.table("measured_by_others", &extents_table(&extents)?)
}

fn limit_out(limit: &StiffestWall) -> LimitOut {
    LimitOut {
        limit: limit.limit.as_str(),
        kind: limit.kind.as_str(),
        stiffness_n_per_m: limit.stiffness_n_per_m,
        error_share: limit.error_share,
        is_unsafe: limit.is_unsafe,
    }
}
