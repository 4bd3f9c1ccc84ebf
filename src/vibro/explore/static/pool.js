/** The solver's workers, and maps that they solve in blocks of rows. */

import { sampleOf } from "./contours.js";

const BLOCK_TIME = 30; // [ms] that a block may take: so long a change waits for workers that are busy
const PATIENCE = 60; // [ms] that a map may take without a coarse one before it
// One core is left to the page; of two none, for the page waits while they solve.
const [FEWEST_WORKERS, MOST_WORKERS] = [2, 8];
const REDRAWN = 250; // [ms] after which a map that takes long is drawn with what is there
const COARSER = 4; // times as wide are the cells of a coarse map
export const [MAP_WIDTH, MAP_HEIGHT] = [200, 150]; // [cells]
export const OF_FLIGHT = ["impact", "flight"]; // views whose numbers depend on the operating point's own friction

/** @typedef {import("./state.js").Shown} Shown @typedef {import("./state.js").Axis} Axis
 * @typedef {{postMessage(message: any): void, onmessage: any, onerror: any}} SolverWorker
 * @typedef {import("./worker.js").MapJob} MapJob @typedef {import("./worker.js").CellRows} CellRows */

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

/** The corners of a box of bands, its centre, and the centres of its faces. @param {Record<string, [number, number]>} bands */
function samplesOf(bands) {
  let samples = /** @type {[string, number][][]} */ ([[]]);
  for (const [name, [low, high]] of Object.entries(bands)) {
    const values = low < high ? [low, high, 0.5 * (low + high)] : [low];
    samples = samples.flatMap((own) => values.map((value) => [...own, /** @type {[string, number]} */ ([name, value])]));
  }
  const between = (/** @type {[string, number][]} */ sample) =>
    sample.filter(([name, value]) => !bands[name].includes(value)).length;
  const most = Math.max(...samples.map(between));
  return samples.filter((own) => [0, most - 1, most].includes(between(own))).map((own) => Object.fromEntries(own));
}

/** Complete a body of the bands: kinetic friction is at most static friction.
 * @param {Shown} state @param {Record<string, number>} own @returns {Record<string, number | undefined>} */
function bodyOf({ values, follows, bands }, own) {
  const most = own.static_friction ?? values.static_friction;
  const isRatio = own.friction_ratio !== undefined || (follows && !bands.kinetic_friction);
  const ratio = own.friction_ratio ?? values.friction_ratio;
  const kinetic = Math.min(most, isRatio ? ratio * most : own.kinetic_friction ?? values.kinetic_friction);
  return { ...own, static_friction: most, kinetic_friction: kinetic, friction_ratio: undefined };
}

/** Of all bodies of the bands that which slips first, and that which slips last. @param {Shown} state */
function extremesOf(state) {
  const all = samplesOf(state.bands).map((own) => bodyOf(state, own));
  const order = (/** @type {any} */ a, /** @type {any} */ b) => a.static_friction - b.static_friction || b.kinetic_friction - a.kinetic_friction;
  const [least, most] = [all.sort(order)[0], all[all.length - 1]];
  return { least, most };
}

/** What decides the cells of a map. @param {Shown} state @param {number} nx @param {number} ny @returns {MapJob} */
export function jobOf(state, nx, ny) {
  const { x, y, bands, given, machine } = state;
  const values = /** @type {Record<string, number | undefined>} */ ({ ...state.values });
  const drawn = [x.name, y.name];
  const isCoupled = state.follows && drawn.includes("static_friction") && !drawn.includes("kinetic_friction");
  const without = ["trough_length", ...drawn, isCoupled || drawn.includes("friction_ratio") ? "kinetic_friction" : "friction_ratio"];
  for (const name of without) delete values[name];
  const samples = Object.keys(bands).length && !OF_FLIGHT.includes(state.view) ? samplesOf(bands) : [];
  const hasFrictions = samples.length > 0 && Object.keys(bands).some((name) => name !== "restitution");
  return {
    values, given,
    machine: machine && { ...machine.fields, kind: machine.kind },
    x: { name: x.name, values: axisValues(x, nx) },
    y: { name: y.name, values: axisValues(y, ny) },
    bodies: samples.map((own) => (hasFrictions ? bodyOf(state, own) : own)),
    edges: hasFrictions ? extremesOf(state) : {},
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

  /** @param {import("./worker.js").RowBlock} block */
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
    const place = (/** @type {number} */ n, /** @type {number} */ to, /** @type {number} */ from) => (n * (from - 1)) / (to - 1);
    for (const [name, values] of Object.entries(this.rows)) {
      const Numbers = /** @type {any} */ (values.constructor);
      const shown = map.rows[name] = new Numbers(map.nx * map.ny);
      const isSmooth = values instanceof Float64Array && /^(ratio|least|most)_/.test(name);
      for (let n = 0; n < shown.length; n++) {
        const [x, y] = [place(n % map.nx, map.nx, this.nx), place(Math.floor(n / map.nx), map.ny, this.ny)];
        shown[n] = isSmooth ? sampleOf(values, this.nx, x, y) : values[Math.round(y) * this.nx + Math.round(x)];
      }
    }
    return map;
  }
}

/** In place of a worker, where a viewer allows none: it solves in the page, between the page's other work. */
class PageWorker {
  /** @param {any} data */
  constructor(data) {
    this.data = data;
    this.engine = engineOf(exports, data.known);
    this.onmessage = /** @type {any} */ (null);
    this.onerror = null;
  }

  /** @param {any} message */
  postMessage({ id, job, begin, end }) {
    setTimeout(() => {
      const began = performance.now();
      const { rows } = solveRows(this.data, this.engine, job, begin, end);
      this.onmessage({ data: { id, begin, end, rows, took: performance.now() - began } });
    });
  }
}

/** Workers of the page's own script; none where a viewer forbids them. @param {any} data @returns {SolverWorker[]} */
export function solverWorkers(data) {
  try {
    const script = new Blob([document.getElementById("solver")?.textContent ?? ""], { type: "text/javascript" });
    const count = Math.min(Math.max((navigator.hardwareConcurrency || 2) - 1, FEWEST_WORKERS), MOST_WORKERS);
    const address = URL.createObjectURL(script);
    return Array.from({ length: count }, () => {
      const worker = new Worker(address);
      worker.postMessage({ data: { known: data.known, quantities: data.quantities } });
      return worker;
    });
  } catch {
    return [];
  }
}

/** @typedef {{id: number, job: MapJob, start: number, low: number, high: number, left: number, take: (block: any) => void, end: (isDone: boolean) => void}} Task */
export class Pool {
  /** @param {any} data @param {SolverWorker[]} workers */
  constructor(data, workers) {
    this.data = data;
    this.pace = 0.01; // [ms] a cell, on one worker
    this.last = 0;
    this.task = /** @type {Task | null} */ (null);
    this.idle = /** @type {SolverWorker[]} */ ([]);
    this.busy = /** @type {Map<SolverWorker, any>} */ (new Map());
    for (const worker of workers.length ? workers : [new PageWorker(data)]) this.hire(worker);
  }

  /** @param {SolverWorker} worker */
  hire(worker) {
    this.idle.push(worker);
    worker.onmessage = (/** @type {any} */ { data }) => this.take(worker, data);
    worker.onerror = () => this.replace(worker);
  }

  /** How long a map may take [ms]. @param {number} cells */
  expected(cells) { return (cells * this.pace) / (this.idle.length + this.busy.size); }

  // Solve a map from a row on, to both sides; true when it is done, false if it is cancelled.
  /** @param {MapJob} job @param {number} row @param {(block: any) => void} take @returns {Promise<boolean>} */
  solve(job, row, take) {
    this.cancel();
    return new Promise((end) => {
      this.task = { id: ++this.last, job, start: row, low: row, high: row, left: job.y.values.length, take, end };
      this.feed();
    });
  }

  /** Give up what is under way; what workers still hand in is dropped. */
  cancel() {
    this.task?.end(false);
    this.task = null;
  }

  feed() {
    while (this.task && this.idle.length) {
      const rows = this.nextRows(this.task);
      if (!rows) return;
      const worker = /** @type {SolverWorker} */ (this.idle.pop());
      const message = { id: this.task.id, job: this.task.job, begin: rows[0], end: rows[1] };
      this.busy.set(worker, message);
      worker.postMessage(message);
    }
  }

  /** Choose rows next to those chosen before, on the side that is nearer to the first. @param {Task} task */
  nextRows(task) {
    const [nx, ny] = [task.job.x.values.length, task.job.y.values.length];
    const open = task.low + ny - task.high;
    if (!open) return null;
    const fair = Math.ceil(open / (this.idle.length + this.busy.size));
    const count = Math.min(fair, Math.max(1, Math.round(BLOCK_TIME / (this.pace * nx))));
    const { start, low, high } = task;
    const isUp = high < ny && (low === 0 || high - start <= start - low);
    if (isUp) task.high = Math.min(ny, high + count);
    else task.low = Math.max(0, low - count);
    return isUp ? [high, task.high] : [task.low, low];
  }

  /** @param {SolverWorker} worker @param {any} block */
  take(worker, block) {
    this.busy.delete(worker);
    this.idle.push(worker);
    const { task } = this;
    const rows = block.end - block.begin;
    if (task && task.id === block.id) {
      this.pace = block.took / (rows * task.job.x.values.length);
      task.left -= rows;
      task.take(block);
      if (!task.left) {
        this.task = null;
        task.end(true);
      }
    }
    this.feed();
  }

  /** Let the page do the work of a worker that a viewer stopped. @param {SolverWorker} worker */
  replace(worker) {
    const message = this.busy.get(worker);
    this.busy.delete(worker);
    this.idle = this.idle.filter((other) => other !== worker);
    const page = new PageWorker(this.data);
    this.hire(page);
    if (message?.id !== this.task?.id) return this.feed();
    this.idle.pop();
    this.busy.set(page, message);
    page.postMessage(message);
  }
}

/** The row that the operating point lies in, or is nearest to. @param {Shown} state @param {number} ny */
function rowOf({ values, y: { name, from, to, log } }, ny) {
  const value = values[name] ?? from;
  const share = log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
  return Math.round((ny - 1) * Math.min(Math.max(share || 0.0, 0.0), 1.0));
}

// Solve a map: at once if that is quick, else a coarse one before it, which fills the rows that are to come.
/** @param {Pool} pool @param {Shown} state @param {(cells: MapCells) => void} show
 * @returns {Promise<boolean>} whether it is done; else another one came between */
export async function solveMap(pool, state, show) {
  const job = jobOf(state, MAP_WIDTH, MAP_HEIGHT);
  let cells = new MapCells(job), shown = -Infinity;
  if (pool.expected(MAP_WIDTH * MAP_HEIGHT * (1 + job.bodies.length)) > PATIENCE) {
    const coarse = new MapCells(jobOf(state, MAP_WIDTH / COARSER, Math.ceil(MAP_HEIGHT / COARSER)));
    if (!await pool.solve(coarse.job, rowOf(state, coarse.ny), (block) => coarse.put(block))) return false;
    cells = coarse.shownIn(job);
    show(cells);
    shown = performance.now();
  }
  const isDone = await pool.solve(job, rowOf(state, cells.ny), (block) => {
    cells.put(block);
    if (cells.isPreviewed && performance.now() - shown > REDRAWN) {
      show(cells);
      shown = performance.now();
    }
  });
  if (isDone) show(cells);
  return isDone;
}
