//! Modes, participants and repeats compared, one metric a figure, from the tables of the stage
//! `compare`.

use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_draw::style::{self, Marker, Stroke};
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Points, Reference, Ticks,
    dodge,
};
use zwidth_study::{Environment, EnvironmentId, Mode, Source, contrast_label, in_a_sentence};
use zwidth_tables::{NoteKind, Table, TableError, Values, in_coordinate, p_value, shown_unit};

/// The figure [`modes_compared`].
pub const MODES_COMPARED: FigureKind = FigureKind {
    stem: "compare",
    shows: "modes compared: means, and differences with their intervals",
    drawn_from: "trial",
};

/// The figure [`participants_compared`].
pub const PARTICIPANTS_COMPARED: FigureKind = FigureKind {
    stem: "participants",
    shows: "each participant's difference between modes",
    drawn_from: "trial",
};

/// The figure [`sessions_compared`].
pub const SESSIONS_COMPARED: FigureKind = FigureKind {
    stem: "sessions",
    shows: "each participant's change between sessions",
    drawn_from: "trial",
};

/// The figure [`repeats_compared`].
pub const REPEATS_COMPARED: FigureKind = FigureKind {
    stem: "learning",
    shows: "mean at each repeat of a condition",
    drawn_from: "trial",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 52.0;
/// Height that one participant's line takes, mm.
const PERSON_MM: f64 = 3.6;
/// From this many participants on their codes would not be read, and a panel keeps its height.
const MANY: usize = 40;
/// Width of means against that of differences.
const WEIGHTS: [f64; 2] = [1.3, 1.0];

/// A metric's tables, and what figures say of it.
#[derive(Debug, Clone, Copy)]
pub struct ComparedTables<'a> {
    /// By participant, session and condition.
    pub cells: &'a Table,
    /// By condition, over the units of analysis.
    pub means: &'a Table,
    /// Differences between modes.
    pub contrasts: &'a Table,
    /// Everybody's differences.
    pub participants: &'a Table,
    /// Changes between sessions.
    pub sessions: &'a Table,
    /// By repeat and condition.
    pub repeats: &'a Table,
    /// Differences between modes in redrawn orders.
    pub redrawn: &'a Table,
}

/// The metric as it stands on an axis.
struct Shown {
    factor: f64,
    unit: String,
    words: String,
}

impl Shown {
    fn of(about: &About, tables: ComparedTables) -> Result<Self, TableError> {
        let unit = &tables.cells.column_of("mean")?.field.unit;
        let (unit, factor) = shown_unit(unit, about.coordinate);
        let unit = if unit == "1" { String::new() } else { unit };
        let title = tables.cells.title();
        let words = title.split_once(": ").map_or(title, |(_, words)| words);
        let words = in_coordinate(words, about.coordinate);
        Ok(Self { factor, unit, words })
    }

    /// The numbers of the column of that stem as they stand on the axis; null is a gap.
    fn numbers(&self, table: &Table, stem: &str) -> Result<Vec<f64>, TableError> {
        let Values::Float(values) = &table.column_of(stem)?.values else { return Ok(Vec::new()) };
        Ok(values.iter().map(|v| v.map_or(f64::NAN, |v| v * self.factor)).collect())
    }
}

/// The panels; where there are none, one that says why.
fn or_note(panels: Vec<Panel>) -> Vec<Panel> {
    let bare = || Axis::bare(0.0, 1.0);
    match panels.is_empty() {
        true => vec![Panel::with_note(Cell::at(0, 0), bare(), bare(), "nothing to compare")],
        false => panels,
    }
}

/// The rows in which a text column has that value.
pub(crate) fn rows_with(table: &Table, columns: &[(&str, &str)]) -> Result<Vec<usize>, TableError> {
    let mut rows: Vec<usize> = (0..table.height()).collect();
    for (column, value) in columns {
        let texts = table.texts(column)?;
        rows.retain(|row| texts[*row].as_deref() == Some(value));
    }
    Ok(rows)
}

fn pick(values: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|row| values[*row]).collect()
}

/// Modes compared: for each environment, at the left everybody's mean in each mode and the mean
/// over them with its interval, at the right the differences between modes with theirs.
///
/// # Errors
/// Tables that are not of the stage `compare`.
pub fn modes_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    tables: ComparedTables,
) -> Result<Figure, TableError> {
    let shown = Shown::of(about, tables)?;
    let (mut panels, mut verdicts) = (Vec::new(), Vec::new());
    for environment in environments {
        let id = environment.id.as_str();
        if rows_with(tables.means, &[("environment", id)])?.is_empty() {
            continue;
        }
        let row = panels.len() / 2;
        let modes = Axis::categories(mode_names(about, id, tables)?);
        let axis = |label: &str| Axis::new(label, shown.unit.as_str()).linked(label);
        let title = plain(&environment.label);
        let panel =
            Panel::new(Cell::at(row, 0), modes, axis("mean"), means(about, id, &shown, tables)?);
        panels.push(Panel { height_mm: Some(PANEL_MM), ..panel.titled(title) });
        let (contrasts, layers) = differences(id, &shown, tables)?;
        let names = contrasts.iter().map(|(name, verdict)| {
            let name = contrast_label(&about.modes, name);
            plain(&if contrasts.len() <= TOLD { format!("{name}: {verdict}") } else { name })
        });
        let names = Axis::categories(names);
        let (cell, y) = (Cell::at(row, 1), axis("difference"));
        let panel = match contrasts.is_empty() {
            true => Panel::with_note(cell, Axis::new("", ""), y, "no two modes to compare"),
            false => Panel::new(cell, names, y, layers),
        };
        panels.push(Panel { height_mm: Some(PANEL_MM), ..panel });
        if contrasts.len() > TOLD {
            let told = contrasts.iter().map(|(name, verdict)| {
                format!("{}: {verdict}", contrast_label(&about.modes, name))
            });
            let told = told.collect::<Vec<_>>().join("; ");
            verdicts.push(plain(&format!("{}: {told}.", environment.label)));
        }
    }
    let units = tables.means.texts("unit_of_analysis")?.into_iter().flatten().next();
    let units = units.unwrap_or_default();
    let intervals = shown.numbers(tables.means, "ci_low")?.iter().any(|low| low.is_finite());
    let level = percent(about.confidence);
    let what = match (units.strip_prefix("trials of "), intervals) {
        (None, true) => {
            format!("A line joins one person's means. Whiskers: {level} intervals, not adjusted.")
        }
        (None, false) => "A line joins one person's means.".to_owned(),
        (Some(who), true) => format!(
            "Left, dots: repeats; whiskers: {level} intervals that describe the trials of {who} and \
             test nothing."
        ),
        (Some(_), false) => "Left, dots: repeats; one value per mode has no interval.".to_owned(),
    };
    let against = (tables.redrawn.height() > 0 && units.starts_with("trials of ")).then(|| {
        "Right, grey: the differences in a hundred orders of the trials that the design could have \
         drawn, had no trial depended on mode; disc: the difference. p is the share of orders at \
         least as far from zero, after Holm."
            .to_owned()
    });
    let footnotes = [what].into_iter().chain(against).map(|note| plain(&note));
    let footnotes = footnotes.chain(jnd_note(tables.contrasts)).chain(last_note(tables.contrasts));
    let footnotes = verdicts.into_iter().chain(footnotes).collect();
    Ok(Figure {
        title: Some(plain(&format!("{}: {}", about.title, shown.words))),
        description: format!(
            "{}, modes compared: means by mode and differences between modes, with {} intervals.",
            shown.words,
            percent(about.confidence)
        ),
        panels: or_note(panels),
        column_weights: WEIGHTS.to_vec(),
        footnotes,
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// What the grey band is, where there is one.
fn jnd_note(contrasts: &Table) -> Option<String> {
    let mut notes = contrasts.notes_by_kind();
    let (_, note) = notes.find(|(kind, _)| *kind == NoteKind::Jnd)?;
    Some(plain(&format!("Band: ± 1 {note}")))
}

/// Whether the metric is the primary one.
fn last_note(contrasts: &Table) -> Option<String> {
    let mut notes = contrasts.notes().iter();
    let note = notes.find(|n| n.starts_with("Primary") || n.starts_with("Exploratory"))?;
    let first = note.split_once(". ").map_or(note.as_str(), |(first, _)| first);
    Some(plain(&format!("{}.", first.trim_end_matches('.'))))
}

/// The modes' labels; of one without any value in this environment, that it has none.
fn mode_names(
    about: &About,
    environment: &str,
    tables: ComparedTables,
) -> Result<Vec<String>, TableError> {
    let name = |mode: &Mode| {
        let keys = [("environment", environment), ("mode", mode.id.as_str())];
        let is_empty = rows_with(tables.means, &keys)?.is_empty();
        Ok(plain(&mode.label) + if is_empty { " (no value)" } else { "" })
    };
    about.modes.iter().map(name).collect()
}

/// Everybody's means, joined, and the mean over them.
fn means(
    about: &About,
    environment: &str,
    shown: &Shown,
    tables: ComparedTables,
) -> Result<Vec<Layer>, TableError> {
    let place = |mode: &str| about.modes.iter().position(|m| m.id.as_str() == mode);
    let (who, modes) = (tables.cells.texts("participant")?, tables.cells.texts("mode")?);
    let values = shown.numbers(tables.cells, "mean")?;
    let mut people: BTreeMap<&str, Vec<Vec<f64>>> = BTreeMap::new();
    for row in rows_with(tables.cells, &[("environment", environment)])? {
        let Some(place) = place(modes[row].as_deref().unwrap_or_default()) else { continue };
        let of = people.entry(who[row].as_deref().unwrap_or_default()).or_default();
        of.resize(about.modes.len(), Vec::new());
        if values[row].is_finite() {
            of[place].push(values[row]);
        }
    }
    let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let mut layers: Vec<Layer> = people
        .values()
        .map(|modes| {
            // A mode without the metric is a gap in the line.
            Layer::Line(Line {
                x: (0..modes.len()).map(|place| place as f64).collect(),
                y: modes.iter().map(mean).collect(),
                stroke: Stroke { opacity: 0.45, ..style::faint(style::GREY) },
                ..Line::default()
            })
        })
        .collect();
    if let Some(commanded) = commanded(environment, shown, tables)? {
        layers.push(Layer::Reference(Reference {
            direction: Direction::Horizontal,
            at: commanded,
            label: None,
            stroke: style::reference(),
            name: Some("commanded value".to_owned()),
        }));
    }
    for (index, mode) in about.modes.iter().enumerate() {
        let keys = [("environment", environment), ("mode", mode.id.as_str())];
        let dots: Vec<f64> = match people.len() {
            1 => pick(&shown.numbers(tables.repeats, "mean")?, &rows_with(tables.repeats, &keys)?),
            _ => people.values().map(|modes| mean(&modes[index])).collect(),
        };
        layers.push(Layer::Points(Points {
            x: vec![index as f64; dots.len()],
            y: dots,
            colour: style::mode_colour(index),
            opacity: 0.55,
            ..Points::default()
        }));
        let rows = rows_with(tables.means, &keys)?;
        let at = vec![index as f64 + ASIDE; rows.len()];
        let intervals = intervals(tables.means, ["mean", "ci_low", "ci_high"], &rows, shown)?;
        let colour = style::mode_colour(index);
        layers.push(Layer::Intervals(Intervals { at, colour, ..intervals }));
    }
    Ok(layers)
}

/// The value of the metric that an environment commands, where it does.
fn commanded(
    environment: &str,
    shown: &Shown,
    tables: ComparedTables,
) -> Result<Option<f64>, TableError> {
    if tables.contrasts.column_of("commanded").is_err() {
        return Ok(None);
    }
    let rows = rows_with(tables.contrasts, &[("environment", environment)])?;
    let values = pick(&shown.numbers(tables.contrasts, "commanded")?, &rows);
    Ok(values.first().copied().filter(|value| value.is_finite()))
}

/// Up to so many contrasts have their verdicts under them; those of more stand below the figure.
const TOLD: usize = 4;

/// Up to so many repeats are named one by one on their axis.
const NAMED_REPEATS: f64 = 12.0;

/// The axis of repeats: named places where they are few, because there is none between two.
fn repeat_axis(numbers: &[f64]) -> Axis {
    let most = numbers.iter().copied().fold(0.0, f64::max);
    let axis = match most <= NAMED_REPEATS {
        true => Axis::categories((1..=most as usize).map(|repeat| repeat.to_string())),
        false => Axis::new("", ""),
    };
    Axis { label: "repeat".to_owned(), ..axis }
}

/// The number of the repeat that stands at 0 of its axis.
fn x_of_first(axis: &Axis) -> f64 {
    if matches!(axis.ticks, Ticks::Categories(_)) { 1.0 } else { 0.0 }
}

/// How far a mean stands beside what it is the mean of, in categories.
const ASIDE: f64 = 0.18;

/// Estimates of these rows, upright, in ink.
fn intervals(
    table: &Table,
    [estimate, low, high]: [&str; 3],
    rows: &[usize],
    shown: &Shown,
) -> Result<Intervals, TableError> {
    let of = |stem| Ok::<_, TableError>(pick(&shown.numbers(table, stem)?, rows));
    Ok(Intervals {
        direction: Direction::Vertical,
        at: Vec::new(),
        estimate: of(estimate)?,
        low: of(low)?,
        high: of(high)?,
        colour: style::INK,
        marker: Marker::Disc,
        name: None,
    })
}

/// A contrast's name and its verdict.
type Judged = (String, String);

/// The contrasts' names with their verdicts, and what is drawn of them: what is not felt, zero,
/// everybody's differences, the mean; of one person's trials the differences in other orders, because
/// the claim rests on these.
fn differences(
    environment: &str,
    shown: &Shown,
    tables: ComparedTables,
) -> Result<(Vec<Judged>, Vec<Layer>), TableError> {
    let rows = rows_with(tables.contrasts, &[("environment", environment)])?;
    let names = tables.contrasts.texts("contrast")?;
    let names: Vec<String> = rows.iter().filter_map(|row| names[*row].clone()).collect();
    let verdicts = rows.iter().map(|row| verdict(tables.contrasts, *row));
    let verdicts = verdicts.collect::<Result<Vec<_>, _>>()?;
    let everybody = shown.numbers(tables.participants, "difference")?;
    let several = tables.participants.texts("participant")?;
    let several = several.windows(2).any(|pair| pair[0] != pair[1]);
    let mut layers = Vec::new();
    let jnds = match tables.contrasts.column_of("jnd") {
        Ok(_) => pick(&shown.numbers(tables.contrasts, "jnd")?, &rows),
        Err(_) => Vec::new(),
    };
    for (place, jnd) in jnds.into_iter().enumerate().filter(|(_, jnd)| jnd.is_finite()) {
        layers.push(Layer::Band(Band {
            x: [-0.45, 0.45].map(|side| place as f64 + side).to_vec(),
            low: vec![-jnd; 2],
            high: vec![jnd; 2],
            colour: style::GREY,
            name: None,
        }));
    }
    layers.push(zero(Direction::Horizontal));
    let redrawn = shown.numbers(tables.redrawn, "difference")?;
    for (place, name) in names.iter().enumerate() {
        let keys = [("environment", environment), ("contrast", name.as_str())];
        if !several {
            let of = pick(&redrawn, &rows_with(tables.redrawn, &keys)?);
            layers.push(stacked(place as f64, &of));
            continue;
        }
        let of = pick(&everybody, &rows_with(tables.participants, &keys)?);
        layers.push(Layer::Points(Points {
            x: vec![place as f64; of.len()],
            y: of,
            colour: style::GREY,
            opacity: 0.55,
            ..Points::default()
        }));
    }
    let stems = ["difference", "difference_ci_low", "difference_ci_high"];
    let aside = if several { ASIDE } else { ASIDE / 2.0 };
    let at = (0..rows.len()).map(|place| place as f64 + aside).collect();
    let means = intervals(tables.contrasts, stems, &rows, shown)?;
    let means = match several {
        true => means,
        false => {
            let none = vec![f64::NAN; means.estimate.len()];
            Intervals { low: none.clone(), high: none, ..means }
        }
    };
    layers.push(Layer::Intervals(Intervals { at, ..means }));
    Ok((names.into_iter().zip(verdicts).collect(), layers))
}

/// `different, felt, p = 0.003, 8 people`; what has a number does not break.
fn verdict(contrasts: &Table, row: usize) -> Result<String, TableError> {
    let text = |name: &str| Ok::<_, TableError>(contrasts.texts(name)?[row].clone());
    let p = contrasts.floats("p_adjusted")?[row].map(|p| format!("p {}", p_value(p)));
    let n = contrasts.integers("n")?[row].unwrap_or_default();
    let unit = match text("unit_of_analysis")?.is_some_and(|unit| unit.starts_with("trials")) {
        true => "trials",
        false => "people",
    };
    let size = contrasts.texts("size").ok().and_then(|sizes| sizes[row].clone());
    let n = Some(format!("{n}\u{a0}{unit}"));
    let p = p.map(|p| p.replace(' ', "\u{a0}"));
    let pieces: Vec<String> = [text("verdict")?, size, p, n].into_iter().flatten().collect();
    Ok(pieces.join(", "))
}

/// Differences that are equally probable, as discs one beside the other at the left of a place where
/// they are of about one size.
fn stacked(place: f64, differences: &[f64]) -> Layer {
    /// Heights at which discs stand.
    const HEIGHTS: f64 = 40.0;
    /// Room that a disc takes at most, in categories.
    const A_DISC: f64 = 0.02;
    /// Room that all of one height take at most.
    const A_STACK: f64 = 0.42;
    let (low, high) = differences
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(*d), high.max(*d)));
    let step = (high - low) / HEIGHTS;
    let mut stacks: BTreeMap<i64, usize> = BTreeMap::new();
    let mut discs = Vec::new();
    for difference in differences {
        let height = if step > 0.0 { ((difference - low) / step).round() } else { 0.0 };
        let stack = stacks.entry(height as i64).or_default();
        discs.push((*stack, low + step * height));
        *stack += 1;
    }
    let most = stacks.values().copied().max().unwrap_or(1) as f64;
    let apart = A_DISC.min(A_STACK / most);
    let (x, y) = discs.into_iter().map(|(i, y)| (place - apart * (i as f64 + 1.0), y)).unzip();
    Layer::Points(Points { x, y, colour: style::GREY, ..Points::default() })
}

fn zero(direction: Direction) -> Layer {
    Layer::Reference(Reference {
        direction,
        at: 0.0,
        label: None,
        stroke: style::zero(),
        name: None,
    })
}

/// Participants compared: everybody's difference with its interval within them, the lowest at the top,
/// one panel per contrast, one row of panels per environment.
///
/// # Errors
/// Tables that are not of the stage `compare`.
pub fn participants_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    tables: ComparedTables,
) -> Result<Figure, TableError> {
    let shown = Shown::of(about, tables)?;
    let contrasts = tables.contrasts.texts("contrast")?;
    let mut panels = Vec::new();
    for (row, environment) in with_contrasts(environments, tables)?.into_iter().enumerate() {
        let of_environment = [("environment", environment.id.as_str())];
        for (column, place) in rows_with(tables.contrasts, &of_environment)?.into_iter().enumerate()
        {
            let contrast = contrasts[place].as_deref().unwrap_or_default();
            let panel = caterpillar(&environment.id, contrast, place, &shown, tables)?;
            let contrast = contrast_label(&about.modes, contrast);
            let title = format!("{}: {}", plain(&environment.label), plain(&contrast));
            panels.push(Panel { cell: Cell::at(row, column), ..panel.titled(title) });
        }
    }
    Ok(Figure {
        title: Some(plain(&format!("{}: participants, {}", about.title, shown.words))),
        description: format!("{}: each participant's difference between modes.", shown.words),
        panels: or_note(panels),
        footnotes: vec![plain(&format!(
            "Whiskers: {} intervals within each participant, repeats as units; the lowest difference at the top. Dashed: mean over participants. Solid: zero.",
            percent(about.confidence)
        ))],
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// The environments in which modes were compared.
fn with_contrasts<'e>(
    environments: &'e [Environment],
    tables: ComparedTables,
) -> Result<Vec<&'e Environment>, TableError> {
    let found = tables.contrasts.texts("environment")?;
    let found: BTreeSet<&str> = found.iter().flatten().map(String::as_str).collect();
    Ok(environments.iter().filter(|e| found.contains(e.id.as_str())).collect())
}

/// One contrast, everybody in the order of their difference.
fn caterpillar(
    environment: &EnvironmentId,
    contrast: &str,
    place: usize,
    shown: &Shown,
    tables: ComparedTables,
) -> Result<Panel, TableError> {
    let keys = [("environment", environment.as_str()), ("contrast", contrast)];
    let mut rows = rows_with(tables.participants, &keys)?;
    let values = shown.numbers(tables.participants, "difference")?;
    rows.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    if rows.len() >= MANY {
        rows.reverse(); // numbers count upwards, names downwards
    }
    let who = tables.participants.texts("participant")?;
    let names = rows.iter().map(|row| plain(who[*row].as_deref().unwrap_or_default()));
    let (y, height) = match rows.len() {
        n if n < MANY => (Axis::categories(names), PERSON_MM * n as f64 + PERSON_MM),
        _ => (Axis::new("participants, in order", ""), MANY as f64 * PERSON_MM),
    };
    let stems = ["difference", "difference_ci_low", "difference_ci_high"];
    let whiskers = intervals(tables.participants, stems, &rows, shown)?;
    let at = (0..rows.len()).map(|row| row as f64).collect();
    let mean = shown.numbers(tables.contrasts, "difference")?[place];
    let mean = Reference {
        direction: Direction::Vertical,
        at: mean,
        label: None,
        stroke: style::reference(),
        name: None,
    };
    let layers = vec![
        zero(Direction::Vertical),
        Layer::Reference(mean),
        Layer::Intervals(Intervals { at, direction: Direction::Horizontal, ..whiskers }),
    ];
    let x = Axis::new("difference", shown.unit.as_str()).linked("difference");
    let panel = Panel::new(Cell::at(0, 0), x, y, layers);
    Ok(Panel { height_mm: Some(height), ..panel })
}

/// Learning: the mean at each repeat of a condition, one panel per environment, one line per mode.
///
/// # Errors
/// Tables that are not of the stage `compare`.
pub fn repeats_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    tables: ComparedTables,
) -> Result<Figure, TableError> {
    let shown = Shown::of(about, tables)?;
    let numbers: Vec<f64> = tables
        .repeats
        .integers("repeat")?
        .into_iter()
        .map(|repeat| repeat.map_or(f64::NAN, |repeat| repeat as f64))
        .collect();
    let repeat = repeat_axis(&numbers);
    let mut panels = Vec::new();
    for environment in environments {
        let mut layers = Vec::new();
        for (index, mode) in about.modes.iter().enumerate() {
            let keys = [("environment", environment.id.as_str()), ("mode", mode.id.as_str())];
            let rows = rows_with(tables.repeats, &keys)?;
            if rows.is_empty() {
                continue;
            }
            let (colour, marker) = (style::mode_colour(index), style::marker(index));
            let aside = dodge(index, about.modes.len()) / 2.0;
            let at: Vec<f64> =
                pick(&numbers, &rows).iter().map(|x| x - x_of_first(&repeat) + aside).collect();
            let stems = ["mean", "ci_low", "ci_high"];
            let marks = intervals(tables.repeats, stems, &rows, &shown)?;
            let (name, y) = (Some(plain(&mode.label)), marks.estimate.clone());
            let stroke = style::single(colour).dashed(style::dash(index));
            layers.push(Layer::Line(Line {
                x: at.clone(),
                y,
                stroke,
                name: name.clone(),
                ..Line::default()
            }));
            layers.push(Layer::Intervals(Intervals { at, colour, marker, name, ..marks }));
        }
        if !layers.is_empty() {
            let cell = Cell::at(0, panels.len());
            let y = Axis::new("mean", shown.unit.as_str()).linked("mean");
            let panel = Panel::new(cell, repeat.clone(), y, layers);
            let panel = panel.titled(plain(&environment.label));
            panels.push(Panel { height_mm: Some(PANEL_MM), ..panel });
        }
    }
    Ok(Figure {
        title: Some(plain(&format!("{}: learning, {}", about.title, shown.words))),
        description: format!("{}: mean at each repeat of a condition.", shown.words),
        panels: or_note(panels),
        footnotes: tables.repeats.notes().first().map(|note| plain(note)).into_iter().collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// Sessions compared: everybody's change against the mean of the two sessions (Bland–Altman), with
/// mean change and limits of agreement; one row of panels per environment, one panel per mode.
///
/// # Errors
/// Tables that are not of the stage `compare`.
pub fn sessions_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    tables: ComparedTables,
) -> Result<Figure, TableError> {
    let shown = Shown::of(about, tables)?;
    let mut panels = Vec::new();
    let mut row = 0;
    for environment in environments {
        let of_environment = [("environment", environment.id.as_str())];
        if rows_with(tables.sessions, &of_environment)?.is_empty() {
            continue;
        }
        let mut column = 0;
        for (index, mode) in about.modes.iter().enumerate() {
            let keys = [of_environment[0], ("mode", mode.id.as_str())];
            let Some(place) = rows_with(tables.sessions, &keys)?.into_iter().next() else {
                continue;
            };
            let title = format!("{}, {}", environment.label, in_a_sentence(&mode.label));
            let layers = bland_altman(&keys, place, index, &shown, tables)?;
            let x = Axis::new("mean of both", shown.unit.as_str()).linked("mean");
            let y = Axis::new("change", shown.unit.as_str()).linked("change");
            let panel = Panel::new(Cell::at(row, column), x, y, layers).titled(plain(&title));
            panels.push(Panel { height_mm: Some(PANEL_MM), ..panel });
            column += 1;
        }
        row += 1;
    }
    let which = tables.sessions.texts("sessions")?.into_iter().flatten().next();
    Ok(Figure {
        title: Some(plain(&format!("{}: sessions, {}", about.title, shown.words))),
        description: format!("{}: each participant's change between sessions.", shown.words),
        panels: or_note(panels),
        footnotes: vec![plain(&format!(
            "Change: {}. A dot is a participant. Dashed: mean change and limits of agreement.",
            which.unwrap_or_default()
        ))],
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// Everybody's change in one condition from the first session to the later one, zero, mean, limits.
fn bland_altman(
    keys: &[(&str, &str)],
    place: usize,
    mode: usize,
    shown: &Shown,
    tables: ComparedTables,
) -> Result<Vec<Layer>, TableError> {
    let which = tables.sessions.texts("sessions")?;
    let which = which[place].as_deref().and_then(|which| which.split_once(" − "));
    let (later, earlier) = which.unwrap_or_default();
    let (who, sessions) = (tables.cells.texts("participant")?, tables.cells.texts("session")?);
    let means = shown.numbers(tables.cells, "mean")?;
    let mut people: BTreeMap<Option<&str>, [f64; 2]> = BTreeMap::new();
    for row in rows_with(tables.cells, keys)? {
        let side = [later, earlier].iter().position(|s| sessions[row].as_deref() == Some(s));
        let of = people.entry(who[row].as_deref()).or_insert([f64::NAN; 2]);
        side.into_iter().for_each(|side| of[side] = means[row]);
    }
    let dots = Points {
        x: people.values().map(|[later, earlier]| (later + earlier) / 2.0).collect(),
        y: people.values().map(|[later, earlier]| later - earlier).collect(),
        colour: style::mode_colour(mode),
        ..Points::default()
    };
    let mut layers = vec![zero(Direction::Horizontal)];
    for stem in ["change", "limit_low", "limit_high"] {
        let at = shown.numbers(tables.sessions, stem)?[place];
        let stroke = style::reference();
        let direction = Direction::Horizontal;
        layers.extend(at.is_finite().then_some(Layer::Reference(Reference {
            direction,
            at,
            label: None,
            stroke,
            name: None,
        })));
    }
    layers.push(Layer::Points(dots));
    Ok(layers)
}
