//! `[compare]` of a `study.toml`: its defaults, its checks, and the way back.

use super::check::Check;
use super::environment::EnvironmentTable;
use super::factors::default_effects;
use super::people::chosen_contrasts;
use super::shape::{BoundTable, CompareTable, WeightedTable};
use crate::{
    Analysis, Bound, Compare, Contrast, Curve, EffectSize, Factor, Families, MetricId, Mode,
    ModeId, PersonColumn, Primary, Study, Term,
};
use std::collections::{BTreeMap, BTreeSet};

/// As many nodes as a branch of a curve can have.
const CURVE_NODES: std::ops::RangeInclusive<usize> = 11..=401;

/// What of a study can be compared.
#[derive(Clone, Copy)]
pub(super) struct Comparable<'a> {
    pub(super) modes: &'a [Mode],
    pub(super) environments: &'a [EnvironmentTable],
    pub(super) factors: &'a [Factor],
    pub(super) people: &'a [PersonColumn],
}

impl Check<'_> {
    pub(super) fn compare(
        &mut self,
        table: CompareTable,
        comparable: &Comparable,
        analysis: &Analysis,
    ) -> Compare {
        let Comparable { modes, environments, factors, people } = *comparable;
        let is_primary_named = table.primary.is_some();
        let primary = table.primary.unwrap_or_else(|| Primary::One(MetricId::primary()));
        let alpha = table.alpha.unwrap_or(Compare::ALPHA);
        let level = table.level.unwrap_or(analysis.confidence);
        if !(alpha > 0.0 && alpha < 0.5) {
            let problem = format!("{alpha} must lie between 0 and 0.5, such as 0.05");
            self.error("compare.alpha", problem);
        }
        if table.level.is_some() && !(level > 0.0 && level < 1.0) {
            let problem = format!("{level} must lie between 0 and 1, such as 0.95");
            self.error("compare.level", problem);
        }
        let curves = self.each_once(
            "compare.curves",
            table.curves.unwrap_or_else(|| Compare::CURVES.to_vec()),
            Curve::as_str,
        );
        self.metrics(&primary, table.metrics.as_deref().unwrap_or_default(), &curves);
        let compared = |m: &MetricId| {
            primary.has(m.as_str())
                || table.metrics.as_ref().is_none_or(|others| others.contains(m))
        };
        for metric in table.better.keys().filter(|metric| !compared(metric)) {
            let problem = format!("'{metric}' is not compared; add it to compare.metrics");
            self.error(&format!("compare.better.{metric}"), problem);
        }
        let (over, covariates) = self.covariates(table.covariates, people);
        let effects = self.effects(table.effects, factors);
        let bounds = table.bounds.iter().map(|(m, b)| (m.clone(), self.bound(m, b, compared(m))));
        Compare {
            bounds: bounds.collect(),
            better: table.better,
            contrasts: match table.contrasts {
                Some(pairs) => self.contrasts(pairs, modes),
                None => default_contrasts(modes, &effects),
            },
            effects,
            trend: self.trends(table.trend, factors),
            weighted: self.weighted(table.weighted, factors, modes, environments),
            families: table.families.unwrap_or_else(|| default_families(&primary)),
            primary,
            is_primary_named,
            metrics: table.metrics,
            alpha,
            level,
            effect_sizes: self.each_once(
                "compare.effect_sizes",
                table.effect_sizes.unwrap_or_else(|| Compare::EFFECT_SIZES.to_vec()),
                EffectSize::as_str,
            ),
            curves,
            curve_nodes: self.curve_nodes(table.curve_nodes),
            groups: self.groups(table.groups, table.group_contrasts, people),
            covariates,
            over,
        }
    }

    /// A list of words that have none twice.
    fn each_once<T: PartialEq + Copy>(
        &mut self,
        key: &str,
        chosen: Vec<T>,
        word: fn(T) -> &'static str,
    ) -> Vec<T> {
        for (i, one) in chosen.iter().enumerate().filter(|(i, one)| chosen[..*i].contains(one)) {
            let problem = format!("'{}' stands twice; leave one out", word(*one));
            self.error(&format!("{key}[{i}]"), problem);
        }
        chosen
    }

    fn curve_nodes(&mut self, chosen: Option<usize>) -> usize {
        let nodes = chosen.unwrap_or(Compare::CURVE_NODES);
        if !CURVE_NODES.contains(&nodes) {
            let (least, most) = (CURVE_NODES.start(), CURVE_NODES.end());
            let problem = format!("{nodes} must lie between {least} and {most}, such as 101");
            self.error("compare.curve_nodes", problem);
        }
        nodes
    }

    fn contrasts(&mut self, pairs: Vec<[ModeId; 2]>, modes: &[Mode]) -> Vec<Contrast> {
        if pairs.is_empty() {
            let problem =
                "the list is empty; leave it out for the last mode against each other one";
            self.error("compare.contrasts", problem);
        }
        let ids: Vec<ModeId> = modes.iter().map(|mode| mode.id.clone()).collect();
        self.pairs("compare.contrasts", "mode", &pairs, &ids);
        pairs.into_iter().map(|[mode, against]| Contrast { mode, against }).collect()
    }

    /// Pairs of modes or groups: of two that there are, each pair once.
    pub(super) fn pairs<T: Ord + ToString>(
        &mut self,
        list: &str,
        what: &str,
        pairs: &[[T; 2]],
        ids: &[T],
    ) {
        let mut seen = BTreeSet::new();
        for (i, [first, second]) in pairs.iter().enumerate() {
            let [one, other] = [first, second].map(T::to_string);
            let unknown = [first, second].into_iter().find(|id| !ids.contains(id));
            let problem = if let Some(unknown) = unknown.map(T::to_string) {
                let ids: Vec<String> = ids.iter().map(T::to_string).collect();
                format!("there is no {what} '{unknown}'; there are {}", ids.join(", "))
            } else if first == second {
                format!("compares '{one}' with itself; name two {what}s")
            } else if !seen.insert([first.min(second), first.max(second)]) {
                format!("'{one}' and '{other}' stand twice; one contrast of two {what}s is enough")
            } else {
                continue;
            };
            self.error(&format!("{list}[{i}]"), problem);
        }
    }

    /// The primary metrics and curves, and the other metrics: each once.
    fn metrics(&mut self, primary: &Primary, others: &[MetricId], curves: &[Curve]) {
        let mut seen = BTreeSet::new();
        if primary.names().is_empty() {
            let problem = "the list is empty; name a metric, or leave it out for the default one";
            self.error("compare.primary", problem);
        }
        for (i, name) in primary.names().iter().enumerate() {
            let key = format!("compare.primary[{i}]");
            if !seen.insert(name) {
                self.error(&key, format!("'{name}' stands twice; leave one out"));
            }
            if Curve::from_word(name.as_str()).is_some_and(|curve| !curves.contains(&curve)) {
                self.error(&key, format!("'{name}' is not compared; add it to compare.curves"));
            }
        }
        for (i, metric) in others.iter().enumerate() {
            let key = format!("compare.metrics[{i}]");
            if primary.has(metric.as_str()) {
                let a = if matches!(primary, Primary::One(_)) { "the" } else { "a" };
                self.error(&key, format!("'{metric}' is {a} primary metric; leave it out here"));
            } else if Curve::from_word(metric.as_str()).is_some() {
                self.error(&key, format!("'{metric}' is a curve; name it in compare.curves"));
            } else if !seen.insert(metric) {
                self.error(&key, format!("'{metric}' stands twice; leave one out"));
            }
        }
        self.at_most_listed("compare.primary", primary.names().len());
        self.at_most_listed("compare.metrics", others.len());
    }

    fn bound(&mut self, metric: &MetricId, bound: &BoundTable, is_compared: bool) -> Bound {
        let key = format!("compare.bounds.{metric}");
        if !is_compared {
            let problem = format!("'{metric}' is not compared; add it to compare.metrics");
            self.error(&key, problem);
        }
        match *bound {
            BoundTable::Absolute(bound) => Bound::Absolute(self.positive(&key, bound)),
            BoundTable::Weber { weber } => {
                if !(weber > 0.0 && weber < 1.0) {
                    let problem =
                        format!("{weber} must be a share between 0 and 1, such as weber = 0.1");
                    self.error(&key, problem);
                }
                Bound::Weber(weber)
            }
        }
    }
}

/// The claims of all that is primary are one family: any of them can be wrong by chance.
fn default_families(primary: &Primary) -> Families {
    if primary.are_several() { Families::Study } else { Families::Metric }
}

/// The last of `modes` against each other one, in their order; none where effects of factors are compared.
fn default_contrasts(modes: &[Mode], effects: &[Term]) -> Vec<Contrast> {
    if !effects.is_empty() {
        return Vec::new();
    }
    let Some((last, others)) = modes.split_last() else { return Vec::new() };
    let pairs = others.iter().map(|other| (last.id.clone(), other.id.clone()));
    pairs.map(|(mode, against)| Contrast { mode, against }).collect()
}

/// Back to the table of the file: what is not the default.
pub(super) fn table(study: &Study) -> CompareTable {
    let compare = &study.compare;
    let contrasts = &compare.contrasts;
    let mut bounds = BTreeMap::new();
    for (metric, bound) in &compare.bounds {
        let bound = match *bound {
            Bound::Absolute(bound) => BoundTable::Absolute(bound),
            Bound::Weber(weber) => BoundTable::Weber { weber },
        };
        bounds.insert(metric.clone(), bound);
    }
    // To the last bit: what is left out is read back as the default.
    let [alpha, level] =
        [(compare.alpha, Compare::ALPHA), (compare.level, study.analysis.confidence)]
            .map(|(value, default)| (value.to_bits() != default.to_bits()).then_some(value));
    CompareTable {
        contrasts: (*contrasts != default_contrasts(&study.modes, &compare.effects))
            .then(|| contrasts.iter().map(|c| [c.mode.clone(), c.against.clone()]).collect()),
        primary: compare.is_primary_named.then(|| compare.primary.clone()),
        metrics: compare.metrics.clone(),
        alpha,
        level,
        families: (compare.families != default_families(&compare.primary))
            .then_some(compare.families),
        effect_sizes: (compare.effect_sizes != Compare::EFFECT_SIZES)
            .then(|| compare.effect_sizes.clone()),
        curves: (compare.curves != Compare::CURVES).then(|| compare.curves.clone()),
        curve_nodes: (compare.curve_nodes != Compare::CURVE_NODES).then_some(compare.curve_nodes),
        bounds,
        better: compare.better.clone(),
        groups: compare.groups.as_ref().map(|groups| groups.column.clone()),
        group_contrasts: compare.groups.as_ref().and_then(chosen_contrasts),
        covariates: compare
            .over
            .iter()
            .map(|over| over.as_str().to_owned())
            .chain(compare.covariates.iter().map(ToString::to_string))
            .collect(),
        effects: (compare.effects != default_effects(&study.factors))
            .then(|| compare.effects.clone()),
        trend: compare.trend.clone(),
        weighted: compare.weighted.iter().map(WeightedTable::of).collect(),
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, demo, text};
    use crate::{Bound, Curve, Families, Study, StudyError};

    /// The template's study with `[compare]` and what stands under it.
    fn with(compare: &str) -> Result<Study, Vec<StudyError>> {
        crate::tests::with("[compare]", compare)
    }

    fn pairs(study: &Study) -> Vec<(&str, &str)> {
        let contrasts = study.compare.contrasts.iter();
        contrasts.map(|c| (c.mode.as_str(), c.against.as_str())).collect()
    }

    fn metric(name: &str) -> crate::MetricId {
        name.parse().unwrap()
    }

    #[test]
    fn a_study_without_the_section_compares_its_last_mode_with_each_other_one() {
        let study = demo();
        assert_eq!(pairs(&study), [("hybrid", "active"), ("hybrid", "passive")]);
        let compare = &study.compare;
        assert_eq!(compare.primary.names(), [metric("discrepancy_user_mean_n")]);
        assert_eq!((compare.metrics.as_ref(), compare.bounds.len()), (None, 0));
        assert_eq!(compare.alpha.to_bits(), 0.05_f64.to_bits());
        assert_eq!(compare.level.to_bits(), 0.95_f64.to_bits());
        assert_eq!(compare.families, Families::Metric);
        assert!(!study.to_toml().unwrap().contains("compare"));
        assert_eq!(with("").unwrap(), study);
        let written = "contrasts = [[\"hybrid\", \"active\"], [\"hybrid\", \"passive\"]]\n\
            primary = \"discrepancy_user_mean_n\"\nalpha = 0.05\nlevel = 0.95\nfamilies = \"metric\"";
        let mut named = study;
        named.compare.is_primary_named = true;
        assert_eq!(with(written).unwrap(), named);
    }

    #[test]
    fn the_level_is_that_of_the_analysis_unless_it_is_given() {
        let text = text().replace("confidence = 0.95", "confidence = 0.99");
        let study = Study::from_toml(&text).unwrap();
        assert_eq!(study.compare.level.to_bits(), 0.99_f64.to_bits());
        let study = Study::from_toml(&(text + "\n[compare]\nlevel = 0.9\n")).unwrap();
        assert_eq!(study.compare.level.to_bits(), 0.9_f64.to_bits());
        check_round_trip(&study);
    }

    #[test]
    fn what_is_chosen_survives_a_round_trip() {
        let study = with(
            "contrasts = [[\"active\", \"passive\"]]\nprimary = \"wall_dwell_s\"\n\
             metrics = [\"discrepancy_user_mean_n\", \"loop_area_j\"]\nalpha = 0.01\nlevel = 0.9\n\
             families = \"environment\"\n[compare.bounds]\ndiscrepancy_user_mean_n = { weber = 0.1 }\n\
             wall_dwell_s = 1",
        )
        .unwrap();
        assert_eq!(pairs(&study), [("active", "passive")]);
        let bounds = &study.compare.bounds;
        assert_eq!(bounds[&metric("discrepancy_user_mean_n")], Bound::Weber(0.1));
        assert_eq!(bounds[&metric("wall_dwell_s")], Bound::Absolute(1.0));
        assert_eq!(study.compare.families, Families::Environment);
        check_round_trip(&study);
    }

    #[test]
    fn several_primary_metrics_are_one_family_unless_it_is_said_otherwise() {
        let study =
            with("primary = [\"wall_dwell_s\", \"loop_area_j\"]\nbounds.loop_area_j = 1").unwrap();
        let both = ["wall_dwell_s", "loop_area_j"].map(metric);
        assert_eq!(study.compare.primary.names(), both);
        assert_eq!(study.compare.families, Families::Study);
        check_round_trip(&study);
        let own =
            with("primary = [\"wall_dwell_s\", \"loop_area_j\"]\nfamilies = \"metric\"").unwrap();
        assert_eq!(own.compare.families, Families::Metric);
        check_round_trip(&own);
        let one = with("primary = [\"wall_dwell_s\"]").unwrap();
        assert_eq!(one.compare.families, Families::Metric);
        check_round_trip(&one);
    }

    #[test]
    fn a_curve_is_primary_beside_metrics_or_alone() {
        let study = with("primary = [\"force_over_angle\", \"loop_area_j\"]").unwrap();
        let primary = &study.compare.primary;
        assert!(primary.curves().eq([Curve::ForceOverAngle]));
        assert!(primary.metrics().eq([&metric("loop_area_j")]));
        assert_eq!(study.compare.families, Families::Study);
        check_round_trip(&study);
        let alone = with("primary = \"force_over_time\"\ncurves = [\"force_over_time\"]").unwrap();
        assert_eq!(alone.compare.primary.metrics().count(), 0);
        assert_eq!(alone.compare.families, Families::Metric);
        check_round_trip(&alone);
    }

    #[test]
    fn no_other_metric_is_a_choice_too() {
        let study = with("metrics = []").unwrap();
        assert_eq!(study.compare.metrics, Some(Vec::new()));
        check_round_trip(&study);
    }

    #[test]
    fn a_study_of_one_mode_has_no_contrast() {
        let text = text();
        let (before, rest) = text.split_once("[[modes]]").unwrap();
        let (mode, _) = rest.split_once("[[modes]]").unwrap();
        let (_, questions) = text.split_once("[[questions]]").unwrap();
        let one = format!("{before}[[modes]]{mode}[[questions]]{questions}");
        assert_eq!(pairs(&Study::from_toml(&one).unwrap()), []);
    }

    #[test]
    fn what_cannot_be_meant_is_one_error_with_value_and_remedy() {
        for (compare, key, words) in [
            ("contrasts = [[\"hybrid\", \"actve\"]]", "compare.contrasts[0]", "there are active"),
            ("contrasts = [[\"hybrid\", \"hybrid\"]]", "compare.contrasts[0]", "with itself"),
            (
                "contrasts = [[\"hybrid\", \"active\"], [\"active\", \"hybrid\"]]",
                "compare.contrasts[1]",
                "stand twice",
            ),
            ("contrasts = []", "compare.contrasts", "leave it out"),
            ("contrasts = [[\"hybrid\"]]", "contrasts", "invalid length 1"),
            ("primary = \"Force N\"", "primary", "not a valid metric id"),
            ("primary = []", "compare.primary", "the list is empty"),
            ("primary = 1", "primary", "a metric or a curve, or a list of such"),
            ("primary = [\"a_s\", \"B c\"]", "primary", "not a valid metric id"),
            ("primary = [\"a_s\", \"a_s\"]", "compare.primary[1]", "'a_s' stands twice"),
            (
                "primary = \"force_over_time\"",
                "compare.primary[0]",
                "'force_over_time' is not compared; add it to compare.curves",
            ),
            (
                "metrics = [\"force_over_angle\"]",
                "compare.metrics[0]",
                "'force_over_angle' is a curve; name it in compare.curves",
            ),
            (
                "primary = [\"a_s\", \"b_s\"]\nmetrics = [\"b_s\"]",
                "compare.metrics[0]",
                "is a primary metric",
            ),
            (
                "metrics = [\"discrepancy_user_mean_n\"]",
                "compare.metrics[0]",
                "is the primary metric",
            ),
            ("metrics = [\"a_s\", \"a_s\"]", "compare.metrics[1]", "'a_s' stands twice"),
            ("alpha = 0.5", "compare.alpha", "0.5 must lie between 0 and 0.5"),
            ("alpha = nan", "compare.alpha", "must lie"),
            ("level = 95.0", "compare.level", "95 must lie between 0 and 1"),
            ("families = \"all\"", "families", "unknown variant"),
            ("curves = [\"force\"]", "curves", "unknown variant `force`"),
            (
                "curves = [\"theta_over_time\", \"theta_over_time\"]",
                "compare.curves[1]",
                "'theta_over_time' stands twice",
            ),
            ("curve_nodes = 10", "compare.curve_nodes", "10 must lie between 11 and 401"),
            ("bounds.a_s = 0.0", "compare.bounds.a_s", "above 0"),
            ("bounds.a_s = -inf", "compare.bounds.a_s", "above 0"),
            ("bounds.a_s = { weber = 10.0 }", "compare.bounds.a_s", "10 must be a share"),
            ("bounds.a_s = \"ten\"", "bounds.a_s", "{ weber = 0.1 }"),
            ("metrics = []\nbounds.a_s = 1.0", "compare.bounds.a_s", "add it to compare.metrics"),
            ("contrast = 1", "contrast", "unknown field"),
        ] {
            check_refused(with(compare), key, words);
        }
    }
}
