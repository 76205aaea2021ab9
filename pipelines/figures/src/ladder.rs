//! The ladder of a scene: what every model costs against how far it is off, and what each term does
//! to angle and force.

use crate::about::FigureKind;
use crate::words::{mark, model_mark, plain};
use zwidth_draw::style;
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Panel, Points, Range, Reference, Ticks};
use zwidth_study::Source;
use zwidth_tables::{Table, TableError};

/// Which terms a scene needs.
pub const LADDER: FigureKind = FigureKind {
    stem: "ladder",
    shows: "which terms of the model the condition needs: cost against error, and what each term does",
    drawn_from: "trial",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 62.0;
/// Models that are off by less are drawn here, so that the fullest one, which is off by nothing,
/// has a place on an axis of powers.
const LEAST_OFF: f64 = 1e-3;
/// A model that does not run, or lacks a number, is drawn here.
const MOST_OFF: f64 = 1e3;
/// The curves whose effects are shown, with their words.
const SIGNALS: [(&str, &str); 2] = [("theta_rad", "*θ*"), ("feedback_n", "force")];

/// Every model's error against its work, the choice marked; and the total effect of every term.
/// `models` and `effects` are tables of the stage `ladder`;
/// `synthetic` says that the scene's force was simulated as if it had been recorded.
///
/// # Errors
/// A table that lacks a column.
pub fn ladder(models: &Table, effects: &Table, synthetic: bool) -> Result<Figure, TableError> {
    let scene = models.title().strip_suffix(": models").unwrap_or(models.title());
    let title = format!("{scene}: which terms of the model are needed");
    Ok(Figure {
        title: Some(plain(&title)),
        description: format!(
            "{}. On the left each point is a model with some of the terms: its work in evaluations against how far \
             it is off the fullest model, over what a person can feel, both on logarithmic axes; the choice is the \
             cheapest below one. On the right the total effect of each term on angle and force.",
            models.title()
        ),
        panels: vec![costs(models)?, shares(effects)?],
        footnotes: models.notes().iter().map(|note| plain(note)).collect(),
        mark: if synthetic { mark([Source::Twin]) } else { model_mark() },
        ..Figure::default()
    })
}

fn costs(models: &Table) -> Result<Panel, TableError> {
    let (work, off) = (models.floats("evaluations")?, models.floats("furthest_off")?);
    let (enough, chosen) = (models.flags("is_enough")?, models.flags("is_chosen")?);
    let points = |name: &str, is: &dyn Fn(usize) -> bool, colour, diameter_pt| {
        let at: Vec<usize> = (0..models.height()).filter(|i| is(*i)).collect();
        let x = at.iter().map(|i| work[*i].map_or(f64::NAN, libm::log10)).collect();
        let place = |i: &usize| libm::log10(off[*i].unwrap_or(MOST_OFF).clamp(LEAST_OFF, MOST_OFF));
        let y = at.iter().map(place).collect();
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
        points("off by more than can be felt", &|i| !is(&enough, i), style::mode_colour(1), 3.0),
        points("enough", &|i| is(&enough, i) && !is(&chosen, i), style::mode_colour(0), 3.0),
        points("chosen", &|i| is(&chosen, i), style::INK, 6.0),
    ];
    let powers = |label: &str| Axis { ticks: Ticks::Powers, ..Axis::new(label, "") };
    let (x, y) = (powers("work of a run, evaluations"), powers("largest error over what is felt"));
    let panel = Panel::new(Cell::at(0, 0), x, y, layers).titled("**a**  models");
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

fn shares(effects: &Table) -> Result<Panel, TableError> {
    let (quantities, terms) = (effects.texts("quantity")?, effects.texts("term")?);
    let totals = effects.floats("total_effect")?;
    let mut names: Vec<String> = terms.iter().flatten().cloned().collect();
    let mut seen = Vec::new();
    names.retain(|name| {
        !seen.contains(name) && {
            seen.push(name.clone());
            true
        }
    });
    let signal = |(k, (quantity, words)): (usize, &(&str, &str))| {
        let rows = (0..effects.height()).filter(|i| quantities[*i].as_deref() == Some(*quantity));
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for i in rows {
            let place = names.iter().position(|name| terms[i].as_ref() == Some(name));
            if let (Some(place), Some(total)) = (place, totals[i]) {
                x.push(total);
                // Side by side, the first above.
                y.push(place as f64 + 0.24 * k as f64 - 0.12);
            }
        }
        let (colour, name) = (style::mode_colour(k + 2), Some((*words).to_owned()));
        Layer::Points(Points { x, y, colour, diameter_pt: 5.0, name, ..Points::default() })
    };
    let layers = SIGNALS.iter().enumerate().map(signal).collect();
    let x = Axis::new("total effect", "").ranged(Range::Fixed(0.0, 1.0));
    let y = Axis::categories(names.iter().map(|name| name.replace('_', " ")));
    let panel = Panel::new(Cell::at(0, 1), x, y, layers).titled("**b**  terms");
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;
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
            Column::text("quantity", "what", ["theta_rad", "theta_rad", "feedback_n"].map(Some)),
            Column::text("term", "term", ["friction", "motor_lag", "friction"].map(Some)),
            Column::float("total_effect", "1", "share", [Some(0.9), Some(0.1), None]),
        ];
        Table::new("ladder.effects", "sine: effects", columns).unwrap()
    }

    #[test]
    fn it_is_drawn_with_every_letter_and_says_what_it_was_made_of() {
        let figure = ladder(&models(), &effects(), false).unwrap();
        assert!(figure.mark.as_deref().is_some_and(|mark| mark.starts_with("SIMULATION")));
        draw(&figure).unwrap();
        let synthetic = ladder(&models(), &effects(), true).unwrap();
        assert!(synthetic.mark.is_some_and(|mark| mark.starts_with("SYNTHETIC")));
    }
}
