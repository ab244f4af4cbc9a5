// SPDX-License-Identifier: Apache-2.0
// What the laboratory measures with and what it measures: certificates of references, types of units, new units, the key, and who is told of alarms.

import { AlarmsCard } from "./alarms_card.mjs";
import { get, post } from "./api.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { KeyCard } from "./key_card.mjs";
import { badge } from "./runs_view.mjs";
import { C, dueText, hintOf, kindText, limitsText, ratingText, standingOf, valueText } from "./records_words.mjs";
import { unitAddress } from "./views.mjs";

const GRAVITY = "gravity";

export class RecordsView {
  #userName;
  #operator;
  #alarms;
  #key;
  #retiring = null; // the entry that the dialog is about

  /** `userName()`: who does something; `operator()`: the same, "" where nobody has said so, for records that state who. */
  constructor(userName, operator) {
    this.#userName = userName;
    this.#operator = operator;
    this.#alarms = new AlarmsCard(userName);
    this.#key = new KeyCard(userName);
    $("reference-form").addEventListener("submit", (event) => this.#addReference(event));
    $("reference-form").addEventListener("input", ({ target }) => target.removeAttribute("aria-invalid"));
    $("reference-kind").addEventListener("change", () => this.#sayUnit());
    $("new-unit-form").addEventListener("submit", (event) => this.#addUnit(event));
    $("retire-form").addEventListener("submit", (event) => this.#retire(event));
    $("retire-cancel").addEventListener("click", () => $("retire-dialog").close());
  }

  async open() {
    this.#sayUnit();
    if (this.#operator()) $("reference-user").value = this.#operator();
    await tell("records-failure", async () => this.#showReferences((await get("references")).references));
    await tell("records-failure", async () => this.#showTypes(await get("types")), { add: true });
    await this.#key.open();
    await this.#alarms.open();
  }

  /** The entries that stand; older ones of a reference come after its newest. */
  #showReferences(references) {
    const seen = new Set();
    const standing = references.filter(({ kind, name }) => !seen.has(`${kind} ${name}`) && seen.add(`${kind} ${name}`));
    const rows = standing.map((entry) => {
      const row = element("tr", "");
      const state = element("td", "");
      state.append(badge(standingOf(entry)));
      if (hintOf(entry)) state.append(Object.assign(element("p", hintOf(entry)), { className: "why" }));
      const retire = Object.assign(element("button", C.references.retire), { type: "button", className: "small" });
      retire.dataset.needs = "engineer";
      retire.setAttribute("aria-label", C.references.retireIt(entry.name));
      retire.addEventListener("click", () => this.#askToRetire(entry));
      const actions = element("td", "");
      if (entry.retired === null) actions.append(retire);
      const { correction, standard_uncertainty: uncertainty, unit } = entry;
      const numbers = [correction, uncertainty].map((value) => valueText(value, uncertainty, unit));
      row.append(...[kindText(entry.kind), entry.name, entry.certificate].map((text) => element("td", text)), state, element("td", dueText(entry.due)), ...numbers.map((text) => element("td", text)), actions);
      return row;
    });
    $("references").tBodies[0].replaceChildren(...rows);
    show($("references-box"), rows.length > 0);
    show($("references-none"), rows.length === 0);
  }

  #showTypes({ types, folder, troubles }) {
    const rows = types.map((type) => {
      const row = element("tr", "");
      const about = element("td", "");
      about.append(english(type.description));
      row.append(element("td", type.name), about, ...[ratingText(type), limitsText(type.limits)].map((text) => element("td", text)));
      return row;
    });
    $("types").tBodies[0].replaceChildren(...rows);
    say($("types-folder"), folder);
    $("types-troubles").replaceChildren(...troubles.map((text) => Object.assign(element("li", text), { lang: "en" })));
    show($("types-troubles"), troubles.length > 0);
    const option = (text, value) => Object.assign(element("option", text), { value });
    $("new-unit-type").replaceChildren(option(C.newUnit.choose, ""), ...types.map(({ name }) => option(name, name)));
  }

  #sayUnit() {
    const [{ value: kind, dataset: { unit } }] = $("reference-kind").selectedOptions;
    const isGravity = kind === GRAVITY;
    const correction = C.entry.corrections[kind];
    say($("reference-unit"), unit);
    say($("reference-correction-what"), isGravity ? C.entry.gravity(unit) : C.entry.correction(unit, correction));
    show($("reference-correction-box"), isGravity || correction !== undefined);
    $("reference-correction").required = isGravity;
  }

  async #addReference(event) {
    event.preventDefault();
    const text = (id) => $(id).value.trim();
    const entry = {
      kind: $("reference-kind").value,
      name: text("reference-name"),
      certificate: text("reference-certificate"),
      issued: $("reference-issued").value,
      due: $("reference-due").value,
      uncertainty: Number($("reference-uncertainty").value),
      k: Number($("reference-k").value),
      correction: text("reference-correction") === "" || $("reference-correction-box").hidden ? null : Number(text("reference-correction")),
    };
    await tell("reference-failure", async () => {
      const user = text("reference-user");
      this.#showReferences((await post("references/add", { ...entry, user }).catch(markField)).references);
      say($("records-news"), C.references.entered(entry.name));
      $("reference-form").reset();
      $("reference-user").value = user;
      this.#sayUnit();
      $("reference-kind").focus();
    });
  }

  #askToRetire(entry) {
    this.#retiring = entry;
    say($("retire-text"), C.retire.about(kindText(entry.kind), entry.name, entry.certificate));
    $("retire-reason").value = "";
    $("retire-user").value = this.#operator();
    show($("retire-failure"), false);
    $("retire-dialog").showModal();
    $("retire-reason").focus();
  }

  async #retire(event) {
    event.preventDefault(); // it stays open until the station has said yes
    await tell("retire-failure", async () => {
      const record = { record_id: this.#retiring.record_id, reason: $("retire-reason").value.trim(), user: $("retire-user").value.trim() };
      const { references } = await post("references/retire", record);
      $("retire-dialog").close();
      this.#showReferences(references);
      say($("records-news"), C.references.retired(this.#retiring.name));
      $("records-title").focus(); // the button that led here is gone
    });
  }

  async #addUnit(event) {
    event.preventDefault();
    $("new-unit-done").replaceChildren();
    await tell("new-unit-failure", async () => {
      const { unit, type } = await post("unit/add", { unit: $("new-unit-serial").value.trim(), type: $("new-unit-type").value, user: this.#userName() });
      const link = Object.assign(element("a", unit), { href: unitAddress(unit) });
      $("new-unit-done").replaceChildren(link, C.newUnit.added(type));
      $("new-unit-serial").value = "";
    });
  }
}

/** Marks the field of the certificate's form that a refusal names, and leads there; the refusal goes on. */
function markField(error) {
  const field = error.where ? $(`reference-${error.where}`) : null;
  field?.setAttribute("aria-invalid", "true");
  field?.focus();
  throw error;
}

let busy = false;

/** Carries out, once at a time; where that fails the place with that id says why. `add`: beside what it says already. */
async function tell(id, work, { add = false } = {}) {
  if (busy) return;
  busy = true;
  if (!add) show($(id), false);
  try {
    await work();
  } catch (error) {
    say($(id), error.message);
    show($(id), true);
  }
  busy = false;
}
