// SPDX-License-Identifier: Apache-2.0
// The gap of a unit: what its model lacks, where that shows, what accepting it has changed.

import { $, element, english, say, show, tell } from "./dom.mjs";
import { clock } from "./format.mjs";
import { acceptsNext, closedText, evidenceOf, experimentOf, G, gapNextOf, gapSureOf, gapText, gapVerdictOf, intervalText, hasFresh, isAccepted, openEffect, openRivals, outsideText, plain, sensorsText, shareText, shownText, sizeText, slowNoiseRows, biasText, biasUnitOf, stepRows } from "./gap_words.mjs";
import { heatTable, mapKey } from "./heat_map.mjs";
import { runningText } from "./job_words.mjs";
import { sensorText, stalePart } from "./unit_words.mjs";

const GAP_PARTS = ["gap-verdict", "gap-next-box", "gap-reason", "gap-map", "gap-limits", "gap-steps", "gap-slow"];

export class GapCard {
  #start;
  #unit = null; // its document
  #busy = true;
  #accepting = ""; // serial number of the unit for which the dialog was opened

  /** `start(kind, members)`: a job of the unit that is shown. */
  constructor(start) {
    this.#start = start;
    for (const kind of ["gap_find", "gap_show"]) $(kind.replace("_", "-")).addEventListener("click", () => this.#ask(kind));
    for (const which of ["before", "after"]) $(`gap-map-${which}`).addEventListener("change", () => this.#renderMap());
    $("gap-map-key").replaceChildren(...mapKey());
    $("gap-accept").addEventListener("click", () => this.#openDialog());
    $("accept-effects").addEventListener("change", () => this.#enable());
    $("accept-cancel").addEventListener("click", () => $("accept-dialog").close());
    $("accept-form").addEventListener("submit", () => this.#ask("gap_accept", { unit: this.#accepting, effects: chosenEffects() }));
    addEventListener("hashchange", () => $("accept-dialog").close()); // the page shows something else by then
  }

  /** `busy`: a job would be refused; `job`: the one that runs, or null. */
  wait(busy, job) {
    this.#busy = busy;
    const isOurs = job !== null && job.unit === this.#unit?.unit && job.kind.startsWith("gap_");
    show($("gap-running"), isOurs);
    if (isOurs) say($("gap-running"), runningText(job, Date.now() / 1000));
    this.#enable();
  }

  render(unit) {
    this.#unit = unit;
    show($("unit-gap"), unit.model !== null);
    if (unit.model === null) return;
    const { find, show: shown } = unit.gap;
    show($("gap-none"), find === null);
    for (const part of GAP_PARTS) show($(part), find !== null);
    this.#renderStale(find);
    this.#renderTerms(unit.model);
    this.#renderShown(shown);
    if (find !== null) this.#renderSearch(find);
    else $("gap-effects").replaceChildren();
    this.#enable();
  }

  #ask(kind, members) {
    $("unit-gap-title").focus(); // the button that was pressed is switched off
    this.#start(kind, members);
  }

  #enable() {
    for (const kind of ["find", "show", "accept"]) $(`gap-${kind}`).disabled = this.#busy;
    $("accept-send").disabled = this.#busy || chosenEffects().length === 0;
    const found = this.#unit?.gap.find ?? null;
    const named = found !== null && found.stale === null && found.job.result.verdict === "named" &&
      found.job.result.effects.some(({ name }) => !carriedBy(this.#unit.model).includes(name));
    show($("gap-accept"), named);
    $("gap-accept").classList.toggle("primary", named && acceptsNext(found.job.result, carriedBy(this.#unit.model)));
    $("gap-find").classList.toggle("primary", this.#unit !== null && this.#unit.gap.find === null);
    $("gap-show").classList.toggle("primary", !named && this.#unit?.model?.terms.length > 0 && this.#unit.gap.show?.stale !== null);
  }

  #renderStale(find) {
    show($("gap-stale"), find !== null && find.stale !== null);
    if (find === null) return;
    const { job } = find;
    const [version, time] = [job.result.model, clock(job.started_utc_s)];
    const isOfBefore = isAccepted(job.result, this.#unit.model);
    tell($("gap-stale"), isOfBefore ? G.card.before(version, time, job.user) : G.card.stale(version, time, job.user, find.stale === null ? "" : stalePart(find.stale)));
  }

  #renderSearch({ job: { result }, stale }) {
    const accepted = isAccepted(result, this.#unit.model);
    const { title, state } = gapVerdictOf(accepted ? "accepted" : result.verdict);
    $("gap-verdict").dataset.state = accepted || stale === null ? state : "";
    say($("gap-verdict-title"), title);
    tell($("gap-verdict-text"), gapText(result, this.#unit.model));
    const shown = this.#unit.gap.show;
    const isCompared = shown !== null && shown.stale === null && hasFresh(shown.job.result);
    tell($("gap-sure"), gapSureOf(result, this.#unit.model, isCompared));
    show($("gap-reason"), result.verdict !== "cannot_judge"); // there it stands above
    say($("gap-reason"), plain(result.reason));
    const carried = carriedBy(this.#unit.model);
    show($("gap-next-box"), accepted ? !isCompared : stale === null);
    tell($("gap-next"), gapNextOf(result, carried, checkOf(this.#unit)));
    show($("gap-how"), result.verdict === "named" && openEffect(result.effects.filter(({ name }) => !carried.includes(name))) !== undefined);
    $("gap-effects").replaceChildren(...[...result.effects, ...result.suspects].map((effect) => effectCard(effect, carried.includes(effect.name))));
    const hasMap = result.map !== undefined && result.map !== null;
    show($("gap-map"), hasMap);
    if (hasMap) this.#renderMap();
    $("gap-limits-body").replaceChildren(...limits(result));
    renderTable("gap-steps", G.steps.heads, stepRows(result.residual_structure?.steps ?? []));
    renderTable("gap-slow", G.slow.heads, slowNoiseRows(result.slow_noise ?? []));
  }

  #renderMap() {
    const { map, effects } = this.#unit.gap.find.job.result;
    const hasAfter = Object.values(map.sensors).some(({ after }) => after !== null);
    show($("gap-map-choice"), hasAfter);
    const which = hasAfter && $("gap-map-after").checked ? "after" : "before";
    const acted = new Set(effects.flatMap(({ sensors }) => sensors));
    const sensors = Object.entries(map.sensors).sort(([a], [b]) => Number(acted.has(b)) - Number(acted.has(a)));
    $("gap-maps").replaceChildren(...sensors.map(([name, sensor]) => {
      const box = element("div", "");
      box.className = "scroll";
      box.tabIndex = 0;
      box.role = "region";
      box.ariaLabel = G.map.label(sensorText(name));
      box.append(heatTable(name, sensor, sensor[which] ?? sensor.before, map));
      return box;
    }));
  }

  #renderTerms({ terms }) {
    show($("gap-terms-box"), terms.length > 0);
    $("gap-terms").replaceChildren(...terms.map(({ sizes, lab_only: labOnly }) => {
      const line = element("li", "");
      line.append(english(plain(sizes.join("; "))), Object.assign(element("span", ` ${labOnly ? G.card.labOnly : G.card.inFile}`), { className: "why" }));
      return line;
    }));
  }

  #renderShown(shown) {
    show($("gap-shown"), shown !== null);
    if (shown === null) return;
    const { job: { result, started_utc_s: started, user }, stale } = shown;
    const old = stale === null ? [] : G.shown.stale(stalePart(stale));
    tell($("gap-shown-text"), [shownText(result), G.shown.compared(clock(started), user), ...old]);
    $("gap-shown-table").replaceChildren(...shownTable(result));
    $("gap-remarks").replaceChildren(...result.remarks.map((text) => element("li", text)));
  }

  #openDialog() {
    const { unit, model, gap } = this.#unit;
    this.#accepting = unit;
    const carried = carriedBy(model);
    const { effects } = gap.find.job.result;
    // Without plateaus an effect stands there once for each shape; it is accepted by its name.
    const names = [...new Set(effects.map(({ name }) => name))];
    $("accept-effects").replaceChildren(element("legend", G.accept.effects), ...names.map((name) => {
      const line = element("label", "");
      const isCarried = carried.includes(name);
      const box = Object.assign(element("input", ""), { type: "checkbox", value: name, checked: !isCarried, disabled: isCarried });
      line.append(box, ` ${G.effect(name)}: ${effects.filter((effect) => effect.name === name).map((effect) => `${sizeText(effect)}, ${sensorsText(effect.sensors)}, ${shareText(effect)}`).join("; ")}`);
      if (isCarried) line.append(Object.assign(element("span", ` ${G.accept.carried}`), { className: "why" }));
      return line;
    }));
    const rivals = [...new Set(effects.filter((effect) => !carried.includes(effect.name)).flatMap(openRivals))];
    say($("accept-text"), G.accept.what(model.version + 1, model.version));
    show($("accept-rivals"), rivals.length > 0);
    say($("accept-rivals"), G.accept.rivals(rivals));
    this.#enable();
    $("accept-dialog").showModal();
  }
}

/** Names of the effects that a model has. */
const carriedBy = (model) => (model?.terms ?? []).map(({ name }) => name);

/** The newest check campaign with runs that no fit has seen; null without one. */
const checkOf = ({ verify_with: fresh }) => fresh.find(({ purpose }) => purpose === "verification")?.campaign ?? null;

const chosenEffects = () => [...$("accept-effects").querySelectorAll("input:checked")].map(({ value }) => value);

/** `isCarried`: by the model; no experiment is asked for then. */
function effectCard(effect, isCarried) {
  const card = element("section", "");
  card.className = "effect";
  const title = element("h3", effect.status === "named" ? G.effectTitle(effect.name) : G.evidence.suspected(effect.name));
  const list = element("dl", "");
  list.className = "facts";
  list.append(...evidenceOf(effect).map(([name, value]) => {
    const box = element("div", "");
    box.append(element("dt", name), element("dd", value));
    return box;
  }));
  card.append(title, Object.assign(element("p", effect.physics), { lang: "en" }), list);
  if (outsideText(effect)) card.append(element("p", outsideText(effect)));
  const experiment = experimentOf(effect, isCarried);
  if (experiment !== null) card.append(told("p", [G.evidence.experiment, { english: plain(experiment) }, "."]));
  return card;
}

/** An element that says a sentence of parts. */
function told(name, parts) {
  const node = element(name, "");
  tell(node, parts);
  return node;
}

/** A table with a head; rows of texts, the first of each names it. */
function tableParts(heads, rows) {
  const top = element("thead", "");
  const head = element("tr", "");
  head.append(...heads.map((text) => Object.assign(element("th", text), { scope: "col" })));
  top.append(head);
  const body = element("tbody", "");
  body.append(...rows.map(([name, ...values]) => {
    const line = element("tr", "");
    line.append(Object.assign(element("th", name), { scope: "row" }), ...values.map((text) => element("td", text)));
    return line;
  }));
  return [top, body];
}

/** The box with that id and its table `ID-table`; nothing of it without rows. */
function renderTable(id, heads, rows) {
  show($(id), rows.length > 0);
  $(`${id}-table`).replaceChildren(...tableParts(heads, rows));
}

/** Fresh runs first: they are what counts. */
function shownTable({ sensors, terms }) {
  const accepted = terms.at(-1)?.gap ?? {};
  const rows = ["fresh", "fitted"].flatMap((use) => Object.entries(sensors).filter(([, sensor]) => sensor[use] !== null).map(([name, sensor]) => {
    const part = sensor[use];
    const closed = use === "fresh" ? closedText(part.closed_fraction) : "–";
    return [sensorText(name), G.shown.uses[use], biasText(part.before_rms, 3), biasText(part.after_rms, 3), biasText(part.floor_rms, 3), biasUnitOf(name), closed,
      use === "fresh" ? intervalText(accepted[name]?.closed_ci95) : "–"];
  }));
  return tableParts(G.shown.heads, rows);
}

function limits({ detection_limit: limit, not_testable: notTestable, rejected_by_gate: rejected, gap }) {
  const parts = [];
  const sensors = Object.keys(limit);
  if (sensors.length > 0) {
    const table = element("table", "");
    table.className = "list figures";
    table.append(...tableParts(G.limits.heads,
      sensors.map((name) => [sensorText(name), biasText(limit[name]), biasText(gap[name]?.before_rms, 3), biasText(gap[name]?.after_rms, 3), biasText(gap[name]?.floor_rms, 3), biasUnitOf(name)])));
    const box = element("div", "");
    box.className = "scroll";
    box.tabIndex = 0;
    box.role = "region";
    box.ariaLabel = G.limits.label;
    box.append(table);
    parts.push(box);
  }
  const list = element("ul", "");
  list.className = "remarks";
  list.append(...notTestable.map(({ name, why }) => told("li", [G.limits.notTestable(name), { english: why }])),
    ...rejected.map(({ run, sensor, segments, of, why }) => told("li", [G.limits.rejected(run, sensor && sensorText(sensor), segments, of), { english: why }])));
  return [...parts, list];
}
