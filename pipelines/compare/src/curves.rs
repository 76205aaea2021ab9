//! Whole curves compared: between modes and by effects of factors, and these between groups.

use crate::claim::Claim;
use crate::{Groups, SessionOrder};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_numerics::series::{common_grid, interpolate_all};
use zwidth_results::{
    AveragePoint, CurveDifference, CurveNode, CurveRun, EffectLevels, FactorEffect, GroupEffect,
    LoopBranch, LoopPoint, Role, Row as _, Verdict,
};
use zwidth_stats::curve::{self, CurveTest, LEAST_FOR_A_CLAIM, Node, SKEWED, UnpairedCurveTest};
use zwidth_stats::null::Sampling;
use zwidth_stats::{paired, sign_flip};
use zwidth_study::{
    Contrast, Curve, Effect, EnvironmentId, Families, GroupContrast, LevelId, ModeId,
    ParticipantId, SessionId, TrialMeta, Weight, counted,
};
use zwidth_tables::{Table, TableError};

/// Flips of signs and arrangements of labels that are drawn where there are too many to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// The parameters of a comparison of curves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurveParameters {
    /// The curves.
    pub curves: Vec<Curve>,
    /// Those of them that are primary: the claims of every other one are exploratory.
    pub primary: Vec<Curve>,
    /// How many claims on metrics are of one family with those of primary curves, at most.
    pub metric_claims: usize,
    /// Nodes of each branch.
    pub nodes: usize,
    /// The environments, in the study's order.
    pub environments: Vec<EnvironmentId>,
    /// The modes, in the study's order.
    pub modes: Vec<ModeId>,
    /// The contrasts.
    pub contrasts: Vec<Contrast>,
    /// Effects of factors.
    pub effects: Vec<Effect>,
    /// The groups of people that are compared.
    pub groups: Option<Groups>,
    /// Which tests are adjusted together.
    pub families: Families,
    /// A difference needs an adjusted p value below this.
    pub alpha: f64,
    /// Level of every band, as a fraction.
    pub level: f64,
    /// The orders of one participant's sessions, and how they were drawn; empty of several participants.
    pub orders: Vec<SessionOrder>,
}

/// A curve over angles or times that rise.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Course {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
}

/// The mean curve of a participant's repeats in one session and condition, or the curve of one of these trials.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionCurve {
    pub(crate) curve: Curve,
    pub(crate) participant: ParticipantId,
    pub(crate) session: SessionId,
    pub(crate) environment: EnvironmentId,
    pub(crate) mode: ModeId,
    /// The trial whose it is; none of a mean.
    pub(crate) trial: Option<u32>,
    /// By branch; one over time has none. A trial may have no course.
    pub(crate) branches: BTreeMap<Option<LoopBranch>, Course>,
}

/// The column of a curve in the tables of the stage `average`.
fn column(curve: Curve) -> &'static str {
    match curve {
        Curve::ForceOverAngle | Curve::ForceOverTime => "force_ex_mean_n",
        Curve::ThetaOverTime => "theta_mean_rad",
        Curve::VelocityOverAngle => "theta_dot_mean_rad_s",
    }
}

impl SessionCurve {
    /// The columns that [`Self::of`] reads.
    pub fn columns(curve: Curve) -> Vec<String> {
        let fields =
            if curve.is_over_angle() { LoopPoint::fields() } else { AveragePoint::fields() };
        let names = fields.into_iter().map(|field| field.name.into_owned());
        names.chain([column(curve).to_owned()]).collect()
    }

    /// The curve of a condition's table of the stage `average`: of the mean by branch over the angle, of that
    /// aligned at onset over time, as long as all repeats last. `None` if it has no such mean.
    ///
    /// # Errors
    /// A table that is not of this stage.
    pub fn of(table: &Table, curve: Curve) -> Result<Option<Self>, TableError> {
        let (condition, branches) = courses(table, curve)?;
        let condition = condition.filter(|_| !branches.is_empty());
        Ok(condition.map(|(participant, session, environment, mode)| Self {
            curve,
            participant,
            session,
            environment,
            mode,
            trial: None,
            branches,
        }))
    }

    /// The curve of a trial, of whose one repeat `table` is such a mean.
    ///
    /// # Errors
    /// A table that is not of this stage.
    pub fn of_trial(meta: &TrialMeta, table: &Table, curve: Curve) -> Result<Self, TableError> {
        let (_, branches) = courses(table, curve)?;
        Ok(Self {
            curve,
            participant: meta.participant.clone(),
            session: meta.session.clone(),
            environment: meta.environment.clone(),
            mode: meta.mode.clone(),
            trial: Some(meta.trial),
            branches,
        })
    }
}

type Condition = (ParticipantId, SessionId, EnvironmentId, ModeId);
type Courses = BTreeMap<Option<LoopBranch>, Course>;

/// The condition of a table of means, which an empty one has not, and its course by branch.
fn courses(table: &Table, curve: Curve) -> Result<(Option<Condition>, Courses), TableError> {
    let values = table.floats(column(curve))?;
    let mut branches = Courses::new();
    let condition = if curve.is_over_angle() {
        let points: Vec<LoopPoint> = table.to_rows()?;
        for (point, value) in points.iter().zip(values) {
            // While the lever is held there is no angle to go over.
            let (LoopBranch::In | LoopBranch::Out, Some(value)) = (point.branch, value) else {
                continue;
            };
            let course = branches.entry(Some(point.branch)).or_default();
            course.x.push(point.theta_rad);
            course.y.push(value);
        }
        if let Some(out) = branches.get_mut(&Some(LoopBranch::Out)) {
            out.x.reverse();
            out.y.reverse();
        }
        points.into_iter().next().map(|p| (p.participant, p.session, p.environment, p.mode))
    } else {
        let points: Vec<AveragePoint> = table.to_rows()?;
        let all = points.first().map_or(0, |point| point.n);
        let whole = points.iter().zip(values).take_while(|(point, _)| point.n == all);
        for (point, value) in whole {
            let Some(value) = value else { break };
            let course = branches.entry(None).or_default();
            course.x.push(point.t_s);
            course.y.push(value);
        }
        points.into_iter().next().map(|p| (p.participant, p.session, p.environment, p.mode))
    };
    Ok((condition, branches))
}

/// Curves compared.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curves {
    /// Every node.
    pub points: Vec<CurveNode>,
    /// The tests.
    pub tests: Vec<CurveDifference>,
    /// Runs of large t.
    pub runs: Vec<CurveRun>,
}

/// Where several curves have nodes.
pub(crate) struct Shared {
    /// The branches that all have, with the angles or times of their nodes.
    pub(crate) branches: Vec<(Option<LoopBranch>, Vec<f64>)>,
    /// Which branches are left out, and why.
    pub(crate) left_out: Vec<String>,
}

impl Shared {
    /// So many nodes of each branch where all curves are, which are `whose`: everybody's, say.
    pub(crate) fn of(curves: &[&SessionCurve], nodes: usize, whose: &str) -> Self {
        let kinds: BTreeSet<Option<LoopBranch>> =
            curves.iter().flat_map(|one| one.branches.keys().copied()).collect();
        let mut shared = Self { branches: Vec::new(), left_out: Vec::new() };
        for branch in kinds {
            let courses: Vec<&Course> =
                curves.iter().filter_map(|one| one.branches.get(&branch)).collect();
            let way = match branch {
                Some(LoopBranch::Out) => "the way back",
                Some(LoopBranch::In | LoopBranch::Held) => "the way there",
                None => "the course",
            };
            let why = match common_grid(courses.iter().map(|course| course.x.as_slice()), nodes) {
                _ if courses.len() < curves.len() && branch == Some(LoopBranch::Out) => {
                    format!("not {whose} returns")
                }
                _ if courses.len() < curves.len() => format!("not {whose} has it"),
                Some(places) => {
                    shared.branches.push((branch, places));
                    continue;
                }
                None => "there is no place that all reach".to_owned(),
            };
            shared.left_out.push(format!("{way} is left out: {why}"));
        }
        shared
    }

    /// The values of one of the curves at the nodes of all branches.
    pub(crate) fn values<'a>(&'a self, curve: &'a SessionCurve) -> impl Iterator<Item = f64> + 'a {
        self.branches.iter().flat_map(|(branch, x)| {
            let course = &curve.branches[branch];
            // Nodes lie within what every course covers.
            interpolate_all(&course.x, &course.y, x).into_iter().map(|y| y.unwrap_or(f64::NAN))
        })
    }

    pub(crate) fn lengths(&self) -> Vec<usize> {
        self.branches.iter().map(|(_, x)| x.len()).collect()
    }

    /// The branch and the place of each node.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = (Option<LoopBranch>, f64)> + '_ {
        self.branches.iter().flat_map(|(branch, x)| x.iter().map(|x| (*branch, *x)))
    }
}

/// What is compared.
pub(crate) struct Comparison {
    pub(crate) effect: GroupEffect,
    /// The environment in which it is; `None` of an effect over several.
    pub(crate) environment: Option<EnvironmentId>,
    /// The weight of each condition.
    pub(crate) weights: Vec<Weight>,
}

impl Comparison {
    /// Whether it is of everybody, besides between groups.
    pub(crate) fn is_of_everybody(&self) -> bool {
        matches!(self.effect, GroupEffect::Of(_) | GroupEffect::OfFactors(_))
    }
}

/// What is compared, environment by environment: contrasts and effects, and where there are groups also what is
/// compared between these alone; at last the effects over several environments.
pub(crate) fn compared(curves: &[&SessionCurve], parameters: &CurveParameters) -> Vec<Comparison> {
    let has =
        |environment: &EnvironmentId| curves.iter().any(|one| one.environment == *environment);
    let of_factors = |environment: Option<&EnvironmentId>| {
        let is_compared = |effect: &&Effect| {
            effect.environment.as_ref() == environment
                && effect.is_claimed
                && !effect.weights.is_empty()
                && effect.weights.iter().all(|weight| has(&weight.environment))
        };
        let effects = parameters.effects.iter().filter(is_compared).map(|effect| {
            let levels = (!effect.levels.is_empty()).then(|| EffectLevels(effect.levels.clone()));
            let name = FactorEffect { term: effect.term.clone(), levels };
            Comparison {
                effect: GroupEffect::OfFactors(name),
                environment: environment.cloned(),
                weights: effect.weights.clone(),
            }
        });
        effects.collect::<Vec<Comparison>>()
    };
    let mut all = Vec::new();
    for environment in parameters.environments.iter().filter(|environment| has(environment)) {
        let comparison = |effect: GroupEffect, modes: &[(&ModeId, f64)]| {
            let weights = modes.iter().map(|(mode, weight)| Weight {
                session: None,
                environment: environment.clone(),
                mode: (*mode).clone(),
                weight: *weight,
            });
            let weights = weights.collect();
            Comparison { effect, environment: Some(environment.clone()), weights }
        };
        let is_here = |mode: &&ModeId| {
            curves.iter().any(|one| one.environment == *environment && one.mode == **mode)
        };
        let modes: Vec<&ModeId> = parameters.modes.iter().filter(is_here).collect();
        if parameters.groups.is_some() && modes.len() > 1 {
            let share = 1.0 / modes.len() as f64;
            let each: Vec<(&ModeId, f64)> = modes.iter().map(|mode| (*mode, share)).collect();
            all.push(comparison(GroupEffect::OverModes, &each));
        }
        all.extend(parameters.contrasts.iter().map(|contrast| {
            let modes = [(&contrast.mode, 1.0), (&contrast.against, -1.0)];
            comparison(GroupEffect::Of(contrast.clone()), &modes)
        }));
        all.extend(of_factors(Some(environment)));
        if parameters.groups.is_some() {
            let in_mode = |mode: &ModeId| comparison(GroupEffect::In(mode.clone()), &[(mode, 1.0)]);
            all.extend(modes.into_iter().map(in_mode));
        }
    }
    all.extend(of_factors(None));
    all
}

/// Everybody's curves on common nodes.
pub(crate) struct People {
    who: Vec<ParticipantId>,
    /// People who have some of the conditions, not all.
    lacking: Vec<ParticipantId>,
    pub(crate) shared: Shared,
    /// The sum over conditions of positive weight and that over the others, person by person, over the nodes of all
    /// branches; the second is taken from the first.
    sides: [Vec<Vec<f64>>; 2],
}

impl People {
    pub(crate) fn of(
        curves: &[&SessionCurve],
        weights: &[Weight],
        parameters: &CurveParameters,
    ) -> Self {
        // Of groups nobody speaks who has none.
        let in_group = |who: &ParticipantId| {
            parameters.groups.as_ref().is_none_or(|groups| groups.levels_of.contains_key(who))
        };
        // Everybody's curve of each weight: session by session, or, where sessions are levels, of all of them
        // together. A session that lacks one would bring its own practice into a difference.
        type OfPerson<'a> = BTreeMap<Option<&'a SessionId>, BTreeMap<usize, &'a SessionCurve>>;
        let mut by_person: BTreeMap<&ParticipantId, OfPerson> = BTreeMap::new();
        for one in curves.iter().filter(|one| in_group(&one.participant)) {
            let place = weights.iter().position(|weight| {
                weight.environment == one.environment
                    && weight.mode == one.mode
                    && weight.session.as_ref().is_none_or(|session| *session == one.session)
            });
            let Some(place) = place else { continue };
            let session = weights[place].session.is_none().then_some(&one.session);
            let sessions = by_person.entry(&one.participant).or_default();
            sessions.entry(session).or_default().insert(place, one);
        }
        let mut lacking = Vec::new();
        by_person.retain(|who, sessions| {
            sessions.retain(|_, own| own.len() == weights.len());
            if sessions.is_empty() {
                lacking.push((*who).clone());
            }
            !sessions.is_empty()
        });
        let curves: Vec<&SessionCurve> =
            by_person.values().flatten().flat_map(|(_, own)| own.values().copied()).collect();
        let shared = Shared::of(&curves, parameters.nodes, "everybody");
        let side = |sign: f64| -> Vec<Vec<f64>> {
            let people = by_person.values().map(|sessions| {
                let mut sum = vec![0.0; shared.lengths().iter().sum()];
                for (place, weight) in weights.iter().enumerate() {
                    if weight.weight * sign <= 0.0 {
                        continue;
                    }
                    for own in sessions.values() {
                        let share = weight.weight.abs() / sessions.len() as f64;
                        for (sum, value) in sum.iter_mut().zip(shared.values(own[&place])) {
                            *sum += share * value;
                        }
                    }
                }
                sum
            });
            people.collect()
        };
        Self {
            sides: [side(1.0), side(-1.0)],
            who: by_person.keys().map(|who| (*who).clone()).collect(),
            lacking,
            shared,
        }
    }

    /// Everybody's differences; values that differ by their rounding do not differ.
    pub(crate) fn differences(&self) -> Vec<Vec<f64>> {
        let mut rows = self.sides[0].clone();
        for node in 0..self.shared.lengths().iter().sum() {
            let pairs = self.sides[0].iter().zip(&self.sides[1]);
            let pairs: Vec<[f64; 2]> = pairs.map(|(a, b)| [a[node], b[node]]).collect();
            for (row, difference) in rows.iter_mut().zip(paired::differences(&pairs)) {
                row[node] = difference;
            }
        }
        rows
    }
}

/// One comparison, not judged yet.
pub(crate) struct Row {
    pub(crate) effect: GroupEffect,
    /// The environment in which it is; `None` of an effect over several.
    pub(crate) environment: Option<EnvironmentId>,
    pub(crate) groups: Option<GroupContrast>,
    /// The one participant whose trials are compared.
    pub(crate) within: Option<ParticipantId>,
    pub(crate) n: usize,
    pub(crate) n_second: Option<usize>,
    /// The branch and the place of each node.
    pub(crate) places: Vec<(Option<LoopBranch>, f64)>,
    /// The means whose difference each node's is.
    pub(crate) means: [Vec<f64>; 2],
    /// The test, or why there is none.
    pub(crate) tested: Result<Test, String>,
    pub(crate) remarks: Vec<String>,
    pub(crate) claim: Claim,
}

/// How curves were compared.
pub(crate) enum Test {
    /// Everybody's differences, by flipped signs.
    Flipped(CurveTest),
    /// Two groups of people, or of one participant's trials, by other arrangements.
    Arranged(UnpairedCurveTest),
    /// Trials that no other order has: described, without a p value.
    Described(UnpairedCurveTest),
}

impl Test {
    fn nodes(&self) -> (&[Node], usize) {
        match self {
            Self::Flipped(test) => (&test.nodes, test.largest),
            Self::Arranged(test) | Self::Described(test) => (&test.nodes, test.largest),
        }
    }
}

/// The mean over rows, node by node.
pub(crate) fn mean(rows: &[&Vec<f64>], nodes: usize) -> Vec<f64> {
    let sum = |node| rows.iter().map(|row| row[node]).sum::<f64>() / rows.len() as f64;
    (0..nodes).map(sum).collect()
}

/// The comparison of everybody, if that is asked, then of each pair of groups.
pub(crate) fn rows(
    comparison: &Comparison,
    people: &People,
    parameters: &CurveParameters,
) -> Vec<Row> {
    let Comparison { effect, environment, weights } = comparison;
    // Those over several environments come together after those of each.
    let family = parameters.environments.iter().position(|own| Some(own) == environment.as_ref());
    let family = family.unwrap_or(parameters.environments.len());
    let mut about = Vec::new();
    if !people.lacking.is_empty() {
        let names: Vec<String> = people.lacking.iter().map(ToString::to_string).collect();
        let are_modes = environment.is_some() && weights.iter().all(|own| own.session.is_none());
        let what = if are_modes { "mode" } else { "condition" };
        about.push(format!("{} without a curve in each {what}", names.join(", ")));
    }
    about.extend(people.shared.left_out.iter().cloned());
    let lengths = people.shared.lengths();
    let nodes = lengths.iter().sum();
    let differences = people.differences();
    let places: Vec<(Option<LoopBranch>, f64)> = people.shared.nodes().collect();
    let n = people.who.len();
    let mut rows = Vec::new();
    if comparison.is_of_everybody() {
        let tested = curve::differences(&differences, &lengths, parameters.level, SAMPLING);
        let mut remarks = about.clone();
        if tested.is_ok() && n < LEAST_FOR_A_CLAIM {
            let least = sign_flip::smallest_p(n);
            remarks.push(format!(
                "no claim: with {} no p value of this test is below {least}, and the interval is pointwise",
                counted(n, "participants")
            ));
        }
        let p = tested.as_ref().ok().and_then(|test| test.p_claimed(n));
        let smallest_p = tested.as_ref().ok().filter(|_| p.is_some()).map(|t| t.flipped.smallest_p);
        if tested.as_ref().is_ok_and(|test| test.skewness > SKEWED) {
            remarks.push(
                "the differences are skewed: the larger p of both tests counts, and the band covers less than it says"
                    .to_owned(),
            );
        }
        rows.push(Row {
            effect: effect.clone(),
            environment: environment.clone(),
            groups: None,
            within: None,
            n,
            n_second: None,
            places: places.clone(),
            means: [0, 1].map(|side| mean(&people.sides[side].iter().collect::<Vec<_>>(), nodes)),
            claim: Claim::new(family, p, smallest_p, None),
            tested: tested.map(Test::Flipped).map_err(|why| why.to_string()),
            remarks,
        });
    }
    let Some(groups) = &parameters.groups else { return rows };
    for contrast in &groups.compared.contrasts {
        // The curves of a group's people, and the block of the drawing of each.
        let of_group = |level: &LevelId| {
            let place = groups.compared.levels.iter().position(|own| own == level);
            let own = people.who.iter().zip(&differences);
            let own = own.filter(|(who, _)| groups.levels_of.get(who).copied() == place);
            let block = |who| groups.blocks.get(who).map_or(0, |block| *block as usize);
            own.map(|(who, row)| (row.clone(), block(who))).unzip::<_, _, Vec<_>, Vec<_>>()
        };
        let [(first, first_blocks), (second, second_blocks)] =
            [&contrast.group, &contrast.against].map(of_group);
        let means = [&first, &second].map(|rows| mean(&rows.iter().collect::<Vec<_>>(), nodes));
        let blocks = [&first_blocks[..], &second_blocks[..]];
        let tested = curve::groups([&first, &second], blocks, &lengths, parameters.level, SAMPLING);
        rows.push(Row {
            effect: effect.clone(),
            environment: environment.clone(),
            groups: Some(contrast.clone()),
            within: None,
            n: first.len(),
            n_second: Some(second.len()),
            places: places.clone(),
            means,
            tested: tested.map(Test::Arranged).map_err(|why| why.to_string()),
            remarks: about.clone(),
            claim: Claim::new(family, None, None, None),
        });
    }
    rows
}

impl Row {
    /// Adds the rows of tables.
    pub(crate) fn add_to(mut self, all: &mut Curves, curve: Curve, parameters: &CurveParameters) {
        let is_angle = curve.is_over_angle();
        let split = |x: f64| if is_angle { (Some(x), None) } else { (None, Some(x)) };
        let tested = self.tested.as_ref().ok();
        let flipped = tested.and_then(|test| match test {
            Test::Flipped(test) => Some(test),
            Test::Arranged(_) | Test::Described(_) => None,
        });
        let permutation = tested.and_then(|test| match test {
            Test::Flipped(test) => Some(test.flipped),
            Test::Arranged(test) => Some(test.permuted),
            Test::Described(_) => None,
        });
        let (nodes, largest) = tested.map(Test::nodes).unwrap_or_default();
        let place = tested.map(|_| self.places[largest]);
        let (theta_rad, t_s) = place.map_or((None, None), |(_, x)| split(x));
        let left_out = nodes.iter().filter(|node| node.statistic.is_none()).count();
        let verdict = self.claim.verdict;
        if verdict == Verdict::Undecided
            && let Some(least) = self.claim.out_of_reach(parameters.alpha)
        {
            let what = match &self.within {
                Some(_) => "other orders".to_owned(),
                None => format!("the signs of {}", counted(self.n, "participants")),
            };
            self.remarks.push(format!("{what} reach an adjusted p of {least:.4} at best"));
        }
        if let Err(why) = &self.tested {
            self.remarks.push(why.clone());
        }
        all.tests.push(CurveDifference {
            curve,
            unit: curve.unit().into(),
            role: match parameters.primary.contains(&curve) {
                true => Role::Primary,
                false => Role::Exploratory,
            },
            environment: self.environment.clone(),
            effect: self.effect.clone(),
            groups: self.groups.clone(),
            within: self.within.clone(),
            n: self.n,
            n_second: self.n_second,
            nodes: nodes.len() - left_out,
            left_out,
            largest_t: tested.and_then(|_| nodes[largest].statistic),
            branch: place.and_then(|(branch, _)| branch),
            theta_rad,
            t_s,
            difference: tested.map(|_| nodes[largest].mean),
            critical_t: flipped.map(|test| test.critical),
            band_t: flipped.and_then(|test| test.band),
            p_value: permutation.map(|test| test.p_value),
            smallest_p: permutation.map(|test| test.smallest_p),
            p_adjusted: self.claim.p_adjusted,
            p_unstudentised: flipped.map(|test| test.p_unstudentised),
            skewness: flipped.map(|test| test.skewness),
            verdict: self.groups.is_none().then_some(verdict),
            remark: (!self.remarks.is_empty()).then(|| self.remarks.join("; ").into()),
        });
        for (i, node) in nodes.iter().enumerate() {
            let (branch, x) = self.places[i];
            let (theta_rad, t_s) = split(x);
            all.points.push(CurveNode {
                curve,
                unit: curve.unit().into(),
                environment: self.environment.clone(),
                effect: self.effect.clone(),
                groups: self.groups.clone(),
                branch,
                theta_rad,
                t_s,
                mean_first: self.means[0][i],
                mean_second: self.means[1][i],
                difference: node.mean,
                difference_std_error: node.std_error,
                statistic: node.statistic,
                band_low: node.ends.map(|ends| ends[0]),
                band_high: node.ends.map(|ends| ends[1]),
            });
        }
        for run in flipped.map(|test| test.runs.as_slice()).unwrap_or_default() {
            let (branch, low) = self.places[run.first];
            let (_, high) = self.places[run.last];
            let [(theta_low_rad, begins_s), (theta_high_rad, ends_s)] = [split(low), split(high)];
            all.runs.push(CurveRun {
                curve,
                environment: self.environment.clone(),
                effect: self.effect.clone(),
                branch,
                theta_low_rad,
                theta_high_rad,
                begins_s,
                ends_s,
                nodes: run.last - run.first + 1,
                mass: run.mass,
                p_value: run.p_value,
            });
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compare_curves;
    use zwidth_study::{FactorId, GroupsCompared, Term};

    /// A person's curve in a mode: of angles up to `end`, a line of that slope there and back.
    fn session(who: usize, mode: &str, end: f64, slope: f64, returns: bool) -> SessionCurve {
        let x: Vec<f64> = (0..=20).map(|i| end * f64::from(i) / 20.0).collect();
        let y = x.iter().map(|x| slope * x + 0.1 * (x * who as f64).sin()).collect();
        let course = Course { x, y };
        let back = returns.then(|| (Some(LoopBranch::Out), course.clone()));
        SessionCurve {
            curve: Curve::ForceOverAngle,
            participant: format!("P{who:02}").parse().unwrap(),
            session: "S01".parse().unwrap(),
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
            trial: None,
            branches: [(Some(LoopBranch::In), course)].into_iter().chain(back).collect(),
        }
    }

    pub(crate) fn parameters() -> CurveParameters {
        let contrast = |mode: &str| Contrast {
            mode: mode.parse().unwrap(),
            against: "active".parse().unwrap(),
        };
        CurveParameters {
            curves: vec![Curve::ForceOverAngle],
            primary: Vec::new(),
            metric_claims: 0,
            nodes: 11,
            environments: vec!["spring".parse().unwrap()],
            modes: ["active", "passive", "hybrid"].map(|id| id.parse().unwrap()).to_vec(),
            contrasts: vec![contrast("hybrid"), contrast("passive")],
            effects: Vec::new(),
            groups: None,
            families: Families::Metric,
            alpha: 0.05,
            level: 0.95,
            orders: Vec::new(),
        }
    }

    /// So many people in two modes, of which the second is steeper.
    pub(crate) fn people(number: usize) -> Vec<SessionCurve> {
        let both = |who| {
            let more = 1.0 + 0.2 * (who as f64).cos();
            let end = 0.5 + 0.01 * who as f64;
            [session(who, "active", end, 2.0, true), session(who, "hybrid", end, 2.0 + more, true)]
        };
        (1..=number).flat_map(both).collect()
    }

    #[test]
    fn people_meet_where_all_reach_and_who_lacks_a_mode_is_named() {
        let mut sessions = people(8);
        sessions.push(session(9, "active", 0.2, 2.0, true));
        let found = compare_curves(&sessions, &parameters()).unwrap();
        let [hybrid, passive] = found.tests.as_slice() else { panic!("{:?}", found.tests) };
        assert_eq!(
            (hybrid.n, hybrid.nodes, hybrid.left_out),
            (8, 20, 2),
            "nobody scatters at zero"
        );
        let remark = hybrid.remark.as_ref().unwrap().to_string();
        assert_eq!(remark, "P09 without a curve in each mode");
        let farthest = found.points.iter().filter_map(|point| point.theta_rad).fold(0.0, f64::max);
        assert!((farthest - 0.51).abs() < 1e-12, "{farthest}");
        // Nobody has the other mode.
        assert_eq!((passive.n, passive.verdict), (0, Some(Verdict::NotTested)));
        assert!(passive.remark.as_ref().unwrap().to_string().contains("0 participants"));
        // One test has a p value: it is adjusted by itself. All have one sign: 2 of 256 flips.
        assert_eq!(hybrid.verdict, Some(Verdict::Different));
        assert!((hybrid.p_adjusted.unwrap() - 2.0 / 256.0).abs() < 1e-12);
        assert!(found.runs.iter().all(|run| run.effect == hybrid.effect && run.nodes > 1));
        let node = &found.points[5];
        assert!((node.mean_first - node.mean_second - node.difference).abs() < 1e-12);
    }

    #[test]
    fn sessions_of_a_person_have_the_same_weight_and_a_way_back_that_somebody_lacks_is_left_out() {
        let mut sessions = people(6);
        let again = |mode: &str, slope: f64, id: &str| SessionCurve {
            session: id.parse().unwrap(),
            ..session(1, mode, 0.6, slope, false)
        };
        // A third session, without the other mode, is in no difference.
        sessions.extend([again("active", 2.0, "S02"), again("hybrid", 12.0, "S02")]);
        sessions.push(again("hybrid", 900.0, "S03"));
        let found = compare_curves(&sessions, &parameters()).unwrap();
        let remark = found.tests[0].remark.as_ref().unwrap().to_string();
        assert!(remark.starts_with("the way back is left out: not everybody returns"));
        assert!(found.points.iter().all(|point| point.branch == Some(LoopBranch::In)));
        let alone = compare_curves(&people(6), &parameters()).unwrap();
        let at_the_end =
            |found: &Curves| found.points[10].difference / found.points[10].theta_rad.unwrap();
        let more = 1.0 + 0.2 * 1.0_f64.cos();
        let expected = at_the_end(&alone) + ((10.0 + more) / 2.0 - more) / 6.0;
        assert!((at_the_end(&found) - expected).abs() < 0.01, "{}", at_the_end(&found));
    }

    #[test]
    fn people_who_reach_no_place_together_are_told_so() {
        let mut sessions = people(6);
        for course in sessions.iter_mut().take(2).flat_map(|one| one.branches.values_mut()) {
            course.x.iter_mut().for_each(|x| *x += 2.0);
        }
        let found = compare_curves(&sessions, &parameters()).unwrap();
        let remark = found.tests[0].remark.as_ref().unwrap().to_string();
        assert!(
            remark.starts_with("the way there is left out: there is no place that all reach; ")
        );
        assert_eq!((found.tests[0].n, found.tests[0].nodes, found.points.len()), (6, 0, 0));
    }

    #[test]
    fn five_people_claim_nothing() {
        let found = compare_curves(&people(5), &parameters()).unwrap();
        let test = &found.tests[0];
        assert_eq!((test.verdict, test.p_adjusted), (Some(Verdict::NotTested), None));
        assert!((test.p_value.unwrap() - 0.0625).abs() < 1e-12 && test.band_t.is_none());
        let remark = test.remark.as_ref().unwrap().to_string();
        assert!(
            remark.starts_with(
                "no claim: with 5 participants no p value of this test is below 0.0625"
            )
        );
    }

    #[test]
    fn of_skewed_differences_both_tests_must_find_the_effect() {
        let mut sessions = people(8);
        let found = compare_curves(&sessions, &parameters()).unwrap();
        assert_eq!(found.tests[0].verdict, Some(Verdict::Different));
        // One person goes far the other way over the greater part: that hides the mean, but not what all have before.
        let hybrid = sessions.iter_mut().filter(|one| one.mode.as_str() == "hybrid");
        for course in hybrid.take(1).flat_map(|one| one.branches.values_mut()) {
            course.y[8..].iter_mut().for_each(|y| *y -= 50.0);
        }
        let found = compare_curves(&sessions, &parameters()).unwrap();
        let test = &found.tests[0];
        assert!(test.skewness.unwrap() > SKEWED && test.p_unstudentised.unwrap() > 0.5, "{test:?}");
        assert!(test.p_value.unwrap() < 0.01 && test.p_adjusted == test.p_unstudentised);
        assert_eq!(test.verdict, Some(Verdict::Undecided));
        assert!(test.remark.as_ref().unwrap().to_string().contains("are skewed"));
    }

    #[test]
    fn primary_curves_share_alpha_with_primary_metrics_and_leave_others_alone() {
        let both = CurveParameters {
            curves: vec![Curve::ForceOverAngle, Curve::VelocityOverAngle],
            families: Families::Study,
            ..parameters()
        };
        let mut sessions = people(8);
        let again: Vec<SessionCurve> = sessions
            .iter()
            .map(|one| SessionCurve { curve: Curve::VelocityOverAngle, ..one.clone() })
            .collect();
        sessions.extend(again);
        let adjusted = |parameters: &CurveParameters| {
            let found = compare_curves(&sessions, parameters).unwrap();
            let tested = found.tests.into_iter().filter(|test| test.p_value.is_some());
            tested.map(|test| (test.role, test.p_adjusted.unwrap() * 256.0)).collect::<Vec<_>>()
        };
        let near = |found: Vec<(Role, f64)>, expected: [(Role, f64); 2]| {
            assert_eq!(found.len(), expected.len());
            for ((role, p), (expected_role, expected)) in found.iter().zip(expected) {
                assert!(*role == expected_role && (p - expected).abs() < 1e-9, "{role:?} {p}");
            }
        };
        let (main, side) = (Role::Primary, Role::Exploratory);
        near(adjusted(&both), [(side, 2.0), (side, 2.0)]);
        // One claim beside three of metrics has a quarter of alpha.
        let beside = CurveParameters {
            primary: vec![Curve::ForceOverAngle],
            metric_claims: 3,
            ..both.clone()
        };
        near(adjusted(&beside), [(main, 8.0), (side, 2.0)]);
        // Two claims beside three of metrics have two fifths, and Holm's method among them.
        let joined = CurveParameters { primary: beside.curves.clone(), ..beside.clone() };
        near(adjusted(&joined), [(main, 10.0), (main, 10.0)]);
        let apart = CurveParameters { families: Families::Metric, metric_claims: 0, ..joined };
        near(adjusted(&apart), [(main, 2.0), (main, 2.0)]);
    }

    /// Of two environments and two sessions in which the second mode is steeper by 1 and 3, and by 0.5 more in the
    /// second session.
    #[test]
    fn effects_over_environments_and_over_sessions_weigh_their_conditions() {
        let mut sessions = Vec::new();
        for (environment, more) in [("spring", 1.0), ("wall", 3.0)] {
            for (id, practice) in [("S01", 0.0), ("S02", 0.5)] {
                for who in 1..=8 {
                    let own = 0.2 * (who as f64).cos();
                    let hybrid = 2.0 + more + practice + own * (1.0 + 0.01 * more);
                    for (mode, slope) in [("active", 2.0), ("hybrid", hybrid)] {
                        sessions.push(SessionCurve {
                            session: id.parse().unwrap(),
                            environment: environment.parse().unwrap(),
                            ..session(who, mode, 0.5, slope, true)
                        });
                    }
                }
            }
        }
        // Who lacks the second session has the mean over sessions, not the change from one to the other.
        sessions.retain(|one| one.participant.as_str() != "P08" || one.session.as_str() == "S01");
        let weight = |session: Option<&str>, environment: &str, mode: &str, weight| Weight {
            session: session.map(|id| id.parse().unwrap()),
            environment: environment.parse().unwrap(),
            mode: mode.parse().unwrap(),
            weight,
        };
        let effect = |id: &str, environment: Option<&str>, weights| Effect {
            term: Term(vec![id.parse::<FactorId>().unwrap()]),
            levels: Vec::new(),
            environment: environment.map(|id| id.parse().unwrap()),
            weights,
            over: None,
            is_claimed: true,
            lacks: None,
        };
        let pair = |session, environment, sign: f64| {
            [
                weight(session, environment, "hybrid", sign),
                weight(session, environment, "active", -sign),
            ]
        };
        let both = |a: [Weight; 2], b: [Weight; 2]| [a, b].concat();
        let effects = vec![
            effect("wall_costs", None, both(pair(None, "wall", 1.0), pair(None, "spring", -1.0))),
            effect(
                "learned",
                Some("wall"),
                both(pair(Some("S02"), "wall", 1.0), pair(Some("S01"), "wall", -1.0)),
            ),
            effect("elsewhere", None, both(pair(None, "wall", 1.0), pair(None, "free", -1.0))),
        ];
        let environments = ["spring", "wall", "free"].map(|id| id.parse().unwrap()).to_vec();
        let parameters =
            CurveParameters { effects, environments, contrasts: Vec::new(), ..parameters() };
        let found = compare_curves(&sessions, &parameters).unwrap();
        let [learned, costs] = found.tests.as_slice() else { panic!("{:?}", found.tests) };
        assert_eq!((learned.environment.as_ref().unwrap().as_str(), learned.n), ("wall", 7));
        assert_eq!(
            learned.remark.as_ref().unwrap().to_string(),
            "P08 without a curve in each condition; all differences are equal, so nothing tells how far they scatter"
        );
        assert_eq!((costs.environment.as_ref(), costs.n), (None, 8));
        assert_eq!(costs.verdict, Some(Verdict::Different));
        let at_the_end = found.points.iter().rfind(|point| point.environment.is_none()).unwrap();
        let people: f64 = (1..=8).map(|who| 0.2 * f64::from(who).cos()).sum::<f64>() / 8.0;
        let expected = 0.5 * (2.0 + 0.02 * people);
        assert!((at_the_end.difference - expected).abs() < 1e-9, "{at_the_end:?} {expected}");
    }

    #[test]
    fn groups_are_compared_in_modes_in_their_mean_and_in_differences() {
        let level = |id: &str| -> LevelId { id.parse().unwrap() };
        let levels = [level("novice"), level("expert")];
        let [against, group] = levels.clone();
        let compared = GroupsCompared {
            column: "skill".parse().unwrap(),
            levels: levels.to_vec(),
            assigned: false,
            contrasts: vec![GroupContrast { group, against }],
        };
        let levels_of = (1..=8).map(|who| (format!("P{who:02}").parse().unwrap(), who % 2));
        let groups = Groups { compared, levels_of: levels_of.collect(), blocks: BTreeMap::new() };
        let parameters = CurveParameters { groups: Some(groups), ..parameters() };
        let found = compare_curves(&people(8), &parameters).unwrap();
        let named: Vec<String> = found
            .tests
            .iter()
            .filter(|test| test.groups.is_some() && test.n > 0)
            .map(|test| format!("{} {} {:?}", test.effect, test.n, test.n_second))
            .collect();
        let expected = ["mean over modes", "hybrid − active", "active", "hybrid"];
        assert_eq!(named, expected.map(|effect| format!("{effect} 4 Some(4)")));
        assert!(found.tests.iter().all(|test| test.verdict.is_none() == test.groups.is_some()));
    }
}
