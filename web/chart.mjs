// SPDX-License-Identifier: Apache-2.0
// Lines of temperature over process time: chamber air, set point and one line a unit.

import { Axis, multiples, niceStep, svg } from "./axes.mjs";
import { duration, number } from "./format.mjs";
import { Plot } from "./plot.mjs";

const MARGIN = { top: 24, right: 14, bottom: 26, left: 46 };
const MAX_POINTS = 8000;
const COLOURS = 8;
const TIME_STEPS_S = [1, 2, 5, 10, 30, 60, 120, 300, 600, 1800, 3600, 7200, 14400, 21600, 43200, 86400, 172800, 604800];

/** "0", "30 min", "2 h", "2 h 30" */
function timeLabel(t_s, step_s) {
  if (t_s === 0) return "0";
  if (step_s < 60) return `${t_s} s`;
  if (step_s < 3600 && t_s < 3600) return `${Math.round(t_s / 60)} min`;
  const hours = Math.floor(t_s / 3600);
  const minutes = Math.round((t_s % 3600) / 60);
  return minutes ? `${hours} h ${String(minutes).padStart(2, "0")}` : `${hours} h`;
}

export class Chart extends Plot {
  #t_s = [];
  #series = new Map();

  /** `host` holds the drawing, `legend` (a list) the names and values. */
  constructor(host, legend) {
    super(host, legend, MARGIN);
    this.#clear();
  }

  /** Starts over with the document of GET /history. */
  setHistory(history) {
    this.#clear();
    this.#t_s = [...history.t_s];
    this.#line("chamber").values = [...history.chamber_c];
    this.#line("set").values = [...history.set_point_c];
    for (const [serial, values] of Object.entries(history.units)) this.#unitLine(serial).values = [...values];
    this.redraw();
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
    this.redraw();
  }

  /** Time of the last point, or null. */
  get last_s() {
    return this.#t_s.at(-1) ?? null;
  }

  get title() {
    return "Temperatures over process time";
  }

  get abscissae() {
    return this.#t_s;
  }

  get lines() {
    return this.#series.values();
  }

  get resting() {
    return this.#t_s.length - 1;
  }

  text(value) {
    return `${number(value, 1)} °C`;
  }

  where(index) {
    return this.cursor === null ? "" : `at ${duration(this.#t_s[index])}`;
  }

  get axes() {
    return { x: new Axis(...this.#times()), y: new Axis(...this.#range()) };
  }

  grid(box) {
    const nodes = [svg("text", { x: 4, y: 10, class: "axis" }, "°C")];
    const { x: times, y: temperatures } = this.axes;
    const [x, y] = [times.scale(box.left, box.right), temperatures.scale(box.bottom, box.top)];
    for (const { value, text } of temperatures.ticks(box.bottom + MARGIN.bottom, 44)) {
      nodes.push(svg("line", { x1: box.left, x2: box.right, y1: y(value), y2: y(value) }));
      nodes.push(svg("text", { x: box.left - 8, y: y(value) + 4, "text-anchor": "end" }, text));
    }
    const rough = ((times.high - times.low) * 84) / (box.right + MARGIN.right);
    const stepS = TIME_STEPS_S.find((s) => s >= rough) ?? niceStep(rough);
    for (const t of multiples(times.low, times.high, stepS)) {
      nodes.push(svg("line", { x1: x(t), x2: x(t), y1: box.bottom, y2: box.bottom + 5 }));
      nodes.push(svg("text", { x: x(t), y: box.bottom + 20, "text-anchor": "middle" }, timeLabel(t, stepS)));
    }
    return nodes;
  }

  #times() {
    const t0 = this.#t_s[0] ?? 0;
    return [t0, Math.max(this.#t_s.at(-1) ?? 0, t0 + 60)];
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

  #clear() {
    this.#t_s = [];
    this.moveCursor(null);
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
}
