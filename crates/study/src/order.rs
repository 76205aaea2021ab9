//! The order of a session's trials.
//!
//! Blocks of one environment follow each other; within a block every mode occurs `repeats` times.
//! Which environment comes first, and by which rows of a Williams square the modes follow each
//! other, is counterbalanced over participants: with one seed for the study, participants with
//! consecutive numbers get the rows in turn.
//!
//! Williams, E. J. (1949), Experimental designs balanced for the estimation of residual effects of
//! treatments, Aust. J. Sci. Res. A 2:149–168.
//!
//! Random numbers are those of the ChaCha8 cipher keyed with the seed: one seed gives one order, on
//! any machine.

use crate::random::{Stream, below, shuffle, stream};
use crate::{AskedPair, Kind, OrderScheme, PlannedTrial, Scene, Study, TaskPlace, task_order};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;

/// How often a mode may come in a row in a constrained order.
const IN_A_ROW: usize = 2;

/// The sequences of Williams squares for `n` conditions, each a permutation of 0…n − 1: n of them
/// for an even n, 2n for an odd one. Each condition is equally often in each position, and each
/// follows each other equally often.
///
/// The first row is 0, 1, n − 1, 2, n − 2, …; the next adds 1 (mod n) to each entry; an odd n also
/// takes the mirror image of each row (Williams 1949).
pub fn williams(n: usize) -> Vec<Vec<usize>> {
    // Entry `i` of the first row: n, which is 0 (mod n), then 1, n − 1, 2, n − 2, ….
    let first = (0..n).map(|i| if i % 2 == 1 { i.div_ceil(2) } else { n - i / 2 });
    let mut rows: Vec<Vec<usize>> =
        (0..n).map(|add| first.clone().map(|entry| (entry + add) % n).collect()).collect();
    if n % 2 == 1 && n > 1 {
        let mirrored: Vec<_> = rows.iter().map(|row| row.iter().rev().copied().collect()).collect();
        rows.extend(mirrored);
    }
    rows
}

/// Everything that determines the order of a session besides the seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rules {
    /// How the order of the modes within a block is drawn.
    pub scheme: OrderScheme,
    /// How often each mode comes in a block.
    pub repeats: u32,
    /// Number of environments.
    pub environments: usize,
    /// Number of modes.
    pub modes: usize,
    /// The participant's number in the counterbalancing; it may start anywhere.
    pub participant_number: u32,
    /// The session's number in the counterbalancing; it may start anywhere.
    pub session_number: u32,
}

/// An order as it was drawn. Environments and modes are numbered from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    /// The modes' order in familiarisation.
    pub practice: Vec<usize>,
    /// The blocks, in order.
    pub blocks: Vec<Block>,
}

/// The trials of one environment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Which environment.
    pub environment: usize,
    /// The mode of each trial.
    pub modes: Vec<usize>,
}

impl Rules {
    /// Those of a session of `study`.
    pub fn of(study: &Study, participant_number: u32, session_number: u32) -> Rules {
        Rules {
            scheme: study.design.order,
            repeats: study.design.repeats,
            environments: study.environments.len(),
            modes: study.modes.len(),
            participant_number,
            session_number,
        }
    }

    /// Rules that, if they are equal, draw the same modes in each environment, whatever the seed:
    /// participants whose rows of a Williams square begin alike share one number. (The environments
    /// may still follow each other differently, and each participant has its own practice.)
    pub fn shared(&self) -> Rules {
        let participant_number = match self.scheme {
            OrderScheme::Williams => {
                let rows = u32::try_from(williams(self.modes).len()).unwrap_or(u32::MAX);
                self.participant_number % rows.max(1)
            }
            OrderScheme::Constrained => self.participant_number,
        };
        Rules { participant_number, ..*self }
    }

    /// Number of trials in a block.
    pub fn trials_per_block(&self) -> usize {
        self.modes * self.repeats as usize
    }
}

/// Draws a session: familiarisation first, then one block of trials per environment
/// ([`draw_modes`]). An environment of tasks has their presentations in place of repeats, task by task in the order of the
/// file.
///
/// Familiarisation takes environments in the order of the blocks and all modes in turn, so that few
/// trials cover every environment and every mode, and environments × modes of them cover every
/// condition.
///
/// `seed` belongs to the study: participants are balanced against each other only under one seed.
/// Numbers may start anywhere.
pub fn draw(
    study: &Study,
    participant_number: u32,
    session_number: u32,
    seed: u64,
) -> Vec<PlannedTrial> {
    let drawn = draw_modes(&Rules::of(study, participant_number, session_number), seed);
    let own = u64::from(participant_number) << u32::BITS | u64::from(session_number);
    let mut rng = stream(seed, Stream::Tasks, own);
    let mut plan = familiarisation(&drawn, study.design.familiarisation);
    for Block { environment, modes } in drawn.blocks {
        let place = |mode, task| Place { kind: Kind::Trial, environment, mode, task };
        let mut tasks = study.tasks_in(&study.environments[environment].id).peekable();
        if tasks.peek().is_none() {
            plan.extend(modes.into_iter().map(|mode| place(mode, None)));
        }
        for task in tasks {
            let trials = task_order::draw(task, study.modes.len(), &mut rng);
            plan.extend(trials.into_iter().map(|(mode, own)| place(mode, Some(own))));
        }
    }
    numbered(study, plan)
}

/// A trial before it has a number.
struct Place {
    kind: Kind,
    /// By its number, from 0.
    environment: usize,
    /// By its number, from 0.
    mode: usize,
    task: Option<TaskPlace>,
}

/// Draws the modes of each environment's trials.
///
/// The order of the environments is a row of their Williams square, by participant and session
/// number in turn. In a Williams block each repeat is one row of the modes' square: over as many
/// participants as it has rows, every repeat of every environment sees each row once. In a
/// constrained block the trials are drawn one by one, in proportion to what remains, with no mode
/// more than twice in a row (a study of one mode has no choice).
pub fn draw_modes(rules: &Rules, seed: u64) -> Order {
    let Rules { scheme, repeats, environments, modes, participant_number, session_number } = *rules;
    let person = participant_number as usize;
    // What is drawn after what decides the order: a seed must give the same one for ever.
    let mut shared = stream(seed, Stream::Study, 0);
    let places = squares(&mut shared, environments);
    let turn = (person + session_number as usize) % places.len().max(1);
    let mut of_session = stream(seed, Stream::Session, session_number.into());
    let rows: Vec<_> = (0..environments).map(|_| squares(&mut of_session, modes)).collect();
    // Side by side in one number, so that no two persons or sessions share a stream.
    let own = u64::from(participant_number) << u32::BITS | u64::from(session_number);
    let mut own = stream(seed, Stream::Person, own);
    let mut practice: Vec<usize> = (0..modes).collect();
    shuffle(&mut own, &mut practice);
    let in_turn = places.get(turn).into_iter().flatten().copied();
    let blocks = in_turn.map(|environment| Block {
        environment,
        modes: match scheme {
            OrderScheme::Williams => {
                let rows = &rows[environment];
                // Each repeat is one row, and the participant says where to begin. Without modes there
                // are no rows, and no remainder by their number.
                let turns =
                    (0..repeats as usize).map(|repeat| (person + repeat) % rows.len().max(1));
                turns.filter_map(|turn| rows.get(turn)).flatten().copied().collect()
            }
            OrderScheme::Constrained => constrained(&mut own, modes, repeats as usize),
        },
    });
    Order { practice, blocks: blocks.collect() }
}

/// Whether [`draw_modes`] can draw these modes of an environment's trials, by some seed.
pub fn can_draw(rules: &Rules, modes: &[usize]) -> bool {
    let mut counts = (0..rules.modes).map(|mode| modes.iter().filter(|m| **m == mode).count());
    let is_whole = modes.len() == rules.trials_per_block()
        && counts.all(|count| count == rules.repeats as usize);
    let is_free_of_runs =
        || rules.modes == 1 || !modes.windows(IN_A_ROW + 1).any(|w| w.iter().all(|m| *m == w[0]));
    is_whole
        && match rules.scheme {
            OrderScheme::Williams => are_rows(rules.modes, modes),
            OrderScheme::Constrained => is_free_of_runs(),
        }
}

/// Whether these modes are rows of one Williams square, all rows in turn. The first row may be any
/// of the square's, whose conditions are named accordingly.
fn are_rows(n: usize, modes: &[usize]) -> bool {
    let square = williams(n);
    let rows: Vec<&[usize]> = modes.chunks(n.max(1)).collect();
    let Some(first) = rows.first() else { return true };
    let in_turn = (0..rows.len())
        .all(|i| (0..i).all(|j| (rows[i] == rows[j]) == ((i - j).is_multiple_of(square.len()))));
    let mut firsts = square.iter();
    in_turn
        && firsts.any(|as_first| {
            let named: Vec<_> = square.iter().map(|row| renamed(row, as_first, first)).collect();
            rows.iter().all(|row| named.iter().any(|other| other == row))
        })
}

/// A row of the square where the conditions of its row `as_first` are called as in `first`.
fn renamed(row: &[usize], as_first: &[usize], first: &[usize]) -> Vec<usize> {
    let places =
        row.iter().map(|entry| as_first.iter().position(|e| e == entry).unwrap_or_default());
    places.map(|place| first[place]).collect()
}

/// Which of `levels` chance gives the participant of a number, and the block of the drawing: of every 2 × `levels` of
/// them, counted from 1, two get each, in an order that is drawn for the block. `of` tells what is drawn.
pub(crate) fn in_block(
    of: &str,
    participant_number: u32,
    levels: usize,
    seed: u64,
) -> (u32, usize) {
    // Number 0 stands alone at the end.
    let place = participant_number.wrapping_sub(1) as usize;
    let mut block: Vec<usize> = (0..2 * levels).map(|i| i % levels).collect();
    let number = place / block.len();
    // Two columns are drawn apart from each other: FNV-1a of the name, from the seed on.
    let seed = of
        .bytes()
        .fold(seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    shuffle(&mut stream(seed, Stream::Groups, number as u64), &mut block);
    (u32::try_from(number).unwrap_or(u32::MAX), block[place % block.len()])
}

/// The order in which a session asks for the pairs of its scores, and which of the two stands first: both at random, each
/// score's pairs together.
pub fn draw_pairs(
    study: &Study,
    participant_number: u32,
    session_number: u32,
    seed: u64,
) -> Vec<AskedPair> {
    let own = u64::from(participant_number) << u32::BITS | u64::from(session_number);
    let mut rng = stream(seed, Stream::Pairs, own);
    let mut all = Vec::new();
    for score in study.scores.iter().filter(|score| score.pairs.is_some()) {
        let mut questions = score.weighing();
        shuffle(&mut rng, &mut questions);
        for question in questions {
            all.push(AskedPair { question, is_turned: below(&mut rng, 2) == 1 });
        }
    }
    all
}

/// Practice trials, with modes in an order of the participant's own.
fn familiarisation(order: &Order, trials: u32) -> Vec<Place> {
    let blocks = &order.blocks;
    let modes = &order.practice;
    // Both indices run in step until they meet again at their least common multiple; then the modes
    // shift by one.
    let period = blocks.len() * modes.len() / gcd(blocks.len(), modes.len());
    let pairs = (0..trials as usize)
        .map(|i| (&blocks[i % blocks.len()], modes[(i + i / period) % modes.len()]));
    let kind = Kind::Familiarisation;
    pairs
        .map(|(block, mode)| Place { kind, environment: block.environment, mode, task: None })
        .collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The rows of a Williams square in random order, with its conditions in random order.
fn squares(rng: &mut ChaCha8Rng, n: usize) -> Vec<Vec<usize>> {
    let mut labels: Vec<usize> = (0..n).collect();
    shuffle(rng, &mut labels);
    let mut rows = williams(n);
    rows.iter_mut().flatten().for_each(|entry| *entry = labels[*entry]);
    shuffle(rng, &mut rows);
    rows
}

/// Each mode `repeats` times, none more than [`IN_A_ROW`] times in a row.
fn constrained(rng: &mut ChaCha8Rng, modes: usize, repeats: usize) -> Vec<usize> {
    let mut left = vec![repeats; modes];
    let mut order: Vec<usize> = Vec::new();
    for _ in 0..modes * repeats {
        let weights: Vec<usize> = (0..modes)
            .map(|mode| match left[mode] {
                n if n > 0 && (modes == 1 || can_follow(&order, &left, mode)) => n,
                _ => 0,
            })
            .collect();
        let mut place = below(rng, weights.iter().sum());
        let chosen = weights.iter().position(|w| {
            let here = place < *w;
            place = place.saturating_sub(*w);
            here
        });
        let mode = chosen.unwrap_or(0);
        left[mode] -= 1;
        order.push(mode);
    }
    order
}

/// Whether `mode` may come next, and the rest can then still be placed: the remaining trials of
/// each mode fit into the gaps between all others.
fn can_follow(order: &[usize], left: &[usize], mode: usize) -> bool {
    let run = 1 + order.iter().rev().take_while(|m| **m == mode).count();
    // Less the one that is placed: only a mode with trials left is asked for.
    let total = left.iter().sum::<usize>() - 1;
    run <= IN_A_ROW
        && left.iter().enumerate().all(|(m, left)| {
            let remaining = left - usize::from(m == mode);
            let gaps = total - remaining;
            // The mode itself has only what its run leaves before the first gap.
            let here = if m == mode { IN_A_ROW.saturating_sub(run) } else { IN_A_ROW };
            remaining <= here + IN_A_ROW * gaps
        })
}

/// Trials with their numbers and repeats.
fn numbered(study: &Study, plan: Vec<Place>) -> Vec<PlannedTrial> {
    let mut repeats: BTreeMap<_, u32> = BTreeMap::new();
    let trials = (1..).zip(plan).map(|(trial, place)| {
        let Place { kind, environment, mode, task } = place;
        let repeat = repeats.entry((kind, environment, mode)).or_default();
        *repeat += 1;
        let environment = &study.environments[environment];
        PlannedTrial {
            trial,
            repeat: *repeat,
            kind,
            environment: environment.id.clone(),
            mode: study.modes[mode].id.clone(),
            samples: environment.scene != Scene::None,
            task,
        }
    });
    trials.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::demo;

    fn study(scheme: OrderScheme, modes: usize, repeats: u32) -> Study {
        let mut study = demo();
        let mode = |i: usize| crate::Mode {
            id: format!("m{i}").parse().unwrap(),
            ..study.modes[0].clone()
        };
        study.modes = (0..modes).map(mode).collect();
        study.design.order = scheme;
        study.design.repeats = repeats;
        study
    }

    /// The modes of the experiment's trials in one environment, by number.
    fn modes_in(study: &Study, trials: &[PlannedTrial], environment: usize) -> Vec<usize> {
        let id = &study.environments[environment].id;
        let of = trials.iter().filter(|t| t.kind == Kind::Trial && t.environment == *id);
        of.map(|t| study.modes.iter().position(|m| m.id == t.mode).unwrap()).collect()
    }

    #[test]
    fn each_condition_stands_in_each_position_and_follows_each_other_equally_often() {
        for n in 2..=8 {
            let rows = williams(n);
            let each = if n % 2 == 0 { 1 } else { 2 };
            assert_eq!(rows.len(), each * n);
            for condition in 0..n {
                for position in 0..n {
                    let here = rows.iter().filter(|r| r[position] == condition).count();
                    assert_eq!(here, each, "{n}");
                }
                for next in (0..n).filter(|next| *next != condition) {
                    let pairs =
                        rows.iter().flat_map(|r| r.windows(2)).filter(|w| **w == [condition, next]);
                    assert_eq!(pairs.count(), each, "{n}: {condition} before {next}");
                }
            }
        }
    }

    #[test]
    fn pairs_come_in_an_order_of_each_sessions_own_and_either_of_the_two_stands_first() {
        let study = crate::tests::with_pairs("pairs = \"Which?\"");
        let ids = study.scores[0].weighing();
        let drawn = |person, session| draw_pairs(&study, person, session, 7);
        assert_eq!(drawn(1, 1), drawn(1, 1));
        assert_ne!(drawn(1, 1), drawn(1, 2));
        let (mut turned, mut first) = (0, std::collections::BTreeSet::new());
        for person in 1..=200 {
            let pairs = drawn(person, 1);
            let mut asked: Vec<_> = pairs.iter().map(|pair| pair.question.clone()).collect();
            first.insert(asked[0].clone());
            turned += pairs.iter().filter(|pair| pair.is_turned).count();
            asked.sort();
            let mut all = ids.clone();
            all.sort();
            assert_eq!(asked, all);
        }
        // Half of 3000, within 5 standard deviations of √(3000 / 4) = 27; each of 15 is first in 1 of 15.
        assert!((1363..=1637).contains(&turned), "{turned}");
        assert_eq!(first.len(), 15);
        assert_eq!(draw_pairs(&demo(), 1, 1, 7), []);
    }

    #[test]
    fn the_square_of_four_is_williamss() {
        assert_eq!(williams(4), [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]);
        assert_eq!(williams(1), [[0]]);
    }

    #[test]
    fn the_thesis_session_has_three_to_practise_and_each_condition_six_times_in_blocks() {
        let study = study(OrderScheme::Williams, 3, 6);
        let trials = draw(&study, 1, 1, 1);
        assert_eq!(trials.len(), 3 + 36);
        assert!(trials.iter().zip(1..).all(|(t, n)| t.trial == n && t.samples));
        let practice = trials.iter().take_while(|t| t.kind == Kind::Familiarisation).count();
        assert_eq!(practice, 3);
        let block = |from: usize| {
            trials[from..from + 18].iter().all(|t| t.environment == trials[from].environment)
        };
        assert!(block(3) && block(21) && trials[3].environment != trials[21].environment);
        for condition in study.conditions() {
            let of = trials
                .iter()
                .filter(|t| t.environment == condition.environment && t.mode == condition.mode);
            let repeats: Vec<u32> =
                of.filter(|t| t.kind == Kind::Trial).map(|t| t.repeat).collect();
            assert_eq!(repeats, [1, 2, 3, 4, 5, 6]);
        }
    }

    /// As many participants as the square has rows: each repeat of each environment sees each row
    /// once, and as many begin with one environment as with the other.
    #[test]
    fn participants_are_balanced_against_each_other() {
        for modes in [2, 3, 4, 5] {
            let study = study(OrderScheme::Williams, modes, 3);
            let rows = williams(modes).len() as u32;
            for session in [1, 2] {
                let all: Vec<_> = (1..=rows).map(|p| draw(&study, p, session, 11)).collect();
                for environment in [0, 1] {
                    for repeat in 0..3 {
                        let row = |t: &Vec<PlannedTrial>| {
                            modes_in(&study, t, environment)[modes * repeat..][..modes].to_vec()
                        };
                        let mut found: Vec<_> = all.iter().map(row).collect();
                        found.sort();
                        found.dedup();
                        assert_eq!(found.len(), rows as usize, "{modes} modes");
                    }
                }
                let first = |t: &&Vec<PlannedTrial>| t[3].environment == study.environments[0].id;
                assert_eq!(all.iter().filter(first).count(), rows as usize / 2);
            }
        }
    }

    #[test]
    fn a_constrained_order_has_each_mode_as_often_and_none_thrice_in_a_row() {
        for modes in 1..=5 {
            for repeats in [1, 2, 6, 25] {
                let study = study(OrderScheme::Constrained, modes, repeats);
                for seed in 0..20 {
                    let order = modes_in(&study, &draw(&study, 1, 1, seed), 0);
                    for mode in 0..modes {
                        assert_eq!(order.iter().filter(|m| **m == mode).count(), repeats as usize);
                    }
                    let thrice = order.windows(3).any(|w| w[0] == w[1] && w[1] == w[2]);
                    assert!(!thrice || modes == 1, "{order:?}");
                }
            }
        }
    }

    #[test]
    fn constrained_orders_begin_with_each_mode_and_pair_them_about_equally_often() {
        let study = study(OrderScheme::Constrained, 3, 6);
        let orders: Vec<_> =
            (0..600).map(|p| modes_in(&study, &draw(&study, p, 1, 5), 0)).collect();
        for mode in 0..3 {
            let first = orders.iter().filter(|o| o[0] == mode).count();
            assert!((150..250).contains(&first), "{first} of 600 begin with {mode}");
        }
        let alike = orders.iter().filter(|o| o[0] == o[1]).count();
        assert!((60..240).contains(&alike), "{alike} of 600 begin with a pair");
    }

    #[test]
    fn familiarisation_covers_environments_modes_and_in_the_end_every_condition() {
        for modes in 1..=4 {
            let mut study = study(OrderScheme::Williams, modes, 1);
            study.design.familiarisation = 2 * modes as u32;
            let trials = draw(&study, 3, 1, 2);
            let practice: Vec<_> =
                trials.iter().filter(|t| t.kind == Kind::Familiarisation).collect();
            let few = &practice[..modes.max(2)];
            assert!(study.environments.iter().all(|e| few.iter().any(|t| t.environment == e.id)));
            assert!(study.modes.iter().all(|m| few.iter().any(|t| t.mode == m.id)), "{modes}");
            let covers = |c: &crate::Condition| {
                practice
                    .iter()
                    .any(|t| t.environment == c.environment && t.mode == c.mode && t.repeat == 1)
            };
            assert!(study.conditions().iter().all(covers), "{modes} modes");
        }
    }

    #[test]
    fn another_seed_participant_or_session_gives_another_order() {
        for scheme in [OrderScheme::Williams, OrderScheme::Constrained] {
            let study = study(scheme, 3, 6);
            assert_ne!(draw(&study, 1, 1, 1), draw(&study, 1, 1, 2));
            assert_ne!(draw(&study, 1, 1, 1), draw(&study, 2, 1, 1));
            assert_ne!(draw(&study, 1, 1, 1), draw(&study, 1, 2, 1));
        }
    }

    /// A session is resumed with the order it was drawn with: this fails if a new version of
    /// anything changes it. The numbers come from the same rules written in Python on a
    /// separate ChaCha8.
    #[test]
    fn the_order_of_a_seed_is_fixed() {
        for (scheme, expect) in [
            (OrderScheme::Williams, [[2, 0, 1, 1, 0, 2], [0, 1, 2, 1, 0, 2]]),
            (OrderScheme::Constrained, [[2, 2, 1, 0, 1, 0], [0, 2, 1, 1, 0, 2]]),
        ] {
            let study = study(scheme, 3, 2);
            let drawn = draw(&study, 1, 1, 1);
            assert_eq!([0, 1].map(|e| modes_in(&study, &drawn, e)), expect);
        }
    }

    #[test]
    fn participants_with_shared_rules_get_the_same_modes_and_others_do_not() {
        for scheme in [OrderScheme::Williams, OrderScheme::Constrained] {
            for (modes, rows) in [(2, 2), (3, 6), (4, 4)] {
                let study = study(scheme, modes, 6);
                let of = |rules: &Rules, seed| {
                    let blocks = draw_modes(rules, seed).blocks;
                    blocks.into_iter().map(|b| (b.environment, b.modes)).collect::<BTreeMap<_, _>>()
                };
                let rules_of: Vec<Rules> = (0..13).map(|p| Rules::of(&study, p, 2)).collect();
                for (a, b) in rules_of.iter().flat_map(|a| rules_of.iter().map(move |b| (a, b))) {
                    let alike = (0..20).all(|seed| of(a, seed) == of(b, seed));
                    assert_eq!(a.shared() == b.shared(), alike, "{a:?} {b:?}");
                }
                let mut numbers: Vec<u32> =
                    rules_of.iter().map(|rules| rules.shared().participant_number).collect();
                numbers.sort();
                numbers.dedup();
                assert_eq!(numbers.len(), if scheme == OrderScheme::Williams { rows } else { 13 });
            }
        }
    }

    /// Every order drawn can be drawn, and what the scheme rules out cannot.
    #[test]
    fn an_order_that_was_drawn_is_one_that_can_be_drawn() {
        for (scheme, modes, repeats) in
            [OrderScheme::Williams, OrderScheme::Constrained].into_iter().flat_map(|scheme| {
                [(scheme, 1, 3), (scheme, 2, 5), (scheme, 3, 6), (scheme, 3, 8), (scheme, 4, 6)]
            })
        {
            let study = study(scheme, modes, repeats);
            for number in 0..50 {
                let rules = Rules::of(&study, number, number % 3);
                for Block { modes, .. } in draw_modes(&rules, u64::from(number)).blocks {
                    assert!(can_draw(&rules, &modes), "{scheme:?} {modes:?}");
                    assert!(!can_draw(&rules, &modes[1..]), "one is missing");
                }
            }
        }
    }

    #[test]
    fn an_order_that_the_scheme_rules_out_cannot_be_drawn() {
        let cannot = |scheme, repeats, orders: &[&[usize]]| {
            let rules = Rules::of(&study(scheme, 3, repeats), 1, 1);
            orders.iter().for_each(|order| assert!(!can_draw(&rules, order), "{order:?}"));
        };
        // Not each mode once in each repeat; a row twice before all came; a mode too often.
        cannot(
            OrderScheme::Williams,
            2,
            &[&[0, 1, 1, 2, 0, 2], &[0, 1, 2, 0, 1, 2], &[0, 1, 2, 0, 1, 1]],
        );
        cannot(OrderScheme::Constrained, 3, &[&[0, 0, 0, 1, 2, 1, 2, 1, 2], &[0; 9], &[3; 9], &[]]);
        let rules = Rules::of(&study(OrderScheme::Williams, 4, 2), 1, 1);
        // In a square each mode begins one row.
        assert!(can_draw(&rules, &[0, 1, 3, 2, 1, 2, 0, 3]));
        assert!(!can_draw(&rules, &[0, 1, 3, 2, 0, 1, 2, 3]));
    }

    /// Every one of the 720 orders of a block that the rule admits is drawn by some seed, and each
    /// about as often.
    #[test]
    fn each_order_of_a_williams_block_is_as_likely() {
        let rules = Rules::of(&study(OrderScheme::Williams, 3, 6), 1, 1);
        let mut found: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        for seed in 0..36_000 {
            let drawn = draw_modes(&rules, seed);
            *found.entry(drawn.blocks[0].modes.clone()).or_default() += 1;
        }
        assert_eq!(found.len(), 720);
        // Poisson with mean 50: all within 5 of its deviations.
        assert!(found.values().all(|n| (15..=85).contains(n)), "{:?}", found.values().max());
    }

    /// The largest numbers that fit are numbers like any other.
    #[test]
    fn numbers_may_be_anything() {
        let study = study(OrderScheme::Williams, 3, 6);
        for number in [0, u32::MAX] {
            assert_eq!(draw(&study, number, number, u64::MAX).len(), 39);
        }
        for (environments, modes) in [(0, 0), (0, 3), (2, 0)] {
            let rules = Rules { environments, modes, ..Rules::of(&study, 1, 1) };
            assert!(draw_modes(&rules, 1).blocks.iter().all(|block| block.modes.is_empty()));
            assert!(can_draw(&Rules { modes: 0, ..rules }, &[]));
        }
    }
}
