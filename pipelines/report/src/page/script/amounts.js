// A metric's numbers as people read them. Of a metric of logarithms these are what it has the logarithms of, and differences are ratios: such numbers stand on an axis as their logarithms.

/** Where a value stands on an axis of its metric. */
const placeOfValue = ({ scale: factor, is_logarithm: isLogarithm }, value) => (isLogarithm ? value + Math.log(factor) : value * factor);
/** Where a difference stands on an axis of differences. */
const placeOfDifference = ({ scale: factor, is_logarithm: isLogarithm }, value) => (isLogarithm ? value : value * factor);
/** The number that is read at a place of an axis: in the metric's unit, or a ratio. */
const atPlace = ({ is_logarithm: isLogarithm }, place) => (isLogarithm ? Math.exp(place) : place);
/** A ratio in words, or how many times as large a ratio is as another. */
const timesWords = (text, isOfRatios) => `${text} times${isOfRatios ? " as large a ratio" : ""}`;
const valueAt = (metric, place) => withUnit(significant(atPlace(metric, place)), metric.unit);
const differenceAt = (metric, place, isOfRatios = false) => (metric.is_logarithm ? timesWords(significant(Math.exp(place)), isOfRatios) : withUnit(significant(place), metric.unit));
/** Between two modes of a difference: of logarithms it is a ratio. */
const signOf = ({ is_logarithm: isLogarithm }) => (isLogarithm ? "/" : "−");
/** The unit behind the title of a chart of values, or of differences. */
const unitBehind = ({ unit, is_logarithm: isLogarithm }, areDifferences) => (isLogarithm && areDifferences ? " (ratio)" : unit ? ` (${unit})` : "");

/** Marks of an axis of a metric from one place to another, at most about `count`. */
function ticksOf({ is_logarithm: isLogarithm }, low, high, count) {
  if (!isLogarithm) return ticks(low, high, count);
  const [from, to] = [Math.exp(low), Math.exp(high)], place = (value, text) => ({ value: Math.log(value), text });
  if (to / from < 5) return ticks(from, to, count).filter(({ value }) => value > 0).map(({ value, text }) => place(value, text));
  const powers = Array.from({ length: Math.ceil(Math.log10(to)) - Math.floor(Math.log10(from)) + 1 }, (_, i) => i + Math.floor(Math.log10(from)));
  const within = (digits) => powers.flatMap((power) => digits.map((digit) => Number(`${digit}e${power}`))).filter((value) => value >= from && value <= to);
  const [dense, sparse] = [within([1, 2, 5]), within([1])];
  return (dense.length > count && sparse.length > 1 ? sparse : dense).map((value) => place(value, String(value)));
}
