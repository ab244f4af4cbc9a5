// SPDX-License-Identifier: Apache-2.0
// References and unit types in words. Nothing here touches the page.

import { number, UNKNOWN } from "./format.mjs";

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

export const valueText = (value, unit) => (value === null ? UNKNOWN : `${Number(value.toPrecision(4))} ${unit}`.replace("-", "−"));

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
