// SPDX-License-Identifier: Apache-2.0
// The release of all units at once: how many models wait for it, the button, and why some may not be released.

import { get, post } from "./api.mjs";
import { $, element, english, say, show, tell } from "./dom.mjs";
import { U } from "./unit_words.mjs";
import { unitAddress } from "./views.mjs";

const LOOK_AGAIN_MS = 1000;
const MOST_UNANSWERED = 10;

export class ReleaseAll {
  #userName;
  #changed;
  #busy = false;

  /** `userName()`: who releases; `changed()`: states of models are others now. */
  constructor(userName, changed) {
    this.#userName = userName;
    this.#changed = changed;
    $("units-release").addEventListener("click", () => this.#release());
  }

  /**
   * `units`: as /api/v1/units has them. Which of the verified ones may be released the station judges when it is asked to.
   * @param {import("./documents.mjs").UnitLine[]} units
   */
  offer(units) {
    const verified = units.filter(({ model }) => model?.state === "verified").length;
    show($("units-release-box"), verified > 0);
    say($("units-verified"), U.releaseAll.waiting(verified));
    $("units-release").disabled = this.#busy;
  }

  #forget() {
    say($("units-release-news"), "");
    $("units-not-released").replaceChildren();
    show($("units-release-failure"), false);
  }

  async #release() {
    this.#forget();
    this.#busy = true;
    $("units-release").disabled = true;
    $("units-title").focus(); // the button is switched off, and may go away
    say($("units-release-news"), U.releaseAll.running);
    let job = null;
    try {
      job = await this.#ended(await post("jobs", { kind: "release_all", user: this.#userName() }));
    } catch (error) {
      this.#fail(error.message);
    }
    this.#busy = false;
    await this.#changed();
    if (job) this.#tell(job);
  }

  /** The document of a job at its end. One question that is not answered says nothing about the job. */
  async #ended(job) {
    let now = job;
    let unanswered = 0;
    while (now.state === "running") {
      await new Promise((done) => setTimeout(done, LOOK_AGAIN_MS));
      try {
        now = await get(`job?${new URLSearchParams({ id: job.id })}`);
        unanswered = 0;
      } catch (error) {
        if (++unanswered === MOST_UNANSWERED) throw error;
      }
    }
    return now;
  }

  #tell({ state, message, result }) {
    if (state !== "done") this.#fail(message ?? state);
    const units = result?.units ?? [];
    const others = units.filter((unit) => unit.obstacles.length > 0);
    const released = units.filter((unit) => unit.state === "released").length;
    say($("units-release-news"), units.length > 0 ? U.releaseAll.done(released, units.length) : "");
    $("units-not-released").replaceChildren(...others.map(({ unit, model, state, obstacles }) => {
      const line = element("li", "");
      const why = state === "released" ? U.releaseAll.againstTheRule(model) : U.releaseAll.notReleased(model);
      line.append(Object.assign(element("a", unit), { href: unitAddress(unit) }), why, english(obstacles.join("; ")));
      return line;
    }));
  }

  #fail(message) {
    say($("units-release-news"), "");
    tell($("units-release-failure"), [`${U.releaseAll.button}: `, { english: message }]);
    show($("units-release-failure"), true);
  }
}
