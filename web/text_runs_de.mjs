// SPDX-License-Identifier: Apache-2.0
// What the views of stored runs say, in German. A channel and a finding are said by their names in the interface; one that is not known here keeps its own.

import { count, plural } from "./format.mjs";

const AXES = { gyro: "Drehrate", accel: "Beschleunigung", temp: "Temperatur" };
const CHANNELS = {
  temp_c: "Prüfling °C", chamber_c: "Kammer °C", plateau_c: "Plateau °C", position: "Lage", rate_dps: "Drehrate der Vorrichtung", turn_deg: "Drehwinkel", air_c: "Luft °C",
  set_point_c: "Sollwert °C", working_set_point_c: "laufender Sollwert °C", output_percent: "Stellgröße", air_rh: "Luftfeuchte", air_rh_percent: "Luftfeuchte", supply_v: "Versorgungsspannung",
  supply_a: "Versorgungsstrom", compressor: "Verdichter", packet: "Paket", status: "Statuswort", utc_s: "Uhrzeit (UTC)", t_since_power_s: "Zeit seit dem Einschalten",
};
/** What the data gate has found (docs/fit.md). */
const FINDINGS = {
  moved: "bewegt", knocked: "angestoßen", spike: "einzelne Ausreißer", lost_packets: "verlorene Pakete", wrong_position: "falsche Lage", saturated: "am Ende des Messbereichs",
  stuck: "hängt fest", dropouts: "Messwerte fehlen", irregular_sampling: "ungleiche Abtastung", coarse_thermometer: "grobes Thermometer",
};

function channelText(name) {
  if (Object.hasOwn(CHANNELS, name)) return CHANNELS[name];
  const [, kind, axis] = name.match(/^(gyro|accel|temp)_([gax]?[xyz])(?:_c)?$/) ?? [];
  return kind ? `${AXES[kind]} ${axis}` : name.replace(/_c$/, " °C").replace(/_/g, " ");
}

/** @type {typeof import("./text_runs_en.mjs").text} */
export const text = {
  list: {
    title: "Kampagnen und Läufe",
    find: "Suchen",
    findHint: "Kampagne, Lauf, Prüfling",
    counting: "Nur was zählt",
    heads: ["Lauf", "Prüfling", "Aufge\u00adzeichnet", "Dauer", "Segmente", "Zustand"],
    recording: (label, campaign) => `${label} von ${campaign} wird gerade aufgezeichnet und steht hier, sobald er zu Ende ist.`,
    none: "Noch ist kein Lauf gespeichert.",
    noneFits: "Kein Lauf passt dazu.",
    count: (count) => plural(count, { one: `${count} Lauf`, other: `${count} Läufe` }),
    notListed: (count) => `${plural(count, { one: `${count} älterer Lauf wird`, other: `${count} ältere Läufe werden` })} hier nicht gezeigt. Eine Kampagne oder einen Prüfling unter „Suchen“ eingeben: Dann stehen auch die älteren Läufe da.`,
    campaigns: (count) => plural(count, { one: `${count} Kampagne`, other: `${count} Kampagnen` }),
    begun: (time) => `begonnen ${time}`,
    noRuns: "Von ihr ist kein Lauf gespeichert: Sie endete vor dem Ende des ersten.",
    notLoaded: (count) => plural(count, { one: `Ihr ${count} Lauf ist älter als die hier gezeigten.`, other: `Ihre ${count} Läufe sind älter als die hier gezeigten.` }),
    older: "Ihre Läufe zeigen",
    refused: (count) => `${count} abgelehnt`,
    void: (count) => `${count} ungültig`,
  },
  report: {
    button: "Bericht",
    of: (campaign) => `Bericht der Kampagne ${campaign}`,
    asked: "Der Bericht ist angefordert.",
    running: "Der Bericht wird geschrieben.",
    made: (time, user) => `Bericht vom ${time}, von ${user}: `,
    failed: "Der Bericht ist nicht entstanden: ",
  },
  marks: { void: "ungültig", verification: "Verifizierung", diagnosis: "Vorprüfung", cutShort: "vorzeitig beendet", noSamples: "ohne Messwerte", simulated: "SIMULIERT", complete: "vollständig" },
  run: {
    back: "← Kampagnen und Läufe",
    unnamed: "Lauf",
    title: (run, campaign, unit) => `${run} von ${campaign}, Prüfling ${unit}`,
    void: "Lauf ungültig erklären …",
    voided: (time, user, reason) => `Ungültig seit ${time}, erklärt von ${user}: ${reason}`,
    cutShort: "Vorzeitig beendet: ",
    dropped: (time, user, reason) => `Messwerte gelöscht (${time}, ${user}): ${reason}`,
    procedure: "Prüfablauf",
    recorded: "Aufgezeichnet",
    length: "Dauer",
    samples: "Messwerte",
    rate: "Mittlere Rate",
    source: "Herkunft",
    id: "Lauf-ID",
  },
  strip: {
    title: "Zeitverlauf",
    shown: "Gezeigter Ausschnitt",
    earlier: "Früher",
    later: "Später",
    closer: "Näher",
    wider: "Weiter",
    all: "Ganzer Lauf",
    channels: "Kanäle",
    used: "Segment, das zählt",
    refused: "von der Datenprüfung abgelehnt",
    void: "ungültig",
    help: `Über das Diagramm ziehen, um näher hinzusehen. Im Diagramm: + und − oder das Mausrad vergrößern und verkleinern (außerhalb das Mausrad mit Strg), Pfeiltasten bewegen den
      Zeiger, mit der Umschalttaste den Ausschnitt, 0 zeigt den ganzen Lauf. Aus der Ferne reicht das Band vom kleinsten bis zum größten Messwert, die Linie ist ihr Mittelwert; ganz nah ist
      jeder Messwert ein Punkt.`,
    unknown: "Nicht bekannt: ",
    window: (from, to) => `${from} bis ${to}`,
    everySample: (rows) => plural(rows, { one: ", ein einziger Messwert", other: `, jeder von ${count(rows)} Messwerten` }),
    stretches: (rows) => `, ${count(rows)} Messwerte: kleinster, mittlerer und größter jedes Abschnitts`,
    label: (about) => `Zeitverlauf, ${about}`,
    labelAt: (time, values) => `Zeitverlauf, bei ${time}: ${values}`,
    channel: channelText,
    stream: (name) => ({ chamber: "Protokoll der Kammer" }[name] ?? name),
    panels: { "°C": "Temperatur", "°/s": "Drehrate", "m/s²": "Spezifische Kraft", V: "Spannung", A: "Strom" },
    noUnit: "Ohne Einheit",
  },
  segments: {
    title: "Segmente",
    refusedOnly: "Nur was nicht zählt",
    plateau: "Plateau",
    up: "Oben",
    from: "Ab",
    length: "Dauer",
    state: "Zustand",
    actions: "Aktionen",
    recorded: (count) => `${count} aufgezeichnet`,
    refused: (count) => `${count} von der Datenprüfung abgelehnt`,
    part: (count) => `${count} mit abgelehnten Sensoren`,
    void: (count) => `${count} ungültig`,
    look: "Ansehen",
    voidIt: "Ungültig …",
    button: (text, place, time) => `${text} ${place}, ab ${time}`,
    noPlateau: "kein Plateau",
    atRest: "in Ruhe",
    attempt: (up, number) => `${up}, Versuch ${number}`,
    sweeps: { up: " (Heizen)", down: " (Kühlen)", unknown: "" },
    states: { used: "in Ordnung", part: "Sensoren abgelehnt", refused: "abgelehnt", void: "ungültig" },
    finding: (code, sensor) => `${FINDINGS[code] ?? code}${sensor ? ` (${channelText(sensor)})` : ""}`,
  },
  void: {
    title: "Ungültig erklären",
    titleRun: "Diesen Lauf ungültig erklären?",
    titleSegment: "Daten dieses Laufs ungültig erklären?",
    scope: "Was ungültig wird",
    reason: "Grund, für das Protokoll",
    user: "Ihr Name, für das Protokoll",
    keep: "Gültig lassen",
    send: "Ungültig erklären",
    segment: (place) => `Nur dieses Segment: ${place}`,
    attempts: (count) => `Alle ${count} Versuche dazu`,
    visit: (plateau) => `Das ganze Plateau: ${plateau}`,
    run: "Der ganze Lauf",
    losesRun: (run, unit, segments) => `Lauf ${run} von Prüfling ${unit} wird ungültig, mit ${plural(segments, { one: "dem einen Segment, das noch gilt", other: `allen ${segments} Segmenten, die noch gelten` })}.`,
    losesSegments: (count, all, run) => `Von den ${all} Segmenten des Laufs ${run}, die noch gelten, ${plural(count, { one: "wird eines", other: `werden ${count}` })} ungültig${count === all ? ": Keines bleibt übrig" : ""}.`,
    notUsed: "Was ungültig ist, geht in keine Anpassung, keine Verifizierung und keinen Bericht ein. Modelle, in denen es steckt, bleiben, wie sie sind, bis der Prüfling neu angepasst wird, verlieren aber ihr Urteil, und freigegebene dürfen nicht mehr weitergegeben werden.",
    keepsSamples: "Die Messwerte bleiben erhalten, zurücknehmen lässt sich das aber nicht.",
    final: "Zurücknehmen lässt sich das nicht.",
  },
};
