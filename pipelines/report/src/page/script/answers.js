// Answers beside a metric.

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
  const sign = (mode, m) => make("li", {}, makeSvg("svg", { width: 16, height: 16, viewBox: "-8 -8 16 16", "aria-hidden": "true" }, makeSvg("path", { d: SHAPES[m % SHAPES.length](5), style: `--own: var(--mode-${m % MODE_COLOURS})` })), short(mode.label, 40));
  const legend = make("ul", { class: "legend" });
  const question = make("p", { class: "question" }), charts = make("div", { class: "charts one" }), tip = make("p", { class: "tip" });
  const tell = (words) => { tip.textContent = words; };
  host.replaceChildren(make("div", { class: "controls" }, who, what, which), question, legend, charts, tip);
  function draw() {
    const q = Number(pickWhat.value), index = Number(pickMetric.value), asks = study.questions[q], metric = study.metrics[index];
    const trials = study.trials.filter((trial) => (!pickWho.value || trial.participant === pickWho.value) && Number.isFinite(answered(trial, q)) && Number.isFinite(measured(trial, index)));
    question.textContent = `“${short(asks.label, 400)}”${asks.reversed ? " (agreement speaks against)" : ""}`;
    tip.textContent = trials.length ? "Point at a mark for its trial; Enter or a click opens it." : "No trial has both an answer to this question and this metric.";
    legend.replaceChildren(...study.modes.map(sign).filter((_, m) => trials.some((trial) => modeIndex(trial.mode) === m)));
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
  for (const { value, text } of ticksOf(metric, ...range, (box.right - box.left) / 70)) svg.append(makeSvg("line", { x1: sx.k * value + sx.c, x2: sx.k * value + sx.c, y1: box.top, y2: box.bottom, class: "grid" }), svgText(text, sx.k * value + sx.c, box.bottom + 16, { "text-anchor": "middle" }));
  svg.append(svgText(short(metricTitle(metric), Math.floor(width / 7)), box.right, box.bottom + 34, { "text-anchor": "end", class: "group" }));
  const seen = new Map(); // dots of one answer are spread over its band, the same way every time
  trials.forEach((trial, i) => {
    const answer = answered(trial, q), place = seen.get(answer) ?? 0;
    seen.set(answer, place + 1);
    svg.append(point(sx.k * values[i] + sx.c, sy.k * (answer + 0.6 * step * spread(place)) + sy.c, { mode: modeIndex(trial.mode), words: `${trialWords(trial)}: answered ${answer}${asks.labels?.[(answer - asks.lowest) / step] ? ` (${short(asks.labels[(answer - asks.lowest) / step])})` : ""}, ${valueAt(metric, values[i])}`, open: () => openTrial(trial, index) }, trials.length > 400 ? 2.5 : 5, tell));
  });
  return svg;
}

const MOST_ANSWERED = 12; // trials whose answers stand side by side

/** The answers that a score is made of, trial by trial. */
function answersBehind(index, trials) {
  const { label, items } = study.metrics[index], shown = trials.slice(0, MOST_ANSWERED);
  const answer = (trial, q) => {
    const { labels, lowest, step = 1 } = study.questions[q], value = answered(trial, q), word = labels?.[(value - lowest) / step];
    return Number.isNaN(value) ? "–" : word ? `${value} (${short(word)})` : `${value}`;
  };
  const cell = (text) => make("td", {}, text);
  const columns = shown.map((trial) => make("th", { scope: "col" }, `trial ${trial.trial}: ${short(labelOf(study.environments, trial.environment), 20)}, ${short(labelOf(study.modes, trial.mode), 20)}, repeat ${trial.repeat}`));
  const lines = items.map((q) => make("tr", {}, make("th", { scope: "row" }, short(study.questions[q].label, 100), study.questions[q].reversed ? make("span", { class: "count" }, " (counts the other way round)") : null), ...shown.map((trial) => cell(answer(trial, q)))));
  const scored = make("tr", { class: "scored" }, make("th", { scope: "row" }, make("strong", {}, short(label, 100))), ...shown.map((trial) => cell(make("strong", {}, significant(atPlace(study.metrics[index], measured(trial, index)))))));
  const people = distinct(trials.map(({ participant, session }) => `${participant} ${session}`)).join(", ");
  const heading = `Answers of ${short(people, 60)} behind the score${trials.length > MOST_ANSWERED ? `: the first ${MOST_ANSWERED} of ${trials.length} trials` : ""}`;
  return make("div", { id: "score-answers", tabindex: "-1" }, make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": heading }, make("table", {}, make("caption", {}, heading), make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "question"), ...columns)), make("tbody", {}, ...lines, scored))));
}
