// SPDX-License-Identifier: Apache-2.0
// The words of the changes that are made to a procedure, in English.

import { plural } from "./format.mjs";

export const text = {
  points: "Set points in °C, in the order of a run",
  /** `example` of a list, as it is written in this language. */
  pointsHint: (example) => `Write them as ${example}.`,
  reference: (temp) => ` Each run also begins and ends at ${temp} °C, where one run is compared with the next.`,
  rest: "Temperature in °C",
  ramp: "Temperatures in °C that the ramp goes to, in this order",
  evenly: "Or fill them in evenly",
  from: "From, °C",
  to: "To, °C",
  every: "Step, K",
  fill: "Fill in",
  course: "Direction",
  once: "As they stand, once",
  andBack: "There and back again",
  runs: "Runs",
  runsHint: "A run goes over all set points, from power-on to power-off.",
  soak: "Soak at least, min",
  soakHint: "Before anything is recorded. Counted from when the air has reached the set point. It takes longer where a unit needs longer.",
  dwell: "Recorded per position, min",
  dwellAtRest: "Recorded, min",
  name: "Name of the changed procedure",
  nameHint: (source) => `${source} stays as it is. The changed one is kept under this name when you start or queue, and is in the list from then on.`,
  undo: "Undo the changes",
  /** What is changed, in the line that opens the fields. */
  changed: (what) => `Changed: ${what}`,
  mistake: "there is a mistake",
  somePoints: (count) => plural(count, { one: `${count} set point`, other: `${count} set points` }),
  someRuns: (count) => plural(count, { one: `${count} run`, other: `${count} runs` }),
  soakShort: (minutes) => `soak ${minutes} min`,
  dwellShort: (minutes) => `${minutes} min recorded`,
  noPoints: "Enter at least one temperature.",
  noTemperature: (word) => `“${word}” is no temperature.`,
  noNumber: "Enter a number.",
  noWhole: "Enter a whole number, 1 or more.",
  noStep: "Enter three numbers; the step is more than 0.",
  tooMany: (most) => `These are more than ${most} set points: take larger steps.`,
  noName: "1 to 60 letters of a to z, digits, - and _; a letter or a digit first.",
  nameTaken: (name) => `There is a procedure ${name} already: choose another name.`,
};
