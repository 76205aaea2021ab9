//! What leaves: the tables, the trials that count, and what is told of them.

use crate::ExportError;
use crate::format::Format;
use crate::rename::Codes;
use crate::study_file::study_file;
use crate::tables::{Late, Sources, from_beginnings, outward};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use zwidth_results::{Column, Field, Type, Values};
use zwidth_store::{
    Lasting, SamplesWriter, Signal, StudyData, Trial, TrialEntry, read_trial,
    read_trial_and_channels,
};
use zwidth_study::{
    Channel, ChannelId, Kind, Known, ParticipantId, PersonValue, Status, TrialMeta, counted,
};
use zwidth_tables::{Table, csv};

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Forms besides the tables and `samples.parquet`.
    pub formats: BTreeSet<Format>,
    /// Whether what is known of people goes too.
    pub people: bool,
    /// The licence, by its SPDX id.
    pub licence: Option<String>,
    /// The day of the export, `2026-01-31`.
    pub date: String,
    /// The program and its version.
    pub software: String,
}

/// A derived table, and the origin that its file bears.
#[derive(Debug, Clone)]
pub struct Origin {
    /// The table as the study has it.
    pub table: Table,
    /// The origin; none of a table that was joined.
    pub origin: Option<String>,
}

/// A trial that begins so far from 0 counts its time from something else than its beginning, s.
const LATE_S: f64 = 60.0;

/// A trial whose samples leave.
#[derive(Debug, Clone)]
pub struct ExportedTrial {
    /// Who, by the code that leaves, and what.
    pub meta: TrialMeta,
    path: Arc<Path>,
    signals: Vec<Signal>,
    channels: Vec<ChannelId>,
    /// The time of its first sample where that is far from 0, else 0, s.
    begin_s: f64,
}

impl ExportedTrial {
    fn of(entry: &TrialEntry) -> Self {
        let channels = entry.said.form.channels.iter().map(|channel| channel.id.clone());
        Self {
            meta: entry.meta.clone(),
            path: entry.path.clone(),
            signals: entry.said.signals.clone(),
            channels: channels.collect(),
            begin_s: 0.0,
        }
    }

    /// The same, counted from its first sample where that is far from 0: as an import took it over, its
    /// time may be one of the day.
    fn begun(self) -> Result<Self, ExportError> {
        // Time is read anyhow.
        let samples = read_trial(&self.path, [])?.samples;
        let first_s = samples.get(Signal::Time).and_then(|t_s| t_s.first().copied());
        Ok(Self { begin_s: first_s.filter(|t_s| t_s.abs() > LATE_S).unwrap_or_default(), ..self })
    }

    /// Its samples.
    ///
    /// # Errors
    /// Those of [`read_trial_and_channels`].
    pub(crate) fn read(&self) -> Result<Trial, ExportError> {
        let signals = self.signals.iter().copied();
        let mut trial = read_trial_and_channels(&self.path, signals, &self.channels)?;
        if self.begin_s.abs() > 0.0 {
            let t_s = trial.samples.get(Signal::Time).unwrap_or_default();
            let t_s = t_s.iter().map(|t_s| t_s - self.begin_s).collect();
            trial.samples.set(Signal::Time, t_s);
        }
        // Of an unsealed session only the log knows the modes; and people may have other codes.
        Ok(Trial { meta: self.meta.clone(), ..trial })
    }

    /// Its folders and the end of its name, as files of trials lie: `participant=P01/session=S01/trial-017`.
    pub(crate) fn stem(&self) -> String {
        let TrialMeta { participant, session, trial, .. } = &self.meta;
        format!("participant={participant}/session={session}/trial-{trial:03}")
    }

    /// The same with all that `zwidth import` has to know of the trial.
    pub(crate) fn told(&self) -> String {
        let TrialMeta { environment, mode, repeat, .. } = &self.meta;
        format!("{}_environment={environment}_mode={mode}_repeat={repeat}", self.stem())
    }
}

/// A column as it is described to others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Described {
    pub(crate) name: String,
    /// `number`, `integer`, `string` or `boolean`.
    pub(crate) kind: &'static str,
    pub(crate) unit: String,
    pub(crate) about: String,
}

/// What leaves.
pub struct Contents {
    /// The study's id.
    pub study: String,
    /// Its title.
    pub title: String,
    /// The tables, with their origins.
    pub tables: Vec<Origin>,
    /// The trials, in the order in which their samples are written.
    pub trials: Vec<ExportedTrial>,
    /// Where the numbers come from.
    pub source: String,
    /// Whether any of them was not measured.
    pub is_simulated: bool,
    /// Whether participants have random codes.
    pub is_renamed: bool,
    /// What stays behind, a line each.
    pub left_out: Vec<String>,
    /// The participants' file, if it goes along.
    pub(crate) people: Option<String>,
    /// The study's file, without what is of the inside.
    pub(crate) study_toml: String,
    /// The signals that some trial has.
    pub(crate) signals: Vec<Signal>,
    /// Those that every trial has.
    pub(crate) in_all: Vec<Signal>,
    /// The study's own channels that some trial's form has.
    pub(crate) channels: Vec<Channel>,
    /// Whether some trials are presentations of tasks.
    pub(crate) tasks: bool,
}

impl Contents {
    /// What leaves of a study, of which these are the derived tables. `text` is its study.toml. With
    /// `codes` participants are renamed.
    ///
    /// # Errors
    /// A table that is none; a study.toml that cannot be read.
    pub fn of(
        data: &StudyData,
        text: &str,
        derived: Vec<Origin>,
        asked: &Asked,
        codes: Option<&Codes>,
    ) -> Result<Self, ExportError> {
        let trials = data.counting().map(|entry| ExportedTrial::of(entry).begun());
        let mut trials = trials.collect::<Result<Vec<_>, ExportError>>()?;
        let late = trials.iter().filter(|trial| trial.begin_s.abs() > 0.0).map(|trial| {
            let TrialMeta { participant, session, trial: number, .. } = &trial.meta;
            let key = (participant.to_string(), session.to_string(), i64::from(*number));
            (key, trial.begin_s)
        });
        let late: Late = late.collect();
        let sources = Sources::of(data);
        let mut left_out = Vec::new();
        let mut tables = Vec::new();
        let care = derived.iter().find(|own| own.table.name() == "trials");
        let trials_table = table_of_trials(data, care.map(|own| &own.table), codes.is_some())?;
        let known = participants(data, asked.people)?;
        // As zwidth reads what is known of people: without a source.
        let people = match codes {
            _ if !asked.people || data.study.people.is_empty() => None,
            Some(codes) => Some(csv(&codes.rename(&known)?.0)),
            None => Some(csv(&known)),
        };
        let own = [trials_table, known].map(|table| Origin { table, origin: None });
        let others = derived.into_iter().filter(|own| own.table.name() != "trials");
        for Origin { table, origin } in own.into_iter().chain(others) {
            let table = from_beginnings(&outward(&table, &sources)?, &late)?;
            let Some(codes) = codes else {
                tables.push(Origin { table, origin });
                continue;
            };
            let (table, columns) = codes.rename(&table)?;
            let of =
                |column| format!("column {column} of {}: it may say who somebody is", table.name());
            left_out.extend(columns.into_iter().map(of));
            tables.push(Origin { table, origin: None });
        }
        for trial in trials.iter_mut() {
            let Some(codes) = codes else { break };
            if let Some(code) = codes.of(&trial.meta.participant) {
                trial.meta.participant = code.clone();
            }
            // A device's own clock may be one of the day.
            trial.signals.retain(|signal| *signal != Signal::DeviceTime);
        }
        let key = |trial: &ExportedTrial| {
            let TrialMeta { participant, session, trial, .. } = &trial.meta;
            (participant.clone(), session.clone(), *trial)
        };
        trials.sort_by_key(key);
        let signals =
            Signal::all().filter(|signal| trials.iter().any(|t| t.signals.contains(signal)));
        let in_all =
            Signal::all().filter(|signal| trials.iter().all(|t| t.signals.contains(signal)));
        let has = |channel: &&Channel| trials.iter().any(|t| t.channels.contains(&channel.id));
        let channels = data.study.channels.iter().filter(has).cloned().collect();
        let mut all = left_behind(data);
        if !data.study.people.is_empty() && !asked.people {
            let ids: Vec<&str> = data.study.people.iter().map(|own| own.id.as_str()).collect();
            all.push(format!(
                "what is known of people ({}): --people takes it along",
                ids.join(", ")
            ));
        }
        if codes.is_some() {
            all.push("the device's own clock, hashes and origins of files".to_owned());
        }
        all.extend(left_out);
        Ok(Self {
            study: data.study.id.to_string(),
            title: data.study.title.clone(),
            tables,
            source: sources.told(&(None, None, None)).unwrap_or_default(),
            is_simulated: is_simulated(data),
            is_renamed: codes.is_some(),
            left_out: all,
            people,
            study_toml: study_file(text)?,
            signals: signals.collect(),
            in_all: in_all.collect(),
            channels,
            tasks: trials.iter().any(|trial| trial.meta.presented.is_some()),
            trials,
        })
    }

    /// The columns of the table of samples.
    ///
    /// # Errors
    /// None that a person meets: nothing is written.
    pub(crate) fn sample_columns(&self) -> Result<Vec<Described>, ExportError> {
        let nowhere = std::io::sink();
        let path = Path::new("samples.parquet");
        let writer = SamplesWriter::begin(
            nowhere,
            &self.signals,
            &self.channels,
            self.tasks,
            Lasting::Kept,
            path,
        )?;
        let columns = writer.fields().map(|(name, unit, about, kind)| Described {
            name: name.to_owned(),
            kind: match kind.as_str() {
                "Utf8" => "string",
                "Int32" | "UInt16" => "integer",
                _ => "number",
            },
            unit: unit.to_owned(),
            about: about.to_owned(),
        });
        Ok(columns.collect())
    }

    /// The mark of simulated data, with a blank before it, where there are some.
    pub(crate) fn mark(&self) -> &'static str {
        if self.is_simulated { " (SYNTHETIC: simulated, not measured)" } else { "" }
    }
}

/// The columns of a table.
pub(crate) fn described(table: &Table) -> Vec<Described> {
    let columns = table.fields().map(|field| Described {
        name: field.name.to_string(),
        kind: match field.kind {
            Type::Float => "number",
            Type::Integer => "integer",
            Type::Text => "string",
            Type::Flag => "boolean",
        },
        unit: field.unit.to_string(),
        about: field.description.to_string(),
    });
    columns.collect()
}

fn is_simulated(data: &StudyData) -> bool {
    let answered = data.answers.iter().filter_map(|a| data.session(&a.participant, &a.session));
    data.counting().any(|entry| entry.meta.source.is_simulated())
        || answered.into_iter().any(|log| log.record.source.is_simulated())
}

/// Every trial that leaves: those with samples, and those that were only answered.
fn table_of_trials(
    data: &StudyData,
    known: Option<&Table>,
    renamed: bool,
) -> Result<Table, ExportError> {
    struct Row<'a> {
        meta: TrialMeta,
        entry: Option<&'a TrialEntry>,
    }
    let key = |meta: &TrialMeta| (meta.participant.clone(), meta.session.clone(), meta.trial);
    let with_samples = data.counting();
    let mut rows: BTreeMap<_, Row> = with_samples
        .map(|entry| (key(&entry.meta), Row { meta: entry.meta.clone(), entry: Some(entry) }))
        .collect();
    for answer in &data.answers {
        let Some(log) = data.session(&answer.participant, &answer.session) else { continue };
        let Some(planned) = log.trials.iter().find(|planned| planned.trial == answer.trial) else {
            continue;
        };
        let meta = TrialMeta {
            participant: answer.participant.clone(),
            session: answer.session.clone(),
            trial: answer.trial,
            repeat: planned.repeat,
            kind: planned.kind,
            status: Status::Complete,
            environment: answer.condition.environment.clone(),
            mode: answer.condition.mode.clone(),
            likert: None,
            source: log.record.source,
            presented: None,
        };
        rows.entry(key(&meta)).or_insert(Row { meta, entry: None });
    }
    let rows: Vec<Row> = rows.into_values().collect();
    let mut doubted = BTreeSet::new();
    if let Some(known) = known {
        let cares = known.flags("read_with_care")?;
        let trials = known.integers("trial")?;
        let people = known.texts("participant")?;
        let sessions = known.texts("session")?;
        for (row, _) in (0..).zip(cares).filter(|(_, care)| *care == Some(true)) {
            let of_row: usize = row;
            doubted.insert((people[of_row].clone(), sessions[of_row].clone(), trials[of_row]));
        }
    }
    let is_doubted = |row: &Row| {
        let TrialMeta { participant, session, trial, .. } = &row.meta;
        let key = (participant.to_string(), session.to_string(), i64::from(*trial));
        doubted.contains(&(Some(key.0), Some(key.1), Some(key.2)))
    };
    let of = |get: &dyn Fn(&TrialMeta) -> String| -> Vec<Option<String>> {
        rows.iter().map(|row| Some(get(&row.meta))).collect()
    };
    let samples =
        rows.iter().map(|row| row.entry.map_or(Some(0), |entry| i64::try_from(entry.rows).ok()));
    let mut columns = vec![
        Column::text("participant", "who", of(&|m| m.participant.to_string())),
        Column::text("session", "in which session", of(&|m| m.session.to_string())),
        Column::integer(
            "trial",
            "1",
            "its number in the session",
            rows.iter().map(|row| Some(row.meta.trial.into())),
        ),
        Column::integer(
            "repeat",
            "1",
            "of its condition",
            rows.iter().map(|row| Some(row.meta.repeat.into())),
        ),
        Column::text("environment", "what was rendered", of(&|m| m.environment.to_string())),
        Column::text("mode", "how it was rendered", of(&|m| m.mode.to_string())),
        Column::text(
            "source",
            "where its numbers come from: recorded, imported, twin or simulated; the last two were not measured",
            of(&|m| m.source.as_str().to_owned()),
        ),
        Column::integer(
            "samples",
            "1",
            "how many samples it has; 0 if it was only answered",
            samples,
        ),
        Column::flag(
            "read_with_care",
            "whether it counts and something was found in it",
            rows.iter().map(|row| Some(is_doubted(row))),
        ),
    ];
    if !renamed {
        columns.push(Column::text(
            "file_blake3",
            "BLAKE3 of the file with its recording",
            rows.iter().map(|row| row.entry.map(|entry| entry.blake3.clone())),
        ));
    }
    Ok(Table::new("trials", "Trials that count", columns)?)
}

/// Everybody who has something that counts, and, if asked for, what is known of them.
fn participants(data: &StudyData, people: bool) -> Result<Table, ExportError> {
    let with_samples = data.counting().map(|entry| &entry.meta.participant);
    let answered = data.answers.iter().map(|answer| &answer.participant);
    let everybody: BTreeSet<&ParticipantId> = with_samples.chain(answered).collect();
    let codes = everybody.iter().map(|person| Some(person.as_str()));
    let mut columns = vec![Column::text("participant", "code of a person", codes)];
    for column in data.study.people.iter().filter(|_| people) {
        let of = |person: &&ParticipantId| data.people.row(person)?.get(&column.id);
        let values = match &column.known {
            Known::Level { .. } => Values::Text(
                everybody
                    .iter()
                    .map(|person| of(person).map(|level| level.to_string().into()))
                    .collect(),
            ),
            Known::Number { .. } => Values::Float(
                everybody
                    .iter()
                    .map(|person| match of(person)? {
                        PersonValue::Number(number) => Some(*number),
                        PersonValue::Level(_) => None,
                    })
                    .collect(),
            ),
        };
        let unit = match &column.known {
            Known::Level { .. } => "1".to_owned(),
            Known::Number { unit } => unit.clone(),
        };
        let field = Field {
            name: column.id.to_string().into(),
            unit: unit.into(),
            description: "what is known of the person, by the participants' file".into(),
            kind: values.kind(),
        };
        columns.push(Column { field, values });
    }
    Ok(Table::new("participants", "Participants", columns)?)
}

/// What stays behind whatever is asked for, a line each.
fn left_behind(data: &StudyData) -> Vec<String> {
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for trial in data.trials.iter().filter(|trial| !trial.counts()) {
        // What was said of an exclusion is the person's own.
        let why = match trial {
            TrialEntry { meta: TrialMeta { kind: Kind::Familiarisation, .. }, .. } => {
                "familiarisation"
            }
            TrialEntry { meta: TrialMeta { status: Status::Incomplete, .. }, .. } => "incomplete",
            TrialEntry { superseded_by: Some(_), .. } => "superseded",
            TrialEntry { excluded: Some(_), .. } => "excluded",
            _ => "sealed, or of an unknown session, environment or mode",
        };
        *reasons.entry(why).or_default() += 1;
    }
    let trials = reasons
        .into_iter()
        .map(|(why, n)| format!("{} of those that do not count: {why}", counted(n, "trials")));
    let mut lines: Vec<String> = trials.collect();
    if !data.answers_left_out.is_empty() {
        let answers = counted(data.answers_left_out.len(), "answers");
        lines.push(format!("{answers} to such trials, or replaced by a later one"));
    }
    if !data.problems.is_empty() {
        lines.push(format!("{} that cannot be read", counted(data.problems.len(), "files")));
    }
    if !data.sweeps.is_empty() {
        lines.push(format!("{} of actuators and sensors", counted(data.sweeps.len(), "sweeps")));
    }
    lines.push("logs of sessions: notes, reasons, who said what, and all clock times".to_owned());
    lines.push("names of files that were imported, of ports and computers".to_owned());
    lines.push(
        "the time at which a trial began, where its samples are more than a minute away from 0"
            .to_owned(),
    );
    if !data.study.stages.is_empty() {
        lines.push("programs of the study's own stages, and how they are started".to_owned());
    }
    lines.push("figures, pages and derived tables that are not listed".to_owned());
    lines
}
