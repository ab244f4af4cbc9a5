// SPDX-License-Identifier: Apache-2.0
// What the campaign does, what it asks, and whether the door may be opened.

import { $, element, say, show } from "./dom.mjs";
import { doorOf } from "./door_words.mjs";
import { allRestAsAsked, faceOf, turnText } from "./face_words.mjs";
import { duration, number, readable, sign, written } from "./format.mjs";
import { drawPose } from "./pose.mjs";
import { T } from "./text.mjs";
import { abortText, finishOf, isActive, isOver, nextBeginsByItself, positionOf, queueText, runOf, stateText, stepText, waitsForChamber } from "./words.mjs";

const CAN_PAUSE = ["preflight", "running", "waiting"];
const CAN_ABORT = ["preflight", "running", "waiting", "paused"];

const DISMISSED = "soak-dismissed"; // the campaign that is over, and whose card somebody has put away

/** The campaign that the buttons are about: the running or last one, or one that can be resumed. */
export const nameOf = ({ campaign, resumable }) => campaign?.name ?? resumable ?? null;

/** @param {import("./documents.mjs").Status} status */
export function renderHead(status) {
  const { state, campaign, prompt } = status;
  const texts = { "campaign-name": nameOf(status) ?? (isActive(status) ? T.head.campaign : T.head.noCampaign), state: stateText(status) };
  for (const [id, text] of Object.entries(texts)) {
    say($(id), text);
    $(id).title = text; // also where there is no room for all of it
  }
  $("state").dataset.state = state;
  show($("simulated"), status.simulated);
  say($("version"), `Soak ${status.version}`);
  const share = campaign ? `${Math.floor(100 * campaign.progress)} % · ${campaign.name} · ` : "";
  document.title = `${prompt ? `● ${T.head.waitsForYou} · ` : ""}${share}Soak`;
}

/**
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function renderCampaign(status, plan) {
  const { campaign, clock: time, state, reason, resumable } = status;
  // After a restart soakd makes the chamber safe before it knows the campaign again: there is no name yet.
  const queued = queueText(status);
  const over = isOver(status);
  const dismissed = over && queued === "" && localStorage.getItem(DISMISSED) === idOf(campaign);
  const shown = !dismissed && (isActive(status) || nameOf(status) !== null || queued !== "");
  show($("progress-card"), shown);
  if (!shown) return;
  $("progress-card").classList.toggle("over", over);
  show($("after"), over);
  if (over) {
    say($("after-text"), T.campaign.after[state](campaign.name));
    say($("after-units"), T.campaign.after.toUnits[campaign.purpose]);
  }
  show($("dismiss"), queued === "");
  show($("step-text"), state !== "finished" || !over);
  say($("step-text"), stepText(status, plan));
  const inBanner = state === "failed" || state === "interrupted" || (waitsForChamber(status) && !status.suspension);
  const says = reason !== null && !inBanner;
  show($("reason"), says);
  say($("reason"), says ? readable(reason) : "");
  $("reason").classList.toggle("calm", !["paused", "stopping", "aborted"].includes(state));
  show($("queue"), queued !== "");
  say($("queue"), queued);
  renderQueue(status.queue.campaigns);
  for (const part of ["progress", "facts"]) show($(part), campaign !== null);
  $("pause").disabled = !CAN_PAUSE.includes(state) || Boolean(campaign?.step_trouble);
  $("resume").disabled = !(state === "paused" || resumable);
  $("abort").disabled = !(CAN_ABORT.includes(state) || (state === "interrupted" && resumable) || status.resumes_by_itself || nextBeginsByItself(status));
  show($("next"), status.queue.waits_for === "somebody" && !isActive(status));
  $("next").disabled = false;
  say($("next"), resumable ? T.campaign.giveUp(resumable) : T.campaign.next);
  $("resume").classList.toggle("primary", !$("resume").disabled);
  const goesOn = isActive(status) && state !== "stopping"; // else nothing comes nearer
  show($("process-time"), goesOn);
  show($("host-time"), goesOn && time.rate !== 1);
  if (campaign) renderFacts(campaign, plan, time, finishOf(status));
}

/** Which campaign it is, among those of the same name too. */
const idOf = ({ name, started_utc_s }) => `${name} ${started_utc_s}`;

/**
 * Puts the card of the campaign that is over away, until there is another one.
 * @param {import("./documents.mjs").Status} status
 */
export function dismiss(status) {
  localStorage.setItem(DISMISSED, idOf(status.campaign));
}

let shownQueue = "";

function renderQueue(campaigns) {
  show($("queue-list"), campaigns.length > 0);
  // Only what has changed: a button that is made anew loses the focus.
  const asked = JSON.stringify(campaigns);
  if (asked === shownQueue) return;
  shownQueue = asked;
  $("queue-list").replaceChildren(...campaigns.map(({ name, procedure, user, estimate_s }) => {
    const entry = element("li", "");
    const out = Object.assign(element("button", T.campaign.takeOut), { type: "button", className: "small" });
    out.dataset.needs = "operator";
    out.dataset.campaign = name;
    out.setAttribute("aria-label", T.campaign.takeOutLabel(name));
    entry.append(element("span", T.campaign.queued(name, procedure, duration(estimate_s), user)), out);
    return entry;
  }));
}

function renderFacts(campaign, plan, time, finish) {
  const run = plan ? runOf(campaign, plan) : { number: campaign.run, of: campaign.runs };
  $("progress").value = campaign.progress;
  show($("finish-box"), finish !== null);
  say($("finish-label"), finish?.label ?? "");
  say($("finish"), finish?.time ?? "");
  say($("percent"), `${number(100 * campaign.progress, 1)} %`);
  say($("run"), run ? T.campaign.of(run.number, run.of) : T.campaign.preflight);
  say($("step"), T.campaign.of(campaign.step + 1, campaign.steps));
  say($("remaining"), duration(campaign.remaining_s));
  say($("process-label"), time.rate === 1 ? T.campaign.left : T.campaign.leftProcess);
  say($("host-label"), T.campaign.leftHost(written(String(time.rate))));
  say($("remaining-host"), duration(campaign.remaining_s / time.rate));
  say($("procedure"), `${campaign.procedure} (${T.purposes[campaign.purpose]})`);
}

/**
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function renderDoor(status, plan) {
  const { lamp, title, text } = doorOf(status, plan);
  $("door").dataset.lamp = lamp;
  say($("door-title"), title);
  say($("door-text"), text);
}

/**
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function renderPrompt(status, plan) {
  const { prompt, campaign } = status;
  if (prompt) say($("prompt-text"), T.prompt.asks(prompt));
  show($("prompt-inner"), prompt !== null);
  bringPrompt(prompt);
  $("confirm").disabled = prompt === null;
  const turning = prompt !== null && campaign?.step_kind === "move";
  renderFaces(turning ? status.units.filter((unit) => unit.attitude) : [], askedFace(status, plan));
  show($("itself-box"), turning && status.units.some((unit) => unit.attitude));
  const pose = turning ? poseOf(status, plan) : null;
  show($("prompt-pose"), Boolean(pose?.expected));
  if (pose?.expected) drawPose($("prompt-pose"), pose);
}

let broughtPrompt = /** @type {number | null} */ (null);

/** A new prompt is brought into view and gets the focus, but not from a field or a dialog: where nothing has it, or the button that was pressed last. */
function bringPrompt(prompt) {
  const id = prompt?.id ?? null;
  if (id === broughtPrompt) return;
  broughtPrompt = id;
  const pressed = document.activeElement?.matches("#start-card button, #confirm");
  if (id === null || !(pressed || document.activeElement === document.body)) return;
  $("prompt-title").focus();
  $("prompt-title").scrollIntoView({ block: "nearest" }); // below the head that stays
}

/** The fixture's face that is asked for; null where the plan is not known. */
function askedFace({ campaign }, plan) {
  const position = plan && positionOf(campaign.step, plan);
  return position && sign(position);
}

/** What is drawn: the fixture by a unit that is mounted straight; without one, the first unit by its own faces. */
function poseOf(status, plan) {
  const asked = askedFace(status, plan);
  const faces = status.units.map((unit) => ({ serial: unit.serial, ...faceOf(unit) })).filter((face) => face.expected);
  const straight = faces.find((face) => face.expected === asked);
  const face = straight ?? faces[0];
  if (!face) return { expected: asked, up: null, wrong: false, whose: "" };
  return { ...face, whose: straight || !asked ? "" : face.serial };
}

function renderFaces(units, asked) {
  const lines = units.map((unit) => {
    const face = faceOf(unit);
    const text = face.up === face.expected && !face.wrong ? `${T.prompt.isUp(face.up)}${face.right ? " ✓" : "…"}` : turnText(face);
    const line = element("li", `${T.prompt.unit(unit.serial, unit.slot, text)}${asked && face.expected !== asked ? T.prompt.ownAxes : ""}`);
    line.className = face.right ? "yes" : "";
    return line;
  });
  $("prompt-faces").replaceChildren(...lines);
}

/**
 * Whether the open prompt may be confirmed without a click: asked for, and every unit rests as it shall.
 * @param {import("./documents.mjs").Status} status
 */
export function confirmsItself(status) {
  return status.prompt !== null && status.campaign?.step_kind === "move" && $("itself").checked && allRestAsAsked(status);
}

/**
 * @param {import("./documents.mjs").Status} status
 * @param {import("./documents.mjs").Plan | null} plan
 */
export function openAbortDialog(status, plan) {
  say($("abort-text"), abortText(status, plan));
  $("abort-reason").value = "";
  $("abort-dialog").showModal();
}
