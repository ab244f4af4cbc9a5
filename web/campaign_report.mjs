// SPDX-License-Identifier: Apache-2.0
// The report of a campaign: the button in its head, what the job that makes it is at, and the file.

import { looksForJobs, post } from "./api.mjs";
import { $, element, say, tell } from "./dom.mjs";
import { fileLink } from "./file_link.mjs";
import { clock } from "./format.mjs";
import { R } from "./run_words.mjs";

const KIND = "report_campaign";
const LOOK_AGAIN_MS = 1000;
const LOOKS_AT_OTHERS = 10; // every so many times where no job is known to run

export class CampaignReports {
  #userName;
  /** @type {import("./documents.mjs").Job[]} */
  #jobs = []; // the newest first
  /** @type {Map<string, string>} */
  #refused = new Map(); // campaign → why the station did not begin its report
  #said = ""; // what the parts on the page say

  /** `userName()`: who asks for a report. */
  constructor(userName) {
    this.#userName = userName;
    let ticks = 0;
    setInterval(() => {
      const isDue = ++ticks % LOOKS_AT_OTHERS === 0; // somebody else may have started one
      if (!$("runs-view").hidden && !document.hidden && (isDue || this.#running !== null)) this.look();
    }, LOOK_AGAIN_MS);
  }

  look = looksForJobs((jobs) => {
    this.#jobs = jobs;
    this.#show();
  });

  get #running() {
    return this.#jobs.find(({ state }) => state === "running") ?? null;
  }

  /**
   * A button, and what became of the newest report; they stay up to date for as long as they are on the page.
   * @param {string} campaign
   */
  partsOf(campaign) {
    const button = Object.assign(element("button", R.report.button), { type: "button", className: "small" });
    button.dataset.needs = "operator";
    button.dataset.report = campaign;
    button.setAttribute("aria-label", R.report.of(campaign));
    button.addEventListener("click", () => this.#start(campaign));
    const news = Object.assign(element("span", ""), { className: "why" });
    news.dataset.reportOf = campaign;
    this.#showOf(button, news);
    return [Object.assign(element("span", ""), { className: "grow" }), news, button];
  }

  async #start(campaign) {
    this.#refused.delete(campaign);
    say($("runs-report-news"), R.report.asked);
    try {
      await post("jobs", { kind: KIND, campaign, user: this.#userName() });
    } catch (error) {
      this.#refused.set(campaign, error.message);
    }
    await this.look();
    this.#show();
  }

  /** Anew only where it says something else: somebody may be about to press a download. */
  #show() {
    const said = JSON.stringify([this.#running?.id, this.#jobs.filter(({ kind }) => kind === KIND).map(({ id, state }) => [id, state]), [...this.#refused]]);
    if (said === this.#said) return;
    this.#said = said;
    for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll("#runs-campaigns [data-report]"))) {
      this.#showOf(button, /** @type {HTMLElement} */ (button.previousElementSibling));
    }
  }

  /**
   * @param {HTMLButtonElement} button
   * @param {HTMLElement} news
   */
  #showOf(button, news) {
    const campaign = button.dataset.report;
    const job = this.#jobs.find((one) => one.kind === KIND && one.campaign === campaign) ?? null;
    button.disabled = this.#running !== null;
    const refused = this.#refused.get(campaign);
    if (refused !== undefined) tell(news, [R.report.failed, { english: refused }]);
    else if (job === null) say(news, "");
    else if (job.state === "running") say(news, R.report.running);
    else if (job.file) news.replaceChildren(R.report.made(clock(job.ended_utc_s), job.user), fileLink(job));
    else tell(news, [R.report.failed, { english: job.message }]);
    if (job !== null && job.state !== "running" && !$("runs-view").hidden) say($("runs-report-news"), news.textContent);
  }
}
