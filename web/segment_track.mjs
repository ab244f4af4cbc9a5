// SPDX-License-Identifier: Apache-2.0
// The segments of a run over its time: a row of boxes above the panels, and a tint behind their lines.

import { svg } from "./axes.mjs";
import { colour } from "./chart_colours.mjs";
import { stateOf, upText } from "./run_words.mjs";

const HEIGHT = 24;
const LETTER = 7; // pixels of one
const TINTS = { used: "accent", part: "warn", refused: "bad", void: "soft" };
const SHARES = { used: 0.07, part: 0.16, refused: 0.2, void: 0.25 };
const MARKS = { part: "△", refused: "✕", void: "–" };

export class SegmentTrack {
  #node;
  #segments = [];

  constructor(node) {
    this.#node = node;
  }

  set segments(segments) {
    this.#segments = segments.map((segment) => ({ segment, kind: stateOf(segment).kind }));
  }

  /** Boxes from `from_s` to `to_s` over `area` {x, w}; `chosen`: the segment that is looked at, or null. */
  draw({ x, w }, from_s, to_s, chosen) {
    const toX = (t_s) => x + (w * (Math.min(to_s, Math.max(from_s, t_s)) - from_s)) / (to_s - from_s);
    const boxes = this.#within(from_s, to_s).flatMap(({ segment, kind }) => {
      const left = toX(segment.t_start_s);
      const width = Math.max(1, toX(segment.t_end_s) - left);
      const style = `box ${kind}${segment === chosen ? " chosen" : ""}`;
      const box = svg("rect", { x: left, y: 2, width, height: HEIGHT - 4, class: style });
      const text = [MARKS[kind], upText(segment)].filter(Boolean).join(" ");
      const shown = width > LETTER * text.length + 4 ? text : width > 10 ? MARKS[kind] ?? "" : "";
      return shown ? [box, svg("text", { x: left + width / 2, y: HEIGHT / 2 + 4, class: kind }, shown)] : [box];
    });
    this.#node.setAttribute("height", HEIGHT);
    this.#node.replaceChildren(...boxes);
  }

  /** Behind the lines of a panel. */
  tint(context, area, toX) {
    const fills = Object.fromEntries(Object.entries(TINTS).map(([kind, name]) => [kind, colour(name)]));
    for (const { segment, kind } of this.#segments) {
      const left = Math.max(area.x, toX(segment.t_start_s));
      const right = Math.min(area.x + area.w, toX(segment.t_end_s));
      if (right <= left) continue;
      context.save();
      context.globalAlpha = SHARES[kind];
      context.fillStyle = fills[kind];
      context.fillRect(left, area.y, Math.max(1, right - left), area.h);
      context.restore();
    }
  }

  /** The segment at that time, or null. */
  at(t_s) {
    return this.#segments.find(({ segment }) => segment.t_start_s <= t_s && t_s <= segment.t_end_s)?.segment ?? null;
  }

  #within(from_s, to_s) {
    return this.#segments.filter(({ segment }) => segment.t_end_s >= from_s && segment.t_start_s <= to_s);
  }
}
