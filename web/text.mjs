// SPDX-License-Identifier: Apache-2.0
// The language that the page speaks, and its texts. Of the modules with texts, one a language, only those that are spoken are loaded: those of the
// station's own view at once, each group of other views with their modules.

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

/** The group of views whose texts an element has; "" of the station's own. */
const groupOf = (node) => node.closest("[data-texts]")?.dataset.texts ?? "";

/**
 * Writes the texts of a group, those in templates among them, where index.html names their keys ("start.name"): in front of what the element holds.
 * @param {ParentNode} root
 * @param {string} group
 * @param {any} texts
 */
function writeTexts(root, group, texts) {
  const textOf = (key) => key.split(".").reduce((part, name) => part[name], texts);
  const named = (name) => /** @type {HTMLElement[]} */ ([...root.querySelectorAll(`[data-${name}]`)]).filter((node) => groupOf(node) === group);
  for (const node of named("text")) node.prepend(textOf(node.dataset.text), node.firstChild ? " " : "");
  for (const [name, attribute] of Object.entries(ATTRIBUTES)) {
    for (const node of named(name)) node.setAttribute(attribute, textOf(node.dataset[name]));
  }
  for (const template of root.querySelectorAll("template")) writeTexts(template.content, group, texts);
}

/** Of groups whose texts stand in the page already: name → texts. */
const written = new Map();

/**
 * The texts of a group of views (text_GROUP_LANGUAGE.mjs), which are written into its part of the page before it is shown. Throws where the station
 * does not answer; another try may find it. A module that fails to begin fails for good: whoever loads modules that ask for texts asks for those texts first.
 * @param {string} group as data-texts of index.html names it
 * @returns {Promise<any>}
 */
export async function textsOf(group) {
  if (!written.has(group)) {
    const { text } = await import(`./text_${group}_${language}.mjs`);
    if (!written.has(group)) writeTexts(document, group, text); // somebody may have asked meanwhile
    written.set(group, text);
  }
  return written.get(group);
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
  writeTexts(document, "", T);
  select.append(...Object.entries(LANGUAGES).map(([tag, name]) => Object.assign(new Option(name, tag, tag === language, tag === language), { lang: tag })));
  select.addEventListener("change", () => choose(select.value));
}
