/** What can be taken along: pictures of the map, its cells, a scene file, a command line. */

import { INK, fontFamily, place, set, svg } from "./draw.js";
import { MAP_HEIGHT, MAP_WIDTH, jobOf } from "./pool.js";
import { typedText } from "./typed.js";

const COPIED = 2000; // [ms] that a button says so
const SAVED = "scene.toml"; // as the page calls it
const MACHINE_NAMES = ["setting", "voltage", "filling", "natural"];
const EXACT = 2 ** 53; // codes of patterns from here on are not

/** @typedef {import("./map.js").MapView} MapView @typedef {import("./pool.js").MapCells} MapCells
 * @typedef {import("./state.js").Shown} Shown */

// ------------------------------------------------------------------------------
// The map as a table.

/** Legs of a cell's cycle as text. @param {any} data @param {any} engine @param {MapCells} cells @param {number} n */
function patternText(data, engine, { rows, nx, job }, n) {
  const { PATTERNS, SPELT_PATTERNS, LETTERS, IRREGULAR } = data.known;
  const code = rows.pattern_code[n];
  if (code === IRREGULAR) return "H...";
  if (code >= 0 && code < SPELT_PATTERNS) return PATTERNS[code];
  let digits = code - SPELT_PATTERNS, letters = "";
  if (digits < 0 || digits >= EXACT) {
    const own = { [job.y.name]: job.y.values[Math.floor(n / nx)], [job.x.name]: job.x.values[n % nx] };
    const one = solveCells(data, engine, job, { ...job.values, ...own }, [1]);
    return engine.pattern(one.grid, one.cells);
  }
  for (; digits > 0; digits = Math.floor(digits / 5)) letters = LETTERS[digits % 5] + letters;
  return letters;
}

/** A value of a cell's scene, in the unit outside. @param {MapCells} cells @param {string} name @param {number} n @returns {number} */
function givenValue({ rows, nx, job }, name, n) {
  if (name === job.x.name) return job.x.values[n % nx];
  if (name === job.y.name) return job.y.values[Math.floor(n / nx)];
  if (name === "amplitude" && rows.amplitude) return 1000.0 * rows.amplitude[n];
  const value = job.values[name];
  if (value !== undefined || name !== "kinetic_friction") return value ?? NaN;
  const [cells, ratio] = [/** @type {MapCells} */ ({ rows, nx, job }), "friction_ratio"];
  return spelledFriction(givenValue(cells, ratio, n), givenValue(cells, "static_friction", n));
}

/** The columns of a map's table, those of `vibro map`: their names, and the number or text of a cell.
 * @param {any} data @param {any} engine @param {Shown} state @param {MapCells} cells
 * @returns {[string, (n: number) => number | string][]} */
function tableColumns(data, engine, state, cells) {
  const { rows, job } = cells, { quantities } = data;
  const drawn = [job.x.name, job.y.name];
  const given = (/** @type {string} */ name) =>
    /** @type {[string, (n: number) => number]} */ ([quantities[name].column, (n) => givenValue(cells, name, n)]);
  if (job.bodies.length) {
    const label = (/** @type {string} */ name) => (/** @type {number} */ n) => data.regimes.find((/** @type {any} */ one) => one.code === rows[name][n])?.label ?? "";
    return [...drawn.map(given), ["lowest_regime", label("lowest")], ["highest_regime", label("highest")],
      ["sampled_speed_mm_s", (n) => 1000.0 * rows.least_velocity[n]]];
  }
  const whereSwept = [...MACHINE_NAMES, "friction_ratio", "normal_acceleration", "restitution"];
  const inputs = Object.keys(quantities).filter((name) => quantities[name].control && !["gravity", "trough_length"].includes(name)
    && (drawn.includes(name) || (!whereSwept.includes(name) && (name in job.values || ["kinetic_friction", rows.amplitude && "amplitude"].includes(name)))));
  const length = state.values.trough_length;
  const madeWith = "normal_acceleration" in job.values || drawn.includes("restitution") ? [] : [given("restitution")];
  const traverse = (/** @type {number} */ n) => (rows.mean_velocity[n] > 0.0 ? length / 1000.0 / rows.mean_velocity[n] : NaN);
  const results = data.columns.flatMap((/** @type {any} */ { name, column, per_si: perSi, texts }) => {
    const own = rows[name];
    const text = (/** @type {number} */ n) => (texts ? texts[own[n] < 0 ? texts.length - 1 : own[n]] : perSi === 1.0 ? own[n] : own[n] * perSi);
    const found = [[column, name === "pattern_code" ? (/** @type {number} */ n) => patternText(data, engine, cells, n) : text]];
    if (name === "peak_velocity") found.push(["traverse_time_s", traverse]);
    if (name === "flight_fraction") found.unshift(...madeWith, ...(length === undefined ? [] : [[quantities.trough_length.column, () => length]]));
    if (name === "model_code" && job.machine) found.unshift(...MACHINE_NAMES.filter((knob) => knob in job.values).map(given));
    return found;
  });
  return [...inputs.map(given), ...results];
}

/** The cells of a map as CSV, in the order of `vibro map`; with a decimal comma cells are parted by semicolons.
 * @param {any} data @param {any} engine @param {Shown} state @param {MapCells} cells @param {boolean} [hasComma] */
export function csvOf(data, engine, state, cells, hasComma = false) {
  const columns = tableColumns(data, engine, state, cells);
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

// ------------------------------------------------------------------------------
// The same map by vibro itself.

/** Quantities of the map without their usual values, as they are typed: ranges with counts. @param {any} data @param {Shown} state
 * @returns {Record<string, string>} */
function givenTexts({ quantities }, state) {
  const { values: fixed } = jobOf(state, 2, 2), { trough_length: length } = state.values;
  const given = /** @type {Record<string, string>} */ ({});
  for (const [name, value] of Object.entries(fixed)) {
    if (value !== undefined && quantities[name]?.control && value !== quantities[name].default) given[name] = typedText(value);
  }
  for (const [axis, count] of /** @type {[Shown["x"], number][]} */ ([[state.x, MAP_WIDTH], [state.y, MAP_HEIGHT]])) {
    given[axis.name] = `${typedText(axis.from)}:${typedText(axis.to)}:${count}${axis.log ? ":log" : ""}`;
  }
  if (length !== undefined) given.trough_length = typedText(length);
  return Object.fromEntries(Object.keys(quantities).filter((name) => name in given).map((name) => [name, given[name]]));
}

/** A word of a command line as a shell takes it, as Python's shlex quotes. @param {string} word */
function shellWord(word) {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`;
}

/** The command line that makes the same map, of the same cells. @param {any} data @param {Shown} state */
export function commandOf(data, state) {
  const isGiven = Boolean(state.given || state.machine);
  const options = isGiven ? [] : Object.entries(givenTexts(data, state)).flatMap(([name, text]) => {
    const option = data.quantities[name].options;
    return option.startsWith("-") ? [option, text] : [`${option}=${text}`];
  });
  const name = data.scenes[state.scene].name || "map";
  return [
    "vibro", "map", ...(isGiven ? [SAVED] : options), "--x", state.x.name, "--y", state.y.name,
    ...(["impact", "flight"].includes(state.view) ? ["--show", state.view] : []),
    ...(state.target === null ? [] : ["--speed", typedText(state.target)]), "-o", `out/${name}`,
  ].map(shellWord).join(" ");
}

/** Lists of amplitudes and phases in place of single harmonics, where a direction has more than an ellipse has.
 * @param {any} data @param {Record<string, number>} values @returns {[Record<string, number[]>, Record<string, number>]} */
function harmonicLists({ quantities }, values) {
  const others = { ...values }, lists = /** @type {Record<string, number[]>} */ ({});
  for (const way of ["along", "normal"]) {
    if (!Object.keys(values).some((name) => name.startsWith(way) && /(^along_phase|_\d+)$/.test(name))) continue;
    for (const first of [`${way}_amplitude`, `${way}_phase`]) {
      const orders = Object.keys(values).filter((name) => name.startsWith(first)).map((name) => Number(/\d+$/.exec(name) ?? 1));
      const names = Array.from({ length: Math.max(1, ...orders) }, (_, n) => (n ? `${first}_${n + 1}` : first));
      lists[quantities[first].column.replace(first, `${first}s`)] = names.map((name) => others[name] ?? 0.0);
      for (const name of names) delete others[name];
    }
  }
  return [lists, others];
}

/** The scene file that makes the same map, of the same cells. @param {any} data @param {Shown} state */
export function tomlOf(data, state) {
  const { quantities } = data, { given, machine } = state;
  const { friction_ratio: _, ...point } = state.values;
  if (given?.table.length) for (const name of Object.keys(given.values)) delete point[name]; // [motion] gives them
  const column = (/** @type {string} */ name) => quantities[name].column;
  const [lists, others] = given ? harmonicLists(data, point) : [{}, point];
  const names = Object.keys(quantities).filter((name) => name in others && !MACHINE_NAMES.includes(name));
  const moved = MACHINE_NAMES.filter((name) => machine && name in point && point[name] !== machine.own[name]);
  // Another spring pack stands with the axes: a machine's own may be the one that it was calibrated with.
  const swept = Object.entries(givenTexts(data, state)).filter(([name, text]) =>
    text.includes(":") || name === "friction_ratio" || (name === "natural" && moved.includes(name)));
  const knobs = Object.fromEntries(moved.filter((name) => name !== "natural").map((name) => [column(name), typedText(point[name])]));
  const table = (/** @type {string} */ name, /** @type {string[]} */ lines) => (lines.length ? [`[${name}]`, ...lines, ""] : []);
  return [
    "[scene]",
    ...Object.entries(lists).map(([key, values]) => `${key} = [${values.map(typedText).join(", ")}]`),
    ...names.map((name) => `${column(name)} = ${typedText(others[name])}`), "",
    ...table("motion", given?.table ?? []),
    ...table("machine", Object.entries({ ...machine?.table, ...knobs }).map(([key, text]) => `${key} = ${text}`)),
    "[map]", ...swept.map(([name, text]) => `${column(name)} = ${text.includes(":") ? `"${text}"` : text}`), "",
  ].join("\n");
}

// ------------------------------------------------------------------------------
// Downloads and copies.

const nameOf = (/** @type {MapView} */ { drawn }) => `vibro-${drawn?.view}`;

/** @param {string} text @param {string} [where] */
function tell(text, where = "says") {
  place(where).textContent = text;
}

/** The map as it is seen, dark on white, with its canvas as an image inside. @param {MapView} view */
function figure({ svg: seen, canvas, box: { left, top, width, height } }) {
  const whole = /** @type {SVGElement} */ (seen.cloneNode(true));
  whole.querySelectorAll("#surface, .reach, .focus").forEach((part) => part.remove());
  const image = svg("image", { x: left, y: top, width, height, href: canvas.toDataURL(), preserveAspectRatio: "none" });
  whole.prepend(svg("rect", { width: "100%", height: "100%", fill: "#FFFFFF" }), image);
  set(whole, { color: INK, "font-family": fontFamily() });
  return new Blob([new XMLSerializer().serializeToString(whole)], { type: "image/svg+xml" });
}

/** @param {Blob | null} blob @param {string} name */
function save(blob, name) {
  if (!blob) return;
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(blob), name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** @param {MapView} view */
async function savePng(view) {
  const image = new Image();
  image.src = URL.createObjectURL(figure(view));
  await image.decode();
  URL.revokeObjectURL(image.src);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * image.width, 2 * image.height];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => save(blob, `${nameOf(view)}.png`));
}

/** Save the cells of the map, for which to be solved may take long, and say so. @param {MapView} view @param {boolean} hasComma */
async function saveCsv(view, hasComma) {
  tell("computing the CSV …", "saving");
  const isDone = await view.solving;
  const { cells, data, state } = view;
  if (isDone && cells && state) {
    const engine = engineOf(exports, data.known);
    save(new Blob([csvOf(data, engine, state, cells, hasComma)], { type: "text/csv" }), "vibro-map.csv");
  }
  tell(isDone ? "" : "There is no CSV, for the map was changed: ask again.", "saving");
}

/** Copy a text, and say so, on its button too for a while. @param {string} id */
async function copy(id) {
  getSelection()?.selectAllChildren(place(id)); // to be copied by hand where that is refused
  const label = place(`copy-${id}`);
  try {
    await navigator.clipboard.writeText(place(id).textContent ?? "");
    tell("copied");
    label.textContent = "Copied";
    setTimeout(() => (label.textContent = "Copy"), COPIED);
  } catch {
    tell("selected");
  }
}

/** @param {MapView} view */
export function offerFiles(view) {
  const acts = {
    csv: () => saveCsv(view, false), "csv-comma": () => saveCsv(view, true),
    png: () => savePng(view), svg: () => save(figure(view), `${nameOf(view)}.svg`),
    "save-toml": () => save(new Blob([place("toml").textContent ?? ""]), SAVED),
    "copy-command": () => copy("command"), "copy-toml": () => copy("toml"),
  };
  for (const [id, act] of Object.entries(acts)) place(id).addEventListener("click", () => void act());
}
