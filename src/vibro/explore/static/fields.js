/** What a map shows of its cells: numbers of the view, their colours, marks, the curves between regimes, notes. */

import { closed, continued, fillUnknown, visibleLines, zeroLines } from "./contours.js";
import { numberText, valueText } from "./draw.js";
import { uncertainText } from "./figures.js";
import { OF_FLIGHT, shareOf } from "./jobs.js";
import { roundNumbers, speedScale, timeScale } from "./scales.js";
import { spansOf } from "./state.js";
import { quantityAt } from "./tables.js";

/** @typedef {import("./jobs.js").MapCells} MapCells @typedef {import("./state.js").Shown} Shown
 * @typedef {import("./state.js").Axis} Axis
 * @typedef {object} AxisInfo
 * @property {string} name @property {string} column @property {string} label @property {string} title
 * @property {string} sign @property {number} from @property {number} to @property {boolean} log
 * @property {number} count @property {Tick[]} ticks
 * @typedef {object} CurveInfo
 * @property {string} name @property {string} label @property {string} colour @property {string} halo
 * @property {number} width @property {number[]} dash @property {number[][][]} lines in shares of the axes
 * @typedef {import("./scales.js").Scale} Scale
 * @typedef {ReturnType<typeof drawnMap>} DrawnMap */

/** @type {Record<string, string[]>} */
const HIDDEN_BY = { // where one of these has begun too, a curve is no boundary
  forward_onset: ["back_slip", "hop"], back_slip: ["hop"], continuous_sliding: ["hop"], hop: [],
};
// The load grows with these alone: over their logarithms ln(G / G_critical) is straight.
const LOADING = ["amplitude", "frequency", "setting", "voltage"];
const EDGES = /** @type {Record<string, number>} */ ({ least: 0.7, most: 1.3 }); // widths of curves of bands
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
const SAMPLED = "Sampled: bodies at the corners, at the middles of the sides and in the centre of the bands. "
  + "vibro.guarantee proves bounds for all bodies of lines and ellipses while none hops; of hops nothing is proved.";
const OUTSIDE = "The operating point's own friction or restitution lies outside of its bands.";
const NOT_SAMPLED = "Flights are those of the operating point's own friction and restitution.";

// ------------------------------------------------------------------------------
// Axes and words.

/** @param {any} data @param {Axis} axis @param {number} count @returns {AxisInfo} */
function axisInfo({ quantities }, axis, count) {
  const { column, label, symbol, sign } = quantities[axis.name];
  const ticks = roundNumbers(axis.from, axis.to, axis.log).map((x) =>
    /** @type {Tick} */ ([Math.min(Math.max(shareOf(axis, x), 0.0), 1.0), numberText(x)]));
  return { ...axis, column, label, title: `${label} ${symbol}${sign && ` [${sign}]`}`, sign, count, ticks };
}

/** Fixed quantities without their usual values: α = 20°, μ_s = 0.74. @param {any} data @param {Shown} state
 * @param {MapCells["job"]} job */
function captionOf({ quantities }, state, job) {
  const spans = spansOf({ ...job.values, trough_length: state.values.trough_length }, state);
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
  const regime = regimesOf(data, cells);
  const [lowest, highest] = isSampled ? [rows.lowest, rows.highest] : [regime, regime];
  const numbers = numbersOf(state, cells, fields.speed);
  const covered = (/** @type {number} */ n) => (OF_FLIGHT.includes(view)
    ? regime[n] >= 0 && regime[n] !== HOPPING : highest[n] === NO_SLIP);
  const seen = numbers && numbers.map((number, n) => (covered(n) ? NaN : number));
  const scale = seen && scaleOf(view, seen, cells, data.known.Regime, fields.reverses);
  const wanted = state.target === null ? null : wantedOf(data, state, cells, fields, isSampled);
  const marked = marksOf(data, state, cells, fields, isSampled, wanted?.meets);
  const looks = looksOf(data, { lowest, highest, numbers, scale, covered, marked });
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
    curves: curvesOf(data, state, cells, fields, isSampled, numbers !== null, wanted?.edges),
    notes: [
      ...(hasNumbers ? [bestOf(data, state, cells, /** @type {Float64Array} */ (seen), unit)] : []),
      ...(isOutside(state) ? [OUTSIDE] : []),
      ...(isSampled ? [SAMPLED] : Object.keys(state.bands).length ? [NOT_SAMPLED] : []),
    ],
  };
}

/** Regimes of cells; of those that show a coarser map by their load, where critical loads are known.
 * @param {any} data @param {MapCells} cells */
function regimesOf({ known }, { rows, nx, solved, isPreviewed }) {
  const { regime, ratio_hop: hop, ratio_back_slip: back, ratio_forward_onset: forward } = rows;
  if (!isPreviewed || !hop) return regime;
  const { NO_SLIP, FORWARD_SLIP, BACK_SLIP, HOPPING } = known.Regime;
  return regime.map((code, n) => {
    if (code < 0 || solved[Math.floor(n / nx)] || Number.isNaN(hop[n])) return code;
    if (hop[n] > 0.0) return HOPPING;
    if (back[n] > 0.0) return BACK_SLIP;
    return forward[n] > 0.0 ? FORWARD_SLIP : NO_SLIP;
  });
}

/** @param {any} data @param {Shown} state @param {MapCells} cells @param {boolean} isSampled */
function fieldsOf({ known }, state, cells, isSampled) {
  const { rows, nx, ny, job } = cells;
  const { regime, status, mean_velocity_error: error, period_cycles: period } = rows;
  const mean = /** @type {Float64Array} */ (rows.mean_velocity);
  const { NO_SLIP, BACK_SLIP, HOPPING } = known.Regime;
  const size = nx * ny;
  const masked = (/** @type {(n: number) => boolean} */ is) =>
    new Float64Array(size).map((_, n) => (is(n) ? 0.5 : -0.5));
  const clipped = (/** @type {Float64Array} */ x) => {
    const found = new Float64Array(size);
    for (let n = 0; n < size; n++) found[n] = Math.min(Math.max(x[n], -MARGIN), MARGIN);
    return found;
  };
  // ln(G / G_critical); where no load is critical, that of cells nearby: a curve must reach the region's edge.
  const ratios = (/** @type {string} */ prefix) => Object.fromEntries(Object.keys(HIDDEN_BY).map((name) => {
    const own = /** @type {Float64Array} */ (rows[`${prefix}_${name}`]);
    return [name, clipped(fillUnknown(own, nx, (n) => !Number.isNaN(own[n])))];
  }));
  /** Beyond one harmonic they follow from the cycles; of back slip only the sign counts. */
  const ratiosOfCycles = () => {
    const of = (/** @type {string} */ name) => {
      const own = /** @type {Float64Array} */ (rows[name]);
      return clipped(fillUnknown(own, nx, (n) => !Number.isNaN(own[n])).map(Math.log));
    };
    const back = fillUnknown(masked((n) => regime[n] === BACK_SLIP), nx, (n) => regime[n] !== HOPPING);
    const never = masked(() => false);
    return { forward_onset: of("forward_ratio"), back_slip: back, continuous_sliding: never, hop: of("throw_number") };
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
  const excess = (/** @type {number} */ n) =>
    quantityAt(cells, "kinetic_friction", n) - quantityAt(cells, "static_friction", n);
  /** Positive where cells have a status without an answer: up to the exact boundary where that has a formula. */
  const unanswered = (/** @type {number} */ code) => (code !== known.Status.INFEASIBLE
    ? masked((n) => status[n] === code)
    : Float64Array.from(status, (own, n) => (own === code && !(excess(n) > 0.0) ? 0.5 : excess(n))));
  const statuses = differentOf(status);
  return {
    ratio, rest, largest, moving, backwards, irregular, masked, statuses,
    speed: /** @type {Float64Array} [mm/s] */ (isSampled ? rows.sampled_velocity : mean).map((x) => 1000.0 * x),
    edges: Object.fromEntries(Object.keys(rows.ratio_hop ? job.edges : {}).map((edge) => [edge, ratios(edge)])),
    reverses: !isSampled && mean.reduce((sum, _, n) => sum + Number(backwards(n)), 0) > SEEN_SHARE * size,
    missing: (/** @type {string[]} */ names) => [
      ...names.map((name) => known.Status[name]).filter((code) => statuses.has(code)).map(unanswered),
      ...(/** @type {Int8Array} */ (status).includes(-1) ? [masked((n) => status[n] < 0)] : []), // not solved yet
    ],
  };
}
/** @typedef {ReturnType<typeof fieldsOf>} Fields */

/** The different ones of many small codes. @param {ArrayLike<number>} codes */
function differentOf(codes) {
  const isThere = new Uint8Array(256);
  for (let n = 0; n < codes.length; n++) isThere[codes[n] & 255] = 1;
  return new Set(Array.from(isThere.keys()).filter((code) => isThere[code]));
}

/** Numbers of the view in the unit outside; none of regimes.
 * @param {Shown} state @param {MapCells} cells @param {Float64Array} speed [mm/s] */
function numbersOf({ view, values }, { rows }, speed) {
  if (view === "regime") return null;
  if (view === "impact") return /** @type {Float64Array} */ (rows.impact_velocity).map((x) => 1000.0 * x);
  if (view === "flight") return /** @type {Float64Array} */ (rows.flight_fraction);
  if (view === "speed") return speed;
  const length = values.trough_length ?? NaN;
  return speed.map((x) => (x > 0.0 && Number.isFinite(length / x) ? length / x : NaN));
}

/** @param {string} view @param {Float64Array} seen @param {MapCells} cells @param {any} Regime
 * @param {boolean} reverses */
function scaleOf(view, seen, { rows }, Regime, reverses) {
  const those = (/** @type {(n: number) => boolean} */ is) => {
    const found = new Float64Array(seen.length);
    let count = 0;
    for (let n = 0; n < seen.length; n++) if (Number.isFinite(seen[n]) && is(n)) found[count++] = seen[n];
    return found.subarray(0, count);
  };
  if (view === "traverse") return timeScale(those(() => true));
  const regular = those((n) => rows.period_cycles[n] === 1.0), calm = those((n) => rows.regime[n] !== Regime.HOPPING);
  return speedScale(those(() => true), regular, calm, reverses && view === "speed");
}

/** Where each mark applies.
 * @param {any} data @param {Shown} state @param {MapCells} cells @param {Fields} fields @param {boolean} isSampled
 * @param {Float64Array} [meets] @returns {Record<string, (n: number) => boolean>} */
function marksOf({ known, statuses }, state, { rows, nx, solved, isPreviewed }, fields, isSampled, meets) {
  const { status, coexists } = rows;
  const isNew = (/** @type {number} */ n) => solved[Math.floor(n / nx)] > 0;
  const hatches = statuses.filter((/** @type {any} */ one) => one.hatch && fields.statuses.has(one.code)).map(
    (/** @type {any} */ one) => [one.hatch, (/** @type {number} */ n) => status[n] === one.code]);
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

// Where bodies reach the wanted speed and do not hop, positive there, and the edges of that. Where back slip begins,
// and at the hop limit, speeds jump, and lines between such cells would be jagged: each regime's speeds are
// continued beyond its edge, and the lines in it end there.
/** @param {any} data @param {Shown} state @param {MapCells} cells @param {Fields} fields @param {boolean} isSampled */
function wantedOf({ known }, { target }, { rows: { regime }, nx }, { speed, ratio, rest, masked, missing }, isSampled) {
  const { FORWARD_SLIP, BACK_SLIP } = known.Regime, { hop, back_slip: back } = ratio; // no friction changes hop
  const isKnown = (/** @type {number} */ n) => Number.isFinite(speed[n]);
  const surplus = (/** @type {(n: number) => boolean} */ isOwn) =>
    continued(speed, nx, (n) => isKnown(n) && isOwn(n)).map((x) => (x || 0.0) / Number(target) - 1.0);
  const less = (/** @type {Float64Array} */ x, /** @type {Float64Array} */ y) =>
    x.map((value, n) => Math.min(value, -y[n]));
  const lines = (/** @type {Float64Array} */ field, /** @type {Float64Array[]} */ hiding) =>
    visibleLines(zeroLines(field, nx), hiding, nx);
  const outside = isSampled ? [hop, masked((n) => !isKnown(n))]
    : [hop, rest(), ...missing(["INFEASIBLE", "INDETERMINATE", "RUNAWAY", "UNRESOLVED"])];
  let reaches = surplus(isSampled ? (n) => !(hop[n] > 0.0) : (n) => regime[n] === FORWARD_SLIP);
  const edges = lines(reaches, isSampled ? outside : [back, ...outside]);
  if (!isSampled) {
    const slower = surplus((n) => regime[n] === BACK_SLIP), forward = back.map((x) => -x);
    const agree = slower.map((x, n) => x * reaches[n]);
    edges.push(...lines(slower, [forward, ...outside]), ...lines(back, [agree, ...outside]));
    reaches = reaches.map((x, n) => (back[n] > 0.0 ? slower[n] : x));
  }
  const fails = reaches.map((x) => -x);
  for (const field of outside) edges.push(...lines(field, [fails, ...outside.filter((other) => other !== field)]));
  return { meets: outside.reduce(less, reaches), edges };
}

/** Colours of cells and marks over them. @param {any} data
 * @param {{lowest: any, highest: any, numbers: Float64Array | null, scale: Scale | null,
 *   covered: (n: number) => boolean, marked: Record<string, (n: number) => boolean>}} shown */
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
  const either = (/** @type {number} */ n) => lowest[n] < highest[n];
  for (const [name, is] of Object.entries({ ...marked, ...(!numbers && { either }) })) {
    const [isReason, isOfNumbers] = [reasons.includes(name), name === "averaged"];
    for (let n = 0; n < faces.length; n++) {
      if (!(isReason ? faces[n] === none : !isOfNumbers || faces[n] >= first)) continue;
      if (is(n)) marks[n] |= bits[name];
    }
  }
  return { faces, others: highest.map((/** @type {number} */ code) => (code >= 0 ? code : none)), marks };
}

/** What the legend tells of regimes and marks.
 * @param {any} data @param {Shown} state @param {{faces: Uint8Array, others: Int8Array, marks: Uint16Array}} looks
 * @param {boolean} isSampled @returns {{text: string, faces: number[], marks: number}[]} */
function legendOf({ looks, regimes }, { view, target }, { faces, others, marks }, isSampled) {
  const found = marks.reduce((all, own) => all | own, 0);
  const seen = new Set([...differentOf(faces), ...(found & looks.marks.either ? differentOf(others) : [])]);
  const words = /** @type {Record<string, string>} */ ({});
  if (target !== null) {
    const speed = `${numberText(target)} mm/s`;
    words.misses = `${isSampled ? "not all samples reach" : "slower than"} ${speed}, or hops`;
  }
  const rest = OF_FLIGHT.includes(view) ? "no flight" : "";
  const faced = regimes.filter((/** @type {any} */ { code }) => code >= 0 && seen.has(code));
  const marked = Object.entries(looks.legend).filter(([name]) => found & looks.marks[name]);
  return [
    ...faced.map((/** @type {any} */ { code, label }) =>
      ({ text: (code === 0 && rest) || label, faces: [code], marks: 0 })),
    ...marked.map(([name, one]) => ({ text: words[name] ?? one.text, faces: one.faces, marks: looks.marks[name] })),
  ];
}

/** The curves between regimes and their pieces.
 * @param {any} data @param {Shown} state @param {MapCells} cells @param {Fields} fields
 * @param {boolean} isSampled @param {boolean} isOnNumbers @param {number[][][]} [edges] @returns {CurveInfo[]} */
function curvesOf({ looks }, state, { nx, job, rows }, fields, isSampled, isOnNumbers, edges) {
  const isFlight = OF_FLIGHT.includes(state.view);
  const place = (/** @type {Axis} */ axis, /** @type {number[]} */ values) => (/** @type {number} */ at) => {
    const n = Math.min(Math.floor(at), values.length - 2), t = at - n;
    const [low, high] = [values[n], values[n + 1]];
    return shareOf(axis, LOADING.includes(axis.name) ? low * (high / low) ** t : low + t * (high - low));
  };
  const [x, y] = [place(state.x, job.x.values), place(state.y, job.y.values)];
  const found = /** @type {CurveInfo[]} */ ([]);
  /** @param {string} name @param {number[][][]} lines @param {Partial<CurveInfo>} [more] */
  const show = (name, lines, more = {}) => {
    const look = looks.curves[name === "target" ? "wanted" : name.replace(/_(least|most)$/, "")];
    const halo = look.halo === "#FFFFFF" && !isOnNumbers ? "" : look.halo;
    const placed = lines.map((line) => line.map(([i, j]) => [x(i), y(j)]));
    if (lines.length) found.push({ name, ...look, halo, ...more, lines: placed });
  };
  /** @param {string} name @param {Float64Array} field @param {Float64Array[]} hiding
   * @param {Partial<CurveInfo>} [more] */
  const draw = (name, field, hiding, more) => show(name, visibleLines(zeroLines(field, nx), hiding, nx), more);
  /** @param {string} name @param {any} ratio @param {string[]} statuses @param {string} [edge] */
  const boundary = (name, ratio, statuses, edge = "") => {
    const hiding = [...HIDDEN_BY[name].map((other) => ratio[other]), ...fields.missing(statuses)];
    if (!edge) return draw(name, ratio[name], hiding);
    const { label, width } = looks.curves[name];
    draw(`${name}_${edge}`, ratio[name], hiding, { label: `${label}, ${edge} friction`, width: EDGES[edge] * width });
  };
  const without = ["INFEASIBLE", "INDETERMINATE"];
  const inContact = isSampled || isFlight ? [] : ["forward_onset", "back_slip", "continuous_sliding"];
  for (const name of inContact) boundary(name, fields.ratio, [...without, "RUNAWAY"]);
  boundary("hop", fields.ratio, without);
  for (const [edge, ratio] of isFlight ? [] : Object.entries(fields.edges)) {
    for (const name of ["forward_onset", "back_slip"]) boundary(name, ratio, ["INFEASIBLE"], edge);
  }
  if (!isSampled && !isFlight && rows.mean_velocity.some((speed) => speed < 0.0)) {
    const reversal = fields.moving().map((/** @type {number} */ speed) => {
      const size = -speed / fields.largest;
      return Math.abs(size) <= NO_SPEED ? 0.0 : size;
    });
    const unknown = fields.masked((n) => Number.isNaN(rows.mean_velocity[n]));
    draw("zero_speed", reversal, [fields.rest(), unknown, fields.irregular()]);
  }
  if (state.target !== null && edges) {
    const label = `${numberText(state.target)} mm/s, ${isSampled ? "of all samples, " : ""}without hopping`;
    show("target", edges, { label });
  }
  return found;
}

/** Whether the operating point is none of the bodies of the bands. @param {Shown} state */
function isOutside({ values, bands }) {
  return Object.entries(bands).some(([name, [low, high]]) => !(values[name] >= low && values[name] <= high));
}

/** Where the largest number is, or the shortest time. @param {any} data @param {Shown} state @param {MapCells} cells
 * @param {Float64Array} seen @param {string} unit */
function bestOf({ quantities }, { view, x, y }, { nx, job, isDone, rows }, seen, unit) {
  const isTime = view === "traverse";
  let best = seen.findIndex((number) => !Number.isNaN(number));
  seen.forEach((number, n) => {
    if (isTime ? number < seen[best] : number > seen[best]) best = n;
  });
  const told = (/** @type {string} */ name, /** @type {number} */ value) =>
    `${quantities[name].label} ${valueText(quantities[name], value)}`;
  const where = `${told(x.name, job.x.values[best % nx])} and ${told(y.name, job.y.values[Math.floor(best / nx)])}`;
  const what = `${isTime ? "Shortest" : "Largest"} here${isDone ? "" : " so far"}`;
  const isMean = view === "speed" && 1000.0 * rows.mean_velocity[best] === seen[best]; // no least one of several bodies
  const number = isMean ? uncertainText(seen[best], 1000.0 * rows.mean_velocity_error[best]) : numberText(seen[best]);
  return `${what}: ${number}${unit && ` ${unit}`}, at ${where}.`;
}

/** What is told of one cell: names and texts.
 * @param {any} data @param {DrawnMap} map @param {number} i @param {number} j */
export function tipRows({ regimes, statuses }, map, i, j) {
  const { x, y, nx, cells: { rows, job }, lowest, highest, isSampled, numbers, label, legend, marks } = map;
  const n = j * nx + i;
  const names = [lowest[n], highest[n]].map((code) =>
    regimes.find((/** @type {any} */ one) => one.code === code)?.label);
  const number = (/** @type {number} */ value) => (Number.isNaN(value) ? "" : numberText(value, 4));
  const [speed, error] = [1000.0 * rows.mean_velocity[n], 1000.0 * rows.mean_velocity_error[n]];
  const mean = Number.isNaN(speed) || isSampled ? "" : uncertainText(speed, error).replace(/^-/, "\u2212");
  const isSpeed = map.view === "speed" && !isSampled;
  const told = legend.filter((item) => item.marks & marks[n]).map((item) => item.text);
  const trouble = statuses.find((/** @type {any} */ one) => one.code === rows.status[n])?.message ?? "";
  const found = [
    [x.label, valueText(x, job.x.values[i])], [y.label, valueText(y, job.y.values[j])],
    ["regime", [...new Set(names)].filter(Boolean).join(" to ")],
    ["mean speed [mm/s]", isSpeed ? "" : mean],
    [label, isSpeed ? mean : number(numbers?.[n] ?? NaN)],
    ["amplitude [mm]", number(1000.0 * (rows.amplitude?.[n] ?? NaN))],
    ...[...new Set([...told, isSampled ? "" : trouble])].map((text) => ["", text]),
  ];
  return found.filter(([, text]) => text);
}
