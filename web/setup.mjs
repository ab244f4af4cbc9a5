// SPDX-License-Identifier: Apache-2.0
// The page on which a station is set up that has no configuration yet: steps with fields, which the station itself checks, and the file that comes of them.

import { get, post } from "./api.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { connectLanguage, textsOf } from "./text.mjs";

connectLanguage($("language"));
/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");
document.title = S.page;
const { SetupForm, STEPS } = await import("./setup_form.mjs");
const { showSurvey } = await import("./setup_answer.mjs");

const AGAIN_MS = 500;
const PATIENCE_MS = 30_000;

/** @param {any} error what a call of the station has thrown: with a status where the station itself has refused */
function fail(error) {
  $("failure").replaceChildren(error.status ? english(error.message) : S.noAnswer);
  show($("failure"), true);
}

class SetupPage {
  #form;
  #step = STEPS[0];

  /** @param {import("./kept_documents.mjs").SetupChoices} choices */
  constructor(choices) {
    this.#form = new SetupForm(choices);
    say($("file"), choices.file);
    for (const button of $("steps").querySelectorAll("button")) {
      button.addEventListener("click", () => this.#go(button.dataset.step));
    }
    for (const section of ["chamber", "fixture"]) $(`${section}-try`).addEventListener("click", () => this.#try(section));
    $("look").addEventListener("click", () => this.#look());
    $("back").addEventListener("click", () => this.#go(STEPS[STEPS.indexOf(this.#step) - 1]));
    $("write").addEventListener("click", () => this.#write());
    $("form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#next();
    });
    this.#show("chamber");
  }

  /** Enter in a field of the last step writes nothing: that is for its button. */
  async #next() {
    if (this.#step === "file") return;
    if (await this.#isSound()) await this.#go(STEPS[STEPS.indexOf(this.#step) + 1]);
  }

  /** Whether the station takes what the present step says; else its mistakes stand at their fields, and the first one is in hand. */
  async #isSound() {
    if ((await this.#check([this.#step])) === null) return false;
    const field = this.#form.firstMistake(this.#step);
    field?.input.focus();
    return field === null;
  }

  /**
   * @param {string[]} steps whose mistakes are told
   * @returns {Promise<import("./kept_documents.mjs").SetupCheck | null>} null: the station did not say
   */
  async #check(steps) {
    show($("failure"), false);
    try {
      const check = await post("setup/check", this.#form.entered());
      this.#form.tell(check.mistakes, steps);
      return check;
    } catch (error) {
      if (!this.#form.tellRefusal(error)) fail(error);
      return null;
    }
  }

  async #go(step) {
    this.#show(step);
    $(`${step}-title`).focus();
    if (step === "file") await this.#review();
  }

  #show(step) {
    this.#step = step;
    show($("failure"), false);
    for (const name of STEPS) show($(`step-${name}`), name === step);
    for (const button of $("steps").querySelectorAll("button")) {
      if (button.dataset.step === step) button.setAttribute("aria-current", "step");
      else button.removeAttribute("aria-current");
    }
    $("back").disabled = step === STEPS[0];
    show($("next"), step !== "file");
    show($("write"), step === "file");
    $("write").disabled = true;
  }

  /** The file as it would be, and what is wrong with it. */
  async #review() {
    const check = await this.#check(STEPS);
    const faults = this.#form.faults();
    $("mistakes").replaceChildren(...faults.map(({ step, field, parts }) => this.#mistake(step, field, parts)));
    show($("text"), check !== null);
    say($("text"), check?.text ?? "");
    const good = check !== null && faults.length === 0;
    show($("good"), good);
    $("write").disabled = !good;
  }

  #mistake(step, field, parts) {
    const item = element("li", "");
    const text = element("span", field ? `${S.steps[step]}, ${field.title}: ` : "");
    text.append(...parts);
    item.append(text);
    if (!field) return item;
    const button = Object.assign(element("button", S.file.toField), { type: "button", className: "small" });
    button.setAttribute("aria-label", `${S.file.toField}: ${field.title}`);
    button.addEventListener("click", async () => {
      await this.#go(step);
      field.input.focus();
    });
    item.append(button);
    return item;
  }

  /** Asks a controller, which takes some seconds where nobody answers. */
  async #try(section) {
    const controller = this.#form[section];
    const answer = $(`${section}-answer`);
    if (!this.#form.checkAll(controller.all)) return;
    $(`${section}-try`).disabled = true;
    answer.replaceChildren(S.try.trying);
    try {
      showSurvey(answer, await post("setup/try", { section, [section]: controller.entered() }));
    } catch (error) {
      answer.replaceChildren();
      if (error.where === section) controller.address.where.tell(english(error.message));
      else if (!this.#form.tellRefusal(error)) fail(error);
      if (error.where) controller.all.find(({ input }) => input.hasAttribute("aria-invalid"))?.input.focus();
    }
    $(`${section}-try`).disabled = false;
  }

  async #look() {
    show($("look-failure"), false);
    if (!this.#form.checkAll(this.#form.slotFields)) return;
    $("look").disabled = true;
    say($("look"), S.units.looking);
    try {
      await this.#form.look();
    } catch (error) {
      if (!this.#form.tellRefusal(error)) {
        $("look-failure").replaceChildren(english(error.message));
        show($("look-failure"), true);
      }
    }
    $("look").disabled = false;
    say($("look"), S.units.look);
  }

  async #write() {
    $("write").disabled = true;
    show($("failure"), false);
    try {
      await post("setup/write", { ...this.#form.entered(), user: this.#form.user.value || "unknown" });
    } catch (error) {
      if (!this.#form.tellRefusal(error)) fail(error);
      $("write").disabled = false;
      return;
    }
    for (const node of [$("form"), $("steps"), $("intro")]) show(node, false);
    show($("done"), true);
    say($("done"), S.file.writing);
    await this.#waitForStation(Date.now() + PATIENCE_MS);
  }

  /** The station goes on by itself; its own page is there once it answers who one is. */
  async #waitForStation(latest) {
    for (;;) {
      try {
        await get("session");
        location.replace("/");
        return;
      } catch {
        if (Date.now() > latest) say($("done"), S.file.slow);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    }
  }
}

try {
  new SetupPage(await get("setup"));
} catch (error) {
  for (const id of ["form", "steps", "intro"]) show($(id), false);
  say($("done"), error.status === 404 ? S.already : S.noAnswer);
  show($("done"), true);
  if (error.status === 404) $("done").append(" ", Object.assign(element("a", S.toStation), { href: "/" }));
}
