// @ts-check
/** Elements, numbers, ticks and legends, the same for the map and the history. */

export const INK = "#222222";
export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
const pen = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));

/**
 * @param {string} tag
 * @param {Record<string, string | number>} [attributes]
 * @param {(Node | string)[]} children
 */
export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/**
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string>} [attributes]
 * @param {(Node | string)[]} children
 */
export function html(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** @template {HTMLElement} T @param {string} id @param {new () => T} type @returns {T} */
export function byId(id, type) {
  const element = document.getElementById(id);
  if (!(element instanceof type)) throw new Error(`no ${type.name} #${id}`);
  return element;
}

/** A number in few digits, with a proper minus. @param {number} value */
export function numberText(value, digits = 4) {
  return String(Number(value.toPrecision(digits))).replace("-", "\u2212").replace("Infinity", "\u221e");
}

/** @param {string} text @param {number} size [px] */
export function textWidth(text, size) {
  pen.font = `${size}px ${FONT}`;
  return pen.measureText(text).width;
}

/** Round numbers between two ends. @param {number} from @param {number} to @param {boolean} log @param {number} most */
export function ticks(from, to, log, most) {
  if (log && to / from >= 10) {
    const decades = Array.from({ length: 40 }, (_, n) => Math.floor(Math.log10(from)) + n);
    const all = decades.flatMap((d) => [1, 2, 5].map((m) => Number(`${m}e${d}`)));
    const within = all.filter((v) => v >= from && v <= to * (1 + 1e-9));
    return within.length <= most ? within : within.filter((v) => Number.isInteger(Math.log10(v)));
  }
  const power = 10 ** Math.floor(Math.log10((to - from) / most));
  const step = power * ([1, 2, 2.5, 5, 10].find((m) => (to - from) / (m * power) <= most) ?? 10);
  const first = Math.ceil(from / step - 1e-9);
  const count = Math.floor(to / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(count, 0) }, (_, n) => Number(((first + n) * step).toPrecision(12)));
}

/**
 * Rows of samples with names.
 * @param {{sample: Element, text: string}[]} items samples are 24 px wide and 14 px high
 * @param {number} left @param {number} top @param {number} width
 */
export function legend(items, left, top, width, size = 12) {
  const group = svg("g", { "font-size": size });
  let [x, y] = [left, top];
  for (const { sample, text } of items) {
    const wide = 31 + textWidth(text, size) + 18;
    if (x > left && x + wide - 18 > left + width) [x, y] = [left, y + 20];
    sample.setAttribute("transform", `translate(${x} ${y})`);
    group.append(sample, svg("text", { x: x + 31, y: y + 11.5, fill: "currentColor" }, text));
    x += wide;
  }
  return { group, height: items.length ? y + 20 - top : 0 };
}

/** @param {string} colour @param {number[]} dash @param {number} width */
export function lineSample(colour, dash, width) {
  const look = { stroke: colour, "stroke-width": width, "stroke-dasharray": dash.join(" ") };
  return svg("g", {}, svg("path", { d: "M0 7H24", ...look }));
}
