// SPDX-License-Identifier: Apache-2.0
// Asks what of a run shall be void, why and by whom, and says what that loses.

import { post } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { RecordDialog } from "./record_dialog.mjs";
import { lossText, R, scopesOf } from "./run_words.mjs";

export class VoidDialog {
  #document = null;
  #scopes = [];
  #dialog;

  /** `done()`: after something has become void. */
  constructor(done) {
    this.#dialog = new RecordDialog("void", async (record) => {
      const { run_id, unit } = this.#document.run;
      await post("run/void", { run: run_id, unit, ...this.#scope.record, ...record });
      done();
    });
    $("void-scope").addEventListener("change", () => this.#sayLoss());
  }

  /** `document`: of the run; `segment`: the one that it is about, or null; `user`: who is at the page, if known. */
  open(document, segment, user) {
    this.#document = document;
    this.#scopes = scopesOf(document, segment);
    say($("void-title"), segment ? R.void.titleSegment : R.void.titleRun);
    $("void-scope").replaceChildren($("void-scope").querySelector("legend"), ...this.#scopes.map((scope, i) => this.#choice(scope, i)));
    show($("void-scope"), this.#scopes.length > 1);
    this.#sayLoss();
    this.#dialog.open(user);
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
}
