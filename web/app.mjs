// SPDX-License-Identifier: Apache-2.0
// The station's page: what /api/v1 says, and what a user can tell it.

import { mayOperate, showAccount } from "./account.mjs";
import { connectAlerts, renderAlerts } from "./alerts.mjs";
import { get, send, subscribe } from "./api.mjs";
import { confirmsItself, dismiss, openAbortDialog, renderCampaign, renderDoor, renderHead, renderPrompt } from "./campaign_cards.mjs";
import { Chart } from "./chart.mjs";
import { renderChamber, renderUnits } from "./device_cards.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { clock, readable, timeText } from "./format.mjs";
import { NoiseCard } from "./noise_card.mjs";
import { StartForm } from "./start_form.mjs";
import { StoredCard } from "./stored_card.mjs";
import { connectLanguage, T, textsOf } from "./text.mjs";
import { connectViews } from "./views.mjs";
import { stepAt } from "./words.mjs";

const HEAD_MARGIN_PX = 8; // between the head and what is scrolled to
const LOG_LINES = 100;
const NOT_IN_THIS_STATE = 409; // docs/http-api.md

connectLanguage($("language"));
const chart = new Chart($("chart"), $("legend"));
const noiseCard = new NoiseCard();
const startForm = new StartForm(userName);
const storedCard = new StoredCard(startForm);
const heedful = []; // views that follow what is recorded, once their modules are loaded
let status = null;
let plan = null;
let planOf = null; // which campaign the plan is of
let planAsked = null; // campaign and step that it was asked for last
let heardAt = null;
let newestLog = 0;
let chartCampaign = null; // which campaign the chart shows
let loadingHistory = null;
let confirmedItself = null; // the prompt that was answered without a click

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
  say($("lost-since"), heardAt ? timeText(heardAt) : T.lost.nowhere);
  show($("lost"), true);
  for (const id of ["pause", "resume", "next", "abort", "confirm"]) $(id).disabled = true;
  show($("prompt-inner"), false); // whether it still asks is not known
  canAsk(false);
  $("door").dataset.lamp = "unknown";
  say($("door-title"), T.door.unknown);
  say($("door-text"), T.lost.door); // what it said last may have come to pass, or not
  if (!status) say($("campaign-name"), T.head.noStation);
}

/** Whether there is a station to ask: else neither queue nor start can be used. */
function canAsk(can) {
  for (const id of ["queue-list", "start-card"]) $(id).inert = !can;
}

function takeStatus(document) {
  status = document;
  canAsk(true);
  heardAt = new Date();
  show($("lost"), false);
  const campaign = status.campaign ? `${status.campaign.name} ${status.campaign.started_utc_s}` : "";
  if (campaign !== planOf) plan = null; // that of another campaign says nothing of this one, nor of none
  render();
  noiseCard.take(status);
  startForm.take(status);
  storedCard.take(status);
  for (const view of heedful) view.take(status);
  if (confirmsItself(status) && mayOperate() && status.prompt.id !== confirmedItself) {
    confirmedItself = status.prompt.id;
    confirm({ itself: true });
  }
  loadPlan(campaign);
  if (campaign !== chartCampaign || status.clock.process_s < (chart.last_s ?? 0)) {
    chartCampaign = campaign;
    loadHistory();
  } else if (!loadingHistory) {
    chart.append(status);
  }
}

function render() {
  renderHead(status);
  renderAlerts(status);
  renderPrompt(status, plan);
  renderCampaign(status, plan);
  renderDoor(status, plan);
  renderChamber(status);
  renderUnits(status);
  show($("noise"), status.units.length > 0);
}

/** Only the steps around the present one, whenever that is not among them: all those of twenty runs weigh more than everything else together. */
async function loadPlan(campaign) {
  const step = Math.min(status.campaign?.step ?? 0, (status.campaign?.steps ?? 1) - 1); // at the end it is beyond the last
  const asked = `${campaign} ${step}`;
  if (asked === planAsked || (campaign === planOf && plan !== null && stepAt(plan, step))) return;
  planAsked = asked;
  planOf = campaign;
  try {
    const found = campaign ? await get(`plan?around=${step}`) : null;
    if (asked === planAsked) plan = found;
  } catch (error) {
    console.warn("no plan:", error.message); // the station's own words for the step remain
  }
  render();
}

async function loadHistory() {
  loadingHistory ??= get("history");
  try {
    chart.setHistory(await loadingHistory, status.clock);
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

// ---- events

/** Entries come in the order of their numbers; those that are shown already are passed over. */
function addLog(entries) {
  for (const entry of entries) {
    if (entry.number <= newestLog) continue;
    newestLog = entry.number;
    const line = document.createElement("li");
    line.dataset.kind = entry.kind;
    line.append(element("time", clock(entry.utc_s)), element("span", entry.subject), element("span", readable(entry.text)));
    $("log").prepend(line);
  }
  while ($("log").childElementCount > LOG_LINES) $("log").lastElementChild.remove();
  show($("log-empty"), $("log").childElementCount === 0);
}

// ---- what the user says

/** Who is at the page, "" where nobody has said so. */
const operator = () => $("user").value.trim();

function userName() {
  return operator() || "web page";
}

/**
 * Sends a command; a refusal is shown until the next command. `mayBeLate`: nobody is told that it is not possible any
 * more in the station's state.
 */
async function command(name, body, mayBeLate = false) {
  show($("failure"), false);
  try {
    await send(name, { user: userName(), ...body });
  } catch (error) {
    if (mayBeLate && error.status === NOT_IN_THIS_STATE) return;
    $("failure").replaceChildren(`${T.campaign.command(name)}: `, english(error.message));
    show($("failure"), true);
  }
}

function rememberUser() {
  $("user").value = localStorage.getItem("soak-user") ?? "";
  $("user").addEventListener("change", () => localStorage.setItem("soak-user", operator()));
  $("itself").checked = localStorage.getItem("soak-itself") === "yes";
  $("itself").addEventListener("change", () => localStorage.setItem("soak-itself", $("itself").checked ? "yes" : "no"));
}

/** `itself`: without a click, and then perhaps after another page or the station itself has closed the prompt. */
const confirm = ({ itself = false } = {}) => command("confirm", { prompt: status.prompt.id }, itself);

function connectButtons() {
  $("pause").addEventListener("click", () => command("pause"));
  $("resume").addEventListener("click", () => command("resume"));
  $("next").addEventListener("click", () => command("next", { campaign: status.queue.campaigns[0]?.name }));
  $("queue-list").addEventListener("click", ({ target }) => {
    if (target.dataset.campaign) command("unqueue", { campaign: target.dataset.campaign });
  });
  $("confirm").addEventListener("click", () => confirm());
  $("dismiss").addEventListener("click", () => {
    dismiss(status);
    render();
    $("start-box").querySelector("summary").focus(); // the button is gone
  });
  $("abort").addEventListener("click", () => openAbortDialog(status, plan));
  $("abort-cancel").addEventListener("click", () => $("abort-dialog").close());
  $("abort-form").addEventListener("submit", () => command("abort", { reason: $("abort-reason").value.trim() }));
}

/**
 * A view whose module and texts are loaded when somebody first goes there: the station's own page must be there soon.
 * @param {string[]} groups of texts that its modules ask for
 * @param {() => Promise<any>} load
 */
function whenAsked(groups, load) {
  let view = null;
  const loadAll = async () => {
    await Promise.all(groups.map(textsOf));
    return load();
  };
  return {
    /**
     * Comes back once its texts are written; what it shows comes later.
     * @param {URLSearchParams} parameters
     */
    async open(parameters) {
      view ??= loadAll();
      view.catch(() => (view = null)); // another try may find the station
      (await view).open(parameters);
    },
  };
}

/** A view that has take(status). */
function heeding(view) {
  heedful.push(view);
  if (status) view.take(status);
  return view;
}

/** What is scrolled to, or gets the focus, does not lie under the head, however many lines that has. */
function keepBelowHead() {
  const head = /** @type {HTMLElement} */ (document.querySelector("header.top"));
  new ResizeObserver(() => { document.documentElement.style.scrollPaddingTop = `${head.offsetHeight + HEAD_MARGIN_PX}px`; }).observe(head);
}

keepBelowHead();
rememberUser();
showAccount().catch((error) => console.warn("no account:", error.message));
connectButtons();
connectAlerts();
connectViews({
  station: { open: () => Promise.all([startForm.open(), storedCard.open()]) },
  runs: whenAsked(["runs"], async () => heeding(new (await import("./runs_view.mjs")).RunsView(userName))),
  run: whenAsked(["runs"], async () => new (await import("./run_view.mjs")).RunView(operator)),
  units: whenAsked(["units", "runs"], async () => heeding(new (await import("./units_view.mjs")).UnitsView(userName))),
  unit: whenAsked(["units", "gap", "runs"], async () => heeding(new (await import("./unit_view.mjs")).UnitView(userName))),
  fleet: whenAsked(["units", "fleet", "runs"], async () => new (await import("./fleet_view.mjs")).FleetView()),
  events: whenAsked(["events"], async () => new (await import("./events_view.mjs")).EventsView()),
  records: whenAsked(["records", "units", "runs"], async () => new (await import("./records_view.mjs")).RecordsView(userName, operator)),
  help: whenAsked([], async () => new (await import("./help_view.mjs")).HelpView()),
});
subscribe(take);
