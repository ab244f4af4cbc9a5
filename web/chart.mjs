// SPDX-License-Identifier: Apache-2.0
// Lines of temperature over process time: chamber air, set point and one line a unit.

import { Axis, multiples, niceStep, svg } from "./axes.mjs";
import { clock, dateText, duration, number, timeText } from "./format.mjs";
import { Plot } from "./plot.mjs";
import { T } from "./text.mjs";

const MARGIN = { top: 24, right: 14, bottom: 26, left: 46 };
const MAX_POINTS = 8000;
const LONGEST_GAP_S = 60; // host time between two points; the station's stream is never silent for longer
const DAY_S = 86400;
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

/** "14:30", at midnight "26 Nov", with seconds where the ticks are that close. */
function clockLabel(utc_s, step_s) {
  const date = new Date(utc_s * 1000);
  if (step_s >= 60 && date.getHours() === 0 && date.getMinutes() === 0) {
    return dateText(date, { day: "numeric", month: "short" });
  }
  return timeText(date, { hour: "2-digit", minute: "2-digit", ...(step_s < 60 && { second: "2-digit" }) });
}

/** Seconds that local time is ahead of UTC then. */
const zone_s = (utc_s) => -60 * new Date(utc_s * 1000).getTimezoneOffset();

export class Chart extends Plot {
  #t_s = [];
  #series = new Map();
  #gap_s = LONGEST_GAP_S; // more between two points: nothing is known of the time between
  #rate = 1;
  #utcAtZero_s = 0; // host time at process time 0

  /** `host` holds the drawing, `legend` (a list) the names and values. */
  constructor(host, legend) {
    super(host, legend, MARGIN);
    this.#clear();
  }

  /** Starts over with the document of GET /history; `clock`: that of the status document. */
  setHistory(history, clock) {
    this.#clear();
    this.#setClock(clock);
    const steps_s = history.t_s.slice(1).map((t_s, i) => t_s - history.t_s[i]).sort((a, b) => a - b);
    this.#gap_s = Math.max(LONGEST_GAP_S * Math.max(1, this.#rate), 4 * (steps_s[steps_s.length >> 1] ?? 0));
    const units = Object.entries(history.units);
    history.t_s.forEach((t_s, i) => {
      this.#add(t_s, history.chamber_c[i], history.set_point_c[i], units.map(([serial, values]) => [serial, values[i]]));
    });
    this.redraw();
  }

  /** Adds what a status document says. A time that is not later than the last one is passed over. */
  append(status) {
    const t_s = status.clock.process_s;
    if (this.#t_s.length > 0 && t_s <= this.#t_s.at(-1)) return;
    this.#setClock(status.clock);
    const { air_c, set_point_c } = status.chamber;
    this.#add(t_s, air_c, set_point_c, status.units.map((unit) => [unit.serial, unit.temp_c]));
    if (this.#t_s.length > MAX_POINTS) this.#thin();
    this.redraw();
  }

  /** Time of the last point, or null. */
  get last_s() {
    return this.#t_s.at(-1) ?? null;
  }

  get title() {
    return T.chart.label;
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
    if (this.cursor === null) return "";
    return this.#rate === 1 ? T.chart.at(clock(this.#utcAtZero_s + this.#t_s[index])) : T.chart.after(duration(this.#t_s[index] - this.#t_s[0]));
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
    for (const { t, text } of this.#timeTicks(times, stepS)) {
      nodes.push(svg("line", { x1: x(t), x2: x(t), y1: box.bottom, y2: box.bottom + 5 }));
      nodes.push(svg("text", { x: x(t), y: box.bottom + 20, "text-anchor": "middle" }, text));
    }
    return nodes;
  }

  /** Times of day; with a clock that runs at another rate, process time since the first point. */
  #timeTicks({ low, high }, step_s) {
    if (this.#rate !== 1) {
      return multiples(0, high - low, step_s).map((t_s) => ({ t: low + t_s, text: timeLabel(t_s, step_s) }));
    }
    const ahead_s = this.#utcAtZero_s + zone_s(this.#utcAtZero_s + low); // local time at process time 0
    return multiples(low + ahead_s, high + ahead_s, step_s).map((local_s) => {
      const t = local_s - ahead_s;
      return { t, text: clockLabel(this.#utcAtZero_s + t, Math.min(step_s, DAY_S)) };
    });
  }

  #setClock({ rate, process_s, utc_s }) {
    this.#rate = rate;
    this.#utcAtZero_s = utc_s - process_s / rate;
  }

  /** `units`: serial number and °C of each. A point without values parts what lies too far from each other. */
  #add(t_s, chamber_c, set_point_c, units) {
    const last_s = this.#t_s.at(-1);
    if (last_s !== undefined && t_s - last_s > this.#gap_s) this.#t_s.push((last_s + t_s) / 2);
    this.#t_s.push(t_s);
    const at = this.#t_s.length - 1;
    this.#line("chamber").values[at] = chamber_c;
    this.#line("set").values[at] = set_point_c;
    for (const [serial, temp_c] of units) this.#unitLine(serial).values[at] = temp_c;
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
      ["chamber", { name: T.chart.chamber, style: "chamber", values: [] }],
      ["set", { name: T.chart.setPoint, style: "set", values: [], steps: true }],
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
