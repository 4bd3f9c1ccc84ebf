/** Elements, numbers, axes and legends, the same for the map and the motion. */

export const INK = "#222222";
export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
const pen = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));

/** @template {Element} E @param {E} element @param {Record<string, string | number>} attributes */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  return element;
}

/** @param {string} tag @param {Record<string, string | number>} [attributes] @param {(Node | string)[]} children */
export function svg(tag, attributes = {}, ...children) {
  const element = /** @type {SVGElement} */ (document.createElementNS("http://www.w3.org/2000/svg", tag));
  element.append(...children);
  return set(element, attributes);
}

/**
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, string | number>} [attributes] @param {(Node | string)[]} children
 */
export function html(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  element.append(...children);
  return set(element, attributes);
}

/** @template {HTMLElement} T @param {string} id @param {new () => T} type */
export function byId(id, type) {
  const element = document.getElementById(id);
  if (element instanceof type) return element;
  throw new Error(`no ${type.name} #${id}`);
}
export const input = (/** @type {string} */ id) => byId(id, HTMLInputElement);
export const select = (/** @type {string} */ id) => byId(id, HTMLSelectElement);
export const place = (/** @type {string} */ id) => byId(id, HTMLElement);

/** A number in few digits, with a proper minus. @param {number} value */
export const numberText = (value, digits = 4) => String(Number(value.toPrecision(digits))).replace("-", "\u2212");

const GREEK = /** @type {Record<string, string>} */ ({ alpha: "α", beta: "β", eta: "η", mu: "μ", phi: "φ", xi: "ξ" });
/** @param {string} letter */
export const symbolText = (letter) => letter.replace(/alpha|beta|eta|mu|phi|xi/, (name) => GREEK[name]);
/** @param {string} unit */
export const unitText = (unit) => unit.replace("deg", "°").replace("^2", "²");

/** @param {string} text @param {number} [size] [px] */
export function textWidth(text, size = 12) {
  pen.font = `${size}px ${FONT}`;
  return pen.measureText(text).width;
}

/** Round numbers along an axis, at most so many. @param {Span} axis @param {number} most */
function ticks({ from, to, log }, most) {
  if (log && to / from >= 10) {
    const powers = Array.from({ length: 64 }, (_, n) => Math.floor(Math.log10(from)) + n);
    const all = powers.flatMap((p) => [1, 2, 5].map((m) => Number(`${m}e${p}`))).filter((v) => v >= from && v <= to);
    return all.length <= most ? all : all.filter((v) => Number.isInteger(Math.log10(v)));
  }
  const power = 10 ** Math.floor(Math.log10((to - from) / most));
  const step = power * ([1, 2, 2.5, 5].find((m) => (to - from) / (m * power) <= most) ?? 10);
  const [first, last] = [Math.ceil(from / step - 1e-9), Math.floor(to / step + 1e-9)];
  return Array.from({ length: last - first + 1 }, (_, n) => Number(((first + n) * step).toPrecision(12)));
}

/** Where a value lies on an axis, 0 to 1. @param {Span} axis @param {number} value */
export function shareAt({ from, to, log }, value) {
  return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
}

/** Ticks and a label below a box. @param {Box} box @param {Span} axis @param {string} label */
export function axisBelow({ left, top, width, height }, axis, label) {
  const name = { x: left + width / 2, y: top + height + 37, "font-size": 13 };
  const group = svg("g", { fill: "currentColor", "text-anchor": "middle" }, svg("text", name, label));
  for (const value of ticks(axis, Math.max(width / 80, 2))) {
    const x = left + width * shareAt(axis, value);
    group.append(svg("path", { d: `M${x} ${top + height}v5`, stroke: "currentColor" }));
    group.append(svg("text", { x, y: top + height + 18 }, numberText(value)));
  }
  return group;
}

/** Ticks left of a box. @param {Box} box @param {Span} axis */
export function axisBeside({ left, top, height }, axis) {
  const group = svg("g", { fill: "currentColor", "text-anchor": "end" });
  for (const value of ticks(axis, Math.max(height / 50, 3))) {
    const y = top + height * (1 - shareAt(axis, value));
    group.append(svg("path", { d: `M${left} ${y}h-5`, stroke: "currentColor" }));
    group.append(svg("text", { x: left - 8, y: y + 4 }, numberText(value)));
  }
  return group;
}

/** Rows of samples, 24 by 14 px, with names. @param {Sample[]} items @param {number} left @param {number} top @param {number} width */
export function legend(items, left, top, width) {
  const group = svg("g");
  let [x, y] = [left, top];
  for (const { sample, text } of items) {
    const wide = 31 + textWidth(text);
    if (x > left && x + wide > left + width) [x, y] = [left, y + 20];
    set(sample, { transform: `translate(${x} ${y})` });
    group.append(sample, svg("text", { x: x + 31, y: y + 11.5, fill: "currentColor" }, text));
    x += wide + 18;
  }
  return { group, height: items.length ? y + 20 - top : 0 };
}
