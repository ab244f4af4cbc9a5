// SPDX-License-Identifier: Apache-2.0
// What the station has found in its slots, below the fields for the serial numbers: which unit it is, whether it is the one in the field, a click that takes it.

import { send } from "./api.mjs";
import { element, english } from "./dom.mjs";
import { T } from "./text.mjs";

/** @typedef {import("./documents.mjs").SlotFinding} SlotFinding */

/** Units are changed at rest: what was found some minutes ago vouches for nothing. */
const KEPT_MS = 5 * 60_000;

/**
 * A line below the field: what stands in it decides whether the unit is the right one.
 * @param {SlotFinding} finding
 * @param {string} entered
 */
function words({ answer, serial, product, firmware, power_output, trouble }, entered) {
  switch (answer) {
    case "identified": {
      const unit = T.found.unit(serial, product, firmware);
      if (entered === serial) return { level: "good", parts: [T.found.right(unit)] };
      return entered ? { level: "bad", parts: [T.found.wrong(unit)] } : { level: "", parts: [T.found.new(unit)] };
    }
    case "anonymous":
      return { level: "bad", parts: [T.found.anonymous, ...(trouble === null ? [] : [" ", english(trouble)])] };
    case "silent":
      // The campaign switches it on, and asks then whether it is that one.
      if (entered && power_output !== null) return { level: "", parts: [T.found.output(power_output)] };
      return { level: "reason", parts: [T.found.silent, power_output === null ? "" : T.found.output(power_output)] };
    default:
      return { level: "bad", parts: [`${T.found.failed} `, english(trouble)] };
  }
}

export class SlotLook {
  #fields;
  #look;
  /** @type {SlotFinding[]} */
  #findings = [];
  #expiry = 0;
  /** An answer to a question that was asked before is about other slots. */
  #turn = 0;

  /**
   * @param {any} fields the element with the inputs that name their slots
   * @param {(user: string) => Promise<any>} look asks the station
   */
  constructor(fields, look = (user) => send("look", { user })) {
    this.#fields = fields;
    this.#look = look;
    fields.addEventListener("input", () => this.#show());
  }

  /** Throws where the station does not look. */
  async ask(user) {
    this.forget();
    const turn = this.#turn;
    const { slots } = await this.#look(user);
    if (turn !== this.#turn) return;
    this.#findings = slots;
    this.#expiry = setTimeout(() => this.forget(), KEPT_MS);
    this.#show();
  }

  forget() {
    clearTimeout(this.#expiry);
    this.#turn += 1;
    this.#findings = [];
    this.#show();
  }

  #show() {
    for (const input of this.#fields.querySelectorAll("input[data-slot]")) {
      const line = this.#lineOf(input);
      const finding = this.#findings.find(({ slot }) => slot === input.dataset.slot);
      if (!finding) {
        line.replaceChildren();
        continue;
      }
      const { level, parts } = words(finding, input.value.trim());
      line.className = `found ${level}`;
      const offer = finding.serial !== null && finding.serial !== input.value.trim();
      line.replaceChildren(...parts, ...(offer ? [" ", this.#offer(input, finding.serial)] : []));
    }
  }

  /** The line below a field, which screen readers tell when it changes. */
  #lineOf(input) {
    const field = input.closest("div");
    const known = field.querySelector(".found");
    if (known) return known;
    const line = element("p", "");
    line.className = "found";
    line.setAttribute("role", "status");
    field.append(line);
    return line;
  }

  #offer(input, serial) {
    const button = Object.assign(element("button", T.found.take(serial)), { type: "button", className: "small" });
    button.addEventListener("click", () => {
      input.value = serial;
      input.focus();
      // The form checks what it is filled with now, as if it were typed.
      input.dispatchEvent(new Event("input", { bubbles: true }));
    });
    return button;
  }
}
