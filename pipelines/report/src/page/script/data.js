// Trials' samples: loaded when asked for, decoded bit for bit.

const MOST_KEPT = 48; // conditions kept decoded; older ones are loaded again
const kept = new Map();
/** The scripts that are being loaded, by their files, with the conditions that each has given. */
const arriving = new Map();
/** A condition's script is that of its environment, with all of its modes. */
const scriptOf = (key) => (key.includes(".") ? key.slice(0, key.lastIndexOf(".")) : key);
window.zwidthData = (key, content) => arriving.get(scriptOf(key))?.given.set(key, content);

/** What a script gives; nothing where it cannot be read. */
function load(file) {
  if (!arriving.has(file)) {
    const given = new Map(), script = make("script", { src: `report-data/${encodeURIComponent(file)}.js` });
    const ended = new Promise((resolve) => { for (const end of ["load", "error"]) script.addEventListener(end, resolve); });
    arriving.set(file, { given, loaded: ended.then(() => { arriving.delete(file); script.remove(); return given; }) });
    document.head.append(script);
  }
  return arriving.get(file).loaded;
}

/** The condition's object as it stands in the page (one file) or beside it. */
async function fetchCondition(key) {
  if (study.single_file) {
    const block = [...document.querySelectorAll("script.trial-data")].find((element) => element.dataset.key === key);
    if (!block) throw new Error(`this page holds no data of ${short(key, 80)}`);
    return JSON.parse(block.textContent);
  }
  const content = (await load(scriptOf(key))).get(key);
  if (!content) throw new Error(`the data of ${short(key, 80)} could not be read: the folder report-data must lie beside this page`);
  return content;
}

const blocks = (name) => new Map([...document.querySelectorAll(`script.${name}`)].map((element) => [element.dataset.key, element]));

function unpacked(text) {
  const binary = atob(text), packed = new Uint8Array(binary.length);
  for (let i = 0; i < packed.length; i++) packed[i] = binary.charCodeAt(i);
  // Not by a Blob's stream: it goes through another process, some milliseconds each.
  const inflate = new DecompressionStream("deflate-raw"), input = inflate.writable.getWriter();
  const written = input.write(packed).then(() => input.close());
  return Promise.all([new Response(inflate.readable).arrayBuffer(), written]).then(([buffer]) => buffer);
}

let figureBlocks = null;
/** Gives a figure of a page in one file its picture. */
async function show(image) {
  const { packed } = image.dataset;
  if (!packed) return;
  delete image.dataset.packed;
  figureBlocks ??= blocks("figure-data");
  const text = new TextDecoder().decode(await unpacked(figureBlocks.get(packed).textContent));
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
}

/** Columns of n numbers, one after the other: base64, deflate, bytes in planes, each value XORed with the one before. Little-endian, as every browser's machine is. */
async function decodeColumns(text, n, count) {
  const buffer = await unpacked(text);
  if (buffer.byteLength !== 8 * n * count) throw new Error(`${count} columns hold ${buffer.byteLength} bytes where ${n} samples take ${8 * n * count}`);
  return Array.from({ length: count }, (_, column) => numbersOf(new Uint8Array(buffer, 8 * n * column, 8 * n), n));
}

function numbersOf(planes, n) {
  const bytes = new Uint8Array(8 * n);
  for (let plane = 0; plane < 8; plane++) for (let i = 0; i < n; i++) bytes[8 * i + plane] = planes[plane * n + i];
  const words = new Uint32Array(bytes.buffer);
  for (let i = 2; i < words.length; i++) words[i] ^= words[i - 2];
  return new Float64Array(bytes.buffer);
}

async function decodeTable({ samples, columns: names, ...table }) {
  const columns = await decodeColumns(samples, table.n, names.length);
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
