// SPDX-License-Identifier: Apache-2.0
// What the card of a unit's gap says, in German. Behind what an effect is stands its English name, by which the guide and soak know it.

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

/** Was Messwerte folgen, das kein Effekt erklärt: was so etwas meist ist, und wo zu suchen ist. */
const KINDS = {
  direction_of_sweep: { usual: "einem Gedächtnis für den Weg der Temperatur: Kleber, Lot oder Gehäuse geben langsam nach, oder die Haltezeit ist zu kurz", look: "die Zeit vor der ersten Lage: Ein Lauf mit doppelter Haltezeit zeigt, ob der Unterschied vergeht" },
  settling: { usual: "einem Prüfling, der innen noch nicht so warm ist, wie sein Thermometer sagt, wenn die erste Lage beginnt", look: "die Zeit vor der ersten Lage: länger halten" },
  creep_after_turn: { usual: "etwas, das sich nach jeder Drehung ein, zwei Minuten weiterbewegt: einer Klemme, einem Kabel, dem Lager der Vorrichtung", look: "die Vorrichtung: wie der Prüfling geklemmt ist, wie sein Kabel hängt; nach einer Drehung länger warten" },
  position_order: { usual: "etwas, das durch einen Besuch läuft und beim nächsten neu beginnt: Wärme aus einem Antrieb der Vorrichtung, Kriechen", look: "die Reihenfolge der Lagen: einen Lauf in einer anderen aufzeichnen" },
  position: { usual: "einer Vorrichtung, die nicht so steht, wie der Prüfablauf sagt, oder einem Feld oder Luftzug, der im Raum feststeht", look: "die Winkel der Vorrichtung und was in der Nähe magnetisch ist oder bläst" },
  position_before: { usual: "einem Prüfling oder einer Vorrichtung mit Gedächtnis für die Lage davor: Klemmen, die rutschen, Kabel, die ziehen", look: "Klemmen und Kabel; einen Lauf mit anderer Reihenfolge der Lagen aufzeichnen" },
  position_and_temperature: { usual: "einer Vorrichtung, die sich beim Erwärmen verbiegt, oder einer Achse des Prüflings, die sich mit der Temperatur auf eigene Weise dreht", look: "die Vorrichtung: was an ihr mit der Temperatur wächst; den Prüfling um 90 Grad gedreht einbauen und vergleichen" },
  drift_in_run: { usual: "etwas, das durch jeden Lauf gleich weitergeht: Einlaufen, Trocknen, eine undichte Referenz", look: "was mit jedem Lauf beginnt: Strom, Heizung, Trocknen des Prüflings; einen Lauf mit anderer Reihenfolge der Temperaturen aufzeichnen" },
  daily_wave: { usual: "dem Gebäude: Heizung, Sonne, Netzspannung oder Menschen, die jeden Tag wiederkehren", look: "den Raum: seine Temperatur, die Versorgung, was zu diesen Stunden sonst eingeschaltet ist" },
  after_power_on: { usual: "Elektronik, die nach dem Einschalten warm wird, aber nicht einfach abklingt", look: "die Einlaufzeit des Prüflings: früher einschalten, und mitten im Lauf aus- und einschalten, um es noch einmal zu sehen" },
  air_gradient: { usual: "Wärme, die durch den Prüfling fließt: Seine Seiten sind nicht gleich warm, solange die Luft der Kammer sich ändert", look: "die Luft um den Prüfling: abschirmen, oder länger halten" },
  between_effects: { usual: "einem Gedächtnis der Temperatur, dessen Form die Bibliothek nicht hat", look: "die Rampen: Ein Lauf mit anderer Rampe und einer mit längerer Haltezeit zeigen, wem es folgt" },
  wander: { usual: "langsamem Rauschen (Bias-Instabilität, Random Walk der Rate); zu wenige Läufe, um es von einem springenden Nullpunkt zu unterscheiden", look: "die Zahl der Läufe: Bei vier oder mehr eines Prüfablaufs wird langsames Rauschen gemessen und als Rauschen gezählt" },
  step: { usual: "einem Kontakt, einer Lötstelle oder einem Sensor, der einmal nachgibt und so bleibt: ein Defekt, ein Stoß, ein Neustart des Prüflings", look: "was zu dieser Zeit geschah: die Ereignisse des Laufs, das Kabel, ein Stoß; findet sich keine Ursache, den Sensor" },
  telegraph_noise: { usual: "einem Wackelkontakt oder einem Defekt im Sensor, der zwischen zwei Werten springt (Telegrafenrauschen)", look: "Stecker und Kabel; bleibt es am anderen Kabel beim Prüfling, ist der Sensor defekt" },
  jumps: { usual: "einem Kontakt oder Sensor, der zeitweise nachgibt oder zwischen zwei Werten springt: Diese Läufe zeigen nicht, was davon", look: "Stecker und Kabel, und was zu den Zeiten der Sprünge geschah; bleibt es beim Prüfling, den Sensor" },
};

/** Dasselbe, wo es von der Aufzeichnung abhängt: auf Rampen, und mit genug Läufen. */
const ON_RAMPS = {
  direction_of_sweep: { usual: "einem Gedächtnis für den Weg der Temperatur: Kleber, Lot oder Gehäuse geben langsam nach, oder das Innere des Prüflings folgt seinem Thermometer in einer Weise, die die Bibliothek nicht hat", look: "wie schnell sich die Temperatur ändert: Derselbe Zyklus mit halber Rampe zeigt, ob der Unterschied kleiner wird" },
  drift_in_run: { usual: "etwas, das durch die Aufzeichnung weitergeht: Warmlaufen, Trocknen, eine Referenz, die leckt", look: "was mit der Aufzeichnung beginnt: Versorgung, Heizungen, Trocknen des Prüflings; denselben Zyklus noch einmal aufzeichnen" },
};
const WANDER_IN_ENOUGH_RUNS = { usual: "etwas, das sich langsam und in jedem Lauf anders bewegt, aber nicht wie langsames Rauschen: der Raum, die Versorgung, ein Kabel", look: "was in den Läufen nicht gleich war: der Raum, die Versorgung, wie der Prüfling befestigt war; einen Lauf aufzeichnen, in dem all das gleich ist" };
const ENOUGH_RUNS = 4; // eines Prüfablaufs, um zu messen, wie ein Nullpunkt wandert

const english = (name) => name.replaceAll("_", " ");
const effect = (name) => (Object.hasOwn(EFFECTS, name) ? `${EFFECTS[name]} (${english(name)})` : english(name));
const either = (names) => names.map(effect).join(" oder ");

/** @type {typeof import("./text_gap_en.mjs").text} */
export const text = {
  card: {
    title: "Lücke: was das Modell nicht erklärt",
    find: "Suchen",
    show: "Vorher und nachher vergleichen",
    none: "Noch hat niemand gesucht, oder das Ergebnis ist nicht aufbewahrt. Eine Suche nimmt die Läufe, die eine Anpassung nimmt: mindestens zwei desselben Prüfablaufs, besser sechs.",
    next: "Um die Lücke zu schließen",
    howToRecord: "Wie das aufgezeichnet wird, Schritt für Schritt",
    accept: "Annehmen …",
    before: (version, time, user) => [`Diese Suche gilt Modell ${version}, ${time} von ${user}: dem vor dem Annehmen ihrer Effekte.`],
    stale: (version, time, user, why) => [`Diese Suche gehört zu Modell ${version}, ${time} von ${user}. Sie gilt nicht mehr: `, why, "."],
    terms: "Effekte, die das Modell enthält",
    labOnly: "Nur im Labor: Der Prüfling selbst kann ihn nicht ausgleichen.",
    inFile: "In der Kalibrierdatei: Der Prüfling gleicht ihn aus.",
  },
  verdicts: { none: "NICHTS GEFUNDEN", named: "EFFEKT GEFUNDEN", accepted: "EFFEKT ANGENOMMEN", unknown: "NICHT ERKLÄRT", cannot_judge: "NICHT ZU BEURTEILEN" },
  effect,
  effectTitle: (name) => effect(name).replace(/^./u, (first) => first.toUpperCase()),
  either,
  sizeOf: { gyro: "der Drehraten", accel: "der Beschleunigungen" },
  allSensors: "allen Sensoren",
  found: {
    none: "Was der Prüfling über das Modell hinaus gemessen hat, ist nicht mehr, als seine Läufe voneinander abweichen. Kleinere Effekte können unbemerkt da sein: Die Grenzen stehen unten.",
    unknown: (where) => ["Der Prüfling misst etwas, das kein bekannter Effekt erklärt.", ...where, " Auf Verdacht wird nichts benannt."],
    follows: (axis, sensors) => [" Es folgt der Größe ", { english: axis }, `, in ${sensors}.`],
    cannotJudge: "Diese Läufe können nicht zeigen, ob dem Modell etwas fehlt.",
    one: (name, size, sensors) => `${effect(name)}: ${size}, in ${sensors}`,
    gap: (sensor, before, floor, unit) => ` Die Lücke von ${sensor} ist ${before} ${unit} (RMS), Rauschen allein lässt ${floor}.`,
    step: (sensor, size, unit, run, when, temp, more) => `Der Nullpunkt von ${sensor} springt um ${size} ${unit} in Lauf ${run}, ${when} nach dessen erstem Messwert auf einem Plateau, bei ${temp} °C${more > 0 ? ` (${more} weitere unten)` : ""}. Kein bekannter Effekt erklärt das.`,
    jumps: (sensors) => ` Der Nullpunkt springt im Lauf hin und her, in ${sensors}.`,
    accepted: (effects, version, newest) => `Die Suche in Modell ${version} ergab: ${effects.join(" und ")}. In Modell ${newest} ist das enthalten.`,
    lacks: (effects) => `Dem Modell fehlt ${effects.join("; und ")}.`,
  },
  /** `runs`: that were searched at plateaus. */
  kinds: (kind, onRamps, runs) => (onRamps && ON_RAMPS[kind]) || (kind === "wander" && runs >= ENOUGH_RUNS ? WANDER_IN_ENOUGH_RUNS : KINDS[kind] ?? null),
  sure: {
    certain: "Zufall ist das nicht",
    likely: "Zufall sieht sehr selten so aus",
    alone: (chance) => `${chance}, und kein anderer bekannter Effekt erklärt es fast so gut.`,
    rivals: (chance, doubts) => `${chance}; aber fast so viel wie ${doubts.map(([name, names]) => `${effect(name)} erklärt ${either(names)}`).join(", wie ")}: Diese Läufe unterscheiden sie nicht sicher.`,
    decided: (chance, pairs) => `${chance}. Fast so viel wie ${pairs.map(([name, names]) => `${effect(name)} erklärt ${either(names)}`).join(", wie ")}, aber mit einer Chance von unter eins zu einer Million: Diese Läufe unterscheiden sie.`,
    limit: (least, most, unit, isGyro) => `${least} bis ${most} ${unit} bei ${isGyro ? "einer Drehrate" : "einer Beschleunigung"}`,
    none: (limits) => (limits.length === 0 ? "Effekte, die kleiner sind als die Streuung dieser Läufe, können unbemerkt da sein."
      : `Kleinere Effekte können unbemerkt da sein: In der Hälfte solcher Kampagnen würde einer benannt ab ${limits.join(", ab ")}.`),
    usual: (usual) => `Auf Verdacht wird nichts benannt; meist kommen solche Messwerte von ${usual}.`,
    suspected: (suspects, usual) => `Vermutet, aber nicht sicher genug für einen Namen: ${suspects.join("; ")}${usual === null ? "" : `; sonst kommen solche Messwerte meist von ${usual}`}.`,
    cannotJudge: (reason) => ["Warum: ", { english: reason }, "."],
    accepted: "Ob das richtig war, zeigt nur ein Lauf, den keine Anpassung gesehen hat.",
    compared: "Ein Lauf, den keine Anpassung gesehen hat, wurde verglichen: Was er sagt, steht unter „Vorher und nachher“.",
  },
  next: {
    none: "Dem Modell fehlt nichts, was diese Läufe zeigen können: weiter mit dem, was oben steht.",
    unknown: "Entlang dieser Größe suchen: Vorrichtung, Kabel, Gebäude. Dann neu aufzeichnen und neu suchen.",
    look: (look) => `Ansehen: ${look}. Dann neu aufzeichnen und neu suchen.`,
    plateaus: (apart) => `Eine Kampagne mit Plateaus im Abstand von ${apart} K aufzeichnen, dann neu suchen.`,
    thirdBranch: "Einen dritten Ast aufzeichnen: noch einmal über dieselben Temperaturen heizen oder kühlen. Dann neu suchen.",
    again: "Denselben Prüfablauf noch einmal aufzeichnen, dann neu suchen.",
    sameCycle: "Denselben Zyklus noch einmal aufzeichnen, dann neu suchen.",
    cannotJudge: "Einen weiteren Lauf desselben Prüfablaufs aufzeichnen, oder den Lauf für ungültig erklären, den die Begründung nennt. Dann neu suchen.",
    carried: "Das Modell enthält schon, was gefunden wurde: einen Lauf aufzeichnen, den keine Anpassung gesehen hat, dann vorher und nachher vergleichen.",
    carriedWith: (check) => `Das Modell enthält schon, was gefunden wurde: vorher mit nachher vergleichen. Kampagne ${check} hat Läufe, die keine Anpassung gesehen hat.`,
    tell: (name, rivals, experiment) => [`Kaum zu unterscheiden: ${effect(name)} von ${either(rivals)}. Vor dem Annehmen dies aufzeichnen: `, { english: experiment },
      ". Ist es für den Einsatz des Prüflings ohne Bedeutung, so lassen und mit dem weitermachen, was oben steht."],
    accept: (names) => `${names.length > 0 ? `Annehmen: ${names.map(effect).join(" und ")}. Dann` : "Was gefunden wurde, annehmen, dann"} einen Lauf aufzeichnen, den keine Anpassung gesehen hat, und vorher mit nachher vergleichen.`,
    acceptWith: (names, check) => `${names.length > 0 ? `Annehmen: ${names.map(effect).join(" und ")}. Dann` : "Was gefunden wurde, annehmen, dann"} vorher mit nachher vergleichen: Kampagne ${check} hat Läufe, die keine Anpassung gesehen hat.`,
  },
  evidence: {
    size: "Größe",
    sensors: "Gefunden in",
    chance: "Wahrscheinlichkeit, dass Streuung so aussieht",
    hardlyAny: "unter 1 zu 1 Million",
    takes: "Anteil der Lücke, den er erklärt, in Läufen, an die er nicht angepasst wurde",
    rivals: "Fast so gut",
    noRivals: "nichts sonst",
    ruledOut: (names) => `nichts sonst: ausgeschlossen ist ${either(names)}`,
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
    asExpected: " Geschlossen ist so viel, wie erwartet war.",
    less: (sensors) => ` Weniger geschlossen, als beim Annehmen erwartet war: ${sensors}. Der Effekt nimmt seinen Teil, denn mit ihm ist die Lücke kleiner: so lassen. Der Rest ist etwas anderes.`,
    curve: (sensors) => ` In neuen Läufen weit über der Untergrenze, obwohl die Effekte darauf nicht wirken: ${sensors}. Die Kurve über der Temperatur passt also nicht zu diesen Läufen. Meist liegen sie zwischen Plateaus, die weit auseinander sind. „Verifizieren“ sagt, ob das die Grenzwerte einhält; wenn nicht, Plateaus dichter beieinander aufzeichnen und neu anpassen.`,
    searchAgain: " Den Prüfablauf zur Kalibrierung noch einmal aufzeichnen, neu anpassen und neu suchen.",
    stale: (why) => [" Das gilt nicht mehr: ", why, "."],
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
    about: "Was die Läufe über die Temperaturkurve hinaus gemessen haben, Mittel über die Läufe; ▲ beim Heizen erreicht, ▼ beim Kühlen. Die Zeilen sind Temperaturen, die der Prüfling hatte, nicht die eingestellten. Farbig ist, was der Zufall nicht oft hervorbringt; unter so vielen Zellen kann eine einzelne trotzdem Zufall sein, eine Zeile oder Spalte nicht.",
    label: (sensor) => `Karte: ${sensor}`,
    more: (sigmas) => `misst mehr, ab ${sigmas} Sigma`,
    less: (sigmas) => `misst weniger, ab ${sigmas} Sigma`,
    from: (sigmas) => `ab ${sigmas}`,
    sweeps: { up: "Heizen", down: "Kühlen", unknown: "" },
    noSigma: "kein Lauf wiederholt einen anderen: Sigma ist nicht bekannt",
    sigma: (least, most) => `1 Sigma ist ${least === most ? least : `${least} bis ${most}`}`,
    any: "beliebig",
  },
  steps: {
    title: "Wo der Nullpunkt springt",
    label: "Sprünge des Nullpunkts",
    heads: ["Lauf", "Messachse", "Nach dem ersten Messwert auf einem Plateau", "Bei, °C", "Größe", "Einheit"],
    span: (from, to) => `${from} bis ${to}`,
  },
  slow: {
    title: "Langsames Rauschen",
    label: "Langsames Rauschen, je Sensor",
    about: "Wie der Nullpunkt im Lauf wandert, in jedem Lauf anders: Bias-Instabilität und Random Walk der Rate. Es zählt als Rauschen. Daneben steht die Bias-Instabilität B der längsten Ruhe des Prüflings, wenn eine mindestens eine halbe Stunde dauert und sie zeigt.",
    heads: ["Messachse", "Im Lauf (Standardabweichung)", "Einheit", "Vergessen in Minuten", "In Stunden", "B in Ruhe (95 %)"],
    rest: (value, low, high) => `${value} (${low} bis ${high})`,
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
    share: (percent) => `erklärt ${percent} % der Lücke`,
    outside: "erklärt nichts von der Lücke: zeigt sich nur in den einzelnen Abtastwerten",
    about: "Ob das richtig war, zeigt nur ein Lauf, den keine Anpassung gesehen hat: einen aufzeichnen, wenn noch keiner da ist, dann vorher und nachher vergleichen. Den Prüfling neu verifizieren, freigeben und exportieren.",
    keep: "Das Modell lassen, wie es ist",
    send: "Annehmen",
    carried: "Schon enthalten: vorher im Terminal zurückziehen.",
    what: (newer, version) => `Modell ${newer} wird sie enthalten: Alle Läufe werden von ihnen befreit und neu angepasst. Modell ${version} bleibt, wie es ist. Vorher wird noch einmal gesucht; nennt die Suche einen von ihnen nicht mehr, wird nichts übernommen.`,
    rivals: (names) => `Fast so gut: ${names.map(effect).join(", ")}. Diese Läufe unterscheiden sie kaum.`,
  },
};
