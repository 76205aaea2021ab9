// Scales, and curves thinned to what a screen can show.

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
