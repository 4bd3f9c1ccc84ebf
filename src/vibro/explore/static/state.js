/** What the page shows: texts of its address, read and checked. The solver gets no other input. */

/** The page as vibro wrote it; null in node. @type {PageData} */
export const data = JSON.parse(globalThis.document?.getElementById("data")?.textContent ?? "null");

/** @typedef {Record<string, string>} Texts by the keys of the address: columns of quantities, and choices
 * @typedef {Record<string, number>} Values of quantities by name, in the units outside
 * @typedef {{low: number, high: number, step: number, axis: string}} Control a slider, and its usual axis
 * @typedef {object} Quantity
 * @property {string} column
 * @property {string} label
 * @property {string} symbol
 * @property {string} unit as it is typed
 * @property {string} sign the unit as it is shown
 * @property {number} per_si
 * @property {number} si
 * @property {Record<string, [number, number]>} sizes of units in the one outside: each a fraction of whole numbers
 * @property {number} low
 * @property {number} high
 * @property {boolean} with_low
 * @property {boolean} with_high
 * @property {number | null} default
 * @property {string} start its text where no scene gives one
 * @property {string} meaning
 * @property {number} order
 * @property {Control | null} control
 * @typedef {{label: string, quantities: string[], x: string, y: string}} DriveKind
 * @typedef {DriveKind & {kind: string, values: Values, motion: any, table: string[]}} GivenDrive
 * @typedef {DriveKind & {packs: Record<string, number>, fields: any, kind: string, share: [number, number] | null}} GivenMachine
 * @typedef {object} Scene
 * @property {string} name
 * @property {Texts} state at the start
 * @property {Record<string, Control>} controls that reach its values
 * @property {GivenDrive | null} given
 * @property {GivenMachine | null} machine
 * @typedef {object} PageData
 * @property {Record<string, Quantity>} quantities in the order of the page
 * @property {Record<string, DriveKind>} drives
 * @property {Record<string, {label: string, state: Texts}>} presets
 * @property {Record<string, string>} views labels by name
 * @property {Scene[]} scenes
 * @property {any} known
 * @property {any} looks
 * @property {any} texts */
/** @typedef {{name: string, from: number, to: number, log: boolean}} Axis
 * @typedef {object} Shown what is checked
 * @property {Texts} texts in full, as numbers are typed in the units outside
 * @property {number} scene its place in the page's data
 * @property {string} drive
 * @property {GivenDrive | null} given of a drive that sliders cannot make
 * @property {GivenMachine | null} machine that drives
 * @property {Values} values
 * @property {Axis} x
 * @property {Axis} y
 * @property {string} view
 * @property {number | null} target [mm/s]
 * @property {number} cycles
 * @property {boolean} follows whether kinetic friction keeps its ratio to static friction
 * @property {Record<string, [number, number]>} bands of what is not known exactly */

/** Choices, which every scene has beside its quantities. @type {Texts} */
const CHOICES = {
  drive: "line", motion: "", view: "regime", x: "", y: "", x_range: "", y_range: "", follow: "1", target: "", cycles: "3",
  static_friction_band: "", kinetic_friction_band: "", friction_ratio_band: "", restitution_band: "",
};
const BODY = ["frequency", "static_friction", "friction_ratio", "kinetic_friction", "trough_angle", "restitution",
  "trough_length", "gravity"]; // quantities of all drives
const FRICTIONS = ["static_friction", "kinetic_friction", "friction_ratio"];
const MOST_CYCLES = 20; // drive cycles of a history: more could not be distinguished
const AROUND = 3; // factor between an operating point and the ends of an axis around it
const SAID = 60; // characters of a text that a message repeats
const LONGEST = 1000; // characters of a number: those of every double fit
const CLOSE = 1e-12; // least share of its values that an axis spans
const ONE_VALUE = "write 1.25 or 1250, not 1,250; axes are chosen at the map";

// ------------------------------------------------------------------------------
// Numbers

/** Why a text is refused: what it says and the remedy, perhaps of another field than the one that is read. */
class Refusal extends Error {
  constructor(/** @type {string} */ text, hint = "", field = "") {
    super(text);
    this.hint = hint;
    this.field = field;
  }
}

/** A text within a message: on one line, and cut where it is long. @param {string} text */
function cutText(text) {
  const long = text.length > SAID && `${text.slice(0, 36)}...${text.slice(-24)} (${text.length} characters)`;
  return (long || text).replace(/\p{C}|\p{Zl}|\p{Zp}/gu, "\u{fffd}");
}

/** A number as formats with a letter g write it: 0.0001, 1e-05, 1e+15. @param {number} value @param {number} digits */
export function generalText(value, digits) {
  if (!Number.isFinite(value)) return String(value);
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = Number(exponent);
  if (power >= -4 && power < digits) return String(Number(value.toPrecision(digits)));
  return `${Number(mantissa)}e${exponent[0]}${exponent.slice(1).padStart(2, "0")}`;
}

/** A number as people type it, such that it is read as the same double. @param {number} value */
export function typedText(value) {
  return generalText(value, [15, 16, 17].find((digits) => Number(value.toPrecision(digits)) === value) ?? 17);
}

// Unlike a plain group, one in a look-ahead is not shortened where the rest does not fit: 5e3.5 is no 5 with a unit.
const NUMBER = /^(?=([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))\1\s*([\p{L}\p{Nl}\p{No}].*|[°%]|1?\/.*)?$/u;
// A decimal comma; before three digits it may part thousands, and between long numbers two of them.
const COMMA = /^([+-]?\d+),(?!\d{3}(?!\d)|(?<=\d{2},)\d{3})(\d+)(?!\d|.*,)/s;
const NOT_FINITE = /^[+-]?(nan|inf|infinity)(?![a-z])/i;
const DECIMALS = 1100; // the middle between two doubles has fewer

/** A unit as it is looked up: people type hz and MM, and there are two micro signs. @param {string} unit */
const folded = (unit) => unit.replace(/\s*\/\s*/g, "/").toLowerCase().replace("\u{b5}", "\u{3bc}");

/** The double nearest to a decimal text times a fraction. @param {string} digits @param {[number, number]} fraction */
function timesFraction(digits, [over, under]) {
  const [mantissa, exponent = "0"] = digits.replace(/^[+-]/, "").toLowerCase().split("e");
  const [whole, decimals = ""] = mantissa.split(".");
  const power = Number(exponent) - decimals.length + DECIMALS;
  const numerator = BigInt(whole + decimals) * BigInt(over) * 10n ** BigInt(Math.max(power, 0));
  const denominator = BigInt(under) * 10n ** BigInt(Math.max(-power, 0));
  const rest = numerator % denominator ? 1 : 0; // on which side of such a middle it lies
  return Number(`${digits.startsWith("-") ? "-" : ""}${numerator / denominator}${rest}e${-DECIMALS - 1}`);
}

/** A number with a hyphen for a minus sign, and a point for a decimal comma. @param {string} text */
function plainText(text) {
  const minus = text.trim().replaceAll("\u{2212}", "-");
  return minus.length > 40 ? minus : minus.replace(COMMA, "$1.$2");
}

/** Read a number that may carry a unit: the double nearest to it in the unit outside, as vibro reads it.
 * @param {Quantity} quantity @param {string} text @returns {number} */
export function numberIn({ label, unit, sizes }, text) {
  const plain = plainText(text);
  const named = `${label} = '${cutText(text)}'`;
  if (plain.length > LONGEST) throw new Refusal(`${named}: longer than ${LONGEST} characters`, "17 digits are enough");
  const [, digits, given = ""] = NUMBER.exec(plain) ?? [];
  if (!digits && !NOT_FINITE.test(plain)) throw new Refusal(`${named}: not a number`, `write it like ${unit ? `1.5${unit}` : "0.5"}`);
  const known = Object.entries(sizes);
  const size = given ? known.find(([name]) => folded(name) === folded(given))?.[1] : /** @type {[number, number]} */ ([1, 1]);
  if (digits && !size) {
    const remedy = unit ? `its units are ${known.map(([name]) => name).join(", ")}` : "it is a pure number, or one in %";
    throw new Refusal(`${named}: '${cutText(given)}' is no unit of ${label}`, remedy);
  }
  const rounded = Number(digits); // first, so that powers of ten below stay small
  const value = size && rounded && Number.isFinite(rounded) && size[0] !== size[1] ? timesFraction(digits, size) : rounded;
  if (!Number.isFinite(value)) throw new Refusal(`${label} = ${cutText(text.trim())}: must be a finite number`);
  return value + 0; // not -0
}

/** Whether a quantity may have a value; compared in SI units, as the solver does. @param {Quantity} quantity @param {number} value */
function allows({ si, per_si, low, high, with_low, with_high }, value) {
  const inside = (/** @type {number} */ x) => (si === 1 ? x / per_si : x * si);
  const [x, least, most] = [value, low, high].map(inside);
  return (with_low ? x >= least : x > least) && (with_high ? x <= most : x < most);
}

/** What a quantity may be, as messages say it. @param {Quantity} quantity */
function allowedText({ unit, low, high, with_low, with_high }) {
  const [least, most] = [low, high].map((end) => generalText(end, 6));
  const above = low === -Infinity ? "finite" : `finite and ${with_low ? ">=" : ">"} ${least}`;
  const inside = `in ${with_low ? "[" : "("}${least}, ${most}${with_high ? "]" : ")"}`;
  return `${high === Infinity ? above : inside} ${unit}`.trim();
}

/** A value with its unit. @param {Quantity} quantity @param {number} value */
const withUnit = ({ label, unit }, value) => `${label} = ${generalText(value, 15)} ${unit}`.trim();

/** Read a number, and check its range. @param {Quantity} quantity @param {string} text */
function valueIn(quantity, text) {
  if (/[:,]/.test(plainText(text))) throw new Refusal(`${quantity.label} = ${cutText(text)}: it takes one value`, ONE_VALUE);
  const value = numberIn(quantity, text);
  if (!allows(quantity, value)) throw new Refusal(`${withUnit(quantity, value)}: must be ${allowedText(quantity)}`);
  return value;
}

// ------------------------------------------------------------------------------
// What a scene has

/** Drives of a scene by name: those of the page, its machine, and its motion where no slider makes that.
 * @param {PageData} data @param {number} scene @returns {Record<string, DriveKind>} */
export function drivesOf(data, scene) {
  const { given, machine } = data.scenes[scene];
  return { ...(machine && { machine }), ...data.drives, ...(given && { given }) };
}

/** Quantities that a drive has, by name, in the order of the page. @param {PageData} data @param {DriveKind} drive */
export function quantitiesOf(data, drive) {
  return Object.keys(data.quantities).filter((name) =>
    data.quantities[name].control && (BODY.includes(name) || drive.quantities.includes(name)));
}

/** The slider of a quantity, and its usual axis. @param {PageData} data @param {number} scene @param {string} name */
export function controlOf(data, scene, name) {
  const own = data.scenes[scene].controls;
  return Object.hasOwn(own, name) ? own[name] : /** @type {Control} */ (data.quantities[name].control);
}

/** All keys of a scene with their texts at the start. @param {PageData} data @param {number} scene @returns {Texts} */
export function initialTexts(data, scene) {
  const names = new Set(Object.values(drivesOf(data, scene)).flatMap((drive) => quantitiesOf(data, drive)));
  names.delete("friction_ratio"); // it follows from both frictions
  const usual = [...names].map((name) => [data.quantities[name].column, data.quantities[name].start]);
  return { ...CHOICES, ...Object.fromEntries(usual), ...data.scenes[scene].state };
}

/** Keys that a drive leaves idle: quantities of the others. @param {PageData} data @param {number} scene @param {string} drive */
function idleKeys(data, scene, drive) {
  const drives = drivesOf(data, scene);
  const own = Object.hasOwn(drives, drive) ? quantitiesOf(data, drives[drive]) : Object.keys(data.quantities);
  return Object.entries(data.quantities).filter(([name]) => !own.includes(name)).map(([, { column }]) => column);
}

// ------------------------------------------------------------------------------
// The state

/** Fill up the texts of an address with those at the start. A drive of its own has axes of its own, and an axis
 * has a range of its own. @param {PageData} data @param {number} scene @param {Texts} texts @returns {Texts} */
function filledTexts(data, scene, texts) {
  const initial = initialTexts(data, scene);
  const filled = { ...initial };
  const given = new Map(Object.entries(texts)); // an address may name anything: objects have constructor and more
  for (const key of ["x", "y"]) {
    if ((given.get("drive") ?? initial.drive) !== initial.drive) filled[key] = "";
    if ((given.get(key) ?? filled[key]) !== initial[key]) filled[`${key}_range`] = "";
  }
  for (const [key, text] of given) if (Object.hasOwn(initial, key)) filled[key] = String(text).trim();
  return filled;
}

/** Texts that are read, and what is refused of them. */
class Reading {
  /** @param {PageData} data @param {number} scene @param {Texts} given */
  constructor(data, scene, given) {
    this.data = data;
    this.scene = scene;
    this.texts = filledTexts(data, scene, given);
    this.unknown = Object.keys(given).filter((key) => !Object.hasOwn(this.texts, key));
    this.drives = drivesOf(data, scene);
    this.problems = /** @type {Problem[]} */ ([]);
  }

  /** @param {string} field @param {string} text @param {string} [hint] */
  wrong(field, text, hint) {
    this.problems.push({ field, text: hint ? `${text} (${hint})` : text });
  }

  /** Read, and note what is refused. @template T @param {string} field @param {() => T} read @returns {T | undefined} */
  take(field, read) {
    try {
      return read();
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.wrong(error.field || field, error.message, error.hint);
    }
  }

  /** Check keys and choices, on which the meaning of all others depends. */
  checkChoices() {
    const { data, drives, texts } = this;
    for (const key of this.unknown) this.wrong("", `unknown key '${cutText(key)}'`, "leave it out");
    const known = { drive: Object.keys(drives), view: Object.keys(data.views), follow: ["0", "1"] };
    for (const [key, choices] of Object.entries(known)) {
      if (!choices.includes(texts[key])) this.wrong(key, `${key} = '${cutText(texts[key])}': must be ${choices.join(", ")}`);
    }
    if (/^([1-9]|1\d|20)$/.test(texts.cycles)) return;
    this.wrong("cycles", `cycles = '${cutText(texts.cycles)}': must be a whole number from 1 to ${MOST_CYCLES}`);
  }

  /** The text that distinguishes drives of scene files; an address does not hold these, and must not show another. */
  motion() {
    const { scene, data: { scenes }, texts: { drive, motion } } = this;
    const own = ["given", "machine"].includes(drive) ? scenes[scene].state.motion : "";
    const what = drive === "machine" ? "machine" : "motion";
    const said = `the link is of another ${what} than that of the scene`;
    if (own && motion && motion !== own) this.wrong("drive", said, "open it in the page that it was made with");
    return own;
  }

  /** The operating point. @param {string[]} names @returns {Values} */
  values(names) {
    const { data: { quantities, scenes }, texts } = this;
    const values = /** @type {Values} */ ({ ...(texts.drive === "given" ? scenes[this.scene].given?.values : {}) });
    for (const name of names) {
      const text = texts[quantities[name].column];
      if (name === "friction_ratio" || (name === "trough_length" && !text)) continue;
      const value = this.take(quantities[name].column, () => valueIn(this.quantity(name, names), text));
      if (value !== undefined) values[name] = value;
    }
    const { static_friction: most, kinetic_friction: kinetic } = values;
    if (kinetic > most) {
      const said = `${withUnit(quantities.kinetic_friction, kinetic)}: must be at most ${withUnit(quantities.static_friction, most)}`;
      this.wrong("kinetic_friction", said, "friction at rest is the larger one: give both, or exchange them");
    }
    const lifting = names.find((name) => name.startsWith("normal_amplitude") && values[name] > 0);
    if (lifting && "normal_acceleration" in values) {
      const said = `${withUnit(quantities[lifting], values[lifting])} beside ${quantities.normal_acceleration.label}`;
      this.wrong(quantities[lifting].column, `${said}: the trough of a clamped part moves along itself alone`, "write 0");
    }
    return { ...values, friction_ratio: most ? kinetic / most : 1 };
  }

  /** A quantity as this drive may have it: a clamped part may hang on a vertical trough. @param {string} name @param {string[]} names */
  quantity(name, names) {
    const quantity = this.data.quantities[name];
    const mayHang = name === "trough_angle" && names.includes("normal_acceleration");
    return mayHang ? { ...quantity, with_low: true, with_high: true } : quantity;
  }

  /** An axis of the map. @param {"x" | "y"} key @param {string[]} names @param {Values} values @returns {Axis} */
  axis(key, names, values) {
    const { data: { quantities }, texts } = this;
    const swept = names.filter((name) => quantities[name].control?.axis);
    const chosen = texts[key];
    const name = chosen ? swept.find((name) => quantities[name].column === chosen) : this.drives[texts.drive][key];
    if (!name) {
      const known = swept.map((name) => quantities[name].column);
      throw new Refusal(`${key} = '${cutText(chosen)}': no axis of this drive`, `choose from ${known.join(", ")}`, key);
    }
    const text = texts[`${key}_range`] || this.usualRange(name, values[name]);
    const said = `${quantities[name].label} = ${cutText(text)}`;
    const parts = text.split(":").map((part) => part.trim());
    const log = parts.length === 3 && parts[2].toLowerCase() === "log";
    if (parts.length !== (log ? 3 : 2) || !parts.every(Boolean)) throw new Refusal(`${said}: must be a range`, "write it like 0.1:3");
    const quantity = this.quantity(name, names);
    const [from, to] = parts.slice(0, 2).map((end) => numberIn(quantity, end));
    if (to <= from) throw new Refusal(`${said}: the range does not ascend`, to < from ? `write ${parts[1]}:${parts[0]}` : "give it two ends");
    if (log && from <= 0) throw new Refusal(`${said}: a logarithmic range must start above 0`, "start it above 0, or leave log out");
    if (!allows(quantity, from) || !allows(quantity, to)) throw new Refusal(`${said}: must be ${allowedText(quantity)}`);
    if (to - from < CLOSE * Math.max(Math.abs(from), Math.abs(to))) throw new Refusal(`${said}: its ends are too close for doubles`, "give a wider range");
    return { name, from, to, log };
  }

  /** The range of a newly chosen axis; where it misses the operating point, one around that.
   * @param {string} name @param {number} value */
  usualRange(name, value) {
    const text = controlOf(this.data, this.scene, name).axis;
    const [low, high] = text.split(":").map(Number);
    const isOutside = (value > 0 && value < low) || value > high;
    if (!isOutside || !allows(this.data.quantities[name], value * AROUND)) return text;
    return [value / AROUND, value * AROUND].map((end) => generalText(end, 3)).join(":");
  }

  /** What is not known exactly: pairs of ends by name. @param {(string | undefined)[]} drawn @param {Values} values */
  bands(drawn, values) {
    const bands = /** @type {Record<string, [number, number]>} */ ({});
    for (const name of [...FRICTIONS, "restitution"]) {
      const text = this.texts[`${name}_band`];
      const ends = text && this.take(`${name}_band`, () => this.band(name, text, drawn));
      if (ends) bands[name] = ends;
    }
    const { static_friction: most, kinetic_friction: kinetic, friction_ratio: ratio } = bands;
    if (kinetic && ratio) this.wrong("friction_ratio_band", "kinetic friction has a band too", "leave one of them out");
    const follows = ratio || (this.texts.follow === "1" && !kinetic);
    const least = kinetic?.[0] ?? values.kinetic_friction, largest = most?.[1] ?? values.static_friction;
    if ((most || kinetic) && !follows && least > largest) {
      const said = `kinetic friction = ${typedText(least)} and more: must reach down to static friction = ${typedText(largest)}`;
      this.wrong(kinetic ? "kinetic_friction_band" : "static_friction_band", said);
    }
    return bands;
  }

  /** @param {string} name @param {string} text @param {(string | undefined)[]} drawn @returns {[number, number]} */
  band(name, text, drawn) {
    const quantity = this.data.quantities[name];
    const rivals = name === "restitution" ? [name] : FRICTIONS;
    if (drawn.some((axis) => axis && rivals.includes(axis))) {
      const what = name === "restitution" ? name : "a friction";
      throw new Refusal(`${what} that is an axis of the map cannot have a band`, "choose other axes, or leave the band out");
    }
    const [low, high = low, ...more] = text.split(":");
    const ends = /** @type {[number, number]} */ ([low, more.length ? text : high].map((end) => valueIn(quantity, end)));
    if (ends[0] > ends[1]) throw new Refusal(`${quantity.label} = ${cutText(text)}: the band does not ascend`, "swap its ends");
    if (name === "static_friction" && !ends[0]) throw new Refusal("bodies without static friction have no regime", "begin the band above 0");
    return ends;
  }
}

/** Read and check a state. Nothing is thrown: without a state there are problems, which name field, value and remedy.
 * @param {PageData} data @param {number} scene @param {Texts} given keys that differ from the start
 * @returns {{state: Shown | null, problems: Problem[]}} */
export function stateOf(data, scene, given) {
  const reading = new Reading(data, scene, given);
  const { texts, problems } = reading;
  const { quantities } = data;
  reading.checkChoices();
  if (problems.length) return { state: null, problems };
  const motion = reading.motion();
  const names = quantitiesOf(data, reading.drives[texts.drive]);
  const values = reading.values(names);
  const [x, y] = /** @type {const} */ (["x", "y"]).map((key) => reading.take(`${key}_range`, () => reading.axis(key, names, values)));
  const drawn = [x?.name, y?.name];
  if (x && x.name === y?.name) reading.wrong("y", `x and y are both ${quantities[x.name].label}`, "choose two quantities");
  else if (drawn.includes("friction_ratio") && drawn.includes("kinetic_friction")) {
    reading.wrong("y", "friction ratio and kinetic friction describe the same", "choose one of them");
  }
  const bands = reading.bands(drawn, values);
  const target = texts.target ? reading.take("target", () => valueIn(quantities.speed, texts.target)) ?? null : null;
  if (texts.view === "traverse" && !texts.trough_length_mm) {
    reading.wrong("trough_length_mm", "the traverse time needs the length of the trough", "give it");
  }
  if (problems.length || !x || !y) return { state: null, problems };

  const typed = names.filter((name) => name in values && name !== "friction_ratio").map((name) => [quantities[name].column, typedText(values[name])]);
  const axes = Object.entries({ x, y }).flatMap(([key, { name, from, to, log }]) => [
    [key, quantities[name].column], [`${key}_range`, [typedText(from), typedText(to), ...(log ? ["log"] : [])].join(":")]]);
  const banded = Object.entries(bands).map(([name, ends]) => [`${name}_band`, ends.map(typedText).join(":")]);
  const canonical = { ...texts, motion, target: target === null ? "" : typedText(target), ...Object.fromEntries([...typed, ...axes, ...banded]) };
  const { given: motionGiven, machine } = data.scenes[scene];
  return { problems, state: {
    texts: canonical, scene, drive: texts.drive, values, x, y, bands, target,
    given: texts.drive === "given" ? motionGiven : null, machine: texts.drive === "machine" ? machine : null,
    view: texts.view, cycles: Number(texts.cycles), follows: texts.follow === "1",
  } };
}

// ------------------------------------------------------------------------------
// Changes, and the address

const PAUSE = 1000; // [ms] after which a further change by the same control gets an entry of its own
const REWRITE = 300; // [ms] between the addresses of a drag: browsers refuse too many of them
const FEW = 4; // digits of what follows from a hand's move

/** The address of a state: all that it has, so that a link shows the same from another page of the same scene.
 * @param {PageData} data @param {number} scene @param {Texts} texts */
export function addressOf(data, scene, texts) {
  const initial = initialTexts(data, scene);
  const idle = idleKeys(data, scene, texts.drive);
  const kept = Object.entries(texts).filter(([key, text]) => (text || initial[key]) && !idle.includes(key));
  const told = scene ? [["scene", String(scene + 1)], ...kept] : kept;
  return `#${new URLSearchParams(told).toString().replaceAll("%3A", ":")}`;
}

/** The scene and the state of an address. @param {PageData} data @param {string} fragment */
export function readAddress(data, fragment) {
  const { scene: number = "1", ...texts } = Object.fromEntries(new URLSearchParams(fragment.slice(1)));
  if (Object.hasOwn(data.scenes, String(Number(number) - 1))) return { scene: Number(number) - 1, texts, problems: [] };
  const text = `scene = '${cutText(number)}': must be a whole number from 1 to ${data.scenes.length}`;
  return { scene: 0, texts, problems: [{ field: "", text }] };
}

/** Bands of a state that had none, a tenth to either side; and those that it has, where kinetic friction comes to
 * follow static friction, or no longer does. @param {Shown} state @param {boolean} follows @returns {Texts} */
export function bandsIf({ values, bands }, follows) {
  const { static_friction: most, kinetic_friction: kinetic } = values;
  const scaled = (/** @type {number[]} */ ends, /** @type {number} */ by) => ends.map((end) => end * by);
  const { kinetic_friction: own, friction_ratio: ratio, ...others } = bands;
  const wanted = /** @type {Record<string, number[]>} */ ({ static_friction: scaled([0.9, 1.1], most), ...others });
  const shares = ratio ?? (own && most ? scaled(own, 1 / most).map((end) => Math.min(end, 1)) : null);
  if (follows && shares) wanted.friction_ratio = shares;
  if (!follows) wanted.kinetic_friction = own ?? scaled(ratio ?? [0.9, 1.1], ratio ? most : kinetic);
  return Object.fromEntries(Object.entries(wanted).map(([name, ends]) => [`${name}_band`, ends.map((end) => generalText(end, FEW)).join(":")]));
}

/** The states of all scenes of the page, of which one is shown. @typedef {ReturnType<typeof createStore>} Store */
export function createStore(/** @type {PageData} */ data) {
  const tabs = data.scenes.map((_, scene) => {
    const { state, problems } = stateOf(data, scene, {});
    return {
      texts: state?.texts ?? initialTexts(data, scene), // as they were typed
      state, // the last one that was valid
      problems, // of the texts
      ratio: NaN, // of kinetic to static friction, as it was last set by hand
    };
  });
  let scene = 0;
  let changer = ""; // the control that changed the state last
  let until = 0; // what it does is the same change [ms]
  let written = 0; // [ms] when the address was

  /** Show a state. @param {number} number @param {Texts} texts */
  function settle(number, texts) {
    const tab = tabs[(scene = number)];
    const { state, problems } = stateOf(data, scene, texts);
    Object.assign(tab, { texts: state?.texts ?? texts, problems });
    if (state) tab.state = state;
    if (!(tab.ratio >= 0)) keepRatio();
  }

  function keepRatio() {
    tabs[scene].ratio = Math.min(tabs[scene].state?.values.friction_ratio ?? NaN, 1);
  }

  /** A number among texts, NaN where that is none. @param {Texts} texts @param {string} name */
  function numberOf(texts, name) {
    try {
      return numberIn(data.quantities[name], texts[name]);
    } catch {
      return NaN;
    }
  }

  /** Write the address; browsers refuse that in some frames and after too many. @param {boolean} isNew */
  function write(isNew) {
    const address = addressOf(data, scene, tabs[scene].texts);
    try {
      if (isNew && address !== location.hash) history.pushState(null, "", address);
      else history.replaceState(null, "", address);
    } catch { /* the page works without it */ }
  }

  return {
    tabs,
    get scene() { return scene; },
    get state() { return tabs[scene].state; },
    get texts() { return tabs[scene].texts; },
    get problems() { return tabs[scene].problems; },

    /** A number of the operating point. @param {string} name @returns {number} */
    value: (name) => tabs[scene].state?.values[name] ?? NaN,

    /** Take over an address; of one that cannot be read the problems are returned, and the start is shown.
     * @param {string} fragment @returns {Problem[]} */
    read(fragment) {
      const { scene: number, texts, problems } = readAddress(data, fragment);
      const wrong = [...problems, ...stateOf(data, number, texts).problems];
      [changer, tabs[number].ratio] = ["", NaN];
      settle(number, wrong.length ? initialTexts(data, number) : filledTexts(data, number, texts));
      if (fragment.length > 1 && !wrong.length) write(false); // in canonical spelling: 0.8 for 800um
      return wrong;
    },

    /** Show another scene. @param {number} number */
    open(number) {
      [scene, changer] = [number, ""];
      write(true);
    },

    /** Change some keys, and the address with them.
     * @param {Texts} patch @param {string} control @param {boolean} isFinished */
    change({ friction_ratio: wanted, ...patch }, control, isFinished) {
      const tab = tabs[scene];
      const texts = { ...tab.texts, ...patch };
      const most = numberOf(texts, "static_friction");
      const atMost = (/** @type {number} */ kinetic) => typedText(Math.min(Number(kinetic.toPrecision(FEW)), most));
      if (wanted !== undefined) texts.kinetic_friction = atMost(Number(wanted) * most);
      else if ("static_friction" in patch && !("kinetic_friction" in patch) && most >= 0) {
        if (texts.follow === "1" && tab.ratio >= 0) texts.kinetic_friction = atMost(tab.ratio * most);
        else if (numberOf(texts, "kinetic_friction") > most) texts.kinetic_friction = typedText(most);
      }
      const isSet = wanted !== undefined || "kinetic_friction" in patch || tab.texts.follow !== texts.follow;
      settle(scene, texts);
      if (isSet) keepRatio();

      const now = performance.now();
      const goesOn = control === changer && now < until;
      if (goesOn && !isFinished && now < written + REWRITE) return;
      write(!goesOn);
      [written, changer, until] = [now, control, isFinished ? now + PAUSE : Infinity];
    },
  };
}
