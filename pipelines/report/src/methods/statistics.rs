//! How modes, sessions and answers are compared, in words.

use super::recorded::{Recorded, plain};
use super::sources::Cited;
use zwidth_study::{
    Bound, Curve, DoseScale, Effect, EffectSize, FactorOf, Families, GroupsCompared, LevelId,
    MetricId, OverTrials, Study, TaskQuantity, contrast_label, curve_label,
};

pub(super) fn paragraphs(study: &Study, recorded: &Recorded, cited: &mut Cited) -> Vec<String> {
    if recorded.compared.is_empty() {
        return recorded.guesses.then(|| guesses(recorded, cited)).into_iter().collect();
    }
    let mut sentences = vec![compared(study, recorded)];
    sentences.push(if recorded.participants > 1 {
        between(study, recorded, cited)
    } else if study.compare.contrasts.is_empty() {
        "With one participant effects are a description of this participant alone: nothing was tested.".to_owned()
    } else {
        // One participant: trials are the units.
        format!(
            "With one participant the units were trials, and every number describes this participant alone. \
             Claims rest on a randomisation test of the null that no trial depended on its mode: 9,999 \
             orders were drawn anew by the rules that drew the actual one {}. Welch's interval {} with \
             sessions as strata stands beside it as a description.",
            cited.cite("edgington"),
            cited.cite("welch")
        )
    });
    sentences.extend(study.compare.over.map(adjusted));
    sentences.push(claims(study, recorded, cited));
    if recorded.curves {
        sentences.push(curves(study, recorded, cited));
    }
    if recorded.answers {
        sentences.push(answers(recorded, cited));
    }
    if recorded.guesses {
        sentences.push(guesses(recorded, cited));
    }
    if recorded.sessions > recorded.participants && recorded.participants > 1 {
        sentences.push(format!(
            "Sessions were compared with each participant's first by limits of agreement {} and \
             intraclass correlation {}.",
            cited.cite("bland"),
            cited.cite("mcgraw")
        ));
    }
    sentences
}

fn compared(study: &Study, recorded: &Recorded) -> String {
    let contrasts = study.compare.contrasts.iter();
    let contrasts: Vec<String> = contrasts.map(|own| contrast_label(&study.modes, own)).collect();
    let primary = &study.compare.primary;
    let others = recorded.compared.iter().filter(|name| !primary.has(name));
    let others: Vec<&str> = others.map(|name| recorded.in_words(name)).collect();
    let exploratory = match others.as_slice() {
        [] => String::new(),
        others => format!(" Exploratory measures were {}.", others.join("; ")),
    };
    let (mut existing, mut missing) = (Vec::new(), Vec::new());
    for metric in primary.metrics() {
        let is_compared = recorded.compared.iter().any(|name| name == metric.as_str());
        let list = if is_compared { &mut existing } else { &mut missing };
        list.push(recorded.in_words(metric.as_str()).to_owned());
    }
    for curve in primary.curves() {
        let list = if recorded.curves { &mut existing } else { &mut missing };
        list.push(curve_label(curve, study.coordinate));
    }
    let measures = match existing.as_slice() {
        [] => String::new(),
        [one] => format!(" The primary measure was {one}."),
        several => format!(" The primary measures were {}.", several.join("; ")),
    };
    let missing = missing.iter().map(|words| {
        let the = if primary.are_several() { "A" } else { "The" };
        format!(" {the} primary measure ({words}) does not exist in these data.")
    });
    let differences = match contrasts.as_slice() {
        [] => String::new(),
        all => format!(
            "These differences between modes were compared in each environment: {}.",
            all.join(", ")
        ),
    };
    let sentences = [factors(study), differences, measures, missing.collect(), exploratory];
    sentences
        .map(|sentence| sentence.trim_start().to_owned())
        .into_iter()
        .filter(|s| !s.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The factors of the design, and which of their effects were compared.
fn factors(study: &Study) -> String {
    let mut text = String::new();
    let factors = study.factors.iter().map(|factor| {
        let levels: Vec<&str> = factor.levels.iter().map(LevelId::as_str).collect();
        let of = match factor.of {
            FactorOf::Modes => "of modes",
            FactorOf::Environments => "of environments",
            FactorOf::Sessions => "of sessions",
        };
        let unit = factor.unit.as_deref().filter(|unit| *unit != "1");
        let unit = unit.map(|unit| format!(" {unit}")).unwrap_or_default();
        format!("{} ({of}; {}{unit})", factor.id, levels.join(", "))
    });
    let factors: Vec<String> = factors.collect();
    text += &match factors.as_slice() {
        [] => String::new(),
        [one] => format!("The factor of the design was {one}."),
        several => format!("The factors of the design were {}.", several.join(", ")),
    };
    let effects: Vec<String> =
        study.compare.effects.iter().map(|term| term.to_string().replace(':', " × ")).collect();
    if !effects.is_empty() {
        let over_all = study.factors.iter().any(|factor| factor.of == FactorOf::Environments);
        let place = if over_all { "over all environments" } else { "in each environment" };
        let has_words = study.factors.iter().any(|factor| factor.unit.is_none());
        let later = if has_words { ": every later level less the first" } else { "" };
        let (the, was) =
            if effects.len() == 1 { ("The effect of", "was") } else { ("The effects of", "were") };
        text += &format!(
            " {the} {} {was} compared {place} as weighted sums of each participant's means, other factors averaged{later}.",
            effects.join(", ")
        );
    }
    for factor in study.factors.iter().filter(|own| own.unit.is_some() && !effects.is_empty()) {
        let trend = study.compare.trend.get(&factor.id).copied().unwrap_or_default();
        let bend = if trend.degree > 1 { ", and the bend of their parabola" } else { "" };
        let scale = if trend.scale == DoseScale::Log2 { ", over its doublings" } else { "" };
        let one = if trend.degree > 1 { "a bend" } else { "one" };
        text += &format!(
            " That of {} is the slope of each participant's own line by least squares{bend}{scale}; who lacked a level \
             has {one} if {} or more are left whose spread makes it at least half as certain.",
            factor.id,
            trend.degree + 2
        );
    }
    for weighted in &study.compare.weighted {
        let weights = weighted.weights.iter().map(|weight| {
            let session = weight.session.as_ref().map(|id| format!("{id}/")).unwrap_or_default();
            format!("{} × {session}{}/{}", plain(weight.weight), weight.environment, weight.mode)
        });
        text += &format!(
            " The contrast {} weighed the conditions {}.",
            weighted.id,
            weights.collect::<Vec<_>>().join(", ")
        );
    }
    text
}

/// Several participants: each gives one difference.
fn between(study: &Study, recorded: &Recorded, cited: &mut Cited) -> String {
    let again = recorded.sessions > recorded.participants;
    let sessions = if again { ", then the sessions" } else { "" };
    let has_contrasts = !study.compare.contrasts.is_empty();
    let test = match &study.compare.groups {
        None => of_one_group(has_contrasts, recorded, cited),
        Some(groups) => of_groups(groups, has_contrasts, cited),
    };
    let effects = effects(&study.compare.effect_sizes, has_contrasts, cited);
    let all = study.effects();
    let is_analysed = |effect: &Effect| {
        let factors = study.factors.iter().filter(|factor| effect.term.0.contains(&factor.id));
        effect.lacks.is_none() && factors.clone().any(|factor| factor.levels.len() > 2)
    };
    let variance = match all.iter().any(is_analysed) {
        true => format!(
            " Beside the effects of factors with several levels stands their analysis of variance, each with its \
             own error and Greenhouse and Geisser's degrees of freedom {}.",
            cited.cite("greenhouse")
        ),
        false => String::new(),
    };
    let each = if has_contrasts { "one difference" } else { "one value of each effect" };
    let model = match has_contrasts {
        true => format!(
            " A mixed model with participant and participant × mode as random effects was fitted to all trials by \
             REML, with Kenward–Roger degrees of freedom {}; no claim rests on it.",
            cited.cite("kenward")
        ),
        false => String::new(),
    };
    format!(
        "The unit of analysis was the participant: each one's repeats were averaged{sessions}, \
         and each participant gave {each}. {test}.{effects}{variance}{model}"
    )
}

/// How differences were tested where participants are of no groups.
fn of_one_group(has_contrasts: bool, recorded: &Recorded, cited: &mut Cited) -> String {
    let flips = cited.cite("fisher");
    // The order in which others drew their trials is not known.
    let beside = match (has_contrasts, recorded.is_foreign()) {
        (false, _) => format!("beside it stands the sign-flip test {flips}"),
        (true, true) => {
            let ranks = cited.cite("wilcoxon");
            format!("beside it stand the sign-flip test {flips} and the signed-rank test {ranks}")
        }
        (true, false) => format!(
            "beside it stand the sign-flip test {flips}, the signed-rank test {} and a randomisation test over \
             the orders that the design could have drawn {}",
            cited.cite("wilcoxon"),
            cited.cite("edgington")
        ),
    };
    format!("Its mean was tested by Student's t with n − 1 degrees of freedom; {beside}")
}

/// How means were adjusted for practice.
fn adjusted(over: OverTrials) -> String {
    let over = match over {
        OverTrials::Trial => "number of the trial",
        OverTrials::Repeat => "repeat",
    };
    format!(
        "Means were adjusted along each participant's own line over the {over} in each environment, by least squares besides the \
         means of the modes; no claim was made where that made the variance of a difference more than five times larger."
    )
}

/// How groups of participants were compared.
fn of_groups(groups: &GroupsCompared, has_contrasts: bool, cited: &mut Cited) -> String {
    let (differences, one) = match has_contrasts {
        true => ("Differences between modes", "difference"),
        false => ("Effects", "effect"),
    };
    let levels: Vec<&str> = groups.levels.iter().map(LevelId::as_str).collect();
    let contrasts: Vec<String> = groups.contrasts.iter().map(ToString::to_string).collect();
    let chosen = if groups.assigned { "assigned by chance" } else { "not assigned by chance" };
    format!(
        "Participants were of the groups {} ({}, {chosen}). {differences} were averaged over groups with \
         the same weight each and tested with Satterthwaite's degrees of freedom {}. Groups were compared ({}) by \
         Welch's t test {}, in the mean over modes and in every {one}, with a claim from four \
         participants in each group on; beside it stands |t| over permuted labels {}",
        levels.join(", "),
        groups.column,
        cited.cite("satterthwaite"),
        contrasts.join(", "),
        cited.cite("welch"),
        cited.cite("chung"),
    )
}

/// What the effect sizes are.
fn effects(sizes: &[EffectSize], have_intervals: bool, cited: &mut Cited) -> String {
    if sizes.is_empty() {
        return String::new();
    }
    let mut text = String::new();
    if sizes.iter().any(|size| matches!(size, EffectSize::GAv | EffectSize::DAv)) {
        text += &format!(
            " d_av is the difference divided by the square root of the mean of the modes' variances \
             between participants {}.",
            cited.cite("cumming")
        );
    }
    if sizes.iter().any(|size| matches!(size, EffectSize::GZ | EffectSize::DZ)) {
        text += " d_z is the difference divided by the standard deviation of the participants' differences.";
    }
    if sizes.iter().any(|size| matches!(size, EffectSize::GAv | EffectSize::GZ)) {
        text += &format!(
            " As g they are without their bias in small samples {}.",
            cited.cite("hedges")
        );
    }
    text + if have_intervals {
        " Their intervals are those of the noncentral t distribution."
    } else {
        ""
    }
}

fn claims(study: &Study, recorded: &Recorded, cited: &mut Cited) -> String {
    let compare = &study.compare;
    let has_several = compare.primary.are_several();
    let family = match compare.families {
        Families::Study if has_several => "of all primary measures over all environments",
        Families::Metric | Families::Study => "over all environments",
        Families::Environment => "in one environment",
    };
    let the = if has_several { "a" } else { "the" };
    let has_groups = compare.groups.is_some() && recorded.participants > 1;
    let has_effects = !(study.factors.is_empty() && compare.weighted.is_empty());
    let claimed = match (compare.contrasts.is_empty(), has_effects, has_groups) {
        (true, true, false) => "effects ",
        (true, true, true) => "effects and the contrasts of groups ",
        (false, true, true) => "effects and the contrasts of modes and of groups ",
        (false, true, false) => "effects and contrasts ",
        (_, false, true) => "contrasts of modes and of groups ",
        (_, false, false) => "contrasts ",
    };
    let mut text = format!(
        "A difference of {the} primary measure was claimed where its p value, adjusted over the \
         {claimed}{family} by Holm's method {}, was below {}; intervals are at {} % and not adjusted.",
        cited.cite("holm"),
        plain(compare.alpha),
        plain(100.0 * compare.level)
    );
    let are_both = compare.primary.metrics().next().and(compare.primary.curves().next()).is_some();
    if are_both && compare.families == Families::Study {
        text += " Whole curves that are primary were a family of their own, and both families had their share of the level \
                 (Bonferroni).";
    }
    if !compare.bounds.is_empty() {
        let bounds = compare.bounds.iter().map(|(metric, bound)| {
            let amount = match bound {
                // Differences of logarithms are ratios: as much less as more.
                Bound::Absolute(value) if is_logarithm(study, metric) => {
                    format!("a factor of {} either way", plain(libm::exp(*value)))
                }
                Bound::Absolute(value) => plain(*value),
                Bound::Weber(share) => format!("{} % of the commanded value", plain(100.0 * share)),
            };
            format!("{amount} ({})", recorded.in_words(metric.as_str()))
        });
        text += &format!(
            " Equivalence was tested by two one-sided tests {} against the bounds {}.",
            cited.cite("schuirmann"),
            bounds.collect::<Vec<_>>().join(", ")
        );
    }
    text
}

/// Whether the values of a metric are natural logarithms.
fn is_logarithm(study: &Study, metric: &MetricId) -> bool {
    let metric = study.task_metric(metric.as_str());
    metric.is_some_and(|(_, quantity)| quantity == TaskQuantity::Jnd)
}

/// How whole curves were compared.
fn curves(study: &Study, recorded: &Recorded, cited: &mut Cited) -> String {
    let compare = &study.compare;
    let curves: Vec<String> =
        compare.curves.iter().map(|curve| curve_label(*curve, study.coordinate)).collect();
    let each =
        if compare.curves.iter().any(|curve| curve.is_over_angle()) { " of each way" } else { "" };
    let groups = match &compare.groups {
        Some(_) => format!(
            " Between groups Welch's t was taken and labels were permuted {}; these are descriptions.",
            cited.cite("chung")
        ),
        None => String::new(),
    };
    let primary: Vec<Curve> = compare.primary.curves().collect();
    let is_joined = compare.families == Families::Study && !primary.is_empty();
    let family = match compare.families {
        Families::Environment => "the comparisons of a curve in an environment",
        Families::Study if is_joined => {
            "all comparisons of primary curves, and those of each other curve"
        }
        Families::Metric | Families::Study => "all comparisons of a curve",
    };
    let role = if primary.is_empty() {
        "; they are exploratory".to_owned()
    } else if primary.len() == compare.curves.len() {
        String::new()
    } else {
        let primary = primary.iter().map(|curve| curve_label(*curve, study.coordinate));
        format!(
            "; all but those of the primary ones ({}) are exploratory",
            primary.collect::<Vec<_>>().join("; ")
        )
    };
    if recorded.participants == 1 {
        return format!(
            "Whole curves ({}) of trials were compared at {} nodes{each} that all trials of an environment reach. The largest \
             |t| of Welch over all nodes was compared with those in other orders that the design could have drawn {}: the \
             hypothesis is that no trial's curve depended on mode. p values were adjusted by Holm's method over \
             {family}{role}. Intervals are pointwise and describe the trials.",
            curves.join("; "),
            compare.curve_nodes,
            cited.cite("edgington"),
        );
    }
    format!(
        "Whole curves ({}) were compared at {} nodes{each} that all participants reach in all modes of a comparison. The \
         largest |t| of the participants' differences over all nodes was compared with that of other signs of their \
         curves {}: of all of them up to 14 participants, else of 9,999; with fewer than six no difference was \
         claimed, and intervals are pointwise. Where the median skewness over nodes exceeded 0.7 the larger p of this and of the largest mean \
         difference, not divided by its standard error, counted. p values were adjusted by Holm's method over \
         {family}{role}. Bands cover the whole curve: their width is from flips of the differences from their mean. Runs of |t| \
         above its pointwise critical value were tested by their sum of |t| {}, not adjusted; they say that there is a \
         difference somewhere in them {}.{groups}",
        curves.join("; "),
        compare.curve_nodes,
        cited.cite("nichols"),
        cited.cite("maris"),
        cited.cite("sassenhagen"),
    )
}

fn guesses(recorded: &Recorded, cited: &mut Cited) -> String {
    let over = match recorded.participants {
        0 | 1 => "",
        _ => ", and averaged over participants with Student's t interval",
    };
    format!(
        "How far participants knew the mode is told by a blinding index: the mean over a participant's trials \
         of a mode of 1 where the mode was named, −1/(k − 1) where another one was, and 0 for “do not know”, \
         with k modes to choose from{over}. For two modes this is the index of Bang and others {}; the \
         form for more is this program's own.",
        cited.cite("bang")
    )
}

fn answers(recorded: &Recorded, cited: &mut Cited) -> String {
    let tally = "Answers are ordinal: they were counted, and two modes compared by P(A > B) + ½ P(A = B) over \
                 pairs of repeats";
    if recorded.participants < 2 {
        return format!("{tally}.");
    }
    format!(
        "{tally}, averaged over participants; beside it stands the odds ratio of a cumulative-logit model \
         with participant and participant × mode as random effects {}.",
        cited.cite("hedeker")
    )
}
