// SPDX-License-Identifier: Apache-2.0
// The drawings of a report: station/report/figures.cpp says where on the page which of them stands, and puts what they
// are drawn from into the page. Its modules are joined into one script there: no name twice, one line for each import.

import { Axis } from "./axes.mjs";
import { BELOW, draw, LEFT, Panel, RIGHT, TOP } from "./figure.mjs";
import { FIGURE_WORDS } from "./figure_words.mjs";
import { BIAS, drawAllan, drawCurve, drawResiduals, HEIGHT, isNumber, ordinates, Range, runLegend, runStyle, SCALE } from "./sensor_figures.mjs";

const GAP_PANEL = 190;
const CHECK_HEIGHT = 240;

/** Units as the report writes them. */
const unitText = (unit) => unit.replace("m/s2", "m/s²").replace("deg/s", "°/s");

const data = JSON.parse(document.getElementById("data").textContent);

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
  const name = `bias at ${reference_c} °C, ${sensor.startsWith("gyro") ? "°/s" : "m/s²"}`;
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
    drawCurve(figure, sensor, sensor.rows, BIAS, FIGURE_WORDS.bias(unitText(sensor.unit)), runLegend(sensor.rows, FIGURE_WORDS), FIGURE_WORDS);
  },
  scale(figure, sensor) {
    drawCurve(figure, sensor, sensor.scale_rows, SCALE, FIGURE_WORDS.scale, [], FIGURE_WORDS);
  },
  residuals: (figure, sensor) => drawResiduals(figure, sensor, unitText(sensor.unit), FIGURE_WORDS),
  gap: drawGap,
  allan: (figure) => drawAllan(figure, data.noise, figure.dataset.of, figure.dataset.of === "gyro" ? "°/s" : "m/s²", FIGURE_WORDS),
  error: (figure) => drawErrors(figure, figure.dataset.of === "mean" ? data.mean : data.outages[figure.dataset.of].errors),
  track: (figure) => drawTrack(figure, data.outages[figure.dataset.of]),
  check: (figure) => drawCheck(figure, figure.dataset.of, data.check[figure.dataset.unit]),
};

/** @type {NodeListOf<HTMLElement>} */
const figures = document.querySelectorAll("figure[data-chart]");
for (const figure of figures) {
  CHARTS[figure.dataset.chart](figure, data.sensors?.[figure.dataset.of]);
}
