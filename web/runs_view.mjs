// SPDX-License-Identifier: Apache-2.0
// All stored runs by campaign.

import { asksAhead } from "./ahead.mjs";
import { get } from "./api.mjs";
import { CampaignReports } from "./campaign_report.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { clock, shortDuration, timeOfDay, UNKNOWN } from "./format.mjs";
import { campaignState, counts, marksOf, R, segmentsText } from "./run_words.mjs";
import { loadDygraphs } from "./strip_panel.mjs";
import { isActive, now_s } from "./words.mjs";

/** A mark in the colours of its state. */
export function badge({ text, state }) {
  const node = element("span", text);
  node.className = state === "simulated" ? "badge simulated" : "badge";
  if (state) node.dataset.state = state;
  return node;
}

const WAIT_FOR_TYPING_MS = 300;
const MOST_ASKED = 8; // campaigns or units whose older runs are asked for at once

export class RunsView {
  #status = null;
  #shownFor = null; // what the station was doing by its last status
  #stale = false; // a run may have ended since the list was loaded
  #runs = [];
  #campaigns = new Map();
  #units = []; // serial numbers of all units
  #listed = 0; // runs that the list itself had
  #notListed = 0; // and those that it left out
  #older = new Set(); // questions for older runs that were asked: "campaign=c1"
  #typing = 0;
  #reports;

  /** `userName()`: who asks for a report. */
  constructor(userName) {
    this.#reports = new CampaignReports(userName);
    for (const id of ["runs-find", "runs-counting"]) $(id).addEventListener("input", () => this.#render());
    $("runs-find").addEventListener("input", () => {
      clearTimeout(this.#typing);
      this.#typing = setTimeout(() => this.#findOlder(), WAIT_FOR_TYPING_MS);
    });
  }

  /** The newest status document. A run that has ended is in the list the next time it is looked at, or at once. */
  take(status) {
    this.#status = status;
    const about = `${status.state} ${status.campaign?.name} ${status.campaign?.run}`;
    this.#stale ||= this.#shownFor !== null && about !== this.#shownFor;
    this.#shownFor = about;
    this.#sayWhatIsRecorded();
    if (this.#stale && !$("runs-view").hidden) this.open();
  }

  async open() {
    this.#stale = false;
    show($("runs-failure"), false);
    try {
      const [{ runs, not_listed }, { campaigns, units }] = await Promise.all([get("runs"), get("stored")]);
      this.#runs = runs;
      this.#listed = runs.length;
      this.#notListed = not_listed;
      this.#units = units.map(({ serial }) => serial);
      this.#older.clear();
      this.#campaigns = new Map(campaigns.map((campaign) => [campaign.name, campaign]));
      this.#render();
      this.#findOlder();
      this.#reports.look();
      // A run will be looked at next.
      loadDygraphs();
      import("./run_view.mjs");
    } catch (error) {
      say($("runs-failure"), error.message);
      show($("runs-failure"), true);
    }
  }

  #sayWhatIsRecorded() {
    const { campaign } = this.#status;
    const records = campaign && isActive(this.#status);
    show($("runs-recording"), Boolean(records));
    if (records) say($("runs-recording"), R.list.recording(campaign.run_label, campaign.name));
  }

  get #words() {
    return $("runs-find").value.trim().toLowerCase().split(/\s+/).filter(Boolean);
  }

  #wanted(run) {
    const text = `${run.campaign} ${run.run} ${run.unit} ${run.procedure} ${run.purpose}`.toLowerCase();
    return this.#words.every((word) => text.includes(word)) && (!$("runs-counting").checked || counts(run));
  }

  /** Whether a campaign is shown of which no run is: what was found is about its runs, unless it names the campaign itself. */
  #wantedWithout({ name, procedure }) {
    const isEmpty = !this.#runs.some(({ campaign }) => campaign === name);
    return isEmpty && !$("runs-counting").checked && this.#words.every((word) => `${name} ${procedure ?? ""}`.toLowerCase().includes(word));
  }

  /** Of the list only the newest runs are there: of what is looked for the older ones are asked for by campaign or unit. */
  async #findOlder() {
    const words = this.#words;
    if (this.#notListed === 0 || words.length === 0) return;
    const fits = (name) => words.some((word) => name.toLowerCase().includes(word));
    await this.#ask("campaign", [...this.#campaigns.keys()].filter(fits).slice(0, MOST_ASKED));
    await this.#ask("unit", this.#units.filter(fits).slice(0, MOST_ASKED));
  }

  /** Adds the runs of these campaigns or units, where that has not been done. */
  async #ask(what, names) {
    for (const name of names) {
      const question = String(new URLSearchParams({ [what]: name }));
      if (this.#older.has(question)) continue;
      this.#older.add(question);
      try {
        const { runs } = await get(`runs?${question}`);
        const key = ({ run_id, unit }) => `${run_id} ${unit}`;
        const known = new Set(this.#runs.map(key));
        this.#runs = [...this.#runs, ...runs.filter((run) => !known.has(key(run)))];
        this.#render();
      } catch (error) {
        this.#older.delete(question);
        say($("runs-failure"), error.message);
        show($("runs-failure"), true);
      }
    }
  }

  #render() {
    const runs = this.#runs.filter((run) => this.#wanted(run));
    const groups = new Map();
    for (const campaign of this.#campaigns.values()) if (this.#wantedWithout(campaign)) groups.set(campaign.name, []);
    for (const run of runs) groups.set(run.campaign, [...(groups.get(run.campaign) ?? []), run]);
    const order = new Map([...this.#campaigns.keys()].map((name, i) => [name, i]));
    const sorted = [...groups].sort(([a], [b]) => (order.get(a) ?? order.size) - (order.get(b) ?? order.size));
    $("runs-campaigns").replaceChildren(...sorted.map(([name, those], i) => this.#campaignCard(name, those, i)));
    const none = this.#runs.length === 0 && groups.size === 0 ? R.list.none : R.list.noneFits;
    say($("runs-nothing"), groups.size === 0 ? none : runs.length === 0 ? R.list.campaigns(groups.size) : R.list.count(runs.length));
    const notHere = this.#notListed - (this.#runs.length - this.#listed);
    show($("runs-more"), notHere > 0);
    say($("runs-more"), R.list.notListed(notHere));
  }

  #campaignCard(name, runs, index) {
    const card = element("section", "");
    card.className = "card";
    const title = element("h3", name);
    title.id = `campaign-${index}`;
    card.setAttribute("aria-labelledby", title.id);
    const head = element("div", "");
    head.className = "row";
    const campaign = this.#campaigns.get(name);
    const state = campaign?.state ?? null;
    head.append(title, badge({ text: campaignState(state), state: state ?? "" }));
    if (runs.length > 0 || campaign?.runs > 0) head.append(...this.#reports.partsOf(name));
    const procedure = runs[0]?.procedure ?? campaign?.procedure ?? "";
    const begun = campaign?.begun_utc_s ?? null;
    const facts = [procedure, begun === null ? "" : R.list.begun(clock(begun))].filter(Boolean);
    const about = Object.assign(element("p", facts.join(" · ")), { className: "about" });
    if (campaign?.reason) about.append(facts.length > 0 ? " · " : "", english(campaign.reason));
    card.append(head, about, runs.length > 0 ? this.#table(runs, title.id) : this.#withoutRuns(name, campaign.runs));
    return card;
  }

  /** A campaign of which no run is there: it has none, or they are older than those of the list. */
  #withoutRuns(name, runs) {
    const isAllHere = this.#notListed === 0;
    const text = Object.assign(element("p", isAllHere ? R.list.noRuns : runs === 0 ? "" : `${R.list.notLoaded(runs)} `), { className: "about" });
    if (isAllHere || this.#older.has(String(new URLSearchParams({ campaign: name })))) return text;
    const more = Object.assign(element("button", R.list.older), { type: "button", className: "small" });
    more.addEventListener("click", () => this.#ask("campaign", [name]));
    text.append(more);
    return text;
  }

  #table(runs, titleId) {
    const table = element("table", "");
    table.className = "list runs";
    table.setAttribute("aria-labelledby", titleId);
    const heads = element("tr", "");
    heads.append(...R.list.heads.map((text) => Object.assign(element("th", text), { scope: "col" })));
    table.createTHead().append(heads);
    table.createTBody().append(...runs.map((run) => this.#row(run)));
    return table;
  }

  #row(run) {
    const row = element("tr", "");
    const link = element("a", run.run);
    const place = new URLSearchParams({ run: run.run_id, unit: run.unit });
    link.href = `#${place}`;
    asksAhead(link, `run?${place}`);
    const name = element("td", "");
    name.append(link);
    const marks = element("td", "");
    marks.append(...marksOf(run).map(badge));
    if (run.void) marks.append(Object.assign(element("p", `${run.void.reason} (${run.void.user})`), { className: "why" }));
    const when = run.created_utc_s > 0 ? timeOfDay(run.created_utc_s, this.#status ? now_s(this.#status) : Date.now() / 1000) : UNKNOWN;
    const cells = [run.unit, when, shortDuration(run.duration_s), segmentsText(run.segments)];
    row.append(name, ...cells.map((text) => element("td", text)), marks);
    return row;
  }
}
