// SPDX-License-Identifier: Apache-2.0
// A unit was repaired or changed: why and by whom, and what that costs.

import { post } from "./api.mjs";
import { $, say } from "./dom.mjs";
import { RecordDialog } from "./record_dialog.mjs";
import { U } from "./unit_words.mjs";

export class RepairDialog {
  #serial = "";
  #dialog;

  /** `done()`: after a unit has begun its next epoch. */
  constructor(done) {
    this.#dialog = new RecordDialog("repair", async (record) => {
      await post("unit/epoch", { unit: this.#serial, ...record });
      done();
    });
  }

  /**
   * @param {string} serial
   * @param {string} user who is at the page
   */
  open(serial, user) {
    this.#serial = serial;
    say($("repair-title"), U.repair.title(serial));
    this.#dialog.open(user);
  }
}
