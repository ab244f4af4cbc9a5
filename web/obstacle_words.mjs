// SPDX-License-Identifier: Apache-2.0
// What is in the way of a release, in the words of the page: the station says it in English and for a terminal. Nothing here touches the page.

import { U, verdictOf } from "./unit_words.mjs";

/** @type {[RegExp, (found: string[]) => string][]} what the station says (station/release/release_rule.cpp), and what the page says instead */
const KNOWN = [
  [/^it was never verified: /, () => U.obstacles.neverVerified],
  [/^its last verification, against campaign '(.*)', says (\w+), not pass: /, ([campaign, verdict]) => U.obstacles.notPassed(campaign, verdictOf(verdict).title)],
  [/^runs for calibration are not in it: (.*): fit again with all, or void them$/, ([runs]) => U.obstacles.leftOut(runs)],
  [/^it belongs to epoch (\d+), the unit is in epoch (\d+): fit again$/, () => U.obstacles.beforeRepair],
  [/^(\d+) of the runs that it was fitted to are withdrawn or not in this data folder: fit again$/, ([count]) => U.obstacles.gone(count)],
  [/^runs of campaign '(.*)' were withdrawn after it was verified against them: verify it again$/, ([campaign]) => U.obstacles.checkWithdrawn(campaign)],
];

/**
 * Parts of a sentence; what is not known keeps the station's own words.
 * @param {string[]} obstacles
 * @returns {import("./dom.mjs").Part[]}
 */
export function obstacleParts(obstacles) {
  const parts = obstacles.map((text) => {
    for (const [pattern, say] of KNOWN) {
      const found = text.match(pattern);
      if (found) return say(found.slice(1));
    }
    return { english: text };
  });
  return [...parts.flatMap((part, i) => (i === 0 ? [part] : ["; ", part])), "."];
}
