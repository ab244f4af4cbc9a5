// SPDX-License-Identifier: Apache-2.0
// The procedure of a new campaign: chosen from the list, changed before it begins, or a file of one's own.

import { get, post } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { procedureText } from "./start_words.mjs";
import { T } from "./text.mjs";

const OWN_FILE = "own file";

/** @typedef {{text: string, file: string}} ChosenText of a procedure, and the name of its file */

export class ProcedureChoice {
  #userName;
  /** @type {import("./documents.mjs").Procedure[]} */
  #procedures = [];
  /** @type {import("./procedure_changes.mjs").ProcedureChanges | null} */
  #changes = null; // once somebody has opened them

  /** `userName()`: who makes a changed procedure. */
  constructor(userName) {
    this.#userName = userName;
    $("start-choice").addEventListener("change", () => this.#choose());
    $("changes-box").addEventListener("toggle", () => this.#open());
  }

  /** Without any, a file of one's own is the only choice. What is chosen stays chosen. */
  show(procedures) {
    const [chosen, known] = [$("start-choice").value, JSON.stringify(procedures)];
    if (known === JSON.stringify(this.#procedures)) return;
    this.#procedures = procedures;
    const option = (text, value, disabled = false) => Object.assign(element("option", text), { value, disabled });
    const own = procedures.map((one) => option(procedureText(one), one.file, one.trouble !== null));
    $("start-choice").replaceChildren(option(T.start.choose, ""), ...own, option(T.start.own, OWN_FILE));
    $("start-choice").value = $("start-procedure").files.length > 0 ? OWN_FILE : chosen;
    if ($("start-choice").selectedIndex < 0) $("start-choice").value = "";
    show($("start-choice-label"), procedures.length > 0);
    this.#choose();
  }

  #choose() {
    const own = this.#procedures.length === 0 || $("start-choice").value === OWN_FILE;
    show($("start-file-label"), own);
    $("start-procedure").required = own;
    $("start-choice").required = !own;
    show($("changes-box"), this.#chosen() !== undefined);
    const chosen = this.#chosen();
    say($("start-chosen"), chosen === undefined ? "" : procedureText(chosen)); // the field may be too narrow for it
    this.#open();
  }

  #chosen() {
    return this.#procedures.find(({ file }) => file === $("start-choice").value);
  }

  /** The fields for the changes of what is chosen. */
  async #open() {
    if (!$("changes-box").open || !this.#chosen()) return;
    const { ProcedureChanges } = await import("./procedure_changes.mjs");
    this.#changes ??= new ProcedureChanges($("changes-box"));
    await this.#offer();
    // The form is checked as if something were typed.
    $("changes-box").dispatchEvent(new Event("input", { bubbles: true }));
  }

  /** The chosen one of the list, as its file is now. */
  async #listed() {
    const { file } = this.#chosen();
    const { procedures } = await get(`procedures?${new URLSearchParams({ file })}`);
    if (procedures.length === 0) throw new Error(T.start.gone(file));
    if (procedures[0].trouble) throw new Error(procedures[0].trouble);
    this.#changes?.offer(procedures[0], this.#procedures.map((one) => one.file));
    return procedures[0];
  }

  /** What is chosen, to be changed; where it cannot be read the check says so. */
  async #offer() {
    try {
      await this.#listed();
    } catch (error) {
      console.warn("no changes:", error.message);
    }
  }

  /**
   * Null where none is chosen. With changes it is what the station makes of them, which is not kept yet.
   * @returns {Promise<ChosenText | null>}
   */
  async text() {
    if (this.#chosen()) {
      const { text, file } = await this.#listed();
      return (await this.#made(true)) ?? { text, file };
    }
    const file = $("start-procedure").files[0];
    return file && !$("start-file-label").hidden ? { text: await file.text(), file: file.name } : null;
  }

  /** Whether a campaign would begin with a procedure that is not kept yet. */
  get isChanged() {
    try {
      return Boolean(this.#chosen() && this.#changes?.request());
    } catch {
      return true; // in a field there is a mistake
    }
  }

  /**
   * Keeps the changed procedure at the station, and goes on with it as the chosen one.
   * @returns {Promise<ChosenText>}
   */
  async keep() {
    const made = await this.#made(false);
    this.show((await get("procedures")).procedures);
    $("start-choice").value = made.file;
    $("changes-box").open = false;
    this.#choose();
    await this.#offer();
    return made;
  }

  /** @returns {Promise<ChosenText | null>} null where nothing is changed */
  async #made(isDraft) {
    try {
      this.#changes?.clearMarks();
      const request = this.#changes?.request() ?? null;
      return request && (await post("procedures/new", { ...request, draft: isDraft, user: this.#userName() }));
    } catch (error) {
      throw Object.assign(error, { isOfChanges: true });
    }
  }

  /**
   * Tells a mistake at the field of the changes that it is about; whether it is about one.
   * @param {any} error
   * @param {boolean} leads the field gets the focus
   */
  mark(error, leads) {
    return Boolean(error.isOfChanges && this.#changes?.mark(error, leads));
  }
}
