/**
 * Motion of one body from rest, exact at any time, as vibro.History and vibro.motion.histories.trace have it.
 *
 * @typedef {import("./engine.js").Drive} Drive
 * @typedef {{kind: string, start: number, end: number, moved: number}} Phase times [s], displacement [m]
 * @typedef {Record<string, Float64Array>} Sample fields of vibro's Sample, in SI units
 * @typedef {object} History
 * @property {any} engine
 * @property {any} grid
 * @property {any} motion legs, the first of those that repeat, their period [drive cycles] and advance [A]
 * @property {number} frequency
 * @property {number} scale A [m]
 * @property {number} end [s]
 * @property {number} startPhase of the trough [rad]
 */

const OFF_JUMP = 1e-9; // [rad] from a jump to the moment whose forces are those on one side of it
const BESIDE = 1e-9; // of the number of steps, or of a drive cycle
const LONGEST_RUN = 1000.0; // [drive cycles] from rest in which phases with flights must begin to repeat
const OPEN_ENDS = 1e-9; // of the largest acceleration: a smaller gap between two pieces is rounding

/**
 * Follow a body from rest; null if its motion cannot be followed.
 * @param {any} engine @param {Drive} drive of plain numbers
 * @param {number} cycles of the drive @param {number} [startPhase] [rad]
 * @returns {History | null}
 */
export function followed(engine, drive, cycles, startPhase = 0.0) {
  const grid = engine.gridOf(drive);
  const [frequency, scale] = [/** @type {number} */ (drive.frequency), engine.scaleOf(drive)];
  const end = cycles / frequency;
  const motion = engine.history(grid, end * frequency, startPhase);
  return motion && { engine, grid, motion, frequency, scale, end, startPhase };
}

/** The leg of the phase with this number, and how often its cycle was completed before. */
function legOf(/** @type {History} */ { motion }, /** @type {number} */ place) {
  const { first, number } = motion;
  const size = Math.max(number - first, 1);
  return place < first ? { row: place, count: 0 }
    : { row: first + ((place - first) % size), count: Math.floor((place - first) / size) };
}

/** When the phase with this number begins [s]; Infinity after the last. */
function startOf(/** @type {History} */ history, /** @type {number} */ place) {
  const { motion: { legs, number, period }, frequency } = history;
  const { row, count } = legOf(history, place);
  if (row >= number) return Infinity;
  return (legs.cycle[row] + period * count + (legs.phase[row] - legs.phase[0]) / TURN) / frequency;
}

/** The number of the phase at a time; where one ends there, that one, or with `isAfter` the next. */
function placeOf(/** @type {History} */ history, /** @type {number} */ time, isAfter = true) {
  const hasBegun = (/** @type {number} */ place) =>
    isAfter ? startOf(history, place) <= time : startOf(history, place) < time;
  let [low, high] = [0, 1];
  while (hasBegun(high)) [low, high] = [high, 2 * high];
  while (high - low > 1) {
    const middle = Math.floor((low + high) / 2);
    if (hasBegun(middle)) low = middle;
    else high = middle;
  }
  return low;
}

/** Shares of the period at which the trough's acceleration jumps. @param {Drive} drive */
function jumpsOf({ motion }) {
  if (!motion) return [];
  const { breaks, pieces, unit } = motion;
  const count = breaks.length - 1;
  const from = (/** @type {number} */ at) => pieces[4 * at];
  const to = (/** @type {number} */ at) => pieces[4 * at] + pieces[4 * at + 1] + pieces[4 * at + 2] + pieces[4 * at + 3];
  const gap = (/** @type {number} */ way, /** @type {number} */ n) =>
    Math.abs(from(way * count + n) - to(way * count + (n + count - 1) % count));
  return [...breaks.slice(0, -1)].filter((_, n) => Math.max(gap(0, n), gap(1, n)) > OPEN_ENDS * unit);
}

/**
 * Motion and forces at times.
 * @param {History} history @param {ArrayLike<number>} times [s]
 * @param {(n: number) => boolean} [isAfter] of which side of an event each is
 * @returns {Sample}
 */
export function sampled(history, times, isAfter = () => true) {
  const { engine, grid, motion: { legs, advance }, frequency, scale } = history;
  const { drive } = grid;
  const speed = scale * TURN * frequency;
  const force = speed * TURN * frequency;
  const at = Array.from(times, (time, n) => {
    const place = placeOf(history, time, isAfter(n));
    const { row, count } = legOf(history, place);
    const since = TURN * frequency * (time - startOf(history, place));
    const isOver = time >= startOf(history, place + 1);
    return { row, count, since: isOver ? legs.length[row] : Math.min(Math.max(since, 0.0), legs.length[row]) };
  });
  const rows = at.map(({ row }) => row);
  const found = engine.moments(grid, legs, rows, at.map(({ since }) => since));
  let forces = found;
  if (jumpsOf(drive).length) { // rounding decides on which side of a jump a time lies: look beside it
    const beside = at.map(({ row, since }, n) =>
      Math.min(Math.max(since + (isAfter(n) ? OFF_JUMP : -OFF_JUMP), 0.0), legs.length[row]));
    forces = engine.moments(grid, legs, rows, beside);
  }
  const each = (/** @type {(n: number) => number} */ of) => Float64Array.from(at, (_, n) => of(n));
  const isLine = drive.kind === "line";
  const flies = (/** @type {number} */ n) => engine.known.LETTERS[legs.mode[rows[n]]] === "H";
  return {
    time: Float64Array.from(times),
    trough_displacement: each((n) => (isLine ? scale * found.sine[n] : NaN)),
    trough_along: each((n) => scale * found.trough_along[n]),
    trough_normal: each((n) => scale * found.trough_normal[n]),
    position: each((n) => scale * (legs.position[rows[n]] + at[n].count * advance + found.path[n])),
    velocity: each((n) => speed * found.velocity[n]),
    acceleration: each((n) => force * forces.acceleration[n]),
    inertial: each((n) => force * forces.inertial[n]),
    friction: each((n) => (flies(n) ? 0.0 : force * (forces.acceleration[n] - forces.inertial[n]))),
    normal: each((n) => force * forces.normal[n]),
    static_limit: each((n) => drive.staticFriction * force * forces.normal[n]),
    gap: each((n) => scale * found.gap[n]),
  };
}

/** All phases until the end. @param {History} history @returns {Phase[]} */
export function phasesOf(history) {
  const { engine, motion: { legs, advance }, scale, end } = history;
  const last = placeOf(history, end, false);
  const positions = Array.from({ length: last + 1 }, (_, place) => {
    const { row, count } = legOf(history, place);
    return scale * (legs.position[row] + count * advance);
  });
  positions.push(sampled(history, [end], () => false).position[0]);
  return positions.slice(0, -1).map((position, place) => ({
    kind: engine.known.LETTERS[legs.mode[legOf(history, place).row]],
    start: startOf(history, place),
    end: place < last ? startOf(history, place + 1) : end,
    moved: positions[place + 1] - position,
  }));
}

/**
 * Sample a history at even steps and on both sides of every event, and of every jump of the trough's acceleration.
 * @param {History} history @param {number} samples a drive cycle
 * @returns {Sample}
 */
export function traced(history, samples) {
  const { grid: { drive }, frequency, end, startPhase } = history;
  const begins = phasesOf(history).map(({ start }) => start).filter((start) => 0.0 < start && start < end);
  const turns = startPhase / TURN;
  const jumps = Array.from({ length: Math.ceil(end * frequency) + 1 }, (_, cycle) =>
    jumpsOf(drive).map((share) => (cycle + Math.floor(turns) + share - turns) / frequency)).flat();
  // where a phase begins at a jump, both times may differ by rounding: they are one event
  const alone = jumps.filter((jump) => 0.0 < jump && jump < end
    && !begins.some((start) => Math.abs(start - jump) <= BESIDE / frequency));
  const events = new Set([...begins, ...alone, end]);
  const rate = samples * frequency;
  const even = Array.from({ length: Math.ceil(rate * end * (1.0 - BESIDE)) }, (_, n) => n / rate);
  const times = [...new Set([...even, ...events])].sort((a, b) => a - b);
  const rows = times.flatMap((time) => [
    ...(events.has(time) ? [{ time, isAfter: false }] : []),
    ...(time < end ? [{ time, isAfter: true }] : []),
  ]);
  return sampled(history, rows.map(({ time }) => time), (n) => rows[n].isAfter);
}

/**
 * The steady cycle as a history, and the time since the trough's middle at which it begins; null if there is none.
 * @param {{engine: any, grid: any, drive: any, cycle: Record<string, Float64Array>, pattern: string}} solved
 * @returns {{history: History, lag: number} | null}
 */
export function steadyHistory({ engine, grid, drive, cycle, pattern }) {
  const { frequency, kind, path } = drive;
  const isOneHarmonic = kind === "line" || kind === "ellipse";
  const hops = cycle.regime[0] === engine.known.Regime.HOPPING;
  if (pattern === "_" || (isOneHarmonic && !hops)) { // its first slide begins at rest, at a known phase
    const phase = pattern === "_" ? 0.0 : engine.slides(grid, cycle.pattern_code[0]).begin[0];
    const history = followed(engine, drive, 1.0, phase);
    return history && { history, lag: phase / (TURN * frequency) };
  }
  const motion = engine.history(grid, LONGEST_RUN);
  const number = motion ? motion.number - motion.first : 0;
  if (!number) return null;
  const turn = isOneHarmonic ? 0 : engine.leastTurn([...motion.legs.mode.slice(motion.first)]);
  const order = Array.from({ length: number }, (_, n) => (n + turn) % number);
  const legs = Object.fromEntries(Object.keys(motion.legs).map((name) =>
    [name, Float64Array.from(order, (n) => motion.legs[name][motion.first + n])]));
  order.forEach((from, n) => { // what was before the first leg comes a cycle later
    if (from >= turn) return;
    legs.cycle[n] += motion.period;
    legs.position[n] += motion.advance;
  });
  for (const name of ["cycle", "position"]) legs[name] = legs[name].map((x) => x - legs[name][0]);
  const lead = kind === "ellipse" ? path[2] : 0.0; // phases count from the middle of the motion along the trough
  const phase = (((legs.phase[0] - lead) % TURN) + TURN) % TURN;
  const steady = { legs, number, first: 0, period: motion.period, advance: motion.advance };
  const history = {
    engine, grid, motion: steady, frequency, scale: engine.scaleOf(drive), end: motion.period / frequency,
    startPhase: phase,
  };
  return { history, lag: phase / (TURN * frequency) };
}
