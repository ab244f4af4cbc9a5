// SPDX-License-Identifier: Apache-2.0
// What the station's documents mean in words that a technician acts on. Nothing here touches the page.

import { faceOf, turnText } from "./face_words.mjs";
import { duration, number, readable, setTemperature, shortDuration, sign, timeOfDay, UNKNOWN } from "./format.mjs";
import { T } from "./text.mjs";

/** States in which a campaign holds the chamber. */
const ACTIVE = ["preflight", "running", "waiting", "paused", "stopping"];
/** What a campaign that waits by itself (docs/campaigns.md) waits for, the most urgent first. */
const SUSPENSIONS = ["chamber", "air", "disk", "storage", "supply", "catalog"];

/** @param {import("./documents.mjs").Status} status */
export const isActive = (status) => ACTIVE.includes(status.state);

/**
 * Whether the campaign has ended, and cannot be resumed.
 * @param {import("./documents.mjs").Status} status
 */
export const isOver = ({ state, campaign, resumable }) => ["finished", "aborted"].includes(state) && campaign !== null && resumable === null;

/**
 * The campaign of which more runs will come: that which is under way, or that which has stopped and can be resumed.
 * @param {import("./documents.mjs").Status} status
 * @returns {{name: string, stopped: boolean, checks: string[], records: string[]} | null} `stopped`: somebody has to resume it; serial numbers of units: `checks` that it verifies,
 * `records` that it records for a fit
 */
export function openCampaign(status) {
  const name = isActive(status) ? (status.campaign?.name ?? null) : status.resumable;
  const serialsFor = (purpose) => (status.campaign?.name === name && status.campaign.purpose === purpose ? status.units.map(({ serial }) => serial) : []);
  return name === null ? null
    : { name, stopped: !isActive(status) && !status.resumes_by_itself, checks: serialsFor("verification"), records: serialsFor("calibration") };
}

/**
 * What is other once a run has ended, and the same whether or not somebody is asked for something meanwhile.
 * @param {import("./documents.mjs").Status} status
 */
export const recordedNow = (status) => `${isActive(status)} ${status.campaign?.name} ${status.campaign?.run}`;

/** Whether the campaign waits by itself for something that is not asked of a person. */
export const waitsByItself = (status) => status.state === "waiting" && (status.suspension !== null || !status.prompt);

/** What it waits for by itself; the most urgent first. */
const causesOf = ({ suspension }) => SUSPENSIONS.filter((cause) => suspension?.causes.includes(cause));

/**
 * Whether the campaign waits for a chamber that does not answer.
 * @param {import("./documents.mjs").Status} status
 */
export const waitsForChamber = (status) => waitsByItself(status) && !status.chamber.connected;

/** @param {import("./documents.mjs").Status} status */
export function stateText(status) {
  if (status.state !== "waiting") return T.states[status.state] ?? status.state;
  if (!waitsByItself(status) || status.campaign?.step_trouble) return T.waitsForYou;
  const [cause] = causesOf(status);
  return T.waitsFor[cause ?? (waitsForChamber(status) ? "chamber" : "catalog")];
}

/**
 * Host time now by the station's clock, in seconds since 1970.
 * @param {import("./documents.mjs").Status} status
 */
export const now_s = (status) => status.clock.utc_s;

// ---- the step

/**
 * {number, of} among the runs that count; null in the pre-flight.
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function runOf(campaign, plan) {
  const counted = plan.runs.filter((run) => !run.preflight);
  const run = plan.runs[campaign.run - 1];
  return !run || run.preflight ? null : { number: counted.indexOf(run) + 1, of: counted.length };
}

/** "−20 °C (1 of 5)" of the plateau that the step belongs to, or null. */
function plateauText(step, plan) {
  if (step.visit === null) return null;
  const visits = plan.plateaus.map(({ visit }) => visit);
  return T.steps.plateau(setTemperature(step.temp_c), visits.indexOf(step.visit) + 1, visits.length);
}

/**
 * A step by its number in the whole plan; undefined where the page has not got it.
 * @param {import("./documents.mjs").Plan} plan
 * @returns {import("./documents.mjs").Step | undefined}
 */
export const stepAt = (plan, number) => plan.steps[number - plan.first_step];

/**
 * What is expected of the steps from that number on, which the page has got, in process time.
 * @param {import("./documents.mjs").Plan} plan
 */
export const timeFrom_s = (plan, number) =>
  plan.steps.slice(number - plan.first_step).reduce((sum, { estimate_s }) => sum + estimate_s, plan.later_s);

/**
 * The fixture position that the step is about: its own, else that of the last move.
 * @param {import("./documents.mjs").Plan} plan
 */
export function positionOf(number, plan) {
  for (let i = number, step; (step = stepAt(plan, i)); --i) if (step.position) return step.position;
  return null;
}

function actionText(status, step, position) {
  const { prompt } = status;
  const up = position ? T.steps.up(sign(position)) : "";
  switch (step.kind) {
    case "turn_fixture":
      return T.steps.turnWhole;
    case "power_on":
      return prompt ? T.steps.switchOffAndOn : T.steps.unitsStart;
    case "move":
      return prompt ? T.steps.turn(up) : T.steps.turning(up);
    case "spin":
      return step.rate_dps ? T.steps.spins(number(step.rate_dps, 0)) : T.steps.spinEnds;
    case "set_temperature":
      return prompt ? T.steps.dryAir : step.visit === null ? T.steps.chamberGoesTo(setTemperature(step.temp_c)) : T.steps.chamberOnItsWay;
    case "wait_stable":
      return T.steps.settling;
    case "record":
      return T.steps.recording(up);
    case "check":
      return T.steps.check;
    case "warm_end":
      return T.steps.warmEnd;
    case "power_off":
      return T.steps.powerOff;
    default:
      return step.kind;
  }
}

/** "Run 1 of 3, −20 °C (1 of 5): units settling" */
function placeAndAction(status, step, plan) {
  const run = runOf(status.campaign, plan);
  const place = [run ? T.steps.run(run.number, run.of) : T.steps.preflight, plateauText(step, plan)].filter(Boolean).join(", ");
  return `${place}: ${actionText(status, step, positionOf(status.campaign.step, plan))}`;
}

/** Process time that is left of the present step; null where the plan cannot say. */
function leftOfStep_s({ campaign }, plan) {
  const later_s = timeFrom_s(plan, campaign.step + 1);
  return campaign.remaining_s > later_s ? campaign.remaining_s - later_s : null;
}

/**
 * "Run 1 of 3, −20 °C (1 of 5): units settling, 12 min". Without a plan, what the station itself calls the step; without
 * the campaign's document (soakd has just begun again), what can be said of its state.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function stepText(status, plan) {
  const { campaign, state, prompt, resumable } = status;
  if (state === "stopping") return T.steps.stopping;
  if (!campaign && !isActive(status)) return resumable ? T.steps.canBeResumed(resumable) : T.steps.none;
  if (!campaign) return T.steps.inState(stateText(status));
  const step = plan && stepAt(plan, campaign.step);
  if (state === "finished") return T.steps.allDone;
  const text = step ? placeAndAction(status, step, plan) : readable(campaign.step_text);
  if (["aborted", "failed", "interrupted"].includes(state)) return T.steps.stoppedAt(text);
  const left_s = !step || prompt || state !== "running" && state !== "preflight" ? null : leftOfStep_s(status, plan);
  return `${text}${left_s !== null && left_s >= 1 ? `, ${shortDuration(left_s)}` : ""}`;
}

/**
 * When it will be over: {label, time}; null where that is not planned.
 * @param {import("./documents.mjs").Status} status
 */
export function finishOf(status) {
  const { campaign, state, clock } = status;
  if (!campaign || !isActive(status) || state === "stopping") return null;
  const holds = state === "paused" || state === "waiting";
  return { label: holds ? T.campaign.readyIfOn : T.campaign.ready, time: timeOfDay(now_s(status) + campaign.remaining_s / clock.rate, now_s(status)) };
}

// ---- campaigns that wait for their turn

export const nextBeginsByItself = ({ queue }) => queue.waits_for === "time";

/** When the first of the queue begins by itself, as a time of day. */
export const nextBegins = (status) => timeOfDay(status.queue.begins_utc_s, now_s(status));

/**
 * What waits, and for what; empty where nothing does.
 * @param {import("./documents.mjs").Status} status
 */
export function queueText(status) {
  const { campaigns, waits_for } = status.queue;
  if (campaigns.length === 0) return "";
  const names = campaigns.map((campaign) => campaign.name).join(", ");
  if (waits_for === "campaign") return T.queue.then(names);
  if (waits_for === "time") return T.queue.atTime(names, campaigns[0].name, nextBegins(status));
  return isActive(status) ? T.queue.waits(names) : T.queue.waitsForYou(names);
}

/**
 * What an abort costs.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function abortText(status, plan) {
  const { campaign, resumable } = status;
  if (nextBeginsByItself(status)) return T.abort.queued(status.queue.campaigns[0].name);
  if (!campaign) return T.abort.givenUp(resumable ?? "");
  const run = plan && runOf(campaign, plan);
  const name = run ? T.abort.run(run.number, run.of) : plan ? T.abort.preflight : T.abort.label(campaign.run_label);
  return T.abort.loses(name, run && run.number > 1 ? T.abort.before(run.number - 1) : "");
}

// ---- what is wrong

/**
 * What needs somebody: {level: "alarm" | "warning", title, detail, action}, the most urgent first. `detail` in the station's own words, times
 * as this page's reader has them.
 * @param {import("./documents.mjs").Status} status
 */
export function alertsOf(status) {
  return status.alarms.map((alarm) => {
    const unit = status.units.find(({ serial }) => serial === alarm.about);
    const face = unit ? faceOf(unit) : null;
    const { title, action, deadline } = T.alarm(alarm, status, face ? turnText(face) : "");
    const ends = alarm.deadline ? ` ${deadline} ${timeOfDay(alarm.deadline.utc_s, now_s(status))}.` : "";
    return { level: alarm.level, title, detail: alarm.detail && readable(alarm.detail), action: `${action}${ends}` };
  });
}

// ---- devices

export const isByHand = ({ fixture }) => fixture.description === "by hand";

/** @param {import("./documents.mjs").Status} status */
export function fixtureText(status) {
  const { fixture } = status;
  if (isByHand(status)) return T.chamber.byHand;
  if (!fixture.connected) return isActive(status) ? T.chamber.notConnected : T.chamber.notAsked;
  return fixture.moving ? T.chamber.moving : sign(fixture.position ?? UNKNOWN);
}

/**
 * The chamber's link: {text, state}.
 * @param {import("./documents.mjs").Status} status
 */
export function linkOf(status) {
  const { chamber } = status;
  if (!chamber.connected) return { text: T.chamber.noAnswer, state: isActive(status) ? "failed" : "waiting" };
  if (chamber.age_s > 10) return { text: T.chamber.silent(duration(chamber.age_s)), state: "failed" };
  return { text: T.chamber.connected, state: "finished" };
}
