// SPDX-License-Identifier: Apache-2.0
// What is stated of a sensor's curve, and how far two of them are apart. Nothing here touches the page.

import { number, significant, UNKNOWN } from "./format.mjs";
import { U, unitText } from "./unit_words.mjs";

/** An error as people read it; small ones with the digits that they have. */
const size = (value) => (value === null ? UNKNOWN : significant(value, 2));

/**
 * [name, value] of what is stated of a sensor's curve.
 * @param {import("./documents.mjs").Sensor} sensor
 */
export function sensorFacts(sensor) {
  const unit = unitText(sensor);
  const residual = sensor.check_rmse_shape === null ? [U.sensors.residualFit, `${size(sensor.train_rmse)} ${unit}`]
    : [U.sensors.residualHeldOut, `${size(sensor.check_rmse_shape)} ${unit}`];
  const widest = Math.max(...sensor.curve.map(({ ci95 }) => ci95));
  return [
    [U.sensors.curve, sensor.deployed === "anfis" ? U.sensors.rules(sensor.rules) : U.sensors.kind(sensor.deployed)],
    residual,
    [U.sensors.runToRun, sensor.run_to_run_sigma === null ? U.sensors.notKnown : `${size(sensor.run_to_run_sigma)} ${unit}`],
    [U.sensors.span, U.sensors.range(number(sensor.temp_min_c, 0), number(sensor.temp_max_c, 0))],
    [U.sensors.widest, `±${size(widest)} ${unit}`],
  ];
}

/** A member of a curve at a temperature, between the two points beside it; null beyond its ends, and where it is not known there. */
function valueAt(curve, key, temp_c) {
  const above = curve.findIndex((point) => point.temp_c >= temp_c);
  const [left, right] = [curve[above - 1] ?? curve[above], curve[above]];
  if (right === undefined || left.temp_c > temp_c || typeof left[key] !== "number" || typeof right[key] !== "number") return null;
  const share = right.temp_c === left.temp_c ? 0 : (temp_c - left.temp_c) / (right.temp_c - left.temp_c);
  return left[key] + share * (right[key] - left[key]);
}

/**
 * Where the curves of two models of a sensor are farthest apart, at the temperatures of the first: {temp_c, difference, band}, `band`: the wider of the
 * two 95 % bands there, null where none is known. Null where they have no temperature in common.
 * @param {import("./documents.mjs").Sensor["curve"]} newest
 * @param {import("./documents.mjs").Sensor["curve"]} older
 * @param {[string, string]} keys of value and band
 */
export function largestDifference(newest, older, [value, band]) {
  let largest = null;
  for (const point of newest) {
    const before = valueAt(older, value, point.temp_c);
    if (before === null || typeof point[value] !== "number") continue;
    const difference = point[value] - before;
    if (largest !== null && Math.abs(difference) <= Math.abs(largest.difference)) continue;
    const bands = [point[band], valueAt(older, band, point.temp_c)].filter((half) => typeof half === "number");
    largest = { temp_c: point.temp_c, difference, band: bands.length > 0 ? Math.max(...bands) : null };
  }
  return largest;
}

/** The same in a sentence; "" where neither curve is known: of a scale. */
export function differenceText(newest, older, keys, unit) {
  if (![newest, older].every((curve) => curve.some((point) => typeof point[keys[0]] === "number"))) return "";
  const largest = largestDifference(newest, older, keys);
  if (largest === null) return U.sensors.notTogether;
  const { difference, temp_c, band } = largest;
  if (difference === 0) return U.sensors.same;
  return U.sensors.difference(`${difference > 0 ? "+" : ""}${significant(difference, 3)}`, unit, number(temp_c, 0), significant(band, 2));
}
