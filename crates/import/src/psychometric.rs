//! Answers to tasks → trials without samples, each the last interval of a presentation, with its answer as an event.

use super::batch::Batch;
use super::context::{Context, Converted, EMPTY};
use super::errors::{Errors, all, append};
use super::given::read_time;
use super::identity::{Identity, identity, number_trials, tell_labels};
use super::judgement::{Judged, Said, judge, right_is_positive};
use super::label::Label;
use super::likert::loss;
use super::limits::{Budget, MOST_NUMBER, MOST_OF_SESSION};
use super::mapping::{EachFrom, Missing, SaidFrom, TaskFrom, Who};
use super::once;
use super::presented::{Presentation, existing, place};
use super::recording::Recording;
use super::report::{FileReport, RowsDropped};
use super::spelling::{find, is_missing, plain, truth};
use super::table::Cell;
use super::unit::factor_of_level;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use zwidth_store::StoreError;
use zwidth_study::{AnswerValue, Asks, Event, QuestionId, Task, TaskLevel};

/// The presentations of a file.
struct Read {
    presentations: Vec<Presentation>,
    report: FileReport,
    /// The columns of its answers, counted from 1.
    columns: BTreeSet<usize>,
}

/// Reads every file, numbers the presentations over all of them, and turns the answers into events.
pub(super) fn psychometric(
    context: &Context,
    from: &TaskFrom,
    files: &[PathBuf],
) -> Result<Batch, Errors> {
    if context.study.tasks.is_empty() {
        let what = "study.toml has no tasks";
        let remedy = "say under [[tasks]] what was asked, what varied and what the standard was";
        return Err(StoreError::new(&context.mapping.path, what, remedy).into());
    }
    let budget = Budget::default();
    let take = context.take(from.columns(), &budget);
    let converted =
        context.convert(files, &take, |recording| convert(context, from, &budget, recording))?;
    let rows = converted.iter().flat_map(|file| &file.parsed.presentations);
    let existing = existing(context, rows)?;
    let is_new = |row: &Presentation| {
        !existing.contains(&(row.identity.participant.clone(), row.identity.session.clone()))
    };
    let rows: Vec<(&Converted<Read>, &Presentation)> = converted
        .iter()
        .flat_map(|file| file.parsed.presentations.iter().map(move |row| (file, row)))
        .collect();
    let identities: Vec<Identity> = rows.iter().map(|(_, row)| row.identity.clone()).collect();
    let mut batch = Batch::default();
    batch.files.extend(converted.iter().map(|file| file_report(file, &identities, &is_new)));
    let mut new = rows;
    new.retain(|(_, row)| is_new(row));
    check_sessions(&new)?;
    let identities: Vec<Identity> = new.iter().map(|(_, row)| row.identity.clone()).collect();
    let mut planned = number_trials(context, &identities, false)?;
    once::answers(context, new.iter().map(|(file, _)| *file), |read: &Read| &read.columns)?;
    let presentations: Vec<&Presentation> = new.iter().map(|(_, row)| *row).collect();
    place(context, &presentations, &mut planned)?;
    let events = new.iter().zip(&planned).map(|((_, row), number)| {
        vec![Event::Answer {
            trial: number.trial,
            question: row.task.clone(),
            value: row.value,
            time_ms: row.time_ms,
        }]
    });
    let mut events: Vec<Vec<Event>> = events.collect();
    // The first presentation of a session in a table says in its log what of the table could not be read.
    let mut noted = BTreeSet::new();
    for ((file, row), events) in new.iter().zip(&mut events) {
        let is_first = noted.insert((&file.path, &row.identity.participant, &row.identity.session));
        let lost = file.parsed.report.lost.as_deref().filter(|_| is_first);
        events.extend(lost.map(loss));
    }
    let sources: Vec<&str> = new.iter().map(|(file, _)| file.blake3.as_str()).collect();
    let columns = new.iter().flat_map(|(file, _)| &file.parsed.columns);
    batch.answer_columns = columns.copied().collect::<BTreeSet<usize>>().into_iter().collect();
    batch.add_sessions(context, &identities, &planned, events, &sources)?;
    Ok(batch)
}

/// Checks that no session has more answers than its record can hold.
fn check_sessions(rows: &[(&Converted<Read>, &Presentation)]) -> Result<(), Errors> {
    let mut counts: BTreeMap<_, usize> = BTreeMap::new();
    for (file, row) in rows {
        let Identity { participant, session, .. } = &row.identity;
        let n = counts.entry((participant, session)).or_default();
        *n += 1;
        if *n > MOST_OF_SESSION {
            let what = format!(
                "session {session} of {participant} has more than {MOST_OF_SESSION} answers, and no more are read of one"
            );
            let remedy = "name several sessions in [trial]";
            return Err(StoreError::new(&file.path, what, remedy).into());
        }
    }
    Ok(())
}

/// The report on a file: how many answers it has, and which sessions are there already.
fn file_report(
    file: &Converted<Read>,
    all: &[Identity],
    is_new: &dyn Fn(&Presentation) -> bool,
) -> FileReport {
    let Read { presentations, report, .. } = &file.parsed;
    let new = presentations.iter().filter(|row| is_new(row)).count();
    let there = presentations.iter().filter(|row| !is_new(row));
    let there: BTreeSet<String> =
        there.map(|row| format!("{} {}", row.identity.participant, row.identity.session)).collect();
    let there = there.into_iter().collect::<Vec<_>>().join(", ");
    if new == 0 && !there.is_empty() {
        return FileReport::there_already(&file.path, &there);
    }
    let mut report = report.clone();
    tell_labels(&mut report, presentations.iter().map(|row| &row.identity), all);
    let mut tasks: BTreeMap<&QuestionId, usize> = BTreeMap::new();
    for row in presentations.iter().filter(|row| is_new(row)) {
        *tasks.entry(&row.task).or_default() += 1;
    }
    let tasks = tasks.iter().map(|(task, n)| format!("{n} answers to {task}"));
    report.made.push(format!(
        "{new} presentations without samples: {}",
        tasks.collect::<Vec<_>>().join(", ")
    ));
    if !there.is_empty() {
        report.told.push(format!("in the study already, and left out: {there}"));
    }
    report
}

/// What the rows of a file have in common that is of the task.
pub(super) struct OfTask<'a> {
    task: &'a Task,
    /// The labels, with the environment of the task.
    who: Who,
    /// What a level is multiplied with.
    factor: f64,
}

/// What was passed over or taken for granted, by the number of rows.
#[derive(Default)]
pub(super) struct Noticed {
    unanswered: usize,
    taken: usize,
    unjudged: usize,
    rounded: usize,
}

fn convert(
    context: &Context,
    from: &TaskFrom,
    budget: &Budget,
    recording: &Recording,
) -> Result<Read, Errors> {
    let labels = all(from.labels().into_iter().map(|column| recording.find(column)))?;
    let level = recording.find(&from.level)?;
    let used = all(from.columns().into_iter().map(|column| recording.find(column)))?;
    let used: Vec<usize> = used.into_iter().collect::<BTreeSet<usize>>().into_iter().collect();
    let mut rows = recording.rows(&context.mapping.file, &[], &labels)?;
    let headers = recording.leave_out_headers(&mut rows, &used);
    let others = leave_out_others(recording, from, &mut rows.kept)?;
    let drops = context.mapping.file.cells.missing == Missing::Drop;
    let before = rows.kept.len();
    if drops {
        rows.kept.retain(|row| recording.number(level, *row) != Ok(None));
    }
    rows.missing += before - rows.kept.len();
    // Counted before anything is made of them.
    budget.answers(&recording.path, answers_in(from, recording, &rows.kept)?)?;
    let mut tasks: BTreeMap<QuestionId, OfTask> = BTreeMap::new();
    let mut noticed = Noticed::default();
    let mut presentations = Vec::new();
    let mut errors = Errors::default();
    for row in &rows.kept {
        let read = read_row(context, from, &mut tasks, recording, *row, &mut noticed);
        match read {
            Ok(read) => presentations.extend(read),
            Err(wrong) => append(&mut errors, wrong),
        }
    }
    errors.none()?;
    if presentations.is_empty() {
        let what = "no row has an answer to a task";
        return Err(recording.error(what, "leave the file out, or check [task]").into());
    }
    let kept = rows.kept.len() - noticed.unanswered;
    let mut report = context.file_report(recording, &rows, kept, &used)?;
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, EMPTY);
    report.add_headers(headers);
    for (n, why) in [
        (others, "they are not those that `when` names"),
        (noticed.unanswered, "without an answer"),
    ] {
        if n > 0 {
            report.rows_dropped.push(RowsDropped { rows: n, why: why.to_owned() });
        }
    }
    for OfTask { task, .. } in tasks.values() {
        let line = from.line.words().map(|words| format!(", as {words}")).unwrap_or_default();
        report.converted.push(format!(
            "levels of {} from {} in {}{line} to {}",
            task.id,
            recording.table.name(level),
            from.unit,
            task.varies
        ));
    }
    let said = from.said.columns();
    let said = said.iter().map(|(what, column)| format!("{what} ({column})"));
    report.converted.push(format!("answers, from {}", said.collect::<Vec<_>>().join(", ")));
    noticed.tell(&mut report, presentations.len());
    if matches!(from.said, SaidFrom::Counts { .. }) {
        report.told.push(
            "counts do not say in which order answers came: of each row the positive ones come first"
                .to_owned(),
        );
    }
    let columns = from.said.columns().into_iter().map(|(_, column)| recording.find(column));
    let columns = all(columns)?.into_iter().map(|place| place + 1).collect();
    Ok(Read { presentations, report, columns })
}

/// The number of answers that rows have at most.
fn answers_in(from: &TaskFrom, recording: &Recording, rows: &[usize]) -> Result<usize, StoreError> {
    let SaidFrom::Counts { presentations, .. } = &from.said else { return Ok(rows.len()) };
    let place = recording.find(presentations)?;
    // What is no count is an error further on.
    let counts = rows.iter().filter_map(|row| recording.number(place, *row).ok()?);
    Ok(counts.map(|n| n as usize).fold(0, usize::saturating_add))
}

impl Noticed {
    pub(super) fn tell(&self, report: &mut FileReport, all: usize) {
        let Self { taken, unjudged, rounded, .. } = *self;
        if taken > 0 {
            report.told.push(format!(
                "{taken} of {all} presentations do not say which interval held the standard: it is taken for the first, \
                 and the answers say of the level what they said"
            ));
        }
        if unjudged > 0 {
            report.told.push(format!(
                "at the standard nothing is right or wrong: of {unjudged} presentations `correct` is not read"
            ));
        }
        if rounded > 0 {
            report
                .told
                .push(format!("{rounded} levels have more than six decimals, and are rounded"));
        }
    }
}

/// Leaves out rows that are not those that the mapping names; how many.
fn leave_out_others(
    recording: &Recording,
    from: &TaskFrom,
    rows: &mut Vec<usize>,
) -> Result<usize, Errors> {
    let before = rows.len();
    for (column, words) in &from.when {
        let place = recording.find(column)?;
        rows.retain(|row| {
            let cell = recording.table.columns[place].cell(*row).to_string();
            words.iter().any(|word| plain(word) == plain(cell.trim()))
        });
    }
    Ok(before - rows.len())
}

/// The presentations of a row; none where the answer is missing and such rows are left out.
pub(super) fn read_row<'a>(
    context: &'a Context,
    from: &TaskFrom,
    tasks: &mut BTreeMap<QuestionId, OfTask<'a>>,
    recording: &Recording,
    row: usize,
    noticed: &mut Noticed,
) -> Result<Vec<Presentation>, Errors> {
    let id = from.id.value("task", recording, row, |text| task_id(context, text))?;
    if !tasks.contains_key(&id) {
        tasks.insert(id.clone(), of_task(context, from, recording, &id)?);
    }
    let OfTask { task, who, factor } = &tasks[&id];
    let identity = identity(who, recording, row, context.study)?;
    let level = read_level(from, *factor, recording, row, noticed)?;
    let track = from.track.as_ref();
    let track = track.map(|label| label.value("track", recording, row, |text| Ok(text.to_owned())));
    let track = track.transpose()?;
    let time_ms = match &from.time {
        Some(time) => read_time(from.time_unit, recording, recording.find(time)?, row)?,
        None => None,
    };
    let presentation = |judged: Judged| Presentation {
        identity: identity.clone(),
        task: id.clone(),
        level,
        is_set: task.asks == Asks::Set && judged.value == 3,
        value: AnswerValue::from(judged.value),
        is_standard: judged.is_standard,
        time_ms,
        track: track.clone(),
    };
    let wrong = |what: &str| {
        let remedy = "mend the row, or what [task] says of its columns";
        recording.row_error(row, &format!("the level {}: {what}", level.value()), remedy)
    };
    match &from.said {
        SaidFrom::Each(each) => {
            let Some(said) = read_said(each, task, recording, row)? else {
                noticed.unanswered += 1;
                return Ok(Vec::new());
            };
            let judged = judge(task, level, said).map_err(|what| wrong(&what))?;
            noticed.taken += usize::from(judged.is_taken);
            noticed.unjudged += usize::from(judged.is_unjudged);
            Ok(vec![presentation(judged)])
        }
        SaidFrom::Counts { .. } => {
            let [positive, all] = read_counts(from, task, level, recording, row, &wrong)?;
            let mut made = Vec::new();
            for (is_positive, n) in [(true, positive), (false, all - positive)] {
                let said = Said { positive: Some(is_positive), ..Said::default() };
                if n > 0 {
                    let judged = judge(task, level, said).map_err(|what| wrong(&what))?;
                    noticed.taken += if judged.is_taken { n } else { 0 };
                    made.extend(std::iter::repeat_n(presentation(judged), n));
                }
            }
            Ok(made)
        }
    }
}

fn task_id(context: &Context, text: &str) -> Result<QuestionId, String> {
    let id: QuestionId = super::identity::id(text)?;
    if context.study.task(&id).is_some() {
        return Ok(id);
    }
    let tasks: Vec<&str> = context.study.tasks.iter().map(|task| task.id.as_str()).collect();
    Err(format!("'{id}' is no task of study.toml, which has {}", tasks.join(", ")))
}

/// What all rows of a task share.
fn of_task<'a>(
    context: &'a Context,
    from: &TaskFrom,
    recording: &Recording,
    id: &QuestionId,
) -> Result<OfTask<'a>, StoreError> {
    let task = context.study.task(id).ok_or_else(|| {
        let what = format!("'{id}' is no task of study.toml");
        recording.error(what, "name it in [task]")
    })?;
    let factor = factor_of_level(&from.unit, &task.varies).ok_or_else(|| {
        let what =
            format!("'{}' does not become the unit in which {} ends", from.unit, task.varies);
        let remedy =
            "name a unit of the same quantity in [task], and change numbers with scale and offset";
        StoreError::new(&context.mapping.path, what, remedy)
    })?;
    let environment = Label::fixed(task.environment.as_str());
    Ok(OfTask { task, who: Who { environment, ..from.who.clone() }, factor })
}

fn read_level(
    from: &TaskFrom,
    factor: f64,
    recording: &Recording,
    row: usize,
    noticed: &mut Noticed,
) -> Result<TaskLevel, StoreError> {
    let column = recording.find(&from.level)?;
    let mut value = recording.numbers(column, &[row])?;
    from.line.apply(&mut value, factor, 0.0);
    let level = TaskLevel::nearest(value[0]).ok_or_else(|| {
        let what = format!("the level {} is beyond ±1e9", value[0]);
        recording.cell_error(column, row, &what, "check unit, scale and offset in [task]")
    })?;
    // A conversion of units leaves less.
    const ROUNDING: f64 = 1e-9;
    let off = (level.value() - value[0]).abs();
    noticed.rounded += usize::from(off > ROUNDING * level.value().abs().max(1.0));
    Ok(level)
}

/// What a row says of its answer; `None` where a column of it is empty and such rows are left out.
fn read_said(
    each: &EachFrom,
    task: &Task,
    recording: &Recording,
    row: usize,
) -> Result<Option<Said>, StoreError> {
    let EachFrom { answer, positive, correct, standard, comparison } = each;
    for label in [answer, positive, correct].into_iter().flatten() {
        if let Some(column) = is_unanswered(recording, label, row)? {
            if recording.form_of(column).missing == Missing::Drop {
                return Ok(None);
            }
            let what = "nothing was answered";
            let remedy = "leave such rows out with missing = \"drop\" in [file], or say in translate what it means";
            return Err(recording.cell_error(column, row, what, remedy));
        }
    }
    let value = |what: &str, label: &Option<Label>, parse: &dyn Fn(&str) -> Result<i16, String>| {
        let label = label.as_ref();
        label.map(|label| label.value(what, recording, row, parse)).transpose()
    };
    let standard = value("standard", standard, &interval)?;
    let is =
        |what: &str, label| Ok::<_, StoreError>(value(what, label, &truth_of)?.map(|n| n == 1));
    Ok(Some(Said {
        answer: value("answer", answer, &|text| answer_of(task.asks, text))?,
        comparison: value("comparison", comparison, &interval)?.or(standard.map(|n| 3 - n)),
        positive: is("positive", positive)?,
        correct: is("correct", correct)?,
    }))
}

/// The column of a label in which nothing stands, or what other programs write there if nothing was pressed.
fn is_unanswered(
    recording: &Recording,
    label: &Label,
    row: usize,
) -> Result<Option<usize>, StoreError> {
    let Some(column) = label.column() else { return Ok(None) };
    let place = recording.find(column)?;
    let cell = recording.table.columns[place].cell(row);
    let is_word = find(&label.translate, &cell.to_string()).is_some();
    let is_empty = match &cell {
        Cell::Text(text) => is_missing(text) || recording.is_without_label(place, row),
        Cell::Number(number) => number.is_nan() || recording.is_without_label(place, row),
        Cell::Empty => true,
    };
    Ok((is_empty && !is_word).then_some(place))
}

/// The place of an answer among those that can be given: its number, or its words.
fn answer_of(asks: Asks, text: &str) -> Result<i16, String> {
    let small = text.trim().to_lowercase();
    let words = asks.answers();
    let same = |word: &&str| *word == small || word.strip_prefix("the ") == Some(&small);
    let place = words.iter().position(same).map(|place| place + 1);
    let number = plain(&small).parse::<usize>().ok();
    let place = place.or(number).filter(|place| (1..=words.len()).contains(place));
    place.and_then(|place| i16::try_from(place).ok()).ok_or_else(|| {
        let listed = words.iter().enumerate().map(|(i, word)| format!("{} ({word})", i + 1));
        let listed = listed.collect::<Vec<_>>().join(" or ");
        format!(
            "the answer '{text}' must be {listed}; other words are turned into these by translate"
        )
    })
}

/// An interval: 1 or 2.
fn interval(text: &str) -> Result<i16, String> {
    match plain(text.trim()).to_lowercase().as_str() {
        "1" | "first" | "the first" => Ok(1),
        "2" | "second" | "the second" => Ok(2),
        _ => Err(format!(
            "the interval '{text}' must be 1 or 2; other words are turned into these by translate"
        )),
    }
}

/// A truth value: 1 or 0.
fn truth_of(text: &str) -> Result<i16, String> {
    match plain(text.trim()).as_ref() {
        "1" => Ok(1),
        "0" => Ok(0),
        text => truth(text).map(i16::from).ok_or_else(|| {
            format!(
                "'{text}' must be 1 or 0, or true or false; other words are turned into these by translate"
            )
        }),
    }
}

/// How many answers were positive, and how many there were.
fn read_counts(
    from: &TaskFrom,
    task: &Task,
    level: TaskLevel,
    recording: &Recording,
    row: usize,
    wrong: &dyn Fn(&str) -> StoreError,
) -> Result<[usize; 2], Errors> {
    let SaidFrom::Counts { presentations, positive, correct } = &from.said else {
        return Ok([0; 2]);
    };
    let count = |column| -> Result<usize, StoreError> {
        let place = recording.find(column)?;
        let number = recording.numbers(place, &[row])?[0];
        let most = f64::from(MOST_NUMBER);
        if number.fract() == 0.0 && (0.0..=most).contains(&number) {
            return Ok(number as usize);
        }
        let what = format!("{number} must be a count: a whole number from 0 to {most}");
        Err(recording.cell_error(place, row, &what, "mend the cell"))
    };
    let all = count(presentations)?;
    if all > MOST_OF_SESSION {
        let what = format!(
            "{all} presentations are more than the {MOST_OF_SESSION} that are read of a session"
        );
        let place = recording.find(presentations)?;
        return Err(recording.cell_error(place, row, &what, "check the column").into());
    }
    let mut found = None;
    for (column, is_correct) in [(positive, false), (correct, true)] {
        let Some(column) = column else { continue };
        let n = count(column)?;
        if n > all {
            let what = format!("{n} answers were so, of {all} presentations");
            let place = recording.find(column)?;
            return Err(recording.cell_error(place, row, &what, "mend the counts").into());
        }
        let is_turned =
            is_correct && !right_is_positive(task, level).map_err(|what| wrong(&what))?;
        let positive = if is_turned { all - n } else { n };
        if found.is_some_and(|other| other != positive) {
            let what = "'positive' and 'correct' do not count the same answers";
            return Err(wrong(what).into());
        }
        found = Some(positive);
    }
    Ok([found.unwrap_or_default(), all])
}

#[cfg(test)]
mod tests {
    use super::super::world::{World, template_once};
    use zwidth_store::TaskAnswer;
    use zwidth_study::PlannedTrial;

    /// The template in schema 3, whose spring asks nothing, with tasks of these ids and kinds, each about its stiffness.
    fn world(tasks: &[(&str, &str)]) -> World {
        let text = template_once().replacen("schema = 2", "schema = 3", 1).replacen(
            "question = \"felt_spring\"\n",
            "",
            1,
        );
        let tasks = tasks.iter().map(|(id, asks)| {
            let method = match *asks {
                "set" => "method = \"adjustment\"\nstarts = [2.0, 6.0]\nstep = 0.2\nlowest = 1.0\nhighest = 7.0\nsettings = 6",
                "2afc" => "method = \"constant\"\nlevels = [4.4, 4.8, 5.2]\ntrials = 20",
                "yes_no" => "method = \"constant\"\nlevels = [4.0, 4.4, 4.8]\ntrials = 20",
                _ => "method = \"constant\"\nlevels = [2.8, 3.2, 3.6, 4.4, 4.8, 5.2]\ntrials = 20",
            };
            format!(
                "\n[[tasks]]\nid = \"{id}\"\ntext = \"What was it?\"\nasks = \"{asks}\"\nenvironment = \"spring\"\n\
                 varies = \"stiffness_n_per_rad\"\nstandard = 4.0\n{method}\n"
            )
        });
        World::with(&(text + &tasks.collect::<String>()))
    }

    fn map(task: &str) -> String {
        format!(
            "kind = \"psychometric\"\n[trial]\nparticipant = {{ column = \"who\" }}\nsession = \"S01\"\n\
             mode = {{ column = \"mode\" }}\n[task]\nid = \"stiffer\"\nlevel = \"k\"\nunit = \"N/rad\"\n{task}"
        )
    }

    /// What a study has of its answers: mode, presentation, level, and whether it was positive.
    fn told(answers: &[TaskAnswer]) -> Vec<String> {
        let told = answers.iter().map(|a| {
            let sign = if a.is_positive { '+' } else { '-' };
            format!("{} {} {} {sign}", a.condition.mode, a.presentation, a.level.value())
        });
        told.collect()
    }

    const INTERVALS: &str = "answer = { column = \"key\", translate = { left = \"1\", right = \"2\" } }\n\
                             comparison = { column = \"side\" }\n";

    #[test]
    fn every_answer_becomes_a_presentation_that_is_read_as_it_was_meant() {
        let world = world(&[("stiffer", "2ifc")]);
        let table = "who,mode,k,key,side,rt,corr\nP01,active,4.4,left,1,0.52,1\nP01,active,3.6,left,1,0.61,0\n\
                     P01,passive,4.4,right,1,0.7,0\nP02,active,2.8,right,1.0,0.8,1\n";
        let map = map(&format!(
            "{INTERVALS}correct = {{ column = \"corr\" }}\ntime = \"rt\"\ntime_unit = \"s\"\n"
        ));
        let report = world.import(&map, &[world.file("a.csv", table)]).unwrap();
        assert_eq!((report.trials, report.sessions, report.answers), (0, 2, 4));
        let answers = world.load().task_answers();
        let expect = ["active 1 4.4 +", "active 2 3.6 +", "passive 1 4.4 -", "active 1 2.8 -"];
        assert_eq!(told(&answers), expect);
        assert_eq!(answers[1].time_ms, Some(610));
        let trials = &world.load().sessions[0].record.trials;
        let place = |trial: &PlannedTrial| {
            let task = trial.task.clone().unwrap();
            (trial.samples, task.interval, task.is_standard)
        };
        assert_eq!(place(&trials[0]), (false, 2, Some(true)));
    }

    #[test]
    fn a_judgement_alone_is_enough_and_the_report_says_what_is_taken_for_granted() {
        let world = world(&[("stiffer", "2ifc")]);
        let table =
            "who,mode,k,corr\nP01,active,4.4,True\nP01,active,3.6,True\nP01,active,3.6,False\n";
        let map = map("correct = { column = \"corr\" }\n");
        let report = world.import(&map, &[world.file("a.csv", table)]).unwrap();
        let words = "3 of 3 presentations do not say which interval held the standard";
        assert!(report.to_string().contains(words), "{report}");
        let expect = ["active 1 4.4 +", "active 2 3.6 -", "active 3 3.6 +"];
        assert_eq!(told(&world.load().task_answers()), expect);
    }

    #[test]
    fn of_two_alternatives_a_right_answer_is_positive_at_any_level() {
        let world = world(&[("stiffer", "2afc")]);
        let table = "who,mode,k,corr\nP01,active,4.4,1\nP01,active,3.6,1\nP01,active,4,0\n";
        let map = map("correct = { column = \"corr\" }\n");
        world.import(&map, &[world.file("a.csv", table)]).unwrap();
        let expect = ["active 1 4.4 +", "active 2 3.6 +", "active 3 4 -"];
        assert_eq!(told(&world.load().task_answers()), expect);
    }

    #[test]
    fn counts_become_as_many_answers() {
        let world = world(&[("stiffer", "more_less")]);
        let map = map("presentations = \"n\"\npositive = { column = \"more\" }\n");
        let table =
            "who,mode,k,n,more\nP01,active,3.6,5,1\nP01,active,4.4,4,4\nP01,passive,4,0,0\n";
        let report = world.import(&map, &[world.file("a.csv", table)]).unwrap();
        assert_eq!(report.answers, 9);
        assert!(report.to_string().contains("in which order answers came"), "{report}");
        let positive = |answers: &[TaskAnswer]| answers.iter().filter(|a| a.is_positive).count();
        let answers = world.load().task_answers();
        assert_eq!((answers.len(), positive(&answers)), (9, 5));
        assert_eq!(answers[8].presentation, 9);
        for (row, words, at) in [
            ("3.6,5,6", "6 answers were so, of 5 presentations (line 2)", "more"),
            ("3.6,5,0.5", "0.5 must be a count", "more"),
            ("3.6,-1,0", "-1 must be a count", "n"),
        ] {
            let text = format!("who,mode,k,n,more\nP03,active,{row}\n");
            world.refuses(&map, &world.file("b.csv", text), words, Some((at, 1)));
        }
        let many = "who,mode,k,n,more\nP03,active,3.6,30000,6\nP03,active,4.4,30000,6\n";
        world.refuses(&map, &world.file("c.csv", many), "has more than 50000 answers", None);
        let many = "who,mode,k,n,more\nP03,active,3.6,60000,6\n";
        let words = "60000 presentations are more than the 50000";
        world.refuses(&map, &world.file("c.csv", many), words, Some(("n", 1)));
        let most = "who,mode,k,n,more\nP03,active,3.6,1000000,6\nP04,active,3.6,1,0\n";
        world.refuses(&map, &world.file("d.csv", most), "more than 1000000 answers to tasks", None);
    }

    #[test]
    fn right_answers_that_are_counted_mean_less_below_the_standard() {
        let world = world(&[("stiffer", "2ifc")]);
        let map = map("presentations = \"n\"\ncorrect = { column = \"right\" }\n");
        let table = "who,mode,k,n,right\nP01,active,3.6,5,4\nP01,active,4.4,5,3\n";
        world.import(&map, &[world.file("a.csv", table)]).unwrap();
        let answers = world.load().task_answers();
        let positive = |level: f64| {
            let is = |a: &&TaskAnswer| a.is_positive && (a.level.value() - level).abs() < 1e-9;
            answers.iter().filter(is).count()
        };
        assert_eq!((positive(3.6), positive(4.4)), (1, 3));
        let table = "who,mode,k,n,right\nP02,active,4,5,4\n";
        let words = "the level 4 is the standard of 'stiffer'";
        world.refuses(&map, &world.file("b.csv", table), words, None);
    }

    #[test]
    fn wrong_rows_are_told_with_their_column_and_row() {
        let world = world(&[("stiffer", "2ifc")]);
        let map = map(&format!("{INTERVALS}correct = {{ column = \"corr\" }}\n"));
        for (row, words, at) in [
            (
                "4.4,left,1,0",
                "'answer' means that there was more in the interval with the level",
                None,
            ),
            ("soft,left,1,1", "'soft' is not a number (line 2)", Some(("k", 1))),
            (
                "4.4,up,1,1",
                "'up' is not in the translation table, which has left, right",
                Some(("key", 1)),
            ),
            ("4.4,left,3,1", "the interval '3' must be 1 or 2", Some(("side", 1))),
            ("4.4,left,1,maybe", "'maybe' must be 1 or 0", Some(("corr", 1))),
            ("4.4,None,1,0", "nothing was answered (line 2)", Some(("key", 1))),
            ("1e12,left,1,1", "is beyond", Some(("k", 1))),
        ] {
            let text = format!("who,mode,k,key,side,corr\nP01,active,{row}\n");
            world.refuses(&map, &world.file("a.csv", text), words, at);
        }
        let third = "who,mode,k,key,side,corr\nP01,active,4.4,3,1,1\n";
        let plain = map.replace(", translate = { left = \"1\", right = \"2\" }", "");
        let words = "the answer '3' must be 1 (the first) or 2 (the second)";
        world.refuses(&plain, &world.file("a.csv", third), words, Some(("key", 1)));
        let metres = map.replace("N/rad", "N/m");
        let words = "'N/m' does not become the unit in which stiffness_n_per_rad ends";
        world.refuses(&metres, &world.file("a.csv", third), words, None);
        let other = map.replace("\"stiffer\"", "\"softer\"");
        let words = "'softer' is no task of study.toml, which has stiffer";
        world.refuses(&other, &world.file("a.csv", third), words, None);
        let none = World::new();
        none.refuses(&map, &none.file("a.csv", third), "study.toml has no tasks", None);
    }

    /// As PsychoPy writes it: a row a screen, a column a component, a comma at the end of each line, `None` for no key,
    /// which its own judgement calls wrong.
    #[test]
    fn a_table_of_psychopy_is_read_without_the_rows_of_its_other_screens() {
        let world = world(&[("stiffer", "2afc")]);
        let head = "comparison,trials.thisN,key_resp.keys,key_resp.corr,key_resp.rt,participant,mode,welcome.started,\n";
        let row = |n: usize| {
            let key = ["f", "j"][n % 2];
            format!(
                "{},{n},{key},{},{},P01,active,,\n",
                4.0 + 0.4 * n as f64,
                n % 3 % 2,
                0.5 + 0.1 * n as f64
            )
        };
        let rows: String = (0..6).map(row).collect();
        let table = format!("{head},,,,,P01,active,0.013,\n{rows}6.4,6,None,0,,P01,active,,\n");
        let map = "kind = \"psychometric\"\n[file]\nmissing = \"drop\"\n[trial]\n\
                   participant = { column = \"participant\" }\nsession = \"S01\"\nmode = { column = \"mode\" }\n\
                   trial = { column = \"trials.thisN\" }\n[task]\nid = \"stiffer\"\nlevel = \"comparison\"\n\
                   unit = \"N/rad\"\nanswer = { column = \"key_resp.keys\", translate = { f = \"1\", j = \"2\" } }\n\
                   correct = { column = \"key_resp.corr\" }\ntime = \"key_resp.rt\"\ntime_unit = \"s\"\n";
        let report = world.import(map, &[world.file("a.csv", table)]).unwrap();
        assert_eq!(report.answers, 6);
        let dropped: Vec<(usize, &str)> =
            report.files[0].rows_dropped.iter().map(|d| (d.rows, d.why.as_str())).collect();
        assert_eq!(dropped[1], (1, "without an answer"), "{report}");
        let answers = world.load().task_answers();
        let positive: Vec<bool> = answers.iter().map(|a| a.is_positive).collect();
        assert_eq!(positive, [false, true, false, false, true, false]);
        assert_eq!(answers[5].time_ms, Some(1000));
        assert_eq!(answers[1].value, 2.into());
    }

    /// As jsPsych writes it: a row a screen, `response` is what was pressed or a button's number from 0.
    #[test]
    fn lines_of_jspsych_are_read_where_their_screen_is_the_task() {
        let world = world(&[("there", "yes_no"), ("stiffer", "2ifc")]);
        let line = |screen: &str, k: f64, response: &str, correct: bool| {
            format!(
                "{{\"trial_type\":\"html-button-response\",\"screen\":\"{screen}\",\"who\":\"P01\",\"mode\":\"hybrid\",\
                 \"k\":{k},\"response\":{response},\"correct\":{correct},\"rt\":512.4}}\n"
            )
        };
        let text = [
            line("hello", 0.0, "0", false),
            line("there", 4.4, "0", true),
            line("there", 4.0, "0", false),
            line("there", 4.0, "1", true),
        ]
        .concat();
        let map = map(
            "answer = { column = \"response\", translate = { \"0\" = \"yes\", \"1\" = \"no\" } }\n\
             correct = { column = \"correct\" }\ntime = \"rt\"\ntime_unit = \"ms\"\nwhen = { screen = [\"there\"] }\n",
        )
        .replace("id = \"stiffer\"", "id = { column = \"screen\" }");
        let report = world.import(&map, &[world.file("a.jsonl", text)]).unwrap();
        assert!(
            report.to_string().contains("1 row: they are not those that `when` names"),
            "{report}"
        );
        let answers = world.load().task_answers();
        assert_eq!(told(&answers), ["hybrid 1 4.4 +", "hybrid 2 4 +", "hybrid 3 4 -"]);
        assert_eq!(answers[0].time_ms, Some(512));
        let wrong = world.file("b.jsonl", line("there", 4.4, "1", true).replace("P01", "P02"));
        world.refuses(&map, &wrong, "'answer' means no, and 'correct' means yes", None);
    }

    #[test]
    fn settings_and_staircases_keep_their_sequences() {
        let world = world(&[("like", "set"), ("stiffer", "2afc")]);
        let set = map("").replace("\"stiffer\"", "\"like\"");
        let table = "who,mode,k\nP01,active,3.9\nP01,active,4.3\nP01,passive,4.1\n";
        world.import(&set, &[world.file("a.csv", table)]).unwrap();
        let tracks = || {
            let answers = world.load().task_answers();
            answers.iter().map(|a| (a.participant.to_string(), a.track)).collect::<Vec<_>>()
        };
        let own = |tracks: Vec<(String, u8)>, who: &str| -> Vec<u8> {
            tracks.into_iter().filter(|(own, _)| own == who).map(|(_, track)| track).collect()
        };
        assert_eq!(own(tracks(), "P01"), [0, 1, 0]);
        let stairs = map("correct = { column = \"corr\" }\ntrack = { column = \"stair\" }\n");
        let table = "who,mode,k,corr,stair\nP02,active,5,1,high\nP02,active,3,0,low\nP02,active,4.8,1,high\n";
        world.import(&stairs, &[world.file("b.csv", table)]).unwrap();
        assert_eq!(own(tracks(), "P02"), [0, 1, 0]);
    }

    #[test]
    fn units_become_those_of_what_varies_and_lines_are_told() {
        let world = world(&[("stiffer", "more_less")]);
        let map = map("positive = { column = \"more\" }\noffset = 4.0\nscale = 0.04\n");
        // Percent more than the standard.
        let table = "who,mode,k,more\nP01,active,10,1\nP01,active,-10,0\n";
        let report = world.import(&map, &[world.file("a.csv", table)]).unwrap();
        assert!(report.to_string().contains("as (0.04 x + 4) to stiffness_n_per_rad"), "{report}");
        assert_eq!(told(&world.load().task_answers()), ["active 1 4.4 +", "active 2 3.6 -"]);
        let degrees = map.replace("offset = 4.0\nscale = 0.04\n", "").replace("N/rad", "N/deg");
        let k = 4.4 * std::f64::consts::PI / 180.0;
        let table = format!("who,mode,k,more\nP02,active,{k},1\n");
        world.import(&degrees, &[world.file("b.csv", table)]).unwrap();
        assert_eq!(told(&world.load().task_answers())[2..], ["active 1 4.4 +"]);
    }

    #[test]
    fn the_same_table_again_adds_its_new_people_and_no_answer_twice() {
        let world = world(&[("stiffer", "2afc")]);
        let map = map("correct = { column = \"corr\" }\n");
        let table = "who,mode,k,corr\nP01,active,4.4,1\nP01,active,4.8,0\n";
        world.import(&map, &[world.file("a.csv", table)]).unwrap();
        let grown = world.file("a.csv", format!("{table}P02,active,4.4,1\n"));
        let report = world.import(&map, std::slice::from_ref(&grown)).unwrap();
        assert!(report.to_string().contains("left out: P01 S01"), "{report}");
        assert_eq!((report.sessions, world.load().task_answers().len()), (1, 3));
        let report = world.import(&map, &[grown]).unwrap().to_string();
        assert!(report.contains("in the study already, as P01 S01, P02 S01"), "{report}");
        let other = world.file("b.csv", table.replace("4.8,0", "4.8,1"));
        world.refuses(&map, &other, "session S01 of P01 is there, with other answers", None);
        let copy = map.replace("\"S01\"", "\"S02\"");
        let file = world.file("a.csv", format!("{table}P02,active,4.4,1\n"));
        world.refuses(&copy, &file, "was imported before, as P02 S01", None);
    }

    #[test]
    fn practice_is_kept_and_does_not_count() {
        let world = world(&[("stiffer", "2afc")]);
        let map = map("correct = { column = \"corr\" }\n").replace(
            "[task]",
            "kind = { column = \"block\", translate = { practice = \"familiarisation\", main = \"trial\" } }\n[task]",
        );
        let table = "who,mode,k,corr,block\nP01,active,4.4,1,practice\nP01,active,4.8,0,main\n";
        world.import(&map, &[world.file("a.csv", table)]).unwrap();
        assert_eq!(told(&world.load().task_answers()), ["active 1 4.8 -"]);
    }
}
