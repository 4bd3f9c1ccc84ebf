/** Numbers as people type them, with units and decimal commas: the doubles that vibro reads, and its messages. */

/** @typedef {import("./state.js").Quantity} Quantity */

const SAID = 60; // characters of a text that a message repeats
const LONGEST = 1000; // characters of a number: those of every double fit
const ONE_VALUE = "write 1.25 or 1250, not 1,250; axes are chosen at the map";

/** Why a text is refused: what it says and the remedy, perhaps of another field than the one that is read. */
export class Refusal extends Error {
  constructor(/** @type {string} */ text, hint = "", field = "") {
    super(text);
    this.hint = hint;
    this.field = field;
  }
}

/** A text within a message: on one line, and cut where it is long. @param {string} text */
export function cutText(text) {
  const long = text.length > SAID && `${text.slice(0, 36)}...${text.slice(-24)} (${text.length} characters)`;
  return (long || text).replace(/\p{C}|\p{Zl}|\p{Zp}/gu, "\u{fffd}");
}

/** Of two texts that are equally near to a number Python's formats take the even one, those of JavaScript the larger
 * one: correct it. @param {string} rounded @param {string} exact all digits of the number @param {number} cut the
 * first that is cut off */
export function evenText(rounded, exact, cut) {
  const wentUp = /^50*$/.test(exact.slice(cut)) && /[13579]$/.test(rounded);
  return wentUp ? rounded.slice(0, -1) + (Number(rounded.slice(-1)) - 1) : rounded;
}

/** A number as formats with a letter g write it: 0.0001, 1e-05, 1e+15. @param {number} value @param {number} digits */
export function generalText(value, digits) {
  if (!Number.isFinite(value)) return String(value);
  let [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  if (Number(value.toPrecision(digits + 1)) === value) {
    const [exact] = value.toExponential(100).split("e");
    mantissa = evenText(mantissa, exact, exact.length - 100 + digits - 1);
  }
  const power = Number(exponent);
  if (power >= -4 && power < digits) return String(Number(`${mantissa}e${exponent}`));
  return `${Number(mantissa)}e${exponent[0]}${exponent.slice(1).padStart(2, "0")}`;
}

/** A number as people type it, such that it is read as the same double. @param {number} value */
export function typedText(value) {
  return generalText(value, [15, 16, 17].find((digits) => Number(value.toPrecision(digits)) === value) ?? 17);
}

/** A text of the state as vibro prints it: 33.3333333333333 for 33.333333333333336. @param {string} text */
export function printedText(text) {
  const value = Number(text);
  return typedText(value) === text ? generalText(value, 15) : text;
}

// Unlike a plain group, one in a look-ahead is not shortened where the rest does not fit: 5e3.5 is no 5 with a unit.
const NUMBER = /^(?=([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))\1\s*([\p{L}\p{Nl}\p{No}].*|[°%]|1?\/.*)?$/u;
// A decimal comma; three digits after one may be thousands, and three or more after several are two numbers.
const COMMA = /^([+-]?(?:\d(?=,(?!\d{3}(?!\d)))|\d{2,}(?=,(?!\d{3})))),(\d+)(?!\d|.*,)/s;
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
  if (!digits && !NOT_FINITE.test(plain)) {
    throw new Refusal(`${named}: not a number`, `write it like ${unit ? `1.5${unit}` : "0.5"}`);
  }
  const known = Object.entries(sizes);
  const one = /** @type {[number, number]} */ ([1, 1]);
  const size = given ? known.find(([name]) => folded(name) === folded(given))?.[1] : one;
  if (digits && !size) {
    const units = `its units are ${known.map(([name]) => name).join(", ")}`;
    const remedy = unit ? units : "it is a pure number, or one in %";
    throw new Refusal(`${named}: '${cutText(given)}' is no unit of ${label}`, remedy);
  }
  const rounded = Number(digits); // first, so that powers of ten below stay small
  const isOther = size && rounded && Number.isFinite(rounded) && size[0] !== size[1];
  const value = isOther ? timesFraction(digits, size) : rounded;
  if (!Number.isFinite(value)) throw new Refusal(`${label} = ${cutText(text.trim())}: must be a finite number`);
  return value + 0; // not -0
}

/** Whether a quantity may have a value; compared in SI units, as the solver does.
 * @param {Quantity} quantity @param {number} value */
export function allows({ si, per_si, low, high, with_low, with_high }, value) {
  const inside = (/** @type {number} */ x) => (si === 1 ? x / per_si : x * si);
  const [x, least, most] = [value, low, high].map(inside);
  return (with_low ? x >= least : x > least) && (with_high ? x <= most : x < most);
}

/** What a quantity may be, as messages say it. @param {Quantity} quantity */
export function allowedText({ unit, low, high, with_low, with_high }) {
  const [least, most] = [low, high].map((end) => generalText(end, 6));
  const above = low === -Infinity ? "finite" : `finite and ${with_low ? ">=" : ">"} ${least}`;
  const inside = `in ${with_low ? "[" : "("}${least}, ${most}${with_high ? "]" : ")"}`;
  return `${high === Infinity ? above : inside} ${unit}`.trim();
}

/** A value with its unit. @param {Quantity} quantity @param {number} value */
export const withUnit = ({ label, unit }, value) => `${label} = ${generalText(value, 15)} ${unit}`.trim();

/** Read a number, and check its range. @param {Quantity} quantity @param {string} text */
export function valueIn(quantity, text) {
  if (/[:,]/.test(plainText(text))) {
    throw new Refusal(`${quantity.label} = ${cutText(text)}: it takes one value`, ONE_VALUE);
  }
  const value = numberIn(quantity, text);
  if (!allows(quantity, value)) throw new Refusal(`${withUnit(quantity, value)}: must be ${allowedText(quantity)}`);
  return value;
}
