// SPDX-License-Identifier: Apache-2.0
// The event log, newest first, by kind, subject, user and time; and whether it is as it was written.

import { get } from "./api.mjs";
import { $, element, english, say, show, tell } from "./dom.mjs";
import { clock, count } from "./format.mjs";
import { styled } from "./style_sheet.mjs";
import { textsOf } from "./text.mjs";

/** @type {typeof import("./text_events_en.mjs").text} */
const E = await textsOf("events");

/** A kind of event in words. */
const kindText = (kind) => (Object.hasOwn(E.kinds, kind) ? E.kinds[kind] : kind.replaceAll("_", " "));

/** Where the event log about a unit, a run or a campaign is. */
const eventsAddress = (asked) => `#${new URLSearchParams({ events: "", ...asked })}`;

/** Of a run or a certificate. */
const NUMBER = /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/;
const FIELDS = ["kind", "subject", "user", "from", "to"];
/** Kinds that the station enters by itself while it works, where nobody is named. */
const OWN = ["alarm", "alarm_not_sent", "alarm_sent", "campaign", "campaign_failed", "campaign_finished", "campaign_interrupted", "campaign_running", "chamber", "check_standard", "device", "job_ended",
  "journal", "position", "power", "pre-flight", "prompt", "run", "run_added", "run_warning", "segment", "step", "storage", "unit"];

export class EventsView {
  #styled = styled("fleet.css");
  #asked = ""; // the question, without the page
  #oldest = null; // number of the last event shown
  #runs = new Map(); // number → the run, of those that events are about
  /** @type {Map<string, import("./documents.mjs").Reference>} */
  #certificates = new Map(); // number → the certificate, likewise
  #opened = 0; // counts the requests: only the answer to the last one is shown

  constructor() {
    $("audit-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const asked = FIELDS.map((name) => [name, $(`audit-${name}`).value.trim()]).filter(([, value]) => value !== "");
      const address = eventsAddress(Object.fromEntries($("audit-routine").checked ? [...asked, ["routine", "true"]] : asked));
      if (address === location.hash) this.#load();
      else location.hash = address;
    });
    $("audit-form").addEventListener("reset", () => { location.hash = "#events"; });
    $("audit-older").addEventListener("click", () => this.#older());
    $("chain-check").addEventListener("click", () => this.#check());
  }

  async open(parameters) {
    await this.#styled;
    for (const name of FIELDS) {
      const value = parameters.get(name) ?? "";
      if (name === "kind" && ![...$("audit-kind").options].some((option) => option.value === value)) this.#addKind(value);
      $(`audit-${name}`).value = value;
    }
    $("audit-routine").checked = parameters.has("routine");
    await this.#load();
  }

  #addKind(kind) {
    $("audit-kind").append(Object.assign(element("option", kindText(kind)), { value: kind, lang: Object.hasOwn(E.kinds, kind) ? "" : "en" }));
  }

  #question() {
    const question = new URLSearchParams();
    const valueOf = (name) => $(`audit-${name}`).value.trim();
    for (const name of ["kind", "user"]) if (valueOf(name)) question.set(name, valueOf(name));
    if (valueOf("subject")) question.set("about", aboutOf(valueOf("subject")));
    if (!valueOf("kind") && !$("audit-routine").checked) question.set("routine", "false");
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
    $("audit").tBodies[0].replaceChildren(...this.#rows(page.events));
    show($("audit"), page.events.length > 0);
    say($("audit-nothing"), page.events.length === 0 ? E.none : "");
  }

  async #older() {
    const page = await this.#page();
    if (page === null) return;
    const [first, ...others] = this.#rows(page.events);
    first.tabIndex = -1;
    $("audit").tBodies[0].append(first, ...others);
    first.focus(); // the button may go away, and reading goes on here
  }

  /** What happened several times one after the other, in the same words, is one row with the newest time. */
  #rows(events) {
    const gathered = [];
    for (const event of events) {
      const last = gathered.at(-1);
      const isSame = last !== undefined && ["kind", "subject", "user", "text"].every((key) => last.event[key] === event[key]);
      if (isSame) last.times += 1;
      else gathered.push({ event, times: 1 });
    }
    return gathered.map(({ event, times }) => eventRow(event, times, this.#runs.get(event.subject) ?? null, this.#certificates.get(event.subject) ?? null));
  }

  /** Looks up the runs and certificates that events are about, once for each page that has one that is not known. */
  async #lookUp(events) {
    const unknown = events.filter(({ subject }) => NUMBER.test(subject) && !this.#runs.has(subject) && !this.#certificates.has(subject));
    const [references, runs] = [true, false].map((is) => unknown.some(({ kind }) => kind.startsWith("reference_") === is));
    try {
      if (references) for (const entry of (await get("references")).references) this.#certificates.set(entry.record_id, entry);
      if (runs) for (const run of (await get("runs")).runs) this.#runs.set(run.run_id, run);
    } catch (error) {
      console.warn("no names:", error.message); // their numbers stand there then
    }
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
      await this.#lookUp(page.events);
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

/** What somebody has written as the column shows it, as the station knows it: a run by label and campaign, a certificate by its number. */
function aboutOf(text) {
  const [, name] = text.match(E.certificateWritten) ?? [];
  if (name !== undefined) return name;
  const [, label, campaign] = text.match(E.runWritten) ?? [];
  return campaign === undefined ? text : `${label} of ${campaign}`;
}

/** `run`, `certificate`: that it is about; null: about something else, or one that is not listed. */
function eventRow({ utc_s, kind, subject, user, text }, times, run, certificate) {
  const row = element("tr", "");
  const time = element("td", "");
  time.append(Object.assign(element("time", clock(utc_s)), { dateTime: new Date(utc_s * 1000).toISOString() }));
  const own = (words) => {
    const cell = element("td", "");
    cell.append(english(words));
    return cell;
  };
  const about = element("td", run !== null ? "" : certificate !== null ? E.certificate(certificate.name, certificate.certificate) : subject);
  if (run !== null) about.append(Object.assign(element("a", E.run(run.run, run.campaign)), { href: `#${new URLSearchParams({ run: run.run_id, unit: run.unit })}`, title: subject }));
  const what = own(text);
  if (times > 1) what.append(E.times(times));
  row.append(time, Object.hasOwn(E.kinds, kind) ? element("td", E.kinds[kind]) : own(kindText(kind)), about, element("td", user ?? (OWN.includes(kind) ? E.station : E.nobody)), what);
  // On a narrow screen the style sheet makes blocks of them, which are no row and cells by themselves.
  row.role = "row";
  for (const cell of row.cells) cell.role = "cell";
  return row;
}
