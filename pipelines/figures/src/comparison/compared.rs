//! Modes, participants and repeats compared, one metric per figure, from the tables of the stage
//! `compare`.

use crate::words::{logarithms_axis, mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::BTreeMap;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Points, Reference, dodge,
};
use zwidth_results as results;
use zwidth_results::{
    Compared, DosePoint, EffectDifference, GroupDifference, GroupMean, GroupMember, Mean,
    MetricNote, ModeDifference, NoteKind, PersonDifference, RedrawnDifference, RepeatMean, Role,
    Row as _, SessionChange, UnitOfAnalysis,
};
use zwidth_study::{
    Contrast, Environment, EnvironmentId, Mode, ParticipantId, Source, contrast_label,
    in_a_sentence, ratio_label,
};
use zwidth_tables::{Amounts, in_coordinate, p_value};

/// The figure [`modes_compared`].
pub const MODES_COMPARED: FigureKind = FigureKind::new(
    "compare",
    "modes compared: means, and differences with their intervals",
    "trial",
);

/// The figure [`participants_compared`].
pub const PARTICIPANTS_COMPARED: FigureKind =
    FigureKind::new("participants", "each participant's difference between modes", "trial");

/// The figure [`sessions_compared`].
pub const SESSIONS_COMPARED: FigureKind =
    FigureKind::new("sessions", "each participant's change between sessions", "trial");

/// The figure [`repeats_compared`].
pub const REPEATS_COMPARED: FigureKind =
    FigureKind::new("learning", "mean at each repeat of a condition", "trial");

/// How groups of people enter a mean over all of them.
pub(super) const EQUAL_WEIGHTS: &str = "Over all people each group has the same weight; intervals and standard deviations are \
     of people within groups.";

/// What stands below figures of a metric that was chosen after the data.
const CHOSEN_AFTER: &str = "Exploratory: chosen after the data.";

/// [`CHOSEN_AFTER`], where it is so.
pub(super) fn chosen_after(compared: &MetricResults) -> Option<String> {
    (compared.metric.role == Role::ChosenAfter).then(|| CHOSEN_AFTER.to_owned())
}

/// Height of a panel, mm.
pub(super) const PANEL_MM: f64 = 52.0;
/// Height that one participant's line takes, mm.
const PERSON_MM: f64 = 3.6;
/// From this many participants on their codes would not be read, and a panel keeps its height.
const MANY: usize = 40;
/// Width of means against that of differences, whose names have the longer words.
pub(super) const WEIGHTS: [f64; 2] = [0.95, 1.0];

/// The results for one metric.
#[derive(Debug, Clone)]
pub struct MetricResults {
    /// The metric.
    pub metric: Compared,
    /// By participant, session and condition.
    pub cells: Vec<results::Cell>,
    /// By condition, over the units of analysis.
    pub means: Vec<Mean>,
    /// Differences between modes.
    pub contrasts: Vec<ModeDifference>,
    /// Everybody's differences.
    pub participants: Vec<PersonDifference>,
    /// Differences between groups, if there are groups.
    pub groups: Vec<GroupDifference>,
    /// Effects of factors, if there are factors.
    pub effects: Vec<EffectDifference>,
    /// Its curves over doses.
    pub trend_curves: Vec<DosePoint>,
    /// Means of groups by condition.
    pub group_means: Vec<GroupMean>,
    /// Who is of which group.
    pub group_members: Vec<GroupMember>,
    /// Changes between sessions.
    pub sessions: Vec<SessionChange>,
    /// By repeat and condition.
    pub repeats: Vec<RepeatMean>,
    /// Differences between modes in redrawn orders.
    pub redrawn: Vec<RedrawnDifference>,
    /// The notes on these.
    pub notes: Vec<MetricNote>,
}

impl MetricResults {
    /// The notes below the table of that name.
    fn notes_below(&self, table: &str) -> impl Iterator<Item = &MetricNote> {
        self.notes.iter().filter(move |note| note.table == table)
    }
}

/// The metric as it stands on axes. Of one of logarithms values are what they are the logarithms of, and differences are
/// ratios, both on logarithmic axes.
pub(super) struct Shown {
    pub(super) amounts: Amounts,
    pub(super) words: String,
}

impl Shown {
    pub(super) fn of(about: &About, metric: &Compared) -> Self {
        let amounts = Amounts::of(&metric.unit, about.coordinate);
        Self { amounts, words: in_coordinate(&metric.words, about.coordinate) }
    }

    /// An axis of values, shared by the panels of a figure.
    pub(super) fn axis(&self, label: &str) -> Axis {
        let unit = if self.amounts.unit() == "1" { "" } else { self.amounts.unit() };
        let axis = match self.amounts.are_logarithms() {
            true => logarithms_axis(label, unit),
            false => Axis::new(label, unit),
        };
        axis.linked(label)
    }

    /// The same of differences.
    pub(super) fn differences_axis(&self, label: &str) -> Axis {
        match (self.amounts.are_logarithms(), label) {
            (false, _) => self.axis(label),
            (true, "difference") => logarithms_axis("ratio", "").linked(label),
            (true, _) => logarithms_axis(&format!("{label}, ratio"), "").linked(label),
        }
    }

    /// A value as it stands on an axis.
    pub(super) fn value(&self, own: f64) -> f64 {
        match self.amounts.are_logarithms() {
            true => own + libm::log(self.amounts.factor()),
            false => own * self.amounts.factor(),
        }
    }

    /// The value that stands there.
    pub(super) fn own(&self, value: f64) -> f64 {
        match self.amounts.are_logarithms() {
            true => value - libm::log(self.amounts.factor()),
            false => value / self.amounts.factor(),
        }
    }

    /// A difference as it stands on an axis of differences.
    pub(super) fn difference(&self, own: f64) -> f64 {
        if self.amounts.are_logarithms() { own } else { own * self.amounts.factor() }
    }

    /// Two modes of a difference.
    pub(super) fn contrast(&self, modes: &[Mode], contrast: &Contrast) -> String {
        compared_modes(modes, contrast, &self.amounts)
    }
}

/// Two modes by their labels: `Hybrid − Active`, of logarithms `Hybrid / Active`.
pub(super) fn compared_modes(modes: &[Mode], contrast: &Contrast, amounts: &Amounts) -> String {
    match amounts.are_logarithms() {
        true => ratio_label(modes, contrast),
        false => contrast_label(modes, contrast),
    }
}

/// The panels; where there are none, one that says why.
pub(super) fn or_note(panels: Vec<Panel>) -> Vec<Panel> {
    let bare = Axis::bare(0.0, 1.0);
    match panels.is_empty() {
        true => vec![Panel::with_note(Cell::at(0, 0), bare.clone(), bare, "nothing to compare")],
        false => panels,
    }
}

/// Modes compared: for each environment, at the left everybody's mean in each mode and the mean
/// over them with its interval, at the right the differences between modes with theirs.
pub fn modes_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let mut panels = Vec::new();
    let mut verdicts = Vec::new();
    for environment in environments {
        if !compared.means.iter().any(|mean| mean.environment == environment.id) {
            continue;
        }
        let row = panels.len() / 2;
        let modes = Axis::categories(mode_names(about, &environment.id, compared));
        let title = plain(&environment.label);
        let layers = means(about, &environment.id, &shown, compared);
        let panel = Panel::new(Cell::at(row, 0), modes, shown.axis("mean"), layers);
        panels.push(panel.titled(title).tall(PANEL_MM));
        let contrasts: Vec<&ModeDifference> =
            compared.contrasts.iter().filter(|row| row.environment == environment.id).collect();
        let are_few = contrasts.len() <= FEW_CONTRASTS;
        let names = contrasts.iter().map(|row| match are_few {
            true => plain(&verdict(&about.modes, row, &shown)),
            false => plain(&shown.contrast(&about.modes, &row.contrast)),
        });
        let names = Axis::categories(names);
        let cell = Cell::at(row, 1);
        let y = shown.differences_axis("difference");
        let panel = match contrasts.is_empty() {
            true => Panel::with_note(cell, Axis::new("", ""), y, "no two modes to compare"),
            false => Panel::new(cell, names, y, differences(&contrasts, &shown, compared)),
        };
        panels.push(panel.tall(PANEL_MM));
        if !are_few {
            let all: Vec<String> =
                contrasts.iter().map(|row| verdict(&about.modes, row, &shown)).collect();
            verdicts.push(plain(&format!("{}: {}.", environment.label, all.join("; "))));
        }
    }
    let intervals = compared.means.iter().any(|mean| mean.ci_low.is_some());
    let level = percent(about.confidence);
    let of_one = compared.metric.unit_of_analysis != UnitOfAnalysis::Participants;
    let what = match (&compared.metric.unit_of_analysis, intervals) {
        (UnitOfAnalysis::Participants, true) => {
            format!("A line joins one person's means. Whiskers: {level} intervals, not adjusted.")
        }
        (UnitOfAnalysis::Participants, false) => "A line joins one person's means.".to_owned(),
        (UnitOfAnalysis::TrialsOf(who), true) => format!(
            "Left, dots: repeats; whiskers: {level} intervals that describe the trials of {who} and \
             test nothing."
        ),
        (UnitOfAnalysis::TrialsOf(_), false) => {
            "Left, dots: repeats; one value per mode has no interval.".to_owned()
        }
    };
    let against = (!compared.redrawn.is_empty() && of_one).then(|| {
        "Right, grey: the differences in a hundred orders of the trials that the design could have \
         drawn, had no trial depended on mode; disc: the difference. p is the share of orders at \
         least as far from zero, after Holm."
            .to_owned()
    });
    let mut jnds = compared.notes_below(ModeDifference::NAME);
    let band = jnds.find(|note| note.kind == NoteKind::Jnd);
    let band = band.map(|note| format!("Band: ± 1 {}", note.note));
    let role = match (compared.metric.role, about.has_several_primary) {
        (Role::Primary, false) => "Primary metric.",
        (Role::Primary, true) => "A primary metric.",
        (Role::Exploratory, false) => "Exploratory: not the primary metric.",
        (Role::Exploratory, true) => "Exploratory: not a primary metric.",
        (Role::ChosenAfter, _) => CHOSEN_AFTER,
    };
    let weights = (!compared.groups.is_empty()).then(|| EQUAL_WEIGHTS.to_owned());
    let footnotes = [what].into_iter().chain(weights).chain(against).chain(band);
    let footnotes = footnotes.chain([role.to_owned()]);
    let footnotes = verdicts.into_iter().chain(footnotes.map(|note| plain(&note))).collect();
    Figure {
        title: Some(plain(&format!("{}: {}", about.title, shown.words))),
        description: format!(
            "{}, modes compared: means by mode and differences between modes, with {level} intervals.",
            shown.words
        ),
        panels: or_note(panels),
        column_weights: WEIGHTS.to_vec(),
        footnotes,
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// The modes' labels; of one without any value in this environment, that it has none.
fn mode_names(about: &About, environment: &EnvironmentId, compared: &MetricResults) -> Vec<String> {
    let mut names = Vec::new();
    for mode in &about.modes {
        let mut means = compared.means.iter();
        let has_mean = means.any(|mean| (&mean.environment, &mean.mode) == (environment, &mode.id));
        names.push(plain(&mode.label) + if has_mean { "" } else { " (no value)" });
    }
    names
}

/// Everybody's means, joined, and the mean over them.
fn means(
    about: &About,
    environment: &EnvironmentId,
    shown: &Shown,
    compared: &MetricResults,
) -> Vec<Layer> {
    let mut people: BTreeMap<&ParticipantId, Vec<Vec<f64>>> = BTreeMap::new();
    for cell in compared.cells.iter().filter(|cell| cell.environment == *environment) {
        let place = about.modes.iter().position(|mode| mode.id == cell.mode);
        let Some(place) = place else { continue };
        // A person's sessions come together: the mean is over all of them.
        let own = people.entry(&cell.participant).or_default();
        own.resize(about.modes.len(), Vec::new());
        own[place].extend(cell.mean.map(|mean| shown.value(mean)));
    }
    let mut layers = Vec::new();
    for modes in people.values() {
        // A mode without the metric is a gap in the line.
        layers.push(Layer::Line(Line {
            x: (0..modes.len()).map(|place| place as f64).collect(),
            y: modes.iter().map(|values| mean(values)).collect(),
            stroke: Stroke { opacity: 0.45, ..style::faint(style::GREY) },
            ..Line::default()
        }));
    }
    let mut contrasts = compared.contrasts.iter().filter(|row| row.environment == *environment);
    if let Some(commanded) = contrasts.find_map(|row| row.commanded) {
        let at = shown.value(commanded);
        let line = Reference::new(Direction::Horizontal, at, style::reference());
        let name = Some("commanded value".to_owned());
        layers.push(Layer::Reference(Reference { name, ..line }));
    }
    for (index, mode) in about.modes.iter().enumerate() {
        let key = (environment, &mode.id);
        let colour = style::mode_colour(index);
        let repeats = compared.repeats.iter().filter(|row| (&row.environment, &row.mode) == key);
        // Of one person the repeats are the units; of several, the people.
        let dots: Vec<f64> = match people.len() {
            1 => repeats.map(|row| row.mean.map_or(f64::NAN, |own| shown.value(own))).collect(),
            _ => people.values().map(|modes| mean(&modes[index])).collect(),
        };
        let x = apart(index as f64, &dots);
        let dots = Points { x, y: dots, colour, opacity: 0.55, ..Points::default() };
        layers.push(Layer::Points(dots));
        let means = compared.means.iter().filter(|row| (&row.environment, &row.mode) == key);
        let estimates: Vec<_> =
            means.map(|row| [Some(row.mean), row.ci_low, row.ci_high]).collect();
        let at = vec![index as f64 + ASIDE; estimates.len()];
        let value = |own| shown.value(own);
        let marks = intervals(Direction::Vertical, at, &estimates, value);
        layers.push(Layer::Intervals(Intervals { colour, ..marks }));
    }
    layers
}

/// Where dots stand: at a place, and those of equal values one beside the other at its left, so that
/// none hides another.
pub(super) fn apart(place: f64, values: &[f64]) -> Vec<f64> {
    /// Room that a dot takes at most, in categories.
    const A_DOT: f64 = 0.06;
    /// Room that all of one value take at most.
    const A_ROW: f64 = 0.3;
    let mut rows: BTreeMap<u64, usize> = BTreeMap::new();
    let nth = values.iter().map(|value| {
        let row = rows.entry((value + 0.0).to_bits()).or_default(); // the two zeros are equal
        *row += 1;
        *row - 1
    });
    let nth: Vec<usize> = nth.collect();
    let most = rows.values().copied().max().unwrap_or(1) as f64;
    let step = A_DOT.min(A_ROW / most);
    nth.iter().map(|nth| place - step * *nth as f64).collect()
}

/// NaN of no values, which is a gap.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Up to so many contrasts have their verdicts under them; those of more stand below the figure.
const FEW_CONTRASTS: usize = 4;

/// Up to so many repeats are named one by one on their axis.
const NAMED_REPEATS: f64 = 12.0;

/// How far a mean stands beside what it is the mean of, in categories.
const ASIDE: f64 = 0.18;

/// Estimates with the ends of their intervals, in ink, each where `placed` says that it stands; null is a gap.
pub(super) fn intervals(
    direction: Direction,
    at: Vec<f64>,
    estimates: &[[Option<f64>; 3]],
    placed: impl Fn(f64) -> f64,
) -> Intervals {
    let column = |i: usize| estimates.iter().map(|row| row[i].map_or(f64::NAN, &placed)).collect();
    Intervals::new(direction, at, [column(0), column(1), column(2)])
}

/// What is drawn of an environment's contrasts: what is not felt, zero, everybody's differences, the
/// mean; of one person's trials the differences in other orders, because the claim rests on these.
fn differences(
    contrasts: &[&ModeDifference],
    shown: &Shown,
    compared: &MetricResults,
) -> Vec<Layer> {
    let several =
        compared.participants.windows(2).any(|two| two[0].participant != two[1].participant);
    let mut layers = Vec::new();
    for (place, row) in contrasts.iter().enumerate() {
        let Some(jnd) = row.jnd.map(|jnd| shown.difference(jnd)) else { continue };
        layers.push(Layer::Band(Band {
            x: [-0.45, 0.45].map(|side| place as f64 + side).to_vec(),
            low: vec![-jnd; 2],
            high: vec![jnd; 2],
            colour: style::GREY,
            name: None,
        }));
    }
    layers.push(zero(Direction::Horizontal));
    for (place, row) in contrasts.iter().enumerate() {
        let key = (&row.environment, &row.contrast);
        // The claim about one person rests on the orders that might have been drawn, not on trials.
        if !several {
            let redrawn = compared.redrawn.iter().filter(|r| (&r.environment, &r.contrast) == key);
            let redrawn: Vec<f64> = redrawn.map(|r| shown.difference(r.difference)).collect();
            layers.push(stacked(place as f64, &redrawn));
            continue;
        }
        let people = compared.participants.iter().filter(|r| (&r.environment, &r.contrast) == key);
        let y: Vec<f64> = people.map(|person| shown.difference(person.difference)).collect();
        let x = apart(place as f64, &y);
        let dots = Points { x, y, colour: style::GREY, opacity: 0.55, ..Points::default() };
        layers.push(Layer::Points(dots));
    }
    let aside = if several { ASIDE } else { ASIDE / 2.0 };
    let at = (0..contrasts.len()).map(|place| place as f64 + aside).collect();
    let estimates = contrasts.iter().map(|row| match several {
        true => [Some(row.difference), row.difference_ci_low, row.difference_ci_high],
        false => [Some(row.difference), None, None],
    });
    let estimates: Vec<[Option<f64>; 3]> = estimates.collect();
    let placed = |own| shown.difference(own);
    layers.push(Layer::Intervals(intervals(Direction::Vertical, at, &estimates, placed)));
    layers
}

/// `hybrid − active: different, felt, p = 0.003, 8 people`; what has a number does not break.
fn verdict(modes: &[Mode], row: &ModeDifference, shown: &Shown) -> String {
    let unit = match row.unit_of_analysis {
        UnitOfAnalysis::TrialsOf(_) => "trials",
        UnitOfAnalysis::Participants => "people",
    };
    let size = row.size.map(|size| size.as_str().to_owned());
    let p = row.p_adjusted.map(|p| format!("p {}", p_value(p)).replace(' ', "\u{a0}"));
    let n = Some(format!("{}\u{a0}{unit}", row.n));
    let verdict = Some(row.verdict.as_str().to_owned());
    let parts: Vec<String> = [verdict, size, p, n].into_iter().flatten().collect();
    format!("{}: {}", shown.contrast(modes, &row.contrast), parts.join(", "))
}

/// Differences that are equally probable, as discs one beside the other at the left of a place where
/// they are of about one size.
pub(super) fn stacked(place: f64, differences: &[f64]) -> Layer {
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
        // Differences that are all equal make one stack.
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

pub(super) fn zero(direction: Direction) -> Layer {
    Layer::Reference(Reference::new(direction, 0.0, style::zero()))
}

/// Participants compared: each participant's difference with its interval within the participant,
/// the lowest at the top, one panel per contrast, one row of panels per environment.
pub fn participants_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let mut panels = Vec::new();
    let mut row = 0;
    for environment in environments {
        let contrasts = compared.contrasts.iter().filter(|row| row.environment == environment.id);
        let mut column = 0;
        for contrast in contrasts {
            let panel = caterpillar(contrast, &shown, compared);
            let label = shown.contrast(&about.modes, &contrast.contrast);
            let title = format!("{}: {}", plain(&environment.label), plain(&label));
            panels.push(Panel { cell: Cell::at(row, column), ..panel.titled(title) });
            column += 1;
        }
        // An environment of which nothing is drawn takes no row.
        row += usize::from(column > 0);
    }
    Figure {
        title: Some(plain(&format!("{}: participants, {}", about.title, shown.words))),
        description: format!("{}: each participant's difference between modes.", shown.words),
        panels: or_note(panels),
        footnotes: [format!(
            "Whiskers: {} intervals within each participant, repeats as units; the lowest difference at the top. Dashed: mean over participants. Solid: zero.",
            percent(about.confidence)
        )]
        .into_iter()
        .chain(chosen_after(compared))
        .map(|note| plain(&note))
        .collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// One contrast, everybody in the order of their difference.
fn caterpillar(contrast: &ModeDifference, shown: &Shown, compared: &MetricResults) -> Panel {
    let key = (&contrast.environment, &contrast.contrast);
    let people =
        compared.participants.iter().filter(|row| (&row.environment, &row.contrast) == key);
    let mut people: Vec<&PersonDifference> = people.collect();
    people.sort_by(|a, b| a.difference.total_cmp(&b.difference));
    if people.len() >= MANY {
        people.reverse(); // numbers count upwards, names downwards
    }
    let names = people.iter().map(|person| plain(person.participant.as_str()));
    let (y, height) = match people.len() {
        n if n < MANY => (Axis::categories(names), PERSON_MM * n as f64 + PERSON_MM),
        _ => (Axis::new("participants, in order", ""), MANY as f64 * PERSON_MM),
    };
    let estimates: Vec<_> = people
        .iter()
        .map(|row| [Some(row.difference), row.difference_ci_low, row.difference_ci_high])
        .collect();
    let at = (0..people.len()).map(|row| row as f64).collect();
    let mean = shown.difference(contrast.difference);
    let placed = |own| shown.difference(own);
    let layers = vec![
        zero(Direction::Vertical),
        Layer::Reference(Reference::new(Direction::Vertical, mean, style::reference())),
        Layer::Intervals(intervals(Direction::Horizontal, at, &estimates, placed)),
    ];
    Panel::new(Cell::at(0, 0), shown.differences_axis("difference"), y, layers).tall(height)
}

/// Learning: the mean at each repeat of a condition, one panel per environment, one line per mode.
pub fn repeats_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let most = compared.repeats.iter().map(|row| row.repeat as f64).fold(0.0, f64::max);
    // Named places where repeats are few, because there is none between two; the first stands at 0.
    let (axis, first) = match most <= NAMED_REPEATS {
        true => (Axis::categories((1..=most as usize).map(|repeat| repeat.to_string())), 1.0),
        false => (Axis::new("", ""), 0.0),
    };
    let repeat = Axis { label: "repeat".to_owned(), ..axis };
    let mut panels = Vec::new();
    for environment in environments {
        let mut layers = Vec::new();
        for (index, mode) in about.modes.iter().enumerate() {
            let key = (&environment.id, &mode.id);
            let rows = compared.repeats.iter().filter(|row| (&row.environment, &row.mode) == key);
            let rows: Vec<&RepeatMean> = rows.collect();
            if rows.is_empty() {
                continue;
            }
            let colour = style::mode_colour(index);
            let marker = style::marker(index);
            let aside = dodge(index, about.modes.len()) / 2.0;
            let x: Vec<f64> = rows.iter().map(|row| row.repeat as f64 - first + aside).collect();
            let estimates: Vec<_> =
                rows.iter().map(|row| [row.mean, row.ci_low, row.ci_high]).collect();
            let value = |own| shown.value(own);
            let marks = intervals(Direction::Vertical, x.clone(), &estimates, value);
            let y = marks.estimate.clone();
            let stroke = style::single(colour).dashed(style::dash(index));
            let name = Some(plain(&mode.label));
            let line = Line { x, y, stroke, name: name.clone(), ..Line::default() };
            layers.push(Layer::Line(line));
            layers.push(Layer::Intervals(Intervals { colour, marker, name, ..marks }));
        }
        if !layers.is_empty() {
            let cell = Cell::at(0, panels.len());
            let panel = Panel::new(cell, repeat.clone(), shown.axis("mean"), layers);
            panels.push(panel.titled(plain(&environment.label)).tall(PANEL_MM));
        }
    }
    Figure {
        title: Some(plain(&format!("{}: learning, {}", about.title, shown.words))),
        description: format!("{}: mean at each repeat of a condition.", shown.words),
        panels: or_note(panels),
        footnotes: compared
            .notes_below(RepeatMean::NAME)
            .take(1)
            .map(|note| note.note.to_string())
            .chain(chosen_after(compared))
            .map(|note| plain(&note))
            .collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// Sessions compared: each participant's change against the mean of the two sessions
/// (Bland–Altman), with mean change and limits of agreement; one row of panels per environment, one
/// panel per mode.
pub fn sessions_compared(
    about: &About,
    environments: &[Environment],
    sources: &[Source],
    compared: &MetricResults,
) -> Figure {
    let shown = Shown::of(about, &compared.metric);
    let mut panels = Vec::new();
    let mut row = 0;
    for environment in environments {
        let mut column = 0;
        for (index, mode) in about.modes.iter().enumerate() {
            let key = (&environment.id, &mode.id);
            let mut changes = compared.sessions.iter();
            let change = changes.find(|change| (&change.environment, &change.mode) == key);
            let Some(change) = change else { continue };
            let title = format!("{}, {}", environment.label, in_a_sentence(&mode.label));
            let layers = bland_altman(change, index, &shown, compared);
            let x = shown.axis("mean of both").linked("mean");
            let y = shown.differences_axis("change");
            let panel = Panel::new(Cell::at(row, column), x, y, layers).titled(plain(&title));
            panels.push(panel.tall(PANEL_MM));
            column += 1;
        }
        row += usize::from(column > 0);
    }
    let which = compared.sessions.first().map(|change| change.sessions.to_string());
    Figure {
        title: Some(plain(&format!("{}: sessions, {}", about.title, shown.words))),
        description: format!("{}: each participant's change between sessions.", shown.words),
        panels: or_note(panels),
        footnotes: [format!(
            "Change: {}. A dot is a participant. Dashed: mean change and limits of agreement.",
            which.unwrap_or_default()
        )]
        .into_iter()
        .chain(chosen_after(compared))
        .map(|note| plain(&note))
        .collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// Everybody's change in one condition from the first session to the later one, zero, mean, limits.
fn bland_altman(
    change: &SessionChange,
    mode: usize,
    shown: &Shown,
    compared: &MetricResults,
) -> Vec<Layer> {
    let mut people: BTreeMap<&ParticipantId, [f64; 2]> = BTreeMap::new();
    for cell in &compared.cells {
        if (&cell.environment, &cell.mode) != (&change.environment, &change.mode) {
            continue;
        }
        let sides = [&change.sessions.later, &change.sessions.earlier];
        let own = people.entry(&cell.participant).or_insert([f64::NAN; 2]);
        if let Some(side) = sides.iter().position(|session| **session == cell.session) {
            own[side] = cell.mean.map_or(f64::NAN, |own| shown.value(own));
        }
    }
    let dots = Points {
        x: people.values().map(|[later, earlier]| (later + earlier) / 2.0).collect(),
        y: people.values().map(|[later, earlier]| later - earlier).collect(),
        colour: style::mode_colour(mode),
        ..Points::default()
    };
    let mut layers = vec![zero(Direction::Horizontal)];
    for at in [change.change, change.limit_low, change.limit_high].into_iter().flatten() {
        let at = shown.difference(at);
        let line = Reference::new(Direction::Horizontal, at, style::reference());
        layers.push(Layer::Reference(line));
    }
    layers.push(Layer::Points(dots));
    layers
}

#[cfg(test)]
mod tests {
    use super::apart;

    #[test]
    fn dots_of_equal_values_stand_side_by_side_and_others_at_their_place() {
        assert_eq!(apart(1.0, &[0.2, 0.0, 0.3, -0.0]), [1.0, 1.0, 1.0, 1.0 - 0.06]);
        let many = apart(2.0, &[5.0; 100]);
        assert!(many.iter().all(|x| (1.7..=2.0).contains(x)));
        assert!(many.windows(2).all(|two| two[1] < two[0]));
        assert_eq!(apart(0.0, &[]), [0.0; 0]);
    }
}
