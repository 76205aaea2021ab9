//! Plane-fit coefficients of free motion with their intervals: sessions side by side, one colour a
//! mode.

use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Marker};
use zwidth_draw::{Axis, Cell, Direction, Figure, Intervals, Layer, Panel, dodge};
use zwidth_study::Source;
use zwidth_tables::{Table, TableError};

/// The figure [`free_motion`].
pub const FREE_MOTION: FigureKind = FigureKind {
    stem: "free_motion",
    shows: "plane fits of free motion, sessions and modes side by side",
    drawn_from: "trial",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 48.0;

/// The coefficients: column stem and unit suffix, axis label, unit.
const COEFFICIENTS: [(&str, &str, &str, &str); 3] = [
    ("offset", "nm", "offset *c*", "N·m"),
    ("inertia", "kg_m2", "inertia *I*", "kg·m²"),
    ("damping", "nm_s_per_rad", "damping *b*", "N·m·s/rad"),
];

/// One panel a coefficient of torque = c + I·acc + b·vel. `fits` is the table of the stage
/// `freemotion`.
pub fn free_motion(about: &About, fits: &Table) -> Result<Figure, TableError> {
    let sessions = sessions(fits)?;
    let mut panels = Vec::new();
    for (i, (stem, suffix, label, unit)) in COEFFICIENTS.into_iter().enumerate() {
        let mut layers = Vec::new();
        for (index, mode) in about.modes.iter().enumerate() {
            let name = |what: &str| format!("{stem}{what}_{suffix}");
            let rows = rows_of(fits, mode.id.as_str())?;
            let pick = |column: &str| -> Result<Vec<f64>, TableError> {
                let values = fits.floats(column)?;
                Ok(rows.iter().map(|r| values[*r].unwrap_or(f64::NAN)).collect())
            };
            let keys = keys(fits)?;
            let place =
                |r: &usize| sessions.iter().position(|s| *s == keys[*r]).unwrap_or(0) as f64;
            layers.push(Layer::Intervals(Intervals {
                direction: Direction::Vertical,
                at: rows.iter().map(|r| place(r) + dodge(index, about.modes.len())).collect(),
                estimate: pick(&name(""))?,
                low: pick(&name("_ci_low"))?,
                high: pick(&name("_ci_high"))?,
                colour: style::mode_colour(index),
                marker: [Marker::Disc, Marker::Square, Marker::Diamond][index % 3],
                name: Some(plain(&mode.label)),
            }));
        }
        let panel = Panel::new(
            Cell::at(0, i),
            Axis::categories(sessions.clone()),
            Axis::new(label, unit),
            layers,
        );
        panels.push(Panel { height_mm: Some(PANEL_MM), ..panel });
    }
    Ok(Figure {
        title: Some(plain(&format!("{}: plane fits of free motion", about.title))),
        description: format!(
            "Coefficients of torque = c + I·acceleration + b·velocity for each session and mode, with their {} \
             intervals (Newey–West).",
            percent(about.confidence)
        ),
        panels,
        footnotes: fits.notes().iter().map(|n| plain(n)).collect(),
        mark: mark(fits.texts("source")?.iter().flatten().filter_map(|s| Source::from_word(s))),
        ..Figure::default()
    })
}

/// Participant and session of each row; the participant is left out where there is only one.
fn keys(fits: &Table) -> Result<Vec<String>, TableError> {
    let participants = fits.texts("participant")?;
    let one = participants.windows(2).all(|w| w[0] == w[1]);
    let pairs = participants.into_iter().zip(fits.texts("session")?);
    Ok(pairs
        .map(|(p, s)| match one {
            true => s.unwrap_or_default(),
            false => format!("{} {}", p.unwrap_or_default(), s.unwrap_or_default()),
        })
        .collect())
}

fn sessions(fits: &Table) -> Result<Vec<String>, TableError> {
    let mut sessions = keys(fits)?;
    sessions.sort();
    sessions.dedup();
    Ok(sessions)
}

fn rows_of(fits: &Table, mode: &str) -> Result<Vec<usize>, TableError> {
    let modes = fits.texts("mode")?;
    Ok((0..modes.len()).filter(|i| modes[*i].as_deref() == Some(mode)).collect())
}
