// SPDX-License-Identifier: Apache-2.0
// The noise of a unit at rest, from what is stored of it, beside what its type allows. Loaded when somebody comes to look at it.

import { get, isBusy } from "./api.mjs";
import { $, element, english, say, show, tell } from "./dom.mjs";
import { duration, number, sign, significant, UNKNOWN, written } from "./format.mjs";
import { drawAllan } from "./sensor_figures.mjs";
import { sensorText, U, unitText } from "./unit_words.mjs";

const KINDS = ["gyro", "accel"];
const STATES = { inside: "finished", outside: "failed", no_limit: "", not_known: "waiting" };
/** Of sensors together: the gravest. */
const GRAVEST = ["outside", "not_known", "no_limit", "inside"];

/** @typedef {import("./documents.mjs").SensorNoise} SensorNoise */

/** @param {SensorNoise} sensor */
const densityUnit = (sensor) => `${unitText(sensor)}/√Hz`;

/** @param {SensorNoise} sensor */
function densityText(sensor) {
  const { density } = sensor;
  if (density === null) return UNKNOWN;
  const [low, high] = density.ci95.map((value) => (value === null ? UNKNOWN : significant(value, 3)));
  if (density.value === null) return U.noise.below(`${high} ${densityUnit(sensor)}`);
  return `${significant(density.value, 3)} ${densityUnit(sensor)}${U.noise.between(low, high)}`;
}

/** @param {SensorNoise} sensor */
const limitText = (sensor) => (sensor.limit === null ? UNKNOWN : `${written(String(sensor.limit))} ${densityUnit(sensor)}`);

/** @param {string} name @param {(string | Node)[]} cells */
function row(name, cells) {
  const line = element("tr", "");
  line.append(...cells.map((text) => element(name, text)));
  return line;
}

/** @param {[string, SensorNoise][]} sensors of one kind */
function verdictLine(kind, type, sensors) {
  const verdict = GRAVEST.find((each) => sensors.some(([, sensor]) => sensor.verdict === each));
  const outside = sensors.filter(([, sensor]) => sensor.verdict === "outside").map(([name]) => sensorText(name)).join(", ");
  const line = element("li", U.noise.verdicts[verdict](U.noise.kinds[kind], type, limitText(sensors[0][1]), outside));
  line.className = "judged";
  line.dataset.state = STATES[verdict];
  return line;
}

/** @param {Record<string, SensorNoise>} sensors */
function figureOf(kind, sensors, unit) {
  const figure = element("figure", "");
  const caption = element("figcaption", "");
  const said = Object.entries(sensors).filter(([name]) => name.startsWith(kind)).map(([name, sensor]) => `${sensorText(name)} ${densityText(sensor)}`);
  caption.append(element("b", U.noise.figure[kind]), element("span", said.join(", ")));
  figure.append(caption);
  drawAllan(figure, sensors, kind, unit, U.sensors.figures, sensorText);
  return figure;
}

/** @param {import("./documents.mjs").UnitNoise} noise */
function fromText({ segment }) {
  const { run, campaign, position, temp_c, duration_s, simulated } = segment;
  return `${U.noise.from(run, campaign, duration(duration_s), sign(position), number(temp_c, 1))}${simulated ? U.noise.simulated : ""}`;
}

/** @param {import("./documents.mjs").UnitNoise} noise */
function render(noise) {
  const sensors = Object.entries(noise.sensors);
  const kinds = KINDS.map((kind) => ({ kind, list: sensors.filter(([name]) => name.startsWith(kind)) })).filter(({ list }) => list.length > 0);
  say($("unit-noise-said"), noise.segment === null ? U.noise.none : fromText(noise));
  show($("unit-noise-found"), sensors.length > 0);
  $("unit-noise-verdicts").replaceChildren(...kinds.map(({ kind, list }) => verdictLine(kind, noise.type, list)));
  const drawn = kinds.filter(({ list }) => list.some(([, { tau_s }]) => tau_s.length > 0));
  $("unit-noise-figures").replaceChildren(...drawn.map(({ kind, list }) => figureOf(kind, noise.sensors, unitText(list[0][1]))));
  const table = $("unit-noise-table");
  table.replaceChildren();
  table.createTHead().append(row("th", U.noise.heads));
  table.createTBody().append(...kinds.flatMap(({ list }) => list).map(([name, sensor]) => row("td", [sensorText(name), U.noise.short[sensor.verdict], densityText(sensor), limitText(sensor)])));
  show($("unit-noise-about"), sensors.some(([, { limit }]) => limit !== null));
  const reasons = [...new Set(sensors.map(([, { reason }]) => reason).filter((reason) => reason !== null))];
  $("unit-noise-reasons").replaceChildren(...reasons.map((reason) => {
    const line = element("li", "");
    line.append(english(reason));
    return line;
  }));
}

/**
 * Asks for the noise of a unit and shows it.
 * @param {string} unit serial number
 * @param {() => boolean} isLate whether another unit is asked for by now
 * @returns {Promise<boolean | "busy">} whether it was found
 */
export async function showNoise(unit, isLate) {
  show($("unit-noise-found"), false);
  say($("unit-noise-said"), U.noise.reading);
  try {
    const noise = await get(`unit/noise?${new URLSearchParams({ unit })}`);
    if (!isLate()) render(noise);
    return true;
  } catch (error) {
    if (!isLate()) tell($("unit-noise-said"), [U.noise.failed, { english: error.message }]);
    return isBusy(error) ? "busy" : false;
  }
}
