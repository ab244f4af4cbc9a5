// SPDX-License-Identifier: Apache-2.0
// References and unit types in words. Nothing here touches the page.

import { number, UNKNOWN } from "./format.mjs";
import { unitText } from "./unit_words.mjs";

const MOST_DIGITS = 2; // of an uncertainty: JCGM 100:2008, 7.2.6

const STANDINGS = {
  valid: { text: "valid", state: "finished" },
  due_soon: { text: "due soon", state: "waiting" },
  expired: { text: "expired", state: "failed" },
  superseded: { text: "superseded", state: "" },
  retired: { text: "retired", state: "" },
  withdrawn: { text: "withdrawn", state: "" },
};

/** {text, state} of a badge: how an entry of the register stands, with its days where they are few, and who signed for it. */
export function standingOf({ standing, days_left, waivers }) {
  const known = STANDINGS[standing] ?? { text: standing, state: "" };
  const waiver = waivers.at(-1);
  if (standing === "expired" && waiver) {
    return waiver.good ? { text: `expired, waived by ${waiver.signer}`, state: "waiting" } : { text: "expired, its waiver is DAMAGED", state: "failed" };
  }
  if (standing !== "due_soon") return known;
  return { ...known, text: `${known.text}: ${days_left} ${days_left === 1 ? "day" : "days"}` };
}

/** Decimals of a value that is known to two digits of its uncertainty; zeros at the end left out where both have them. */
function decimalsOf(value, uncertainty) {
  const most = Math.max(0, MOST_DIGITS - 1 - Math.floor(Math.log10(uncertainty)));
  return Math.max(...[value, uncertainty].map((each) => each.toFixed(most).match(/\.(\d*[1-9])/)?.[1].length ?? 0));
}

/** "9.80665 m/s²": a value with as many decimals as its standard uncertainty, in the same unit, needs. */
export const valueText = (value, uncertainty, unit) => (value === null ? UNKNOWN : `${number(value, decimalsOf(value, uncertainty))} ${unitText({ unit })}`);

export function ratingText({ temp_min_c, temp_max_c }) {
  if (temp_min_c === null || temp_max_c === null) return "not stated";
  return `${number(temp_min_c, 0)} to ${number(temp_max_c, 0)} °C`;
}

/** "gyro_x 0.05 deg/s, accel_x 0.02 m/s²": the limits that soak verify asks for. */
export function limitsText(limits) {
  const unitOf = (name) => (name.endsWith("_scale_ppm") ? "ppm" : name.startsWith("gyro") ? "deg/s" : "m/s²");
  const listed = Object.entries(limits).map(([name, value]) => `${name.replace("_scale_ppm", " scale")} ${value} ${unitOf(name)}`);
  return listed.length === 0 ? "none: a verification judges nothing" : listed.join(", ");
}
