/** The motion of the operating point from rest: panels of curves over time, and the part on its trough. */

import {
  INK, axis, curve, html, input, legend, numberText, place, plot, set, shape, svg, textWidth, way,
} from "./draw.js";
import { roundNumbers } from "./scales.js";
import { followed, phasesOf, sampled, traced } from "./histories.js";
import { pointOf } from "./numbers.js";

const SAMPLES = 100; // a drive cycle, beside every event
const SHOWN = ["trough", "forces", "velocity", "position"]; // panels; the gap of bodies that leave the trough
const EDGE = 0.06; // of a panel, above and below its curves
const STRETCH = 1.5; // the load may stretch the panel of forces to so many times what friction needs
const NOT_FOLLOWED = "No motion to follow: the scene's loads or frictions are too extreme.";

/**
 * @typedef {{label: string, colour: string, dash: number[], width: number, values: Float64Array}} Line
 * @typedef {{name: string, title: string, height: number, low: number, high: number, curves: Line[]}} Panel
 * @typedef {object} Motion
 * @property {import("./histories.js").History} history
 * @property {import("./histories.js").Sample} rows over time
 * @property {{name: string, colour: string, start: number, end: number}[]} phases [s]
 * @property {Panel[]} panels
 */

/**
 * What the panels show; null where there is no motion to follow.
 * @param {any} data @param {any} engine @param {any} state
 * @returns {Motion | null}
 */
export function motionOf(data, engine, state) {
  const { looks } = data;
  const { drive } = pointOf(data, engine, state);
  const history = followed(engine, drive, state.cycles);
  if (!history) return null;
  const phases = phasesOf(history).map(({ kind, start, end }) => ({ ...looks.phases[kind], start, end }));
  const rows = traced(history, SAMPLES);
  const isLine = !Number.isNaN(rows.trough_displacement[0]);
  const flies = rows.gap.some((gap) => gap > 0.0);
  const names = [...SHOWN, ...(flies ? ["gap"] : [])];
  const panels = names.map((name) =>
    panelOf(name, looks.panels[name === "trough" && !isLine ? "ellipse" : name], rows));
  return { history, rows, phases, panels };
}

/** Curves of a panel in its unit, and the ends of its axis.
 * @param {string} name @param {any} look @param {import("./histories.js").Sample} rows @returns {Panel} */
function panelOf(name, { title, unit, per_si: unitSize, height, curves }, rows) {
  const most = name === "forces" ? mostForce(rows) : Infinity;
  const lines = curves.flatMap((/** @type {any} */ { field, in_contact: isInContact, label, ...look }) => {
    const values = rows[field].map((x, n) => (isInContact && !(rows.normal[n] > 0.0) ? NaN : x * unitSize));
    const isCut = values.some((x) => Math.abs(x) > most);
    const line = { ...look, values, label: curves.length > 1 ? label + (isCut ? " (cut off)" : "") : "" };
    if (field !== "static_limit") return [line];
    return [line, { ...line, values: values.map((x) => -x), label: "" }]; // it holds either way
  });
  let [low, high] = [0.0, 0.0];
  for (const { values } of lines) {
    for (const x of values) if (!Number.isNaN(x)) [low, high] = [Math.min(low, x), Math.max(high, x)];
  }
  [low, high] = [Math.max(low, -most), Math.min(high, most)];
  const margin = EDGE * (high - low || 1.0);
  return { name, title: `${title} [${unit}]`, height, low: low - margin, high: high + margin, curves: lines };
}

/** Where bodies hop, the load is often ten times as large as any friction, whose curve would be flat. */
function mostForce(/** @type {Record<string, Float64Array>} */ { static_limit: limits, friction }) {
  const largest = limits.reduce((most, x, n) => Math.max(most, x, Math.abs(friction[n])), 0.0);
  return STRETCH * largest || Infinity;
}

// ------------------------------------------------------------------------------
// Panels.

const UNIT = 88; // [px] of a panel whose height is 1
const [LEFT, RIGHT] = [58, 16]; // [px] beside the panels

/** Round numbers on an axis, by their shares of it. @param {number} low @param {number} high */
const evenTicks = (low, high, most = 8) => roundNumbers(low, high, false, most).map((x) =>
  /** @type {[number, string]} */ ([(x - low) / (high - low), numberText(x)]));

/** What fills the box of a panel. @param {Panel} panel @param {Box} box @param {Motion} motion */
function drawPanel({ low, high, curves }, box, { history: { end }, rows: { time }, phases }) {
  const share = (/** @type {number} */ value) => (value - low) / (high - low);
  const shades = phases.map(({ colour, start, end: until }) => svg("rect", {
    x: (1000 * start) / end, width: (1000 * (until - start)) / end, height: 1000, fill: colour, "fill-opacity": 0.35,
  }));
  const zero = curve(way(2, (n) => [n, share(0)]), { colour: INK, width: 0.7, dash: [] });
  const lines = curves.map((line) => curve(way(time.length, (n) => [time[n] / end, share(line.values[n])]), line));
  const paper = svg("rect", { width: 1000, height: 1000, fill: "#FFFFFF" });
  return [plot(box, {}, paper, ...shades, zero, ...lines), axis(box, "left", evenTicks(low, high, 4))];
}

/** All panels over one axis of time, and a line at the moment of the animation.
 * @param {Motion} motion @param {string} title */
function drawPanels(motion, title) {
  const { history: { end }, phases, panels } = motion;
  const wide = Math.max(place("history").clientWidth, LEFT + RIGHT); // 0 before the page is laid out
  const box = { left: LEFT, top: 0, width: wide - LEFT - RIGHT, height: 0 };
  const picture = svg("svg", { role: "img", "aria-label": title, "font-size": 12 });
  for (const { name, start, end: until } of phases) {
    if (textWidth(name) > (box.width * (until - start)) / end - 4) continue;
    const x = LEFT + (box.width * (start + until)) / (2 * end);
    picture.append(svg("text", { x, y: 12, "text-anchor": "middle", fill: "currentColor" }, name));
  }
  for (const panel of panels) {
    const samples = panel.curves.filter((line) => line.label)
      .map((line) => ({ text: line.label, sample: [curve("M0 7H24", line)] }));
    const names = legend(samples, LEFT, box.top + 42, box.width);
    picture.append(svg("text", { x: LEFT, y: box.top + 34, "font-weight": 600, fill: "currentColor" }, panel.title));
    box.top += 42 + names.height;
    box.height = UNIT * panel.height;
    picture.append(names.group, ...drawPanel(panel, box, motion));
    box.top += box.height - 10;
  }
  picture.append(axis({ ...box, height: 10 }, "below", evenTicks(0.0, 1e3 * end), "time [ms]"));
  const now = svg("path", { id: "now", d: `M0 18V${box.top + 10}`, stroke: "#808080", "stroke-dasharray": "3 3" });
  picture.append(now);
  set(picture, { width: wide, height: box.top + 54 });
  const move = (/** @type {number} */ share) => set(now, { transform: `translate(${LEFT + box.width * share} 0)` });
  return { picture, move };
}

// ------------------------------------------------------------------------------
// The part on its trough, slowed down.

const [WIDE, HIGH, PART, TOP, FLOOR] = [720, 150, [56, 32], 12, 112]; // [px]
const STRIPE = 36; // [px] between marks on the trough
const ARROW = 90; // [px] of the largest force
const LASTS = 2.0; // [s] that a drive cycle takes on the screen

/** Set the stage for a motion; what is returned shows its moments.
 * @param {Motion} motion @param {any} looks @param {number} slope of the trough [deg] */
function createStage({ history, rows, panels }, looks, slope) {
  const range = (/** @type {Float64Array} */ x, /** @type {Float64Array} */ y) => x.reduce((ends, _, n) =>
    [Math.min(ends[0], x[n] + y[n]), Math.max(ends[1], x[n] + y[n])], [Infinity, -Infinity]);
  const [left, right] = range(rows.position, rows.trough_along);
  const [low, high] = range(rows.gap, rows.trough_normal);
  const across = (WIDE - 2 * PART[0]) / Math.max(right - left, 1e-12);
  const scale = Math.min(across, (FLOOR - TOP - PART[1]) / Math.max(high - low, 1e-12));
  const middle = WIDE / 2 - (scale * (left + right)) / 2;
  const ground = FLOOR + scale * low;
  const forces = panels.find(({ name }) => name === "forces");
  const most = forces ? Math.max(-forces.low, forces.high) : 1.0;

  const stripes = Array.from({ length: Math.ceil((3 * WIDE) / STRIPE) }, (_, n) => `M${n * STRIPE - WIDE} 3l-6 9`);
  const marks = stripes.join("");
  const trough = svg("g", {},
    svg("path", { d: `M${-WIDE} 0H${2 * WIDE}`, stroke: "currentColor", "stroke-width": 3 }),
    svg("path", { d: marks, stroke: "currentColor" }));
  const [long, tall] = PART;
  const body = svg("rect", { x: -long / 2, y: -tall, width: long, height: tall, rx: 4, stroke: "currentColor" });
  /** @type {any[]} */
  const shown = looks.panels.forces.curves.filter((/** @type {any} */ { field }) => field !== "static_limit");
  const arrows = shown.map(({ field, colour }, n) => {
    const arrow = svg("path", { stroke: colour, fill: colour, "stroke-width": 2.5 });
    return { field, up: (-tall * (n + 1)) / (shown.length + 1), arrow };
  });
  const part = svg("g", {}, body, ...arrows.map(({ arrow }) => arrow));
  const rest = svg("path", { d: `M${-WIDE} ${ground}H${2 * WIDE}`, stroke: "currentColor", "stroke-dasharray": "2 6" });
  const tilted = svg("g", { transform: `rotate(${-slope} ${WIDE / 2} ${FLOOR})` }, rest, trough, part);
  const rise = (WIDE / 2 - PART[0]) * Math.abs(Math.sin((slope * Math.PI) / 180.0));
  set(shape("animation"), { viewBox: `0 ${-rise} ${WIDE} ${HIGH + 2 * rise}` }).replaceChildren(tilted);

  /** Show a moment [s]. @param {number} at @param {string} colour of its phase */
  return (at, colour) => {
    const now = sampled(history, [at]);
    const [x, y] = [scale * now.trough_along[0], scale * now.trough_normal[0]];
    const far = middle + x + scale * now.position[0];
    set(trough, { transform: `translate(${middle + x} ${ground - y})` });
    set(part, { transform: `translate(${far} ${ground - y - scale * now.gap[0]})` });
    set(body, { fill: colour });
    for (const { field, up, arrow } of arrows) {
      const reach = ARROW * Math.max(-1.0, Math.min(now[field][0] / most, 1.0));
      const head = Math.sign(reach) * Math.min(7, Math.abs(reach));
      set(arrow, { d: Math.abs(reach) < 1 ? "" : `M0 ${up}h${reach}l${-head} -4v8l${head} -4` });
    }
  };
}

const A_BIT = 0.05; // of a drive cycle, by which people move on who want no motion

/** What plays: the share of the motion that is shown, how long all of it takes [s], and how many cycles it has. */
const film = { share: 0.0, lasts: 1.0, cycles: 1, show: (/** @type {number} */ _) => {}, last: 0.0, frame: 0 };
const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

function moveOn(/** @type {number} */ share) {
  film.share = (film.share + share) % 1.0;
  film.show(film.share);
}

function playOn(/** @type {number} */ now) {
  moveOn(Math.min(Math.max(now - film.last, 0.0), 100.0) / (1e3 * film.lasts));
  film.last = now;
  film.frame = requestAnimationFrame(playOn);
}

/** Go on, or stand still. */
function play(/** @type {boolean} */ isPlaying) {
  cancelAnimationFrame(film.frame);
  film.last = performance.now();
  film.frame = isPlaying ? requestAnimationFrame(playOn) : 0;
  place("play").textContent = isPlaying ? "Pause" : isCalm() ? "Step" : "Play";
}

/** Let the slider and the button move the animation. It stands still until somebody starts it. */
function startFilm() {
  const slider = input("moment");
  slider.oninput = () => {
    play(false);
    film.show((film.share = Number(slider.value)));
  };
  place("play").onclick = () => (isCalm() ? moveOn(A_BIT / film.cycles) : play(!film.frame));
  if (!film.frame) play(false);
}

/**
 * Draw the panels, and the part on its trough.
 * @param {any} data @param {any} engine @param {any} state
 */
export function drawMotion(data, engine, state) {
  const motion = motionOf(data, engine, state);
  if (!motion) {
    play(false);
    shape("animation").replaceChildren();
    place("history").replaceChildren(html("p", {}, NOT_FOLLOWED));
    return;
  }
  const { history: { end }, phases } = motion;
  const { picture, move } = drawPanels(motion, `first ${state.cycles} drive cycles from rest`);
  const stage = createStage(motion, data.looks, state.values.trough_angle ?? 0.0);
  Object.assign(film, { lasts: LASTS * state.cycles, cycles: state.cycles });
  set(place("play"), { title: `${numberText((LASTS * state.cycles) / end, 2)} times slower` });
  film.show = (share) => {
    const at = share * end;
    const phase = phases.find(({ end: until }) => at < until) ?? phases[phases.length - 1];
    const text = `${numberText(1e3 * at, 3)} ms, ${phase.name}`;
    stage(at, phase.colour);
    move(share);
    place("when").textContent = text;
    set(input("moment"), { "aria-valuetext": text }).value = String(share);
  };
  startFilm();
  place("history").replaceChildren(picture);
  film.show(film.share);
}
