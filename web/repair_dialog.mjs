// SPDX-License-Identifier: Apache-2.0
// A unit was repaired or changed: why and by whom, and what that costs.

import { post } from "./api.mjs";
import { $, say, show } from "./dom.mjs";
import { U } from "./unit_words.mjs";

/** Whoever has not given their name at the page is asked for it here. */
const NOBODY = "web page";

export class RepairDialog {
  #serial = "";
  #done;

  /** `done()`: after a unit has begun its next epoch. */
  constructor(done) {
    this.#done = done;
    $("repair-cancel").addEventListener("click", () => $("repair-dialog").close());
    $("repair-form").addEventListener("submit", (event) => this.#send(event));
  }

  /**
   * @param {string} serial
   * @param {string} user who is at the page
   */
  open(serial, user) {
    this.#serial = serial;
    say($("repair-title"), U.repair.title(serial));
    $("repair-reason").value = "";
    $("repair-user").value = user === NOBODY ? "" : user;
    show($("repair-failure"), false);
    $("repair-dialog").showModal();
    $("repair-reason").focus();
  }

  async #send(event) {
    event.preventDefault(); // it stays open until the station has said yes
    $("repair-send").disabled = true;
    try {
      await post("unit/epoch", { unit: this.#serial, reason: $("repair-reason").value.trim(), user: $("repair-user").value.trim() });
      $("repair-dialog").close();
      this.#done();
    } catch (error) {
      say($("repair-failure"), error.where ? `${error.where}: ${error.message}` : error.message);
      show($("repair-failure"), true);
    }
    $("repair-send").disabled = false;
  }
}
