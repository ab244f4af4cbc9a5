// SPDX-License-Identifier: Apache-2.0
// What the drawings of sensors say in English, on the page and in reports, which are in English alone.

/** @type {import("./sensor_figures.mjs").FigureWords} */
export const FIGURE_WORDS = {
  temperature: "temperature of the unit, °C",
  bias: (unit) => `bias, ${unit}`,
  scale: "scale error, ppm",
  deployed: "deployed curve",
  mean: "95 %, mean curve",
  fresh: "95 %, one fresh power-on",
  moreRuns: (count) => `and ${count} more runs`,
  sweeps: "▲ heating ▼ cooling",
  drawn: (drawn, total) => `${drawn} of ${total} points drawn`,
  residual: (unit) => `point − curve, ${unit}`,
  shape: (unit) => `the same, each run’s own offset removed, ${unit}`,
  freshRun: "fresh run, in no fit",
  limit: "limit",
  limitBeyond: (limit) => `limit ±${limit}: beyond the drawing`,
  tau: "averaging time τ, s",
  deviation: (unit) => `Allan deviation, ${unit}`,
  interval: "shaded: 95 %",
};
