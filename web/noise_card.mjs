// SPDX-License-Identifier: Apache-2.0
// The noise of one unit: loaded while the card can be seen, anew every ten seconds while something is recorded.

import { AllanChart } from "./allan_chart.mjs";
import { get } from "./api.mjs";
import { $, say, show } from "./dom.mjs";
import { count, significant } from "./format.mjs";
import { T } from "./text.mjs";

const AGAIN_MS = 10000;

export class NoiseCard {
  #chart = new AllanChart($("noise-chart"), $("noise-legend"));
  #status = null;
  #noise = null;
  #about = ""; // which unit and run were asked for last
  #askedAt = 0;
  #grows = false; // something has been recorded since then, or was being: the answer was not the last word
  #loading = false;
  #inView = false;

  constructor() {
    $("noise-unit").addEventListener("change", () => this.#follow());
    for (const kind of ["gyro", "accel"]) $(`noise-${kind}`).addEventListener("change", () => this.#render());
    document.addEventListener("visibilitychange", () => this.#follow());
    new IntersectionObserver((entries) => {
      this.#inView = entries.at(-1).isIntersecting;
      this.#follow();
    }).observe($("noise"));
    this.#render();
  }

  /** The newest status document. */
  take(status) {
    this.#status = status;
    this.#grows ||= status.campaign?.step_kind === "record";
    this.#offerUnits(status.units.map((unit) => unit.serial));
    this.#follow();
  }

  #offerUnits(serials) {
    const select = $("noise-unit");
    const offered = [...select.options].map((option) => option.value);
    if (offered.join("\n") === serials.join("\n")) return;
    const chosen = select.value;
    select.replaceChildren(...serials.map((serial) => new Option(serial, serial)));
    if (serials.includes(chosen)) select.value = chosen;
    select.disabled = serials.length === 0;
  }

  async #follow() {
    if (this.#loading || !this.#status || !this.#inView || document.hidden) return;
    const serial = $("noise-unit").value;
    const { campaign } = this.#status;
    const about = `${serial} ${campaign?.name} ${campaign?.started_utc_s} ${campaign?.run}`;
    const recording = campaign?.step_kind === "record";
    const due = this.#grows && Date.now() - this.#askedAt >= AGAIN_MS;
    if (about === this.#about && !due) return;
    this.#about = about;
    this.#askedAt = Date.now();
    this.#grows = recording;
    await this.#load(serial);
    this.#follow(); // another unit may have been chosen meanwhile
  }

  async #load(serial) {
    this.#loading = true;
    try {
      this.#noise = serial ? await get(`noise?unit=${encodeURIComponent(serial)}`) : null;
    } catch (error) {
      console.warn("no noise:", error.message); // asked again with the next recording
      this.#noise = null;
    }
    this.#loading = false;
    this.#render();
  }

  #render() {
    this.#chart.show(this.#noise, $("noise-accel").checked ? "accel" : "gyro");
    show($("noise-empty"), this.#chart.empty);
    const { samples, rate_hz } = this.#noise ?? {};
    say($("noise-samples"), this.#chart.empty ? "" : T.noise.samples(count(samples), significant(rate_hz, 3)));
  }
}
