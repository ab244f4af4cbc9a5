// SPDX-License-Identifier: Apache-2.0
// What the views of units say, in German. Warnings and sensors are said by their names in the interface; one that is not known here keeps its own.

import { plural } from "./format.mjs";
import { WARNINGS } from "./text_warnings_de.mjs";

const KINDS = { gyro: "Drehrate", accel: "Beschleunigung" };
const CURVES = { poly3: "Polynom 3. Grades", poly5: "Polynom 5. Grades", spline: "Spline", constant: "Konstante" };

function sensorName(sensor) {
  const [kind, axis] = sensor.split("_");
  return Object.hasOwn(KINDS, kind) ? `${KINDS[kind]} ${axis}` : sensor;
}

/** @type {typeof import("./text_units_en.mjs").text} */
export const text = {
  list: {
    title: "Prüflinge",
    find: "Suchen",
    findHint: "Seriennummer, Typ",
    none: "Noch ist kein Prüfling bekannt: einen Lauf aufzeichnen oder importieren.",
    noneFits: "Kein Prüfling passt dazu.",
    count: (count) => plural(count, { one: `${count} Prüfling`, other: `${count} Prüflinge` }),
    unit: "Prüfling",
    verdict: "Urteil",
    type: "Typ",
    model: "Modell",
    runs: "Läufe",
    lastRun: "Letzter Lauf",
    noModel: "noch keines",
  },
  unit: {
    back: "← Prüflinge",
    unnamed: "Prüfling",
    next: "Was als Nächstes zu tun ist",
    simulated: "SIMULIERT",
    type: "Typ",
    model: "Modell",
    runs: "Läufe",
    epoch: "Epoche",
    exported: "Exportiert",
    toFit: (runs, count) => `${runs}, davon ${count} für eine Anpassung`,
    notExported: "noch nicht",
    exportedBy: (time, user) => `${time} von ${user}`,
  },
  states: { fitted: "angepasst", verified: "verifiziert", released: "freigegeben", withdrawn: "zurückgezogen" },
  verdicts: { pass: "BESTANDEN", marginal: "GRENZWERTIG", fail: "NICHT BESTANDEN", not_measured: "NICHT GEMESSEN", none: "NICHT BEURTEILT" },
  why: {
    noModel: "Von diesem Prüfling gibt es noch kein Modell.",
    notVerified: (version) => `Modell ${version} wurde hier noch nicht verifiziert.`,
    by: (version, campaign, user) => `Modell ${version} gegen Kampagne ${campaign}, durch ${user}`,
    stale: (why, verdict, by) => ["Die letzte Verifizierung gilt nicht mehr: ", { english: why }, `. Ihr Urteil war ${verdict}: ${by}.`],
    noLimits: (by, type) => `${by}: Für den Typ ${type} sind keine Grenzwerte gesetzt, deshalb wurde nichts beurteilt.`,
    judged: {
      pass: "alle Sensoren liegen innerhalb ihrer Grenzwerte", fail: "jenseits der Grenzwerte", marginal: "zu nah an den Grenzwerten für ein Urteil", info: "nicht gemessen",
    },
  },
  next: {
    record: "Mit ihm eine Kampagne aufzeichnen oder seine Aufzeichnungen importieren.",
    fit: "Anpassen.",
    changed: "So aufzeichnen, wie er jetzt ist, und neu anpassen: Nach diesem Modell wurde er repariert oder verändert.",
    withdrawn: "Neu anpassen: Daten dieses Modells wurden für ungültig erklärt.",
    verify: "Mit einem Lauf verifizieren, den die Anpassung nicht gesehen hat.",
    recordFresh: "Mit einem Prüfablauf zur Verifizierung einen Lauf aufzeichnen, den die Anpassung nicht gesehen hat, dann verifizieren.",
    newCampaign: "Neue Kampagne",
    how: "Wie?",
    fail: "Nicht ausliefern: Er überschreitet seine Grenzwerte. Der Bericht zeigt, wo.",
    marginal: "Nicht als bestanden ausliefern: mehr Läufe für die Anpassung oder die Verifizierung aufzeichnen und neu verifizieren.",
    notJudged: (type) => `Grenzwerte in die Datei seines Typs schreiben, ${type}.toml, oder über den ganzen Bereich verifizieren: Er ist noch nicht beurteilt.`,
    grave: "Nicht ausliefern, bevor die erste Warnung unten geklärt ist.",
    export: "Exportieren.",
    nothing: "Nichts: Er ist verifiziert und exportiert.",
  },
  jobs: {
    title: "Aufträge",
    campaign: "Kampagne, die die Anpassung nicht gesehen hat",
    noCampaign: "Es gibt keine: Jeder Lauf steckt im Modell. Einen in einer eigenen Kampagne aufzeichnen.",
    campaignRuns: (campaign, count) => `${campaign} (${plural(count, { one: `${count} Lauf`, other: `${count} Läufe` })})`,
    format: "Dateiformat",
    sign: "Signieren",
    noKey: "Signieren: Die Station hat noch keinen Schlüssel, unter „Prüfmittel“ entsteht einer",
    signWith: (key) => `Mit Schlüssel ${key} signieren`,
    keyUnknown: "Signieren: ",
    simulated: "Obwohl die Daten SIMULIERT sind",
    tickSimulated: "Export: Das Modell stammt aus SIMULIERTEN Daten. Erst „Obwohl die Daten SIMULIERT sind“ ankreuzen, wenn das so gewollt ist.",
    cancel: "Abbrechen",
    ended: "Beendete Aufträge, der neueste zuerst",
    none: "Zu diesem Prüfling ist kein Auftrag aufbewahrt.",
    refused: (what) => `${what}: `,
    asked: (what) => `${what}: ist angefordert`,
    download: (file) => `${file} herunterladen`,
    running: (doing, unit, since, user) => `${doing}: Prüfling ${unit}, seit ${since}, gestartet von ${user}`,
    states: { done: "fertig", failed: "gescheitert", cancelled: "abgebrochen" },
    against: (campaign) => ` gegen ${campaign}`,
    as: (format) => ` als ${format}`,
    signed: (key) => (key ? `, signiert mit Schlüssel ${key}` : ", signiert"),
    model: (version) => `: Modell ${version}`,
    ofEffects: (effects) => `: ${effects}`,
    verbs: { fit: "Anpassen", verify: "Verifizieren", report: "Bericht", export: "Exportieren", gap_find: "Suchen", gap_accept: "Annehmen", gap_show: "Vergleichen" },
    doing: {
      fit: "Anpassung läuft", verify: "Verifizierung läuft", report: "Bericht wird geschrieben", export: "Export läuft", gap_find: "Suche nach dem, was dem Modell fehlt",
      gap_accept: "Neue Anpassung mit den angenommenen Effekten", gap_show: "Vergleich von vorher und nachher",
    },
    nouns: {
      fit: "Anpassung", verify: "Verifizierung", report: "Bericht", export: "Export", gap_find: "Suche nach Lücken", gap_accept: "Angenommen", gap_show: "Vorher und nachher",
    },
  },
  formats: {
    blob: "Kalibrierdatei (.soakcal)", c: "C-Header (.h)", json: "JSON-Datei", px4: "PX4-Parameter", ardupilot: "ArduPilot-Parameter", kalibr: "Rauschwerte für Kalibr",
  },
  warnings: {
    title: "Warnungen",
    none: "Keine Warnung verlangt etwas.",
    more: (count) => `${count} weitere, bei denen nichts zu tun ist`,
    name: (code) => (Object.hasOwn(WARNINGS, code) ? WARNINGS[code][0] : ""),
    remedy: (code, own) => (Object.hasOwn(WARNINGS, code) ? WARNINGS[code][1] : { english: own }),
  },
  sensors: {
    name: sensorName,
    curves: "Kurven",
    older: "Daneben ein älteres Modell",
    noOlder: "keines",
    version: (version) => `Modell ${version}`,
    bias: (sensor) => `Nullpunktfehler, ${sensor}`,
    temperature: "Temperatur des Prüflings, °C",
    ordinate: (unit) => `Nullpunktfehler, ${unit}`,
    deployed: "ausgelieferte Kurve",
    mean: "95 %, mittlere Kurve",
    fresh: "95 %, ein neues Einschalten",
    olderMean: "dessen 95 %, mittlere Kurve",
    curve: "Kurve",
    rules: (count) => `ANFIS, ${plural(count, { one: `${count} Regel`, other: `${count} Regeln` })}`,
    kind: (name) => (Object.hasOwn(CURVES, name) ? CURVES[name] : name),
    residualFit: "Restfehler der Anpassung",
    residualHeldOut: "Restfehler, zurückgehaltene Läufe",
    runToRun: "Von Lauf zu Lauf",
    notKnown: "nicht bekannt",
    span: "Bereich",
    range: (low, high) => `${low} bis ${high} °C`,
    widest: "95-%-Band, breiteste Stelle",
  },
  impact: {
    title: "Was die Kalibrierung in der Navigation bringt",
    notKnown: "Nicht bekannt: Die Sensoren wurden nicht bei zwei gemeinsamen Temperaturen kalibriert.",
    heads: ["Messachse", "Nullpunkt ändert sich um", "Bleibt (95 %)", "30 s, ohne", "30 s, mit", "60 s, ohne", "60 s, mit"],
    bySensor: "Positionsfehler je Sensor",
    intervals: { pi95: "ein neues Einschalten", ci95: "nur die mittlere Kurve: kann viel zu klein sein" },
    about: (from, to) => `Positionsfehler allein durch den Nullpunktfehler jedes Sensors, ohne Satellitennavigation, von ${from} °C beim Einschalten bis ${to} °C; der Nullpunktfehler beim
      Einschalten ist bekannt, die Achse des Sensors liegt waagrecht.`,
    drives: "Fahrten mit einem Navigationsfilter werden hier nicht simuliert, das dauert Sekunden:",
  },
};
