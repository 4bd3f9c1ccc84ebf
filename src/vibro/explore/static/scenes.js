"use strict";
/**
 * Scenes as people give them, in the units outside, turned into drives as the solver reads them.
 *
 * @typedef {number | {values: ArrayLike<number>, strides: number[]}} Outside a quantity; an axis has values
 * @typedef {object} Given
 * @property {Record<string, Outside>} values of quantities, by name
 * @property {null | {kind: string, motion?: any}} given of a drive that sliders cannot make
 */

/** @typedef {{per_si: number, si: number, default: number | null, low: number, high: number}} SceneQuantity
 * @typedef {Record<string, SceneQuantity>} Quantities */

/**
 * Change every number of a field, or of two that vary differently.
 * @param {(x: number, y: number) => number} change
 * @param {Outside} first
 * @param {Outside} [second]
 * @returns {any}
 */
function changedField(change, first, second = 0.0) {
  if (typeof first === "number" && typeof second === "number") return change(first, second);
  if (typeof first === "number") return changedField((y, x) => change(x, y), second, first);
  const { values, strides } = first;
  if (typeof second === "number") return { values: Float64Array.from(values, (x) => change(x, second)), strides };
  if (strides.every((step, axis) => step === second.strides[axis])) {
    return { values: Float64Array.from(values, (x, n) => change(x, second.values[n])), strides };
  }
  // along different axes of a map
  const [rows, columns] = strides[0] ? [first, second] : [second, first];
  const shape = [rows.values.length, columns.values.length];
  const others = cellsOf(second, shape);
  return { values: cellsOf(first, shape).map((x, n) => change(x, others[n])), strides: [shape[1], 1] };
}

/**
 * One value for each cell of a grid.
 * @param {any} field
 * @param {number[]} shape
 */
function cellsOf(field, [rows, columns = 1]) {
  if (typeof field === "number") return new Float64Array(rows * columns).fill(field);
  const [down, across = 0] = field.strides;
  const cells = new Float64Array(rows * columns);
  for (let row = 0, n = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++, n++) cells[n] = field.values[row * down + column * across];
  }
  return cells;
}

/**
 * Convert to SI units and radians, as vibro.units.Kind does.
 * @param {{per_si: number, si: number}} quantity
 * @param {Outside} value
 */
function toSi({ per_si, si }, value) {
  if (si !== 1.0) return changedField((x) => x * si, value);
  return per_si === 1.0 ? value : changedField((x) => x / per_si, value);
}

/**
 * Kinetic friction by its ratio to static friction, spelled as a person would: 0.8 of 0.2 is 0.16.
 * @param {number} ratio
 * @param {number} most
 */
function spelledFriction(ratio, most) {
  if (ratio === 1.0) return most;
  const product = ratio * most;
  const spelled = Number(product.toPrecision(15));
  const spacing = 2 ** (Math.floor(Math.log2(Math.abs(product))) - 52);
  const close = Math.abs(spelled - product) <= spacing ? spelled : product;
  return ratio < 1.0 ? Math.min(close, most) : close;
}

/**
 * The drive of a scene, or of all cells of a map.
 * @param {{quantities: Quantities}} data
 * @param {Given} scene
 * @returns {Drive}
 */
function driveOf({ quantities }, { values, given }) {
  const has = (/** @type {string} */ name) => values[name] !== undefined;
  const si = (/** @type {string} */ name, fallback = 0.0) =>
    (has(name) ? toSi(quantities[name], values[name]) : fallback);
  const usual = (/** @type {string} */ name) => si(name, toSi(quantities[name], quantities[name].default ?? 0.0));
  const kinetic = () => changedField(spelledFriction, values.friction_ratio, values.static_friction);
  const body = {
    frequency: si("frequency"),
    staticFriction: si("static_friction"),
    kineticFriction: has("kinetic_friction") ? si("kinetic_friction") : kinetic(),
    troughAngle: usual("trough_angle"),
    gravity: usual("gravity"),
    restitution: usual("restitution"),
  };
  const moved = [usual("motion_scale"), si("normal_acceleration", NaN)];
  if (given?.kind === "pieces") return { kind: "pieces", path: moved, ...body, motion: given.motion };
  if (has("amplitude")) return { kind: "line", path: [si("amplitude"), si("drive_angle")], ...body };
  const orders = Object.keys(values).filter((name) => /^(along|normal)_(amplitude|phase)/.test(name))
    .map((name) => Number(/\d+$/.exec(name)?.[0] ?? 1));
  if (has("along_phase") || has("normal_acceleration") || Math.max(...orders) > 1) {
    const isThere = (/** @type {string} */ name) => typeof values[name] === "object" || Number(values[name]) !== 0.0;
    const named = (/** @type {string} */ of, /** @type {number} */ n) => (n === 1 ? of : `${of}_${n}`);
    const sizes = ["along_amplitude", "normal_amplitude"];
    const count = Math.max(1, ...orders.filter((n) => sizes.some((of) => has(named(of, n)) && isThere(named(of, n)))));
    const columns = ["along_amplitude", "along_phase", "normal_amplitude", "normal_phase"].map((of) =>
      Array.from({ length: count }, (_, n) => si(named(of, n + 1))));
    return { kind: "harmonics", path: moved, ...body, harmonics: columns };
  }
  const scale = values.motion_scale ?? 1.0;
  const scaled = (/** @type {string} */ name) => changedField((size, by) => by * size, si(name), scale);
  const path = [scaled("along_amplitude"), scaled("normal_amplitude"), si("normal_phase")];
  return { kind: "ellipse", path, ...body };
}

/**
 * Larger semi-axis of an ellipse: it is two opposite rotations, the sum of whose radii this is.
 * @param {number[]} path amplitudes along and normal, and a phase
 */
function reachOf([along, normal, phase]) {
  const sine = normal * Math.sin(phase), cosine = normal * Math.cos(phase);
  return 0.5 * (Math.hypot(along + sine, cosine) + Math.hypot(along - sine, cosine));
}

/**
 * Where a machine settles with its filling, as vibro.operate finds it.
 * @param {{quantities: Quantities}} data
 * @param {any} engine
 * @param {Given & {machine: Record<string, any>}} scene without an amplitude
 * @param {number[]} [shape] of the grid
 * @returns {Record<string, Float64Array>} by the names of vibro.OperatingPoints, in SI units; no amplitude is NaN
 */
function operatingOf(data, engine, { values, machine }, shape = [1]) {
  const { quantities } = data;
  const named = (/** @type {string} */ name, fallback = 0.0) =>
    cellsOf(name in values ? toSi(quantities[name], values[name]) : fallback, shape);
  const frequency = named("frequency"), setting = named("setting", 1.0), voltage = named("voltage", 1.0);
  const natural = named("natural", machine.natural_frequency), filling = named("filling");
  const force = frequency.map((f, n) => machine.force * setting[n] * voltage[n] ** machine.voltage_exponent
    * (f / machine.force_frequency) ** machine.force_exponent); // Eq. (80)
  const { low, high } = quantities.amplitude;
  const [share, damping] = machine.share ?? [NaN, NaN];
  const springs = {
    ...machine, pushes_counter_mass: machine.kind === "exciter", narrowest: low / 1000.0, widest: high / 1000.0,
  };
  const drive = driveOf(data, { values: { ...values, amplitude: 1000.0 }, given: null });
  const found = engine.operate(engine.gridOf(drive, shape), springs, {
    force, natural_frequency: natural, filling,
    added_mass_share: cellsOf(share, shape), added_damping_share: cellsOf(damping, shape),
  });
  return {
    ...found,
    frequency_ratio: frequency.map((f, n) => f / natural[n]),
    second_harmonic: found.second_real.map((/** @type {number} */ x, /** @type {number} */ n) =>
      Math.hypot(x, found.second_imaginary[n])),
  };
}
