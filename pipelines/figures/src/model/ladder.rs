//! The ladder of a scene: the cost of every model against its error, and the terms that decide the
//! error.

use crate::about::FigureKind;
use crate::extent::holding;
use crate::words::{just_felt, mark, model_mark, plain, powers_axis};
use zwidth_draw::style;
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Panel, Points};
use zwidth_results::{LadderModel, LadderTerm, TermEffect};
use zwidth_study::Source;

/// Which terms a scene needs.
pub const LADDER: FigureKind = FigureKind::new(
    "ladder",
    "which terms of the model the condition needs: cost against error, and the error without each term",
    "trial",
);

/// Height of a panel, mm.
const PANEL_MM: f64 = 62.0;
/// Models that are off by less are drawn here, so that the fullest one, which is off by nothing,
/// has a place on an axis of powers.
const LEAST_OFF: f64 = 1e-3;
/// A model that does not run, or lacks a number, is drawn here.
const MOST_OFF: f64 = 1e3;

/// The ladder of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct LadderRows {
    /// Every model.
    pub models: Vec<LadderModel>,
    /// What each term does to each quantity.
    pub effects: Vec<TermEffect>,
}

/// Every model's error against its work, the choice marked; and the error that decides whether the
/// choice has a term, the largest first. The axes also cover the conditions with which the figure
/// is compared, `beside`. `notes` are below the table of models, and below the figure; `synthetic`
/// says that the scene's force was simulated as if it had been recorded.
pub fn ladder(
    own: &LadderRows,
    beside: &[LadderRows],
    notes: &[String],
    synthetic: bool,
) -> Figure {
    let all: Vec<&LadderRows> = beside.iter().chain([own]).collect();
    let scene = own.models.first().map_or("", |model| &*model.scene);
    let title = format!("{scene}: which terms of the model are needed");
    Figure {
        title: Some(plain(&title)),
        description: format!(
            "{scene}: models. On the left each point is a model with some of the terms: its work in evaluations \
             against how far it is off the fullest model, over what a person can feel, both on logarithmic axes; the \
             choice is the cheapest below one. On the right, in the same measure, the error that decides about each \
             term: of the choice without it where it is kept, of the fullest model without it where it is left out."
        ),
        panels: vec![costs(&own.models, &all), terms(&own.effects, &all)],
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: if synthetic { mark([Source::Twin]) } else { model_mark() },
        ..Figure::default()
    }
}

/// The place of an error on its axis.
fn place(off: Option<f64>) -> f64 {
    libm::log10(off.unwrap_or(MOST_OFF).clamp(LEAST_OFF, MOST_OFF))
}

/// The models of a scene, on the axes of all.
fn costs(models: &[LadderModel], all: &[&LadderRows]) -> Panel {
    let mut layers = vec![just_felt(Direction::Horizontal)];
    let (far, enough) = (style::environment_colour(4), style::environment_colour(0));
    let off = models.iter().filter(|model| !model.is_enough);
    let unchosen = models.iter().filter(|model| model.is_enough && !model.is_chosen);
    let chosen = models.iter().filter(|model| model.is_chosen);
    let groups: [(&str, Vec<&LadderModel>, _, f64); 3] = [
        ("off by more than can be felt", off.collect(), far, 3.0),
        ("enough", unchosen.collect(), enough, 3.0),
        ("chosen", chosen.collect(), style::INK, 6.0),
    ];
    for (name, own, colour, diameter_pt) in groups {
        layers.push(Layer::Points(Points {
            x: own.iter().map(|model| libm::log10(model.evaluations)).collect(),
            y: own.iter().map(|model| place(model.furthest_off)).collect(),
            colour,
            diameter_pt,
            name: own.first().map(|_| name.to_owned()),
            ..Points::default()
        }));
    }
    let shown = all.iter().flat_map(|ladder| &ladder.models);
    let works = shown.clone().map(|model| libm::log10(model.evaluations));
    let offs = shown.map(|model| place(model.furthest_off));
    let x = powers_axis("work of a run, evaluations", "").ranged(holding(works));
    let y = powers_axis("largest error over what is felt", "").ranged(holding(offs));
    Panel::new(Cell::at(0, 0), x, y, layers).titled("**a**  models").tall(PANEL_MM)
}

/// A term, the place of the largest error of the model that decides about it, and whether it is
/// kept.
struct Decided {
    term: LadderTerm,
    off: f64,
    is_kept: bool,
}

/// The terms of a scene, on the axis of all.
fn terms(effects: &[TermEffect], all: &[&LadderRows]) -> Panel {
    let judged = all.iter().flat_map(|ladder| &ladder.effects).filter(|effect| effect.is_judged);
    let shown = judged.map(|effect| place(effect.deciding_off));
    let mut terms: Vec<Decided> = Vec::new();
    for effect in effects.iter().filter(|effect| effect.is_judged) {
        let off = place(effect.deciding_off);
        match terms.iter_mut().find(|decided| decided.term == effect.term) {
            Some(decided) => decided.off = decided.off.max(off),
            None => {
                let is_kept = effect.is_kept == Some(true);
                terms.push(Decided { term: effect.term, off, is_kept });
            }
        }
    }
    terms.sort_by(|a, b| b.off.total_cmp(&a.off));
    let mut layers = vec![just_felt(Direction::Vertical)];
    for (is_kept, name, colour) in
        [(true, "kept", style::INK), (false, "left out", style::environment_colour(0))]
    {
        let rows = terms.iter().enumerate().filter(|(_, term)| term.is_kept == is_kept);
        let (x, y): (Vec<f64>, Vec<f64>) = rows.map(|(row, term)| (term.off, row as f64)).unzip();
        // Nothing of a kind has no entry in the legend.
        let name = Some(name.to_owned()).filter(|_| !x.is_empty());
        let points = Points { x, y, colour, diameter_pt: 5.0, name, ..Points::default() };
        layers.push(Layer::Points(points));
    }
    let x = powers_axis("largest error without it", "").ranged(holding(shown));
    let y = Axis::categories(terms.iter().map(|decided| decided.term.title()));
    Panel::new(Cell::at(0, 1), x, y, layers).titled("**b**  terms").tall(PANEL_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::{Range, Ticks, draw};
    use zwidth_results::TermSet;

    fn model(
        evaluations: f64,
        furthest_off: Option<f64>,
        is_enough: bool,
        is_chosen: bool,
    ) -> LadderModel {
        LadderModel {
            scene: "sine".into(),
            terms: TermSet::NONE,
            number_of_terms: 0,
            evaluations,
            steps: 0.0,
            products: 0.0,
            exponentials: 0.0,
            decisions: 0.0,
            furthest_off,
            furthest_quantity: None,
            is_enough,
            is_chosen,
        }
    }

    fn models() -> Vec<LadderModel> {
        vec![
            model(500.0, None, false, false),
            model(900.0, Some(0.4), true, true),
            model(3000.0, Some(0.0), true, false),
        ]
    }

    fn effects() -> Vec<TermEffect> {
        let effect = |term, deciding_off, is_judged, is_kept| TermEffect {
            scene: "sine".into(),
            quantity: "theta_rad".into(),
            is_judged,
            term,
            total_effect: None,
            first_order: None,
            strongest_partner: None,
            partner_second_order: None,
            off_without: None,
            deciding_off: Some(deciding_off),
            is_kept: Some(is_kept),
            reason: None,
        };
        vec![
            effect(LadderTerm::MotorLag, 0.2, true, false),
            effect(LadderTerm::Friction, 0.5, true, true),
            effect(LadderTerm::Friction, 9.0, true, true),
            effect(LadderTerm::Delay, 70.0, false, false),
        ]
    }

    fn own() -> LadderRows {
        LadderRows { models: models(), effects: effects() }
    }

    #[test]
    fn terms_stand_in_the_order_of_the_error_that_decides() {
        let panel = terms(&effects(), &[&own()]);
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
        let figure = ladder(&own(), &[], &[], false);
        assert!(figure.mark.as_deref().is_some_and(|mark| mark.starts_with("SIMULATION")));
        draw(&figure).unwrap();
        let synthetic = ladder(&own(), &[], &[], true);
        assert!(synthetic.mark.is_some_and(|mark| mark.starts_with("SYNTHETIC")));
    }

    #[test]
    fn the_conditions_of_a_study_stand_on_the_same_axes() {
        let more = vec![model(5e4, Some(0.4), true, true), model(9e4, None, false, false)];
        let (own, other) = (own(), LadderRows { models: more, effects: effects() });
        let axes = |own: &LadderRows, beside: &[LadderRows]| {
            let figure = ladder(own, beside, &[], false);
            figure.panels.iter().map(|p| (p.x.range, p.y.range)).collect::<Vec<_>>()
        };
        let all = [own.clone(), other.clone()];
        assert_eq!(axes(&own, &all), axes(&other, &all));
        assert_ne!(axes(&own, &[]), axes(&other, &[]));
        let range = Range::Holding(libm::log10(500.0), libm::log10(9e4));
        assert_eq!(axes(&own, &all)[0].0, range);
    }
}
