// SPDX-License-Identifier: Apache-2.0
// What the charts share: lines over an abscissa, a cursor that pointer and arrow keys move, a legend that says the
// values there.

import { svg } from "./axes.mjs";
import { element } from "./dom.mjs";
import { T } from "./text.mjs";

/**
 * What a chart says that it shows.
 * @typedef {object} Shown
 * @property {number[]} abscissae of the points, rising
 * @property {{name: string, style: string, values: (number | null | undefined)[], steps?: boolean}[]} lines a value for each abscissa,
 *   null or undefined where it is not known; with `steps` each holds until the next
 * @property {string} title for those who cannot see it
 * @property {{x: any, y: any}} axes Axis of the abscissae, Axis of the values
 * @property {(box: {left: number, right: number, top: number, bottom: number}, axes: any) => Node[]} grid nodes behind the lines
 * @property {number} resting index of the point that the legend shows while there is no cursor
 * @property {(value: number) => string} text a value in the legend
 * @property {(index: number) => string} where what the legend says of that point itself, "" for nothing
 */

/** A chart derives from this and has the members of Shown. */
export class Plot {
  #host;
  #legend;
  #margin;
  #cursor = null; // index of a point
  #drawing = false;
  #shown = /** @type {Shown} */ (/** @type {unknown} */ (this));
  #x = (abscissa) => abscissa;

  /** `host` holds the drawing, `legend` (a list) the names and values. */
  constructor(host, legend, margin) {
    this.#host = host;
    this.#legend = legend;
    this.#margin = margin;
    host.tabIndex = 0;
    host.setAttribute("role", "img");
    host.addEventListener("pointermove", (event) => this.#pointAt(event.clientX - host.getBoundingClientRect().left));
    host.addEventListener("pointerleave", () => this.moveCursor(null));
    host.addEventListener("blur", () => this.moveCursor(null));
    host.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.redraw()).observe(host);
  }

  /** Index of the point that the user looks at, or null. */
  get cursor() {
    return this.#cursor;
  }

  moveCursor(index) {
    if (index === this.#cursor) return;
    this.#cursor = index;
    this.redraw();
  }

  /** Draws anew with the next frame. */
  redraw() {
    if (this.#drawing) return;
    this.#drawing = true;
    requestAnimationFrame(() => {
      this.#drawing = false;
      this.#draw();
    });
  }

  #draw() {
    const { clientWidth: width, clientHeight: height } = this.#host;
    const margin = this.#margin;
    const box = { left: margin.left, right: width - margin.right, top: margin.top, bottom: height - margin.bottom };
    if (box.right - box.left < 20 || box.bottom - box.top < 10) return;
    const axes = this.#shown.axes;
    const [x, y] = [axes.x.scale(box.left, box.right), axes.y.scale(box.bottom, box.top)];
    this.#x = x;
    const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
    const grid = svg("g", { class: "grid" });
    grid.append(...this.#shown.grid(box));
    root.append(grid);
    for (const line of this.#shown.lines) {
      root.append(svg("path", { d: this.#path(line, x, y), class: `line ${line.style}` }));
    }
    if (this.#cursor !== null) root.append(this.#cursorMarks(box, x, y));
    this.#host.replaceChildren(root);
    this.#drawLegend();
  }

  /** At most four points for each column of pixels: first, lowest, highest, last. A value that is not known is a gap. */
  #path({ values, steps = false }, x, y) {
    const abscissae = this.#shown.abscissae;
    const parts = [];
    let pen = "M";
    let column = null;
    let height = null; // of the point before
    const flush = () => {
      if (!column) return;
      const seen = new Set([column.first, column.low, column.high, column.last]);
      for (const i of [...seen].sort((a, b) => a - b)) {
        const [across, up] = [x(abscissae[i]).toFixed(1), y(values[i]).toFixed(1)];
        if (steps && pen === "L" && up !== height) parts.push(`L${across} ${height}`);
        parts.push(`${pen}${across} ${up}`);
        pen = "L";
        height = up;
      }
      column = null;
    };
    for (let i = 0; i < abscissae.length; ++i) {
      if (values[i] === null || values[i] === undefined) {
        flush();
        pen = "M";
        continue;
      }
      const pixel = Math.round(x(abscissae[i]));
      if (column && column.pixel !== pixel) flush();
      column ??= { pixel, first: i, low: i, high: i, last: i };
      if (values[i] < values[column.low]) column.low = i;
      if (values[i] > values[column.high]) column.high = i;
      column.last = i;
    }
    flush();
    return parts.join("");
  }

  #cursorMarks(box, x, y) {
    const at = x(this.#shown.abscissae[this.#cursor]);
    const marks = svg("g", { class: "cursor" });
    marks.append(svg("line", { x1: at, x2: at, y1: box.top, y2: box.bottom }));
    for (const { style, values } of this.#shown.lines) {
      const value = values[this.#cursor];
      if (value === null || value === undefined) continue;
      marks.append(svg("circle", { cx: at, cy: y(value), r: 3.5, class: `dot ${style}` }));
    }
    return marks;
  }

  #drawLegend() {
    const index = this.#cursor ?? this.#shown.resting;
    const items = [...this.#shown.lines].map(({ name, style, values }) => {
      const item = document.createElement("li");
      const swatch = document.createElement("span");
      swatch.className = `swatch ${style}`;
      item.append(swatch, `${name} `, element("b", this.#shown.text(values[index])));
      return item;
    });
    const where = this.#shown.where(index);
    if (where) {
      const item = element("li", where);
      item.className = "where";
      items.unshift(item);
    }
    this.#legend.replaceChildren(...items);
    const summary = items.map((item) => item.textContent).join(", ");
    this.#host.setAttribute("aria-label", `${this.#shown.title}. ${summary}. ${T.chart.keys}`);
  }

  #pointAt(pixel) {
    const abscissae = this.#shown.abscissae;
    if (abscissae.length === 0) return;
    let low = 0;
    let high = abscissae.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#x(abscissae[middle]) < pixel) low = middle + 1;
      else high = middle;
    }
    this.moveCursor(low);
  }

  #key(event) {
    const last = this.#shown.abscissae.length - 1;
    if (last < 0) return;
    const stride = Math.max(1, Math.round(last / 100));
    const from = this.#cursor ?? this.#shown.resting;
    const target = { ArrowLeft: from - stride, ArrowRight: from + stride, Home: 0, End: last }[event.key];
    if (event.key === "Escape") this.moveCursor(null);
    if (target === undefined) return;
    event.preventDefault();
    this.moveCursor(Math.min(last, Math.max(0, target)));
  }
}
