//! A scene of the model as the schematics name its parts: symbols of the thesis, numbers of the
//! scene.

use crate::words::plain;
use zwidth_draw::style::{self, Colour, Stroke};
use zwidth_draw::{Figure, LegendPlace, ONE_COLUMN_MM, Panel};
use zwidth_dynamics::{Demand, DynamicsError, Finger, ModelScene, System, Term};
use zwidth_tables::{number, with_unit};

/// A scene of the model, and how a figure of the study runs it.
#[derive(Debug, Clone, PartialEq)]
pub struct Modelled {
    /// The scene, its step that of the run.
    pub(crate) scene: ModelScene,
    /// Its file, as study.toml names it.
    file: String,
    /// Name of the solver.
    pub(crate) solver: String,
}

/// Pen of what is acted with.
pub(crate) const FORCE: Stroke = style::mean(style::INK);
/// Edge of a mass.
pub(crate) const MASS: Colour = style::GREY;

/// A part's symbol, with its number where it is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    symbol: &'static str,
    number: Option<String>,
}

impl Part {
    pub(crate) fn new(symbol: &'static str, value: Option<f64>, unit: &str) -> Self {
        let number = value.map(|value| with_unit(&number(value, None), unit));
        Self { symbol, number }
    }

    /// On one line: `K = 4 N/rad`.
    pub(crate) fn line(&self) -> String {
        match &self.number {
            Some(number) => format!("{} = {number}", self.symbol),
            None => self.symbol.to_owned(),
        }
    }

    /// The symbol, and its number below it.
    pub(crate) fn lines(&self) -> Vec<String> {
        [Some(self.symbol.to_owned()), self.number.clone()].into_iter().flatten().collect()
    }
}

/// Stiffness, damping and mass of the object or of the finger.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Body {
    pub(crate) stiffness: Part,
    pub(crate) damping: Part,
    pub(crate) mass: Part,
    pub(crate) pen: Stroke,
}

impl Body {
    /// The rendered object by its symbols, with what is known of stiffness, damping and mass.
    pub(crate) fn object(
        n_per_rad: Option<f64>,
        ns_per_rad: Option<f64>,
        mass_kg: Option<f64>,
    ) -> Self {
        Self {
            stiffness: Part::new("*K*_{O}", n_per_rad, "N/rad"),
            damping: Part::new("*B*_{O}", ns_per_rad, "N·s/rad"),
            mass: Part::new("*M*_{O}", mass_kg.map(|kg| kg * 1e3), "g"),
            pen: style::mean(style::BRAKE),
        }
    }

    /// The finger likewise.
    pub(crate) fn finger(finger: Option<Finger>) -> Self {
        Self {
            stiffness: Part::new("*K*_{F}", finger.map(|f| f.stiffness_n_per_m), "N/m"),
            damping: Part::new("*B*_{F}", finger.map(|f| f.damping_ns_per_m), "N·s/m"),
            mass: Part::new("*M*_{F}", finger.map(|f| f.mass_kg * 1e3), "g"),
            pen: style::mean(style::FINGER),
        }
    }
}

impl Modelled {
    /// A scene that can be run, with the step of the figure where that has its own.
    ///
    /// # Errors
    /// The first number of the scene that makes no sense.
    pub fn new(
        scene: ModelScene,
        file: &str,
        solver: &str,
        step_s: Option<f64>,
    ) -> Result<Self, DynamicsError> {
        let step_s = step_s.unwrap_or(scene.step_s);
        let scene = ModelScene { step_s, ..scene };
        // Only to refuse what cannot be run.
        System::new(scene.clone())?;
        Ok(Self { scene, file: file.to_owned(), solver: solver.to_owned() })
    }

    /// The rendered object; K_O and B_O are those of the scene's first spring.
    pub(crate) fn object(&self) -> Body {
        let spring = self.scene.environment.zones.iter().find_map(|zone| match zone.demand {
            Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, .. } => {
                Some((stiffness_n_per_rad, damping_ns_per_rad))
            }
            Demand::Force { .. } | Demand::Full | Demand::FullUp => None,
        });
        let (stiffness, damping) = spring.unzip();
        Body::object(stiffness, damping, Some(self.scene.plant.mass_kg))
    }

    /// The finger, where the scene has one.
    pub(crate) fn finger(&self) -> Option<Body> {
        self.scene.finger.map(|finger| Body::finger(Some(finger)))
    }

    /// Length of the lever.
    pub(crate) fn lever(&self) -> Part {
        Part::new("*L*", Some(self.scene.plant.lever_m), "m")
    }

    /// The step of the run.
    pub(crate) fn step(&self) -> Part {
        Part::new("*h*", Some(self.scene.step_s * 1e3), "ms")
    }

    /// Where the tissue is fully pressed, a sentence with a space before it; nothing where the
    /// scene does not say.
    pub(crate) fn pressed(&self) -> String {
        let length = self.scene.finger.and_then(|finger| finger.length_m);
        let at = length.map(|m| Part::new("*L*_{F0}", Some(m * 1e3), "mm").line());
        at.map(|at| format!(" The tissue is fully pressed at {at}.")).unwrap_or_default()
    }

    /// A figure of the model, one column wide, with these notes, where its numbers are from, and what
    /// the scene has and the drawings do not.
    pub(crate) fn figure(
        &self,
        title: &str,
        description: &str,
        panels: Vec<Panel>,
        notes: impl IntoIterator<Item = String>,
    ) -> Figure {
        let friction = self.scene.friction.map(|_| "friction");
        let terms: Vec<&str> =
            friction.into_iter().chain(self.scene.terms.iter().map(Term::name)).collect();
        let not_drawn = match terms.is_empty() {
            true => String::new(),
            false => format!(" Not drawn: {}.", plain(&terms.join(", "))),
        };
        let mut footnotes: Vec<String> = notes.into_iter().collect();
        footnotes.push(format!(
            "Numbers: {} ({}), the first scene that study.toml draws runs of.{not_drawn}",
            plain(&self.file),
            plain(&self.scene.name),
        ));
        Figure {
            title: Some(title.to_owned()),
            description: description.to_owned(),
            width_mm: ONE_COLUMN_MM,
            panels,
            legend: LegendPlace::Hidden,
            footnotes,
            ..Figure::default()
        }
    }
}
