// SPDX-License-Identifier: Apache-2.0
// Allan deviation over averaging time of three sensors of a unit, both axes logarithmic.

import { allanOfWhite, grid, LogAxis, svg } from "./axes.mjs";
import { significant } from "./format.mjs";
import { Plot } from "./plot.mjs";
import { T } from "./text.mjs";

const MARGIN = { top: 24, right: 14, bottom: 44, left: 52 };
const AXES = ["x", "y", "z"];
const ROOM = 1.25; // factor left above and below the lines
const RESTING_S = 1;

/** What is shown of each kind of sensor: the document's numbers are too small to read. */
export const KINDS = {
  gyro: { unit: "m°/s", factor: 1000 },
  accel: { unit: "mm/s²", factor: 1000 },
};

export class AllanChart extends Plot {
  #tau_s = [];
  #kind = "gyro";
  #lines = [];
  #allowed = []; // a line, or none

  /** `host` holds the drawing, `legend` (a list) the names and values. */
  constructor(host, legend) {
    super(host, legend, MARGIN);
    this.show(null, "gyro", null);
  }

  /** The document of GET /noise, or null; `kind`: "gyro" or "accel"; `limit`: density that the type allows, or null. */
  show(noise, kind, limit) {
    this.#tau_s = noise?.tau_s ?? [];
    this.#kind = kind;
    this.#lines = AXES.map((axis, i) => {
      const values = noise?.sensors[`${kind}_${axis}`].oadev ?? [];
      const shown = values.map((value) => (value > 0 ? value * KINDS[kind].factor : null));
      return { name: axis, style: `unit-${i}`, values: shown };
    });
    const allowed = this.#tau_s.map((tau_s) => allanOfWhite(limit, tau_s) * KINDS[kind].factor);
    this.#allowed = limit === null || this.empty ? [] : [{ name: T.noise.allowed, style: "limit", values: allowed }];
    if (this.cursor >= this.#tau_s.length) this.moveCursor(null);
    this.redraw();
  }

  /** Whether there is nothing to show. */
  get empty() {
    return this.#lines.every(({ values }) => values.every((value) => value === null));
  }

  get title() {
    return T.noise.label[this.#kind];
  }

  get abscissae() {
    return this.#tau_s;
  }

  get lines() {
    return [...this.#lines, ...this.#allowed];
  }

  /** The averaging time nearest to 1 s. */
  get resting() {
    const distance = (tau_s) => Math.abs(tau_s - RESTING_S);
    return this.#tau_s.reduce((best, tau_s, i) => (distance(tau_s) < distance(this.#tau_s[best]) ? i : best), 0);
  }

  text(value) {
    return `${significant(value, 3)} ${KINDS[this.#kind].unit}`;
  }

  where(index) {
    return T.noise.at(significant(this.#tau_s[index], 3));
  }

  get axes() {
    return { x: new LogAxis(...this.#times()), y: new LogAxis(...this.#range()) };
  }

  grid(box) {
    if (this.empty) return [];
    const { x, y } = this.axes;
    const name = T.noise.ordinate(KINDS[this.#kind].unit);
    const guides = this.#guides(x.scale(box.left, box.right), y.scale(box.bottom, box.top));
    return [...guides, ...grid(box, x, y, T.noise.abscissa, name)];
  }

  /** σ = c / √τ for each power of ten c, as far as the chart reaches. */
  #guides(x, y) {
    const [t0, t1] = this.#times();
    const [low, high] = this.#range();
    const nodes = [];
    const last = Math.floor(Math.log10(high * Math.sqrt(t1)));
    for (let k = Math.ceil(Math.log10(low * Math.sqrt(t0))); k <= last; ++k) {
      const c = 10 ** k;
      const [from, to] = [Math.max(t0, (c / high) ** 2), Math.min(t1, (c / low) ** 2)];
      const [y1, y2] = [from, to].map((tau_s) => y(c / Math.sqrt(tau_s)));
      nodes.push(svg("line", { x1: x(from), x2: x(to), y1, y2, class: "guide" }));
    }
    return nodes;
  }

  #times() {
    const t0 = this.#tau_s[0] ?? 1;
    return [t0, Math.max(this.#tau_s.at(-1) ?? 1, 10 * t0)];
  }

  /** One decade at least. */
  #range() {
    const values = this.lines.flatMap((line) => line.values).filter((value) => value !== null);
    if (values.length === 0) return [1, 10];
    const [low, high] = [Math.min(...values) / ROOM, Math.max(...values) * ROOM];
    const widen = Math.max(1, Math.sqrt((10 * low) / high));
    return [low / widen, high * widen];
  }
}
