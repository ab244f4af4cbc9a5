// SPDX-License-Identifier: Apache-2.0
// A model is withdrawn: which version, why and by whom, and what that means.

import { post } from "./api.mjs";
import { $, say } from "./dom.mjs";
import { RecordDialog } from "./record_dialog.mjs";
import { U } from "./unit_words.mjs";

/**
 * The versions that can be withdrawn here, the newest first: all that are not withdrawn, also those that break the rule of release by now.
 * @param {import("./documents.mjs").Unit} unit
 */
export const versionsToWithdraw = ({ versions }) => versions.filter(({ state }) => state !== "withdrawn");

export class WithdrawDialog {
  #serial = "";
  #dialog;

  /** `done()`: after a model has been withdrawn. */
  constructor(done) {
    this.#dialog = new RecordDialog("withdraw", async (record) => {
      await post("model/withdraw", { unit: this.#serial, model: Number($("withdraw-version").value), ...record });
      done();
    });
  }

  /**
   * @param {import("./documents.mjs").Unit} unit
   * @param {string} user who is at the page
   */
  open(unit, user) {
    this.#serial = unit.unit;
    say($("withdraw-title"), U.withdraw.title(unit.unit));
    $("withdraw-version").replaceChildren(...versionsToWithdraw(unit).map(({ version, state }) =>
      new Option(version === unit.model?.version ? U.jobs.newestVersion(version) : U.jobs.olderVersion(version, U.states[state]), String(version))));
    this.#dialog.open(user);
  }
}
