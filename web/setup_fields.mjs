// SPDX-License-Identifier: Apache-2.0
// Fields of the page on which a station is set up: each with its label, a hint, and the mistake that is told at it.

import { element, english, show } from "./dom.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

/** What the server takes in a member that is a number. */
const WHOLE = /^\d{1,9}$/;
const DECIMAL = /^[-−]?\d{1,6}([.,]\d{1,9})?$/;
/** As somebody has typed it, in either language. */
const decimal = (text) => Number(text.replace(",", ".").replace("−", "-"));

/**
 * @typedef {object} FieldKind
 * @property {Record<string, string>} [options] value to text: a list to choose from
 * @property {string} [hint]
 * @property {string} [list] id of a list that is offered
 * @property {boolean} [whole] a whole number
 * @property {boolean} [decimal] a number
 * @property {boolean} [needed]
 * @property {"seen" | "hidden"} [secret] a line for soakd alone, whether others may see it while it is typed; it does not outlive the page
 * @property {string} [value]
 */

/** A field whose name is that of the member of the body that it gives: "chamber.host". */
export class Field {
  #kind;
  #mistake = element("p", "");
  #hint = element("p", "");

  /**
   * @param {string} name
   * @param {string} label
   * @param {FieldKind} kind
   */
  constructor(name, label, kind = {}) {
    this.name = name;
    /** How the field is called where it is not seen. */
    this.title = label;
    this.#kind = kind;
    const id = name.replaceAll(".", "-");
    /** @type {HTMLInputElement | HTMLSelectElement} */
    this.input = kind.options ? document.createElement("select") : document.createElement("input");
    this.input.id = id;
    this.offer(kind.options ?? {});
    if (this.input instanceof HTMLInputElement) this.#type(kind);
    if (kind.value !== undefined) this.input.value = kind.value;
    Object.assign(this.#mistake, { id: `${id}-mistake`, className: "mistake" });
    Object.assign(this.#hint, { id: `${id}-hint`, className: "hint" });
    this.hint(kind.hint ?? "");
    this.input.setAttribute("aria-describedby", `${id}-mistake ${id}-hint`);
    if (kind.needed) this.input.required = true;
    const caption = element("label", label);
    caption.append(this.input);
    this.node = document.createElement("div");
    this.node.append(caption, this.#mistake, this.#hint);
    this.input.addEventListener("input", () => this.clear());
  }

  /** @param {FieldKind} kind */
  #type({ list, whole, secret }) {
    Object.assign(this.input, { type: secret === "hidden" ? "password" : "text", maxLength: secret ? 2000 : 200, autocomplete: secret ? "new-password" : "off", spellcheck: false });
    if (list) this.input.setAttribute("list", list);
    if (whole) this.input.inputMode = "numeric";
  }

  /** @param {Record<string, string>} options what there is to choose from; what was chosen stays so where it is among them */
  offer(options) {
    if (!(this.input instanceof HTMLSelectElement)) return;
    const chosen = this.input.value;
    this.input.replaceChildren(...Object.entries(options).map(([value, text]) => new Option(text, value, false, value === chosen)));
  }

  /** Whether something must be entered here. */
  need(needed) {
    this.#kind = { ...this.#kind, needed };
    this.input.required = needed;
  }

  hint(text) {
    this.#hint.textContent = text;
    show(this.#hint, text !== "");
  }

  get value() {
    return this.input.value.trim();
  }

  set value(text) {
    this.input.value = text;
  }

  show(visible) {
    show(this.node, visible);
  }

  /** Whether what stands there is for soakd alone. */
  get isSecret() {
    return this.#kind.secret !== undefined;
  }

  /** Tells a mistake at the field; `parts`: the page's own words, or nodes of what the station says. */
  tell(...parts) {
    this.#mistake.replaceChildren(...parts);
    this.input.setAttribute("aria-invalid", "true");
    const fold = this.node.closest("details");
    if (fold) fold.open = true; // nothing that is wrong is hidden
  }

  /** What stands there, to be shown elsewhere, too. */
  told() {
    return [...this.#mistake.childNodes].map((node) => node.cloneNode(true));
  }

  clear() {
    this.#mistake.replaceChildren();
    this.input.removeAttribute("aria-invalid");
  }

  /** What is plain to see without the station; whether there is nothing. */
  check() {
    if (this.node.hidden) return true;
    if (this.#kind.needed && this.value === "") this.tell(S.needed);
    else if (this.#kind.whole && this.value !== "" && !WHOLE.test(this.value)) this.tell(S.notWhole);
    else if (this.#kind.decimal && this.value !== "" && !DECIMAL.test(this.value)) this.tell(S.notANumber);
    else return true;
    return false;
  }

  /** The member of a body: absent where nothing is entered, or nothing that can be one. */
  member() {
    const key = this.name.split(".").at(-1);
    if (this.node.hidden || this.value === "") return {};
    if (this.#kind.decimal) return DECIMAL.test(this.value) ? { [key]: decimal(this.value) } : {};
    if (!this.#kind.whole) return { [key]: this.value };
    return WHOLE.test(this.value) ? { [key]: Number(this.value) } : {};
  }
}

/** Where a device is reached: over the network or at a serial port. */
export class AddressFields {
  /**
   * @param {string} owner "chamber", "slots.0"
   * @param {{port?: string, baud?: string, needsPort?: boolean, ports: number}} usual what the station takes where nothing is entered; how many ports it has found
   */
  constructor(owner, { port = "", baud = "", needsPort = false, ports }) {
    this.way = new Field(`${owner}.way`, S.fields.way, { options: S.fields.ways, value: "tcp" });
    this.host = new Field(`${owner}.host`, S.fields.host, { needed: true, hint: S.fields.hostHint });
    this.port = new Field(`${owner}.port`, S.fields.port, { whole: true, needed: needsPort, hint: port && S.fields.usual(port) });
    this.device = new Field(`${owner}.device`, S.fields.device, { needed: true, list: "ports", hint: ports > 0 ? S.fields.deviceHint : S.fields.noDeviceHint });
    this.baud = new Field(`${owner}.baud`, S.fields.baud, { whole: true, hint: baud && S.fields.usual(baud) });
    this.way.input.addEventListener("change", () => this.#showWay());
    this.#showWay();
  }

  get all() {
    return [this.way, this.host, this.port, this.device, this.baud];
  }

  get isSerial() {
    return this.way.value === "serial";
  }

  /** Nobody has answered there: each field that may be wrong is marked. */
  tellNoAnswer(why) {
    if (this.isSerial) return this.device.tell(why, ` ${S.try.noAnswerSerial}`);
    this.host.tell(why, ` ${S.try.noAnswerNetwork}`);
    this.port.tell(S.try.wrongPort);
  }

  /** As people write it. */
  get text() {
    if (this.isSerial) return this.device.value;
    return this.port.value === "" ? this.host.value : `${this.host.value}:${this.port.value}`;
  }

  /** The field that an answer is about which the device did not give. */
  get where() {
    return this.isSerial ? this.device : this.host;
  }

  #showWay() {
    for (const field of [this.host, this.port]) field.show(!this.isSerial);
    for (const field of [this.device, this.baud]) field.show(this.isSerial);
  }

  /** Members of the body. */
  entered() {
    if (this.isSerial) return { device: this.device.value, ...this.baud.member() };
    return { host: this.host.value, ...this.port.member() };
  }
}

/** A controller: its map, its address, and what Modbus adds. */
export class ControllerFields {
  #maps;

  /**
   * @param {string} owner "chamber", "fixture" or "power"
   * @param {import("./kept_documents.mjs").SetupMap[]} maps
   * @param {number} ports
   */
  constructor(owner, maps, ports) {
    this.owner = owner;
    this.#maps = maps;
    const names = Object.fromEntries(maps.map(({ file, name }) => [file, name]));
    this.map = new Field(`${owner}.map`, S.fields.map, { options: { "": S.choose, ...names }, needed: true });
    for (const option of this.map.input.querySelectorAll("option:not([value=''])")) option.setAttribute("lang", "en"); // as the map's file has it
    this.address = new AddressFields(owner, { ports });
    this.parity = new Field(`${owner}.parity`, S.fields.parity, { options: { "": S.fields.asInMap, ...S.fields.parities } });
    this.stopBits = new Field(`${owner}.stop_bits`, S.fields.stop_bits, { options: { "": S.fields.asInMap, 1: "1", 2: "2" }, whole: true });
    this.unit = new Field(`${owner}.unit`, S.fields.unit, { whole: true });
    for (const field of [this.map, this.address.way]) field.input.addEventListener("change", () => this.#follow());
    this.#follow();
  }

  get all() {
    return [this.map, ...this.address.all, this.parity, this.stopBits, this.unit];
  }

  /** What the chosen map has as its own, and which fields there are with it. */
  #follow() {
    const map = this.#maps.find(({ file }) => file === this.map.value);
    const usual = (value) => (value === null || value === undefined ? "" : S.fields.usual(String(value)));
    this.address.port.hint(usual(map?.port));
    this.address.baud.hint(usual(map?.baud));
    this.unit.hint(usual(map?.unit));
    const modbus = map?.protocol === "modbus";
    this.unit.show(modbus);
    for (const field of [this.parity, this.stopBits]) field.show(modbus && this.address.isSerial);
  }

  entered() {
    const more = [this.parity, this.stopBits, this.unit].map((field) => field.member());
    return { map: this.map.value, ...this.address.entered(), ...Object.assign({}, ...more) };
  }
}

/** A place for a unit. */
export class SlotFields {
  /**
   * @param {number} index from 0
   * @param {number} ports
   */
  constructor(index, ports) {
    const owner = `slots.${index}`;
    this.name = new Field(`${owner}.name`, S.units.name, { needed: true, value: String(index + 1) });
    this.address = new AddressFields(owner, { baud: "115200", needsPort: true, ports });
    this.unit = new Field(`${owner}.unit`, S.units.serial, { hint: S.units.serialHint });
    this.output = new Field(`${owner}.power_output`, S.power.output, { whole: true, hint: S.power.outputHint });
    this.supply = [new Field(`${owner}.supply_v`, S.power.volts, { decimal: true, hint: S.power.asSet }), new Field(`${owner}.supply_limit_a`, S.power.amps, { decimal: true, hint: S.power.asSet })];
    this.followPower("hand");
    for (const field of this.all) field.title = `${S.units.slot(index + 1)}, ${field.title}`;
    this.node = Object.assign(document.createElement("fieldset"), { className: "slot-box" });
    const fields = Object.assign(document.createElement("div"), { className: "fields" });
    fields.append(...this.all.map(({ node }) => node));
    this.node.append(element("legend", S.units.slot(index + 1)), fields);
  }

  /** @param {import("./setup_power.mjs").PowerWay} way by which the units are switched */
  followPower(way) {
    this.output.show(way !== "hand");
    for (const field of this.supply) field.show(way === "map");
  }

  get all() {
    return [this.name, ...this.address.all, this.unit, this.output, ...this.supply];
  }

  entered() {
    const power = [this.output, ...this.supply].map((field) => field.member());
    return { name: this.name.value, ...this.address.entered(), ...this.unit.member(), ...Object.assign({}, ...power) };
  }
}

/** What the station says at a field. */
export const said = (message) => english(message);
