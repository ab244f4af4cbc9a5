// SPDX-License-Identifier: Apache-2.0
// What a controller has answered when it was tried.

import { element, english } from "./dom.mjs";
import { number } from "./format.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

/** @typedef {import("./kept_documents.mjs").Survey} Survey */

/** @param {Survey} survey */
function verdict(survey) {
  if (!survey.sound) return S.try.unsound;
  const air = survey.entries.find(({ name }) => name === "air_c");
  return air && air.value !== null ? S.try.air(number(air.value, 2)) : S.try.sound;
}

/** @param {Survey["entries"]} entries */
function table(entries) {
  const list = Object.assign(document.createElement("table"), { className: "list" });
  const head = list.createTHead().insertRow();
  for (const title of [S.try.name, S.try.found, S.try.trouble]) head.append(Object.assign(element("th", title), { scope: "col" }));
  const body = list.createTBody();
  for (const { name, text, trouble } of entries) {
    const row = body.insertRow();
    for (const cell of [name, text ?? "–", trouble ?? ""]) row.insertCell().append(english(cell));
  }
  return list;
}

/**
 * @param {HTMLElement} node
 * @param {Survey} survey
 * @param {string} address that was asked
 */
export function showSurvey(node, survey, address) {
  const line = Object.assign(element("p", `${address}: ${verdict(survey)}`), { className: survey.sound ? "good" : "bad" });
  const all = document.createElement("details");
  all.append(element("summary", S.try.all), table(survey.entries));
  all.open = !survey.sound;
  node.replaceChildren(line, all);
}
