// SPDX-License-Identifier: Apache-2.0
// What a gap search and a comparison mean in words. Nothing here touches the page.

import { significant, UNKNOWN } from "./format.mjs";

const VERDICTS = {
  none: { title: "NOTHING FOUND", state: "finished" },
  named: { title: "EFFECT FOUND", state: "waiting" },
  unknown: { title: "NOT EXPLAINED", state: "failed" },
  cannot_judge: { title: "CANNOT BE JUDGED", state: "" },
};
const MOST_PER_CENT = 999; // beyond, a fraction says only that the gap was small

/** {title, state} of a search's verdict. */
export const gapVerdictOf = (verdict) => (Object.hasOwn(VERDICTS, verdict) ? VERDICTS[verdict] : { title: String(verdict), state: "" });

/** "sensor lag" */
export const effectName = (name) => name.replaceAll("_", " ");

/** "m°/s", "mm/s²": a thousandth of what the document has. */
const SMALL = { "deg/s": "m°/s", "m/s2": "mm/s²" };
export const smallUnitOf = (sensor) => (sensor.startsWith("gyro") ? SMALL["deg/s"] : SMALL["m/s2"]);
export const small = (value, digits = 2) => (value === null || value === undefined ? UNKNOWN : significant(1000 * value, digits));

/** "312 s, tau 320 s" */
export const sizeText = ({ magnitude, shape }) => `${significant(magnitude.value, 3)} ${magnitude.unit}${shape ? `, ${shape}` : ""}`;

export const sensorsText = (sensors) => (sensors.length === 6 ? "all sensors" : sensors.map((name) => name.replace("_", " ")).join(", "));

const listed = (names) => names.map(effectName).join(" or ");

/** What the search has found, in one or two sentences. */
export function gapText({ verdict, effects, residual_structure: structure }) {
  if (verdict === "none") return "What the unit read beyond the model is no more than how its runs differ. Smaller effects may be there unseen: the limits are below.";
  if (verdict === "unknown") {
    const where = structure ? ` It follows ${structure.axis}, in ${sensorsText(structure.sensors)}.` : "";
    return `The unit reads something that no known effect explains.${where} Nothing is named on a guess.`;
  }
  if (verdict === "cannot_judge") return "These runs cannot show whether the model lacks something.";
  const found = effects.map((effect) => `${effectName(effect.name)} (${sizeText(effect)}) in ${sensorsText(effect.sensors)}`);
  return `The model lacks ${found.join("; and ")}.`;
}

/** The effect that an experiment has to be recorded for before it is accepted, if any; `effects`: those that the model does not carry. */
const openEffect = (effects) => effects.find(({ next_experiment: next }) => next !== null);

/** Whether accepting is what is to be done next. */
export const acceptsNext = ({ effects }, carried) => openEffect(effects.filter(({ name }) => !carried.includes(name))) === undefined;

/** What is to be done after a search; `carried`: names of the effects that the model has already. */
export function gapNextOf({ verdict, effects: found }, carried) {
  if (verdict === "none") return "The model lacks nothing that these runs can show: go on with what stands at the top.";
  if (verdict === "unknown") return "Look along that axis: fixture, cables, building. Then record again and search again.";
  if (verdict === "cannot_judge") return "Record another run of the same procedure, or void the run that the reason names. Then search again.";
  const effects = found.filter(({ name }) => !carried.includes(name));
  if (effects.length === 0) return "The model carries what was found already: record a run that no fit has seen, then compare before and after.";
  const open = openEffect(effects);
  if (open) return `${effectName(open.name)} is hardly told from ${listed(open.confusable_with)}. Before you accept it, record this: ${open.next_experiment}.`;
  const which = effects.length === found.length ? "it" : effects.map(({ name }) => effectName(name)).join(" and ");
  return `Accept ${which}, record a run that no fit has seen, then compare before and after.`;
}

/** Effects of which docs/gap-terms.md says that they take nothing of the mean. */
const OUTSIDE_THE_MEAN = ["noise_vs_temperature", "quantization", "saturation"];

/** Why an effect counts as found that takes nothing of the gap; "" for all others. */
export const outsideText = ({ name }) => (OUTSIDE_THE_MEAN.includes(name) ? "It shows in the single samples, not in their mean: the gap, which is one of means, stays as it is." : "");

/** [name, value] of what speaks for an effect. */
export const evidenceOf = ({ evidence, confusable_with: rivals, sensors, magnitude, shape }) => [
  ["Size", sizeText({ magnitude, shape })],
  ["In", sensorsText(sensors)],
  ["Chance that scatter looks like it", evidence.p_adjusted < 1e-6 ? "below 1 in a million" : significant(evidence.p_adjusted, 2)],
  ["Takes of the gap in runs set aside", `${Math.round(100 * evidence.heldout_gain)} %`],
  ["Nearly as good", rivals.length === 0 ? "nothing else" : listed(rivals)],
];

// ---- before and after

/** "84 %", "too small to tell" */
export const closedText = (fraction) => (fraction === null ? "too small to tell"
  : Math.abs(100 * fraction) > MOST_PER_CENT ? "chance: the gap was small" : `${Math.round(100 * fraction)} %`.replace("-", "−"));

export const intervalText = (ci95) => (ci95 === null || ci95 === undefined ? UNKNOWN : `${ci95.map((end) => Math.round(100 * end)).join(" to ").replaceAll("-", "−")} %`);

/** What fresh runs say of the accepted effects, in a sentence. */
export function shownText({ before, model, terms, runs, sensors }) {
  const fresh = runs.filter(({ use }) => use === "fresh").length;
  if (terms.length === 0) return `Model ${model} carries no accepted effect: this is how far it is from what was measured.`;
  const which = `Model ${before} before, model ${model} after`;
  if (fresh === 0) return `${which}. No run is fresh, so nothing is proved yet: record one that no fit has seen.`;
  const acted = new Set(terms.flatMap(({ parts }) => parts.flatMap((part) => part.sensors)));
  const judged = Object.entries(sensors).filter(([name, sensor]) => acted.has(name) && sensor.fresh !== null);
  const closer = judged.filter(([, { fresh: part }]) => part.after_rms < part.before_rms);
  const how = closer.length === judged.length ? "the gap is smaller in every sensor" : `the gap is smaller in ${closer.length} of ${judged.length} sensors`;
  return `${which}, on ${fresh} fresh ${fresh === 1 ? "run" : "runs"}: ${how} that the effects act on.`;
}
