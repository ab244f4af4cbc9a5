// SPDX-License-Identifier: Apache-2.0
// What switches the units on and off, on the page on which a station is set up.

import { $, show } from "./dom.mjs";
import { ControllerFields, Field } from "./setup_fields.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

/** @typedef {"hand" | "map" | "chamber" | "usb_hubs"} PowerWay */

export class PowerFields {
  /**
   * @param {import("./kept_documents.mjs").SetupMap[]} maps
   * @param {number} ports
   */
  constructor(maps, ports) {
    this.choice = new Field("power.way.choice", S.power.way, { options: S.power.ways });
    this.controller = new ControllerFields("power", maps, ports);
    this.hubs = new Field("power.usb_hubs", S.power.hubs, { needed: true, hint: S.power.hubsHint });
    for (const field of [this.hubs, ...this.controller.all]) field.title = `${S.parts.power}, ${field.title}`;
    this.choice.input.addEventListener("change", () => this.#follow());
    this.#follow();
  }

  /** @returns {PowerWay} */
  get way() {
    return /** @type {PowerWay} */ (this.choice.value);
  }

  #follow() {
    show($("power-part"), this.way === "map");
    this.hubs.show(this.way === "usb_hubs");
  }

  get all() {
    return [this.choice, this.hubs, ...this.controller.all];
  }

  /** Those that count. */
  get fields() {
    return [this.choice, this.hubs, ...(this.way === "map" ? this.controller.all : [])];
  }

  /** Members of the body. */
  entered() {
    switch (this.way) {
      case "map": return { power: this.controller.entered() };
      case "chamber": return { power: { from: "chamber" } };
      case "usb_hubs": return { power: { usb_hubs: this.hubs.value.split(",").map((path) => path.trim()).filter((path) => path !== "") } };
      default: return {};
    }
  }
}
