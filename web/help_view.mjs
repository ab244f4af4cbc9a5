// SPDX-License-Identifier: Apache-2.0
// The Help: pages of docs/ that tools/help_pages.py has turned into HTML when soakd was built.

import { $, element, say, show } from "./dom.mjs";
import { styled } from "./style_sheet.mjs";
import { language, T } from "./text.mjs";

/** Where somebody at the page begins, who names no page of the Help. */
const FIRST = { name: "guide", heading: "from-the-browser" };

const SHORTEST_WORD = 2;
const MOST_FOUND = 30;
const EXCERPT = 160; // letters

/** The parts of a page, each from a heading to the next one. */
function chaptersOf(page, article) {
  const chapters = [];
  for (const node of article.children) {
    if (node.id.startsWith("at-")) chapters.push({ page, at: node.id.slice("at-".length), heading: node.textContent, plain: "" });
    else if (chapters.length > 0) chapters[chapters.length - 1].plain += ` ${node.textContent}`;
  }
  const title = chapters[0]?.heading ?? page;
  return chapters.map((chapter) => ({ ...chapter, title, text: `${chapter.heading} ${chapter.plain}`.toLowerCase() }));
}

/** The words around the first place of one. */
function around(text, word) {
  const plain = text.replace(/\s+/g, " ").trim();
  const begin = Math.max(0, plain.toLowerCase().indexOf(word) - EXCERPT / 2);
  return `${begin > 0 ? "… " : ""}${plain.slice(begin, begin + EXCERPT)}${begin + EXCERPT < plain.length ? " …" : ""}`;
}

export class HelpView {
  #pages = new Map(); // name → its text as HTML
  #shown = null;
  #opened = 0;

  #asked = ""; // what is looked for

  #styled = styled("help.css");

  constructor() {
    show($("help-english"), language !== "en");
    $("help-find").addEventListener("input", () => this.#find());
    $("help-search").addEventListener("submit", (event) => event.preventDefault());
    $("help-found").addEventListener("click", ({ target }) => {
      if (target.closest("a")) this.#clear(); // what was found is shown instead
    });
  }

  #clear() {
    $("help-find").value = "";
    this.#find();
  }

  /** Looks through all pages of the Help, which are read once for that. */
  async #find() {
    const words = $("help-find").value.toLowerCase().split(/\s+/).filter((word) => word.length >= SHORTEST_WORD);
    const asked = words.join(" ");
    this.#asked = asked;
    show($("help-found-box"), asked !== "");
    show($("help-page"), asked === "");
    if (asked === "") return;
    say($("help-found-count"), T.help.reading);
    $("help-found").replaceChildren();
    const chapters = await this.#chapters().catch((error) => error);
    if (this.#asked !== asked) return;
    if (chapters instanceof Error) {
      say($("help-found-count"), chapters.message);
      return;
    }
    const found = chapters.filter(({ text }) => words.every((word) => text.includes(word)));
    // A chapter that names it in its heading comes before one that mentions it.
    const rank = ({ heading }) => words.filter((word) => !heading.toLowerCase().includes(word)).length;
    found.sort((a, b) => rank(a) - rank(b));
    say($("help-found-count"), found.length === 0 ? T.help.nothing : T.help.found(found.length));
    $("help-found").replaceChildren(...found.slice(0, MOST_FOUND).map(({ page, title, at, heading, plain }) => {
      const line = element("li", "");
      line.append(Object.assign(element("a", heading), { href: `#${new URLSearchParams({ help: page, at })}` }), element("span", ` ${title}`),
        element("p", around(plain, words[0])));
      return line;
    }));
  }

  /** Every part of every page under its heading: {page, title, at, heading, plain, text}, `text` in small letters. */
  async #chapters() {
    const first = new DOMParser().parseFromString(await this.#text(FIRST.name), "text/html");
    const names = [...first.querySelectorAll("nav a")].map((link) => new URLSearchParams(link.getAttribute("href").slice(1)))
      .filter((address) => !address.has("at")).map((address) => address.get("help"));
    const pages = await Promise.all([...new Set([FIRST.name, ...names])].map(async (name) => [name, await this.#text(name)]));
    return pages.flatMap(([name, text]) => chaptersOf(name, new DOMParser().parseFromString(text, "text/html").querySelector("article")));
  }

  /** `help`: the page, `at`: the heading on it, as the links of the pages have them. */
  async open(parameters) {
    const name = parameters.get("help") || FIRST.name;
    const heading = parameters.get("help") ? parameters.get("at") : FIRST.heading;
    const mine = ++this.#opened;
    show($("help-failure"), false);
    try {
      const text = await this.#text(name);
      await this.#styled;
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
