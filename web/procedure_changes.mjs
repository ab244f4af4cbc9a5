// SPDX-License-Identifier: Apache-2.0
// Fields in which a procedure is changed before a campaign begins with it: set points, runs, times. The station makes the new procedure of them.

import { element, english, say, show } from "./dom.mjs";
import { setTemperature, written } from "./format.mjs";
import { MOST_POINTS, evenList, listText, thereAndBack, typedList, typedNumber, wayThere } from "./set_points.mjs";
import { T, textsOf } from "./text.mjs";

/** @type {typeof import("./text_changes_en.mjs").text} */
const C = await textsOf("changes");

/** @typedef {import("./documents.mjs").Procedure} Procedure */

const NAME = /^[a-z0-9][a-z0-9_-]{0,59}$/i;
const LONGEST_BASE = 55; // of a name, before the number that is put behind it
const SECONDS = 60; // in a minute
const BACK = "back";

const minutesText = (seconds) => written(String(Number((seconds / SECONDS).toFixed(4))));
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** A mistake that the page itself sees, at a field. */
export class FieldMistake extends Error {
  /**
   * @param {string} where the field, as the interface names it
   * @param {string} message in the language of the page
   */
  constructor(where, message) {
    super(message);
    this.where = where;
    /** @type {import("./dom.mjs").Part[]} */
    this.parts = [message];
  }
}

/** A field with its label, what is wrong with it and a hint. */
class Field {
  #mistake = element("p", "");
  #hint = element("p", "");
  #label = document.createElement("span");

  /**
   * @param {string} name
   * @param {string} label
   * @param {HTMLInputElement | HTMLSelectElement} input
   */
  constructor(name, label, input = document.createElement("input")) {
    this.input = input;
    input.id = `change-${name}`;
    if (input instanceof HTMLInputElement) Object.assign(input, { type: "text", maxLength: 20000, autocomplete: "off", spellcheck: false });
    Object.assign(this.#mistake, { id: `${input.id}-mistake`, className: "bad" });
    this.#mistake.setAttribute("role", "status");
    Object.assign(this.#hint, { id: `${input.id}-hint`, className: "hint" });
    input.setAttribute("aria-describedby", `${this.#mistake.id} ${this.#hint.id}`);
    const caption = document.createElement("label");
    caption.append(this.#label, input);
    this.node = document.createElement("div");
    this.node.append(caption, this.#mistake, this.#hint);
    this.call(label);
    input.addEventListener("input", () => this.tell([]));
  }

  call(label) {
    say(this.#label, label);
  }

  hint(text) {
    say(this.#hint, text);
    return this;
  }

  /** @param {(string | HTMLElement)[]} parts none: nothing is wrong */
  tell(parts) {
    this.#mistake.replaceChildren(...parts);
    if (parts.length > 0) this.input.setAttribute("aria-invalid", "true");
    else this.input.removeAttribute("aria-invalid");
  }
}

export class ProcedureChanges {
  #box;
  #title;
  /** @type {Procedure | null} */
  #source = null;
  /** Files that there are. */
  #files = [];
  #points = new Field("points", C.points);
  #course = new Field("course", C.course, document.createElement("select"));
  #even = [C.from, C.to, C.every].map((label, i) => new Field(`even-${i}`, label));
  #runs = new Field("runs", C.runs).hint(C.runsHint);
  #soak = new Field("soak", C.soak).hint(C.soakHint);
  #dwell = new Field("dwell", C.dwell);
  #name = new Field("name", C.name);
  #evenBox = document.createElement("fieldset");
  #undo = button(C.undo);
  #fields = { set_points_c: this.#points, runs: this.#runs, minimum_soak_s: this.#soak, dwell_s: this.#dwell, name: this.#name };

  /** @param {HTMLElement} box the details with their summary; who listens to its `input` learns of each change */
  constructor(box) {
    this.#box = box;
    this.#title = box.querySelector("summary");
    this.#course.input.append(new Option(C.once, ""), new Option(C.andBack, BACK));
    const fill = button(C.fill);
    this.#evenBox.append(element("legend", C.evenly), ...this.#even.map(({ node }) => node), fill);
    const fields = document.createElement("div");
    fields.append(this.#points.node, this.#evenBox, this.#course.node, this.#runs.node, this.#soak.node, this.#dwell.node, this.#name.node, this.#undo);
    for (const node of [this.#points.node, this.#evenBox, this.#name.node, this.#undo]) node.classList.add("wide");
    box.append(fields);
    fill.addEventListener("click", () => this.#fill());
    this.#undo.addEventListener("click", () => this.#reset(true));
    this.#points.input.addEventListener("change", () => this.#tidy());
    box.addEventListener("input", () => this.#sayWhat());
    // Enter begins no campaign from here.
    box.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && event.target instanceof HTMLInputElement) event.preventDefault();
    });
  }

  /**
   * What is changed from now on; another one, also one whose file says something else by now, begins unchanged.
   * @param {Procedure} procedure with its text
   * @param {string[]} files of all procedures
   */
  offer(procedure, files) {
    this.#files = files;
    if (this.#source?.file === procedure.file && same(this.#source.changeable, procedure.changeable)) return;
    this.#source = procedure;
    this.#reset(false);
  }

  /** @param {boolean} isTold whoever listens learns of it */
  #reset(isTold) {
    const { kind, name, changeable } = this.#source;
    const { set_points_c, runs, dwell_s, minimum_soak_s, reference_c } = changeable;
    const there = kind === "soak" ? wayThere(set_points_c) : null;
    const example = kind === "rest" ? listText([35]) : listText([-20, 0, 22.5, 60]);
    this.#points.call({ ramp: C.ramp, rest: C.rest }[kind] ?? C.points);
    this.#points.hint(C.pointsHint(example) + (reference_c === null ? "" : C.reference(setTemperature(reference_c))));
    this.#points.input.value = listText(there ?? set_points_c);
    this.#course.input.value = there ? BACK : "";
    this.#runs.input.value = String(runs);
    this.#dwell.call(kind === "rest" ? C.dwellAtRest : C.dwell);
    for (const [field, seconds] of /** @type {[Field, number | null][]} */ ([[this.#dwell, dwell_s], [this.#soak, minimum_soak_s]])) {
      show(field.node, seconds !== null);
      field.input.value = seconds === null ? "" : minutesText(seconds);
    }
    for (const { input } of this.#even) input.value = "";
    show(this.#evenBox, kind !== "rest");
    show(this.#course.node, kind === "soak");
    this.#name.input.value = this.#freeName();
    this.#name.hint(C.nameHint(name));
    for (const field of [...Object.values(this.#fields), ...this.#even]) field.tell([]);
    this.#sayWhat();
    if (!isTold) return;
    this.#box.dispatchEvent(new Event("input", { bubbles: true }));
    this.#points.input.focus();
  }

  /** "six-position-soak-2", or with the next number that is free. */
  #freeName() {
    const base = this.#source.file.replace(/\.toml$/, "").replace(/-\d+$/, "").replace(/[^a-z0-9_-]+/gi, "-").replace(/^[-_]+/, "").slice(0, LONGEST_BASE) || "procedure";
    let number = 2;
    while (this.#files.includes(`${base}-${number}.toml`)) number += 1;
    return `${base}-${number}`;
  }

  #fill() {
    const points = evenList(...this.#typedEven());
    this.#even[2].tell(points ? [] : [this.#typedEven()[2] > 0 && this.#typedEven().every(Number.isFinite) ? C.tooMany(MOST_POINTS) : C.noStep]);
    if (!points) return this.#even[2].input.focus();
    this.#points.input.value = listText(points);
    this.#points.input.dispatchEvent(new Event("input", { bubbles: true }));
    this.#points.input.focus();
  }

  /** @returns {[number, number, number]} */
  #typedEven() {
    const [from, to, step] = this.#even.map(({ input }) => typedNumber(input.value));
    return [from, to, step];
  }

  /** What was understood, as it is written here. */
  #tidy() {
    const { points, wrong } = typedList(this.#points.input.value);
    if (wrong === null && points.length > 0) this.#points.input.value = listText(points);
  }

  #setPoints() {
    const { points, wrong } = typedList(this.#points.input.value);
    if (wrong !== null) throw new FieldMistake("set_points_c", C.noTemperature(wrong));
    if (points.length === 0) throw new FieldMistake("set_points_c", C.noPoints);
    return this.#course.input.value === BACK ? thereAndBack(points) : points;
  }

  #wholeRuns() {
    const runs = typedNumber(this.#runs.input.value);
    if (!Number.isInteger(runs) || runs < 1) throw new FieldMistake("runs", C.noWhole);
    return runs;
  }

  /** Seconds of a field in minutes; as they were where nobody has touched it. */
  #seconds(where, before) {
    const { input } = this.#fields[where];
    if (before === null || input.value === minutesText(before)) return before;
    const minutes = typedNumber(input.value);
    if (Number.isNaN(minutes)) throw new FieldMistake(where, C.noNumber);
    return Math.round(minutes * SECONDS * 10) / 10;
  }

  /** The members that are changed. Throws the first FieldMistake. */
  #changes() {
    const before = this.#source.changeable;
    const after = {
      set_points_c: this.#setPoints(),
      runs: this.#wholeRuns(),
      minimum_soak_s: this.#seconds("minimum_soak_s", before.minimum_soak_s),
      dwell_s: this.#seconds("dwell_s", before.dwell_s),
    };
    return Object.fromEntries(Object.entries(after).filter(([name, value]) => !same(value, before[name])));
  }

  /** What is changed stands in the line that opens the fields, also while they are closed. */
  #sayWhat() {
    if (!this.#source) return;
    const words = { set_points_c: ({ length }) => C.somePoints(length), runs: C.someRuns, minimum_soak_s: (seconds) => C.soakShort(minutesText(seconds)), dwell_s: (seconds) => C.dwellShort(minutesText(seconds)) };
    let changes = null;
    try {
      changes = Object.entries(this.#changes());
    } catch (error) {
      if (!(error instanceof FieldMistake)) throw error;
    }
    const isChanged = changes === null || changes.length > 0;
    const what = changes === null ? C.mistake : changes.map(([name, value]) => words[name](value)).join(", ");
    say(this.#title, isChanged ? C.changed(what) : T.start.change);
    show(this.#name.node, isChanged);
    show(this.#undo, isChanged);
  }

  /**
   * The body of POST procedures/new, without its user; null where nothing is changed. Throws the first FieldMistake.
   */
  request() {
    if (!this.#source) return null;
    const changes = this.#changes();
    if (Object.keys(changes).length === 0) return null;
    const name = this.#name.input.value.trim();
    if (!NAME.test(name)) throw new FieldMistake("name", C.noName);
    if (this.#files.includes(`${name}.toml`)) throw new FieldMistake("name", C.nameTaken(name));
    return { from: this.#source.file, name, ...changes };
  }

  /**
   * Tells a mistake at its field; whether there is one.
   * @param {any} error as api.mjs throws them, or a FieldMistake
   * @param {boolean} leads the field gets the focus
   */
  mark(error, leads) {
    const field = this.#fields[error.where];
    if (!field) return false;
    field.tell(error instanceof FieldMistake ? [error.message] : [english(error.message)]);
    if (leads) {
      /** @type {HTMLDetailsElement} */ (this.#box).open = true;
      field.input.focus();
    }
    return true;
  }

  clearMarks() {
    for (const field of Object.values(this.#fields)) field.tell([]);
  }
}

function button(text) {
  return Object.assign(element("button", text), { type: "button", className: "small" });
}
