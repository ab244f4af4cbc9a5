// SPDX-License-Identifier: Apache-2.0
// The drawings of a report: station/report/figures.cpp says where on the page which of them stands, and puts what they
// are drawn from into the page. Its modules are joined into one script there: no name twice, one line for each import.

import { Axis, LogAxis } from "./axes.mjs";
import { BELOW, draw, LEFT, Panel, RIGHT, TOP } from "./figure.mjs";
import { significant } from "./format.mjs";

const HEIGHT = 340;
const GAP_PANEL = 190;
const CHECK_HEIGHT = 240;
const RUN_COLOURS = 8;
const MOST_IN_LEGEND = 12;
const WIDEST_BAND = 3; // times what else there is to see: a wider band is cut off at the frame

const data = JSON.parse(document.getElementById("data").textContent);

/** Grows to hold what it is told. */
class Range {
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
    const room = this.span > 0 ? 0.06 * this.span : Math.max(0.1 * Math.abs(this.low), 1e-6);
    return new Axis(this.low - room, this.high + room);
  }
}

const isNumber = (value) => typeof value === "number";
const ordinates = (points) => points.map(([, y]) => y);

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

const runStyle = (run) => `unit-${run % RUN_COLOURS}`;

/** Temperatures of the valid range of a sensor. */
function temperatures({ temp_min_c: low, temp_max_c: high }) {
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

function runLegend(rows) {
  if (!rows?.runs.length) return [];
  const legend = rows.runs.slice(0, MOST_IN_LEGEND).map((run, i) => [`run ${runStyle(i)}`, run]);
  const more = rows.runs.length - MOST_IN_LEGEND;
  if (more > 0) legend.push(["none", `and ${more} runs more`]);
  legend.push(["none", "▲ heating ▼ cooling"]);
  const drawn = rows.points.run.length;
  if (drawn < rows.total) legend.push(["none", `${drawn} of ${rows.total} rows drawn`]);
  return legend;
}

/**
 * A deployed curve with its bands, and the rows that it was fitted to.
 * @param {[string, string, string?]} keys of the curve and its bands
 */
function drawCurve(figure, sensor, rows, keys, name, more) {
  const [key, ci95, pi95] = keys;
  const { curve } = sensor;
  const line = points(curve, key);
  const [wide, narrow] = [band(curve, pi95, key), band(curve, ci95, key)];
  const range = new Range().take(ordinates(line)).take(ordinates(points(rows?.points, "value")));
  const axis = range.takeBand(wide).takeBand(narrow).axis;
  const panel = new Panel(TOP, HEIGHT - BELOW, temperatures(sensor), axis, "temperature of the unit, °C", name);
  panel.band(wide, "pi95");
  panel.band(narrow, "ci95");
  drawRows(panel, rows, "value");
  panel.line(line, "curve");
  const legend = [["line curve", "deployed curve"], ["band ci95", "95 %, mean curve"]];
  if (wide.length) legend.push(["band pi95", "95 %, one fresh power-on"]);
  draw(figure, HEIGHT, [panel], [...legend, ...more]);
}

/** Rows less the curve: as they are, in the bands, with fresh runs; below with each run's own offset removed. */
function drawResiduals(figure, sensor) {
  const { rows, fresh, limit, curve } = sensor;
  const [wide, narrow] = [band(curve, "pi95"), band(curve, "ci95")];
  const own = [rows, fresh].flatMap((some) => ordinates(points(some?.points, "residual")));
  const range = new Range().take([0, ...own]).takeBand(wide).takeBand(narrow);
  if (isNumber(limit)) range.takeBand([[0, -limit, limit]]);
  const { axis } = range;
  const showsLimit = isNumber(limit) && axis.low <= -limit && limit <= axis.high;
  const middle = (TOP + HEIGHT - BELOW) / 2;
  const upper = new Panel(TOP, middle - 14, temperatures(sensor), axis, "", `row − curve, ${sensor.unit}`);
  upper.band(wide, "pi95");
  upper.band(narrow, "ci95");
  upper.level(0, "curve");
  if (showsLimit) for (const level of [limit, -limit]) upper.level(level, "limit");
  drawRows(upper, rows, "residual");
  upper.marks(points(fresh?.points, "residual"), "square", "fresh");

  const shapes = new Range().take([0, ...ordinates(points(rows?.points, "shape_residual"))]);
  const name = `the same, each run's own offset removed, ${sensor.unit}`;
  const lower = new Panel(middle + 26, HEIGHT - BELOW, temperatures(sensor), shapes.axis, "temperature, °C", name);
  lower.level(0, "curve");
  drawRows(lower, rows, "shape_residual");
  const legend = fresh ? [["square fresh", "fresh run, in no fit"]] : [];
  if (showsLimit) legend.push(["line limit", "limit"]);
  else if (isNumber(limit)) legend.push(["none", `limit ±${significant(limit, 3)}: beyond the drawing`]);
  draw(figure, HEIGHT, [upper, lower], legend);
}

/** Overlapping Allan deviation of the sensors of one kind, with its interval. */
function drawAllan(figure, kind) {
  const known = Object.entries(data.noise).filter(([name, { tau_s }]) => name.startsWith(kind) && tau_s);
  const lines = known.map(([name, { tau_s, oadev, ci95 }]) => ({
    name,
    line: tau_s.map((tau, i) => [tau, oadev[i]]).filter(([, deviation]) => deviation > 0),
    interval: tau_s.map((tau, i) => [tau, ...ci95[i]]).filter((point) => point.every(isNumber)),
  }));
  const all = lines.flatMap(({ line }) => line);
  const axis = (values, room) => {
    const { low, high } = new Range().take(values);
    return new LogAxis(low / room, Math.max(high * room, (10 * low) / room));
  };
  const name = `Allan deviation, ${kind === "gyro" ? "deg/s" : "m/s²"}`;
  const [x, y] = [axis(all.map(([tau]) => tau), 1), axis(ordinates(all), 1.4)];
  const panel = new Panel(TOP, HEIGHT - BELOW, x, y, "averaging time τ, s", name);
  for (const [i, { line, interval }] of lines.entries()) {
    panel.band(interval, runStyle(i));
    panel.line(line, runStyle(i));
  }
  const legend = lines.map((line, i) => [`line ${runStyle(i)}`, line.name]);
  draw(figure, HEIGHT, [panel], [...legend, ["none", "shaded: 95 %"]]);
}

/** One sensor of a check standard over the campaigns; those of this model are ringed. */
function drawCheck(figure, sensor, { campaigns, reference_c }) {
  const found = campaigns.map((campaign, i) => ({ ...campaign, ...campaign.sensors[sensor], number: i + 1 }));
  const values = found.filter(({ bias }) => isNumber(bias));
  const limited = values.filter(({ limits }) => limits);
  const at = (list, value) => list.map((campaign) => [campaign.number, value(campaign)]);
  const biases = (keep) => at(values.filter(keep), ({ bias }) => bias);
  const isOut = ({ verdict }) => verdict === "out_of_control";
  const [lower, centre, upper] = ["lower", "centre", "upper"].map((key) => at(limited, ({ limits }) => limits[key]));
  const { axis } = new Range().take(ordinates([...biases(() => true), ...lower, ...upper]));
  const name = `bias at ${reference_c} °C, ${sensor.startsWith("gyro") ? "deg/s" : "m/s²"}`;
  const x = new Axis(0, Math.max(10, campaigns.length + 1));
  const panel = new Panel(TOP, CHECK_HEIGHT - BELOW, x, axis, "campaigns in the order of time", name);
  panel.line(centre, "curve");
  panel.line(lower, "limit");
  panel.line(upper, "limit");
  panel.marks(biases((campaign) => !isOut(campaign)), "dot", runStyle(0));
  panel.marks(biases(isOut), "up", "out");
  panel.marks(biases(({ of_model }) => of_model), "ring", "fresh");
  const legend = [[`run ${runStyle(0)}`, "campaign"], ["ring fresh", "of this model"]];
  if (values.some(isOut)) legend.push(["none", "▲ out of control"]);
  if (limited.length) legend.push(["line curve", "mean of earlier ones"], ["line limit", "limits"]);
  draw(figure, CHECK_HEIGHT, [panel], legend);
}

/** What was read beyond the simulation: one panel, or two of before and after. */
function drawGap(figure, { unit, temp_min_c, temp_max_c, panels }) {
  const most = Math.max(1e-12, ...panels.flatMap(({ marks }) => Object.values(marks).flat().map(([, y]) => 1.05 * Math.abs(y))));
  const marks = [["other", "dot", runStyle(2)], ["up", "up", runStyle(0)], ["down", "down", runStyle(1)], ["fresh", "square", "fresh"]];
  const drawn = panels.map((shown, i) => {
    const top = TOP + i * (GAP_PANEL + 36);
    const xName = i + 1 < panels.length ? "" : "temperature (°C)";
    const x = new Axis(temp_min_c, temp_max_c);
    const panel = new Panel(top, top + GAP_PANEL, x, new Axis(-most, most), xName, `${shown.name} (${unit})`);
    panel.marks(shown.marks.segments, "dot", "faint");
    panel.level(0, "curve");
    for (const [key, mark, style] of marks) panel.marks(shown.marks[key], mark, style);
    return panel;
  });
  const legend = [["run faint", "one position"], [`run ${runStyle(0)}`, "heating"], [`run ${runStyle(1)}`, "cooling"]];
  if (panels[0].marks.other.length) legend.push([`run ${runStyle(2)}`, "first plateau"]);
  if (panels[0].marks.fresh.length) legend.push(["square fresh", "fresh runs"]);
  draw(figure, TOP + GAP_PANEL + (panels.length - 1) * (GAP_PANEL + 36) + BELOW, drawn, legend);
}

const pipelineLegend = () => data.pipelines.map((name, i) => [`line ${runStyle(i)}`, name]);

/** Horizontal position error of each pipeline: [seconds since the outage began, metres]. */
function drawErrors(figure, lines) {
  const all = lines.flat();
  const [x, y] = [new Range().take(all.map(([after_s]) => after_s)), new Range().take([0, ...ordinates(all)])];
  const panel = new Panel(TOP, HEIGHT - BELOW, new Axis(0, x.high), y.axis, "time since the outage began, s", "horizontal error, m");
  for (const [i, line] of lines.entries()) panel.line(line, runStyle(i));
  draw(figure, HEIGHT, [panel], pipelineLegend());
}

/** Where the antenna was, and where each pipeline took it to be; a metre to the east is as long as one to the north. */
function drawTrack(figure, { truth, tracks }) {
  const all = [truth, ...tracks].flat();
  const [east, north] = [0, 1].map((axis) => new Range().take(all.map((point) => point[axis])));
  const [width, height] = [RIGHT - LEFT, HEIGHT - BELOW - TOP];
  const metresPerPixel = 1.1 * Math.max(east.span / width, north.span / height, 0.01);
  const axis = ({ low, high }, pixels) => {
    const [middle, half] = [(low + high) / 2, (metresPerPixel * pixels) / 2];
    return new Axis(middle - half, middle + half);
  };
  const panel = new Panel(TOP, HEIGHT - BELOW, axis(east, width), axis(north, height), "east, m", "north, m");
  for (const [i, track] of tracks.entries()) panel.line(track, runStyle(i));
  panel.line(truth, "curve");
  panel.marks(truth.slice(0, 1), "ring", "fresh");
  const legend = [["line curve", "truth"], ["ring fresh", "begins here"], ...pipelineLegend()];
  draw(figure, HEIGHT, [panel], legend);
}

const CHARTS = {
  curve(figure, sensor) {
    const { rows, unit } = sensor;
    drawCurve(figure, sensor, rows, ["bias", "ci95", "pi95"], `bias, ${unit}`, runLegend(rows));
  },
  scale(figure, sensor) {
    drawCurve(figure, sensor, sensor.scale_rows, ["scale_ppm", "scale_ci95_ppm"], "scale error, ppm", []);
  },
  residuals: drawResiduals,
  gap: drawGap,
  allan: (figure) => drawAllan(figure, figure.dataset.of),
  error: (figure) => drawErrors(figure, figure.dataset.of === "mean" ? data.mean : data.outages[figure.dataset.of].errors),
  track: (figure) => drawTrack(figure, data.outages[figure.dataset.of]),
  check: (figure) => drawCheck(figure, figure.dataset.of, data.check[figure.dataset.unit]),
};

/** @type {NodeListOf<HTMLElement>} */
const figures = document.querySelectorAll("figure[data-chart]");
for (const figure of figures) {
  CHARTS[figure.dataset.chart](figure, data.sensors?.[figure.dataset.of]);
}
