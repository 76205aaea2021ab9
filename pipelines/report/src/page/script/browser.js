// The trial browser on the page: what can be chosen.

const parts = {}; // the browser's elements
// What is on the screen: "rows" of actuator states, "last" the panel that has the title of the time, "seen" which modes and marks.
const screen = { theme: null, range: null, plots: new Map(), rows: [], last: null, seen: { modes: new Set(), marks: new Set() } };

function option(value, text, chosen) {
  return make("option", { value, selected: chosen }, short(text, 60));
}

function field(label, id, change) {
  const select = make("select", { id, onchange: () => change(select.value) });
  return [make("label", { class: "field", for: id }, make("span", {}, label), select), select];
}

function tickBox(label, checked, change, extra = {}) {
  const box = make("input", { type: "checkbox", checked, ...extra, onchange: () => change(box.checked) });
  return make("label", { class: "tick" }, box, ...[label].flat());
}

/** A short piece of the mode's line: colour and dashes as in the plots. */
function swatch(index) {
  const line = makeSvg("line", { x1: 1, y1: 5, x2: 27, y2: 5, "stroke-width": 3, style: `stroke: var(--mode-${index % MODE_COLOURS})`, "stroke-dasharray": DASHES[index % DASHES.length].join(" ") || "none" });
  return makeSvg("svg", { width: 28, height: 10, "aria-hidden": "true", class: "swatch" }, line);
}

const change = (patch) => { Object.assign(view, patch); settle(); writeControls(); return refresh(); };

function buildBrowser(host) {
  const [participant, pickParticipant] = field("Participant", "pick-participant", (p) => change({ p }));
  const [session, pickSession] = field("Session", "pick-session", (s) => change({ s }));
  const [environment, pickEnvironment] = field("Environment", "pick-environment", (e) => change({ e, zoom: null, brush: [null, null] }));
  const [repeat, pickRepeat] = field("Repeats", "pick-repeat", (r) => change({ r: Number(r) || "all" }));
  const [beside, pickBeside] = field("Beside it", "pick-beside", (key) => change({ beside: key || null }));
  const [align, pickAlign] = field("Time from", "pick-align", (a) => change({ a, zoom: null, brush: [null, null] }));
  const modes = make("fieldset", { class: "ticks", id: "pick-modes" }, make("legend", {}, "Modes"));
  const show = make("fieldset", { class: "ticks", id: "pick-show" }, make("legend", {}, "Show"));
  const button = (id, label, act, title) => make("button", { type: "button", id, title, onclick: act }, label);
  const tools = make("div", { class: "tools", role: "group", "aria-label": "Cursor and zoom" },
    button("span-start", "Span from here", () => setEdge(0), "key ["), button("span-end", "Span to here", () => setEdge(1), "key ]"),
    button("zoom-span", "Zoom to span", zoomToSpan, "key Z"), button("zoom-wall", "Zoom at the wall", zoomToWall, "key W"), button("zoom-reset", "Reset", resetZoom, "Escape"));
  const panels = PANELS.map(buildPanel);
  const surface = make("div", { class: "surface", id: "surface", tabindex: "0", role: "application", "aria-roledescription": "plot", "aria-label": "Plots of the chosen trials", "aria-describedby": "surface-keys", "aria-details": "trial-table", onkeydown: onKey, onfocus: () => browser.index === null && moveTo(0) }, ...panels);
  const keys = make("p", { class: "caption", id: "surface-keys" }, "In the plots: ", make("kbd", {}, "←"), make("kbd", {}, "→"), " sample by sample, ", make("kbd", {}, "Page"), " ten at a time, ", make("kbd", {}, "Home"), make("kbd", {}, "End"), " ends, ", make("kbd", {}, "↑"), make("kbd", {}, "↓"), " another curve, ", make("kbd", {}, "["), make("kbd", {}, "]"), " mark a span, ", make("kbd", {}, "Z"), " zoom to it, ", make("kbd", {}, "W"), " at the wall, ", make("kbd", {}, "Esc"), " reset.");
  Object.assign(parts, { pickParticipant, pickSession, pickEnvironment, pickRepeat, pickAlign, pickBeside, beside, modes, show, surface, session,
    status: make("p", { class: "status", role: "status" }), note: make("p", { class: "caption" }), readout: make("dl", { class: "readout", id: "readout" }), live: make("p", { class: "unseen", "aria-live": "polite", id: "live" }), table: buildTable() });
  host.replaceChildren(make("div", { class: "controls", role: "group", "aria-label": "Trials to show" }, participant, session, environment, beside, repeat, align, modes, show), tools, parts.status, surface, parts.readout, parts.live, parts.note, keys, parts.table, buildExports());
  host.dataset.ready = "true";
}

function buildPanel(panel) {
  const base = make("canvas", { "aria-hidden": "true" });
  const over = make("canvas", { "aria-hidden": "true", class: "over" });
  const plot = make("div", { class: "plot", "data-panel": panel.id }, base, over);
  screen.plots.set(panel.id, { panel, plot, base, over, scales: null });
  if (panel.y === null) return plot;
  let dragged = null;
  const time = (event) => pointIn(panel, event).t;
  plot.addEventListener("pointermove", (event) => {
    if (dragged !== null && Math.abs(event.clientX - dragged.x) > 3) { dragged.moved = true; setBrush(dragged.t, time(event)); }
    hover(panel, event);
  });
  plot.addEventListener("pointerdown", (event) => {
    hover(panel, event);
    if (panel.x !== "t" || event.button !== 0) return;
    dragged = { t: time(event), x: event.clientX };
    plot.setPointerCapture(event.pointerId);
  });
  for (const end of ["pointerup", "pointercancel"]) plot.addEventListener(end, () => { if (dragged?.moved) keepHash(); dragged = null; });
  return plot;
}

/** The controls as the view has them. */
function writeControls() {
  const every = (ids, chosen) => (ids.length > 1 ? [option(EVERY, "all", chosen === EVERY)] : []);
  const people = [...sessionsOf.keys()], sessions = view.p === EVERY ? [] : [...sessionsOf.get(view.p)];
  parts.pickParticipant.replaceChildren(...every(people, view.p), ...people.map((id) => option(id, id, id === view.p)));
  parts.pickSession.replaceChildren(...every(sessions, view.s), ...sessions.map((id) => option(id, id, id === view.s)));
  parts.session.hidden = sessions.length < 2;
  const there = study.environments.filter(({ id }) => study.modes.some((mode) => hasTrials(id, mode.id)));
  parts.pickEnvironment.replaceChildren(...there.map(({ id, label }) => option(id, label, id === view.e)));
  const others = besides();
  parts.pickBeside.replaceChildren(option("", "nothing", !view.beside), ...others.map(({ key, label }) => option(key, label, key === view.beside)));
  parts.beside.hidden = !others.length;
  const repeats = distinct(shownTrials().map((trial) => trial.repeat)).sort((a, b) => a - b);
  parts.pickRepeat.replaceChildren(option("all", "all", view.r === "all"), ...repeats.map((r) => option(r, `only ${r}`, view.r === r)));
  parts.pickAlign.replaceChildren(...Object.entries(ALIGN).map(([id, label]) => option(id, label, id === view.a)));
  keepFocus(parts.modes, study.modes.map((mode, i) => {
    const there = hasTrials(view.e, mode.id);
    return tickBox([swatch(i), short(mode.label, 40)], view.m.includes(mode.id), (on) => change({ m: on ? [...view.m, mode.id] : view.m.filter((id) => id !== mode.id) }), { value: mode.id, disabled: !there });
  }));
  keepFocus(parts.show, Object.entries(SHOW).map(([id, label]) => tickBox(label, view.show.has(id), (on) => { view.show[on ? "add" : "delete"](id); change({}); }, { value: id })));
  showSwatches();
  byId("zoom-wall").hidden = wallOf(view.e) === null;
  byId("zoom-wall").setAttribute("aria-pressed", String(view.wall));
}

/** A mode has its line beside its name while a curve of it can be seen. */
function showSwatches() {
  for (const box of parts.modes.querySelectorAll("input")) box.parentElement.querySelector(".swatch").classList.toggle("absent", !screen.seen.modes.has(box.value));
}

/** Replaces a fieldset's boxes, and gives the focus back to the one that had it. */
function keepFocus(fieldset, boxes) {
  const focused = fieldset.contains(document.activeElement) ? document.activeElement.value : null;
  fieldset.replaceChildren(fieldset.firstElementChild, ...boxes);
  if (focused !== null) fieldset.querySelector(`input[value="${CSS.escape(focused)}"]`)?.focus();
}

let refreshes = 0;
/** Loads what the view names, and draws it. A newer wish wins over an older one. */
async function refresh() {
  const mine = ++refreshes;
  const wanted = view.m.flatMap((mode) => trialsIn(view.e, mode).map(([{ data: key, participant: p, session: s }]) => ({ mode, key, who: { p, s, e: view.e } }))).filter(({ key }) => key);
  const other = besides().find(({ key }) => key === view.beside);
  if (other) for (const mode of view.m) for (const [{ data: key }] of [trialsBy.get(pathOf(other.p, other.s, other.e, mode))].filter(Boolean)) wanted.push({ mode, key, who: { ...other, isBeside: true } });
  const waiting = setTimeout(() => mine === refreshes && say("Loading …"), 200);
  const found = await Promise.allSettled(wanted.map(({ key }) => condition(key)));
  clearTimeout(waiting);
  if (mine !== refreshes) return;
  const lost = found.filter((one) => one.status === "rejected").map((one) => one.reason.message);
  say(distinct(lost).join(". "), lost.length > 0);
  const active = browser.curves[browser.active];
  browser.of = { p: view.p, s: view.s, e: view.e, m: [...view.m], r: view.r };
  browser.curves = found.flatMap((one, i) => (one.status === "fulfilled" ? curvesOfMode(wanted[i], one.value) : []));
  browser.active = Math.max(0, browser.curves.findIndex((curve) => active && curve.label === active.label));
  if (!browser.curves[browser.active]?.overTime) browser.active = Math.max(0, browser.curves.findIndex((curve) => curve.overTime));
  browser.index = browser.curves.length && browser.index !== null ? Math.min(browser.index, browser.curves[browser.active].n - 1) : null;
  browser.rows = findStateRows();
  keepHash();
  drawAll();
  writeReadout();
  closeTable();
}

const say = (text, bad = false) => { parts.status.textContent = text; parts.status.classList.toggle("bad", bad); };
let touched = false; // the address stays as it was until somebody chooses something
const keepHash = () => touched && !matrix.open?.view && history.replaceState(null, "", writeHash());

/** What the plots show that is not named on them. */
function writeNote() {
  const notes = [], { marks } = screen.seen;
  const sessions = distinct(browser.curves.map(({ who }) => `${who.p} ${who.s}`)).length, all = [...sessionsOf.values()].reduce((sum, some) => sum + some.size, 0);
  if (view.p === EVERY && all > MOST_TOGETHER) notes.push(`The first ${MOST_TOGETHER} of ${all} sessions are shown.`);
  else if (sessions > 1 && !view.beside) notes.push(`${sessions} sessions are shown together; a curve says whose it is at the cursor.`);
  if (view.beside) notes.push(`Dotted: ${besides().find(({ key }) => key === view.beside)?.label ?? ""}, beside ${view.p} ${view.s}, ${labelOf(study.environments, view.e)}.`);
  if (!browser.curves.length) notes.push("No curve is shown: choose repeats or the mean under “Show”.");
  if (marks.has("mean") && view.a === "onset" && browser.curves.some((curve) => curve.kind === "mean" && !curve.overTime)) notes.push("Thick: mean of the repeats, over time from their onsets, over the angle by landmarks (start, contact, reversal and end meet).");
  else if (marks.has("mean")) notes.push(`Thick: mean of the repeats, ${view.a === "landmarks" ? "by landmarks" : "from their onsets"}.`);
  if (view.a === "none" && view.show.has("mean")) notes.push("A mean needs a time from onset or by landmarks.");
  if (marks.has("command")) notes.push("Fine dots: commanded force, cut off where it goes far beyond the measured one.");
  if (marks.has("replay")) notes.push("Replay: the model, given the recorded force.");
  else if (view.show.has("replay") && !browser.curves.some((curve) => curve.kind === "replay")) notes.push("No replay of these trials is stored.");
  const events = Object.entries(EVENTS).filter(([kind]) => marks.has(kind)).map(([, [sign, name]]) => `${sign} ${name}`);
  if (events.length) notes.push(`${events.join("  ")}.`);
  for (const curve of browser.curves.filter((one) => one.recorded > one.n)) notes.push(`${curve.label}: ${curve.n.toLocaleString("en")} of ${curve.recorded.toLocaleString("en")} recorded samples are shown, among them the extremes of each short stretch.`);
  parts.note.textContent = notes.join(" ");
}
