// SPDX-License-Identifier: Apache-2.0
// The warnings of a model, of its verification and of a report in German (docs/fit.md, docs/report.md): what each is called, and what is to be done.

const RECORD_AGAIN = "Diese Segmente neu aufzeichnen; war eine Angabe falsch, sie berichtigen und in eine neue Kampagne importieren.";
const NOTHING = "Nichts zu tun.";
const FIT_AGAIN = "„Anpassen“ klicken, dann das neue Modell verifizieren und seinen Bericht erstellen.";
const MISSING_POSITIONS = "Die fehlenden Lagen bei diesen Temperaturen aufzeichnen, wenn der Prüfling dort eingesetzt wird.";

/** @type {Record<string, [string, string]>} by code */
export const WARNINGS = {
  // of the data gate
  moved: ["bewegt", RECORD_AGAIN],
  knocked: ["angestoßen", RECORD_AGAIN],
  wrong_position: ["falsche Lage", RECORD_AGAIN],
  spike: ["einzelne Ausreißer", "Nichts zu tun, sie sind weggelassen; viele davon weisen auf Kabel oder Adapter hin."],
  lost_packets: ["verlorene Pakete", "Kabel, Adapter und die Rate prüfen, mit der der Prüfling sendet."],
  saturated: ["am Ende des Messbereichs", RECORD_AGAIN],
  stuck: ["hängt fest", "Den Sensor und seinen Anschluss prüfen, dann diese Segmente neu aufzeichnen."],
  dropouts: ["Messwerte fehlen", "Kabel und Aufzeichnung auf verlorene Messwerte prüfen, dann diese Segmente neu aufzeichnen."],
  irregular_sampling: ["ungleiche Abtastung", "Den Takt der Aufzeichnung prüfen; Standardunsicherheiten setzen gleiche Abstände voraus."],
  coarse_thermometer: ["grobes Thermometer", "Ein Thermometer mit feineren Stufen aufzeichnen, falls der Prüfling eines hat."],
  // of the fit
  runs_left_since: ["Läufe sind weggefallen", "Unter „Lücke“ auf „Suchen“ klicken: Dort zeigt sich, ob der Effekt auch ohne sie gefunden wird."],
  copied_runs: ["mehrfach vorhandene Läufe", "Nichts zu tun, sie zählen einmal; wer die Kopien loswerden will, öffnet den Lauf unter „Kampagnen“ und erklärt ihn für ungültig."],
  unit_type_unknown: ["Typ des Prüflings unbekannt", "Die Datei des Typs in procedures/units anlegen, dann neu anpassen."],
  term_not_evaluated: ["angenommener Effekt nicht abgezogen", "Die Spalte aufzeichnen, die der Effekt braucht, oder ihn aus dem Modell nehmen."],
  few_runs: ["wenige Läufe", "Mehr Läufe aufzeichnen: Für einen Fehler an ungesehenen Läufen muss der Prüfling mindestens dreimal eingeschaltet worden sein."],
  one_way: ["nur in einer Richtung", "Einen Prüfablauf aufzeichnen, der heizt und kühlt (sweep = \"up_down\", etwa six-position-both-ways), oder die Hysterese im Typ des Prüflings angeben."],
  one_run: ["ein einziger Lauf", "Mehr Läufe aufzeichnen, mit mindestens dreimaligem Einschalten."],
  few_temperatures: ["wenige Temperaturen", "Mehr Plateaus aufzeichnen."],
  baseline_deployed: ["einfache Kurve statt ANFIS", "Nichts zu tun: Die Datei enthält die bessere Kurve, nach ungesehenen Läufen oder, bei wenigen Läufen, nach dem erwarteten Fehler."],
  one_temperature: ["eine einzige Temperatur", "Im Typ des Prüflings angeben, wie weit Konstanten gelten, oder für Kurven bei drei Temperaturen oder mehr aufzeichnen."],
  misalignment_not_seen: ["Achsenfehler nicht messbar", "Auch Lagen auf Kanten und Ecken aufzeichnen."],
  turns_not_seen: ["zu wenige Bewegungen", "Die Drehraten mitschreiben, während der Prüfling in neun Lagen oder mehr gebracht wird, oder ihn um bekannte Winkel drehen."],
  turns_without_angle: ["Drehungen ohne Winkel", "Den Winkel der Drehungen angeben: turn_deg."],
  turns_saturated: ["Drehungen außerhalb des Messbereichs", "Den Prüfling langsamer bewegen, innerhalb des Messbereichs seiner Drehratensensoren."],
  turns_with_gaps: ["Drehungen mit Lücken", "Ohne Unterbrechung mitschreiben, während der Prüfling bewegt wird."],
  unnamed_attitudes_excluded: ["Lagen ohne Namen weggelassen", "Diese Aufzeichnungen in einer eigenen Kampagne anpassen."],
  hysteresis: ["Hysterese", "Langsamere Rampen, längeres Warten oder ein besser platziertes Thermometer; mit Fehlern dieser Größe ist zu rechnen."],
  missing_position: ["fehlende Lagen", "Die fehlenden Lagen aufzeichnen."],
  cut_short_visit: ["abgebrochenes Plateau", "Dieses Plateau dieses Teils für ungültig erklären, dann neu anpassen: Der andere Teil hat es ganz."],
  scale_left_out: ["Skalenfehler an zu wenigen Temperaturen", "Nichts zu tun, oder die Drehraten an drei Plateaus oder mehr aufzeichnen."],
  scale_range: ["Skalenfehler nicht überall gemessen", MISSING_POSITIONS],
  own_thermometer: ["Sensor mit eigenem Thermometer", "Die Temperatur seines eigenen Thermometers angeben, wenn die Kurve ausgewertet wird."],
  scale_not_measured: ["Skalenfehler nicht gemessen", MISSING_POSITIONS],
  even_order: ["quadratischer Anteil", "Prüfen, ob die Flächen der Vorrichtung rechtwinklig zueinander stehen: Eine schiefe Vorrichtung sieht genauso aus."],
  heading_incomplete: ["unvollständige Azimute", "Die fehlenden Azimute angeben und in eine neue Kampagne importieren, oder auf sie verzichten."],
  rate_positions: ["Drehung der Vorrichtung", NOTHING],
  check_standard_out_of_control: ["Kontrollnormal außerhalb der Eingriffsgrenzen", "Vor der Auslieferung herausfinden, was sich an der Station geändert hat; die Hilfe hat dazu „Check standards“."],
  reference_retired: ["Prüfmittel ausgemustert", "Prüfen, ob der Grund auch betrifft, was vorher damit gemessen wurde."],
  reference_withdrawn: ["Kalibrierschein zurückgezogen", "Den richtigen Kalibrierschein eintragen, dann neu anpassen."],
  reference_expired: ["Kalibrierschein abgelaufen", "Kalibrieren lassen und den Kalibrierschein eintragen; hat sich der Wert geändert, für ungültig erklären, was damit gemessen wurde."],
  waiver_signature: ["Unterschrift einer Ausnahme stimmt nicht", "Mit den Unterlagen des Labors vergleichen; eine neue Ausnahme unterschreiben, dann neu anpassen und exportieren."],
  gravity_assumed: ["Fallbeschleunigung angenommen", "Diese Läufe für ungültig erklären und mit Breite und Höhe oder mit der Fallbeschleunigung neu importieren."],
  one_attitude: ["eine einzige Lage", "Sechs Lagen aufzeichnen, wenn Nullpunkt- und Skalenfehler der Beschleunigung absolut gebraucht werden."],
  runs_without_plateaus: ["Läufe ohne Plateaus", "In diesen Aufzeichnungen plateau_c angeben, oder sie in einer eigenen Kampagne anpassen."],
  // of a verification
  not_verified: ["nicht verifiziert", "Die Verifizierungsläufe mit diesem Sensor aufzeichnen oder importieren."],
  gravity_differs: ["andere Fallbeschleunigung", "Die Verifizierungsläufe mit der Fallbeschleunigung importieren, mit der die Datei entstanden ist."],
  partial_range: ["nur ein Teil des Bereichs", "Über den ganzen Temperaturbereich verifizieren."],
  out_of_range: ["außerhalb des Bereichs", "Innerhalb des gültigen Bereichs verifizieren."],
  band_too_narrow: ["Band zu schmal", "Auf die Fehler der neuen Läufe verlassen, nicht auf die Bänder; herausfinden, was sich seit der Anpassung geändert hat, oder mehr Läufe aufzeichnen."],
  // of a report
  simulated: ["simulierte Daten", "Nicht in einem echten Prüfling verwenden."],
  voided_since: ["Daten seither ungültig", FIT_AGAIN],
  not_in_model: ["Läufe fehlen im Modell", FIT_AGAIN],
  run_missing: ["Lauf verloren", "Den Lauf wiederherstellen oder mit den übrigen Läufen neu anpassen."],
  rows_missing: ["Messwerte verloren", "Die Läufe wiederherstellen oder neu aufzeichnen, dann neu anpassen."],
  older_epoch: ["vor einer Reparatur oder Änderung", "Den Prüfling aufzeichnen, wie er jetzt ist, und neu anpassen."],
  older_model: ["älteres Modell", "Den Bericht vom neuesten Modell erstellen, wenn nicht gerade dieses gewünscht ist."],
  verification_failed: ["Verifizierung nicht möglich", "Verifizierungsläufe aufzeichnen oder importieren, die die Temperaturen des Modells abdecken."],
};

/** Sentences of warnings that say the same of every unit, by what the station says. @type {Record<string, string>} */
export const SENTENCES = {
  "the model comes from SIMULATED data: it is not of a real unit": "Das Modell stammt aus SIMULIERTEN Daten: Es ist nicht von einem echten Prüfling",
};
