//! Plane-fit coefficients of free motion with their intervals: sessions side by side, one colour
//! per mode.

use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use zwidth_draw::style;
use zwidth_draw::{Axis, Cell, Direction, Figure, Intervals, Layer, Panel, dodge};
use zwidth_results::FreePlane;

/// The figure [`free_motion`].
pub const FREE_MOTION: FigureKind = FigureKind::new(
    "free_motion",
    "plane fits of free motion, sessions and modes side by side",
    "trial",
);

/// Height of a panel, mm.
const PANEL_MM: f64 = 48.0;

/// A coefficient of a plane: the label and unit of its axis, estimate and interval.
struct Coefficient {
    label: &'static str,
    unit: &'static str,
    estimate_and_ends: [fn(&FreePlane) -> f64; 3],
}

const COEFFICIENTS: [Coefficient; 3] = [
    Coefficient {
        label: "offset *c*",
        unit: "N·m",
        estimate_and_ends: [
            |fit| fit.offset_nm,
            |fit| fit.offset_ci_low_nm,
            |fit| fit.offset_ci_high_nm,
        ],
    },
    Coefficient {
        label: "inertia *I*",
        unit: "kg·m²",
        estimate_and_ends: [
            |fit| fit.inertia_kg_m2,
            |fit| fit.inertia_ci_low_kg_m2,
            |fit| fit.inertia_ci_high_kg_m2,
        ],
    },
    Coefficient {
        label: "damping *b*",
        unit: "N·m·s/rad",
        estimate_and_ends: [
            |fit| fit.damping_nm_s_per_rad,
            |fit| fit.damping_ci_low_nm_s_per_rad,
            |fit| fit.damping_ci_high_nm_s_per_rad,
        ],
    },
];

/// One panel per coefficient of torque = c + I·acc + b·vel, with the notes of the fits below.
pub fn free_motion(about: &About, fits: &[FreePlane], notes: &[String]) -> Figure {
    // The participant is left out where there is only one.
    let one = fits.windows(2).all(|pair| pair[0].participant == pair[1].participant);
    let key = |fit: &FreePlane| match one {
        true => fit.session.to_string(),
        false => format!("{} {}", fit.participant, fit.session),
    };
    let keys: Vec<String> = fits.iter().map(key).collect();
    let mut sessions = keys.clone();
    sessions.sort();
    sessions.dedup();
    let mut panels = Vec::new();
    for (i, coefficient) in COEFFICIENTS.into_iter().enumerate() {
        let mut layers = Vec::new();
        for (index, mode) in about.modes.iter().enumerate() {
            let own: Vec<(&FreePlane, &String)> =
                fits.iter().zip(&keys).filter(|(fit, _)| fit.mode == mode.id).collect();
            let at = own.iter().map(|(_, key)| {
                let session = sessions.iter().position(|session| session == *key).unwrap_or(0);
                session as f64 + dodge(index, about.modes.len())
            });
            let estimates = coefficient
                .estimate_and_ends
                .map(|pick| own.iter().map(|(fit, _)| pick(fit)).collect());
            layers.push(Layer::Intervals(Intervals {
                colour: style::mode_colour(index),
                marker: style::marker(index),
                name: Some(plain(&mode.label)),
                ..Intervals::new(Direction::Vertical, at.collect(), estimates)
            }));
        }
        let x = Axis::categories(sessions.clone());
        let y = Axis::new(coefficient.label, coefficient.unit);
        panels.push(Panel::new(Cell::at(0, i), x, y, layers).tall(PANEL_MM));
    }
    Figure {
        title: Some(plain(&format!("{}: plane fits of free motion", about.title))),
        description: format!(
            "Coefficients of torque = c + I·acceleration + b·velocity for each session and mode, with their {} \
             intervals (Newey–West).",
            percent(about.confidence)
        ),
        panels,
        footnotes: notes.iter().map(|n| plain(n)).collect(),
        mark: mark(fits.iter().map(|fit| fit.source)),
        ..Figure::default()
    }
}
