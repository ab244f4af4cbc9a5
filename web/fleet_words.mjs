// SPDX-License-Identifier: Apache-2.0
// What the comparison of a type's units means in words. Nothing here touches the page.

import { number, significant, UNKNOWN, written } from "./format.mjs";
import { textsOf } from "./text.mjs";
import { sensorText, verdictOf } from "./unit_words.mjs";

/** @type {typeof import("./text_fleet_en.mjs").text} */
export const F = await textsOf("fleet");

const JUDGED = ["pass", "marginal", "fail"];
/** In which unit a curve of a sensor is drawn, and what of the document that takes. */
const SCALE = { unit: "ppm", factor: 1 };
const BIAS = { "deg/s": { unit: "°/s", factor: 1 }, "m/s2": { unit: "m/s²", factor: 1 } };

export const CURVES = ["bias", "scale"];
export const shownUnit = (sensor, curve) => (curve === "scale" ? SCALE : BIAS[sensor.unit]);

/** [name, value] of how many units passed. */
export function yieldOf({ units }) {
  const count = (verdict) => units.filter((unit) => unit.verdict === verdict).length;
  const counts = JUDGED.map(count);
  const judged = counts.reduce((sum, one) => sum + one);
  return [
    [F.yield.units, String(units.length)],
    ...JUDGED.map((verdict, i) => [verdictOf(verdict).title, String(counts[i])]),
    [F.yield.notJudged, String(units.length - judged)],
    [F.yield.ofJudged, judged === 0 ? UNKNOWN : `${Math.round((100 * count("pass")) / judged)} %`],
  ];
}

/** For each unit: where it stands out and what has moved, of all sensors and curves: serial number → {outliers, drifts}. */
export function findingsOf({ sensors }) {
  const found = new Map();
  for (const [name, sensor] of Object.entries(sensors)) {
    for (const curve of CURVES) {
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

const curveName = ({ name, curve }) => F.curves.of[curve](sensorText(name));

/** "bias of gyro x: 5.1 spreads, most at 40 °C" */
export const outlierText = (outlier) => F.outlier(curveName(outlier), number(outlier.distance, 1), number(outlier.farthest_c, 0));

/** "bias of gyro x: +0.012 °/s at 40 °C, band ±0.004" */
export function driftText(drift) {
  const [change, band] = [drift.change, drift.band].map((value) => significant(drift.unit.factor * value, 2));
  return F.drift(curveName(drift), `${drift.change > 0 ? "+" : ""}${change} ${drift.unit.unit}`, number(drift.temp_c, 0), band);
}

/** How many units are compared with their model before. */
function comparedBefore({ sensors }) {
  const compared = Object.values(sensors).flatMap((sensor) => CURVES.flatMap((curve) => sensor[curve]?.units.filter(({ drift }) => drift) ?? []));
  return new Set(compared.map(({ unit }) => unit)).size;
}

/** Whether the only unit with a model has moved since its model before; "" where no model before is compared. */
const ownDriftText = (fleet, hasMoved) => (comparedBefore(fleet) > 0 ? F.ownDrift(hasMoved) : "");

/** Whether there are enough units to say which is unlike the others. */
export const isCompared = ({ units, rule }) => units.filter(({ model }) => model !== null).length >= rule.fewest_units;

/** Why no unit is in the list of those that stand out. */
export const noneMarked = (fleet) => (isCompared(fleet) ? F.list.none : F.list.fewToMark(fleet.rule.fewest_units));

/** What is to be looked at, in a sentence. */
export function summaryOf(fleet, findings) {
  const all = [...findings.values()];
  const apart = all.filter(({ outliers }) => outliers.length > 0).length;
  const moved = all.filter(({ drifts }) => drifts.length > 0).length;
  const fitted = fleet.units.filter(({ model }) => model !== null).length;
  if (fitted === 0) return F.noModels;
  if (fitted === 1) return F.oneModel + ownDriftText(fleet, moved > 0);
  return [isCompared(fleet) ? F.apart(apart) : F.few(fitted, fleet.rule.fewest_units), F.moved(moved, comparedBefore(fleet))].join(" ");
}

/** How a unit comes to be marked. */
export const ruleText = ({ rule }) => F.rule(written(String(rule.outlier_distance)), rule.fewest_units);
