// SPDX-License-Identifier: Apache-2.0
// All units of a type beside each other: yield, who stands out, what has moved since the models before.

import { Axis } from "./axes.mjs";
import { get } from "./api.mjs";
import { $, element, english, say, show } from "./dom.mjs";
import { BELOW, draw, Panel, TOP } from "./figure.mjs";
import { CURVES, driftText, F, findingsOf, isCompared, noneMarked, outlierText, ruleText, shownUnit, summaryOf, yieldOf } from "./fleet_words.mjs";
import { UNKNOWN } from "./format.mjs";
import { badge } from "./runs_view.mjs";
import { styled } from "./style_sheet.mjs";
import { sensorText, verdictOf } from "./unit_words.mjs";
import { unitAddress } from "./views.mjs";

const HEIGHT = 260;
const COLOURS = ["unit-6", "unit-1", "unit-3", "unit-5"];
const PARTS = ["fleet-yield", "fleet-summary", "fleet-rule", "fleet-units-card", "fleet-curves"];

const LAST = "soak-fleet-type"; // the type that was looked at last

/** The type that was looked at last, else the one with most units; "" where there is none. */
function typeToBegin(counts) {
  const last = localStorage.getItem(LAST);
  if (counts.has(last)) return last;
  return [...counts].sort(([a, few], [b, many]) => many - few || (a < b ? -1 : 1))[0]?.[0] ?? "";
}

/** Where the page of a type is. */
const fleetAddress = (type) => `#${new URLSearchParams({ fleet: type })}`;

export class FleetView {
  #styled = styled("fleet.css");
  #asked = null; // the type that the page shows
  #fleet = null; // its document
  #findings = new Map();
  #opened = 0;

  constructor() {
    $("fleet-type").addEventListener("change", () => { location.hash = fleetAddress($("fleet-type").value); });
    $("fleet-marked").addEventListener("change", () => this.#renderUnits());
    for (const curve of CURVES) $(`fleet-${curve}`).addEventListener("change", () => this.#renderCurves());
  }

  async open(parameters) {
    const mine = ++this.#opened;
    this.#asked = parameters.get("fleet");
    if (this.#asked !== this.#fleet?.type) this.#hideParts();
    show($("fleet-failure"), false);
    try {
      const { units } = await get("units");
      await this.#styled;
      if (mine !== this.#opened) return; // somebody has gone on meanwhile
      const counts = new Map();
      for (const { type } of units) counts.set(type, (counts.get(type) ?? 0) + 1);
      const types = [...counts.keys()].sort();
      this.#asked ||= typeToBegin(counts);
      if (counts.has(this.#asked)) localStorage.setItem(LAST, this.#asked);
      this.#offer(types);
      const type = this.#asked;
      if (type === "") return;
      say($("fleet-nothing"), F.reading);
      const fleet = await get(`fleet?${new URLSearchParams({ type })}`);
      if (mine === this.#opened) this.#take(fleet);
    } catch (error) {
      if (mine !== this.#opened) return;
      this.#hideParts();
      say($("fleet-nothing"), "");
      say($("fleet-failure"), error.message);
      show($("fleet-failure"), true);
    }
  }

  #hideParts() {
    for (const part of PARTS) show($(part), false);
  }

  #offer(types) {
    $("fleet-type").replaceChildren(...types.map((type) => Object.assign(element("option", type), { value: type })));
    $("fleet-type").value = this.#asked;
    $("fleet-type").disabled = types.length === 0;
    if (types.length === 0) say($("fleet-nothing"), F.noUnits);
  }

  #take(fleet) {
    this.#fleet = fleet;
    this.#findings = findingsOf(fleet);
    for (const part of PARTS) show($(part), true);
    const left = fleet.not_listed;
    say($("fleet-nothing"), left > 0 ? F.notListed(fleet.units.length, left) : "");
    $("fleet-yield").replaceChildren(...yieldOf(fleet).map(([name, value]) => {
      const box = element("div", "");
      box.append(element("dt", name), element("dd", value));
      return box;
    }));
    say($("fleet-summary"), summaryOf(fleet, this.#findings));
    say($("fleet-rule"), ruleText(fleet));
    this.#renderUnits();
    this.#renderCurves();
  }

  #found(serial) {
    return this.#findings.get(serial) ?? { outliers: [], drifts: [] };
  }

  #renderUnits() {
    const rank = ({ unit, verdict }) => {
      const { outliers, drifts } = this.#found(unit);
      return (outliers.length > 0 ? 4 : 0) + (verdict === "fail" ? 2 : 0) + (drifts.length > 0 ? 1 : 0);
    };
    const onlyMarked = $("fleet-marked").checked;
    const units = this.#fleet.units.filter((unit) => !onlyMarked || rank(unit) > 0).sort((a, b) => rank(b) - rank(a));
    show($("fleet-units-none"), units.length === 0);
    say($("fleet-units-none"), noneMarked(this.#fleet));
    $("fleet-units").tBodies[0].replaceChildren(...units.map((unit) => this.#row(unit)));
  }

  #row(unit) {
    const row = element("tr", "");
    const link = Object.assign(element("a", unit.unit), { href: unitAddress(unit.unit) });
    const { title, state } = verdictOf(unit.verdict);
    const { outliers, drifts } = this.#found(unit.unit);
    const cell = (...parts) => {
      const node = element("td", "");
      node.append(...parts);
      return node;
    };
    const lines = (texts) => (texts.length === 0 ? [UNKNOWN] : texts.map((text) => element("p", text)));
    const why = whyNotJudged(unit);
    row.append(cell(link), cell(badge({ text: title, state }), ...(why === null ? [] : [whyLine(why)])),
      cell(...lines(outliers.map(outlierText))), cell(...lines(drifts.map(driftText))));
    return row;
  }

  #renderCurves() {
    const curve = $("fleet-scale").checked ? "scale" : "bias";
    const drawn = Object.entries(this.#fleet.sensors).filter(([, sensor]) => sensor[curve] !== null);
    $("fleet-sensors").replaceChildren(...drawn.map(([name, sensor]) => sensorCard(name, sensor, curve, isCompared(this.#fleet))));
    if (drawn.length === 0) $("fleet-sensors").replaceChildren(element("p", F.curves.none));
  }
}

function whyLine(why) {
  const line = Object.assign(element("p", ""), { className: "why" });
  line.append(why);
  return line;
}

/** In the page's words, or the station's in an element; null where the newest model is judged. */
function whyNotJudged({ trouble, model, epoch }) {
  if (trouble !== null) return english(trouble);
  if (model === null) return F.list.noModel;
  return model.epoch === epoch ? null : F.list.changed;
}

/** [temperature, value] where there is one. */
const pointsOf = (temps_c, values, factor) => values.map((value, i) => [temps_c[i], value === null ? null : factor * value]).filter(([, value]) => value !== null);

function axisOf(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = high > low ? 0.06 * (high - low) : Math.max(0.1 * Math.abs(low), 1e-3);
  return new Axis(low - room, high + room);
}

/** Thin lines of all units behind those that stand out and the median; `enough`: units to say which do. */
function sensorCard(name, sensor, curve, enough) {
  const { temp_c: temps_c, median, spread, units } = sensor[curve];
  const { unit, factor } = shownUnit(sensor, curve);
  const lines = units.filter(({ values }) => values !== null).map(({ unit: serial, values, outlier }) => ({ serial, outlier, points: pointsOf(temps_c, values, factor) }));
  const middle = pointsOf(temps_c, median, factor);
  const band = temps_c.map((temp_c, i) => [temp_c, median[i], spread[i]]).filter(([, value, half]) => value !== null && half !== null)
    .map(([temp_c, value, half]) => [temp_c, factor * (value - half), factor * (value + half)]);
  const card = element("section", "");
  card.className = "card sensor";
  const title = element("h3", sensorText(name));
  title.id = `fleet-of-${name}`;
  card.setAttribute("aria-labelledby", title.id);
  const figure = element("figure", "");
  const apart = lines.filter(({ outlier }) => outlier);
  const caption = element("figcaption", "");
  caption.append(element("b", F.curves.label(F.curves.names[curve], sensorText(name))), element("span", F.curves.about(units.length, apart.map(({ serial }) => serial), enough)));
  figure.append(caption);
  const values = lines.flatMap(({ points }) => points.map(([, value]) => value));
  const room = temps_c.length > 1 ? 0 : 1;
  const panel = new Panel(TOP, HEIGHT - BELOW, new Axis(temps_c[0] - room, temps_c.at(-1) + room), axisOf([...values, ...band.flatMap(([, low, high]) => [low, high])]),
    F.curves.axes.temp, F.curves.axes[curve](unit));
  panel.band(band, "pi95");
  // A few units all have a colour and a name; of many, those that stand out.
  const named = lines.length <= COLOURS.length ? lines : apart;
  for (const { points } of lines.filter((line) => !named.includes(line))) drawLine(panel, points, "each");
  for (const [i, { points }] of named.entries()) drawLine(panel, points, `apart ${COLOURS[i % COLOURS.length]}`);
  drawLine(panel, middle, "curve");
  const legend = [["line curve", F.curves.median], ...(band.length > 0 ? [["band pi95", F.curves.spread]] : []),
    ...(named.length < lines.length ? [["line each", units.length > lines.length ? F.curves.some(lines.length, units.length) : F.curves.each]] : []),
    ...named.slice(0, COLOURS.length).map(({ serial }, i) => [`line ${COLOURS[i]}`, serial])];
  if (named.length > COLOURS.length) legend.push(["none", F.curves.more(named.length - COLOURS.length)]);
  draw(figure, HEIGHT, [panel], legend);
  caption.firstElementChild.remove(); // the card's title says it
  card.append(title, figure);
  return card;
}

/** A curve of one temperature is a dot. */
function drawLine(panel, points, style) {
  if (points.length === 1) panel.marks(points, "dot", style);
  else panel.line(points, style);
}
