// The interactive parts of a study's page: trial browser, dots, answers, the model turned by hand. One classic script without a library, because a page
// opened from disk may load neither modules nor anything by fetch. Text from the study is only ever set as text, never as markup.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const source = byId("study-data");
  if (!source) return;
  const study = JSON.parse(source.textContent);
  const LINEAR = study.angle_unit === "mm";
  const ANGLE_SCALE = study.angle_scale; // what an angle in rad is multiplied by to be shown
  const FORCE = study.force_unit || "N";
  const DASHES = [[], [8, 4], [8, 3, 2, 3], [2, 3], [12, 3], [4, 2, 1, 2]];
  const BITS = { 1: "saturated", 2: "stale force", 4: "stale angle", 8: "dropout", 16: "clipped", 32: "past wall", 64: "outside work space", 128: "brake on", 256: "motor on" };
  const EVENTS = { onset: ["○", "onset"], contact: ["×", "contact"], reversal: ["△", "reversal"], let_go: ["◇", "let-go"], end: ["□", "end"] };

  // ---- Words and numbers ----------------------------------------------------------------------------------------------------

  /** An element with attributes, listeners (`onclick`) and children; strings become text. */
  function make(tag, attributes = {}, ...children) {
    return fill(document.createElement(tag), attributes, children);
  }

  function makeSvg(tag, attributes = {}, ...children) {
    return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
  }

  function fill(element, attributes, children) {
    for (const [name, value] of Object.entries(attributes)) {
      if (typeof value === "function") element.addEventListener(name.slice(2), value);
      else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
    }
    element.append(...children.filter((child) => child !== null && child !== undefined));
    return element;
  }

  /** At most `limit` characters, so that no label breaks a plot. */
  const short = (text, limit = 28) => (String(text).length > limit ? `${String(text).slice(0, limit - 1)}…` : String(text));
  const minus = (text) => text.replace("-", "−");
  const rounded = (value, digits) => (Number.isFinite(value) ? minus(value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1")) : "–");
  const significant = (value) => (Number.isFinite(value) ? minus(String(Number(value.toPrecision(4)))) : "–");
  /** The stored number itself: reading it back gives the same 64 bits. */
  const exact = (value) => (Object.is(value, -0) ? "-0" : String(value));
  const finite = (values) => values.filter(Number.isFinite);
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const deviation = (values) => (values.length < 2 ? NaN : Math.sqrt(values.reduce((sum, value) => sum + (value - mean(values)) ** 2, 0) / (values.length - 1)));
  const distinct = (values) => [...new Set(values)];
  const environmentOf = (id) => study.environments.find((environment) => environment.id === id);
  const modeIndex = (id) => study.modes.findIndex((mode) => mode.id === id);
  const labelOf = (list, id) => list.find((item) => item.id === id)?.label ?? id;
  const calm = matchMedia("(prefers-reduced-motion: reduce)");

  // ---- Trials' data ---------------------------------------------------------------------------------------------------------

  const MOST_KEPT = 48; // conditions kept decoded; older ones are loaded again
  const kept = new Map();
  const awaited = new Map();
  window.zwidthData = (key, content) => awaited.get(key)?.(content);

  /** The condition's object as it stands in the page (one file) or beside it. */
  function fetchCondition(key) {
    if (study.single_file) {
      const block = [...document.querySelectorAll("script.trial-data")].find((element) => element.dataset.key === key);
      return block ? Promise.resolve(JSON.parse(block.textContent)) : Promise.reject(new Error(`this page holds no data of ${short(key, 80)}`));
    }
    return new Promise((resolve, reject) => {
      const script = make("script", { src: `report-data/${encodeURIComponent(key)}.js` });
      const finish = (end, result) => { awaited.delete(key); script.remove(); end(result); };
      awaited.set(key, (content) => finish(resolve, content));
      const missing = () => awaited.has(key) && finish(reject, new Error(`the data of ${short(key, 80)} could not be read: the folder report-data must lie beside this page`));
      script.addEventListener("error", missing);
      script.addEventListener("load", missing); // it ran and gave nothing
      document.head.append(script);
    });
  }

  /** A column: base64, deflate, bytes in planes, each value XORed with the one before. Little-endian, as every browser's machine is. */
  async function decodeColumn(text, n) {
    const packed = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const planes = new Uint8Array(await new Response(stream).arrayBuffer());
    if (planes.length !== 8 * n) throw new Error(`a column holds ${planes.length} bytes where ${n} samples take ${8 * n}`);
    const bytes = new Uint8Array(8 * n);
    for (let plane = 0; plane < 8; plane++) for (let i = 0; i < n; i++) bytes[8 * i + plane] = planes[plane * n + i];
    const words = new Uint32Array(bytes.buffer);
    for (let i = 2; i < words.length; i++) words[i] ^= words[i - 2];
    return new Float64Array(bytes.buffer);
  }

  async function decodeTable(table) {
    const names = Object.keys(table.columns);
    const columns = await Promise.all(names.map((name) => decodeColumn(table.columns[name], table.n)));
    return { ...table, columns: Object.fromEntries(names.map((name, i) => [name, columns[i]])) };
  }

  async function decodeGroup(group = {}) {
    return Object.fromEntries(await Promise.all(Object.entries(group).map(async ([name, table]) => [name, await decodeTable(table)])));
  }

  /** The decoded condition; what was used last stays in memory. */
  function condition(key) {
    const found = kept.get(key) ?? fetchCondition(key).then(async (content) => ({
      trials: await Promise.all((content.trials ?? []).map(decodeTable)), means: await decodeGroup(content.means), replay: await decodeGroup(content.replay),
    }));
    kept.delete(key);
    kept.set(key, found);
    if (kept.size > MOST_KEPT) kept.delete(kept.keys().next().value);
    found.catch(() => kept.delete(key));
    return found;
  }

  // ---- Pens: the same calls draw on a canvas and write an SVG ---------------------------------------------------------------

  const FONT = "system-ui, -apple-system, 'Segoe UI', 'Noto Sans', 'Liberation Sans', sans-serif";

  function canvasPen(context) {
    const trace = (points) => {
      context.beginPath();
      for (let i = 0, down = false; i < points.length; i += 2) {
        if (points[i] !== points[i]) down = false;
        else if (down) context.lineTo(points[i], points[i + 1]);
        else { context.moveTo(points[i], points[i + 1]); down = true; }
      }
    };
    return {
      line(points, { colour, width = 1, dash = [], opacity = 1 }) {
        Object.assign(context, { strokeStyle: colour, lineWidth: width, globalAlpha: opacity, lineJoin: "round" });
        context.setLineDash(dash);
        trace(points);
        context.stroke();
        context.globalAlpha = 1;
      },
      rect(x, y, width, height, { colour, opacity = 1 }) {
        Object.assign(context, { fillStyle: colour, globalAlpha: opacity });
        context.fillRect(x, y, width, height);
        context.globalAlpha = 1;
      },
      text(text, x, y, { colour, halo, size = 12, align = "start", bold = false }) {
        Object.assign(context, { font: `${bold ? 600 : 400} ${size}px ${FONT}`, textAlign: align, textBaseline: "middle", fillStyle: colour });
        if (halo) {
          Object.assign(context, { strokeStyle: halo, lineWidth: 4, lineJoin: "round" });
          context.setLineDash([]);
          context.strokeText(text, x, y);
        }
        context.fillText(text, x, y);
      },
      within({ x, y, width, height }, draw) {
        context.save();
        context.beginPath();
        context.rect(x, y, width, height);
        context.clip();
        draw();
        context.restore();
      },
    };
  }

  function svgPen(width, height, name) {
    const parts = [];
    const clips = [];
    const escape = (text) => (String(text).toWellFormed?.() ?? String(text)).replace(/[&<>"]/g, (character) => `&#${character.charCodeAt(0)};`).replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f]/g, "\ufffd");
    const n = (value) => String(Math.round(value * 100) / 100);
    return {
      line(points, { colour, width: stroke = 1, dash = [], opacity = 1 }) {
        let path = "";
        for (let i = 0, down = false; i < points.length; i += 2) {
          if (points[i] !== points[i]) { down = false; continue; }
          path += `${down ? "L" : "M"}${n(points[i])} ${n(points[i + 1])}`;
          down = true;
        }
        parts.push(`<path d="${path}" fill="none" stroke="${colour}" stroke-width="${stroke}" stroke-linejoin="round"${dash.length ? ` stroke-dasharray="${dash}"` : ""}${opacity < 1 ? ` opacity="${opacity}"` : ""}/>`);
      },
      rect(x, y, w, h, { colour, opacity = 1 }) {
        parts.push(`<rect x="${n(x)}" y="${n(y)}" width="${n(w)}" height="${n(h)}" fill="${colour}" opacity="${opacity}"/>`);
      },
      text(text, x, y, { colour, halo, size = 12, align = "start", bold = false }) {
        const anchor = { start: "start", center: "middle", end: "end" }[align];
        parts.push(`<text x="${n(x)}" y="${n(y + 0.35 * size)}" font-size="${size}" text-anchor="${anchor}" fill="${colour}"${bold ? ' font-weight="600"' : ""}${halo ? ` stroke="${halo}" stroke-width="4" stroke-linejoin="round" paint-order="stroke"` : ""}>${escape(text)}</text>`);
      },
      within(box, draw) {
        clips.push(`<clipPath id="${name}-clip${clips.length}"><rect x="${box.x}" y="${box.y}" width="${box.width}" height="${box.height}"/></clipPath>`);
        parts.push(`<g clip-path="url(#${name}-clip${clips.length - 1})">`);
        draw();
        parts.push("</g>");
      },
      finish: () => `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="${FONT}"><defs>${clips.join("")}</defs>${parts.join("")}</svg>\n`,
    };
  }

  const PAPER = 690; // width of a printed page, in CSS pixels
  let printing = false;
  const redraws = new Set(); // what is drawn anew for paper

  /** Colours from the style sheet; `light` for paper, whatever the screen shows. */
  function readTheme(light = false) {
    const probe = make("div", { class: light ? "light" : null, hidden: true });
    document.body.append(probe);
    const style = getComputedStyle(probe);
    const colour = (name) => style.getPropertyValue(name).trim();
    const theme = { ink: colour("--ink"), quiet: colour("--quiet"), grid: colour("--grid"), paper: colour("--paper"), mark: colour("--mark"), modes: study.modes.map((_, i) => colour(`--mode-${i % 6}`)) };
    probe.remove();
    return theme;
  }

  // ---- Scales -----------------------------------------------------------------------------------------------------------------

  /** Round numbers within [low, high], at most about `count`, and how many decimals they need. */
  function ticks(low, high, count) {
    const raw = (high - low) / Math.max(1, count);
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((factor) => factor * power >= raw * 0.999) * power;
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const values = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) values.push(i * step);
    return values.map((value) => ({ value, text: rounded(value, Math.min(digits, 12)) }));
  }

  /** A straight map from [low, high] to pixels [from, to]: pixel = k · value + c. */
  function scale([low, high], from, to) {
    const k = (to - from) / (high - low || 1);
    return { k, c: from - k * low, low, high };
  }

  /** [low, high] with a margin; something to draw on where all values are alike or none is there. */
  function padded(low, high, share = 0.05) {
    if (!(low <= high)) return [0, 1];
    const margin = (high - low) * share || Math.abs(low) * share || 0.5;
    return [low - margin, high + margin];
  }

  let fineness = 1; // columns of dots per CSS pixel: the screen's own, more for paper

  /** Points of y over a rising t, at most four per pixel column (first, least, largest, last), so that no peak is lost. */
  function thinOverTime(t, y, from, to, sx, sy) {
    const points = [];
    let column = NaN, x = 0, first = 0, last = 0, low = 0, high = 0, lowFirst = true, count = 0;
    const flush = () => {
      if (!count) return;
      points.push(x, first);
      if (count > 2) points.push(x, lowFirst ? low : high, x, lowFirst ? high : low);
      if (count > 1) points.push(x, last);
      count = 0;
    };
    for (let i = from; i < to; i++) {
      const py = sy.k * y[i] + sy.c, px = sx.k * t[i] + sx.c;
      if (py !== py || px !== px) { flush(); points.push(NaN, NaN); column = NaN; continue; }
      const at = Math.round(px * fineness);
      if (at !== column) { flush(); column = at; x = px; first = low = high = py; lowFirst = true; }
      if (py < low) { low = py; lowFirst = false; }
      if (py > high) { high = py; lowFirst = true; }
      last = py;
      count++;
    }
    flush();
    return points;
  }

  /** Points of a loop without those that lie within half a pixel of the one before. */
  function thinLoop(xs, ys, from, to, sx, sy) {
    const points = [];
    let lastX = NaN, lastY = NaN;
    for (let i = from; i < to; i++) {
      const px = sx.k * xs[i] + sx.c, py = sy.k * ys[i] + sy.c;
      if (px !== px || py !== py) { points.push(NaN, NaN); lastX = NaN; continue; }
      if (Math.abs(px - lastX) < 0.5 && Math.abs(py - lastY) < 0.5) continue;
      points.push(px, py);
      lastX = px;
      lastY = py;
    }
    return points;
  }

  /** First index whose value is not below `value`. */
  function lowerBound(sorted, value) {
    let low = 0, high = sorted.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (sorted[middle] < value) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  function nearestIndex(sorted, value) {
    const after = lowerBound(sorted, value);
    if (after === 0) return 0;
    if (after === sorted.length) return after - 1;
    return value - sorted[after - 1] <= sorted[after] - value ? after - 1 : after;
  }

  // ---- The trial browser's state --------------------------------------------------------------------------------------------

  const SHOW = { repeats: "repeats", mean: "mean", replay: "replay", command: "commanded force", states: "actuators", events: "events" };
  const ALIGN = { onset: "onset", landmarks: "landmarks (mean only)", none: "none" };
  const trialsBy = new Map(); // "participant/session/environment/mode" → its trials
  const pathOf = (...ids) => ids.join("/");
  for (const trial of study.trials) {
    const path = pathOf(trial.participant, trial.session, trial.environment, trial.mode);
    if (!trialsBy.has(path)) trialsBy.set(path, []);
    trialsBy.get(path).push(trial);
  }
  const sessionsOf = new Map();
  for (const { participant, session } of study.trials) sessionsOf.set(participant, (sessionsOf.get(participant) ?? new Set()).add(session));

  const view = { p: null, s: null, e: null, m: [], r: "all", a: "onset", show: new Set(["repeats", "mean", "states"]), zoom: null, wall: false, brush: [null, null] };

  const wallOf = (id) => environmentOf(id)?.wall_rad ?? null;
  const shownTrials = () => view.m.flatMap((mode) => trialsBy.get(pathOf(view.p, view.s, view.e, mode)) ?? []);

  /** Chooses something that is there wherever the wish is not. */
  function settle() {
    if (!sessionsOf.has(view.p)) view.p = study.trials[0].participant;
    if (!sessionsOf.get(view.p).has(view.s)) view.s = [...sessionsOf.get(view.p)][0];
    const mine = (environment) => study.modes.some((mode) => trialsBy.has(pathOf(view.p, view.s, environment, mode.id)));
    if (!mine(view.e)) view.e = study.environments.find((environment) => mine(environment.id))?.id ?? null;
    view.m = study.modes.map((mode) => mode.id).filter((mode) => view.m.includes(mode));
    if (!shownTrials().length) view.m = study.modes.map((mode) => mode.id).filter((mode) => trialsBy.has(pathOf(view.p, view.s, view.e, mode)));
    if (!shownTrials().some((trial) => trial.repeat === view.r)) view.r = "all";
    if (view.wall && wallOf(view.e) === null) view.wall = false;
  }

  function writeHash() {
    const query = new URLSearchParams({ p: view.p, s: view.s, e: view.e, m: view.m.join(","), r: view.r, a: view.a, show: [...view.show].join(",") });
    if (view.zoom) query.set("t", view.zoom.map(exact).join(","));
    if (view.wall) query.set("wall", "1");
    if (view.brush.every(Number.isFinite)) query.set("b", view.brush.map(exact).join(","));
    return `#trials?${query}`;
  }

  const span = (text) => {
    const numbers = (text ?? "").split(",").map(Number);
    return text && numbers.length === 2 && numbers.every(Number.isFinite) && numbers[0] < numbers[1] ? numbers : null;
  };

  /** Takes the view from an address; whether it named one. */
  function readHash() {
    if (!location.hash.startsWith("#trials?")) return false;
    const query = new URLSearchParams(location.hash.slice("#trials?".length));
    Object.assign(view, { p: query.get("p"), s: query.get("s"), e: query.get("e"), m: (query.get("m") ?? "").split(","), r: Number(query.get("r")) || "all", a: Object.hasOwn(ALIGN, query.get("a")) ? query.get("a") : "onset" });
    if (query.has("show")) view.show = new Set(query.get("show").split(",").filter((name) => Object.hasOwn(SHOW, name)));
    Object.assign(view, { zoom: span(query.get("t")), wall: query.get("wall") === "1", brush: span(query.get("b")) ?? [null, null] });
    settle();
    return true;
  }

  // ---- Curves: what is drawn ------------------------------------------------------------------------------------------------

  function shifted(times, shift) {
    const moved = new Float64Array(times.length);
    for (let i = 0; i < times.length; i++) moved[i] = times[i] - shift;
    return moved;
  }

  function curveOf(table, mode, key, kind, label, shift, { overTime = true, overAngle = true } = {}) {
    const c = table.columns;
    const times = shift ? shifted(c.t_s, shift) : c.t_s;
    const y = { t: times, theta: c.theta_rad, velocity: c.theta_dot_rad_s, force: c.force_ex_n ?? c.torque_ex_nm, command: c.force_cmd_n ?? c.torque_cmd_nm };
    return { y, stored: c, n: table.n, mode, key, kind, label, shift, overTime, overAngle, trial: table.trial ?? null, repeat: table.repeat ?? null, bits: c.state_bits, events: table.events ?? [] };
  }

  const onsetOf = (trial) => trial?.events?.find((event) => event.kind === "onset")?.t_s;

  /** The curves of one mode: its repeats, its mean as the alignment allows, its replay. */
  function curvesOfMode(mode, key, data) {
    const shift = (trial) => (view.a === "onset" ? onsetOf(trial) ?? 0 : 0);
    const name = short(labelOf(study.modes, mode));
    const one = view.r !== "all";
    const landmarks = view.a === "landmarks" && data.means.landmarks;
    const curves = [];
    if (view.show.has("repeats") || one)
      for (const trial of data.trials.filter((item) => !one || item.repeat === view.r))
        curves.push(curveOf(trial, mode, key, "trial", `${name}, repeat ${trial.repeat} (trial ${trial.trial})`, shift(trial), { overTime: !landmarks }));
    if (view.show.has("mean") && view.a !== "none") {
      // Over time the mean counts from the onset. Over the angle such a mean follows no repeat, so there it goes by landmarks.
      const { onset, landmarks: marked } = data.means;
      if (landmarks) curves.push(curveOf(marked, mode, key, "mean", `${name}, mean by landmarks`, 0));
      else {
        if (onset) curves.push(curveOf(onset, mode, key, "mean", `${name}, mean from onset`, 0, { overAngle: !marked }));
        if (marked) curves.push(curveOf(marked, mode, key, "mean", `${name}, mean by landmarks`, 0, { overTime: !onset }));
      }
    }
    if (view.show.has("replay"))
      for (const [kind, table] of Object.entries(data.replay)) {
        const trial = data.trials.find((item) => item.trial === table.trial);
        curves.push(curveOf(table, mode, key, "replay", `${name}, replay ${kind.replace("_", " ")} (trial ${table.trial})`, shift(trial), { overTime: !landmarks }));
      }
    return curves;
  }

  /** How a curve is drawn: alone or as a mean it is strong and has its mode's dashes, among repeats it is thin. */
  function styleOf(curve, curves, theme) {
    const colour = theme.modes[modeIndex(curve.mode)];
    const dash = DASHES[modeIndex(curve.mode) % DASHES.length];
    if (curve.kind === "replay") return { colour: theme.ink, width: 1.5, dash: curve.label.includes("fitted") ? [2, 2] : [7, 3, 1, 3], opacity: 0.85 };
    if (curve.kind === "mean") return { colour, width: 2.5, dash };
    const alone = curves.filter((other) => other.mode === curve.mode && other.kind === "trial").length === 1;
    return alone ? { colour, width: view.show.has("mean") ? 1.25 : 2, dash } : { colour, width: 1, opacity: curves.some((other) => other.kind === "mean") ? 0.45 : 0.8 };
  }

  // ---- Panels ---------------------------------------------------------------------------------------------------------------

  const SYMBOL = LINEAR ? "x" : "θ";
  const PANELS = [
    { id: "theta", x: "t", y: "theta", name: LINEAR ? "Position" : "Angle", title: `${SYMBOL} (${study.angle_unit})`, height: 205 },
    { id: "velocity", x: "t", y: "velocity", name: "Velocity", title: `${SYMBOL}\u0307 (${study.angle_unit}/s)`, height: 180 },
    { id: "force", x: "t", y: "force", name: FORCE === "N" ? "Force" : "Torque", title: `${FORCE === "N" ? "F" : "τ"} of the user (${FORCE})`, height: 205 },
    { id: "states", x: "t", y: null, name: "Actuators", title: "motor and brake on; darker: in more of the repeats", height: 0 },
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
        const curves = browser.curves.filter((curve) => curve.mode === mode && curve.kind === "trial" && curve.overTime && curve.bits);
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
    const bottom = panel.id === "force" && view.show.has("states") && !exported ? 22 : MARGIN.bottom;
    const box = { x: MARGIN.left, y: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - (["theta", "velocity"].includes(panel.id) && !exported ? 22 : bottom) };
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

  function drawEvents(pen, panel, curve, sx, sy, theme) {
    if (panel.y === "velocity" || curve.kind !== "trial") return;
    for (const { kind, t_s: time } of curve.events) {
      const i = nearestIndex(curve.stored.t_s, time);
      if (Object.hasOwn(EVENTS, kind)) pen.text(EVENTS[kind][0], sx.k * curve.y[panel.x][i] + sx.c, sy.k * curve.y[panel.y][i] + sy.c, { colour: theme.ink, halo: theme.paper, size: 13, align: "center" });
    }
  }

  /** Names on the curves themselves: for each mode the place farthest from all curves and other names, if there is room. */
  function drawLabels(pen, panel, box, sx, sy, theme, taken) {
    const drawn = drawnIn(panel);
    const chosen = study.modes.flatMap(({ id }) => {
      const mine = drawn.filter((curve) => curve.mode === id);
      const strongest = mine.find((curve) => curve.kind === "mean") ?? mine.find((curve) => curve.kind === "trial");
      return [...(strongest ? [{ curve: strongest, text: short(labelOf(study.modes, id), 16) }] : []), ...mine.filter((curve) => curve.kind === "replay").map((curve) => ({ curve, text: `replay, ${curve.label.includes("fitted") ? "fitted" : "by eye"}` }))];
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

  function drawStates(pen, panel, box, sx, theme, range) {
    const rows = browser.rows;
    const foot = MARGIN.top + 16 * rows.length;
    pen.text(panel.title, 6, 12, { colour: theme.quiet });
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

  // ---- The browser on the page ----------------------------------------------------------------------------------------------

  const parts = {}; // the browser's elements
  const screen = { theme: null, range: null, plots: new Map() };

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
    const line = makeSvg("line", { x1: 1, y1: 5, x2: 27, y2: 5, "stroke-width": 3, style: `stroke: var(--mode-${index % 6})`, "stroke-dasharray": DASHES[index % DASHES.length].join(" ") || "none" });
    return makeSvg("svg", { width: 28, height: 10, "aria-hidden": "true", class: "swatch" }, line);
  }

  const change = (patch) => { Object.assign(view, patch); settle(); writeControls(); return refresh(); };

  function buildBrowser(host) {
    const [participant, pickParticipant] = field("Participant", "pick-participant", (p) => change({ p }));
    const [session, pickSession] = field("Session", "pick-session", (s) => change({ s }));
    const [environment, pickEnvironment] = field("Environment", "pick-environment", (e) => change({ e, zoom: null, brush: [null, null] }));
    const [repeat, pickRepeat] = field("Repeats", "pick-repeat", (r) => change({ r: Number(r) || "all" }));
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
    Object.assign(parts, { pickParticipant, pickSession, pickEnvironment, pickRepeat, pickAlign, modes, show, surface, session,
      status: make("p", { class: "status", role: "status" }), note: make("p", { class: "caption" }), readout: make("dl", { class: "readout", id: "readout" }), live: make("p", { class: "unseen", "aria-live": "polite", id: "live" }), table: buildTable() });
    host.replaceChildren(make("div", { class: "controls", role: "group", "aria-label": "Trials to show" }, participant, session, environment, repeat, align, modes, show), tools, parts.status, surface, parts.readout, parts.live, parts.note, keys, parts.table, buildExports());
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
    parts.pickParticipant.replaceChildren(...[...sessionsOf.keys()].map((id) => option(id, id, id === view.p)));
    parts.pickSession.replaceChildren(...[...sessionsOf.get(view.p)].map((id) => option(id, id, id === view.s)));
    parts.session.hidden = sessionsOf.get(view.p).size < 2;
    const there = study.environments.filter(({ id }) => study.modes.some((mode) => trialsBy.has(pathOf(view.p, view.s, id, mode.id))));
    parts.pickEnvironment.replaceChildren(...there.map(({ id, label }) => option(id, label, id === view.e)));
    const repeats = distinct(shownTrials().map((trial) => trial.repeat)).sort((a, b) => a - b);
    parts.pickRepeat.replaceChildren(option("all", "all", view.r === "all"), ...repeats.map((r) => option(r, `only ${r}`, view.r === r)));
    parts.pickAlign.replaceChildren(...Object.entries(ALIGN).map(([id, label]) => option(id, label, id === view.a)));
    keepFocus(parts.modes, study.modes.map((mode, i) => {
      const there = trialsBy.has(pathOf(view.p, view.s, view.e, mode.id));
      return tickBox([swatch(i), short(mode.label, 40)], view.m.includes(mode.id), (on) => change({ m: on ? [...view.m, mode.id] : view.m.filter((id) => id !== mode.id) }), { value: mode.id, disabled: !there });
    }));
    keepFocus(parts.show, Object.entries(SHOW).map(([id, label]) => tickBox(label, view.show.has(id), (on) => { view.show[on ? "add" : "delete"](id); change({}); }, { value: id })));
    byId("zoom-wall").hidden = wallOf(view.e) === null;
    byId("zoom-wall").setAttribute("aria-pressed", String(view.wall));
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
    const wanted = view.m.map((mode) => ({ mode, key: trialsBy.get(pathOf(view.p, view.s, view.e, mode))?.[0]?.data })).filter(({ key }) => key);
    const waiting = setTimeout(() => mine === refreshes && say("Loading …"), 200);
    const found = await Promise.allSettled(wanted.map(({ key }) => condition(key)));
    clearTimeout(waiting);
    if (mine !== refreshes) return;
    const lost = found.filter((one) => one.status === "rejected").map((one) => one.reason.message);
    say(distinct(lost).join(". "), lost.length > 0);
    const active = browser.curves[browser.active];
    browser.of = { p: view.p, s: view.s, e: view.e, m: [...view.m], r: view.r };
    browser.curves = found.flatMap((one, i) => (one.status === "fulfilled" ? curvesOfMode(wanted[i].mode, wanted[i].key, one.value) : []));
    browser.active = Math.max(0, browser.curves.findIndex((curve) => active && curve.label === active.label));
    if (!browser.curves[browser.active]?.overTime) browser.active = Math.max(0, browser.curves.findIndex((curve) => curve.overTime));
    browser.index = browser.curves.length && browser.index !== null ? Math.min(browser.index, browser.curves[browser.active].n - 1) : null;
    browser.rows = findStateRows();
    keepHash();
    writeNote();
    drawAll();
    writeReadout();
    closeTable();
  }

  const say = (text, bad = false) => { parts.status.textContent = text; parts.status.classList.toggle("bad", bad); };
  let touched = false; // the address stays as it was until somebody chooses something
  const keepHash = () => touched && history.replaceState(null, "", writeHash());

  function writeNote() {
    const notes = [];
    if (view.show.has("mean") && view.a === "onset" && browser.curves.some((curve) => curve.kind === "mean" && !curve.overTime)) notes.push("Thick: mean of the repeats, over time from their onsets, over the angle by landmarks (start, contact, reversal and end meet).");
    else if (browser.curves.some((curve) => curve.kind === "mean")) notes.push(`Thick: mean of the repeats, ${view.a === "landmarks" ? "by landmarks" : "from their onsets"}.`);
    if (view.a === "none" && view.show.has("mean")) notes.push("A mean needs a time from onset or by landmarks.");
    if (view.show.has("command")) notes.push("Fine dots: commanded force, cut off where it goes far beyond the measured one.");
    if (view.show.has("replay")) notes.push(browser.curves.some((curve) => curve.kind === "replay") ? "Replay: the model, given the recorded force." : "No replay of these trials is stored.");
    if (view.show.has("events")) notes.push(`${Object.values(EVENTS).map(([sign, name]) => `${sign} ${name}`).join("  ")}.`);
    parts.note.textContent = notes.join(" ");
  }

  // ---- Drawing on the screen ------------------------------------------------------------------------------------------------

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
    const states = view.show.has("states") ? browser.rows.length : 0;
    screen.plots.get("states").plot.hidden = states === 0;
    const stacked = matchMedia("(max-width: 720px)").matches;
    const tall = PANELS.slice(0, 3).reduce((sum, panel) => sum + panel.height, 0) + (states ? MARGIN.top + 16 * states + 34 : 0);
    for (const one of screen.plots.values()) {
      one.width = one.plot.clientWidth;
      one.height = one.panel.id === "states" ? MARGIN.top + 16 * states + 34 : one.panel.id === "loop" ? (stacked ? Math.min(420, Math.max(280, one.width)) : tall) : one.panel.height;
      if (one.panel.id === "force" && !states) one.height += 16;
      if (!one.width || one.plot.hidden) continue;
      const context = sizeCanvas(one.base, one.width, one.height);
      one.scales = drawPanel(canvasPen(context), one.panel, one.width, one.height, screen.theme, screen.range, false);
    }
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

  // ---- Cursor, brush, zoom --------------------------------------------------------------------------------------------------

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
    Object.assign(parts.readout.dataset, { kind: active.kind, participant: browser.of.p, session: browser.of.s, key: active.key, trial: active.trial ?? "", index: i });
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

  // ---- Table and downloads --------------------------------------------------------------------------------------------------

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

  const fileName = (name) => [study.study, browser.of.p, browser.of.s, browser.of.e, browser.of.m.join("-"), name].join(".").replace(/[^A-Za-z0-9_.-]/g, "_").slice(0, 150);
  const quoted = (value) => (/[",\r\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : String(value));

  /** Every shown curve, every sample, as stored; `origin` marks simulated data in each row. */
  function csv() {
    const columns = distinct(browser.curves.flatMap((curve) => Object.keys(curve.stored)));
    const lines = [["participant", "session", "environment", "mode", "curve", "trial", "repeat", "origin", ...columns].join(",")];
    for (const curve of browser.curves) {
      const head = [browser.of.p, browser.of.s, browser.of.e, curve.mode, curve.kind === "trial" ? "trial" : curve.label, curve.trial ?? "", curve.repeat ?? "", study.simulated ? "simulated" : "recorded"].map(quoted).join(",");
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
    pen.text(short(`${study.study}, ${labelOf(study.environments, browser.of.e)}, ${browser.of.p} ${browser.of.s}${browser.of.r === "all" ? "" : `, repeat ${browser.of.r}`}`, 70), 8, height - 24, { colour: theme.quiet, size: 11 });
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
    const rows = PANELS.map(({ id, name }) => make("li", {}, make("span", {}, name), save(id, "png", name), save(id, "svg", name)));
    const data = make("li", {}, make("span", {}, "Every sample shown"), make("button", { type: "button", "data-export": "csv", "aria-label": "Every sample shown as csv", onclick: () => download(`${fileName("samples")}.csv`, "text/csv", csv()) }, "csv"));
    return make("details", { id: "saves" }, make("summary", {}, "Save plots and samples"), make("ul", { class: "saves" }, ...rows, data));
  }

  /** Opens trials in the browser from elsewhere on the page, and takes the focus there. */
  function openTrials(patch) {
    if (!parts.surface) return;
    touched = true;
    Object.assign(view, { zoom: null, wall: false, brush: [null, null], r: "all" }, patch);
    browser.index = null;
    settle();
    writeControls();
    const done = refresh();
    byId("trials").scrollIntoView({ behavior: calm.matches ? "auto" : "smooth", block: "start" });
    parts.surface.focus({ preventScroll: true });
    return done;
  }

  /** The first participant who has such trials, the one shown now if possible. */
  function whoHas(environment, mode) {
    const has = (p, s) => trialsBy.has(pathOf(p, s, environment, mode));
    if (has(view.p, view.s)) return {};
    const trial = study.trials.find((one) => one.environment === environment && one.mode === mode);
    return trial ? { p: trial.participant, s: trial.session } : {};
  }

  function linkMatrix() {
    for (const link of document.querySelectorAll("a[data-environment][data-mode]")) {
      const { environment, mode } = link.dataset;
      link.addEventListener("click", (event) => {
        event.preventDefault();
        openTrials({ e: environment, m: [mode], ...whoHas(environment, mode) });
      });
    }
  }

  // ---- Dots: a small SVG chart of categories, and one of two numbers -----------------------------------------------------------

  const SHAPES = [
    (r) => `M${-r} 0A${r} ${r} 0 1 0 ${r} 0A${r} ${r} 0 1 0 ${-r} 0Z`, (r) => `M${-r} ${-r}H${r}V${r}H${-r}Z`, (r) => `M0 ${-1.2 * r}L${1.2 * r} ${r}H${-1.2 * r}Z`,
    (r) => `M0 ${-1.3 * r}L${1.3 * r} 0L0 ${1.3 * r}L${-1.3 * r} 0Z`, (r) => `M0 ${1.2 * r}L${1.2 * r} ${-r}H${-1.2 * r}Z`, (r) => `M${-r} ${-r / 3}H${-r / 3}V${-r}H${r / 3}V${-r / 3}H${r}V${r / 3}H${r / 3}V${r}H${-r / 3}V${r / 3}H${-r}Z`,
  ];
  const MANY = 60; // participants from which dots are participants, not trials

  const svgText = (text, x, y, extra = {}) => makeSvg("text", { x, y, ...extra }, text);
  /** The same place for the same dot on every visit: steps of the golden ratio spread any number of dots evenly. */
  const spread = (i) => ((i * 0.6180339887498949 + 0.5) % 1) - 0.5;

  /** A point that says what it is and opens its trials; `tell` shows the words to those who see. */
  function point(x, y, { words, open, mode }, radius, tell) {
    const act = (event) => { event.preventDefault(); open(); };
    return makeSvg("path", { d: SHAPES[mode % SHAPES.length](radius), transform: `translate(${x.toFixed(2)} ${y.toFixed(2)})`, class: "point", style: `--own: var(--mode-${mode % 6})`, role: "button", tabindex: "-1", "aria-label": words, onclick: act, onkeydown: (event) => (event.key === "Enter" || event.key === " ") && act(event), onfocus: () => tell(words), onpointerenter: () => tell(words) });
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
  function groupChart({ title, width, groups, lines, yRange, zero, tell }) {
    const { svg, box, sy } = chartFrame(title, width, 300, 56, yRange);
    const step = (box.right - box.left) / groups.length;
    const centre = (g) => box.left + step * (g + 0.5);
    const place = (g, i) => centre(g) - Math.min(0.12 * step, 20) + spread(i) * Math.min(0.45 * step, 72);
    if (zero) svg.append(makeSvg("line", { x1: box.left, x2: box.right, y1: sy.c, y2: sy.c, class: "zero" }));
    const path = lines.map((line) => line.filter(({ y }) => Number.isFinite(y)).map(({ g, i, y }, k) => `${k ? "L" : "M"}${place(g, i).toFixed(1)} ${(sy.k * y + sy.c).toFixed(1)}`).join("")).join("");
    if (path) svg.append(makeSvg("path", { d: path, class: "pairs", opacity: Math.min(0.5, Math.max(0.03, 12 / lines.length)) }));
    groups.forEach((group, g) => {
      const crowd = group.points.length > 200;
      group.points.forEach((one, i) => svg.append(point(place(g, i), sy.k * one.value + sy.c, { ...one, mode: group.mode }, crowd ? 2 : 4.5, tell)));
      svg.append(svgText(short(group.label, Math.max(6, Math.floor(step / 7))), centre(g), box.bottom + 20, { "text-anchor": "middle", class: "group" }));
      const { mean: middle, low, high } = group.summary;
      if (!Number.isFinite(middle)) return;
      const x = centre(g) + Math.min(0.2 * step, 36), y = sy.k * middle + sy.c;
      if (Number.isFinite(low) && Number.isFinite(high)) svg.append(makeSvg("line", { x1: x, x2: x, y1: sy.k * low + sy.c, y2: sy.k * high + sy.c, class: "whisker" }));
      svg.append(makeSvg("circle", { cx: x, cy: y, r: 4, class: "mean" }), svgText(significant(middle), x + 9, y + 4, { class: "value" }));
    });
    return svg;
  }

  /** Mean or difference with its interval as the tables have it, else of the drawn dots with their SD; and which it is. */
  function summaryOf(metric, estimates, environment, of, values) {
    const given = estimates.find((one) => one.environment === environment && one.of === of);
    if (given) {
      const [middle, low, high] = [given.value, given.low, given.high].map((value) => (value ?? NaN) * metric.scale);
      return { mean: middle, low, high, given: true };
    }
    const middle = values.length ? mean(values) : NaN, sd = deviation(values);
    return { mean: middle, low: middle - sd, high: middle + sd, given: false };
  }

  const metricTitle = ({ label, unit }) => `${short(label, 90)}${unit ? ` (${unit})` : ""}`;
  const measured = (trial, index) => (trial.metrics[index] === null || trial.metrics[index] === undefined ? NaN : trial.metrics[index] * study.metrics[index].scale);
  const trialWords = (trial) => `${trial.participant} ${trial.session}, trial ${trial.trial}, ${short(labelOf(study.modes, trial.mode))}, repeat ${trial.repeat}`;
  const openTrial = (trial) => openTrials({ p: trial.participant, s: trial.session, e: trial.environment, m: [trial.mode], r: trial.repeat });

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
        ? [...groupBy(trials, (trial) => trial.participant)].map(([p, mine]) => ({ value: mean(mine.map((trial) => measured(trial, index))), of: p, words: `${p}, ${short(mode.label)}, mean of ${mine.length} trials`, open: () => openTrials({ p, s: mine[0].session, e: environment.id, m: [mode.id] }) }))
        : trials.map((trial) => ({ value: measured(trial, index), of: trial.participant, words: trialWords(trial), open: () => openTrial(trial) }));
      for (const one of points) one.words += `: ${significant(one.value)} ${metric.unit}`;
      return { label: mode.label, mode: m, points, summary: summaryOf(metric, metric.means, environment.id, mode.id, points.map((one) => one.value)) };
    }).filter((group) => group.points.length);
  }

  /** Differences of every two modes by participant; with one participant by repeat. */
  function differenceGroups(environment, index, single) {
    const metric = study.metrics[index];
    const mine = study.trials.filter((trial) => trial.environment === environment.id && Number.isFinite(measured(trial, index)));
    const units = groupBy(mine, (trial) => (single ? `${trial.session}, repeat ${trial.repeat}` : trial.participant));
    const pairs = study.modes.flatMap((from, i) => study.modes.slice(i + 1).map((to) => [from, to]));
    // A contrast is drawn the way round in which the tables have it.
    const asked = ([from, to]) => (metric.differences.some((one) => one.of === `${from.id} − ${to.id}`) ? [to, from] : [from, to]);
    return pairs.map(asked).map(([from, to]) => {
      const points = [...units].flatMap(([unit, trials]) => {
        const of = ({ id }) => trials.filter((trial) => trial.mode === id).map((trial) => measured(trial, index));
        if (!of(from).length || !of(to).length) return [];
        const value = mean(of(to)) - mean(of(from));
        const [{ participant: p, session: s, repeat }] = trials;
        return [{ value, words: `${unit}, ${short(to.label)} minus ${short(from.label)}: ${significant(value)} ${metric.unit}`, open: () => openTrials({ p, s, e: environment.id, m: [from.id, to.id], r: single ? repeat : "all" }) }];
      });
      const summary = summaryOf(metric, metric.differences, environment.id, `${to.id} − ${from.id}`, points.map((one) => one.value));
      return { label: `${short(to.label, 12)} − ${short(from.label, 12)}`, mode: study.modes.indexOf(to), points, summary };
    }).filter((group) => group.points.length);
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
    const charts = make("div", { class: "charts" }), tip = make("p", { class: "tip" }), note = make("p", { class: "caption" });
    const tell = (words) => { tip.textContent = words; };
    host.replaceChildren(make("div", { class: "controls" }, pick), charts, tip, note);
    function draw() {
      const index = Number(select.value), metric = study.metrics[index], many = participants > MANY, single = participants === 1;
      const facets = study.environments.map((environment) => ({ environment, groups: dotGroups(environment, index, many), differences: differenceGroups(environment, index, single) })).filter(({ groups }) => groups.length);
      const range = rangeOfGroups(facets.flatMap(({ groups }) => groups)), apart = rangeOfGroups(facets.flatMap(({ differences }) => differences), true);
      const room = printing ? PAPER : charts.clientWidth, columns = room >= 640 ? 2 : 1, width = Math.max(260, room / columns - (columns - 1) * 12);
      charts.replaceChildren(...facets.flatMap(({ environment, groups, differences }) => [
        groupChart({ title: `${short(environment.label, 30)}${metric.unit ? ` (${metric.unit})` : ""}`, width, groups, lines: single ? [] : linesOf(groups), yRange: range, tell }),
        differences.length ? groupChart({ title: `${short(environment.label, 24)}: differences${metric.unit ? ` (${metric.unit})` : ""}`, width, groups: differences, lines: [], yRange: apart, zero: true, tell }) : make("div"),
      ]));
      charts.querySelectorAll("svg").forEach(rove);
      const all = facets.flatMap(({ groups, differences }) => [...groups, ...differences]);
      const bars = all.every(({ summary }) => summary.given) ? "Bars: mean and interval as in the tables." : all.some(({ summary }) => summary.given) ? "Bars: mean and interval as in the tables, else mean ± SD of the dots drawn." : "Bars: mean ± SD of the dots drawn.";
      tip.textContent = "Point at a dot for its trial; Enter or a click opens it.";
      note.textContent = [`${many ? "Dots: means of participants." : "Dots: trials."}`, bars, single ? `Dots of differences: by repeat, within ${[...sessionsOf.keys()][0]}; nothing is said of anybody else.` : "Dots of differences: by participant, from each one's means."].join(" ");
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

  // ---- Answers beside a metric --------------------------------------------------------------------------------------------------

  const answered = (trial, question) => trial.answers?.[question] ?? NaN;

  function buildAnswers(host) {
    const asked = study.questions.map((_, q) => q).filter((q) => study.trials.some((trial) => Number.isFinite(answered(trial, q))));
    const usable = study.metrics.map((_, i) => i).filter((i) => study.trials.some((trial) => Number.isFinite(measured(trial, i))));
    if (!asked.length || !usable.length) return;
    const people = [...sessionsOf.keys()];
    const [who, pickWho] = field("Participant", "answers-participant", draw), [what, pickWhat] = field("Question", "answers-question", draw), [which, pickMetric] = field("Metric", "answers-metric", draw);
    pickWho.replaceChildren(...(people.length > 1 ? [option("", "all", people.length <= MANY)] : []), ...people.map((id, i) => option(id, id, people.length > MANY && i === 0)));
    pickWhat.replaceChildren(...asked.map((q) => option(q, study.questions[q].label, false)));
    pickMetric.replaceChildren(...usable.map((i) => option(i, metricTitle(study.metrics[i]), false)));
    const legend = make("ul", { class: "legend" }, ...study.modes.map((mode, m) => make("li", {}, makeSvg("svg", { width: 16, height: 16, viewBox: "-8 -8 16 16", "aria-hidden": "true" }, makeSvg("path", { d: SHAPES[m % SHAPES.length](5), style: `--own: var(--mode-${m % 6})` })), short(mode.label, 40))));
    const question = make("p", { class: "question" }), charts = make("div", { class: "charts one" }), tip = make("p", { class: "tip" });
    const tell = (words) => { tip.textContent = words; };
    host.replaceChildren(make("div", { class: "controls" }, who, what, which), question, legend, charts, tip);
    function draw() {
      const q = Number(pickWhat.value), index = Number(pickMetric.value), asks = study.questions[q], metric = study.metrics[index];
      const trials = study.trials.filter((trial) => (!pickWho.value || trial.participant === pickWho.value) && Number.isFinite(answered(trial, q)) && Number.isFinite(measured(trial, index)));
      question.textContent = `“${short(asks.label, 400)}”${asks.reversed ? " (agreement speaks against)" : ""}`;
      tip.textContent = trials.length ? "Point at a mark for its trial; Enter or a click opens it." : "No trial has both an answer to this question and this metric.";
      charts.replaceChildren(answerChart(trials, q, index, asks, metric, printing ? PAPER : Math.max(280, charts.clientWidth), tell));
      rove(charts.firstChild);
    }
    draw();
    onWidth(charts, draw);
  }

  function answerChart(trials, q, index, asks, metric, width, tell) {
    const step = asks.step ?? 1, points = (asks.highest - asks.lowest) / step + 1;
    const every = step * Math.ceil((points - 1) / 10); // of a long scale at most eleven answers are named
    const levels = Array.from({ length: Math.floor((asks.highest - asks.lowest) / every) + 1 }, (_, i) => ({ value: asks.lowest + i * every, text: `${short(asks.labels?.[i] ?? "", width < 480 ? 12 : 24)} ${asks.lowest + i * every}`.trim() }));
    const left = 16 + 6.4 * Math.max(...levels.map(({ text }) => text.length));
    const { svg, box, sy } = chartFrame("Answer", width, 60 + 46 * levels.length + 30, left, [asks.lowest - 0.5 * every, asks.highest + 0.5 * every], levels);
    const values = trials.map((trial) => measured(trial, index));
    const range = padded(values.reduce((a, b) => Math.min(a, b), Infinity), values.reduce((a, b) => Math.max(a, b), -Infinity));
    const sx = scale(range, box.left, box.right);
    for (const { value, text } of ticks(...range, (box.right - box.left) / 70)) svg.append(makeSvg("line", { x1: sx.k * value + sx.c, x2: sx.k * value + sx.c, y1: box.top, y2: box.bottom, class: "grid" }), svgText(text, sx.k * value + sx.c, box.bottom + 16, { "text-anchor": "middle" }));
    svg.append(svgText(short(metricTitle(metric), Math.floor(width / 7)), box.right, box.bottom + 34, { "text-anchor": "end", class: "group" }));
    const seen = new Map(); // dots of one answer are spread over its band, the same way every time
    trials.forEach((trial, i) => {
      const answer = answered(trial, q), place = seen.get(answer) ?? 0;
      seen.set(answer, place + 1);
      svg.append(point(sx.k * values[i] + sx.c, sy.k * (answer + 0.6 * step * spread(place)) + sy.c, { mode: modeIndex(trial.mode), words: `${trialWords(trial)}: answered ${answer}${asks.labels?.[(answer - asks.lowest) / step] ? ` (${short(asks.labels[(answer - asks.lowest) / step])})` : ""}, ${significant(values[i])} ${metric.unit}`, open: () => openTrial(trial) }, trials.length > 400 ? 2.5 : 5, tell));
    });
    return svg;
  }

  // ---- The model, turned by hand --------------------------------------------------------------------------------------------------

  const TURNS = [["Mass", "kg", 1], ["Damping", study.turned?.damping_unit, study.turned?.damping_scale], ["Friction", "N", 1]];

  async function decodeTurned(turned) {
    const counts = turned.values.map((values) => values.length);
    const combinations = counts.reduce((product, count) => product * count, 1);
    const [t, recorded, errors, angles] = await Promise.all([decodeColumn(turned.t_s, turned.times), decodeColumn(turned.recorded_rad, turned.times), decodeColumn(turned.rmse_rad, combinations), decodeColumn(turned.theta_rad, combinations * turned.times)]);
    return { ...turned, counts, t, recorded, errors, angles };
  }

  /** Which run has these places on the sliders. */
  const runOf = ({ counts }, [mass, damping, friction]) => (mass * counts[1] + damping) * counts[2] + friction;
  /** The places of values on the sliders; the nearest where a value is not among them. */
  const placesOf = ({ values }, wanted) => values.map((list, k) => list.reduce((best, value, i) => (Math.abs(value - wanted[k]) < Math.abs(list[best] - wanted[k]) ? i : best), 0));

  async function buildModel(host) {
    host.replaceChildren(make("p", { class: "status", role: "status" }, "Loading the model’s runs…"));
    let all;
    try {
      all = await Promise.all((await fetchCondition(study.turned.data)).turned.map(decodeTurned));
    } catch (error) {
      host.replaceChildren(make("p", { class: "status", role: "alert" }, error.message));
      return;
    }
    if (!all.length) { host.replaceChildren(make("p", {}, "No trial could be replayed: the table “replay” says why.")); return; }
    const [which, pick] = field("Condition", "model-condition", choose);
    pick.replaceChildren(...all.map((one, i) => option(i, `${labelOf(study.environments, one.environment)}, ${labelOf(study.modes, one.mode)}`, i === 0)));
    const sliders = TURNS.map(([name, unit, times], k) => {
      const said = make("output", { for: `model-${k}` });
      const input = make("input", { type: "range", id: `model-${k}`, min: 0, step: 1, oninput: () => { at[k] = Number(input.value); draw(); } });
      return { unit, times, said, input, row: make("label", { class: "slider", for: `model-${k}` }, make("span", {}, name), input, said) };
    });
    const set = (id, label, wanted) => make("button", { type: "button", id, onclick: () => { at = placesOf(chosen, wanted()); draw(); } }, label);
    const buttons = make("div", { class: "tools", role: "group", "aria-label": "Known parameters" }, set("model-by-eye", "By eye", () => chosen.by_eye), all[0].fitted ? set("model-fitted", "Fitted", () => chosen.fitted) : null);
    const verdict = make("p", { class: "status", role: "status", id: "model-error" }), charts = make("div", { class: "charts one" });
    let chosen = all[0], at = [0, 0, 0];
    host.replaceChildren(make("div", { class: "controls" }, which), make("div", { class: "sliders" }, ...sliders.map(({ row }) => row)), buttons, verdict, charts,
      make("p", { class: "caption" }, `Trials of ${short(study.turned.participant)} ${short(study.turned.session)}; lags as fitted. Each stop of a slider is a run that zwidth made; nothing in between is guessed.`));
    host.dataset.ready = "true";
    function choose() {
      chosen = all[Number(pick.value)];
      at = placesOf(chosen, chosen.by_eye);
      draw();
    }
    function draw() {
      const run = runOf(chosen, at), error = (places) => chosen.errors[runOf(chosen, places)] * ANGLE_SCALE;
      const told = (value) => (Number.isFinite(value) ? `${significant(value)}${LINEAR ? " " : ""}${study.angle_unit}` : "none: the model does not run");
      sliders.forEach(({ unit, times, said, input }, k) => {
        const text = `${significant(times * chosen.values[k][at[k]])} ${unit}`;
        Object.assign(input, { max: chosen.values[k].length - 1, value: at[k] });
        input.setAttribute("aria-valuetext", text);
        said.textContent = text;
      });
      const known = [["by eye", chosen.by_eye], ["fitted", chosen.fitted]].filter(([, values]) => values).map(([name, values]) => `${name} ${told(error(placesOf(chosen, values)))}`);
      verdict.textContent = `RMS error of the angle: ${told(error(at))} (${known.join(", ")}).`;
      charts.replaceChildren(modelChart(chosen, run, printing ? PAPER : Math.max(280, charts.clientWidth)));
    }
    choose();
    onWidth(charts, draw);
  }

  function modelChart(turned, run, width) {
    const shown = (values) => Array.from(values, (value) => value * ANGLE_SCALE);
    const model = shown(turned.angles.subarray(run * turned.times, (run + 1) * turned.times)), recorded = shown(turned.recorded);
    // The axis is that of the recording with room for a model that goes astray, so that turning does not move it.
    const low = Math.min(...recorded), high = Math.max(...recorded), room = 0.5 * (high - low || 1);
    const range = [low - room, high + room];
    const { svg, box, sy } = chartFrame(`Angle (${study.angle_unit})`, width, 300, 56, range);
    const times = [turned.t[0], turned.t[turned.times - 1]], sx = scale(times, box.left, box.right);
    for (const { value, text } of ticks(...times, (box.right - box.left) / 70)) svg.append(svgText(text, sx.k * value + sx.c, box.bottom + 16, { "text-anchor": "middle" }));
    svg.append(svgText("time (s)", box.right, box.bottom + 34, { "text-anchor": "end", class: "group" }));
    const clip = (value) => Math.min(range[1], Math.max(range[0], value));
    const path = (values) => values.map((value, i) => (Number.isFinite(value) ? `${i && Number.isFinite(values[i - 1]) ? "L" : "M"}${(sx.k * turned.t[i] + sx.c).toFixed(1)} ${(sy.k * clip(value) + sy.c).toFixed(1)}` : "")).join("");
    svg.append(makeSvg("path", { d: path(recorded), class: "recorded" }), makeSvg("path", { d: path(model), class: "model", style: `--own: var(--mode-${modeIndex(turned.mode) % 6})` }));
    svg.append(makeSvg("line", { x1: box.right - 190, x2: box.right - 160, y1: 12, y2: 12, class: "recorded" }), svgText("recorded", box.right - 154, 16), makeSvg("line", { x1: box.right - 90, x2: box.right - 60, y1: 12, y2: 12, class: "model", style: `--own: var(--mode-${modeIndex(turned.mode) % 6})` }), svgText("model", box.right - 54, 16));
    return svg;
  }

  // ---- The page -------------------------------------------------------------------------------------------------------------------

  function linkCopies() {
    for (const button of document.querySelectorAll("button.copy[data-copy]")) {
      button.addEventListener("click", async () => {
        const text = byId(button.dataset.copy);
        try {
          await navigator.clipboard.writeText(text.textContent);
          button.textContent = "Copied";
        } catch {
          getSelection().selectAllChildren(text); // no clipboard on a page from disk: select it for the reader
          button.textContent = "Selected: press Ctrl+C";
        }
      });
    }
  }

  /** Paper is light, and shows every figure and statement. */
  function preparePrint() {
    const opened = [];
    addEventListener("beforeprint", () => {
      printing = true;
      for (const build of unbuilt) build();
      for (const redraw of redraws) redraw();
      for (const image of document.querySelectorAll("img[loading=lazy]")) image.loading = "eager";
      for (const details of document.querySelectorAll("#figures details, #statements details, #tables details, #quality details")) if (!details.open) { details.open = true; opened.push(details); }
      if (parts.surface) paperPanels();
    });
    addEventListener("afterprint", () => {
      printing = false;
      for (const details of opened.splice(0)) details.open = false;
      for (const redraw of redraws) redraw();
      for (const drawing of document.querySelectorAll(".plot > svg")) drawing.remove();
    });
  }

  /** The panels as drawings of lines, which paper shows sharper than pixels, at the width of a page. */
  function paperPanels() {
    fineness = 3;
    const theme = readTheme(true);
    for (const { panel, plot, height } of screen.plots.values()) {
      if (plot.hidden || !height) continue;
      const width = panel.id === "loop" ? PAPER * 0.46 : PAPER * 0.54;
      const pen = svgPen(width, height, `paper-${panel.id}`);
      drawPanel(pen, panel, width, height, theme, screen.range, false);
      const drawing = new DOMParser().parseFromString(pen.finish(), "image/svg+xml").documentElement;
      if (drawing.nodeName === "svg") plot.append(document.importNode(drawing, true));
    }
  }

  /** Marks in the contents the section that is being read. */
  function followReading() {
    const links = [...document.querySelectorAll("#contents a[href^='#']")];
    const watcher = new IntersectionObserver((entries) => {
      for (const { isIntersecting, target } of entries) {
        if (!isIntersecting) continue;
        for (const link of links) link.toggleAttribute("aria-current", link.hash === `#${target.id}`);
      }
    }, { rootMargin: "-20% 0px -70% 0px" });
    for (const link of links) { const target = byId(link.hash.slice(1)); if (target) watcher.observe(target); }
  }

  /** Builds a part when it is about to be seen, so that a large study's page is there at once. */
  const unbuilt = new Set();
  function whenNear(host, build) {
    if (!host) return;
    const now = () => { watcher.disconnect(); if (unbuilt.delete(now)) build(host); };
    const watcher = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && now(), { rootMargin: "600px" });
    unbuilt.add(now);
    watcher.observe(host);
  }

  function startBrowser(host) {
    buildBrowser(host);
    const named = readHash();
    touched = named;
    settle();
    writeControls();
    refresh();
    if (named) byId("trials").scrollIntoView();
    host.addEventListener("change", () => { touched = true; }, true);
    addEventListener("hashchange", () => { if (readHash()) { writeControls(); refresh(); byId("trials").scrollIntoView(); } });
    onWidth(parts.surface, drawAll);
    redraws.delete(drawAll);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
    linkMatrix();
  }

  preparePrint();
  linkCopies();
  followReading();
  if (study.trials.length) {
    if (byId("browser")) startBrowser(byId("browser"));
    whenNear(byId("dot-plot"), buildDots);
    whenNear(byId("answer-plot"), buildAnswers);
    whenNear(byId("model-plot"), buildModel);
  }
})();
