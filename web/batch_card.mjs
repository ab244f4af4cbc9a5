// SPDX-License-Identifier: Apache-2.0
// Fit, verification, release and hand-over of all units at once: what there is to do, the job that does it, and what became of the last one.

import { get, looksForJobs, post } from "./api.mjs";
import { $, element, say, show, tell } from "./dom.mjs";
import { clock } from "./format.mjs";
import { endedText, runningText, showShare } from "./job_words.mjs";
import { batchText, messageOf, restOf } from "./batch_words.mjs";
import { fileLink } from "./file_link.mjs";
import { badge } from "./runs_view.mjs";
import { isSure } from "./sure_dialog.mjs";
import { isToReleaseAgain, U } from "./unit_words.mjs";
import { unitAddress } from "./views.mjs";
import { openCampaign } from "./words.mjs";

const LOOK_AGAIN_MS = 1000;
const LOOKS_AT_OTHERS = 10; // every so many times where no job is known to run
const BUTTONS = { fit_all: "units-fit", verify_all: "units-verify", release_all: "units-release", export_all: "units-export" };
const OF_RUNS = "kalibr"; // the one format that is not of a model

export class BatchCard {
  #userName;
  #changed;
  #running = null; // the job that is under way, of whatever unit
  #shown = null; // number of the job of all units that is shown as the last; 0: none; null: nobody has looked
  /** @type {import("./documents.mjs").UnitLine[]} */
  #may = []; // those that may be released
  #can = { fit_all: false, verify_all: false, release_all: false, export_all: false };
  #asked = false; // somebody has asked for a job, and the station has not answered
  #picked = false; // somebody has chosen the campaign to verify with
  #campaigns = []; // those with check runs, the newest first
  /** @type {ReturnType<typeof openCampaign>} */
  #open = null; // the campaign that is not over yet

  /** `userName()`: who is at the page; `changed()`: models or verdicts are others now. */
  constructor(userName, changed) {
    this.#userName = userName;
    this.#changed = changed;
    for (const [kind, button] of Object.entries(BUTTONS)) $(button).addEventListener("click", () => this.#start(kind));
    $("units-format").append(...Object.entries(U.formats).filter(([value]) => value !== OF_RUNS).map(([value, text]) => new Option(text, value)));
    $("units-cancel").addEventListener("click", () => this.#cancel());
    $("units-campaign").addEventListener("change", () => {
      this.#picked = true;
    });
    let ticks = 0;
    setInterval(() => {
      const isDue = ++ticks % LOOKS_AT_OTHERS === 0; // somebody else may have started one
      if (!$("units-view").hidden && !document.hidden && (this.#running || isDue)) this.look();
    }, LOOK_AGAIN_MS);
  }

  /**
   * What can be done, as /api/v1/units says. The station judges again which may be released when it is asked to.
   * @param {import("./documents.mjs").PlainAnswers["units"]} document
   */
  offer({ units, check_campaigns: campaigns }) {
    const toFit = units.filter(({ to_fit }) => to_fit > 0).length;
    const verified = units.filter(({ model }) => model?.state === "verified");
    const may = units.filter(({ model, release }) => (model?.state === "verified" && release?.obstacles.length === 0) || (model?.state === "released" && isToReleaseAgain(release)));
    this.#may = may;
    const notSearched = may.filter(({ gap_searched: isSearched }) => !isSearched).length;
    this.#can = { fit_all: toFit > 0, verify_all: campaigns.length > 0 && units.some(({ model }) => model !== null), release_all: may.length > 0, export_all: units.some(({ model }) => model !== null && (model.state === "released" || model.version > 1)) };
    show($("units-batch"), units.length > 0);
    say($("units-to-fit"), `${U.batch.toFit(toFit)} ${U.batch.leftAlone}`);
    const blocked = verified.filter(({ release }) => release?.obstacles.length !== 0).length;
    say($("units-verified"), U.releaseAll.waiting(may.length) + (blocked > 0 ? U.releaseAll.blocked(blocked) : "") + (notSearched > 0 ? U.releaseAll.notSearched(notSearched) : ""));
    this.#campaigns = campaigns;
    this.#offerCampaigns();
    show($("units-campaign-box"), campaigns.length > 0);
    show($("units-campaign-none"), campaigns.length === 0);
    this.#enable();
  }

  /** @param {import("./documents.mjs").Status} status of a campaign that is not over, which has more check runs to come */
  take(status) {
    const open = openCampaign(status);
    if (open?.name === this.#open?.name && open?.stopped === this.#open?.stopped) return;
    this.#open = open;
    this.#offerCampaigns();
  }

  /** The newest that is over, unless somebody has chosen another one. */
  #offerCampaigns() {
    const names = this.#campaigns.map(({ campaign }) => campaign);
    const chosen = $("units-campaign").value;
    const isOpen = (name) => name === this.#open?.name;
    $("units-campaign").replaceChildren(...this.#campaigns.map(({ campaign, units }) =>
      new Option(U.batch.campaignUnits(campaign, units, isOpen(campaign) ? this.#open : null), campaign)));
    $("units-campaign").value = this.#picked && names.includes(chosen) ? chosen : (names.find((name) => !isOpen(name)) ?? names[0] ?? "");
  }

  #enable() {
    for (const [kind, button] of Object.entries(BUTTONS)) $(button).disabled = this.#asked || this.#running !== null || !this.#can[kind];
  }

  /** Whether those that may be released are to be: with their serial numbers, and what nobody has looked for. */
  #isSureToRelease() {
    const { title, text, unit: line, send } = U.releaseAll.ask;
    const list = this.#may.map(({ unit, model, gap_searched: searched }) => line(unit, model.version, { again: model.state === "released", searched }));
    return isSure({ title: title(list.length), text, list, send });
  }

  async #start(kind) {
    if (kind === "release_all" && !(await this.#isSureToRelease())) return;
    const own = { verify_all: () => ({ campaign: $("units-campaign").value }), export_all: () => ({ format: $("units-format").value, simulated: $("units-simulated").checked }) };
    await this.#ask(kind, "jobs", { kind, ...own[kind]?.(), user: this.#userName() });
  }

  async #cancel() {
    if (this.#running) await this.#ask("cancel", "jobs/cancel", { id: this.#running.id, user: this.#userName() });
  }

  async #ask(what, path, body) {
    const name = what === "cancel" ? U.jobs.cancel : $(BUTTONS[what]).textContent;
    this.#asked = true;
    show($("units-batch-failure"), false);
    // The button is switched off, or goes away: the keyboard goes on from the title.
    if ($("units-batch").contains(document.activeElement)) $("units-batch-title").focus();
    this.#enable();
    try {
      await post(path, body);
    } catch (error) {
      tell($("units-batch-failure"), [U.jobs.refused(name), { english: error.message }]);
      show($("units-batch-failure"), true);
    }
    this.#asked = false;
    await this.look();
    this.#enable();
  }

  /** Which job runs, and which was the last. */
  look = looksForJobs((jobs) => this.#take(jobs));

  async #take(jobs) {
    this.#running = jobs.find(({ state }) => state === "running") ?? null;
    this.#showRunning();
    const last = jobs.find(({ kind, state }) => Object.hasOwn(BUTTONS, kind) && state !== "running");
    const isNews = last !== undefined && last.id !== this.#shown;
    const isFirst = this.#shown === null;
    if (isNews) this.#showLast(await get(`job?${new URLSearchParams({ id: String(last.id) })}`));
    this.#shown = last?.id ?? 0;
    if (isNews && !isFirst) await this.#changed();
    this.#enable();
  }

  #showRunning() {
    const job = this.#running;
    if (job === null && $("units-running").contains(document.activeElement)) $("units-batch-title").focus();
    show($("units-running"), job !== null);
    if (job === null) return;
    say($("units-running-text"), runningText(job, Date.now() / 1000));
    showShare($("units-progress"), job);
  }

  /** @param {import("./documents.mjs").Job} job with what became of each unit */
  #showLast(job) {
    const { title, badge: mark } = endedText(job);
    $("units-last-job").replaceChildren(badge(mark), " ", element("strong", U.batch.last(title)), " ",
      Object.assign(element("span", `${clock(job.ended_utc_s ?? job.started_utc_s)}, ${job.user}`), { className: "why" }));
    if (job.file) $("units-last-job").append(" ", fileLink(job));
    say($("units-last-text"), batchText(job));
    const message = messageOf(job);
    show($("units-last-message"), message !== null);
    say($("units-last-message"), message ?? "");
    $("units-last-rest").replaceChildren(...restOf(job).map(({ unit, parts }) => {
      const line = element("li", "");
      const why = element("span", "");
      tell(why, parts);
      line.append(Object.assign(element("a", unit), { href: unitAddress(unit) }), why);
      return line;
    }));
  }
}
