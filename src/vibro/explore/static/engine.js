"use strict";
/**
 * The solver with scenes as plain objects. Runs in the page, in its workers, and in node.
 *
 * A drive gives its fields in SI units and radians. Each is a number, or has values that differ from cell to
 * cell of the grid: along each axis, rows first, it goes on by so many values; by 0 where one serves all.
 *
 * @typedef {number | {values: ArrayLike<number>, strides: number[]}} Field
 * @typedef {object} Drive
 * @property {"line" | "ellipse" | "harmonics" | "pieces"} kind
 * @property {Field[]} path amplitude and drive angle; amplitudes along and normal, and a phase; else the scale
 *   of the motion and the normal force over the mass of a clamped part, NaN of a free one
 * @property {Field} frequency
 * @property {Field} staticFriction
 * @property {Field} kineticFriction
 * @property {Field} troughAngle
 * @property {Field} gravity
 * @property {Field} restitution
 * @property {Field[][]} [harmonics] amplitudes along, their phases, amplitudes normal, their phases
 * @property {{breaks: number[], pieces: number[], unit: number, jumps: number[]}} [motion] of pieces, as
 *   PiecewiseMotion has them
 *
 * @typedef {Record<string, Float64Array>} Rows
 */

const TURN = 2.0 * Math.PI;

/**
 * @param {Record<string, any>} doors of the solver
 * @param {Record<string, any>} known its constants and codes
 */
function engineOf(doors, known) {
  const KINDS = { line: known.LINE, ellipse: known.ELLIPSE, harmonics: known.HARMONICS, pieces: known.PIECES };
  const MOST_LEGS = 2 ** 20;
  const OFF_JUMP = 1e-9; // [rad] from a jump to the moment whose forces are those on one side of it

  /** @param {readonly string[]} names @param {number} size @returns {Rows} */
  const rows = (names, size) => Object.fromEntries(names.map((name) => [name, new Float64Array(size)]));
  /** @param {string} door @param {number} argument @returns {string[]} */
  const fields = (door, argument) => doors[door].takes[argument];
  const flights = rows(fields("solve_hops", 4), known.MOST_BOUNCES + known.LONGEST_CYCLE);
  const hops = rows(fields("solve_hops", 5), known.BODIES * known.MOST_HOPS);

  /**
   * Scenes as the solver reads them.
   * @param {Drive} drive
   * @param {number[]} shape of the grid; [1] of one scene
   */
  function gridOf(drive, shape = [1]) {
    const [first, second, third = 0.0] = drive.path;
    const { frequency, staticFriction, kineticFriction, troughAngle, gravity, restitution } = drive;
    const own = [first, second, third, frequency, staticFriction, kineticFriction, troughAngle, gravity, restitution];
    const further = (drive.harmonics ?? []).flat();
    const all = [...own, ...further];
    const values = all.map((x) => Float64Array.from(typeof x === "number" ? [x] : x.values));
    const strides = shape.flatMap((_, axis) => all.map((x) => (typeof x === "number" ? 0 : x.strides[axis])));
    const starts = [0];
    for (const x of values.slice(known.FIELDS)) starts.push(starts[starts.length - 1] + x.length);
    const motion = drive.motion ?? { breaks: [0.0], pieces: [0.0], unit: 0.0 };
    const count = drive.kind === "pieces" ? motion.breaks.length - 1 : further.length / 4;
    const scenes = {
      ...Object.fromEntries(fields("solve_contact", 0).slice(0, known.FIELDS).map((name, i) => [name, values[i]])),
      harmonics: Float64Array.from(values.slice(known.FIELDS).flatMap((x) => [...x])),
      starts: Float64Array.from(starts),
      shape: Float64Array.from(shape),
      strides: Float64Array.from(strides),
      axes: shape.length,
      kind: KINDS[drive.kind],
      size: count,
      most: motion.unit,
    };
    let numbers = 1, marks = 1;
    if (drive.kind === "harmonics") numbers = known.ROOM * 2 * count + 8 * count * count;
    if (drive.kind === "pieces") numbers = known.ROOM * 4 * count + 5 * count + 1;
    if (count) marks = 2 * known.MIXES;
    const place = {
      index: new Float64Array(shape.length + all.length),
      number: new Float64Array(numbers),
      mark: new Float64Array(marks),
    };
    doors.prepare(scenes, place, Float64Array.from(motion.breaks), Float64Array.from(motion.pieces));
    return { scenes, place, drive, size: shape.reduce((a, b) => a * b, 1) };
  }

  /**
   * Solve the cells of a range; the others are left NaN.
   * @param {ReturnType<typeof gridOf>} grid
   * @param {{begin?: number, end?: number}} [range]
   * @returns {Rows} by the names of vibro.SteadyCycle's results
   */
  function solve(grid, { begin = 0, end = grid.size } = {}) {
    const out = rows(fields("solve_contact", 2), grid.size);
    const hopping = doors.solve_contact(grid.scenes, grid.place, out, begin, end, false);
    if (hopping) {
      const cells = new Float64Array(hopping);
      let found = 0;
      for (let i = begin; i < end; i++) if (out.status[i] === known.Status.FLIGHT_NOT_MODELLED) cells[found++] = i;
      doors.solve_hops(grid.scenes, grid.place, out, cells, flights, hops, 0, found);
    }
    return out;
  }

  /**
   * Spell the pattern of a code; null if it has more letters than the digits of a double can hold.
   * @param {number} code
   */
  function spelt(code) {
    if (code === known.IRREGULAR) return "H...";
    if (code >= 0 && code < known.SPELT_PATTERNS) return known.PATTERNS[code];
    let digits = code - known.SPELT_PATTERNS, letters = "";
    if (digits < 0 || digits > Number.MAX_SAFE_INTEGER) return null;
    for (; digits > 0; digits = Math.floor(digits / 5)) letters = known.LETTERS[digits % 5] + letters;
    return letters;
  }

  /**
   * Spell the pattern of one scene's cycle; empty if it has none.
   * @param {ReturnType<typeof gridOf>} grid
   * @param {Rows} cycle
   */
  function pattern(grid, cycle) {
    const text = spelt(cycle.pattern_code[0]);
    if (text !== null) return text;
    let number = 64, legs = new Float64Array(0);
    while (number > legs.length) {
      legs = new Float64Array(number);
      number = doors.write_letters(grid.scenes, grid.place, 0, flights, hops, legs, number);
    }
    return [...legs.slice(0, number)].map((mode) => known.LETTERS[mode]).join("");
  }

  /**
   * Follow the body of one scene from rest until its motion repeats; null if it cannot be followed, or has too many
   * legs that do not repeat.
   * @param {ReturnType<typeof gridOf>} grid
   * @param {number} cycles
   * @param {number} [phase] of the trough at the start [rad]
   */
  function history(grid, cycles, phase = 0.0) {
    if (!doors.followed(grid.scenes, grid.place, 0)) return null;
    const last = rows(fields("history", 10), known.MOST_BOUNCES + known.LONGEST_CYCLE);
    for (let room = 256; room <= MOST_LEGS; room *= 8) {
      const legs = rows(fields("history", 7), room);
      const cycle = rows(fields("history", 9), 1);
      const number = doors.history(
        grid.scenes, grid.place, phase, 0.0, 0.0, 0.0, cycles, legs, room, cycle, last, flights);
      if (number >= 0) {
        for (const name in legs) legs[name] = legs[name].slice(0, number);
        const [first, period, advance] = [cycle.first[0], cycle.period[0], cycle.advance[0]];
        return { legs, number, first, period, advance, frequency: grid.drive.frequency };
      }
    }
    return null;
  }

  /**
   * Motion and forces of one scene's body at times, by the names of vibro.Sample, in SI units.
   * @param {ReturnType<typeof gridOf>} grid
   * @param {any} motion legs, and what of them repeats
   * @param {ArrayLike<number>} times [s]
   * @param {(n: number) => boolean} [isAfter] whether each is after what happens then
   */
  function sample(grid, motion, times, isAfter = () => true) {
    const found = rows(["time", ...fields("sample", 8)], times.length);
    found.time.set(times);
    const after = Float64Array.from(times, (_, n) => Number(isAfter(n)));
    const off = grid.drive.motion?.jumps.length ? OFF_JUMP : 0.0;
    doors.sample(grid.scenes, grid.place, motion.legs, motion, 0.0, off, times, after, found, times.length);
    return found;
  }

  /**
   * The phases of a motion until a time: legs, and where they begin, in time [s] and along it [A]; and the next one.
   * @param {any} motion @param {number} end [s]
   */
  function phases(motion, end) {
    const number = doors.phase_at(motion.legs, motion, end, false) + 1;
    const found = rows(["row", "start", "position"], number + 1);
    doors.phases(motion.legs, motion, found.row, found.start, found.position, number + 1);
    return { number, ...found };
  }

  /**
   * The cycle of a motion that repeats, as a motion of its own; null if none does.
   * @param {any} motion @param {boolean} turns whether it begins where its letters are least
   */
  function steady(motion, turns) {
    const number = motion.number - motion.first;
    const legs = rows(fields("steady_legs", 0), number);
    if (number) doors.steady_legs(motion.legs, motion, turns, legs);
    return number ? { ...motion, legs, number, first: 0 } : null;
  }

  /**
   * When the body of one scene has moved by a length from rest [s]; Infinity if never, NaN if that is unknown.
   * @param {ReturnType<typeof gridOf>} grid
   * @param {number} length [m]
   * @param {Rows} cycle its steady cycle
   */
  function arrival(grid, length, cycle) {
    const times = new Float64Array(1);
    doors.arrivals(
      grid.scenes, grid.place, 0.0, 0.0, 0.0, 0.0, Float64Array.of(length), cycle.displacement_per_cycle, times,
      flights, 0, 1);
    return times[0];
  }

  /**
   * The slides of one scene's contact cycle, of a drive of one harmonic.
   * @param {ReturnType<typeof gridOf>} grid
   * @param {number} code of its pattern
   */
  function slides(grid, code) {
    const found = rows(fields("cycle_legs", 3), 2);
    doors.cycle_legs(grid.scenes, grid.place, Float64Array.of(code), found, 0, 1, 1);
    return found;
  }

  /** Whether the body of one scene can be followed. @param {ReturnType<typeof gridOf>} grid */
  const isFollowed = (grid) => doors.followed(grid.scenes, grid.place, 0) > 0;

  /**
   * The motions of bodies that are laid down in one scene at evenly spread phases, in units of the solver, with the
   * counts and means of core's Found.
   * @param {ReturnType<typeof gridOf>} grid
   */
  function attractors(grid) {
    const room = known.STARTS + known.KNOWN;
    const motions = rows(fields("attractors", 6), room);
    const found = { counts: new Float64Array(5), means: new Float64Array(3) };
    doors.attractors(grid.scenes, grid.place, known.STARTS, 0.0, flights, hops, motions, found, room);
    const [number, home, irregular, lost] = found.counts;
    return { number, home, irregular, lost, mean: found.means[0], ...motions };
  }

  /**
   * Factors of one scene's motion, beyond one harmonic, between which it has each class; and those of the hop, and of
   * the loads that exceed static friction forward and back.
   * @param {ReturnType<typeof gridOf>} grid
   */
  function spans(grid) {
    const counts = new Float64Array(2 * known.CLASSES + 1);
    for (let room = 64; ; room *= 4) {
      const found = new Float64Array(2 * known.CLASSES * room + 3);
      doors.class_scales(grid.scenes, grid.place, found, counts, room);
      if (Math.max(...counts.slice(0, known.CLASSES)) > room) continue;
      const pair = (/** @type {number} */ at) => [found[at], found[at + 1]];
      const classes = Array.from({ length: known.CLASSES }, (_, k) =>
        Array.from({ length: counts[k] }, (_, i) => pair(2 * (k * room + i))));
      const [hop, forward, back] = found.slice(-3);
      return { classes, hop, forward, back };
    }
  }

  /**
   * Unit of length of one scene in the solver [m].
   * @param {Drive} drive of plain numbers
   */
  function scaleOf(drive) {
    const { kind, path: [first, second], frequency, harmonics = [], motion } = /** @type {any} */ (drive);
    if (kind === "line") return first;
    if (kind === "ellipse") return Math.max(first, second) || 1.0;
    if (kind === "harmonics") return Math.max(...harmonics[0], ...harmonics[2]) * first || 1.0;
    return (motion.unit / TURN ** 2) * (first / frequency ** 2);
  }

  /**
   * Critical loads of one scene, each over its load G.
   * @param {ReturnType<typeof gridOf>} grid
   */
  function limits(grid) {
    const out = rows(fields("transition_loads", 2), grid.size);
    doors.transition_loads(grid.scenes, grid.place, out, 0, grid.size);
    return out;
  }

  /**
   * Find the operating points of a machine, each of least amplitude.
   * @param {ReturnType<typeof gridOf>} grid scenes of an amplitude of 1 m
   * @param {Record<string, any>} springs the machine, as core's Springs has it
   * @param {Rows} fillings what differs from cell to cell
   * @returns {Rows} by the names of vibro.OperatingPoints, in SI units; no amplitude is NaN
   */
  function operate(grid, springs, fillings) {
    const out = rows(fields("operate", 4), grid.size);
    doors.operate(grid.scenes, grid.place, springs, fillings, out, flights, hops, 0, grid.size);
    return out;
  }

  return {
    gridOf, solve, spelt, pattern, history, sample, phases, steady, arrival, slides, isFollowed, attractors, limits,
    spans, operate, scaleOf, known,
  };
}
