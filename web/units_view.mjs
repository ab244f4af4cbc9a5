// SPDX-License-Identifier: Apache-2.0
// All units that the station knows: which are judged, which are not.

import { get } from "./api.mjs";
import { BatchCard } from "./batch_card.mjs";
import { $, element, say, show } from "./dom.mjs";
import { timeOfDay, UNKNOWN } from "./format.mjs";
import { badge } from "./runs_view.mjs";
import { stateBadge, U, verdictOf } from "./unit_words.mjs";
import { unitAddress } from "./views.mjs";
import { recordedNow } from "./words.mjs";

export class UnitsView {
  #units = [];
  #batch;
  #recorded = null; // what was recorded when the last status came

  /** `userName()`: who fits, verifies and releases. */
  constructor(userName) {
    this.#batch = new BatchCard(userName, () => this.#load());
    $("units-find").addEventListener("input", () => this.#render());
  }

  async open() {
    await Promise.all([this.#load(), this.#batch.look()]);
  }

  /**
   * A run that has ended counts among a unit's.
   * @param {import("./documents.mjs").Status} status
   */
  take(status) {
    const before = this.#recorded;
    this.#recorded = recordedNow(status);
    this.#batch.take(status);
    if (before !== null && before !== this.#recorded && !$("units-view").hidden) this.#load();
  }

  async #load() {
    show($("units-failure"), false);
    try {
      const document = await get("units");
      this.#units = document.units;
      this.#render();
      this.#batch.offer(document);
    } catch (error) {
      say($("units-failure"), error.message);
      show($("units-failure"), true);
    }
  }

  #render() {
    const words = $("units-find").value.trim().toLowerCase().split(/\s+/);
    const units = this.#units.filter((unit) => words.every((word) => `${unit.unit} ${unit.type}`.toLowerCase().includes(word)));
    const none = this.#units.length === 0 ? U.list.none : U.list.noneFits;
    say($("units-nothing"), units.length === 0 ? none : U.list.count(units.length));
    show($("units-list"), units.length > 0);
    $("units-list").tBodies[0].replaceChildren(...units.map((unit) => this.#row(unit)));
  }

  #row(unit) {
    const row = element("tr", "");
    const link = element("a", unit.unit);
    link.href = unitAddress(unit.unit);
    const name = element("td", "");
    name.append(link);
    const { title, state } = verdictOf(unit.verdict);
    const verdict = element("td", "");
    verdict.append(badge({ text: title, state }));
    if (unit.trouble !== null) verdict.append(Object.assign(element("p", unit.trouble), { className: "why", lang: "en" }));
    const when = (utc_s) => (utc_s === null ? UNKNOWN : timeOfDay(utc_s, Date.now() / 1000));
    const model = element("td", unit.model === null ? U.list.noModel : `${unit.model.version}, ${when(unit.model.created_utc_s)} `);
    if (unit.model !== null) model.append(badge(stateBadge(unit.model, unit.release)));
    const cell = (text) => element("td", String(text));
    row.append(name, verdict, cell(unit.type), model, cell(unit.runs), cell(when(unit.newest_run_utc_s)));
    return row;
  }
}
