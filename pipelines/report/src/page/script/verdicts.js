// The matrix of verdicts: every difference over what a person can feel. A dot opens its person's traces, a row its metric; people and trials can be left out.

const ROW = { height: 36, middle: 12, dots: 26, pad: 10 };
const matrix = { rows: [], open: null, chosen: new Map() };
const rowKey = (row) => [study.metrics[row.index].name, row.environment, row.of].join("/");
const placeOf = (row) => `${labelOf(study.environments, row.environment)}: ${labelOf(study.modes, row.mode)} − ${labelOf(study.modes, row.against)}`;

/** The dots of a row: people, or of the only one the repeats that both modes have. */
function dotsOf(row) {
  const { scale: factor, unit } = study.metrics[row.index];
  const words = (who, value) => `${who}: ${withUnit(significant(value * factor), unit)}`;
  const open = (p, s, r) => ({ p, s, e: row.environment, m: [row.mode, row.against], r });
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
function rowPlot(row, width, range) {
  const sx = scale(range, ROW.pad, width - ROW.pad);
  const chosen = makeSvg("circle", { r: 5.5, class: "chosen", visibility: "hidden" });
  const svg = makeSvg("svg", { class: "chart row", viewBox: `0 0 ${width} ${ROW.height}`, tabindex: "0", role: "slider", "aria-label": `${row.isSingle ? "Repeats" : "People"} of ${placeOf(row)}`, "aria-valuemin": 1, "aria-valuemax": Math.max(1, row.dots.length), "aria-valuenow": 1, "aria-valuetext": row.dots[0]?.words ?? "none" }, ...drawRow(row, sx), chosen);
  let at = 0;
  const choose = (i) => {
    at = Math.max(0, Math.min(row.dots.length - 1, i));
    const dot = row.dots[at];
    if (!dot) return;
    for (const [name, value] of Object.entries({ cx: dot.x, cy: dot.y, visibility: "visible" })) chosen.setAttribute(name, value);
    svg.setAttribute("aria-valuenow", at + 1);
    svg.setAttribute("aria-valuetext", dot.words);
    matrix.tip.textContent = `${dot.words}. Enter or a click opens the traces of both modes.`;
  };
  const nearest = (event) => {
    const box = svg.getBoundingClientRect(), x = ((event.clientX - box.left) * width) / box.width, y = ((event.clientY - box.top) * ROW.height) / box.height;
    return row.dots.reduce((best, dot, i) => (Math.hypot(dot.x - x, dot.y - y) < best.far ? { i, far: Math.hypot(dot.x - x, dot.y - y) } : best), { i: -1, far: 14 }).i;
  };
  const open = () => row.dots[at] && openRow(row, row.dots[at].view);
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

const whoWords = (row) => `${row.n} ${row.isSingle ? "trials" : row.n === 1 ? "person" : "people"}`;

function drawMatrix() {
  // What is open stays as it is, with the traces in it, and so does the focus.
  const detail = matrix.table.querySelector("tr.detail"), focused = document.activeElement, line = focused?.closest("tr[data-row]");
  const [key, part] = line ? [line.dataset.row, focused.localName] : [null, null];
  detail?.remove();
  matrix.rows = verdictRows().map((row) => ({ ...row, dots: null }));
  for (const row of matrix.rows) row.dots = dotsOf(row);
  const width = printing ? 300 : Math.max(160, Math.min(520, matrix.table.parentElement.clientWidth * 0.4));
  matrix.table.style.setProperty("--plot", `${width}px`);
  const bodies = ["jnd", "sd", "none"].flatMap((by) => {
    const rows = matrix.rows.filter((row) => row.by === by);
    if (!rows.length) return [];
    const range = by === "none" ? null : sharedRange(rows);
    const bodies = [...groupBy(rows, ({ index }) => index)].map(([index, own]) => {
      const { label, better, is_primary: isPrimary } = study.metrics[index];
      const head = make("tr", { class: "metric" }, make("th", { colspan: 3, scope: "rowgroup" }, isPrimary ? make("strong", {}, label) : label, better === "neither" ? "" : ` (${better} is better)`));
      return make("tbody", { "data-by": by }, head, ...own.map((row) => rowLine(row, width, range)));
    });
    if (!range) return bodies;
    const sx = scale(range, ROW.pad, width - ROW.pad);
    const axis = make("tr", { class: "axis" }, make("td"), make("td", {}, makeSvg("svg", { class: "chart", viewBox: `0 0 ${width} 42`, "aria-hidden": "true" }, ...drawAxis(sx, range, by, width))), make("td"));
    bodies.at(-1).append(axis);
    return bodies;
  });
  matrix.table.replaceChildren(matrix.head, ...bodies);
  writeExplored();
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

function rowLine(row, width, range) {
  const button = make("button", { type: "button", class: "row-name", "aria-expanded": "false", onclick: () => openRow(row) }, placeOf(row));
  return make("tr", { "data-row": rowKey(row), "data-value": exact(row.value), "data-low": row.low === null ? "" : exact(row.low), "data-high": row.high === null ? "" : exact(row.high), "data-p": row.p_adjusted === null ? "" : exact(row.p_adjusted), "data-n": row.n },
    make("th", { scope: "row" }, button), make("td", { class: "plot-cell" }, range ? rowPlot(row, width, range) : "nothing to measure it by"), make("td", {}, make("span", { class: "number" }, valueWords(row)), make("span", { class: "judged" }, verdictWords(row), " ", make("span", { class: "count" }, `(${whoWords(row)})`))));
}

const lineOf = (key) => [...matrix.table.querySelectorAll("tr[data-row]")].find((line) => line.dataset.row === key);

/** Closes what is open; the browser of trials goes back to its own place. */
function closeRow() {
  bringBack();
  matrix.table.querySelector("tr.detail")?.remove();
  matrix.table.querySelector("[aria-expanded=true]")?.setAttribute("aria-expanded", "false");
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
  const { key, view: traces } = matrix.open, row = matrix.rows.find((one) => rowKey(one) === key), line = lineOf(key);
  if (!line) { matrix.open = null; return; }
  matrix.table.querySelector("tr.detail")?.remove();
  line.querySelector("button").setAttribute("aria-expanded", "true");
  const cell = make("td", { colspan: 3 });
  line.after(make("tr", { class: "detail" }, cell));
  if (traces) openTrials({ ...traces, beside: null }, cell);
  else cell.append(...metricDetails(row));
}

/** Means, differences, and the figures of learning, sessions and answers of a row's metric. */
function metricDetails(row) {
  const metric = study.metrics[row.index], environment = environmentOf(row.environment), { scale: factor, unit, name } = metric;
  const tip = make("p", { class: "tip" }, "Point at a dot for its trial; Enter or a click opens it."), tell = (words) => { tip.textContent = words; };
  const charts = make("div", { class: "charts" });
  const isAlone = sessionsOf.size === 1;
  const groups = dotGroups(environment, row.index, sessionsOf.size > MANY), differences = differenceGroups(environment, row.index, isAlone);
  const draw = () => {
    const width = Math.max(260, Math.min(520, matrix.table.clientWidth / 2 - 30));
    charts.replaceChildren(groupChart({ title: `${short(environment.label, 30)}${unit ? ` (${unit})` : ""}`, width, groups, lines: isAlone ? [] : linesOf(groups), yRange: rangeOfGroups(groups), tell }));
    if (differences.length) charts.append(groupChart({ title: `${short(environment.label, 24)}: differences${unit ? ` (${unit})` : ""}`, width, groups: differences, lines: [], yRange: rangeOfGroups(differences, true), zero: true, tell }));
    charts.querySelectorAll("svg").forEach(rove);
  };
  draw();
  requestAnimationFrame(() => { onWidth(charts, draw); redraws.delete(draw); }); // once it has a width; paper takes what is on the screen
  const means = metric.means.filter((one) => one.environment === row.environment);
  const table = make("table", {}, make("thead", {}, make("tr", {}, ...["mode", "mean", "interval", "SD", "n"].map((text) => make("th", { scope: "col" }, text)))), make("tbody", {}, ...means.map((one) => {
    const text = (value) => (value === null ? "–" : toDigits(value * factor, one.sd === null ? null : one.sd * factor));
    return make("tr", {}, make("th", { scope: "row" }, labelOf(study.modes, one.of)), make("td", { class: "number" }, withUnit(text(one.value), unit)), make("td", { class: "number" }, one.low === null ? "–" : `${text(one.low)} to ${text(one.high)}`), make("td", { class: "number" }, text(one.sd)), make("td", { class: "number" }, `${one.n}`));
  })));
  const named = [["compare", "the modes compared"], ["participants", "everybody’s differences"], ["learning", "from repeat to repeat"], ["sessions", "from session to session"]];
  const figures = named.map(([stem, words]) => [byId(`figure-${stem}.${name}`), words]).filter(([figure]) => figure).map(([figure, words]) => make("details", { ontoggle: (event) => { if (event.target.open && !event.target.querySelector("img")) { const image = figure.querySelector("img").cloneNode(); image.loading = "eager"; event.target.append(image); show(image); } } }, make("summary", {}, `Figure: ${words}`)));
  const answers = byId("answers-metric") || byId("answer-plot") ? make("button", { type: "button", onclick: () => besideAnswers(row.index) }, "Answers beside this metric") : null;
  return [charts, tip, make("p", { class: "caption of-all", hidden: !leftOut.size }, "The table and the figures are of all trials."), make("div", { class: "scroll" }, table), ...figures, answers].filter(Boolean);
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
  for (const note of [matrix.explored, ...matrix.table.querySelectorAll(".of-all")]) note.hidden = !leftOut.size;
  if (!leftOut.size) return matrix.explored.replaceChildren();
  const people = [...leftOut].filter((key) => !key.includes("/")).length, trials = leftOut.size - people;
  const what = [people ? `${people} ${people === 1 ? "person" : "people"}` : null, trials ? `${trials} ${trials === 1 ? "trial" : "trials"}` : null].filter(Boolean).join(" and ");
  matrix.explored.replaceChildren(make("p", {}, make("strong", {}, "Explored, not the analysis."), ` Without ${what}.${study.has_groups ? " Only the dots are: differences and groups stay as analysed, because the page does not say who is of which group." : ""} Everything below the rows is as analysed. These lines, each with its reason, would make it so:`), make("pre", {}, excludeLines().join("\n")), make("button", { type: "button", onclick: () => { leftOut.clear(); explore(); writePeople(); byId("left-out").firstElementChild.focus(); } }, "Take all back in"));
}

function explore() {
  drawMatrix();
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

const matrixCells = () => [["metric", "environment", "contrast", "difference", "low", "high", "unit", "jnd", "verdict", "size", "n", "left out", "origin"], ...matrix.rows.map((row) => { const { label, unit, scale: factor } = study.metrics[row.index], si = (value) => (value === null || value === undefined ? "" : exact(value * factor)); return [label, row.environment, row.of, si(row.value), row.isSingle ? "" : si(row.low), row.isSingle ? "" : si(row.high), unit, si(row.jnd), row.verdict, row.size ?? "", row.n, [...leftOut].join(" "), study.simulated ? "simulated" : "recorded"]; })];

/** The matrix as one drawing, light as paper is. */
function matrixDrawing() {
  const names = 330, plot = 420, words = 420, width = names + plot + words;
  const theme = readTheme(true), styles = `text { font: 12px ${FONT}; fill: ${theme.ink}; } .unfelt { fill: ${theme.grid}; } .none, .grid { stroke: ${theme.quiet}; } .people { fill: ${theme.quiet}; } .redrawn { stroke: ${theme.quiet}; stroke-opacity: 0.35; } .whisker { stroke: ${theme.ink}; stroke-width: 2; fill: none; } .estimate { fill: ${theme.ink}; } .head { font-weight: 600; }`;
  const svg = makeSvg("svg", { xmlns: "http://www.w3.org/2000/svg", width }, makeSvg("style", {}, styles), svgText(`${study.title}: differences between modes`, 6, 18, { class: "head" }));
  let y = 32;
  const named = [...leftOut].slice(0, 8).join(", ") + (leftOut.size > 8 ? ` and ${leftOut.size - 8} more` : "");
  for (const line of [study.simulated ? "SYNTHETIC: simulated, not measured." : null, leftOut.size ? `Explored, not the analysis: without ${named}.` : null].filter(Boolean)) { svg.append(svgText(line, 6, y + 4)); y += 16; }
  for (const by of ["jnd", "sd", "none"]) {
    const rows = matrix.rows.filter((row) => row.by === by);
    if (!rows.length) continue;
    const range = by === "none" ? null : sharedRange(rows), sx = range && scale(range, ROW.pad, plot - ROW.pad);
    for (const [index, own] of groupBy(rows, (row) => row.index)) {
      const { label, better } = study.metrics[index];
      svg.append(svgText(short(label, 90) + (better === "neither" ? "" : ` (${better} is better)`), 6, y + 18, { class: "head" }));
      y += 24;
      for (const row of own) {
        svg.append(svgText(short(placeOf(row), 52), 14, y + 20), makeSvg("g", { transform: `translate(${names} ${y})` }, ...(sx ? drawRow(row, sx) : [])), svgText(valueWords(row), names + plot + 10, y + 14), svgText(short(`${verdictWords(row)} (${whoWords(row)})`, 64), names + plot + 10, y + 29));
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

function saveMatrix(format) {
  const name = `${study.study}.verdicts`.replace(/[^A-Za-z0-9_.-]/g, "_");
  if (format === "csv") return download(`${name}.csv`, "text/csv", matrixCells().map((line) => line.map(quoted).join(",")).join("\n") + "\n");
  const { text, width, height } = matrixDrawing();
  if (format === "svg") return download(`${name}.svg`, "image/svg+xml", text);
  const fine = Math.min(2, 16000 / height); // a browser's canvas ends at 16,384 pixels
  const image = new Image(), canvas = make("canvas", { width: Math.floor(fine * width), height: Math.floor(fine * height) });
  image.addEventListener("load", () => { canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height); canvas.toBlob((blob) => (blob ? download(`${name}.png`, "image/png", blob) : tellMatrix("This browser draws no picture of this size: save it as SVG."))); });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
}

const tellMatrix = (text) => { matrix.tip.textContent = text; };

async function copyMatrix(button) {
  const text = matrixCells().map((line) => line.join("\t")).join("\n");
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
  } catch {
    matrix.copied.textContent = text; // no clipboard on a page from disk: selected for the reader
    matrix.copied.hidden = false;
    getSelection().selectAllChildren(matrix.copied);
    button.textContent = "Selected: press Ctrl+C";
  }
}

function buildMatrix(host) {
  if (!study.metrics.some(({ differences }) => differences.length)) return;
  const col = (text) => make("th", { scope: "col" }, text);
  matrix.head = make("thead", {}, make("tr", {}, col("environment, modes"), col("everybody’s difference, mean and interval"), col("difference and verdict")));
  if (sessionsOf.size === 1) matrix.head.rows[0].cells[1].textContent = "difference of each repeat, mean";
  matrix.table = make("table", { class: "verdicts" });
  matrix.tip = make("p", { class: "tip" }, "A name opens its metric, a dot the traces behind it.");
  matrix.explored = make("div", { class: "explored", role: "status", hidden: true });
  matrix.copied = make("pre", { hidden: true });
  const [pick, select] = field("Trials of", "left-out-of", writePeople);
  Object.assign(matrix, { pick: select, people: make("fieldset", { class: "ticks boxes", id: "left-out-people" }), trials: make("fieldset", { class: "ticks boxes", id: "left-out-trials" }) });
  const explore = make("details", { id: "left-out", ontoggle: () => explore.open && writePeople() }, make("summary", {}, "Leave people or trials out, and see what follows"), matrix.people, pick, matrix.trials);
  const percent = `${Number((100 * study.level).toPrecision(6))} %`, isAlone = sessionsOf.size === 1;
  const all = study.metrics.flatMap(({ differences }) => differences);
  const family = { metric: "the contrasts of a metric", environment: "the contrasts of a metric in an environment", study: "the contrasts of all primary metrics together, and of each other metric" }[study.families];
  const legend = make("p", { class: "caption" }, [
    all.some(({ jnd }) => jnd !== null) && "Grey band: within ±1 just noticeable difference (JND), below what is felt.",
    isAlone ? "Disc: mean difference; dots: repeats." : `Disc and whiskers: mean and ${percent} interval, not adjusted; dots: people. Verdicts are adjusted for ${family}${study.has_groups ? ", differences between groups among them, which sentences and figures below tell" : ""} (Holm).`,
    isAlone && all.some(({ redrawn }) => redrawn.length) && "Ticks above: the difference in other orders of the trials, had none depended on mode: they decide the verdict.",
  ].filter(Boolean).join(" "));
  const save = (format) => make("button", { type: "button", "data-save-matrix": format, "aria-label": `Matrix as ${format}`, onclick: () => saveMatrix(format) }, format.toUpperCase());
  const tools = make("div", { class: "tools" }, make("button", { type: "button", id: "copy-matrix", onclick: (event) => copyMatrix(event.currentTarget) }, "Copy values"), ...["svg", "png", "csv"].map(save));
  host.replaceChildren(matrix.explored, make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Every difference between modes" }, matrix.table), legend, matrix.tip, tools, matrix.copied, explore);
  for (const still of document.querySelectorAll("#verdicts > figure")) still.hidden = true;
  const isNamed = readMatrixAddress();
  drawMatrix();
  onWidth(host, drawMatrix);
  addEventListener("hashchange", () => { if (readMatrixAddress()) { drawMatrix(); writePeople(); } });
  if (isNamed && leftOut.size) explore.open = true;
  if (matrix.open) lineOf(matrix.open.key)?.scrollIntoView({ block: "center" });
  host.dataset.ready = "true";
}
