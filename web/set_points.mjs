// SPDX-License-Identifier: Apache-2.0
// Set points as people write them: a list, evenly spaced, there and back. Nothing here touches the page.

import { setTemperature, written } from "./format.mjs";

/** Most set points that a procedure has (docs/procedures.md). */
export const MOST_POINTS = 2000;

const hasDecimalComma = () => written("0.5").includes(",");

/** "−20, −10, 22.5"; with decimal commas "−20; −10; 22,5". */
export const listText = (points) => points.map(setTemperature).join(hasDecimalComma() ? "; " : ", ");

/** A number as somebody has typed it, in either language; NaN where it is none. */
export function typedNumber(text) {
  const plain = text.trim().replace(/[−–]/, "-").replace(",", ".");
  return /^[-+]?\d{1,6}(\.\d{1,6})?$/.test(plain) ? Number(plain) : NaN;
}

/**
 * Temperatures with commas, semicolons or blanks between them. Where decimals have a comma, one between two digits is that.
 * @param {string} text
 * @returns {{points: number[], wrong: string | null}} `wrong`: the first that is none
 */
export function typedList(text) {
  const plain = text.replace(/°\s*C?/gi, " ");
  const words = (hasDecimalComma() ? plain.replace(/(\d),(?=\d)/g, "$1.") : plain).split(/[\s,;]+/).filter(Boolean);
  const points = words.map(typedNumber);
  const wrong = points.findIndex((point) => Number.isNaN(point));
  return { points, wrong: wrong < 0 ? null : words[wrong] };
}

/**
 * From one temperature to another in steps; the last one is reached also where the steps do not end there. Null where that is no list, or too long.
 * @param {number} from
 * @param {number} to
 * @param {number} step
 */
export function evenList(from, to, step) {
  const steps = Math.abs(to - from) / step;
  if (!(step > 0) || Number.isNaN(steps) || steps > MOST_POINTS) return null;
  const whole = Math.floor(steps + 1e-9);
  const points = Array.from({ length: whole + 1 }, (_, i) => Number((from + Math.sign(to - from) * i * step).toFixed(6)));
  return steps - whole > 1e-9 ? [...points, to] : points;
}

/** Over the points, and back over all but the last. */
export const thereAndBack = (points) => [...points, ...points.slice(0, -1).reverse()];

/**
 * The points of the way there, where a course goes one way and back over the same ones; else null.
 * @param {number[]} points
 */
export function wayThere(points) {
  const there = points.slice(0, (points.length + 1) / 2);
  const isOneWay = there.every((point, i) => i === 0 || Math.sign(point - there[i - 1]) === Math.sign(there[1] - there[0]));
  const isBack = points.length > 2 && points.length % 2 === 1 && points.every((point, i) => point === points[points.length - 1 - i]);
  return isOneWay && isBack && there[0] !== there[1] ? there : null;
}
