// SPDX-License-Identifier: Apache-2.0
// The Help: pages of docs/ that tools/help_pages.py has turned into HTML when soakd was built.

import { $, say, show } from "./dom.mjs";
import { language, T } from "./text.mjs";

/** Where somebody at the page begins, who names no page of the Help. */
const FIRST = { name: "guide", heading: "from-the-browser" };

export class HelpView {
  #pages = new Map(); // name → its text as HTML
  #shown = null;
  #opened = 0;

  constructor() {
    show($("help-english"), language !== "en");
  }

  /** `help`: the page, `at`: the heading on it, as the links of the pages have them. */
  async open(parameters) {
    const name = parameters.get("help") || FIRST.name;
    const heading = parameters.get("help") ? parameters.get("at") : FIRST.heading;
    const mine = ++this.#opened;
    show($("help-failure"), false);
    try {
      const text = await this.#text(name);
      if (mine !== this.#opened) return; // somebody has gone on meanwhile
      this.#show(name, text);
      this.#go(heading);
    } catch (error) {
      if (mine !== this.#opened) return;
      say($("help-failure"), error.message);
      show($("help-failure"), true);
    }
  }

  async #text(name) {
    if (!this.#pages.has(name)) {
      const answer = await fetch(`help-${encodeURIComponent(name)}.html`).catch(() => {
        throw new Error(T.help.noAnswer);
      });
      if (!answer.ok) throw new Error(answer.status === 404 ? T.help.unknown(name) : `HTTP status ${answer.status}`);
      this.#pages.set(name, await answer.text());
    }
    return this.#pages.get(name);
  }

  #show(name, text) {
    if (name === this.#shown) return;
    this.#shown = name;
    $("help-page").replaceChildren(...new DOMParser().parseFromString(text, "text/html").body.childNodes);
  }

  #go(heading) {
    const target = heading ? document.getElementById(`at-${heading}`) : null;
    target?.scrollIntoView();
    target?.focus({ preventScroll: true });
  }
}
