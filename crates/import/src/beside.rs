//! Streams that another program recorded beside a session, in an XDF file that has the session's markers too: each sample
//! gets the trial during which it was taken, and its time in that trial.
//!
//! A marker is found in the session's log by its trial, its moment and its time in the trial, which no other session has in
//! common with it. Where the log has the machine's monotonic clock too, and the markers were stamped by that clock, as the
//! LabStreamingLayer does on one machine, it says when each trial began; otherwise the arrival of the trial's markers does, of
//! which the earliest counts: on its way a marker is only ever delayed.

use super::limits::{Budget, MOST_FILE, Take};
use super::spelling::shown;
use super::table::{Cell, Cells, listed};
use super::xdf::{Recorded, Stream, Synchronised, choose, recorded, streams_of, synchronise};
use arrow::array::{ArrayRef, Float64Array, LargeStringArray};
use regex::Regex;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{BesideChannel, BesideStream, StoreError, read_named};
use zwidth_study::{Event, Moment, StreamId, counted};

/// Times of markers that are the same: those sent have six decimals, and so do those in the log, µs.
const SAME_US: f64 = 1.5;
/// Stamps of markers are by the clock of the session's machine if the first of them lies behind its moment by less than this, s.
const MOST_LATE_S: f64 = 2.0;
/// A stamp may lie so far before the moment that it marks, s: both are rounded.
const EARLY_S: f64 = 1e-4;
/// Markers of one trial that disagree by more than this were not sent as the trial ran, s.
const MOST_SPREAD_S: f64 = 0.5;
/// A pause of so many intervals in a stream of a rate is a gap.
const GAP: f64 = 5.5;

/// A stream that is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    /// Its name in the file, or its number.
    pub name: String,
    /// What it is to be called; the name as far as that goes if nothing is said.
    pub id: Option<StreamId>,
}

/// What an XDF file holds beside a session.
#[derive(Debug, Clone)]
pub struct Beside {
    /// Each stream that was asked for.
    pub streams: Vec<BesideStream>,
    /// What is to be known of the file and of each stream, in words.
    pub remarks: Vec<String>,
    /// The trials whose start is known.
    pub trials: usize,
}

/// A marker as it stands in a line of the stream.
#[derive(Deserialize)]
struct Line {
    marker: String,
    trial: u32,
    t_s: f64,
}

/// When a trial ran, by the recorder's clock, s.
#[derive(Debug, Clone, Copy)]
struct Ran {
    trial: u32,
    begin_s: f64,
    end_s: f64,
}

/// The streams of the XDF file at `path` with the times of the session of that log, whose markers are in the stream called
/// `markers`. All others are read if none is `wanted`.
///
/// # Errors
/// A file that cannot be read; a stream that is missing or whose name does not tell which it is; markers that are not this
/// session's.
pub fn beside(
    path: &Path,
    log: &[Event],
    markers: &str,
    wanted: &[Wanted],
) -> Result<Beside, StoreError> {
    let bytes = read_named(path, MOST_FILE).map_err(|e| StoreError::io(path, "read", &e))?;
    let streams = streams_of(path, &bytes)?;
    let all = Regex::new("").map_err(|e| StoreError::defect(path, &e))?;
    let whole = |number: u32, stream| {
        // The room of a recording is that of each stream.
        let budget = Budget::default();
        let take = Take { pattern: Some(&all), ..Take::of(Vec::new(), &budget) };
        let recording = recorded(path, &bytes, number, stream, &take);
        budget.held(&[path.to_owned()]).map_err(|error| StoreError {
            remedy: format!("record stream {number} in parts, or leave it out with --stream"),
            ..error
        })?;
        recording
    };
    let ask_for_name = |error: StoreError| StoreError {
        remedy: "name it with --stream, or the stream of markers with --markers".to_owned(),
        ..error
    };
    let number = choose(path, &streams, Some(markers)).map_err(ask_for_name)?;
    let mut remarks = Vec::new();
    let ran = {
        let stream = &streams[&number];
        let recording = whole(number, stream)?;
        when_trials_ran(path, log, stream, recording, &mut remarks)?
    };
    let chosen: Vec<(u32, Option<StreamId>)> = if wanted.is_empty() {
        let others = streams.iter().filter(|(other, one)| **other != number && one.has_samples);
        others.map(|(other, _)| (*other, None)).collect()
    } else {
        let numbers = wanted.iter().map(|Wanted { name, id }| {
            Ok((choose(path, &streams, Some(name)).map_err(ask_for_name)?, id.clone()))
        });
        numbers.collect::<Result<_, StoreError>>()?
    };
    if chosen.is_empty() {
        let what = "beside the markers the file has no stream with samples";
        return Err(StoreError::new(path, what, "record the other streams into the same file"));
    }
    let mut ids = BTreeSet::new();
    let mut made = Vec::new();
    for (number, id) in chosen {
        let stream = &streams[&number];
        let id = match id {
            Some(id) => id,
            None => id_of(stream.name()).ok_or_else(|| {
                let what = format!("'{}' makes no id for stream {number}", shown(stream.name()));
                StoreError::new(path, what, format!("give it one: --stream {number}=emg"))
            })?,
        };
        if !ids.insert(id.clone()) {
            let what = format!("two streams would be called {id}");
            let remedy = format!("give one of them another id: --stream {number}=other");
            return Err(StoreError::new(path, what, remedy));
        }
        let recording = whole(number, stream)?;
        made.push(in_trials(path, id, stream, recording, &ran, &mut remarks)?);
    }
    Ok(Beside { streams: made, remarks, trials: ran.len() })
}

/// A marker of the session's log.
struct LoggedMarker<'a> {
    trial: u32,
    moment: &'a str,
    t_us: f64,
    /// By the machine's clock, s.
    monotonic_s: Option<f64>,
}

/// A marker of the file that is in the session's log.
struct FoundMarker {
    trial: u32,
    t_s: f64,
    /// When it arrived, by the clock of the machine that it was sent to, s.
    stamp_s: f64,
    /// The same by the recorder's clock, s.
    recorder_s: f64,
    /// When it was, by the clock of the session's machine, s.
    monotonic_s: Option<f64>,
}

/// When each trial ran by the recorder's clock, in its order.
fn when_trials_ran(
    path: &Path,
    log: &[Event],
    stream: &Stream,
    recording: Recorded<'_>,
    remarks: &mut Vec<String>,
) -> Result<Vec<Ran>, StoreError> {
    let mut logged: Vec<LoggedMarker> = Vec::new();
    let mut end_us: BTreeMap<u32, f64> = BTreeMap::new();
    for event in log {
        let Event::Marker { trial, moment, t_us, monotonic_us, .. } = event else { continue };
        let t_us = *t_us as f64;
        logged.push(LoggedMarker {
            trial: *trial,
            moment: moment.as_str(),
            t_us,
            monotonic_s: monotonic_us.map(|us| us as f64 * 1e-6),
        });
        if *moment != Moment::Answer {
            let end = end_us.entry(*trial).or_insert(t_us);
            *end = end.max(t_us);
        }
    }
    if logged.is_empty() {
        let what = "the session's log has no marker";
        let remedy = "record sessions with `zwidth acquire … --markers tcp:127.0.0.1:9000` and examples/markers/to_lsl.py";
        return Err(StoreError::new(path, what, remedy));
    }
    let stamps = recording.times;
    let mut recorder = stamps.clone();
    let Synchronised { doubts, .. } = synchronise(&mut recorder, &stream.offsets, 0.0);
    let doubts = recording.told.into_iter().chain(doubts);
    remarks.extend(doubts.map(|doubt| format!("markers: {doubt}")));
    let mut found: Vec<FoundMarker> = Vec::new();
    let mut unknown = Vec::new();
    for (row, (&stamp_s, &recorder_s)) in stamps.iter().zip(&recorder).enumerate() {
        let cell = recording.cells.first().map_or(Cell::Empty, |channel| channel.cell(row));
        let Cell::Text(text) = cell else { continue };
        let line = serde_json::from_str::<Line>(text).ok();
        let marker = line.and_then(|Line { marker, trial, t_s }| {
            let same = logged.iter().find(|own| {
                (own.trial, own.moment) == (trial, marker.as_str())
                    && (t_s * 1e6 - own.t_us).abs() < SAME_US
            });
            let monotonic_s = same?.monotonic_s;
            Some(FoundMarker { trial, t_s, stamp_s, recorder_s, monotonic_s })
        });
        match marker {
            Some(marker) => found.push(marker),
            None => unknown.push(text.to_owned()),
        }
    }
    if found.is_empty() {
        let what = match unknown.first() {
            Some(first) => format!(
                "none of the {} in it is in the session's log; the first is {}",
                counted(unknown.len(), "markers"),
                shown(first)
            ),
            None => "the stream of markers has no sample".to_owned(),
        };
        return Err(StoreError::new(path, what, "is it the recording of this session?"));
    }
    if let Some(first) = unknown.first() {
        remarks.push(format!(
            "{} of the file not in the session's log: of a trial that was cut short, or of another session; the first is {}",
            counted(unknown.len(), "markers"),
            shown(first)
        ));
    }
    // How long after its moment each arrived, if both are by one clock.
    let late_s: Option<Vec<f64>> =
        found.iter().map(|marker| Some(marker.stamp_s - marker.monotonic_s?)).collect();
    let lateness = late_s.map(|late_s| {
        let least_s = late_s.iter().copied().fold(f64::INFINITY, f64::min);
        (least_s, late_s.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    });
    // By two clocks the difference is anything.
    let one_clock = lateness.filter(|(least_s, _)| (-EARLY_S..MOST_LATE_S).contains(least_s));
    let mut begins: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for marker in found {
        let moment_s = marker.monotonic_s.filter(|_| one_clock.is_some()).unwrap_or(marker.stamp_s);
        let ahead_s = marker.recorder_s - marker.stamp_s;
        begins.entry(marker.trial).or_default().push(moment_s - marker.t_s + ahead_s);
    }
    let mut widest = (0.0, 0);
    let mut ran = Vec::new();
    for (trial, at) in begins {
        let begin_s = at.iter().copied().fold(f64::INFINITY, f64::min);
        let spread_s = at.iter().copied().fold(f64::NEG_INFINITY, f64::max) - begin_s;
        if spread_s > widest.0 {
            widest = (spread_s, trial);
        }
        let end_s = begin_s + end_us.get(&trial).copied().unwrap_or(0.0) * 1e-6;
        ran.push(Ran { trial, begin_s, end_s });
    }
    let (spread_s, trial) = widest;
    if spread_s > MOST_SPREAD_S {
        let what = format!("the markers of trial {trial} disagree by {spread_s:.3} s");
        let remedy = "they did not arrive as the trial ran: record with to_lsl.py on the machine of the session";
        return Err(StoreError::new(path, what, remedy));
    }
    remarks.push(match one_clock {
        Some((least_s, most_s)) => format!(
            "trials are found by the machine's clock, which stamped the markers too: they arrived {:.1} to {:.1} ms after their moments",
            least_s.max(0.0) * 1e3,
            most_s * 1e3
        ),
        None => format!(
            "trials are found by the arrival of their first marker, some ms late; markers of a trial arrived up to {:.1} ms apart",
            spread_s * 1e3
        ),
    });
    ran.sort_by(|a, b| a.begin_s.total_cmp(&b.begin_s));
    Ok(ran)
}

/// A stream whose samples have their trial.
fn in_trials(
    path: &Path,
    id: StreamId,
    stream: &Stream,
    recording: Recorded<'_>,
    ran: &[Ran],
    remarks: &mut Vec<String>,
) -> Result<BesideStream, StoreError> {
    let Recorded { header, times: stamp_s, cells, told: notes, lost } = recording;
    let interval_s = if header.rate_hz > 0.0 { 1.0 / header.rate_hz } else { 0.0 };
    let mut recorder_s = stamp_s.clone();
    let Synchronised { all_used, doubts } =
        synchronise(&mut recorder_s, &stream.offsets, interval_s);
    let mut doubts: Vec<String> = notes.into_iter().chain(lost).chain(doubts).collect();
    if stream.offsets.is_empty() || !all_used {
        doubts.push("it has no clock offsets of use: its times are on its own clock".to_owned());
    }
    if let Some(row) = recorder_s.iter().position(|t| !t.is_finite()) {
        let what =
            format!("a sample of {id} has the time {}, which is not a number", recorder_s[row]);
        return Err(StoreError::new(path, what, "record it again").row0(row));
    }
    let in_trial: Vec<Option<(u32, f64)>> = recorder_s
        .iter()
        .map(|t| {
            let before = ran.partition_point(|trial| trial.begin_s <= *t);
            let own = ran.get(before.checked_sub(1)?)?;
            (*t <= own.end_s).then(|| (own.trial, t - own.begin_s))
        })
        .collect();
    let mut gaps = Vec::new();
    for (i, pair) in recorder_s.windows(2).enumerate() {
        let pause_s = pair[1] - pair[0];
        let trial = in_trial[i].or(in_trial[i + 1]);
        if let Some((trial, _)) = trial.filter(|_| interval_s > 0.0 && pause_s > GAP * interval_s) {
            gaps.push((pause_s, trial));
        }
    }
    if let Some((pause_s, trial)) = gaps.iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
        doubts.push(format!(
            "it pauses {} during trials, for {pause_s:.3} s in trial {trial}: nothing is put into a gap",
            counted(gaps.len(), "times")
        ));
    }
    let backwards = recorder_s.windows(2).filter(|pair| pair[1] < pair[0]).count();
    if backwards > 0 {
        doubts.push(format!("its times go back {}", counted(backwards, "times")));
    }
    let with: BTreeSet<u32> = in_trial.iter().flatten().map(|(trial, _)| *trial).collect();
    let without: Vec<u32> =
        ran.iter().map(|own| own.trial).filter(|trial| !with.contains(trial)).collect();
    if !without.is_empty() {
        let trials = listed(without.iter().map(u32::to_string));
        doubts.push(format!("it has no sample in {} ({trials})", counted(without.len(), "trials")));
    }
    let inside = in_trial.iter().flatten().count();
    remarks.push(format!(
        "{id}: {}, {inside} of them in {}",
        counted(in_trial.len(), "samples"),
        counted(with.len(), "trials")
    ));
    remarks.extend(doubts.iter().map(|doubt| format!("{id}: {doubt}")));
    let mut names = BTreeSet::new();
    let mut channels = Vec::new();
    for (place, (channel, cells)) in header.channels.iter().zip(&cells).enumerate() {
        let plain = column_name(&channel.name);
        let taken = |name: &str| BesideStream::is_taken(name) || names.contains(name);
        let name = if plain.is_empty() || taken(&plain) {
            format!("channel_{}", place + 1)
        } else {
            plain
        };
        if !names.insert(name.clone()) {
            let what = format!("two channels of stream {id} would be called {name}");
            return Err(StoreError::new(path, what, "give them labels of their own"));
        }
        let unit = if channel.unit.is_empty() { "1" } else { &channel.unit };
        channels.push(BesideChannel {
            name,
            unit: unit.to_owned(),
            label: channel.name.clone(),
            values: array(cells),
        });
    }
    let offsets: Vec<[f64; 2]> = stream
        .offsets
        .iter()
        .map(|(t, by)| [*t, *by])
        .filter(|o| o.iter().all(|v| v.is_finite()))
        .collect();
    let begins: Vec<(u32, f64, f64)> =
        ran.iter().map(|own| (own.trial, own.begin_s, own.end_s)).collect();
    let json = |text: serde_json::Result<String>| text.map_err(|e| StoreError::defect(path, &e));
    let about = BTreeMap::from([
        ("name".to_owned(), header.name.clone()),
        ("type".to_owned(), header.kind.clone()),
        ("source_id".to_owned(), header.source_id.clone()),
        ("uid".to_owned(), header.uid.clone()),
        ("nominal_rate_hz".to_owned(), header.rate_hz.to_string()),
        ("clock_offsets_s".to_owned(), json(serde_json::to_string(&offsets))?),
        ("trials_recorder_s".to_owned(), json(serde_json::to_string(&begins))?),
        ("doubts".to_owned(), doubts.join("; ")),
    ]);
    Ok(BesideStream { id, stamp_s, recorder_s, in_trial, channels, about })
}

/// The values of a channel; no number is a null, which a NaN is too.
fn array(cells: &Cells) -> ArrayRef {
    match cells {
        Cells::Text(texts) => Arc::new(texts.clone()),
        Cells::Numbers(numbers) => {
            let numbers = numbers.iter().map(|own| own.filter(|value| value.is_finite()));
            Arc::new(Float64Array::from_iter(numbers))
        }
        _ => Arc::new(LargeStringArray::new_null(cells.len())),
    }
}

/// A label as the name of a column: what is neither letter nor digit of ASCII is a `_`.
fn column_name(label: &str) -> String {
    let plain: String =
        label.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    plain.trim_matches('_').chars().take(64).collect()
}

/// A stream's name as an id, in small letters.
fn id_of(name: &str) -> Option<StreamId> {
    let plain: String = column_name(name).to_ascii_lowercase().chars().take(32).collect();
    plain.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::super::xdf::tests::{chunk, header, length, offset, samples};
    use super::*;

    /// When the first trial began by the markers' clock, s; the second begins 10 s later.
    const BEGUN_S: f64 = 1000.0;
    /// What the recorder's clock is ahead of both others', s.
    const AHEAD_S: f64 = 50.0;

    fn trial_begun_s(trial: u32) -> f64 {
        BEGUN_S + 10.0 * f64::from(trial - 1)
    }

    /// A session of two trials of 2 s with its markers, which has the machine's clock or not.
    fn log(has_clock: bool) -> Vec<Event> {
        let moments = [
            (Moment::Start, 0),
            (Moment::Contact, 500_000),
            (Moment::End, 2_000_000),
            (Moment::Answer, 3_000_000),
        ];
        let one = |trial: u32, (moment, t_us): (Moment, u64)| Event::Marker {
            trial,
            moment,
            t_us,
            device_us: None,
            monotonic_us: has_clock.then(|| (trial_begun_s(trial) * 1e6) as u64 + t_us),
        };
        let note = Event::Note { trial: None, text: "left-handed".to_owned() };
        (1..=2).flat_map(|trial| moments.map(|own| one(trial, own))).chain([note]).collect()
    }

    /// A word of a stream of words.
    fn word(at_s: f64, text: &str) -> Vec<u8> {
        [&length(1)[..], &[8], &at_s.to_le_bytes(), &length(text.len()), text.as_bytes()].concat()
    }

    /// The markers of the log, each late by its own way; `more` besides.
    fn markers(late_s: impl Fn(usize) -> f64, more: &[(f64, &str)]) -> Vec<u8> {
        let mut file = header(7, "zwidth", 1, 0.0, "string", "");
        for (i, event) in log(false).iter().enumerate() {
            let Event::Marker { trial, moment, t_us, .. } = event else { continue };
            let t_s = *t_us as f64 * 1e-6;
            let line = format!(
                "{{\"marker\":\"{}\",\"trial\":{trial},\"t_s\":{t_s:.6}}}",
                moment.as_str()
            );
            file.extend(chunk(3, Some(7), &word(trial_begun_s(*trial) + t_s + late_s(i), &line)));
        }
        more.iter().for_each(|(at_s, text)| file.extend(chunk(3, Some(7), &word(*at_s, text))));
        file.extend([1000.0, 1010.0].map(|t| offset(7, t, AHEAD_S)).concat());
        file
    }

    /// An EMG of 10 Hz from before the first trial to after the second, without its sample at these numbers.
    fn emg(gap: std::ops::Range<usize>) -> Vec<u8> {
        let desc = "<channels><channel><label>m. biceps</label><unit>mV</unit></channel><channel><label>t_s</label></channel></channels>";
        let mut file = header(3, "EMG of the arm", 2, 10.0, "float32", desc);
        for i in (0..150).filter(|i| !gap.contains(i)) {
            // By a clock of its own, which the recorder's is 450 s ahead of.
            let at = BEGUN_S - 1.0 + 0.1 * i as f64 - 400.0;
            file.extend(samples(3, &[(Some(at), &[i as f32, f32::NAN])]));
        }
        file.extend([600.0, 612.0].map(|t| offset(3, t, AHEAD_S + 400.0)).concat());
        file
    }

    /// What is found in a file of these parts.
    fn found(
        parts: &[Vec<u8>],
        has_clock: bool,
        wanted: &[(&str, Option<&str>)],
    ) -> Result<Beside, StoreError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lab.xdf");
        let bytes = [
            b"XDF:".to_vec(),
            chunk(1, None, b"<info><version>1.0</version></info>"),
            parts.concat(),
        ]
        .concat();
        std::fs::write(&path, bytes).unwrap();
        let wanted = wanted.iter().map(|(name, id)| Wanted {
            name: (*name).to_owned(),
            id: id.map(|id| id.parse().unwrap()),
        });
        beside(&path, &log(has_clock), "zwidth", &wanted.collect::<Vec<_>>())
    }

    fn refusal(parts: &[Vec<u8>], wanted: &[(&str, Option<&str>)]) -> String {
        found(parts, false, wanted).unwrap_err().to_string()
    }

    #[test]
    fn each_sample_has_its_trial_and_its_time_there_by_the_clock_that_log_and_markers_share() {
        let late = |i: usize| 0.003 + 0.001 * i as f64;
        let Beside { streams, remarks, trials } =
            found(&[markers(late, &[]), emg(0..0)], true, &[]).unwrap();
        let [emg] = &streams[..] else { panic!("{}", streams.len()) };
        assert_eq!((emg.id.as_str(), trials, emg.in_trial.len()), ("emg_of_the_arm", 2, 150));
        // The first sample is a second before the first trial, and the recorder's clock 450 s ahead of its own.
        assert!((emg.stamp_s[0] - 599.0).abs() < 1e-9 && (emg.recorder_s[0] - 1049.0).abs() < 1e-6);
        for (i, at) in emg.in_trial.iter().enumerate() {
            let t_s = 0.1 * i as f64 - 1.0;
            let expect = [(1, t_s), (2, t_s - 10.0)]
                .into_iter()
                .find(|(_, t_s)| (-1e-6..=2.0 + 1e-6).contains(t_s));
            match (at, expect) {
                (Some((trial, t)), Some((own, expect))) => {
                    assert!(*trial == own && (t - expect).abs() < 1e-6, "{i}: {at:?}");
                }
                // At an end itself rounding decides.
                (at, expect) => assert!(
                    at.is_none() == expect.is_none() || [10, 30, 110, 130].contains(&i),
                    "{i}: {at:?}"
                ),
            }
        }
        let names: Vec<(&str, &str)> =
            emg.channels.iter().map(|own| (own.name.as_str(), own.unit.as_str())).collect();
        assert_eq!(names, [("m__biceps", "mV"), ("channel_2", "1")]);
        assert_eq!(emg.channels[1].values.null_count(), 150, "no number is a null");
        assert!(remarks.iter().any(|line| line.contains("by the machine's clock")), "{remarks:?}");
        assert!(emg.about["clock_offsets_s"].starts_with("[[600.0,450.0]"), "{:?}", emg.about);
    }

    #[test]
    fn without_that_clock_the_earliest_marker_of_a_trial_says_when_it_began() {
        let late = |i: usize| [0.004, 0.002, 0.007, 0.003][i % 4];
        let Beside { streams, remarks, .. } =
            found(&[markers(late, &[]), emg(0..0)], false, &[]).unwrap();
        let (trial, t_s) = streams[0].in_trial[20].unwrap();
        // A second after the first trial began, which is taken to be 2 ms later than it was.
        assert!(trial == 1 && (t_s - 0.998).abs() < 1e-6, "{t_s}");
        assert!(remarks.iter().any(|line| line.contains("up to 5.0 ms apart")), "{remarks:?}");
    }

    #[test]
    fn a_gap_is_told_and_nothing_is_put_into_it() {
        let Beside { streams, remarks, .. } =
            found(&[markers(|_| 0.001, &[]), emg(15..25)], true, &[]).unwrap();
        assert_eq!(streams[0].in_trial.len(), 140);
        assert!(
            remarks
                .iter()
                .any(|line| line.contains("pauses 1 time during trials, for 1.100 s in trial 1")),
            "{remarks:?}"
        );
        assert!(streams[0].about["doubts"].contains("pauses"));
    }

    #[test]
    fn a_recording_of_another_session_and_streams_that_nobody_can_tell_apart_are_refused() {
        let other = [(1000.0, "{\"marker\":\"start\",\"trial\":1,\"t_s\":0.250000}")];
        let strange = [
            header(7, "zwidth", 1, 0.0, "string", ""),
            chunk(3, Some(7), &word(other[0].0, other[0].1)),
        ]
        .concat();
        assert!(
            refusal(&[strange, emg(0..0)], &[])
                .contains("is in the session's log; the first is {\"marker\":\"start\"")
        );
        let good = markers(|_| 0.001, &other);
        let remarks = found(&[good.clone(), emg(0..0)], false, &[]).unwrap().remarks;
        assert!(
            remarks
                .iter()
                .any(|line| line.starts_with("1 marker of the file not in the session's log")),
            "{remarks:?}"
        );
        assert!(refusal(&[emg(0..0)], &[]).contains("there is no stream 'zwidth'"));
        assert!(refusal(std::slice::from_ref(&good), &[]).contains("no stream with samples"));
        assert!(
            refusal(&[good.clone(), emg(0..0)], &[("gaze", None)])
                .contains("there is no stream 'gaze'")
        );
        let twice = [("3", None), ("EMG of the arm", Some("emg_of_the_arm"))];
        assert!(
            refusal(&[good.clone(), emg(0..0)], &twice)
                .contains("two streams would be called emg_of_the_arm")
        );
        let unnamed =
            [header(4, "µ", 1, 0.0, "float32", ""), samples(4, &[(Some(1.0), &[0.0])])].concat();
        assert!(refusal(&[good, unnamed], &[]).contains("makes no id for stream 4"));
        let late = |i: usize| if i == 2 { 0.9 } else { 0.001 };
        assert!(
            refusal(&[markers(late, &[]), emg(0..0)], &[])
                .contains("the markers of trial 1 disagree by 0.899 s")
        );
        let silent = beside(Path::new("absent.xdf"), &[], "zwidth", &[]).unwrap_err().to_string();
        assert!(silent.contains("absent.xdf"), "{silent}");
    }
}
