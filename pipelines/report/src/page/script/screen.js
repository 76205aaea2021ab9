// The plots of the trial browser on the screen.

function sizeCanvas(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}

function drawAll() {
  const began = performance.now();
  fineness = window.devicePixelRatio || 1;
  screen.theme = readTheme();
  screen.range = ranges();
  screen.rows = view.show.has("states") ? rowsWithin(screen.range.t) : [];
  // A panel without a curve would be the name of a signal that is not there.
  for (const { panel, plot } of screen.plots.values()) {
    plot.hidden = panel.id === "states" ? screen.rows.length === 0 : !hasCurve(panel);
    parts.surface.parentElement.querySelector(`[data-save="${panel.id}"]`).hidden = plot.hidden;
  }
  const overTime = [...screen.plots.values()].filter(({ panel, plot }) => panel.x === "t" && !plot.hidden);
  screen.last = overTime.at(-1)?.panel.id;
  const heightOf = (panel) => (panel.id === "states" ? MARGIN.top + 16 * screen.rows.length + 34 : panel.height + (panel.id === screen.last ? 16 : 0));
  const stacked = matchMedia("(max-width: 720px)").matches;
  const tall = Math.max(280, overTime.reduce((sum, { panel }) => sum + heightOf(panel), 0));
  screen.seen = { modes: new Set(), marks: new Set() };
  for (const one of screen.plots.values()) {
    if (one.plot.hidden) continue;
    one.width = one.plot.clientWidth;
    one.height = one.panel.id === "loop" ? (stacked ? Math.min(420, Math.max(280, one.width)) : tall) : heightOf(one.panel);
    if (!one.width) continue;
    const context = sizeCanvas(one.base, one.width, one.height);
    one.scales = drawPanel(canvasPen(context), one.panel, one.width, one.height, screen.theme, screen.range, false);
    if (one.panel.y === null) continue;
    const { modes, marks } = seenIn(one.panel, one.scales);
    modes.forEach((mode) => screen.seen.modes.add(mode));
    marks.forEach((mark) => screen.seen.marks.add(mark));
  }
  for (const { mode } of screen.rows) screen.seen.modes.add(mode);
  showSwatches();
  writeNote();
  drawCursor();
  const spans = view.brush.every(Number.isFinite);
  byId("zoom-span").disabled = !spans;
  byId("zoom-reset").disabled = !(view.zoom || view.wall || view.brush.some(Number.isFinite));
  Object.assign(parts.surface.dataset, { drawn: String(++browser.ready), drawMs: (performance.now() - began).toFixed(1) });
}

let asked = 0;
/** Draws once a frame however often it is asked to. */
const drawSoon = () => { asked = asked || requestAnimationFrame(() => { asked = 0; drawAll(); }); };

/** The shared cursor: a line through the panels over time, a dot on every curve, a large one on the active curve. */
function drawCursor() {
  const { theme } = screen;
  const active = browser.curves[browser.active];
  for (const { panel, plot, over, scales, width, height } of screen.plots.values()) {
    if (!scales || plot.hidden) continue;
    const context = sizeCanvas(over, width, height);
    if (!active || browser.index === null) continue;
    const time = active.overTime ? active.y.t[browser.index] : null;
    const { box, sx, sy } = scales;
    if (panel.x === "t" && time !== null) canvasPen(context).line([sx.k * time + sx.c, box.y, sx.k * time + sx.c, box.y + box.height], { colour: theme.ink, width: 1, opacity: 0.55 });
    if (!sy) continue;
    canvasPen(context).within(box, () => {
      for (const curve of drawnIn(panel)) {
        if (curve === active || time === null || !curve.overTime) continue;
        dot(context, curve, nearestIndex(curve.y.t, time), panel, sx, sy, 2.5, theme);
      }
      if (drawnIn(panel).includes(active)) dot(context, active, browser.index, panel, sx, sy, 5, theme);
    });
  }
}

function dot(context, curve, index, panel, sx, sy, radius, theme) {
  const x = sx.k * curve.y[panel.x][index] + sx.c, y = sy.k * curve.y[panel.y][index] + sy.c;
  context.beginPath();
  context.arc(x, y, radius, 0, 7);
  Object.assign(context, { fillStyle: curve.kind === "replay" ? theme.ink : theme.modes[modeIndex(curve.mode)], strokeStyle: theme.paper, lineWidth: radius > 3 ? 2 : 1 });
  context.fill();
  context.stroke();
}
