// SPDX-License-Identifier: Apache-2.0
// A drawing of each sensor's curve with its bands, as the report has it, without the rows behind it.

import { Axis } from "./axes.mjs";
import { element } from "./dom.mjs";
import { BELOW, draw, Panel, TOP } from "./figure.mjs";
import { badge } from "./runs_view.mjs";
import { sensorFacts, sensorText, U, unitText, verdictOf } from "./unit_words.mjs";

const HEIGHT = 260;

const isNumber = (value) => typeof value === "number";

/** [temperature, low, high] of the points that have that band. */
function band(curve, key) {
  const known = curve.filter((point) => isNumber(point.bias) && isNumber(point[key]));
  return known.map((point) => [point.temp_c, point.bias - point[key], point.bias + point[key]]);
}

/** An axis that holds the values, with some room at both ends. */
function axisOf(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = high > low ? 0.06 * (high - low) : Math.max(0.1 * Math.abs(low), 1e-6);
  return new Axis(low - room, high + room);
}

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

/** The points of a curve that are numbers, and what its bands span. */
function drawn({ curve }) {
  const known = curve.filter(({ bias }) => isNumber(bias));
  return { line: known.map(({ temp_c, bias }) => [temp_c, bias]), wide: band(known, "pi95"), narrow: band(known, "ci95") };
}

/**
 * The card of a sensor; `judged`: its part of a verification that holds, or null; `older`: {version, sensor} of another model, to be drawn
 * behind it, or null.
 * @param {string} name
 * @param {import("./documents.mjs").Sensor} sensor
 * @param {{verdict: import("./documents.mjs").Verdict} | null} judged
 * @param {{version: number, sensor: import("./documents.mjs").Sensor} | null} older
 */
export function sensorCard(name, sensor, judged, older) {
  const card = element("section", "");
  card.className = "card sensor";
  const title = element("h3", sensorText(name));
  title.id = `sensor-${name}`;
  card.setAttribute("aria-labelledby", title.id);
  const head = element("div", "");
  head.className = "row";
  head.append(title);
  if (judged) {
    const { title: text, state } = verdictOf(judged.verdict);
    head.append(badge({ text, state }));
  }
  const { line, wide, narrow } = drawn(sensor);
  const before = older && drawn(older.sensor);
  const figure = element("figure", "");
  const caption = element("figcaption", "");
  caption.append(element("b", U.sensors.bias(sensorText(name))),
    element("span", sensorFacts(sensor).map((fact) => fact.join(" ")).join(", ")));
  figure.append(caption);
  const all = [sensor, ...(older ? [older.sensor] : [])];
  const x = axisOf(all.flatMap(({ temp_min_c, temp_max_c }) => [temp_min_c, temp_max_c]));
  const bands = [...wide, ...narrow, ...(before?.narrow ?? [])];
  const y = axisOf([...line, ...(before?.line ?? [])].map(([, bias]) => bias).concat(bands.flatMap(([, low, high]) => [low, high])));
  const panel = new Panel(TOP, HEIGHT - BELOW, x, y, U.sensors.temperature, U.sensors.ordinate(unitText(sensor)));
  panel.band(wide, "pi95");
  panel.band(narrow, "ci95");
  if (before) {
    panel.band(before.narrow, "older");
    panel.line(before.line, "older");
  }
  panel.line(line, "curve");
  const legend = [["line curve", U.sensors.deployed], ["band ci95", U.sensors.mean]];
  if (wide.length > 0) legend.push(["band pi95", U.sensors.fresh]);
  if (older) legend.push(["line older", U.sensors.version(older.version)], ["band older", U.sensors.olderMean]);
  draw(figure, HEIGHT, [panel], legend);
  caption.firstElementChild.remove(); // the card's title says it
  card.append(head, figure, facts(sensor));
  return card;
}
