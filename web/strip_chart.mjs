// SPDX-License-Identifier: Apache-2.0
// The strip chart of a run: panels above each other, one for each unit of measure, over one span of time that drag, wheel
// and keyboard change. Samples or stretches of them come from the station as that span asks for.

import { get } from "./api.mjs";
import { forgetColours } from "./chart_colours.mjs";
import { $, say, tell } from "./dom.mjs";
import { isStretches, R, runTime, windowText } from "./run_words.mjs";
import { SegmentTrack } from "./segment_track.mjs";
import { linesOf, questionsOf } from "./series.mjs";
import { loadDygraphs, StripPanel } from "./strip_panel.mjs";
import { clamped, isWithin, moved, wholeOf, zoomed } from "./time_span.mjs";

const CLICK_PIXELS = 5;
const [ZOOM, WHEEL_ZOOM] = [2, 1.25];
const STEP = 0.25; // of the window
const BUSY_MS = 1000;
const BUSY = "busy"; // docs/http-api.md

export class StripChart {
  #Dygraph = null;
  #document = null;
  #channels = []; // {key, stream, name, style}
  #panels = new Map(); // by unit
  #window = null; // [from_s, to_s]
  #answered = []; // the series that are shown
  #loading = false;
  #stale = false;
  #moved = false; // since the address named the window
  #cursor_s = null;
  #chosen = null;
  #track = new SegmentTrack($("strip-segments"));
  #drag = null;
  #onWindow;
  #onChoose;
  #rectangle = Object.assign(document.createElement("div"), { className: "selection", hidden: true });
  #line = Object.assign(document.createElement("div"), { className: "cursor-line", hidden: true });

  /** `onWindow(from_s, to_s)`: another span is shown; `onChoose(segment)`: one was clicked, or null. */
  constructor(onWindow, onChoose) {
    this.#onWindow = onWindow;
    this.#onChoose = onChoose;
    $("strip").append(this.#rectangle, this.#line);
    this.#listen();
  }

  /** Shows another run, or the same one after it has changed; `span`: [from_s, to_s], or null for all of it, or what was shown of it. */
  open(document, span) {
    const isSame = document.run.run_id === this.#document?.run.run_id && document.run.unit === this.#document.run.unit;
    this.#document = document;
    this.#track.segments = document.segments;
    this.#chosen = null;
    if (!isSame) this.#forget();
    if (span) this.#window = clamped(span, this.#whole());
    else if (!isSame) this.#window = this.#whole();
    this.#sayWindow();
  }

  #forget() {
    this.#arrange(new Set());
    this.#answered = [];
    this.#cursor_s = null;
    delete $("strip").dataset.kind;
    $("strip-segments").replaceChildren();
  }

  /** `channels`: {key, stream, name, style}. */
  set channels(channels) {
    this.#channels = channels;
    this.#load();
  }

  look(from_s, to_s) {
    this.#window = clamped([from_s, to_s], this.#whole());
    for (const panel of this.#panels.values()) panel.look(...this.#window);
    this.#redrawTrack();
    this.#moved = true;
    this.#load();
  }

  lookAtAll() {
    this.look(...this.#whole());
  }

  choose(segment) {
    this.#chosen = segment;
    this.#redrawTrack();
  }

  zoom(factor, at_s = this.#middle()) {
    this.look(...zoomed(this.#window, factor, at_s));
  }

  move(share) {
    this.look(...moved(this.#window, share, this.#whole()));
  }

  #whole() {
    return wholeOf(this.#document.streams);
  }

  #middle() {
    return isWithin(this.#cursor_s, this.#window) ? this.#cursor_s : (this.#window[0] + this.#window[1]) / 2;
  }

  // ---- what the station says

  /** One question at a time: what was asked for meanwhile is asked next. */
  async #load() {
    this.#stale = true;
    if (this.#loading) return;
    this.#loading = true;
    $("strip").setAttribute("aria-busy", "true");
    while (this.#stale) {
      this.#stale = false;
      const [from_s, to_s] = this.#window;
      try {
        const questions = questionsOf(this.#document.run, this.#channels, from_s, to_s, $("strip").clientWidth);
        const answers = await Promise.all(questions.map((question) => get(question)));
        this.#Dygraph ??= await loadDygraphs();
        if (!this.#stale) this.#draw(answers);
      } catch (error) {
        if (error.where === BUSY && !$("run-view").hidden) {
          await new Promise((done) => setTimeout(done, BUSY_MS));
          this.#stale = true;
        } else tell($("strip-window"), [R.strip.unknown, { english: error.message }]);
      }
    }
    this.#loading = false;
    $("strip").setAttribute("aria-busy", "false");
  }

  #draw(answers) {
    this.#answered = answers;
    const lines = answers.flatMap(linesOf);
    const styles = new Map(this.#channels.map(({ key, style }) => [key, style]));
    this.#arrange(new Set(lines.map((line) => line.unit)));
    for (const [unit, panel] of this.#panels) {
      panel.draw(this.#Dygraph, lines.filter((line) => line.unit === unit), styles, ...this.#window);
    }
    $("strip").dataset.kind = isStretches(answers) ? "buckets" : "samples";
    this.#redrawTrack();
    this.#sayWindow();
    if (this.#moved) this.#onWindow(...this.#window); // not at each turn of the wheel: browsers refuse floods of that
    this.#moved = false;
  }

  /** A panel for each unit, in the order in which the channels come. */
  #arrange(units) {
    for (const [unit, panel] of this.#panels) {
      if (units.has(unit)) continue;
      panel.close();
      this.#panels.delete(unit);
    }
    for (const unit of units) {
      if (this.#panels.has(unit)) continue;
      const panel = new StripPanel(unit, (context, area, toX) => this.#track.tint(context, area, toX));
      this.#panels.set(unit, panel);
      $("strip-panels").append(panel.node);
    }
  }

  #sayWindow() {
    say($("strip-window"), windowText(...this.#window, this.#answered));
    $("strip").setAttribute("aria-label", R.strip.label($("strip-window").textContent));
  }

  // ---- what the user does

  #area() {
    for (const panel of this.#panels.values()) {
      const area = panel.area;
      if (area) return area;
    }
    return null;
  }

  #redrawTrack() {
    const area = this.#area();
    if (area) this.#track.draw(area, ...this.#window, this.#chosen);
    if (this.#cursor_s !== null) this.#point(this.#cursor_s);
  }

  #timeAt(clientX) {
    const { x, w } = this.#area();
    const [from_s, to_s] = this.#window;
    const share = (clientX - $("strip").getBoundingClientRect().left - x) / w;
    return from_s + Math.min(1, Math.max(0, share)) * (to_s - from_s);
  }

  #xOf(t_s) {
    const { x, w } = this.#area();
    const [from_s, to_s] = this.#window;
    return x + ((t_s - from_s) / (to_s - from_s)) * w;
  }

  #point(t_s) {
    if (!this.#area()) return;
    const [from_s, to_s] = this.#window;
    this.#cursor_s = isWithin(t_s, this.#window) ? t_s : null;
    this.#line.hidden = this.#cursor_s === null;
    const texts = [...this.#panels.values()].flatMap((panel) => panel.point(this.#cursor_s));
    if (this.#line.hidden) return;
    this.#line.style.left = `${this.#xOf(this.#cursor_s)}px`;
    const at = runTime(this.#cursor_s, (to_s - from_s) / 1000);
    $("strip").setAttribute("aria-label", R.strip.labelAt(at, texts.join(", ")));
  }

  #listen() {
    const strip = $("strip");
    strip.addEventListener("pointerdown", (event) => this.#press(event));
    strip.addEventListener("pointermove", (event) => this.#pull(event));
    strip.addEventListener("pointerup", (event) => this.#release(event));
    strip.addEventListener("pointercancel", () => this.#endDrag());
    strip.addEventListener("pointerleave", () => this.#drag || this.#point(null));
    strip.addEventListener("blur", () => this.#point(null));
    strip.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    strip.addEventListener("keydown", (event) => this.#key(event));
    strip.addEventListener("dblclick", () => this.lookAtAll());
    const buttons = { "strip-in": () => this.zoom(ZOOM), "strip-out": () => this.zoom(1 / ZOOM), "strip-back": () => this.move(-STEP), "strip-on": () => this.move(STEP), "strip-all": () => this.lookAtAll() };
    for (const [id, work] of Object.entries(buttons)) $(id).addEventListener("click", work);
    new ResizeObserver(() => {
      for (const panel of this.#panels.values()) panel.resize();
      this.#redrawTrack();
    }).observe(strip);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      forgetColours();
      for (const panel of this.#panels.values()) panel.recolour();
    });
  }

  #press(event) {
    if (event.button !== 0 || !this.#area()) return;
    this.#drag = { pixel: event.clientX, t_s: this.#timeAt(event.clientX) };
    $("strip").setPointerCapture(event.pointerId);
  }

  #pull(event) {
    if (!this.#area()) return;
    const t_s = this.#timeAt(event.clientX);
    this.#point(t_s);
    if (!this.#drag) return;
    const [left, right] = [this.#xOf(this.#drag.t_s), this.#xOf(t_s)].sort((a, b) => a - b);
    Object.assign(this.#rectangle.style, { left: `${left}px`, width: `${right - left}px` });
    this.#rectangle.hidden = Math.abs(event.clientX - this.#drag.pixel) <= CLICK_PIXELS;
  }

  #release(event) {
    if (!this.#drag) return;
    const [from_s, to_s] = [this.#drag.t_s, this.#timeAt(event.clientX)].sort((a, b) => a - b);
    const dragged = Math.abs(event.clientX - this.#drag.pixel) > CLICK_PIXELS;
    this.#endDrag();
    if (dragged) this.look(from_s, to_s);
    else this.#onChoose(this.#track.at(to_s));
  }

  #endDrag() {
    this.#drag = null;
    this.#rectangle.hidden = true;
  }

  /** The page itself scrolls with the wheel, unless the chart has the focus. */
  #wheel(event) {
    if (!this.#area() || event.deltaY === 0 || !(event.ctrlKey || document.activeElement === $("strip"))) return;
    event.preventDefault();
    this.zoom(event.deltaY < 0 ? WHEEL_ZOOM : 1 / WHEEL_ZOOM, this.#timeAt(event.clientX));
  }

  #key(event) {
    if (!this.#area() || event.altKey || event.metaKey || event.ctrlKey) return;
    const [from_s, to_s] = this.#window;
    const step = (way) => {
      if (event.shiftKey) this.move(way * STEP);
      else this.#point(Math.min(to_s, Math.max(from_s, this.#middle() + (way * (to_s - from_s)) / 100)));
    };
    const work = {
      ArrowLeft: () => step(-1),
      ArrowRight: () => step(1),
      "+": () => this.zoom(ZOOM),
      "=": () => this.zoom(ZOOM),
      "-": () => this.zoom(1 / ZOOM),
      0: () => this.lookAtAll(),
      Enter: () => this.#onChoose(this.#track.at(this.#middle())),
      Escape: () => this.#point(null),
    }[event.key];
    if (!work) return;
    event.preventDefault();
    work();
  }
}
