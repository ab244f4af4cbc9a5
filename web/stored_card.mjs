// SPDX-License-Identifier: Apache-2.0
// What a station at rest has stored.

import { get } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { timeOfDay, UNKNOWN } from "./format.mjs";
import { T } from "./text.mjs";
import { unitAddress } from "./views.mjs";
import { isActive, now_s } from "./words.mjs";

const MOST_ROWS = 12;
const RETRY_MS = 2000;

export class StoredCard {
  #form;
  #status = null;
  #shownFor = null; // state and campaign for which it is shown
  #loading = false;

  /** `form`: that of a new campaign, which is told of the station's slots. */
  constructor(form) {
    this.#form = form;
  }

  /** Whenever the address leads to the station's own view: units may have been entered meanwhile. */
  async open() {
    this.#shownFor = null;
    if (this.#status) this.take(this.#status);
  }

  /** The newest status document. */
  take(status) {
    this.#status = status;
    const atRest = !isActive(status);
    show($("idle"), atRest);
    const about = `${status.state} ${status.campaign?.name} ${status.campaign?.started_utc_s}`;
    if (!atRest) this.#shownFor = null;
    else if (about !== this.#shownFor && !this.#loading) this.#load(about);
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
    const rows = campaigns.map((one) => [one.name, T.states[one.state] ?? T.imported, when(one.begun_utc_s), one.runs, one.units.join(", ")]);
    fill($("stored-campaigns"), rows);
    fill($("stored-units"), units.map((unit) => [Object.assign(element("a", unit.serial), { href: unitAddress(unit.serial) }), unit.type, unit.runs, when(unit.newest_run_utc_s)]));
    say($("stored-nothing"), campaigns.length === 0 && units.every(({ runs }) => runs === 0) ? T.stored.nothing : "");
    this.#form.showSlots(slots);
  }
}

/** The rows of a table's body, of texts, numbers and nodes; its card is hidden where there are none. */
function fill(table, rows) {
  const shown = rows.slice(0, MOST_ROWS).map((cells) => {
    const row = document.createElement("tr");
    row.append(...cells.map((content) => {
      const cell = element("td", "");
      cell.append(content);
      return cell;
    }));
    return row;
  });
  table.tBodies[0].replaceChildren(...shown);
  show(table, rows.length > 0);
  const more = rows.length - shown.length;
  table.tFoot.rows[0].cells[0].textContent = more > 0 ? T.stored.more(more) : "";
}
