// SPDX-License-Identifier: Apache-2.0
// One pair of axes of the strip chart, drawn by dygraphs: lines of one unit with the band between the least and the
// greatest sample of each stretch.

import { colour } from "./chart_colours.mjs";
import { element } from "./dom.mjs";
import { written } from "./format.mjs";
import { panelTitle, runTime, valueText } from "./run_words.mjs";
import { nearest, tableOf, timeTicks } from "./series.mjs";

const DOT_PIXELS = 4; // for each sample, from which on it is a dot
const [TICK_PIXELS, TIME_PIXELS] = [104, 96]; // between two times, and of one: 16:40:03.125
const VALUE_PIXELS = 68;

/** dygraphs, loaded when stored runs are looked at: the station's own view needs none of it. */
export async function loadDygraphs() {
  // @ts-ignore: Debian's file, beside the modules in soakd; it has no types
  await import("./dygraph.min.js");
  const { Dygraph } = /** @type {any} */ (window);
  // The page has a legend of its own, and its policy forbids the style attributes that this one writes.
  Dygraph.PLUGINS = Dygraph.PLUGINS.filter((plugin) => plugin !== Dygraph.Plugins.Legend);
  return Dygraph;
}

const BAND_ALPHA = 0.3;

/** The stretches of a line between its pauses: those are points that are not finite (series.mjs). A row of another line only has no value of this one. */
function partsOf(points) {
  const parts = [[]];
  for (const point of points.filter(({ yval }) => yval !== null)) {
    if (Number.isFinite(point.y_top) && Number.isFinite(point.y_bottom)) parts.at(-1).push(point);
    else parts.push([]);
  }
  return parts;
}

/** `area`: of the lines, in which y_top and y_bottom are shares of the height. */
function fillPart(context, area, points) {
  let left = Math.round(points[0]?.canvasx ?? 0);
  let [top, bottom] = [Infinity, -Infinity];
  points.forEach(({ canvasx, y_top, y_bottom }, i) => {
    [top, bottom] = [Math.min(top, y_top, y_bottom), Math.max(bottom, y_top, y_bottom)]; // its y_top is of the least value
    const next = points[i + 1];
    const right = next ? Math.round((canvasx + next.canvasx) / 2) : Math.max(Math.round(canvasx), left + 1);
    if (right <= left) return; // the next one lies on the same pixel
    context.fillRect(left, area.y + area.h * top, right - left, area.h * (bottom - top));
    [left, top, bottom] = [right, Infinity, -Infinity];
  });
}

/**
 * Plotter of dygraphs: the band of a line as a rectangle for each of its points, on whole pixels. The path of quadrilaterals that dygraphs itself
 * fills takes a second on a machine without a graphics processor.
 */
function plotBand({ drawingContext: context, color, points, plotArea }) {
  context.save();
  context.globalAlpha = BAND_ALPHA;
  context.fillStyle = color;
  for (const part of partsOf(points)) fillPart(context, plotArea, part);
  context.restore();
}

const axisText = (value) => written(String(Number(value.toPrecision(9))));

export class StripPanel {
  #graph = null;
  #lines = [];
  #times = []; // of the rows that dygraphs has
  #legend;
  #plot;
  #under;

  /** `under(context, area, toX)`: draws what lies below the lines. */
  constructor(unit, under) {
    this.unit = unit;
    this.#under = under;
    this.node = element("div", "");
    this.node.className = "panel";
    this.#legend = element("ul", "");
    this.#legend.className = "legend";
    const head = element("div", "");
    head.className = "row";
    head.append(element("h3", panelTitle(unit)), this.#legend);
    this.#plot = element("div", "");
    this.#plot.className = "plot";
    this.node.append(head, this.#plot);
  }

  /** Draws `lines` from `from_s` to `to_s`; `styles`: key of a line → number of its colour. */
  draw(Dygraph, lines, styles, from_s, to_s) {
    this.#lines = lines.map((line) => ({ ...line, style: styles.get(line.key) }));
    const table = tableOf(lines, from_s, to_s);
    this.#times = table.map(([t_s]) => t_s);
    const few = lines.every((line) => line.raw && DOT_PIXELS * line.points.length <= this.#plot.clientWidth);
    const options = {
      labels: ["t", ...lines.map((line) => line.key)],
      dateWindow: [from_s, to_s],
      drawPoints: few,
      ...this.#colours(),
    };
    if (this.#graph) this.#graph.updateOptions({ ...options, file: table });
    else this.#graph = new Dygraph(this.#plot, table, { ...options, ...this.#fixed(Dygraph) });
    this.point(null);
  }

  /** Another part of what is drawn, until the station has answered. */
  look(from_s, to_s) {
    this.#graph?.updateOptions({ dateWindow: [from_s, to_s] });
  }

  recolour() {
    this.#graph?.updateOptions(this.#colours());
  }

  resize() {
    if (this.#plot.clientWidth > 0) this.#graph?.resize();
  }

  /** {x, w}: where the lines are, in pixels from the left of the panel. */
  get area() {
    return this.#graph?.getArea() ?? null;
  }

  /** Shows what the lines are at `t_s`; null: nowhere. The texts of the legend. */
  point(t_s) {
    const row = t_s === null ? -1 : nearest(this.#times, t_s);
    if (row >= 0) this.#graph.setSelection(row);
    else this.#graph.clearSelection();
    const items = this.#lines.map((line) => this.#item(line, t_s));
    this.#legend.replaceChildren(...items);
    return items.map((item) => item.textContent);
  }

  close() {
    this.#graph?.destroy();
    this.node.remove();
  }

  #item({ name, points, raw, style }, t_s) {
    const item = element("li", "");
    const swatch = element("span", "");
    swatch.className = `swatch unit-${style}`;
    item.append(swatch, `${name} `);
    const at = t_s === null ? -1 : nearest(points.map((point) => point.t_s), t_s);
    if (at >= 0) item.append(element("b", this.#valueText(points[at], raw)));
    return item;
  }

  #valueText({ low, mean, high }, raw) {
    const [bottom, top] = this.#graph.yAxisRange();
    const text = (value) => valueText(value, top - bottom);
    return raw || low === high ? text(mean) : `${text(mean)} (${text(low)} … ${text(high)})`;
  }

  #colours() {
    return {
      colors: this.#lines.map(({ style }) => colour(`unit-${style}`)),
      axisLineColor: colour("line"),
      gridLineColor: colour("grid"),
    };
  }

  #fixed(Dygraph) {
    const ticker = (from_s, to_s, pixels) => {
      const { step_s, times_s } = timeTicks(from_s, to_s, pixels / TICK_PIXELS);
      return times_s.map((t_s) => ({ v: t_s, label: runTime(t_s, step_s) }));
    };
    return {
      customBars: true,
      connectSeparatedPoints: true,
      interactionModel: {}, // the strip chart's own, for all panels at once
      plotter: [plotBand, Dygraph.Plotters.linePlotter],
      strokeWidth: 1.4,
      pointSize: 2,
      highlightCircleSize: 4,
      yRangePad: 8,
      axisLabelFontSize: 12,
      axes: { x: { ticker, axisLabelWidth: TIME_PIXELS }, y: { axisLabelFormatter: axisText, axisLabelWidth: VALUE_PIXELS } },
      underlayCallback: (context, area, graph) => this.#under(context, area, (t_s) => graph.toDomXCoord(t_s)),
    };
  }
}
