// SPDX-License-Identifier: Apache-2.0
// What the view of references, unit types, key and alarm messages says, in German.

import { plural } from "./format.mjs";

const KINDS = { gyro: { name: "Drehrate", unit: "°/s" }, accel: { name: "Beschleunigung", unit: "m/s²" } };

const ALL_AXES = {
  gyro: { name: "Drehraten, Nullpunkt", unit: "°/s" }, accel: { name: "Beschleunigungen, Nullpunkt", unit: "m/s²" },
  gyro_scale_ppm: { name: "Drehraten, Skala", unit: "ppm" }, accel_scale_ppm: { name: "Beschleunigungen, Skala", unit: "ppm" },
};

/** Of a name in the file of a type; one that is not known here keeps its own. */
function limitText(name, value) {
  const [kind, axis, ...scale] = name.split("_");
  if (!Object.hasOwn(KINDS, kind)) return `${name} ${value}`;
  return scale.length > 0 ? `Skalenfaktor ${KINDS[kind].name} ${axis} ${value} ppm` : `${KINDS[kind].name} ${axis} ${value} ${KINDS[kind].unit}`;
}

/** @type {typeof import("./text_records_en.mjs").text} */
export const text = {
  wider: "→ Die Tabelle geht nach rechts weiter: wischen.",
  references: {
    title: "Prüfmittel",
    about: "Kalibrierscheine dessen, womit das Labor misst. Eine Kampagne beginnt nur mit Prüfmitteln, deren Kalibrierschein gültig ist oder für die jemand mit Unterschrift eine Ausnahme erlaubt hat.",
    none: "Kein Kalibrierschein ist eingetragen. Kampagnen laufen trotzdem, aber kein Ergebnis sagt, wie unsicher Vorrichtung, Fallbeschleunigung, Versorgung und Drehrate sind.",
    kind: "Art",
    name: "Name",
    certificate: "Kalibrierschein",
    state: "Status",
    due: "Fällig",
    correction: "Korrektion",
    uncertainty: "Standardunsicherheit",
    actions: "Aktionen",
    kinds: {
      chamber_probe: "Lufttemperaturfühler der Kammer", fixture_squareness: "Rechtwinkligkeit der Vorrichtung", level: "Horizontierung der Grundfläche", gravity: "Örtliche Fallbeschleunigung",
      supply: "Stromversorgung", rate: "Drehrate des Drehtischs",
    },
    retire: "Ausmustern …",
    retireIt: (name) => `${name} ausmustern`,
    entered: (name) => `${name} ist eingetragen.`,
    retired: (name) => `${name} ist ausgemustert.`,
  },
  standings: { valid: "gültig", due_soon: "bald fällig", expired: "abgelaufen", superseded: "ersetzt", retired: "ausgemustert", withdrawn: "zurückgezogen" },
  standing: {
    days: (standing, days) => `${standing}: ${plural(days, { one: `noch ${days} Tag`, other: `noch ${days} Tage` })}`,
    waived: (signer) => `abgelaufen, Ausnahme erlaubt von ${signer}`,
    damaged: "abgelaufen, die Ausnahme dafür ist BESCHÄDIGT",
    expiredHint: "Keine Kampagne beginnt damit: den nächsten Kalibrierschein eintragen oder im Terminal eine Ausnahme unterschreiben lassen (soak reference waive).",
    waivedHint: "Kampagnen beginnen trotzdem damit, und Ergebnisse nennen die Ausnahme. Sie endet, sobald der nächste Kalibrierschein eingetragen oder das Prüfmittel ausgemustert ist.",
  },
  entry: {
    title: "Kalibrierschein eintragen",
    name: "Name im Labor",
    certificate: "Nummer des Kalibrierscheins",
    issued: "Ausgestellt",
    dueHint: "Ab dem Tag der Fälligkeit beginnt keine Kampagne damit, bis der nächste Kalibrierschein eingetragen ist. Mit einer Ausnahme, im Terminal unterschrieben (soak reference waive), beginnen Kampagnen trotzdem: nur für diesen Kalibrierschein, und bis der nächste eingetragen oder das Prüfmittel ausgemustert ist.",
    uncertainty: "Erweiterte Messunsicherheit,",
    factor: "Deren Erweiterungsfaktor k (steht im Kalibrierschein, meist 2)",
    user: "Ihr Name, für das Protokoll",
    send: "Eintragen",
    gravity: (unit) => `Örtliche Fallbeschleunigung, ${unit}`,
    correction: (unit, meaning) => `Korrektion, ${unit}: ${meaning}`,
    corrections: {
      chamber_probe: "wird zur Anzeige des Fühlers addiert", level: "Abweichung von der Waagrechten", supply: "wird zur Anzeige der Versorgung addiert", rate: "wird zur Drehrate des Drehtischs addiert",
    },
  },
  retire: {
    title: "Dieses Prüfmittel ausmustern?",
    about: (kind, name, certificate) => `${kind}: „${name}“, Kalibrierschein ${certificate}, wird ab jetzt nicht mehr verwendet. Ergebnisse nennen es weiter, und dass es ausgemustert wurde.`,
    looking: "Es wird nachgesehen, welche Freigaben darauf beruhen…",
    nothingLost: "Kein freigegebener Prüfling beruht darauf.",
    lost: (count) => plural(count, { one: `${count} freigegebener Prüfling beruht darauf und darf nicht mehr ausgeliefert werden, bis er mit neueren Läufen verifiziert oder angepasst ist:`, other: `${count} freigegebene Prüflinge beruhen darauf und dürfen nicht mehr ausgeliefert werden, bis sie mit neueren Läufen verifiziert oder angepasst sind:` }),
    unit: (serial, model) => `${serial}, Modell ${model}`,
    notKnown: (message) => `Welche freigegebenen Prüflinge darauf beruhen, ist nicht bekannt: ${message}`,
    reason: "Grund, für das Protokoll",
    keep: "Behalten",
    send: "Ausmustern",
  },
  newUnit: {
    title: "Neuer Prüfling",
    serial: "Seriennummer",
    type: "Typ",
    choose: "Wählen …",
    send: "Anlegen",
    added: (type) => ` ist angelegt, Typ ${type}.`,
  },
  types: {
    title: "Prüflingstypen",
    about: "Was es ist",
    rating: "Temperaturbereich",
    limits: "Größter Fehler, den eine Verifizierung durchlässt",
    file: "Jeder steht in einer eigenen Datei in",
    read: ". Die Station liest sie, wenn eine Kampagne beginnt, und für jede Verifizierung.",
    change: "Einen Grenzwert ändern, Schritt für Schritt",
    allAxes: (kind, value) => `${ALL_AXES[kind].name} ${value} ${ALL_AXES[kind].unit}`,
    troubles: "Fehlerhafte Dateien",
    range: (low, high) => `${low} bis ${high} °C`,
    notStated: "nicht angegeben",
    limit: limitText,
    noLimits: "keine: Eine Verifizierung beurteilt nichts",
  },
  key: {
    title: "Schlüssel, mit dem Kalibrierdateien signiert werden",
    none: "Die Station hat noch keinen. Wer eine signierte Datei bekommt, kann prüfen, dass sie von hier stammt und nicht verändert wurde. Im Terminal:",
    owner: "Wem der Schlüssel gehört, für alle, die prüfen",
    ownerHint: "Labor 1, 2027",
    make: "Schlüssel erzeugen",
    of: (owner, id) => `${owner}, Schlüssel ${id}. `,
    download: "Öffentlichen Schlüssel herunterladen",
    give: ": Wer prüfen soll, braucht ihn. Der geheime Schlüssel bleibt im Datenordner der Station.",
  },
  station: {
    title: "Einstellungen der Station",
    about: "Kammer, Vorrichtung, Schalter der Prüflinge, Steckplätze, Ort und Raum, und wer von Alarmen erfährt. Mit dem, was geändert wird, beginnt die Station neu; während einer Kampagne geht es daher nicht.",
    change: "Einstellungen der Station ändern",
    role: "Ein Ingenieur ändert sie.",
  },
  alarms: {
    title: "Wer von Alarmen erfährt",
    none: "Niemand: Nur diese Seite zeigt sie. Postfächer und einen Webhook gibt man weiter unten unter „Einstellungen der Station“ an:",
    how: "so geht es",
    ways: "Mail und Webhook",
    test: "Testnachricht senden",
    sending: "Wird gesendet …",
    to: { mail: "Mail an", webhook: "Webhook an" },
    nothingSent: "nichts gesendet, seit soakd gestartet wurde",
    lastSent: (time) => `zuletzt gesendet: ${time}`,
    waiting: (count) => plural(count, { one: ", eine Nachricht wartet", other: `, ${count} Nachrichten warten` }),
    lastTest: (time, user) => `Letzte Testnachricht ${time}, von ${user}: `,
    tookTest: "vom Server angenommen",
    taken: (ways) => `Der Server hat sie angenommen: ${ways}. Bitte nachsehen, ob sie ankommt.`,
  },
};
