// SPDX-License-Identifier: Apache-2.0
// References and unit types in words. Nothing here touches the page.

import { dayText, number, UNKNOWN, written } from "./format.mjs";
import { textsOf } from "./text.mjs";
import { unitText } from "./unit_words.mjs";

/** @type {typeof import("./text_records_en.mjs").text} */
export const C = await textsOf("records");

const MOST_DIGITS = 2; // of an uncertainty: JCGM 100:2008, 7.2.6

/** States of a badge. */
const STANDINGS = { valid: "finished", due_soon: "waiting", expired: "failed", superseded: "", retired: "", withdrawn: "" };

/** {text, state} of a badge: how an entry of the register stands, with its days where they are few, and who signed for it. */
export function standingOf({ standing, days_left, waivers }) {
  if (!Object.hasOwn(STANDINGS, standing)) return { text: standing, state: "" };
  const waiver = waivers.at(-1);
  if (standing === "expired" && waiver) {
    return waiver.good ? { text: C.standing.waived(waiver.signer), state: "waiting" } : { text: C.standing.damaged, state: "failed" };
  }
  const text = standing === "due_soon" ? C.standing.days(C.standings.due_soon, days_left) : C.standings[standing];
  return { text, state: STANDINGS[standing] };
}

/** What an expired certificate means for campaigns, and what ends that; "" for others. */
export function hintOf({ standing, waivers }) {
  if (standing !== "expired") return "";
  return waivers.at(-1)?.good ? C.standing.waivedHint : C.standing.expiredHint;
}

/** Decimals of a value that is known to two digits of its uncertainty; zeros at the end left out where both have them. */
function decimalsOf(value, uncertainty) {
  const most = Math.max(0, MOST_DIGITS - 1 - Math.floor(Math.log10(uncertainty)));
  return Math.max(...[value, uncertainty].map((each) => each.toFixed(most).match(/\.(\d*[1-9])/)?.[1].length ?? 0));
}

/** "9.80665 m/s²": a value with as many decimals as its standard uncertainty, in the same unit, needs. */
export const valueText = (value, uncertainty, unit) => (value === null ? UNKNOWN : `${number(value, decimalsOf(value, uncertainty))} ${unitText({ unit })}`);

/** A kind of reference; one that is not known here keeps its own name. */
export const kindText = (kind) => (Object.hasOwn(C.references.kinds, kind) ? C.references.kinds[kind] : kind);

/** The day until which a certificate holds: the register has it as YYYY-MM-DD, of no time zone. */
export const dueText = (due) => dayText(new Date(`${due}T00:00`));

export function ratingText({ temp_min_c, temp_max_c }) {
  if (temp_min_c === null || temp_max_c === null) return C.types.notStated;
  return C.types.range(number(temp_min_c, 0), number(temp_max_c, 0));
}

/** Of one kind of sensor, by axis; the same of all three is said once. */
function limitsOf(kind, limits) {
  const names = ["x", "y", "z"].map((axis) => kind.replace(/^[a-z]+/, (sensor) => `${sensor}_${axis}`));
  const values = names.map((name) => limits[name]);
  if (values.every((value) => value !== undefined && value === values[0])) return [C.types.allAxes(kind, written(String(values[0])))];
  return names.filter((name) => limits[name] !== undefined).map((name) => C.types.limit(name, written(String(limits[name]))));
}

/** "gyros, bias 0.05 °/s, accel x 0.02 m/s²": the limits that soak verify asks for. */
export function limitsText(limits) {
  const listed = ["gyro", "accel", "gyro_scale_ppm", "accel_scale_ppm"].flatMap((kind) => limitsOf(kind, limits));
  return listed.length === 0 ? C.types.noLimits : listed.join(", ");
}
