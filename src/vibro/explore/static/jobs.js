/** What decides the cells of a map, and these cells as far as they are solved. */

import { sampleOf } from "./contours.js";
import { hasRatio } from "./state.js";

export const [MAP_WIDTH, MAP_HEIGHT] = [200, 150]; // [cells]
export const OF_FLIGHT = ["impact", "flight"]; // views whose numbers are those of the operating point's own friction

/** @typedef {import("./state.js").Shown} Shown @typedef {import("./state.js").Axis} Axis */

/** A number as a whole one over a power of ten. @param {number} value @returns {[bigint, number]} */
function decimalOf(value) {
  const [digits, power] = value.toExponential().split("e");
  const [whole, part = ""] = digits.split(".");
  return [BigInt(whole + part), part.length - Number(power)];
}

// The values of an axis: each the double nearest to the exact one, so 0.1 to 0.5 in 5 holds 0.3, not
// 0.30000000000000004. Those of a logarithmic one have 15 digits.
/** @param {Axis} axis @param {number} count */
export function axisValues({ from, to, log }, count) {
  const last = count - 1;
  const inside = (/** @type {(n: number) => number} */ value) =>
    Array.from({ length: count }, (_, n) => (n === 0 ? from : n === last ? to : value(n)));
  if (log) {
    const [low, high] = [Math.log10(from), Math.log10(to)];
    return inside((n) => Number((10.0 ** (low + n * ((high - low) / last))).toPrecision(15)));
  }
  const ends = [decimalOf(from), decimalOf(to)];
  const power = Math.max(0, ...ends.map(([, p]) => p));
  const [a, b] = ends.map(([whole, p]) => whole * 10n ** BigInt(power - p));
  const parts = BigInt(last) * 10n ** BigInt(power);
  return inside((n) => Number(`${((a * BigInt(last - n) + b * BigInt(n)) * 10n ** 40n) / parts}e-40`));
}

/** Where a value lies on an axis, 0 to 1 or beyond. @param {Axis} axis @param {number} value */
export function shareOf({ from, to, log }, value) {
  return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
}

/** The corners of a box of bands, its centre, and the centres of its faces.
 * @param {Record<string, [number, number]>} bands */
function samplesOf(bands) {
  let samples = /** @type {Record<string, number>[]} */ ([{}]);
  for (const [name, [low, high]] of Object.entries(bands)) {
    const values = low < high ? [low, high, 0.5 * (low + high)] : [low];
    samples = samples.flatMap((own) => values.map((value) => ({ ...own, [name]: value })));
  }
  const middles = samples.map((own) =>
    Object.entries(own).filter(([name, value]) => !bands[name].includes(value)).length);
  const most = Math.max(...middles);
  return samples.filter((_, n) => [0, most - 1, most].includes(middles[n]));
}

/** Complete a body of the bands: kinetic friction is at most static friction.
 * @param {Shown} state @param {Record<string, number>} own @returns {Record<string, number | undefined>} */
function bodyOf(state, own) {
  const { static_friction: most, friction_ratio: ratio, kinetic_friction: free } = { ...state.values, ...own };
  const kinetic = Math.min(most, hasRatio(state) ? ratio * most : free);
  return { ...own, static_friction: most, kinetic_friction: kinetic, friction_ratio: undefined };
}

/** Of bodies that which slips first, of least static and most kinetic friction, and that which slips last.
 * @param {Record<string, number | undefined>[]} bodies */
function extremesOf(bodies) {
  const [least, ...others] = [...bodies].sort((a, b) =>
    Number(a.static_friction) - Number(b.static_friction) || Number(b.kinetic_friction) - Number(a.kinetic_friction));
  return { least, most: others.pop() ?? least };
}

/** What decides the cells of a map. @param {Shown} state @param {number} nx @param {number} ny @returns {MapJob} */
export function jobOf(state, nx, ny) {
  const { x, y, bands, given, machine } = state;
  const drawn = [x.name, y.name];
  const isCoupled = state.follows && drawn.includes("static_friction") && !drawn.includes("kinetic_friction");
  const isRatio = isCoupled || drawn.includes("friction_ratio");
  const values = /** @type {Record<string, number | undefined>} */ ({ ...state.values });
  for (const name of [...drawn, "trough_length", isRatio ? "kinetic_friction" : "friction_ratio"]) delete values[name];
  const banded = OF_FLIGHT.includes(state.view) ? [] : Object.keys(bands);
  const hasFrictions = banded.some((name) => name !== "restitution");
  const samples = banded.length ? samplesOf(bands) : [];
  const bodies = samples.map((own) => (hasFrictions ? bodyOf(state, own) : own));
  return {
    values,
    given,
    machine: machine && machine.fields,
    x: { name: x.name, values: axisValues(x, nx) },
    y: { name: y.name, values: axisValues(y, ny) },
    bodies,
    edges: hasFrictions ? extremesOf(bodies) : {},
  };
}

/** The cells of a map, as far as they are solved. */
export class MapCells {
  /** @param {MapJob} job */
  constructor(job) {
    this.job = job;
    this.nx = job.x.values.length;
    this.ny = job.y.values.length;
    this.rows = /** @type {CellRows} */ ({});
    this.solved = new Uint8Array(this.ny);
    this.isPreviewed = false; // whether rows that are not solved show a coarser map
  }

  get isDone() { return this.share === 1.0; }
  get share() { return this.solved.reduce((sum, one) => sum + one, 0) / this.ny; }

  /** @param {RowBlock} block */
  put({ begin, end, rows }) {
    for (const [name, values] of Object.entries(rows)) {
      const Numbers = /** @type {any} */ (values.constructor);
      this.rows[name] ??= new Numbers(this.nx * this.ny);
      this.rows[name].set(values, begin * this.nx);
    }
    this.solved.fill(1, begin, end);
  }

  /** A map of other cells of the same field that shows these until its own are solved. @param {MapJob} job */
  shownIn(job) {
    const map = new MapCells(job);
    map.isPreviewed = true;
    for (let row = 0; row < this.ny; row++) { // those that are not there yet have no numbers
      if (this.solved[row]) continue;
      for (const values of Object.values(this.rows)) {
        values.fill(values instanceof Int8Array ? -1 : NaN, row * this.nx, (row + 1) * this.nx);
      }
    }
    const [across, up] = [[map.nx, this.nx], [map.ny, this.ny]].map(([many, few]) =>
      Float64Array.from({ length: many }, (_, n) => (n * (few - 1)) / (many - 1)));
    const [columns, rows] = [across, up].map((places) => Int32Array.from(places, Math.round));
    for (const [name, values] of Object.entries(this.rows)) {
      const Numbers = /** @type {any} */ (values.constructor);
      const shown = map.rows[name] = new Numbers(map.nx * map.ny);
      const isSmooth = /^(ratio|least|most)_/.test(name); // what curves are drawn of
      for (let j = 0, n = 0; j < map.ny; j++) for (let i = 0; i < map.nx; i++, n++) {
        shown[n] = isSmooth ? sampleOf(values, this.nx, across[i], up[j]) : values[rows[j] * this.nx + columns[i]];
      }
    }
    return map;
  }
}
