// What the study is, and words and numbers of its page.

const byId = (id) => document.getElementById(id);
const source = byId("study-data");
if (!source) return;
const study = JSON.parse(source.textContent);
const LINEAR = study.angle_unit === "mm";
const ANGLE_SCALE = study.angle_scale; // what an angle in rad is multiplied by to be shown
const FORCE = study.force_unit || "N";
const DASHES = WIDTHS.map((widths) => widths.map((width) => 2 * width)); // as in the figures, of lines that are 2 px wide
const BITS = { 1: "saturated", 2: "stale force", 4: "stale angle", 8: "dropout", 16: "clipped", 32: "past wall", 64: "outside work space", 128: "brake on", 256: "motor on" };
const EVENTS = { onset: ["○", "onset"], contact: ["×", "contact"], reversal: ["△", "reversal"], let_go: ["◇", "let-go"], end: ["□", "end"] };

/** An element with attributes, listeners (`onclick`) and children; strings become text. A `style` is set as one: as an attribute the page's policy forbids it. */
function make(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

function makeSvg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (name === "style") element.style.cssText = value;
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** At most `limit` characters, so that no label breaks a plot. */
const short = (text, limit = 28) => {
  const letters = [...String(text)];
  return letters.length > limit ? `${letters.slice(0, limit - 1).join("")}…` : String(text);
};
const minus = (text) => text.replace("-", "−");
const rounded = (value, digits) => (Number.isFinite(value) ? minus(value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1")) : "–");
const significant = (value) => (Number.isFinite(value) ? minus(String(Number(value.toPrecision(4)))) : "–");
/** The stored number itself: reading it back gives the same 64 bits. */
const exact = (value) => (Object.is(value, -0) ? "-0" : String(value));
const finite = (values) => values.filter(Number.isFinite);
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
const deviation = (values) => {
  const middle = mean(values);
  return values.length < 2 ? NaN : Math.sqrt(values.reduce((sum, value) => sum + (value - middle) ** 2, 0) / (values.length - 1));
};
const distinct = (values) => [...new Set(values)];
const environmentOf = (id) => study.environments.find((environment) => environment.id === id);
const modeIndex = (id) => study.modes.findIndex((mode) => mode.id === id);
const labelOf = (list, id) => list.find((item) => item.id === id)?.label ?? id;
const calm = matchMedia("(prefers-reduced-motion: reduce)");
