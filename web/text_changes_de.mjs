// SPDX-License-Identifier: Apache-2.0
// The words of the changes that are made to a procedure, in German.

import { plural } from "./format.mjs";

/** @type {typeof import("./text_changes_en.mjs").text} */
export const text = {
  points: "Sollwerte in °C, in der Reihenfolge eines Laufs",
  pointsHint: (example) => `So schreiben: ${example}.`,
  reference: (temp) => ` Jeder Lauf beginnt und endet außerdem bei ${temp} °C; dort werden die Läufe miteinander verglichen.`,
  rest: "Temperatur in °C",
  ramp: "Temperaturen in °C, zu denen die Rampe fährt, in dieser Reihenfolge",
  evenly: "Oder gleichmäßig eintragen",
  from: "Von, °C",
  to: "Bis, °C",
  every: "Schritt, K",
  fill: "Eintragen",
  course: "Richtung",
  once: "Wie sie dastehen, einmal",
  andBack: "Hin und wieder zurück",
  runs: "Läufe",
  runsHint: "Ein Lauf geht über alle Sollwerte, vom Einschalten bis zum Ausschalten.",
  soak: "Warten mindestens, min",
  soakHint: "Vor der Aufnahme. Gezählt, sobald die Luft den Sollwert erreicht hat. Braucht ein Prüfling länger, dauert es länger.",
  dwell: "Aufnahme je Lage, min",
  dwellAtRest: "Aufnahme, min",
  name: "Name des geänderten Prüfablaufs",
  nameHint: (source) => `${source} bleibt, wie er ist. Der geänderte wird beim Starten oder Einreihen unter diesem Namen aufgehoben und steht von da an in der Liste.`,
  undo: "Änderungen zurücknehmen",
  changed: (what) => `Geändert: ${what}`,
  mistake: "da ist ein Fehler",
  somePoints: (count) => plural(count, { one: `${count} Sollwert`, other: `${count} Sollwerte` }),
  someRuns: (count) => plural(count, { one: `${count} Lauf`, other: `${count} Läufe` }),
  soakShort: (minutes) => `${minutes} min Warten`,
  dwellShort: (minutes) => `${minutes} min Aufnahme`,
  noPoints: "Mindestens eine Temperatur eingeben.",
  noTemperature: (word) => `„${word}“ ist keine Temperatur.`,
  noNumber: "Eine Zahl eingeben.",
  noWhole: "Eine ganze Zahl ab 1 eingeben.",
  noStep: "Drei Zahlen eingeben; der Schritt ist größer als 0.",
  tooMany: (most) => `Das sind mehr als ${most} Sollwerte: größere Schritte nehmen.`,
  noName: "1 bis 60 Buchstaben von a bis z, Ziffern, - und _; zuerst ein Buchstabe oder eine Ziffer.",
  nameTaken: (name) => `Einen Prüfablauf ${name} gibt es schon: einen anderen Namen wählen.`,
};
