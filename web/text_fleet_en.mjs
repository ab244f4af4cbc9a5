// SPDX-License-Identifier: Apache-2.0
// What the comparison of a type's units says, in English.

import { plural } from "./format.mjs";

export const text = {
  title: "Fleet",
  type: "Type",
  curve: "Curve",
  reading: "Reading the models…",
  noUnits: "No unit is known yet: record or import a run.",
  notListed: (listed, left) => `The last ${listed} by serial number; ${left} more are not compared.`,
  yield: { units: "Units", notJudged: "Not judged", ofJudged: "Yield, of those judged" },
  noModels: "No unit of this type has a model yet: fit one.",
  oneModel: "Only one unit of this type has a model: nothing to compare with yet.",
  ownDrift: (hasMoved) => ` It has ${hasMoved ? "" : "not "}moved since the model before.`,
  apart: (count) => `${count === 0 ? "No unit stands" : plural(count, { one: `${count} unit stands`, other: `${count} units stand` })} out from the others.`,
  few: (count, fewest) => `Too few units to say which is unlike the others: ${count} have a model, ${fewest} are needed.`,
  /** `of`: the units of which two models are compared. */
  moved: (count, of) => (of === 0 ? "Whether one has moved is not known: that takes two models of the same unit, each of several runs."
    : `${plural(of, { one: `Of ${of} unit with a model before`, other: `Of ${of} units with a model before` })}, ${
      count === 0 ? "none has" : plural(count, { one: `${count} has`, other: `${count} have` })} moved since.`),
  rule: (distance, fewest) =>
    `A unit is marked where its curve is more than ${distance} spreads from the median curve (root mean square over the temperatures, every 5 °C). The spread is the standard deviation ` +
    "of the fleet, from the median of the deviations so that a few odd units do not widen it, and never less than what the curves are uncertain by. Of units that differ by chance alone, about 1 in 100 is marked in a fleet of " +
    `${fewest}, fewer in a larger one. Moved means: the newest model differs from the one before, somewhere, by more than the root of the sum of squares of both 95 % bands, widened so that all curves and temperatures ` +
    "of a unit together say so by chance in at most 5 of 100 units. Models of one run are left out, as they do not tell how a unit differs from power-on to power-on.",
  list: {
    title: "Units",
    onlyMarked: "Only those that stand out",
    none: "No unit stands out.",
    fewToMark: (fewest) => `No unit is marked. With fewer than ${fewest} models nobody can say which is unlike the others.`,
    unit: "Unit",
    verdict: "Verdict",
    outliers: "Not like the others in",
    drifts: "Moved since the model before",
    noModel: "no model yet",
    changed: "repaired or changed since its model",
  },
  curves: {
    title: "Curves of all units",
    names: { bias: "Bias", scale: "Scale error" },
    choices: { bias: "Bias", scale: "Scale" },
    of: { bias: (sensor) => `bias of ${sensor}`, scale: (sensor) => `scale error of ${sensor}` },
    axes: { temp: "temperature of the unit, °C", bias: (unit) => `bias, ${unit}`, scale: (unit) => `scale error, ${unit}` },
    none: "No model of this type states such a curve.",
    label: (curve, sensor) => `${curve} of ${sensor}`,
    about: (count, serials, isCompared) => `${plural(count, { one: `${count} unit`, other: `${count} units` })}; ${
      !isCompared ? "too few to compare" : serials.length === 0 ? "none stands out" : plural(serials.length, { one: `${serials[0]} stands out`, other: `${serials.join(", ")} stand out` })}`,
    median: "median",
    spread: "one spread either way",
    each: "each unit",
    some: (drawn, count) => `${drawn} of ${count} units`,
    more: (count) => plural(count, { one: `and ${count} more that stands out`, other: `and ${count} more that stand out` }),
  },
  outlier: (curve, distance, temp_c) => `${curve}: ${distance} spreads, most at ${temp_c} °C`,
  drift: (curve, change, temp_c, band) => `${curve}: ${change} at ${temp_c} °C, band ±${band}`,
};
