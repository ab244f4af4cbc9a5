// SPDX-License-Identifier: Apache-2.0
// All stored runs by campaign.

import { asksAhead } from "./ahead.mjs";
import { get } from "./api.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { shortDuration, timeOfDay, UNKNOWN } from "./format.mjs";
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

export class RunsView {
  #status = null;
  #shownFor = null; // what the station was doing by its last status
  #stale = false; // a run may have ended since the list was loaded
  #runs = [];
  #campaigns = new Map();
  #notListed = 0;

  constructor() {
    for (const id of ["runs-find", "runs-counting"]) $(id).addEventListener("input", () => this.#render());
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
      const [{ runs, not_listed }, { campaigns }] = await Promise.all([get("runs"), get("stored")]);
      this.#runs = runs;
      this.#notListed = not_listed;
      this.#campaigns = new Map(campaigns.map((campaign) => [campaign.name, campaign]));
      this.#render();
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

  #wanted(run) {
    const words = $("runs-find").value.trim().toLowerCase().split(/\s+/);
    const text = `${run.campaign} ${run.run} ${run.unit} ${run.procedure} ${run.purpose}`.toLowerCase();
    return words.every((word) => text.includes(word)) && (!$("runs-counting").checked || counts(run));
  }

  #render() {
    const runs = this.#runs.filter((run) => this.#wanted(run));
    const groups = new Map();
    for (const run of runs) groups.set(run.campaign, [...(groups.get(run.campaign) ?? []), run]);
    $("runs-campaigns").replaceChildren(...[...groups].map(([name, those], i) => this.#campaignCard(name, those, i)));
    const none = this.#runs.length === 0 ? R.list.none : R.list.noneFits;
    say($("runs-nothing"), runs.length === 0 ? none : R.list.count(runs.length));
    show($("runs-more"), this.#notListed > 0);
    say($("runs-more"), R.list.notListed(this.#notListed));
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
    const about = Object.assign(element("p", runs[0].procedure), { className: "about" });
    if (campaign?.reason) about.append(runs[0].procedure ? " · " : "", english(campaign.reason));
    card.append(head, about, this.#table(runs, title.id));
    return card;
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
