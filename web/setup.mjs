// SPDX-License-Identifier: Apache-2.0
// The page on which a station is set up that has no configuration yet: steps with fields, which the station itself checks, and the file that comes of them.

import { post } from "./api.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { connectLanguage, textsOf } from "./text.mjs";

connectLanguage($("language"));
/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");
document.title = S.page;
const { SetupForm, STEPS } = await import("./setup_form.mjs");
const { showSurvey } = await import("./setup_answer.mjs");
const { forgetKept } = await import("./setup_kept.mjs");
const { sayInstead, taskHere } = await import("./setup_task.mjs");
const { connectHelp } = await import("./setup_help.mjs");
connectHelp();

/** Status of HTTP: there is a file already. */
const CONFLICT = 409;

/**
 * @param {any} error what a call of the station has thrown: with a status where the station itself has refused
 * @param {HTMLElement} node
 */
function fail(error, node = $("failure")) {
  node.replaceChildren(error.status ? english(error.message) : S.noAnswer);
  show(node, true);
}

class SetupPage {
  #form;
  #task;
  #step = STEPS[0];
  #isSetUp = false;
  /** How often what stands in a section has changed: an answer is about what stood there when it was asked. */
  #changes = { chamber: 0, fixture: 0, power: 0 };
  /** @type {import("./setup_kept.mjs").Tries} */
  #tries = { chamber: null, fixture: null, power: null };

  /**
   * @param {import("./setup_task.mjs").FirstTask | import("./setup_task.mjs").ChangeTask} task
   * @param {import("./setup_form.mjs").SetupForm} form
   */
  constructor(task, form) {
    this.#form = form;
    this.#task = task;
    say($("file"), task.choices.file);
    for (const button of $("steps").querySelectorAll("button")) {
      button.addEventListener("click", () => this.#go(button.dataset.step));
    }
    for (const section of ["chamber", "fixture", "power"]) {
      $(`${section}-try`).addEventListener("click", () => this.#try(section));
      $(`${section}-fields`).addEventListener("input", () => {
        this.#changes[section] += 1;
        this.#tries[section] = null;
        $(`${section}-answer`).replaceChildren();
      });
    }
    $("look").addEventListener("click", () => this.#look());
    $("alarms-test").addEventListener("click", () => this.#testAlarms());
    $("back").addEventListener("click", () => this.#go(STEPS[STEPS.indexOf(this.#step) - 1]));
    $("write").addEventListener("click", () => this.#write());
    $("form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#next();
    });
    addEventListener("pagehide", () => {
      if (!this.#isSetUp) task.leave({ step: this.#step, tries: this.#tries, ...this.#form.values() });
    });
    const kept = task.begin(form);
    if (kept) this.#form.fill(kept);
    Object.assign(this.#tries, kept?.tries); // after the fields, whose changes make them void
    this.#show(STEPS[0], true);
    if (kept && STEPS.indexOf(kept.step) > 0) this.#go(kept.step);
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
      const check = await post(`${this.#task.path}/check`, this.#task.body(this.#form.entered()));
      this.#form.tell(check.mistakes, steps);
      return check;
    } catch (error) {
      this.#refused(error, steps === STEPS);
      return null;
    }
  }

  /**
   * What the station has refused stands at its field; where that is on another step, it is said here, too.
   * @param {any} error
   * @param {boolean} isListed all mistakes are listed here anyway
   */
  #refused(error, isListed = false) {
    const told = this.#form.tellRefusal(error);
    if (!told) return fail(error);
    if (told.step === this.#step || isListed) return;
    $("failure").replaceChildren(...this.#mistake(told.step, told.field, [english(error.message)]));
    show($("failure"), true);
  }

  async #go(step) {
    this.#show(step);
    $(`${step}-title`).focus();
    if (step === "file") await this.#review();
  }

  #show(step, keepsFailure = false) {
    this.#step = step;
    if (!keepsFailure) show($("failure"), false);
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
    $("mistakes").replaceChildren(...faults.map(({ step, field, parts }) => {
      const item = element("li", "");
      item.append(...this.#mistake(step, field, parts));
      return item;
    }));
    const isSame = this.#task.isChange && check?.text === "";
    show($("text"), check !== null && !isSame);
    say($("text"), check?.text ?? "");
    const good = check !== null && faults.length === 0 && !isSame;
    show($("good"), good);
    show($("same"), isSame && faults.length === 0);
    this.#listNotSound();
    show($("no-gravity"), !this.#form.knowsGravity);
    show($("no-dew-point"), !this.#form.knowsDewPoint);
    $("write").disabled = !good;
  }

  /** The controllers that are relied on without a good try; one that is not entered rightly has nothing to be tried yet. */
  #listNotSound() {
    if (this.#task.isChange) return; // it is not tried here
    const wrong = new Set(this.#form.faults().map(({ step }) => step));
    const notSound = this.#form.controllers.filter((section) => this.#tries[section] !== "good" && !wrong.has(section));
    $("not-sound").replaceChildren(...notSound.map((section) => element("li", S.try[this.#tries[section] === null ? "never" : "failed"](S.parts[section]))));
    show($("not-sound"), notSound.length > 0);
  }

  /** A mistake and where it is, with a button that leads there. */
  #mistake(step, field, parts) {
    const text = element("span", field ? `${S.steps[step]}, ${field.title}: ` : "");
    text.append(...parts);
    if (!field) return [text];
    const button = Object.assign(element("button", S.file.toField), { type: "button", className: "small" });
    button.setAttribute("aria-label", `${S.file.toField}: ${field.title}`);
    button.addEventListener("click", async () => {
      await this.#go(step);
      field.input.focus();
    });
    return [text, " ", button];
  }

  /** Asks a controller, which takes some seconds where nobody answers. */
  async #try(section) {
    const controller = this.#form[section];
    const answer = $(`${section}-answer`);
    if (!this.#form.checkAll(controller.all)) return;
    $(`${section}-try`).disabled = true;
    show($("failure"), false);
    answer.replaceChildren(S.try.trying);
    const asked = this.#changes[section];
    const address = controller.address.text;
    try {
      const survey = await post("setup/try", { section, [section]: controller.entered() });
      if (asked === this.#changes[section]) {
        this.#tries[section] = survey.sound ? "good" : "bad";
        showSurvey(answer, survey, address);
      }
    } catch (error) {
      if (asked === this.#changes[section]) {
        this.#tries[section] = "bad";
        this.#notTried(section, error);
      }
    }
    $(`${section}-try`).disabled = false;
    if (this.#step === "file") this.#listNotSound(); // somebody has gone on meanwhile
  }

  #notTried(section, error) {
    const controller = this.#form[section];
    $(`${section}-answer`).replaceChildren();
    if (error.where === section) controller.address.tellNoAnswer(english(error.message));
    else this.#refused(error);
    if (error.where) controller.all.find(({ input }) => input.hasAttribute("aria-invalid"))?.input.focus();
  }

  async #look() {
    for (const id of ["look-failure", "failure"]) show($(id), false);
    if (!this.#form.checkAll(this.#form.slotFields)) return;
    $("look").disabled = true;
    say($("look"), S.units.looking);
    try {
      await this.#form.look();
    } catch (error) {
      if (error.status && error.where) this.#refused(error);
      else fail(error, $("look-failure"));
    }
    $("look").disabled = false;
    say($("look"), S.units.look);
  }

  /** Sends a message to whoever is to be told of alarms. */
  async #testAlarms() {
    show($("failure"), false);
    if (!this.#form.checkAll(this.#form.alarms.fields)) return;
    await this.#form.alarms.test(this.#form.user.value || "unknown", this.#task.path).catch((error) => this.#refused(error));
  }

  async #write() {
    $("write").disabled = true;
    show($("failure"), false);
    const user = this.#form.user.value || "unknown";
    try {
      await post(`${this.#task.path}/write`, this.#task.body({ ...this.#form.entered(), user }));
    } catch (error) {
      this.#refused(error);
      if (error.status === CONFLICT && !this.#task.isChange) $("failure").append(" ", this.#useButton(user));
      $("write").disabled = false;
      return;
    }
    await this.#end();
  }

  /** Goes on with the file that is there; the station says what is wrong in it. */
  #useButton(user) {
    const button = Object.assign(element("button", S.file.use), { type: "button", className: "small", id: "use" });
    button.addEventListener("click", async () => {
      try {
        await post("setup/use", { user });
      } catch (error) {
        return fail(error);
      }
      await this.#end();
    });
    return button;
  }

  async #end() {
    this.#isSetUp = true;
    const user = this.#form.user.value;
    if (user !== "") localStorage.setItem("soak-user", user); // as the station's page keeps it
    forgetKept();
    for (const node of [$("form"), $("steps"), $("intro")]) show(node, false);
    show($("done"), true);
    say($("done"), this.#task.isChange ? S.change.starting : S.file.starting);
    await this.#task.finish();
  }
}

async function begin() {
  const task = await taskHere();
  if (task === null) return;
  const form = new SetupForm(task.choices);
  new SetupPage(task, form);
  if ("isWhole" in task && !(await task.isWhole(form))) sayInstead([S.change.notWhole, " ", english(task.choices.file)]);
}

try {
  await begin();
} catch (error) {
  sayInstead([error.status === 404 ? S.already : S.noAnswer]);
}
