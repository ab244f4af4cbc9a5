// SPDX-License-Identifier: Apache-2.0
// A model is withdrawn: which version, why and by whom, and what that means.

import { post } from "./api.mjs";
import { $, say, show } from "./dom.mjs";
import { U } from "./unit_words.mjs";

/** Whoever has not given their name at the page is asked for it here. */
const NOBODY = "web page";

/**
 * The versions that can be withdrawn here, the newest first: all that are not withdrawn, also those that break the rule of release by now.
 * @param {import("./documents.mjs").Unit} unit
 */
export const versionsToWithdraw = ({ versions }) => versions.filter(({ state }) => state !== "withdrawn");

export class WithdrawDialog {
  #serial = "";
  #done;

  /** `done()`: after a model has been withdrawn. */
  constructor(done) {
    this.#done = done;
    $("withdraw-cancel").addEventListener("click", () => $("withdraw-dialog").close());
    $("withdraw-form").addEventListener("submit", (event) => this.#send(event));
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
    $("withdraw-reason").value = "";
    $("withdraw-user").value = user === NOBODY ? "" : user;
    show($("withdraw-failure"), false);
    $("withdraw-dialog").showModal();
    $("withdraw-reason").focus();
  }

  async #send(event) {
    event.preventDefault(); // it stays open until the station has said yes
    const [reason, user] = ["reason", "user"].map((name) => $(`withdraw-${name}`).value.trim());
    $("withdraw-send").disabled = true;
    try {
      await post("model/withdraw", { unit: this.#serial, model: Number($("withdraw-version").value), reason, user });
      $("withdraw-dialog").close();
      this.#done();
    } catch (error) {
      say($("withdraw-failure"), error.where ? `${error.where}: ${error.message}` : error.message);
      show($("withdraw-failure"), true);
    }
    $("withdraw-send").disabled = false;
  }
}
