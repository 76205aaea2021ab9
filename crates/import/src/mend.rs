//! Repairs times before they are converted: clocks are read, counters unwrapped, rows of equal time
//! joined.

use super::clock::{Clock, clock};
use super::counter::wrap_of;
use super::mapping::{Equal, Mend};
use super::plan::TimeColumn;
use super::recording::{Recording, Rows};
use super::table::Cells;
use arrow::array::Float64Array;
use zwidth_store::StoreError;

impl Mend {
    /// The repairs, in words.
    pub(super) fn words(self) -> Vec<String> {
        let counter = self.counts_at_hz.map(|rate_hz| {
            format!("t_s = the samples counted / {rate_hz} Hz, the first at 0: samples that the counter passes over are missing")
        });
        let wrap = self.wrap.map(|wrap| format!("t_s unwrapped where it starts over at {wrap}"));
        let equal = self.equal.map(|equal| match equal {
            Equal::Drop => "of rows of one time the first is kept".to_owned(),
            Equal::Mean => "rows of one time are their mean".to_owned(),
        });
        [counter, wrap, equal].into_iter().flatten().collect()
    }
}

impl Recording {
    /// Reads a column of times that is written as clocks are; before rows without a value are sought.
    ///
    /// # Errors
    /// No such column; a cell that is written otherwise than the first; another unit in the mapping.
    pub(super) fn read_clock(
        &mut self,
        time: TimeColumn,
        from_first: bool,
    ) -> Result<(), StoreError> {
        let column = self.find(time.from)?;
        let read = clock(&self.table.columns[column], &self.cells, from_first);
        let read = read.map_err(|row| {
            let cell = self.table.columns[column].cell(row);
            let what = format!("'{cell}' is not a time as the first row has it");
            let remedy = "mend the cell, or leave the row out with bad_lines";
            self.cell_error(column, row, &what, remedy)
        })?;
        let values = match read {
            None => return Ok(()),
            #[allow(clippy::float_cmp)] // the factor of a second
            // Clock texts become seconds, whatever the mapping says: another unit there is a mistake.
            Some(Clock::Seconds(_)) if time.unit.to_si != 1.0 => {
                let what =
                    "its cells are clock times or durations, which say their unit themselves";
                return Err(self
                    .error(what, "set unit = \"s\" in [time]")
                    .column(time.from.to_string()));
            }
            Some(Clock::Seconds(values) | Clock::LessTheFirst(values)) => values,
        };
        self.table.columns[column] = Cells::Numbers(values);
        Ok(())
    }

    /// What mends times that do not go on in one of these rows; nothing if they do, or if the row before is not
    /// there.
    pub(super) fn time_remedy(&self, column: usize, rows: &[usize], at: usize) -> Option<String> {
        let times = self.numbers(column, rows).ok()?;
        let [before, after] = [*times.get(at.checked_sub(1)?)?, *times.get(at)?];
        if after > before {
            return None;
        }
        Some(match wrap_of(&times) {
            Some(wrap) => format!("a counter that starts over? set wrap = {wrap} in [time]"),
            None if after < before => {
                "if another recording begins there, set backwards = \"split\" in [time]; if a counter starts over, wrap; else \
                 mend the recording"
                    .to_owned()
            }
            None => {
                "set equal = \"drop\" in [time] if rows come twice, or \"mean\"; or take the time from rate_hz or a counter"
                    .to_owned()
            }
        })
    }

    /// Mends the times of the rows that are kept; `labels` part them into trials, and `numeric` are the
    /// columns of which rows of one time have a mean.
    ///
    /// # Errors
    /// A cell of them that is no number.
    pub(super) fn mend(
        &mut self,
        time: TimeColumn,
        rows: &mut Rows,
        numeric: &[usize],
        labels: &[usize],
    ) -> Result<(), StoreError> {
        let Mend { wrap, equal, counts_at_hz } = time.mend;
        if wrap.is_none() && equal.is_none() {
            return Ok(());
        }
        let column = self.find(time.from)?;
        let height = self.table.columns[column].len();
        let mut times = self.numbers(column, &rows.kept)?;
        // Trial by trial: a time has nothing to do with that of the trial before.
        let mut ends = Vec::new();
        let mut begin = 0;
        for piece in self.pieces(&rows.kept, labels) {
            let end = begin + piece.len();
            if let Some(wrap) = wrap {
                unwrap_times(&mut times[begin..end], wrap, counts_at_hz.is_some());
            }
            ends.push(end);
            begin = end;
        }
        self.table.columns[column] = spread(&times, &rows.kept, height);
        let Some(equal) = equal else { return Ok(()) };
        #[allow(clippy::float_cmp)] // one and the same time, as it was written
        let goes_on = |i: usize| i > 0 && times[i] == times[i - 1] && !ends.contains(&i);
        if equal == Equal::Mean {
            for other in numeric.iter().filter(|other| **other != column) {
                let mut values = self.numbers(*other, &rows.kept)?;
                let mut from = 0;
                for to in 1..=values.len() {
                    if to == values.len() || !goes_on(to) {
                        values[from] = super::convert::mean(&values[from..to]);
                        from = to;
                    }
                }
                self.table.columns[*other] = spread(&values, &rows.kept, height);
            }
        }
        let mut kept = Vec::new();
        let mut joined = Vec::new();
        for (i, row) in rows.kept.iter().enumerate() {
            if goes_on(i) { joined.push(*row) } else { kept.push(*row) }
        }
        (rows.kept, rows.joined) = (kept, joined);
        Ok(())
    }
}

/// A column of `height` cells with these values in the rows that are kept, and none elsewhere.
fn spread(values: &[f64], kept: &[usize], height: usize) -> Cells {
    let mut cells = vec![None; height];
    kept.iter().zip(values).for_each(|(row, value)| cells[*row] = Some(*value));
    Cells::Numbers(Float64Array::from(cells))
}

/// Adds `wrap` as often as the time started over. A time may also run backwards, or begin again with
/// another trial, by less than half of that; a counter only counts on.
pub(super) fn unwrap_times(times: &mut [f64], wrap: f64, only_forward: bool) {
    let mut turns = 0.0;
    let mut before = times.first().copied().unwrap_or(0.0);
    for time in times {
        let fall = before - *time;
        before = *time;
        if fall > 0.0 && (only_forward || fall > wrap / 2.0) {
            turns += 1.0;
        }
        *time += turns * wrap;
    }
}

/// The same for an angle, which starts over at both ends: each value lies within half a turn of the one
/// before.
pub(super) fn unwrap_angle(values: &mut [f64], wrap: f64) {
    let mut before = values.first().copied().unwrap_or(0.0);
    let mut turns = 0.0;
    for value in values {
        turns -= ((*value - before) / wrap).round_ties_even();
        before = *value;
        *value += turns * wrap;
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::{ONE, World, close, column, trials_map};
    use super::*;
    use zwidth_store::{GAPS, Signal};

    #[test]
    #[allow(clippy::float_cmp)] // whole numbers
    fn an_angle_that_starts_over_at_either_end_goes_on() {
        let mut angle = [350.0, 10.0, 190.0, 359.0, 1.0, 179.0];
        unwrap_angle(&mut angle, 360.0);
        assert_eq!(angle, [350.0, 370.0, 550.0, 719.0, 721.0, 899.0]);
        let mut signed = [170.0, -170.0, -10.0, 179.0];
        unwrap_angle(&mut signed, 360.0);
        assert_eq!(signed, [170.0, 190.0, 350.0, 179.0]);
    }

    fn map(file: &str, time: &str) -> String {
        trials_map(&[file, ONE, "[time]\n", time, &column("force_ex_n", "f", "N")])
    }

    fn times(map: &str, text: &str) -> (World, Vec<f64>) {
        let world = World::new();
        world.import(map, &[world.file("a.csv", text)]).unwrap();
        let t = world.column(1, Signal::Time);
        (world, t)
    }

    #[test]
    fn times_that_do_not_go_on_are_refused_with_the_key_that_mends_them() {
        let map = map("", "from = \"t\"\nunit = \"us\"\nzero = \"first\"\n");
        let world = World::new();
        for (times, remedy) in [
            ("4294967200 4294967290 4 94", "set wrap = 4294967296 in [time]"),
            ("0 100 100 200", "set equal = \"drop\" in [time]"),
            ("0 100 200 0 100 200", "set backwards = \"split\" in [time]"),
        ] {
            let rows: String = times.split(' ').map(|t| format!("{t},1\n")).collect();
            let file = world.file("a.csv", format!("t,f\n{rows}"));
            world.refuses(&map, &file, remedy, None);
            let errors = world.import_streamed(&map, &[file]).unwrap_err();
            assert!(errors[0].remedy.contains(remedy), "{errors:?}");
        }
    }

    #[test]
    fn a_counter_of_microseconds_goes_on_where_it_starts_over() {
        let rows = "t,f\n4294967000,1\n4294967290,2\n296,3\n596,4\n";
        let time = "from = \"t\"\nunit = \"us\"\nzero = \"first\"\n";
        let (world, t) = times(&map("", &format!("{time}wrap = 4294967296\n")), rows);
        close(&t, &[0.0, 290e-6, 592e-6, 892e-6]);
        assert!(world.computed(1).contains("unwrapped where it starts over at 4294967296"));
        let signed = "t,f\n2147483000,1\n2147483600,2\n-2147483096,3\n";
        let (_, t) = times(&map("", &format!("{time}wrap = 4294967296\n")), signed);
        close(&t, &[0.0, 600e-6, 1200e-6]);
        let world = World::new();
        world.refuses(&map("", time), &world.file("a.csv", rows), "time runs backwards", None);
    }

    #[test]
    fn samples_that_a_counter_passes_over_are_missing() {
        let text = "n,f\n14,1\n15,2\n0,3\n1,4\n5,5\n4,6\n";
        let time = "rate_hz = 100.0\ncounter = \"n\"\nwrap = 16\n";
        let (_, t) = times(&map("", time), text);
        close(&t, &[0.0, 0.01, 0.02, 0.03, 0.07, 0.22]);
    }

    #[test]
    fn rows_of_one_time_are_joined_as_the_mapping_says() {
        let text = "t,f\n0,1\n0,2\n0.5,4\n1,5\n1,6\n1,10\n";
        let time = "from = \"t\"\nunit = \"s\"\n";
        for (word, forces) in [("drop", [1.0, 4.0, 5.0]), ("mean", [1.5, 4.0, 7.0])] {
            let (world, t) = times(&map("", &format!("{time}equal = \"{word}\"\n")), text);
            assert_eq!(t, [0.0, 0.5, 1.0]);
            assert_eq!(world.column(1, Signal::ForceEx), forces);
            assert!(!world.trial("P01", "S01", 1).file.contains_key(GAPS));
        }
    }

    #[test]
    fn a_time_that_runs_backwards_begins_another_trial_where_the_mapping_says_so() {
        let split = map("", "from = \"t\"\nunit = \"s\"\nbackwards = \"split\"\n");
        let world = World::new();
        let file = world.file("a.csv", "t,f\n0,1\n1,2\n0.5,3\n1,4\n");
        let refuse = split.replace("split", "refuse");
        world.refuses(&refuse, &file, "time runs backwards", Some(("t", 3)));
        assert_eq!(world.import(&split, &[file]).unwrap().trials, 2);
    }

    #[test]
    fn clocks_and_durations_are_seconds_and_a_cell_that_is_neither_is_refused() {
        let rows = |[a, b, c]: [&str; 3]| format!("t,f\n{a},1\n{b},2\n{c},3\n");
        let time = "from = \"t\"\nunit = \"s\"\nzero = \"first\"\n";
        for times_as_written in [
            ["10:00:00.000", "10:00:00.040", "10:00:01.000"],
            ["0 days 00:00:00", "0 days 00:00:00.04", "0 days 00:00:01"],
            ["0 sec", "0.04 sec", "1 sec"],
            ["2026-01-31 23:59:59.5", "2026-01-31 23:59:59.54", "2026-02-01 00:00:00.5"],
        ] {
            let (_, t) = times(&map("", time), &rows(times_as_written));
            close(&t, &[0.0, 0.04, 1.0]);
        }
        let world = World::new();
        let file = world.file("b.csv", rows(["0 sec", "soon", "1 sec"]));
        let words = "'soon' is not a time as the first row has it";
        world.refuses(&map("", time), &file, words, Some(("t", 2)));
    }

    #[test]
    fn nanoseconds_since_1970_lose_none() {
        let text = "t,f\n1785300000000000001,1\n1785300000000000002,2\n1785300000001000003,3\n";
        let time = "from = \"t\"\nunit = \"ns\"\nzero = \"first\"\n";
        let (_, t) = times(&map("", time), text);
        assert_eq!(t, [0.0, 1e-9, 1_000_002e-9]);
    }
}
