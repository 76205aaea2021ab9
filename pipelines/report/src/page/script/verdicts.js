// Tables of verdicts: every difference over what a person can feel. A dot opens its person's traces, a row its metric; from the matrix of modes people and trials can be left out.

const ROW = { height: 36, middle: 12, dots: 26, pad: 10 };
const matrix = { open: null };
const BEHIND = byId("browser") ? "traces" : "answers"; // what a dot opens
/** The tables: what differs by mode; the script's part about effects and groups adds theirs. */
const verdictTables = [{
  host: "verdict-matrix",
  name: "verdicts",
  title: "differences between modes",
  label: "Every difference between modes",
  columns: ["environment, modes", () => (sessionsOf.size === 1 ? "difference of each repeat, mean" : "everybody’s difference, mean and interval"), "difference and verdict"],
  rows: () => verdictRows().map((row) => ({ ...row, place: placeOf(row), claim: row.of, who: whoWords(row), opens: { e: row.environment, m: [row.mode, row.against] }, left: [...leftOut].join(" ") })),
  judged: verdictWords,
  dots: dotsOf,
  legend: modesLegend,
  details: modesDetails,
  hint: `A name opens its metric, a dot the ${BEHIND} behind it.`,
  isThere: () => study.metrics.some(({ differences }) => differences.length),
  isExplored: true,
}];
const rowKey = (row) => [study.metrics[row.index].name, row.environment, row.claim].join("/");
const placeOf = (row) => `${labelOf(study.environments, row.environment)}: ${labelOf(study.modes, row.mode)} ${signOf(study.metrics[row.index])} ${labelOf(study.modes, row.against)}`;
const whoWords = (row) => `${row.n}\u00a0${row.isSingle ? "trials" : row.n === 1 ? "person" : "people"}`;
const openRowLine = () => document.querySelector(".verdicts tr.detail");

/** The dots of a row: people, or of the only one the repeats that both modes have. */
function dotsOf(row) {
  const metric = study.metrics[row.index];
  const words = (who, value) => `${who}: ${differenceAt(metric, placeOfDifference(metric, value), row.is_of_ratios)}`;
  const open = (p, s, r) => ({ index: row.index, p, s, ...row.opens, r });
  if (!row.isSingle) return row.people.map(({ participant: p, value }) => ({ value, words: words(p, value), view: open(p, EVERY, "all") })).sort((a, b) => a.value - b.value);
  const mine = study.trials.filter((trial) => trial.environment === row.environment && counts(trial) && trial.metrics[row.index] !== null);
  const repeats = groupBy(mine, ({ repeat }) => repeat);
  return [...repeats].flatMap(([repeat, trials]) => {
    const [first, second] = [row.mode, row.against].map((mode) => trials.filter((trial) => trial.mode === mode).map((trial) => trial.metrics[row.index]));
    if (!first.length || !second.length) return [];
    const value = mean(first) - mean(second);
    return [{ value, words: words(`repeat ${repeat}`, value), view: open(trials[0].participant, sessionsOf.get(trials[0].participant).size > 1 ? EVERY : trials[0].session, repeat) }];
  }).sort((a, b) => a.value - b.value);
}

/** The scale that rows measured by the same share: all that is drawn, zero and the band of what is not felt. */
function sharedRange(rows) {
  const values = rows.flatMap((row) => [...row.dots.map(({ value }) => value), row.value, row.isSingle ? NaN : row.low ?? NaN, row.isSingle ? NaN : row.high ?? NaN, ...(row.isSingle ? row.redrawn ?? [] : [])].map((value) => value / row.one)).filter(Number.isFinite);
  const felt = rows[0].by === "jnd" ? 1.2 : 0;
  return padded(values.reduce((a, b) => Math.min(a, b), -felt), values.reduce((a, b) => Math.max(a, b), felt));
}

/** What a row draws, into any SVG, from y = 0 on. */
function drawRow(row, sx) {
  const x = (value) => (sx.k * value) / row.one + sx.c;
  const ring = (at, y, r) => `M${(at - r).toFixed(1)} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
  const parts = [];
  if (row.by === "jnd") parts.push(makeSvg("rect", { x: sx.c - sx.k, y: -6, width: 2 * sx.k, height: ROW.height + 12, class: "unfelt" }));
  parts.push(makeSvg("line", { x1: sx.c, x2: sx.c, y1: -6, y2: ROW.height + 6, class: "none" }));
  if (row.isSingle && row.redrawn?.length) parts.push(makeSvg("path", { d: row.redrawn.map((value) => `M${x(value).toFixed(1)} 1v5`).join(""), class: "redrawn" }));
  const radius = row.dots.length > 200 ? 1.8 : 3.4;
  row.dots.forEach((dot, i) => { dot.x = x(dot.value); dot.y = ROW.dots + (row.dots.length > 12 ? 9 * spread(i) : 0); });
  parts.push(makeSvg("path", { d: row.dots.map((dot) => ring(dot.x, dot.y.toFixed(1), radius)).join(""), class: "people", "fill-opacity": row.dots.length < 40 ? 0.6 : 0.25 }));
  if (!row.isSingle && row.low !== null) parts.push(makeSvg("path", { d: `M${x(row.low).toFixed(1)} ${ROW.middle}H${x(row.high).toFixed(1)}`, class: "whisker" }));
  parts.push(makeSvg("circle", { cx: x(row.value), cy: ROW.middle, r: 4.2, class: "estimate" }));
  return parts;
}

function drawAxis(sx, range, by, width) {
  const marks = ticks(...range, width / 64).flatMap(({ value, text }) => { const x = sx.k * value + sx.c; return [makeSvg("line", { x1: x, x2: x, y1: 0, y2: 5, class: "grid" }), svgText(text, x, 18, { "text-anchor": "middle" })]; });
  return [makeSvg("line", { x1: sx.low * sx.k + sx.c, x2: sx.high * sx.k + sx.c, y1: 0, y2: 0, class: "none" }), ...marks, svgText(by === "jnd" ? "difference ÷ what a person can feel (JND)" : "difference ÷ standard deviation: it is not known what is felt", width / 2, 36, { "text-anchor": "middle", class: "group" })];
}

/** One stop of the Tab key for a row's dots: arrows go from dot to dot, Enter or a click opens. */
function rowPlot(row, table, width, range) {
  const sx = scale(range, ROW.pad, width - ROW.pad);
  const box = { class: "chart row", viewBox: `0 0 ${width} ${ROW.height}` };
  if (!row.dots.length) return makeSvg("svg", { ...box, role: "img", "aria-label": row.value === null ? "no estimate" : valueWords(row) }, ...drawRow(row, sx));
  const chosen = makeSvg("circle", { r: 5.5, class: "chosen", visibility: "hidden" });
  const svg = makeSvg("svg", { ...box, tabindex: "0", role: "slider", "aria-label": `${row.isSingle ? "Repeats" : "People"} of ${row.place}`, "aria-valuemin": 1, "aria-valuemax": row.dots.length, "aria-valuenow": 1, "aria-valuetext": row.dots[0].words }, ...drawRow(row, sx), chosen);
  let at = 0;
  const choose = (i) => {
    at = Math.max(0, Math.min(row.dots.length - 1, i));
    const dot = row.dots[at];
    for (const [name, value] of Object.entries({ cx: dot.x, cy: dot.y, visibility: "visible" })) chosen.setAttribute(name, value);
    svg.setAttribute("aria-valuenow", at + 1);
    svg.setAttribute("aria-valuetext", dot.words);
    table.tip.textContent = `${dot.words}. Enter or a click opens the ${BEHIND} of ${row.opens.m.length === 2 ? "both" : "its"} modes.`;
  };
  const nearest = (event) => {
    const box = svg.getBoundingClientRect(), x = ((event.clientX - box.left) * width) / box.width, y = ((event.clientY - box.top) * ROW.height) / box.height;
    return row.dots.reduce((best, dot, i) => (Math.hypot(dot.x - x, dot.y - y) < best.far ? { i, far: Math.hypot(dot.x - x, dot.y - y) } : best), { i: -1, far: 14 }).i;
  };
  const open = () => openRow(row, row.dots[at].view);
  svg.addEventListener("pointermove", (event) => { const i = nearest(event); svg.classList.toggle("on-dot", i >= 0); if (i >= 0) choose(i); });
  svg.addEventListener("click", (event) => { const i = nearest(event); if (i >= 0) { choose(i); open(); } });
  svg.addEventListener("focus", () => choose(at));
  svg.addEventListener("keydown", (event) => {
    const to = { ArrowRight: at + 1, ArrowUp: at + 1, ArrowLeft: at - 1, ArrowDown: at - 1, PageUp: at + 10, PageDown: at - 10, Home: 0, End: row.dots.length - 1 }[event.key];
    if (to !== undefined) choose(to); else if (event.key === "Enter" || event.key === " ") open(); else return;
    event.preventDefault();
  });
  return svg;
}

/** Draws every table again. What is open stays as it is, with the traces in it, and so does the focus. */
function drawTables() {
  const detail = openRowLine(), focused = document.activeElement, line = focused?.closest("tr[data-row]");
  const [key, part] = line ? [line.dataset.row, focused.localName] : [null, null];
  detail?.remove();
  for (const table of verdictTables) if (table.element) drawTable(table);
  if (matrix.explored) writeExplored();
  const place = matrix.open && lineOf(matrix.open.key);
  if (place && detail) {
    place.querySelector("button").setAttribute("aria-expanded", "true");
    place.after(detail);
  } else if (matrix.open) {
    bringBack(detail?.querySelector("#browser"));
    if (place) reopen(); else matrix.open = null;
  }
  const again = key ? lineOf(key)?.querySelector(part) : focused;
  if (again && again.isConnected && again !== document.activeElement) again.focus({ preventScroll: true });
}

function drawTable(table) {
  table.drawn = table.rows();
  for (const row of table.drawn) row.dots = table.dots(row);
  const width = printing ? 300 : Math.max(160, Math.min(520, table.element.parentElement.clientWidth * 0.4));
  table.element.style.setProperty("--plot", `${width}px`);
  const bodies = ["jnd", "sd", "none"].flatMap((by) => {
    const rows = table.drawn.filter((row) => row.by === by);
    if (!rows.length) return [];
    const range = by === "none" ? null : sharedRange(rows);
    const bodies = [...groupBy(rows, ({ index }) => index)].map(([index, own]) => {
      const { label, better, is_primary: isPrimary } = study.metrics[index];
      const head = make("tr", { class: "metric" }, make("th", { colspan: 3, scope: "rowgroup" }, isPrimary ? make("strong", {}, label) : label, better === "neither" ? "" : ` (${better} is better)`));
      return make("tbody", { "data-by": by }, head, ...own.map((row) => rowLine(row, table, width, range)));
    });
    if (!range) return bodies;
    const sx = scale(range, ROW.pad, width - ROW.pad);
    const axis = make("tr", { class: "axis" }, make("td"), make("td", {}, makeSvg("svg", { class: "chart", viewBox: `0 0 ${width} 42`, "aria-hidden": "true" }, ...drawAxis(sx, range, by, width))), make("td"));
    bodies.at(-1).append(axis);
    return bodies;
  });
  table.element.replaceChildren(table.element.tHead, ...bodies);
  // A name of several lines makes its row taller than its plot: band and zero line reach over all of it.
  for (const plot of table.element.querySelectorAll(".chart.row")) {
    const over = Math.max(6, (plot.closest("tr").getBoundingClientRect().height - ROW.height) / 2 + 1), all = { y: -over, height: ROW.height + 2 * over, y1: -over, y2: ROW.height + over };
    for (const part of plot.querySelectorAll(".unfelt, .none")) for (const [name, value] of Object.entries(all)) if (part.hasAttribute(name)) part.setAttribute(name, value);
  }
}

function rowLine(row, table, width, range) {
  const button = make("button", { type: "button", class: "row-name", "aria-expanded": "false", onclick: () => openRow(row) }, row.place);
  const number = (value) => (value === null ? "" : exact(value));
  return make("tr", { "data-row": rowKey(row), "data-value": number(row.value), "data-low": number(row.low), "data-high": number(row.high), "data-p": number(row.p_adjusted), "data-n": row.n },
    make("th", { scope: "row" }, button), make("td", { class: "plot-cell" }, range ? rowPlot(row, table, width, range) : row.value === null ? "" : "nothing to measure it by"), make("td", {}, row.value === null ? "" : make("span", { class: "number" }, valueWords(row)), make("span", { class: "judged" }, table.judged(row), " ", row.value === null ? "" : make("span", { class: "count" }, `(${row.who})`))));
}

const lineOf = (key) => [...document.querySelectorAll(".verdicts tr[data-row]")].find((line) => line.dataset.row === key);

/** Closes what is open; the browser of trials goes back to its own place. */
function closeRow() {
  bringBack();
  openRowLine()?.remove();
  document.querySelector(".verdicts [aria-expanded=true]")?.setAttribute("aria-expanded", "false");
  matrix.open = null;
}

/** Opens a row below itself, or with `view` the traces of a person there; once more closes it. */
function openRow(row, view = null) {
  const key = rowKey(row), again = matrix.open?.key === key && !view;
  closeRow();
  if (again) return writeAddress();
  matrix.open = { key, view };
  reopen();
  writeAddress();
}

function reopen() {
  const { key, view: traces } = matrix.open, line = lineOf(key);
  if (!line) { matrix.open = null; return; }
  const table = verdictTables.find(({ drawn }) => drawn?.some((row) => rowKey(row) === key)), row = table.drawn.find((row) => rowKey(row) === key);
  openRowLine()?.remove();
  line.querySelector("button").setAttribute("aria-expanded", "true");
  const cell = make("td", { colspan: 3 });
  line.after(make("tr", { class: "detail" }, cell));
  if (traces) openTrials({ ...traces, beside: null }, cell);
  else cell.append(...metricDetails(row, table));
}

/** The charts of a difference between modes: the modes, and everybody's difference. */
function modesDetails(row) {
  const environment = environmentOf(row.environment), isAlone = sessionsOf.size === 1;
  const groups = dotGroups(environment, row.index, sessionsOf.size > MANY), differences = differenceGroups(environment, row.index, isAlone);
  const charts = [{ title: short(environment.label, 30), groups, lines: isAlone ? [] : linesOf(groups), zero: false }];
  if (differences.length) charts.push({ title: `${short(environment.label, 24)}: differences`, groups: differences, lines: [], zero: true });
  return charts;
}

/** The charts of a row, means, and the figures of learning, sessions and answers of its metric. */
function metricDetails(row, verdictTable) {
  const metric = study.metrics[row.index], { scale: factor, unit, name, is_logarithm: isLogarithm } = metric;
  const shown = verdictTable.details(row), points = shown.flatMap(({ groups }) => groups.flatMap((group) => group.points));
  const tip = make("p", { class: "tip", hidden: !points.length }, points.some(({ open }) => open) ? "Point at a dot for its trial; Enter or a click opens it." : "Point at a dot for its value."), tell = (words) => { tip.textContent = words; };
  const charts = make("div", { class: "charts" });
  const draw = () => {
    const width = Math.max(260, Math.min(520, verdictTable.element.clientWidth / 2 - 30));
    charts.replaceChildren(...shown.map((chart) => groupChart({ ...chart, title: `${chart.title}${unitBehind(metric, chart.zero || chart.areRatios)}`, metric, width, yRange: rangeOfGroups(chart.groups, chart.zero), tell })));
    charts.querySelectorAll("svg").forEach(rove);
  };
  draw();
  requestAnimationFrame(() => { onWidth(charts, draw); redraws.delete(draw); }); // once it has a width; paper takes what is on the screen
  const means = row.groups ? row.groups.map(({ label, mean: value, sd }, i) => ({ of: label, value, sd, low: null, n: [row.n, row.n_against][i] })) : metric.means.filter((one) => one.environment === row.environment);
  const areRatios = row.groups && row.is_of_ratios;
  const hasIntervals = means.some(({ low }) => low !== null), right = (text) => make("td", { class: "number" }, text);
  const head = [row.groups ? "group" : "mode", "mean", hasIntervals && "interval", "SD", "n"].filter(Boolean);
  const table = make("table", {}, make("thead", {}, make("tr", {}, ...head.map((text) => make("th", { scope: "col" }, text)))), make("tbody", {}, ...means.map((one) => {
    // Of logarithms the mean is a geometric one, and a deviation a factor; in ratios groups have a mean ratio.
    const read = (value) => (areRatios ? Math.exp(value) : atPlace(metric, placeOfValue(metric, value)));
    const error = one.sd === null ? null : one.sd * (isLogarithm ? read(one.value) : factor);
    const text = (value) => (value === null ? "–" : toDigits(read(value), error));
    const spread = one.sd === null ? "–" : isLogarithm ? `×/÷ ${toDigits(Math.exp(one.sd), Math.expm1(one.sd))}` : toDigits(one.sd * factor, error);
    const middle = areRatios ? timesWords(text(one.value), false) : withUnit(text(one.value), unit);
    const interval = hasIntervals ? right(one.low === null ? "–" : `${text(one.low)} to ${text(one.high)}`) : null;
    return make("tr", {}, make("th", { scope: "row" }, row.groups ? one.of : labelOf(study.modes, one.of)), right(one.value === null ? "–" : middle), interval, right(spread), right(`${one.n}`));
  })));
  const named = [["compare", "the modes compared"], ["effects", "effects of factors"], ["participants", "everybody’s differences"], ["groups", "groups compared"], ["learning", "from repeat to repeat"], ["sessions", "from session to session"]];
  const figures = named.map(([stem, words]) => [byId(`figure-${stem}.${name}`), words]).filter(([figure]) => figure).map(([figure, words]) => make("details", { ontoggle: (event) => { if (event.target.open && !event.target.querySelector("img")) { const image = figure.querySelector("img").cloneNode(); image.loading = "eager"; event.target.append(image); show(image); } } }, make("summary", {}, `Figure: ${words}`)));
  const answers = byId("answers-metric") || byId("answer-plot") ? make("button", { type: "button", onclick: () => besideAnswers(row.index) }, "Answers beside this metric") : null;
  return [charts, tip, make("p", { class: "caption of-all", hidden: !leftOut.size }, "The table and the figures are of all trials."), means.length ? make("div", { class: "scroll" }, table) : null, ...figures, answers].filter(Boolean);
}

function besideAnswers(index) {
  for (const build of unbuilt) build();
  const select = byId("answers-metric");
  if (!select) return;
  select.value = index;
  select.dispatchEvent(new Event("change"));
  byId("answers").scrollIntoView({ behavior: calm.matches ? "auto" : "smooth" });
}

/** What was left out, as commands that would make it so. */
function excludeLines() {
  const trials = study.trials.filter((trial) => !counts(trial));
  return [...groupBy(trials, ({ participant, session }) => pathOf(participant, session)).values()].map((own) => `zwidth exclude ${study.study} -p ${own[0].participant} -s ${own[0].session} --trial ${own.map(({ trial }) => trial).sort((a, b) => a - b).join(",")} "WHY"`);
}

function writeExplored() {
  for (const note of [matrix.explored, ...document.querySelectorAll(".verdicts .of-all")]) note.hidden = !leftOut.size;
  if (!leftOut.size) return matrix.explored.replaceChildren();
  const people = [...leftOut].filter((key) => !key.includes("/")).length, trials = leftOut.size - people;
  const what = [people ? `${people} ${people === 1 ? "person" : "people"}` : null, trials ? `${trials} ${trials === 1 ? "trial" : "trials"}` : null].filter(Boolean).join(" and ");
  const claimed = study.metrics.some(({ claims }) => claims);
  matrix.explored.replaceChildren(make("p", {}, make("strong", {}, "Explored, not the analysis."), ` Without ${what}.${study.has_groups ? " Only the dots are: differences and groups stay as analysed, because the page has values by group without anybody’s code." : ""} Everything below the rows${claimed ? ", effects of factors among it," : ""} is as analysed. These lines, each with its reason, would make it so:`), make("pre", {}, excludeLines().join("\n")), make("button", { type: "button", onclick: () => { leftOut.clear(); explore(); writePeople(); byId("left-out").firstElementChild.focus(); } }, "Take all back in"));
}

function explore() {
  drawTables();
  writeAddress();
}

const setLeftOut = (key, isIn) => { if (isIn) leftOut.delete(key); else leftOut.add(key); explore(); };

/** Boxes for people, and for the trials of one of them. */
function writePeople() {
  const people = [...sessionsOf.keys()], pick = matrix.pick.value || people[0];
  matrix.pick.replaceChildren(...people.map((id) => option(id, id, id === pick)));
  matrix.people.replaceChildren(make("legend", {}, "People"), ...people.map((id) => tickBox(id, !leftOut.has(id), (isIn) => setLeftOut(id, isIn), { value: id })));
  const mine = study.trials.filter(({ participant }) => participant === pick);
  matrix.trials.replaceChildren(make("legend", {}, `Trials of ${pick}`), ...mine.map((trial) => tickBox(`${trial.session} ${trial.trial}: ${short(labelOf(study.environments, trial.environment), 18)}, ${short(labelOf(study.modes, trial.mode), 14)}, repeat ${trial.repeat}`, !leftOut.has(trialPath(trial)), (isIn) => setLeftOut(trialPath(trial), isIn), { value: trialPath(trial) })));
}

const writeAddress = () => history.replaceState(null, "", `#verdicts?${new URLSearchParams({ ...(leftOut.size ? { x: [...leftOut].join(",") } : {}), ...(matrix.open ? { row: matrix.open.key } : {}) })}`);

/** Takes what is left out, and the row that is open, from an address; that of trials names what is left out, too. */
function readMatrixAddress() {
  const [, part, text] = /^#(verdicts|trials)\?(.*)$/.exec(location.hash) ?? [];
  if (!part) return false;
  const query = new URLSearchParams(text), all = new Set(study.trials.flatMap((trial) => [trial.participant, trialPath(trial)]));
  leftOut.clear();
  for (const key of (query.get("x") ?? "").split(",")) if (all.has(key)) leftOut.add(key);
  if (part === "verdicts") {
    closeRow();
    if (query.has("row")) matrix.open = { key: query.get("row"), view: null };
  }
  return true;
}

/** The values of a table, a line for each row. */
function cellsOfTable({ drawn }) {
  const areGroups = drawn.some(({ n_against: second }) => second !== undefined && second !== null);
  const head = ["metric", "environment", "contrast", "difference", "low", "high", "unit", "jnd", "verdict", "size", "n", ...(areGroups ? ["n of the second group"] : []), "left out", "origin"];
  return [head, ...drawn.map((row) => {
    // For programs logarithms stay what they are, and their unit says so.
    const metric = study.metrics[row.index], { label, is_logarithm: isLogarithm } = metric, unit = isLogarithm ? `ln ${metric.unit}`.trim() : metric.unit;
    const shown = (value) => (value === null || value === undefined ? "" : exact(placeOfDifference(metric, value)));
    return [label, row.environment ?? "", row.claim, shown(row.value), row.isSingle ? "" : shown(row.low), row.isSingle ? "" : shown(row.high), unit, shown(row.jnd), row.verdict, row.size ?? "", row.n, ...(areGroups ? [row.n_against ?? ""] : []), row.left, study.simulated ? "simulated" : "recorded"];
  })];
}

/** A table as one drawing, light as paper is. */
function tableDrawing(table) {
  const letters = Math.max(52, Math.min(100, ...table.drawn.map(({ place }) => place.length))), names = 18 + 6 * letters, plot = 420, words = 420, width = names + plot + words;
  const theme = readTheme(true), styles = `text { font: 12px ${FONT}; fill: ${theme.ink}; } .unfelt { fill: ${theme.grid}; } .none, .grid { stroke: ${theme.quiet}; } .people { fill: ${theme.quiet}; } .redrawn { stroke: ${theme.quiet}; stroke-opacity: 0.35; } .whisker { stroke: ${theme.ink}; stroke-width: 2; fill: none; } .estimate { fill: ${theme.ink}; } .head { font-weight: 600; }`;
  const svg = makeSvg("svg", { xmlns: "http://www.w3.org/2000/svg", width }, makeSvg("style", {}, styles), svgText(`${study.title}: ${table.title}`, 6, 18, { class: "head" }));
  let y = 32;
  const named = [...leftOut].slice(0, 8).join(", ") + (leftOut.size > 8 ? ` and ${leftOut.size - 8} more` : "");
  for (const line of [study.simulated ? "SYNTHETIC: simulated, not measured." : null, leftOut.size && table.isExplored ? `Explored, not the analysis: without ${named}.` : null].filter(Boolean)) { svg.append(svgText(line, 6, y + 4)); y += 16; }
  for (const by of ["jnd", "sd", "none"]) {
    const rows = table.drawn.filter((row) => row.by === by);
    if (!rows.length) continue;
    const range = by === "none" ? null : sharedRange(rows), sx = range && scale(range, ROW.pad, plot - ROW.pad);
    for (const [index, own] of groupBy(rows, (row) => row.index)) {
      const { label, better } = study.metrics[index];
      svg.append(svgText(short(label, 90) + (better === "neither" ? "" : ` (${better} is better)`), 6, y + 18, { class: "head" }));
      y += 24;
      for (const row of own) {
        svg.append(svgText(short(row.place, letters), 14, y + 20), makeSvg("g", { transform: `translate(${names} ${y})` }, ...(sx ? drawRow(row, sx) : [])), svgText(row.value === null ? "" : valueWords(row), names + plot + 10, y + 14), svgText(short(`${table.judged(row)}${row.value === null ? "" : ` (${row.who})`}`, 64), names + plot + 10, y + 29));
        y += ROW.height;
      }
    }
    if (sx) svg.append(makeSvg("g", { transform: `translate(${names} ${y})` }, ...drawAxis(sx, range, by, plot)));
    y += 48;
  }
  for (const [name, value] of Object.entries({ height: y, viewBox: `0 0 ${width} ${y}` })) svg.setAttribute(name, value);
  svg.prepend(makeSvg("rect", { width: "100%", height: "100%", fill: theme.paper }));
  return { text: new XMLSerializer().serializeToString(svg), width, height: y };
}

function saveTable(table, format) {
  const name = `${study.study}.${table.name}`.replace(/[^A-Za-z0-9_.-]/g, "_");
  if (format === "csv") return download(`${name}.csv`, "text/csv", cellsOfTable(table).map((line) => line.map(quoted).join(",")).join("\n") + "\n");
  const { text, width, height } = tableDrawing(table);
  if (format === "svg") return download(`${name}.svg`, "image/svg+xml", text);
  const fine = Math.min(2, 16000 / height); // a browser's canvas ends at 16,384 pixels
  const image = new Image(), canvas = make("canvas", { width: Math.floor(fine * width), height: Math.floor(fine * height) });
  image.addEventListener("load", () => { canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height); canvas.toBlob((blob) => { if (blob) download(`${name}.png`, "image/png", blob); else table.tip.textContent = "This browser draws no picture of this size: save it as SVG."; }); });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
}

async function copyTable(table, button) {
  const text = cellsOfTable(table).map((line) => line.join("\t")).join("\n");
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
  } catch {
    table.copied.textContent = text; // no clipboard on a page from disk: selected for the reader
    table.copied.hidden = false;
    getSelection().selectAllChildren(table.copied);
    button.textContent = "Selected: press Ctrl+C";
  }
}

const levelWords = () => `${Number((100 * study.level).toPrecision(6))} %`;

/** What p values are adjusted by. */
function adjustmentWords() {
  const { curve_claims: claims } = study;
  return claims ? `Holm, and for primary metrics Bonferroni for ${claims} ${claims === 1 ? "claim" : "claims"} on primary curves` : "Holm";
}

function modesLegend() {
  const isAlone = sessionsOf.size === 1, all = study.metrics.flatMap(({ differences }) => differences);
  const family = { metric: "the contrasts of a metric", environment: "the contrasts of a metric in an environment", study: "the contrasts of all primary metrics together, and of each other metric" }[study.families];
  return [
    all.some(({ jnd }) => jnd !== null) && "Grey band: within ±1 just noticeable difference (JND), below what is felt.",
    isAlone ? "Disc: mean difference; dots: repeats." : `Disc and whiskers: mean and ${levelWords()} interval, not adjusted; dots: people. Verdicts are adjusted for ${family}${study.has_groups ? ", differences between groups among them, which the table below has" : ""} (${adjustmentWords()}).`,
    isAlone && all.some(({ redrawn }) => redrawn.length) && "Ticks above: the difference in other orders of the trials, had none depended on mode: they decide the verdict.",
  ];
}

/** A table in its place, with what can be taken from it. */
function buildTableOf(table, host) {
  const columns = table.columns.map((text) => make("th", { scope: "col" }, typeof text === "function" ? text() : text));
  table.element = make("table", { class: "verdicts" }, make("thead", {}, make("tr", {}, ...columns)));
  table.tip = make("p", { class: "tip" }, table.hint);
  table.copied = make("pre", { hidden: true });
  const save = (format) => make("button", { type: "button", "data-save-matrix": format, "aria-label": `${table.label} as ${format}`, onclick: () => saveTable(table, format) }, format.toUpperCase());
  const tools = make("div", { class: "tools" }, make("button", { type: "button", class: "copy-values", onclick: (event) => copyTable(table, event.currentTarget) }, "Copy values"), ...["svg", "png", "csv"].map(save));
  host.replaceChildren(make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": table.label }, table.element), make("p", { class: "caption" }, table.legend().filter(Boolean).join(" ")), table.tip, tools, table.copied);
}

/** What people and trials are left out of the differences between modes, and the boxes for it. */
function buildExploring(host) {
  matrix.explored = make("div", { class: "explored", role: "status", hidden: true });
  const [pick, select] = field("Trials of", "left-out-of", writePeople);
  Object.assign(matrix, { pick: select, people: make("fieldset", { class: "ticks boxes", id: "left-out-people" }), trials: make("fieldset", { class: "ticks boxes", id: "left-out-trials" }) });
  const explore = make("details", { id: "left-out", ontoggle: () => explore.open && writePeople() }, make("summary", {}, "Leave people or trials out, and see what follows"), matrix.people, pick, matrix.trials);
  host.prepend(matrix.explored);
  host.append(explore);
  return explore;
}

function buildVerdicts() {
  const built = verdictTables.filter(({ host, isThere }) => byId(host) && isThere());
  if (!built.length) return;
  let exploring = null;
  for (const table of built) {
    const host = byId(table.host);
    buildTableOf(table, host);
    if (table.heading) host.prepend(make("h3", {}, table.heading()));
    if (table.isExplored) exploring = buildExploring(host);
  }
  // The figure of all verdicts has these rows, too.
  for (const still of document.querySelectorAll("#verdicts > figure")) still.hidden = true;
  const isNamed = readMatrixAddress();
  drawTables();
  onWidth(byId(built[0].host), drawTables);
  addEventListener("hashchange", () => { if (readMatrixAddress()) { drawTables(); if (exploring) writePeople(); } });
  if (isNamed && leftOut.size && exploring) exploring.open = true;
  if (matrix.open) lineOf(matrix.open.key)?.scrollIntoView({ block: "center" });
  for (const { host } of built) byId(host).dataset.ready = "true";
}
