// SPDX-License-Identifier: Apache-2.0
// Who is told of alarms, on the page on which a station is set up.

import { post } from "./api.mjs";
import { $, element, english, show } from "./dom.mjs";
import { Field } from "./setup_fields.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_setup_en.mjs").text} */
const S = await textsOf("setup");

/** Ports of mail servers where none is entered (docs/station-config.md). */
const MAIL_PORTS = { starttls: 587, tls: 465, none: 25 };

/** @param {Field[]} fields */
const membersOf = (fields) => Object.assign({}, ...fields.map((field) => field.member()));

export class AlarmFields {
  constructor() {
    this.wanted = new Field("mail.wanted.choice", S.alarms.wanted, { options: { no: S.alarms.no, yes: S.alarms.yes } });
    const security = new Field("mail.security", S.alarms.security, { options: S.alarms.securities });
    const port = new Field("mail.port", S.fields.port, { whole: true });
    const followSecurity = () => port.hint(S.fields.usual(MAIL_PORTS[security.value]));
    security.input.addEventListener("change", followSecurity);
    followSecurity();
    this.mail = [
      new Field("mail.host", S.alarms.host, { needed: true }), security, port, new Field("mail.from", S.alarms.from, { needed: true }),
      new Field("mail.to", S.alarms.to, { needed: true, hint: S.alarms.toHint }),
    ];
    this.login = [new Field("mail.user", S.alarms.user), new Field("mail.password", S.alarms.password, { secret: "hidden", hint: S.alarms.secretHint })];
    this.hookWanted = new Field("webhook.wanted.choice", S.alarms.webhook, { options: { no: S.alarms.noWebhook, yes: S.alarms.callWebhook } });
    this.hook = [
      new Field("webhook.url", S.alarms.url, { needed: true, secret: "seen", hint: S.alarms.urlHint }),
      new Field("webhook.token", S.alarms.token, { secret: "hidden", hint: S.alarms.tokenHint }),
    ];
    for (const choice of [this.wanted, this.hookWanted]) choice.input.addEventListener("change", () => this.#follow());
    for (const field of this.all) field.input.addEventListener("input", () => $("alarms-answer").replaceChildren());
    this.#follow();
  }

  /**
   * Those that the station has stay where nothing is entered.
   * @param {{password: boolean, url: boolean, token: boolean}} kept
   */
  keepSecrets({ password, url, token }) {
    if (password) this.login[1].hint(S.change.keptPassword);
    if (password) this.login[1].node.closest("details")?.setAttribute("open", "");
    if (url) this.hook[0].need(false);
    if (url) this.hook[0].hint(S.change.keptUrl);
    if (token) this.hook[1].hint(S.change.keptToken);
  }

  get #hasMail() {
    return this.wanted.value === "yes";
  }

  get #hasHook() {
    return this.hookWanted.value === "yes";
  }

  #follow() {
    show($("mail-part"), this.#hasMail);
    show($("webhook-part"), this.#hasHook);
    show($("alarms-test-part"), this.#hasMail || this.#hasHook);
    $("alarms-answer").replaceChildren();
  }

  get all() {
    return [this.wanted, ...this.mail, ...this.login, this.hookWanted, ...this.hook];
  }

  /** Those that count. */
  get fields() {
    return [...(this.#hasMail ? [...this.mail, ...this.login] : []), ...(this.#hasHook ? this.hook : [])];
  }

  /** Members of the body. */
  entered() {
    const mail = membersOf([...this.mail, ...this.login]);
    const to = (mail.to ?? "").split(",").map((address) => address.trim()).filter((address) => address !== "");
    return { ...(this.#hasMail ? { mail: { ...mail, to } } : {}), ...(this.#hasHook ? { webhook: membersOf(this.hook) } : {}) };
  }

  /** Sends a test to all that are entered, and says what became of it; fails where the station has refused to. */
  async test(user, path = "setup") {
    $("alarms-test").disabled = true;
    $("alarms-answer").replaceChildren(S.alarms.sending);
    try {
      this.#tell((await post(`${path}/tell`, { ...this.entered(), user })).ways);
    } catch (error) {
      $("alarms-answer").replaceChildren();
      throw error;
    } finally {
      $("alarms-test").disabled = false;
    }
  }

  /** @param {{way: "mail" | "webhook", to: string, trouble: string | null}[]} ways */
  #tell(ways) {
    $("alarms-answer").replaceChildren(...ways.map(({ way, to, trouble }) => {
      if (trouble === null) return Object.assign(element("p", S.alarms.taken[way](to)), { className: "good" });
      const line = Object.assign(element("p", `${S.alarms.notTaken[way](to)} `), { className: "bad" });
      line.append(english(trouble));
      return line;
    }));
  }
}
