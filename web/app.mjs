// SPDX-License-Identifier: Apache-2.0
// The station's page: what /api/v1 says, and the five things that a user can tell it.

import { get, send, subscribe } from "./api.mjs";
import { KINDS } from "./allan_chart.mjs";
import { Chart } from "./chart.mjs";
import { $, element, say, show } from "./dom.mjs";
import { clock, count, duration, number, significant, UNKNOWN } from "./format.mjs";
import { NoiseCard } from "./noise_card.mjs";

const LOG_LINES = 100;
const STATES = {
  idle: "idle",
  preflight: "pre-flight",
  running: "running",
  waiting: "waiting for you",
  paused: "paused",
  stopping: "stopping",
  interrupted: "interrupted",
  finished: "finished",
  aborted: "aborted",
  failed: "failed",
};
const CAN_PAUSE = ["preflight", "running", "waiting"];
const CAN_RESUME = ["paused", "interrupted"];
const CAN_ABORT = ["preflight", "running", "waiting", "paused", "interrupted"];

const chart = new Chart($("chart"), $("legend"));
const noiseCard = new NoiseCard();
const unitCards = new Map(); // serial → card
let status = null;
let heardAt = null;
let newestLog = 0;
let chartCampaign = null; // which campaign the chart shows
let loadingHistory = null;

// ---- what the station says

function take({ kind, data }) {
  if (kind === "connected") {
    show($("lost"), false);
    loadLog();
    if (status) loadHistory();
  }
  if (kind === "lost") lose();
  if (kind === "status") takeStatus(data);
  if (kind === "log") addLog([data]);
}

function lose() {
  say($("lost-since"), heardAt ? heardAt.toLocaleTimeString("en-GB") : "nowhere yet");
  show($("lost"), true);
  for (const id of ["pause", "resume", "abort", "confirm"]) $(id).disabled = true;
  if (!status) say($("campaign-name"), "No station");
}

function takeStatus(document) {
  status = document;
  heardAt = new Date();
  show($("lost"), false);
  renderHead();
  renderPrompt();
  renderCampaign();
  renderChamber();
  renderUnits();
  noiseCard.take(status);
  const campaign = status.campaign ? `${status.campaign.name} ${status.campaign.started_utc_s}` : "";
  if (campaign !== chartCampaign || status.clock.process_s < (chart.last_s ?? 0)) {
    chartCampaign = campaign;
    loadHistory();
  } else if (!loadingHistory) {
    chart.append(status);
  }
}

async function loadHistory() {
  loadingHistory ??= get("history");
  try {
    chart.setHistory(await loadingHistory);
  } catch (error) {
    console.warn("no history:", error.message); // the live points still come
  }
  loadingHistory = null;
}

async function loadLog() {
  try {
    addLog((await get(`log?after=-${LOG_LINES}`)).entries);
  } catch (error) {
    console.warn("no log:", error.message);
  }
}

// ---- head, prompt, progress

function renderHead() {
  const { state, campaign } = status;
  say($("campaign-name"), campaign ? campaign.name : "No campaign");
  say($("state"), STATES[state] ?? state);
  $("state").dataset.state = state;
  show($("simulated"), status.simulated);
  say($("version"), `Soak ${status.version}`);
  const share = campaign ? `${Math.floor(100 * campaign.progress)} % · ${campaign.name} · ` : "";
  document.title = `${status.prompt ? "● Waiting for you · " : ""}${share}Soak`;
}

function renderPrompt() {
  const { prompt } = status;
  if (prompt) say($("prompt-text"), prompt.text);
  show($("prompt-inner"), prompt !== null);
  $("confirm").disabled = prompt === null;
}

function renderCampaign() {
  const { campaign, clock: time, state, reason } = status;
  show($("idle"), !campaign);
  show($("progress-card"), campaign !== null);
  if (!campaign) return;
  say($("step-text"), campaign.step_text);
  show($("reason"), reason !== null);
  say($("reason"), reason ?? "");
  $("progress").value = campaign.progress;
  say($("percent"), `${number(100 * campaign.progress, 1)} %`);
  say($("run"), `${campaign.run} of ${campaign.runs}`);
  say($("step"), `${campaign.step + 1} of ${campaign.steps}`);
  say($("remaining"), duration(campaign.remaining_s));
  show($("host-time"), time.rate !== 1);
  say($("process-label"), time.rate === 1 ? "Still to go" : "Process time to go");
  say($("host-label"), `Host time to go (rate ${time.rate})`);
  say($("remaining-host"), duration(campaign.remaining_s / time.rate));
  say($("procedure"), `${campaign.procedure} (${campaign.purpose})`);
  $("pause").disabled = !CAN_PAUSE.includes(state);
  $("resume").disabled = !CAN_RESUME.includes(state);
  $("abort").disabled = !CAN_ABORT.includes(state);
}

// ---- devices

function renderChamber() {
  const { chamber, fixture } = status;
  say($("air"), number(chamber.air_c, 2));
  say($("set-point"), `${number(chamber.set_point_c, 1)} °C`);
  say($("output"), `${number(chamber.output_percent, 0)} %${chamber.running === false ? ", stopped" : ""}`);
  say($("fixture"), fixtureText(fixture));
  const old = chamber.connected && chamber.age_s > 10;
  say($("chamber-link"), !chamber.connected ? "not connected" : old ? `${duration(chamber.age_s)} old` : "connected");
  $("chamber-link").dataset.state = !chamber.connected ? "failed" : old ? "waiting" : "finished";
  $("chamber").classList.toggle("stale", !chamber.connected);
  const alarms = chamber.alarms.join("\n");
  if ($("alarms").dataset.text !== alarms) {
    $("alarms").dataset.text = alarms;
    $("alarms").replaceChildren(...chamber.alarms.map((text) => element("li", text)));
  }
  say($("chamber-about"), chamber.description);
}

function fixtureText(fixture) {
  if (!fixture.connected) return "not connected";
  return fixture.moving ? "moving" : (fixture.position ?? UNKNOWN);
}

function renderUnits() {
  const serials = new Set(status.units.map((unit) => unit.serial));
  for (const [serial, card] of unitCards) {
    if (serials.has(serial)) continue;
    card.remove();
    unitCards.delete(serial);
  }
  for (const unit of status.units) renderUnit(unitCards.get(unit.serial) ?? newUnitCard(unit.serial), unit);
}

function newUnitCard(serial) {
  const card = $("unit-template").content.firstElementChild.cloneNode(true);
  card.setAttribute("aria-label", `Unit ${serial}`);
  unitCards.set(serial, card);
  $("units").append(card);
  return card;
}

function renderUnit(card, unit) {
  const part = (name) => card.querySelector(`.${name}`);
  say(part("serial"), unit.serial);
  say(part("slot"), `slot ${unit.slot}`);
  say(part("unit-state"), unit.powered === false ? "off" : unit.state);
  say(part("temp"), number(unit.temp_c, 2));
  say(part("stable"), unit.stable ? "✓ stable" : "settling");
  part("stable").classList.toggle("yes", unit.stable);
  say(part("slope"), `${number(unit.slope_kpmin, 3)} ± ${number(unit.slope_half_width_kpmin, 3)}`);
  say(part("position"), unit.position ?? UNKNOWN);
  say(part("samples"), count(unit.samples));
  say(part("lost"), count(unit.lost));
  part("lost").classList.toggle("bad", unit.lost > 0);
  const reading = (value) => number(value, 3);
  fillAxes(part("gyro"), unit.gyro_dps, reading);
  fillAxes(part("accel"), unit.accel_mps2, reading);
  say(part("tau"), significant(unit.noise.tau_s, 2));
  const noiseOf = (kind) => (value) => significant(value === undefined ? null : value * KINDS[kind].factor, 3);
  fillAxes(part("gyro-noise"), unit.noise.gyro_dps, noiseOf("gyro"));
  fillAxes(part("accel-noise"), unit.noise.accel_mps2, noiseOf("accel"));
  say(part("about"), unit.type + (unit.simulated ? " · simulated" : ""));
}

function fillAxes(row, values, text) {
  row.querySelectorAll("td").forEach((cell, axis) => say(cell, text(values?.[axis])));
}

// ---- events

/** Entries come in the order of their numbers; those that are shown already are passed over. */
function addLog(entries) {
  for (const entry of entries) {
    if (entry.number <= newestLog) continue;
    newestLog = entry.number;
    const line = document.createElement("li");
    line.dataset.kind = entry.kind;
    line.append(element("time", clock(entry.utc_s)), element("span", entry.subject), element("span", entry.text));
    $("log").prepend(line);
  }
  while ($("log").childElementCount > LOG_LINES) $("log").lastElementChild.remove();
  show($("log-empty"), $("log").childElementCount === 0);
}

// ---- what the user says

function userName() {
  return $("user").value.trim() || "web page";
}

/** Sends a command; a refusal is shown until the next command. */
async function command(name, body) {
  show($("failure"), false);
  try {
    await send(name, { user: userName(), ...body });
  } catch (error) {
    say($("failure"), `${name}: ${error.message}`);
    show($("failure"), true);
  }
}

function rememberUser() {
  $("user").value = localStorage.getItem("soak-user") ?? "";
  $("user").addEventListener("change", () => localStorage.setItem("soak-user", userName()));
}

function connectButtons() {
  $("pause").addEventListener("click", () => command("pause"));
  $("resume").addEventListener("click", () => command("resume"));
  $("confirm").addEventListener("click", () => command("confirm", { prompt: status.prompt.id }));
  $("abort").addEventListener("click", () => {
    $("abort-reason").value = "";
    $("abort-dialog").showModal();
  });
  $("abort-cancel").addEventListener("click", () => $("abort-dialog").close());
  $("abort-form").addEventListener("submit", () => command("abort", { reason: $("abort-reason").value.trim() }));
}

rememberUser();
connectButtons();
subscribe(take);
