// SPDX-License-Identifier: Apache-2.0
// What the documents of units mean in words that a technician acts on. Nothing here touches the page.

import { clock, number, significant } from "./format.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_units_en.mjs").text} */
export const U = await textsOf("units");

/** States of a badge. */
const VERDICTS = { pass: "finished", marginal: "waiting", fail: "failed", not_measured: "waiting" };

/** {title, state}: of the document's verdict, null where nothing has been judged. */
export const verdictOf = (verdict) =>
  verdict !== null && Object.hasOwn(VERDICTS, verdict) ? { title: U.verdicts[verdict], state: VERDICTS[verdict] } : { title: U.verdicts.none, state: "" };

/**
 * The verdict that holds for the newest model, or null.
 * @param {import("./documents.mjs").Unit} unit
 */
export function verdictNow({ verification }) {
  return verification && verification.stale === null ? (verification.job.result.verdict ?? null) : null;
}

/**
 * {title, state} of what stands at the top: that a model is withdrawn comes before any verdict.
 * @param {import("./documents.mjs").Unit} unit
 */
export const headOf = (unit) =>
  unit.model?.state === "withdrawn" ? { title: U.verdicts.withdrawn, state: "failed" } : verdictOf(verdictNow(unit));

/**
 * What was found of each curve that has a limit: the worst error, its U, the limit, at which temperature; the nearest to its limit first.
 * @param {any} result of a verification
 * @param {import("./documents.mjs").Model} model
 */
export function judgedCurves({ sensors }, model) {
  const curve = (name, isScale, { worst_abs: worst, guard, limit, worst_temp_c: temp_c }, verdict) =>
    ({ name, isScale, worst, guard, limit, temp_c, verdict, unit: isScale ? "ppm" : unitText(model.sensors[name] ?? { unit: "" }) });
  return Object.entries(sensors).flatMap(([name, sensor]) => [
    curve(name, false, sensor, sensor.bias_verdict ?? sensor.verdict), ...(sensor.scale ? [curve(name, true, sensor.scale, sensor.scale.verdict)] : []),
  ]).filter(({ limit, worst }) => typeof limit === "number" && typeof worst === "number").sort((a, b) => (b.worst + (b.guard ?? 0)) / b.limit - (a.worst + (a.guard ?? 0)) / a.limit);
}

/** @returns {[string, string]} an error and its U to the same decimal: that of the second digit of U (JCGM 100:2008, 7.2.6); without a U two digits */
export function errorTexts(worst, guard) {
  if (typeof guard !== "number" || !(guard > 0)) return [significant(worst, 2), significant(guard, 2)];
  const decimals = Math.max(0, 1 - Math.floor(Math.log10(guard)));
  return [number(worst, decimals), number(guard, decimals)];
}

/** " Nearest to its limit: accel y, 0.021 ± 0.009 of 0.03 m/s² at 26 °C."; "" where no limit is set. */
function nearestText(result, model) {
  const [nearest] = judgedCurves(result, model);
  if (nearest === undefined) return "";
  const { name, isScale, worst, guard, limit, temp_c, unit } = nearest;
  const told = worst > limit ? U.judged.beyond : U.judged.nearest;
  return ` ${told(U.judged.curve(sensorText(name), isScale), ...errorTexts(worst, guard), significant(limit, 2), unit, number(temp_c, 0))}`;
}

/**
 * Why what was found does not hold any more, in the words of the page where it has any.
 * @param {string} why
 * @returns {import("./dom.mjs").Part}
 */
export const stalePart = (why) => (Object.hasOwn(U.stale, why) ? U.stale[why] : { english: why });

const curvesWith = (sensors, verdict) =>
  Object.entries(sensors).filter(([, sensor]) => sensor.verdict === verdict).map(([name]) => sensorText(name)).join(", ");

/** Whether a verification of the newest model is stored, as the rule of release sees it. */
const wasVerified = ({ model, release }) =>
  model.state !== "withdrawn" && release?.obstacles !== undefined && (release.obstacles.length > 0 || model.state !== "fitted") && !release.obstacles.some((text) => /^it was never verified/.test(text));

/**
 * Why the verdict is what it is, one sentence.
 * @param {import("./documents.mjs").Unit} unit
 * @returns {import("./dom.mjs").Part[]}
 */
export function verdictText(unit) {
  const { model, verification } = unit;
  if (model === null) return [U.why.noModel];
  if (model.withdrawn) return [U.why.withdrawn(model.version, clock(model.withdrawn.utc_s), model.withdrawn.user, model.withdrawn.reason)];
  if (verification === null) return [wasVerified(unit) ? U.why.verifiedElsewhere(model.version) : U.why.notVerified(model.version)];
  const { job, stale } = verification;
  const by = U.why.by(job.result.model, job.campaign, job.user);
  if (stale !== null) return U.why.stale(stalePart(stale), verdictOf(job.result.verdict).title, by);
  const { verdict, sensors, limits } = job.result;
  if (verdict === "info" && limits === null) return [U.why.noLimits(by, unit.type)];
  const which = verdict === "pass" ? "" : curvesWith(sensors, verdict === "info" ? "not_measured" : verdict);
  return [`${by}: ${[U.why.judged[verdict], which].filter(Boolean).join(": ")}.${nearestText(job.result, model)}`];
}

/**
 * Whether a released model failed a verification since, has passed the last one, and only has to be released again.
 * @param {{obstacles: string[]} | null} release
 */
export const isToReleaseAgain = (release) => release?.obstacles.length === 1 && /^a verification on .* after its release, said \w+: release it again /.test(release.obstacles[0]);

/**
 * What became of a model, as a badge: one that breaks the rule of release by now does not look as if it might be handed over.
 * @param {{state: import("./documents.mjs").Model["state"]}} model
 * @param {{obstacles: string[]} | null} release
 */
export function stateBadge({ state }, release) {
  const isBlocked = Object.hasOwn(U.blocked, state) && (release?.obstacles.length ?? 0) > 0;
  return isBlocked ? { text: U.blocked[state], state: "waiting" } : { text: U.states[state], state };
}

/**
 * What became of the newest model, and whether it is of simulated data.
 * @param {import("./documents.mjs").Unit} unit
 */
export function badgesOf({ model, release }) {
  if (model === null) return [];
  const state = stateBadge(model, release);
  return model.simulated ? [state, { text: U.unit.simulated, state: "simulated" }] : [state];
}

/**
 * Whether what a gap search has found is neither in the model nor explained.
 * @param {import("./documents.mjs").Unit} unit
 */
function isGapOpen({ model, gap: { find } }) {
  if (find === null) return false;
  const { verdict, effects } = find.job.result;
  if (verdict === "unknown") return find.stale === null;
  const carried = model.terms.map(({ name }) => name);
  const isOld = find.stale !== null && find.job.result.model === model.version;
  return verdict === "named" && !isOld && effects.some(({ name }) => !carried.includes(name));
}

/**
 * What is to be done with a model that has passed; as nextOf().
 * @param {import("./documents.mjs").Unit} unit
 */
function nextOfPassed(unit) {
  const { model, release: { obstacles }, exported } = unit;
  if (model.state !== "released") {
    if (obstacles.length > 0) return { kind: null, text: U.next.notReleased, why: obstacles };
    return { kind: "release", text: isGapOpen(unit) ? U.next.releaseGapOpen : U.next.release };
  }
  if (isToReleaseAgain(unit.release)) return { kind: "release", text: U.next.releaseAgain };
  if (obstacles.length > 0) return { kind: null, text: U.next.notGoodAnyMore, why: obstacles };
  if (exported === null || exported.result.unreleased) return { kind: "export", text: U.next.export };
  return { kind: null, text: isGapOpen(unit) ? U.next.gapOpen : U.next.nothing };
}

/**
 * @typedef {object} OpenCampaign a campaign of which more runs will come
 * @property {string} name
 * @property {number | null} of how many runs it has in all, if that is known
 * @property {boolean} stopped somebody has to resume it
 * @property {string[]} checks serial numbers of the units that it verifies
 * @property {string[]} records serial numbers of the units that it records for a fit
 */

/**
 * The campaign that a verification takes where nobody chooses: one for verification before one for calibration, and of
 * either one that is over before one that is open. Null where there is none.
 * @param {import("./documents.mjs").Unit["verify_with"]} campaigns the newest of each purpose first
 * @param {OpenCampaign | null} open
 */
export function campaignToVerifyWith(campaigns, open) {
  const isOver = ({ campaign }) => campaign !== open?.name;
  const checks = campaigns.filter(({ purpose }) => purpose === "verification");
  const of = checks.length > 0 ? checks : campaigns;
  return of.find(isOver) ?? of[0] ?? null;
}

/**
 * While the check campaign itself is open.
 * @param {{campaign: string, runs: number}} recorded
 * @param {OpenCampaign} open
 */
function nextOfOpen({ campaign, runs }, { of, stopped }) {
  if (!stopped) return { kind: null, text: U.next.checkRuns(campaign, runs, of) };
  return { kind: null, text: U.next.checkStopped(campaign, runs, of), link: toStation() };
}

/** How many runs of a campaign the next fit of a unit takes: those of other campaigns do not count. */
const recordedOf = ({ fit_campaigns: campaigns }, name) => campaigns.find(({ campaign }) => campaign === name)?.runs ?? 0;

const toStation = () => ({ text: U.next.toStation, address: "#station" });

/**
 * While the campaign is open that records the runs of the first fit.
 * @param {import("./documents.mjs").Unit} unit
 * @param {OpenCampaign} open
 */
function nextOfRecorded(unit, { name, of, stopped }) {
  const runs = recordedOf(unit, name);
  if (!stopped) return { kind: null, text: U.next.recordRuns(name, runs, of) };
  return { kind: null, text: U.next.recordStopped(name, runs, of, unit.to_fit), link: toStation() };
}

/** Those in the way of a release that only a new fit settles. */
const toFitAgain = ({ release }) => (release?.obstacles ?? []).filter((text) => /: fit again( with all of them)?$/.test(text));

const BY_ENGINEER = ["release", "export"];

/**
 * What is to be done next, as it is told to somebody of a role: who does it, where that is somebody else.
 * @template {{kind: string | null, text: string, link?: {text: string, address: string}, beside?: {text: string, link?: {text: string, address: string}}}} Next
 * @param {Next} next as nextOf() says
 * @param {string | null} role null: the station has no accounts
 * @returns {Next}
 */
export function nextForRole(next, role) {
  const told = role === "viewer" && next.beside ? { ...next, beside: { text: next.beside.text } } : next; // nor may they resume a campaign
  if (BY_ENGINEER.includes(next.kind) && role !== null && role !== "engineer") return { ...told, text: `${next.text} ${U.next.byEngineer}` };
  const isWork = next.kind !== null || next.link?.address === "#station";
  return isWork && role === "viewer" ? { ...told, text: `${next.text} ${U.next.byOperator}`, link: undefined } : told;
}

/**
 * Whether the campaign that is open records the first check runs of the unit.
 * @param {import("./documents.mjs").Unit} unit
 * @param {OpenCampaign | null} open
 */
export const isBeingChecked = ({ unit, verify_with }, open) =>
  open !== null && open.checks.includes(unit) && !verify_with.some(({ purpose }) => purpose === "verification");

/**
 * What is to be done next: {kind, text, why, link, beside}; `kind` of the job that does it, null where none does; `why`: in the station's words; `link`:
 * {text, address} of where it is done or described; `beside`: what can be done as well.
 * @param {import("./documents.mjs").Unit} unit
 * @param {OpenCampaign | null} [open] the campaign that is not over yet
 * @returns {{kind: string | null, text: string, why?: string[], link?: {text: string, address: string}, beside?: {text: string, link?: {text: string, address: string}}}}
 */
export function nextOf(unit, open = null) {
  const { model } = unit;
  if (!open?.records.includes(unit.unit)) return nextByItself(unit, open);
  if (model === null || model.epoch !== unit.epoch) return nextOfRecorded(unit, open);
  const { name, of, stopped } = open;
  const runs = recordedOf(unit, name);
  // A model that was fitted before its campaign is over would lack the runs to come; a campaign that has stopped may never go on.
  if (!stopped) return { kind: null, text: U.next.moreRuns(name, runs, of) };
  return { ...nextByItself(unit, open), beside: { text: U.next.moreRunsStopped(name, runs, of), link: toStation() } };
}

/**
 * The same where no campaign records the unit.
 * @param {import("./documents.mjs").Unit} unit
 * @param {OpenCampaign | null} open
 */
function nextByItself(unit, open) {
  const { model, verify_with } = unit;
  if (model === null && unit.to_fit === 0) return { kind: null, text: U.next.record };
  if (model === null) return { kind: "fit", text: U.next.fit };
  if (model.epoch !== unit.epoch) return unit.to_fit > 0 ? { kind: "fit", text: U.next.changedFit } : { kind: null, text: U.next.changed, link: { text: U.next.newCampaign, address: "#station" } };
  if (model.state === "withdrawn") return { kind: "fit", text: U.next.retired };
  if (unit.warnings.some(({ code }) => code === "voided_since")) return { kind: "fit", text: U.next.withdrawn };
  const wrong = model.state === "released" ? toFitAgain(unit) : [];
  if (wrong.length > 0 && unit.to_fit > 0) return { kind: "fit", text: U.next.fitAgain, why: wrong };
  const verdict = verdictNow(unit);
  if (verdict === null && isBeingChecked(unit, open)) return nextOfOpen({ campaign: open.name, runs: 0 }, open);
  if (verdict === null && verify_with.length > 0) {
    const chosen = campaignToVerifyWith(verify_with, open);
    return open && chosen?.campaign === open.name && chosen.purpose === "verification" ? nextOfOpen(chosen, open) : { kind: "verify", text: unit.gap.find === null && model.terms.length === 0 ? U.next.verify + U.next.gapFirst : U.next.verify };
  }
  if (verdict === null) return { kind: null, text: U.next.recordFresh, link: { text: U.next.newCampaign, address: "#station" } };
  if (verdict === "fail") return { kind: "report", text: U.next.fail };
  if (verdict === "marginal") return { kind: null, text: U.next.marginal, link: { text: U.next.how, address: "#help=guide&at=marginal" } };
  if (verdict !== "pass") return { kind: null, text: U.next.notJudged(unit.type), link: { text: U.next.how, address: "#help=guide&at=change-a-limit" } };
  if (warningsOf(unit).some(({ code, urgency }) => urgency === "grave" && code !== "simulated")) return { kind: "report", text: U.next.grave };
  return nextOfPassed(unit);
}

// ---- warnings

const URGENCIES = ["grave", "act", "none"];

/**
 * Those of the model and of its verification, the gravest first.
 * @param {import("./documents.mjs").Unit} unit
 */
export function warningsOf({ warnings, verification }) {
  const rank = ({ urgency }) => URGENCIES.indexOf(urgency);
  return [...warnings, ...(verification?.warnings ?? [])].sort((a, b) => rank(a) - rank(b));
}

/** The station's words with sensors as people write them: "accel_x scale" → "accel x scale". */
export const withSensors = (text) => text.replace(/\b(gyro|accel)_([xyz])\b/g, "$1 $2");

/** A warning about each of several sensors in the same words is one: its `text` then does not begin with the sensor, which `sensors` names. */
function gathered(warnings) {
  const found = new Map();
  for (const warning of warnings) {
    const [first] = warning.sensors;
    const text = first && warning.text.startsWith(first) ? warning.text.slice(first.length).replace(/^:? /, "") : warning.text;
    const key = JSON.stringify([warning.code, text, warning.remedy, warning.urgency]);
    const same = found.get(key);
    found.set(key, same ? { ...same, text, sensors: [...new Set([...same.sensors, ...warning.sensors])] } : warning);
  }
  return [...found.values()];
}

/**
 * {act, rest}: those that ask for something, the gravest first, and those that ask for nothing.
 * @param {import("./documents.mjs").Unit} unit
 */
export function sortedWarnings(unit) {
  const warnings = gathered(warningsOf(unit));
  const asks = ({ urgency }) => urgency !== "none";
  return { act: warnings.filter(asks), rest: warnings.filter((warning) => !asks(warning)) };
}

// ---- sensors

export const sensorText = (name) => U.sensors.name(name);
export const unitText = ({ unit }) => ({ deg: "°", "deg/s": "°/s", "m/s2": "m/s²" })[unit] ?? unit;
