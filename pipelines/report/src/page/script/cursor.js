// Cursor, brush, zoom.

function pointIn(panel, event) {
  const { plot, scales } = screen.plots.get(panel.id);
  const frame = plot.getBoundingClientRect();
  const x = event.clientX - frame.left, y = event.clientY - frame.top;
  return { x, y, t: panel.x === "t" && scales ? Math.min(scales.sx.high, Math.max(scales.sx.low, (x - scales.sx.c) / scales.sx.k)) : null };
}

/** Puts the cursor on the sample nearest to the pointer. */
function hover(panel, event) {
  const { scales } = screen.plots.get(panel.id);
  if (!scales || !scales.sy) return;
  const { x, y, t } = pointIn(panel, event);
  let best = null;
  browser.curves.forEach((curve, c) => {
    if (!drawnIn(panel).includes(curve)) return;
    const xs = curve.y[panel.x], ys = curve.y[panel.y];
    const consider = (i) => {
      const distance = Math.hypot(scales.sx.k * xs[i] + scales.sx.c - x, scales.sy.k * ys[i] + scales.sy.c - y);
      if (!best || distance < best.distance) best = { distance, c, i };
    };
    if (panel.x === "t") consider(nearestIndex(xs, t));
    else for (let i = 0; i < curve.n; i++) consider(i);
  });
  if (best && Number.isFinite(best.distance)) { browser.active = best.c; moveTo(best.i, false); }
}

function moveTo(index, spoken = true) {
  const active = browser.curves[browser.active];
  if (!active) return;
  browser.index = Math.min(active.n - 1, Math.max(0, index));
  drawCursor();
  writeReadout();
  if (spoken) speakSoon();
}

/** The next curve that is drawn over time, at the same time. */
function otherCurve(step) {
  const time = browser.curves[browser.active]?.y.t[browser.index ?? 0];
  for (let tries = 0; tries < browser.curves.length; tries++) {
    browser.active = (browser.active + step + browser.curves.length) % browser.curves.length;
    const curve = browser.curves[browser.active];
    if (curve.overTime || view.a === "landmarks") return moveTo(nearestIndex(curve.y.t, time));
  }
}

function setBrush(a, b) {
  view.brush = a === b ? [null, null] : [Math.min(a, b), Math.max(a, b)];
  drawSoon();
}

function setEdge(edge) {
  const active = browser.curves[browser.active];
  if (!active || browser.index === null || !active.overTime) return;
  view.brush[edge] = active.y.t[browser.index];
  const [from, to] = view.brush;
  if (from !== null && to !== null) setBrush(from, to);
  touched = true;
  keepHash();
  drawSoon();
  parts.live.textContent = `Span ${edge ? "to" : "from"} ${rounded(active.y.t[browser.index], 3)} s`;
}

const zoomBy = (patch, words) => { Object.assign(view, patch); touched = true; writeControls(); keepHash(); drawSoon(); parts.live.textContent = words; };
const zoomToSpan = () => view.brush.every(Number.isFinite) && zoomBy({ zoom: [...view.brush], brush: [null, null] }, "Zoomed to the span");
const zoomToWall = () => wallOf(view.e) !== null && zoomBy({ wall: !view.wall }, view.wall ? "Whole range" : "Zoomed at the wall");
const resetZoom = () => zoomBy({ zoom: null, wall: false, brush: [null, null] }, "Whole range");

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target !== parts.surface) return;
  const at = browser.index ?? 0;
  const keys = {
    ArrowLeft: () => moveTo(at - 1), ArrowRight: () => moveTo(at + 1), PageUp: () => moveTo(at - 10), PageDown: () => moveTo(at + 10),
    Home: () => moveTo(0), End: () => moveTo(Infinity), ArrowUp: () => otherCurve(-1), ArrowDown: () => otherCurve(1),
    "[": () => setEdge(0), "]": () => setEdge(1), z: zoomToSpan, w: zoomToWall, Escape: resetZoom,
  };
  const act = keys[event.key] ?? keys[event.key.toLowerCase()];
  if (!act) return;
  event.preventDefault();
  act();
}

/** The values at the cursor: rounded to read, the stored number in `data-value`. */
function writeReadout() {
  const active = browser.curves[browser.active];
  if (!active || browser.index === null) {
    parts.readout.replaceChildren(make("div", {}, make("dt", {}, "Cursor"), make("dd", {}, "point at a curve, or press an arrow key in the plots")));
    return;
  }
  const i = browser.index;
  Object.assign(parts.readout.dataset, { kind: active.kind, participant: active.who.p, session: active.who.s, key: active.key, trial: active.trial ?? "", index: i });
  const unit = { theta_rad: [SYMBOL, ANGLE_SCALE, 2, study.angle_unit], theta_dot_rad_s: [`${SYMBOL}\u0307`, ANGLE_SCALE, 1, `${study.angle_unit}/s`], force_ex_n: ["F of the user", 1, 3, "N"], torque_ex_nm: ["τ of the user", 1, 4, "N·m"], force_cmd_n: ["F commanded", 1, 3, "N"], torque_cmd_nm: ["τ commanded", 1, 4, "N·m"] };
  const entry = (name, text, column, value) => make("div", {}, make("dt", {}, name), make("dd", column ? { "data-column": column, "data-value": exact(value), title: `stored: ${exact(value)}` } : {}, text));
  const rows = [entry("Curve", active.label), entry("t", `${rounded(active.stored.t_s[i], 4)} s`, "t_s", active.stored.t_s[i])];
  if (active.shift) rows.push(entry("since onset", `${rounded(active.y.t[i], 4)} s`));
  for (const [column, [name, factor, digits, suffix]] of Object.entries(unit)) {
    const values = active.stored[column];
    if (values) rows.push(entry(name, `${rounded(values[i] * factor, digits)}${suffix === "°" ? "" : " "}${suffix}`, column, values[i]));
  }
  if (active.bits) rows.push(entry("state", Object.entries(BITS).filter(([bit]) => active.bits[i] & bit).map(([, name]) => name).join(", ") || "none", "state_bits", active.bits[i]));
  parts.readout.replaceChildren(...rows);
}

let speaking = 0;
/** Speaks the readout once the cursor has rested, not on every step. */
function speakSoon() {
  clearTimeout(speaking);
  speaking = setTimeout(() => { parts.live.textContent = [...parts.readout.children].map((row) => `${row.firstChild.textContent} ${row.lastChild.textContent}`).join(", "); }, 600);
}
