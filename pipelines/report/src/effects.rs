//! What the comparison of factors says, in sentences.

use crate::compared::{Brief, ComparedMetric, before, explored};
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::{EffectDifference, FactorTest, Role, Verdict};
use zwidth_study::{Setup, counted};
use zwidth_tables::{number, p_value, with_unit};

/// First, of a primary metric without contrasts of modes, which effects were shown; then every effect in a
/// sentence, with interval and test; of factors with several levels, and their interactions, the line of the
/// analysis of variance too.
pub fn factor_effects(study: &Setup, metric: &ComparedMetric) -> Vec<Finding> {
    let words = metric.words(study.coordinate);
    let shown = || Shown::Effects(metric.metric.metric.to_string());
    let mut findings = Vec::new();
    if metric.contrasts.is_empty() && metric.metric.role == Role::Primary {
        // Weighted contrasts in an environment stand after the effects of all.
        let mut places: Vec<Vec<&EffectDifference>> = Vec::new();
        for row in metric.effects {
            match places.iter_mut().find(|place| place[0].environment == row.environment) {
                Some(place) => place.push(row),
                None => places.push(vec![row]),
            }
        }
        let answers = places.iter().filter_map(|effects| answer(study, metric, effects, &words));
        findings
            .extend(answers.map(|text| Finding { is_answer: true, ..Finding::new(text, shown()) }));
    }
    let effects = metric.effects.iter().map(|row| sentence(study, metric, row, &words));
    let lines = metric.factor_tests.iter().filter(|line| line.df_effect > 1.0);
    let lines = lines.map(|line| analysed(study, line, &words));
    findings.extend(effects.chain(lines).map(|text| Finding::new(text, shown())));
    findings
}

/// The effects on a metric that is not primary, in one sentence.
pub fn explored_effects(study: &Setup, metric: &ComparedMetric) -> Option<Finding> {
    let briefs = metric.effects.iter().map(|row| Brief {
        place: place(study, metric, row),
        difference: row.difference,
        error: row.difference_std_error,
        ends: row.difference_ci_low.zip(row.difference_ci_high),
        sides: row.sides(),
        verdict: row.verdict,
        size: row.size,
        remark: row.remark.as_ref(),
    });
    explored(study, metric, briefs.collect(), Shown::Effects(metric.metric.metric.to_string()))
}

/// `Spring, effect of motor (yes − no)`; of logarithms `(yes / no)`.
fn place(study: &Setup, metric: &ComparedMetric, row: &EffectDifference) -> String {
    let factors = row.effect.to_string().replace(':', " × ");
    let amounts = metric.amounts(study);
    let levels = row.levels.as_ref().map(|levels| amounts.compared(&levels.to_string()));
    let levels = levels.map(|levels| format!(" ({levels})")).unwrap_or_default();
    format!("{}effect of {factors}{levels}", before(study, row.environment.as_ref(), ", "))
}

/// `Spring, effects of factors on the force (8 participants). Shown: motor (yes − no: 0.45 N). Neither shown nor
/// excluded: brake (…).`; nothing where none is tested.
fn answer(
    study: &Setup,
    metric: &ComparedMetric,
    effects: &[&EffectDifference],
    words: &str,
) -> Option<String> {
    let amounts = metric.amounts(study);
    let listed = |verdicts: &[Verdict]| -> Option<String> {
        let rows: Vec<&&EffectDifference> =
            effects.iter().filter(|row| verdicts.contains(&row.verdict)).collect();
        let terms = rows.chunk_by(|a, b| a.effect == b.effect).map(|rows| {
            let each = rows.iter().filter_map(|row| {
                let error = row.difference_std_error;
                let amount = amounts.told(row.difference?, None, error, row.sides());
                let levels = row.levels.as_ref();
                let levels = levels.map(|own| format!("{}: ", amounts.compared(&own.to_string())));
                Some(levels.unwrap_or_default() + &amount.text)
            });
            let each: Vec<String> = each.collect();
            let values =
                if each.is_empty() { String::new() } else { format!(" ({})", each.join("; ")) };
            rows[0].effect.to_string().replace(':', " × ") + &values
        });
        let terms: Vec<String> = terms.collect();
        (!terms.is_empty()).then(|| terms.join(", "))
    };
    let lists = [
        ("Shown", listed(&[Verdict::Different, Verdict::DifferentBelowBound])),
        ("Shown to be too small to matter", listed(&[Verdict::Equivalent])),
        ("Neither shown nor excluded", listed(&[Verdict::Undecided])),
        ("Not tested", listed(&[Verdict::NotTested])),
    ];
    let is_tested = lists[..3].iter().any(|(_, list)| list.is_some());
    let people = counted(effects.iter().map(|row| row.n).max().unwrap_or_default(), "participants");
    let lists = lists.into_iter().filter_map(|(what, list)| Some(format!("{what}: {}", list?)));
    let lists: Vec<String> = lists.collect();
    is_tested.then(|| {
        format!(
            "{}effects of factors on {words} ({people}). {}.",
            before(study, effects[0].environment.as_ref(), ", "),
            lists.join(". ")
        )
    })
}

/// `Spring, motor: yes − no: the force is 0.45 N higher (…)`.
fn sentence(study: &Setup, metric: &ComparedMetric, row: &EffectDifference, words: &str) -> String {
    let amounts = metric.amounts(study);
    let place = place(study, metric, row);
    let why = match &row.remark {
        Some(remark) => format!("; {remark}"),
        None if row.verdict == Verdict::Undecided => {
            ", neither an effect nor its absence was shown".to_owned()
        }
        None => String::new(),
    };
    let Some(difference) = row.difference else {
        return format!("{place} on {words}: {}{why}.", row.verdict.as_str());
    };
    let ends = row.difference_ci_low.zip(row.difference_ci_high);
    let amount = amounts.told(difference, ends, row.difference_std_error, row.sides());
    let interval = amount.ends.map(|ends| format!("interval {ends}, "));
    let test = row
        .statistic
        .zip(row.df)
        .map(|(t, df)| format!(", t({}) = {}", number(df, None), number(t, None)));
    let p = row.p_adjusted.map(|p| format!(", adjusted p {}", p_value(p)));
    let sizes = [("g_av", row.g_av), ("g_z", row.g_z), ("d_av", row.d_av), ("d_z", row.d_z)];
    let mut sizes = sizes
        .into_iter()
        .filter_map(|(name, value)| Some(format!(", {name} = {}", number(value?, None))));
    let more: String = [test, p, sizes.next()].into_iter().flatten().collect();
    let size = row.size.map(|size| {
        let jnds = row.difference_jnd.map(|jnds| format!(": {} JND", number(jnds, None)));
        format!("; {}{}", size.as_str(), jnds.unwrap_or_default())
    });
    let turns = row.turns_at.map(|dose| {
        let unit = row.dose_unit.as_deref().unwrap_or("1");
        format!("; the parabola turns at about {}", with_unit(&number(dose, None), unit))
    });
    format!(
        "{place} on {words}: {} ({}{}{more}): {}{why}{}{}.",
        amount.text,
        interval.unwrap_or_default(),
        counted(row.n, "participants"),
        row.verdict.as_str(),
        size.unwrap_or_default(),
        turns.unwrap_or_default(),
    )
}

/// `Over all levels of visual × haptic: F(4, 116) = 84.66, ε = 0.80, p < 0.001, partial η² = 0.74`.
fn analysed(study: &Setup, line: &FactorTest, words: &str) -> String {
    format!(
        "{}all levels of {} in {words}: F({}, {}) = {}, Greenhouse and Geisser's ε = {}, p {}, partial η² = {} \
         ({} participants; a description, no claim).",
        before(study, line.environment.as_ref(), ", "),
        line.effect.to_string().replace(':', " × "),
        number(line.df_effect, None),
        number(line.df_error, None),
        number(line.f, None),
        number(line.epsilon_gg, None),
        p_value(line.p_gg),
        number(line.eta_squared_partial, None),
        line.n,
    )
}
