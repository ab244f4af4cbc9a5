// SPDX-License-Identifier: Apache-2.0
// A drawing that stands still: panels of bands, lines and marks above a legend, as large as screen and paper want it.

import { grid, svg } from "./axes.mjs";
import { element } from "./dom.mjs";

export const WIDTH = 520;
export const LEFT = 66;
export const RIGHT = WIDTH - 12;
export const TOP = 26;
export const BELOW = 42; // what numbers and name of the abscissa need

const MARKS = {
  dot: "m-2.4 0a2.4 2.4 0 1 0 4.8 0a2.4 2.4 0 1 0-4.8 0z",
  up: "m0-3.4l3 5.4h-6z",
  down: "m0 3.4l3-5.4h-6z",
  square: "m-2.6-2.6h5.2v5.2h-5.2z",
  ring: "m-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0z",
};

/** One pair of axes and what is drawn between them. Points are [abscissa, ordinate]; styles those of the style sheet. */
export class Panel {
  constructor(top, bottom, x, y, xName, yName) {
    this.node = svg("g");
    this.x = x.scale(LEFT, RIGHT);
    this.y = y.scale(bottom, top);
    const lines = svg("g", { class: "grid" });
    lines.append(...grid({ left: LEFT, right: RIGHT, top, bottom }, x, y, xName, yName));
    this.node.append(lines);
  }

  /** Points are [abscissa, low, high]. */
  band(points, style) {
    const edge = points.map(([x, low]) => [x, low]).concat(points.map(([x, , high]) => [x, high]).reverse());
    this.#path(edge, (p) => `L${p}`, `band ${style}`);
  }

  line(points, style) {
    this.#path(points, (p) => `L${p}`, `line ${style}`);
  }

  marks(points, mark, style) {
    this.#path(points, (p) => `M${p}${MARKS[mark]}`, `mark ${style}`);
  }

  /** Across the whole panel. */
  level(y, style) {
    this.node.append(svg("path", { d: `M${LEFT} ${this.y(y).toFixed(1)}H${RIGHT}`, class: `line ${style}` }));
  }

  #path(points, part, style) {
    if (points.length === 0) return;
    const d = points.map(([x, y]) => part(`${this.x(x).toFixed(1)} ${this.y(y).toFixed(1)}`)).join("");
    this.node.append(svg("path", { d: `M${d.slice(1)}`, class: style }));
  }
}

/** Draws into a figure that names itself in its caption; `legend`: [style of the swatch, text]. */
export function draw(figure, height, panels, legend) {
  const [title, description] = figure.querySelectorAll("figcaption > *");
  const label = `${title.textContent}. ${description.textContent}`;
  const root = svg("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": label });
  root.append(...panels.map((panel) => panel.node));
  const list = element("ul", "");
  list.className = "legend";
  for (const [style, text] of legend) {
    const swatch = element("span", "");
    swatch.className = `swatch ${style}`;
    const entry = element("li", "");
    entry.append(swatch, text);
    list.append(entry);
  }
  description.remove();
  figure.append(root, list);
}
