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

/**
 * @param {Kept} kept until the tab is closed
 * @param {string} of the file whose settings are changed; "": the station has none yet
 */
export function keep(kept, of = "") {
  sessionStorage.setItem(KEY, JSON.stringify({ ...kept, of }));
}

export function forgetKept() {
  sessionStorage.removeItem(KEY);
}

/** @returns {Kept | null} null: nothing was kept here for that file */
export function takeKept(of = "") {
  try {
    const kept = JSON.parse(sessionStorage.getItem(KEY) ?? "null");
    if (of !== "") forgetKept();
    return (kept?.of ?? "") === of ? kept : null;
  } catch {
    return null;
  }
}
