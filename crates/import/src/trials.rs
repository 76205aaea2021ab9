//! Files of samples → trials.

use super::batch::{Batch, Output};
use super::blocks::{blake3_of, is_long};
use super::context::{Context, Converted, EMPTY, EMPTY_AT_A_RATE, MISSING, Step, given_once};
use super::errors::{Errors, all};
use super::growing::{Growing, Part};
use super::identity::{Identity, identity, number_trials, tell_labels};
use super::join::{self, Joiner, Uses};
use super::limits::{Budget, MOST_FILE};
use super::mapping::{TrialsFrom, Who};
use super::outline::Outline;
use super::plan::{Plan, plan};
use super::recorded::{Said, Sayings, place_presented};
use super::recording::{Gaps, Recording, Rows, Standing};
use super::report::{FileReport, RowsDropped, null_columns};
use super::stream::Source as LongText;
use super::table::{Cells, ColumnRef};
use super::{counter, once, outline, unit};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use zwidth_store::{
    Asked, DOUBTS, GAPS, JOINED, LOST, Samples, Signal, StoreError, Trial, TrialFile, TrialWriter,
    ZEROS, check_form, check_samples, trial_bytes,
};
use zwidth_study::{AnswerValue, Event, PlannedTrial, Status, TrialMeta};

/// The trials of a file.
struct FileTrials {
    identities: Vec<Identity>,
    /// What is said of each.
    said: Vec<Said>,
    /// What was joined to the recording.
    uses: Uses,
    /// None of a long text: its samples are read once more when they are written.
    made: Vec<Made>,
    /// None yet of a long text, which was read for its labels alone.
    report: Option<FileReport>,
}

/// The samples of one trial, and notes in its file on how it was made.
struct Made {
    samples: Samples,
    /// Samples missing between its first and its last ([`GAPS`]).
    gaps: Option<String>,
    /// The parts of the recording that could not be read ([`LOST`]).
    lost: Option<String>,
    /// The zeros of its sensors ([`ZEROS`]).
    zeros: Vec<String>,
    /// Why it is to be read with care although its samples do not show it ([`DOUBTS`]).
    doubts: Vec<String>,
    /// The files that were joined to it ([`JOINED`]).
    joined: Vec<String>,
}

/// A trial's file.
struct Encoded {
    path: PathBuf,
    output: Output,
    /// The trial in words, for the report.
    words: String,
    care: Vec<String>,
    /// The parts of the recording that could not be read.
    lost: Option<String>,
}

/// Converts every file, numbers the trials over all of them, and encodes them.
pub(super) fn trials(
    context: &Context,
    from: &TrialsFrom,
    files: &[PathBuf],
) -> Result<Batch, Errors> {
    let TrialsFrom { who, time, columns, channels, beside } = from;
    // Before any file is read: whatever is in them, the study takes no trial of another form.
    check_form(context.files, context.layout, context.study)?;
    let mut plan = plan(context.study, &context.mapping.path, time, columns, channels)?;
    let named: Vec<&ColumnRef> =
        plan.columns().chain(who.columns()).chain(beside.columns()).collect();
    plan.computed.extend(beside.words(&named));
    let budget = Budget::default();
    let splits_at = context.mapping.file.splits_at_time;
    let joiner = Joiner::new(beside, who, &plan, &budget, splits_at, named);
    let converted = convert_files(context, from, &plan, &joiner, &budget, files)?;
    // Before those that are there already are left out: a log has their rows too.
    let uses = converted.iter().map(|file| (file.path.as_path(), &file.parsed.uses));
    let of_joined = join::check(uses)?;
    let (mut converted, existing) =
        once::new_trials(context, converted, |file| file.identities.iter().collect())?;
    // Samples of long texts are not there yet.
    let made = converted.iter_mut().map(|file| &mut file.parsed);
    let mut made: Vec<(&Identity, &mut Made)> =
        made.flat_map(|file| file.identities.iter().zip(&mut file.made)).collect();
    let outlines: Vec<Outline> =
        made.iter().map(|(identity, made)| Outline::of(identity, &made.samples)).collect();
    for ((_, made), doubts) in made.iter_mut().zip(outline::doubts(&outlines)) {
        made.doubts.extend(doubts);
    }
    let identities = converted.iter().flat_map(|file| &file.parsed.identities);
    let identities: Vec<Identity> = identities.cloned().collect();
    let mut planned = number_trials(context, &identities, true)?;
    let said = converted.iter().flat_map(|file| &file.parsed.said);
    let said: Vec<Said> = said.cloned().collect();
    if beside.task.is_some() {
        place_presented(context, &said, &mut planned)?;
    }
    let mut batch = Batch { files: existing, ..Batch::default() };
    let mut numbers = planned.iter();
    let mut losses = Vec::new();
    for Converted { path, blake3, parsed } in converted {
        let FileTrials { identities: own, made, report, .. } = parsed;
        let numbered: Vec<(&Identity, &PlannedTrial)> = own.iter().zip(numbers.by_ref()).collect();
        let encoded = match report {
            Some(report) => all(numbered
                .into_par_iter()
                .zip(made)
                .map(|((own, number), made)| encode(context, &plan, own, made, number, &blake3))
                .collect::<Vec<_>>())
            .map(|encoded| (encoded, report)),
            None => stream_trials(context, who, &plan, &path, numbered, &blake3),
        };
        // The trials after it are not written, and those before it are taken away again.
        let (encoded, mut report) = encoded.inspect_err(|_| batch.discard(context.files))?;
        tell_labels(&mut report, &own, &identities);
        report.told.extend(of_joined.get(&path).cloned());
        for Encoded { path, output, words, care, lost } in encoded {
            report.made.push(words);
            report.care.extend(care);
            losses.push(lost);
            batch.outputs.push((path, output));
        }
        batch.files.push(report);
    }
    let mut events = Vec::new();
    // Long texts have nothing but samples and labels.
    let said = said.iter().map(Some).chain(std::iter::repeat(None));
    let trials = planned.iter().zip(&identities).zip(losses).zip(said);
    for ((((number, identity), lost), said), (_, output)) in trials.zip(&batch.outputs) {
        let trial = number.trial;
        let recorded = Event::Recorded { trial, blake3: output.blake3() };
        // An answer may stand beside the samples.
        let environment = context.study.environment(&identity.environment);
        let question = environment.and_then(|environment| environment.question.clone());
        let answer = question.zip(identity.likert);
        let answer =
            answer.map(|(question, value)| Event::Answer { trial, question, value, time_ms: None });
        let lost = lost.map(|text| Event::Note { trial: Some(trial), text });
        let said = said.into_iter().flat_map(|said| said.events(trial));
        events.push(std::iter::once(recorded).chain(answer).chain(said).chain(lost).collect());
    }
    // The trials' own footers say what they were imported from.
    batch.add_sessions(context, &identities, &planned, events, &[])?;
    Ok(batch)
}

/// Converts the short files, and reads the labels of long texts; all in the order of `files`.
fn convert_files(
    context: &Context,
    from: &TrialsFrom,
    plan: &Plan,
    joiner: &Joiner,
    budget: &Budget,
    files: &[PathBuf],
) -> Result<Vec<Converted<FileTrials>>, Errors> {
    let (long, short): (Vec<PathBuf>, Vec<PathBuf>) =
        files.iter().cloned().partition(|path| is_long(path, &context.mapping.file));
    // Columns that no mapping names may count the samples that the times pass over.
    // Of a file as large as no other is read, there is room for those that are mapped alone.
    let is_large = |path: &PathBuf| path.metadata().is_ok_and(|file| file.len() > MOST_FILE);
    let looked_at: Vec<ColumnRef> = match short.iter().any(is_large) {
        true => Vec::new(),
        false => counter::looked_at().collect(),
    };
    let TrialsFrom { who, beside, .. } = from;
    let named = plan.columns().chain(who.columns()).chain(beside.columns());
    let own = named.filter(|column| !beside.is_of_file(column));
    let taken = own.chain(&looked_at).collect();
    let take = context.take(taken, budget);
    let mut short = match short.is_empty() {
        true => Vec::new(),
        false => context.convert(&short, &take, |recording| {
            convert(context, from, plan, joiner, budget, recording)
        })?,
    };
    if long.is_empty() {
        return Ok(short);
    }
    let mut long = all(long.iter().map(|path| {
        let blake3 = blake3_of(path)?;
        let Some(source) = LongText::of(context, who, plan, path)? else {
            let what = "it was long when the import began, and is not now";
            return Err(StoreError::new(path, what, "import it again").into());
        };
        let identities = source.identities(budget)?;
        let (said, uses) = (Vec::new(), Uses::default());
        let parsed = FileTrials { identities, said, uses, made: Vec::new(), report: None };
        Ok::<_, Errors>(Converted { path: path.clone(), blake3, parsed })
    }))?;
    let mut in_order = Vec::new();
    for path in files {
        for list in [&mut short, &mut long] {
            if let Some(at) = list.iter().position(|c| c.path == *path) {
                in_order.push(list.remove(at));
                break;
            }
        }
    }
    given_once(&in_order)?;
    Ok(in_order)
}

/// Writes the trials of a long text beside their places, and makes the report on it.
fn stream_trials(
    context: &Context,
    who: &Who,
    plan: &Plan,
    path: &Path,
    trials: Vec<(&Identity, &PlannedTrial)>,
    blake3: &str,
) -> Result<(Vec<Encoded>, FileReport), Errors> {
    let source = LongText::of(context, who, plan, path)?.ok_or_else(|| changed(path))?;
    let mut trials = trials.into_iter();
    let mut encoded: Vec<Encoded> = Vec::new();
    let mut open: Option<Open> = None;
    let mut report = None;
    let walked = source.walk(&|bytes| (context.progress)(Step::Read(bytes)), &mut |stretch| {
        if stretch.begins {
            encoded.extend(open.take().map(|open| open.end(context)).transpose()?);
            let (identity, number) = trials.next().ok_or_else(|| changed(path))?;
            open = Some(Open::begin(context, plan, path, identity, number, blake3)?);
        }
        if report.is_none() {
            let (recording, used) = stretch.recording();
            report = Some(context.file_report(recording, &Rows::default(), 0, &used)?);
        }
        if let Some(Open { growing, writer, .. }) = &mut open {
            growing.add(&stretch.part())?;
            growing.write(writer, false)?;
        }
        Ok(true)
    });
    let ended = walked.and_then(|walked| {
        encoded.extend(open.take().map(|open| open.end(context)).transpose()?);
        let report = report.take().ok_or_else(|| changed(path))?;
        // The labels were read in a first pass: they are those of the samples only if nothing changed.
        if walked.blake3 != blake3 || trials.next().is_some() {
            return Err(changed(path));
        }
        Ok((walked, report))
    });
    match ended {
        Ok((walked, report)) => {
            let missing = (walked.rows.missing > 0)
                .then(|| RowsDropped { rows: walked.rows.missing, why: MISSING.to_owned() });
            let signals = plan.taken.iter().map(|taken| taken.to);
            let signals: Vec<Signal> = signals
                .chain(plan.derived.iter().map(|(to, _)| *to))
                .chain([Signal::Time])
                .collect();
            let mut report = FileReport {
                rows_read: walked.rows.read,
                rows_kept: walked.kept,
                rows_dropped: missing.into_iter().collect(),
                converted: plan.converted.clone(),
                computed: plan.computed.clone(),
                null: null_columns(&signals),
                ..report
            };
            report.add_empty(walked.empty, why_empty(plan));
            Ok((encoded, report))
        }
        Err(errors) => {
            if let Some(Open { writer, .. }) = open {
                writer.discard(context.files);
            }
            let staged = Batch {
                outputs: encoded.into_iter().map(|e| (e.path, e.output)).collect(),
                ..Batch::default()
            };
            staged.discard(context.files);
            Err(errors)
        }
    }
}

fn changed(path: &Path) -> Errors {
    let what = "the file changed while it was read";
    StoreError::new(path, what, "import it again when nothing writes to it").into()
}

/// A trial of a long text that is being written.
struct Open<'a> {
    growing: Growing<'a>,
    writer: TrialWriter,
    path: PathBuf,
    identity: &'a Identity,
    number: &'a PlannedTrial,
}

impl<'a> Open<'a> {
    fn begin(
        context: &Context,
        plan: &'a Plan<'a>,
        from: &Path,
        identity: &'a Identity,
        number: &'a PlannedTrial,
        blake3: &str,
    ) -> Result<Self, StoreError> {
        let path = context.layout.trial(&identity.participant, &identity.session, number.trial);
        // In the study's own folder, which is there.
        let name =
            format!("{}_{}_trial-{}.parquet", identity.participant, identity.session, number.trial);
        let near = context.layout.raw().join(name);
        let meta = meta(context, identity, number);
        let file = file(context, plan, blake3);
        let form = context.study.trial_form();
        let writer = TrialWriter::begin(context.files, &near, &path, meta, file, &form)?;
        Ok(Self { growing: Growing::new(plan, from), writer, path, identity, number })
    }

    fn end(mut self, context: &Context) -> Result<Encoded, Errors> {
        let gaps = gap_words(self.growing.plan, self.growing.gaps(), self.growing.taken);
        if let Some(gaps) = gaps {
            self.writer.note(GAPS, gaps);
        }
        let hidden = self.growing.hidden();
        if let Some(hidden) = &hidden {
            self.writer.note(DOUBTS, hidden.clone());
        }
        if let Err(errors) = self.growing.write(&mut self.writer, true) {
            self.writer.discard(context.files);
            return Err(errors);
        }
        let staged = self.writer.end()?;
        let requested = Asked::of(context.study, &self.number.environment);
        let findings = staged.check(context.files, &requested);
        let findings = findings.inspect_err(|_| staged.discard(context.files))?;
        let samples = self.growing.rows;
        let mut care = care(&findings, self.number, samples);
        care.extend(hidden.map(|hidden| format!("trial {}, {hidden}", self.number.trial)));
        Ok(Encoded {
            words: words(self.identity, self.number, samples),
            care,
            path: self.path,
            output: Output::Staged(staged),
            // What cannot be read of a long text is an error.
            lost: None,
        })
    }
}

fn words(i: &Identity, number: &PlannedTrial, samples: usize) -> String {
    let PlannedTrial { trial, repeat, environment, mode, .. } = number;
    format!(
        "{} {} trial {trial}: {environment}, {mode}, repeat {repeat}, {samples} samples",
        i.participant, i.session
    )
}

/// Findings about the samples of a trial, in words, as `verify` and a run will report them too.
fn care(findings: &[StoreError], number: &PlannedTrial, samples: usize) -> Vec<String> {
    let mut lines = Vec::new();
    for StoreError { column, row, what, remedy, .. } in findings {
        let column = column.as_deref().unwrap_or_default();
        let row = row.map(|row| format!(", row {row}")).unwrap_or_default();
        lines.push(format!("trial {}, {column}{row}: {what}; {remedy}", number.trial));
    }
    if samples == 1 {
        lines.push(format!(
            "trial {}: it has one sample: nothing can be computed from it",
            number.trial
        ));
    }
    lines
}

/// A clock is too coarse if more than this share of the rows have the time of one before them.
const COARSE: f64 = 0.05;

/// One file's trials: consecutive rows with equal labels are one trial.
fn convert(
    context: &Context,
    from: &TrialsFrom,
    plan: &Plan,
    joiner: &Joiner,
    budget: &Budget,
    recording: &mut Recording,
) -> Result<FileTrials, Errors> {
    let TrialsFrom { who, beside, .. } = from;
    check_turned(context.mapping.file.turned, recording)?;
    let joins = beside.log.is_some() || !beside.with.is_empty();
    if let Some(time) = plan.time.filter(|_| joins) {
        recording.read_clock(time, time.from_first)?;
    }
    let uses = joiner.join(context, recording)?;
    let numeric = all(plan.columns().map(|column| recording.find(column)))?;
    let labels = all(who.columns().into_iter().map(|c| recording.find(c)))?;
    let mut other_units = all(plan.taken.iter().zip(&numeric).map(|(taken, place)| {
        recording.check_unit(*place, taken.unit.0, taken.unit.1, &taken.line)
    }))?;
    other_units.extend(all(plan.channels.iter().zip(&numeric[plan.taken.len()..]).map(
        |(channel, place)| match unit::declared(&channel.unit) {
            Some(unit) => recording.check_unit(*place, unit, &channel.unit, &channel.line),
            None => Ok(None),
        },
    ))?);
    let other_units: Vec<String> = other_units.into_iter().flatten().collect();
    if let Some(time) = plan.time {
        recording.read_clock(time, time.from_first)?;
    }
    let needed = all(who.needed_columns().into_iter().map(|c| recording.find(c)))?;
    recording.height(&numeric, &labels)?;
    let mut rows = recording.rows(&context.mapping.file, &numeric, &needed)?;
    if let Some(time) = plan.time {
        recording.mend(time, &mut rows, &numeric, &labels)?;
    }
    let recording = &*recording;
    let time = numeric.first().copied().filter(|_| context.mapping.file.splits_at_time);
    let wrap = time.and_then(|time| recording.numbers(time, &rows.kept).ok());
    if let Some(wrap) = wrap.and_then(|times| counter::wrap_of(&times)) {
        let what = format!(
            "its times start over as a counter does that ends at {wrap}, and are to be parted there: a movement would become two"
        );
        let remedy = format!("set wrap = {wrap} in [time] in place of backwards or split");
        return Err(recording.error(what, remedy).into());
    }
    let pieces = || {
        let labelled = recording.pieces(&rows.kept, &labels);
        labelled.flat_map(|rows| match time {
            Some(time) => recording.restarts(rows, time).collect(),
            None => vec![rows],
        })
    };
    // A row that comes twice is one sample; other rows of one time are several.
    let joined = rows.joined.iter().filter(|row| {
        numeric
            .iter()
            .any(|column| recording.number(*column, **row) != recording.number(*column, **row - 1))
    });
    let joined = joined.count();
    let coarse = (joined as f64 > COARSE * rows.read as f64).then(|| {
        format!(
            "t_s: {joined} of {} rows have the time of a row before them, and other values: its clock is too coarse for \
             them; take the time from a counter, or from rate_hz",
            rows.read
        )
    });
    // Counted before anything is made of them.
    budget.trials(&recording.path, pieces().count())?;
    let begins: Vec<usize> = pieces().map(|rows| rows[0]).collect();
    uses.check_begins(recording, &begins)?;
    let mut sayings = Sayings::new(context, beside);
    let trials = all(pieces().enumerate().map(|(i, stretch)| {
        let identity = identity(who, recording, stretch[0], context.study)?;
        let said = sayings.of(recording, stretch[0], &identity)?;
        let values = all(numeric.iter().map(|column| recording.numbers(*column, stretch)))?;
        let part = Part {
            recording,
            numeric: &numeric,
            labels: &labels,
            rows: stretch,
            values: values.iter().map(Vec::as_slice).collect(),
            before: Standing::default(),
            is_whole: true,
        };
        let mut growing = Growing::new(plan, &recording.path);
        growing.add(&part)?;
        let zeros = std::mem::take(&mut growing.zero_notes);
        let hidden = growing.hidden();
        let samples = growing.samples()?;
        let gaps = gap_words(plan, recording.gaps(&rows, stretch), stretch.len());
        // Rows that could not be read are the trial's before them, or the first one's.
        let from = if i == 0 { 0 } else { stretch[0] };
        let lost = recording.lost(&rows, from..begins.get(i + 1).copied().unwrap_or(usize::MAX));
        let lost = lost.map(|lost| match begins.len() {
            1 => lost,
            n => format!("{lost} (the recording has {n} trials)"),
        });
        let doubts = recording.table.doubts.iter().chain(&other_units).chain(&coarse).cloned();
        let doubts = doubts.chain(zeros.doubts).chain(hidden).collect();
        let zeros = zeros.words;
        let joined = uses.words(stretch[0]);
        Ok::<_, Errors>(((identity, said), Made { samples, gaps, lost, zeros, doubts, joined }))
    }))?;
    let (said, made): (Vec<(Identity, Said)>, Vec<Made>) = trials.into_iter().unzip();
    let (identities, said): (Vec<Identity>, Vec<Said>) = said.into_iter().unzip();
    let signals: Vec<Signal> =
        Signal::all().filter(|s| made.iter().any(|m| m.samples.get(*s).is_some())).collect();
    let of_answers = all(beside.columns().into_iter().map(|column| recording.find(column)))?;
    let used = [numeric.as_slice(), &labels, &of_answers].concat();
    let mut report = FileReport {
        converted: plan.converted.clone(),
        computed: plan.computed.clone(),
        null: null_columns(&signals),
        ..context.file_report(recording, &rows, rows.kept.len(), &used)?
    };
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, why_empty(plan));
    sayings.tell(&mut report, &said);
    // What was only looked at is not kept: its room is free for the next file.
    let looked_at = recording.table.columns.iter().enumerate();
    let looked_at = looked_at.filter(|(place, _)| !used.contains(place));
    budget.give_back(looked_at.map(|(_, cells)| cells.len()).sum());
    Ok(FileTrials { identities, said, uses, made, report: Some(report) })
}

/// Whether a matrix has its samples in rows: Simulink's "To File" has its signals there.
///
/// # Errors
/// It has a time, so few rows and so many columns that its rows are the signals.
pub(super) fn check_turned(turned: bool, recording: &Recording) -> Result<(), StoreError> {
    let table = &recording.table;
    if !table.is_turned() {
        return Ok(());
    }
    let rows = table.columns.iter().map(Cells::len).max().unwrap_or(0);
    let columns = table.columns.len();
    if table.names.is_some() || !table.lines.is_empty() {
        let what = format!("it has {rows} rows and {columns} columns: are its rows the signals?");
        return Err(recording.error(what, "turn the table, so that each signal has a column"));
    }
    let (what, remedy) = match turned {
        false => (
            format!("its matrix has {rows} rows and {columns} columns: its rows are the signals"),
            "set signals = \"rows\" in [file]",
        ),
        true => (
            format!(
                "its matrix has {columns} rows and {rows} columns: its columns are the signals"
            ),
            "remove signals = \"rows\" from [file]",
        ),
    };
    Err(recording.error(what, remedy))
}

/// Why empty rows of a file are left out.
fn why_empty(plan: &Plan) -> &'static str {
    if plan.rate_hz.is_some() { EMPTY_AT_A_RATE } else { EMPTY }
}

/// What a trial's file says of its gaps. Where times were recorded, they say when there was a sample,
/// and an empty row is none that is missing.
fn gap_words(plan: &Plan, gaps: Gaps, kept: usize) -> Option<String> {
    let empty = if plan.rate_hz.is_some() { gaps.empty } else { 0 };
    Gaps { empty, ..gaps }.in_words(kept)
}

/// One trial's file.
fn encode(
    context: &Context,
    plan: &Plan,
    identity: &Identity,
    Made { samples, gaps, lost, zeros, doubts, joined }: Made,
    number: &PlannedTrial,
    blake3: &str,
) -> Result<Encoded, StoreError> {
    let path = context.layout.trial(&identity.participant, &identity.session, number.trial);
    let requested = Asked::of(context.study, &number.environment);
    let findings = check_samples(&requested, Path::new(""), &samples);
    let words = words(identity, number, samples.len());
    let mut care = care(&findings, number, samples.len());
    care.extend(doubts.iter().map(|doubt| format!("trial {}, {doubt}", number.trial)));
    let meta = meta(context, identity, number);
    let mut file = file(context, plan, blake3);
    file.extend(gaps.map(|gaps| (GAPS.to_owned(), gaps)));
    file.extend(lost.clone().map(|lost| (LOST.to_owned(), lost)));
    for (key, lines) in [(ZEROS, zeros), (DOUBTS, doubts), (JOINED, joined)] {
        if !lines.is_empty() {
            file.insert(key.to_owned(), lines.join("; "));
        }
    }
    let trial = Trial { meta, file, samples };
    let bytes = trial_bytes(&trial, &context.study.trial_form(), &path)?;
    Ok(Encoded { path, output: bytes.into(), words, care, lost })
}

/// The metadata of an imported trial.
fn meta(context: &Context, identity: &Identity, number: &PlannedTrial) -> TrialMeta {
    let i = identity.clone();
    let presented = number.task.as_ref().and_then(|place| {
        let task = context.study.task(&place.task)?;
        Some(place.presented(task, place.level?))
    });
    TrialMeta {
        participant: i.participant,
        session: i.session,
        trial: number.trial,
        repeat: number.repeat,
        kind: i.kind,
        status: Status::Complete,
        environment: i.environment,
        mode: i.mode,
        // The file has answers on five points alone; any other answer is an event.
        likert: i.likert.and_then(AnswerValue::whole),
        source: context.mapping.source(),
        presented,
    }
}

/// The footer of an imported trial's file.
fn file(context: &Context, plan: &Plan, blake3: &str) -> TrialFile {
    let mut file: TrialFile = context.footer(blake3.to_owned(), &plan.computed);
    file.extend(plan.lever_m.map(|l| ("lever_m".to_owned(), l.to_string())));
    file
}

#[cfg(test)]
mod tests {
    use super::super::world::{
        COLUMNS, FORCE, ONE, World, close, column, template_once, trials_map,
    };
    use zwidth_store::{Signal, file_blake3, read_channels};
    use zwidth_study::{Event, Kind, Schema, Source};

    #[test]
    fn a_time_that_starts_over_begins_another_trial_where_the_mapping_says_so() {
        let world = World::new();
        let file = world.file("a.csv", "t,f\n0,1\n1,2\n0,3\n1,4\n2,5\n");
        let map = trials_map(&["[file]\nsplit = \"time\"\n", ONE, FORCE]);
        assert_eq!(world.import(&map, &[file]).unwrap().trials, 2);
        assert_eq!(world.column(2, Signal::ForceEx), [3.0, 4.0, 5.0]);
        let other = World::new();
        let file = other.file("a.csv", "t,f\n0,1\n1,2\n0,3\n");
        other.refuses(&trials_map(&[ONE, FORCE]), &file, "time runs backwards", None);
    }

    #[test]
    fn bad_lines_are_passed_by_and_each_is_reported() {
        let world = World::new();
        let file = world.file("a.csv", "t,f\n0,1\n1\n2,x\n3,4\n");
        let bad = |n: u32| trials_map(&[&format!("[file]\nbad_lines = {n}\n"), ONE, FORCE]);
        world.refuses(&bad(1), &file, "'x' is not a number", Some(("f", 3)));
        let report = world.import(&bad(2), &[file]).unwrap();
        let why: Vec<&str> = report.files[0].rows_dropped.iter().map(|d| d.why.as_str()).collect();
        let expect = [
            "line 3 has 1 cells where 2 belong (bad_lines)",
            "'x' is not a number (line 4) (bad_lines)",
        ];
        assert_eq!(why, expect);
        assert_eq!(world.column(1, Signal::Time), [0.0, 3.0]);
    }

    #[test]
    fn a_labchart_export_is_read_block_by_block() {
        let world = World::new();
        let text = "Interval=\t0.5 s\r\nChannelTitle=\tf\tx\r\nRange=\t1 N\t1 V\r\n0\t1\t0\r\n0.5\t2\t0\t#* go\r\n\
                    Interval=\t0.5 s\r\nChannelTitle=\tf\tx\r\n0\t3\t0\r\n0.5\t4\t0\r\n";
        let file = world.file("a.txt", text);
        let force = FORCE.replace("from = \"t\"", "from = \"Time\"");
        let map = trials_map(&["[file]\nsplit = \"time\"\n", ONE, &force]);
        let report = world.import(&map, &[file]).unwrap();
        assert_eq!(report.trials, 2);
        assert!(report.files[0].told[0].contains("LabChart"), "{:?}", report.files[0].told);
        assert_eq!(world.column(2, Signal::ForceEx), [3.0, 4.0]);
    }

    #[test]
    fn a_velocity_in_degrees_taken_for_radians_is_imported_and_said() {
        let world = World::new();
        let row = |i: i32| {
            let t = f64::from(i) * 0.005;
            let (sin, cos) = libm::sincos(3.0 * t);
            format!("{t},{},{}\n", 0.4 * sin, (1.2 * cos).to_degrees())
        };
        let rows: String = (0..200).map(row).collect();
        let columns = column("theta_rad", "x", "rad") + &column("theta_dot_rad_s", "v", "rad/s");
        let map = trials_map(&[ONE, "[time]\nfrom = \"t\"\nunit = \"s\"\n", &columns]);
        let report = world.import(&map, &[world.file("a.csv", format!("t,x,v\n{rows}"))]).unwrap();
        let [care] = &report.files[0].care[..] else { panic!("{report}") };
        let words = "trial 1, theta_dot_rad_s: the velocity is 57.3 times";
        assert!(care.starts_with(words), "{care}");
        let mended = map.replace("unit = \"rad/s\"", "unit = \"deg/s\"");
        let other = World::new();
        let file = other.file("a.csv", format!("t,x,v\n{rows}"));
        assert!(other.import(&mended, &[file]).unwrap().files[0].care.is_empty());
    }

    #[test]
    fn a_file_becomes_a_trial_a_session_and_an_event_with_the_files_hash() {
        let world = World::new();
        let file = world.file("a.csv", "t,f,note\n0,1,x\n0.5,1e-321,y\n1,-0,z\n");
        let report = world.import(&trials_map(&[ONE, FORCE]), &[file]).unwrap();
        assert_eq!((report.trials, report.sessions, report.answers), (1, 1, 0));
        assert_eq!((report.files[0].rows_read, report.files[0].rows_kept), (3, 3));
        assert_eq!(report.files[0].columns_dropped[0].column, "note");
        assert_eq!(report.files[0].null.len(), Signal::of(Schema::Two).count() - 2);
        let trial = world.trial("P01", "S01", 1);
        let bits: Vec<u64> = world.column(1, Signal::ForceEx).iter().map(|v| v.to_bits()).collect();
        assert_eq!(bits, [1.0, 1e-321, -0.0].map(f64::to_bits));
        assert_eq!(trial.samples.get(Signal::Theta), None);
        assert_eq!(trial.file["software"], "zwidth test");
        assert!(!trial.file.contains_key("made_by_import"), "nothing was computed");
        let path = world.layout.trials().join("participant=P01/session=S01/trial-001.parquet");
        let recorded = Event::Recorded { trial: 1, blake3: file_blake3(&path).unwrap() };
        assert_eq!(world.events("P01", "S01"), [recorded]);
        let data = world.load();
        assert_eq!((data.counting().count(), data.sessions[0].record.trials.len()), (1, 1));
    }

    #[test]
    fn a_column_becomes_a_channel_of_the_study_in_its_unit_and_no_other() {
        let map = |to: &str, unit: &str| {
            let channel = column(to, "g", unit).replace("column", "channel");
            trials_map(&[ONE, FORCE, &channel, "sign = -1\n"])
        };
        let world = World::with(&format!("{}\n{GRIP}", template_once()));
        let file = world.file("a.csv", "t,f,g\n0,0,1.5\n1,1,-2\n");
        world.refuses(&map("grip_n", "mN"), &file, "'grip_n' is in 'N' in study.toml", None);
        world.refuses(&map("hum", "N"), &file, "'hum' is not a channel of study.toml", None);
        world.refuses(&map("t_s", "N"), &file, "a column of every trial file", None);
        let bad = world.file("b.csv", "t,f,g\n0,0,1.5\n1,1,x\n");
        world.refuses(&map("grip_n", "N"), &bad, "x", Some(("g", 2)));
        world.import(&map("grip_n", "N"), &[file]).unwrap();
        let (p, s) = ("P01".parse().unwrap(), "S01".parse().unwrap());
        let grip = "grip_n".parse().unwrap();
        let path = world.layout.trial(&p, &s, 1);
        let samples = read_channels(&path, std::slice::from_ref(&grip)).unwrap().samples;
        assert_eq!(samples.channel(&grip), Some([-1.5, 2.0].as_slice()));
        world.load();
    }

    #[test]
    fn a_recording_that_the_mapping_calls_simulated_says_so_and_can_be_taken_back() {
        let world = World::new();
        let map = trials_map(&["simulated = true\n", ONE, FORCE]);
        let text = "t,f\n0,1\n1,2\n";
        world.import(&map, &[world.file("a.csv", text)]).unwrap();
        assert_eq!(world.trial("P01", "S01", 1).meta.source, Source::Simulated);
        let data = world.load();
        assert_eq!(data.sessions[0].record.source, Source::Simulated);
        assert!(data.trials.iter().all(|trial| trial.meta.source.is_simulated()));
        let streamed = World::new();
        streamed.import_streamed(&map, &[streamed.file("a.csv", text)]).unwrap();
        assert_eq!(streamed.trial("P01", "S01", 1).meta.source, Source::Simulated);
    }

    const GRIP: &str = "[[channels]]\nid = \"grip_n\"\nunit = \"N\"\ndescription = \"grip\"\n";

    #[test]
    fn an_import_of_another_form_than_the_trials_that_are_there_is_refused() {
        let world = World::new();
        let (map, file) = (trials_map(&[ONE, FORCE]), world.file("a.csv", "t,f\n0,1\n"));
        world.import(&map, &[file]).unwrap();
        let text = std::fs::read_to_string(world.layout.study_toml()).unwrap();
        let world = World::again(world, &format!("{text}\n{GRIP}"));
        let other = world.file("b.csv", "t,f\n0,2\n");
        let errors = world.import(&map.replace("P01", "P02"), &[other]).unwrap_err();
        assert!(errors[0].remedy.contains("keeps the form it began with"), "{errors:?}");
    }

    #[test]
    fn a_rate_makes_the_time_as_the_file_says_and_dropped_rows_leave_a_gap_and_are_counted() {
        let world = World::new();
        let rated = "[time]\nrate_hz = 200.0\n".to_owned() + &column("torque_ex_nm", "tau", "mN·m");
        let file = world.file("a.csv", "tau\n1\n2\n3\n");
        world.import(&trials_map(&[ONE, &rated]), &[file]).unwrap();
        assert_eq!(world.column(1, Signal::Time), [0.0, 0.005, 0.01]);
        let made = world.computed(1);
        assert!(made.contains("t_s = row / 200 Hz"), "{made}");
        let world = World::new();
        let map = trials_map(&["[file]\nmissing = \"drop\"\nrows = 4\n", ONE, &rated]);
        let file = world.file("a.csv", "tau,x\n1,\n,5\n3,\nNaN,\n5,\n");
        let report = world.import(&map, &[file]).unwrap();
        assert_eq!(world.column(1, Signal::Time), [0.0, 0.01]);
        let file = &report.files[0];
        assert_eq!((file.rows_read, file.rows_kept), (5, 2));
        assert_eq!(file.rows_dropped.iter().map(|d| d.rows).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn a_derivative_is_made_only_where_asked_for_and_the_file_says_so() {
        let world = World::new();
        let map = trials_map(&[
            ONE,
            "[time]\nfrom = \"t\"\nunit = \"ms\"\n",
            &column("theta_dot_rad_s", "w", "rad/s"),
            "[[column]]\nto = \"theta_ddot_rad_s2\"\nderive = \"derivative of theta_dot_rad_s\"\n",
            "[[column]]\nto = \"theta_rad\"\nderive = \"integral of theta_dot_rad_s\"\n",
        ]);
        let file = world.file("a.csv", "t,w\n0,0\n500,1\n1000,4\n");
        world.import(&map, &[file]).unwrap();
        close(&world.column(1, Signal::ThetaDdot), &[2.0, 4.0, 6.0]);
        close(&world.column(1, Signal::Theta), &[0.0, 0.25, 1.5]);
        let made = world.computed(1);
        assert!(made.contains("derivative of theta_dot_rad_s (central differences)"), "{made}");
        assert!(made.contains("theta_rad = integral of theta_dot_rad_s"), "{made}");
    }

    #[test]
    fn one_file_may_hold_many_trials_of_many_participants() {
        let world = World::new();
        let csv = "who,mode,n,kind,q,t,f\n\
            P01,active,1,familiarisation,3,0,1\nP01,active,1,familiarisation,3,1,1\n\
            P01,active,2,trial,5,0,2\nP01,active,2,trial,5,1,2\n\
            P02,active,1,trial,1,0,3\nP02,active,1,trial,1,1,3\n";
        let report =
            world.import(&trials_map(&[COLUMNS, FORCE]), &[world.file("a.csv", csv)]).unwrap();
        assert_eq!((report.trials, report.sessions), (3, 2));
        let meta = world.trial("P01", "S01", 2).meta;
        assert_eq!((meta.likert, meta.repeat, meta.kind), (None, 1, Kind::Trial));
        let question = "felt_spring".parse().unwrap();
        let answer = Event::Answer { trial: 2, question, value: 5.into(), time_ms: None };
        assert!(world.events("P01", "S01").contains(&answer));
        assert_eq!(world.trial("P01", "S01", 1).meta.kind, Kind::Familiarisation);
        assert_eq!(world.load().counting().count(), 2, "familiarisation does not count");
    }

    #[test]
    fn an_answer_beside_the_samples_may_lie_on_a_line_and_is_an_event_then() {
        let line = "id = \"felt_spring\"\npoints = 101\nfrom = 0\n";
        let world = World::with(&template_once().replace("id = \"felt_spring\"\n", line));
        let map = format!("{ONE}likert = {{ column = \"q\" }}\n");
        let map = trials_map(&["[file]\ndecimal = \",\"\n", &map, FORCE]);
        let file = world.file("a.csv", "t;f;q\n0;1,5;47,273\n0,5;2;47,273\n");
        world.import(&map, &[file]).unwrap();
        assert_eq!(world.trial("P01", "S01", 1).meta.likert, None);
        let value = |event: &Event| match event {
            Event::Answer { value, .. } => Some(value.get()),
            _ => None,
        };
        let answers: Vec<f64> = world.events("P01", "S01").iter().filter_map(value).collect();
        assert_eq!(answers, [47.273]);
    }
}
