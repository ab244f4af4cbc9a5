// SPDX-License-Identifier: Apache-2.0
// What the documents of jobs mean in words. Nothing here touches the page.

import { number, shortDuration } from "./format.mjs";
import { G, gapVerdictOf, plain } from "./gap_words.mjs";
import { stalePart, U, verdictOf } from "./unit_words.mjs";

/** A text by its name in the interface; one that is not known is that name. */
const known = (texts, name) => (Object.hasOwn(texts, name ?? "") ? texts[name] : name);

export const verbOf = (kind) => known(U.jobs.verbs, kind);

/** What a job makes a model of: runs, or a model with effects. Others work on the model that is there. */
const MAKES = ["fit", "gap_accept"];

/**
 * "unit SN1, model 2, campaign check-1": what a job works on.
 * @param {import("./documents.mjs").Job} job
 */
function subjectOf({ kind, unit, model, campaign, result }) {
  const version = model ?? (MAKES.includes(kind) ? null : (result?.model ?? null));
  if (kind === "report_campaign") return U.jobs.ofCampaign(campaign);
  const units = unit === "" ? U.jobs.allUnits : U.jobs.ofUnit(unit);
  const of = kind === "fit" || kind === "fit_all" ? U.jobs.ofRuns : kind === "export_all" ? U.jobs.releasedModels : unit === "" ? U.jobs.newestModels : version === null ? "" : U.jobs.ofModel(version);
  return [units, of, campaign === null ? "" : U.jobs.ofCampaign(campaign)].filter(Boolean).join(", ");
}

/**
 * "Fitting: unit SN1, all its runs for calibration; for 12 s now, started by Eva"
 * @param {import("./documents.mjs").Job} job
 * @param {number} now_s
 */
export function runningText(job, now_s) {
  const since = shortDuration(Math.max(0, Math.round(now_s - job.started_utc_s)));
  const share = typeof job.progress === "number" ? ` ${number(100 * job.progress, 0)} %.` : "";
  return `${U.jobs.running(`${known(U.jobs.doing, job.kind)}: ${subjectOf(job)}`, since, job.user)}${stepText(job)}${share}`;
}

/**
 * " Reading the recordings."; "" where the job is of several units, or the step has no words here.
 * @param {import("./documents.mjs").Job} job
 */
function stepText({ unit, doing }) {
  const steps = unit === "" ? {} : U.jobs.steps;
  return Object.hasOwn(steps, doing ?? "") ? ` ${steps[doing]}` : "";
}

/**
 * How far a job is, on a bar; one that goes to and fro where nobody knows.
 * @param {HTMLProgressElement} bar
 * @param {import("./documents.mjs").Job} job
 */
export function showShare(bar, { progress }) {
  if (typeof progress === "number") bar.value = progress;
  else bar.removeAttribute("value");
}

/** @param {import("./documents.mjs").Job} job */
const detailOf = ({ kind, format, effects, sign, result }) => {
  if (kind === "export_all") return U.jobs.as(known(U.formats, format));
  const made = MAKES.includes(kind) && result ? U.jobs.made(result.model) : "";
  if (kind === "gap_accept") return `, ${effects.map(G.effect).join(", ")}${made}`;
  if (kind === "export") return `${U.jobs.as(known(U.formats, format))}${sign ? U.jobs.signed(result?.key_id) : ""}`;
  return made;
};

/** What a unit's document says of its models, as it is asked here.
 * @typedef {Pick<import("./documents.mjs").Unit, "epoch" | "model" | "versions" | "verification" | "warnings">} Judged */

/**
 * What became of the version that a job worked on; null where that is not known.
 * @param {import("./documents.mjs").Job} job
 * @param {Judged | null} unit
 */
function versionOf(job, unit) {
  const last = unit?.verification?.job;
  const number = last?.id === job.id ? last.result.model : job.result?.model; // a verification of all units names none
  return unit?.versions.find(({ version }) => version === number) ?? null;
}

/**
 * Whether data were withdrawn that the last word on the newest model rests on.
 * @param {Judged} unit
 */
const isDataVoid = ({ verification, warnings }) => warnings.some(({ code }) => code === "voided_since") || (verification !== null && verification.stale !== null && !isAgain(verification.stale));

/** A newer fit is told in other words. */
const isAgain = (stale) => /^the unit was fitted again since$/.test(stale);

/** A report that was made after that has no verdict, and says why. */
const saysSoItself = ({ kind, result }) => kind === "report" && result?.verdict === "info";

/**
 * Whether what a job said or made of a unit does not hold any more: that is a matter of the version that it worked on, whatever came after that.
 * @param {import("./documents.mjs").Job} job
 * @param {Judged | null} unit
 */
export function isVoid(job, unit) {
  const of = versionOf(job, unit);
  if (of === null || job.state !== "done" || saysSoItself(job)) return false;
  return of.void !== null || of.epoch !== unit.epoch || of.state === "withdrawn" || (of.version === unit.model?.version && isDataVoid(unit));
}

/**
 * The same of a job that says a verdict.
 * @param {import("./documents.mjs").Job} job
 * @param {Judged | null} unit
 */
export const isVerdictVoid = (job, unit) => ["verify", "verify_all", "report"].includes(job.kind) && isVoid(job, unit);

/**
 * Which model a file was made from, and what became of that since: void comes first, then that there is a newer one; "" where it was made from none.
 * @param {import("./documents.mjs").Job} job
 * @param {Judged | null} unit
 */
export function madeFrom(job, unit) {
  const { kind, state, result, started_utc_s: started } = job;
  const newest = unit?.model ?? null;
  const verification = unit?.verification ?? null;
  const version = result?.model ?? null;
  if (state !== "done" || version === null || (kind !== "report" && kind !== "export")) return "";
  const of = versionOf(job, unit);
  if (of !== null && of.epoch !== unit.epoch && !saysSoItself(job)) return U.jobs.madeBeforeRepair(version);
  if (of?.state === "withdrawn") return U.jobs.madeFromWithdrawn(version);
  if (isVoid(job, unit)) return U.jobs.madeBeforeVoid(version);
  if (newest !== null && newest.version !== version) return U.jobs.madeFromOlder(version, newest.version);
  const verdict = verification?.stale === null && verification.job.started_utc_s > started ? verification.job.result.verdict : "pass";
  if (verdict !== "pass") return U.jobs.madeBeforeVerdict(version, verdictOf(verdict).title);
  const isMarked = result.unreleased === true;
  return isMarked && newest?.state === "released" ? U.jobs.madeBeforeRelease(version) : U.jobs.madeFrom(version);
}

/**
 * Why a verdict that a job gave does not count for the unit any more, as parts of a sentence; null where it counts, and of jobs that gave none.
 * @param {import("./documents.mjs").Job} job
 * @param {import("./documents.mjs").Unit | null} unit
 * @returns {import("./dom.mjs").Part[] | null}
 */
export function voidOf({ id, kind, state }, unit) {
  const verification = unit?.verification ?? null;
  if (verification === null || state !== "done" || kind !== "verify") return null;
  if (verification.job.id !== id) return [U.jobs.judgedAgain];
  return verification.stale === null ? null : [U.jobs.voidVerdict, stalePart(verification.stale), "."];
}

/**
 * What a job that has ended did: {title, badge, text}; `text` is why not, or what came of it, in the station's words.
 * @param {import("./documents.mjs").Job} job
 */
export function endedText(job) {
  const title = `${known(U.jobs.nouns, job.kind)}: ${subjectOf(job)}${detailOf(job)}`;
  if (job.state === "done") {
    const verdict = job.result?.verdict;
    const judged = job.kind === "gap_find" ? gapVerdictOf : verdictOf;
    const shown = verdict === undefined ? { title: U.jobs.states.done, state: "finished" } : judged(verdict);
    return { title, badge: { text: shown.title, state: shown.state }, text: job.result?.sentence ?? plain(job.result?.reason ?? "") };
  }
  const state = job.state === "failed" ? "failed" : "waiting";
  return { title, badge: { text: known(U.jobs.states, job.state), state }, text: job.message ?? "" };
}
