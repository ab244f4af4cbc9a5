// SPDX-License-Identifier: Apache-2.0
// What the calibration of a unit buys in navigation: metres without satellite navigation. Loaded with the first unit that has a model.

import { get } from "./api.mjs";
import { element } from "./dom.mjs";
import { number, significant, UNKNOWN } from "./format.mjs";
import { sensorText, U, unitText } from "./unit_words.mjs";

const size = (value, digits) => (value === null ? UNKNOWN : significant(value, digits));

function row(name, cells) {
  const line = element("tr", "");
  line.append(...cells.map((text) => element(name, text)));
  return line;
}

/** @param {import("./documents.mjs").SensorImpact} sensor */
function cellsOf(sensor) {
  const { change, left, left_interval: interval, after_30_s_m: soon, after_60_s_m: later } = sensor;
  const metres = [soon.without, soon.with, later.without, later.with].map((value) => (value === null ? UNKNOWN : `${size(value, 2)} m`));
  return [sensorText(sensor.sensor), `${size(change, 2)} ${unitText(sensor)}`, left === null ? UNKNOWN : `${size(left, 2)} ${unitText(sensor)} (${U.impact.intervals[interval]})`, ...metres];
}

function table(sensors) {
  const list = Object.assign(element("table", ""), { className: "list figures" });
  list.createTHead().append(row("th", U.impact.heads));
  list.createTBody().append(...sensors.map((sensor) => row("td", cellsOf(sensor))));
  const box = Object.assign(element("div", ""), { className: "scroll", tabIndex: 0 });
  box.setAttribute("role", "region");
  box.setAttribute("aria-label", U.impact.bySensor);
  box.append(list);
  return box;
}

/** @param {import("./documents.mjs").UnitDrives} drives */
function drivesText({ drives, outages, length_s, without, with: corrected, gain }) {
  const metres = ({ horizontal_final_m: error }) => `${number(error.value, 1)} m`;
  const percent = (share) => number(100 * share, 0);
  return U.impact.drives({ drives, outages, seconds: number(length_s, 0), without: metres(without), corrected: metres(corrected), less: percent(gain.value), between: gain.ci95?.map(percent) ?? null });
}

/** Fills a paragraph with what simulated drives say, which takes a moment. */
async function tellDrives(place, unit, version) {
  /** @type {import("./documents.mjs").ImpactOfUnit} */
  let answer;
  try {
    answer = await get(`impact?${new URLSearchParams({ unit, version: String(version) })}`);
  } catch (error) {
    place.prepend(`${U.impact.drivesFailed(error.message)} `);
    return;
  }
  const { drives, warnings } = answer.impact;
  const failure = warnings.find(({ code }) => code === "drives_not_simulated");
  if (drives !== null) place.prepend(`${U.impact.ofModel(answer.model)} ${drivesText(drives)} `);
  else place.prepend(failure ? Object.assign(element("span", `${failure.text}. `), { lang: "en" }) : `${U.impact.noDrives} `);
}

/**
 * Fills the card.
 * @param {HTMLElement} card
 * @param {import("./documents.mjs").Model} model
 * @param {string} unit serial number
 */
export function renderImpact(card, { impact, version }, unit) {
  const title = Object.assign(element("h2", U.impact.title(version)), { id: "unit-impact-title" });
  const about = (text) => Object.assign(element("p", text), { className: "about" });
  if (impact === null) {
    card.replaceChildren(title, about(U.impact.notKnown));
    return;
  }
  const drives = Object.assign(about(`${U.impact.more} `), { id: "unit-drives" });
  drives.append(element("code", `soak nav impact --unit ${unit}`));
  tellDrives(drives, unit, version);
  const bySensor = element("details", "");
  bySensor.append(element("summary", U.impact.bySensor), about(U.impact.about(number(impact.from_c, 1), number(impact.to_c, 1))), table(impact.free_inertial));
  card.replaceChildren(title, bySensor, ...impact.warnings.map(({ text }) => Object.assign(about(text), { lang: "en" })), drives);
}
