/**
 * Motion of one body from rest, exact at any time, as vibro.History and vibro.motion.histories.trace have it.
 *
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

const BESIDE = 1e-9; // of the number of steps, or of a drive cycle
const LONGEST_RUN = 1000.0; // [drive cycles] from rest in which phases with flights must begin to repeat

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

/**
 * Motion and forces at times.
 * @param {History} history @param {ArrayLike<number>} times [s]
 * @param {(n: number) => boolean} [isAfter] of which side of an event each is
 * @returns {Sample}
 */
export const sampled = ({ engine, grid, motion }, times, isAfter) => engine.sample(grid, motion, times, isAfter);

/** All phases until the end. @param {History} history @returns {Phase[]} */
export function phasesOf(history) {
  const { engine, motion, scale, end } = history;
  const { number, row, start, position } = engine.phases(motion, end);
  const last = sampled(history, [end], () => false).position[0];
  return Array.from({ length: number }, (_, n) => {
    const isLast = n === number - 1;
    const moved = (isLast ? last : scale * position[n + 1]) - scale * position[n];
    const kind = engine.known.LETTERS[motion.legs.mode[row[n]]];
    return { kind, start: start[n], end: isLast ? end : start[n + 1], moved };
  });
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
    (drive.motion?.jumps ?? []).map((/** @type {number} */ share) =>
      (cycle + Math.floor(turns) + share - turns) / frequency)).flat();
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
  const steady = motion && engine.steady(motion, !isOneHarmonic);
  if (!steady) return null;
  const lead = kind === "ellipse" ? path[2] : 0.0; // phases count from the middle of the motion along the trough
  const phase = (((steady.legs.phase[0] - lead) % TURN) + TURN) % TURN;
  const history = {
    engine, grid, motion: steady, frequency, scale: engine.scaleOf(drive), end: motion.period / frequency,
    startPhase: phase,
  };
  return { history, lag: phase / (TURN * frequency) };
}
