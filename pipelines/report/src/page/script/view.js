// What the trial browser shows, and its address.

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

const view = { p: null, s: null, e: null, m: [], r: "all", a: "onset", beside: null, show: new Set(["repeats", "mean", "states"]), zoom: null, wall: false, brush: [null, null] };

const EVERY = "*"; // everybody, or every session: no name has a star
const MOST_TOGETHER = 60; // sessions that are shown together

/** Participant and session of everything that the view shows, in the order of the study. */
function whose() {
  const people = view.p === EVERY ? [...sessionsOf.keys()] : [view.p];
  return people.flatMap((p) => (view.s === EVERY ? [...sessionsOf.get(p)] : [view.s]).map((s) => ({ p, s }))).slice(0, MOST_TOGETHER);
}

/** The trials of a condition that the view may show, by participant and session. */
const trialsIn = (environment, mode) => whose().map(({ p, s }) => trialsBy.get(pathOf(p, s, environment, mode)) ?? []).filter((trials) => trials.length);
const hasTrials = (environment, mode) => trialsIn(environment, mode).length > 0;

const wallOf = (id) => environmentOf(id)?.wall_rad ?? null;
const shownTrials = () => view.m.flatMap((mode) => trialsIn(view.e, mode).flat());

/** What else could be shown beside the view: the same of another person, session or environment. */
function besides() {
  if (view.p === EVERY || view.s === EVERY) return [];
  const sessionOf = (p) => (sessionsOf.get(p).has(view.s) ? view.s : [...sessionsOf.get(p)][0]);
  const people = [...sessionsOf.keys()].filter((p) => p !== view.p).map((p) => ({ key: `p:${p}`, label: p, p, s: sessionOf(p), e: view.e }));
  const sessions = [...sessionsOf.get(view.p)].filter((s) => s !== view.s).map((s) => ({ key: `s:${s}`, label: `session ${s}`, p: view.p, s, e: view.e }));
  const environments = study.environments.filter(({ id }) => id !== view.e).map(({ id, label }) => ({ key: `e:${id}`, label, p: view.p, s: view.s, e: id }));
  return [...environments, ...sessions, ...people].filter(({ p, s, e }) => study.modes.some((mode) => trialsBy.has(pathOf(p, s, e, mode.id))));
}

/** Chooses something that is there wherever the wish is not. */
function settle() {
  if (view.p === EVERY && sessionsOf.size > 1) view.s = EVERY;
  else if (!sessionsOf.has(view.p)) view.p = study.trials[0].participant;
  const sessions = view.p === EVERY ? [] : [...sessionsOf.get(view.p)];
  if (view.p !== EVERY && !sessions.includes(view.s) && (view.s !== EVERY || sessions.length < 2)) view.s = sessions[0];
  const mine = (environment) => study.modes.some((mode) => hasTrials(environment, mode.id));
  if (!mine(view.e)) view.e = study.environments.find((environment) => mine(environment.id))?.id ?? null;
  view.m = study.modes.map((mode) => mode.id).filter((mode) => view.m.includes(mode));
  if (!shownTrials().length) view.m = study.modes.map((mode) => mode.id).filter((mode) => hasTrials(view.e, mode));
  if (!shownTrials().some((trial) => trial.repeat === view.r)) view.r = "all";
  if (view.wall && wallOf(view.e) === null) view.wall = false;
  if (!besides().some(({ key }) => key === view.beside)) view.beside = null;
}

function writeHash() {
  const query = new URLSearchParams({ p: view.p, s: view.s, e: view.e, m: view.m.join(","), r: view.r, a: view.a, show: [...view.show].join(",") });
  if (view.zoom) query.set("t", view.zoom.map(exact).join(","));
  if (view.wall) query.set("wall", "1");
  if (view.beside) query.set("beside", view.beside);
  if (leftOut.size) query.set("x", [...leftOut].join(","));
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
  Object.assign(view, { zoom: span(query.get("t")), wall: query.get("wall") === "1", beside: query.get("beside"), brush: span(query.get("b")) ?? [null, null] });
  settle();
  return true;
}
