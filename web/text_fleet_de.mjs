// SPDX-License-Identifier: Apache-2.0
// What the comparison of a type's units says, in German.

import { plural } from "./format.mjs";

const apart = (count) => (count === 0 ? "Kein Prüfling weicht" : plural(count, { one: `${count} Prüfling weicht`, other: `${count} Prüflinge weichen` }));
const moved = (count) => (count === 0 ? "keiner hat" : plural(count, { one: `${count} hat`, other: `${count} haben` }));

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
  summary: (unlike, drifted) => `${apart(unlike)} von den anderen ab; ${moved(drifted)} sich seit dem Modell davor verschoben.`,
  few: (fewest) => ` Bei weniger als ${fewest} Modellen wird keines als Ausreißer gekennzeichnet.`,
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
    about: (count, serials) => `${plural(count, { one: `${count} Prüfling`, other: `${count} Prüflinge` })}; ${
      serials.length === 0 ? "keiner weicht ab" : plural(serials.length, { one: `${serials[0]} weicht ab`, other: `${serials.join(", ")} weichen ab` })}`,
    median: "Median",
    spread: "eine Streuung nach beiden Seiten",
    each: "jeder Prüfling",
    some: (drawn, count) => `${drawn} von ${count} Prüflingen`,
    more: (count) => plural(count, { one: `und ${count} weiterer, der abweicht`, other: `und ${count} weitere, die abweichen` }),
  },
  outlier: (curve, distance, temp_c) => `${curve}: ${distance} Streuungen, am weitesten bei ${temp_c} °C`,
  drift: (curve, change, temp_c, band) => `${curve}: ${change} bei ${temp_c} °C, Band ±${band}`,
};
