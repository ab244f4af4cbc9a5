// SPDX-License-Identifier: Apache-2.0
// What the comparison of a type's units means in words. Nothing here touches the page.

import { number, significant, UNKNOWN } from "./format.mjs";
import { sensorText } from "./unit_words.mjs";

const JUDGED = ["pass", "marginal", "fail"];
/** In which unit a curve of a sensor is drawn, and what of the document that takes. */
const SCALE = { unit: "ppm", factor: 1 };
const BIAS = { "deg/s": { unit: "m°/s", factor: 1000 }, "m/s2": { unit: "mm/s²", factor: 1000 } };

export const CURVES = { bias: "Bias", scale: "Scale error" };
export const shownUnit = (sensor, curve) => (curve === "scale" ? SCALE : BIAS[sensor.unit]);

/** [name, value] of how many units passed. */
export function yieldOf({ units }) {
  const count = (verdict) => units.filter((unit) => unit.verdict === verdict).length;
  const [pass, marginal, fail] = JUDGED.map(count);
  const judged = pass + marginal + fail;
  return [
    ["Units", String(units.length)],
    ["PASS", String(pass)],
    ["MARGINAL", String(marginal)],
    ["FAIL", String(fail)],
    ["Not judged", String(units.length - judged)],
    ["Yield, of those judged", judged === 0 ? UNKNOWN : `${Math.round((100 * pass) / judged)} %`],
  ];
}

/** For each unit: where it stands out and what has moved, of all sensors and curves: serial number → {outliers, drifts}. */
export function findingsOf({ sensors }) {
  const found = new Map();
  for (const [name, sensor] of Object.entries(sensors)) {
    for (const curve of Object.keys(CURVES)) {
      for (const unit of sensor[curve]?.units ?? []) {
        if (!found.has(unit.unit)) found.set(unit.unit, { outliers: [], drifts: [] });
        const of = found.get(unit.unit);
        const where = { name, curve, unit: shownUnit(sensor, curve) };
        if (unit.outlier) of.outliers.push({ ...where, distance: unit.distance, farthest_c: unit.farthest_c });
        if (unit.drift?.beyond_band) of.drifts.push({ ...where, ...unit.drift });
      }
    }
  }
  for (const { outliers, drifts } of found.values()) {
    outliers.sort((a, b) => b.distance - a.distance);
    drifts.sort((a, b) => Math.abs(b.change) / b.band - Math.abs(a.change) / a.band);
  }
  return found;
}

const curveName = ({ name, curve }) => `${CURVES[curve].toLowerCase()} of ${sensorText(name)}`;

/** "bias of gyro x: 5.1 spreads, most at 40 °C" */
export const outlierText = (outlier) => `${curveName(outlier)}: ${number(outlier.distance, 1)} spreads, most at ${number(outlier.farthest_c, 0)} °C`;

/** "bias of gyro x: +12 m°/s at 40 °C, band ±4" */
export function driftText(drift) {
  const [change, band] = [drift.change, drift.band].map((value) => significant(drift.unit.factor * value, 2));
  return `${curveName(drift)}: ${drift.change > 0 ? "+" : ""}${change} ${drift.unit.unit} at ${number(drift.temp_c, 0)} °C, band ±${band}`;
}

/** What is to be looked at, in a sentence. */
export function summaryOf(fleet, findings) {
  const all = [...findings.values()];
  const apart = all.filter(({ outliers }) => outliers.length > 0).length;
  const moved = all.filter(({ drifts }) => drifts.length > 0).length;
  const fitted = fleet.units.filter(({ model }) => model !== null).length;
  if (fitted === 0) return "No unit of this type has a model yet: fit one.";
  const few = fitted < fleet.rule.fewest_units ? ` With fewer than ${fleet.rule.fewest_units} models none is marked as an outlier.` : "";
  const units = (n, one, more) => (n === 0 ? `no unit ${one}` : n === 1 ? `1 unit ${one}` : `${n} units ${more}`);
  const text = `${units(apart, "stands", "stand")} out from the others; ${units(moved, "has", "have")} moved since the model before.${few}`;
  return text[0].toUpperCase() + text.slice(1);
}

/** How a unit comes to be marked. */
export const ruleText = ({ rule }) =>
  `A unit is marked where its curve is more than ${rule.outlier_distance} spreads from the median curve (root mean square over the temperatures, every 5 °C). The spread is the standard deviation ` +
  "of the fleet, from the median of the deviations so that a few odd units do not widen it, and never less than what the curves are uncertain by. Of units that differ by chance alone, about 1 in 100 is marked in a fleet of " +
  `${rule.fewest_units}, fewer in a larger one. Moved means: the newest model differs from the one before, somewhere, by more than the root of the sum of squares of both 95 % bands, widened so that all curves and temperatures ` +
  "of a unit together say so by chance in at most 5 of 100 units. Models of one run are left out, as they do not tell how a unit differs from power-on to power-on.";
