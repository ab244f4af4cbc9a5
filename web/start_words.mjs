// SPDX-License-Identifier: Apache-2.0
// What the check of a campaign that has not begun says, in words. Nothing here touches the page.

import { number, setTemperature, shortDuration } from "./format.mjs";
import { T } from "./text.mjs";

/** Where a mistake is about the serial numbers in the slots: also that there is none. */
export const IN_SLOTS = "--unit";
const REFERENCES = "references"; // where a mistake is about certificates of the register
const BYTES_PER_GB = 1e9;
const BYTES_PER_MB = 1e6;

function size(bytes) {
  return bytes >= BYTES_PER_GB ? `${number(bytes / BYTES_PER_GB, 1)} GB` : `${number(Math.max(1, bytes / BYTES_PER_MB), 0)} MB`;
}

/** "9 visits each", or "4 and 6 visits" where a power cycle parts the runs. */
const visitsText = (visits) => (visits.every((count) => count === visits[0]) ? T.start.visits(visits[0] ?? 0) : T.start.visitsOf(visits));

function extentText({ runs, visits, set_points_c, positions }) {
  const [lowest, highest] = [Math.min(...set_points_c), Math.max(...set_points_c)];
  const range = lowest === highest ? T.start.at(setTemperature(lowest)) : T.start.range(setTemperature(lowest), setTemperature(highest));
  return [T.start.runs(runs), visitsText(visits), range, T.start.positions(positions.length)].join(", ");
}

/** `end(estimate_s)`: when it would end if it began now, null where that is not known. */
function timeText({ estimate_s, turns }, { rate, end, safe }) {
  // Time that is simulated fast is no time for people who turn a fixture: nothing is said of when it ends.
  if (safe && turns > 0 && rate !== 1) return T.start.simulatedByHand(shortDuration(estimate_s));
  const at = end(estimate_s);
  const takes = rate === 1 ? T.start.takes(shortDuration(estimate_s)) : T.start.simulated(shortDuration(estimate_s), shortDuration(estimate_s / rate));
  return `${takes}${at ? T.start.ends(at) : ""}`;
}

/**
 * What a fixture that is turned by hand asks of people: how often, and where the door stays closed meanwhile. `safe`: {from_c, to_c}, where it may be opened.
 * @returns {string[]}
 */
function byHandTexts({ turns, set_points_c, estimate_s }, safe, rate) {
  if (turns === 0) return [];
  const closed = [...new Set(set_points_c)].filter((temp_c) => temp_c <= safe.from_c || temp_c >= safe.to_c).sort((a, b) => a - b).map(setTemperature);
  const every = shortDuration(estimate_s / turns);
  const often = rate === 1 ? T.start.turns(turns, every) : T.start.turnsSimulated(turns, every);
  return closed.length === 0 ? [often] : [often, T.start.turnsClosed(closed.join(", "), setTemperature(safe.from_c), setTemperature(safe.to_c))];
}

function diskText({ needed_bytes, free_bytes }) {
  const free = free_bytes === null ? "" : T.start.free(size(free_bytes));
  return `${T.start.writes(size(needed_bytes))}${free}`;
}

/** The first sentence of a description, short enough for a list. */
function firstSentence(description, most) {
  const [sentence] = description.trim().replace(/\s+/g, " ").split(/(?<=[.:;])(?<!\b\p{Lu}\.) /u); // not after the initial of a name
  const text = sentence.replace(/[.:;]$/, "");
  if (text.length <= most) return text;
  const end = text.lastIndexOf(" ", most);
  return `${text.slice(0, end > 0 ? end : most).replace(/[,:;]$/, "")}…`; // one long word is cut where it is too long
}

const MOST_OF_DESCRIPTION = 90; // characters

/**
 * "verification, 9 h 20 min: One short run that no fit sees": a procedure in the list to choose from.
 * @param {import("./documents.mjs").Procedure} procedure
 */
export function procedureText({ file, name, trouble, description, purpose, estimate_s }) {
  if (trouble !== null) return T.start.mistakes(file);
  const what = [name, T.purposes[purpose] ?? purpose, shortDuration(estimate_s)].join(", ");
  return description ? `${what}: ${firstSentence(description, MOST_OF_DESCRIPTION)}` : what;
}

/** Serial numbers of which the station knows no type. */
export const unknownUnits = ({ mistakes }) => mistakes.map(({ where }) => where.match(/^unit (?!type )(.*)/)?.[1]).filter((serial) => serial);

/**
 * Lines {parts, level, link} (`bad`: it would be refused; `note`; `good`), the refusals first; `link`: {text, address} of what mends it, if the page does. `named`, `filled`: whether a name and a serial number have been entered;
 * before that their lack is no mistake to tell. `safe`: where people turn the fixture, between which temperatures {from_c, to_c} the door may be opened; null: a machine does.
 */
export function reviewLines({ procedure, units = [], mistakes, notes = [], disk }, { named, filled, rate, end, safe }) {
  const told = mistakes.filter(({ where }) => (named || where !== "--name") && (filled || where !== IN_SLOTS));
  const place = (where) => (where.includes("/") ? ` (${where})` : "");
  const mends = (where) => (where === REFERENCES ? { text: T.start.toRecords, address: "#records" } : undefined);
  const lines = told.map(({ message, where }) => ({ parts: [T.start.refused, { english: message }, place(where)], level: "bad", link: mends(where) }));
  if (procedure?.description) lines.push({ parts: [{ english: procedure.description.trim() }], level: "note" });
  if (procedure) {
    lines.push({ parts: [`${procedure.name}: ${extentText(procedure)}; ${timeText(procedure, { rate, end, safe })}`], level: told.length > 0 ? "note" : "good" });
    if (!filled && units.length === 0) lines.push({ parts: [T.start.noUnit], level: "note" });
    for (const text of safe ? byHandTexts(procedure, safe, rate) : []) lines.push({ parts: [text], level: "reason" });
    if (disk.needed_bytes !== null) lines.push({ parts: [diskText(disk)], level: "note" });
  }
  for (const { slot, serial, type } of units) lines.push({ parts: [T.start.holds(slot, serial, type)], level: "note" });
  return [...lines, ...notes.map((note) => ({ parts: [T.start.noHindrance, { english: note }], level: "note" }))];
}
