// SPDX-License-Identifier: Apache-2.0
// The language that the page speaks, and its texts. Of the modules with texts, one a language, only the one that is spoken is loaded.

import { speak } from "./format.mjs";

/** Each by the name that it has for those who speak it. */
export const LANGUAGES = { en: "English", de: "Deutsch" };
const KEY = "soak-language";
/** Where a text goes that is not the element's own: attribute by the name of the data-… that holds the key. */
const ATTRIBUTES = { label: "aria-label", hint: "placeholder", tip: "title" };

/** The one that was chosen here, else the first that the browser asks for and the page has, else English. */
function spoken() {
  const wanted = [localStorage.getItem(KEY), ...navigator.languages].map((tag) => tag?.slice(0, 2).toLowerCase());
  return wanted.find((tag) => Object.hasOwn(LANGUAGES, tag ?? "")) ?? "en";
}

export const language = spoken();
speak(language);

/** @type {typeof import("./text_en.mjs").text} */
export const T = (await (language === "de" ? import("./text_de.mjs") : import("./text_en.mjs"))).text;

/** "start.name" → that text. */
const textOf = (key) => key.split(".").reduce((group, name) => group[name], T);

/**
 * Writes the texts of a part of the page, its templates among it, where index.html names their keys: in front of what the element holds.
 * @param {ParentNode} root
 */
export function writeTexts(root) {
  for (const node of root.querySelectorAll("[data-text]")) node.prepend(textOf(/** @type {HTMLElement} */ (node).dataset.text), node.firstChild ? " " : "");
  for (const [name, attribute] of Object.entries(ATTRIBUTES)) {
    for (const node of root.querySelectorAll(`[data-${name}]`)) node.setAttribute(attribute, textOf(/** @type {HTMLElement} */ (node).dataset[name]));
  }
  for (const template of root.querySelectorAll("template")) writeTexts(template.content);
}

/**
 * Speaks another language from now on: the page is loaded again, at the same place.
 * @param {string} tag
 */
function choose(tag) {
  localStorage.setItem(KEY, tag);
  location.reload();
}

/** The whole page in its language; `select`: where another one is chosen. */
export function connectLanguage(select) {
  document.documentElement.lang = language;
  writeTexts(document);
  select.append(...Object.entries(LANGUAGES).map(([tag, name]) => Object.assign(new Option(name, tag, tag === language, tag === language), { lang: tag })));
  select.addEventListener("change", () => choose(select.value));
}
