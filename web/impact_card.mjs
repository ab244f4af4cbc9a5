// SPDX-License-Identifier: Apache-2.0
// What the calibration of a unit buys in navigation: metres without satellite navigation. Loaded with the first unit that has a model.

import { element } from "./dom.mjs";
import { number, significant, UNKNOWN } from "./format.mjs";
import { sensorText, unitText } from "./unit_words.mjs";

const HEADINGS = ["Sensor", "Bias changes by", "Left (95 %)", "30 s, without", "30 s, with", "60 s, without", "60 s, with"];

const size = (value, digits) => (value === null ? UNKNOWN : significant(value, digits));

function row(name, cells) {
  const line = element("tr", "");
  line.append(...cells.map((text) => element(name, text)));
  return line;
}

/** @param {import("./documents.mjs").SensorImpact} sensor */
function cellsOf(sensor) {
  const { change, left, after_30_s_m: soon, after_60_s_m: later } = sensor;
  const metres = [soon.without, soon.with, later.without, later.with].map((value) => (value === null ? UNKNOWN : `${size(value, 2)} m`));
  return [sensorText(sensor.sensor), `${size(change, 2)} ${unitText(sensor)}`, left === null ? UNKNOWN : `${size(left, 2)} ${unitText(sensor)}`, ...metres];
}

function table(sensors) {
  const list = Object.assign(element("table", ""), { className: "list figures" });
  list.createTHead().append(row("th", HEADINGS));
  list.createTBody().append(...sensors.map((sensor) => row("td", cellsOf(sensor))));
  const box = Object.assign(element("div", ""), { className: "scroll", tabIndex: 0 });
  box.setAttribute("role", "region");
  box.setAttribute("aria-label", "Position errors by sensor");
  box.append(list);
  return box;
}

/**
 * Fills the card.
 * @param {HTMLElement} card
 * @param {import("./documents.mjs").Model} model
 * @param {string} unit serial number
 */
export function renderImpact(card, { impact }, unit) {
  const title = Object.assign(element("h2", "What the calibration buys in navigation"), { id: "unit-impact-title" });
  const about = (text) => Object.assign(element("p", text), { className: "about" });
  if (impact === null) {
    card.replaceChildren(title, about("Not known: the sensors were not calibrated at two common temperatures."));
    return;
  }
  const course = `${number(impact.from_c, 1)} °C at power-on to ${number(impact.to_c, 1)} °C`;
  const drives = about("Drives with a navigation filter are not simulated here, as that takes seconds: ");
  drives.append(element("code", `soak nav impact --unit ${unit}`));
  card.replaceChildren(title,
    about(`Position error from each sensor's bias alone without satellite navigation, from ${course}; the bias at power-on is known, the sensor's axis lies horizontally.`),
    table(impact.free_inertial), ...impact.warnings.map(({ text }) => about(text)), drives);
}
