// SPDX-License-Identifier: Apache-2.0
// The line of a job of a unit that has ended: what it said, what it made, and whether that still holds.

import { cubicPart } from "./cubic_part.mjs";
import { element, tell } from "./dom.mjs";
import { fileLink } from "./file_link.mjs";
import { clock } from "./format.mjs";
import { endedText, voidOf } from "./job_words.mjs";
import { badge } from "./runs_view.mjs";
import { U, verdictOf } from "./unit_words.mjs";

/** What is said aloud of a job that has ended. */
export const spoken = (job) => {
  const { title, badge: { text }, text: why } = endedText(job);
  return [`${title}: ${text}. `, { english: why }];
};

/** What a job of all units said of this one, if that was the last verification; else null. */
export const verdictIn = ({ id, unit }, verification) => (unit === "" && verification?.job.id === id ? verification.job.result.verdict : null);

/** As voidOf(), also of a job of all units that this one was judged in. */
export const voidIn = (job, unit) => voidOf(verdictIn(job, unit?.verification ?? null) === null ? job : { ...job, kind: "verify" }, unit);

/** What stands for the verdict `given`: whether it is void, or another one counts by now. */
function markOf(given, isOver, not) {
  if (isOver) return { text: U.jobs.voidSince(given.text), state: "waiting" };
  return not === null ? given : { text: U.jobs.noMore(given.text), state: "" };
}

/** `from`: as madeFrom() says; `verdict`: as verdictIn(); `isOver`: it does not hold any more; `not`: as voidIn(). */
export function jobLine(job, from, verdict, isOver, not) {
  const { title, badge: own, text } = endedText(job);
  const given = verdict === null ? own : { text: verdictOf(verdict).title, state: verdictOf(verdict).state };
  const mark = markOf(given, isOver, not);
  const line = element("li", "");
  line.dataset.state = job.state;
  const head = Object.assign(element("div", ""), { className: "row" });
  head.append(badge(mark), element("strong", title), Object.assign(element("span", `${clock(job.ended_utc_s ?? job.started_utc_s)}, ${job.user}`), { className: "why" }));
  if (job.file) head.append(fileLink(job));
  line.append(head);
  if (from) line.append(Object.assign(element("p", from), { className: "why" }));
  if (not !== null) {
    const why = Object.assign(element("p", ""), { className: "why" });
    tell(why, not);
    line.append(why);
  }
  if (job.result?.cubic) line.append(cubicPart(job.result));
  if (text) line.append(Object.assign(element("p", text), { className: job.state === "failed" ? "bad" : "why", lang: "en" }));
  return line;
}
