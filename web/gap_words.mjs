// SPDX-License-Identifier: Apache-2.0
// What a gap search and a comparison mean in words. Nothing here touches the page.

import { duration, number, readable, significant, UNKNOWN } from "./format.mjs";
import { textsOf } from "./text.mjs";
import { sensorText } from "./unit_words.mjs";

/** @type {typeof import("./text_gap_en.mjs").text} */
export const G = await textsOf("gap");

/** States of a badge. */
const VERDICTS = { none: "finished", named: "waiting", accepted: "finished", unknown: "failed", cannot_judge: "" };
const HARDLY_ANY = 1e-6; // chance below which nobody asks for the figure
const FAR_ABOVE = 3; // floors, from which on a gap that nothing was accepted for is told
const MOST_PER_CENT = 999; // beyond, a fraction says only that the gap was small

/** {title, state} of a search's verdict. */
export const gapVerdictOf = (verdict) => (Object.hasOwn(VERDICTS, verdict) ? { title: G.verdicts[verdict], state: VERDICTS[verdict] } : { title: String(verdict), state: "" });

/** The unit of a sensor's bias, as everywhere on the page. */
export const biasUnitOf = (sensor) => (sensor.startsWith("gyro") ? "°/s" : "m/s²");
export const biasText = (value, digits = 2) => (value === null || value === undefined ? UNKNOWN : significant(value, digits));

/** Units of a size that only one kind of sensor has. */
const OF_KIND = { "deg/s": "gyro", "m/s2": "accel", "m/s²": "accel" };

/** "312 s, tau 320 s"; of an effect in gyros and accelerometers whose size is in the unit of one kind, which kind that is. */
export function sizeText({ magnitude, shape, sensors = [] }) {
  const kind = OF_KIND[magnitude.unit];
  const isOfOne = kind !== undefined && sensors.some((sensor) => !sensor.startsWith(kind)) && sensors.some((sensor) => sensor.startsWith(kind));
  return `${significant(magnitude.value, 3)} ${readable(magnitude.unit)}${isOfOne ? ` (${G.sizeOf[kind]})` : ""}${shape ? `, ${shape}` : ""}`;
}

export const sensorsText = (sensors) => (sensors.length === 6 ? G.allSensors : sensors.map(sensorText).join(", "));

/** What the station says of an experiment, as people write it: names without underscores, a true minus sign. */
export const plain = (text) => text.replace(/([a-z])_(?=[a-z])/g, "$1 ").replace(/(^|\s)-(?=\d)/g, "$1−");

/**
 * Whether all that a search of an earlier model has found is in the newest one by now.
 * @param {any} result
 * @param {import("./documents.mjs").Model} newest
 */
export const isAccepted = ({ verdict, model, effects }, newest) => verdict === "named" && model !== newest.version &&
  effects.every((effect) => newest.terms.some(({ name }) => name === effect.name));

/**
 * What the search has found, in one or two sentences; `newest`: the unit's newest model.
 * @param {import("./documents.mjs").GapFind} result
 * @param {import("./documents.mjs").Model} newest
 * @returns {import("./dom.mjs").Part[]}
 */
export function gapText(result, newest) {
  const { verdict, effects } = result;
  if (isAccepted(result, newest)) return [G.found.accepted([...new Set(effects.map(({ name }) => name))].map(G.effect), result.model, newest.version)];
  if (verdict === "none") return [G.found.none];
  if (verdict === "unknown") return unknownText(result);
  if (verdict === "cannot_judge") return [G.found.cannotJudge];
  return [G.found.lacks(effects.map(withSize))];
}

const withSize = (effect) => G.found.one(effect.name, sizeText(effect), sensorsText(effect.sensors));

/**
 * What is not explained, where, and how much of it there is; of steps the largest against the noise.
 * @param {import("./documents.mjs").GapFind} result
 * @returns {import("./dom.mjs").Part[]}
 */
function unknownText({ residual_structure: structure, suspects, gap }) {
  const over = (sensor) => (gap[sensor]?.floor_rms > 0 ? gap[sensor].before_rms / gap[sensor].floor_rms : 0);
  const sensors = structure?.sensors ?? suspects.flatMap((suspect) => suspect.sensors);
  const [most] = [...sensors].sort((a, b) => over(b) - over(a));
  const size = most !== undefined && over(most) > 0 ? [G.found.gap(sensorText(most), biasText(gap[most].before_rms, 3), biasText(gap[most].floor_rms, 3), biasUnitOf(most))] : [];
  if (structure === null) return [...G.found.unknown([]), ...size];
  const steps = structure.steps ?? [];
  if (structure.kind !== "telegraph_noise" && steps.length > 0) {
    const inNoise = (step) => Math.abs(step.size) / (gap[step.sensor]?.floor_rms || 1);
    const largest = steps.reduce((a, b) => (inNoise(b) > inNoise(a) ? b : a));
    return [G.found.step(sensorText(largest.sensor), biasText(largest.size), biasUnitOf(largest.sensor), largest.run, whenText(largest), number(largest.temp_c, 0), steps.length - 1)];
  }
  const where = structure.kind === "telegraph_noise" ? [G.found.jumps(sensorsText(sensors))] : G.found.follows(structure.axis, sensorsText(sensors));
  return [...G.found.unknown(where), ...size];
}

/** "0.0011 to 0.0014 °/s in a gyro": the sizes at the gate, of gyros and of accelerometers. */
function limitsText(limit) {
  return [true, false].flatMap((isGyro) => {
    const sensors = Object.keys(limit).filter((sensor) => sensor.startsWith("gyro") === isGyro);
    if (sensors.length === 0) return [];
    const values = sensors.map((sensor) => limit[sensor]);
    return [G.sure.limit(biasText(Math.min(...values)), biasText(Math.max(...values)), biasUnitOf(sensors[0]), isGyro)];
  });
}

/** When a bias stepped: from the last block before to the first after it. */
const whenText = ({ last_before_s: before, since_start_s: since }) => {
  const [from, to] = [before, since].map((seconds) => duration(60 * Math.round(seconds / 60)));
  return from === to ? to : G.steps.span(from, to);
};

/** What stands of a structure in the language of the page; nulls where it is not known. */
const aboutOf = (structure, heldOut) => G.kinds(structure?.kind ?? "", heldOut !== "run", structure?.runs ?? 0) ?? { usual: null, look: null };

/** Odds below which a rival is out: on campaigns of another laboratory all 297 first names that stood so were right. */
const OUT = 1e-6;

/** Rivals that have a chance beside the effect; of some no odds are known, of none in documents kept before they were told. */
export const openRivals = ({ confusable_with: rivals, odds }) => rivals.filter((name) => (odds?.[name] ?? 1) >= OUT);

/** Whether there is one. */
export const isOpen = (effect) => openRivals(effect).length > 0;

/**
 * How sure that is, and what it cannot be told from; `isCompared`: fresh runs were, with what was accepted.
 * @param {import("./documents.mjs").GapFind} result
 * @param {import("./documents.mjs").Model} newest
 * @returns {import("./dom.mjs").Part[]}
 */
export function gapSureOf(result, newest, isCompared = false) {
  const { verdict, effects, suspects, residual_structure: structure, held_out: heldOut, detection_limit: limit, reason } = result;
  if (isAccepted(result, newest)) return [isCompared ? G.sure.compared : G.sure.accepted];
  if (verdict === "none") return [G.sure.none(limitsText(limit))];
  if (verdict === "cannot_judge") return G.sure.cannotJudge(reason);
  if (verdict === "unknown") {
    const { usual } = aboutOf(structure, heldOut);
    if (suspects.length > 0) return [G.sure.suspected(suspects.map(withSize), usual)];
    return usual === null ? [] : [G.sure.usual(usual)];
  }
  const chance = effects.every(({ evidence }) => evidence.p_adjusted < HARDLY_ANY) ? G.sure.certain : G.sure.likely;
  const withRivals = effects.filter(({ confusable_with: rivals }) => rivals.length > 0);
  if (withRivals.length === 0) return [G.sure.alone(chance)];
  const pairs = (/** @type {typeof effects} */ list, rivalsOf) => list.map((effect) => /** @type {[string, string[]]} */ ([effect.name, rivalsOf(effect)]));
  const doubts = withRivals.filter(isOpen);
  return [doubts.length === 0 ? G.sure.decided(chance, pairs(withRivals, ({ confusable_with: rivals }) => rivals)) : G.sure.rivals(chance, pairs(doubts, openRivals))];
}

/** The effect that an experiment has to be recorded for before it is accepted, if any; `effects`: those that the model does not carry. */
export const openEffect = (effects) => effects.find((effect) => effect.next_experiment !== null && isOpen(effect));

/** Whether accepting is what is to be done next. */
export const acceptsNext = ({ effects }, carried) => openEffect(effects.filter(({ name }) => !carried.includes(name))) === undefined;

/** What to record, or where to look. */
function nextOfUnknown(structure, heldOut) {
  if (heldOut === "half") return G.next.thirdBranch;
  if (heldOut === "branch" && structure?.kind === "drift_in_run") return G.next.sameCycle;
  const apart = structure?.closer_plateaus_k ?? null;
  if (apart !== null) return G.next.plateaus(apart);
  const { look } = aboutOf(structure, heldOut);
  if (structure === null) return G.next.again;
  return look === null ? G.next.unknown : G.next.look(look);
}

/**
 * What is to be done after a search; `carried`: names of the effects that the model has already; `check`: a check campaign that no fit has seen, or null.
 * @returns {import("./dom.mjs").Part[]}
 */
export function gapNextOf({ verdict, effects: found, residual_structure: structure, held_out: heldOut }, carried, check = null) {
  if (verdict === "none") return [G.next.none];
  if (verdict === "unknown") return [nextOfUnknown(structure ?? null, heldOut)];
  if (verdict === "cannot_judge") return [G.next.cannotJudge];
  const effects = found.filter(({ name }) => !carried.includes(name));
  if (effects.length === 0) return [check === null ? G.next.carried : G.next.carriedWith(check)];
  const open = openEffect(effects);
  if (open) return G.next.tell(open.name, openRivals(open), plain(open.next_experiment));
  const names = effects.length === found.length ? [] : effects.map(({ name }) => name);
  return [check === null ? G.next.accept(names) : G.next.acceptWith(names, check)];
}

/** Effects of which docs/gap-terms.md says that they take nothing of the mean. */
const OUTSIDE_THE_MEAN = ["noise_vs_temperature", "quantization", "saturation"];

/** Why an effect counts as found that takes nothing of the gap; "" for all others. */
export const outsideText = ({ name }) => (OUTSIDE_THE_MEAN.includes(name) ? G.evidence.outside : "");

/** How much of the gap an effect explains: "explains 84 % of the gap", of one outside the mean that it explains nothing of it. */
export const shareText = (effect) => (outsideText(effect) ? G.accept.outside : G.accept.share(Math.round(100 * effect.evidence.heldout_gain)));

/** What explains nearly as much as an effect: what is out only as such. */
function rivalsText(effect) {
  const open = openRivals(effect);
  if (open.length > 0) return G.either(open);
  return effect.confusable_with.length === 0 ? G.evidence.noRivals : G.evidence.ruledOut(effect.confusable_with);
}

/** The experiment that tells an effect from its rivals; null where none is left, or the model carries it already. */
export const experimentOf = (effect, isCarried) => (isCarried || !isOpen(effect) ? null : effect.next_experiment);

/** [name, value] of what speaks for an effect. */
export const evidenceOf = (effect) => [
  [G.evidence.size, sizeText(effect)],
  [G.evidence.sensors, sensorsText(effect.sensors)],
  [G.evidence.chance, effect.evidence.p_adjusted < HARDLY_ANY ? G.evidence.hardlyAny : significant(effect.evidence.p_adjusted, 2)],
  [G.evidence.takes, `${Math.round(100 * effect.evidence.heldout_gain)} %`],
  [G.evidence.rivals, rivalsText(effect)],
];

// ---- slow noise, and where a bias steps

/**
 * Rows of the table of slow noise.
 * @param {import("./documents.mjs").SlowNoise[]} list
 */
export const slowNoiseRows = (list) => list.map(({ sensor, within_run: size, share_minutes: minutes, share_hours: hours, bias_instability: rest }) => [
  sensorText(sensor), biasText(size), biasUnitOf(sensor), `${Math.round(100 * minutes)} %`, `${Math.round(100 * hours)} %`,
  rest === null ? UNKNOWN : G.slow.rest(biasText(rest.value), biasText(rest.ci95[0]), biasText(rest.ci95[1]))]);

/**
 * Rows of the table of steps.
 * @param {import("./documents.mjs").BiasStep[]} steps
 */
export const stepRows = (steps) => steps.map((step) => [
  step.run, sensorText(step.sensor), whenText(step), number(step.temp_c, 1), biasText(step.size), biasUnitOf(step.sensor)]);

// ---- before and after

/** "84 %", "too small to tell" */
export const closedText = (fraction) => (fraction === null ? G.shown.tooSmall
  : Math.abs(100 * fraction) > MOST_PER_CENT ? G.shown.chance : `${Math.round(100 * fraction)} %`.replace("-", "−"));

export function intervalText(ci95) {
  if (ci95 === null || ci95 === undefined) return UNKNOWN;
  const [low, high] = ci95.map((end) => String(Math.round(100 * end)).replace("-", "−"));
  return G.shown.interval(low, high);
}

/** The terms that show in the mean; all, where none does. */
function inTheMean(terms) {
  const shown = terms.filter(({ name }) => !OUTSIDE_THE_MEAN.includes(name));
  return shown.length > 0 ? shown : terms;
}

/** Sensors that the terms act on. */
const sensorsOf = (terms) => new Set(terms.flatMap(({ parts }) => parts.flatMap((part) => part.sensors)));

/** Whether a comparison has seen a fresh run. */
export const hasFresh = ({ runs }) => runs.some(({ use }) => use === "fresh");

/** What fresh runs say of the accepted effects, in a sentence; and beside it what was expected. */
export function shownText({ before, model, terms, runs, sensors }) {
  const fresh = runs.filter(({ use }) => use === "fresh").length;
  if (terms.length === 0) return G.shown.noTerms(model);
  const models = G.shown.models(before, model);
  if (fresh === 0) return G.shown.noFresh(models);
  const acted = sensorsOf(inTheMean(terms));
  const judged = Object.entries(sensors).filter(([name, sensor]) => acted.has(name) && sensor.fresh !== null);
  const closer = judged.filter(([, { fresh: part }]) => part.after_rms < part.before_rms);
  const said = G.shown.closer(models, fresh, closer.length, judged.length);
  return closer.length < judged.length ? said : said + expectedText(inTheMean(terms), judged, Object.entries(sensors).filter(([name]) => !acted.has(name)));
}

/** How the closed part of the gap lies to what was expected when the effects were accepted; "" where nothing was. `others`: sensors that they do not act on. */
function expectedText(terms, judged, others) {
  const expected = (sensor) => terms.filter((term) => sensorsOf([term]).has(sensor)).at(-1)?.gap?.[sensor]?.closed_ci95 ?? null; // effects may be accepted in several steps
  const known = judged.filter(([name, { fresh }]) => fresh.closed_fraction !== null && expected(name) !== null);
  const less = known.filter(([name, { fresh }]) => fresh.closed_fraction < expected(name)[0]);
  if (less.length === 0) return known.length > 0 && judged.every(([name]) => expected(name) !== null) ? G.shown.asExpected : "";
  const off = others.filter(([, { fresh }]) => fresh !== null && fresh.after_rms > FAR_ABOVE * fresh.floor_rms);
  const names = (list) => list.map(([name]) => sensorText(name)).join(", ");
  return G.shown.less(names(less)) + (off.length > 0 ? G.shown.curve(names(off)) : G.shown.searchAgain);
}
