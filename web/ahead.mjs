// SPDX-License-Identifier: Apache-2.0
// What somebody is about to ask for, asked as soon as the pointer or the keyboard says so.

import { get } from "./api.mjs";

const KEPT_MS = 5000; // an older answer may be true no more
const REST_MS = 50; // of the pointer on a link: one that only passes asks for nothing

/** @type {{path: string, answer: Promise<any>, asked_ms: number} | null} */
let kept = null;

/** @param {string} path */
const isKept = (path) => kept !== null && kept.path === path && performance.now() - kept.asked_ms < KEPT_MS;

/** @param {string} path */
function askAhead(path) {
  if (isKept(path)) return;
  const mine = { path, answer: get(path), asked_ms: performance.now() };
  // Whoever needs it asks again, and is told why there is none.
  mine.answer.catch(() => { if (kept === mine) kept = null; });
  kept = mine;
}

/**
 * Asks for a document once the pointer rests on what leads to it, or presses it, or it has the focus.
 * @param {HTMLElement} node
 * @param {string} path
 */
export function asksAhead(node, path) {
  let rest = 0;
  node.addEventListener("pointerenter", () => { rest = setTimeout(() => askAhead(path), REST_MS); });
  node.addEventListener("pointerleave", () => clearTimeout(rest));
  for (const event of ["pointerdown", "focus"]) node.addEventListener(event, () => askAhead(path));
}

/**
 * As get(); what was asked for ahead is taken once, if it is fresh.
 * @param {string} path
 * @returns {Promise<any>}
 */
export function getAhead(path) {
  const answer = kept !== null && isKept(path) ? kept.answer : get(path);
  kept = null;
  return answer;
}
