// SPDX-License-Identifier: Apache-2.0
// Whether the chamber may be opened, and when, in words. Nothing here touches the page.

import { number, setTemperature, shortDuration, timeOfDay } from "./format.mjs";
import { T } from "./text.mjs";
import { isActive, nextBegins, nextBeginsByItself, now_s, stepAt, timeFrom_s, waitsByItself } from "./words.mjs";

/** °C above the dew point from which the station itself calls a unit dry (docs/campaigns.md, the safe state). */
const DRY_MARGIN_K = 2;
/** °C from which bare metal burns at a touch of a minute (ISO 13732-1, 51 °C), rounded down. */
const HOT_C = 50;
/** A pause is advised where air and units that lie beside the set point are safe, too. */
const PAUSE_MARGIN_K = 3;
/** Ends that may have left units cold; of a campaign that is finished the last step has warmed them. */
const CUT_SHORT = ["failed", "aborted", "interrupted"];

/**
 * Between which temperatures somebody may open the door.
 * @param {import("./documents.mjs").Status} status
 */
export const safeToOpen = ({ room }) => ({ from_c: room.dew_point_c + DRY_MARGIN_K + PAUSE_MARGIN_K, to_c: HOT_C - PAUSE_MARGIN_K });

/** Coldest and hottest of air and units whose temperature is known. */
function extremes({ chamber, units }) {
  const known = [chamber.air_c, ...units.map((unit) => unit.temp_c)].filter((value) => value !== null);
  return { coldest: Math.min(...known), hottest: Math.max(...known) };
}

/**
 * Host seconds until no more than `left_s` of the plan is left; null where it is late already, or the campaign does not go on now.
 * @param {import("./documents.mjs").Status} status
 */
function comesIn_s({ campaign, clock, state }, left_s) {
  if (!["preflight", "running"].includes(state) || campaign.on_way_back) return null;
  const in_s = campaign.remaining_s - left_s;
  return in_s > 0 ? in_s / clock.rate : null;
}

/** The same as words in a sentence: `words(time of day, span)`; "" where nothing is planned (`left_s` null). */
function plannedText(status, left_s, words) {
  const in_s = left_s === null ? null : comesIn_s(status, left_s);
  return in_s === null ? "" : words(timeOfDay(now_s(status) + in_s, now_s(status)), shortDuration(in_s));
}

/**
 * When the units are warm at the end of this run. Only after the last one the door may be opened without a pause.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
function endOfRunText(status, plan) {
  const { campaign } = status;
  const step = campaign && plan && stepAt(plan, campaign.step);
  if (!step) return "";
  const isToCome = plan.warm_end !== null && plan.warm_end.step >= campaign.step;
  return plannedText(status, isToCome ? plan.warm_end.after_s : null, step.run === plan.runs.length - 1 ? T.door.later : T.door.betweenRuns);
}

/**
 * The next recording of this run at a temperature that `isSafe`: {temp_c, left_s}; undefined where there is none.
 * @param {{step: number}} campaign
 * @param {import("./documents.mjs").Plan} plan
 * @param {(temp_c: number) => boolean} isSafe
 */
function nextRecording({ step: present }, plan, isSafe) {
  if (!stepAt(plan, present)) return undefined;
  for (let number = present + 1, step; (step = stepAt(plan, number)); ++number) {
    if (step.kind === "record" && isSafe(step.temp_c)) return { temp_c: step.temp_c, left_s: timeFrom_s(plan, number) };
  }
  return plan.plateaus.find(({ step, temp_c }) => step !== null && step > present && isSafe(temp_c));
}

/** Which plateau it will be, where the plan cannot say when. On the way back it is not known what comes: that plateau may be behind it. */
function unplannedText({ campaign, prompt, state }, temp) {
  if (campaign.on_way_back && ["preflight", "running", "waiting"].includes(state)) return T.door.wayBack;
  return temp !== "" && prompt && state === "waiting" ? T.door.pauseNext(temp) : "";
}

/** How the fixture is turned that somebody is asked to turn behind a closed door. */
const turnsText = ({ prompt }) => (["position", "heading"].includes(prompt?.code ?? "") ? T.door.turnClosed : "");

/**
 * How a door that is closed because of the temperature can be opened: by a pause at the next plateau of this run that is neither cold nor hot, or at its end.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
function opensText(status, plan) {
  const { from_c, to_c } = safeToOpen(status);
  const isSafe = (temp_c) => temp_c > from_c && temp_c < to_c;
  const { campaign, chamber } = status;
  if (status.state === "paused") return chamber.set_point_c !== null && isSafe(chamber.set_point_c) ? T.door.waitHere : T.door.pausedHere;
  if (!campaign || !plan) return turnsText(status);
  const next = nextRecording(campaign, plan, isSafe);
  const temp = next ? setTemperature(next.temp_c) : "";
  const planned = plannedText(status, next?.left_s ?? null, (time, span) => T.door.pauseAt(temp, time, span));
  return `${turnsText(status)}${planned || unplannedText(status, temp)}${endOfRunText(status, plan)}`;
}

/**
 * Whether the chamber may be opened: {lamp: "yes" | "no" | "unknown", title, text}.
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function doorOf(status, plan) {
  const { chamber, fixture, room, state, units } = status;
  const dew = (room.dew_point_assumed ? T.door.dewAssumed : T.door.dew)(number(room.dew_point_c, 0));
  const no = (why, how = "") => ({ lamp: "no", title: T.door.closed, text: `${why}.${how}` });
  if (!chamber.connected) {
    return { lamp: "unknown", title: T.door.unknown, text: T.door.noChamber(dew) };
  }
  if (fixture.moving) return no(T.door.moves);
  const { coldest, hottest } = extremes(status);
  const dry_c = room.dew_point_c + DRY_MARGIN_K;
  const how = opensText(status, plan);
  if (coldest <= dry_c) return no(T.door.cold(number(coldest, 0), number(dry_c, 0), dew), how);
  if (hottest >= HOT_C) return no(T.door.hot(number(hottest, 0)), how);
  if (status.resumes_by_itself) return no(T.door.goesOn);
  if (nextBeginsByItself(status)) return no(T.door.begins(status.queue.campaigns[0].name, nextBegins(status)));
  if (state === "paused") return { lamp: "yes", title: T.door.open, text: T.door.paused(number(coldest, 0), dew) };
  if (state === "waiting" && !waitsByItself(status)) return { lamp: "yes", title: T.door.open, text: T.door.asks(number(coldest, 0), dew) };
  if (status.campaign?.step_trouble) return no(T.door.notOff);
  if (state === "stopping" || isActive(status)) return no(state === "stopping" ? T.door.stopping : T.door.runs, endOfRunText(status, plan));
  // An alarm on the way to the safe state may have switched the chamber off while the units were cold (docs/campaigns.md, the safe state).
  if (CUT_SHORT.includes(state) && units.every((unit) => unit.temp_c === null)) {
    return { lamp: "unknown", title: T.door.unknown, text: T.door.coldUnits(number(chamber.air_c, 0), dew) };
  }
  return { lamp: "yes", title: T.door.open, text: T.door.safe(number(coldest, 0), dew) };
}
