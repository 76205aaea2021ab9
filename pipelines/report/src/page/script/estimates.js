// Differences between modes, estimated again without what is left out: as the program's stage `compare` has them.

const leftOut = new Set(); // people by their code, trials by their path
const trialPath = ({ participant, session, trial }) => pathOf(participant, session, trial);
const counts = (trial) => !leftOut.has(trial.participant) && !leftOut.has(trialPath(trial));

/** ln Γ(x) for x > 0: Lanczos (1964, SIAM J. Numer. Anal. B 1:86), g = 7. */
function logGamma(x) {
  const terms = [676.5203681218851, -1259.1392167224028, 771.32342877765313, -176.61502916214059, 12.507343278686905, -0.13857109526572012, 9.9843695780195716e-6, 1.5056327351493116e-7];
  const at = x + 6.5;
  const sum = terms.reduce((total, term, i) => total + term / (x + i), 0.99999999999980993);
  return 0.5 * Math.log(2 * Math.PI) + (x - 0.5) * Math.log(at) - at + Math.log(sum);
}

/** The regularised incomplete beta function: its continued fraction (DLMF 8.17.22) by the rule of Lentz. */
function betaShare(x, a, b) {
  if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - betaShare(1 - x, b, a);
  const tiny = 1e-300, away = (value) => (Math.abs(value) < tiny ? tiny : value);
  let c = 1, d = 1 / away(1 - ((a + b) * x) / (a + 1)), fraction = d;
  for (let m = 1; m < 500; m++) {
    for (const term of [(m * (b - m) * x) / ((a + 2 * m - 1) * (a + 2 * m)), (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1))]) {
      d = 1 / away(1 + term * d);
      c = away(1 + term / c);
      fraction *= c * d;
    }
    if (Math.abs(c * d - 1) < 1e-15) break;
  }
  return (Math.exp(a * Math.log(x) + b * Math.log1p(-x) + logGamma(a + b) - logGamma(a) - logGamma(b)) * fraction) / a;
}

/** P(|T| ≥ |t|) for Student's t. */
const twoSided = (t, df) => betaShare(df / (df + t * t), df / 2, 0.5);
const upperTail = (t, df) => (t > 0 ? twoSided(t, df) / 2 : 1 - twoSided(t, df) / 2);

const criticals = new Map();
/** The t with P(|T| < t) = level. */
function critical(level, df) {
  const key = `${level} ${df}`;
  if (!criticals.has(key)) {
    let low = 0, high = 1;
    while (twoSided(high, df) > 1 - level) high *= 2;
    for (let i = 0; i < 80; i++) {
      const middle = (low + high) / 2;
      if (twoSided(middle, df) > 1 - level) low = middle; else high = middle;
    }
    criticals.set(key, (low + high) / 2);
  }
  return criticals.get(key);
}

/** Holm's adjusted p values, in their order. */
function holm(values) {
  const order = values.map((_, i) => i).sort((i, j) => values[i] - values[j]), adjusted = [];
  order.reduce((largest, index, rank) => (adjusted[index] = Math.max(largest, Math.min(1, (values.length - rank) * values[index]))), 0);
  return adjusted;
}

const ROUNDING = 1e-12; // a difference below this share of its terms is their rounding

/** Values of one environment and metric: by participant, then by session, then by mode. */
function cellsOf(index, environment, isIn = counts) {
  const cells = new Map();
  for (const trial of study.trials) {
    const value = trial.metrics[index];
    if (trial.environment !== environment || value === null || value === undefined || !isIn(trial)) continue;
    const sessions = cells.get(trial.participant) ?? cells.set(trial.participant, new Map()).get(trial.participant);
    const modes = sessions.get(trial.session) ?? sessions.set(trial.session, new Map()).get(trial.session);
    (modes.get(trial.mode) ?? modes.set(trial.mode, []).get(trial.mode)).push(value);
  }
  return cells;
}

const groupOf = (values) => ({ n: values.length, mean: mean(values), sd: values.length < 2 ? 0 : deviation(values) });

/** Everybody's difference: the mean over the sessions that have both modes, with the groups that it is made of. */
function peoplesDifferences(cells, { mode, against }) {
  return [...cells].flatMap(([participant, sessions]) => {
    const strata = [...sessions.values()].filter((modes) => modes.has(mode) && modes.has(against)).map((modes) => [mode, against].map((id) => groupOf(modes.get(id))));
    if (!strata.length) return [];
    const means = [0, 1].map((side) => mean(strata.map((pair) => pair[side].mean)));
    return [{ participant, strata, means, value: means[0] - means[1] }];
  });
}

/** Student's t over people's differences; nothing where there is no test. */
function testedOverPeople(people) {
  const bound = ROUNDING * Math.max(...people.flatMap(({ means }) => means.map(Math.abs)));
  let values = people.map(({ value }) => (Math.abs(value) <= bound ? 0 : value));
  if (values.every((value) => Math.abs(value - values[0]) <= bound)) values = values.map(() => values[0]);
  const error = deviation(values) / Math.sqrt(values.length);
  const largest = Math.max(...values.map(Math.abs)), plain = mean(values), middle = Math.abs(plain) <= ROUNDING * largest ? 0 : plain;
  return values.length < 2 || largest <= 0 || error <= 10 * Number.EPSILON * Math.abs(middle) ? null : { error, df: values.length - 1, middle };
}

/** Welch's t over the trials of one person, sessions as strata. */
function testedWithinOne({ strata, value }) {
  const groups = strata.flat(), shares = groups.map(({ n, sd }) => (sd * sd) / n / strata.length ** 2);
  const variance = shares.reduce((sum, share) => sum + share, 0);
  if (groups.some(({ n }) => n < 2) || variance <= 0) return null;
  return { error: Math.sqrt(variance), df: variance ** 2 / shares.reduce((sum, share, i) => sum + share ** 2 / (groups[i].n - 1), 0), middle: value };
}

/** A difference of the study without what is left out; nothing where nobody has both modes. */
function estimatedAgain(index, difference, cells, isSingle) {
  const people = peoplesDifferences(cells, difference);
  if (!people.length) return null;
  const largest = Math.max(...people.flatMap(({ means }) => means.map(Math.abs)));
  const plain = mean(people.map(({ value }) => value)), value = Math.abs(plain) <= ROUNDING * largest ? 0 : plain;
  const tested = isSingle ? testedWithinOne(people[0]) : testedOverPeople(people);
  const means = [0, 1].map((side) => mean(people.map((person) => person.means[side])));
  const again = { ...difference, value, means, people, n: isSingle ? people[0].strata.flat().reduce((sum, { n }) => sum + n, 0) : people.length, error: null, low: null, high: null, p: null, p_adjusted: null, p_not_equivalent: null, redrawn: [] };
  const [share, floor] = study.metrics[index].noticed ?? [0, 0];
  if (difference.jnd !== null && !difference.is_commanded) again.jnd = Math.max(share * Math.abs(means[1]), floor) || null;
  if (!tested) return again;
  const half = critical(study.level, tested.df) * tested.error;
  Object.assign(again, { error: tested.error, low: tested.middle - half, high: tested.middle + half });
  if (!isSingle) again.p = twoSided(tested.middle / tested.error, tested.df);
  const { bound } = difference;
  if (bound !== null) again.p_not_equivalent = Math.max(upperTail((tested.middle + bound) / tested.error, tested.df), upperTail((bound - tested.middle) / tested.error, tested.df));
  return again;
}

/** What the effects of a metric are without the people that are left out, as claims that share a family with differences. Where trials are left out their p is unknown: the page has everybody's effect over all trials. */
function effectsAgain(index) {
  const isKnown = study.trials.every((trial) => leftOut.has(trial.participant) || !leftOut.has(trialPath(trial)));
  return (study.metrics[index].claims ?? []).filter(({ p_adjusted: adjusted }) => adjusted !== null).map(({ environment, people = [] }) => {
    const left = people.filter(({ participant }) => !leftOut.has(participant)), tested = left.length ? testedOverPeople(left.map(({ value }) => ({ value, means: [value] }))) : null;
    return { index, environment, p: !isKnown ? NaN : tested && twoSided(tested.middle / tested.error, tested.df) };
  });
}

/** Verdicts of one family of claims, which shares alpha with `effects` (Holm) and with as many claims `elsewhere` (Bonferroni). One person's rest on the orders that the design could have drawn, which the program alone redraws. */
function judge(family, effects, isSingle, elsewhere) {
  const isUnknown = isSingle || effects.some(({ p }) => Number.isNaN(p));
  const claims = [...family, ...effects].filter(({ p }) => p !== null), share = (claims.length + elsewhere) / claims.length;
  if (!isUnknown) holm(claims.map(({ p }) => p)).forEach((p, i) => { claims[i].p_adjusted = Math.min(1, p * share); });
  for (const row of family) {
    const isEquivalent = row.p_not_equivalent !== null && row.p_not_equivalent < study.alpha;
    const isDifferent = row.p_adjusted !== null && row.p_adjusted < study.alpha;
    if (isUnknown) row.verdict = "not judged here";
    else if (row.p_adjusted === null) row.verdict = "not tested";
    else row.verdict = isDifferent ? (isEquivalent ? "different, within the bound" : "different") : isEquivalent ? "equivalent" : "undecided";
    const [low, high] = [row.low, row.high].map((end) => (end === null || row.jnd === null ? NaN : end / row.jnd));
    row.size = Number.isFinite(low) ? (low > 1 || high < -1 ? "felt" : low > -1 && high < 1 ? "below what is felt" : "may be felt") : null;
  }
}

/** Standard deviation of a mode over people; of one person's trials that within sessions. */
function deviationIn(cells, mode, isSingle) {
  const people = [...cells.values()].map((sessions) => [...sessions.values()].filter((modes) => modes.has(mode)).map((modes) => groupOf(modes.get(mode)))).filter((groups) => groups.length);
  if (!isSingle) return deviation(people.map((groups) => mean(groups.map((group) => group.mean))));
  const groups = people.flat(), spare = groups.reduce((sum, { n }) => sum + n - 1, 0);
  return spare ? Math.sqrt(groups.reduce((sum, { n, sd }) => sum + (n - 1) * sd * sd, 0) / spare) : NaN;
}

/** Every difference of the study with everybody's own, what it is measured by and what is said of it; those without a known just noticeable difference last. */
function verdictRows() {
  const isSingle = new Set(study.trials.filter(counts).map(({ participant }) => participant)).size === 1;
  // Groups have the same weight, and no code stands with a group on the page: such differences stay as the program has them.
  const isAgain = leftOut.size && !study.has_groups;
  const rows = study.metrics.flatMap((metric, index) => {
    const all = study.environments.flatMap(({ id }) => {
      const own = metric.differences.filter(({ environment }) => environment === id);
      if (!own.length) return [];
      const cells = cellsOf(index, id);
      return own.map((difference) => {
        const row = isAgain ? estimatedAgain(index, difference, cells, isSingle) : { ...difference, people: peoplesDifferences(cells, difference) };
        if (!row) return null;
        const sdOf = (mode) => metric.means.find((own) => own.environment === id && own.of === mode)?.sd ?? NaN;
        const sds = [row.mode, row.against].map((mode) => (study.has_groups ? sdOf(mode) : deviationIn(cells, mode, isSingle)));
        return { ...row, index, isSingle, sav: Math.sqrt((sds[0] ** 2 + sds[1] ** 2) / 2) };
      }).filter(Boolean);
    });
    return all;
  });
  if (isAgain) {
    const isClaim = ({ index }) => study.families === "study" && study.metrics[index].is_primary;
    const familyOf = (row) => (isClaim(row) ? "primary" : study.families === "environment" ? `${row.index} ${row.environment}` : String(row.index));
    const effects = groupBy(study.metrics.flatMap((_, index) => effectsAgain(index)), familyOf);
    for (const [name, family] of groupBy(rows, familyOf)) judge(family, effects.get(name) ?? [], isSingle, name === "primary" ? study.curve_claims : 0);
  }
  for (const row of rows) Object.assign(row, row.jnd !== null ? { by: "jnd", one: row.jnd } : { by: "sd", one: row.sav });
  // Where nothing varies, or nothing was repeated, there is no measure.
  for (const row of rows) if (!(row.one > 0)) row.by = "none";
  return ["jnd", "sd", "none"].flatMap((by) => rows.filter((row) => row.by === by));
}

const powerOf = (value, digits) => Number(value.toExponential(digits === undefined ? undefined : digits - 1).split("e")[1]);

/** Rounded digits, or where the value lies in the middle, which its long form shows, those that end with an even one: the program's rule. */
function even(text, long, places) {
  const kept = long.indexOf(".") + 1 + places, down = long.slice(0, kept).replace(/\.$/, "");
  return /^50*$/.test(long.slice(kept)) && /[02468]$/.test(down) ? down : text;
}

const fixed = (value, places) => even(value.toFixed(places), value.toFixed(Math.min(100, places + 30)), places);

function exponential(value, places) {
  const [[text, exponent], [long, before]] = [value.toExponential(places), value.toExponential(Math.min(100, places + 30))].map((number) => number.split("e"));
  return exponent === before ? [even(text, long, places), exponent] : [text, exponent];
}

const evenMultiple = (value, step) => (Math.abs((value / step) % 1) === 0.5 ? 2 * Math.round(value / step / 2) : Math.round(value / step)) * step;

/** A number to the two digits that its error allows, or to four where that is not known: the program's rule. */
function toDigits(value, error) {
  const isKnown = error !== null && error > 1e-9 * Math.abs(value);
  const last = isKnown ? powerOf(error, 2) - 1 : powerOf(value, 4) - 3, place = isKnown || powerOf(value, 4) >= 6 ? last : Math.min(last, 0);
  const digits = Math.max(0, powerOf(value) - place + 1), power = digits ? powerOf(value, digits) : place;
  let [mantissa, exponent] = [null, null];
  if (place >= -7 && power < 6) mantissa = place <= 0 ? fixed(value, -place) : fixed(evenMultiple(value, 10 ** place), 0);
  else if (!digits && Math.abs(value) > 0.5 * 10 ** place) [mantissa, exponent] = [value < 0 ? "-1" : "1", place];
  else if (!digits || value === 0) mantissa = "0";
  else [mantissa, exponent] = exponential(value, Math.abs(power - place));
  if (!isKnown && mantissa.includes(".") && Number(`${mantissa}e${exponent ?? 0}`) === value) mantissa = mantissa.replace(/\.?0+$/, "");
  if (!/[1-9]/.test(mantissa)) mantissa = mantissa.replace("-", "");
  const raised = exponent === null ? "" : `\u00a0×\u00a010${[...String(Number(exponent))].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("")}`;
  return minus(mantissa) + raised;
}

const withUnit = (text, unit) => (unit === "" ? text : unit === "°" ? `${text}°` : `${text}\u00a0${unit}`);

/** A difference in its unit, of logarithms as a ratio, with its interval where that speaks of people. */
function valueWords(row) {
  const metric = study.metrics[row.index], read = (value) => atPlace(metric, placeOfDifference(metric, value));
  const error = row.error === null ? null : row.error * (metric.is_logarithm ? read(row.value) : metric.scale);
  const text = (value) => toDigits(read(value), error);
  return (metric.is_logarithm ? timesWords(text(row.value), row.is_of_ratios) : withUnit(text(row.value), metric.unit)) + (row.isSingle || row.low === null ? "" : ` (${text(row.low)} to ${text(row.high)})`);
}

/** The mode that is better, where there is a difference and one way is better: of means of two signs neither is, but of logarithms. */
function bestOf({ index, verdict, means: [first, second], mode, against }) {
  const { better, is_logarithm: isLogarithm } = study.metrics[index], size = isLogarithm ? (value) => value : Math.abs;
  if (!verdict.startsWith("different") || better === "neither" || (better === "lower" && !isLogarithm && first * second < 0)) return null;
  return (better === "lower" ? size(first) < size(second) : first > second) ? mode : against;
}

/** What the tests show, whether it is felt, and which mode is better. */
function verdictWords(row) {
  const best = bestOf(row);
  const plant = leftOut.size && study.metrics[row.index].is_of_plant ? " (approximate: the program would fit the plant again)" : "";
  return `${row.verdict}${row.size ? `, ${row.size}` : ""}${plant}${best ? `: ${short(labelOf(study.modes, best), 24)} is better` : ""}`;
}
