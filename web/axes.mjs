// SPDX-License-Identifier: Apache-2.0
// What every drawing shares: axes with their round numbers, from what is drawn to pixels. SVG, so that colours come
// from the style sheet and the text is text.

import { number, written } from "./format.mjs";

const SVG = "http://www.w3.org/2000/svg";
const FEW_DECADES = 1.7; // with no more of them 2 and 5 are marked too

export function svg(name, attributes = {}, text = "") {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.textContent = text;
  return node;
}

/** The smallest of 1, 2, 5 × 10^k that is not below `raw`. */
export function niceStep(raw) {
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * ([1, 2, 5].find((m) => m * power >= raw) ?? 10);
}

/** The multiples of `step` from `low` to `high`. */
export function multiples(low, high, step) {
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(k * step);
  return found;
}

/** A linear axis; `low` < `high`. */
export class Axis {
  constructor(low, high) {
    this.low = low;
    this.high = high;
  }

  share(value) {
    return (value - this.low) / (this.high - this.low);
  }

  /** A function from values to pixels between those of `low` and `high`; what lies outside is drawn at the edge. */
  scale(from, to) {
    return (value) => from + this.share(Math.min(this.high, Math.max(this.low, value))) * (to - from);
  }

  /** Round values with their texts; no two nearer to each other than `apart` of all the `pixels`. */
  ticks(pixels, apart) {
    const step = niceStep(((this.high - this.low) * apart) / pixels);
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return multiples(this.low, this.high, step).map((value) => ({ value, text: number(value, decimals) }));
  }
}

/** A logarithmic axis; 0 < `low` < `high`. */
export class LogAxis extends Axis {
  share(value) {
    return Math.log(value / this.low) / Math.log(this.high / this.low);
  }

  ticks() {
    const mantissas = Math.log10(this.high / this.low) > FEW_DECADES ? [1] : [1, 2, 5];
    const found = [];
    for (let k = Math.floor(Math.log10(this.low)); k <= Math.log10(this.high); ++k) {
      found.push(...mantissas.map((m) => Number(`${m}e${k}`)).filter((v) => v >= this.low && v <= this.high));
    }
    const text = (value) => (value >= 1e-4 && value < 1e5 ? written(String(value)) : written(value.toExponential()));
    return found.map((value) => ({ value, text: text(value) }));
  }
}

const ROW_PIXELS = 22;
const COLUMN_PIXELS = 40;

/** Grid lines, numbers and names; without a name of the abscissa its numbers are left out too. `x`, `y`: axes. */
export function grid({ left, right, top, bottom }, x, y, xName, yName) {
  const nodes = [];
  const [toX, toY] = [x.scale(left, right), y.scale(bottom, top)];
  for (const { value, text } of y.ticks(bottom - top, ROW_PIXELS)) {
    nodes.push(svg("line", { x1: left, x2: right, y1: toY(value), y2: toY(value) }));
    nodes.push(svg("text", { x: left - 7, y: toY(value) + 4, "text-anchor": "end" }, text));
  }
  for (const { value, text } of x.ticks(right - left, COLUMN_PIXELS)) {
    nodes.push(svg("line", { x1: toX(value), x2: toX(value), y1: top, y2: bottom + 4 }));
    if (xName) nodes.push(svg("text", { x: toX(value), y: bottom + 18, "text-anchor": "middle" }, text));
  }
  if (xName) nodes.push(svg("text", { x: (left + right) / 2, y: bottom + 35, "text-anchor": "middle" }, xName));
  nodes.push(svg("text", { x: 4, y: top - 10 }, yName));
  return nodes;
}

/** The Allan deviation of white noise of that one-sided density: σ²(τ) = N²/τ, and N² is half of the density's square. */
export const allanOfWhite = (density, tau_s) => density / Math.sqrt(2 * tau_s);
