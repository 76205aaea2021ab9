//! A session of very many trials: no trial costs more than earlier ones.

use super::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// What was asked of a disk: files and names that were looked at, reads and their bytes, names in
/// folders that were listed, writes and their bytes.
type Counts = [AtomicU64; 6];

/// The same at a moment.
type Sums = [u64; 6];

/// A disk that counts what is asked of it.
fn counted(counts: &Arc<Counts>) -> Heard {
    let counts = Arc::clone(counts);
    Heard::new(move |request| {
        let more: Sums = match request {
            Request::Look | Request::Sync(_) => [1, 0, 0, 0, 0, 0],
            Request::Read(bytes) => [0, 1, bytes as u64, 0, 0, 0],
            Request::List(names) => [0, 0, 0, 1 + names as u64, 0, 0],
            Request::Write(_, bytes) | Request::Append(_, bytes) => {
                [0, 0, 0, 0, 1, bytes.len() as u64]
            }
        };
        for (count, n) in counts.iter().zip(more) {
            count.fetch_add(n, Ordering::Relaxed);
        }
        Ok(())
    })
}

/// Six conditions this often, and one trial for practice: 2,005 trials.
const REPEATS: usize = 334;

#[test]
fn the_last_of_two_thousand_trials_asks_no_more_of_the_disk_than_the_tenth() {
    let mut desk = Desk::new(false);
    let text = small("small", false)
        .replace("repeats = 1", &format!("repeats = {REPEATS}"))
        .replace("trial_limit_s = 4.0", "trial_limit_s = 0.1")
        .replace("pause_s = 5.0", "pause_s = 0.0");
    std::fs::write(desk.plan.layout.study_toml(), &text).unwrap();
    desk.plan.study = Study::from_toml(&text).unwrap();
    desk.plan.study_toml = text.into_bytes();
    let counts: Arc<Counts> = Arc::default();
    let files = counted(&counts);
    // What had been asked when so many trials were done.
    let mut sums: Vec<Sums> = Vec::new();
    let outcome = {
        let mut front = somebody(|view: &View| {
            if view.done == sums.len() {
                sums.push(counts.each_ref().map(|count| count.load(Ordering::Relaxed)));
            }
            None
        });
        desk.run(&mut Mock::default(), &files, &mut front).unwrap()
    };
    assert_eq!((outcome.done, outcome.total), (6 * REPEATS + 1, 6 * REPEATS + 1));
    let of_trial = |n: usize| -> Sums { std::array::from_fn(|i| sums[n][i] - sums[n - 1][i]) };
    let [looks, reads, read_bytes, listed, writes, written_bytes] = of_trial(10);
    let last = of_trial(outcome.done - 1);
    assert!(reads > 0 && writes > 0, "nothing was counted");
    assert_eq!([last[0], last[1], last[3], last[4]], [looks, reads, listed, writes]);
    // A number has three digits more, which stand in a handful of names and lines.
    const DIGITS: u64 = 200;
    assert!(last[2] < read_bytes + DIGITS, "{} bytes read, not {read_bytes}", last[2]);
    assert!(last[5] < written_bytes + DIGITS, "{} bytes written, not {written_bytes}", last[5]);
}
