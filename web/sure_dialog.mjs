// SPDX-License-Identifier: Apache-2.0
// A question before something that others will rely on.

import { $, element, say, show } from "./dom.mjs";

/**
 * Whether who is at the page agrees.
 * @param {{title: string, text: string, list?: string[], send: string}} question `send`: what the button that agrees says
 * @returns {Promise<boolean>}
 */
export function isSure({ title, text, list = [], send }) {
  const dialog = $("sure-dialog");
  say($("sure-title"), title);
  say($("sure-text"), text);
  $("sure-list").replaceChildren(...list.map((line) => element("li", line)));
  show($("sure-list"), list.length > 0);
  say($("sure-send"), send);
  dialog.returnValue = "";
  return new Promise((done) => {
    dialog.addEventListener("close", () => done(dialog.returnValue === "sure"), { once: true });
    dialog.showModal();
    $("sure-cancel").focus();
  });
}
