// SPDX-License-Identifier: Apache-2.0
// A dialog before something that cannot be taken back: it asks why and who, and stays open until the station has said yes.

import { $, say, show } from "./dom.mjs";

/** Whoever has not given their name at the page is asked for it here. */
const NOBODY = "web page";

export class RecordDialog {
  #name;

  /**
   * Of the elements NAME-dialog, -form, -reason, -user, -cancel, -send and -failure.
   * @param {string} name
   * @param {(record: {reason: string, user: string}) => Promise<unknown>} send throws what the station refuses
   */
  constructor(name, send) {
    this.#name = name;
    this.#part("cancel").addEventListener("click", () => this.#part("dialog").close());
    this.#part("form").addEventListener("submit", (event) => this.#submit(event, send));
  }

  /** @param {string} user who is at the page */
  open(user) {
    this.#part("reason").value = "";
    this.#part("user").value = user === NOBODY ? "" : user;
    show(this.#part("failure"), false);
    this.#part("dialog").showModal();
    this.#part("reason").focus();
  }

  #part(name) {
    return $(`${this.#name}-${name}`);
  }

  async #submit(event, send) {
    event.preventDefault();
    const [reason, user] = ["reason", "user"].map((name) => this.#part(name).value.trim());
    this.#part("send").disabled = true;
    try {
      await send({ reason, user });
      this.#part("dialog").close();
    } catch (error) {
      say(this.#part("failure"), error.where ? `${error.where}: ${error.message}` : error.message);
      show(this.#part("failure"), true);
    }
    this.#part("send").disabled = false;
  }
}
