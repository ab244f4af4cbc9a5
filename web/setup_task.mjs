// SPDX-License-Identifier: Apache-2.0
// What the form of a station is filled in for: its first set-up, or a change of its settings while it works.

import { get, post } from "./api.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { clock } from "./format.mjs";
import { keep, takeKept } from "./setup_kept.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

const AGAIN_MS = 500;
const PATIENCE_MS = 30_000;
const pause = () => new Promise((resolve) => setTimeout(resolve, AGAIN_MS));

/** @typedef {import("./setup_form.mjs").SetupForm} SetupForm */
/** @typedef {import("./setup_kept.mjs").Kept} Kept */

/** Puts a link behind a line: the station's own page. */
function lead(node, text = S.toStation) {
  node.append(" ", Object.assign(element("a", text), { href: "/" }));
}

/** A station that has no configuration yet. */
export class FirstTask {
  path = "setup";
  isChange = false;

  /** @param {import("./kept_documents.mjs").SetupChoices} choices */
  constructor(choices) {
    this.choices = choices;
  }

  /** @returns {Kept | null} what was entered before the page was loaded again */
  begin() {
    return takeKept();
  }

  /** @param {Kept} entered */
  leave(entered) {
    keep(entered);
  }

  body(entered) {
    return entered;
  }

  /** The station goes on by itself; its own page is there once it answers who one is. */
  async finish() {
    const latest = Date.now() + PATIENCE_MS;
    for (;;) {
      try {
        await get("session");
        location.replace("/");
        return;
      } catch {
        if (Date.now() > latest) say($("done"), S.file.slow);
        await pause();
      }
    }
  }
}

/** A station that works. */
export class ChangeTask {
  path = "station";
  isChange = true;
  #station;
  #isLanguage = false;

  /** @param {import("./kept_documents.mjs").StationSettings} station */
  constructor(station) {
    this.#station = station;
    this.choices = station.choices;
    $("language").addEventListener("change", () => {
      this.#isLanguage = true; // only that keeps what was entered: whoever comes back later sees what the file says
    });
  }

  /**
   * Fills in what the station has, and says which secrets stay.
   * @param {SetupForm} form
   */
  begin(form) {
    const { answers, kept } = this.#station;
    if (answers === null || kept === null) return null;
    document.title = S.change.page;
    for (const [id, text] of Object.entries({ "setup-title": S.change.title, "setup-intro": S.change.intro, "file-title": S.change.review, "file-place": S.change.place, good: S.change.good, write: S.change.write })) say($(id), text);
    say(document.querySelector("[data-step='file']"), S.change.review);
    lead($("setup-intro"), S.change.leave);
    $("text").setAttribute("aria-label", S.change.text);
    for (const node of document.querySelectorAll("[data-first]")) show(/** @type {HTMLElement} */ (node), false);
    form.fill(valuesOf(answers));
    form.keepSecrets(kept);
    if (answers.unit_type === "") form.type.need(false);
    form.user.value = localStorage.getItem("soak-user") ?? "";
    this.#tellTrouble();
    return takeKept(this.#station.revision);
  }

  #tellTrouble() {
    const { trouble } = this.#station;
    if (trouble === null) return;
    $("failure").replaceChildren(S.change.undone(clock(trouble.utc_s), trouble.user), " ", english(trouble.text));
    show($("failure"), true);
  }

  /** @param {Kept} entered */
  leave(entered) {
    if (this.#isLanguage) keep(entered, this.#station.revision);
  }

  body(entered) {
    return { ...entered, revision: this.#station.revision };
  }

  /**
   * Whether the form says what the file says as long as nobody has changed anything.
   * @param {SetupForm} form
   */
  async isWhole(form) {
    return (await post("station/check", this.body(form.entered()))).text === "";
  }

  /** The station ends and begins with the new settings; or it does not, and goes on with those of before. */
  async finish() {
    const latest = Date.now() + PATIENCE_MS;
    for (;;) {
      const answer = await fetch("/api/v1/station").catch(() => null);
      if (answer?.status === 401) return lead(replaced(S.change.logIn));
      const station = answer?.ok ? await answer.json().catch(() => null) : null; // it may end in the middle of an answer
      if (station && !station.changing) return this.#tellEnd(station);
      if (Date.now() > latest) say($("done"), S.file.slow);
      await pause();
    }
  }

  /** @param {import("./kept_documents.mjs").StationSettings} station */
  #tellEnd({ trouble, file }) {
    const node = replaced(trouble === null ? S.change.done(`${file}.before`) : S.change.notBegun);
    if (trouble !== null) node.append(" ", english(trouble.text));
    lead(node);
  }
}

function replaced(text) {
  say($("done"), text);
  return $("done");
}

/** What stands in the fields of an address, a controller or a slot. */
function ofDevice(owner, device) {
  return { [`${owner}.way`]: device.device === undefined ? "tcp" : "serial", ...named(owner, device) };
}

function named(owner, members) {
  return Object.fromEntries(Object.entries(members).map(([key, value]) => [`${owner}.${key}`, Array.isArray(value) ? value.join(", ") : String(value)]));
}

/** @returns {"hand" | "chamber" | "usb_hubs" | "map"} */
function wayOf(power) {
  if (!power) return "hand";
  if (power.from) return "chamber";
  return power.usb_hubs ? "usb_hubs" : "map";
}

/**
 * The answers as they stand in the fields of the form.
 * @param {any} answers
 */
function valuesOf({ chamber, fixture, power, slots, mail, webhook, site = {}, room = {}, purge = {}, unit_type, decoder }) {
  const way = wayOf(power);
  const fields = {
    ...ofDevice("chamber", chamber), "fixture.kind.choice": fixture ? "machine" : "hand", ...(fixture ? ofDevice("fixture", fixture) : {}),
    "power.way.choice": way, ...(way === "map" ? ofDevice("power", power) : named("power", power ?? {})), unit_type, decoder,
    ...named("site", site), ...named("room", room), ...named("purge", purge),
    "mail.wanted.choice": mail ? "yes" : "no", ...named("mail", mail ?? {}), "webhook.wanted.choice": webhook ? "yes" : "no",
  };
  return { slots: slots.length, fields: Object.assign(fields, ...slots.map((slot, i) => ofDevice(`slots.${i}`, slot))) };
}

/**
 * What there is to do here; null, and the page says why, where there is nothing.
 * @returns {Promise<FirstTask | ChangeTask | null>}
 */
export async function taskHere() {
  if (location.hash !== "#change") return new FirstTask(await get("setup"));
  const { role } = await get("session");
  const station = role === null || role === "engineer" ? await get("station") : null;
  if (station?.obstacle === null) return new ChangeTask(station);
  document.title = S.change.page;
  say($("setup-title"), S.change.title);
  sayInstead(station === null ? [S.change.role] : [S.change.obstacle, " ", english(station.obstacle ?? "")]);
  return null;
}

/** In place of the form. */
export function sayInstead(parts) {
  for (const id of ["form", "steps", "intro"]) show($(id), false);
  $("done").replaceChildren(...parts);
  show($("done"), true);
  lead($("done"));
}
