/**
 * The answer about one scene, as texts: what vibro.answers.scene writes for `vibro solve --all`, figure by figure.
 *
 * @typedef {{label: string, text: string}} Fact
 * @typedef {{title: string, columns: string[], rows: string[][]}} AnswerTable the first text of a row names it
 * @typedef {object} Answer
 * @property {string} title regime and speed
 * @property {string} regime
 * @property {string} colour of the regime
 * @property {string} speedText
 * @property {string[]} warnings
 * @property {Fact[]} facts
 * @property {AnswerTable[]} tables
 * @property {string[]} notes
 */
import { html, tableOf } from "./draw.js";
import { briefText, filledText, shownText, uncertainText } from "./figures.js";
import { phasesOf, steadyHistory } from "./histories.js";
import { loadOf, strokeOf } from "./paths.js";
import { generalText } from "./typed.js";

// ------------------------------------------------------------------------------
// One solved scene.

const SAME = 1e-12; // [1] relative distance within which two loads are the same
const LEAST_DIFFERENCE = 2 ** -26; // [A] where slides to and fro nearly cancel, their difference is rounding
const MOST_KINDS = 5; // of motions in one line
const DIGITS_OF_SHARES = 3;
const LEAST_CERTAIN = 1.0 / 3.0; // error over the size of a mean whose sign is not in doubt
const MILLI = 1000.0; // [mm/m]

const points = new WeakMap(); // by state: numbers and motion of one change ask for the same

/** The operating point: its quantities in the units outside, as they are given, and its drive. */
export function pointOf(/** @type {any} */ data, /** @type {any} */ engine, /** @type {any} */ state) {
  if (!points.has(state)) points.set(state, foundPoint(data, engine, state));
  return points.get(state);
}

/** A machine finds its amplitude; one that has none gets an arbitrary one, whose results are withheld. */
function foundPoint(/** @type {any} */ data, /** @type {any} */ engine, /** @type {any} */ state) {
  const { given, machine, values: { trough_length: length = NaN, friction_ratio: _, ...values } } = state;
  /** @type {any} */
  const operated = machine && operatingOf(data, engine, { values, given: null, machine: machine.fields });
  if (operated) values.amplitude = MILLI * operated.amplitude[0];
  const isLost = Number.isNaN(values.amplitude);
  const drive = /** @type {any} */ (driveOf(data, { values: isLost ? { ...values, amplitude: 1.0 } : values, given }));
  if (given?.table.length) for (const name in given.values) delete values[name]; // the scene's file has a motion
  return { values, length, drive, machine, operated, isLost };
}

/** The operating point, its steady cycle, and what most facts need of them. */
function solvedScene(/** @type {any} */ data, /** @type {any} */ engine, /** @type {any} */ state) {
  const point = pointOf(data, engine, state);
  const { values, drive } = point;
  const grid = engine.gridOf(drive);
  const cycle = engine.solve(grid);
  if (point.operated) withhold(cycle, point.operated, engine.known);
  const pattern = engine.pattern(grid, cycle);
  const isSmall = Math.abs(cycle.displacement_per_cycle[0]) <= LEAST_DIFFERENCE * engine.scaleOf(drive);
  const isStill = isSmall && pattern.includes("F") && pattern.includes("B");
  const speed = isStill ? 0.0 : MILLI * cycle.mean_velocity[0];
  const error = MILLI * cycle.mean_velocity_error[0];
  const relativeError = speed ? Math.abs(error / speed) : 0.0;
  return {
    ...point, data, engine, grid, cycle, pattern, speed, error, relativeError,
    texts: data.texts,
    says: data.texts.says,
    regime: data.regimes.find((/** @type {any} */ x) => x.code === cycle.regime[0]),
    status: data.statuses.find((/** @type {any} */ x) => x.code === cycle.status[0]),
    isCertain: !(relativeError > LEAST_CERTAIN),
    size: sizeOf(data, values),
  };
}

/** @typedef {ReturnType<typeof solvedScene>} Solved */

/** What the drive is scaled by, as it was given; NaN if by several. */
function sizeOf(/** @type {any} */ { quantities, texts: { says } }, /** @type {Record<string, number>} */ values) {
  const sizes = Object.keys(values).filter((name) => name.includes("amplitude"));
  if (sizes.length > 1) return { label: sizes.length === 2 ? says.both : says.all, unit: "", value: NaN };
  const name = sizes[0] ?? "motion_scale";
  return { label: quantities[name].label, unit: quantities[name].unit, value: values[name] ?? NaN };
}

/**
 * All that is known of the operating point.
 * @param {any} data @param {any} engine @param {any} state
 * @returns {Answer}
 */
export function answerOf(data, engine, state) {
  const one = solvedScene(data, engine, state);
  const { regime, says, speed, error } = one;
  const speedText = Number.isNaN(speed) ? says.unknown : `${uncertainText(speed, error, 6)} mm/s`;
  return {
    title: [regime.label, speedText].filter(Boolean).join(", "),
    regime: regime.label,
    colour: regime.colour,
    speedText,
    warnings: [...doubtsOf(one), ...warningsOf(one)],
    facts: [
      ...sharesFacts(one), motionFact(one), ...restitutionFacts(one), ...traverseFacts(one), ...speedFacts(one),
      ...machineFacts(one), ...rareFacts(one),
    ],
    tables: one.isLost ? [] : [...beginningsTable(one), ...sensitivitiesTable(one), ...phasesTable(one)],
    notes: notesOf(one),
  };
}

/** A figure with its unit, error and note. @returns {Fact} */
function factOf(/** @type {Solved} */ { says }, /** @type {[string, string]} */ [label, unit],
  /** @type {number | string | null} */ value, note = "", error = 0.0) {
  const behind = note && ` (${note})`;
  if (value === null || Number.isNaN(value)) return { label, text: says.unknown + behind };
  const number = typeof value === "number" ? uncertainText(value, error) : value;
  return { label, text: `${number} ${unit}`.trimEnd() + behind };
}

/** Rows as texts below their heads, without columns that are empty; no table without rows. @returns {AnswerTable[]} */
function filledTable(/** @type {string} */ title, /** @type {[string, string][]} */ heads,
  /** @type {(number | string | null)[][]} */ rows) {
  const cells = rows.map((row) => row.map((cell) => shownText(cell)));
  const isFilled = (/** @type {unknown} */ _, /** @type {number} */ i) => cells.some((row) => row[i]);
  const columns = heads.map(([label, unit]) => (unit ? `${label} [${unit}]` : label)).filter(isFilled);
  return rows.length ? [{ title, columns, rows: cells.map((row) => row.filter(isFilled)) }] : [];
}

// ------------------------------------------------------------------------------
// Facts.

/** What parts do that are laid down at any moment, where they do not all move as the one from rest. */
function sharesFacts(/** @type {Solved} */ one) {
  const { engine, says, grid, drive, cycle, speed, values, status, regime } = one;
  const hops = regime.code === engine.known.Regime.HOPPING;
  if (Number.isNaN(speed) || !(hops || cycle.coexists[0] > 0) || !engine.isFollowed(grid)) return [];
  const { number, home, irregular, lost, mean, starts, displacement } = engine.attractors(grid);
  const unit = MILLI * engine.scaleOf(drive) * values.frequency;
  const rows = Array.from({ length: number }, (_, n) => n).filter((n) => starts[n] > 0);
  const ordered = [...rows.filter((n) => n === home), ...rows.filter((n) => n !== home)];
  const kinds = ordered.map((n) => ({ count: starts[n], text: says.share, speed: unit * displacement[n] }));
  if (irregular) kinds.push({ count: irregular, text: says["share irregular"], speed: unit * mean });
  if (lost) kinds.push({ count: lost, text: says["share lost"], speed: NaN });
  const all = engine.known.STARTS;
  if (status.name === "AVERAGED" ? irregular === all : kinds.length < 2) return [];
  kinds.sort((a, b) => b.count - a.count);
  const percent = (/** @type {number} */ count) => Math.floor((100.0 * count) / all + 0.5);
  const texts = kinds.slice(0, MOST_KINDS).map(({ count, text, speed: own }) =>
    filledText(text, { share: percent(count), speed: shownText(own, DIGITS_OF_SHARES) }));
  const others = kinds.slice(MOST_KINDS).reduce((sum, { count }) => sum + count, 0);
  if (others) texts.push(filledText(says["share of others"], { share: percent(others) }));
  // in the end the body from rest may repeat, where a mean is not that of a cycle
  const released = home >= 0 ? unit * displacement[home] : speed;
  const note = filledText(says.released, { speed: shownText(released, DIGITS_OF_SHARES) });
  return [factOf(one, [says["laid down"], ""], texts.join(", "), note)];
}

function motionFact(/** @type {Solved} */ one) {
  const { says, regime, speed, error, values } = one;
  const label = regime.label || says.none;
  if (Number.isNaN(speed)) return factOf(one, [label, ""], one.status.name === "RUNAWAY" ? says["runs away"] : null);
  const [mean, rate, advance] = [[1.0, 4], [0.06, 3], [1.0 / values.frequency, 4]].map(([by, digits]) =>
    uncertainText(by * speed, by * error, digits));
  return factOf(one, [label, ""], filledText(says.speed, { speed: mean, rate, advance }));
}

/** Whether restitution is the usual one, and decides the speed alone: with a filling it changes the amplitude too. */
const assumesPlastic = (/** @type {Solved} */ { cycle, values }) =>
  cycle.flight_fraction[0] > 0.0 && values.restitution === 0.0 && !(values.filling > 0.0);

/** Between which speeds a part that hops may be. @returns {Fact[]} */
function restitutionFacts(/** @type {Solved} */ one) {
  const { engine, drive, says, texts } = one;
  if (!assumesPlastic(one)) return [];
  const [count, largest] = texts.restitutions;
  const values = Array.from({ length: count }, (_, n) => (n * largest) / (count - 1));
  const found = engine.solve(engine.gridOf({ ...drive, restitution: { values, strides: [1] } }, [count]));
  const known = Array.from(found.mean_velocity, (velocity) => MILLI * velocity).filter(Number.isFinite);
  if (!known.length) return [];
  const speeds = [...new Set([shownText(Math.min(...known)), shownText(Math.max(...known))])].join(says.to);
  return [factOf(one, texts.facts.restitution, filledText(says.assumed, { speeds }),
    filledText(says.sampled, { count }))];
}

/** The time over the trough at the mean speed, and exactly from rest. */
function traverseFacts(/** @type {Solved} */ one) {
  const { says, texts, length, speed, isCertain, engine, grid, cycle } = one;
  if (Number.isNaN(length)) return [];
  const [label] = texts.facts.traverse;
  const time = speed <= 0.0 ? Infinity : length / speed;
  const exact = one.isLost ? NaN : engine.arrival(grid, length / MILLI, cycle);
  const fromRest = Number.isFinite(exact) ? filledText(says["from rest"], { time: shownText(exact, 6) }) : "";
  if (Number.isFinite(time) && isCertain) {
    const over = filledText(says.over, { length: generalText(length, 10) });
    return [factOf(one, [label, over], time, fromRest || says["from rest unknown"], time * one.relativeError)];
  }
  const never = time === Infinity && isCertain ? says.never : null;
  return [factOf(one, [label, ""], one.status.name === "RUNAWAY" ? says["not steady"] : never, fromRest)];
}

function speedFacts(/** @type {Solved} */ one) {
  const { says, texts: { facts }, cycle } = one;
  const found = Number.isNaN(one.speed) ? [] : [factOf(one, facts.peak, MILLI * cycle.peak_velocity[0])];
  if (cycle.flight_fraction[0] > 0.0) {
    const period = cycle.period_cycles[0];
    let again = Number.isNaN(period) ? says.irregular : says["every cycle"];
    if (period > 1.0) again = filledText(says["every few cycles"], { period });
    const lands = filledText(says.lands, { impact: shownText(MILLI * cycle.impact_velocity[0]), again });
    found.push(factOf(one, facts.flight, 100.0 * cycle.flight_fraction[0], lands));
  }
  return [...found, factOf(one, facts.throw, briefText(cycle.throw_number[0]), says.hops)];
}

/** What the machine does, and how fast parts are where its filling bends the trough's sine. */
function machineFacts(/** @type {Solved} */ one) {
  const { values, machine, operated, texts } = one;
  const { says, facts, results, "warned harmonic": warned } = texts.machine;
  if (!machine) return [];
  const empty = filledText(says["when empty"], { amplitude: shownText(MILLI * operated.amplitude_empty[0]) });
  const natural = values.natural ?? machine.fields.natural_frequency;
  const pack = Object.keys(machine.packs).find((name) => machine.packs[name] === natural);
  const named = pack ? filledText(says.pack, { name: pack }) : "";
  const springs = filledText(says.springs, { natural: generalText(natural, 5) }) + named;
  const supply = ["setting", "voltage"].filter((name) => machine.knobs.includes(name));
  const parts = [
    ...machine.parts.map((/** @type {string | null} */ part) => part ?? springs),
    ...supply.map((name) => filledText(says.supplied, { name, percent: generalText(values[name], 6) })),
  ];
  const known = Object.keys(results).filter((name) => !Number.isNaN(operated[name][0]));
  const isBent = operated.second_harmonic[0] > warned;
  const bent = isBent && !one.isLost ? MILLI * bentSpeed(one) : NaN;
  return [
    factOf(one, facts.amplitude, values.amplitude, values.filling ? empty : says.empty),
    factOf(one, facts.machine, parts.join(", ")),
    ...known.map((name) => factOf(one, results[name].slice(0, 2), results[name][2] * operated[name][0])),
    ...(isBent ? [factOf(one, texts.facts.bent, bent)] : []),
  ];
}

/** Speed where the trough moves with the second harmonic of its filling too [m/s]. */
function bentSpeed(/** @type {Solved} */ { engine, drive, operated }) {
  const [size, angle] = drive.path;
  const [real, imaginary] = [operated.second_real[0] || 0.0, operated.second_imaginary[0] || 0.0];
  const [share, phase] = [Math.hypot(real, imaginary), Math.atan2(imaginary, real)];
  const [along, normal] = [size * Math.cos(angle), size * Math.sin(angle)];
  const harmonics = [[along, along * share], [0.0, phase], [normal, normal * share], [0.0, phase]];
  const bent = { ...drive, kind: "harmonics", path: [1.0, NaN], harmonics };
  return engine.solve(engine.gridOf(bent)).mean_velocity[0];
}

function rareFacts(/** @type {Solved} */ one) {
  const { texts: { facts, phases: names }, drive, values, pattern } = one;
  const letters = [...new Set(pattern)].filter((kind) => kind in names).map((kind) => `${kind} ${names[kind]}`);
  const stroke = "amplitude" in values ? 2.0 * values.amplitude : MILLI * strokeOf(drive);
  return [
    factOf(one, facts.scene, sceneText(one)),
    factOf(one, facts.pattern, pattern || null, letters.join(", ")),
    factOf(one, facts.stroke, stroke),
    factOf(one, facts.acceleration, one.isLost ? NaN : loadOf(drive)),
  ];
}

/** The quantities of the scene without their usual values, after the kind of its motion. */
function sceneText(/** @type {Solved} */ { data: { quantities }, says, texts, values, drive, machine }) {
  const isSaid = (/** @type {string} */ name) => name in values
    && !(name === "amplitude" && machine) // which follows from it
    && (values[name] !== quantities[name].default || name === "motion_scale");
  const given = texts.listed.filter(isSaid).map((/** @type {string} */ name) =>
    `${quantities[name].label} ${generalText(values[name], 15)} ${quantities[name].unit}`.trimEnd()).join(", ");
  if (drive.kind === "pieces") return filledText(says.pieces, { count: drive.motion.breaks.length - 1, given });
  if (drive.kind !== "harmonics") return given;
  const count = drive.harmonics[0].length;
  return filledText(count > 1 ? says.harmonics : says.harmonic, { count, given });
}

// ------------------------------------------------------------------------------
// Where each motion begins, as vibro.transitions has it.

/** Whether two loads are the same but for rounding; none is the same as an infinite one. */
const areSame = (/** @type {number} */ a, /** @type {number} */ b) =>
  a === b || (Math.abs(a - b) < Infinity && Math.abs(a - b) <= SAME * Math.max(Math.abs(a), Math.abs(b)));

/**
 * Loads between which motions last, by their names, each over the scene's load.
 * @typedef {{name: string, low: number, high: number}} Lasting
 * @returns {Lasting[]}
 */
function lastingMotions(/** @type {Solved} */ { engine, grid, drive, texts: { motions, loads, hop: hopping } }) {
  if (drive.kind === "harmonics" || drive.kind === "pieces") {
    const { classes, hop, forward, back } = engine.spans(grid);
    const found = motions.flatMap((/** @type {string} */ name, /** @type {number} */ k) =>
      classes[k].map((/** @type {[number, number]} */ [low, high]) => ({ name, low, high })));
    const firstOf = (/** @type {string} */ name) =>
      found.find((/** @type {any} */ x) => x.name === name)?.low ?? Infinity;
    [forward, back].forEach((low, k) => {
      if (!areSame(firstOf(motions[k]), low)) found.push({ name: loads[k], low, high: hop });
    });
    return [...found, { name: hopping, low: hop, high: Infinity }];
  }
  const [now, limits] = [loadOf(drive), engine.limits(grid)];
  const [high, forward, back, slip, slide] =
    ["hop", "forward_onset", "back_onset", "back_slip", "continuous_sliding"].map((name) => limits[name][0] / now);
  return [
    // where back slip comes first its slides may outlast the forward window
    { name: back < forward ? loads[0] : motions[0], low: forward, high },
    { name: motions[1], low: slip, high },
    { name: motions[2], low: slide, high },
    ...(areSame(back, slip) ? [] : [{ name: loads[1], low: back, high }]),
    { name: hopping, low: high, high: Infinity },
  ];
}

function beginningsTable(/** @type {Solved} */ one) {
  const { texts: { heads, titles, hop: hopping }, values, size, drive, machine } = one;
  const countsFrequency = drive.kind !== "pieces" && !machine; // whether it changes accelerations, and they alone
  const lasting = lastingMotions(one);
  const hop = lasting[lasting.length - 1].low;
  const found = lasting
    .filter(({ name, low }) => low > 0.0 && low < Infinity && (name === hopping || low < hop))
    .sort((a, b) => a.low - b.low);
  /** @type {{head: [string, string], of: (motion: Lasting) => number | string}[]} */
  const columns = [
    { head: heads.motion, of: ({ name }) => name },
    { head: heads.begin, of: ({ low }) => low },
  ];
  if (!Number.isNaN(size.value)) columns.push({ head: [size.label, size.unit], of: ({ low }) => size.value * low });
  if (countsFrequency) columns.push({ head: heads.frequency, of: ({ low }) => values.frequency * Math.sqrt(low) });
  if (!["line", "ellipse"].includes(drive.kind)) columns.push({ head: heads.end, of: ({ high }) => high });
  const rows = found.map((motion) => columns.map(({ of }) => of(motion)));
  return filledTable(titles.beginnings, columns.map(({ head }) => head), rows);
}

// ------------------------------------------------------------------------------
// A little more of each input, solved again.

const [MORE, SOME_MORE, TURNED] = [0.01, 0.1, Math.PI / 180.0]; // [1], of the whole drive, [rad]
const ROUNDING = 1e-9; // [%] change of a speed that is rounding alone
/** @type {Record<string, string[]>} */
const KNOBS = {
  line: ["amplitude", "frequency", "drive_angle"],
  ellipse: ["along_amplitude", "normal_amplitude", "normal_phase", "frequency"],
  harmonics: ["motion_scale", "frequency"],
  pieces: ["motion_scale", "frequency"],
};
const PARTS = ["static_friction", "kinetic_friction", "trough_angle"];
/** Places of quantities in the path of a drive, and the names of its others. @type {Record<string, number>} */
const OF_PATH = {
  amplitude: 0, along_amplitude: 0, motion_scale: 0, drive_angle: 1, normal_amplitude: 1, normal_phase: 2,
};
/** @type {Record<string, string>} */
const OF_BODY = {
  frequency: "frequency", static_friction: "staticFriction", kinetic_friction: "kineticFriction",
  trough_angle: "troughAngle", restitution: "restitution",
};

/** The drive with more of one quantity. @returns {Drive} */
function changedDrive(/** @type {any} */ drive, /** @type {string} */ name, /** @type {(x: number) => number} */ more) {
  if (name in OF_BODY) return { ...drive, [OF_BODY[name]]: more(drive[OF_BODY[name]]) };
  const path = [...drive.path];
  path[OF_PATH[name]] = more(path[OF_PATH[name]]);
  return { ...drive, path };
}

function sensitivitiesTable(/** @type {Solved} */ one) {
  const { data, engine, says, texts: { heads, titles }, drive, cycle, size, values, machine } = one;
  const { quantities, regimes, statuses } = data;
  if (machine && values.filling > 0.0) return []; // with a filling friction and angles change the amplitude too
  const bounced = cycle.regime[0] === engine.known.Regime.HOPPING ? ["restitution"] : [];
  const names = [...KNOBS[drive.kind], ...PARTS, ...bounced]
    .filter((name) => !(machine && name === "frequency")); // as it does
  const sizes = drive.kind === "ellipse" ? names.slice(0, 2) : names.slice(0, 1);
  const changes = names.map((name) => {
    const isTurned = name === "normal_phase" || name === "trough_angle";
    const label = name === "amplitude" ? size.label : quantities[name].label;
    const isBounced = name === "restitution";
    const more = (/** @type {number} */ x) => x + (isTurned ? TURNED : isBounced ? MORE : MORE * x);
    const step = isTurned ? says.turned : isBounced ? says.bounced : says.more;
    return { label, step, changed: changedDrive(drive, name, more) };
  });
  const whole = sizes.reduce((so, name) => changedDrive(so, name, (x) => x * (1.0 + SOME_MORE)), drive);
  changes.push({ label: size.label, step: says["some more"], changed: whole });
  const speed = MILLI * cycle.mean_velocity[0];
  const rows = changes.map(({ label, step, changed }) => {
    const found = engine.solve(engine.gridOf(changed));
    const then = MILLI * found.mean_velocity[0];
    const isExact = speed !== 0.0 && cycle.mean_velocity_error[0] === 0.0;
    const change = isExact ? 100.0 * (then / speed - 1.0) : NaN;
    const [regime, status] = [found.regime[0], found.status[0]];
    const codeIs = (/** @type {number} */ code) => (/** @type {any} */ x) => x.code === code;
    return [
      filledText(says["a little more"], { what: label, step }),
      then,
      Number.isNaN(change) ? null : Math.abs(change) < ROUNDING ? 0.0 : change,
      engine.known.answered.includes(status)
        ? (regime === cycle.regime[0] ? "" : regimes.find(codeIs(regime)).label)
        : statuses.find(codeIs(status)).name.toLowerCase().replaceAll("_", "-"),
    ];
  });
  return filledTable(titles.sensitivities, ["input", "speed", "change", "then"].map((name) => heads[name]), rows);
}

// ------------------------------------------------------------------------------
// The phases of one steady cycle, counted from the drive's middle on.

const SHORT = 1e-2; // [rad] shorter flights are listed as one phase
const SHORTEST = 1e-12; // [drive cycles] shorter phases at the ends of a cycle are rounding

function phasesTable(/** @type {Solved} */ one) {
  const { engine, texts: { heads, titles, phases: names, "most phases": most }, cycle, pattern } = one;
  const hops = cycle.regime[0] === engine.known.Regime.HOPPING;
  if (hops ? !(cycle.flight_fraction[0] > 0.0) : !pattern) return [];
  const steady = steadyHistory(one);
  if (!steady) return [];
  const { history, lag } = steady;
  const rounding = SHORTEST / history.frequency;
  const short = SHORT / (TURN * history.frequency);
  /** @type {import("./histories.js").Phase[]} */
  const listed = [];
  for (const phase of phasesOf(history)) {
    if (!(phase.end > rounding && phase.start < history.end - rounding)) continue;
    const kind = phase.kind === "H" && phase.end - phase.start < short ? "h" : phase.kind;
    const last = listed[listed.length - 1];
    if (kind === "h" && last?.kind === "h") {
      last.end = phase.end;
      last.moved += phase.moved;
    } else listed.push({ ...phase, kind });
  }
  const rows = listed.slice(0, most).map(({ kind, start, end, moved }) =>
    [names[kind], MILLI * (start + lag), MILLI * (end + lag), MILLI * moved]);
  return filledTable(titles.phases, ["phase", "from", "until", "displacement"].map((name) => heads[name]), rows);
}

// ------------------------------------------------------------------------------
// Notes, and the answer as part of a page.

/** A sentence for a status, and for each doubt. @returns {string[]} */
function notesOf(/** @type {Solved} */ one) {
  const { says, drive, cycle, status, values } = one;
  const { troughAngle, kineticFriction } = /** @type {any} */ (drive);
  const notes = status.name === "OK" ? [] : [status.message];
  if (cycle.coexists[0] > 0) {
    const isSteep = Math.abs(Math.tan(troughAngle)) > kineticFriction;
    if (isSteep) notes.push(says["may run away"]);
    else if (!sharesFacts(one).length) notes.push(says["may settle elsewhere"]);
  }
  const isPlastic = cycle.flight_fraction[0] > 0.0 && values.restitution === 0.0;
  if (isPlastic && !assumesPlastic(one)) notes.push(says["no bounce"]);
  return notes;
}

/** What is unusual, and probably in wrong units, as vibro.sweeps.request.Request.doubts has it. @returns {string[]} */
function doubtsOf(/** @type {Solved} */ one) {
  const { data: { quantities }, texts, drive, length, machine, operated } = one;
  const { amplitude, ...others } = one.values;
  const values = machine ? others : one.values; // of which the machine's amplitude is none
  const written = (/** @type {number} */ x) => generalText(x, 15);
  const doubt = (/** @type {string} */ name, /** @type {number} */ value) => {
    const { usual: [low, high], doubts: [below, above] } = quantities[name];
    const text = value > high ? above : value < low && value ? below : "";
    return filledText(text, { 0: written(value), 1: written(value / 100.0) });
  };
  const names = Object.keys(quantities).filter((name) => name in values);
  const found = Object.fromEntries(names.map((name) => [name, doubt(name, values[name])]));
  const isExplained = names.some((name) => found[name] && /amplitude|^frequency$|^gravity$/.test(name));
  const path = machine ? [operated.amplitude_empty[0], drive.path[1]] : drive.path;
  const load = isExplained ? NaN : loadOf({ ...drive, path });
  if (load < Infinity) found.acceleration = doubt("acceleration", Number(generalText(load, 4)));
  if (machine) {
    const { filling } = values, times = filling / machine.fields.trough_mass;
    const told = { filling: written(filling), times: generalText(times, 3) };
    found.filling = times > texts.machine.heavy ? filledText(texts.machine["heavy filling"], told) : "";
  }
  const stroke = 2.0 * (values.amplitude ?? values.along_amplitude);
  const short = { length: written(length), largest: "", stroke: written(stroke) };
  return [...Object.values(found), length < stroke ? filledText(texts["short trough"], short) : ""].filter(Boolean);
}

/** What is in doubt about the operating point of a machine, as vibro.OperatingPoints.remarks has it.
 * @returns {string[]} */
function warningsOf(/** @type {Solved} */ { texts, engine, machine, operated }) {
  if (!machine) return [];
  const { doubts, "warned harmonic": warned } = texts.machine;
  const { BOUNDARY, AVERAGED } = engine.known.Status;
  const { status: [status], number: [number], strikes: [strikes], uncertain: [isUncertain] } = operated;
  const [second] = operated.second_harmonic;
  const bent = isUncertain ? doubts.uncertain : doubts.bent;
  const near = 2.0 * machine.fields.damping_ratio;
  const ratios = [operated.frequency_ratio, operated.filled_frequency_ratio];
  const isNear = near > 0.0 && ratios.some(([ratio]) => Math.abs(ratio - 1.0) <= near);
  return [
    ...(isNear ? [filledText(doubts["near resonance"], { percent: generalText(100.0 * near, 3) })] : []),
    ...(number > 1 ? [filledText(doubts.several, { number })] : []),
    ...(status === BOUNDARY && machine.fields.kind !== "crank" ? [doubts.jumps] : []),
    ...(status === AVERAGED ? [doubts.irregular] : []),
    ...(second > warned || isUncertain ? [filledText(bent, { percent: generalText(100.0 * second, 2) })] : []),
    ...(strikes ? [doubts.strikes] : []),
  ];
}

/** Show an answer: its warnings, facts, tables and notes. @param {Answer} answer @param {Element} place */
export function showAnswer({ warnings, facts, tables, notes }, place) {
  const list = tableOf("What the body does", [], facts.map(({ label, text }) => [label, text]), { class: "facts" });
  const numeric = tables.map(({ title, columns, rows }) => tableOf(title, columns, rows, { class: "numeric" }));
  const warned = warnings.map((text) => html("p", { class: "warning" }, `Warning: ${text}`));
  place.replaceChildren(...warned, list, ...numeric, ...notes.map((note) => html("p", {}, note)));
}
