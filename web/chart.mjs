// SPDX-License-Identifier: Apache-2.0
// Lines of temperature over process time: chamber air, set point and one line a unit. SVG, so that colours come from
// the style sheet and the text is text.

import { duration, number } from "./format.mjs";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = { top: 24, right: 14, bottom: 26, left: 46 };
const MAX_POINTS = 8000;
const COLOURS = 8;
const TIME_STEPS_S = [1, 2, 5, 10, 30, 60, 120, 300, 600, 1800, 3600, 7200, 14400, 21600, 43200, 86400, 172800, 604800];

function svg(name, attributes = {}, text = "") {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.textContent = text;
  return node;
}

/** The smallest of 1, 2, 5 × 10^k that is not below `raw`. */
function niceStep(raw) {
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * ([1, 2, 5].find((m) => m * power >= raw) ?? 10);
}

function ticks(low, high, step) {
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high; ++k) found.push(k * step);
  return found;
}

/** "0", "30 min", "2 h", "2 h 30" */
function timeLabel(t_s, step_s) {
  if (t_s === 0) return "0";
  if (step_s < 60) return `${t_s} s`;
  if (step_s < 3600 && t_s < 3600) return `${Math.round(t_s / 60)} min`;
  const hours = Math.floor(t_s / 3600);
  const minutes = Math.round((t_s % 3600) / 60);
  return minutes ? `${hours} h ${String(minutes).padStart(2, "0")}` : `${hours} h`;
}

export class Chart {
  #host;
  #legend;
  #t_s = [];
  #series = new Map();
  #cursor = null; // index into #t_s
  #drawing = false;
  #x = (t_s) => t_s;

  /** `host` holds the drawing, `legend` (a list) the names and values. */
  constructor(host, legend) {
    this.#host = host;
    this.#legend = legend;
    host.tabIndex = 0;
    host.setAttribute("role", "img");
    host.addEventListener("pointermove", (event) => this.#pointAt(event.clientX - host.getBoundingClientRect().left));
    host.addEventListener("pointerleave", () => this.#moveCursor(null));
    host.addEventListener("blur", () => this.#moveCursor(null));
    host.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#redraw()).observe(host);
    this.#clear();
  }

  /** Begins anew with the document of GET /history. */
  setHistory(history) {
    this.#clear();
    this.#t_s = [...history.t_s];
    this.#line("chamber").values = [...history.chamber_c];
    this.#line("set").values = [...history.set_point_c];
    for (const [serial, values] of Object.entries(history.units)) this.#unitLine(serial).values = [...values];
    this.#redraw();
  }

  /** Adds what a status document says. A time that is not later than the last one is passed over. */
  append(status) {
    const t_s = status.clock.process_s;
    if (this.#t_s.length > 0 && t_s <= this.#t_s.at(-1)) return;
    this.#t_s.push(t_s);
    this.#line("chamber").values[this.#t_s.length - 1] = status.chamber.air_c;
    this.#line("set").values[this.#t_s.length - 1] = status.chamber.set_point_c;
    for (const unit of status.units) this.#unitLine(unit.serial).values[this.#t_s.length - 1] = unit.temp_c;
    if (this.#t_s.length > MAX_POINTS) this.#thin();
    this.#redraw();
  }

  /** Time of the last point, or null. */
  get last_s() {
    return this.#t_s.at(-1) ?? null;
  }

  #clear() {
    this.#t_s = [];
    this.#cursor = null;
    this.#series = new Map([
      ["chamber", { name: "chamber", style: "chamber", values: [] }],
      ["set", { name: "set point", style: "set", values: [] }],
    ]);
  }

  #line(key) {
    return this.#series.get(key);
  }

  #unitLine(serial) {
    const key = `unit ${serial}`;
    if (!this.#series.has(key)) {
      const style = `unit-${(this.#series.size - 2) % COLOURS}`;
      this.#series.set(key, { name: serial, style, values: [] });
    }
    return this.#series.get(key);
  }

  /** Drops every other point of the older half: what is recent stays fine. */
  #thin() {
    const half = this.#t_s.length / 2;
    const keeps = (_, i) => i >= half || i % 2 === 0;
    for (const line of this.#series.values()) {
      line.values = Array.from(this.#t_s, (_, i) => line.values[i] ?? null).filter(keeps);
    }
    this.#t_s = this.#t_s.filter(keeps);
  }

  #redraw() {
    if (this.#drawing) return;
    this.#drawing = true;
    requestAnimationFrame(() => {
      this.#drawing = false;
      this.#draw();
    });
  }

  #range() {
    let low = Infinity;
    let high = -Infinity;
    for (const { values } of this.#series.values()) {
      for (const value of values) {
        if (value === null || value === undefined) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (low > high) return [0, 40];
    const room = Math.max(1, 0.06 * (high - low));
    return [low - room, high + room];
  }

  #draw() {
    const width = this.#host.clientWidth;
    const height = this.#host.clientHeight;
    if (width < MARGIN.left + MARGIN.right + 20 || height < 60) return;
    const [low, high] = this.#range();
    const t0 = this.#t_s[0] ?? 0;
    const t1 = Math.max(this.#t_s.at(-1) ?? 0, t0 + 60);
    const x = (t) => MARGIN.left + ((t - t0) / (t1 - t0)) * (width - MARGIN.left - MARGIN.right);
    const y = (c) => height - MARGIN.bottom - ((c - low) / (high - low)) * (height - MARGIN.top - MARGIN.bottom);
    this.#x = x;
    const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
    root.append(this.#grid(x, y, { t0, t1, low, high, width, height }));
    for (const line of this.#series.values()) {
      root.append(svg("path", { d: this.#path(line.values, x, y), class: `line ${line.style}` }));
    }
    if (this.#cursor !== null) root.append(this.#cursorMarks(x, y, height));
    this.#host.replaceChildren(root);
    this.#drawLegend();
  }

  #grid(x, y, { t0, t1, low, high, width, height }) {
    const grid = svg("g", { class: "grid" });
    const stepC = niceStep(((high - low) * 44) / height);
    for (const c of ticks(low, high, stepC)) {
      grid.append(svg("line", { x1: MARGIN.left, x2: width - MARGIN.right, y1: y(c), y2: y(c) }));
      grid.append(svg("text", { x: MARGIN.left - 8, y: y(c) + 4, "text-anchor": "end" }, number(c, stepC < 1 ? 1 : 0)));
    }
    const rough = ((t1 - t0) * 84) / width;
    const stepS = TIME_STEPS_S.find((s) => s >= rough) ?? niceStep(rough);
    for (const t of ticks(t0, t1, stepS)) {
      grid.append(svg("line", { x1: x(t), x2: x(t), y1: height - MARGIN.bottom, y2: height - MARGIN.bottom + 5 }));
      grid.append(svg("text", { x: x(t), y: height - 6, "text-anchor": "middle" }, timeLabel(t, stepS)));
    }
    grid.append(svg("text", { x: 4, y: 10, class: "axis" }, "°C"));
    return grid;
  }

  /** At most four points for each column of pixels: first, lowest, highest, last. A value that is not known is a gap. */
  #path(values, x, y) {
    const parts = [];
    let pen = "M";
    let column = null;
    const flush = () => {
      if (!column) return;
      const seen = new Set([column.first, column.low, column.high, column.last]);
      for (const i of [...seen].sort((a, b) => a - b)) {
        parts.push(`${pen}${x(this.#t_s[i]).toFixed(1)} ${y(values[i]).toFixed(1)}`);
        pen = "L";
      }
      column = null;
    };
    for (let i = 0; i < this.#t_s.length; ++i) {
      if (values[i] === null || values[i] === undefined) {
        flush();
        pen = "M";
        continue;
      }
      const pixel = Math.round(x(this.#t_s[i]));
      if (column && column.pixel !== pixel) flush();
      column ??= { pixel, first: i, low: i, high: i, last: i };
      if (values[i] < values[column.low]) column.low = i;
      if (values[i] > values[column.high]) column.high = i;
      column.last = i;
    }
    flush();
    return parts.join("");
  }

  #cursorMarks(x, y, height) {
    const at = x(this.#t_s[this.#cursor]);
    const marks = svg("g", { class: "cursor" });
    marks.append(svg("line", { x1: at, x2: at, y1: MARGIN.top, y2: height - MARGIN.bottom }));
    for (const { style, values } of this.#series.values()) {
      const value = values[this.#cursor];
      if (value === null || value === undefined) continue;
      marks.append(svg("circle", { cx: at, cy: y(value), r: 3.5, class: `dot ${style}` }));
    }
    return marks;
  }

  #drawLegend() {
    const index = this.#cursor ?? this.#t_s.length - 1;
    const items = [...this.#series.values()].map(({ name, style, values }) => {
      const item = document.createElement("li");
      const swatch = document.createElement("span");
      swatch.className = `swatch ${style}`;
      const value = document.createElement("b");
      value.textContent = `${number(values[index], 1)} °C`;
      item.append(swatch, `${name} `, value);
      return item;
    });
    if (this.#cursor !== null) {
      const when = document.createElement("li");
      when.className = "when";
      when.textContent = `at ${duration(this.#t_s[index])}`;
      items.unshift(when);
    }
    this.#legend.replaceChildren(...items);
    const summary = items.map((item) => item.textContent).join(", ");
    this.#host.setAttribute("aria-label", `Temperatures over process time. ${summary}. Arrow keys move a cursor.`);
  }

  #pointAt(pixel) {
    if (this.#t_s.length === 0) return;
    let low = 0;
    let high = this.#t_s.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#x(this.#t_s[middle]) < pixel) low = middle + 1;
      else high = middle;
    }
    this.#moveCursor(low);
  }

  #key(event) {
    const last = this.#t_s.length - 1;
    if (last < 0) return;
    const stride = Math.max(1, Math.round(last / 100));
    const from = this.#cursor ?? last;
    const target = { ArrowLeft: from - stride, ArrowRight: from + stride, Home: 0, End: last }[event.key];
    if (event.key === "Escape") this.#moveCursor(null);
    if (target === undefined) return;
    event.preventDefault();
    this.#moveCursor(Math.min(last, Math.max(0, target)));
  }

  #moveCursor(index) {
    if (index === this.#cursor) return;
    this.#cursor = index;
    this.#redraw();
  }
}
