/** What the page shows: texts of its address, read and checked. The solver gets no other input. */

import { Refusal, allowedText, allows, cutText, generalText, numberIn, typedText, valueIn, withUnit } from "./typed.js";

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
 * @property {[number, number]} usual
 * @property {[string, string]} doubts about values below and above the usual ones
 * @property {string} meaning
 * @property {number} order
 * @property {Control | null} control
 * @typedef {{label: string, quantities: string[], x: string, y: string}} DriveKind
 * @typedef {DriveKind & {kind: string, values: Values, motion: any, table: string[]}} GivenDrive
 * @typedef {DriveKind & {packs: Record<string, number>, fields: any, own: Values, table: Texts}} GivenMachine
 * @typedef {object} Scene
 * @property {string} name
 * @property {string} file begins the names of its downloads
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

const BODY = ["frequency", "static_friction", "friction_ratio", "kinetic_friction", "trough_angle", "restitution",
  "trough_length", "gravity"]; // quantities of all drives
const FRICTIONS = ["static_friction", "kinetic_friction", "friction_ratio"];
export const BANDED = [...FRICTIONS, "restitution"]; // what may have a band
const CYCLES = Array.from({ length: 20 }, (_, n) => String(n + 1)); // of a history: more could not be distinguished
const AROUND = 3; // factor between an operating point and the ends of an axis around it
const CLOSE = 1e-12; // least share of its values that an axis spans

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
  const texts = { ...data.scenes[scene].state };
  for (const name of names) texts[data.quantities[name].column] ??= data.quantities[name].start;
  return texts;
}

/** Keys that a drive leaves idle: quantities of the others.
 * @param {PageData} data @param {number} scene @param {string} drive */
export function idleKeys(data, scene, drive) {
  const drives = drivesOf(data, scene);
  const own = Object.hasOwn(drives, drive) ? quantitiesOf(data, drives[drive]) : Object.keys(data.quantities);
  return Object.entries(data.quantities).filter(([name]) => !own.includes(name)).map(([, { column }]) => column);
}

/** Whether bodies of bands have a ratio of kinetic to static friction, of which the operating point's kinetic friction
 * is only one case. @param {Pick<Shown, "bands" | "follows">} state */
export const hasRatio = ({ bands, follows }) =>
  Boolean(bands.friction_ratio || (bands.static_friction && follows && !bands.kinetic_friction));

/** The ends of quantities, both the same of those without a band.
 * @param {Record<string, number | undefined>} values @param {Shown} state */
export function spansOf(values, state) {
  const { bands, values: { friction_ratio: ratio } } = state;
  const spans = /** @type {Record<string, [number, number]>} */ ({});
  for (const [name, value] of Object.entries(values)) {
    if (value !== undefined) spans[name] = bands[name] ?? [value, value];
  }
  if (!hasRatio(state)) return spans;
  const { kinetic_friction: _, ...others } = spans;
  return { ...others, friction_ratio: bands.friction_ratio ?? [ratio, ratio] };
}

// ------------------------------------------------------------------------------
// The state

/** Fill up the texts of an address with those at the start. A drive of its own has axes of its own, and an axis
 * has a range of its own. @param {PageData} data @param {number} scene @param {Texts} texts @returns {Texts} */
export function filledTexts(data, scene, texts) {
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

  /** Read, and note what is refused. @template T @param {string} field @param {() => T} read
   * @returns {T | undefined} */
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
    const known = { drive: Object.keys(drives), view: Object.keys(data.views), follow: ["0", "1"], cycles: CYCLES };
    for (const [key, choices] of Object.entries(known)) {
      if (choices.includes(texts[key])) continue;
      const allowed = key === "cycles" ? `a whole number from 1 to ${CYCLES.length}` : choices.join(", ");
      this.wrong(key, `${key} = '${cutText(texts[key])}': must be ${allowed}`);
    }
  }

  /** The text that distinguishes drives of scene files; an address does not hold these, and must not show another. */
  motion() {
    const { scene, data: { scenes }, texts: { drive, motion } } = this;
    const own = ["given", "machine"].includes(drive) ? scenes[scene].state.motion : "";
    const what = drive === "machine" ? "machine" : "motion";
    const why = `the link is of another ${what} than that of the scene`;
    if (own && motion && motion !== own) this.wrong("drive", why, "open it in the page that it was made with");
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
      const allowed = withUnit(quantities.static_friction, most);
      const why = `${withUnit(quantities.kinetic_friction, kinetic)}: must be at most ${allowed}`;
      this.wrong("kinetic_friction", why, "friction at rest is the larger one: give both, or exchange them");
    }
    const lifting = names.find((name) => name.startsWith("normal_amplitude") && values[name] > 0);
    if (lifting && "normal_acceleration" in values) {
      const why = `${withUnit(quantities[lifting], values[lifting])} beside ${quantities.normal_acceleration.label}`;
      const rule = "the trough of a clamped part moves along itself alone";
      this.wrong(quantities[lifting].column, `${why}: ${rule}`, "write 0");
    }
    return { ...values, friction_ratio: most ? kinetic / most : 1 };
  }

  /** A quantity as this drive may have it: a clamped part may hang on a vertical trough.
   * @param {string} name @param {string[]} names */
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
    const quantity = this.quantity(name, names);
    const refuse = (/** @type {string} */ why, hint = "") => {
      throw new Refusal(`${quantity.label} = ${cutText(text)}: ${why}`, hint);
    };
    const [low, high, ...more] = text.split(":").map((part) => part.trim());
    const log = more[0]?.toLowerCase() === "log";
    if (!low || !high || more.length !== Number(log)) refuse("must be a range", "write it like 0.1:3");
    const [from, to] = [low, high].map((end) => numberIn(quantity, end));
    if (to <= from) refuse("the range does not ascend", to < from ? `write ${high}:${low}` : "give it two ends");
    if (log && from <= 0) refuse("a logarithmic range must start above 0", "start it above 0, or leave log out");
    if (!allows(quantity, from) || !allows(quantity, to)) refuse(`must be ${allowedText(quantity)}`);
    if (to - from < CLOSE * Math.max(to, -from)) refuse("its ends are too close for doubles", "give a wider range");
    return { name, from, to, log };
  }

  /** The range of a newly chosen axis; where it misses the operating point, one around that, as far as the quantity
   * may be so small. @param {string} name @param {number} value */
  usualRange(name, value) {
    const text = controlOf(this.data, this.scene, name).axis;
    const [low, high] = text.split(":").map(Number);
    const isOutside = (value > 0 && value < low) || value > high;
    if (!isOutside || !allows(this.data.quantities[name], value * AROUND)) return text;
    const least = Math.max(value / AROUND, this.data.quantities[name].low);
    return [least, value * AROUND].map((end) => generalText(end, 3)).join(":");
  }

  /** What is not known exactly: pairs of ends by name. @param {(string | undefined)[]} drawn @param {Values} values */
  bands(drawn, values) {
    const bands = /** @type {Record<string, [number, number]>} */ ({});
    for (const name of BANDED) {
      const text = this.texts[`${name}_band`];
      const ends = text && this.take(`${name}_band`, () => this.band(name, text, drawn));
      if (ends) bands[name] = ends;
    }
    const { static_friction: [, most] = [0, values.static_friction], kinetic_friction: kinetic } = bands;
    if (kinetic && bands.friction_ratio) {
      this.wrong("friction_ratio_band", "kinetic friction has a band too", "leave one of them out");
    }
    const isFree = (kinetic || bands.static_friction) && !hasRatio({ bands, follows: this.texts.follow === "1" });
    const least = kinetic ? kinetic[0] : values.kinetic_friction;
    if (isFree && least > most) {
      const reach = `must reach down to static friction = ${typedText(most)}`;
      const why = `kinetic friction = ${typedText(least)} and more: ${reach}`;
      this.wrong(kinetic ? "kinetic_friction_band" : "static_friction_band", why);
    }
    return bands;
  }

  /** @param {string} name @param {string} text @param {(string | undefined)[]} drawn @returns {[number, number]} */
  band(name, text, drawn) {
    const quantity = this.data.quantities[name];
    const rivals = name === "restitution" ? [name] : FRICTIONS;
    if (drawn.some((axis) => axis && rivals.includes(axis))) {
      const what = name === "restitution" ? name : "a friction";
      const why = `${what} that is an axis of the map cannot have a band`;
      throw new Refusal(why, "choose other axes, or leave the band out");
    }
    const [low, high = low, ...more] = text.split(":");
    const [least, most] = [low, more.length ? text : high].map((end) => valueIn(quantity, end));
    if (least > most) {
      throw new Refusal(`${quantity.label} = ${cutText(text)}: the band does not ascend`, "swap its ends");
    }
    if (name === "static_friction" && !least) {
      throw new Refusal("bodies without static friction have no regime", "begin the band above 0");
    }
    return [least, most];
  }

  /** All of it; null where something is refused. @returns {Shown | null} */
  state() {
    const { data: { quantities, scenes }, scene, texts } = this;
    this.checkChoices();
    if (this.problems.length) return null;
    const { drive, view } = texts;
    const motion = this.motion();
    const names = quantitiesOf(this.data, this.drives[drive]);
    const values = this.values(names);
    const axis = (/** @type {"x" | "y"} */ key) => this.take(`${key}_range`, () => this.axis(key, names, values));
    const [x, y] = [axis("x"), axis("y")];
    const drawn = [x?.name, y?.name];
    if (x && x.name === y?.name) {
      this.wrong("y", `x and y are both ${quantities[x.name].label}`, "choose two quantities");
    } else if (drawn.includes("friction_ratio") && drawn.includes("kinetic_friction")) {
      this.wrong("y", "friction ratio and kinetic friction describe the same", "choose one of them");
    }
    const bands = this.bands(drawn, values);
    const target = (texts.target && this.take("target", () => valueIn(quantities.speed, texts.target))) || null;
    if (view === "traverse" && !texts.trough_length_mm) {
      this.wrong("trough_length_mm", "the traverse time needs the length of the trough", "give it");
    }
    if (this.problems.length || !x || !y) return null;

    const given = drive === "given" ? scenes[scene].given : null;
    const machine = drive === "machine" ? scenes[scene].machine : null;
    const canonical = /** @type {Texts} */ ({ ...texts, motion, target: target === null ? "" : typedText(target) });
    for (const name of names) {
      if (name in values && name !== "friction_ratio") canonical[quantities[name].column] = typedText(values[name]);
    }
    for (const [key, { name, from, to, log }] of Object.entries({ x, y })) {
      canonical[key] = quantities[name].column;
      canonical[`${key}_range`] = `${typedText(from)}:${typedText(to)}${log ? ":log" : ""}`;
    }
    for (const [name, ends] of Object.entries(bands)) canonical[`${name}_band`] = ends.map(typedText).join(":");
    const chosen = { drive, view, cycles: Number(texts.cycles), follows: texts.follow === "1" };
    return { texts: canonical, scene, ...chosen, given, machine, values, x, y, target, bands };
  }
}

/** Read and check a state. Nothing is thrown: without a state there are problems, which name field, value and remedy.
 * @param {PageData} data @param {number} scene @param {Texts} given keys that differ from the start
 * @returns {{state: Shown | null, problems: Problem[]}} */
export function stateOf(data, scene, given) {
  const reading = new Reading(data, scene, given);
  return { state: reading.state(), problems: reading.problems };
}
