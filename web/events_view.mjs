// SPDX-License-Identifier: Apache-2.0
// The event log, newest first, by kind, subject, user and time; and whether it is as it was written.

import { get } from "./api.mjs";
import { $, element, english, say, show, tell } from "./dom.mjs";
import { clock, count } from "./format.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_events_en.mjs").text} */
const E = await textsOf("events");

/** Where the event log about a unit, a run or a campaign is. */
const eventsAddress = (asked) => `#${new URLSearchParams({ events: "", ...asked })}`;

const FIELDS = ["kind", "subject", "user", "from", "to"];

export class EventsView {
  #asked = ""; // the question, without the page
  #oldest = null; // number of the last event shown
  #opened = 0; // counts the requests: only the answer to the last one is shown

  constructor() {
    $("audit-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const address = eventsAddress(Object.fromEntries(FIELDS.map((name) => [name, $(`audit-${name}`).value.trim()]).filter(([, value]) => value !== "")));
      if (address === location.hash) this.#load();
      else location.hash = address;
    });
    $("audit-form").addEventListener("reset", () => { location.hash = "#events"; });
    $("audit-older").addEventListener("click", () => this.#older());
    $("chain-check").addEventListener("click", () => this.#check());
  }

  async open(parameters) {
    for (const name of FIELDS) {
      const value = parameters.get(name) ?? "";
      if (name === "kind" && ![...$("audit-kind").options].some((option) => option.value === value)) this.#addKind(value);
      $(`audit-${name}`).value = value;
    }
    await this.#load();
  }

  #addKind(kind) {
    $("audit-kind").append(Object.assign(element("option", kind), { value: kind, lang: "en" }));
  }

  #question() {
    const question = new URLSearchParams();
    for (const name of ["kind", "subject", "user"]) if ($(`audit-${name}`).value.trim()) question.set(name, $(`audit-${name}`).value.trim());
    for (const name of ["from", "to"]) if ($(`audit-${name}`).value) question.set(`${name}_utc_s`, String(new Date($(`audit-${name}`).value).getTime() / 1000));
    return question;
  }

  async #load() {
    this.#asked = this.#question().toString();
    this.#oldest = null;
    // Events that another question found must not stand below this one.
    $("audit").tBodies[0].replaceChildren();
    for (const id of ["audit", "audit-older"]) show($(id), false);
    say($("audit-nothing"), "");
    const page = await this.#page();
    if (page === null) return;
    const known = new Set([...$("audit-kind").options].map(({ value }) => value));
    for (const kind of page.kinds) if (!known.has(kind)) this.#addKind(kind);
    $("audit-users").replaceChildren(...page.users.map((user) => new Option("", user)));
    $("audit").tBodies[0].replaceChildren(...page.events.map(eventRow));
    show($("audit"), page.events.length > 0);
    say($("audit-nothing"), page.events.length === 0 ? E.none : "");
  }

  async #older() {
    const page = await this.#page();
    if (page === null) return;
    const first = eventRow(page.events[0]);
    first.tabIndex = -1;
    $("audit").tBodies[0].append(first, ...page.events.slice(1).map(eventRow));
    first.focus(); // the button may go away, and reading goes on here
  }

  /** The next page of what was asked for; null where it did not come, or something else is asked for by now. */
  async #page() {
    const mine = ++this.#opened;
    const question = new URLSearchParams(this.#asked);
    if (this.#oldest !== null) question.set("before", String(this.#oldest));
    show($("audit-failure"), false);
    $("audit-older").disabled = true;
    try {
      const page = await get(`audit?${question}`);
      if (mine !== this.#opened) return null;
      this.#oldest = page.events.at(-1)?.number ?? this.#oldest;
      show($("audit-older"), page.has_older);
      return page;
    } catch (error) {
      if (mine !== this.#opened) return null;
      say($("audit-failure"), error.message);
      show($("audit-failure"), true);
      return null;
    } finally {
      if (mine === this.#opened) $("audit-older").disabled = false;
    }
  }

  async #check() {
    const result = $("chain-result");
    $("chain-check").disabled = true;
    result.dataset.state = "";
    say(result, E.chain.reading);
    show(result, true);
    try {
      const { ok, events, chain_sha256: end, problem, where } = await get("audit/check");
      result.dataset.state = ok ? "finished" : "failed";
      tell(result, [ok ? E.chain.whole(count(events), end) : { english: `${where}: ${problem}` }]);
    } catch (error) {
      result.dataset.state = "waiting";
      tell(result, [E.chain.notChecked, { english: error.message }]);
    }
    $("chain-check").disabled = false;
  }
}

function eventRow({ utc_s, kind, subject, user, text }) {
  const row = element("tr", "");
  const time = element("td", "");
  time.append(Object.assign(element("time", clock(utc_s)), { dateTime: new Date(utc_s * 1000).toISOString() }));
  const own = (words) => {
    const cell = element("td", "");
    cell.append(english(words));
    return cell;
  };
  row.append(time, own(kind), element("td", subject), element("td", user ?? E.notRecorded), own(text));
  // On a narrow screen the style sheet makes blocks of them, which are no row and cells by themselves.
  row.role = "row";
  for (const cell of row.cells) cell.role = "cell";
  return row;
}
