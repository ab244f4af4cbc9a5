// SPDX-License-Identifier: Apache-2.0
// A new campaign: what is chosen is checked while the form is filled in, then started, or put into the queue while another one runs.

import { get, post, send } from "./api.mjs";
import { $, element, say, show, tell } from "./dom.mjs";
import { timeOfDay } from "./format.mjs";
import { safeToOpen } from "./door_words.mjs";
import { ProcedureChoice } from "./procedure_choice.mjs";
import { IN_SLOTS, reviewLines, unknownUnits } from "./start_words.mjs";
import { T } from "./text.mjs";
import { isActive, isByHand, now_s } from "./words.mjs";

const CHECK_AFTER_MS = 400;

export class StartForm {
  #userName;
  #status = null;
  #slots = [];
  #procedure;
  #types = [];
  #unknown = ""; // the units that can be entered, as they are shown
  #wasAtRest = null;
  #checks = 0;
  #timer = 0;
  /** @type {import("./slot_look.mjs").SlotLook | null} */
  #look = null; // once somebody has looked
  #looks = false;
  #sends = false;

  /** `userName()`: who starts a campaign. */
  constructor(userName) {
    this.#userName = userName;
    this.#procedure = new ProcedureChoice(userName);
    $("start-form").addEventListener("submit", (event) => this.#start(event));
    $("start-form").addEventListener("input", () => {
      show($("start-failure"), false);
      this.#checkSoon();
    });
    $("start-box").addEventListener("toggle", () => this.#load());
    // Files may have been changed meanwhile, time passed.
    document.addEventListener("visibilitychange", () => this.#load());
    // A scanner ends each serial number with Enter: that is not yet the start.
    $("start-look").addEventListener("click", () => this.#lookIntoSlots());
    $("start-last").addEventListener("click", () => this.#takeLast());
    $("start-slots").addEventListener("input", () => this.#offerLast());
    $("start-slots").addEventListener("keydown", (event) => this.#nextSlot(event));
  }

  /** Whenever the address leads to the station's own view: records may have been made meanwhile. */
  async open() {
    show($("start-failure"), false); // it was about an attempt before
    await this.#load();
  }

  /** The newest status document. */
  take(status) {
    this.#status = status;
    show($("start-card"), true);
    this.#offerStart(!isActive(status));
    show($("start-gives-up"), status.resumable !== null);
    say($("start-gives-up"), T.start.givesUp(status.resumable));
  }

  /** A field for each slot of the station, with the unit that its configuration names; those of the last campaign are offered. */
  showSlots(slots) {
    const places = (list) => JSON.stringify(list.map(({ name, unit }) => [name, unit]));
    const known = places(this.#slots);
    this.#slots = slots;
    if (places(slots) !== known) this.#makeFields(slots);
    this.#offerLast();
  }

  #makeFields(slots) {
    const fields = slots.map(({ name, unit }) => {
      const label = element("label", `${T.start.slot(name)} `);
      const input = Object.assign(document.createElement("input"), { type: "text", value: unit, maxLength: 200, autocomplete: "off" });
      input.dataset.slot = name;
      label.append(input);
      const field = element("div", "");
      field.append(label);
      return field;
    });
    $("start-slots").replaceChildren(...fields);
  }

  /** {input, serial} of the empty fields whose slot held a unit in the last campaign. */
  #lastUnits() {
    const inputs = [...$("start-slots").querySelectorAll("input")];
    return this.#slots.map(({ last_unit }, i) => ({ input: inputs[i], serial: last_unit })).filter(({ input, serial }) => serial && !input.value.trim());
  }

  #offerLast() {
    const last = this.#lastUnits();
    show($("start-last"), last.length > 0);
    say($("start-last"), T.start.last(last.map(({ serial }) => serial).join(", ")));
  }

  #takeLast() {
    const last = this.#lastUnits();
    for (const { input, serial } of last) {
      input.value = serial;
      // The form checks what it is filled with now, as if it were typed.
      input.dispatchEvent(new Event("input", { bubbles: true }));
    }
    last[0]?.input.focus();
  }

  /** Asks the units themselves, which takes some seconds. */
  async #lookIntoSlots() {
    this.#showLooking(true);
    show($("start-failure"), false);
    try {
      const { SlotLook } = await import("./slot_look.mjs");
      this.#look ??= new SlotLook($("start-slots"));
      await this.#look.ask(this.#userName());
    } catch (error) {
      this.#fail([`${T.start.look}: `, { english: error.message }]);
    }
    this.#showLooking(false);
  }

  /** The station refuses a start while it looks: its button says so. */
  #showLooking(looks) {
    this.#looks = looks;
    $("start-look").disabled = looks;
    $("start-send").disabled = looks || this.#sends;
    say($("start-look"), looks ? T.start.looking : T.start.look);
    say($("start-send"), looks ? T.start.waitsForLook : T.start.send);
  }

  /** At rest the form lies open; beside a campaign it is for the queue only, and folded. */
  #offerStart(atRest) {
    if (atRest === this.#wasAtRest) return;
    this.#wasAtRest = atRest;
    // Whoever is typing goes on typing.
    if (atRest || !$("start-box").contains(document.activeElement)) $("start-box").open = atRest;
    say($("start-title"), atRest ? T.start.title : T.start.queueTitle);
    show($("start-send"), atRest);
    show($("start-look"), atRest);
    this.#look?.forget(); // units may be changed while a campaign runs
    this.#checkSoon();
  }

  /** Whenever somebody comes to it: what there is to choose from, and whether what they have chosen still holds. */
  async #load() {
    if (!$("start-box").open || document.hidden || $("station-view").hidden) return;
    await Promise.all([
      this.#ask("procedures", ({ procedures }) => this.#procedure.show(procedures)),
      this.#ask("types", ({ types }) => (this.#types = types.map(({ name }) => name))),
      this.#ask("stored", ({ slots }) => this.showSlots(slots)),
    ]);
    this.#checkSoon();
  }

  async #ask(what, take) {
    try {
      take(await get(what));
    } catch (error) {
      this.#fail([`${T.start.unknown[what]}: `, { english: error.message }]);
    }
  }

  /** @param {import("./dom.mjs").Part[]} parts */
  #fail(parts) {
    tell($("start-failure"), parts);
    show($("start-failure"), true);
  }

  async #request() {
    const procedure = await this.#procedure.text();
    const units = {};
    for (const input of $("start-slots").querySelectorAll("input")) {
      if (input.value.trim()) units[input.dataset.slot] = input.value.trim();
    }
    return procedure && { procedure_text: procedure.text, procedure_file: procedure.file, campaign: $("start-name").value.trim(), units };
  }

  /** Not at every key; of several answers the last question's counts. */
  #checkSoon() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#check(), CHECK_AFTER_MS);
  }

  async #check() {
    const number = ++this.#checks;
    try {
      const request = await this.#request();
      /** @type {import("./documents.mjs").CampaignCheck} */
      const review = request && (await send("check", { user: this.#userName(), ...request }));
      if (number === this.#checks) this.#showReview(review, request);
    } catch (error) {
      if (number !== this.#checks) return;
      if (this.#procedure.mark(error, false)) this.#showReview(null, null);
      else this.#showReview({ procedure: null, mistakes: [{ message: error.message, where: "" }] }, { units: {} });
    }
  }

  #showReview(review, request) {
    show($("start-review"), review !== null);
    if (review === null) {
      this.#offerUnits([]);
      return;
    }
    const { rate } = this.#status.clock;
    const end = (estimate_s) => (this.#wasAtRest ? timeOfDay(now_s(this.#status) + estimate_s / rate, now_s(this.#status)) : null);
    const asked = { named: Boolean(request.campaign), filled: Object.keys(request.units).length > 0, rate, end, safe: isByHand(this.#status) ? safeToOpen(this.#status) : null };
    $("start-review").replaceChildren(...reviewLines(review, asked).map(reviewLine));
    this.#offerUnits(unknownUnits(review));
  }

  /** Units whose type nobody knows yet can be entered on the spot; whoever is choosing goes on choosing. */
  #offerUnits(serials) {
    const about = JSON.stringify([serials, this.#types]);
    if (about === this.#unknown) return;
    this.#unknown = about;
    const rows = serials.map((serial) => {
      const row = element("p", "");
      const types = document.createElement("select");
      types.append(new Option(T.start.choose, ""), ...this.#types.map((name) => new Option(name)));
      types.setAttribute("aria-label", T.start.typeOf(serial));
      const add = Object.assign(element("button", T.start.enter(serial)), { type: "button", className: "small", disabled: true });
      types.addEventListener("change", () => { add.disabled = types.value === ""; });
      add.addEventListener("click", () => this.#enterUnit(serial, types.value));
      row.append(types, " ", add);
      return row;
    });
    $("start-unknown").replaceChildren(...rows);
  }

  async #enterUnit(unit, type) {
    try {
      await post("unit/add", { unit, type, user: this.#userName() });
      $("start-form").querySelector(`[data-slot]`)?.focus();
    } catch (error) {
      this.#fail([{ english: error.message }]);
    }
    this.#check();
  }

  #nextSlot(event) {
    if (event.key !== "Enter" || event.target.localName !== "input") return;
    event.preventDefault();
    const inputs = [...$("start-slots").querySelectorAll("input")];
    (inputs[inputs.indexOf(event.target) + 1] ?? $(this.#wasAtRest ? "start-send" : "start-queue")).focus();
  }

  /** Keeps the procedure that was changed, unless the campaign would be refused: nobody wants to find it in the list then. */
  async #keep(request) {
    const { mistakes } = await send("check", { user: this.#userName(), ...request });
    if (mistakes.length > 0) throw Object.assign(new Error(mistakes.map(({ message }) => message).join("\n")), { where: mistakes[0].where });
    const { text, file } = await this.#procedure.keep();
    return { procedure_text: text, procedure_file: file };
  }

  async #start(event) {
    event.preventDefault();
    // Enter in a field presses the first button, also where that is hidden.
    const forQueue = event.submitter?.id === "start-queue" || !this.#wasAtRest;
    show($("start-failure"), false);
    this.#sends = true;
    for (const button of ["start-send", "start-queue"]) $(button).disabled = true;
    try {
      const request = await this.#request();
      const kept = this.#procedure.isChanged ? await this.#keep(request) : {};
      await send(forQueue ? "queue" : "start", { user: this.#userName(), ...request, ...kept });
      $("start-name").value = "";
      this.#showReview(null, null);
      this.#checks += 1; // an answer that is under way is about what has begun
      clearTimeout(this.#timer);
    } catch (error) {
      const isEmpty = error.where === IN_SLOTS && [...$("start-slots").querySelectorAll("input")].every(({ value }) => !value.trim());
      $("start-box").open = true;
      this.#fail(isEmpty ? [T.start.noUnit] : (error.parts ?? [{ english: error.message }]));
      this.#procedure.mark(error, true);
    }
    this.#sends = false;
    $("start-send").disabled = this.#looks;
    $("start-queue").disabled = false;
  }
}

function reviewLine({ parts, level, link }) {
  const line = Object.assign(element("li", ""), { className: level });
  tell(line, parts);
  if (link) line.append(". ", Object.assign(element("a", link.text), { href: link.address }));
  return line;
}
