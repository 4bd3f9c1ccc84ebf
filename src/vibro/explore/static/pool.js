/** The solver's workers, and maps that they solve in blocks of rows. */

import { MAP_HEIGHT, MAP_WIDTH, MapCells, jobOf, shareOf } from "./jobs.js";

const BLOCK_TIME = 30; // [ms] that a block may take: so long a change waits for workers that are busy
const SLOW = 0.1; // [ms] a cell, until one of its kind was solved: a block of a whole map would be waited for
const LEAST_TIME = 8; // [ms] of a block: less is not worth its messages
const PATIENCE = 60; // [ms] that a map may take without a coarse one before it
// One core is left to the page; of two none, for the page waits while they solve.
const [FEWEST_WORKERS, MOST_WORKERS] = [2, 8];
const REDRAWN = 400; // [ms] after which a map that takes long is drawn with what is there
const COARSER = 4; // times as wide are the cells of a coarse map

/** @typedef {import("./state.js").Shown} Shown
 * @typedef {{postMessage(message: any): void, onmessage: any, onerror: any}} SolverWorker */

/** In place of a worker, where a viewer allows none: it solves in the page, between the page's other work. */
class PageWorker {
  /** @param {any} data */
  constructor(data) {
    this.data = data;
    this.engine = engineOf(exports, data.known);
    this.onmessage = /** @type {any} */ (null);
    this.onerror = /** @type {(() => void) | null} */ (null);
  }

  /** @param {any} message */
  postMessage({ id, job, begin, end }) {
    setTimeout(() => {
      const began = performance.now();
      try {
        const { rows } = solveRows(this.data, this.engine, job, begin, end);
        this.onmessage({ data: { id, begin, end, rows, took: performance.now() - began } });
      } catch (error) {
        console.error(error);
        this.onerror?.();
      }
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

/** What decides how long a cell takes: of bodies that bounce a hundred times as long. @param {MapJob} job */
const kindOf = ({ values, given, machine, bodies }) =>
  [values.restitution === 0.0, given !== null, machine !== null, bodies.length].join();

/** @typedef {object} Task a map that is being solved
 * @property {number} id
 * @property {MapJob} job
 * @property {number} start the row at which it begins
 * @property {number} low rows from here ...
 * @property {number} high ... up to here are asked for
 * @property {number} left rows that are not there yet
 * @property {(block: any) => void} take
 * @property {(isDone: boolean) => void} end */

/** Workers, each with at most one block of one map. */
export class Pool {
  /** @param {any} data @param {SolverWorker[]} workers */
  constructor(data, workers) {
    this.data = data;
    this.paces = /** @type {Record<string, number>} */ ({}); // [ms] a cell, on one worker, by kinds of maps
    this.last = 0; // number of the last map
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

  /** How long a cell may take [ms]. @param {MapJob} job */
  paceOf(job) { return this.paces[kindOf(job)] ?? SLOW; }

  /** How long a map may take [ms]. @param {MapJob} job */
  expected(job) {
    return (job.x.values.length * job.y.values.length * this.paceOf(job)) / (this.idle.length + this.busy.size);
  }

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
    const within = (/** @type {number} */ time) => Math.max(1, Math.round(time / (this.paceOf(task.job) * nx)));
    const count = Math.max(Math.min(fair, within(BLOCK_TIME)), within(LEAST_TIME));
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
      const pace = this.paceOf(task.job);
      this.paces[kindOf(task.job)] = 0.5 * (pace + block.took / (rows * task.job.x.values.length));
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
    if (worker instanceof PageWorker) return this.cancel(); // it is the scene that cannot be solved
    if (!message || message.id !== this.task?.id) return this.feed();
    this.idle.pop();
    this.busy.set(page, message);
    page.postMessage(message);
  }
}

/** The row that the operating point lies in, or is nearest to. @param {Shown} state @param {number} ny */
function rowOf({ values, y }, ny) {
  const share = shareOf(y, values[y.name]) || 0.0; // none where an axis has no such value
  return Math.round((ny - 1) * Math.min(Math.max(share, 0.0), 1.0));
}

// Solve a map: at once if that is quick, else a coarse one before it, which fills the rows that are to come.
/** @param {Pool} pool @param {Shown} state @param {(cells: MapCells) => void} show
 * @returns {Promise<boolean>} whether it is done; else another one came between */
export async function solveMap(pool, state, show) {
  const job = jobOf(state, MAP_WIDTH, MAP_HEIGHT);
  let cells = new MapCells(job), shown = performance.now();
  const showAll = () => {
    show(cells);
    shown = performance.now();
  };
  const isLate = () => performance.now() - shown > REDRAWN;
  if (pool.expected(job) > PATIENCE) {
    const coarse = new MapCells(jobOf(state, MAP_WIDTH / COARSER, Math.ceil(MAP_HEIGHT / COARSER)));
    const isThere = await pool.solve(coarse.job, rowOf(state, coarse.ny), (block) => {
      coarse.put(block);
      if (!coarse.isDone && !isLate()) return;
      cells = coarse.shownIn(job);
      showAll();
    });
    if (!isThere) return false;
  }
  const isDone = await pool.solve(job, rowOf(state, cells.ny), (block) => {
    cells.put(block);
    if (cells.isPreviewed && isLate()) showAll();
  });
  if (isDone) show(cells);
  return isDone;
}
