// SPDX-License-Identifier: Apache-2.0
// What the station's documents mean in words that a technician acts on. Nothing here touches the page.

import { duration, number, readable, setTemperature, shortDuration, timeOfDay, UNKNOWN } from "./format.mjs";
import { T } from "./text.mjs";

/** States in which a campaign holds the chamber. */
const ACTIVE = ["preflight", "running", "waiting", "paused", "stopping"];
/** What a campaign that waits by itself (docs/campaigns.md) waits for, the most urgent first. */
const SUSPENSIONS = ["chamber", "air", "disk", "storage", "supply", "catalog"];
/** °C above the dew point from which the station itself calls a unit dry (docs/campaigns.md, the safe state). */
const DRY_MARGIN_K = 2;
/** °C from which bare metal burns at a touch of a minute (ISO 13732-1, 51 °C), rounded down. */
const HOT_C = 50;
/** A pause is advised where air and units that lie beside the set point are safe, too. */
const PAUSE_MARGIN_K = 3;
/** Degrees from the expected direction within which the station calls a position right (station/lab/position_watch.h). */
const TILT_DEG = 5;

/** @param {import("./documents.mjs").Status} status */
export const isActive = (status) => ACTIVE.includes(status.state);

/**
 * Whether the campaign has ended, and cannot be resumed.
 * @param {import("./documents.mjs").Status} status
 */
export const isOver = ({ state, campaign, resumable }) => ["finished", "aborted"].includes(state) && campaign !== null && resumable === null;

/**
 * What is other once a run has ended, and the same whether or not somebody is asked for something meanwhile.
 * @param {import("./documents.mjs").Status} status
 */
export const recordedNow = (status) => `${isActive(status)} ${status.campaign?.name} ${status.campaign?.run}`;

/** Whether the campaign waits by itself for something that is not asked of a person. */
const waitsByItself = (status) => status.state === "waiting" && (status.suspension !== null || !status.prompt);

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
  const visits = [...new Set(plan.steps.filter((s) => s.run === step.run && s.visit !== null).map((s) => s.visit))];
  return T.steps.plateau(setTemperature(step.temp_c), visits.indexOf(step.visit) + 1, visits.length);
}

/**
 * The fixture position that the step is about: its own, else that of the last move.
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function positionOf(index, plan) {
  for (let i = index; i >= 0; --i) if (plan.steps[i].position) return plan.steps[i].position;
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
  const later_s = plan.steps.slice(campaign.step + 1).reduce((sum, step) => sum + step.estimate_s, 0);
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
  const step = plan?.steps[campaign.step];
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

const nextBegins = (status) => timeOfDay(status.queue.begins_utc_s, now_s(status));

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

// ---- the door

/** Coldest and hottest of air and units whose temperature is known. */
function extremes({ chamber, units }) {
  const known = [chamber.air_c, ...units.map((unit) => unit.temp_c)].filter((value) => value !== null);
  return { coldest: Math.min(...known), hottest: Math.max(...known) };
}

/**
 * Host seconds until a step of the plan begins; null where it is late already, or the campaign does not go on now.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan} plan
 */
function beginsIn_s({ campaign, clock, state }, plan, step) {
  if (!["preflight", "running"].includes(state) || campaign.on_way_back) return null;
  const from_s = plan.steps.slice(step).reduce((sum, { estimate_s }) => sum + estimate_s, 0);
  const left_s = campaign.remaining_s - from_s;
  return left_s > 0 ? left_s / clock.rate : null;
}

/** The same as words in a sentence: `words(time of day, span)`; "" where nothing is planned. */
function plannedText(status, plan, step, words) {
  const in_s = step < 0 ? null : beginsIn_s(status, plan, step);
  return in_s === null ? "" : words(timeOfDay(now_s(status) + in_s, now_s(status)), shortDuration(in_s));
}

/**
 * When the units are warm at the end of this run. Only after the last one the door may be opened without a pause.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
function endOfRunText(status, plan) {
  const { campaign } = status;
  if (!campaign || !plan) return "";
  const { run } = plan.steps[campaign.step] ?? {};
  const end = plan.steps.findIndex((step, i) => i >= campaign.step && step.run === run && step.kind === "warm_end");
  const isLast = plan.steps.every((step) => step.run <= run);
  return plannedText(status, plan, end < 0 ? -1 : end + 1, isLast ? T.door.later : T.door.betweenRuns);
}

/**
 * How a door that is closed because of the temperature can be opened: by a pause at the next plateau of this run that is neither cold nor hot, or at its end.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
function opensText(status, plan, dry_c) {
  const isSafe = (temp_c) => temp_c > dry_c + PAUSE_MARGIN_K && temp_c < HOT_C - PAUSE_MARGIN_K;
  const { campaign, chamber } = status;
  if (status.state === "paused") return chamber.set_point_c !== null && isSafe(chamber.set_point_c) ? T.door.waitHere : T.door.pausedHere;
  if (!campaign || !plan) return "";
  const { run } = plan.steps[campaign.step] ?? {};
  const plateau = plan.steps.findIndex((step, i) => i > campaign.step && step.run === run && step.kind === "record" && isSafe(step.temp_c));
  const pauses = plannedText(status, plan, plateau, (time, span) => T.door.pauseAt(setTemperature(plan.steps[plateau].temp_c), time, span));
  return `${pauses}${endOfRunText(status, plan)}`;
}

/**
 * Whether the chamber may be opened: {lamp: "yes" | "no" | "unknown", title, text}.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function doorOf(status, plan) {
  const { chamber, fixture, room, state, units } = status;
  const dew = T.door.dew(number(room.dew_point_c, 0));
  const no = (why, how = "") => ({ lamp: "no", title: T.door.closed, text: `${why}.${how}` });
  if (!chamber.connected) {
    return { lamp: "unknown", title: T.door.unknown, text: T.door.noChamber(dew) };
  }
  if (fixture.moving) return no(T.door.moves);
  const { coldest, hottest } = extremes(status);
  const dry_c = room.dew_point_c + DRY_MARGIN_K;
  const how = opensText(status, plan, dry_c);
  if (coldest <= dry_c) return no(T.door.cold(number(coldest, 0), number(dry_c, 0), dew), how);
  if (hottest >= HOT_C) return no(T.door.hot(number(hottest, 0)), how);
  if (status.resumes_by_itself) return no(T.door.goesOn);
  if (nextBeginsByItself(status)) return no(T.door.begins(status.queue.campaigns[0].name, nextBegins(status)));
  if (state === "paused") return { lamp: "yes", title: T.door.open, text: T.door.paused(number(coldest, 0), dew) };
  if (state === "waiting" && !waitsByItself(status)) return { lamp: "yes", title: T.door.open, text: T.door.asks(number(coldest, 0), dew) };
  if (status.campaign?.step_trouble) return no(T.door.notOff);
  if (state === "stopping" || isActive(status)) return no(state === "stopping" ? T.door.stopping : T.door.runs, endOfRunText(status, plan));
  // An alarm may have switched the chamber off while the units were cold (docs/campaigns.md, the safe state).
  if (state === "failed" && units.every((unit) => unit.temp_c === null)) {
    return { lamp: "unknown", title: T.door.unknown, text: T.door.coldUnits(number(chamber.air_c, 0), dew) };
  }
  return { lamp: "yes", title: T.door.open, text: T.door.safe(number(coldest, 0), dew) };
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

// ---- units

/** A label as people read it: with a true minus sign. */
export const sign = (label) => label.replace("-", "−");

export const isByHand = ({ fixture }) => fixture.description === "by hand";

/** @param {import("./documents.mjs").LiveUnit} unit */
export function unitStateText(unit) {
  if (unit.dropped) return T.unit.dropped;
  return T.unit.states[unit.state] ?? unit.state;
}

/**
 * Whether its temperature stands still; "" where nothing is known of it.
 * @param {import("./documents.mjs").LiveUnit} unit
 */
export function stableText(unit) {
  if (unit.temp_c === null) return "";
  return unit.stable ? T.unit.stable : T.unit.settling;
}

/** What the unit's accelerometers say: {up, expected, wrong, right}, in its own axes; null where they do not say. */
export function faceOf({ attitude }) {
  if (!attitude) return null;
  const right = attitude.right === true;
  const expected = sign(attitude.expected);
  return { up: right ? expected : sign(attitude.up || UNKNOWN), expected, right, wrong: attitude.right === false };
}

/** How a unit that rests wrong comes to rest as it should: turned, or seated where the right face is up already. */
export function turnText({ up, expected }) {
  if (up === expected) return T.faces.tilted(TILT_DEG, expected);
  return up.slice(1) === expected.slice(1) ? T.faces.half(up, expected) : T.faces.quarter(up, expected);
}

/**
 * The face that is up by the unit's own accelerometers where they say it; else the one that is expected, as such.
 * @param {import("./documents.mjs").LiveUnit} unit
 */
export function positionText(unit) {
  const face = faceOf(unit);
  if (!face) return unit.position ? sign(unit.position) : UNKNOWN;
  if (face.right) return face.up;
  if (!face.wrong) return T.faces.turning(face.expected);
  return face.up === face.expected ? T.faces.isTilted(face.up) : T.faces.wrong(face.up, face.expected);
}

/** Whether every unit that sends rests as the open prompt asks; false where one cannot say. */
export function allRestAsAsked({ units }) {
  const sending = units.filter((unit) => unit.state === "streaming");
  return sending.length > 0 && sending.every((unit) => unit.attitude?.right === true);
}

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
