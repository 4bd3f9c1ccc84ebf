"use strict";
/**
 * Scenes as people give them, in the units outside, turned into drives as the solver reads them.
 *
 * @typedef {number | {values: ArrayLike<number>, strides: number[]}} Outside a quantity; an axis has values
 * @typedef {object} Given
 * @property {Record<string, Outside>} values of quantities, by name
 * @property {null | {kind: string, motion?: any}} given of a drive that sliders cannot make
 */

/** @typedef {Record<string, {per_si: number, si: number, default: number | null, low: number, high: number}>} Quantities */

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
  return Float64Array.from({ length: rows * columns }, (_, n) =>
    field.values[Math.floor(n / columns) * down + (n % columns) * across]);
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
 * @returns {import("./engine.js").Drive}
 */
function driveOf({ quantities }, { values, given }) {
  const has = (/** @type {string} */ name) => values[name] !== undefined;
  const si = (/** @type {string} */ name, fallback = 0.0) => (has(name) ? toSi(quantities[name], values[name]) : fallback);
  const usual = (/** @type {string} */ name) => (has(name) ? si(name) : toSi(quantities[name], quantities[name].default ?? 0.0));
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
  const orders = Object.keys(values).filter((name) => /^(along|normal)_(amplitude|phase)/.test(name)).map((name) => Number(/\d+$/.exec(name)?.[0] ?? 1));
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
  return { kind: "ellipse", path: [scaled("along_amplitude"), scaled("normal_amplitude"), si("normal_phase")], ...body };
}

/**
 * Larger semi-axis of an ellipse: it is two opposite rotations, the sum of whose radii this is.
 * @param {number[]} path amplitudes along and normal, and a phase
 */
function reachOf([along, normal, phase]) {
  const sine = normal * Math.sin(phase), cosine = normal * Math.cos(phase);
  return 0.5 * (Math.hypot(along + sine, cosine) + Math.hypot(along - sine, cosine));
}

// ------------------------------------------------------------------------------
// Machines: what they do empty, Eqs. (80) to (85), and where they settle with their filling.

/** @typedef {[number, number]} Complex real and imaginary part */
const plus = (/** @type {Complex} */ [a, b], /** @type {Complex} */ [c, d]) => /** @type {Complex} */ ([a + c, b + d]);
const times = (/** @type {Complex} */ [a, b], /** @type {Complex} */ [c, d]) =>
  /** @type {Complex} */ ([a * c - b * d, a * d + b * c]);
const over = (/** @type {Complex} */ a, /** @type {Complex} */ [c, d]) => {
  const size = Math.hypot(c, d);
  const [x, y] = [c / size, d / size];
  return /** @type {Complex} */ ([(a[0] * x + a[1] * y) / size, (a[1] * x - a[0] * y) / size]);
};
const real = (/** @type {number} */ x) => /** @type {Complex} */ ([x, 0.0]);

/**
 * Motion of the masses over the force, Eqs. (81) to (85), as vibro.machines.machine.transfer solves it.
 * @param {Record<string, any>} machine fields of vibro.Machine
 * @param {number} frequency
 * @param {number} natural
 * @param {Complex} added mass of the filling, with its share
 */
function transferOf(machine, frequency, natural, added) {
  if (machine.kind === "crank") return { trough: real(1.0), relative: real(1.0), compliance: real(0.0) };
  const m1 = machine.trough_mass, r = 1.0 / machine.counter_mass;
  const mu = m1 / (1.0 + m1 * r);
  const w = TURN * frequency, ww = w * w, w0 = TURN * natural;
  const damping = 2.0 * machine.damping_ratio * mu * w0 * w;
  const kappa = /** @type {Complex} */ ([mu * w0 * w0, damping]);
  const g = (machine.base_stiffness * r) / ww;
  const free = 1.0 - g;
  const coupling = plus(times(kappa, real(r)), real(-ww * free)); // dZ/dM
  const detuning = /** @type {Complex} */ ([mu * TURN ** 2 * (natural - frequency) * (natural + frequency), damping]);
  const held = times(real(-g), plus(kappa, real(-m1 * ww)));
  const empty = plus(times(real(1.0 + m1 * r), detuning), held); // Z_0, Eq. (82)
  const mass = plus(real(m1), added);
  const impedance = plus(empty, times(added, coupling));
  const isExciter = machine.kind === "exciter"; // Eq. (83)
  const trough = isExciter ? times(kappa, real(-r / ww)) : real(free);
  const relative = isExciter ? times(mass, real(-r)) : plus(real(free), times(mass, real(r)));
  return { trough: over(trough, impedance), relative: over(relative, impedance), compliance: over(coupling, empty) };
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
  const { OK, AVERAGED } = engine.known.Status;
  const named = (/** @type {string} */ name, fallback = 0.0) =>
    cellsOf(name in values ? toSi(quantities[name], values[name]) : fallback, shape);
  const [f, mass] = [named("frequency"), named("filling")];
  const [setting, voltage, natural] = [named("setting", 1.0), named("voltage", 1.0), named("natural", machine.natural_frequency)];
  const size = f.length;
  const of = (/** @type {(n: number) => number} */ number) => Float64Array.from({ length: size }, (_, n) => number(n));
  const { low: least, high: most } = quantities.amplitude;
  const force = of((n) => machine.force * setting[n] * voltage[n] ** machine.voltage_exponent
    * (f[n] / machine.force_frequency) ** machine.force_exponent); // Eq. (80)
  const still = Array.from(f, (x, n) => transferOf(machine, x, natural[n], real(0.0)));
  const empty = of((n) => force[n] * Math.hypot(...still[n].trough));
  const bounded = of((n) => Number(1000.0 * empty[n] >= least && 1000.0 * empty[n] <= most));
  const share = machine.share ? /** @type {Complex} */ ([machine.share[0], -machine.share[1]]) : null;
  const pulled = (/** @type {number} */ n, /** @type {Complex} */ by) => times(times(real(mass[n]), by), still[n].compliance);
  const found = {
    amplitude: of((n) => empty[n] / Math.hypot(...plus(real(1.0), pulled(n, share ?? real(0.0))))),
    low: new Float64Array(size), high: new Float64Array(size), number: new Float64Array(size).fill(1),
    status: new Float64Array(size).fill(OK), share: of(() => share?.[0] ?? NaN), damping: of(() => -(share?.[1] ?? NaN)),
    second: of((n) => (mass[n] > 0.0 ? NaN : 0.0)), secondImaginary: of((n) => (mass[n] > 0.0 ? NaN : 0.0)),
  };
  for (const end of [found.low, found.high]) end.set(found.amplitude);
  const solvedAt = Float64Array.from(found.amplitude);
  const stiff = of((n) => Number(Math.hypot(...still[n].compliance) === 0.0));
  const full = [...of((n) => n)].filter((n) => mass[n] > 0.0 && bounded[n]);
  const moved = driveOf(data, { values: { ...values, amplitude: 1000.0 }, given: null });
  const body = Object.fromEntries(Object.entries(moved).filter(([, x]) => typeof x !== "string" && !Array.isArray(x)));
  const path = cellsOf(moved.path[1], shape);
  const fields = Object.fromEntries(Object.entries(body).map(([name, x]) => [name, cellsOf(x, shape)]));

  /** Some cells as a grid, at an amplitude for each. @param {number[]} cells @param {(n: number) => number} amplitude */
  function gridOf(cells, amplitude) {
    const few = (/** @type {(n: number) => number} */ number) => ({ values: Float64Array.from(cells, number), strides: [1] });
    const own = Object.fromEntries(Object.entries(fields).map(([name, x]) => [name, few((n) => x[n])]));
    return engine.gridOf({ kind: "line", path: [few(amplitude), few((n) => path[n])], ...own }, [cells.length]);
  }

  // an upper bound of m abs(H) A abs(lambda - i delta) for all amplitudes, Eq. (89)
  const reach = of((n) => {
    const pressed = 2.0 * (Math.sin(path[n]) + fields.staticFriction[n] * Math.cos(path[n])) * Math.cos(fields.troughAngle[n]);
    return mass[n] * Math.hypot(...still[n].compliance) * pressed * (fields.gravity[n] / (TURN * f[n]) ** 2);
  });
  const loose = share ? [] : full.filter((n) => !stiff[n]);
  if (loose.length) {
    const pulls = loose.map((n) => pulled(n, real(1.0)));
    const out = engine.operate(gridOf(loose, () => 1.0), {
      empty: Float64Array.from(loose, (n) => empty[n]),
      pull_real: Float64Array.from(pulls, ([x]) => x),
      pull_imaginary: Float64Array.from(pulls, ([, x]) => x),
    });
    loose.forEach((n, k) => {
      for (const name of /** @type {const} */ (["amplitude", "low", "high", "number", "status"])) found[name][n] = out[name][k];
      solvedAt[n] = out.solved_at[k];
    });
  }
  if (!share && full.length) {
    const grid = gridOf(full, (n) => solvedAt[n]);
    const cycle = engine.solve(grid);
    const weighed = engine.weigh(grid, cycle);
    full.forEach((n, k) => {
      const isKnown = !stiff[n] && found.status[n] !== OK;
      const isNone = Number.isNaN(found.amplitude[n]);
      const late = !isKnown && !stiff[n];
      const status = cycle.status[k];
      if (!isKnown) found.status[n] = status;
      found.share[n] = isNone ? NaN : weighed.added_mass[k];
      found.damping[n] = isNone ? NaN : weighed.added_damping[k];
      found.second[n] = isNone ? NaN : weighed.second_real[k];
      found.secondImaginary[n] = isNone ? NaN : weighed.second_imaginary[k];
      if (late && status === AVERAGED) {
        found.low[n] = Math.max(empty[n] - reach[n], 0.0);
        found.high[n] = empty[n] + reach[n];
      } else if (late && !engine.known.answered.includes(status)) {
        found.amplitude[n] = found.low[n] = found.high[n] = NaN;
        found.number[n] = 0;
      }
    });
  }

  const bend = (/** @type {ReturnType<typeof transferOf>} */ { relative, trough }) => Math.hypot(...over(relative, trough));
  const unsure = of((n) => Number(mass[n] > 0.0 && Number.isNaN(found.share[n]) && !stiff[n] && found.status[n] === AVERAGED));
  const added = (/** @type {number} */ n) =>
    /** @type {Complex} */ ([mass[n] * (found.share[n] || 0.0), -mass[n] * (found.damping[n] || 0.0)]);
  const filled = Array.from(f, (x, n) => transferOf(machine, x, natural[n], mass[n] > 0.0 ? added(n) : real(0.0)));
  const infinite = of((n) => Number(!(bounded[n] || empty[n] < 1.0) || found.amplitude[n] === Infinity));
  const relative = of((n) => {
    if (infinite[n]) return Infinity;
    if (!unsure[n]) return found.amplitude[n] * bend(filled[n]);
    // over the amplitude of the trough it is linear in the added mass, of which Eq. (89) bounds m A abs(z)
    const one = transferOf(machine, f[n], natural[n], real(1.0));
    const more = over(one.relative, one.trough), own = over(still[n].relative, still[n].trough);
    const slope = Math.hypot(more[0] - own[0], more[1] - own[1]);
    return found.high[n] * bend(still[n]) + (slope * reach[n]) / Math.hypot(...still[n].compliance);
  });
  const strikes = of((n) => Number(relative[n] > machine.gap || infinite[n]));
  const isNone = (/** @type {number} */ n) => strikes[n] || Number.isNaN(found.amplitude[n]);
  const twice = Array.from(f, (x, n) => transferOf(machine, 2.0 * x, natural[n], real(0.0)));
  const phasors = Array.from(f, (_, n) => // Eq. (90)
    times(times([found.second[n], found.secondImaginary[n]], real(-0.25 * mass[n])), twice[n].compliance));
  const filledNatural = (/** @type {number} */ n) => {
    const r = 1.0 / machine.counter_mass, m1 = machine.trough_mass, sum = m1 + added(n)[0];
    const ratio = (m1 / sum) * ((1.0 + sum * r) / (1.0 + m1 * r));
    return natural[n] * Math.sqrt(ratio > 0.0 ? ratio : Infinity);
  };
  const isUnknown = (/** @type {number} */ n) => unsure[n] || Number.isNaN(found.amplitude[n]);
  return {
    amplitude: of((n) => (isNone(n) ? NaN : found.amplitude[n])),
    amplitude_low: of((n) => (isNone(n) ? NaN : found.low[n])),
    amplitude_high: of((n) => (isNone(n) ? NaN : found.high[n])),
    amplitude_empty: of((n) => (bounded[n] || empty[n] < 1.0 ? empty[n] : Infinity)),
    number: of((n) => (strikes[n] ? 0 : found.number[n])),
    status: found.status,
    phase: of((n) => (isUnknown(n) ? NaN : Math.atan2(filled[n].trough[1] + 0.0, filled[n].trough[0] + 0.0))),
    frequency_ratio: of((n) => f[n] / natural[n]),
    filled_frequency_ratio: of((n) => (isUnknown(n) ? NaN : f[n] / (mass[n] > 0.0 ? filledNatural(n) : natural[n]))),
    added_mass_share: found.share,
    added_damping_share: found.damping,
    relative_amplitude: relative,
    strikes,
    second_harmonic: of((n) => Math.hypot(...phasors[n])),
    second_real: of((n) => phasors[n][0]),
    second_imaginary: of((n) => phasors[n][1]),
  };
}

if (typeof module !== "undefined") module.exports = { cellsOf, driveOf, operatingOf, reachOf, toSi, changedField, spelledFriction };
