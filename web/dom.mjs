// SPDX-License-Identifier: Apache-2.0
// The few things that are done to the page over and over.

import { readable } from "./format.mjs";

/**
 * The element with that id. What kind of element it is index.html says.
 * @param {string} id
 * @returns {any}
 */
export const $ = (id) => document.getElementById(id);

export function show(node, visible) {
  node.hidden = !visible;
}

export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function element(name, text) {
  const node = document.createElement(name);
  node.textContent = text;
  return node;
}

/**
 * What the station itself says, which is English whatever the page speaks: for screen readers.
 * @param {string | null} text null: it says nothing
 */
export function english(text) {
  return Object.assign(element("span", readable(text ?? "")), { lang: "en" });
}

/** @typedef {string | {english: string | null}} Part of a sentence: the page's own words, or those of the station */

/**
 * Says a sentence of parts.
 * @param {HTMLElement} node
 * @param {Part[]} parts
 */
export function tell(node, parts) {
  const nodes = parts.map((part) => (typeof part === "string" ? document.createTextNode(part) : english(part.english)));
  if (node.textContent !== nodes.map(({ textContent }) => textContent).join("")) node.replaceChildren(...nodes);
}
