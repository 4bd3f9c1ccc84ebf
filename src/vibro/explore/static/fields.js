/** What a map shows of its cells: numbers of the view, their colours, marks, the curves between regimes, notes. */

import { closed, fillUnknown, visibleLines, zeroLines } from "./contours.js";
import { numberText, valueText } from "./draw.js";
import { OF_FLIGHT } from "./pool.js";

/** @typedef {import("./pool.js").MapCells} MapCells @typedef {import("./state.js").Shown} Shown
 * @typedef {import("./state.js").Axis} Axis
 * @typedef {object} AxisInfo
 * @property {string} name @property {string} column @property {string} label @property {string} title
 * @property {string} sign @property {number} from @property {number} to @property {boolean} log
 * @property {number} count @property {Tick[]} ticks
 * @typedef {object} CurveInfo
 * @property {string} name @property {string} label @property {string} colour @property {string} halo
 * @property {number} width @property {number[]} dash @property {number[][][]} lines in shares of the axes
 * @typedef {{palette: string, ticks: Tick[] | null, low: number, high: number, share: (number: number) => number}} Scale
 * @typedef {ReturnType<typeof drawnMap>} DrawnMap */

const HIDDEN_BY = { // where one of these has begun too, a curve is no boundary
  forward_onset: ["back_slip", "hop"], back_slip: ["hop"], continuous_sliding: ["hop"], hop: [],
};
// The load grows with these alone: over their logarithms ln(G / G_critical) is straight.
const LOADING = ["amplitude", "frequency", "setting", "voltage"];
const OF_SPEED = ["speed", "traverse"];
const MARGIN = Math.log(1e30); // beyond which a logarithm of ratios says no more
const CERTAIN = 3.0; // standard errors below zero, from which a mean is negative
const NO_SPEED = 1e-9; // of the largest speed: less counts as none
// Where motion repeats after more cycles, or never, numbers jump from cell to cell: there no curve is drawn, nor
// in gaps of such cells, nor close to them.
const FEW_CYCLES = 4.0;
const [ROUGH_ACROSS, ROUGH_AROUND] = [10, 8]; // [cells]
const SEEN_SHARE = 0.02; // of a map: less of it does not decide on the colours
const LISTED_HARMONICS = 2;

// ------------------------------------------------------------------------------
// Round numbers, and scales of colours.

/** Round numbers within a range, with at most so many steps. @param {number} low @param {number} high */
export function roundNumbers(low, high, isLog = false, most = 8) {
  const slack = 1e-9 * (high - low);
  const within = (/** @type {number} */ x) => x >= low - slack && x <= high + slack;
  if (isLog && high > 5.0 * low) return decades(low, high, high < 200.0 * low).filter(within);
  const unit = 10.0 ** Math.floor(Math.log10((high - low) / most));
  const step = [1.0, 2.0, 2.5, 5.0, 10.0].map((size) => size * unit).find((size) => size * most >= high - low - slack) ?? 10.0 * unit;
  const first = Math.ceil((low - slack) / step);
  const count = Math.floor((high + slack) / step) - first + 1;
  return Array.from({ length: Math.max(count, 0) }, (_, n) => Number(((first + n) * step).toPrecision(12)));
}

/** The numbers 1, 2, 5, 10 ... about a range above 0, or powers of ten alone. @param {number} low @param {number} high @param {boolean} isDense */
function decades(low, high, isDense) {
  const powers = Array.from({ length: Math.ceil(Math.log10(high / low)) + 2 }, (_, n) => n + Math.floor(Math.log10(low)));
  return powers.flatMap((power) => (isDense ? [1, 2, 5] : [1]).map((size) => Number(`${size}e${power}`)));
}

/** @param {number} low @param {number} high */
function logTicks(low, high) {
  return decades(low, high, Math.log10(high / low) <= 3.0).filter((x) => x > low && x < high);
}

/** @param {Float64Array} ascending @param {number} share */
function quantileOf(ascending, share) {
  const at = share * (ascending.length - 1), n = Math.min(Math.floor(at), ascending.length - 2);
  return n < 0 ? ascending[0] : ascending[n] + (at - n) * (ascending[n + 1] - ascending[n]);
}

/** A scale of colours, and its ticks. @param {string} palette @param {number} low @param {number} high
 * @param {(x: number) => number} along what is even on it @param {number[]} numbers for ticks @returns {Scale} */
function scaleAlong(palette, low, high, along, numbers) {
  const [first, last] = [along(low), along(high)];
  const share = (/** @type {number} */ x) => Math.min(Math.max((along(x) - first) / (last - first), 0.0), 1.0);
  const ticks = numbers.filter((x) => x >= low && x <= high).map((x) => /** @type {Tick} */ ([share(x), numberText(x)]));
  return { palette, low, high, share, ticks };
}

// Speeds, or shares: from zero up, about zero where motion reverses, from the least number where all are alike,
// and logarithmic where few large ones would leave most others in one colour (vibro.plots.scales).
/** @param {Float64Array} seen @param {Float64Array} regular of motion that repeats with the drive @param {Float64Array} calm in contact
 * @param {boolean} reverses */
export function speedScale(seen, regular, calm, reverses) {
  const even = (/** @type {string} */ palette, /** @type {number} */ low, /** @type {number} */ high) =>
    scaleAlong(palette, low, high, (x) => x, roundNumbers(low, high, false, 6));
  const sizes = Float64Array.from(seen, Math.abs).sort();
  const largest = (/** @type {Float64Array} */ numbers) => numbers.reduce((most, x) => Math.max(most, Math.abs(x)), 0.0);
  const [least, middle, most] = [sizes[0] ?? 0.0, sizes.length ? quantileOf(sizes, 0.5) : 0.0, sizes[sizes.length - 1] ?? 0.0];
  if (!most) return even("cividis", 0.0, 1.0);
  const low = seen.reduce((a, b) => Math.min(a, b)), high = seen.reduce((a, b) => Math.max(a, b));
  if (low * high > 0.0 && least > 0.5 * most) return even("cividis", low, high > low ? high : 1.01 * low);
  const usual = largest(calm);
  const isUneven = [3.0 * usual, 2.0 * largest(regular), 10.0 * middle].some((size) => size > 0.0 && size < most);
  if (!isUneven) return reverses ? even("RdBu", -most, most) : even("cividis", 0.0, Math.max(high, 0.01 * most));
  if (reverses) {
    const width = 0.25 * (usual || middle);
    const ticks = logTicks(width, most);
    return scaleAlong("RdBu", -most, most, (x) => Math.asinh(x / width), [...ticks.map((x) => -x), 0.0, ...ticks]);
  }
  const above = seen.filter((x) => x > 0.0).sort();
  const foot = Math.min(Math.max(quantileOf(above, 0.02), 1e-5 * high), 0.5 * high);
  return scaleAlong("cividis", foot, high, (x) => Math.log(Math.max(x, foot)), logTicks(foot, high));
}

/** Times: logarithmic; near rest they grow without bound. @param {Float64Array} seen */
export function timeScale(seen) {
  const ascending = seen.slice().sort();
  const bottom = ascending[0] ?? 1.0;
  const top = Math.max(1.01 * bottom, Math.min(seen.length ? quantileOf(ascending, 0.98) : 2.0, 1e5 * bottom));
  return scaleAlong("cividis_r", bottom, top, Math.log, top > 5.0 * bottom ? logTicks(bottom, top) : roundNumbers(bottom, top));
}

// ------------------------------------------------------------------------------
// Axes and words.

/** Where a value lies on an axis, 0 to 1 or beyond. @param {Axis} axis @param {number} value */
export function shareOf({ from, to, log }, value) {
  return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
}

/** @param {any} data @param {Axis} axis @param {number} count @returns {AxisInfo} */
function axisInfo({ quantities }, axis, count) {
  const { column, label, symbol, sign } = quantities[axis.name];
  const ticks = roundNumbers(axis.from, axis.to, axis.log).map((x) =>
    /** @type {Tick} */ ([Math.min(Math.max(shareOf(axis, x), 0.0), 1.0), numberText(x)]));
  return { ...axis, column, label, title: `${label} ${symbol}${sign && ` [${sign}]`}`, sign, count, ticks };
}

/** Fixed quantities without their usual values: α = 20°, μ_s = 0.74. @param {any} data @param {Shown} state
 * @param {MapCells["job"]} job */
function captionOf({ quantities }, { values, bands, follows }, job) {
  const spans = /** @type {Record<string, number[]>} */ ({ ...bands });
  for (const [name, value] of Object.entries({ ...job.values, trough_length: values.trough_length })) {
    if (typeof value === "number") spans[name] ??= [value, value];
  }
  const isRatio = bands.friction_ratio || (bands.static_friction && follows && !bands.kinetic_friction);
  if (isRatio) {
    spans.friction_ratio ??= [values.friction_ratio, values.friction_ratio];
    delete spans.kinetic_friction;
  }
  const told = Object.entries(quantities).filter(([name, { default: usual, order }]) =>
    spans[name] && (order ?? 0) <= LISTED_HARMONICS && (spans[name][0] !== spans[name][1] || spans[name][0] !== usual));
  return told.map(([name, quantity]) => {
    const ends = new Set(spans[name].map((value) => valueText(quantity, value)));
    return `${quantity.symbol} = ${[...ends].join(" to ")}`;
  }).join(", ");
}

// ------------------------------------------------------------------------------
// Numbers, marks and curves.

/** What a map shows. @param {any} data of the page @param {Shown} state @param {MapCells} cells */
export function drawnMap(data, state, cells) {
  const { view } = state, { rows, nx, ny, job } = cells;
  const { NO_SLIP, HOPPING } = data.known.Regime;
  const isSampled = job.bodies.length > 0;
  const fields = fieldsOf(data, state, cells, isSampled);
  const [x, y] = [axisInfo(data, state.x, nx), axisInfo(data, state.y, ny)];
  const [lowest, highest] = isSampled ? [rows.lowest, rows.highest] : [rows.regime, rows.regime];
  const numbers = numbersOf(state, cells, fields.speed);
  const covered = (/** @type {number} */ n) => (OF_FLIGHT.includes(view)
    ? rows.regime[n] >= 0 && rows.regime[n] !== HOPPING : highest[n] === NO_SLIP);
  const seen = numbers && numbers.map((number, n) => (covered(n) ? NaN : number));
  const scale = seen && scaleOf(view, seen, cells, data.known.Regime, fields.reverses);
  const looks = looksOf(data, { lowest, highest, numbers, scale, covered, marked: marksOf(data, state, cells, fields, isSampled) });
  const label = data.views[view] + (isSampled && OF_SPEED.includes(view) ? ", sampled" : "");
  const unit = { speed: "mm/s", traverse: "s", impact: "mm/s" }[view] ?? "";
  const hasNumbers = seen?.some(Number.isFinite);
  return {
    view, x, y, nx, ny, isSampled, numbers, seen, lowest, highest, cells, ...looks,
    scale: scale && { ...scale, ticks: hasNumbers ? scale.ticks : null },
    title: label, label: label + (unit && ` [${unit}]`), unit,
    caption: captionOf(data, state, job),
    progress: cells.isDone ? "" : `${Math.round(100 * cells.share)} % exact, the rest a preview`,
    legend: legendOf(data, state, looks, isSampled),
    curves: curvesOf(data, state, cells, fields, isSampled, numbers !== null),
    notes: [
      ...(hasNumbers ? [bestOf(data, state, cells, /** @type {Float64Array} */ (seen), unit)] : []),
      ...(isSampled ? ["Sampled: bodies at the corners, at the middles of the sides and in the centre of the bands. "
        + "vibro guarantee proves bounds for all bodies."] : []),
      ...(Object.keys(state.bands).length && !isSampled ? ["Flights are those of the operating point's own friction and restitution."] : []),
    ],
  };
}

/** @param {any} data @param {Shown} state @param {MapCells} cells @param {boolean} isSampled */
function fieldsOf({ known }, state, { rows, nx, ny, job }, isSampled) {
  const { regime, status, mean_velocity_error: error, period_cycles: period } = rows;
  const mean = /** @type {Float64Array} */ (rows.mean_velocity);
  const { NO_SLIP, BACK_SLIP, HOPPING } = known.Regime;
  const size = nx * ny;
  const masked = (/** @type {(n: number) => boolean} */ is) => new Float64Array(size).map((_, n) => (is(n) ? 0.5 : -0.5));
  const clipped = (/** @type {Float64Array} */ x) => x.map((value) => Math.min(Math.max(value, -MARGIN), MARGIN));
  // ln(G / G_critical); where no load is critical, that of cells nearby: a curve must reach the region's edge.
  const ratios = (/** @type {string} */ prefix) => Object.fromEntries(Object.keys(HIDDEN_BY).map((name) => {
    const own = /** @type {Float64Array} */ (rows[`${prefix}_${name}`]);
    return [name, clipped(fillUnknown(own, nx, (n) => !Number.isNaN(own[n])))];
  }));
  /** Beyond one harmonic they follow from the cycles; of back slip only the sign counts. */
  const ratiosOfCycles = () => {
    const of = (/** @type {string} */ name) => clipped(fillUnknown(/** @type {Float64Array} */ (rows[name]), nx, (n) => !Number.isNaN(rows[name][n])).map(Math.log));
    const back = fillUnknown(masked((n) => regime[n] === BACK_SLIP), nx, (n) => regime[n] !== HOPPING);
    return { forward_onset: of("forward_ratio"), back_slip: back, continuous_sliding: masked(() => false), hop: of("throw_number") };
  };
  const ratio = rows.ratio_hop ? ratios("ratio") : ratiosOfCycles();
  /** Positive where nothing moves. */
  const rest = () => ratio.hop.map((hop, n) => -Math.max(hop, ratio.forward_onset[n], ratio.back_slip[n]));
  /** Mean speed; at rest that of a cell nearby that moves: curves of numbers reach the exact edge of rest. */
  const moving = () => fillUnknown(mean, nx, (n) => Number.isFinite(mean[n]) && regime[n] !== NO_SLIP);
  const largest = mean.reduce((most, speed) => Math.max(most, Math.abs(speed) || 0.0), 0.0) || 1.0;
  const backwards = (/** @type {number} */ n) => mean[n] < -CERTAIN * error[n] && mean[n] < -NO_SPEED * largest;
  const irregular = () => {
    const rough = Uint8Array.from(mean, (speed, n) => Number(Number.isFinite(speed) && !(period[n] <= FEW_CYCLES)));
    const patches = closed(rough, nx, ROUGH_ACROSS, ROUGH_AROUND);
    return masked((n) => patches[n] > 0);
  };
  /** A quantity of a cell. @param {string} name @param {number} n */
  const valueOf = (name, n) => Number(name === job.x.name ? job.x.values[n % nx]
    : name === job.y.name ? job.y.values[Math.floor(n / nx)] : job.values[name] ?? NaN);
  const excess = (/** @type {number} */ n) => {
    const most = valueOf("static_friction", n), own = valueOf("kinetic_friction", n);
    return (Number.isNaN(own) ? valueOf("friction_ratio", n) * most : own) - most;
  };
  /** Positive where cells have a status without an answer: up to the exact boundary where that has a formula. */
  const unanswered = (/** @type {number} */ code) => (code !== known.Status.INFEASIBLE ? masked((n) => status[n] === code)
    : Float64Array.from(status, (own, n) => (own === code && !(excess(n) > 0.0) ? 0.5 : excess(n))));
  const statuses = new Set(status);
  return {
    ratio, rest, largest, moving, backwards, irregular, masked, statuses,
    speed: /** @type {Float64Array} */ (isSampled ? rows.least_velocity : mean).map((speed) => 1000.0 * speed), // [mm/s]
    edges: Object.fromEntries(Object.keys(job.edges).map((edge) => [edge, ratios(edge)])),
    reverses: !isSampled && masked(backwards).filter((x) => x > 0.0).length > SEEN_SHARE * size,
    missing: (/** @type {string[]} */ names) => names.map((name) => known.Status[name]).filter((code) => statuses.has(code)).map(unanswered),
  };
}
/** @typedef {ReturnType<typeof fieldsOf>} Fields */

/** Numbers of the view in the unit outside; none of regimes. @param {Shown} state @param {MapCells} cells @param {any} speed [mm/s] */
function numbersOf({ view, values }, { rows }, speed) {
  if (view === "regime") return null;
  if (view === "impact") return Float64Array.from(rows.impact_velocity, (x) => 1000.0 * x);
  if (view === "flight") return Float64Array.from(rows.flight_fraction);
  if (view === "speed") return Float64Array.from(speed);
  const length = values.trough_length ?? NaN;
  return Float64Array.from(speed, (/** @type {number} */ x) => (x > 0.0 && Number.isFinite(length / x) ? length / x : NaN));
}

/** @param {string} view @param {Float64Array} seen @param {MapCells} cells @param {any} Regime @param {boolean} reverses */
function scaleOf(view, seen, { rows }, Regime, reverses) {
  const those = (/** @type {(n: number) => boolean} */ is) => seen.filter((number, n) => Number.isFinite(number) && is(n));
  if (view === "traverse") return timeScale(those(() => true));
  const regular = those((n) => rows.period_cycles[n] === 1.0), calm = those((n) => rows.regime[n] !== Regime.HOPPING);
  return speedScale(those(() => true), regular, calm, reverses && view === "speed");
}

/** Where each mark applies. @param {any} data @param {Shown} state @param {MapCells} cells @param {Fields} fields @param {boolean} isSampled
 * @returns {Record<string, (n: number) => boolean>} */
function marksOf({ known, statuses }, state, { rows, nx, solved, isPreviewed }, fields, isSampled) {
  const { status, coexists } = rows;
  const isNew = (/** @type {number} */ n) => solved[Math.floor(n / nx)] > 0;
  const hatches = statuses.filter((/** @type {any} */ one) => one.hatch && fields.statuses.has(one.code)).map(
    (/** @type {any} */ one) => [one.hatch, (/** @type {number} */ n) => status[n] === one.code]);
  const meets = state.target === null ? null : meetsOf(state, { rows, nx }, fields, isSampled);
  return {
    ...Object.fromEntries(hatches),
    ...(isPreviewed && { preview: (/** @type {number} */ n) => !isNew(n) }),
    ...(meets && { misses: (/** @type {number} */ n) => !(meets[n] > 0.0) }),
    ...(isSampled ? { sampled: () => true } : {
      backwards: fields.backwards,
      ...(fields.statuses.has(known.Status.AVERAGED) && {
        averaged: (/** @type {number} */ n) => status[n] === known.Status.AVERAGED,
      }),
      coexists: (/** @type {number} */ n) => coexists[n] > 0,
    }),
  };
}

/** Positive where bodies reach the wanted speed and do not hop. @param {Shown} state @param {{rows: MapCells["rows"], nx: number}} cells
 * @param {Fields} fields @param {boolean} isSampled */
function meetsOf({ target }, { rows, nx }, fields, isSampled) {
  const wanted = Number(target);
  const isKnown = (/** @type {number} */ n) => Number.isFinite(fields.speed[n]);
  if (isSampled) {
    const speed = fillUnknown(fields.speed, nx, isKnown);
    return speed.map((x, n) => Math.min(x / wanted - 1.0, isKnown(n) ? 0.5 : -0.5));
  }
  const missing = fields.missing(["INFEASIBLE", "INDETERMINATE", "RUNAWAY", "UNRESOLVED"]);
  const fails = [fields.ratio.hop, fields.rest(), ...missing];
  return fields.moving().map((speed, n) => Math.min((1000.0 * speed) / wanted - 1.0, ...fails.map((field) => -field[n])));
}

/** Colours of cells and marks over them. @param {any} data
 * @param {{lowest: any, highest: any, numbers: Float64Array | null, scale: Scale | null, covered: (n: number) => boolean,
 *   marked: Record<string, (n: number) => boolean>}} shown */
function looksOf({ looks, statuses }, { lowest, highest, numbers, scale, covered, marked }) {
  const [first, count] = looks.scale;
  const bits = looks.marks, none = looks.faces.no_answer;
  const faces = new Uint8Array(lowest.length), marks = new Uint16Array(lowest.length);
  for (let n = 0; n < faces.length; n++) {
    if (!numbers || !scale) faces[n] = lowest[n] >= 0 ? lowest[n] : none;
    else if (covered(n)) faces[n] = 0;
    else faces[n] = Number.isNaN(numbers[n]) ? none : first + Math.round((count - 1) * scale.share(numbers[n]));
  }
  const reasons = statuses.map((/** @type {any} */ one) => one.hatch); // told where there is no answer
  for (const [name, is] of Object.entries({ ...marked, either: (/** @type {number} */ n) => !numbers && lowest[n] < highest[n] })) {
    const [isReason, isOfNumbers] = [reasons.includes(name), name === "averaged"];
    for (let n = 0; n < faces.length; n++) {
      if (!(isReason ? faces[n] === none : !isOfNumbers || faces[n] >= first)) continue;
      if (is(n)) marks[n] |= bits[name];
    }
  }
  return { faces, others: Uint8Array.from(highest, (/** @type {number} */ code) => (code >= 0 ? code : none)), marks };
}

/** @param {any} data @param {Shown} state @param {{faces: Uint8Array, others: Uint8Array, marks: Uint16Array}} looks @param {boolean} isSampled
 * @returns {{text: string, faces: number[], marks: number}[]} */
function legendOf({ looks, regimes }, { view, target }, { faces, others, marks }, isSampled) {
  const found = marks.reduce((all, own) => all | own, 0);
  const seen = new Set(faces);
  if (found & looks.marks.either) for (const face of others) seen.add(face);
  const words = /** @type {Record<string, string>} */ ({});
  if (target !== null) {
    const speed = `${numberText(target)} mm/s`;
    words.misses = isSampled ? `not all samples reach ${speed}` : `slower than ${speed}, or hops`;
  }
  const rest = OF_FLIGHT.includes(view) ? "no flight" : "";
  return [
    ...regimes.filter((/** @type {any} */ one) => one.code >= 0 && seen.has(one.code)).map((/** @type {any} */ { code, label }) =>
      ({ text: (code === 0 && rest) || label, faces: [code], marks: 0 })),
    ...Object.entries(looks.legend).filter(([name]) => found & looks.marks[name]).map(([name, one]) =>
      ({ text: words[name] ?? one.text, faces: one.faces, marks: looks.marks[name] })),
  ];
}

/** The curves between regimes and their pieces. @param {any} data @param {Shown} state @param {MapCells} cells @param {Fields} fields
 * @param {boolean} isSampled @param {boolean} isOnNumbers @returns {CurveInfo[]} */
function curvesOf({ looks }, state, { nx, job, rows }, fields, isSampled, isOnNumbers) {
  const isFlight = OF_FLIGHT.includes(state.view);
  const place = (/** @type {Axis} */ axis, /** @type {number[]} */ values) => (/** @type {number} */ at) => {
    const n = Math.min(Math.floor(at), values.length - 2), t = at - n;
    const [low, high] = [values[n], values[n + 1]];
    return shareOf(axis, LOADING.includes(axis.name) ? low * (high / low) ** t : low + t * (high - low));
  };
  const [x, y] = [place(state.x, job.x.values), place(state.y, job.y.values)];
  const found = /** @type {CurveInfo[]} */ ([]);
  const draw = (/** @type {string} */ name, /** @type {Float64Array} */ field, /** @type {Float64Array[]} */ hiding, more = {}) => {
    const look = looks.curves[name === "target" ? "wanted" : name.replace(/_(least|most)$/, "")];
    const lines = visibleLines(zeroLines(field, nx), hiding, nx).map((line) => line.map(([i, j]) => [x(i), y(j)]));
    const halo = look.halo === "#FFFFFF" && !isOnNumbers ? "" : look.halo;
    if (lines.length) found.push({ name, ...look, halo, ...more, lines });
  };
  /** @param {string} name @param {any} ratio @param {string[]} statuses @param {string} [edge] */
  const boundary = (name, ratio, statuses, edge = "") => {
    const hiding = [.../** @type {any} */ (HIDDEN_BY)[name].map((/** @type {string} */ other) => ratio[other]), ...fields.missing(statuses)];
    const look = looks.curves[name], width = { least: 0.7, most: 1.3 }[edge] ?? 1.0;
    if (!edge) draw(name, ratio[name], hiding);
    else draw(`${name}_${edge}`, ratio[name], hiding, { label: `${look.label}, ${edge} friction`, width: width * look.width });
  };
  const without = ["INFEASIBLE", "INDETERMINATE"];
  for (const name of Object.keys(HIDDEN_BY)) {
    if (name === "hop" || !(isSampled || isFlight)) boundary(name, fields.ratio, name === "hop" ? without : [...without, "RUNAWAY"]);
  }
  for (const [edge, ratio] of isFlight ? [] : Object.entries(fields.edges)) {
    for (const name of ["forward_onset", "back_slip"]) boundary(name, ratio, ["INFEASIBLE"], edge);
  }
  if (!isSampled && !isFlight && rows.mean_velocity.some((speed) => speed < 0.0)) {
    const reversal = fields.moving().map((/** @type {number} */ speed) => (Math.abs(speed) <= NO_SPEED * fields.largest ? 0.0 : -speed / fields.largest));
    draw("zero_speed", reversal, [fields.rest(), fields.masked((n) => Number.isNaN(rows.mean_velocity[n])), fields.irregular()]);
  }
  if (state.target !== null) {
    const label = `${numberText(state.target)} mm/s, ${isSampled ? "of all samples" : "without hopping"}`;
    draw("target", meetsOf(state, { rows, nx }, fields, isSampled), [], { label });
  }
  return found;
}

/** Where the largest number is, or the shortest time. @param {any} data @param {Shown} state @param {MapCells} cells
 * @param {Float64Array} seen @param {string} unit */
function bestOf({ quantities }, { view, x, y }, { nx, job, isDone }, seen, unit) {
  const isTime = view === "traverse";
  const best = seen.reduce((at, number, n) => (at < 0 || Number.isNaN(seen[at]) || (isTime ? number < seen[at] : number > seen[at]) ? n : at), -1);
  const where = [[x.name, job.x.values[best % nx]], [y.name, job.y.values[Math.floor(best / nx)]]].map(([name, value]) =>
    `${quantities[name].label} ${valueText(quantities[name], Number(value))}`);
  return `${isTime ? "Shortest" : "Largest"} here${isDone ? "" : " so far"}: ${numberText(seen[best])}${unit && ` ${unit}`}, at ${where.join(" and ")}.`;
}

/** What is told of one cell: names and texts. @param {any} data @param {DrawnMap} map @param {number} i @param {number} j */
export function tipRows({ regimes, statuses }, map, i, j) {
  const { x, y, nx, cells: { rows, job }, lowest, highest, isSampled, numbers, label, legend, marks } = map;
  const n = j * nx + i;
  const names = [lowest[n], highest[n]].map((code) => regimes.find((/** @type {any} */ one) => one.code === code)?.label);
  const number = (/** @type {number | undefined} */ value) => (value === undefined || Number.isNaN(value) ? "" : numberText(value, 4));
  const told = legend.filter((item) => item.marks & marks[n]).map((item) => item.text);
  const trouble = statuses.find((/** @type {any} */ one) => one.code === rows.status[n])?.message ?? "";
  const found = [
    [x.label, valueText(x, job.x.values[i])], [y.label, valueText(y, job.y.values[j])],
    ["regime", [...new Set(names)].filter(Boolean).join(" to ")],
    ["mean speed [mm/s]", isSampled || map.view === "speed" ? "" : number(1000.0 * rows.mean_velocity[n])],
    [label, number(numbers?.[n])], ["amplitude [mm]", number(rows.amplitude && 1000.0 * rows.amplitude[n])],
    ...[...new Set([...told, isSampled ? "" : trouble])].map((text) => ["", text]),
  ];
  return found.filter(([, text]) => text);
}
