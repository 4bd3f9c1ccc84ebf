"use strict";
/**
 * Blocks of rows of a map. A worker answers each message with one; without workers the page calls `solveRows`.
 *
 * @typedef {{name: string, values: number[]}} AxisValues in the unit outside, ascending
 * @typedef {object} MapJob what decides the cells of a map
 * @property {Record<string, number | undefined>} values of all other quantities, in the units outside
 * @property {AxisValues} x along rows
 * @property {AxisValues} y from row to row
 * @property {any} given drive of a scene that sliders cannot make, or null
 * @property {any} machine from which amplitudes follow, or null
 * @property {Record<string, number | undefined>[]} bodies of the bands, by the quantities in which they differ
 * @property {Record<string, Record<string, number | undefined>>} edges bodies whose critical loads are drawn
 *
 * @typedef {Record<string, Float64Array | Int8Array>} CellRows results by name, row after row
 * @typedef {object} RowBlock
 * @property {number} begin its first row
 * @property {number} end the row after its last
 * @property {CellRows} rows
 */

const CELL_CODES = ["regime", "status", "coexists", "model_code"]; // results that are small whole numbers
const OF_MACHINES = [ // results of operating points
  "amplitude", "frequency_ratio", "amplitude_empty", "added_mass_share", "added_damping_share", "relative_amplitude",
  "second_harmonic", "uncertain",
];
const LOG_RATIOS = ["hop", "forward_onset", "back_slip", "continuous_sliding"];

/**
 * Solve some rows of a map: results by the names of vibro.SteadyCycle, and of ln(G / G_critical) as `ratio_...`.
 * @param {any} data of the page
 * @param {any} engine
 * @param {MapJob} job
 * @param {number} begin
 * @param {number} end
 * @returns {RowBlock}
 */
function solveRows(data, engine, job, begin, end) {
  const shape = [end - begin, job.x.values.length];
  const axes = {
    [job.y.name]: { values: job.y.values.slice(begin, end), strides: [1, 0] },
    [job.x.name]: { values: job.x.values, strides: [0, 1] },
  };
  const solved = (/** @type {Record<string, any>} */ own) =>
    solveCells(data, engine, job, { ...job.values, ...axes, ...own }, shape);
  const { drive, cells, operating } = solved({});
  const rows = /** @type {CellRows} */ ({});
  for (const [name, x] of Object.entries(cells)) rows[name] = CELL_CODES.includes(name) ? new Int8Array(x) : x;
  if (operating) for (const name of OF_MACHINES) rows[name] = operating[name];
  Object.assign(rows, logRatiosOf(engine, drive, shape, "ratio"));
  for (const [edge, own] of Object.entries(job.edges)) {
    const values = { ...job.values, ...axes, ...own, ...(operating && { amplitude: 1.0 }) };
    Object.assign(rows, logRatiosOf(engine, driveOf(data, { values, given: job.given }), shape, edge));
  }
  if (job.bodies.length) Object.assign(rows, leastOf(job.bodies.map((own) => solved(own).cells)));
  return { begin, end, rows };
}

/**
 * @param {any} data @param {any} engine @param {MapJob} job
 * @param {Record<string, any>} values @param {number[]} shape
 */
function solveCells(data, engine, { given, machine }, values, shape) {
  const operating = machine ? operatingOf(data, engine, { values, machine, given: null }, shape) : null;
  if (operating) { // any amplitude, where there is none: those results are withheld
    const found = operating.amplitude.map((x) => (Number.isNaN(x) ? 1.0 : 1000.0 * x));
    values = { ...values, amplitude: { values: found, strides: [shape[1], 1] } };
  }
  const drive = driveOf(data, { values, given });
  const grid = engine.gridOf(drive, shape);
  const cells = engine.solve(grid);
  if (operating) withhold(cells, operating, engine.known);
  return { drive, grid, cells, operating };
}

/**
 * Let no cell be surer than its operating point, as vibro.sweeps.machines.withheld does.
 * @param {Record<string, Float64Array>} cells
 * @param {Record<string, Float64Array>} operating
 * @param {any} known
 */
function withhold(cells, operating, known) {
  const { OK, BOUNDARY, INFEASIBLE, AVERAGED } = known.Status;
  const isAnswered = (/** @type {number} */ status) => known.answered.includes(status);
  const nothing = /** @type {Record<string, number>} */ ({ regime: -1, coexists: -1, pattern_code: 0, model_code: 0 });
  for (let n = 0; n < cells.status.length; n++) {
    const [own, point] = [cells.status[n], operating.status[n]];
    if (Number.isNaN(operating.amplitude[n])) {
      if (own === INFEASIBLE) continue;
      for (const [name, x] of Object.entries(cells)) x[n] = nothing[name] ?? NaN;
      cells.status[n] = isAnswered(point) ? INFEASIBLE : point; // the masses strike
    } else if (point === AVERAGED && isAnswered(own)) { // the amplitude is known to an interval
      if (own !== AVERAGED) cells.mean_velocity_error[n] = NaN;
      cells.status[n] = AVERAGED;
    } else if (point === BOUNDARY && own === OK) cells.status[n] = BOUNDARY;
  }
}

/**
 * ln(G / G_critical) of each cell: positive where a motion has begun. None of drives beyond one harmonic.
 * @param {any} engine @param {any} drive @param {number[]} shape @param {string} prefix of the names
 * @returns {CellRows}
 */
function logRatiosOf(engine, drive, [many, few], prefix) {
  if (drive.kind !== "line" && drive.kind !== "ellipse") return {};
  // Critical loads depend on proportions, angles and frictions alone: they are found once where axes change none.
  const isLine = drive.kind === "line";
  const path = isLine ? [1.0, drive.path[1]] : drive.path;
  const bare = { ...drive, path, frequency: 1.0, gravity: 1.0, restitution: 0.0 };
  const fields = [...path, drive.staticFriction, drive.kineticFriction, drive.troughAngle];
  const [rows, columns] = [many, few].map((n, axis) => (fields.some((x) => x.strides?.[axis]) ? n : 1));
  const limits = engine.limits(engine.gridOf(bare, [rows, columns]));
  const critical = LOG_RATIOS.map((name) => limits[name].map(Math.log));
  const found = LOG_RATIOS.map(() => new Float64Array(many * few));
  const all = [...drive.path, drive.frequency, drive.gravity].map((x) => cellsOf(x, [many, few]));
  const [first, second, third] = all, [frequency, gravity] = all.slice(-2);
  for (let n = 0; n < many * few; n++) {
    const reach = isLine ? first[n] : reachOf([first[n], second[n], third[n]]);
    const turn = TURN * frequency[n];
    const load = Math.log((reach * turn * turn) / gravity[n]);
    const k = (rows > 1 ? Math.floor(n / few) : 0) * columns + (columns > 1 ? n % few : 0);
    for (let m = 0; m < found.length; m++) found[m][n] = load - critical[m][k];
  }
  return Object.fromEntries(LOG_RATIOS.map((name, m) => [`${prefix}_${name}`, found[m]]));
}

/**
 * Of several bodies the least speed, unknown where any is, and the lowest and the highest regime.
 * @param {Record<string, Float64Array>[]} bodies their cells
 */
function leastOf(bodies) {
  const of = (/** @type {string} */ name, /** @type {(...x: number[]) => number} */ pick) =>
    bodies[0][name].map((_, n) => pick(...bodies.map((cells) => cells[name][n])));
  return {
    sampled_velocity: of("mean_velocity", Math.min),
    lowest: Int8Array.from(of("regime", Math.min)),
    highest: Int8Array.from(of("regime", Math.max)),
  };
}

/** In a worker: take what all blocks need, then answer each message with a block of rows. */
function answerBlocks() {
  let data = /** @type {any} */ (null), engine = /** @type {any} */ (null);
  self.onmessage = ({ data: message }) => {
    if (message.data) {
      data = message.data;
      engine = engineOf(exports, data.known);
      return;
    }
    const began = performance.now();
    const { begin, end, rows } = solveRows(data, engine, message.job, message.begin, message.end);
    const block = { id: message.id, begin, end, rows, took: performance.now() - began };
    /** @type {any} */ (self).postMessage(block, Object.values(rows).map((x) => x.buffer));
  };
}

// Not in the page or in node.
if (typeof document === "undefined" && typeof importScripts === "function") answerBlocks();
