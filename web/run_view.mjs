// SPDX-License-Identifier: Apache-2.0
// One run: what it is, its strip chart, its segments with what the gate refused, and how to void it.

import { getAhead } from "./ahead.mjs";
import { $, element, say, show, tell } from "./dom.mjs";
import { clock, count, duration, significant, UNKNOWN } from "./format.mjs";
import { channelText, marksOf, placeText, plateauText, quantityOf, R, runTime, stateOf, upText } from "./run_words.mjs";
import { badge } from "./runs_view.mjs";
import { StripChart } from "./strip_chart.mjs";
import { VoidDialog } from "./void_dialog.mjs";

const COLOURS = 8;
const MOST_CHANNELS = 12; // of one stream, docs/http-api.md
const FIRST_SHOWN = ["temp_c", "chamber_c", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"];
const NOT_DRAWN = ["label"]; // units whose numbers stand for texts
const AROUND = 0.1; // of a segment's length, beside it where it is looked at

export class RunView {
  #document = null;
  #asked = null; // "ID SN" that the address names
  #userName;
  #strip;
  #dialog;
  #channels = [];

  /** `userName()`: who is at the page, "" where nobody has said so. */
  constructor(userName) {
    this.#userName = userName;
    this.#strip = new StripChart((from_s, to_s) => this.#noteWindow(from_s, to_s), (segment) => this.#choose(segment));
    this.#dialog = new VoidDialog(() => this.#load(null));
    $("run-void").addEventListener("click", () => this.#dialog.open(this.#document, null, this.#userName()));
    $("segments-refused").addEventListener("change", () => this.#renderSegments());
    $("strip-channels").addEventListener("change", () => this.#pickChannels());
  }

  /** `parameters`: run, unit and, of a link to a part of it, from and to. */
  async open(parameters) {
    const span = [Number(parameters.get("from") ?? NaN), Number(parameters.get("to") ?? NaN)];
    const question = new URLSearchParams({ run: parameters.get("run") ?? "", unit: parameters.get("unit") ?? "" });
    const isAnother = String(question) !== this.#asked;
    this.#asked = String(question);
    if (isAnother) {
      this.#document = null;
      say($("run-title"), R.run.unnamed);
      $("strip-channels").replaceChildren($("strip-channels").querySelector("legend"));
    }
    await this.#load(span.every(Number.isFinite) && span[0] < span[1] ? span : null);
  }

  async #load(span) {
    const asked = this.#asked;
    show($("run-failure"), false);
    try {
      const document = await getAhead(`run?${asked}`);
      if (asked !== this.#asked) return; // another run was asked for meanwhile
      const wasShown = this.#document !== null;
      this.#document = document;
      this.#showParts();
      // First: the rest of the page is written while the station answers.
      if (this.#hasSamples()) this.#showStrip(span, wasShown);
      this.#render();
    } catch (error) {
      if (asked !== this.#asked) return;
      say($("run-failure"), error.message);
      show($("run-failure"), true);
    }
    this.#showParts();
  }

  #showStrip(span, wasShown) {
    this.#strip.open(this.#document, span);
    this.#choose(null);
    if (!wasShown) this.#offerChannels();
    this.#pickChannels();
  }

  #showParts() {
    for (const part of ["run-badges", "run-facts", "segments-card", "run-void"]) show($(part), this.#document !== null);
    show($("strip-card"), this.#hasSamples());
    if (this.#document === null) for (const part of ["run-void-record", "run-cut-short", "run-dropped"]) show($(part), false);
  }

  #hasSamples() {
    return this.#document !== null && this.#document.run.samples_dropped === null;
  }

  #noteWindow(from_s, to_s) {
    const place = new URLSearchParams(this.#asked);
    place.set("from", from_s.toPrecision(9));
    place.set("to", to_s.toPrecision(9));
    history.replaceState(null, "", `#${place}`);
  }

  // ---- what it is

  #render() {
    const { run, source, streams } = this.#document;
    say($("run-title"), R.run.title(run.run, run.campaign, run.unit));
    $("run-badges").replaceChildren(...marksOf(run).map(badge));
    show($("run-void-record"), run.void !== null);
    if (run.void) say($("run-void-record"), R.run.voided(clock(run.void.utc_s), run.void.user, run.void.reason));
    $("run-void").disabled = run.voided;
    show($("run-cut-short"), run.cut_short !== null);
    tell($("run-cut-short"), run.cut_short === null ? [] : [R.run.cutShort, { english: run.cut_short }]);
    const dropped = run.samples_dropped;
    show($("run-dropped"), dropped !== null);
    say($("run-dropped"), dropped === null ? "" : R.run.dropped(clock(dropped.utc_s), dropped.user, dropped.reason));
    const samples = streams.find((stream) => stream.name === "imu");
    const rate_hz = samples?.channels[0].rate_hz ?? null;
    const facts = [
      [R.run.procedure, run.procedure || UNKNOWN],
      [R.run.recorded, run.created_utc_s > 0 ? clock(run.created_utc_s) : UNKNOWN],
      [R.run.length, duration(run.duration_s)],
      [R.run.samples, count(run.rows)],
      [R.run.rate, rate_hz === null ? UNKNOWN : `${significant(rate_hz, 4)} Hz`],
      [R.run.source, source || UNKNOWN],
      [R.run.id, run.run_id],
    ];
    $("run-facts").replaceChildren(...facts.map(([name, value]) => {
      const box = element("div", "");
      box.append(element("dt", name), element("dd", value));
      return box;
    }));
    this.#renderSegments();
  }

  // ---- channels

  #offerChannels() {
    this.#channels = this.#document.streams.flatMap((stream) =>
      stream.channels.slice(1).filter((channel) => !NOT_DRAWN.includes(channel.unit) && channel.values > 0)
        .map((channel) => ({ key: `${stream.name}/${channel.name}`, stream: stream.name, name: channel.name, unit: quantityOf(channel.unit).unit })));
    const ofUnit = new Set(this.#channels.filter(({ stream }) => stream === "imu").map(({ name }) => name));
    const inPanel = new Map();
    const boxes = this.#channels.map((channel) => {
      const before = inPanel.get(channel.unit) ?? 0;
      inPanel.set(channel.unit, before + 1);
      channel.style = before % COLOURS;
      const label = element("label", "");
      const isFirst = FIRST_SHOWN.includes(channel.name) && (channel.stream === "imu" || !ofUnit.has(channel.name));
      const input = Object.assign(document.createElement("input"), { type: "checkbox", checked: isFirst, value: channel.key });
      label.append(input, ` ${channelText(channel.stream, channel.name)}`);
      return label;
    });
    $("strip-channels").append(...boxes);
  }

  #pickChannels() {
    const boxes = [...$("strip-channels").querySelectorAll("input")];
    const picked = boxes.filter((box) => box.checked);
    for (const box of boxes) box.disabled = !box.checked && picked.length >= MOST_CHANNELS;
    const keys = new Set(picked.map((box) => box.value));
    this.#strip.channels = this.#channels.filter((channel) => keys.has(channel.key));
  }

  // ---- segments

  #renderSegments() {
    const { segments } = this.#document;
    const of = (kind) => segments.filter((segment) => stateOf(segment).kind === kind).length;
    const others = ["refused", "part", "void"].map((kind) => [kind, of(kind)]).filter(([, count]) => count > 0);
    say($("segments-summary"), [R.segments.recorded(segments.length), ...others.map(([kind, count]) => R.segments[kind](count))].join(", "));
    const shown = $("segments-refused").checked ? segments.filter((segment) => stateOf(segment).kind !== "used") : segments;
    $("segments").tBodies[0].replaceChildren(...shown.map((segment) => this.#row(segment)));
  }

  #row(segment) {
    const row = element("tr", "");
    const { kind, title, why } = stateOf(segment);
    row.dataset.kind = kind;
    const state = element("td", "");
    state.append(badge({ text: title, state: { used: "finished", part: "waiting", refused: "failed", void: "" }[kind] }));
    if (why.length > 0) {
      const reason = Object.assign(element("p", ""), { className: "why" });
      tell(reason, why);
      state.append(reason);
    }
    const cells = [plateauText(segment), upText(segment), runTime(segment.t_start_s), duration(segment.t_end_s - segment.t_start_s)];
    const actions = element("td", "");
    actions.className = "actions";
    if (this.#hasSamples()) actions.append(this.#button(R.segments.look, segment, () => this.#lookAt(segment)));
    if (!segment.void) {
      const button = this.#button(R.segments.voidIt, segment, () => this.#dialog.open(this.#document, segment, this.#userName()));
      button.dataset.needs = "engineer";
      actions.append(button);
    }
    row.append(...cells.map((text) => element("td", text)), state, actions);
    return row;
  }

  #button(text, segment, work) {
    const button = Object.assign(element("button", text), { type: "button", className: "small" });
    button.setAttribute("aria-label", R.segments.button(text, placeText(segment), runTime(segment.t_start_s)));
    button.addEventListener("click", work);
    return button;
  }

  #lookAt(segment) {
    const room_s = AROUND * (segment.t_end_s - segment.t_start_s);
    this.#choose(segment);
    this.#strip.look(segment.t_start_s - room_s, segment.t_end_s + room_s);
    $("strip-card").scrollIntoView({ block: "start" });
    $("strip").focus({ preventScroll: true });
  }

  #choose(segment) {
    this.#strip.choose(segment);
    if (segment === null) {
      say($("strip-segment"), "");
      return;
    }
    const { title, why } = stateOf(segment);
    tell($("strip-segment"), [`${placeText(segment)}, ${title}${why.length > 0 ? ": " : ""}`, ...why]);
  }
}
