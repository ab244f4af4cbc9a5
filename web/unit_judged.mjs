// SPDX-License-Identifier: Apache-2.0
// The numbers behind a verdict: of each curve the worst error, how sure that is, the limit, and where.

import { element, show } from "./dom.mjs";
import { number, significant, UNKNOWN } from "./format.mjs";
import { badge } from "./runs_view.mjs";
import { errorTexts, judgedCurves, sensorText, U, verdictNow, verdictOf } from "./unit_words.mjs";

/** A row; the first cell names it. */
function rowOf(curve) {
  const { name, isScale, worst, guard, limit, unit, temp_c, verdict } = curve;
  const line = element("tr", "");
  const [error, uncertainty] = errorTexts(worst, guard);
  const judged = element("td", "");
  judged.append(badge({ text: verdictOf(verdict).title, state: verdictOf(verdict).state }));
  line.append(Object.assign(element("th", U.judged.curve(sensorText(name), isScale)), { scope: "row" }),
    ...[error, typeof guard === "number" ? `±${uncertainty}` : UNKNOWN, significant(limit, 2), unit, number(temp_c, 0)].map((text) => element("td", text)), judged);
  return line;
}

/**
 * Fills the box, or hides it where no verdict holds or no limit is set.
 * @param {HTMLElement} box
 * @param {import("./documents.mjs").Unit} unit
 */
export function renderJudged(box, unit) {
  const curves = verdictNow(unit) === null ? [] : judgedCurves(unit.verification.job.result, unit.model);
  show(box, curves.length > 0);
  if (curves.length === 0) return;
  const table = Object.assign(element("table", ""), { className: "list figures" });
  const head = element("tr", "");
  head.append(...U.judged.heads.map((text) => Object.assign(element("th", text), { scope: "col" })));
  table.createTHead().append(head);
  table.createTBody().append(...curves.map(rowOf));
  const scroll = Object.assign(element("div", ""), { className: "scroll", tabIndex: 0, role: "region", ariaLabel: U.judged.title });
  scroll.append(table);
  box.replaceChildren(element("summary", U.judged.title), scroll, Object.assign(element("p", U.judged.about), { className: "about" }));
}
