// SPDX-License-Identifier: Apache-2.0
// What the view of the event log says, in German. The events are the station's own words.

/** @type {typeof import("./text_events_en.mjs").text} */
export const text = {
  title: "Ereignisse: wer wann was getan hat",
  kind: "Art",
  all: "alle",
  about: "Betrifft",
  aboutHint: "Prüfling, Lauf, Kampagne",
  by: "Durch",
  byHint: "Bediener",
  from: "Von",
  to: "Bis",
  show: "Anzeigen",
  clear: "Zurücksetzen",
  none: "Kein Ereignis passt dazu. „Betrifft“ und „Durch“ müssen der ganze Name sein.",
  time: "Zeit",
  what: "Was",
  older: "Ältere",
  nobody: "niemand genannt",
  run: (label, campaign) => `${label} der Kampagne ${campaign}`,
  times: (count) => ` (${count}-mal)`,
  kinds: {
    alarm_sent: "Alarmnachricht", backup_made: "Sicherung", calibration_exported: "Export", campaign: "Kampagne", campaign_aborted: "Kampagne abgebrochen", campaign_begun: "Kampagne begonnen",
    campaign_failed: "Kampagne gescheitert", campaign_finished: "Kampagne fertig", campaign_interrupted: "Kampagne unterbrochen", campaign_paused: "Kampagne angehalten", campaign_running: "Kampagne läuft",
    device: "Gerät", epoch_begun: "Reparatur oder Änderung", gap_accepted: "Effekt angenommen", job_ended: "Auftrag beendet", job_started: "Auftrag begonnen", key_made: "Schlüssel erzeugt",
    model_added: "Modell entstanden", model_released: "Modell freigegeben", model_verified: "Modell verifiziert", nothing_to_void: "für ungültig erklärt, ohne Daten", procedure_made: "Prüfablauf angelegt", prompt: "Frage an den Bediener", reference: "Prüfmittel",
    reference_added: "Kalibrierschein eingetragen", run: "Lauf", run_added: "Lauf gespeichert", segment: "Segment", station_changed: "Einstellungen geändert", station_change_undone: "Einstellungen zurückgenommen", station_set_up: "Station eingerichtet", step: "Schritt", unit: "Prüfling", unit_added: "Prüfling angelegt",
    check_standard_added: "Kontrollnormal benannt", gap_withdrawn: "Effekt zurückgenommen", noise_exported: "Rauschwerte ausgegeben", reference_retired: "Kalibrierschein außer Dienst",
    reference_withdrawn: "Kalibrierschein zurückgezogen", samples_dropped: "Messwerte entfernt", shard_merged: "Modelle eines anderen Rechners", verification: "Verifizierung", voided: "für ungültig erklärt",
    account: "Konto", alarm: "Alarm", alarm_not_sent: "Alarmnachricht nicht gesendet", chamber: "Kammer", check_standard: "Kontrollnormal", check_standard_ended: "kein Kontrollnormal mehr",
    journal: "Aufzeichnung der Kampagne", logged_in: "angemeldet", logged_out: "abgemeldet", login_limited: "Anmeldung für eine Weile gesperrt", login_refused: "Anmeldung abgelehnt", model_fitted: "Modell angepasst",
    model_withdrawn: "Modell zurückgezogen", position: "Lage", power: "Stromversorgung", reference_waived: "Ausnahme für ein abgelaufenes Prüfmittel", run_warning: "Warnung zu einem Lauf", storage: "Speicher",
  },
  chain: {
    title: "Ist das Protokoll so, wie es geschrieben wurde?",
    check: "Kette prüfen",
    about: "Jedes Ereignis trägt einen Hash aller Ereignisse davor. Die Prüfung liest das ganze Protokoll und sagt, ob eines verändert oder entfernt wurde. In einem Terminal:",
    reading: "Das ganze Protokoll wird gelesen…",
    whole: (count, end) => `Ereignisse: ${count}, keines verändert oder entfernt. Ende der Kette: ${end ?? "keines"}`,
    notChecked: "Nicht geprüft: ",
  },
};
