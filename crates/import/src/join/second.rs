//! Columns of a second file of the same trial, put on the times of the recording.

use super::super::convert::median;
use super::super::errors::Errors;
use super::super::mapping::{Missing, WithFrom};
use super::super::recording::Recording;
use super::super::shape::Resample;
use super::super::table::Cells;
use super::named::{Named, add};
use super::times::{self, lasts, span};

use arrow::array::{Array as _, Float64Array};
use zwidth_store::StoreError;

/// Times that differ by less are one, s: programs write microseconds, and sums round.
const SAME_S: f64 = 1e-6;
/// Nothing is put between samples farther apart than so many usual steps, …
const GAP_STEPS: f64 = 5.0;
/// … if that is longer than this, s.
const GAP_S: f64 = 0.05;
/// Of a recording more than this share outside of the second file is told as a doubt.
const MUCH: f64 = 0.1;

/// The use that a recording makes of a second file.
#[derive(Debug)]
pub(super) struct SecondUse {
    pub(super) id: String,
    pub(super) path: std::path::PathBuf,
    pub(super) blake3: String,
    /// From when to when it is used, s, on its own clock.
    pub(super) span: [f64; 2],
    how: String,
}

impl SecondUse {
    pub(super) fn words(&self) -> String {
        format!("{} {}, {}", self.id, self.blake3, self.how)
    }
}

/// Adds the columns of a second file to a recording, whose rows have these times.
///
/// # Errors
/// Times of the file that stand still or run backwards; times that do not meet; values between samples that nobody asked
/// for; a gap.
pub(super) fn join(
    named: &Named,
    with: &WithFrom,
    recording: &mut Recording,
    mut other: Recording,
    times: &[f64],
) -> Result<SecondUse, Errors> {
    let columns: Vec<_> = named.of(&with.id).collect();
    let mut places = Vec::new();
    for (_, column) in &columns {
        places.push(other.find(column)?);
    }
    let height = other.height(&places, &[])?;
    let own = times::of_file(&mut other, &with.clock, with.offset_s, height)?;
    let rows: Vec<usize> = (0..height).filter(|row| !own[*row].is_nan()).collect();
    let own: Vec<f64> = rows.iter().map(|row| own[*row]).collect();
    if let Some(at) = own.windows(2).position(|pair| pair[1] <= pair[0]) {
        let what =
            "its times stand still or run backwards, and files are joined by times that go on";
        return Err(other
            .row_error(rows[at + 1], what, "mend the file, or name its times otherwise")
            .into());
    }
    let overlap = span(times).zip(span(&own)).and_then(|([a, b], [c, d])| {
        let both = [a.max(c), b.min(d)];
        (both[0] <= both[1] + SAME_S).then_some(both)
    });
    let Some([from, to]) = overlap else {
        let of = |times| span(times).map_or("no time at all".to_owned(), lasts);
        let what = format!(
            "it and {} ({}) have no time in common: it lasts from {}, and that, with offset_s, from {}",
            other.path.display(),
            with.id,
            of(times),
            of(&own)
        );
        let remedy = format!(
            "check offset_s and unit of '{}', and that its path is that of this recording",
            with.id
        );
        return Err(recording.error(what, remedy).into());
    };
    recording
        .joined
        .keep(times.len(), |row| times[row] >= from - SAME_S && times[row] <= to + SAME_S);
    let inside = |time: &f64| *time >= from - SAME_S && *time <= to + SAME_S;
    let neighbours: Vec<Option<Neighbours>> =
        times.iter().map(|time| inside(time).then(|| Neighbours::of(&own, *time))).collect();
    if with.resample.is_none() {
        check_same(with, recording, &neighbours, times)?;
    }
    let gap = GAP_S.max(GAP_STEPS * median(own.windows(2).map(|pair| pair[1] - pair[0]).collect()));
    let longest = neighbours.iter().flatten().filter(|near| near.share > 0.0);
    let longest = longest.map(|near| own[near.after] - own[near.before]).fold(0.0, f64::max);
    let drops = recording.cells.missing == Missing::Drop;
    if with.resample == Some(Resample::Linear) && longest > gap && !drops {
        let near = neighbours.iter().flatten();
        let mut near =
            near.filter(|near| near.share > 0.0 && own[near.after] - own[near.before] > gap);
        let at = near.next().map_or([0.0; 2], |near| [own[near.before], own[near.after]]);
        let what = format!(
            "it has no sample from {}, and nothing is put between samples so far apart",
            lasts(at)
        );
        let remedy = "leave the rows between them out with missing = \"drop\" in [file], or take the last value with \
                      resample = \"previous\"";
        return Err(other.error(what, remedy).into());
    }
    let mut added: Vec<&str> = Vec::new();
    for ((name, _), place) in columns.iter().zip(&places) {
        if added.contains(name) {
            continue;
        }
        added.push(name);
        let values = values(&other, *place, &rows)?;
        let cells: Float64Array = neighbours
            .iter()
            .map(|near| {
                let Neighbours { before, after, share } = (*near)?;
                let is_far = own[after] - own[before] > gap;
                match with.resample {
                    _ if share == 0.0 => values[before],
                    None => values[if share < 0.5 { before } else { after }],
                    Some(Resample::Previous) => values[before],
                    Some(Resample::Linear) if is_far => None,
                    Some(Resample::Linear) => {
                        let (before, after) = values[before].zip(values[after])?;
                        Some(before + share * (after - before))
                    }
                }
            })
            .collect();
        if !named.budget.cells(cells.len()) {
            return Err(recording
                .error("with its second file it has more than is read at once", "split it")
                .into());
        }
        let unit = other.table.units.get(place).cloned();
        add(recording, name, Cells::Numbers(cells), unit)?;
    }
    named.budget.give_back(other.table.columns.iter().map(Cells::len).sum());
    let how = match with.resample {
        None => "at the same times".to_owned(),
        Some(Resample::Previous) => {
            format!("the last sample before, held for {longest:.6} s at most")
        }
        Some(Resample::Linear) => {
            format!("on the line between samples {longest:.6} s apart at most")
        }
    };
    let outside = neighbours.iter().filter(|near| near.is_none()).count();
    let table = &mut recording.table;
    if outside as f64 > MUCH * times.len() as f64 {
        table.doubts.push(format!(
            "{outside} of {} rows lie outside of the times of '{}': check its offset_s",
            times.len(),
            with.id
        ));
    }
    if with.resample == Some(Resample::Previous) && longest > gap {
        table.doubts.push(format!(
            "'{}' has no sample for {longest:.6} s, and its last value stands there",
            with.id
        ));
    }
    let of_it = |text: String| format!("of '{}': {text}", with.id);
    table.told.extend(other.table.told.into_iter().map(of_it));
    table.doubts.extend(other.table.doubts.into_iter().map(of_it));
    table.lost = table
        .lost
        .take()
        .into_iter()
        .chain(other.table.lost.map(of_it))
        .reduce(|a, b| format!("{a}; {b}"));
    Ok(SecondUse {
        id: with.id.clone(),
        path: other.path,
        blake3: other.blake3,
        span: [from - with.offset_s, to - with.offset_s],
        how: format!("{how}, its times + {} s", with.offset_s),
    })
}

/// The samples on both sides of a time, by their places, and where between them it lies, from 0 to 1.
#[derive(Debug, Clone, Copy)]
struct Neighbours {
    before: usize,
    after: usize,
    share: f64,
}

impl Neighbours {
    /// Those of a time that lies within these, which rise.
    fn of(own: &[f64], time: f64) -> Self {
        let next = own.partition_point(|other| *other <= time);
        let before = next.saturating_sub(1);
        let after = next.min(own.len() - 1);
        // At either end, and where a sum was rounded, a time is that of a sample.
        let nearest = [before, after].into_iter().find(|i| (own[*i] - time).abs() <= SAME_S);
        match nearest {
            Some(i) => Self { before: i, after: i, share: 0.0 },
            None => {
                Self { before, after, share: (time - own[before]) / (own[after] - own[before]) }
            }
        }
    }
}

/// The numbers of a column in these rows; nothing where one is missing.
fn values(other: &Recording, place: usize, rows: &[usize]) -> Result<Vec<Option<f64>>, StoreError> {
    if let Cells::Numbers(cells) = &other.table.columns[place]
        && cells.null_count() == 0
        && other.cells.missing_words.is_empty()
        && cells.values().iter().all(|value| value.is_finite())
    {
        return Ok(rows.iter().map(|row| Some(cells.value(*row))).collect());
    }
    let remedy = "correct the cell; only numbers are taken from the other file";
    let numbers = rows.iter().map(|row| {
        other.number(place, *row).map_err(|what| other.cell_error(place, *row, &what, remedy))
    });
    numbers.collect()
}

/// Checks that both files have their samples at the same times.
fn check_same(
    with: &WithFrom,
    recording: &Recording,
    neighbours: &[Option<Neighbours>],
    times: &[f64],
) -> Result<(), StoreError> {
    let between = neighbours.iter().position(|near| near.is_some_and(|near| near.share > 0.0));
    let Some(row) = between else { return Ok(()) };
    let what = format!(
        "'{}' has no sample at {:.6} s, where it has one: nothing is put between samples unless the mapping says how",
        with.id, times[row]
    );
    let remedy = format!(
        "set resample = \"linear\" (on the line between the samples on both sides) or \"previous\" (the last one before) for '{}'",
        with.id
    );
    Err(recording.row_error(row, &what, &remedy))
}
