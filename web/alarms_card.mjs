// SPDX-License-Identifier: Apache-2.0
// Who is told of alarms when nobody looks at the page, and whether that works: a test.

import { get, post } from "./api.mjs";
import { $, element, english, say, show, tell } from "./dom.mjs";
import { clock } from "./format.mjs";
import { C } from "./records_words.mjs";

/** "Mail to eva@lab.example" */
const nameOf = ({ way, to }) => `${Object.hasOwn(C.alarms.to, way) ? C.alarms.to[way] : way} ${to}`;

/** @param {import("./documents.mjs").AlarmWay} way */
function wayLine(way) {
  const { waiting, trouble, sent_utc_s, test } = way;
  const line = element("li", "");
  const last = sent_utc_s === null ? C.alarms.nothingSent : C.alarms.lastSent(clock(sent_utc_s));
  line.append(element("span", `${nameOf(way)}: ${last}`));
  if (waiting > 0) line.append(element("span", C.alarms.waiting(waiting)));
  if (test) line.append(testLine(test));
  if (trouble && (waiting > 0 || trouble !== test?.trouble)) line.append(Object.assign(element("p", trouble), { className: "bad", lang: "en" }));
  return line;
}

/** @param {NonNullable<import("./documents.mjs").AlarmWay["test"]>} test */
function testLine({ utc_s, user, trouble }) {
  const line = Object.assign(element("p", C.alarms.lastTest(clock(utc_s), user)), { className: trouble === null ? "good" : "bad" });
  line.append(trouble === null ? C.alarms.tookTest : english(trouble));
  return line;
}

/** @param {import("./dom.mjs").Part[]} parts */
function fail(parts) {
  tell($("alarms-failure"), parts);
  show($("alarms-failure"), true);
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
    say($("alarms-news"), C.alarms.sending);
    await this.#tell(async () => {
      const { ways } = await post("alarms/test", { user: this.#userName() });
      const sent = ways.filter(({ trouble }) => trouble === null).map(nameOf);
      say($("alarms-news"), sent.length ? C.alarms.taken(sent.join("; ")) : "");
      const troubled = ways.filter(({ trouble }) => trouble !== null);
      if (troubled.length) fail(troubled.flatMap((way, i) => [`${i ? "; " : ""}${nameOf(way)}: `, { english: way.trouble }]));
      try {
        await this.#show();
      } catch (error) {
        if (troubled.length === 0) throw error; // what became of the test matters more
      }
    });
    $("alarms-test").disabled = false;
  }

  /** Carries out; the card says why where that fails. */
  async #tell(work) {
    show($("alarms-failure"), false);
    try {
      await work();
    } catch (error) {
      if ($("alarms-news").textContent === C.alarms.sending) say($("alarms-news"), "");
      fail([{ english: error.message }]);
    }
  }
}
