// SPDX-License-Identifier: Apache-2.0
// What is in the way of a release, in the words of the page: the station says it in English and for a terminal. Nothing here touches the page.

import { dayText } from "./format.mjs";
import { U, verdictOf } from "./unit_words.mjs";

const reference = (kind, name, certificate) => U.obstacles.reference(U.obstacles.kinds[kind] ?? kind, name, certificate);
const day = (text) => dayText(new Date(`${text}T00:00`));

/** [label, campaign] of each of "R01 of campaign week-1, R02 of campaign week-1"; what has no campaign is the rest of a name with a comma. */
function runsOf(text) {
  const runs = [];
  for (const part of text.split(", ")) {
    const [, label, campaign] = part.match(/^(.*?) of campaign (.*)$/) ?? [];
    if (campaign !== undefined) runs.push([label, campaign]);
    else if (runs.length > 0) runs[runs.length - 1][1] += `, ${part}`;
  }
  return runs;
}

/** @type {[RegExp, (found: string[]) => string][]} what the station says (station/release/release_rule.cpp and the warnings that it asks for), and what the page says instead */
const KNOWN = [
  [/^it was never verified: /, () => U.obstacles.neverVerified],
  [/^its last verification, against campaign '(.*)', says (\w+), not pass: /, ([campaign, verdict]) => U.obstacles.notPassed(campaign, verdictOf(verdict).title)],
  [/^runs for calibration are not in it: (.*): fit again with all of them$/, ([runs]) => U.obstacles.leftOut(runsOf(runs))],
  [/^it belongs to epoch (\d+), the unit is in epoch (\d+): fit again$/, () => U.obstacles.beforeRepair],
  [/^(\d+) of the runs that it was fitted to are withdrawn or not in this data folder: fit again$/, ([count]) => U.obstacles.gone(count)],
  [/^runs of campaign '(.*)' were withdrawn after it was verified against them: verify it again$/, ([campaign]) => U.obstacles.checkWithdrawn(campaign)],
  [/^it was measured, and runs of campaign '(.*)' are SIMULATED: /, ([campaign]) => U.obstacles.checkSimulated(campaign)],
  [/^a verification on ([\d-]{10}), after its release, said (\w+): release it again /, ([on, verdict]) => U.obstacles.releaseAgain(day(on), verdictOf(verdict).title)],
  [/^it is withdrawn: fit again$/, () => U.obstacles.withdrawn],
  [/^withdrawn, whole or in part, after the model was fitted to it: (.*): fit again$/, ([runs]) => U.obstacles.voided(runs)],
  [/^(\w+) '(.*?)' \(certificate (.*?)\) was due on ([\d-]{10}): /, ([kind, name, certificate, due]) => U.obstacles.due(reference(kind, name, certificate), day(due))],
  [/^the entry of (\w+) '(.*?)' \(certificate (.*?)\) was withdrawn on ([\d-]{10}) by (.*?): (.*); (its values still apply here; |no entry corrects it, ).*: (fit again|verify it against newer runs)$/, ([kind, name, certificate, on, user, reason, correction, remedy]) =>
    U.obstacles.entryWithdrawn(reference(kind, name, certificate), day(on), user, reason, correction.startsWith("its"), U.obstacles.remedies[remedy])],
  [/^(\w+) '(.*?)' \(certificate (.*?)\), which was used for this measurement, was retired on ([\d-]{10}) by (.*?): (.*): (fit again|verify it against newer runs)$/, ([kind, name, certificate, on, user, reason, remedy]) =>
    U.obstacles.retired(reference(kind, name, certificate), day(on), user, reason, U.obstacles.remedies[remedy])],
  [/^(\w+) '(.*?)' \(certificate (.*?)\), which was used for this measurement, expired on ([\d-]{10}) and .*: (fit again|verify it against newer runs)$/, ([kind, name, certificate, on, remedy]) =>
    U.obstacles.expired(reference(kind, name, certificate), day(on), U.obstacles.remedies[remedy])],
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
