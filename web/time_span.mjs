// SPDX-License-Identifier: Apache-2.0
// Spans of time [from_s, to_s] within a run. Nothing here touches the page.

const SHORTEST_S = 0.002;

/** From the first row of any stream to the last; never shorter than SHORTEST_S. */
export function wholeOf(streams) {
  const known = streams.filter((stream) => stream.rows > 0);
  if (known.length === 0) return [0, 1];
  const first_s = Math.min(...known.map((stream) => stream.first_s));
  return [first_s, Math.max(...known.map((stream) => stream.last_s), first_s + SHORTEST_S)];
}

/**
 * The part of a span that lies in `whole`; one that is too short grows about its middle.
 * @param {number[]} span
 * @param {number[]} whole
 * @returns {[number, number]}
 */
export function clamped([from_s, to_s], [first_s, last_s]) {
  const middle_s = (from_s + to_s) / 2;
  const half_s = Math.max(to_s - from_s, SHORTEST_S) / 2;
  return [
    Math.max(first_s, Math.min(middle_s - half_s, last_s - SHORTEST_S)),
    Math.min(last_s, Math.max(middle_s + half_s, first_s + SHORTEST_S)),
  ];
}

/** `factor` times closer; what lies at `at_s` stays in its place. */
export const zoomed = ([from_s, to_s], factor, at_s) => [at_s - (at_s - from_s) / factor, at_s + (to_s - at_s) / factor];

/**
 * As long as before, later by that share of its length, or as far as `whole` reaches.
 * @param {number[]} span
 * @param {number} share
 * @param {number[]} whole
 * @returns {[number, number]}
 */
export function moved([from_s, to_s], share, [first_s, last_s]) {
  const by_s = Math.min(last_s - to_s, Math.max(first_s - from_s, share * (to_s - from_s)));
  return [from_s + by_s, to_s + by_s];
}

/** Whether `t_s` is a time in a window; null is none. */
export const isWithin = (t_s, [from_s, to_s]) => t_s !== null && t_s >= from_s && t_s <= to_s;
