/** The map: a canvas of cells, and over it axes, curves, the operating point, and what they mean. */

import { colours, paint, picture, piecesOf } from "./cells.js";
import { axis, curve, html, legend, numberText, place, plot, set, shape, svg, way } from "./draw.js";

const [STEP, LEAP] = [0.01, 0.1]; // of an axis, by an arrow key, and with Shift
/** @type {Record<string, number[]>} */
const KEYS = { ArrowLeft: [-1, NaN], ArrowRight: [1, NaN], ArrowUp: [NaN, 1], ArrowDown: [NaN, -1] };

/** A value at a share of an axis, in as many digits as a hand can set. @param {AxisInfo} axis @param {number} share */
function valueAt({ from, to, log }, share) {
  if (log) return Number((from * (to / from) ** share).toPrecision(4));
  const digits = Math.ceil(3 - Math.log10(to - from));
  return Number((from + (to - from) * share).toFixed(Math.min(Math.max(digits, 0), 12)));
}

/** Where a value lies on an axis, 0 to 1; beyond where it cannot. @param {AxisInfo} axis @param {number} value */
function shareAt({ from, to, log }, value) {
  const share = log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
  return Number.isFinite(share) ? share : -1;
}

/** @param {AxisInfo} axis @param {number} value */
const valueText = ({ unit }, value) => (Number.isNaN(value) ? "–" : `${numberText(value, 5)} ${unit}`.trim());
/** @param {string[]} values */
const pointText = (values) => `operating point: ${values.join(", ")}`;
const within = (/** @type {number} */ share) => Math.min(Math.max(share, 0), 1);

/** A curve; a halo parts it from the colours of cells. @param {string} d @param {CurveInfo} info */
function line(d, info) {
  const under = { ...info, colour: info.halo, width: info.width + 1.7, dash: [] };
  const halo = info.halo ? [curve(d, under, { "stroke-opacity": 0.8 })] : [];
  return [...halo, curve(d, info, { "data-curve": info.name })];
}

/** @typedef {(patch: State, isFinished: boolean) => void} Move */
export class MapView {
  // numberOf gives the values of the operating point; move is called while a hand moves it.
  /** @param {Schema} schema @param {(column: string) => number} numberOf @param {Move} move */
  constructor(schema, numberOf, move) {
    this.schema = schema;
    this.numberOf = numberOf;
    this.move = move;
    this.stage = place("stage");
    this.canvas = /** @type {HTMLCanvasElement} */ (place("cells"));
    this.svg = shape("map");
    this.surface = shape("surface");
    this.point = shape("point");
    this.map = /** @type {MapAnswer | null} */ (null);
    this.cells = /** @type {Cells | null} */ (null);
    this.at = [0, 0]; // the operating point: shares of the axes, perhaps outside of them
    this.box = { left: 58, top: 30, width: 1, height: 1 };
    this.sign = /** @type {Element | null} */ (null); // the operating point's values as a text
    this.dragging = false;
    this.pointer = /** @type {PointerEvent | null} */ (null); // the last event of one that is over the map
    new ResizeObserver(() => this.draw()).observe(this.stage);
    this.listen();
  }

  /** @param {MapAnswer} map */
  show(map) {
    const { header: { palette, hatches, x, y }, arrays: { faces, others, marks } } = map;
    const looks = { palette: colours(palette), hatches, pale: this.schema.marks.misses };
    this.map = map;
    this.cells = { ...looks, faces, others, marks, nx: x.count, ny: y.count, pieces: piecesOf(map) };
    this.draw();
    place("notes").replaceChildren(...map.header.notes.map((note) => html("p", {}, note)));
  }

  draw() {
    if (!this.map || !this.cells) return;
    const { box, cells, map: { header: { title, caption, label, progress, x, y, scale } } } = this;
    const wide = this.stage.clientWidth;
    const room = window.innerHeight * (wide < 600 ? 0.4 : 0.64);
    const hasBar = scale && scale.ticks.length > 0;
    const texts = [...caption.split(", "), progress.text].filter(Boolean);
    const facts = legend(texts.map((text) => ({ text, sample: [] })), box.left, 25, wide - box.left);
    box.top = 30 + facts.height;
    box.width = wide - box.left - (hasBar ? 84 : 16);
    box.height = Math.round(Math.max(Math.min(0.75 * box.width, room), 180));
    const under = box.top + box.height + 50;
    const names = legend(this.samples(cells), 12, under, wide - 24);
    this.sign = names.group.querySelector(":scope > :last-child > text");
    const name = title[0].toUpperCase() + title.slice(1);
    shape("frame").replaceChildren(
      svg("text", { x: box.left, y: 18, "font-size": 14, "font-weight": 600, fill: "currentColor" }, name),
      facts.group, axis(box, "below", x.ticks, x.title), axis(box, "left", y.ticks, y.title),
      ...(hasBar ? this.bar(scale, label, cells) : []), plot(box, { class: "curves" }, ...this.curves()), names.group);
    const height = under + names.height;
    set(this.svg, { width: wide, height, viewBox: `0 0 ${wide} ${height}` });
    set(this.svg, { "aria-label": `${name}, over ${x.title} and ${y.title}` });
    set(this.surface, { x: box.left, y: box.top, width: box.width, height: box.height });
    for (const [side, length] of Object.entries(box)) this.canvas.style.setProperty(side, `${length}px`);
    const zoom = window.devicePixelRatio;
    [this.canvas.width, this.canvas.height] = [Math.round(box.width * zoom), Math.round(box.height * zoom)];
    paint(this.canvas, zoom, cells);
    this.put();
    this.hover();
  }

  /** The colour bar. @param {ScaleInfo} scale @param {string} label @param {Cells} cells */
  bar({ colours: [first, count], ticks }, label, cells) {
    const box = { ...this.box, left: this.box.left + this.box.width + 14, width: 12 };
    const href = picture(cells, Array.from({ length: count }, (_, n) => first + n), 1, 128);
    const image = svg("image", { href, width: 1000, height: 1000, preserveAspectRatio: "none" });
    return [plot(box, {}, image), axis(box, "right", ticks, label)];
  }

  curves() {
    const { header, arrays: { points } } = /** @type {MapAnswer} */ (this.map);
    let first = 0;
    return header.curves.flatMap((info) => {
      const own = points.subarray(first, (first += 2 * info.count));
      return line(way(info.count, (n) => own.subarray(2 * n)), info);
    });
  }

  /** What the legend shows. @param {Cells} cells */
  samples(cells) {
    const { legend, curves, x, y } = /** @type {MapAnswer} */ (this.map).header;
    const edge = { x: 0.5, y: 0.5, width: 23, height: 13, fill: "none", stroke: "#777777" };
    const kinds = legend.map(({ text, faces, marks }) => {
      const href = picture(cells, faces, 24, 14, marks);
      return { text, sample: [svg("image", { href, width: 24, height: 14 }), svg("rect", edge)] };
    });
    const lines = curves.map((info) => ({ text: info.label, sample: line("M0 7H24", info) }));
    const ring = svg("circle", { cx: 12, cy: 7, r: 4.5, fill: "#FFFFFF", stroke: "#000000", "stroke-width": 2.5 });
    const widest = [x, y].map((axis) => valueText(axis, 0.12345));
    return [...kinds, ...lines, { text: pointText(widest), sample: [ring] }];
  }

  /** Put the operating point where the state has it. */
  put() {
    if (!this.map) return;
    const { x, y } = this.map.header;
    const { left, top, width, height } = this.box;
    const numbers = [x, y].map((axis) => this.numberOf(axis.column));
    // While what somebody typed is no number, or one with a unit, the point stays where it was.
    this.at = [x, y].map((axis, n) => (Number.isNaN(numbers[n]) ? this.at[n] : shareAt(axis, numbers[n])));
    const [u, v] = this.at.map(within);
    const isOutside = this.at.some((share) => Math.abs(share - 0.5) > 0.5 + 1e-6);
    const values = [x, y].map((axis, n) => valueText(axis, numbers[n]));
    this.sign?.replaceChildren(pointText(values));
    set(this.point, {
      transform: `translate(${left + width * u} ${top + height * (1 - v)})`,
      "stroke-dasharray": isOutside ? "3 2.5" : "none",
      "aria-valuenow": Math.round(100 * u), "aria-valuetext": `${x.label} ${values[0]}, ${y.label} ${values[1]}`,
    });
    place("outside").hidden = !isOutside;
  }

  listen() {
    this.svg.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      this.svg.setPointerCapture(event.pointerId);
      this.dragging = true;
      if (event.target === this.surface) this.moveTo(this.sharesOf(event));
      this.hover(event);
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (this.dragging) this.moveTo(this.sharesOf(event));
      this.hover(event);
    });
    this.svg.addEventListener("lostpointercapture", () => {
      this.dragging = false;
      this.move({}, true);
      this.hover();
    });
    this.svg.addEventListener("pointerleave", () => this.hover(null));
    document.addEventListener("keydown", ({ key }) => key === "Escape" && this.hover(null));
    this.point.addEventListener("keydown", (event) => {
      if (!(event.key in KEYS) || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      const far = event.shiftKey ? LEAP : STEP;
      this.moveTo(KEYS[event.key].map((way, n) => this.at[n] + way * far));
    });
    this.point.addEventListener("keyup", ({ key }) => key in KEYS && this.move({}, true));
  }

  /** Where a pointer is: shares of the axes, perhaps outside of them. @param {PointerEvent} event */
  sharesOf({ clientX, clientY }) {
    const area = this.canvas.getBoundingClientRect();
    return [(clientX - area.left) / area.width, 1 - (clientY - area.top) / area.height];
  }

  /** Move the point to shares of the axes; NaN leaves a coordinate as it is. @param {number[]} shares */
  moveTo(shares) {
    if (!this.map) return;
    const { x, y } = this.map.header;
    const moved = [x, y].map((axis, n) => [axis.column, String(valueAt(axis, within(shares[n])))]);
    this.move(Object.fromEntries(moved.filter((_, n) => !Number.isNaN(shares[n]))), false);
  }

  // Show the numbers of the cell under a pointer that is over the map and does not move the point.
  /** @param {PointerEvent | null} pointer */
  hover(pointer = this.pointer) {
    this.pointer = pointer;
    const tip = place("tip");
    const [u, v] = pointer && !this.dragging ? this.sharesOf(pointer) : [NaN, NaN];
    tip.hidden = !(within(u) === u && within(v) === v);
    if (!this.map || !pointer || tip.hidden) return;
    const { header: { x, y, bands, label, legend }, arrays } = this.map;
    const { regime, lowest = regime, highest = regime, status, speed, values, amplitude, marks } = arrays;
    const [i, j] = [Math.round(u * (x.count - 1)), Math.round(v * (y.count - 1))];
    const cell = j * x.count + i;
    const names = [lowest, highest].map((codes) => this.schema.regimes.find((r) => r.code === codes[cell])?.label);
    const number = (/** @type {Numbers | undefined} */ numbers) =>
      numbers && !Number.isNaN(numbers[cell]) ? numberText(numbers[cell]) : "";
    const trouble = this.schema.statuses.find((s) => s.code === status[cell])?.message ?? "not computed yet";
    const told = legend.filter((item) => item.marks & marks[cell]).map((item) => item.text);
    const rows = [
      [x.label, valueText(x, valueAt(x, i / (x.count - 1)))], [y.label, valueText(y, valueAt(y, j / (y.count - 1)))],
      ["regime", [...new Set(names)].filter(Boolean).join(" to ")],
      ["mean speed [mm/s]", number(speed)], [label, number(values)], ["amplitude [mm]", number(amplitude)],
      ...[...new Set([...told, bands ? "" : trouble])].map((text) => ["", text]),
    ];
    tip.replaceChildren(...rows.filter(([, text]) => text).map(([name, text]) =>
      html("div", {}, html("span", {}, name), html("b", {}, text))));
    const area = this.stage.getBoundingClientRect();
    tip.style.left = `min(${pointer.clientX - area.left + 16}px, 100% - ${tip.offsetWidth}px)`;
    tip.style.top = `min(${pointer.clientY - area.top + 12}px, 100% - ${tip.offsetHeight}px)`;
  }
}
