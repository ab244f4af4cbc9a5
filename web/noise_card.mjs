// SPDX-License-Identifier: Apache-2.0
// The noise of one unit: loaded while the card can be seen, anew every ten seconds while something is recorded.

import { AllanChart } from "./allan_chart.mjs";
import { get } from "./api.mjs";
import { $, say, show, tell } from "./dom.mjs";
import { count, significant, written } from "./format.mjs";
import { T } from "./text.mjs";

const AGAIN_MS = 10000;

export class NoiseCard {
  #chart = new AllanChart($("noise-chart"), $("noise-legend"));
  #status = null;
  #noise = null;
  #failure = ""; // why the station did not answer
  #types = null; // of units, once they are known
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
    this.#failure = "";
    try {
      this.#types ??= (await get("types")).types;
      this.#noise = serial ? await get(`noise?unit=${encodeURIComponent(serial)}`) : null;
    } catch (error) {
      console.warn("no noise:", error.message); // asked again with the next recording
      this.#noise = null;
      this.#failure = error.message;
    }
    this.#loading = false;
    this.#render();
  }

  #render() {
    const kind = $("noise-accel").checked ? "accel" : "gyro";
    this.#chart.show(this.#noise, kind, this.#limitOf(kind)?.limit ?? null);
    show($("noise-empty"), this.#chart.empty);
    tell($("noise-empty"), this.#whyEmpty());
    const { samples, rate_hz, tau_s } = this.#noise ?? {};
    say($("noise-samples"), this.#chart.empty ? "" : T.noise.samples(count(samples), significant(rate_hz, 3)));
    say($("noise-reach"), this.#chart.empty ? "" : T.noise.reach(significant(tau_s.at(-1), 2)));
    say($("noise-limit"), this.#limitText(kind));
  }

  /** @returns {import("./dom.mjs").Part[]} */
  #whyEmpty() {
    if (this.#failure) return [T.noise.failed, { english: this.#failure }];
    return [this.#noise?.samples > 0 ? T.noise.tooShort(count(this.#noise.samples)) : T.noise.empty];
  }

  /** What the type of the unit states of the noise in pre-flight; null where the type is not known here. */
  #limitOf(kind) {
    const unit = this.#status?.units.find(({ serial }) => serial === $("noise-unit").value);
    const type = this.#types?.find(({ name }) => name === unit?.type);
    return type ? { type: type.name, limit: type[kind === "gyro" ? "gyro_noise_max_dps_rthz" : "accel_noise_max_mps2_rthz"] } : null;
  }

  #limitText(kind) {
    const stated = this.#limitOf(kind);
    if (stated === null) return "";
    const { type, limit } = stated;
    return limit === null ? T.noise.noLimit[kind](type) : T.noise.limit[kind](type, written(String(limit)));
  }
}
