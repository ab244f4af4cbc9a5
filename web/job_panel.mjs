// SPDX-License-Identifier: Apache-2.0
// The jobs of a unit: buttons that start them, the one that runs, what came of those before.

import { get, looksForJobs, post } from "./api.mjs";
import { $, element, say, show, tell } from "./dom.mjs";
import { jobLine, spoken, verdictIn, voidIn } from "./job_line.mjs";
import { isVerdictVoid, madeFrom, runningText, showShare, verbOf } from "./job_words.mjs";
import { obstacleParts } from "./obstacle_words.mjs";
import { isSure } from "./sure_dialog.mjs";
import { campaignToVerifyWith, isBeingChecked, isToReleaseAgain, nextOf, U } from "./unit_words.mjs";

const LOOK_AGAIN_MS = 1000;
const LOOKS_AT_OTHERS = 10; // every so many times where no job is known to run
const MOST_SHOWN = 8;
const OF_RUNS = "kalibr"; // the one format that is not of a model
const MOST_ID = 2147483647;
const KINDS = ["fit", "verify", "release", "export", "report"];

export class JobPanel {
  #userName;
  #changed;
  #took;
  #serial = null;
  #unit = null; // its document
  #running = null; // the job that is under way, of whatever unit
  #ended = []; // those of this unit that are shown
  #shown = null; // which these are, as text; null before the first look
  #ofAll = null; // the last job that ended and was of all units; null before the first look
  #picked = false; // somebody has chosen the campaign to verify with
  #ticked = ""; // which model the tick of simulated data is about
  #lines = ""; // the same, with the models that they were made from
  #lookForJobs = looksForJobs((jobs) => this.#take(jobs));

  /**
   * `userName()`: who is at the page; `changed()`: a job of this unit has ended; `took(busy, job)`: whether another one
   * would be refused, and the one that runs, if it is known.
   */
  constructor(userName, changed, took) {
    this.#userName = userName;
    this.#changed = changed;
    this.#took = took;
    $("unit-format").append(...Object.entries(U.formats).map(([value, text]) => Object.assign(element("option", text), { value })));
    for (const kind of KINDS) $(`unit-${kind}`).addEventListener("click", () => this.#startOwn(kind));
    $("unit-format").addEventListener("change", () => {
      this.#offerSignature();
      this.#showVersions();
      this.#enable();
    });
    $("unit-campaign").addEventListener("change", () => {
      this.#picked = true;
    });
    $("unit-version").addEventListener("change", () => {
      this.#showSimulated();
      this.#enable();
    });
    $("unit-cancel").addEventListener("click", () => this.#cancel());
    let ticks = 0;
    setInterval(() => {
      const isDue = ++ticks % LOOKS_AT_OTHERS === 0; // somebody else may have started one
      if (!$("unit-view").hidden && !document.hidden && this.#serial !== null && (this.#running || isDue)) this.#look();
    }, LOOK_AGAIN_MS);
    document.addEventListener("visibilitychange", () => {
      if (!$("unit-view").hidden && !document.hidden && this.#serial !== null) this.#changed();
    });
  }

  open(serial) {
    if (serial !== this.#serial) {
      $("unit-format").selectedIndex = 0; // what was chosen for another unit is not what is wanted of this one
      $("unit-ids").value = "";
    }
    this.#serial = serial;
    this.#picked = false;
    this.#ended = [];
    this.#shown = null;
    this.#lines = "";
    $("unit-jobs").replaceChildren();
    $("unit-jobs").setAttribute("aria-busy", "true");
    show($("job-failure"), false);
    this.#offerSignature();
    this.#look();
  }

  /** What can be done with a unit as it is; `open`: the campaign that is not over yet, as for nextOf(). */
  offer(unit, open) {
    this.#unit = unit;
    this.#offerCampaigns(unit, open);
    this.#offerVersions(unit);
    const { kind: next } = nextOf(unit, open);
    for (const kind of KINDS) $(`unit-${kind}`).classList.toggle("primary", kind === next);
    const isOpen = isUnreleased(unit);
    const obstacles = isOpen ? (unit.release?.obstacles ?? []) : [];
    tell($("unit-release-why"), obstacles.length > 0 ? [U.jobs.notReleased, ...obstacleParts(obstacles)] : []);
    this.#showEnded();
    this.#enable();
  }

  /** Those that a fit has seen stand there, too, so that nobody looks for them in vain. What somebody has chosen stays chosen. */
  #offerCampaigns(unit, open) {
    const { model, verify_with: fresh, fitted_to: fitted } = unit;
    const chosen = $("unit-campaign").value;
    const named = (campaign, runs, use) => (campaign === open?.name ? U.jobs.campaignOpen(campaign, runs, open, use) : U.jobs.campaignRuns(campaign, runs, use));
    const option = (text, value, disabled) => Object.assign(element("option", text), { value, disabled });
    $("unit-campaign").replaceChildren(
      ...fresh.map(({ campaign, runs, purpose }) => option(named(campaign, runs, purpose), campaign, false)),
      ...fitted.map(({ campaign, runs }) => option(named(campaign, runs, "fitted"), campaign, true)));
    const isThere = fresh.some(({ campaign }) => campaign === chosen);
    const own = campaignToVerifyWith(fresh, open)?.campaign ?? null;
    if (this.#picked && isThere) $("unit-campaign").value = chosen;
    else if (own !== null) $("unit-campaign").value = own;
    $("unit-campaign").disabled = fresh.length === 0;
    show($("unit-campaign-none"), model !== null && fresh.length === 0);
    say($("unit-campaign-none"), isBeingChecked(unit, open) ? U.jobs.beingChecked(open.name) : U.jobs.noCampaign);
  }

  /** Released models stay so when the next one is fitted: their files can be had until that is released, too. */
  #offerVersions({ unit, model, released_before: released }) {
    const { dataset: { unit: of }, value: chosen } = $("unit-version");
    const option = (text, value) => Object.assign(element("option", text), { value: String(value) });
    const newest = model === null ? [] : [option(U.jobs.newestVersion(model.version), "")];
    $("unit-version").replaceChildren(...newest, ...released.map((version) => option(U.jobs.releasedVersion(version), version)));
    $("unit-version").dataset.unit = unit;
    $("unit-version").value = of === unit && released.includes(Number(chosen)) ? chosen : "";
    this.#showVersions();
  }

  #showVersions() {
    show($("unit-version-box"), $("unit-format").value !== OF_RUNS && (this.#unit?.released_before.length ?? 0) > 0);
    this.#showSimulated();
  }

  /** The tick is about one model, and not about the one that is chosen or fitted after it. */
  #showSimulated() {
    const model = this.#unit?.model ?? null;
    const older = this.#olderVersion();
    const about = model === null ? "" : `${this.#unit.unit} ${older ?? model.version}`;
    if (about !== this.#ticked) $("unit-simulated").checked = false;
    this.#ticked = about;
    show($("unit-simulated-box"), this.#isSimulated());
    say($("unit-simulated-text"), model === null ? "" : U.jobs.simulated(older ?? model.version));
  }

  /** Whether what would be exported is of simulated data. */
  #isSimulated() {
    const older = this.#olderVersion();
    return this.#unit?.model != null && (older === null ? this.#unit.model.simulated : this.#unit.simulated_before.includes(older));
  }

  #enable() {
    const busy = this.#running !== null || this.#unit === null;
    const hasModel = this.#unit?.model != null;
    $("unit-fit").disabled = busy || this.#unit.to_fit === 0;
    show($("unit-fit-none"), this.#unit?.to_fit === 0);
    const isOlder = hasModel && this.#unit.model.epoch !== this.#unit.epoch; // of the unit before its repair
    $("unit-verify").disabled = busy || !hasModel || isOlder || this.#unit.verify_with.length === 0;
    $("unit-report").disabled = busy || !hasModel;
    $("unit-release").disabled = busy || !hasModel || !mayBeReleased(this.#unit);
    const against = hasModel && this.#unit.model.state === "released" ? this.#unit.release.obstacles : []; // the rule of release, by now
    const isUnfit = isOlder || this.#unit?.model?.state === "withdrawn" || against.length > 0;
    const isExportOff = isUnfit && this.#olderVersion() === null && $("unit-format").value !== OF_RUNS;
    $("unit-export").disabled = busy || !hasModel || isExportOff;
    tell($("unit-older-why"), isOlder ? [U.jobs.beforeRepair(this.#unit.model.version, isExportOff)]
      : isExportOff && against.length > 0 ? [U.jobs.againstTheRule(this.#unit.model.version), ...obstacleParts(against)] : []);
    this.#took(busy, this.#running);
  }

  /** Starts a job of this unit; `members`: of the request, beside kind, unit and user. */
  async start(kind, members = {}) {
    await this.#tell(verbOf(kind), "jobs", { kind, unit: this.#serial, user: this.#userName(), ...members });
  }

  async #startOwn(kind) {
    const members = {};
    if (kind === "verify") members.campaign = $("unit-campaign").value;
    if (kind === "export") Object.assign(members, this.#exportMembers());
    if (kind === "export" && this.#isSimulated() && !members.simulated) {
      say($("job-failure"), U.jobs.tickSimulated(this.#olderVersion() ?? this.#unit.model.version));
      show($("job-failure"), true);
      $("unit-simulated").focus();
      return;
    }
    if (kind === "export" && members.accel_id === null) {
      say($("job-failure"), U.jobs.wrongDeviceIds);
      show($("job-failure"), true);
      $("unit-ids").focus();
      return;
    }
    if (kind === "export" && !(await this.#isSureToExport(members))) return;
    await this.start(kind, members);
  }

  /**
   * A file that nobody vouches for leaves only when that is wanted.
   * @param {any} members of the request
   */
  async #isSureToExport({ format, model, sign }) {
    if (format === OF_RUNS || model !== undefined || !isUnreleased(this.#unit)) return true;
    const { title, text, send } = U.jobs.askUnreleased;
    return isSure({ title: title(this.#unit.model.version), text: text(`${this.#unit.unit}.unreleased…`, sign), send });
  }

  #exportMembers() {
    const isChosen = (name) => !$(`${name}-box`).hidden && !$(name).disabled && $(name).checked;
    const older = this.#olderVersion();
    return { format: $("unit-format").value, ...(older === null ? {} : { model: older }), ...this.#deviceIds(), simulated: isChosen("unit-simulated"), sign: isChosen("unit-sign") };
  }

  /** Of PX4, where they are given; `accel_id` is null where what is written is none. */
  #deviceIds() {
    const text = $("unit-ids").value.trim();
    if ($("unit-ids-box").hidden || text === "") return {};
    const ids = text.split(",").map((one) => (/^\s*\d+\s*$/.test(one) ? Number(one) : 0));
    if (ids.length > 2 || ids.some((id) => id < 1 || id > MOST_ID)) return { accel_id: null };
    return { accel_id: ids[0], ...(ids.length > 1 ? { gyro_id: ids[1] } : {}) };
  }

  /** The version that is to be exported instead of the newest; null where it is that. */
  #olderVersion() {
    return $("unit-version-box").hidden || $("unit-version").value === "" ? null : Number($("unit-version").value);
  }

  /** Only a calibration file can be signed, and only by a station that has a key; only PX4 asks for which device it is. */
  async #offerSignature() {
    for (const id of ["unit-ids-box", "unit-ids-none"]) show($(id), $("unit-format").value === "px4");
    show($("unit-sign-box"), $("unit-format").value === "blob");
    try {
      const { key } = await get("key");
      $("unit-sign").disabled = key === null;
      say($("unit-sign-text"), key === null ? U.jobs.noKey : U.jobs.signWith(key.key_id));
    } catch (error) {
      $("unit-sign").disabled = true;
      tell($("unit-sign-text"), [U.jobs.keyUnknown, { english: error.message }]);
    }
  }

  async #cancel() {
    if (this.#running) await this.#tell(U.jobs.cancel, "jobs/cancel", { id: this.#running.id, user: this.#userName() });
  }

  async #tell(what, path, body) {
    show($("job-failure"), false);
    if ($("unit-work").contains(document.activeElement)) $("unit-work-title").focus();
    for (const kind of KINDS) $(`unit-${kind}`).disabled = true;
    this.#took(true, this.#running);
    say($("job-news"), U.jobs.asked(what));
    try {
      await post(path, body);
    } catch (error) {
      tell($("job-failure"), [U.jobs.refused(what), { english: error.message }]);
      show($("job-failure"), true);
    }
    await this.#look();
  }

  async #look() {
    if (await this.#lookForJobs()) $("unit-jobs").setAttribute("aria-busy", "false");
  }

  #take(jobs) {
    this.#running = jobs.find(({ state }) => state === "running") ?? null;
    this.#showRunning();
    // A verification of all has judged this unit, too.
    const isOurs = ({ unit, kind, state }) => state !== "running" && (unit === this.#serial || (kind === "verify_all" && state === "done"));
    const own = jobs.filter(isOurs).slice(0, MOST_SHOWN);
    const about = own.map(({ id }) => id).join(" ");
    if (about !== this.#shown) {
      const isFirst = this.#shown === null;
      this.#shown = about;
      this.#ended = own;
      this.#showEnded();
      tell($("job-news"), isFirst || own.length === 0 ? [] : spoken(own[0]));
      this.#changed(); // also at the first look: one may have ended since the unit was read
    }
    this.#heed(jobs.find(({ unit, state }) => unit === "" && state !== "running")?.id ?? 0);
    show($("unit-jobs-none"), own.length === 0);
    this.#enable();
  }

  /** A job of all units has changed this one, too. */
  #heed(ofAll) {
    const isFirst = this.#ofAll === null;
    if (ofAll === this.#ofAll) return;
    this.#ofAll = ofAll;
    if (!isFirst) this.#changed();
  }

  /** Anew only where they say something else: somebody may be about to press a download. */
  #showEnded() {
    const lines = this.#ended.map((job) => ({ job, from: madeFrom(job, this.#unit), isOver: isVerdictVoid(job, this.#unit), not: voidIn(job, this.#unit) }));
    const judged = this.#unit?.verification ?? null;
    const about = lines.map(({ job, from, isOver, not }) => `${job.id} ${from} ${isOver} ${verdictIn(job, judged)} ${JSON.stringify(not)}`).join("\n");
    if (about === this.#lines) return;
    this.#lines = about;
    $("unit-jobs").replaceChildren(...lines.map(({ job, from, isOver, not }) => jobLine(job, from, verdictIn(job, judged), isOver, not)));
  }

  #showRunning() {
    const job = this.#running;
    // What has the focus goes away: the keyboard goes on from the jobs' title.
    if (job === null && $("job-running").contains(document.activeElement)) $("unit-work-title").focus();
    show($("job-running"), job !== null);
    if (job === null) return;
    say($("job-running-text"), runningText(job, Date.now() / 1000));
    showShare($("job-progress"), job);
  }
}

/**
 * Whether nobody has released the newest model.
 * @param {import("./documents.mjs").Unit} unit
 */
const isUnreleased = ({ model }) => model?.state === "fitted" || model?.state === "verified";

/**
 * Whether the rule lets the newest model be released, for the first time or again.
 * @param {import("./documents.mjs").Unit} unit
 */
const mayBeReleased = ({ model, release }) => (model.state === "released" ? isToReleaseAgain(release) : release.obstacles.length === 0);
