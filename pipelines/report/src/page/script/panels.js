// Panels of the trial browser: axes, curves, labels, actuator states.

const SYMBOL = LINEAR ? "x" : "θ";
const PANELS = [
  { id: "theta", x: "t", y: "theta", name: LINEAR ? "Position" : "Angle", title: `${SYMBOL} (${study.angle_unit})`, height: 205 },
  { id: "velocity", x: "t", y: "velocity", name: "Velocity", title: `${SYMBOL}\u0307 (${study.angle_unit}/s)`, height: 180 },
  { id: "force", x: "t", y: "force", name: FORCE === "N" ? "Force" : "Torque", title: `${FORCE === "N" ? "F" : "τ"} of the user (${FORCE})`, height: 205 },
  { id: "states", x: "t", y: null, name: "Actuators", title: null, height: 0 },
  { id: "loop", x: "theta", y: "force", name: LINEAR ? "Force over position" : "Force over angle", title: `${FORCE === "N" ? "F" : "τ"} of the user (${FORCE})`, height: 0 },
];
const UNIT_SCALE = { t: 1, theta: ANGLE_SCALE, velocity: ANGLE_SCALE, force: 1 };
const MARGIN = { left: 46, right: 12, top: 26, bottom: 38 };
const browser = { of: {}, curves: [], rows: [], active: 0, index: null, ready: 0 };
const timeTitle = () => ({ onset: "time since onset (s)", landmarks: "time by landmarks (s)", none: "time (s)" })[view.a];

/** Rows of the panel of actuator states: mode × actuator, where any curve ever has it on. */
function findStateRows() {
  const rows = [];
  for (const mode of browser.of.m)
    for (const [bit, name] of [[256, "motor"], [128, "brake"]]) {
      const curves = browser.curves.filter((curve) => curve.mode === mode && curve.kind === "trial" && curve.overTime && curve.bits && !curve.who.isBeside);
      if (curves.some((curve) => curve.bits.some((bits) => bits & bit))) rows.push({ mode, bit, name, curves });
    }
  return rows;
}

const known = new WeakMap(); // least and largest value of whole columns, which most drawings need
function extremes(values) {
  if (!known.has(values)) known.set(values, extremesOf(values, () => true, 0, values.length));
  return known.get(values);
}

function extremesOf(values, counts, from, to) {
  let low = Infinity, high = -Infinity;
  for (let i = from; i < to; i++) {
    if (values[i] < low && counts(i)) low = values[i];
    if (values[i] > high && counts(i)) high = values[i];
  }
  return [low, high];
}

/** Range of what is shown: t, θ, θ̇, F in stored units; zoom in time and at the wall narrow each other's view. */
function ranges() {
  const wall = view.wall ? wallOf(browser.of.e) : null;
  const reach = 2 / ANGLE_SCALE; // ±2° (or mm)
  const near = wall === null ? null : [wall - reach, wall + reach];
  const range = { t: [Infinity, -Infinity], theta: [Infinity, -Infinity], velocity: [Infinity, -Infinity], force: [Infinity, -Infinity] };
  const widen = (name, [low, high]) => { range[name] = [Math.min(range[name][0], low), Math.max(range[name][1], high)]; };
  let commanded = [Infinity, -Infinity];
  for (const curve of browser.curves) {
    const { t, theta, velocity, force, command } = curve.y;
    const zoomed = view.zoom && curve.overTime;
    const inView = (i) => !near || !theta || (theta[i] >= near[0] && theta[i] <= near[1]);
    const of = (values) => (zoomed || near ? extremesOf(values, inView, zoomed ? lowerBound(t, view.zoom[0]) : 0, zoomed ? lowerBound(t, view.zoom[1]) : curve.n) : extremes(values));
    if (curve.overTime) widen("t", of(t));
    if (theta) widen("theta", of(theta));
    if (velocity && curve.overTime) widen("velocity", of(velocity));
    if (force) widen("force", of(force));
    if (command && view.show.has("command")) commanded = [Math.min(commanded[0], of(command)[0]), Math.max(commanded[1], of(command)[1])];
  }
  // A brake at the wall is commanded far more than anybody feels; that must not squeeze what was felt.
  const beyond = 0.3 * (range.force[1] - range.force[0]);
  if (beyond >= 0) widen("force", [Math.max(commanded[0], range.force[0] - beyond), Math.min(commanded[1], range.force[1] + beyond)]);
  else widen("force", commanded);
  const within = Object.fromEntries(Object.entries(range).map(([name, [low, high]]) => [name, padded(low, high, name === "t" ? 0.01 : 0.05)]));
  if (view.zoom) within.t = view.zoom;
  if (near) within.theta = near;
  return within;
}

/** Draws one panel with any pen, and gives the scales for the cursor. */
function drawPanel(pen, panel, width, height, theme, range, exported) {
  // Of the panels over time the last one has their title.
  const bottom = panel.x !== "t" || panel.id === screen.last || exported ? MARGIN.bottom : 22;
  const box = { x: MARGIN.left, y: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - bottom };
  const sx = scale(range[panel.x], box.x, box.x + box.width);
  if (panel.y === null) return drawStates(pen, panel, box, sx, theme, range);
  const sy = scale(range[panel.y], box.y + box.height, box.y);
  drawAxes(pen, panel, box, range, theme, exported, height - box.y - box.height > 30);
  let taken = []; // places of labels
  pen.within(box, () => {
    taken = drawWall(pen, panel, box, sx, sy, theme);
    drawBrush(pen, panel, box, sx, theme);
    for (const curve of drawnIn(panel)) drawCurve(pen, panel, curve, sx, sy, theme);
    if (view.show.has("events")) for (const curve of drawnIn(panel)) drawEvents(pen, panel, curve, sx, sy, theme);
  });
  drawLabels(pen, panel, box, sx, sy, theme, taken);
  return { box, sx, sy };
}

/** Whether a sample of a curve lies within a box. */
function isWithin({ y, n, overTime }, panel, { box, sx, sy }, values) {
  const xs = y[panel.x];
  const from = panel.x === "t" && overTime ? lowerBound(xs, sx.low) : 0, to = panel.x === "t" && overTime ? Math.min(n, lowerBound(xs, sx.high) + 1) : n;
  for (let i = from; i < to; i++) if (isInside(sx.k * xs[i] + sx.c, sy.k * values[i] + sy.c, box)) return true;
  return false;
}

const isInside = (px, py, box) => px > box.x && px < box.x + box.width && py > box.y && py < box.y + box.height;

/** What can be seen in a panel: the modes whose colour a curve has, and the kinds of curves and marks. The page explains these beside it. */
function seenIn(panel, scales) {
  const modes = new Set(), marks = new Set();
  for (const curve of drawnIn(panel)) {
    const see = (values, mark) => {
      if (!isWithin(curve, panel, scales, values)) return;
      marks.add(mark);
      if (curve.kind !== "replay") modes.add(curve.mode);
    };
    see(curve.y[panel.y], curve.kind);
    if (panel.y === "force" && view.show.has("command") && curve.y.command) see(curve.y.command, "command");
  }
  if (!view.show.has("events")) return { modes, marks };
  for (const curve of drawnIn(panel)) for (const { kind, x, y } of eventsOn(curve, panel, scales.sx, scales.sy)) if (isInside(x, y, scales.box)) marks.add(kind);
  return { modes, marks };
}

/** Whether a panel has anything to draw, whatever part of it is shown. */
const hasCurve = (panel) => drawnIn(panel).some(({ y }) => y[panel.y].some(Number.isFinite));

const drawnIn = (panel) => browser.curves.filter((curve) => (panel.id === "loop" ? curve.overAngle : curve.overTime) && curve.y[panel.x] && (panel.y === null || curve.y[panel.y]));

function drawAxes(pen, panel, box, range, theme, exported, withTitle) {
  const right = box.x + box.width, foot = box.y + box.height;
  const shown = (name) => [range[name][0] * UNIT_SCALE[name], range[name][1] * UNIT_SCALE[name]];
  const sx = scale(shown(panel.x), box.x, right), sy = scale(shown(panel.y), foot, box.y);
  for (const { value, text } of ticks(...shown(panel.x), box.width / 70)) {
    const x = sx.k * value + sx.c;
    pen.line([x, box.y, x, foot], { colour: theme.grid });
    pen.text(text, x, foot + 12, { colour: theme.quiet, align: "center" });
  }
  for (const { value, text } of ticks(...shown(panel.y), box.height / 32)) {
    const y = sy.k * value + sy.c;
    pen.line([box.x, y, right, y], { colour: theme.grid });
    pen.text(text, box.x - 6, y, { colour: theme.quiet, align: "end" });
  }
  pen.line([box.x, box.y, box.x, foot, right, foot], { colour: theme.quiet });
  pen.text(panel.title, exported ? box.x : 6, 12, { colour: theme.ink, bold: true });
  if (withTitle) pen.text(panel.x === "t" ? timeTitle() : `${SYMBOL} (${study.angle_unit})`, right, foot + 28, { colour: theme.quiet, align: "end" });
}

function drawWall(pen, panel, box, sx, sy, theme) {
  const wall = wallOf(browser.of.e);
  if (wall === null || (panel.x !== "theta" && panel.y !== "theta")) return [];
  const style = { colour: theme.quiet, width: 1.25, dash: [5, 4] };
  const label = `wall ${significant(wall * ANGLE_SCALE)}${LINEAR ? " mm" : "°"}`;
  const { low, high } = panel.y === "theta" ? sy : sx;
  if (wall < low || wall > high) return []; // beside a wall out of sight its name would stand alone
  if (panel.y === "theta") {
    const y = sy.k * wall + sy.c;
    pen.line([box.x, y, box.x + box.width, y], style);
    const beside = y - 9 < box.y + 8 ? y + 10 : y - 9;
    pen.text(label, box.x + 5, beside, { colour: theme.quiet, halo: theme.paper });
    return [{ x: box.x + 35, y: beside }];
  }
  const x = sx.k * wall + sx.c;
  pen.line([x, box.y, x, box.y + box.height], style);
  pen.text(label, x - 5, box.y + box.height - 10, { colour: theme.quiet, halo: theme.paper, align: "end" });
  return [{ x: x - 35, y: box.y + box.height - 10 }];
}

function drawBrush(pen, panel, box, sx, theme) {
  const [from, to] = view.brush;
  if (panel.x !== "t") return;
  if (Number.isFinite(from) && Number.isFinite(to)) pen.rect(sx.k * from + sx.c, box.y, sx.k * (to - from), box.height, { colour: theme.ink, opacity: 0.1 });
  for (const edge of view.brush) if (Number.isFinite(edge)) pen.line([sx.k * edge + sx.c, box.y, sx.k * edge + sx.c, box.y + box.height], { colour: theme.ink, opacity: 0.6 });
}

function drawCurve(pen, panel, curve, sx, sy, theme) {
  const style = styleOf(curve, browser.curves, theme);
  const { t } = curve.y;
  const from = panel.x === "t" ? Math.max(0, lowerBound(t, sx.low) - 1) : 0;
  const to = panel.x === "t" ? Math.min(curve.n, lowerBound(t, sx.high) + 1) : curve.n;
  const points = (y, first, last) => (panel.x === "t" ? thinOverTime(t, y, first, last, sx, sy) : thinLoop(curve.y[panel.x], y, first, last, sx, sy));
  const marked = panel.x !== "t" && view.brush.every(Number.isFinite);
  if (panel.y === "force" && view.show.has("command") && curve.y.command) pen.line(points(curve.y.command, from, to), { ...style, width: 1, dash: [2, 2], opacity: marked ? 0.15 : 0.7 });
  pen.line(points(curve.y[panel.y], from, to), marked ? { ...style, opacity: 0.18 } : style);
  if (marked && curve.overTime) pen.line(points(curve.y[panel.y], lowerBound(t, view.brush[0]), lowerBound(t, view.brush[1])), { ...style, dash: [], width: style.width + 1, opacity: curve.kind === "trial" && style.opacity ? 0.7 : 1 });
}

/** Where the events of a curve stand in a panel. */
function eventsOn(curve, panel, sx, sy) {
  if (panel.y === "velocity" || curve.kind !== "trial") return [];
  return curve.events.filter(({ kind }) => Object.hasOwn(EVENTS, kind)).map(({ kind, t_s: time }) => {
    const i = nearestIndex(curve.stored.t_s, time);
    return { kind, x: sx.k * curve.y[panel.x][i] + sx.c, y: sy.k * curve.y[panel.y][i] + sy.c };
  }).filter(({ x, y }) => Number.isFinite(x) && Number.isFinite(y));
}

function drawEvents(pen, panel, curve, sx, sy, theme) {
  for (const { kind, x, y } of eventsOn(curve, panel, sx, sy)) pen.text(EVENTS[kind][0], x, y, { colour: theme.ink, halo: theme.paper, size: 13, align: "center" });
}

/** Names on the curves themselves: for each mode the place farthest from all curves and other names, if there is room. */
function drawLabels(pen, panel, box, sx, sy, theme, taken) {
  const drawn = drawnIn(panel);
  const chosen = study.modes.flatMap(({ id }) => {
    const mine = drawn.filter((curve) => curve.mode === id && isWithin(curve, panel, { box, sx, sy }, curve.y[panel.y]));
    const strongest = mine.find((curve) => curve.kind === "mean") ?? mine.find((curve) => curve.kind === "trial");
    return [...(strongest ? [{ curve: strongest, text: short(labelOf(study.modes, id), 16) }] : []), ...mine.filter((curve) => curve.kind === "replay").map((curve) => ({ curve, text: `replay, ${curve.model.replace("_", " ")}` }))];
  });
  const traces = chosen.map(({ curve }) => pixels(curve, panel, box, sx, sy, 200));
  const crowd = traces.flat();
  const placed = [...taken];
  chosen.forEach(({ curve, text }, c) => {
    const others = traces.filter((_, other) => other !== c).flat();
    const place = roomiest(pixels(curve, panel, box, sx, sy, 60), 3.4 * text.length, box, crowd, others, placed);
    if (!place) return;
    placed.push(place);
    pen.text(text, place.x, place.y, { colour: curve.kind === "replay" ? theme.ink : theme.modes[modeIndex(curve.mode)], halo: theme.paper, align: "center", bold: true });
  });
}

/** About `count` points of a curve that lie within the box: x, y, x, y, … */
function pixels({ y, n }, panel, box, sx, sy, count) {
  const xs = y[panel.x], ys = y[panel.y], points = [];
  for (let k = 0; k < Math.min(n, count); k++) {
    const i = n <= count ? k : Math.floor((k * n) / count);
    const px = sx.k * xs[i] + sx.c, py = sy.k * ys[i] + sy.c;
    if (px > box.x && px < box.x + box.width && py > box.y && py < box.y + box.height) points.push(px, py);
  }
  return points;
}

/** Beside which of a curve's points a label of this half width has most room, best where the curve is far from others. */
function roomiest(points, half, box, crowd, others, placed) {
  let best = null;
  const consider = (x, y, alone) => {
    if (x - half < box.x || x + half > box.x + box.width || y < box.y + 8 || y > box.y + box.height - 8) return;
    let apart = 24, room = 22;
    for (const other of placed) apart = Math.min(apart, Math.abs(other.x - x) / 3 + Math.abs(other.y - y));
    if (apart < 14) return;
    const least = Math.max(5, best ? best.score - apart - alone : 0);
    for (let i = 0; i < crowd.length && room > least; i += 2) {
      const distance = Math.max(0, Math.abs(crowd[i] - x) - half) + Math.abs(crowd[i + 1] - y);
      if (distance < room) room = distance;
    }
    if (room > least) best = { x, y, score: room + apart + alone };
  };
  for (let i = 0; i < points.length; i += 2) {
    const x = points[i], y = points[i + 1];
    let alone = 40;
    for (let k = 0; k < others.length; k += 2) alone = Math.min(alone, Math.abs(others[k] - x) + Math.abs(others[k + 1] - y));
    consider(x, y - 14, alone);
    consider(x + half + 8, y, alone);
    consider(x - half - 8, y, alone);
    consider(x, y + 14, alone);
  }
  return best;
}

/** The rows of actuator states of which something can be seen. */
const rowsWithin = ([low, high]) => browser.rows.filter(({ bit, curves }) => curves.some((curve) => runs(curve, bit).some(([from, to]) => to >= low && from <= high)));

function drawStates(pen, panel, box, sx, theme, range) {
  const rows = screen.rows;
  const foot = MARGIN.top + 16 * rows.length;
  const title = `${distinct(rows.map(({ name }) => name)).join(" and ")} on${rows.some(({ curves }) => curves.length > 1) ? "; darker: in more of the repeats" : ""}`;
  pen.text(title, 6, 12, { colour: theme.quiet });
  rows.forEach(({ mode, bit, name, curves }, row) => {
    const y = MARGIN.top + 16 * row;
    pen.text(name, box.x - 6, y + 6, { colour: theme.quiet, align: "end", size: 11 });
    pen.line([box.x, y + 6, box.x + box.width, y + 6], { colour: theme.grid });
    pen.within({ x: box.x, y, width: box.width, height: 12 }, () => {
      for (const curve of curves)
        for (const [from, to] of runs(curve, bit)) pen.rect(sx.k * from + sx.c, y + 1, Math.max(0.5, sx.k * (to - from)), 10, { colour: theme.modes[modeIndex(mode)], opacity: 1 - 0.12 ** (1 / curves.length) });
    });
  });
  for (const { value, text } of ticks(...range.t, box.width / 70)) pen.text(text, sx.k * value + sx.c, foot + 8, { colour: theme.quiet, align: "center" });
  pen.text(timeTitle(), box.x + box.width, foot + 24, { colour: theme.quiet, align: "end" });
  return { box: { ...box, height: 16 * rows.length }, sx, sy: null };
}

/** Spans of time in which a bit is set. */
function runs({ bits, y, n }, bit) {
  const spans = [];
  for (let i = 0, start = -1; i <= n; i++) {
    const on = i < n && (bits[i] & bit) !== 0;
    if (on && start < 0) start = i;
    if (!on && start >= 0) { spans.push([y.t[start], y.t[Math.min(i, n - 1)]]); start = -1; }
  }
  return spans;
}
