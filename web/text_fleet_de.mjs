// SPDX-License-Identifier: Apache-2.0
// What the comparison of a type's units says, in German.

import { plural } from "./format.mjs";

/** @type {typeof import("./text_fleet_en.mjs").text} */
export const text = {
  title: "Flotte",
  type: "Typ",
  curve: "Kurve",
  reading: "Modelle werden gelesen…",
  noUnits: "Noch ist kein Prüfling bekannt: einen Lauf aufzeichnen oder importieren.",
  notListed: (listed, left) => `Die letzten ${listed} nach Seriennummer; ${left} weitere werden nicht verglichen.`,
  yield: { units: "Prüflinge", notJudged: "Nicht beurteilt", ofJudged: "Ausbeute, von den beurteilten" },
  noModels: "Von diesem Typ hat noch kein Prüfling ein Modell: einen anpassen.",
  oneModel: "Nur ein Prüfling dieses Typs hat ein Modell: Noch gibt es nichts zu vergleichen.",
  ownDrift: (hasMoved) => ` Er hat sich seit dem Modell davor ${hasMoved ? "" : "nicht "}verschoben.`,
  apart: (count) => `${count === 0 ? "Kein Prüfling weicht" : plural(count, { one: `${count} Prüfling weicht`, other: `${count} Prüflinge weichen` })} von den anderen ab.`,
  few: (count, fewest) => `Zu wenige Prüflinge, um zu sagen, welcher anders als die anderen ist: ${count} haben ein Modell, ${fewest} sind nötig.`,
  moved: (count, of) => (of === 0 ? "Ob sich einer verschoben hat, ist nicht bekannt: Dazu braucht es zwei Modelle desselben Prüflings, jedes aus mehreren Läufen."
    : `Von ${plural(of, { one: `${of} Prüfling`, other: `${of} Prüflingen` })} mit einem Modell davor ${
      count === 0 ? "hat sich keiner" : plural(count, { one: `hat sich ${count}`, other: `haben sich ${count}` })} seitdem verschoben.`),
  rule: (distance, fewest) =>
    `Ein Prüfling ist gekennzeichnet, wo seine Kurve um mehr als ${distance} Streuungen von der Mediankurve abweicht (quadratisches Mittel über die Temperaturen, alle 5 °C). Die Streuung ist die ` +
    "Standardabweichung der Flotte, aus dem Median der Abweichungen, damit einzelne Ausreißer sie nicht vergrößern, und nie kleiner als die Unsicherheit der Kurven. Von Prüflingen, die sich nur zufällig " +
    `unterscheiden, wird in einer Flotte von ${fewest} etwa 1 von 100 gekennzeichnet, in einer größeren weniger. Verschoben heißt: Das neueste Modell weicht irgendwo von dem davor um mehr ab als die Wurzel aus ` +
    "der Summe der Quadrate beider 95-%-Bänder; diese sind so erweitert, dass alle Kurven und Temperaturen eines Prüflings zusammen dies bei höchstens 5 von 100 Prüflingen aus Zufall ergeben. Modelle aus einem " +
    "einzigen Lauf bleiben weg, denn sie zeigen nicht, wie sich ein Prüfling von Einschalten zu Einschalten unterscheidet.",
  list: {
    title: "Prüflinge",
    onlyMarked: "Nur die auffälligen",
    none: "Kein Prüfling ist auffällig.",
    fewToMark: (fewest) => `Kein Prüfling ist gekennzeichnet. Bei weniger als ${fewest} Modellen lässt sich nicht sagen, welcher anders als die anderen ist.`,
    unit: "Prüfling",
    verdict: "Urteil",
    outliers: "Anders als die anderen bei",
    drifts: "Verschoben seit dem Modell davor",
    noModel: "noch kein Modell",
    changed: "nach diesem Modell repariert oder verändert",
  },
  curves: {
    title: "Kurven aller Prüflinge",
    names: { bias: "Nullpunktfehler", scale: "Skalenfehler" },
    choices: { bias: "Nullpunkt", scale: "Skala" },
    of: { bias: (sensor) => `Nullpunktfehler, ${sensor}`, scale: (sensor) => `Skalenfehler, ${sensor}` },
    axes: { temp: "Temperatur des Prüflings, °C", bias: (unit) => `Nullpunktfehler, ${unit}`, scale: (unit) => `Skalenfehler, ${unit}` },
    none: "Kein Modell dieses Typs enthält eine solche Kurve.",
    label: (curve, sensor) => `${curve}, ${sensor}`,
    about: (count, serials, isCompared) => `${plural(count, { one: `${count} Prüfling`, other: `${count} Prüflinge` })}; ${
      !isCompared ? "zu wenige zum Vergleichen" : serials.length === 0 ? "keiner weicht ab" : plural(serials.length, { one: `${serials[0]} weicht ab`, other: `${serials.join(", ")} weichen ab` })}`,
    median: "Median",
    spread: "eine Streuung nach beiden Seiten",
    each: "jeder Prüfling",
    some: (drawn, count) => `${drawn} von ${count} Prüflingen`,
    more: (count) => plural(count, { one: `und ${count} weiterer, der abweicht`, other: `und ${count} weitere, die abweichen` }),
  },
  outlier: (curve, distance, temp_c) => `${curve}: ${distance} Streuungen, am weitesten bei ${temp_c} °C`,
  drift: (curve, change, temp_c, band) => `${curve}: ${change} bei ${temp_c} °C, Band ±${band}`,
};
