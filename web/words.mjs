// SPDX-License-Identifier: Apache-2.0
// What the station's documents mean in words that a technician acts on. Nothing here touches the page.

import { duration, number, shortDuration, timeOfDay, UNKNOWN } from "./format.mjs";

/** States in which a campaign holds the chamber. */
const ACTIVE = ["preflight", "running", "waiting", "paused", "stopping"];
const STATES = {
  idle: "idle",
  preflight: "pre-flight",
  running: "running",
  paused: "paused",
  stopping: "stopping",
  interrupted: "interrupted",
  finished: "finished",
  aborted: "aborted",
  failed: "failed",
};
/** What a campaign that waits by itself (docs/campaigns.md) waits for, the most urgent first. */
const SUSPENSIONS = {
  chamber: "the chamber",
  air: "the chamber's temperature",
  disk: "room on the disk",
  storage: "the disk",
  supply: "a unit's supply",
  catalog: "the catalog",
};
const UNIT_STATES = { closed: "off", silent: "sends nothing", configuring: "starting", streaming: "on", failed: "failed" };
/** °C above the dew point from which the station itself calls a unit dry (docs/campaigns.md, the safe state). */
const DRY_MARGIN_K = 2;
/** °C from which bare metal burns at a touch of a minute (ISO 13732-1, 51 °C), rounded down. */
const HOT_C = 50;
/** Degrees from the expected direction within which the station calls a position right (station/lab/position_watch.h). */
const TILT_DEG = 5;

/** @param {import("./documents.mjs").Status} status */
export const isActive = (status) => ACTIVE.includes(status.state);

/** Whether the campaign waits by itself for something that is not asked of a person. */
const waitsByItself = (status) => status.state === "waiting" && (status.suspension !== null || !status.prompt);

/** What it waits for by itself; the most urgent first. */
const causesOf = ({ suspension }) => Object.keys(SUSPENSIONS).filter((cause) => suspension?.causes.includes(cause));

/**
 * Whether the campaign waits for a chamber that does not answer.
 * @param {import("./documents.mjs").Status} status
 */
export const waitsForChamber = (status) => waitsByItself(status) && !status.chamber.connected;

/** @param {import("./documents.mjs").Status} status */
export function stateText(status) {
  if (status.state !== "waiting") return STATES[status.state] ?? status.state;
  if (!waitsByItself(status) || status.campaign?.step_trouble) return "waiting for you";
  const [cause] = causesOf(status);
  const waits = cause ?? (waitsForChamber(status) ? "chamber" : "catalog");
  return `waiting for ${SUSPENSIONS[waits]}`;
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
  return `${number(step.temp_c, 0)} °C (${visits.indexOf(step.visit) + 1} of ${visits.length})`;
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
  const up = position ? `, ${sign(position)} up` : "";
  switch (step.kind) {
    case "turn_fixture":
      return "turn the whole fixture";
    case "power_on":
      return prompt ? "switch the units off and on" : "units start";
    case "move":
      return prompt ? `turn the fixture${up}` : `turning${up}`;
    case "spin":
      return step.rate_dps ? `turning at ${number(step.rate_dps, 0)} °/s` : "rotation stops";
    case "set_temperature":
      return prompt ? "dry air" : step.visit === null ? `chamber goes to ${number(step.temp_c, 0)} °C` : "chamber on its way";
    case "wait_stable":
      return "units settling";
    case "record":
      return `recording${up}`;
    case "check":
      return "units are checked";
    case "warm_end":
      return "warming up, so that no dew forms";
    case "power_off":
      return "units are switched off";
    default:
      return step.kind;
  }
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
  if (state === "stopping") return "On the way to the safe state";
  if (!campaign && !isActive(status)) return resumable ? `Campaign ${resumable} can be resumed` : "No campaign runs";
  if (!campaign) return `The campaign: ${stateText(status)}`;
  const step = plan?.steps[campaign.step];
  if (state === "finished") return "All steps are done";
  if (["aborted", "failed", "interrupted"].includes(state)) return `Stopped at: ${campaign.step_text}`;
  if (!step) return campaign.step_text;
  const run = runOf(campaign, plan);
  const place = [run ? `Run ${run.number} of ${run.of}` : "Pre-flight", plateauText(step, plan)].filter(Boolean).join(", ");
  const left_s = prompt || state !== "running" && state !== "preflight" ? null : leftOfStep_s(status, plan);
  const left = left_s !== null && left_s >= 1 ? `, ${shortDuration(left_s)}` : "";
  return `${place}: ${actionText(status, step, positionOf(campaign.step, plan))}${left}`;
}

/**
 * When it will be over: {label, time}; null where that is not planned.
 * @param {import("./documents.mjs").Status} status
 */
export function finishOf(status) {
  const { campaign, state, clock } = status;
  if (!campaign || !isActive(status) || state === "stopping") return null;
  const holds = state === "paused" || state === "waiting";
  return { label: holds ? "Ready, if it goes on now" : "Ready", time: timeOfDay(now_s(status) + campaign.remaining_s / clock.rate, now_s(status)) };
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
  if (waits_for === "campaign") return `Then: ${names}.`;
  if (waits_for === "time") return `Next: ${names}. ${campaigns[0].name} begins by itself at ${nextBegins(status)}; Abort stops that.`;
  return `In the queue: ${names}.${isActive(status) ? "" : " It waits for you."}`;
}

/**
 * What an abort costs.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function abortText(status, plan) {
  const { campaign, resumable } = status;
  if (nextBeginsByItself(status)) return `Campaign ${status.queue.campaigns[0].name} does not begin by itself. It stays in the queue. What has been recorded stays.`;
  if (!campaign) return `Campaign ${resumable ?? ""} is given up: it cannot be resumed afterwards. Its finished runs stay.`;
  const run = plan && runOf(campaign, plan);
  const name = run ? `run ${run.number} of ${run.of}` : plan ? "the pre-flight" : campaign.run_label;
  const before = run && run.number > 1 ? ` The ${run.number === 2 ? "run" : `${run.number - 1} runs`} before it ${run.number === 2 ? "stays" : "stay"}.` : "";
  return `What ${name} has recorded becomes void: it is kept, but nothing is fitted from it.${before}
    The campaign cannot be resumed afterwards. The chamber goes to its safe state, the units are switched off. To stop for a while only, pause instead.`;
}

// ---- the door

/** Coldest and hottest of air and units whose temperature is known. */
function extremes({ chamber, units }) {
  const known = [chamber.air_c, ...units.map((unit) => unit.temp_c)].filter((value) => value !== null);
  return { coldest: Math.min(...known), hottest: Math.max(...known) };
}

/** Host seconds until the end of the next warm-up, after which the door may be opened; null where that is not planned. */
function opensIn_s({ campaign, clock, state }, plan) {
  if (!campaign || !plan || !["preflight", "running", "waiting"].includes(state)) return null;
  const end = plan.steps.findIndex((step, i) => i >= campaign.step && step.kind === "warm_end");
  if (end < 0) return null;
  const after_s = plan.steps.slice(end + 1).reduce((sum, step) => sum + step.estimate_s, 0);
  return Math.max(0, campaign.remaining_s - after_s) / clock.rate;
}

/**
 * Whether the chamber may be opened: {lamp: "yes" | "no" | "unknown", title, text}.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function doorOf(status, plan) {
  const { chamber, fixture, room, state, units } = status;
  const dew = `dew point of the room ${number(room.dew_point_c, 0)} °C`;
  const in_s = opensIn_s(status, plan);
  const later = in_s === null ? "" : ` Safe at ${timeOfDay(now_s(status) + in_s, now_s(status))} (in ${shortDuration(in_s)}).`;
  const no = (why) => ({ lamp: "no", title: "Keep the door closed", text: `${why}.${later}` });
  if (!chamber.connected) {
    return { lamp: "unknown", title: "Not known whether the door may be opened", text: `The chamber's temperature is not known; ${dew}.` };
  }
  if (fixture.moving) return no("The fixture moves");
  const { coldest, hottest } = extremes(status);
  const dry_c = room.dew_point_c + DRY_MARGIN_K;
  if (coldest <= dry_c) return no(`Dew may form: the coldest part is at ${number(coldest, 0)} °C, it takes ${number(dry_c, 0)} °C (${dew})`);
  if (hottest >= HOT_C) return no(`Hot: ${number(hottest, 0)} °C`);
  if (status.resumes_by_itself) return no("The campaign goes on by itself once the chamber is safe: abort it first");
  if (nextBeginsByItself(status)) return no(`Campaign ${status.queue.campaigns[0].name} begins by itself at ${nextBegins(status)}: abort it first`);
  if (state === "paused") return { lamp: "yes", title: "Safe to open", text: `Paused; ${number(coldest, 0)} °C, ${dew}. After Resume the units settle again.` };
  if (state === "waiting" && !waitsByItself(status)) return { lamp: "yes", title: "Safe to open", text: `It waits for you; ${number(coldest, 0)} °C, ${dew}.` };
  if (status.campaign?.step_trouble) return no("Heating and cooling are not off");
  if (state === "stopping" || isActive(status)) return no(state === "stopping" ? "The chamber is being made safe" : "A campaign is running: pause it first");
  // An alarm may have switched the chamber off while the units were cold (docs/campaigns.md, the safe state).
  if (state === "failed" && units.every((unit) => unit.temp_c === null)) {
    return { lamp: "unknown", title: "Not known whether the door may be opened", text: `The air is at ${number(chamber.air_c, 0)} °C, but the units do not say how cold they are; ${dew}.` };
  }
  return { lamp: "yes", title: "Safe to open", text: `${number(coldest, 0)} °C, ${dew}.` };
}

// ---- what is wrong

/**
 * What needs somebody, as the station says: {level: "alarm" | "warning", title, detail, action}, the most urgent first. Times as this
 * page's reader has them.
 * @param {import("./documents.mjs").Status} status
 */
export function alertsOf(status) {
  return status.alarms.map(({ level, title, detail, action, deadline }) => {
    const ends = deadline ? ` ${deadline.text} ${timeOfDay(deadline.utc_s, now_s(status))}.` : "";
    return { level, title, detail, action: `${action}${ends}` };
  });
}

// ---- units

/** A label as people read it: with a true minus sign. */
export const sign = (label) => label.replace("-", "−");

export const isByHand = ({ fixture }) => fixture.description === "by hand";

/** @param {import("./documents.mjs").LiveUnit} unit */
export function unitStateText(unit) {
  if (unit.dropped) return "dropped: not recorded in this run";
  return UNIT_STATES[unit.state] ?? unit.state;
}

/**
 * Whether its temperature stands still; "" where nothing is known of it.
 * @param {import("./documents.mjs").LiveUnit} unit
 */
export function stableText(unit) {
  if (unit.temp_c === null) return "";
  return unit.stable ? "✓ stable" : "settling";
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
  if (up === expected) return `rests more than ${TILT_DEG}° from ${expected}: seat it`;
  const half = up.slice(1) === expected.slice(1);
  return `${up} is up now, turn it ${half ? "half a turn" : "a quarter turn"} to ${expected}`;
}

/**
 * The face that is up by the unit's own accelerometers where they say it; else the one that is expected, as such.
 * @param {import("./documents.mjs").LiveUnit} unit
 */
export function positionText(unit) {
  const face = faceOf(unit);
  if (!face) return unit.position ? sign(unit.position) : UNKNOWN;
  if (face.right) return face.up;
  if (!face.wrong) return `turning to ${face.expected}`;
  return face.up === face.expected ? `${face.up}, tilted` : `${face.up}, not ${face.expected}`;
}

/** Whether every unit that sends rests as the open prompt asks; false where one cannot say. */
export function allRestAsAsked({ units }) {
  const sending = units.filter((unit) => unit.state === "streaming");
  return sending.length > 0 && sending.every((unit) => unit.attitude?.right === true);
}

/** @param {import("./documents.mjs").Status} status */
export function fixtureText(status) {
  const { fixture } = status;
  if (isByHand(status)) return "turned by hand";
  if (!fixture.connected) return isActive(status) ? "not connected" : "not asked now";
  return fixture.moving ? "moving" : sign(fixture.position ?? UNKNOWN);
}

/**
 * The chamber's link: {text, state}.
 * @param {import("./documents.mjs").Status} status
 */
export function linkOf(status) {
  const { chamber } = status;
  if (!chamber.connected) return { text: "does not answer", state: isActive(status) ? "failed" : "waiting" };
  if (chamber.age_s > 10) return { text: `silent for ${duration(chamber.age_s)}`, state: "failed" };
  return { text: "connected", state: "finished" };
}
