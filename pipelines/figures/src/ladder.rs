//! The ladder of a scene: what every model costs against how far it is off, and which terms decide
//! that.

use crate::about::FigureKind;
use crate::extent::holding;
use crate::words::{mark, model_mark, plain};
use zwidth_draw::style;
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Panel, Points, Reference, Ticks};
use zwidth_study::Source;
use zwidth_tables::{Table, TableError};

/// Which terms a scene needs.
pub const LADDER: FigureKind = FigureKind {
    stem: "ladder",
    shows: "which terms of the model the condition needs: cost against error, and the error without each term",
    drawn_from: "trial",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 62.0;
/// Models that are off by less are drawn here, so that the fullest one, which is off by nothing,
/// has a place on an axis of powers.
const LEAST_OFF: f64 = 1e-3;
/// A model that does not run, or lacks a number, is drawn here.
const MOST_OFF: f64 = 1e3;

/// Every model's error against its work, the choice marked; and the error that decides whether the
/// choice has a term, the largest first.
/// `models` and `effects` are tables of the stage `ladder`; the axes hold those of the conditions that
/// the figure is compared with, `beside`; `synthetic` says that the scene's force was simulated as if it had been recorded.
///
/// # Errors
/// A table that lacks a column.
pub fn ladder(
    models: &Table,
    effects: &Table,
    beside: &[[Table; 2]],
    synthetic: bool,
) -> Result<Figure, TableError> {
    let all_models: Vec<&Table> = beside.iter().map(|[models, _]| models).chain([models]).collect();
    let all_effects: Vec<&Table> =
        beside.iter().map(|[_, effects]| effects).chain([effects]).collect();
    let scene = models.title().strip_suffix(": models").unwrap_or(models.title());
    let title = format!("{scene}: which terms of the model are needed");
    Ok(Figure {
        title: Some(plain(&title)),
        description: format!(
            "{}. On the left each point is a model with some of the terms: its work in evaluations against how far \
             it is off the fullest model, over what a person can feel, both on logarithmic axes; the choice is the \
             cheapest below one. On the right, in the same measure, the error that decides about each term: of the \
             choice without it where it is kept, of the fullest model without it where it is left out.",
            models.title()
        ),
        panels: vec![costs(models, &all_models)?, terms(effects, &all_effects)?],
        footnotes: models.notes().iter().map(|note| plain(note)).collect(),
        mark: if synthetic { mark([Source::Twin]) } else { model_mark() },
        ..Figure::default()
    })
}

/// The place of an error on its axis.
fn place(off: Option<f64>) -> f64 {
    libm::log10(off.unwrap_or(MOST_OFF).clamp(LEAST_OFF, MOST_OFF))
}

/// The models of a scene, on the axes of all.
fn costs(models: &Table, all: &[&Table]) -> Result<Panel, TableError> {
    let (work, off) = (models.floats("evaluations")?, models.floats("furthest_off")?);
    let (mut works, mut offs) = (Vec::new(), Vec::new());
    for table in all {
        works.extend(table.floats("evaluations")?.into_iter().flatten().map(libm::log10));
        offs.extend(table.floats("furthest_off")?.into_iter().map(place));
    }
    let (enough, chosen) = (models.flags("is_enough")?, models.flags("is_chosen")?);
    let points = |name: &str, is: &dyn Fn(usize) -> bool, colour, diameter_pt| {
        let at: Vec<usize> = (0..models.height()).filter(|i| is(*i)).collect();
        let x = at.iter().map(|i| work[*i].map_or(f64::NAN, libm::log10)).collect();
        let y = at.iter().map(|i| place(off[*i])).collect();
        let name = Some(name.to_owned()).filter(|_| !at.is_empty());
        Layer::Points(Points { x, y, colour, diameter_pt, name, ..Points::default() })
    };
    let is = |flags: &[Option<bool>], i: usize| flags[i] == Some(true);
    let layers = vec![
        Layer::Reference(Reference {
            direction: Direction::Horizontal,
            at: 0.0,
            label: Some("just felt".to_owned()),
            stroke: style::reference(),
            name: None,
        }),
        points(
            "off by more than can be felt",
            &|i| !is(&enough, i),
            style::environment_colour(4),
            3.0,
        ),
        points("enough", &|i| is(&enough, i) && !is(&chosen, i), style::environment_colour(0), 3.0),
        points("chosen", &|i| is(&chosen, i), style::INK, 6.0),
    ];
    let powers = |label: &str, values: Vec<f64>| Axis {
        ticks: Ticks::Powers,
        range: holding(values),
        ..Axis::new(label, "")
    };
    let x = powers("work of a run, evaluations", works);
    let y = powers("largest error over what is felt", offs);
    let panel = Panel::new(Cell::at(0, 0), x, y, layers).titled("**a**  models");
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

/// A term: its name, the largest error of the model that decides about it, and whether it is kept.
struct Decided {
    name: String,
    off: f64,
    is_kept: bool,
}

/// The terms of a scene, on the axis of all.
fn terms(effects: &Table, all: &[&Table]) -> Result<Panel, TableError> {
    let (names, offs) = (effects.texts("term")?, effects.floats("deciding_off")?);
    let mut shown = Vec::new();
    for table in all {
        let judged = table.flags("is_judged")?;
        let offs = table.floats("deciding_off")?.into_iter().zip(judged);
        shown.extend(offs.filter(|(_, is)| *is == Some(true)).map(|(off, _)| place(off)));
    }
    let (judged, kept) = (effects.flags("is_judged")?, effects.flags("is_kept")?);
    let mut terms: Vec<Decided> = Vec::new();
    for (i, name) in names.into_iter().enumerate() {
        let Some(name) = name.filter(|_| judged[i] == Some(true)) else { continue };
        let off = offs[i].unwrap_or(MOST_OFF).clamp(LEAST_OFF, MOST_OFF);
        match terms.iter_mut().find(|term| term.name == name) {
            Some(term) => term.off = term.off.max(off),
            None => terms.push(Decided { name, off, is_kept: kept[i] == Some(true) }),
        }
    }
    terms.sort_by(|a, b| b.off.total_cmp(&a.off));
    let points = |is_kept: bool, name: &str, colour| {
        let rows = terms.iter().enumerate().filter(|(_, term)| term.is_kept == is_kept);
        let (x, y): (Vec<f64>, Vec<f64>) =
            rows.map(|(row, term)| (libm::log10(term.off), row as f64)).unzip();
        let name = Some(name.to_owned()).filter(|_| !x.is_empty());
        Layer::Points(Points { x, y, colour, diameter_pt: 5.0, name, ..Points::default() })
    };
    let layers = vec![
        Layer::Reference(Reference {
            direction: Direction::Vertical,
            at: 0.0,
            label: Some("just felt".to_owned()),
            stroke: style::reference(),
            name: None,
        }),
        points(true, "kept", style::INK),
        points(false, "left out", style::environment_colour(0)),
    ];
    let range = holding(shown);
    let x = Axis { ticks: Ticks::Powers, range, ..Axis::new("largest error without it", "") };
    let y = Axis::categories(terms.iter().map(|term| term.name.replace('_', " ")));
    let panel = Panel::new(Cell::at(0, 1), x, y, layers).titled("**b**  terms");
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::{Range, draw};
    use zwidth_tables::Column;

    fn models() -> Table {
        let columns = vec![
            Column::float("evaluations", "1", "work", [500.0, 900.0, 3000.0].map(Some)),
            Column::float("furthest_off", "1", "error", [None, Some(0.4), Some(0.0)]),
            Column::flag("is_enough", "enough", [false, true, true].map(Some)),
            Column::flag("is_chosen", "chosen", [false, true, false].map(Some)),
        ];
        Table::new("ladder.models", "sine: models", columns).unwrap()
    }

    fn effects() -> Table {
        let columns = vec![
            Column::text("term", "term", ["motor_lag", "friction", "friction", "delay"].map(Some)),
            Column::float("deciding_off", "1", "off", [0.2, 0.5, 9.0, 70.0].map(Some)),
            Column::flag("is_judged", "judged", [true, true, true, false].map(Some)),
            Column::flag("is_kept", "kept", [false, true, true, false].map(Some)),
        ];
        Table::new("ladder.effects", "sine: effects", columns).unwrap()
    }

    #[test]
    fn terms_stand_in_the_order_of_the_error_that_decides() {
        let panel = terms(&effects(), &[&effects()]).unwrap();
        let Ticks::Categories(names) = &panel.y.ticks else { panic!("{:?}", panel.y) };
        assert_eq!(names, &["friction", "motor lag"], "what judges nothing is not shown");
        let points = |layer: &Layer| match layer {
            Layer::Points(points) => Some((points.name.clone(), points.x.clone())),
            _ => None,
        };
        let points: Vec<_> = panel.layers.iter().filter_map(points).collect();
        assert_eq!(points[0], (Some("kept".to_owned()), vec![libm::log10(9.0)]));
        assert_eq!(points[1], (Some("left out".to_owned()), vec![libm::log10(0.2)]));
    }

    #[test]
    fn it_is_drawn_with_every_letter_and_says_what_it_was_made_of() {
        let figure = ladder(&models(), &effects(), &[], false).unwrap();
        assert!(figure.mark.as_deref().is_some_and(|mark| mark.starts_with("SIMULATION")));
        draw(&figure).unwrap();
        let synthetic = ladder(&models(), &effects(), &[], true).unwrap();
        assert!(synthetic.mark.is_some_and(|mark| mark.starts_with("SYNTHETIC")));
    }

    #[test]
    fn the_conditions_of_a_study_stand_on_the_same_axes() {
        let columns = vec![
            Column::float("evaluations", "1", "work", [5e4, 9e4].map(Some)),
            Column::float("furthest_off", "1", "error", [Some(0.4), None]),
            Column::flag("is_enough", "enough", [true, false].map(Some)),
            Column::flag("is_chosen", "chosen", [true, false].map(Some)),
        ];
        let other = [Table::new("ladder.models", "step: models", columns).unwrap(), effects()];
        let own = [models(), effects()];
        let axes = |[models, effects]: &[Table; 2], beside: &[[Table; 2]]| {
            let figure = ladder(models, effects, beside, false).unwrap();
            figure.panels.iter().map(|p| (p.x.range, p.y.range)).collect::<Vec<_>>()
        };
        let all = [own.clone(), other.clone()];
        assert_eq!(axes(&own, &all), axes(&other, &all));
        assert_ne!(axes(&own, &[]), axes(&other, &[]));
        let range = Range::Holding(libm::log10(500.0), libm::log10(9e4));
        assert_eq!(axes(&own, &all)[0].0, range);
    }
}
