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
  notRecorded: "nicht aufgezeichnet",
  chain: {
    title: "Ist das Protokoll so, wie es geschrieben wurde?",
    check: "Kette prüfen",
    about: "Jedes Ereignis trägt einen Hash aller Ereignisse davor. Die Prüfung liest das ganze Protokoll und sagt, ob eines verändert oder entfernt wurde. In einem Terminal:",
    reading: "Das ganze Protokoll wird gelesen…",
    whole: (count, end) => `Ereignisse: ${count}, keines verändert oder entfernt. Ende der Kette: ${end ?? "keines"}`,
    notChecked: "Nicht geprüft: ",
  },
};
