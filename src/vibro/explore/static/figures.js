/** Figures as vibro.answers.answer writes them for people. */

import { evenText, generalText } from "./typed.js";

const LEAST_ERRORS = [1e-9, 1e-12]; // of a value, and of its unit: nobody measures with less error

/** As Python's `z.2f`. @param {number} value @param {number} decimals */
function fixedText(value, decimals) {
  const exact = value.toFixed(100);
  const text = evenText(value.toFixed(decimals), exact, exact.indexOf(".") + 1 + decimals);
  return /[1-9]/.test(text) ? text : text.replace("-", "");
}

/** The power of ten of a number's first digit. @param {number} value */
const powerOf = (value) => Number(value.toExponential().split("e")[1]);

/** A value for people, a number to some digits, nothing for null. @param {number | string | null} value */
export function shownText(value, digits = 4) {
  if (typeof value !== "number") return value ?? "";
  if (Number.isNaN(value)) return "-";
  return generalText(value, digits).replace("Infinity", "inf");
}

/** A value with its standard error, to two digits of that; one without, or exact, to some digits.
 * @param {number} value @param {number} error */
export function uncertainText(value, error, digits = 4) {
  const isSeen = Math.max(LEAST_ERRORS[0] * Math.abs(value), LEAST_ERRORS[1]) < error && error < Infinity;
  if (!isSeen) return shownText(value, digits);
  const decimals = Math.max(0, 1 - powerOf(error));
  return `${fixedText(value, decimals)} \u00b1 ${fixedText(error, decimals)}`;
}

/** Three digits, zeros at the end among them. @param {number} value */
export function briefText(value) {
  const size = Math.abs(value);
  if (!(size >= 1e-4 && size < 1e6)) return shownText(value, 3);
  return fixedText(value, Math.max(0, 2 - powerOf(size)));
}

/** A text with its parts in their places: `{speed} mm/s`.
 * @param {string} text @param {Record<string, string | number>} parts */
export const filledText = (text, parts) => text.replace(/\{(\w+)\}/g, (_, name) => String(parts[name]));
