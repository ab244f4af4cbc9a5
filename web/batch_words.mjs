// SPDX-License-Identifier: Apache-2.0
// What became of the units of a job of all, in words. Nothing here touches the page.

import { obstacleParts } from "./obstacle_words.mjs";
import { U, verdictOf } from "./unit_words.mjs";

const VERDICTS = ["pass", "marginal", "fail", "info"];

const countOf = (units, key, value) => units.filter((unit) => unit[key] === value).length;

function judgedText(units) {
  const counts = VERDICTS.map((verdict) => [countOf(units, "verdict", verdict), verdictOf(verdict).title]).filter(([count]) => count > 0);
  return counts.length === 0 ? "" : U.batch.judged(counts.map(([count, title]) => `${count} ${title}`).join(", "));
}

/** Older results name only the units that were verified. */
function verifiedText(units, notVerified, skipped) {
  const counted = [[notVerified.length, U.batch.notVerified], [skipped.length, U.batch.skipped]].filter(([count]) => count > 0);
  return [judgedText(units), ...counted.map(([count, text]) => text(count))].filter(Boolean).join(" ");
}

/** `isKnown`: whether the job has said what it came to; one that was killed has not. */
function fittedText(units, state, isKnown) {
  const skipped = countOf(units, "result", "skipped");
  const said = isKnown ? [U.batch.fitted(countOf(units, "result", "fitted"), countOf(units, "result", "up_to_date"), countOf(units, "result", "failed"))] : [];
  return [...said, ...(skipped > 0 ? [U.batch.noRuns(skipped)] : []), ...(state === "cancelled" ? [U.batch.fitCancelled(isKnown)] : [])].join(" ");
}

const skippedText = ({ skipped }) => (skipped.length > 0 ? ` ${U.batch.skipped(skipped.length)}` : "");

/**
 * One sentence on all units, also of a job that was cut short; "" where it came to none.
 * @param {import("./documents.mjs").Job} job
 */
export function batchText({ kind, state, result }) {
  const units = result?.units ?? [];
  if (kind === "fit_all") return fittedText(units, state, state === "cancelled" ? units.length > 0 : result !== null);
  if (kind === "export_all") return result === null ? "" : `${U.handOver.done(units.length)}${skippedText(result)}`;
  if (kind === "verify_all") return verifiedText(units, result?.not_verified ?? [], result?.skipped ?? []);
  if (units.length === 0) return "";
  const released = countOf(units, "state", "released");
  return state === "done" ? U.releaseAll.done(released, units.length) : U.releaseAll.cutShort(released, units.length);
}

/**
 * What the station said of the job as a whole; null where the sentence and the list of units say it all.
 * @param {import("./documents.mjs").Job} job
 */
export function messageOf({ kind, state, result, message, exit_status }) {
  // One that was killed has not come to the end of its list.
  const isWhole = exit_status !== null && exit_status < 128;
  const isListed = state === "failed" && ((kind === "fit_all" && result !== null) || (kind === "verify_all" && isWhole && result?.not_verified?.length > 0));
  return state === "done" || isListed ? null : message;
}

/**
 * Units that somebody has to look at: {unit, parts}, the parts of a sentence behind the serial number.
 * @param {import("./documents.mjs").Job} job
 * @returns {{unit: string, parts: import("./dom.mjs").Part[]}[]}
 */
export function restOf({ kind, result }) {
  const units = result?.units ?? [];
  if (kind === "fit_all") {
    return units.filter((unit) => unit.result === "failed").map(({ unit, message }) => ({ unit, parts: [U.batch.why(null), { english: message }] }));
  }
  const because = (text) => ({ unit, message }) => ({ unit, parts: [text, { english: message }] });
  if (kind === "export_all") return (result?.skipped ?? []).map(because(U.batch.whySkipped));
  if (kind === "verify_all") {
    return [
      ...(result?.not_verified ?? []).map(because(U.batch.whyNotVerified)),
      ...units.filter(({ verdict }) => verdict !== "pass").map(({ unit, model, verdict }) => ({ unit, parts: [`${U.batch.why(model)}${verdictOf(verdict).title}`] })),
      ...(result?.skipped ?? []).map(because(U.batch.whySkipped)),
    ];
  }
  return units.filter(({ obstacles }) => obstacles.length > 0).map(({ unit, model, state, obstacles }) => ({
    unit, parts: [state === "released" ? U.releaseAll.againstTheRule(model) : U.releaseAll.notReleased(model), ...obstacleParts(obstacles)],
  }));
}
