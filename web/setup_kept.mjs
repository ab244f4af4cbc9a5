// SPDX-License-Identifier: Apache-2.0
// What was entered on the page on which a station is set up, over a reload of the page: another language loads it again.

const KEY = "soak-setup";

/** @typedef {Record<"chamber" | "fixture" | "power", "good" | "bad" | null>} Tries what became of the last try of a controller as it is entered; null: there was none */

/**
 * @typedef {object} Kept
 * @property {string} step
 * @property {number} slots how many
 * @property {Record<string, string>} fields name to what stands in it
 * @property {Tries} [tries] absent where it was kept before they were
 */

/** @param {Kept} kept until the tab is closed */
export function keep(kept) {
  sessionStorage.setItem(KEY, JSON.stringify(kept));
}

export function forgetKept() {
  sessionStorage.removeItem(KEY);
}

/** @returns {Kept | null} null: nothing was kept here */
export function takeKept() {
  try {
    return JSON.parse(sessionStorage.getItem(KEY) ?? "null");
  } catch {
    return null;
  }
}
