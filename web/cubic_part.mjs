// SPDX-License-Identifier: Apache-2.0
// What an autopilot's file loses: its cubics over temperature beside the curves, with the figures that `soak export` prints.

import { element, english } from "./dom.mjs";
import { number, significant } from "./format.mjs";
import { sensorText, U, unitText } from "./unit_words.mjs";

const W = U.jobs.cubic;
const DIGITS = 3;

/** @param {Record<string, import("./documents.mjs").CubicLoss>} cubic */
function lossTable(cubic) {
  const table = element("table", "");
  table.className = "list figures";
  const head = table.createTHead().insertRow();
  head.append(...W.heads.map((text) => Object.assign(element("th", text), { scope: "col" })));
  const body = table.createTBody();
  for (const [name, loss] of Object.entries(cubic)) {
    const row = body.insertRow();
    row.append(Object.assign(element("th", sensorText(name)), { scope: "row" }), ...[unitText(loss), significant(loss.rms, DIGITS), significant(loss.worst, DIGITS),
      number(loss.worst_temp_c, 1), significant(loss.ci95_at_worst, DIGITS), `${number(100 * loss.beyond_ci95, 0)} %`].map((text) => element("td", text)));
  }
  const box = Object.assign(element("div", ""), { className: "scroll", tabIndex: 0 });
  box.setAttribute("role", "region");
  box.setAttribute("aria-label", W.label);
  box.append(table);
  return box;
}

/**
 * In a sentence how far the worst cubic is off, and behind that each sensor and what is to be done before the file is loaded.
 * @param {{cubic: Record<string, import("./documents.mjs").CubicLoss>, notes?: string[]}} result of an export as px4 or ardupilot
 */
export function cubicPart({ cubic, notes = [] }) {
  const part = element("details", "");
  const [name, worst] = Object.entries(cubic).reduce((most, one) => (one[1].beyond_ci95 > most[1].beyond_ci95 ? one : most));
  const list = Object.assign(element("ul", ""), { className: "remarks" });
  list.append(...notes.map((note) => {
    const line = element("li", "");
    line.append(english(note));
    return line;
  }));
  part.append(element("summary", W.title(worst.beyond_ci95 === 0 ? 0 : Math.max(1, Math.round(100 * worst.beyond_ci95)), sensorText(name))), lossTable(cubic), list);
  return part;
}
