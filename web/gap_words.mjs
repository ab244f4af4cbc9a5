// SPDX-License-Identifier: Apache-2.0
// What a gap search and a comparison mean in words. Nothing here touches the page.

import { readable, significant, UNKNOWN } from "./format.mjs";
import { textsOf } from "./text.mjs";
import { sensorText } from "./unit_words.mjs";

/** @type {typeof import("./text_gap_en.mjs").text} */
export const G = await textsOf("gap");

/** States of a badge. */
const VERDICTS = { none: "finished", named: "waiting", accepted: "finished", unknown: "failed", cannot_judge: "" };
const MOST_PER_CENT = 999; // beyond, a fraction says only that the gap was small

/** {title, state} of a search's verdict. */
export const gapVerdictOf = (verdict) => (Object.hasOwn(VERDICTS, verdict) ? { title: G.verdicts[verdict], state: VERDICTS[verdict] } : { title: String(verdict), state: "" });

/** "m°/s", "mm/s²": a thousandth of what the document has. */
const SMALL = { "deg/s": "m°/s", "m/s2": "mm/s²" };
export const smallUnitOf = (sensor) => (sensor.startsWith("gyro") ? SMALL["deg/s"] : SMALL["m/s2"]);
export const small = (value, digits = 2) => (value === null || value === undefined ? UNKNOWN : significant(1000 * value, digits));

/** "312 s, tau 320 s" */
export const sizeText = ({ magnitude, shape }) => `${significant(magnitude.value, 3)} ${readable(magnitude.unit)}${shape ? `, ${shape}` : ""}`;

export const sensorsText = (sensors) => (sensors.length === 6 ? G.allSensors : sensors.map(sensorText).join(", "));

/**
 * Whether all that a search of an earlier model has found is in the newest one by now.
 * @param {any} result
 * @param {import("./documents.mjs").Model} newest
 */
export const isAccepted = ({ verdict, model, effects }, newest) => verdict === "named" && model !== newest.version &&
  effects.every((effect) => newest.terms.some(({ name }) => name === effect.name));

/**
 * What the search has found, in one or two sentences; `newest`: the unit's newest model.
 * @returns {import("./dom.mjs").Part[]}
 */
export function gapText(result, newest) {
  const { verdict, effects, residual_structure: structure } = result;
  if (isAccepted(result, newest)) return [G.found.accepted([...new Set(effects.map(({ name }) => name))].map(G.effect), result.model, newest.version)];
  if (verdict === "none") return [G.found.none];
  if (verdict === "unknown") {
    return G.found.unknown(structure ? G.found.follows(structure.axis, sensorsText(structure.sensors)) : []);
  }
  if (verdict === "cannot_judge") return [G.found.cannotJudge];
  return [G.found.lacks(effects.map((effect) => G.found.one(G.effect(effect.name), sizeText(effect), sensorsText(effect.sensors))))];
}

/** The effect that an experiment has to be recorded for before it is accepted, if any; `effects`: those that the model does not carry. */
const openEffect = (effects) => effects.find(({ next_experiment: next }) => next !== null);

/** Whether accepting is what is to be done next. */
export const acceptsNext = ({ effects }, carried) => openEffect(effects.filter(({ name }) => !carried.includes(name))) === undefined;

/**
 * What is to be done after a search; `carried`: names of the effects that the model has already.
 * @returns {import("./dom.mjs").Part[]}
 */
export function gapNextOf({ verdict, effects: found }, carried) {
  if (verdict === "none") return [G.next.none];
  if (verdict === "unknown") return [G.next.unknown];
  if (verdict === "cannot_judge") return [G.next.cannotJudge];
  const effects = found.filter(({ name }) => !carried.includes(name));
  if (effects.length === 0) return [G.next.carried];
  const open = openEffect(effects);
  if (open) return G.next.tell(open.name, open.confusable_with, open.next_experiment);
  return [G.next.accept(effects.length === found.length ? [] : effects.map(({ name }) => name))];
}

/** Effects of which docs/gap-terms.md says that they take nothing of the mean. */
const OUTSIDE_THE_MEAN = ["noise_vs_temperature", "quantization", "saturation"];

/** Why an effect counts as found that takes nothing of the gap; "" for all others. */
export const outsideText = ({ name }) => (OUTSIDE_THE_MEAN.includes(name) ? G.evidence.outside : "");

/** [name, value] of what speaks for an effect. */
export const evidenceOf = ({ evidence, confusable_with: rivals, sensors, magnitude, shape }) => [
  [G.evidence.size, sizeText({ magnitude, shape })],
  [G.evidence.sensors, sensorsText(sensors)],
  [G.evidence.chance, evidence.p_adjusted < 1e-6 ? G.evidence.hardlyAny : significant(evidence.p_adjusted, 2)],
  [G.evidence.takes, `${Math.round(100 * evidence.heldout_gain)} %`],
  [G.evidence.rivals, rivals.length === 0 ? G.evidence.noRivals : G.either(rivals)],
];

// ---- before and after

/** "84 %", "too small to tell" */
export const closedText = (fraction) => (fraction === null ? G.shown.tooSmall
  : Math.abs(100 * fraction) > MOST_PER_CENT ? G.shown.chance : `${Math.round(100 * fraction)} %`.replace("-", "−"));

export function intervalText(ci95) {
  if (ci95 === null || ci95 === undefined) return UNKNOWN;
  const [low, high] = ci95.map((end) => String(Math.round(100 * end)).replace("-", "−"));
  return G.shown.interval(low, high);
}

/** What fresh runs say of the accepted effects, in a sentence. */
export function shownText({ before, model, terms, runs, sensors }) {
  const fresh = runs.filter(({ use }) => use === "fresh").length;
  if (terms.length === 0) return G.shown.noTerms(model);
  const models = G.shown.models(before, model);
  if (fresh === 0) return G.shown.noFresh(models);
  const acted = new Set(terms.flatMap(({ parts }) => parts.flatMap((part) => part.sensors)));
  const judged = Object.entries(sensors).filter(([name, sensor]) => acted.has(name) && sensor.fresh !== null);
  const closer = judged.filter(([, { fresh: part }]) => part.after_rms < part.before_rms);
  return G.shown.closer(models, fresh, closer.length, judged.length);
}
