/** Elements, numbers, axes and legends, the same for the map and the motion. */

import { generalText } from "./typed.js";

export const INK = "#222222";
export const fontFamily = () => getComputedStyle(document.body).fontFamily;
let pen = /** @type {CanvasRenderingContext2D | null} */ (null); // made when it is first needed: node has none

/** @template {Element} E @param {E} element @param {Record<string, string | number>} attributes
 * @param {(Node | string)[]} children */
export function set(element, attributes, ...children) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/** @param {string} tag @param {Record<string, string | number>} [attributes] @param {(Node | string)[]} children */
export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  return set(/** @type {SVGElement} */ (element), attributes, ...children);
}

/** @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, string | number>} [attributes] @param {(Node | string)[]} children */
export function html(tag, attributes = {}, ...children) {
  return set(document.createElement(tag), attributes, ...children);
}

/** A table, of whose rows the first texts are names. @param {string} caption @param {string[]} heads perhaps none
 * @param {string[][]} rows @param {Record<string, string>} [attributes] */
export function tableOf(caption, heads, rows, attributes) {
  const head = heads.map((text) => html("th", { scope: "col" }, text));
  const lines = rows.map(([name, ...cells]) =>
    html("tr", {}, html("th", { scope: "row" }, name), ...cells.map((text) => html("td", {}, text))));
  return html("table", attributes, html("caption", {}, caption),
    ...(head.length ? [html("thead", {}, html("tr", {}, ...head))] : []), html("tbody", {}, ...lines));
}

/** @template {Element} T @param {string} id @param {new () => T} type */
function byId(id, type) {
  const element = document.getElementById(id);
  if (element instanceof type) return element;
  throw new Error(`no ${type.name} #${id}`);
}
export const input = (/** @type {string} */ id) => byId(id, HTMLInputElement);
export const place = (/** @type {string} */ id) => byId(id, HTMLElement);
export const shape = (/** @type {string} */ id) => byId(id, SVGElement);

/** A number in few digits, with a proper minus. @param {number} value */
export const numberText = (value, digits = 5) => generalText(value, digits).replaceAll("-", "\u2212");
/** A value of a quantity with its unit. @param {{sign: string}} quantity @param {number} value */
export const valueText = ({ sign }, value) => numberText(value) + (sign === "\u00b0" || !sign ? "" : " ") + sign;

/** @param {string} text @param {number} [size] [px] */
export function textWidth(text, size = 12) {
  pen ??= /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
  pen.font = `${size}px ${fontFamily()}`;
  return pen.measureText(text).width;
}

const SIDES = {
  below: { mark: "M0 0v5", x: 0, y: 18, anchor: "middle", away: 37 },
  left: { mark: "M0 0h-5", x: -8, y: 4, anchor: "end", away: -44 },
  right: { mark: "M0 0h4", x: 7, y: 4, anchor: "start", away: 52 },
};

// Marks with numbers along a side of a box, and what they are.
/** @param {Box} box @param {keyof typeof SIDES} side @param {Tick[]} ticks @param {string} [label] */
export function axis({ left, top, width, height }, side, ticks, label = "") {
  const { mark, x, y, anchor, away } = SIDES[side];
  const [edge, isBelow] = [side === "right" ? left + width : left, side === "below"];
  const size = 13 * Math.min(1, (isBelow ? width : height) / textWidth(label, 13)); // on telephones a map is low
  const move = (/** @type {number} */ share, /** @type {number} */ far) => isBelow
    ? `translate(${left + width * share} ${top + height + far})`
    : `translate(${edge + far} ${top + height * (1 - share)})`;
  const middle = move(0.5, away) + (isBelow ? "" : " rotate(-90)");
  return svg("g", { "text-anchor": anchor, fill: "currentColor" },
    ...ticks.map(([share, text]) => svg("g", { transform: move(share, 0) },
      svg("path", { d: mark, stroke: "currentColor" }), svg("text", { x, y }, text))),
    svg("text", { transform: middle, "text-anchor": "middle", "font-size": size }, label));
}

// The way of a curve through points, in shares of a plot; NaN interrupts it.
/** @param {number} count @param {(n: number) => ArrayLike<number>} point */
export function way(count, point) {
  let [d, pen] = ["", "M"];
  for (let n = 0; n < count; n++) {
    const { 0: x, 1: y } = point(n);
    const isThere = !Number.isNaN(x + y);
    if (isThere) d += `${pen}${(1000 * x).toFixed(1)} ${(1000 - 1000 * y).toFixed(1)}`;
    pen = isThere ? "L" : "M";
  }
  return d;
}

/** @param {string} d @param {{ colour: string, width: number, dash: number[] }} look */
export function curve(d, { colour, width, dash }, more = {}) {
  const look = { stroke: colour, "stroke-width": width, "stroke-dasharray": dash.join(" "), ...more };
  return svg("path", { d, fill: "none", "vector-effect": "non-scaling-stroke", ...look });
}

// What is drawn in a box of 1000 by 1000, cut at its edges, and its frame.
/** @param {Box} box @param {Record<string, string>} attributes @param {Node[]} children */
export function plot({ left, top, width, height }, attributes, ...children) {
  const area = { x: left, y: top, width, height };
  const inside = { ...area, viewBox: "0 0 1000 1000", preserveAspectRatio: "none", ...attributes };
  const frame = svg("rect", { ...area, fill: "none", stroke: "currentColor" });
  return svg("g", {}, svg("svg", inside, ...children), frame);
}

// Rows of names, each after a sample on paper, 24 by 14 px, if it has one.
/** @param {Sample[]} items @param {number} left @param {number} top @param {number} width */
export function legend(items, left, top, width) {
  const group = svg("g");
  let [x, y] = [left, top];
  for (const { sample, text } of items) {
    const indent = sample.length ? 31 : 0;
    const wide = indent + textWidth(text);
    if (x > left && x + wide > left + width) [x, y] = [left, y + 20];
    const paper = sample.length ? [svg("rect", { width: 24, height: 14, fill: "#FFFFFF" })] : [];
    const name = svg("text", { x: indent, y: 11.5, fill: "currentColor" }, text);
    group.append(svg("g", { transform: `translate(${x} ${y})` }, ...paper, ...sample, name));
    x += wide + 18;
  }
  return { group, height: items.length ? y + 20 - top : 0 };
}
