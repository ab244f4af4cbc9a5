// SPDX-License-Identifier: Apache-2.0
// The card of a sensor: its curves with the points of the runs, what is left of these, in the drawings of the report.

import { element } from "./dom.mjs";
import { differenceText, sensorFacts } from "./curve_words.mjs";
import { badge } from "./runs_view.mjs";
import { BIAS, drawCurve, drawResiduals, runLegend, SCALE } from "./sensor_figures.mjs";
import { sensorText, U, unitText, verdictOf } from "./unit_words.mjs";

const WORDS = U.sensors.figures;

function facts(sensor) {
  const list = element("dl", "");
  list.className = "facts";
  list.append(...sensorFacts(sensor).map(([name, value]) => {
    const box = element("div", "");
    box.append(element("dt", name), element("dd", value));
    return box;
  }));
  return list;
}

/**
 * A sensor as drawings take it: its curve in lists.
 * @param {import("./documents.mjs").Sensor} sensor
 * @returns {import("./sensor_figures.mjs").Drawn}
 */
function drawn({ temp_min_c, temp_max_c, curve }) {
  const list = (key) => curve.map((point) => point[key] ?? null);
  return { temp_min_c, temp_max_c, curve: Object.fromEntries(["temp_c", ...BIAS, ...SCALE].map((key) => [key, list(key)])) };
}

/** A figure with its title and, for those who do not see it, what is stated of the curve. */
function figureOf(shows, title, sensor) {
  const figure = element("figure", "");
  figure.dataset.shows = shows;
  const caption = element("figcaption", "");
  caption.append(element("b", title), element("span", sensorFacts(sensor).map((fact) => fact.join(" ")).join(", ")));
  figure.append(caption);
  return figure;
}

/** What the legend says of an older model that lies behind the curve. */
const olderLegend = (version) => [["line older", U.sensors.version(version)], ["band older", U.sensors.olderMean]];

/** How far the two models are apart, in numbers. */
function differencePart(sensor, older) {
  const part = Object.assign(element("p", ""), { className: "difference" });
  const { bias, scale } = U.sensors.differenceOf;
  const of = (name, text) => (text === "" ? [] : [element("span", `${name}${text}`)]);
  part.append(...of(bias, differenceText(sensor.curve, older.curve, ["bias", "ci95"], unitText(sensor))),
    ...of(scale, differenceText(sensor.curve, older.curve, ["scale_ppm", "scale_ci95_ppm"], "ppm")));
  return part;
}

/** Title and verdict. */
function headOf(title, judged) {
  const head = element("div", "");
  head.className = "row";
  head.append(title);
  if (judged) {
    const { title: text, state } = verdictOf(judged.verdict);
    head.append(badge({ text, state }));
  }
  return head;
}

/** The curve of the scale, or why there is none. */
function scalePart(name, sensor, own, rows, older) {
  if (!sensor.curve.some(({ scale_ppm }) => typeof scale_ppm === "number")) {
    return Object.assign(element("p", U.sensors.noScale[name.startsWith("gyro") ? "gyro" : "accel"]), { className: "about" });
  }
  const scale = figureOf("scale", U.sensors.scale(sensorText(name)), sensor);
  drawCurve(scale, own, rows?.scale_rows ?? null, SCALE, WORDS.scale, [], WORDS, older);
  return scale;
}

/**
 * The card of a sensor; `judged`: its part of a verification that holds, or null; `older`: {version, sensor} of another model, to be drawn
 * behind it, or null; `rows`: the points of the runs, or null while they are not there.
 * @param {string} name
 * @param {import("./documents.mjs").Sensor} sensor
 * @param {{verdict: import("./documents.mjs").Verdict} | null} judged
 * @param {{version: number, sensor: import("./documents.mjs").Sensor} | null} older
 * @param {import("./documents.mjs").SensorRows | null} rows
 */
export function sensorCard(name, sensor, judged, older, rows) {
  const card = element("section", "");
  card.className = "card sensor";
  const title = element("h3", sensorText(name));
  title.id = `sensor-${name}`;
  card.setAttribute("aria-labelledby", title.id);
  const own = { ...drawn(sensor), ...rows };
  const before = older && { sensor: drawn(older.sensor), legend: olderLegend(older.version) };
  const bias = figureOf("bias", U.sensors.bias(sensorText(name)), sensor);
  drawCurve(bias, own, rows?.rows ?? null, BIAS, WORDS.bias(unitText(sensor)), runLegend(rows?.rows ?? null, WORDS), WORDS, before);
  card.append(headOf(title, judged), bias);
  if (older) card.append(differencePart(sensor, older.sensor));
  if (rows?.rows || rows?.fresh) {
    const residuals = figureOf("residuals", U.sensors.residuals(sensorText(name)), sensor);
    drawResiduals(residuals, own, unitText(sensor), WORDS);
    card.append(residuals);
  }
  card.append(scalePart(name, sensor, own, rows, before), facts(sensor));
  return card;
}
