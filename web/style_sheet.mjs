// SPDX-License-Identifier: Apache-2.0
// Style sheets that the first view of the page does without.

import { element } from "./dom.mjs";

const sheets = new Map(); // address → its end

/**
 * Once it is there, or cannot be had: what is shown then is plain, but is shown.
 * @param {string} href
 * @returns {Promise<unknown>}
 */
export function styled(href) {
  const before = sheets.get(href);
  if (before) return before;
  const link = Object.assign(/** @type {HTMLLinkElement} */ (element("link", "")), { rel: "stylesheet", href });
  const end = new Promise((done) => ["load", "error"].forEach((kind) => link.addEventListener(kind, done)));
  sheets.set(href, end);
  document.head.append(link);
  return end;
}
