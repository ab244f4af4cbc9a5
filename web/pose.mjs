// SPDX-License-Identifier: Apache-2.0
// Drawings of a block with one face up: how it stands, how it shall stand.

import { svg } from "./axes.mjs";
import { T } from "./text.mjs";

// Corners of the block, seen from a corner above.
const TOP = "60,30 106,54 60,78 14,54";
const LEFT = "14,54 60,78 60,126 14,102";
const RIGHT = "60,78 106,54 106,102 60,126";

/** A block with the texts of the faces that can be seen; `kind` is its class. */
function block({ top, right = "", caption, kind, arrow = null }) {
  const root = svg("svg", { viewBox: "0 0 140 160", class: `pose ${kind}`, "aria-hidden": "true" });
  for (const [name, points] of Object.entries({ left: LEFT, right: RIGHT, top: TOP })) root.append(svg("polygon", { points, class: `face ${name}` }));
  root.append(svg("path", { d: "M60 44V10M53 19l7-10 7 10", class: "up" }));
  root.append(svg("text", { x: 60, y: 66, class: "label" }, top));
  if (right) root.append(svg("text", { x: 84, y: 98, class: "label to" }, right));
  if (arrow) root.append(svg("path", { d: arrow, class: "turn" }));
  root.append(svg("text", { x: 60, y: 152, class: "caption" }, caption));
  return root;
}

const QUARTER = "M112 84Q134 40 92 28M103 25l-12 3 6 11";
const HALF = "M70 132Q150 120 122 40Q110 20 84 18M95 12l-12 6 9 9";

/**
 * Draws into `host` the face that shall be up and, where `up` is known and another one, the face that is up now with the
 * way from it. Labels such as "+X". `wrong`: it does not rest as it shall; with the right face up it is tilted. `whose`:
 * whose faces they are, "" for the fixture's.
 */
export function drawPose(host, { expected, up, wrong, whose }) {
  const key = `${expected} ${up} ${wrong} ${whose}`;
  if (host.dataset.pose === key) return;
  host.dataset.pose = key;
  const half = up && up.slice(1) === expected.slice(1);
  const reached = up === expected && !wrong;
  const blocks = [block({ top: expected, caption: reached ? T.faces.asAsked : up === expected ? T.faces.seat : T.faces.turn, kind: reached ? "reached" : "wanted" })];
  if (up && up !== expected) {
    blocks.unshift(block({ top: up, right: half ? "" : expected, caption: whose ? T.faces.nowOf(whose) : T.faces.now, kind: "now", arrow: half ? HALF : QUARTER }));
  }
  host.replaceChildren(...blocks);
  host.setAttribute("aria-label", up && up !== expected ? T.faces.upNow(up, expected) : T.faces.isUp(expected));
}
