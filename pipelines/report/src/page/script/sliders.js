// The model, turned by hand: each stop of a slider is a run that was made.

const TURNS = [["Mass", "kg", 1], ["Damping", study.turned?.damping_unit, study.turned?.damping_scale], ["Friction", "N", 1]];

async function decodeTurned(turned) {
  const counts = turned.values.map((values) => values.length);
  const combinations = counts.reduce((product, count) => product * count, 1);
  const [[t], [recorded], [errors], [angles]] = await Promise.all([decodeColumns(turned.t_s, turned.times, 1), decodeColumns(turned.recorded_rad, turned.times, 1), decodeColumns(turned.rmse_rad, combinations, 1), decodeColumns(turned.theta_rad, combinations * turned.times, 1)]);
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
  const style = `--own: var(--mode-${modeIndex(turned.mode) % MODE_COLOURS})`;
  // A model that does not run has no curve, and so no name.
  for (const [name, values, x, look] of [["recorded", recorded, box.right - 190, {}], ["model", model, box.right - 90, { style }]]) {
    if (!values.some(Number.isFinite)) continue;
    svg.append(makeSvg("path", { d: path(values), class: name, ...look }));
    svg.append(makeSvg("line", { x1: x, x2: x + 30, y1: 12, y2: 12, class: name, ...look }), svgText(name, x + 36, 16));
  }
  return svg;
}
