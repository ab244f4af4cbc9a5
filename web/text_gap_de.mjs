// SPDX-License-Identifier: Apache-2.0
// What the card of a unit's gap says, in German. Effects keep their names in the interface, with what they are beside them.

import { plural } from "./format.mjs";

/** The library of effects (docs/gap-workflow.md). */
const EFFECTS = {
  thermal_hysteresis: "Hysterese zwischen Heizen und Kühlen", temperature_rate: "folgt der Temperaturänderung", sensor_lag: "Sensor folgt dem Thermometer verspätet",
  warmup_transient: "Einlaufen nach dem Einschalten", g_sensitivity: "Drehrate hängt von der Beschleunigung ab", earth_rate: "Erddrehung",
  cross_axis: "Achsenfehler wandern mit der Temperatur", fixture_tilt: "Vorrichtung verkippt zwischen den Läufen", scale_nonlinearity: "Kennlinie ist nicht gerade",
  vibration_rectification: "Erschütterung durch den Verdichter", supply_sensitivity: "Abhängigkeit von der Versorgungsspannung",
  temperature_gradient: "Temperaturgefälle zwischen Luft und Prüfling", position_memory: "Nachwirkung der Lage davor", moisture: "Feuchte, die austrocknet",
  narrow_bump: "schmaler Höcker über der Temperatur", aging_drift: "Alterung", noise_vs_temperature: "Rauschen hängt von der Temperatur ab", quantization: "grobe Stufen der Messwerte", saturation: "Messwerte am Ende des Messbereichs",
};

const effect = (name) => (Object.hasOwn(EFFECTS, name) ? `${name} (${EFFECTS[name]})` : name);
const either = (names) => names.map(effect).join(" oder ");

/** @type {typeof import("./text_gap_en.mjs").text} */
export const text = {
  card: {
    title: "Lücke: was das Modell nicht erklärt",
    find: "Suchen",
    show: "Vorher und nachher vergleichen",
    none: "Noch hat niemand gesucht, oder das Ergebnis ist nicht aufbewahrt. Eine Suche nimmt die Läufe, die eine Anpassung nimmt: mindestens zwei desselben Prüfablaufs, besser sechs.",
    next: "Was als Nächstes zu tun ist",
    accept: "Annehmen …",
    stale: (version, time, user, why) => [`Diese Suche gehört zu Modell ${version}, ${time} von ${user}. Sie gilt nicht mehr: `, { english: why }, "."],
    terms: "Effekte, die das Modell enthält",
    labOnly: "Nur im Labor: Der Prüfling selbst kann ihn nicht ausgleichen.",
    inFile: "In der Kalibrierdatei: Der Prüfling gleicht ihn aus.",
  },
  verdicts: { none: "NICHTS GEFUNDEN", named: "EFFEKT GEFUNDEN", accepted: "EFFEKT ANGENOMMEN", unknown: "NICHT ERKLÄRT", cannot_judge: "NICHT ZU BEURTEILEN" },
  effect,
  effectTitle: effect,
  either,
  allSensors: "allen Sensoren",
  found: {
    none: "Was der Prüfling über das Modell hinaus gemessen hat, ist nicht mehr, als seine Läufe voneinander abweichen. Kleinere Effekte können unbemerkt da sein: Die Grenzen stehen unten.",
    unknown: (where) => ["Der Prüfling misst etwas, das kein bekannter Effekt erklärt.", ...where, " Auf Verdacht wird nichts benannt."],
    follows: (axis, sensors) => [" Es folgt der Größe ", { english: axis }, `, in ${sensors}.`],
    cannotJudge: "Diese Läufe können nicht zeigen, ob dem Modell etwas fehlt.",
    one: (effect, size, sensors) => `${effect}: ${size}, in ${sensors}`,
    accepted: (effects, version, newest) => `Die Suche in Modell ${version} ergab: ${effects.join(" und ")}. In Modell ${newest} ist das enthalten.`,
    lacks: (effects) => `Dem Modell fehlt ${effects.join("; und ")}.`,
  },
  next: {
    none: "Dem Modell fehlt nichts, was diese Läufe zeigen können: weiter mit dem, was oben steht.",
    unknown: "Entlang dieser Größe suchen: Vorrichtung, Kabel, Gebäude. Dann neu aufzeichnen und neu suchen.",
    cannotJudge: "Einen weiteren Lauf desselben Prüfablaufs aufzeichnen, oder den Lauf für ungültig erklären, den die Begründung nennt. Dann neu suchen.",
    carried: "Das Modell enthält schon, was gefunden wurde: einen Lauf aufzeichnen, den keine Anpassung gesehen hat, dann vorher und nachher vergleichen.",
    tell: (name, rivals, experiment) => [`Kaum zu unterscheiden: ${effect(name)} von ${either(rivals)}. Vor dem Annehmen dies aufzeichnen: `, { english: experiment }, "."],
    accept: (names) => `${names.length > 0 ? `Annehmen: ${names.map(effect).join(" und ")}. Dann` : "Was gefunden wurde, annehmen, dann"} einen Lauf aufzeichnen, den keine Anpassung gesehen hat, und vorher mit nachher vergleichen.`,
  },
  evidence: {
    size: "Größe",
    sensors: "Gefunden in",
    chance: "Wahrscheinlichkeit, dass Streuung so aussieht",
    hardlyAny: "unter 1 zu 1 Million",
    takes: "Verkleinert die Lücke in zurückgehaltenen Läufen um",
    rivals: "Fast so gut",
    noRivals: "nichts sonst",
    suspected: (name) => `Nur vermutet: ${effect(name)}`,
    experiment: "Nächster Versuch: ",
    outside: "Er zeigt sich in den einzelnen Abtastwerten, nicht in ihrem Mittel: Die Lücke, eine der Mittelwerte, bleibt, wie sie ist.",
  },
  shown: {
    title: "Vorher und nachher",
    bySensor: "Vorher und nachher, je Sensor",
    noTerms: (version) => `Modell ${version} enthält keinen angenommenen Effekt: So weit ist es von den Messwerten entfernt.`,
    models: (before, after) => `Vorher Modell ${before}, nachher Modell ${after}`,
    noFresh: (models) => `${models}. Kein Lauf ist neu, also ist noch nichts bewiesen: einen aufzeichnen, den keine Anpassung gesehen hat.`,
    closer: (models, fresh, closer, judged) => `${models}, an ${plural(fresh, { one: `${fresh} neuen Lauf`, other: `${fresh} neuen Läufen` })}: Die Lücke ist kleiner in ${
      closer === judged ? "jedem Sensor" : `${closer} von ${judged} Sensoren`}, auf den die Effekte wirken.`,
    compared: (time, user) => ` Verglichen ${time} von ${user}.`,
    stale: (why) => [" Das gilt nicht mehr: ", { english: why }, "."],
    heads: ["Messachse", "Läufe", "Vorher", "Nachher", "Untergrenze", "Einheit", "Geschlossen", "Beim Annehmen erwartet (95 %)"],
    uses: { fresh: "neu", fitted: "angepasst" },
    tooSmall: "zu klein für ein Urteil",
    chance: "Zufall: Die Lücke war klein",
    interval: (low, high) => `${low} bis ${high} %`,
  },
  map: {
    title: "Wo sie sitzt: Plateau und Lage",
    effects: "Effekte",
    without: "Ohne die gefundenen Effekte",
    with: "Mit ihnen",
    about: "Was die Läufe über die Temperaturkurve hinaus gemessen haben, Mittel über die Läufe; ▲ beim Heizen erreicht, ▼ beim Kühlen. Farbig ist, was der Zufall nicht oft hervorbringt; unter so vielen Zellen kann eine einzelne trotzdem Zufall sein, eine Zeile oder Spalte nicht.",
    label: (sensor) => `Karte: ${sensor}`,
    more: (sigmas) => `misst mehr, ab ${sigmas} Sigma`,
    less: (sigmas) => `misst weniger, ab ${sigmas} Sigma`,
    from: (sigmas) => `ab ${sigmas}`,
    sweeps: { up: "Heizen", down: "Kühlen", unknown: "" },
    noSigma: "kein Lauf wiederholt einen anderen: Sigma ist nicht bekannt",
    sigma: (least, most) => `1 Sigma ist ${least === most ? least : `${least} bis ${most}`}`,
    any: "beliebig",
  },
  limits: {
    title: "Was diese Suche nicht sehen konnte",
    label: "Kleinste Effekte, die benannt würden",
    heads: ["Messachse", "In der Hälfte solcher Kampagnen benannt ab", "Lücke ohne", "mit den Effekten", "Untergrenze", "Einheit"],
    notTestable: (name) => `Nicht prüfbar: ${effect(name)}: `,
    rejected: (run, sensor, segments, all) => `Von der Datenprüfung abgelehnt: Lauf ${run}${sensor ? `, ${sensor}` : ""}: ${segments} von ${all} Segmenten: `,
  },
  accept: {
    title: "In das Modell aufnehmen?",
    effects: "Effekte",
    about: "Ob das richtig war, zeigt nur ein Lauf, den keine Anpassung gesehen hat: einen aufzeichnen, dann vorher und nachher vergleichen. Den Prüfling neu verifizieren, freigeben und exportieren.",
    keep: "Das Modell lassen, wie es ist",
    send: "Annehmen",
    carried: "Schon enthalten: vorher im Terminal zurückziehen.",
    what: (newer, version) => `Modell ${newer} wird sie enthalten: Alle Läufe werden von ihnen befreit und neu angepasst. Modell ${version} bleibt, wie es ist. Vorher wird noch einmal gesucht; nennt die Suche einen von ihnen nicht mehr, wird nichts übernommen.`,
    rivals: (names) => `Fast so gut: ${names.map(effect).join(", ")}. Diese Läufe unterscheiden sie kaum.`,
  },
};
