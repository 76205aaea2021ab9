//! A mapping file to edit, guessed from a recording: how its text is written, and what its columns
//! may be.
//!
//! Nothing is imported by a guess: the mapping is a text that a person reads, mends and names in
//! `--map`. What could not be told stands in it as a line to fill in.

use super::format::Format;
use super::guess_apart::{Sorted, sort};
use super::guess_names::{Names, names};
use super::guess_read::{LOOKED_AT, Looked, MOST_GUESSED, Written, look};
use super::guess_words::{ANSWERS, COMMANDED, CURRENTS, LABELS, Said, said, signal_of};
use super::recording::number;
use super::table::{Cell, Cells, Table};
use super::text::Encoding;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zwidth_store::{Signal, StoreError};
use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR, REFERENCE};

/// What a guess found.
#[derive(Debug)]
pub struct Guess {
    /// The mapping's text, to be edited.
    pub mapping: String,
    /// Files that the mapping does not fit: what each is instead, and what to do with it.
    pub apart: Vec<StoreError>,
}

/// A mapping for recordings, guessed: from the first of those that are alike what is in them, from
/// all of their names whose trial each is. Files with other columns are told apart.
///
/// # Errors
/// A file that cannot be read, where it is the only one or the first of those alike.
pub fn guess(path: &Path, others: &[PathBuf]) -> Result<Guess, StoreError> {
    let files: Vec<PathBuf> = std::iter::once(path.to_owned()).chain(others.to_vec()).collect();
    let Sorted { alike, apart } = sort(&files);
    let first = alike.first().map_or(path, PathBuf::as_path);
    let Looked { table, format, written } = look(first)?;
    let text = mapping((first, &apart), &table, format, written, &names(&alike));
    Ok(Guess { mapping: text, apart })
}

/// The mapping's text.
fn mapping(
    (path, apart): (&Path, &[StoreError]),
    table: &Table,
    format: Option<Format>,
    written: Option<Written>,
    names: &Names,
) -> String {
    let mut text = format!(
        "# Guessed from {}: check every line, fill in what stands at `TODO`, then\n# zwidth import STUDY --map THIS FILES…\n",
        file_name(path)
    );
    for StoreError { path, what, remedy, .. } in apart {
        let told = format!("{what}; {remedy}").replace(char::is_control, " ");
        let _ = writeln!(text, "# Not for {}: {told}", file_name(path));
    }
    text.push_str("kind = \"trials\"\n\n[file]\n");
    if let Some(format) = format {
        let _ = writeln!(text, "format = \"{}\"", format.word());
    }
    let comma = written.is_some_and(|written| written.decimal_comma);
    if let Some(written) = written {
        write_form(&mut text, written);
    }
    let columns = described(table, comma);
    let time = columns.iter().find(|c| c.to == Some(Signal::Time));
    if time.is_some_and(|c| starts_over(&table.columns[c.place], comma)) {
        text.push_str(
            "split = \"time\"          # the time starts over: several trials in one file\n",
        );
    }
    for told in &table.told {
        let _ = writeln!(text, "# {told}");
    }
    if let Some((row, why)) = table.bad.first() {
        let _ = writeln!(
            text,
            "bad_lines = {}           # the first: row {}: {why}",
            table.bad.len(),
            row + 1
        );
    }
    write_labels(&mut text, names);
    match time {
        Some(column) => {
            let _ = writeln!(
                text,
                "[time]\nfrom = {}\nunit = {}",
                column.from,
                column.unit_line("s, ms or µs?")
            );
        }
        None => text.push_str(
            "[time]\nrate_hz = \"TODO\"        # no column of time was found: samples per second\n",
        ),
    }
    for column in &columns {
        column.write(&mut text);
    }
    let has = |signal| columns.iter().any(|column| column.to == Some(signal));
    if has(Signal::Theta) && !has(Signal::ThetaDot) {
        let _ = writeln!(
            text,
            "\n# no velocity was found; without one there is no onset, and no average over time\n[[column]]\n\
             to = \"{}\"\nderive = \"derivative of {}\"",
            Signal::ThetaDot.name(),
            Signal::Theta.name()
        );
    }
    text
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, " ")
}

/// `[name]` and `[trial]`.
fn write_labels(text: &mut String, names: &Names) {
    const WHO: &str = "\"TODO\"     # a code; or { column = \"…\" }, or { name = \"…\" } with a pattern in [name]";
    let or = |told: &Option<String>, else_: &str| told.as_deref().unwrap_or(else_).to_owned();
    let _ = write!(
        text,
        "{}\n[trial]\nparticipant = {}\nsession = {}\nenvironment = \"TODO\"     # as in study.toml\n\
         mode = {}\n",
        names.block,
        or(&names.participant, WHO),
        or(&names.session, "\"S01\""),
        or(&names.mode, "\"TODO\"            # as in study.toml"),
    );
    for (key, told) in [("repeat", &names.repeat), ("trial", &names.trial)] {
        if let Some(told) = told {
            let _ = writeln!(text, "{key} = {told}");
        }
    }
    text.push('\n');
}

fn write_form(text: &mut String, written: Written) {
    let delimiter = match written.delimiter {
        b'\t' => "\\t".to_owned(),
        other => char::from(other).to_string(),
    };
    let _ = writeln!(text, "delimiter = \"{delimiter}\"");
    let _ = writeln!(text, "decimal = \"{}\"", if written.decimal_comma { ',' } else { '.' });
    let _ = writeln!(text, "header = {}", written.header);
    if let Some(mark) = written.comment {
        let _ = writeln!(text, "comment = \"{}\"", char::from(mark));
    }
    if written.skip > 0 {
        let _ = writeln!(text, "skip = {}", written.skip);
    }
    match written.encoding {
        Encoding::Utf8 => {}
        Encoding::Utf16 => text.push_str("encoding = \"utf-16\"\n"),
        Encoding::Latin1 => text.push_str("encoding = \"latin-1\"\n"),
        Encoding::Windows1252 => text.push_str("encoding = \"windows-1252\"\n"),
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
}

impl Guessed {
    fn says(&self, known: &[&str]) -> bool {
        self.words.iter().any(|word| known.contains(&word.as_str()))
    }

    /// A name for it among the study's channels: that of a winding's current has a fixed meaning.
    fn channel(&self) -> String {
        if self.says(&CURRENTS) {
            let which = if self.says(&["brake", "bremse"]) { CURRENT_BRAKE } else { CURRENT_MOTOR };
            return which.to_owned();
        }
        let asked_for = |word: &&String| !COMMANDED.contains(&word.as_str());
        let words: Vec<String> = self.words.iter().filter(asked_for).cloned().collect();
        let is_angle = match words.is_empty() {
            true => self.unit.as_deref().is_some_and(|unit| ["rad", "deg", "°"].contains(&unit)),
            false => signal_of(&words) == Some(Signal::Theta),
        };
        if words.len() < self.words.len() && is_angle {
            return REFERENCE.to_owned();
        }
        let is_plain = |letter: &char| letter.is_ascii_alphanumeric() || *letter == '_';
        let words = self.words.iter().map(|word| word.chars().filter(is_plain).collect::<String>());
        let name = Vec::from_iter(
            words.chain(
                self.unit
                    .as_ref()
                    .map(|unit| unit.chars().filter(is_plain).collect::<String>().to_lowercase()),
            ),
        )
        .join("_");
        if name.is_empty() { format!("column_{}", self.place + 1) } else { name }
    }

    fn unit_line(&self, which: &str) -> String {
        self.unit
            .as_ref()
            .map_or_else(|| format!("\"TODO\"            # {which}"), |unit| format!("\"{unit}\""))
    }

    fn write(&self, text: &mut String) {
        let Self { from, .. } = self;
        let _ = match self.to {
            Some(Signal::Time) => Ok(()),
            Some(to) => {
                let unit = self.unit_line("which?");
                writeln!(text, "\n[[column]]\nto = \"{}\"\nfrom = {from}\nunit = {unit}", to.name())
            }
            None if LABELS.iter().any(|(_, known)| self.says(known)) => {
                let (key, _) =
                    LABELS.iter().find(|(_, known)| self.says(known)).unwrap_or(&LABELS[0]);
                writeln!(
                    text,
                    "\n# a label of the trial? Then under [trial]: {key} = {{ column = {from} }}"
                )
            }
            None if self.says(&ANSWERS) => {
                writeln!(text, "\n# an answer? Then under [trial]: likert = {{ column = {from} }}")
            }
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

/// Every column, each of ours at most once.
fn described(table: &Table, decimal_comma: bool) -> Vec<Guessed> {
    let mut taken = Vec::new();
    let one = |place: usize| {
        let name =
            table.names.as_ref().and_then(|names| names.get(place)).filter(|n| !n.is_empty());
        let is_number = is_number(&table.columns[place], decimal_comma);
        let Said { words, signal, unit } = name.map_or_else(Said::default, |name| said(name));
        let to = signal.filter(|to| is_number && !taken.contains(to));
        taken.extend(to);
        let from = name.map_or_else(|| (place + 1).to_string(), |name| quoted(name));
        Guessed { place, from, to, unit, is_number, words }
    };
    (0..table.columns.len().min(MOST_GUESSED)).map(one).collect()
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            letter if letter.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(letter));
            }
            letter => quoted.push(letter),
        }
    }
    quoted + "\""
}

fn first_numbers(cells: &Cells, decimal_comma: bool) -> Vec<Option<f64>> {
    let value = |row: usize| match cells.cell(row) {
        Cell::Number(value) => Some(value),
        Cell::Text(text) => number(text, decimal_comma).ok().flatten(),
        Cell::Empty => None,
    };
    (0..cells.len()).map(value).collect()
}

/// Whether most of a column's first cells are numbers.
fn is_number(cells: &Cells, decimal_comma: bool) -> bool {
    let looked_at = first_numbers(cells, decimal_comma);
    let looked_at = &looked_at[..looked_at.len().min(LOOKED_AT)];
    2 * looked_at.iter().flatten().count() > looked_at.len()
}

fn starts_over(cells: &Cells, decimal_comma: bool) -> bool {
    let times: Vec<f64> = first_numbers(cells, decimal_comma).into_iter().flatten().collect();
    times.windows(2).any(|t| t[1] < t[0])
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use super::*;

    fn check(name: &str, content: &[u8], expect: &[&str]) -> String {
        let world = World::new();
        let text = guess(&world.file(name, content), &[]).unwrap().mapping;
        for words in expect {
            assert!(text.contains(words), "'{words}' is not in\n{text}");
        }
        text
    }

    #[test]
    fn delimiter_decimal_mark_header_and_units_are_guessed() {
        check(
            "a.csv",
            b"rig 2\n\ntime_ms;angle (deg);F [mN];note\n0;-45,0;0,02;ok\n1;-44,9;-0,05;ok\n",
            &[
                "delimiter = \";\"\ndecimal = \",\"\nheader = true\nskip = 2\n",
                "[time]\nfrom = \"time_ms\"\nunit = \"ms\"\n",
                "to = \"theta_rad\"\nfrom = \"angle (deg)\"\nunit = \"deg\"\n",
                "to = \"force_ex_n\"\nfrom = \"F [mN]\"\nunit = \"mN\"\n",
                "# not recognised: \"note\", a column of texts",
            ],
        );
        check(
            "a.dat",
            b"0.0  1.5\n0.1  2.5\n0.2  3.5\n",
            &[
                "delimiter = \" \"\n",
                "header = false\n",
                "rate_hz = \"TODO\"",
                "# not recognised: 1, a column of numbers",
            ],
        );
        check(
            "a.log",
            b"t|\xfcber\n0|1\n1|2\n0|3\n",
            &["format = \"txt\"\ndelimiter = \"|\"", "encoding = \"latin-1\"", "split = \"time\""],
        );
    }

    #[test]
    fn a_name_of_several_words_says_what_it_is_and_whether_it_was_only_asked_for() {
        check(
            "a.csv",
            b"t_s_inferred,x_desired_mm,x_measured_mm,force_desired_N,force_measured_N,theta_dot\n0,1,2,3,4,5\n1,1,2,3,5,6\n",
            &[
                "[time]\nfrom = \"t_s_inferred\"\nunit = \"s\"\n",
                "# not recognised: \"x_desired_mm\"",
                "# to = \"reference_rad\"\n# from = \"x_desired_mm\"\n",
                "to = \"theta_rad\"\nfrom = \"x_measured_mm\"\nunit = \"mm\"\n",
                "to = \"force_cmd_n\"\nfrom = \"force_desired_N\"\nunit = \"N\"\n",
                "to = \"force_ex_n\"\nfrom = \"force_measured_N\"\nunit = \"N\"\n",
                "to = \"theta_dot_rad_s\"\nfrom = \"theta_dot\"\nunit = \"TODO\"",
            ],
        );
    }

    #[test]
    fn a_column_of_a_current_an_answer_or_anything_else_is_told_where_it_may_go() {
        check(
            "a.csv",
            b"t_s,Brake current (A),Grip force [kg],likert,x y,controller,repetition\n0,1,2,3,4,pid,1\n1,1,2,3,5,pid,1\n",
            &[
                "under [trial]: mode = { column = \"controller\" }",
                "under [trial]: repeat = { column = \"repetition\" }",
                "# to = \"current_brake_a\"\n# from = \"Brake current (A)\"\n",
                "likert = { column = \"likert\" }",
            ],
        );
    }

    #[test]
    fn lines_of_remarks_before_the_header_are_comments() {
        check(
            "a.txt",
            b"% knob logger v2\n% rate 1000\nt_s\ttheta_rad\tref_rad\tF\n0\t1\t0\t2\n1\t2\t0\t2\n",
            &[
                "delimiter = \"\\t\"\ndecimal = \".\"\nheader = true\ncomment = \"%\"\n",
                "[time]\nfrom = \"t_s\"\nunit = \"s\"\n",
                "# to = \"reference_rad\"\n# from = \"ref_rad\"\n",
            ],
        );
    }

    #[test]
    fn a_header_behind_a_mark_of_remarks_is_a_header() {
        check("a.csv", b"#t_s,theta_rad\n0,1\n1,2\n", &["header = true\n", "from = \"theta_rad\""]);
    }

    #[test]
    fn a_velocity_that_was_not_recorded_is_derived() {
        let derived = "to = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        check("a.csv", b"time_ms,angle_deg\n0,1\n1,2\n", &[derived]);
        let world = World::new();
        for text in ["t_s,theta_rad,omega\n0,1,2\n1,2,3\n", "t_s,force_n\n0,1\n1,2\n"] {
            assert!(
                !guess(&world.file("b.csv", text), &[]).unwrap().mapping.contains("derive"),
                "{text}"
            );
        }
    }

    /// What is guessed imports, once what only a person knows is filled in.
    #[test]
    fn a_guess_with_its_blanks_filled_in_imports() {
        let world = World::new();
        let file = world.file("a.csv", "Time (s)\tForce (N)\r\n0\t1,5\r\n0,5\t2,5\r\n");
        let text = guess(&file, &[]).unwrap().mapping;
        let filled = text
            .replacen("\"TODO\"     # a code", "\"P01\"     # a code", 1)
            .replace("environment = \"TODO\"", "environment = \"spring\"")
            .replace("mode = \"TODO\"", "mode = \"hybrid\"");
        world.import(&filled, &[file]).unwrap_or_else(|e| panic!("{e:#?}\n{filled}"));
        assert_eq!(world.column(1, Signal::ForceEx), [1.5, 2.5]);
    }

    #[test]
    fn a_recording_without_text_is_described_by_its_columns() {
        check(
            "a.jsonl",
            b"{\"t\":0,\"force\":1}\n{\"t\":1,\"force\":2}\n",
            &["[time]\nfrom = \"t\"\n", "to = \"force_ex_n\"\nfrom = \"force\"\nunit = \"TODO\""],
        );
    }
}
