//! A mapping file to edit, guessed from a recording: how its text is written, and what its columns
//! may be.
//!
//! A guess imports nothing: the mapping is a text that a person reads, corrects and names in
//! `--map`. It has a line to fill in for whatever could not be guessed.

use super::axes::not_recorded;
use super::clock::{Clock, clock};
use super::counter::wrap_of;
use super::guess_answers::answers;
use super::guess_apart::{Sorted, sort};
use super::guess_log;
use super::guess_names::{Names, names};
use super::guess_read::{Looked, MOST_GUESSED, Written, first_numbers, is_number, look, quoted};
use super::guess_task::task;
use super::guess_words::{
    ANSWERS, COMMANDED, CURRENTS, ColumnName, LABELS, axis_of, has_word, parse_name, signal_of,
};
use super::mapping::CellForm;
use super::recording::number;
use super::spelling::shown;
use super::table::{Cell, Cells, Table};
use super::text::{Encoding, HDF5};
use super::unit::{find, may_become, word_of};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zwidth_numerics::series::ends;
use zwidth_store::{Signal, StoreError};
use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR, REFERENCE, Schema};

/// The result of a guess.
#[derive(Debug)]
pub struct Guess {
    /// The mapping's text, to be edited.
    pub mapping: String,
    /// Files that the mapping does not fit: what each is instead, and what to do with it.
    pub apart: Vec<StoreError>,
}

/// A guessed mapping for recordings: their content from the first of the similar ones, the trial of
/// each from all names. Files with other columns are named apart.
///
/// # Errors
/// A file that cannot be read, if it is the only one or the first of the similar ones.
pub fn guess(path: &Path, others: &[PathBuf]) -> Result<Guess, StoreError> {
    let files: Vec<PathBuf> = std::iter::once(path.to_owned()).chain(others.to_vec()).collect();
    let Sorted { alike, apart } = sort(&files);
    let first = alike.first().map_or(path, PathBuf::as_path);
    let looked = look(first)?;
    let text = mapping(first, &apart, &looked, &names(&alike));
    Ok(Guess { mapping: text, apart })
}

/// The mapping's text.
fn mapping(path: &Path, apart: &[StoreError], looked: &Looked, names: &Names) -> String {
    let mut text = format!(
        "# Guessed from {}: check every line, fill in what stands at `TODO`, then\n# zwidth import STUDY --map THIS FILES…\n",
        file_name(path)
    );
    for StoreError { path, what, remedy, .. } in apart {
        let reason = format!("{what}; {remedy}").replace(char::is_control, " ");
        let _ = writeln!(text, "# Not for {}: {reason}", file_name(path));
    }
    let Looked { table, written, .. } = looked;
    let comma = written.is_some_and(|written| written.decimal_comma);
    if let Some(task) = task(table, comma) {
        text.push_str("kind = \"psychometric\"\n\n[file]\n");
        write_file(&mut text, looked);
        task.write(&mut text, table, names);
        return text;
    }
    if let Some(answers) = answers(table, comma) {
        text.push_str("kind = \"likert\"\n\n[file]\n");
        write_file(&mut text, looked);
        answers.write(&mut text, table, names);
        return text;
    }
    text.push_str("kind = \"trials\"\n\n[file]\n");
    write_file(&mut text, looked);
    let columns = describe_columns(looked, comma);
    let time = columns.iter().find(|c| c.to == Some(Signal::Time));
    let is_clock = time.is_some_and(|time| !time.is_number);
    let times = time.map(|time| {
        let cells = &table.columns[time.place];
        first_numbers(clock_times(cells, comma).as_ref().unwrap_or(cells), comma)
    });
    let times: Vec<f64> = times.into_iter().flatten().flatten().collect();
    let wrap = wrap_of(&times);
    // A counter that starts over begins no other trial.
    if wrap.is_none() && times.windows(2).any(|t| t[1] < t[0]) {
        text.push_str(
            "split = \"time\"          # the time starts over: several trials in one file\n",
        );
    }
    let mapped = columns.iter().filter(|column| column.to.is_some() && column.is_number);
    let mapped: Vec<&Cells> = mapped.map(|column| &table.columns[column.place]).collect();
    write_bad_rows(&mut text, table, &mapped, comma);
    names.write(&mut text, WHO);
    text.push('\n');
    match (time, looked.labview.as_ref().and_then(|heads| heads.step_s)) {
        (Some(column), _) => {
            // If the unit is a day, steps between samples are 10 µs to 1 s long.
            let mut steps: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
            steps.sort_by(f64::total_cmp);
            let median = steps.get(steps.len() / 2);
            let unit = if is_clock {
                "\"s\"               # clock times and durations are read as seconds".to_owned()
            } else if median.is_some_and(|step| (1e-10..1.2e-5).contains(step)) {
                "\"d\"               # days, as workbooks count them? Or s, ms or µs?".to_owned()
            } else {
                column.unit_line("s, ms or µs?")
            };
            let _ = writeln!(text, "[time]\nfrom = {}\nunit = {unit}", column.from);
            if let Some(wrap) = wrap {
                let _ = writeln!(text, "wrap = {wrap}      # the counter starts over there");
            }
            let doubled = times.windows(2).filter(|t| t[1].to_bits() == t[0].to_bits()).count();
            if doubled > 0 {
                let _ = writeln!(
                    text,
                    "equal = \"drop\"         # {doubled} rows have the time of the row before; \"mean\" joins them"
                );
            }
            let first = times.first().copied().unwrap_or(0.0);
            if first > LONG_BEFORE || (is_clock && first > 0.0) {
                text.push_str("zero = \"first\"          # the times count from long before\n");
            }
        }
        (None, Some(step_s)) => {
            let _ = writeln!(text, "[time]\nrate_hz = {:?}        # 1 / Delta_X", 1.0 / step_s);
        }
        (None, None) => text.push_str(
            "[time]\nrate_hz = \"TODO\"        # no column of time was found: samples per second\n",
        ),
    }
    for column in &columns {
        column.write(&mut text);
    }
    let signals: Vec<Option<Signal>> = columns.iter().map(|column| column.to).collect();
    if signals.iter().flatten().any(|signal| signal.schema() >= Schema::Three) {
        text.push_str(AXES);
    }
    if signals.contains(&Some(Signal::Theta)) && !signals.contains(&Some(Signal::ThetaDot)) {
        let _ = writeln!(
            text,
            "\n# no velocity was found; without one there is no onset, and no average over time\n[[column]]\n\
             to = \"{}\"\nderive = \"derivative of {}\"",
            Signal::ThetaDot.name(),
            Signal::Theta.name()
        );
    }
    let apart: Vec<&Path> = apart.iter().map(|apart| apart.path.as_path()).collect();
    guess_log::write(&mut text, path, &apart, names);
    text
}

/// The mapping of another program's trajectory: its time, its angle, and if there are any its velocity
/// and the user's force. Whose trial it is does not matter.
///
/// # Errors
/// A file that cannot be read; no time or no angle, or one whose unit is not known.
pub(super) fn trajectory_mapping(path: &Path) -> Result<String, StoreError> {
    let looked = look(path)?;
    let comma = looked.written.is_some_and(|written| written.decimal_comma);
    let columns = describe_columns(&looked, comma);
    let names: Vec<&str> = columns.iter().map(|column| column.from.as_str()).collect();
    let of = |signal: Signal, what: &str, example: &str| {
        columns.iter().find(|column| column.to == Some(signal)).ok_or_else(|| {
            let what = format!("no column of {what} was found; the file has {}", names.join(", "));
            let remedy = format!(
                "call it {example}, or write a mapping (`zwidth import --guess` begins one) and name it with --map"
            );
            StoreError::new(path, what, remedy)
        })
    };
    let unit = |column: &Guessed, example: &str| {
        let own = if column.is_number { column.unit.clone() } else { Some("s".to_owned()) };
        own.ok_or_else(|| {
            let name = column.from.trim_matches('"');
            let what = format!("the unit of '{name}' is not known");
            StoreError::new(path, what, format!("add it to the column's name: {example}"))
        })
    };
    let time = of(Signal::Time, "time", "t_s")?;
    let angle = of(Signal::Theta, "the angle", "theta_rad")?;
    let mut text = "kind = \"trials\"\nsimulated = true\n\n[file]\n".to_owned();
    write_file(&mut text, &looked);
    text.push_str("\n[trial]\n");
    for label in
        ["participant = \"P01\"", "session = \"S01\"", "environment = \"any\"", "mode = \"any\""]
    {
        let _ = writeln!(text, "{label}");
    }
    let _ =
        writeln!(text, "\n[time]\nfrom = {}\nunit = \"{}\"", time.from, unit(time, "t_s, t_ms")?);
    let more = [(Signal::ThetaDot, "theta_dot_rad_s"), (Signal::ForceEx, "force_ex_n")];
    let more = more.iter().filter_map(|(signal, example)| {
        Some((columns.iter().find(|column| column.to == Some(*signal))?, *example))
    });
    for (column, example) in std::iter::once((angle, "theta_rad, theta_deg")).chain(more) {
        column.write_as(&mut text, &unit(column, example)?);
    }
    Ok(text)
}

/// What no file says of its axes.
const AXES: &str = r#"
# Several axes: study.toml needs schema = 3, and what no file tells of them:
#   [axes]
#   frame = "TODO"         # where x, y and z point, and which of them is up: "x right, y up, z to the person"
#   push = [0, 0, -1]      # TODO: the direction of a push into the object in that frame, of length 1
# Are the forces those of the person on the device? If they are those of the device on the person, set sign = -1 in each.
# Positions have the frame's own zero; zero = "first" in a column counts from its first sample.
# For the metrics of one coordinate and one force as well, along push (study.toml needs device.lever_m for it):
# [[column]]
# to = "theta_rad"
# derive = "along push"
# origin = "first"         # or where it is 0: a place in m, such as [0.0, 0.12, 0.0]
# [[column]]
# to = "theta_dot_rad_s"
# derive = "derivative of theta_rad"
# [[column]]
# to = "force_ex_n"
# derive = "along push"
"#;

/// What stands for a participant whom the names do not tell.
const WHO: &str =
    "\"TODO\"     # a code; or { column = \"…\" }, or { name = \"…\" } with a pattern in [name]";

/// A first time beyond this is counted from the start of a computer or from 1970, whatever its unit.
const LONG_BEFORE: f64 = 1e8;

/// Says how many rows cannot be read, and whether some lack a value in a column that is taken: as the
/// importer counts them.
fn write_bad_rows(text: &mut String, table: &Table, taken: &[&Cells], comma: bool) {
    let mut bad: BTreeMap<usize, String> = table.bad.iter().cloned().collect();
    let mut missing = 0;
    for row in 0..taken.iter().map(|cells| cells.len()).min().unwrap_or(0) {
        let numbers = taken.iter().map(|cells| match cells.cell(row) {
            Cell::Text(text) => number(text, comma),
            Cell::Number(value) => Ok(Some(value).filter(|value| !value.is_nan())),
            Cell::Empty => Ok(None),
        });
        let cells: Vec<Result<Option<f64>, String>> = numbers.collect();
        if let Some(why) = cells.iter().find_map(|cell| cell.as_ref().err()) {
            bad.entry(row).or_insert_with(|| why.clone());
        }
        missing += usize::from(!bad.contains_key(&row) && cells.contains(&Ok(None)));
    }
    if let Some((row, why)) = bad.first_key_value() {
        let place = table
            .lines
            .get(*row)
            .map_or_else(|| format!("row {}", row + 1), |line| format!("line {line}"));
        let why = shown(why).replace(char::is_control, " ");
        let _ = writeln!(text, "bad_lines = {}           # the first: {place}: {why}", bad.len());
    }
    if missing > 0 {
        let _ = writeln!(
            text,
            "missing = \"drop\"       # {missing} rows lack a value in a column below"
        );
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, " ")
}

/// `[file]`, as far as it does not depend on the columns.
fn write_file(text: &mut String, Looked { table, format, written, part, turned, .. }: &Looked) {
    if let Some(format) = format {
        let _ = writeln!(text, "format = \"{}\"", format.word());
    }
    if let Some(Written { dialect, decimal_comma }) = written {
        let delimiter = match dialect.delimiter {
            b'\t' => "\\t".to_owned(),
            other => char::from(other).to_string(),
        };
        let _ = writeln!(text, "delimiter = \"{delimiter}\"");
        let _ = writeln!(text, "decimal = \"{}\"", if *decimal_comma { ',' } else { '.' });
        let _ = writeln!(text, "header = {}", dialect.header);
        if let Some(mark) = dialect.comment {
            let _ = writeln!(text, "comment = \"{}\"", char::from(mark));
        }
        if dialect.skip > 0 {
            let _ = writeln!(text, "skip = {}", dialect.skip);
        }
        match dialect.encoding {
            Encoding::Utf8 => {}
            Encoding::Utf16 => text.push_str("encoding = \"utf-16\"\n"),
            Encoding::Latin1 => text.push_str("encoding = \"latin-1\"\n"),
            Encoding::Windows1252 => text.push_str("encoding = \"windows-1252\"\n"),
        }
    }
    if let Some(part) = part {
        let _ = writeln!(text, "matrix = {}", quoted(part));
    }
    if *turned {
        text.push_str("signals = \"rows\"       # the matrix has more columns than rows\n");
    }
    for remark in &table.told {
        let _ = writeln!(text, "# {remark}");
    }
}

/// A column of theirs, and what it may be.
struct Guessed {
    place: usize,
    /// As `from` names it: a text in quotes, or a position.
    from: String,
    to: Option<Signal>,
    unit: Option<String>,
    is_number: bool,
    /// The words of its name, in small letters.
    words: Vec<String>,
    /// Behind its position, what it is called or from where to where its numbers go.
    about: String,
    /// Why it is no column of the recording, if it is none.
    why_not: Option<String>,
}

impl Guessed {
    /// A name for it among the study's channels: that of a winding's current has a fixed meaning.
    fn channel(&self) -> String {
        if has_word(&self.words, &CURRENTS) {
            let is_brake = has_word(&self.words, &["brake", "bremse"]);
            return if is_brake { CURRENT_BRAKE } else { CURRENT_MOTOR }.to_owned();
        }
        let words: Vec<String> =
            self.words.iter().filter(|word| !COMMANDED.contains(&word.as_str())).cloned().collect();
        let is_angle = match words.is_empty() {
            true => self.unit.as_deref().is_some_and(|unit| ["rad", "deg", "°"].contains(&unit)),
            false => signal_of(&words) == Some(Signal::Theta),
        };
        if words.len() < self.words.len() && is_angle {
            return REFERENCE.to_owned();
        }
        // The id of a channel has small ASCII letters alone, and a unit may have capitals.
        let parts = self.words.iter().chain(&self.unit).map(|part| {
            let letters = part.chars().filter(|l| l.is_ascii_alphanumeric() || *l == '_');
            letters.collect::<String>().to_lowercase()
        });
        let name = parts.collect::<Vec<_>>().join("_");
        if name.is_empty() { format!("column_{}", self.place + 1) } else { name }
    }

    fn unit_line(&self, which: &str) -> String {
        self.unit
            .as_ref()
            .map_or_else(|| format!("\"TODO\"            # {which}"), |unit| format!("\"{unit}\""))
    }

    /// As the signal that it is, in a unit.
    fn write_as(&self, text: &mut String, unit: &str) {
        let to = self.to.map_or("", Signal::name);
        let _ =
            writeln!(text, "\n[[column]]\nto = \"{to}\"\nfrom = {}\nunit = \"{unit}\"", self.from);
    }

    fn write(&self, text: &mut String) {
        let Self { from, about, words, .. } = self;
        let _ = match self.to {
            Some(Signal::Time) => Ok(()),
            Some(to) => {
                let unit = self.unit_line("which?");
                writeln!(
                    text,
                    "\n[[column]]\nto = \"{}\"\nfrom = {from}{about}\nunit = {unit}",
                    to.name()
                )
            }
            None if let Some(why) = &self.why_not => {
                writeln!(text, "\n# not read: {from}, {why}")
            }
            None if let Some((key, _)) = LABELS.iter().find(|(_, list)| has_word(words, list)) => {
                writeln!(
                    text,
                    "\n# a label of the trial? Then under [trial]: {key} = {{ column = {from} }}"
                )
            }
            None if let Some(why) = not_recorded(from.trim_matches('"')) => {
                writeln!(text, "\n# not read: {why}")
            }
            None if has_word(words, &ANSWERS) => {
                writeln!(text, "\n# an answer? Then under [trial]: likert = {{ column = {from} }}")
            }
            None if self.is_number && self.words.is_empty() => writeln!(
                text,
                "\n# not recognised: {from}, a column of numbers{about}. To take it, say what it is:\n\
                 # [[column]]\n# to = \"TODO\"\n# from = {from}\n# unit = \"TODO\""
            ),
            None if self.is_number => writeln!(
                text,
                "\n# not recognised: {from}, a column of numbers. To keep it, list it under [[channels]] of study.toml, and:\n\
                 # [[channel]]\n# to = \"{}\"\n# from = {from}\n# unit = \"{}\"",
                self.channel(),
                self.unit.as_deref().unwrap_or("TODO")
            ),
            None => writeln!(
                text,
                "\n# not recognised: {from}, a column of texts: a label of the trial, perhaps"
            ),
        };
    }
}

/// Describes every column; each of our signals is the target of one column at most.
fn describe_columns(looked: &Looked, decimal_comma: bool) -> Vec<Guessed> {
    let Looked { table, labview, labels, .. } = looked;
    let mut taken = Vec::new();
    let mut columns = Vec::new();
    // The most common number of values among columns with more than one; the larger of two equally
    // common. Vectors of one file may differ in length.
    let mut lengths: BTreeMap<usize, usize> = BTreeMap::new();
    for length in table.columns.iter().map(Cells::len).filter(|length| *length > 1) {
        *lengths.entry(length).or_default() += 1;
    }
    let usual = lengths.into_iter().max_by_key(|(length, count)| (*count, *length));
    let usual = usual.map_or(1, |(length, _)| length);
    let names = table.names.as_deref().unwrap_or_default();
    let has_axes = has_several_axes(looked, decimal_comma);
    for (place, cells) in table.columns.iter().enumerate().take(MOST_GUESSED) {
        let name = names.get(place).filter(|name| !name.is_empty());
        // A structure whose fields are columns too is no column itself.
        if cells.len() == 0
            && let Some(name) = name
            && names
                .iter()
                .filter_map(|other| other.strip_prefix(name.as_str()))
                .any(|rest| rest.starts_with(['.', '(', '/']))
        {
            continue;
        }
        let label = name.or_else(|| labels.get(place).filter(|label| !label.is_empty()));
        let is_number = is_number(cells, decimal_comma);
        let ColumnName { words, mut signal, mut unit } =
            label.map_or_else(ColumnName::default, |label| parse_name(label));
        let axis = label.and_then(|label| {
            let axis = axis_of(&words)?;
            let of_force = [Signal::ForceX, Signal::ForceY, Signal::ForceZ].contains(&axis);
            let is_several = if of_force { has_axes.force } else { has_axes.position };
            // A unit that does not fit leaves the column to what it was.
            let fits = unit.as_deref().and_then(find).is_none_or(|unit| may_become(unit, axis));
            (is_several && fits && not_recorded(label).is_none()).then_some(axis)
        });
        if axis.is_some() {
            signal = axis;
        } else if (has_axes.force || has_axes.position)
            && label.is_some_and(|label| not_recorded(label).is_some())
        {
            signal = None;
        }
        let mut why_not = why_not(cells, usual);
        if let Some(heads) = labview {
            let is_x = place == 0 || (heads.has_many_times && place % 2 == 0);
            match is_x {
                true if place == 0 && heads.is_time == Some(true) => {
                    (signal, unit) = (Some(Signal::Time), Some("s".to_owned()));
                }
                true => {
                    (signal, unit) = (None, None);
                    if heads.has_many_times && why_not.is_none() {
                        let first = first_numbers(&table.columns[0], decimal_comma);
                        let is_same = first_numbers(cells, decimal_comma) == first;
                        let reason = if is_same { SAME_TIMES } else { OTHER_TIMES };
                        why_not = Some(reason.to_owned());
                    }
                }
                false => {
                    let channel = if heads.has_many_times { place / 2 } else { place - 1 };
                    unit = unit.or_else(|| unit_of(heads.units.get(channel)?, signal));
                }
            }
        }
        let declared = table.units.get(&place).map(|declared| declared.unit.as_str());
        unit = unit.or_else(|| unit_of(declared?, signal));
        // Some programs write a row of units below the names.
        if unit.is_none()
            && is_number
            && let Cell::Text(below) = cells.cell(0)
        {
            unit = unit_of(below, signal);
        }
        // The first column of a matrix that has no names is its time if it only grows.
        let is_matrix = names.is_empty() && table.lines.is_empty();
        if is_matrix && place == 0 {
            let numbers = first_numbers(cells, false);
            let mut pairs = numbers.windows(2);
            let grows = pairs.all(|pair| pair[0].zip(pair[1]).is_some_and(|(a, b)| b > a));
            if numbers.len() > 1 && grows {
                signal = Some(Signal::Time);
            }
        }
        // A time may be written as that of a clock.
        let is_clock = signal == Some(Signal::Time) && clock_times(cells, decimal_comma).is_some();
        let to =
            signal.filter(|to| (is_number || is_clock) && why_not.is_none() && !taken.contains(to));
        taken.extend(to);
        let from = name.map_or_else(|| (place + 1).to_string(), |name| quoted(name));
        let about = match (name, label) {
            (None, Some(label)) => format!("      # {}", label.replace(char::is_control, " ")),
            (None, None) => {
                let numbers = first_numbers(cells, decimal_comma);
                let (low, high) = ends(&numbers.into_iter().flatten().collect::<Vec<f64>>());
                if low <= high { format!(" from {low} to {high}") } else { String::new() }
            }
            _ => String::new(),
        };
        columns.push(Guessed { place, from, to, unit, is_number, words, about, why_not });
    }
    columns
}

/// Whether a file has positions, and forces, in more than one axis.
struct SeveralAxes {
    position: bool,
    force: bool,
}

fn has_several_axes(looked: &Looked, decimal_comma: bool) -> SeveralAxes {
    let Looked { table, labels, .. } = looked;
    let names = table.names.as_ref().unwrap_or(labels);
    let numbers =
        names.iter().zip(&table.columns).filter(|(_, cells)| is_number(cells, decimal_comma));
    let axes: BTreeSet<Signal> =
        numbers.filter_map(|(name, _)| axis_of(&parse_name(name).words)).collect();
    let count = |of: [Signal; 3]| of.iter().filter(|axis| axes.contains(axis)).count();
    SeveralAxes {
        position: count([Signal::X, Signal::Y, Signal::Z]) > 1,
        force: count([Signal::ForceX, Signal::ForceY, Signal::ForceZ]) > 1,
    }
}

/// Why another channel's times in a file of LabVIEW's are no column.
const SAME_TIMES: &str = "the times of column 1 once more";
const OTHER_TIMES: &str =
    "the times of the next channel, which are not those of column 1: import each channel by itself";

/// Why a column is none of a recording whose columns have the usual length.
fn why_not(cells: &Cells, usual: usize) -> Option<String> {
    match cells {
        Cells::Other(why) => {
            // Too long a line for each text of a file.
            let why = why.replace(HDF5, "an import that names it says how to convert the file");
            Some(shown(&why).replace(char::is_control, " "))
        }
        Cells::Unread => Some("it is not read".to_owned()),
        cells if cells.len() != usual => {
            Some(format!("its length is {}, and that of most columns {usual}", cells.len()))
        }
        _ => None,
    }
}

/// The clock times, dates or durations of a column in s, if it holds such, as the importer reads them.
fn clock_times(cells: &Cells, decimal_comma: bool) -> Option<Cells> {
    let form = CellForm { decimal_comma, ..CellForm::default() };
    match clock(cells, &form, false) {
        Ok(Some(Clock::Seconds(seconds))) => Some(Cells::Numbers(seconds)),
        _ => None,
    }
}

/// The unit that a file names in a place of its own, as a mapping spells it.
fn unit_of(named: &str, signal: Option<Signal>) -> Option<String> {
    let singular = named.strip_suffix('s').unwrap_or(named);
    let spellings = [named, singular].into_iter();
    let unit = spellings.chain(word_of(singular)).find(|text| {
        find(text).is_some_and(|unit| signal.is_none_or(|signal| may_become(unit, signal)))
    });
    unit.map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::super::report::Report;
    use super::super::world::World;
    use super::super::{hdf5, labview};
    use super::*;
    use hdf5_pure::FileBuilder;

    fn says(map: &str, expect: &[&str]) {
        for words in expect {
            assert!(map.contains(words), "'{words}' is not in\n{map}");
        }
    }

    /// The mapping that is guessed for a file says this.
    fn check(name: &str, content: impl AsRef<[u8]>, expect: &[&str]) -> String {
        let world = World::new();
        let map = guess(&world.file(name, content), &[]).unwrap().mapping;
        says(&map, expect);
        map
    }

    #[test]
    fn delimiter_decimal_mark_header_and_units_are_guessed() {
        let text = "rig 2\n\ntime_ms;angle (deg);F [mN];note\n0;-45,0;0,02;ok\n1;-44,9;-0,05;ok\n";
        let expect = [
            "delimiter = \";\"\ndecimal = \",\"\nheader = true\nskip = 2\n",
            "[time]\nfrom = \"time_ms\"\nunit = \"ms\"\n",
            "to = \"theta_rad\"\nfrom = \"angle (deg)\"\nunit = \"deg\"\n",
            "to = \"force_ex_n\"\nfrom = \"F [mN]\"\nunit = \"mN\"\n",
            "# not recognised: \"note\", a column of texts",
        ];
        check("a.csv", text, &expect);
        let expect = [
            "delimiter = \" \"\n",
            "header = false\n",
            "rate_hz = \"TODO\"",
            "# not recognised: 1, a column of numbers",
        ];
        check("a.dat", "0.0  1.5\n0.1  2.5\n0.2  3.5\n", &expect);
        let expect =
            ["format = \"txt\"\ndelimiter = \"|\"", "encoding = \"latin-1\"", "split = \"time\""];
        check("a.log", b"t|\xfcber\n0|1\n1|2\n0|3\n", &expect);
    }

    #[test]
    fn a_pose_and_a_wrench_are_guessed_axis_by_axis_and_what_no_file_tells_is_asked() {
        let text = "t,x,y,z,roll,Fx,Fy,Fz,Tx\n0,1,2,3,0,4,5,6,7\n0.01,1,2,3,0,4,5,6,7\n";
        let expect = [
            "to = \"x_m\"\nfrom = \"x\"\nunit = \"TODO\"",
            "to = \"z_m\"\nfrom = \"z\"",
            "to = \"force_x_n\"\nfrom = \"Fx\"",
            "to = \"force_z_n\"\nfrom = \"Fz\"",
            "# not read: 'roll' is orientation",
            "# not read: 'Tx' is a moment about an axis",
            "#   push = [0, 0, -1]      # TODO",
            "which of them is up",
        ];
        let map = check("a.csv", text, &expect);
        assert!(!map.contains("to = \"theta_rad\"\nfrom"), "{map}");
        let text = "time_ms;pos_x (mm);pos_y (mm);ForceX (N);ForceY (N)\n0;1;2;3;4\n10;1;2;3;4\n";
        let expect = [
            "to = \"x_m\"\nfrom = \"pos_x (mm)\"\nunit = \"mm\"",
            "to = \"force_y_n\"\nfrom = \"ForceY (N)\"\nunit = \"N\"",
        ];
        check("a.csv", text, &expect);
        // One axis is the coordinate, as ever.
        let expect = ["to = \"theta_rad\"\nfrom = \"x\"", "to = \"force_ex_n\"\nfrom = \"fx\""];
        check("a.csv", "t,x,fx\n0,1,2\n1,2,3\n", &expect);
    }

    #[test]
    fn a_name_of_several_words_says_what_it_is_and_whether_it_was_only_asked_for() {
        let text = "t_s_inferred,x_desired_mm,x_measured_mm,force_desired_N,force_measured_N,theta_dot\n0,1,2,3,4,5\n1,1,2,3,5,6\n";
        let expect = [
            "[time]\nfrom = \"t_s_inferred\"\nunit = \"s\"\n",
            "# not recognised: \"x_desired_mm\"",
            "# to = \"reference_rad\"\n# from = \"x_desired_mm\"\n",
            "to = \"theta_rad\"\nfrom = \"x_measured_mm\"\nunit = \"mm\"\n",
            "to = \"force_cmd_n\"\nfrom = \"force_desired_N\"\nunit = \"N\"\n",
            "to = \"force_ex_n\"\nfrom = \"force_measured_N\"\nunit = \"N\"\n",
            "to = \"theta_dot_rad_s\"\nfrom = \"theta_dot\"\nunit = \"TODO\"",
        ];
        check("a.csv", text, &expect);
    }

    #[test]
    fn a_column_of_a_current_an_answer_or_anything_else_is_told_where_it_may_go() {
        let text = "t_s,Brake current (A),Grip force [kg],likert,x y,controller,repetition\n0,1,2,3,4,pid,1\n1,1,2,3,5,pid,1\n";
        let expect = [
            "under [trial]: mode = { column = \"controller\" }",
            "under [trial]: repeat = { column = \"repetition\" }",
            "# to = \"current_brake_a\"\n# from = \"Brake current (A)\"\n",
            "likert = { column = \"likert\" }",
        ];
        check("a.csv", text, &expect);
    }

    #[test]
    fn a_counter_that_starts_over_rows_that_come_twice_and_clocks_are_guessed() {
        let rows = |time: fn(u64) -> String| {
            let rows: String = (0..40).map(|i| format!("{},{i}\n", time(i))).collect();
            format!("t,force_N\n{rows}")
        };
        let wraps = rows(|i| ((4_294_960_000 + 1000 * i) % (1 << 32)).to_string());
        let map = check("a.csv", wraps, &["wrap = 4294967296 "]);
        assert!(!map.contains("split"), "{map}");
        let restarts = rows(|i| (1000 * (i % 20)).to_string());
        let map = check("b.csv", restarts, &["split = \"time\""]);
        assert!(!map.contains("wrap"), "{map}");
        check("c.csv", rows(|i| (i / 2).to_string()), &["equal = \"drop\"         # 20 rows"]);
        check("d.csv", rows(|i| format!("10:00:0{}.{}", i / 10, i % 10)), &["unit = \"s\""]);
        check("e.csv", rows(|i| format!("{i} sec")), &["unit = \"s\""]);
    }

    #[test]
    fn lines_of_remarks_before_the_header_are_comments_unless_the_header_is_one() {
        let text =
            "% knob logger v2\n% rate 1000\nt_s\ttheta_rad\tref_rad\tF\n0\t1\t0\t2\n1\t2\t0\t2\n";
        let expect = [
            "delimiter = \"\\t\"\ndecimal = \".\"\nheader = true\ncomment = \"%\"\n",
            "[time]\nfrom = \"t_s\"\nunit = \"s\"\n",
            "# to = \"reference_rad\"\n# from = \"ref_rad\"\n",
        ];
        check("a.txt", text, &expect);
        check("a.csv", "#t_s,theta_rad\n0,1\n1,2\n", &["header = true\n", "from = \"theta_rad\""]);
    }

    #[test]
    fn a_velocity_that_was_not_recorded_is_derived() {
        let derived = "to = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        check("a.csv", "time_ms,angle_deg\n0,1\n1,2\n", &[derived]);
        for text in ["t_s,theta_rad,omega\n0,1,2\n1,2,3\n", "t_s,force_n\n0,1\n1,2\n"] {
            assert!(!check("b.csv", text, &[]).contains("derive"), "{text}");
        }
    }

    /// What is guessed imports, once what only a person knows is filled in; the mapping says this, and
    /// the forces are these.
    fn imports(
        name: &str,
        content: impl AsRef<[u8]>,
        force: &[f64],
        expect: &[&str],
    ) -> (String, Report) {
        let world = World::new();
        let file = world.file(name, content);
        let map = guess(&file, &[])
            .unwrap()
            .mapping
            .replacen("participant = \"TODO\"", "participant = \"P01\"", 1)
            .replace("environment = \"TODO\"", "environment = \"spring\"")
            .replace("mode = \"TODO\"", "mode = \"hybrid\"")
            .replace("unit = \"TODO\"            # s", "unit = \"s\"            # s")
            .replace("slider_response =", "felt_spring =")
            .replace("rating =", "felt_spring =");
        let report = world.import(&map, &[file]).unwrap_or_else(|e| panic!("{e:#?}\n{map}"));
        if !force.is_empty() {
            assert_eq!(world.column(1, Signal::ForceEx), force, "{map}");
        }
        says(&map, expect);
        (map, report)
    }

    #[test]
    fn a_guess_with_its_blanks_filled_in_imports() {
        let text = "Time (s)\tForce (N)\r\n0\t1,5\r\n0,5\t2,5\r\n";
        imports("a.csv", text, &[1.5, 2.5], &[]);
        // Letters of Windows are no control characters.
        let expect = ["encoding = \"windows-1252\""];
        imports("a.csv", b"t_s,F_N,\x93x\x94\n0,1,2\n1,2,3\n", &[1.0, 2.0], &expect);
    }

    #[test]
    fn commas_in_quotes_stand_between_no_cells() {
        let text = "t_s,F_N,gains\n0,1,\"[1.0, 0.5, 2.0]\"\n1,2,\"[1.0, 0.5, 2.0]\"\n";
        let expect = ["header = true", "from = \"t_s\"", "not recognised: \"gains\""];
        let (map, _) = imports("a.csv", text, &[1.0, 2.0], &expect);
        assert!(!map.contains("skip"), "{map}");
        imports("a.csv", "note,t_s,F_N\n\"one\ntwo\",0,1\n\"a, b\",1,2\n", &[1.0, 2.0], &[]);
    }

    #[test]
    fn commas_in_single_quotes_part_cells_and_shift_no_name() {
        for list in ["'[1, 2]'", "'[1, 2, 3]'"] {
            let text = format!("t_s,F_N,gains,angle_deg\n0,1,{list},5\n1,2,{list},6\n");
            let expect = ["header = false\nskip = 1\n", "from = 1\n", "from = 2      # F_N\n"];
            let (map, _) = imports("a.csv", &text, &[1.0, 2.0], &expect);
            assert!(!map.contains("angle"), "{map}");
            let world = World::new();
            let named = map
                .replace("header = false\nskip = 1", "header = true")
                .replace("from = 1\n", "from = \"t_s\"\n")
                .replace("from = 2", "from = \"F_N\"");
            let words = "a delimiter stands in single quotes";
            world.refuses(&named, &world.file("a.csv", &text), words, None);
        }
    }

    #[test]
    fn a_first_line_that_names_the_delimiter_is_passed_by() {
        for text in [
            "\u{feff}sep=;\nt_s;F_N\n0,5;1,5\n1;2\n",
            "sep=;\r\nt_s;F_N\r\n0,5;1,5\r\n1;2\r\n",
            "\"sep=;\"\nt_s;F_N\n0,5;1,5\n1;2\n",
        ] {
            let expect = ["delimiter = \";\"", "decimal = \",\"", "skip = 1\n"];
            imports("a.csv", text, &[1.5, 2.0], &expect);
        }
    }

    #[test]
    fn a_file_of_labview_is_read_behind_its_two_heads_in_the_units_that_they_name() {
        let names = "X_Value\tangle\tF\tComment";
        let rows = "0,00\t1,0\t2,5\n0,05\t1,0\t3,5\tstart\n0,10\t1,0\t4,5\n";
        let text = labview::tests::written("One", names, rows);
        let expect = [
            "format = \"txt\"",
            "decimal = \",\"",
            "skip = 14\n",
            "from = \"X_Value\"\nunit = \"s\"",
            "from = \"angle\"\nunit = \"deg\"",
            "from = \"F\"\nunit = \"N\"",
        ];
        let (map, _) = imports("a.lvm", &text, &[2.5, 3.5, 4.5], &expect);
        assert!(!map.contains("bad_lines"), "{map}");
        let many = "X_Value\tangle\tX_Value\tF\tComment";
        let rows = "0,00\t1,0\t0,00\t2,5\n0,05\t1,0\t0,05\t3,5\n";
        let text = labview::tests::written("Multi", many, rows);
        let expect = [
            "header = false\nskip = 15\n",
            "[time]\nfrom = 1\nunit = \"s\"",
            "to = \"theta_rad\"\nfrom = 2      # angle\nunit = \"deg\"",
            "# not read: 3, the times of column 1 once more",
        ];
        imports("a.lvm", &text, &[2.5, 3.5], &expect);
        let other = text.replace("0,05\t3,5", "0,06\t3,5");
        check("b.lvm", other, &["# not read: 3, the times of the next channel, which are not"]);
        let rows = "\t1,0\t2,5\n\t1,0\t3,5\n";
        let text = labview::tests::written("No", names, rows);
        imports("a.lvm", text, &[2.5, 3.5], &["rate_hz = 20.0"]);
    }

    #[test]
    fn lines_that_the_importer_cannot_read_are_counted_as_it_counts_them() {
        let block = "t_s\tF_N\n0.0\t1\n0.5\t2\n";
        let text = format!("{block}0\n{block}0\n{block}0\n");
        let expect = ["bad_lines = 5 ", "split = \"time\""];
        assert_eq!(imports("a.txt", text, &[1.0, 2.0], &expect).1.trials, 3);
        let expect = ["bad_lines = 1 ", "from = \"t\"\nunit = \"s\"", "from = \"F\"\nunit = \"N\""];
        imports("a.csv", "t,F\ns,N\n0,1\n1,2\n", &[], &expect);
        imports("a.csv", "t_s,F_N\n0,1\n1,NA\n2,3\n", &[1.0, 3.0], &["missing = \"drop\""]);
    }

    #[test]
    fn times_of_a_clock_and_days_are_told_and_times_since_1970_begin_at_0() {
        let zero = "zero = \"first\"";
        let expect = ["[time]\nfrom = \"time\"\nunit = \"s\"", "clock times", zero];
        imports("a.csv", "time,F_N\n10:00:00.0,1\n10:00:00.5,2\n", &[1.0, 2.0], &expect);
        let dates = "time,F_N\n2026-01-31 23:59:59.9,1\n2026-02-01 00:00:00.1,2\n";
        imports("a.csv", dates, &[1.0, 2.0], &[zero]);
        let midnight = "time,F_N\n23:59:59.9,1\n00:00:00.0,2\n00:00:00.1,3\n";
        imports("a.csv", midnight, &[1.0, 2.0, 3.0], &["wrap = 86400 ", zero]);
        let spans = "time,F_N\n0 days 00:00:00,1\n0 days 00:00:00.5,2\n";
        assert!(!imports("a.csv", spans, &[1.0, 2.0], &[]).0.contains("zero"));
        let days = "time,F_N\n0,1\n0.00000001,2\n0.00000002,3\n";
        check("a.csv", days, &["unit = \"d\"", "days, as workbooks count them?"]);
        let since_1970 = "t_s,F_N\n1785300900.00,1\n1785300900.10,2\n";
        imports("a.csv", since_1970, &[1.0, 2.0], &[zero]);
    }

    #[test]
    fn a_table_of_answers_is_no_recording() {
        let psychopy = "\u{feff}mode,trials.thisN,key_resp.rt,slider.response,slider.rt,slider.history,mouse.x,participant,session,\n";
        let rows = "active,0,0.512,4.0,1.5,\"[(3.0, 0.8), (4.0, 1.5)]\",\"[0.1, 0.2]\",P01,001,\n\
                    passive,1,,None,1.5,\"[(3.0, 0.8)]\",\"[0.1, 0.2]\",P01,001,\n";
        let again = rows.replace("P01", "P02");
        let text = format!("{psychopy}{rows}{psychopy}{again}").replacen("\n\u{feff}", "\n", 1);
        let expect = [
            "kind = \"likert\"",
            "participant = { column = \"participant\" }",
            "session = { column = \"session\" }",
            "mode = { column = \"mode\" }",
            "trial = { column = \"trials.thisN\" }",
            "missing = \"drop\"",
            "slider.response",
            "time_unit = \"s\"",
        ];
        let (_, report) = imports("a.csv", text, &[], &expect);
        assert_eq!((report.sessions, report.answers), (2, 2));
        let dropped = &report.files[0].rows_dropped[0];
        assert_eq!((dropped.rows, dropped.why.as_str()), (1, "the header, which comes again"));

        let wide = "Participant ID,condition,rating,age\n1,active,4,22\n1,passive,2,22\n";
        let expect = ["kind = \"likert\"", "participant = { column = \"Participant ID\" }"];
        assert_eq!(imports("a.csv", wide, &[], &expect).1.answers, 2);

        // A row for each screen, of which one asks.
        let jspsych = "rt,trial_type,trial_index,response,participant,mode\n\
            900,html-button-response,0,0,P01,active\n\
            4100,survey-likert,1,\"{\"\"felt_spring\"\":3,\"\"felt_wall\"\":0}\",P01,active\n";
        let expect =
            ["lowest = 0", "felt_spring = { column = \"response\", key = \"felt_spring\" }"];
        let (_, report) = imports("a.csv", jspsych, &[], &expect);
        assert_eq!((report.sessions, report.answers), (1, 2));
        let dropped = &report.files[0].rows_dropped[0];
        assert_eq!(dropped.rows, 1, "{}", dropped.why);

        let long = "participant,mode,item,response\n1,active,felt_spring,4\n1,active,felt_wall,2\n";
        let expect = ["question = { column = \"item\" }\nanswer = \"response\""];
        assert_eq!(imports("a.csv", long, &[], &expect).1.answers, 2);
    }

    #[test]
    fn the_loop_of_psychopy_that_numbers_all_answers_is_the_trial() {
        let header =
            "mode,practice.thisN,trials.thisN,blocks.thisN,slider.response,participant,session\n";
        let practice = "active,0,,,2,P01,001\n";
        let blocks = "active,,0,0,1,P01,001\npassive,,1,0,2,P01,001\n";
        let text = format!("{header}{blocks},,,,,P01,001\n");
        let expect = ["trial = { column = \"trials.thisN\" }"];
        assert_eq!(imports("a.csv", text, &[], &expect).1.answers, 2);
        // A practice that no other loop counts, and a loop that starts over in each block.
        let again = blocks.replace(",0,P", ",1,P").replace(",0,1", ",0,3").replace(",0,2", ",1,3");
        for more in [practice, again.as_str()] {
            let text = format!("{header}{blocks}{more}");
            let expect = ["# no trial, as no loop numbers all: of "];
            let (map, report) = imports("a.csv", text, &[], &expect);
            assert!(!map.contains("\ntrial = "), "{map}");
            assert_eq!(report.answers, 2 + more.lines().count(), "{map}");
        }
    }

    #[test]
    fn a_recording_with_a_column_of_answers_is_a_recording() {
        for text in [
            "participant,t_s,F_N,rating\n1,0,1,4\n1,1,2,4\n1,2,3,4\n",
            "participant,mode,counts\n1,active,2048\n1,active,2050\n",
            "participant,time,slider\n1,0.0,4\n1,0.5,4\n1,1.0,5\n",
        ] {
            check("a.csv", text, &["kind = \"trials\""]);
        }
    }

    #[test]
    fn the_last_part_of_a_path_says_what_a_column_is_and_a_matrix_is_called_one() {
        let expect = [
            "[time]\nfrom = \"t\"\n",
            "to = \"force_ex_n\"\nfrom = \"rig/f\"\n",
            "# not read: \"m\", it is a 2 × 3 matrix; name it as matrix in [file]",
        ];
        check("a.h5", hdf5::tests::written(b""), &expect);
        let expect = ["matrix = \"log\"\n", "from = \"s/angle\"", "from = \"s/F\""];
        check("a.h5", hdf5::tests::nested(), &expect);
        let expect = ["from = \"t/value\"", "# not read: \"who/value\", it is text"];
        check("b.h5", hdf5::tests::octave(), &expect);
    }

    #[test]
    fn the_one_matrix_of_a_file_is_read_by_position_turned_where_its_rows_are_the_signals() {
        let written = |shape: &[u64], values: &[f64]| {
            let mut file = FileBuilder::new();
            file.create_dataset("ans").with_f64_data(values).with_shape(shape);
            file.create_dataset("fs").with_f64_data(&[1000.0]).with_shape(&[1]);
            file.finish().unwrap()
        };
        let rows: Vec<f64> =
            (0..180).map(|i| f64::from(i % 60) * [0.5, 2.0, -1.0][i as usize / 60]).collect();
        let turned =
            check("a.h5", written(&[3, 60], &rows), &["matrix = \"ans\"\nsignals = \"rows\" "]);
        let columns: Vec<f64> = (0..180).map(|i| rows[(i % 3) * 60 + i / 3]).collect();
        let plain = check("a.h5", written(&[60, 3], &columns), &["matrix = \"ans\"\n"]);
        assert!(!plain.contains("signals"), "{plain}");
        for map in [turned, plain] {
            let expect = [
                "[time]\nfrom = 1\n",
                "# not recognised: 3, a column of numbers from -59 to -0",
                "# from = 3\n",
            ];
            says(&map, &expect);
        }
    }

    #[test]
    fn a_recording_without_text_is_described_by_its_columns() {
        let text = "{\"t\":0,\"force\":1}\n{\"t\":1,\"force\":2}\n";
        let expect =
            ["[time]\nfrom = \"t\"\n", "to = \"force_ex_n\"\nfrom = \"force\"\nunit = \"TODO\""];
        check("a.jsonl", text, &expect);
    }
}
