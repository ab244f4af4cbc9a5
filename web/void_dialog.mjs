// SPDX-License-Identifier: Apache-2.0
// Asks what of a run shall be void, why and by whom, and says what that loses.

import { post } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { lossText, R, scopesOf } from "./run_words.mjs";

export class VoidDialog {
  #document = null;
  #scopes = [];
  #done;

  /** `done()`: after something has become void. */
  constructor(done) {
    this.#done = done;
    $("void-cancel").addEventListener("click", () => $("void-dialog").close());
    $("void-form").addEventListener("submit", (event) => this.#send(event));
    $("void-scope").addEventListener("change", () => this.#sayLoss());
  }

  /** `document`: of the run; `segment`: the one that it is about, or null; `user`: who is at the page, if known. */
  open(document, segment, user) {
    this.#document = document;
    this.#scopes = scopesOf(document, segment);
    say($("void-title"), segment ? R.void.titleSegment : R.void.titleRun);
    $("void-scope").replaceChildren($("void-scope").querySelector("legend"), ...this.#scopes.map((scope, i) => this.#choice(scope, i)));
    show($("void-scope"), this.#scopes.length > 1);
    $("void-reason").value = "";
    $("void-user").value = user;
    show($("void-failure"), false);
    this.#sayLoss();
    $("void-dialog").showModal();
    $("void-reason").focus();
  }

  #choice(scope, index) {
    const label = element("label", "");
    const input = Object.assign(document.createElement("input"), { type: "radio", name: "void-scope", value: index, checked: index === 0 });
    label.append(input, ` ${scope.text}`);
    return label;
  }

  get #scope() {
    return this.#scopes[$("void-scope").querySelector(":checked").value];
  }

  #sayLoss() {
    say($("void-text"), lossText(this.#document, this.#scope));
  }

  async #send(event) {
    event.preventDefault(); // it stays open until the station has said yes
    const { run_id, unit } = this.#document.run;
    const record = { run: run_id, unit, ...this.#scope.record, reason: $("void-reason").value.trim(), user: $("void-user").value.trim() };
    $("void-send").disabled = true;
    try {
      await post("run/void", record);
      $("void-dialog").close();
      this.#done();
    } catch (error) {
      say($("void-failure"), error.where ? `${error.where}: ${error.message}` : error.message);
      show($("void-failure"), true);
    }
    $("void-send").disabled = false;
  }
}
