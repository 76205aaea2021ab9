// Dots: a small SVG chart of categories, and one of two numbers.

const SHAPES = [ // the first three as the figures' markers
  (r) => `M${-r} 0A${r} ${r} 0 1 0 ${r} 0A${r} ${r} 0 1 0 ${-r} 0Z`, (r) => `M${-r} ${-r}H${r}V${r}H${-r}Z`, (r) => `M0 ${-1.3 * r}L${1.3 * r} 0L0 ${1.3 * r}L${-1.3 * r} 0Z`,
  (r) => `M0 ${-1.2 * r}L${1.2 * r} ${r}H${-1.2 * r}Z`, (r) => `M0 ${1.2 * r}L${1.2 * r} ${-r}H${-1.2 * r}Z`, (r) => `M${-r} ${-r / 3}H${-r / 3}V${-r}H${r / 3}V${-r / 3}H${r}V${r / 3}H${r / 3}V${r}H${-r / 3}V${r / 3}H${-r}Z`,
];
const MANY = 60; // participants from which dots are participants, not trials

const svgText = (text, x, y, extra = {}) => makeSvg("text", { x, y, ...extra }, text);
/** The same place for the same dot on every visit: steps of the golden ratio spread any number of dots evenly. */
const spread = (i) => ((i * 0.6180339887498949 + 0.5) % 1) - 0.5;

/** A point that says what it is and opens its trials, where it can be known which these are; `tell` shows the words to those who see. */
function point(x, y, { words, open, mode, shape = mode }, radius, tell) {
  const act = (event) => { event.preventDefault(); open(); };
  const acts = open ? { role: "button", onclick: act, onkeydown: (event) => (event.key === "Enter" || event.key === " ") && act(event) } : { role: "img" };
  return makeSvg("path", { d: SHAPES[shape % SHAPES.length](radius), transform: `translate(${x.toFixed(2)} ${y.toFixed(2)})`, class: "point", style: `--own: var(${mode === null ? "--quiet" : `--mode-${mode % MODE_COLOURS}`})`, tabindex: "-1", "aria-label": words, ...acts, onfocus: () => tell(words), onpointerenter: () => tell(words) });
}

/** One stop of the Tab key for all dots of a chart; arrows, Home and End go from dot to dot. */
function rove(chart) {
  const dots = [...chart.querySelectorAll(".point")];
  if (!dots.length) return;
  dots[0].setAttribute("tabindex", "0");
  chart.addEventListener("keydown", (event) => {
    const at = dots.indexOf(document.activeElement);
    const to = { ArrowRight: at + 1, ArrowDown: at + 1, ArrowLeft: at - 1, ArrowUp: at - 1, Home: 0, End: dots.length - 1 }[event.key];
    if (at < 0 || to === undefined) return;
    event.preventDefault();
    const next = dots[Math.max(0, Math.min(dots.length - 1, to))];
    dots[at].setAttribute("tabindex", "-1");
    next.setAttribute("tabindex", "0");
    next.focus();
  });
}

/** The frame of a chart: horizontal grid with numbers, and the scale of y. */
function chartFrame(title, width, height, left, yRange, labels = null) {
  const svg = makeSvg("svg", { viewBox: `0 0 ${width} ${height}`, class: "chart", role: "group", "aria-label": title });
  const box = { left, right: width - 10, top: 30, bottom: height - 40 };
  const sy = scale(yRange, box.bottom, box.top);
  svg.append(svgText(title, 4, 14, { class: "chart-title" }));
  for (const { value, text } of labels ?? ticks(...yRange, (box.bottom - box.top) / 34)) {
    const y = sy.k * value + sy.c;
    svg.append(makeSvg("line", { x1: box.left, x2: box.right, y1: y, y2: y, class: "grid" }), svgText(text, box.left - 6, y + 4, { "text-anchor": "end" }));
  }
  return { svg, box, sy };
}

/** Groups side by side: dots, thin lines of those that belong together, mean with its interval. */
function groupChart({ title, metric, width, groups, lines, yRange, zero, tell }) {
  const { svg, box, sy } = chartFrame(title, width, 300, 56, yRange, ticksOf(metric, ...yRange, 230 / 34));
  const step = (box.right - box.left) / groups.length;
  const centre = (g) => box.left + step * (g + 0.5);
  const place = (g, i) => centre(g) - Math.min(0.12 * step, 20) + spread(i) * Math.min(0.45 * step, 72);
  if (zero) svg.append(makeSvg("line", { x1: box.left, x2: box.right, y1: sy.c, y2: sy.c, class: "zero" }));
  const path = lines.map((line) => line.filter(({ y }) => Number.isFinite(y)).map(({ g, i, y }, k) => `${k ? "L" : "M"}${place(g, i).toFixed(1)} ${(sy.k * y + sy.c).toFixed(1)}`).join("")).join("");
  if (path) svg.append(makeSvg("path", { d: path, class: "pairs", opacity: Math.min(0.5, Math.max(0.03, 12 / lines.length)) }));
  groups.forEach((group, g) => {
    const crowd = group.points.length > 200;
    group.points.forEach((one, i) => svg.append(point(place(g, i), sy.k * one.value + sy.c, { ...one, mode: group.mode, shape: group.mode ?? g }, crowd ? 2 : 4.5, tell)));
    svg.append(svgText(short(group.label, Math.max(6, Math.floor(step / 7))), centre(g), box.bottom + 20, { "text-anchor": "middle", class: "group" }));
    const { mean: middle, low, high } = group.summary;
    if (!Number.isFinite(middle)) return;
    const x = centre(g) + Math.min(0.2 * step, 36), y = sy.k * middle + sy.c;
    if (Number.isFinite(low) && Number.isFinite(high)) svg.append(makeSvg("line", { x1: x, x2: x, y1: sy.k * low + sy.c, y2: sy.k * high + sy.c, class: "whisker" }));
    svg.append(makeSvg("circle", { cx: x, cy: y, r: 4, class: "mean" }), svgText(significant(atPlace(metric, middle)), x + 9, y + 4, { class: "value" }));
  });
  return svg;
}

/** Mean or difference with its interval as the tables have it, else of the drawn dots with their SD; and which it is. */
function summaryOf(estimates, place, environment, of, values) {
  const given = estimates.find((one) => one.environment === environment && one.of === of);
  if (given) {
    const [middle, low, high] = [given.value, given.low, given.high].map((value) => place(value ?? NaN));
    return { mean: middle, low, high, given: true };
  }
  const middle = values.length ? mean(values) : NaN, sd = deviation(values);
  return { mean: middle, low: middle - sd, high: middle + sd, given: false };
}

const metricTitle = ({ label, unit }) => `${short(label, 90)}${unit ? ` (${unit})` : ""}`;
/** Where a trial's value stands on an axis. */
const measured = (trial, index) => (trial.metrics[index] === null || trial.metrics[index] === undefined ? NaN : placeOfValue(study.metrics[index], trial.metrics[index]));
const trialWords = (trial) => `${trial.participant} ${trial.session}, trial ${trial.trial}, ${short(labelOf(study.modes, trial.mode))}, repeat ${trial.repeat}`;
const openTrial = (trial, index = null) => openTrials({ index, p: trial.participant, s: trial.session, e: trial.environment, m: [trial.mode], r: trial.repeat });

function groupBy(items, keyOf) {
  const groups = new Map();
  for (const item of items) {
    const key = keyOf(item);
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(item);
  }
  return groups;
}

/** Dots of one environment: trials, or means of participants where there are many. */
function dotGroups(environment, index, many) {
  const metric = study.metrics[index];
  return study.modes.map((mode, m) => {
    const trials = study.trials.filter((trial) => trial.environment === environment.id && trial.mode === mode.id && Number.isFinite(measured(trial, index)));
    const points = many
      ? [...groupBy(trials, (trial) => trial.participant)].map(([p, mine]) => ({ value: mean([...groupBy(mine, (trial) => trial.session).values()].map((own) => mean(own.map((trial) => measured(trial, index))))), of: p, words: `${p}, ${short(mode.label)}, mean of ${mine.length} trials`, open: () => openTrials({ index, p, s: EVERY, e: environment.id, m: [mode.id] }) }))
      : trials.map((trial) => ({ value: measured(trial, index), of: trial.participant, words: trialWords(trial), open: () => openTrial(trial, index) }));
    for (const one of points) one.words += `: ${valueAt(metric, one.value)}`;
    return { label: mode.label, mode: m, points, summary: summaryOf(metric.means, (value) => placeOfValue(metric, value), environment.id, mode.id, points.map((one) => one.value)) };
  }).filter((group) => group.points.length);
}

/** Differences of every two modes by participant; with one participant by repeat. */
function differenceGroups(environment, index, single) {
  const metric = study.metrics[index], place = (value) => placeOfDifference(metric, value), than = metric.is_logarithm ? "over" : "minus";
  const mine = study.trials.filter((trial) => trial.environment === environment.id && Number.isFinite(measured(trial, index)));
  const units = groupBy(mine, (trial) => `${trial.session}, repeat ${trial.repeat}`);
  const cells = cellsOf(index, environment.id, () => true);
  const pairs = study.modes.flatMap((from, i) => study.modes.slice(i + 1).map((to) => [from, to]));
  // A contrast is drawn the way round in which the tables have it.
  const asked = ([from, to]) => (metric.differences.some((one) => one.of === `${from.id} − ${to.id}`) ? [to, from] : [from, to]);
  return pairs.map(asked).map(([from, to]) => {
    const ofPeople = () => peoplesDifferences(cells, { mode: to.id, against: from.id }).map(({ participant: p, value }) => ({ value: place(value), words: `${p}, ${short(to.label)} ${than} ${short(from.label)}: ${differenceAt(metric, place(value))}`, open: () => openTrials({ index, p, s: EVERY, e: environment.id, m: [from.id, to.id], r: "all" }) }));
    const points = !single ? ofPeople() : [...units].flatMap(([unit, trials]) => {
      const of = ({ id }) => trials.filter((trial) => trial.mode === id).map((trial) => measured(trial, index));
      if (!of(from).length || !of(to).length) return [];
      const value = mean(of(to)) - mean(of(from));
      const [{ participant: p, session, repeat }] = trials;
      return [{ value, words: `${unit}, ${short(to.label)} ${than} ${short(from.label)}: ${differenceAt(metric, value)}`, open: () => openTrials({ index, p, s: session, e: environment.id, m: [from.id, to.id], r: repeat }) }];
    });
    const summary = summaryOf(metric.differences, place, environment.id, `${to.id} − ${from.id}`, points.map((one) => one.value));
    return { label: `${short(to.label, 12)} ${signOf(metric)} ${short(from.label, 12)}`, names: [short(to.label), short(from.label)], mode: study.modes.indexOf(to), points, summary };
  }).filter((group) => group.points.length);
}

/** How many of the people, or of the only one's repeats, have a difference of the more frequent sign. */
function everybodyWords(environment, { points, names: [mode, against] }, isSingle) {
  const higher = points.filter(({ value }) => value > 0).length, lower = points.filter(({ value }) => value < 0).length;
  if (!higher && !lower) return "";
  return `${short(environment.label, 30)}: ${higher >= lower ? "higher" : "lower"} with ${mode} than with ${against} in ${Math.max(higher, lower)} of ${points.length} ${isSingle ? "repeats" : points.length === 1 ? "person" : "people"}.`;
}

function rangeOfGroups(groups, withZero = false) {
  const values = finite(groups.flatMap((group) => [...group.points.map((one) => one.value), group.summary.low, group.summary.high, group.summary.mean]));
  const reach = (pick, start) => values.reduce((sofar, value) => pick(sofar, value), start);
  return padded(reach(Math.min, withZero ? 0 : Infinity), reach(Math.max, withZero ? 0 : -Infinity));
}

function buildDots(host) {
  const usable = study.metrics.map((metric, i) => i).filter((i) => study.trials.some((trial) => Number.isFinite(measured(trial, i))));
  if (!usable.length) return;
  const participants = sessionsOf.size;
  const [pick, select] = field("Metric", "dots-metric", draw);
  select.replaceChildren(...usable.map((i) => option(i, metricTitle(study.metrics[i]), false)));
  const charts = make("div", { class: "charts" }), tip = make("p", { class: "tip" }), note = make("p", { class: "caption" }), lead = make("p", { class: "lead" });
  const tell = (words) => { tip.textContent = words; };
  host.replaceChildren(make("div", { class: "controls" }, pick), lead, charts, tip, note);
  function draw() {
    const index = Number(select.value), metric = study.metrics[index], many = participants > MANY, single = participants === 1;
    const facets = study.environments.map((environment) => ({ environment, groups: dotGroups(environment, index, many), differences: differenceGroups(environment, index, single) })).filter(({ groups }) => groups.length);
    const range = rangeOfGroups(facets.flatMap(({ groups }) => groups)), apart = rangeOfGroups(facets.flatMap(({ differences }) => differences), true);
    const room = printing ? PAPER : charts.clientWidth, columns = room >= 640 ? 2 : 1, width = Math.max(260, room / columns - (columns - 1) * 12);
    charts.replaceChildren(...facets.flatMap(({ environment, groups, differences }) => [
      groupChart({ title: `${short(environment.label, 30)}${unitBehind(metric, false)}`, metric, width, groups, lines: single ? [] : linesOf(groups), yRange: range, tell }),
      differences.length ? groupChart({ title: `${short(environment.label, 24)}: differences${unitBehind(metric, true)}`, metric, width, groups: differences, lines: [], yRange: apart, zero: true, tell }) : make("div"),
    ]));
    charts.querySelectorAll("svg").forEach(rove);
    const all = facets.flatMap(({ groups, differences }) => [...groups, ...differences]);
    const bars = all.every(({ summary }) => summary.given) ? "Bars: mean and interval as in the tables." : all.some(({ summary }) => summary.given) ? "Bars: mean and interval as in the tables, else mean ± SD of the dots drawn." : "Bars: mean ± SD of the dots drawn.";
    lead.textContent = facets.flatMap(({ environment, differences }) => differences.map((group) => everybodyWords(environment, group, single))).join(" ");
    tip.textContent = "Point at a dot for its trial; Enter or a click opens it.";
    note.textContent = [metric.is_logarithm ? "Axes are logarithmic, and means geometric." : "", `${many ? "Dots: means of participants." : "Dots: trials."}`, bars, facets.every(({ differences }) => !differences.length) ? "" : single ? `Dots of differences: by repeat, within ${[...sessionsOf.keys()][0]}; nothing is said of anybody else.` : "Dots of differences: by participant, from each one's means."].join(" ");
  }
  draw();
  onWidth(charts, draw);
}

/** For each participant the way from mode to mode, through the first dot in each. */
function linesOf(groups) {
  const lines = new Map();
  groups.forEach((group, g) => {
    const means = groupBy(group.points.map((one, i) => ({ ...one, i })), (one) => one.of);
    for (const [of, mine] of means) lines.set(of, [...(lines.get(of) ?? []), { g, i: mine[0].i, y: mean(mine.map((one) => one.value)) }]);
  });
  return [...lines.values()];
}

/** Draws again when the width changes (not the height, which drawing itself changes). */
function onWidth(element, draw) {
  let width = element.clientWidth;
  redraws.add(draw);
  new ResizeObserver(() => {
    if (element.clientWidth === width || printing) return;
    width = element.clientWidth;
    requestAnimationFrame(draw);
  }).observe(element);
}
