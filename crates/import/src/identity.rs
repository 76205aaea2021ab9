//! Who, which trial, under which condition: labels resolved, checked, and numbered.

use super::context::Context;
use super::errors::{Errors, append};
use super::label::Label;
use super::limits::MOST_NUMBER;
use super::mapping::Who;
use super::recording::{self, Recording};
use super::report::FileReport;
use super::spelling::{is_missing, plain, truth, uuid};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use zwidth_store::{StoreError, readable_records};
use zwidth_study::{
    AnswerScale, AnswerValue, EnvironmentId, IdError, Kind, ModeId, ParticipantId, PlannedTrial,
    SessionId, Study,
};

/// The labels of one trial. Numbers are there where the mapping gives them.
#[derive(Debug, Clone)]
pub(super) struct Identity {
    pub(super) participant: ParticipantId,
    pub(super) session: SessionId,
    pub(super) environment: EnvironmentId,
    pub(super) mode: ModeId,
    pub(super) kind: Kind,
    pub(super) repeat: Option<u32>,
    pub(super) trial: Option<u32>,
    pub(super) likert: Option<AnswerValue>,
    /// Notes for people on how its labels were read.
    notes: Vec<Note>,
    /// The file, for errors.
    pub(super) file: PathBuf,
}

/// A note for people on how a label was read.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Note {
    /// It was a UUID, which is longer than an id.
    Uuid(&'static str),
    /// Other programs write this word for a missing value.
    Mark(&'static str, String),
}

/// Resolves the labels of the trial that begins with `row`.
///
/// # Errors
/// A label that is missing, no id, or not in the study, with file, column and row.
pub(super) fn identity(
    who: &Who,
    recording: &Recording,
    row: usize,
    study: &Study,
) -> Result<Identity, StoreError> {
    let mut notes = Vec::new();
    for (what, label) in [("participant", &who.participant), ("session", &who.session)] {
        let word = label.word(recording, row)?;
        if uuid(&word).is_some() {
            notes.push(Note::Uuid(what));
        }
        // A word that the mapping itself has was chosen by a person.
        if label.column().is_some() && label.translate.is_empty() && is_missing(&word) {
            notes.push(Note::Mark(what, word));
        }
    }
    let participant = who.participant.value("participant", recording, row, id)?;
    let session = who.session.value("session", recording, row, id)?;
    let environments = study.environments.iter().map(|environment| &environment.id);
    let environment = who
        .environment
        .value("environment", recording, row, |t| listed("environment", environments, t))?;
    let question = study.environment(&environment).and_then(|e| e.question.as_ref());
    let question = question.and_then(|id| study.question(id));
    let scale = question.map(|question| question.scale.clone()).unwrap_or_default();
    let modes = study.modes.iter().map(|mode| &mode.id);
    let number = |what: &str, label: &Option<Label>| {
        let label = label.as_ref();
        label.map(|label| label.value(what, recording, row, |t| counted(what, t))).transpose()
    };
    // Fields are evaluated in this order: of several labels that are wrong the first is reported.
    Ok(Identity {
        participant,
        session,
        environment,
        mode: who.mode.value("mode", recording, row, |t| listed("mode", modes, t))?,
        kind: match &who.kind {
            Some(label) => label.value("kind", recording, row, |text| {
                let kind = Kind::from_word(text);
                kind.ok_or_else(|| format!("kind '{text}' must be trial or familiarisation"))
            })?,
            None => Kind::Trial,
        },
        repeat: number("repeat", &who.repeat)?,
        trial: number("trial", &who.trial)?,
        likert: match &who.likert {
            Some(label) if recording.lacks_answer(label, row)? => None,
            Some(label) => {
                let decimal_comma = label.has_decimal_comma(recording, row)?;
                Some(label.value("likert", recording, row, |t| answer(t, decimal_comma, &scale))?)
            }
            None => None,
        },
        notes,
        file: recording.path.clone(),
    })
}

/// The id that a text spells. A UUID has more characters than an id, and as many as that without its
/// hyphens; a whole number loses the decimals that pandas gave it.
pub(super) fn id<T: FromStr<Err = IdError>>(text: &str) -> Result<T, String> {
    let text = match uuid(text) {
        Some(id) => Cow::Owned(id),
        // A truth value keeps its spelling, which may be that of the study's id.
        None if truth(text).is_some() => Cow::Borrowed(text),
        None => plain(text),
    };
    text.parse().map_err(|e: IdError| e.to_string())
}

/// The one of the study's ids that a text spells, in whatever spelling.
fn listed<'a, T: FromStr<Err = IdError> + Clone + PartialEq + Display + 'a>(
    what: &str,
    ids: impl Iterator<Item = &'a T> + Clone,
    text: &str,
) -> Result<T, String> {
    let spelled: T = id(text)?;
    let is_like = |id: &&T| plain(&id.to_string()) == plain(&spelled.to_string());
    let same = ids.clone().find(|id| **id == spelled);
    if let Some(id) = same.or_else(|| ids.clone().find(is_like)) {
        return Ok(id.clone());
    }
    let ids: Vec<String> = ids.map(ToString::to_string).collect();
    Err(format!("{what} '{spelled}' is not in study.toml, which has {}", ids.join(", ")))
}

/// A number of a trial, a repeat or a sweep. Spreadsheets write it as `3.0` too.
pub(super) fn number(what: &str, text: &str) -> Result<u32, String> {
    let value = counted(what, text).ok().filter(|number| *number > 0);
    value.ok_or_else(|| format!("{what} '{text}' must be a whole number from 1 to {MOST_NUMBER}"))
}

/// Like [`number`], for programs that may count from 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) fn counted(what: &str, text: &str) -> Result<u32, String> {
    let value: Option<f64> = plain(text).parse().ok();
    value
        .filter(|v| (0.0..=f64::from(MOST_NUMBER)).contains(v) && v.fract() == 0.0)
        .map(|v| v as u32)
        .ok_or_else(|| format!("{what} '{text}' must be a whole number from 0 to {MOST_NUMBER}"))
}

/// An answer on a scale; of a pair it may be what the chosen one is called.
pub(super) fn answer(
    text: &str,
    decimal_comma: bool,
    scale: &AnswerScale,
) -> Result<AnswerValue, String> {
    let small = |text: &str| text.trim().to_lowercase();
    if let AnswerScale::Pair(labels) = scale
        && let Some((value, _)) =
            (1_i16..).zip(labels).find(|(_, label)| small(label) == small(text))
    {
        return Ok(AnswerValue::from(value));
    }
    let answer = written(text, decimal_comma).filter(|answer| scale.has(*answer));
    answer.ok_or_else(|| match scale {
        AnswerScale::Pair(_) => format!("the answer '{text}' must be {}, or 1 or 2", scale.name()),
        _ => format!("the answer '{text}' must be {}", scale.must_be()),
    })
}

/// The number that a text is; a whole one may be written `4,0` in any file.
pub(super) fn written(text: &str, decimal_comma: bool) -> Option<AnswerValue> {
    let number = recording::number(&plain(text), decimal_comma).ok()??;
    AnswerValue::new(number).ok()
}

/// The trials that a table names by number, so that no two rows contradict each other.
#[derive(Default)]
pub(super) struct Named(BTreeMap<(ParticipantId, SessionId, u32), (usize, Identity)>);

impl Named {
    /// Notes the trial that a row of a recording names, if it names one by number.
    ///
    /// # Errors
    /// A row before it said that this trial has another environment, mode, kind or repeat.
    pub(super) fn add(
        &mut self,
        recording: &Recording,
        row: usize,
        identity: &Identity,
    ) -> Result<(), StoreError> {
        let Some(trial) = identity.trial else { return Ok(()) };
        let key = (identity.participant.clone(), identity.session.clone(), trial);
        let (first, named) = self.0.entry(key).or_insert_with(|| (row, identity.clone()));
        if (&named.environment, &named.mode, named.kind, named.repeat)
            == (&identity.environment, &identity.mode, identity.kind, identity.repeat)
        {
            return Ok(());
        }
        let what = format!(
            "duplicate trial: trial {trial} of {} {} is {} in {}, and {} here",
            identity.participant,
            identity.session,
            condition_words(named),
            recording.row_name(*first),
            condition_words(identity)
        );
        let remedy = "correct one of the rows, or give each trial a number of its own";
        Err(recording.row_error(row, &what, remedy))
    }
}

fn condition_words(i: &Identity) -> String {
    let repeat = i.repeat.map(|repeat| format!(", repeat {repeat}")).unwrap_or_default();
    let kind = if i.kind == Kind::Trial { "" } else { ", familiarisation" };
    format!("{}, {}{repeat}{kind}", i.environment, i.mode)
}

/// Which numbers of an import are counted from 0: those of which one is 0. All of them become one
/// more, so that they are the same in all sessions.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FromZero {
    pub(super) trial: bool,
    pub(super) repeat: bool,
}

impl FromZero {
    pub(super) fn of(identities: &[Identity]) -> Self {
        Self {
            trial: identities.iter().any(|i| i.trial == Some(0)),
            repeat: identities.iter().any(|i| i.repeat == Some(0)),
        }
    }

    /// The number of the trial and that of the repeat, as far as labels name them, from 1.
    pub(super) fn numbers(self, i: &Identity) -> [Option<u32>; 2] {
        [(i.trial, self.trial), (i.repeat, self.repeat)]
            .map(|(number, is_from_zero)| number.map(|n| n + u32::from(is_from_zero)))
    }
}

/// Adds to the report on a file what a person should know of its labels, which are `own` among all
/// of the import.
pub(super) fn tell_labels<'a>(
    report: &mut FileReport,
    own: impl IntoIterator<Item = &'a Identity>,
    all: &[Identity],
) {
    let FromZero { trial, repeat } = FromZero::of(all);
    for (what, is_from_zero) in [("trial", trial), ("repeat", repeat)] {
        if is_from_zero {
            let note =
                format!("{what}s are counted from 0 there, and from 1 here: {what} 0 is {what} 1");
            report.told.push(note);
        }
    }
    let notes: BTreeSet<&Note> = own.into_iter().flat_map(|identity| &identity.notes).collect();
    for note in notes {
        match note {
            Note::Uuid(what) => {
                report.told.push(format!("a {what} is a UUID, which is kept without its hyphens"));
            }
            Note::Mark(what, word) => report.care.push(format!(
                "{what} '{word}': this also stands for a missing value; if nobody has this code, leave such rows \
                 out with missing_words = [\"{word}\"] and missing = \"drop\" in [file]"
            )),
        }
    }
}

/// The trials in the order of `identities`, each with its number in the session and its repeat of the
/// condition: as labels name them, or counted up from 1. Numbers counted from 0 become one more.
///
/// # Errors
/// Two trials of one number, and a trial or session that lies on the disk already.
pub(super) fn number_trials(
    context: &Context,
    identities: &[Identity],
    samples: bool,
) -> Result<Vec<PlannedTrial>, Errors> {
    let mut trials = BTreeMap::new();
    let mut repeats = BTreeMap::new();
    let mut planned = Vec::new();
    let from_zero = FromZero::of(identities);
    for i in identities {
        let session = (&i.participant, &i.session);
        let [trial, repeat] = from_zero.numbers(i);
        let trial = next(&mut trials, session, trial);
        // Practice has repeats of its own: the first repeat that counts is 1.
        let repeat = next(&mut repeats, (session, &i.environment, &i.mode, i.kind), repeat);
        let environment = i.environment.clone();
        let mode = i.mode.clone();
        planned.push(PlannedTrial {
            trial,
            repeat,
            kind: i.kind,
            environment,
            mode,
            samples,
            task: None,
        });
    }
    // Both, so that every problem is reported at once.
    let mut errors = duplicates(context, identities, &planned);
    append(&mut errors, twins(context, identities)?);
    errors.none().map(|()| planned)
}

/// The number that a label names, or the one after the highest so far.
pub(super) fn next<K: Ord>(last: &mut BTreeMap<K, u32>, key: K, named: Option<u32>) -> u32 {
    let last = last.entry(key).or_insert(0);
    let number = named.unwrap_or(*last + 1);
    // Named numbers may come in any order.
    *last = number.max(*last);
    number
}

/// What to do about an existing session.
fn again(context: &Context, participant: &ParticipantId, session: &SessionId) -> String {
    let trial = context.layout.trial(participant, session, 1);
    let trials = trial.parent().unwrap_or(&trial);
    let files = context.layout.session(participant, session).with_extension("*");
    format!(
        "sessions are imported whole, all files in one command: choose another session id, or, to \
         import it again, first remove {} and {}",
        context.layout.shown(trials).display(),
        context.layout.shown(&files).display()
    )
}

fn duplicates(context: &Context, identities: &[Identity], planned: &[PlannedTrial]) -> Errors {
    let mut errors = Errors::default();
    let mut seen: BTreeMap<_, &Path> = BTreeMap::new();
    let mut sessions: BTreeMap<_, bool> = BTreeMap::new();
    for (i, p) in identities.iter().zip(planned) {
        let duplicate = |also: String, remedy: String| {
            let what = format!(
                "duplicate trial: trial {} of {} {} {also}",
                p.trial, i.participant, i.session
            );
            StoreError::new(&i.file, what, remedy)
        };
        if let Some(first) = seen.insert((&i.participant, &i.session, p.trial), &i.file) {
            let remedy = "give every trial a number of its own, or leave the file out".to_owned();
            errors.push(duplicate(format!("is in {} too", first.display()), remedy));
        }
        let path = context.layout.trial(&i.participant, &i.session, p.trial);
        let exists = context.files.kind(&path).is_some();
        if exists {
            let also = format!("is at {} already", context.layout.shown(&path).display());
            errors.push(duplicate(also, again(context, &i.participant, &i.session)));
        }
        *sessions.entry((&i.participant, &i.session)).or_insert(false) |= exists;
    }
    // A session whose trials were named above is not named again.
    for ((participant, session), _) in sessions.iter().filter(|(_, named)| !**named) {
        let record = context.layout.session(participant, session);
        let events = context.layout.events(participant, session);
        if let Some(path) = [record, events].iter().find(|p| context.files.kind(p).is_some()) {
            let what = format!("session {session} of {participant} exists already");
            errors.push(StoreError::new(path, what, again(context, participant, session)));
        }
    }
    errors
}

/// Ids that differ only by case from others: some disks, and some people, take them for the same.
fn twins(context: &Context, identities: &[Identity]) -> Result<Errors, StoreError> {
    let records = readable_records(context.files, context.layout)?;
    let mut people = Cases::default();
    let mut sessions = Cases::default();
    for record in &records {
        people.knows("", record.participant.as_str());
        sessions.knows(record.participant.as_str(), record.session.as_str());
    }
    let mut errors = Errors::default();
    for i in identities {
        let who = i.participant.as_str();
        let which = i.session.as_str();
        let twin = people.add("", who).map(|other| ("participant", who, other));
        let twin = twin.or_else(|| sessions.add(who, which).map(|other| ("session", which, other)));
        errors.extend(twin.map(|(what, id, other)| {
            let what = format!("{what} '{id}' differs only by case from '{other}', which is there");
            StoreError::new(&i.file, what, "write it as it is written there, or choose another id")
        }));
    }
    Ok(errors)
}

/// Ids, and how they are written.
#[derive(Default)]
pub(super) struct Cases(BTreeMap<(String, String), String>);

impl Cases {
    /// Notes an id, within another.
    pub(super) fn knows(&mut self, within: &str, id: &str) {
        self.0.entry((within.to_owned(), id.to_ascii_lowercase())).or_insert_with(|| id.to_owned());
    }

    /// Notes an id; the other one that differs only by case, if there is one. Each such id is told once.
    pub(super) fn add(&mut self, within: &str, id: &str) -> Option<String> {
        self.knows(within, id);
        let other = self.0.get(&(within.to_owned(), id.to_ascii_lowercase()))?;
        let twin = (other != id).then(|| other.clone())?;
        // No id holds a blank, so that this key is never that of an id within another.
        let key = (format!("{within} told"), id.to_owned());
        self.0.insert(key, id.to_owned()).is_none().then_some(twin)
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::{COLUMNS, FORCE, ONE, World, trials_map};
    use super::*;
    use zwidth_study::NumberScale;

    #[test]
    fn numbers_not_given_follow_the_highest_so_far() {
        let mut last = BTreeMap::new();
        let mut at = |key, given| next(&mut last, key, given);
        assert_eq!((at("a", None), at("a", None), at("b", None)), (1, 2, 1));
        assert_eq!((at("a", Some(7)), at("a", Some(3)), at("a", None)), (7, 3, 8));
    }

    #[test]
    fn an_answer_is_a_whole_number_from_1_to_5() {
        let answer = |text: &str| answer(text, false, &AnswerScale::FivePoint);
        assert_eq!((answer("1"), answer("5.0")), (Ok(1.into()), Ok(5.into())));
        for bad in ["0", "6", "2.5", "", "NaN", "agree"] {
            let error = answer(bad).unwrap_err();
            assert!(error.contains("must be a whole number from 1 to 5"), "{bad}: {error}");
        }
    }

    #[test]
    fn an_answer_on_a_line_may_have_decimals_behind_the_sign_of_its_file() {
        let scale = NumberScale { points: 101, from: 0, step: 1, labels: Vec::new() };
        let scale = AnswerScale::Numbers(scale);
        for (text, decimal_comma, expect) in [
            ("47.273", false, Some(47.273)),
            ("47,273", true, Some(47.273)),
            ("47.0", true, Some(47.0)),
            ("47,0", false, Some(47.0)),
            ("1e1", false, Some(10.0)),
            ("47,273", false, None),
            ("47.273", true, None),
            ("100.001", false, None),
            ("-0.5", false, None),
            ("inf", false, None),
            ("", false, None),
        ] {
            let wrong = format!("the answer '{text}' must be a number from 0 to 100");
            let given = answer(text, decimal_comma, &scale).map(AnswerValue::get);
            assert_eq!(given, expect.ok_or(wrong));
        }
    }

    #[test]
    fn a_number_is_whole_and_at_least_1() {
        assert_eq!((number("trial", "12"), number("trial", "3.0")), (Ok(12), Ok(3)));
        for bad in ["0", "-1", "1.5", "x", "1000001", "4294967295", "1e300"] {
            assert!(number("trial", bad).is_err(), "{bad}");
        }
    }

    const NAMED: &str = "
[name]
pattern = '(?<who>\\w+)/(?<session>\\d+)_(?<mode>[a-z]+)\\.csv$'
[trial]
participant = { name = \"who\" }
session = { name = \"session\", prefix = \"S\", digits = 2 }
environment = \"spring\"
mode = { name = \"mode\", translate = { act = \"active\", pas = \"passive\" } }
";

    #[test]
    fn labels_come_from_the_path_and_repeats_are_counted_up_in_file_order() {
        let world = World::new();
        let names = ["P07/9_act.csv", "P07/9_pas.csv", "again/P07/9_act.csv"];
        let files = names.map(|n| {
            world.file(n, format!("t,f\n0,1\n1,{}\n", n.bytes().map(u32::from).sum::<u32>()))
        });
        let map = trials_map(&[NAMED, FORCE]);
        world.import(&map, &files).unwrap();
        let metas: Vec<_> = (1..=3).map(|n| world.trial("P07", "S09", n).meta).collect();
        assert_eq!(metas.iter().map(|m| m.repeat).collect::<Vec<_>>(), [1, 1, 2]);
        assert_eq!(metas[1].mode.as_str(), "passive");
        for (name, words) in [
            ("P08/9_xxx.csv", "'xxx' is not in the translation table, which has act, pas"),
            ("P08.csv", "does not match the pattern"),
        ] {
            world.refuses(&map, &world.file(name, "t,f\n0,1\n1,2\n"), words, None);
        }
    }

    #[test]
    fn a_trial_that_exists_or_comes_back_is_refused_by_name() {
        let world = World::new();
        let csv = "who,mode,n,kind,q,t,f\nP01,active,1,trial,3,0,1\nP01,active,2,trial,3,0,1\nP01,active,1,trial,3,1,1\n";
        let twice = "duplicate trial: trial 1 of P01 S01 is in";
        world.refuses(&trials_map(&[COLUMNS, FORCE]), &world.file("a.csv", csv), twice, None);
        let map = trials_map(&[ONE, FORCE]);
        let file = world.file("b.csv", "t,f\n0,1\n1,2\n");
        world.import(&map, std::slice::from_ref(&file)).unwrap();
        let before = world.written();
        let other = world.file("c.csv", "t,f\n0,1\n1,3\n");
        let there = "duplicate trial: trial 1 of P01 S01 is at raw/demo/trials";
        world.refuses(&map, &other, there, None);
        let second = trials_map(&[ONE, "trial = 2\n", FORCE]);
        world.refuses(&second, &other, "session S01 of P01 exists already", None);
        let errors = world.import(&map, &[file.clone(), file]).unwrap_err();
        assert!(errors[0].what.contains("given twice"), "{errors:?}");
        assert_eq!(world.written(), before);
    }

    #[test]
    fn labels_that_are_no_ids_or_not_in_the_study_are_refused_with_column_and_row() {
        let world = World::new();
        let no_mode = "mode 'actve' is not in study.toml, which has active, passive, hybrid";
        for (from, to, words, at) in [
            ("P01", "../x", "'../x' is not a valid participant id", "who"),
            ("P01", "", "there is no participant", "who"),
            ("active", "actve", no_mode, "mode"),
            ("trial", "test", "kind 'test' must be trial or familiarisation", "kind"),
            (",1,trial", ",-1,trial", "trial '-1' must be a whole number from 0", "n"),
            ("3,0,1", "6,0,1", "the answer '6' must be a whole number from 1 to 5", "q"),
        ] {
            let row = "P01,active,1,trial,3,0,1".replace(from, to);
            let file = world.file("bad.csv", format!("who,mode,n,kind,q,t,f\n{row}\n"));
            world.refuses(&trials_map(&[COLUMNS, FORCE]), &file, words, Some((at, 1)));
        }
    }

    #[test]
    fn numbers_counted_from_0_become_one_more_in_every_session_and_the_report_says_so() {
        let world = World::new();
        let map = COLUMNS.replace("\nkind = {", "\nrepeat = { column = \"r\" }\nkind = {");
        let rows = "P01,active,0,0,0,1\nP01,active,1,1,0,2\nP02,passive,1,1,0,3\n";
        let file = world.file("a.csv", format!("who,mode,n,r,t,f\n{rows}"));
        let map = map.replace("kind = { column = \"kind\" }\nlikert = { column = \"q\" }\n", "");
        let report = world.import(&trials_map(&[&map, FORCE]), &[file]).unwrap();
        let numbers = |participant, trial| {
            let meta = world.trial(participant, "S01", trial).meta;
            (meta.trial, meta.repeat)
        };
        assert_eq!([numbers("P01", 1), numbers("P01", 2)], [(1, 1), (2, 2)]);
        assert_eq!(numbers("P02", 2), (2, 2));
        let told = report.files[0].told.join("\n");
        assert!(told.contains("trials are counted from 0 there, and from 1 here"), "{told}");
        assert!(told.contains("repeat 0 is repeat 1"), "{told}");
    }

    #[test]
    fn a_uuid_is_an_id_without_its_hyphens() {
        let world = World::new();
        let map = ONE.replace("\"S01\"", "{ column = \"s\" }");
        let file = world.file("a.csv", "s,t,f\n5bc8fbbc-bde5-4099-8164-d8399f767c45,0,1\n");
        let report = world.import(&trials_map(&[&map, FORCE]), &[file]).unwrap();
        let trial = world.trial("P01", "5bc8fbbcbde540998164d8399f767c45", 1);
        assert_eq!(trial.samples.len(), 1);
        let told = ["a session is a UUID, which is kept without its hyphens"];
        assert_eq!(report.files[0].told, told);
    }

    #[test]
    fn a_participant_called_as_a_missing_value_is_kept_and_told() {
        let world = World::new();
        let map = ONE.replace("\"P01\"", "{ column = \"who\" }");
        let map = trials_map(&["[file]\nmissing = \"drop\"\n", &map, FORCE]);
        let text = "who,t,f\nNA,0,1\nP02,0,2\n";
        let report = world.import(&map, &[world.file("a.csv", text)]).unwrap();
        assert_eq!((report.trials, report.files[0].rows_kept), (2, 2));
        assert!(report.files[0].care[0].contains("participant 'NA': this also stands"), "{report}");
        let named = map.replace("missing =", "missing_words = [\"NA\"]\nmissing =");
        let other = World::new();
        let report = other.import(&named, &[other.file("a.csv", text)]).unwrap();
        assert_eq!((report.trials, report.files[0].rows_dropped[0].rows), (1, 1));
    }

    #[test]
    fn one_spelling_of_a_label_does_not_part_a_trial_from_another() {
        let map = ONE.replace("\"P01\"", "{ column = \"who\", prefix = \"P\", digits = 2 }");
        let modes = "{ column = \"on\", translate = { true = \"active\", false = \"passive\" } }";
        let map = trials_map(&[&map.replace("\"hybrid\"", modes), FORCE]);
        let text = "who,on,t,f\n1,True,0,1\n1.0,true,1,2\n1,TRUE,2,3\n1,False,0,4\n1.0,FALSE,1,5\n";
        for import in [World::import, World::import_streamed] {
            let world = World::new();
            let report = import(&world, &map, &[world.file("a.csv", text)]);
            assert_eq!(report.unwrap().trials, 2);
            assert_eq!(world.trial("P01", "S01", 1).samples.len(), 3);
        }
        let world = World::new();
        let line = |on: &str, f: u8| format!("{{\"who\":1,\"on\":{on},\"t\":0,\"f\":{f}}}\n");
        world.import(&map, &[world.file("a.jsonl", line("true", 1) + &line("1", 2))]).unwrap();
        assert_eq!(world.trial("P01", "S01", 2).meta.mode.as_str(), "active");
    }

    #[test]
    fn a_mode_of_the_study_is_known_in_any_spelling_of_a_truth_value() {
        let toml = zwidth_study::template(&zwidth_study::StudyId::new("demo").unwrap());
        let world = World::with(&toml.replace("id = \"hybrid\"", "id = \"True\""));
        let map = ONE.replace("\"hybrid\"", "{ column = \"on\" }");
        let file = world.file("a.csv", "on,t,f\nTRUE,0,1\n");
        world.import(&trials_map(&[&map, FORCE]), &[file]).unwrap();
        assert_eq!(world.trial("P01", "S01", 1).meta.mode.as_str(), "True");
    }

    #[test]
    fn an_id_that_differs_only_by_case_from_another_is_refused() {
        let world = World::new();
        let file = world.file("a.csv", "t,f\n0,1\n1,2\n");
        world.import(&trials_map(&[ONE, FORCE]), &[file]).unwrap();
        let before = world.written();
        let other = world.file("b.csv", "t,f\n0,1\n1,3\n");
        for (from, to, words) in [
            ("P01", "p01", "participant 'p01' differs only by case from 'P01'"),
            ("S01", "s01", "session 's01' differs only by case from 'S01'"),
        ] {
            let map = trials_map(&[&ONE.replace(from, to), FORCE]);
            let errors = world.import(&map, std::slice::from_ref(&other)).unwrap_err();
            assert!(errors.len() == 1 && errors[0].what.contains(words), "{errors:?}");
        }
        assert_eq!(world.written(), before);
        let csv = "who,mode,n,kind,q,t,f\nPx,active,1,trial,3,0,1\nPX,active,1,trial,3,0,1\npx,active,1,trial,3,1,1\n";
        let errors = world.import(&trials_map(&[COLUMNS, FORCE]), &[world.file("c.csv", csv)]);
        assert_eq!(errors.unwrap_err().len(), 2);
        let second = trials_map(&[&ONE.replace("S01", "S02"), FORCE]);
        assert_eq!(world.import(&second, &[other]).unwrap().sessions, 1);
    }
}
