//! Figure 21: what is rendered, the model that stands for it, and the device that renders it, side
//! by side.

use super::device::front;
use super::lever_model::LeverModel;
use super::model::{Body, Part};
use crate::FigureKind;
use crate::schematic::sketch::{Lever, Point, Way, ground, line, panel, polar, right_of};
use crate::words::plain;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Figure, Layer, LegendPlace, TWO_COLUMNS_MM};
use zwidth_study::{Coordinate, Setup, Spring};
use zwidth_tables::given;

/// The figure [`translation`].
pub(crate) const TRANSLATION: FigureKind = FigureKind::new(
    "schematic.translation",
    "the rendered object, its model, and the device",
    "trial",
);

/// Corners of the three drawings, mm: one height, and together as wide as the page has room for.
const OBJECT: [Point; 2] = [(-19.0, -21.0), (24.5, 34.5)];
const MODEL: [Point; 2] = [(-46.5, -21.0), (27.0, 34.5)];
const DEVICE: [Point; 2] = [(-23.5, -21.0), (23.5, 34.5)];
/// Length of the lever, mm; the model's, which has more around it, is longer.
const LEVER_MM: f64 = 22.0;
const MODEL_MM: f64 = 27.0;
/// Turns of the torsion spring and pieces of each, and its inner and outer radius, mm.
const TURNS: f64 = 2.25;
const PIECES: f64 = 90.0;
const COIL_MM: (f64, f64) = (2.0, 7.5);

/// The study's first environment with a spring, as object, model and device; `None` without a lever
/// between stops or without a spring.
pub(crate) fn translation(setup: &Setup) -> Option<Figure> {
    let stops = setup.stops_rad()?;
    let (environment, rendered) =
        setup.environments.iter().find_map(|e| Some((e, e.scene.spring()?)))?;
    let lever = Lever::between(LEVER_MM, stops[0], stops[1]);
    let model = LeverModel {
        lever: Lever { length_mm: MODEL_MM, ..lever },
        length: Part::new("*L*", None, "m"),
        object: Body::object(None, None, None),
        finger: Some(Body::finger(None)),
        high_rad: stops[1],
    };
    let drawings = [
        ("**a**  object", OBJECT, object(&lever, rendered)),
        ("**b**  model", MODEL, model.layers()),
        ("**c**  device", DEVICE, front(setup, LEVER_MM, stops)),
    ];
    let panels = drawings.into_iter().enumerate().map(|(column, (title, corners, layers))| {
        panel(Cell::at(0, column), corners[0], corners[1], layers).titled(title)
    });
    Some(Figure {
        title: Some(format!("{}: object, model and device", plain(&environment.label))),
        description: format!(
            "{}: a beam on a torsion spring; the model with the object's spring and damper at a lever's \
             axis and the finger at its end; the device with wheel and capstan.",
            environment.label
        ),
        width_mm: TWO_COLUMNS_MM,
        column_weights: [OBJECT, MODEL, DEVICE].map(|c| c[1].0 - c[0].0).to_vec(),
        panels: panels.collect(),
        legend: LegendPlace::Hidden,
        footnotes: vec![
            "The user feels a beam on a torsion spring (a). The model has it as stiffness and damping \
             about the lever's axis, and the finger as a mass on tissue (b). Motor and brake make its \
             torque *T*_{O} by way of the shaft (c)."
                .to_owned(),
        ],
        ..Figure::default()
    })
}

/// A beam on a torsion spring, and where it rests.
fn object(lever: &Lever, rendered: Spring) -> Vec<Layer> {
    let beam = Stroke { width_pt: 3.2, ..style::mean(style::INK) };
    let words = given(rendered.stiffness_n_per_rad, "N/rad", Coordinate::Rotational);
    let mut layers = ground(&Way::through([(-7.0, -9.5), (7.0, -9.5)]), style::mean(style::INK));
    layers.push(line([(0.0, -9.5), (0.0, -COIL_MM.1)], style::mean(style::BRAKE)));
    // A spiral about the axis that ends below it.
    let pieces = (TURNS * PIECES) as usize;
    let coil = (0..=pieces).map(|i| {
        let share = i as f64 / pieces as f64;
        let turned = std::f64::consts::TAU * (0.5 + TURNS * (share - 1.0));
        polar((0.0, 0.0), COIL_MM.0 + share * (COIL_MM.1 - COIL_MM.0), turned)
    });
    layers.push(line(coil, style::mean(style::BRAKE)));
    layers.push(line([(0.0, 0.0), lever.tip()], beam));
    layers.extend(lever.rest(rendered.rest_rad));
    layers.extend(lever.push());
    layers.push(right_of(vec!["*K*_{O}".to_owned(), words], (COIL_MM.1 + 1.0, 0.0)));
    layers
}
