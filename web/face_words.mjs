// SPDX-License-Identifier: Apache-2.0
// Units of the campaign and how they rest, in words. Nothing here touches the page.

import { sign, UNKNOWN } from "./format.mjs";
import { T } from "./text.mjs";

/** Degrees from the expected direction within which the station calls a position right (station/lab/position_watch.h). */
const TILT_DEG = 5;

/**
 * @param {import("./documents.mjs").LiveUnit} unit
 * @param {boolean} isOn whether the campaign has it switched on now
 */
export function unitStateText(unit, isOn) {
  if (unit.dropped) return T.unit.dropped;
  if (unit.state === "closed" && isOn) return T.unit.noLink;
  return T.unit.states[unit.state] ?? unit.state;
}

/**
 * Whether its temperature stands still; "" where nothing is known of it.
 * @param {import("./documents.mjs").LiveUnit} unit
 */
export function stableText(unit) {
  if (unit.temp_c === null) return "";
  return unit.stable ? T.unit.stable : T.unit.settling;
}

/** What the unit's accelerometers say: {up, expected, wrong, right}, in its own axes; null where they do not say. */
export function faceOf({ attitude }) {
  if (!attitude) return null;
  const right = attitude.right === true;
  const expected = sign(attitude.expected);
  return { up: right ? expected : sign(attitude.up || UNKNOWN), expected, right, wrong: attitude.right === false };
}

/** How a unit that rests wrong comes to rest as it should: turned, or seated where the right face is up already. */
export function turnText({ up, expected }) {
  if (up === expected) return T.faces.tilted(TILT_DEG, expected);
  return up.slice(1) === expected.slice(1) ? T.faces.half(up, expected) : T.faces.quarter(up, expected);
}

/**
 * The face that is up by the unit's own accelerometers where they say it; else the one that is expected, as such.
 * @param {import("./documents.mjs").LiveUnit} unit
 */
export function positionText(unit) {
  const face = faceOf(unit);
  if (!face) return unit.position ? sign(unit.position) : UNKNOWN;
  if (face.right) return face.up;
  if (!face.wrong) return T.faces.turning(face.expected);
  return face.up === face.expected ? T.faces.isTilted(face.up) : T.faces.wrong(face.up, face.expected);
}

/** Whether every unit that sends rests as the open prompt asks; false where one cannot say. */
export function allRestAsAsked({ units }) {
  const sending = units.filter((unit) => unit.state === "streaming");
  return sending.length > 0 && sending.every((unit) => unit.attitude?.right === true);
}
