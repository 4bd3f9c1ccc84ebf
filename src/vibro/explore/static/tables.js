/** The cells of a map as a table, with the columns of `vibro map`. */

import { spansOf } from "./state.js";

export const KNOBS_OF_MACHINES = ["setting", "voltage", "filling", "natural"];
const WITHOUT_COLUMN = ["gravity", "trough_length"]; // among the inputs
const WHERE_SWEPT = [...KNOBS_OF_MACHINES, "friction_ratio", "normal_acceleration", "restitution"]; // have one

/** @typedef {import("./jobs.js").MapCells} MapCells @typedef {import("./state.js").Shown} Shown
 * @typedef {(n: number) => number | string} CellOf what a cell has in a column, by its place
 * @typedef {[name: string, of: CellOf]} TableColumn
 * @typedef {{data: any, engine: any, state: Shown, cells: MapCells}} Tabled */

/** Legs of a cell's cycle as text. @param {Tabled} tabled @param {number} n */
function patternText({ data, engine, cells: { rows, nx, job } }, n) {
  const text = engine.spelt(rows.pattern_code[n]);
  if (text !== null) return text;
  const own = { [job.y.name]: job.y.values[Math.floor(n / nx)], [job.x.name]: job.x.values[n % nx] };
  const one = solveCells(data, engine, job, { ...job.values, ...own }, [1]);
  return engine.pattern(one.grid, one.cells);
}

/** A quantity of a cell's scene, in the unit outside. @param {MapCells} cells @param {string} name @param {number} n
 * @returns {number} */
export function quantityAt(cells, name, n) {
  const { rows, nx, job } = cells;
  if (name === job.x.name) return job.x.values[n % nx];
  if (name === job.y.name) return job.y.values[Math.floor(n / nx)];
  if (name === "amplitude" && rows.amplitude) return 1000.0 * rows.amplitude[n];
  const value = job.values[name];
  if (value !== undefined || name !== "kinetic_friction") return value ?? NaN;
  return spelledFriction(quantityAt(cells, "friction_ratio", n), quantityAt(cells, "static_friction", n));
}

/** Columns of quantities. @param {Tabled} tabled @param {string[]} names @returns {TableColumn[]} */
function quantityColumns({ data: { quantities }, cells }, names) {
  return names.map((name) => [quantities[name].column, (n) => quantityAt(cells, name, n)]);
}

/** The column of a result.
 * @param {Tabled} tabled @param {{name: string, column: string, per_si: number, texts: string[] | null}} result
 * @returns {TableColumn} */
function resultColumn(tabled, { name, column, per_si: perSi, texts }) {
  const own = tabled.cells.rows[name];
  if (name === "pattern_code") return [column, (n) => patternText(tabled, n)];
  if (texts) return [column, (n) => texts[own[n] < 0 ? texts.length - 1 : own[n]]];
  return [column, (n) => (perSi === 1.0 ? own[n] : own[n] * perSi)];
}

/** Columns of a map with bands: of which bodies it is, and what its samples do.
 * @param {Tabled} tabled @returns {TableColumn[]} */
function sampledColumns(tabled) {
  const { data, state, cells: { rows, job } } = tabled;
  const spans = spansOf({ ...job.values, trough_length: state.values.trough_length }, state);
  const given = Object.entries(data.quantities).flatMap(([name, { column, control }]) => {
    const isOfCell = [job.x.name, job.y.name].includes(name) || (name === "amplitude" && job.machine !== null);
    if (isOfCell) return quantityColumns(tabled, [name]);
    if (!spans[name] || !control || name === "gravity") return [];
    const [low, high] = spans[name];
    const ends = name in state.bands ? { [`${column}_low`]: low, [`${column}_high`]: high } : { [column]: low };
    return Object.entries(ends).map(([key, end]) => /** @type {TableColumn} */ ([key, () => end]));
  });
  const label = (/** @type {number} */ code) =>
    data.regimes.find((/** @type {any} */ regime) => regime.code === code)?.label ?? "";
  return [
    ...given,
    ["lowest_regime", (n) => label(rows.lowest[n])], ["highest_regime", (n) => label(rows.highest[n])],
    ["sampled_speed_mm_s", (n) => 1000.0 * rows.sampled_velocity[n]],
  ];
}

/** All columns of a map, in the order of `vibro map`. @param {Tabled} tabled @returns {TableColumn[]} */
function tableColumns(tabled) {
  const { data: { quantities, columns }, state, cells: { rows, job } } = tabled;
  const drawn = [job.x.name, job.y.name];
  if (job.bodies.length) return sampledColumns(tabled);
  const isGiven = (/** @type {string} */ name) =>
    name in job.values || name === "kinetic_friction" || (name === "amplitude" && job.machine !== null);
  const inputs = Object.keys(quantities).filter((name) => quantities[name].control && !WITHOUT_COLUMN.includes(name))
    .filter((name) => drawn.includes(name) || (isGiven(name) && !WHERE_SWEPT.includes(name)));
  const length = state.values.trough_length;
  const hops = !("normal_acceleration" in job.values) && !drawn.includes("restitution");
  const traverse = (/** @type {number} */ speed) => (speed > 0.0 ? length / 1000.0 / speed : NaN);
  /** Columns that stand before those of results. @type {Record<string, TableColumn[]>} */
  const before = {
    throw_number: [["traverse_time_s", (n) => traverse(rows.mean_velocity[n])]],
    flight_fraction: quantityColumns(tabled, hops ? ["restitution"] : []),
    model_code: [],
  };
  if (length !== undefined) before.flight_fraction.push([quantities.trough_length.column, () => length]);
  if (job.machine) {
    before.model_code.push(...quantityColumns(tabled, KNOBS_OF_MACHINES.filter((name) => !drawn.includes(name))));
    before.model_code.push(...columns.machine.map((/** @type {any} */ result) => resultColumn(tabled, result)));
  }
  const results = columns.cycle.flatMap((/** @type {any} */ result) =>
    [...(before[result.name] ?? []), resultColumn(tabled, result)]);
  return [...quantityColumns(tabled, inputs), ...results];
}

/** The cells of a map as CSV, in the order of `vibro map`; with a decimal comma cells are parted by semicolons.
 * @param {any} data @param {any} engine @param {Shown} state @param {MapCells} cells @param {boolean} [hasComma] */
export function csvOf(data, engine, state, cells, hasComma = false) {
  const columns = tableColumns({ data, engine, state, cells });
  const names = Object.keys(data.quantities);
  const isTurned = names.indexOf(state.x.name) < names.indexOf(state.y.name); // columns vary slowest
  const text = (/** @type {number | string} */ value) => {
    if (typeof value === "string") return value;
    if (!Number.isFinite(value)) return "";
    return hasComma ? String(value).replace(".", ",") : String(value);
  };
  const lines = [columns.map(([name]) => name)];
  for (let k = 0; k < cells.nx * cells.ny; k++) {
    const n = isTurned ? (k % cells.ny) * cells.nx + Math.floor(k / cells.ny) : k;
    lines.push(columns.map(([, of]) => text(of(n))));
  }
  return lines.map((line) => `${line.join(hasComma ? ";" : ",")}\n`).join("");
}
