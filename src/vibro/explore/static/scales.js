/** Round numbers, and scales of colours, as vibro's pictures have them (vibro.plots.scales). */

import { numberText } from "./draw.js";

/** @typedef {[share: number, text: string]} ScaleTick
 * @typedef {object} Scale
 * @property {string} palette
 * @property {ScaleTick[] | null} ticks none where no number is seen
 * @property {number} low
 * @property {number} high
 * @property {(number: number) => number} share where a number lies, 0 to 1 */

/** Round numbers within a range, with at most so many steps. @param {number} low @param {number} high */
export function roundNumbers(low, high, isLog = false, most = 8) {
  const slack = 1e-9 * (high - low);
  const within = (/** @type {number} */ x) => x >= low - slack && x <= high + slack;
  if (isLog && high > 5.0 * low) return decades(low, high, high < 200.0 * low).filter(within);
  const unit = 10.0 ** Math.floor(Math.log10((high - low) / most));
  const steps = [1.0, 2.0, 2.5, 5.0, 10.0].map((size) => size * unit);
  const step = steps.find((size) => size * most >= high - low - slack) ?? 10.0 * unit;
  const first = Math.ceil((low - slack) / step);
  const count = Math.floor((high + slack) / step) - first + 1;
  return Array.from({ length: Math.max(count, 0) }, (_, n) => Number(((first + n) * step).toPrecision(12)));
}

/** The numbers 1, 2, 5, 10 ... about a range above 0, or powers of ten alone.
 * @param {number} low @param {number} high @param {boolean} isDense */
function decades(low, high, isDense) {
  const first = Math.floor(Math.log10(low));
  const powers = Array.from({ length: Math.ceil(Math.log10(high / low)) + 2 }, (_, n) => n + first);
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
  const seen = numbers.filter((x) => x >= low && x <= high);
  const ticks = seen.map((x) => /** @type {ScaleTick} */ ([share(x), numberText(x)]));
  return { palette, low, high, share, ticks };
}

// Speeds, or shares: from zero up, about zero where motion reverses, from the least number where all are alike,
// and logarithmic where few large ones would leave most others in one colour.
/** @param {Float64Array} seen @param {Float64Array} regular of motion that repeats with the drive
 * @param {Float64Array} calm in contact @param {boolean} reverses whether bodies surely move backwards */
export function speedScale(seen, regular, calm, reverses) {
  const even = (/** @type {string} */ palette, /** @type {number} */ low, /** @type {number} */ high) =>
    scaleAlong(palette, low, high, (x) => x, roundNumbers(low, high, false, 6));
  const ascending = seen.slice().sort();
  const [low, high] = [ascending[0], ascending[ascending.length - 1]];
  const sizes = low < 0.0 ? ascending.map(Math.abs).sort() : ascending;
  const largest = (/** @type {Float64Array} */ numbers) =>
    numbers.reduce((most, x) => Math.max(most, Math.abs(x)), 0.0);
  const [least, middle, most] = [0.0, 0.5, 1.0].map((share) => (sizes.length ? quantileOf(sizes, share) : 0.0));
  if (!most) return even("cividis", 0.0, 1.0);
  if (low * high > 0.0 && least > 0.5 * most) return even("cividis", low, high > low ? high : 1.01 * low);
  const usual = largest(calm);
  const isUneven = [3.0 * usual, 2.0 * largest(regular), 10.0 * middle].some((size) => size > 0.0 && size < most);
  if (!isUneven) return reverses ? even("RdBu", -most, most) : even("cividis", 0.0, Math.max(high, 0.01 * most));
  if (reverses) {
    const width = 0.25 * (usual || middle);
    const ticks = logTicks(width, most);
    return scaleAlong("RdBu", -most, most, (x) => Math.asinh(x / width), [...ticks.map((x) => -x), 0.0, ...ticks]);
  }
  const foot = Math.min(Math.max(quantileOf(ascending.filter((x) => x > 0.0), 0.02), 1e-5 * high), 0.5 * high);
  return scaleAlong("cividis", foot, high, (x) => Math.log(Math.max(x, foot)), logTicks(foot, high));
}

/** Times: logarithmic; near rest they grow without bound. @param {Float64Array} seen */
export function timeScale(seen) {
  const ascending = seen.slice().sort();
  const bottom = ascending[0] ?? 1.0;
  const top = Math.max(1.01 * bottom, Math.min(seen.length ? quantileOf(ascending, 0.98) : 2.0, 1e5 * bottom));
  const numbers = top > 5.0 * bottom ? logTicks(bottom, top) : roundNumbers(bottom, top);
  return scaleAlong("cividis_r", bottom, top, Math.log, numbers);
}
