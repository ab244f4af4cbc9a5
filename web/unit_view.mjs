// SPDX-License-Identifier: Apache-2.0
// One unit: its verdict, what is to be done next, its curves, and the jobs that do it.

import { roleHere } from "./account.mjs";
import { get, isBusy } from "./api.mjs";
import { $, element, english, say, show, tell } from "./dom.mjs";
import { clock, dayText } from "./format.mjs";
import { GapCard } from "./gap_card.mjs";
import { JobPanel } from "./job_panel.mjs";
import { obstacleParts } from "./obstacle_words.mjs";
import { RepairDialog } from "./repair_dialog.mjs";
import { badge } from "./runs_view.mjs";
import { sensorCard } from "./unit_curves.mjs";
import { renderJudged } from "./unit_judged.mjs";
import { badgesOf, headOf, nextForRole, nextOf, sensorText, sortedWarnings, U, verdictNow, verdictText, withSensors } from "./unit_words.mjs";
import { WhenSeen } from "./when_seen.mjs";
import { versionsToWithdraw, WithdrawDialog } from "./withdraw_dialog.mjs";
import { openCampaign, recordedNow } from "./words.mjs";

const PARTS = ["unit-repair", "unit-verdict", "unit-next-box", "unit-facts", "unit-work", "unit-warnings-card", "unit-impact", "unit-gap", "unit-curves", "unit-noise"];
const LOOK_AGAIN_MS = 5000; // whether somebody has done something elsewhere, in a terminal too
/** What a campaign enters by the hundred: nothing that the page shows becomes other by it. */
const ROUTINE = ["position", "power", "segment", "step"];
/** What takes data away that points and noise are made of. */
const TAKES_DATA = ["voided", "samples_dropped"];
const MOST_EVENTS = 500; // that the station tells at once

export class UnitView {
  #asked = null; // serial number that the address names
  #unit = null; // its document
  #older = null; // the document of the model beside the newest one
  /** @type {Record<string, import("./documents.mjs").SensorRows>} */
  #rows = {}; // the points of the newest model, once they are there
  #points = new WhenSeen($("unit-curves"), (isLate) => this.#loadPoints(isLate));
  #noise = new WhenSeen($("unit-noise"), async (isLate) => (await import("./unit_noise.mjs")).showNoise(this.#asked, isLate));
  #recorded = null; // what was recorded when the last status came
  /** @type {import("./unit_words.mjs").OpenCampaign | null} */
  #open = null; // the campaign that is not over yet
  #planned = ""; // for which state of which campaign the plan was asked
  #repair;
  #withdraw;
  #newest = null; // number of the newest event that was looked at; null before the first look
  #taken = 0; // number of an event by which data may be gone
  #gap;
  #jobs;

  /** `userName()`: who starts a job. */
  constructor(userName) {
    this.#gap = new GapCard((kind, members) => this.#jobs.start(kind, members));
    this.#jobs = new JobPanel(userName, () => this.#load(), (busy, job) => this.#gap.wait(busy, job));
    this.#repair = new RepairDialog(() => this.#load());
    $("unit-repair").addEventListener("click", () => this.#repair.open(this.#unit.unit, userName()));
    this.#withdraw = new WithdrawDialog(() => this.#load());
    $("unit-withdraw").addEventListener("click", () => this.#withdraw.open(this.#unit, userName()));
    setInterval(() => {
      if (!$("unit-view").hidden && !document.hidden && this.#asked) this.#lookForEvents();
    }, LOOK_AGAIN_MS);
    $("unit-older").addEventListener("change", () => this.#compare());
  }

  /**
   * A run that has ended may be one to fit or to verify with.
   * @param {import("./documents.mjs").Status} status
   */
  take(status) {
    const before = this.#recorded;
    this.#recorded = recordedNow(status);
    if (before !== null && before !== this.#recorded && !$("unit-view").hidden) this.#load();
    this.#heed(status);
  }

  /** A campaign that is under way, or can be resumed, has more runs to come. */
  async #heed(status) {
    const open = openCampaign(status);
    const before = this.#open;
    if (open?.name !== before?.name || open?.stopped !== before?.stopped || membersOf(open) !== membersOf(before)) {
      // How many runs there are stays known of one that stops or goes on.
      this.#open = open && { ...open, of: open.name === before?.name ? before.of : null };
      this.#planned = "";
      this.#offer();
    }
    if (open === null || this.#open.of !== null || status.campaign?.name !== open.name) return;
    const about = `${open.name} ${recordedNow(status)}`;
    if (about === this.#planned) return; // asked for already
    this.#planned = about;
    try {
      const plan = await get("plan?around=0"); // the steps are not asked for
      if (plan === null || this.#open?.name !== open.name) return;
      this.#open = { ...this.#open, of: plan.runs.filter(({ preflight }) => !preflight).length };
      this.#offer();
    } catch (error) {
      console.warn("no plan:", error.message); // how many runs there will be is not told
    }
  }

  /** Whoever does something, and wherever: it is in the event log. */
  async #lookForEvents() {
    try {
      if (await this.#isNews()) await this.#load();
    } catch (error) {
      console.warn("no events:", error.message); // the next look will tell
    }
  }

  /**
   * Whether something was entered since the last look that may bear on the unit. Not all of that is about the unit by name: data are withdrawn of a run, and a
   * certificate is one of a reference.
   */
  async #isNews() {
    const { events: [event] } = await get("audit?most=1");
    const newest = event?.number ?? 0;
    const missed = newest - (this.#newest ?? newest);
    const isLost = missed < 0 || missed > MOST_EVENTS; // the log is another one, or nobody has looked for long
    const { events } = missed === 0 || isLost ? { events: [] } : await get(`audit?most=${missed}`);
    this.#newest = newest;
    if (isLost || events.some(({ kind }) => TAKES_DATA.includes(kind))) this.#taken = newest;
    return isLost || events.some(({ kind }) => !ROUTINE.includes(kind));
  }

  /** What to do next, and the jobs that do it. */
  #offer() {
    const unit = this.#unit;
    if (unit === null || unit.unit !== this.#asked) return;
    const next = nextForRole(nextOf(unit, this.#open), roleHere());
    $("unit-next").replaceChildren(...withLink(next),
      ...(next.why ? [" ", ...obstacleParts(next.why).map((part) => (typeof part === "string" ? part : english(part.english)))] : []),
      ...(next.beside ? [" ", ...withLink(next.beside)] : []));
    this.#jobs.offer(unit, this.#open);
  }

  async open(parameters) {
    const serial = parameters.get("unit") ?? "";
    if (serial !== this.#asked) {
      for (const part of PARTS) show($(part), false);
      $("unit-badges").replaceChildren();
      this.#older = null;
      $("unit-older").value = "";
      show($("unit-older-failure"), false);
    }
    this.#asked = serial;
    say($("unit-title"), serial);
    await this.#isNews().catch((error) => console.warn("no events:", error.message)); // the next look will tell
    await this.#load();
    if (serial === this.#asked) this.#jobs.open(serial);
  }

  async #load() {
    const asked = this.#asked;
    show($("unit-failure"), false);
    try {
      const unit = await get(`unit?${new URLSearchParams({ unit: asked })}`);
      if (asked === this.#asked) this.#render(unit);
    } catch (error) {
      if (asked !== this.#asked) return;
      for (const part of PARTS) show($(part), false);
      say($("unit-failure"), error.message);
      show($("unit-failure"), true);
    }
  }

  #render(unit) {
    for (const part of PARTS) show($(part), true);
    show($("unit-withdraw"), versionsToWithdraw(unit).length > 0);
    const { title, state } = headOf(unit);
    $("unit-verdict").dataset.state = state;
    say($("unit-verdict-title"), title);
    tell($("unit-verdict-text"), verdictText(unit));
    renderJudged($("unit-judged"), unit);
    $("unit-badges").replaceChildren(...badgesOf(unit).map(badge));
    this.#renderFacts(unit);
    this.#renderWarnings(unit);
    this.#unit = unit;
    this.#offerOlder(unit.model?.version ?? 0);
    this.#wantMore();
    this.#renderCurves();
    this.#renderImpact();
    this.#gap.render(unit);
    this.#offer();
  }

  /** Versions count from 1; one that is chosen stays chosen. */
  #offerOlder(newest) {
    const versions = Array.from({ length: Math.max(0, newest - 1) }, (_, i) => String(newest - 1 - i));
    const chosen = $("unit-older").value; // its model may be on the way
    const option = (text, value) => Object.assign(element("option", text), { value });
    $("unit-older").replaceChildren(option(U.sensors.noOlder, ""), ...versions.map((version) => option(U.sensors.version(version), version)));
    $("unit-older").value = versions.includes(chosen) ? chosen : "";
    show($("unit-older-box"), versions.length > 0);
  }

  async #compare() {
    const [asked, version] = [this.#asked, $("unit-older").value];
    const isLate = () => asked !== this.#asked || version !== $("unit-older").value; // another one was chosen meanwhile
    show($("unit-older-failure"), false);
    try {
      const model = version ? (await get(`model?${new URLSearchParams({ unit: asked, version })}`)).model : null;
      if (isLate()) return;
      this.#older = model;
    } catch (error) {
      if (isLate()) return;
      this.#older = null;
      say($("unit-older-failure"), error.message);
      show($("unit-older-failure"), true);
    }
    this.#renderCurves();
  }

  /** Points and noise belong to a model, to the runs that there are and to what is left of those. */
  #wantMore() {
    const { unit, epoch, runs, newest_run_utc_s: newest, model } = this.#unit;
    const key = JSON.stringify([unit, epoch, runs, newest, model?.version, model?.created_utc_s, this.#recorded, this.#taken]);
    if (this.#points.want(model && key)) {
      this.#rows = {};
      say($("unit-points"), "");
    }
    this.#noise.want(key);
  }

  /** @returns {Promise<boolean | "busy">} whether they were found */
  async #loadPoints(isLate) {
    say($("unit-points"), U.sensors.reading);
    try {
      const { unit, model } = this.#unit;
      const { sensors } = await get(`model/rows?${new URLSearchParams({ unit, version: String(model.version) })}`);
      if (isLate()) return true;
      this.#rows = sensors;
      say($("unit-points"), Object.values(sensors).every(({ rows }) => rows === null) ? U.sensors.noPoints : "");
      this.#renderCurves();
      return true;
    } catch (error) {
      if (!isLate()) tell($("unit-points"), [U.sensors.failed, { english: error.message }]);
      return isBusy(error) ? "busy" : false;
    }
  }

  #renderCurves() {
    const { model, verification } = this.#unit;
    const holds = verdictNow(this.#unit) !== null;
    const judged = (name) => (holds ? (verification.job.result.sensors[name] ?? null) : null);
    const older = (name) => (this.#older?.sensors[name] ? { version: this.#older.version, sensor: this.#older.sensors[name] } : null);
    const sensors = Object.entries(model?.sensors ?? {});
    $("unit-sensors").replaceChildren(...sensors.map(([name, sensor]) => sensorCard(name, sensor, judged(name), older(name), this.#rows[name] ?? null)));
  }

  async #renderImpact() {
    const { unit, model } = this.#unit;
    const asked = this.#asked;
    show($("unit-impact"), false);
    if (model === null) return;
    const { renderImpact } = await import("./impact_card.mjs");
    // Another unit may have been asked for meanwhile, or a newer model has come.
    if (asked !== this.#asked || model !== this.#unit.model) return;
    renderImpact($("unit-impact"), model, unit);
    show($("unit-impact"), true);
  }

  #renderFacts(unit) {
    const { model, exported } = unit;
    const facts = [
      [U.unit.type, unit.type],
      [U.unit.model, model === null ? U.list.noModel : `${model.version}, ${clock(model.created_utc_s)}`],
      [U.unit.runs, U.unit.toFit(unit.runs, unit.to_fit)],
      [U.unit.epoch, String(unit.epoch)],
      [U.unit.released, releasedText(unit)],
      [U.unit.exported, exported === null ? U.unit.notExported : U.unit.exportedBy(clock(exported.ended_utc_s), exported.user)],
    ];
    $("unit-facts").replaceChildren(...facts.map(([name, value]) => {
      const box = element("div", "");
      box.append(element("dt", name), element("dd", value));
      return box;
    }));
    if (unit.epoch > 0) this.#tellEpoch(unit.unit, unit.epoch);
  }

  /** Why the unit's epoch began is in the event log. */
  async #tellEpoch(serial, epoch) {
    try {
      const { events } = await get(`audit?${new URLSearchParams({ kind: "epoch_begun", subject: serial })}`);
      const began = events.find(({ text }) => text.startsWith(`epoch ${epoch}, `));
      if (serial !== this.#asked || began === undefined) return;
      const why = began.text.replace(/^epoch \d+, (by .*?: )?/, "");
      const place = [...$("unit-facts").querySelectorAll("dt")].find(({ textContent }) => textContent === U.unit.epoch)?.nextElementSibling;
      if (place) say(place, U.unit.epochSince(epoch, clock(began.utc_s), why));
    } catch (error) {
      console.warn("no events:", error.message); // the number alone stands there then
    }
  }

  #renderWarnings(unit) {
    const { act, rest } = sortedWarnings(unit);
    show($("unit-warnings-card"), unit.model !== null);
    show($("unit-warnings-none"), act.length === 0);
    $("unit-warnings").replaceChildren(...act.map(warningLine));
    show($("unit-warnings-rest"), rest.length > 0);
    say($("unit-warnings-rest-title"), U.warnings.more(rest.length));
    $("unit-warnings-rest-list").replaceChildren(...rest.map(warningLine));
  }
}

/**
 * A text with the link behind it, where it has one.
 * @param {{text: string, link?: {text: string, address: string}}} told
 */
const withLink = ({ text, link }) => [text, ...(link ? [" ", Object.assign(element("a", link.text), { href: link.address })] : [])];

/** Which units an open campaign is about, and what for. */
const membersOf = (open) => JSON.stringify([open?.checks, open?.records]);

/** @param {import("./documents.mjs").Unit} unit */
function releasedText({ model, release }) {
  if (model === null) return U.unit.notReleased;
  if (model.state === "withdrawn") return U.states.withdrawn;
  if (model.state !== "released") return U.unit.notReleased;
  if (release.obstacles.length > 0) return U.unit.againstTheRule;
  return release.expires === null ? U.unit.noExpiry : U.unit.goodUntil(dayText(new Date(`${release.expires}T00:00`)));
}

/** @param {import("./documents.mjs").Warning} warning */
function warningLine({ code, text, remedy, sensors, urgency }) {
  const line = element("li", "");
  line.dataset.urgency = urgency;
  const name = U.warnings.name(code);
  const isNamed = name === "" && sensors.length === 1 && text.startsWith(sensors[0]);
  const who = sensors.length > 0 && !isNamed ? `${sensors.map(sensorText).join(", ")}: ` : "";
  const said = U.warnings.text(code, withSensors(text));
  line.append(`${who}${name}${name && ": "}`, typeof said === "string" ? said : english(said.english), ...(text.endsWith(".") ? [] : ["."]));
  const toDo = Object.assign(element("span", ""), { className: "why" });
  tell(toDo, [" ", U.warnings.remedy(code, remedy)]);
  if (remedy) line.append(toDo);
  line.append(" ", element("code", code));
  return line;
}
