//! How often the studies were right, and whether that is as often as they claim.

use super::people::{CONTRASTS, PARTICIPANTS, People, THESIS, Truth, What};
use super::studies::{ALPHA, Found, LEVEL, Said};
use anyhow::{Context as _, ensure};
use zwidth_stats::power::{
    DifferenceSearch, HALVINGS, Plan, PlannedTest, Simulation, clopper_pearson, power,
    smallest_difference,
};
use zwidth_stats::student_t::two_sided_p;

/// Level of the intervals that the page shows.
const SHOWN: f64 = 0.95;
/// Level at which a share is wrong. Some of two dozen intervals of 95 % miss what they are to hold;
/// one of these does so once in forty runs.
const WRONG: f64 = 0.999;
/// Level of the interval of observed power that holds what was predicted.
const OF_POWER: f64 = 0.99;
/// The power that a difference is planned with, and in how many studies it is simulated.
const TARGET: f64 = 0.8;
const SIMULATED: usize = 10_000;
/// What `zwidth power` tests at: alpha shared by the two default contrasts.
const ALPHA_OF_POWER: f64 = ALPHA / 2.0;

/// Prints what came out and fails where it is not what it must be.
pub(crate) fn tell(people: &People, found: &Found) -> anyhow::Result<()> {
    let mut wrong = Vec::new();
    coverage(people, found, &mut wrong)?;
    nothing(people, found, &mut wrong)?;
    planned(people, found)?;
    ensure!(wrong.is_empty(), "{}", wrong.join("\n"));
    Ok(())
}

/// The share of intervals that hold the truth. The t decides; the mixed model stands beside it, as
/// in a study: it pools the modes' variances, and where people differ more in one mode than in
/// another its intervals are too short for one contrast and too long for another.
fn coverage(people: &People, found: &Found, wrong: &mut Vec<String>) -> anyhow::Result<()> {
    println!(
        "Intervals of {:.0} % that hold the truth, of 100 (95 % interval of Clopper and Pearson):\n",
        100.0 * LEVEL
    );
    println!("| difference | truth | its std error | t | mixed model, Kenward–Roger |");
    println!("|---|---|---|---|---|");
    for what in people.compared().into_iter().filter(|what| !what.is_null()) {
        let said = of(&found.both, what)?;
        let truth = people.truth(what, false)?;
        let holds = |[low, high]: [f64; 2]| low <= truth.mean && truth.mean <= high;
        let plain = Share::of(said.iter().map(|said| holds(said.interval)));
        let model = Share::of(said.iter().filter_map(|said| Some(holds(said.model?.0))));
        let Truth { mean, std_error, .. } = truth;
        println!("| {} | {mean:.4} | {std_error:.4} | {plain} | {model} |", what.words());
        let (low, high) = plain.interval(WRONG)?;
        if low > LEVEL || high < LEVEL {
            wrong.push(format!("{}: {plain} of 100 intervals hold the truth", what.words()));
        }
    }
    Ok(())
}

/// The share of studies that find a difference between a mode and its copy, which was moved to the
/// mode's own mean.
fn nothing(people: &People, found: &Found, wrong: &mut Vec<String>) -> anyhow::Result<()> {
    println!("\nStudies that claim a difference between a mode and its copy at {ALPHA}, of 100:\n");
    println!(
        "| difference | as simulated, its std errors | t | mixed model | sign flips | signed ranks |"
    );
    println!("|---|---|---|---|---|---|");
    for what in people.compared().into_iter().filter(|what| what.is_null()) {
        let said = of(&found.both, what)?;
        let copied = people.copied[&what];
        let below = |p: &dyn Fn(&Said) -> Option<f64>| {
            Share::of(said.iter().filter_map(|said| Some(p(said)? < ALPHA)))
        };
        let shares = [
            below(&|said| Some(said.p_value)),
            below(&|said| Some(said.model?.1)),
            below(&|said| Some(said.p_exact[0])),
            below(&|said| Some(said.p_exact[1])),
        ];
        let [t, model, flips, ranks] = shares;
        let off = copied.mean / copied.std_error;
        println!("| {} | {off:.1} | {t} | {model} | {flips} | {ranks} |", what.words());
        for share in shares {
            if share.interval(WRONG)?.0 > ALPHA {
                wrong.push(format!(
                    "{}: {share} of 100 studies claim what is not there",
                    what.words()
                ));
            }
        }
    }
    Ok(())
}

/// Power predicted from the spread of people in the two modes (beside it, from that of all modes),
/// and the share of studies that find such a difference: one session, as it is planned. Everybody's
/// difference is moved by the same, so that the mean is the one planned and the people differ as
/// they do. Shown and not judged: a plan draws normal people, and these are not (`soak null` judges
/// power where they are).
fn planned(people: &People, found: &Found) -> anyhow::Result<()> {
    println!("\nPower of {PARTICIPANTS} participants in one session, of 100 (99 % interval):\n");
    println!(
        "| difference | SD of people's differences | difference planned | predicted | observed |"
    );
    println!("|---|---|---|---|---|");
    for what in people.compared().into_iter().filter(|what| !what.is_null()) {
        let said = of(&found.first, what)?;
        let truth = people.truth(what, true)?;
        let simulation = Simulation {
            test: PlannedTest::PairedT,
            alpha: ALPHA_OF_POWER,
            studies: SIMULATED,
            seed: 1,
        };
        let of_two = people.plan(what, &CONTRASTS[what.contrast])?;
        let of_all = people.plan(what, &THESIS)?;
        let search = DifferenceSearch {
            target: TARGET,
            start: of_two.difference_std_error(),
            halvings: HALVINGS,
            participants: of_two.participants * SIMULATED,
        };
        let at = |difference| power(&Plan { difference, ..of_two }, &simulation);
        let difference = smallest_difference(&search, &at, &|_| {})?
            .context("no difference is found with that power")?;
        let predicted = power(&Plan { difference, ..of_two }, &simulation)?.estimate;
        let by_all = power(&Plan { difference, ..of_all }, &simulation)?.estimate;
        let claims = |said: &Said| -> anyhow::Result<bool> {
            let moved = said.estimate - truth.mean + difference;
            Ok(two_sided_p(moved / said.std_error, said.df)? < ALPHA_OF_POWER)
        };
        let claims: Vec<bool> = said.iter().map(claims).collect::<anyhow::Result<_>>()?;
        let observed = Share::of(claims.into_iter());
        let (low, high) = observed.interval(OF_POWER)?;
        println!(
            "| {} | {:.4} | {difference:.4} | {:.1} | {:.1} | {:.1} ({:.1} to {:.1}) |",
            what.words(),
            truth.sd,
            100.0 * predicted,
            100.0 * by_all,
            100.0 * observed.share(),
            100.0 * low,
            100.0 * high,
        );
    }
    Ok(())
}

fn of(found: &std::collections::BTreeMap<What, Vec<Said>>, what: What) -> anyhow::Result<&[Said]> {
    Ok(found.get(&what).with_context(|| format!("{}: no study has it", what.words()))?)
}

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Share {
    count: usize,
    n: usize,
}

impl Share {
    fn of(all: impl Iterator<Item = bool>) -> Self {
        all.fold(Share { count: 0, n: 0 }, |Share { count, n }, is| Share {
            count: count + usize::from(is),
            n: n + 1,
        })
    }

    fn share(self) -> f64 {
        self.count as f64 / self.n as f64
    }

    fn interval(self, level: f64) -> anyhow::Result<(f64, f64)> {
        Ok(clopper_pearson(self.count, self.n, level)?)
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (low, high) = self.interval(SHOWN).map_err(|_| std::fmt::Error)?;
        write!(f, "{:.1} ({:.1} to {:.1})", 100.0 * self.share(), 100.0 * low, 100.0 * high)
    }
}
