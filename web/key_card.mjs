// SPDX-License-Identifier: Apache-2.0
// The key that the station signs calibration files with: its public part to give away, and a new one where there is none.

import { get, post } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { C } from "./records_words.mjs";

export class KeyCard {
  #userName;

  /** `userName()`: who makes the key. */
  constructor(userName) {
    this.#userName = userName;
    $("key-form").addEventListener("submit", (event) => this.#make(event));
  }

  async open() {
    await this.#tell(async () => this.#show((await get("key")).key));
  }

  /** @param {import("./documents.mjs").StationKey | null} key */
  #show(key) {
    show($("key-none"), key === null);
    show($("key-form"), key === null);
    show($("key-text"), key !== null);
    if (key === null) return;
    const link = Object.assign(element("a", C.key.download), { download: `${key.key_id}.pub` });
    link.href = URL.createObjectURL(new Blob([key.file], { type: "text/plain" }));
    $("key-text").replaceChildren(C.key.of(key.comment, key.key_id), link, C.key.give);
  }

  async #make(event) {
    event.preventDefault();
    await this.#tell(async () => {
      const { key } = await post("key/new", { comment: $("key-comment").value.trim(), user: this.#userName() });
      this.#show(key);
      $("key-title").tabIndex = -1;
      $("key-title").focus(); // the form is gone
    });
  }

  async #tell(work) {
    show($("key-failure"), false);
    try {
      await work();
    } catch (error) {
      say($("key-failure"), error.message);
      show($("key-failure"), true);
    }
  }
}
