// SPDX-License-Identifier: Apache-2.0
// The guide beside the page on which a station is set up: the pages of the Help in a dialog.

import { $, say, show } from "./dom.mjs";
import { language, textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

/** Connects the buttons that name a page of the Help, and the links within such pages. */
export function connectHelp() {
  show($("help-english"), language !== "en");
  for (const button of document.querySelectorAll("button[data-help]")) {
    const { help = "", at = null } = /** @type {HTMLElement} */ (button).dataset;
    button.addEventListener("click", () => open(help, at));
  }
  $("help-page").addEventListener("click", (event) => {
    const address = event.target.closest("a")?.getAttribute("href") ?? "";
    if (!address.startsWith("#help=")) return;
    event.preventDefault(); // what was entered stays
    const parameters = new URLSearchParams(address.slice(1));
    open(parameters.get("help") ?? "", parameters.get("at"));
  });
}

/**
 * @param {string} name of the page, as its file in docs/
 * @param {string | null} heading
 */
async function open(name, heading) {
  show($("help-failure"), false);
  if (!$("help").open) $("help").showModal();
  try {
    const answer = await fetch(`help-${encodeURIComponent(name)}.html`);
    if (!answer.ok) throw new Error(`HTTP status ${answer.status}`);
    $("help-page").replaceChildren(...new DOMParser().parseFromString(await answer.text(), "text/html").body.childNodes);
    const target = heading ? document.getElementById(`at-${heading}`) : null;
    (target ?? $("help-title")).scrollIntoView();
  } catch {
    $("help-page").replaceChildren();
    say($("help-failure"), S.help.noAnswer);
    show($("help-failure"), true);
  }
}
