// Effects of factors and differences between groups: a table like the matrix of modes, as the program has them.

const claimsOf = study.metrics.flatMap(({ claims }) => claims ?? []);
const claimKinds = [claimsOf.some(({ is_of_groups: isOfGroups }) => !isOfGroups) && "effect", claimsOf.some(({ is_of_groups: isOfGroups }) => isOfGroups) && "groups"].filter(Boolean).join(" or ");
const claimsTitle = { effect: "Effects of factors", groups: "Differences between groups" }[claimKinds] ?? "Effects of factors, and differences between groups";

/** Every claim by what it is measured by. */
function claimRows() {
  const rows = study.metrics.flatMap(({ claims }, index) => (claims ?? []).map((claim) => {
    const one = claim.jnd ?? claim.deviation;
    // A dot opens the traces of the first environment, in which the picker of environments stands.
    const conditions = claim.conditions ?? [], { environment, modes } = conditions[0] ?? {};
    const who = claim.n_against === null ? whoWords(claim) : `${claim.n}\u00a0and\u00a0${claim.n_against}\u00a0people`;
    return { ...claim, index, isSingle: false, one, by: claim.value === null || !(one > 0) ? "none" : claim.jnd === null ? "sd" : "jnd", place: claim.of, claim: claim.of, who, people: claim.people ?? [], conditions, opens: { e: environment, m: modes ?? [] }, left: "" };
  }));
  return ["jnd", "sd", "none"].flatMap((by) => rows.filter((row) => row.by === by));
}

/** Everybody's effect beside the means that it is made of; of groups a column for each. */
function claimDetails(row) {
  const metric = study.metrics[row.index], environment = row.environment === null ? null : environmentOf(row.environment);
  const title = environment ? short(environment.label, 24) : "Several environments";
  if (row.groups) {
    // Of people there are values, or of logarithms ratios where groups are compared in these.
    const [place, words] = row.is_of_ratios ? [placeOfDifference, differenceAt] : [placeOfValue, valueAt];
    const groups = row.groups.map(({ label, mean: middle, sd, values }) => {
      const [centre, low, high] = [0, -1, 1].map((side) => place(metric, (middle ?? NaN) + side * (side ? sd ?? NaN : 0)));
      return { label, mode: null, points: values.map((value) => ({ value: place(metric, value), words: `${label}: ${words(metric, place(metric, value))}` })), summary: { mean: centre, low, high } };
    });
    return [{ title: `${title}: groups, mean ± SD`, groups, lines: [], zero: false, areRatios: row.is_of_ratios }];
  }
  const points = row.people.map(({ participant: p, value }) => ({ value: placeOfDifference(metric, value), words: `${p}: ${differenceAt(metric, placeOfDifference(metric, value), row.is_of_ratios)}`, open: () => openTrials({ index: row.index, p, s: EVERY, ...row.opens, r: "all" }) }));
  const [middle, low, high] = [row.value, row.low, row.high].map((value) => placeOfDifference(metric, value ?? NaN));
  const charts = points.length ? [{ title: `${title}: everybody’s effect`, groups: [{ label: "effect", mode: null, points, summary: { mean: middle, low, high } }], lines: [], zero: true }] : [];
  const conditions = row.conditions.map(({ environment: id, modes }) => {
    const own = environmentOf(id), groups = dotGroups(own, row.index, sessionsOf.size > MANY).filter(({ mode }) => modes.includes(study.modes[mode].id));
    return { title: short(own.label, 24), groups, lines: sessionsOf.size === 1 ? [] : linesOf(groups), zero: false };
  });
  return [...conditions.filter(({ groups }) => groups.length), ...charts];
}

function claimsLegend() {
  const rows = claimRows();
  const family = { metric: "all claims about a metric", environment: "all claims about a metric in an environment", study: "all claims about primary metrics, and about each other metric" }[study.families];
  const scatter = { effect: "everybody’s effects", groups: "people within both groups" }[claimKinds] ?? "everybody’s effects, or of people within both groups";
  return [
    rows.some(({ by }) => by === "jnd") && "Grey band: within ±1 just noticeable difference (JND), below what is felt.",
    rows.some(({ by }) => by === "sd") && `Standard deviations are those of ${scatter}.`,
    `Disc and whiskers: mean and ${levelWords()} interval, not adjusted${rows.some(({ people }) => people.length) ? "; dots: people" : ""}. Verdicts are adjusted for ${family}${study.metrics.some(({ differences }) => differences.length) ? ", differences between modes among them" : ""} (${adjustmentWords()}).`,
    rows.some(({ groups }) => groups?.some(({ values }) => !values.length)) && "Of a group of fewer than three people no dots are shown.",
  ];
}

verdictTables.push({
  host: "claims",
  name: claimKinds === "groups" ? "groups" : "effects",
  title: claimsTitle.replace(/^./, (letter) => letter.toLowerCase()),
  label: claimsTitle,
  heading: () => claimsTitle,
  columns: [`environment, ${claimKinds}`, claimKinds === "groups" ? "mean and interval" : "everybody’s effect, mean and interval", "difference and verdict"],
  rows: claimRows,
  judged: (row) => [row.verdict, row.size].filter(Boolean).join(", ") + (row.remark ? `: ${row.remark}` : ""),
  dots: dotsOf,
  legend: claimsLegend,
  details: claimDetails,
  hint: { effect: `A name opens its metric, a dot the ${BEHIND} behind it.`, groups: "A name opens its metric and everybody’s values." }[claimKinds] ?? `A name opens its metric, a dot the ${BEHIND} behind it; of groups a name opens everybody’s values.`,
  isThere: () => claimsOf.length > 0,
});
