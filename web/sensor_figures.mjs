// SPDX-License-Identifier: Apache-2.0
// The drawings of a sensor, for a report and for the page of a unit: its curves with the points behind them, what is left of these, its
// Allan deviation. Who draws says the words.

import { allanOfWhite, Axis, LogAxis } from "./axes.mjs";
import { BELOW, draw, Panel, TOP } from "./figure.mjs";
import { significant } from "./format.mjs";

export const HEIGHT = 340;
/** What drawCurve() draws: keys of the curve and of its bands. */
export const BIAS = ["bias", "ci95", "pi95"];
export const SCALE = ["scale_ppm", "scale_ci95_ppm"];
const LEAST_SPAN = 1e-7; // of the values themselves, which come with eight digits
const RUN_COLOURS = 8;
const MOST_IN_LEGEND = 12;
const WIDEST_BAND = 3; // times what else there is to see: a wider band is cut off at the frame

/**
 * @typedef {object} FigureWords what stands at axes and in legends
 * @property {string} temperature
 * @property {(unit: string) => string} bias
 * @property {string} scale
 * @property {string} deployed
 * @property {string} mean
 * @property {string} fresh
 * @property {(count: number) => string} moreRuns
 * @property {string} sweeps
 * @property {(drawn: number, total: number) => string} drawn
 * @property {(unit: string) => string} residual
 * @property {(unit: string) => string} shape
 * @property {string} freshRun
 * @property {string} limit
 * @property {(limit: string) => string} limitBeyond
 * @property {string} tau
 * @property {(unit: string) => string} deviation
 * @property {string} interval
 */

/**
 * @typedef {object} Drawn a sensor as it is drawn: lists by the name of what they hold
 * @property {number} temp_min_c
 * @property {number} temp_max_c
 * @property {Record<string, (number | null)[]>} curve
 * @property {import("./documents.mjs").RowColumns | null} [rows]
 * @property {import("./documents.mjs").RowColumns | null} [fresh]
 * @property {number | null} [limit]
 */

/** Grows to hold what it is told. */
export class Range {
  low = Infinity;
  high = -Infinity;

  take(values) {
    for (const value of values) {
      this.low = Math.min(this.low, value);
      this.high = Math.max(this.high, value);
    }
    return this;
  }

  get span() {
    return this.high - this.low;
  }

  /** Takes a band where it leaves the rest to be seen. */
  takeBand(points) {
    const wider = new Range().take([this.low, this.high]).take(points.flatMap(([, low, high]) => [low, high]));
    if (points.length && (!(this.span > 0) || wider.span <= WIDEST_BAND * this.span)) Object.assign(this, wider);
    return this;
  }

  /** With some room at both ends. */
  get axis() {
    if (this.low > this.high) return new Axis(0, 1);
    // Values that differ by their rounding alone are one: an axis has no numbers for less.
    const differs = this.span > LEAST_SPAN * Math.max(Math.abs(this.low), Math.abs(this.high));
    const room = differs ? 0.06 * this.span : Math.max(0.1 * Math.abs(this.low), 1e-6);
    return new Axis(this.low - room, this.high + room);
  }
}

export const isNumber = (value) => typeof value === "number";
export const ordinates = (points) => points.map(([, y]) => y);

/** [temperature, value] of columns, where the value is known. */
function points(columns, key) {
  const values = columns?.[key] ?? [];
  return values.map((value, i) => [columns.temp_c[i], value]).filter(([, value]) => isNumber(value));
}

/** [temperature, low, high] of a half-width about another column, or about 0. */
function band(curve, key, about) {
  const halves = curve[key] ?? [];
  const known = halves.map((half, i) => [curve.temp_c[i], about ? curve[about][i] : 0, half]).filter((p) => p.every(isNumber));
  return known.map(([temp_c, middle, half]) => [temp_c, middle - half, middle + half]);
}

export const runStyle = (run) => `unit-${run % RUN_COLOURS}`;

/** Temperatures of the valid range of a sensor, and of an older model of it. */
function temperatures(sensor, older = sensor) {
  const [low, high] = [Math.min(sensor.temp_min_c, older.temp_min_c), Math.max(sensor.temp_max_c, older.temp_max_c)];
  const room = Math.max(1, 0.02 * (high - low));
  return new Axis(low - room, high + room);
}

/** The rows of the runs, one path for each run and sweep. */
function drawRows(panel, rows, key) {
  const groups = new Map();
  for (const [i, point] of points(rows?.points, key).entries()) {
    const group = `${rows.points.run[i]} ${rows.points.sweep[i]}`;
    groups.set(group, [...(groups.get(group) ?? []), point]);
  }
  for (const [group, list] of groups) {
    const [run, sweep] = group.split(" ");
    panel.marks(list, sweep in { up: 1, down: 1 } ? sweep : "dot", runStyle(Number(run)));
  }
}

/**
 * @param {import("./documents.mjs").RowColumns | null} rows
 * @param {FigureWords} words
 */
export function runLegend(rows, words) {
  if (!rows?.runs.length) return [];
  const legend = rows.runs.slice(0, MOST_IN_LEGEND).map((run, i) => [`run ${runStyle(i)}`, run]);
  const more = rows.runs.length - MOST_IN_LEGEND;
  if (more > 0) legend.push(["none", words.moreRuns(more)]);
  legend.push(["none", words.sweeps]);
  const drawn = rows.points.run.length;
  if (drawn < rows.total) legend.push(["none", words.drawn(drawn, rows.total)]);
  return legend;
}

/**
 * A deployed curve with its bands, and the rows that it was fitted to; behind it that of an older model, where one is given.
 * @param {HTMLElement} figure
 * @param {Drawn} sensor
 * @param {import("./documents.mjs").RowColumns | null} rows
 * @param {string[]} keys of the curve and its bands
 * @param {string} name at the axis
 * @param {string[][]} more of the legend
 * @param {FigureWords} words
 * @param {{sensor: Drawn, legend: string[][]} | null} older
 */
export function drawCurve(figure, sensor, rows, keys, name, more, words, older = null) {
  const [key, ci95, pi95] = keys;
  const { curve } = sensor;
  const line = points(curve, key);
  const [before, beforeBand] = older ? [points(older.sensor.curve, key), band(older.sensor.curve, ci95, key)] : [[], []];
  const [wide, narrow] = [band(curve, pi95, key), band(curve, ci95, key)];
  const range = new Range().take(ordinates([...line, ...before])).take(ordinates(points(rows?.points, "value")));
  const axis = range.takeBand(wide).takeBand(narrow).takeBand(beforeBand).axis;
  const panel = new Panel(TOP, HEIGHT - BELOW, temperatures(sensor, older?.sensor), axis, words.temperature, name);
  panel.band(wide, "pi95");
  panel.band(narrow, "ci95");
  panel.band(beforeBand, "older");
  panel.line(before, "older");
  drawRows(panel, rows, "value");
  panel.line(line, "curve");
  const legend = [["line curve", words.deployed], ["band ci95", words.mean]];
  if (wide.length) legend.push(["band pi95", words.fresh]);
  draw(figure, HEIGHT, [panel], [...legend, ...(before.length ? older.legend : []), ...more]);
}

/**
 * Rows less the curve: as they are, in the bands, with fresh runs; below with each run's own offset removed.
 * @param {HTMLElement} figure
 * @param {Drawn} sensor
 * @param {string} unit
 * @param {FigureWords} words
 */
export function drawResiduals(figure, sensor, unit, words) {
  const { rows, fresh, limit, curve } = sensor;
  const [wide, narrow] = [band(curve, "pi95"), band(curve, "ci95")];
  const own = [rows, fresh].flatMap((some) => ordinates(points(some?.points, "residual")));
  const range = new Range().take([0, ...own]).takeBand(wide).takeBand(narrow);
  if (isNumber(limit)) range.takeBand([[0, -limit, limit]]);
  const { axis } = range;
  const showsLimit = isNumber(limit) && axis.low <= -limit && limit <= axis.high;
  const middle = (TOP + HEIGHT - BELOW) / 2;
  const upper = new Panel(TOP, middle - 14, temperatures(sensor), axis, "", words.residual(unit));
  upper.band(wide, "pi95");
  upper.band(narrow, "ci95");
  upper.level(0, "curve");
  if (showsLimit) for (const level of [limit, -limit]) upper.level(level, "limit");
  drawRows(upper, rows, "residual");
  upper.marks(points(fresh?.points, "residual"), "square", "fresh");

  const shapes = new Range().take([0, ...ordinates(points(rows?.points, "shape_residual"))]);
  const lower = new Panel(middle + 26, HEIGHT - BELOW, temperatures(sensor), shapes.axis, words.temperature, words.shape(unit));
  lower.level(0, "curve");
  drawRows(lower, rows, "shape_residual");
  const legend = fresh ? [["square fresh", words.freshRun]] : [];
  if (showsLimit) legend.push(["line limit", words.limit]);
  else if (isNumber(limit)) legend.push(["none", words.limitBeyond(significant(limit, 3))]);
  draw(figure, HEIGHT, [upper, lower], legend);
}

/**
 * Overlapping Allan deviation of the sensors of one kind, with its interval; what the type allows, where it says so.
 * @param {HTMLElement} figure
 * @param {Record<string, {tau_s?: number[], oadev?: (number | null)[], ci95?: (number | null)[][], limit?: number | null}>} noise
 * @param {string} kind "gyro", "accel"
 * @param {string} unit
 * @param {FigureWords} words
 * @param {(name: string) => string} nameOf a sensor
 */
export function drawAllan(figure, noise, kind, unit, words, nameOf = (name) => name) {
  const known = Object.entries(noise).filter(([name, { tau_s }]) => name.startsWith(kind) && tau_s?.length);
  const lines = known.map(([name, { tau_s, oadev, ci95 }]) => ({
    name: nameOf(name),
    line: tau_s.map((tau, i) => [tau, oadev[i]]).filter(([, deviation]) => deviation > 0),
    interval: tau_s.map((tau, i) => [tau, ...ci95[i]]).filter((point) => point.every(isNumber)),
  }));
  const all = lines.flatMap(({ line }) => line);
  const taus = new Range().take(all.map(([tau]) => tau));
  const limit = known.find(([, sensor]) => isNumber(sensor.limit))?.[1].limit ?? null;
  const allowed = limit === null ? [] : [taus.low, taus.high].map((tau) => [tau, allanOfWhite(limit, tau)]);
  const axis = ({ low, high }, room) => new LogAxis(low / room, Math.max(high * room, (10 * low) / room));
  const [x, y] = [axis(taus, 1), axis(new Range().take(ordinates([...all, ...allowed])), 1.4)];
  const panel = new Panel(TOP, HEIGHT - BELOW, x, y, words.tau, words.deviation(unit));
  for (const [i, { line, interval }] of lines.entries()) {
    panel.band(interval, runStyle(i));
    panel.line(line, runStyle(i));
  }
  panel.line(allowed, "limit");
  const legend = lines.map((line, i) => [`line ${runStyle(i)}`, line.name]);
  if (limit !== null) legend.push(["line limit", words.limit]);
  draw(figure, HEIGHT, [panel], [...legend, ["none", words.interval]]);
}
