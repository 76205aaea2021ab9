// The table of samples, and what can be saved.

const ROWS = 200; // rows of the table at a time

function buildTable() {
  const body = make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Samples of the shown curve" });
  const bar = make("div", { class: "tools" });
  const details = make("details", { id: "trial-table", ontoggle: () => details.open && writeTable(Math.floor((browser.index ?? 0) / ROWS) * ROWS) }, make("summary", {}, "Table of the curve at the cursor"), bar, body);
  Object.assign(parts, { tableBody: body, tableBar: bar });
  return details;
}

function closeTable() {
  parts.table.open = false;
  parts.tableBody.replaceChildren();
}

function writeTable(from) {
  const active = browser.curves[browser.active];
  if (!active) return;
  const columns = Object.keys(active.stored);
  const rows = [];
  for (let i = from; i < Math.min(active.n, from + ROWS); i++) rows.push(make("tr", {}, make("th", { scope: "row" }, String(i)), ...columns.map((column) => make("td", {}, exact(active.stored[column][i])))));
  const turn = (label, to) => make("button", { type: "button", disabled: to < 0 || to >= active.n, onclick: () => writeTable(to) }, label);
  parts.tableBar.replaceChildren(turn("Earlier", from - ROWS), turn("Later", from + ROWS), make("span", {}, `Samples ${from} to ${Math.min(active.n, from + ROWS) - 1} of ${active.n}`));
  parts.tableBody.replaceChildren(make("table", { class: "samples" }, make("caption", {}, `${active.label}, as stored${study.simulated ? ", simulated" : ""}`), make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "sample"), ...columns.map((column) => make("th", { scope: "col" }, column)))), make("tbody", {}, ...rows)));
}

function download(name, type, content) {
  const address = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

const named = (id) => (id === EVERY ? "all" : id);
const fileName = (name) => [study.study, named(browser.of.p), named(browser.of.s), browser.of.e, browser.of.m.join("-"), ...(view.beside ? ["beside", view.beside.slice(2)] : []), name].join(".").replace(/[^A-Za-z0-9_.-]/g, "_").slice(0, 150);
const quoted = (value) => (/[",\r\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : String(value));

/** Every shown curve, every sample, as stored; `origin` marks simulated data in each row. */
function csv() {
  const columns = distinct(browser.curves.flatMap((curve) => Object.keys(curve.stored)));
  const lines = [["participant", "session", "environment", "mode", "curve", "trial", "repeat", "origin", ...columns].join(",")];
  for (const curve of browser.curves) {
    const head = [curve.who.p, curve.who.s, curve.who.e, curve.mode, curve.kind === "trial" ? "trial" : curve.label, curve.trial ?? "", curve.repeat ?? "", study.simulated ? "simulated" : "recorded"].map(quoted).join(",");
    for (let i = 0; i < curve.n; i++) lines.push(`${head},${columns.map((column) => (Number.isFinite(curve.stored[column]?.[i]) ? exact(curve.stored[column][i]) : "")).join(",")}`);
  }
  return `${lines.join("\n")}\n`;
}

/** Draws a panel for paper: light, with what it shows and the mark of simulated data. */
function drawExport(pen, id, width, height) {
  const { panel } = screen.plots.get(id);
  const theme = readTheme(true);
  fineness = 3;
  pen.rect(0, 0, width, height, { colour: theme.paper });
  const shifted = { ...pen };
  drawPanel(shifted, panel, width, height - 34, theme, screen.range, true);
  const beside = besides().find(({ key }) => key === view.beside);
  pen.text(short(`${study.study}, ${labelOf(study.environments, browser.of.e)}, ${browser.of.p === EVERY ? "all participants" : `${browser.of.p} ${browser.of.s === EVERY ? "all sessions" : browser.of.s}`}${browser.of.r === "all" ? "" : `, repeat ${browser.of.r}`}${beside ? `; dotted: ${beside.label}` : ""}`, 90), 8, height - 24, { colour: theme.quiet, size: 11 });
  if (study.simulated) pen.text("SYNTHETIC: simulated, not measured", 8, height - 10, { colour: theme.mark, size: 11, bold: true });
}

function exportPlot(id, format) {
  const width = 720, height = id === "loop" ? 560 : id === "states" ? screen.plots.get(id).height + 40 : 360;
  if (format === "svg") {
    const pen = svgPen(width, height, id);
    drawExport(pen, id, width, height);
    return download(`${fileName(id)}.svg`, "image/svg+xml", pen.finish());
  }
  const canvas = make("canvas", { width: 3 * width, height: 3 * height });
  const context = canvas.getContext("2d");
  context.scale(3, 3);
  drawExport(canvasPen(context), id, width, height);
  canvas.toBlob((blob) => download(`${fileName(id)}.png`, "image/png", blob));
}

function buildExports() {
  const save = (id, format, name) => make("button", { type: "button", "data-export": `${id}.${format}`, "aria-label": `${name} as ${format}`, onclick: () => exportPlot(id, format) }, format);
  const rows = PANELS.map(({ id, name }) => make("li", { "data-save": id }, make("span", {}, name), save(id, "png", name), save(id, "svg", name)));
  const data = make("li", {}, make("span", {}, "Every sample shown"), make("button", { type: "button", "data-export": "csv", "aria-label": "Every sample shown as csv", onclick: () => download(`${fileName("samples")}.csv`, "text/csv", csv()) }, "csv"));
  return make("details", { id: "saves" }, make("summary", {}, "Save plots and samples"), make("ul", { class: "saves" }, ...rows, data));
}

/** Brings the browser of trials back from where it was opened. */
function bringBack(browserHost = byId("browser")) {
  const home = byId("trials");
  if (!home || !browserHost || home.contains(browserHost)) return;
  home.querySelector(".elsewhere")?.remove();
  home.append(browserHost);
}

/** Opens trials in the browser from elsewhere on the page, or there with `host`, and takes the focus to them; of a score (`index` names the metric) the answers, too. */
function openTrials({ index = null, ...patch }, host = null) {
  const from = document.activeElement?.closest("section");
  if (!host && matrix.open?.view) closeRow();
  bringBack();
  byId("score-answers")?.remove();
  if (study.metrics[index]?.items) {
    const wanted = ({ p, s, e, m, r = "all" }) => study.trials.filter((trial) => (p === EVERY || p === trial.participant) && (s === EVERY || s === trial.session) && e === trial.environment && m.includes(trial.mode) && (r === "all" || r === trial.repeat) && Number.isFinite(measured(trial, index)));
    const answers = answersBehind(index, wanted(patch));
    if (host) host.append(answers);
    else if (parts.surface) byId("browser").before(answers);
    else (from ?? byId("dots")).append(answers);
    if (!parts.surface) {
      answers.scrollIntoView({ behavior: calm.matches ? "auto" : "smooth", block: "nearest" });
      answers.focus({ preventScroll: true });
    }
  }
  if (!parts.surface) return;
  if (host) {
    byId("trials").append(make("p", { class: "elsewhere" }, "The plots are open in the matrix. ", make("button", { type: "button", onclick: () => { const name = lineOf(matrix.open.key)?.querySelector("button"); closeRow(); name?.focus({ preventScroll: true }); } }, "Bring them back")));
    host.append(byId("browser"));
  }
  touched = true;
  Object.assign(view, { zoom: null, wall: false, brush: [null, null], r: "all" }, patch);
  browser.index = null;
  settle();
  writeControls();
  const done = refresh();
  (host ?? byId("trials")).scrollIntoView({ behavior: calm.matches ? "auto" : "smooth", block: host ? "nearest" : "start" });
  parts.surface.focus({ preventScroll: true });
  return done;
}

/** A mean of the table is over everybody, so a cell opens the trials of everybody. */
function linkMatrix() {
  for (const link of document.querySelectorAll("a[data-environment][data-mode]")) {
    const { environment, mode } = link.dataset;
    link.addEventListener("click", (event) => {
      event.preventDefault();
      openTrials({ e: environment, m: [mode], p: EVERY, s: EVERY });
    });
  }
}
