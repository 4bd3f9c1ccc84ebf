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

const SIDES = { below: [0, 5, 0, 18, "middle"], left: [-5, 0, -8, 4, "end"], right: [4, 0, 7, 4, "start"] };

/** Marks with numbers on a side of a box. @type {Marks} */
export function marks({ left, top, width, height }, side, values, share) {
  const [dx, dy, x, y, anchor] = SIDES[side];
  return svg("g", { "text-anchor": anchor, fill: "currentColor" }, ...values.map((value) => {
    const along = side === "below" ? left + width * share(value) : side === "left" ? left : left + width;
    const down = side === "below" ? top + height : top + height * (1 - share(value));
    const mark = svg("path", { d: `M0 0l${dx} ${dy}`, stroke: "currentColor" });
    return svg("g", { transform: `translate(${along} ${down})` }, mark, svg("text", { x, y }, numberText(value)));
  }));
}

/** Marks below a box, or left of it, and what they are. @param {Box} box @param {"below" | "left"} side @param {Span} axis */
export function axisMarks(box, side, axis, label = "") {
  const values = ticks(axis, side === "below" ? Math.max(box.width / 80, 2) : Math.max(box.height / 50, 3));
  return svg("g", {}, marks(box, side, values, (value) => shareAt(axis, value)), sideLabel(box, side, label));
}

/** Words along a side of a box. @param {Box} box @param {keyof typeof SIDES} side @param {string} text */
export function sideLabel({ left, top, width, height }, side, text) {
  const [x, y] = [side === "left" ? 14 : side === "right" ? left + width + 52 : left + width / 2, top + height / 2];
  const place = side === "below" ? `translate(${x} ${top + height + 37})` : `translate(${x} ${y}) rotate(-90)`;
  return svg("text", { transform: place, "text-anchor": "middle", "font-size": 13, fill: "currentColor" }, text);
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
