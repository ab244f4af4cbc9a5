// SPDX-License-Identifier: Apache-2.0
// What is entered on the page on which a station is set up, by steps, and the mistakes in it.

import { post } from "./api.mjs";
import { $, say, show } from "./dom.mjs";
import { AlarmFields } from "./setup_alarms.mjs";
import { ControllerFields, Field, said, SlotFields } from "./setup_fields.mjs";
import { PowerFields } from "./setup_power.mjs";
import { SlotLook } from "./slot_look.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

export const STEPS = ["chamber", "fixture", "units", "site", "alarms", "file"];
const MOST_SLOTS = 64;
/** Protocols by the beginning of the names of types that speak them; the others are of Xsens. */
const SPEAKS = { vn: "vectornav", ahrs: "ahrs400" };

export class SetupForm {
  #choices;
  /** @type {SlotFields[]} */
  #slots = [];
  /** @type {{field: string, message: string}[]} mistakes that no field has */
  #others = [];
  #slotLook = new SlotLook($("slots"), () => this.#askSlots());

  /** @param {import("./kept_documents.mjs").SetupChoices} choices */
  constructor(choices) {
    this.#choices = choices;
    $("ports").append(...choices.ports.map(({ device, node }) => new Option(node === device ? "" : node, device)));
    this.chamber = new ControllerFields("chamber", choices.chambers, choices.ports.length);
    this.fixture = new ControllerFields("fixture", choices.fixtures, choices.ports.length);
    this.kind = new Field("fixture.kind.choice", S.fixture.kind, { options: { hand: S.fixture.byHand, machine: S.fixture.machine } });
    this.type = new Field("unit_type", S.units.type, { options: this.#types(), needed: true });
    this.decoder = new Field("decoder", S.units.decoder, { options: S.units.decoders });
    this.powerSwitch = new PowerFields(choices.powers, choices.ports.length);
    this.power = this.powerSwitch.controller;
    this.purge = new Field("purge.below_c", S.purge.below, { decimal: true, hint: S.purge.belowHint });
    this.alarms = new AlarmFields();
    this.site = [
      new Field("site.latitude_deg", S.site.latitude, { decimal: true, hint: S.site.latitudeHint }), new Field("site.height_m", S.site.height, { decimal: true, hint: S.site.heightHint }),
      new Field("site.gravity_mps2", S.site.gravity, { decimal: true, hint: S.site.gravityHint }),
    ];
    this.room = [
      new Field("room.dew_point_c", S.room.dewPoint, { decimal: true, hint: S.room.dewPointHint }), new Field("room.temp_c", S.room.temp, { decimal: true, hint: S.room.tempHint }),
    ];
    this.user = new Field("user", S.file.user);
    const parts = { "chamber-fields": this.chamber.all, "fixture-kind": [this.kind], "fixture-fields": this.fixture.all, "units-fields": [this.type, this.decoder], "site-fields": this.site, "room-fields": this.room,
      "purge-fields": [this.purge], "power-choice": [this.powerSwitch.choice, this.powerSwitch.hubs], "power-fields": this.power.all,
      "mail-wanted": [this.alarms.wanted], "mail-fields": this.alarms.mail, "login-fields": this.alarms.login,
      "webhook-wanted": [this.alarms.hookWanted], "webhook-fields": this.alarms.hook, "user-fields": [this.user] };
    for (const [id, fields] of Object.entries(parts)) $(id).append(...fields.map(({ node }) => node));
    this.kind.input.addEventListener("change", () => show($("fixture-part"), this.#hasFixture));
    this.powerSwitch.choice.input.addEventListener("change", () => this.#followPower());
    this.type.input.addEventListener("change", () => this.#followType());
    $("slot-more").addEventListener("click", () => this.#addSlot().name.input.focus());
    $("slot-less").addEventListener("click", () => this.#dropSlot());
    for (const field of [this.type, this.decoder]) this.#watch(field);
    this.#addSlot();
  }

  #types() {
    return { "": S.choose, ...Object.fromEntries(this.#choices.types.map(({ name }) => [name, name])) };
  }

  get #hasFixture() {
    return this.kind.value === "machine";
  }

  /** Sections of the controllers that the station will have. */
  get controllers() {
    return ["chamber", ...(this.#hasFixture ? ["fixture"] : []), ...(this.powerSwitch.way === "map" ? ["power"] : [])];
  }

  #followPower() {
    for (const slot of this.#slots) slot.followPower(this.powerSwitch.way);
  }

  #followType() {
    const beginning = Object.keys(SPEAKS).find((name) => this.type.value.startsWith(name));
    this.decoder.value = beginning ? SPEAKS[beginning] : "xsens";
    say($("type-about"), this.#choices.types.find(({ name }) => name === this.type.value)?.description ?? "");
  }

  #addSlot() {
    const slot = new SlotFields(this.#slots.length, this.#choices.ports.length);
    slot.unit.input.dataset.slot = slot.name.value;
    slot.name.input.addEventListener("input", () => {
      slot.unit.input.dataset.slot = slot.name.value;
    });
    for (const field of [slot.name, ...slot.address.all]) this.#watch(field);
    slot.followPower(this.powerSwitch.way);
    this.#slots.push(slot);
    $("slots").append(slot.node);
    this.#countSlots();
    return slot;
  }

  #dropSlot() {
    this.#slots.pop()?.node.remove();
    this.#countSlots();
  }

  /** What was found in the slots was found with what stands here now. */
  #watch(field) {
    field.input.addEventListener("input", () => this.#slotLook.forget());
  }

  #countSlots() {
    this.#slotLook.forget();
    $("slot-less").disabled = this.#slots.length < 2;
    $("slot-more").disabled = this.#slots.length >= MOST_SLOTS;
  }

  /** Those of all slots. */
  get slotFields() {
    return this.#slots.flatMap((slot) => slot.all);
  }

  /** Fields that count, by their steps. */
  #fieldsOf(step) {
    switch (step) {
      case "chamber": return [...this.chamber.all, this.purge];
      case "fixture": return this.#hasFixture ? this.fixture.all : [];
      case "units": return [this.type, this.decoder, ...this.slotFields, ...this.powerSwitch.fields];
      case "site": return [...this.site, ...this.room];
      case "alarms": return this.alarms.fields;
      default: return [this.user];
    }
  }

  /** Whether gravity will be known: given, or by latitude and height. */
  get knowsGravity() {
    const [latitude, , gravity] = this.site.map(({ value }) => value !== "");
    return gravity || latitude;
  }

  /** Whether somebody has said from which temperature on dew forms. */
  get knowsDewPoint() {
    return this.room[0].value !== "";
  }

  keepSecrets(kept) {
    this.alarms.keepSecrets(kept);
  }

  /** The body of POST /api/v1/setup/check. */
  entered() {
    const site = Object.assign({}, ...this.site.map((field) => field.member()));
    const room = Object.assign({}, ...this.room.map((field) => field.member()));
    const purge = this.purge.member();
    return {
      chamber: this.chamber.entered(),
      ...(this.#hasFixture ? { fixture: this.fixture.entered() } : {}),
      ...(Object.keys(site).length > 0 ? { site } : {}),
      ...(Object.keys(room).length > 0 ? { room } : {}),
      ...(Object.keys(purge).length > 0 ? { purge } : {}),
      ...this.powerSwitch.entered(),
      ...this.alarms.entered(),
      unit_type: this.type.value,
      decoder: this.decoder.value,
      slots: this.#slots.map((slot) => slot.entered()),
    };
  }

  /** All fields, each behind those that it follows. */
  get #all() {
    return [...this.chamber.all, this.kind, ...this.fixture.all, this.type, this.decoder, ...this.slotFields, ...this.powerSwitch.all, this.purge, ...this.site, ...this.room, ...this.alarms.all, this.user];
  }

  /** What stands in all fields, those that are not seen among them, but no secret: for fill(). */
  values() {
    return { slots: this.#slots.length, fields: Object.fromEntries(this.#all.filter(({ isSecret }) => !isSecret).map(({ name, input }) => [name, input.value])) };
  }

  /** @param {{slots: number, fields: Record<string, string>}} values */
  fill({ slots, fields }) {
    while (this.#slots.length < Math.min(slots, MOST_SLOTS)) this.#addSlot();
    for (const { name, input } of this.#all) {
      if (!Object.hasOwn(fields, name)) continue;
      if (input instanceof HTMLSelectElement && ![...input.options].some(({ value }) => value === fields[name])) continue;
      input.value = fields[name];
      for (const kind of ["input", "change"]) input.dispatchEvent(new Event(kind, { bubbles: true }));
    }
  }

  /** Asks the units themselves who they are. */
  async look() {
    await this.#slotLook.ask("");
  }

  async #askSlots() {
    const { mail, webhook, site, room, purge, ...devices } = this.entered();
    return post("setup/look", devices);
  }

  /**
   * Whether nothing is plainly wrong in these fields; what is stands at them, and the first one is in hand.
   * @param {Field[]} fields
   */
  checkAll(fields) {
    for (const field of fields) field.clear();
    const wrong = fields.filter((field) => !field.check());
    wrong[0]?.input.focus();
    return wrong.length === 0;
  }

  /** The field that a member of the body is entered in: its own, or the first of the part that it names. */
  #fieldOf(name) {
    const all = STEPS.flatMap((step) => this.#fieldsOf(step));
    return all.find((field) => field.name === name) ?? all.find((field) => name !== "" && field.name.startsWith(`${name}.`) && !field.node.hidden);
  }

  /**
   * Tells the mistakes that the station has found, and those that are plain to see, each at its field.
   * @param {{field: string, message: string}[]} mistakes
   * @param {string[]} steps of the others nothing is told: nobody has come to them yet
   */
  tell(mistakes, steps) {
    const fields = steps.flatMap((step) => this.#fieldsOf(step));
    for (const field of fields) field.clear();
    this.#others = [];
    for (const { field: name, message } of mistakes) {
      const field = this.#fieldOf(name);
      if (!field) this.#others.push({ field: name, message });
      else if (fields.includes(field)) field.tell(said(message));
    }
    // Last, since these are in the language of the page.
    for (const field of fields) field.check();
  }

  /**
   * The same of a command that the station has refused.
   * @returns {{step: string, field: Field} | null} where it stands; null: the refusal names no field
   */
  tellRefusal(error) {
    const field = error.where ? this.#fieldOf(error.where) : undefined;
    if (!field) return null;
    field.tell(said(error.message));
    field.input.focus();
    return { step: STEPS.find((step) => this.#fieldsOf(step).includes(field)) ?? "", field };
  }

  /** @returns {Field | null} the first field of a step at which a mistake stands */
  firstMistake(step) {
    return this.#fieldsOf(step).find(({ input }) => input.hasAttribute("aria-invalid")) ?? null;
  }

  /** All mistakes that stand at fields, and the others. */
  faults() {
    const atFields = STEPS.flatMap((step) => this.#fieldsOf(step).filter(({ input }) => input.hasAttribute("aria-invalid")).map((field) => ({ step, field, parts: field.told() })));
    return [...atFields, ...this.#others.map(({ message }) => ({ step: "", field: null, parts: [said(message)] }))];
  }
}
