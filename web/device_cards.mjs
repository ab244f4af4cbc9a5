// SPDX-License-Identifier: Apache-2.0
// The cards of chamber and units.

import { KINDS } from "./allan_chart.mjs";
import { $, element, say } from "./dom.mjs";
import { faceOf, positionText, stableText, unitStateText } from "./face_words.mjs";
import { count, number, significant } from "./format.mjs";
import { T } from "./text.mjs";
import { fixtureText, isActive, linkOf } from "./words.mjs";

const unitCards = new Map(); // serial → card

/** @param {import("./documents.mjs").Status} status */
export function renderChamber(status) {
  const { chamber } = status;
  say($("air"), number(chamber.air_c, 2));
  say($("set-point"), `${number(chamber.set_point_c, 1)} °C`);
  say($("output"), `${number(chamber.output_percent, 0)} %${chamber.running === false ? T.chamber.stopped : ""}`);
  say($("fixture"), fixtureText(status));
  const link = linkOf(status);
  say($("chamber-link"), link.text);
  $("chamber-link").dataset.state = link.state;
  $("chamber").classList.toggle("stale", !chamber.connected);
  const alarms = chamber.alarms.join("\n");
  if ($("alarms").dataset.text !== alarms) {
    $("alarms").dataset.text = alarms;
    $("alarms").replaceChildren(...chamber.alarms.map((text) => element("li", text)));
  }
  say($("chamber-about"), chamber.description);
}

/** Steps in which units are switched on or off. */
const SWITCHES = ["power_on", "power_off", "turn_fixture"];

/** @param {import("./documents.mjs").Status} status */
export function renderUnits(status) {
  const { units, campaign, state } = status;
  const isOn = isActive(status) && state !== "stopping" && campaign !== null && !SWITCHES.includes(campaign.step_kind);
  const serials = new Set(units.map((unit) => unit.serial));
  for (const [serial, card] of unitCards) {
    if (serials.has(serial)) continue;
    card.remove();
    unitCards.delete(serial);
  }
  for (const unit of units) renderUnit(unitCards.get(unit.serial) ?? newUnitCard(unit.serial), unit, isOn);
}

function newUnitCard(serial) {
  const card = $("unit-template").content.firstElementChild.cloneNode(true);
  card.setAttribute("aria-label", T.unit.label(serial));
  unitCards.set(serial, card);
  $("units").append(card);
  return card;
}

function renderUnit(card, unit, isOn) {
  const part = (name) => card.querySelector(`.${name}`);
  say(part("serial"), unit.serial);
  say(part("slot"), T.unit.slot(unit.slot));
  say(part("unit-state"), unitStateText(unit, isOn));
  part("unit-state").dataset.state = unit.dropped || unit.state === "failed" || (unit.state === "closed" && isOn) ? "failed" : "";
  say(part("temp"), number(unit.temp_c, 2));
  say(part("stable"), stableText(unit));
  part("stable").classList.toggle("yes", unit.stable);
  say(part("slope"), `${number(unit.slope_kpmin, 3)} ± ${number(unit.slope_half_width_kpmin, 3)}`);
  say(part("position"), positionText(unit));
  part("position").classList.toggle("bad", faceOf(unit)?.wrong ?? false);
  say(part("samples"), count(unit.samples));
  say(part("lost"), count(unit.lost));
  part("lost").classList.toggle("bad", unit.lost > 0);
  const reading = (value) => number(value, 3);
  fillAxes(part("gyro"), unit.gyro_dps, reading);
  fillAxes(part("accel"), unit.accel_mps2, reading);
  say(part("tau"), significant(unit.noise.tau_s, 2));
  const noiseOf = (kind) => (value) => significant(value === undefined ? null : value * KINDS[kind].factor, 3);
  fillAxes(part("gyro-noise"), unit.noise.gyro_dps, noiseOf("gyro"));
  fillAxes(part("accel-noise"), unit.noise.accel_mps2, noiseOf("accel"));
  say(part("about"), unit.type + (unit.simulated ? ` · ${T.unit.simulated}` : ""));
}

function fillAxes(row, values, text) {
  row.querySelectorAll("td").forEach((cell, axis) => say(cell, text(values?.[axis])));
}
