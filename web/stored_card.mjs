// SPDX-License-Identifier: Apache-2.0
// What a station at rest has stored, and a campaign that is started, or put into the queue while another one runs.

import { get, send } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { timeOfDay, UNKNOWN } from "./format.mjs";
import { isActive, now_s } from "./words.mjs";

const MOST_ROWS = 12;
const RETRY_MS = 2000;

export class StoredCard {
  #userName;
  #status = null;
  #shownFor = null; // state and campaign for which it is shown
  #loading = false;
  #slots = [];
  #wasAtRest = null;

  /** `userName()`: who starts a campaign. */
  constructor(userName) {
    this.#userName = userName;
    $("start-form").addEventListener("submit", (event) => this.#start(event));
    $("start-box").addEventListener("toggle", () => this.#loadSlots());
    // A scanner ends each serial number with Enter: that is not yet the start.
    $("start-slots").addEventListener("keydown", (event) => this.#nextSlot(event));
  }

  /** The newest status document. */
  take(status) {
    this.#status = status;
    const atRest = !isActive(status);
    show($("idle"), atRest);
    show($("start-card"), true);
    this.#offerStart(atRest);
    show($("start-gives-up"), status.resumable !== null);
    say($("start-gives-up"), `Start gives ${status.resumable} up: it cannot be resumed afterwards.`);
    const about = `${status.state} ${status.campaign?.name} ${status.campaign?.started_utc_s}`;
    if (!atRest) this.#shownFor = null;
    else if (about !== this.#shownFor && !this.#loading) this.#load(about);
  }

  /** At rest the form lies open; beside a campaign it is for the queue only, and folded. */
  #offerStart(atRest) {
    if (atRest === this.#wasAtRest) return;
    this.#wasAtRest = atRest;
    // Whoever is typing goes on typing.
    if (atRest || !$("start-box").contains(document.activeElement)) $("start-box").open = atRest;
    say($("start-title"), atRest ? "New campaign" : "Queue a campaign");
    show($("start-send"), atRest);
  }

  /** Beside a campaign nobody has asked for the slots yet. */
  async #loadSlots() {
    if (!$("start-box").open || this.#slots.length > 0) return;
    try {
      this.#showSlots((await get("stored")).slots);
    } catch (error) {
      console.warn("slots are not known:", error.message);
    }
  }

  /** Loads and shows; where that fails, again after a while. */
  async #load(about) {
    this.#loading = true;
    try {
      this.#show(await get("stored"));
      this.#shownFor = about;
    } catch (error) {
      console.warn("not known what is stored:", error.message);
      await new Promise((done) => setTimeout(done, RETRY_MS));
    }
    this.#loading = false;
    this.take(this.#status); // the newest may be about something else by now
  }

  #show({ slots, units, campaigns }) {
    const when = (utc_s) => (utc_s === null ? UNKNOWN : timeOfDay(utc_s, now_s(this.#status)));
    const rows = campaigns.map((one) => [one.name, one.state ?? "imported", when(one.begun_utc_s), one.runs, one.units.join(", ")]);
    fill($("stored-campaigns"), rows);
    fill($("stored-units"), units.map((unit) => [unit.serial, unit.type, unit.runs, when(unit.newest_run_utc_s)]));
    say($("stored-nothing"), campaigns.length + units.length === 0 ? "Nothing is stored yet." : "");
    this.#showSlots(slots);
  }

  #showSlots(slots) {
    if (JSON.stringify(slots) === JSON.stringify(this.#slots)) return;
    this.#slots = slots;
    const fields = slots.map(({ name, unit }) => {
      const label = element("label", `Slot ${name}: serial number `);
      const input = Object.assign(document.createElement("input"), { type: "text", value: unit, maxLength: 200, autocomplete: "off" });
      input.dataset.slot = name;
      label.append(input);
      return label;
    });
    $("start-slots").replaceChildren(...fields);
  }

  #nextSlot(event) {
    if (event.key !== "Enter") return;
    event.preventDefault();
    const inputs = [...$("start-slots").querySelectorAll("input")];
    (inputs[inputs.indexOf(event.target) + 1] ?? $(this.#wasAtRest ? "start-send" : "start-queue")).focus();
  }

  async #start(event) {
    event.preventDefault();
    // Enter in a field presses the first button, also where that is hidden.
    const forQueue = event.submitter?.id === "start-queue" || !this.#wasAtRest;
    show($("start-failure"), false);
    const file = $("start-procedure").files[0];
    const units = {};
    for (const input of $("start-slots").querySelectorAll("input")) {
      if (input.value.trim()) units[input.dataset.slot] = input.value.trim();
    }
    for (const button of ["start-send", "start-queue"]) $(button).disabled = true;
    try {
      const request = { procedure_text: await file.text(), procedure_file: file.name, campaign: $("start-name").value.trim(), units };
      await send(forQueue ? "queue" : "start", { user: this.#userName(), ...request });
      $("start-name").value = "";
    } catch (error) {
      say($("start-failure"), error.message);
      show($("start-failure"), true);
      $("start-box").open = true;
    }
    for (const button of ["start-send", "start-queue"]) $(button).disabled = false;
  }
}

/** The rows of a table's body; its card is hidden where there are none. */
function fill(table, rows) {
  const shown = rows.slice(0, MOST_ROWS).map((cells) => {
    const row = document.createElement("tr");
    row.append(...cells.map((text) => element("td", String(text))));
    return row;
  });
  table.tBodies[0].replaceChildren(...shown);
  show(table, rows.length > 0);
  const more = rows.length - shown.length;
  table.tFoot.rows[0].cells[0].textContent = more > 0 ? `and ${more} more` : "";
}
