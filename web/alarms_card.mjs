// SPDX-License-Identifier: Apache-2.0
// Who is told of alarms when nobody looks at the page, and whether that works: a test.

import { get, post } from "./api.mjs";
import { $, element, say, show } from "./dom.mjs";
import { clock } from "./format.mjs";

const WAYS = { mail: "Mail to", webhook: "Webhook at" };

/** @param {import("./documents.mjs").AlarmWay} way */
function wayLine({ way, to, waiting, trouble, sent_utc_s }) {
  const line = element("li", "");
  const last = sent_utc_s === null ? "nothing sent yet" : `last sent ${clock(sent_utc_s)}`;
  line.append(element("span", `${WAYS[way] ?? way} ${to}: ${last}`));
  if (waiting > 0) line.append(element("span", `, ${waiting} waiting`));
  if (trouble) line.append(Object.assign(element("p", trouble), { className: "bad" }));
  return line;
}

export class AlarmsCard {
  #userName;

  /** `userName()`: who asks for a test. */
  constructor(userName) {
    this.#userName = userName;
    $("alarms-test").addEventListener("click", () => this.#test());
  }

  async open() {
    say($("alarms-news"), "");
    await this.#tell(() => this.#show());
  }

  async #show() {
    const { ways } = await get("alarms");
    $("alarms-ways").replaceChildren(...ways.map(wayLine));
    show($("alarms-ways"), ways.length > 0);
    show($("alarms-test"), ways.length > 0);
    show($("alarms-none"), ways.length === 0);
  }

  async #test() {
    $("alarms-test").disabled = true;
    say($("alarms-news"), "Sending…");
    await this.#tell(async () => {
      const { ways } = await post("alarms/test", { user: this.#userName() });
      const sent = ways.filter(({ trouble }) => trouble === null).map(({ way, to }) => `${WAYS[way] ?? way} ${to}`);
      say($("alarms-news"), sent.length ? `The server has taken it: ${sent.join("; ")}. Look whether it arrives.` : "");
      const troubles = ways.filter(({ trouble }) => trouble !== null).map(({ way, to, trouble }) => `${WAYS[way] ?? way} ${to}: ${trouble}`);
      if (troubles.length) throw new Error(troubles.join("; "));
    });
    $("alarms-test").disabled = false;
  }

  /** Carries out; the card says why where that fails. */
  async #tell(work) {
    show($("alarms-failure"), false);
    try {
      await work();
    } catch (error) {
      if ($("alarms-news").textContent === "Sending…") say($("alarms-news"), "");
      say($("alarms-failure"), error.message);
      show($("alarms-failure"), true);
    }
  }
}
