// Curves: what is drawn.

function shifted(times, shift) {
  const moved = new Float64Array(times.length);
  for (let i = 0; i < times.length; i++) moved[i] = times[i] - shift;
  return moved;
}

function curveOf(table, mode, key, kind, label, shift, { overTime = true, overAngle = true, model = null } = {}) {
  const c = table.columns;
  const times = shift ? shifted(c.t_s, shift) : c.t_s;
  const y = { t: times, theta: c.theta_rad, velocity: c.theta_dot_rad_s, force: c.force_ex_n ?? c.torque_ex_nm, command: c.force_cmd_n ?? c.torque_cmd_nm };
  return { y, stored: c, n: table.n, mode, key, kind, label, shift, overTime, overAngle, model, trial: table.trial ?? null, repeat: table.repeat ?? null, recorded: table.recorded ?? table.n, bits: c.state_bits, events: table.events ?? [] };
}

const onsetOf = (trial) => trial?.events?.find((event) => event.kind === "onset")?.t_s;

/** The curves of one mode of one session: its repeats, its mean as the alignment allows, its replay. */
function curvesOfMode({ mode, key, who }, data) {
  const shift = (trial) => (view.a === "onset" ? onsetOf(trial) ?? 0 : 0);
  const place = who.e === view.e ? "" : `${short(labelOf(study.environments, who.e))}, `;
  const name = whose().length > 1 || view.beside ? `${who.p} ${who.s}, ${place}${short(labelOf(study.modes, mode))}` : short(labelOf(study.modes, mode));
  const one = view.r !== "all";
  const landmarks = view.a === "landmarks" && data.means.landmarks;
  const curves = [];
  // One repeat has no mean beside it.
  if (view.show.has("repeats") || one || (view.show.has("mean") && data.trials.length === 1))
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
      curves.push(curveOf(table, mode, key, "replay", `${name}, replay ${kind.replace("_", " ")} (trial ${table.trial})`, shift(trial), { overTime: !landmarks, model: kind }));
    }
  return curves.map((curve) => ({ ...curve, who }));
}

/** How a curve is drawn: alone or as a mean it is strong and has its mode's dashes, among repeats it is thin. */
function styleOf(curve, curves, theme) {
  const colour = theme.modes[modeIndex(curve.mode)];
  const dash = DASHES[modeIndex(curve.mode) % DASHES.length];
  if (curve.kind === "replay") return { colour: theme.ink, width: 1.5, dash: curve.model === "fitted" ? [2, 2] : [7, 3, 1, 3], opacity: 0.85 };
  if (curve.who.isBeside) return { colour, width: curve.kind === "mean" ? 2.5 : 1.25, dash: [1.5, 3], opacity: 0.9 };
  const means = curves.filter((other) => other.mode === curve.mode && other.kind === "mean" && other.overTime === curve.overTime).length;
  if (curve.kind === "mean") return { colour, width: means > 1 ? 1.5 : 2.5, dash };
  const alone = curves.filter((other) => other.mode === curve.mode && other.kind === "trial").length === 1;
  return alone ? { colour, width: view.show.has("mean") ? 1.25 : 2, dash } : { colour, width: 1, opacity: curves.some((other) => other.kind === "mean") ? 0.45 : 0.8 };
}
