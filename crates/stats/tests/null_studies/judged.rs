//! What tests said of many studies without an effect, and what they may have said.

use rayon::prelude::*;
use zwidth_stats::Tested;
use zwidth_stats::power::clopper_pearson;

/// The level of all tests, and of intervals.
pub(crate) const ALPHA: f64 = 0.05;
pub(crate) const LEVEL: f64 = 0.95;
/// A two-sided interval whose ends are one-sided bounds of 99.9 % each.
const BOUNDS: f64 = 0.998;
/// What an approximate test at 5 % may reject at most, by the upper bound.
pub(crate) const MOST: f64 = 0.06;

/// Said of one study: whether the test rejects (nothing of an interval alone), and whether its
/// interval holds the truth. What has no estimate claims nothing, and has no interval.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Said {
    pub(crate) rejects: Option<bool>,
    pub(crate) covers: Option<bool>,
}

impl Said {
    /// Of a p value; an exact one may lie on the level.
    pub(crate) fn by_p(p_value: Option<f64>) -> Self {
        Self { rejects: Some(p_value.is_some_and(|p| p <= ALPHA)), covers: None }
    }

    /// Of an estimate with an interval, where the truth is zero.
    pub(crate) fn by_estimate(tested: Option<Tested>) -> Self {
        Self::about(tested, 0.0)
    }

    /// Of the test of zero, and whether the interval holds the truth.
    pub(crate) fn about(tested: Option<Tested>, truth: f64) -> Self {
        Self {
            rejects: Some(tested.is_some_and(|t| t.p_value < ALPHA)),
            covers: tested.map(|t| t.ci_low <= truth && truth <= t.ci_high),
        }
    }
}

/// A count of so many.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Share {
    pub(crate) count: usize,
    pub(crate) of: usize,
}

impl Share {
    fn among(all: impl Iterator<Item = bool>) -> Self {
        let add =
            |share: Self, is: bool| Self { count: share.count + usize::from(is), of: share.of + 1 };
        all.fold(Self::default(), add)
    }

    pub(crate) fn estimate(self) -> f64 {
        self.count as f64 / self.of as f64
    }

    /// Its one-sided bounds of 99.9 % (Clopper & Pearson 1934).
    pub(crate) fn bounds(self) -> (f64, f64) {
        clopper_pearson(self.count, self.of, BOUNDS).unwrap()
    }

    /// Whether a test at 5 % rejects more than 6 % beyond doubt.
    pub(crate) fn is_too_many(self) -> bool {
        self.of > 0 && self.bounds().0 > MOST
    }

    /// As in a table: per cent, with its bounds.
    pub(crate) fn words(self) -> String {
        if self.of == 0 {
            return "–".to_owned();
        }
        let (low, high) = self.bounds();
        let text =
            format!("{:.1} ({:.1}–{:.1})", 100.0 * self.estimate(), 100.0 * low, 100.0 * high);
        text
    }
}

/// What may be asked of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Asked {
    /// Approximate: the upper bound of its false positives is at most this, and the share of its
    /// intervals that hold the truth lies between these.
    Approximate { most: f64, coverage: [f64; 2] },
    /// Exact: it rejects not significantly more than 5 %.
    Exact,
    /// Nothing: it is shown beside, to say what it would have done.
    Nothing,
}

/// What a test said of all studies of a kind.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    pub(crate) test: &'static str,
    pub(crate) asked: Asked,
    pub(crate) rejected: Share,
    pub(crate) covered: Share,
}

impl Judged {
    /// What breaks a promise, in words. Few studies (`is_whole` false) cannot show that a limit is
    /// kept: there none may be shown to be broken.
    pub(crate) fn broken(&self, is_whole: bool) -> Option<String> {
        let (low, high) = if self.rejected.of == 0 { (0.0, 0.0) } else { self.rejected.bounds() };
        let at_most = |most: f64| if is_whole { high <= most } else { low <= most };
        let within = |[least, most]: [f64; 2]| {
            if self.covered.of == 0 {
                return true;
            }
            let (low, high) = self.covered.bounds();
            let share = self.covered.estimate();
            if is_whole { least <= share && share <= most } else { least <= high && low <= most }
        };
        let holds = match self.asked {
            Asked::Approximate { most, coverage } => at_most(most) && within(coverage),
            Asked::Exact => low <= ALPHA,
            Asked::Nothing => true,
        };
        (!holds).then(|| {
            let (rejected, covered) = (self.rejected.words(), self.covered.words());
            format!("{} rejects {rejected} %, covers {covered} %", self.test)
        })
    }
}

/// Puts so many studies to some tests, each with its name and what is asked of it.
pub(crate) fn judge<const N: usize>(
    studies: usize,
    tests: [(&'static str, Asked); N],
    say: impl Fn(u64) -> [Said; N] + Sync + Send,
) -> Vec<Judged> {
    let said: Vec<[Said; N]> = (0..studies as u64).into_par_iter().map(say).collect();
    let judged = |(place, (test, asked)): (usize, (&'static str, Asked))| Judged {
        test,
        asked,
        rejected: Share::among(said.iter().filter_map(|said| said[place].rejects)),
        covered: Share::among(said.iter().filter_map(|said| said[place].covers)),
    };
    tests.into_iter().enumerate().map(judged).collect()
}
