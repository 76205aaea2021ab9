//! The trials of a long text: read block by block, as many at a time as there are cores, and
//! written as they are read, so neither the whole text nor its columns are ever in memory. The
//! result is the same as for a short recording.

use super::blocks::{Block, Blocks, is_long};
use super::context::Context;
use super::counter;
use super::csv;
use super::errors::{Errors, all};
use super::even;
use super::growing::Part;
use super::identity::{Identity, identity};
use super::limits::{Budget, Take};
use super::mapping::{CellForm, FileForm, Who};
use super::plan::Plan;
use super::recording::{Recording, Rows, Standing, empty_between, groups};
use super::spelling::plain;
use super::table::{Cell, ColumnRef, Table};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use zwidth_store::{MOST_ROWS, StoreError};

/// A long text, and what is taken from it.
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    context: &'a Context<'a>,
    who: &'a Who,
    plan: &'a Plan<'a>,
    form: FileForm,
    groups: BTreeMap<String, String>,
}

/// A block, read.
struct Parsed {
    recording: Recording,
    rows: Rows,
    numeric: Vec<usize>,
    labels: Vec<usize>,
    /// Numbers in the kept rows, a column each.
    values: Vec<Vec<f64>>,
    /// Stretches of the kept rows that may be trials of their own, and whose they are.
    stretches: Vec<(Range<usize>, Identity)>,
    /// The labels' cells of the first and of the last kept row.
    ends: [Vec<String>; 2],
    /// Of the text.
    bytes: u64,
}

/// Rows of one trial that follow each other in a block.
pub(super) struct Stretch<'a> {
    /// Whether they are the first of their trial.
    pub(super) begins: bool,
    pub(super) identity: &'a Identity,
    parsed: &'a Parsed,
    range: Range<usize>,
    /// Rows of the file before the block, with values and in all.
    before: Standing,
}

/// The state of the walk through a text.
#[derive(Debug, Default)]
pub(super) struct Walked {
    pub(super) rows: Rows,
    /// The number of rows kept.
    pub(super) kept: usize,
    /// The number of empty rows between the first that was kept and the last.
    pub(super) empty: usize,
    /// Rows that were read, empty ones included.
    places: usize,
    /// The places of the first and of the last row that were kept.
    ends: Option<[Standing; 2]>,
    pub(super) blake3: String,
    /// The names of the columns, and how many there are, as the first block has them.
    shape: Option<(Option<Vec<String>>, usize)>,
    /// The labels' cells of the last row that was kept, and its time where that parts trials.
    last: Option<(Vec<String>, Option<f64>)>,
}

impl<'a> Source<'a> {
    /// The text at `path`, if it is long.
    ///
    /// # Errors
    /// A path that the pattern of the mapping does not match.
    pub(super) fn of(
        context: &'a Context<'a>,
        who: &'a Who,
        plan: &'a Plan<'a>,
        path: &'a Path,
    ) -> Result<Option<Self>, StoreError> {
        let form = &context.mapping.file;
        if !is_long(path, form) {
            return Ok(None);
        }
        let pattern = context.mapping.name.as_ref();
        let groups =
            pattern.map_or_else(|| Ok(BTreeMap::new()), |pattern| groups(path, pattern))?;
        Ok(Some(Self { path, context, who, plan, form: form.clone(), groups }))
    }

    /// Whose the trials in it are, in order. Where no label comes from a column, and time does not
    /// part trials, it is one trial, and the first rows tell.
    ///
    /// # Errors
    /// Everything wrong with the file, as far as it was read.
    pub(super) fn identities(&self, budget: &Budget) -> Result<Vec<Identity>, Errors> {
        let one = self.who.columns().is_empty() && !self.form.splits_at_time;
        let mut identities: Vec<Identity> = Vec::new();
        let walked = self.walk(&|_| {}, &mut |stretch| {
            if stretch.begins {
                budget.trials(self.path, 1)?;
                identities.push(stretch.identity.clone());
            }
            Ok(!one)
        })?;
        if identities.is_empty() {
            return Err(self.empty(walked.rows.read).into());
        }
        Ok(identities)
    }

    fn empty(&self, read: usize) -> StoreError {
        let what = if read == 0 { "the file has 0 rows" } else { "no row has all mapped values" };
        StoreError::new(self.path, what, "leave the file out of the import")
    }

    /// Goes through the text; `each` gets every stretch in order, and says whether to go on,
    /// `progress` how many bytes were read.
    ///
    /// # Errors
    /// What is wrong with the first block in which anything is; what `each` says.
    pub(super) fn walk(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        each: &mut (dyn FnMut(&Stretch) -> Result<bool, Errors> + Send),
    ) -> Result<Walked, Errors> {
        let dialect = self.form.dialect(self.form.format_of(self.path)?);
        let mut blocks = Blocks::open(self.path, dialect)?;
        let mut walked = Walked::default();
        let mut parsed = self.parse_some(&mut blocks);
        while !parsed.is_empty() {
            let mut go_on = true;
            // The next blocks are parsed while these are written: memory holds both.
            let (next, done) = rayon::join(
                || self.parse_some(&mut blocks),
                || -> Result<(), Errors> {
                    for block in parsed {
                        // A block counts its rows from its own beginning.
                        let rows = walked.rows.read;
                        let block = block.map_err(|errors| {
                            errors.map(|error| StoreError {
                                row: error.row.map(|row| row + rows),
                                ..error
                            })
                        })?;
                        go_on = go_on && self.pass(&block, &mut walked, progress, each)?;
                    }
                    Ok(())
                },
            );
            done?;
            if !go_on {
                return Ok(walked);
            }
            parsed = next;
        }
        walked.empty = walked.ends.map_or(0, |[first, last]| empty_between(first, last));
        walked.blake3 = blocks.blake3();
        if walked.kept == 0 {
            return Err(self.empty(walked.rows.read).into());
        }
        Ok(walked)
    }

    /// Passes a block on; whether to go on.
    fn pass(
        &self,
        parsed: &Parsed,
        walked: &mut Walked,
        progress: &(dyn Fn(u64) + Sync),
        each: &mut (dyn FnMut(&Stretch) -> Result<bool, Errors> + Send),
    ) -> Result<bool, Errors> {
        let before = Standing { row: walked.rows.read, place: walked.places };
        // A header that is a cell short of its first record is mended: of every block or of none.
        let table = &parsed.recording.table;
        let shape = (table.names.clone(), table.columns.len());
        let has_rows = parsed.rows.read > 0;
        if has_rows && *walked.shape.get_or_insert_with(|| shape.clone()) != shape {
            let what = "it has another number of cells than the rows before it";
            let error = StoreError::new(self.path, what, "mend the row, or remove it");
            return Err(error.row0(before.row).into());
        }
        walked.places = walked.places.saturating_add(table.place(parsed.rows.read));
        walked.rows.read += parsed.rows.read;
        walked.rows.missing += parsed.rows.missing;
        walked.kept += parsed.rows.kept.len();
        if walked.rows.read > MOST_ROWS {
            let what = format!("the file has more than {MOST_ROWS} rows, and no more are read");
            return Err(StoreError::new(self.path, what, "split it").into());
        }
        progress(parsed.bytes);
        let times = parsed.values.first().filter(|_| self.form.splits_at_time);
        for (i, (range, identity)) in parsed.stretches.iter().enumerate() {
            let continues = i == 0
                && walked.last.as_ref().is_some_and(|(labels, last_time)| {
                    let time = times.and_then(|times| times.get(range.start));
                    let falls = time.zip(*last_time).is_some_and(|(b, a)| *b < a);
                    *labels == parsed.ends[0] && !falls
                });
            let range = range.clone();
            if !each(&Stretch { begins: !continues, identity, parsed, range, before })? {
                return Ok(false);
            }
        }
        if let (Some(first), Some(end)) = (parsed.rows.kept.first(), parsed.rows.kept.last()) {
            let [first, end] = [*first, *end].map(|row| before.of(table, row));
            walked.ends = Some([walked.ends.map_or(first, |[first, _]| first), end]);
            let time = times.and_then(|times| times.last()).copied();
            walked.last = Some((parsed.ends[1].clone(), time));
        }
        Ok(true)
    }

    /// The next blocks, as many as there are cores.
    fn parse_some(&self, blocks: &mut Blocks) -> Vec<Result<Parsed, Errors>> {
        let mut read = Vec::new();
        // Parsed, a block takes some ten times its bytes: on many cores memory is the bound.
        for _ in 0..rayon::current_num_threads().clamp(1, 8) {
            match blocks.next() {
                Ok(Some(block)) => read.push(Ok(block)),
                Ok(None) => break,
                Err(error) => {
                    read.push(Err(Errors::from(error)));
                    break;
                }
            }
        }
        read.into_par_iter().map(|block| self.parse(&block?)).collect()
    }

    /// The table of a block in which all is plain, if numbers may not be spelled as words or with a comma.
    fn even(&self, block: &Block, take: &Take) -> Option<Table> {
        let CellForm { decimal_comma, missing_words, .. } = &self.form.cells;
        let labels = self.who.columns();
        // Of a label the text is needed.
        let is_number = |place: usize, name: Option<&str>| {
            self.plan.columns().any(|column| column.means(place, name))
                && !labels.iter().any(|column| column.means(place, name))
        };
        let is_plain = !decimal_comma && missing_words.is_empty();
        is_plain.then(|| even::read(self.path, block, take, &is_number)).flatten()
    }

    fn parse(&self, block: &Block) -> Result<Parsed, Errors> {
        // Columns that are not mapped cost time: where times are recorded they are not read.
        let looked_at: Vec<ColumnRef> =
            self.plan.rate_hz.map_or_else(Vec::new, |_| counter::looked_at().collect());
        let columns = self.plan.columns().chain(self.who.columns()).chain(&looked_at).collect();
        let budget = Budget::default();
        let take = Take::of(columns, &budget);
        let table = match self.even(block, &take) {
            Some(table) => table,
            None => csv::read(self.path, &block.text, block.dialect, &take)?,
        };
        let mut recording =
            Recording::part(self.path, table, self.form.cells.clone(), self.groups.clone());
        if let Some(time) = self.plan.time {
            recording.read_clock(time, false)?;
        }
        let numeric = all(self.plan.columns().map(|column| recording.find(column)))?;
        let labels = all(self.who.columns().into_iter().map(|c| recording.find(c)))?;
        let needed = all(self.who.needed_columns().into_iter().map(|c| recording.find(c)))?;
        let rows = recording.rows_in(&self.form, &numeric, &needed)?;
        let values = all(numeric.iter().map(|column| recording.numbers(*column, &rows.kept)))?;
        let mut stretches = Vec::new();
        let mut at = 0;
        let time = numeric.first().copied().filter(|_| self.form.splits_at_time);
        for stretch in recording.pieces(&rows.kept, &labels) {
            let parts: Vec<&[usize]> = match time {
                Some(time) => recording.restarts(stretch, time).collect(),
                None => vec![stretch],
            };
            for part in parts {
                let whose = identity(self.who, &recording, part[0], self.context.study)?;
                stretches.push((at..at + part.len(), whose));
                at += part.len();
            }
        }
        let ends = [rows.kept.first(), rows.kept.last()].map(|row| {
            let Some(row) = row else { return Vec::new() };
            let cells = labels.iter().map(|column| recording.table.columns[*column].cell(*row));
            // An empty cell and an empty text are not the same.
            let texts = cells.map(|cell| {
                format!("{}{}", u8::from(cell != Cell::Empty), plain(&cell.to_string()))
            });
            texts.collect()
        });
        let bytes = block.text.len() as u64;
        Ok(Parsed { numeric, labels, values, stretches, ends, rows, recording, bytes })
    }
}

impl Stretch<'_> {
    /// The recording and its columns, from which the report on the file is made.
    pub(super) fn recording(&self) -> (&Recording, Vec<usize>) {
        (&self.parsed.recording, [&self.parsed.numeric[..], &self.parsed.labels].concat())
    }

    pub(super) fn part(&self) -> Part<'_> {
        let Parsed { recording, rows, numeric, labels, values, .. } = self.parsed;
        Part {
            recording,
            numeric,
            labels,
            rows: &rows.kept[self.range.clone()],
            values: values.iter().map(|column| &column[self.range.clone()]).collect(),
            before: self.before,
            is_whole: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::FileReport;
    use super::super::skipped::{Imported, both};
    use super::super::world::{ONE, World, trials_map};
    use std::fmt::Write as _;
    use std::path::Path;
    use zwidth_store::{StudyData, Trial, read_channels};

    const MOVED: &str = "
[time]
from = \"t\"
unit = \"ms\"
zero = \"first\"
[[column]]
to = \"theta_rad\"
from = \"x\"
unit = \"deg\"
sign = -1
zero = \"first\"
[[column]]
to = \"theta_dot_rad_s\"
derive = \"derivative of theta_rad\"
[[column]]
to = \"theta_ddot_rad_s2\"
derive = \"derivative of theta_dot_rad_s\"
[[column]]
to = \"force_ex_n\"
from = \"f\"
unit = \"N\"
";
    const INTEGRATED: &str = "
[time]
from = \"t\"
unit = \"ms\"
[[column]]
to = \"theta_dot_rad_s\"
from = \"x\"
unit = \"deg/s\"
[[column]]
to = \"theta_rad\"
derive = \"integral of theta_dot_rad_s\"
";

    /// A text of `rows` rows; `row` gives what stands behind time, angle and force.
    fn text(header: &str, rows: usize, row: impl Fn(usize) -> String) -> String {
        let mut text = format!("{header}\n");
        for i in 0..rows {
            #[allow(clippy::cast_precision_loss)]
            let t = i as f64;
            let (x, f) = (20.0 * libm::sin(t * 0.011), libm::cos(t * 0.013));
            let _ = writeln!(text, "{},{x},{f}{}", 100.0 + t, row(i));
        }
        text
    }

    fn trials(world: &World) -> Vec<Trial> {
        // `verify` has something to say of such a recording, of both ways the same.
        let data = StudyData::load(&world.layout).unwrap();
        let channels: Vec<_> = data.study.channels.iter().map(|c| c.id.clone()).collect();
        let read = |path: &Path| {
            let mut trial = zwidth_store::read_trial(path, zwidth_store::Signal::all()).unwrap();
            for (id, values) in read_channels(path, &channels).unwrap().samples.channels() {
                trial.samples.set_channel(id.clone(), values.to_vec());
            }
            trial
        };
        data.trials.iter().map(|entry| read(&entry.path)).collect()
    }

    /// Both ways give the same trials, bit for bit, and the same report.
    #[track_caller]
    fn alike(map: &str, content: &str, trials_made: usize) {
        let [(whole, of_whole), (streamed, of_streamed)] = both(map, "a.csv", content.as_bytes());
        let report = |imported: Imported| -> Vec<FileReport> {
            let files = imported.unwrap().files.into_iter();
            files.map(|file| FileReport { file: String::new(), ..file }).collect()
        };
        assert_eq!(report(of_whole), report(of_streamed));
        let (expect, found) = (trials(&whole), trials(&streamed));
        assert_eq!(expect.len(), trials_made);
        // Formatted numbers tell -0 from 0, and what a file says of itself is compared too.
        assert_eq!(format!("{expect:?}"), format!("{found:?}"));
    }

    #[test]
    fn a_long_text_becomes_the_same_trial_as_one_that_is_read_whole() {
        alike(&trials_map(&[ONE, MOVED]), &text("t,x,f", 3000, |_| String::new()), 1);
        let rated =
            MOVED.replace("from = \"t\"\nunit = \"ms\"\nzero = \"first\"", "rate_hz = 500.0");
        alike(&trials_map(&[ONE, &rated]), &text("t,x,f", 2100, |_| String::new()), 1);
        alike(&trials_map(&[ONE, INTEGRATED]), &text("t,x,f", 2100, |_| String::new()), 1);
        let spaced = text("t,x,f", 900, |_| String::new()).replace(',', "   ");
        let map = trials_map(&["[file]\nformat = \"txt\"\n", ONE, MOVED]);
        alike(&map, &spaced, 1);
    }

    #[test]
    fn labels_restarts_and_dropped_rows_part_a_long_text_as_a_short_one() {
        let labels = "
[trial]
participant = \"P01\"
session = \"S01\"
environment = \"spring\"
mode = { column = \"m\" }
";
        let modes = ["active", "passive", "hybrid"];
        let mode = |i: usize| format!(",{}", modes[i / 1000]);
        let map = trials_map(&["[file]\nmissing = \"drop\"\n", labels, MOVED]);
        let content = text("t,x,f,m", 2500, mode);
        let mut lines: Vec<&str> = content.lines().collect();
        for (line, without_angle) in
            [(1, "100,,1,active"), (1000, "1099,,1,active"), (2001, "2100,nan,1,hybrid")]
        {
            lines[line] = without_angle;
        }
        alike(&map, &lines.join("\n"), 3);
        let restarts = text("t,x,f", 1300, |_| String::new());
        let again = restarts.split_once('\n').unwrap().1;
        let map = trials_map(&["[file]\nsplit = \"time\"\n", ONE, MOVED]);
        alike(&map, &format!("{restarts}{again}{again}"), 3);
    }

    #[test]
    fn a_header_after_skipped_lines_quotes_and_another_encoding_are_read_block_by_block_too() {
        let content = text("\"t\",\"x\",f,n\u{f6}te", 1500, |i| format!(",\"a, {i}\n\u{e9}\""));
        let map = trials_map(&[
            "[file]\nskip = 2\nencoding = \"latin-1\"\ncomment = \"#\"\n",
            ONE,
            MOVED,
        ]);
        let latin: Vec<u8> =
            format!("rig\nof 2026\n# a remark\n{content}").chars().map(|c| c as u8).collect();
        let [whole, streamed] = both(&map, "a.csv", &latin).map(|(world, imported)| {
            imported.unwrap();
            format!("{:?}", trials(&world))
        });
        assert_eq!(whole, streamed);
    }

    #[test]
    fn what_is_wrong_far_down_a_long_text_is_told_as_in_a_short_one_and_nothing_stays() {
        let map = trials_map(&[ONE, MOVED]);
        let good = text("t,x,f", 3000, |_| String::new());
        let cell = |line: usize, to: &str| {
            let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
            lines[line] = to.to_owned();
            lines.join("\n") + "\n"
        };
        for bad in [
            cell(2500, "2599,x,1"),
            cell(2500, "2599,1"),
            cell(2500, "1,1,1"),
            cell(2500, "2599,,1"),
            cell(2700, "2799,9e9,1"),
        ] {
            let [(_, whole), (streamed, found)] = both(&map, "a.csv", bad.as_bytes());
            let words = |imported: Imported| -> Vec<(Option<String>, Option<usize>, String)> {
                imported.unwrap_err().into_iter().map(|e| (e.column, e.row, e.what)).collect()
            };
            assert_eq!(words(whole), words(found));
            assert_eq!(streamed.written(), ["study.toml"]);
        }
    }

    #[test]
    fn a_header_that_is_a_cell_short_or_has_a_lone_quote_is_read_as_in_a_short_text() {
        let map = trials_map(&["[file]\ncomment = \"#\"\n", ONE, MOVED]);
        alike(&map, &text("t,x,f", 1500, |_| ",".to_owned()), 1);
        alike(&map, &text("t,x,f,wheel of 5\"", 1500, |_| ",1".to_owned()), 1);
        let remarks = "# a remark\n".repeat(1000);
        alike(&map, &(text("t,x,f", 1500, |_| ",".to_owned()) + &remarks), 1);
        let old = text("t,x,f", 1500, |_| String::new()).replace('\n', "\r");
        alike(&trials_map(&[ONE, MOVED]), &old, 1);
    }

    #[test]
    fn a_last_row_with_a_cell_too_many_is_refused_wherever_blocks_end() {
        let map = trials_map(&[ONE, MOVED]);
        // Of some length the row is a block of its own.
        for rows in 400..520 {
            let content = text("t,x,f", rows, |_| String::new()) + "9999,1,1,1\n";
            let world = World::new();
            let errors = world.import_streamed(&map, &[world.file("a.csv", content)]).unwrap_err();
            assert!(errors[0].what.contains("cells"), "{errors:?}");
        }
    }

    #[test]
    fn a_long_text_that_is_there_already_is_refused() {
        let world = World::new();
        let map = trials_map(&[ONE, MOVED]);
        let file = world.file("a.csv", text("t,x,f", 800, |_| String::new()));
        world.import_streamed(&map, std::slice::from_ref(&file)).unwrap();
        let before = world.written();
        let other = map.replace("S01", "S02");
        let errors = world.import_streamed(&other, &[file]).unwrap_err();
        assert!(errors[0].what.contains("imported before"), "{errors:?}");
        assert_eq!(world.written(), before);
    }
}
