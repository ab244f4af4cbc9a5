// SPDX-License-Identifier: Apache-2.0
// What the page says, in German: as a technician of a laboratory says it. What the station itself says is English; what has a code is said here by it.

import { number, plural, setTemperature, written } from "./format.mjs";

const sign = (label) => label.replace("-", "−");
const list = (names) => new Intl.ListFormat("de").format(names);
/** "Steckplatz A" or "den Steckplätzen A und B": in the case that follows `in`. */
const slotsText = (names) => plural(names.length, { one: `Steckplatz ${names[0]}`, other: `den Steckplätzen ${list(names)}` });

const CLOSED = "Die Tür geschlossen halten, bis die Station sie freigibt.";
const GOES_ON = "Die Kampagne läuft dann von selbst weiter.";
const WAITS = {
  air: ["Die Lufttemperatur ist nicht am Sollwert: Die Kampagne wartet", "Die Tür der Temperaturkammer schließen und die Anzeige der Kammer ablesen. Ist der Sollwert wieder erreicht, läuft die Kampagne von selbst weiter."],
  disk: ["Die Festplatte ist voll: Die Kampagne wartet", `Auf der Festplatte der Station Platz schaffen, im Datenordner aber nichts löschen. ${GOES_ON}`],
  storage: ["Messwerte lassen sich nicht schreiben: Die Kampagne wartet", "Die Festplatte der Station prüfen. Sobald sie sich beschreiben lässt, läuft die Kampagne von selbst weiter."],
  supply: ["Die Versorgungsspannung eines Prüflings liegt außerhalb der Grenzen: Die Kampagne wartet", "Netzgerät und Kabel prüfen. Stimmt die Spannung wieder, läuft die Kampagne von selbst weiter."],
  catalog: ["Der Katalog lässt sich nicht schreiben: Die Kampagne wartet", `Das andere Programm beenden, das ihn belegt (ein angehaltenes „soak import“?). ${GOES_ON}`],
};

/** What to do at a chamber that does not answer; what becomes of the campaign then. */
function atSilentChamber({ state, suspension, units }) {
  if (state === "stopping") return "Zur Kammer gehen: Antwortet sie nicht, lässt sie sich nur von Hand abschalten, und zwar erst, wenn die Prüflinge warm sind.";
  const isAnyHeard = units.length === 0 || units.some((unit) => unit.dropped === null && unit.state !== "failed" && unit.state !== "silent");
  if (state !== "paused" && !isAnyHeard) return "Zur Kammer gehen: Ist der Strom ausgefallen? Auch von den Prüflingen kommt nichts. Ein Prüfling, der ohne Strom war, kann seinen Lauf nicht fortsetzen: Waren es alle, endet die Kampagne, und „Fortsetzen“ führt sie weiter.";
  const look = "Zur Kammer gehen: Ist sie eingeschaltet, steckt das Kabel?";
  if (suspension) return `${look} ${String(suspension.causes) === "chamber" ? "Sobald sie antwortet, läuft die Kampagne von selbst weiter." : "Die Kampagne wartet auch noch auf etwas anderes."}`;
  if (state === "paused") return `${look} Die Kampagne bleibt pausiert; „Fortsetzen“ gibt der Kammer ihren Sollwert wieder.`;
  return `${look} Antwortet sie binnen einer Minute, geht es sofort weiter.`;
}

/** What to do about a unit that is lost; `then`: what becomes of the others, if there are any. */
function atLostUnit({ units }, then) {
  const isAnyLeft = units.some(({ dropped, state }) => dropped === null && state !== "failed");
  return `Kabel und Versorgung prüfen. ${isAnyLeft ? then : "Kein Prüfling ist mehr übrig: Ohne einen kann die Kampagne nicht weiterlaufen."}`;
}

function wrongFace(who, { about }, status, turn) {
  const { up, expected } = status.units.find(({ serial }) => serial === about).attitude;
  const byHand = status.fixture.description === "by hand";
  const action = up === expected || byHand ? `${byHand && up !== expected ? "Die Vorrichtung drehen" : who}: ${turn}.`
    : "Prüfen, ob er so eingebaut ist, wie es in der Konfiguration der Station steht, und ob die Vorrichtung wirklich in der Lage ist, die sie meldet.";
  return { title: up === expected ? `${who} liegt schief` : `${who} hat ${sign(up)} oben statt ${sign(expected)}`, action };
}

/** What is to be done at a campaign that has ended and does not go on by itself. */
function afterAnEnd(ending) {
  const resume = "„Fortsetzen“ setzt sie fort, sobald die Station sicher ist.";
  if (ending?.outcome === "interrupted") return `${resume} Wurde soakd beendet, soakd vorher wieder starten.`;
  return `Beheben, was hier genannt ist.${ending && ending.outcome !== "aborted" ? ` ${resume}` : ""}`;
}

/** {title, action} of each alarm by its code (docs/http-api.md, `alarms`). */
const ALARMS = {
  chamber_silent: (alarm, status) => ({ title: "Die Temperaturkammer antwortet nicht", action: atSilentChamber(status) }),
  chamber_alarm: ({ about }) => ({ title: `Die Temperaturkammer meldet einen Alarm: ${about}`, action: `Zur Kammer gehen und auf ihre Anzeige sehen. ${CLOSED}` }),
  chamber_not_off: () => ({ title: "Die Temperaturkammer schaltet nicht ab", action: `Zur Kammer gehen und Heizung und Kühlung von Hand abschalten. ${CLOSED}` }),
  data_folder: () => ({ title: "Der Datenordner fehlt", action: "Ihn wiederherstellen (ist seine Festplatte eingehängt?) oder soakd neu starten. Vorher beginnt keine Kampagne." }),
  unit_dropped: (alarm, status, who) => ({ title: `${who} wurde ausgelassen: in diesem Lauf nicht aufgezeichnet`,
    action: atLostUnit(status, "Die anderen Prüflinge laufen weiter, der nächste Lauf versucht es wieder mit ihm.") }),
  unit_failed: (alarm, status, who) => ({ title: `${who} ist ausgefallen`, action: atLostUnit(status, "Die anderen Prüflinge laufen weiter.") }),
  unit_face: (alarm, status, who, turn) => wrongFace(who, alarm, status, turn),
  campaign_aborted: () => ({ title: "Die Kampagne wurde abgebrochen: Die Station geht in den sicheren Zustand", action: CLOSED }),
  campaign_ended: (alarm, { resumes_by_itself, ending }) => ({ title: "Die Kampagne ist zu Ende: Die Station geht in den sicheren Zustand",
    action: `${resumes_by_itself ? "Sie läuft dann von selbst weiter; wer das nicht will, bricht sie ab." : afterAnEnd(ending)} ${CLOSED}` }),
  campaign_failed: (alarm, { resumable }) => ({ title: "Die Kampagne ist fehlgeschlagen",
    action: resumable ? "Beheben, was hier genannt ist, dann „Fortsetzen“ drücken: Es geht beim Plateau vor der Unterbrechung weiter."
      : "Beheben, was hier genannt ist, dann eine neue Kampagne starten." }),
  campaign_interrupted: (alarm, { resumes_by_itself, resumable }) => resumes_by_itself
    ? { title: "Die Kampagne wurde unterbrochen und läuft von selbst weiter", action: "Die Tür geschlossen halten. Wer das nicht will, bricht sie ab." }
    : { title: "Die Kampagne wurde unterbrochen", action: resumable ? "„Fortsetzen“ drücken: Es geht beim Plateau vor der Unterbrechung weiter." : "Eine neue Kampagne starten." },
  queue_begins: ({ about }) => ({ title: `Kampagne ${about} beginnt von selbst`, action: "Die Tür geschlossen halten. Wer das nicht will, bricht sie ab." }),
  queue_held: ({ about }) => ({ title: `Kampagne ${about} beginnt nicht`, action: "Beheben, was hier genannt ist, dann „Nächste beginnen“ drücken." }),
};

function alarmText(alarm, status, turn) {
  const unit = status.units.find(({ serial }) => serial === alarm.about);
  const waits = WAITS[alarm.code.replace(/^waits_for_/, "")];
  const deadline = alarm.code === "queue_begins" ? "Beginn:" : "Sonst endet die Kampagne:";
  if (waits) return { title: waits[0], action: waits[1], deadline };
  const said = ALARMS[alarm.code]?.(alarm, status, unit && `Prüfling ${unit.serial} in Steckplatz ${unit.slot}`, turn);
  return { title: alarm.title, action: alarm.action, ...said, deadline };
}

/** What is asked, by its code (docs/http-api.md, `prompt`). */
const QUESTIONS = {
  position: ({ position, wrong }) => `${wrong.length > 0 ? `Noch nicht richtig: Prüfling ${list(wrong)}. ` : ""}Die Vorrichtung so drehen, dass ihr ${sign(position)} nach oben zeigt, dann bestätigen.`,
  heading: ({ heading_deg }) => heading_deg === 0 ? "Die ganze Vorrichtung in ihre übliche Richtung zurückdrehen, dann bestätigen."
    : `Die ganze Vorrichtung aus ihrer üblichen Richtung um ${written(String(Math.abs(heading_deg)))}° ${heading_deg > 0 ? "im" : "gegen den"} Uhrzeigersinn drehen (von oben gesehen), dann bestätigen.`,
  dry_air: ({ temp_c }) => `Die Spülung mit trockener Luft einschalten, dann bestätigen: Der nächste Sollwert ist ${setTemperature(temp_c)} °C.`,
  power: ({ off_s, slots }) => `Die Prüflinge in ${slotsText(slots)} mindestens ${number(off_s, 0)} s lang ausschalten, wieder einschalten und bestätigen.`,
  units: ({ slots, expected, found }) => `${slots.map((slot, i) => `In Steckplatz ${slot} steckt Prüfling ${found[i]}, erwartet ist ${expected[i]}.`).join(" ")}
    Die richtigen Prüflinge einsetzen oder ihre Kabel umstecken, dann bestätigen. Sind die Seriennummern der Kampagne falsch: abbrechen und mit den richtigen neu starten.`,
};

/** @type {typeof import("./text_en.mjs").text} */
export const text = {
  nav: {
    views: "Ansichten", station: "Station", runs: "Kampagnen und Läufe", units: "Prüflinge", fleet: "Flotte", events: "Ereignisse", records: "Prüfmittel", help: "Hilfe",
  },
  head: {
    connecting: "Verbinde …",
    simulated: "SIMULIERT",
    simulatedTip: "Prüflinge oder Uhr sind simuliert: Mit diesen Zahlen wird nichts kalibriert",
    operator: "Bediener",
    yourName: "Ihr Name",
    logOut: "Abmelden",
    soundOff: "Alarmton aus",
    soundOn: "Alarmton an",
    soundAsks: "Alarmton: zum Erlauben klicken",
    campaign: "Kampagne",
    noCampaign: "Keine Kampagne",
    noStation: "Keine Station",
    waitsForYou: "Wartet auf Sie",
    language: "Sprache",
    licence: "Lizenz von dygraphs",
    viewFailure: "Diese Ansicht konnte nicht geladen werden. Ist die Station da? Noch einmal dorthin gehen oder die Seite neu laden.",
  },
  help: {
    title: "Hilfe",
    english: "Die Anleitung gibt es nur auf Englisch.",
    find: "Suchen",
    findHint: "limit, release, alarm…",
    reading: "Die Seiten werden gelesen…",
    nothing: "Keine Stelle der Hilfe hat alle diese Wörter. Sie ist auf Englisch.",
    found: (count) => plural(count, { one: `${count} Stelle:`, other: `${count} Stellen:` }),
    unknown: (name) => `In der Hilfe gibt es keine Seite „${name}“.`,
    noAnswer: "Die Station antwortet nicht: Diese Seite der Hilfe ist jetzt nicht zu lesen.",
  },
  lost: {
    title: "Keine Verbindung zu soakd.",
    before: "Stand der Anzeige:",
    after: "; die Kampagne selbst läuft vielleicht weiter. Ist soakd ausgefallen, steuert niemand die Kammer: hingehen und nachsehen. Neuer Versuch …",
    nowhere: "noch keiner",
    door: "Es besteht keine Verbindung zu soakd. Ist es ausgefallen, steuert niemand die Kammer, und sie bleibt bei ihrem letzten Sollwert: hingehen und nachsehen. „soak chamber make-safe --config station.toml“, mit der Datei der Station, macht sie sicher.",
  },
  roles: {
    viewer: "Dieses Konto sieht alles und ändert nichts",
    operator: "Dieses Konto fährt Kampagnen und beurteilt Prüflinge; Freigabe, Export, Schlüssel, Kalibrierscheine und das Ungültigerklären brauchen die Rolle Ingenieur",
    engineer: "Dieses Konto darf alles",
  },
  roleNames: { viewer: "Betrachter", operator: "Bediener", engineer: "Ingenieur" },
  login: {
    title: "An dieser Station anmelden",
    page: "Soak: Anmeldung",
    name: "Name",
    password: "Passwort",
    send: "Anmelden",
    forgotten: "Vergessen? Wer die Station betreibt, gibt Ihnen ein neues Passwort.",
  },

  // ---- the campaign

  states: {
    idle: "bereit", preflight: "Vorprüfung", running: "läuft", waiting: "wartet", paused: "pausiert", stopping: "wird beendet", interrupted: "unterbrochen",
    finished: "fertig", aborted: "abgebrochen", failed: "fehlgeschlagen",
  },
  waitsFor: {
    chamber: "wartet auf die Temperaturkammer", air: "wartet auf die Lufttemperatur", disk: "wartet auf Platz auf der Festplatte", storage: "wartet auf die Festplatte",
    supply: "wartet auf die Versorgungsspannung", catalog: "wartet auf den Katalog",
  },
  waitsForYou: "wartet auf Sie",
  imported: "importiert",
  purposes: { calibration: "Kalibrierung", verification: "Verifizierung", diagnosis: "Diagnose" },
  campaign: {
    title: "Kampagne",
    pause: "Pausieren",
    resume: "Fortsetzen",
    next: "Nächste beginnen",
    abort: "Kampagne abbrechen …",
    ready: "Fertig",
    readyIfOn: "Fertig, wenn es jetzt weitergeht",
    done: "Erledigt",
    run: "Lauf",
    step: "Schritt",
    left: "Restzeit",
    leftProcess: "Simulierte Restzeit",
    leftHost: (rate) => `Wirkliche Restzeit (${rate}-fache Geschwindigkeit)`,
    procedure: "Prüfablauf",
    of: (number, all) => `${number} von ${all}`,
    preflight: "Vorprüfung",
    after: {
      finished: (name) => `${name} ist fertig.`,
      aborted: (name) => `${name} wurde abgebrochen: Die fertigen Läufe bleiben.`,
      then: "Als Nächstes:",
      toRuns: "ihre Läufe ansehen",
      toUnits: { calibration: "ihre Prüflinge kalibrieren und beurteilen", verification: "ihre Prüflinge verifizieren", diagnosis: "die Lücke ihrer Prüflinge suchen" },
      dismiss: "Ausblenden",
    },
    giveUp: (resumable) => `${resumable} aufgeben, nächste beginnen`,
    queue: "Kampagnen in der Warteschlange",
    takeOut: "Entfernen",
    takeOutLabel: (name) => `${name} aus der Warteschlange nehmen`,
    queued: (name, procedure, time, user) => `${name}: ${procedure}, etwa ${time}, eingereiht von ${user}`,
    command: (name) => ({ pause: "Pausieren", resume: "Fortsetzen", next: "Nächste beginnen", abort: "Kampagne abbrechen", confirm: "Bestätigen", unqueue: "Entfernen" }[name] ?? name),
  },
  steps: {
    up: (face) => `, ${face} oben`,
    turnWhole: "die ganze Vorrichtung drehen",
    switchOffAndOn: "die Prüflinge aus- und wieder einschalten",
    unitsStart: "Prüflinge starten",
    turn: (up) => `Vorrichtung drehen${up}`,
    turning: (up) => `dreht${up}`,
    spins: (rate) => `dreht mit ${rate} °/s`,
    spinEnds: "Drehung wird gestoppt",
    dryAir: "trockene Luft",
    chamberGoesTo: (temp) => `Kammer fährt auf ${temp} °C`,
    chamberOnItsWay: "Kammer fährt zum Sollwert",
    settling: "Temperaturausgleich der Prüflinge",
    recording: (up) => `Aufzeichnung${up}`,
    check: "Prüflinge werden geprüft",
    warmEnd: "Aufwärmen, damit sich kein Tau bildet",
    powerOff: "Prüflinge werden ausgeschaltet",
    plateau: (temp, number, all) => `${temp} °C (${number} von ${all})`,
    run: (number, all) => `Lauf ${number} von ${all}`,
    preflight: "Vorprüfung",
    stopping: "Auf dem Weg in den sicheren Zustand",
    canBeResumed: (name) => `Kampagne ${name} kann fortgesetzt werden`,
    none: "Keine Kampagne läuft",
    inState: (state) => `Die Kampagne: ${state}`,
    allDone: "Alle Schritte sind erledigt",
    stoppedAt: (step) => `Angehalten bei: ${step}`,
  },
  queue: {
    then: (names) => `Danach: ${names}.`,
    atTime: (names, first, time) => `Als Nächstes: ${names}. ${first} beginnt von selbst: ${time}; „Kampagne abbrechen“ verhindert das.`,
    waits: (names) => `In der Warteschlange: ${names}.`,
    waitsForYou: (names) => `In der Warteschlange: ${names}. Weiter geht es erst mit „Nächste beginnen“.`,
  },
  abort: {
    title: "Die Kampagne abbrechen?",
    reason: "Grund",
    keep: "Weiterlaufen lassen",
    send: "Kampagne abbrechen",
    queued: (name) => `Kampagne ${name} beginnt nicht von selbst. Sie bleibt in der Warteschlange. Was aufgezeichnet ist, bleibt.`,
    givenUp: (name) => `Kampagne ${name} wird aufgegeben: Sie kann danach nicht fortgesetzt werden. Ihre fertigen Läufe bleiben.`,
    run: (number, all) => `von Lauf ${number} von ${all}`,
    preflight: "von der Vorprüfung",
    label: (label) => `von ${label}`,
    before: (count) => ` ${plural(count, { one: "Der Lauf davor bleibt.", other: `Die ${count} Läufe davor bleiben.` })}`,
    loses: (what, before) => `Was ${what} aufgezeichnet ist, wird ungültig: Es bleibt erhalten, geht aber in keine Kalibrierung ein.${before}
    Die Kampagne kann danach nicht fortgesetzt werden. Die Temperaturkammer geht in ihren sicheren Zustand, die Prüflinge werden ausgeschaltet. Wer nur eine Weile anhalten will, pausiert stattdessen.`,
  },
  door: {
    unknown: "Unbekannt, ob die Tür geöffnet werden darf",
    closed: "Tür geschlossen halten",
    open: "Tür darf geöffnet werden",
    dew: (temp) => `Taupunkt des Raums ${temp} °C`,
    dewAssumed: (temp) => `Taupunkt ${temp} °C: angenommen, weil kein Taupunkt des Raums angegeben ist`,
    later: (time, span) => ` Ohne Pause darf sie geöffnet werden, wenn die Kampagne beendet ist, ${time} (in ${span}).`,
    betweenRuns: (time, span) => ` Am Ende dieses Laufs, ${time} (in ${span}), sind die Prüflinge warm: dann „Pausieren“ drücken, der nächste Lauf beginnt von selbst.`,
    pauseNext: (temp) => ` Zum Öffnen beim nächsten Plateau von ${temp} °C „Pausieren“ drücken und auf die grüne Lampe warten.`,
    wayBack: " Sobald die Kampagne wieder dort ist, wo sie stand, steht hier, wann sie geöffnet werden kann.",
    turnClosed: " Die Vorrichtung bei geschlossener Tür drehen: durch die Durchführung der Kammer, mit ihrem Handschuh oder einer Welle.",
    pauseAt: (temp, time, span) => ` Zum Öffnen bei ${temp} °C „Pausieren“ drücken, ab ${time} (in ${span}), und auf die grüne Lampe warten.`,
    waitHere: " Auf die grüne Lampe warten: Dieser Sollwert ist ungefährlich.",
    pausedHere: " Eine Pause hält diese Temperatur: „Fortsetzen“ drücken, und an einem ungefährlichen Plateau wieder „Pausieren“.",
    noChamber: (dew) => `Die Temperatur der Kammer ist nicht bekannt; ${dew}.`,
    moves: "Die Vorrichtung bewegt sich",
    cold: (coldest, dry, dew) => `An kalten Prüflingen bildet sich Tau: Das kälteste Teil hat ${coldest} °C, nötig sind ${dry} °C (${dew})`,
    hot: (hottest) => `Heiß: ${hottest} °C`,
    goesOn: "Die Kampagne läuft von selbst weiter, sobald die Kammer sicher ist: zuerst abbrechen",
    begins: (name, time) => `Kampagne ${name} beginnt von selbst (${time}): zuerst abbrechen`,
    paused: (coldest, dew) => `Pausiert; ${coldest} °C, ${dew}. Nach „Fortsetzen“ wird der Temperaturausgleich neu abgewartet.`,
    asks: (coldest, dew) => `Die Station wartet auf Sie; ${coldest} °C, ${dew}.`,
    notOff: "Heizung und Kühlung sind nicht aus",
    stopping: "Die Kammer wird in den sicheren Zustand gebracht",
    runs: "Eine Kampagne läuft: zuerst pausieren",
    coldUnits: (air, dew) => `Die Luft hat ${air} °C, aber die Prüflinge melden nicht, wie kalt sie sind; ${dew}.`,
    safe: (coldest, dew) => `${coldest} °C, ${dew}.`,
  },

  // ---- what needs somebody

  alarm: (alarm, status, turn) => alarmText(alarm, status, turn),
  prompt: {
    title: "Die Station wartet auf Sie",
    faces: "Was oben liegt",
    confirm: "Bestätigen",
    itself: "Von selbst bestätigen, sobald jeder Prüfling so liegt",
    asks: (prompt) => QUESTIONS[prompt.code]?.(prompt.about) ?? prompt.text,
    unit: (serial, slot, face) => `${serial}, Steckplatz ${slot}: ${face}`,
    isUp: (face) => `${face} liegt oben`,
    ownAxes: " (in seinen eigenen Achsen)",
  },
  faces: {
    tilted: (tilt, face) => `weicht um mehr als ${tilt}° von ${face} ab, richtig aufsetzen`,
    quarter: (up, face) => `${up} liegt jetzt oben, eine Vierteldrehung auf ${face} drehen`,
    half: (up, face) => `${up} liegt jetzt oben, eine halbe Drehung auf ${face} drehen`,
    turning: (face) => `dreht auf ${face}`,
    isTilted: (face) => `${face}, schief`,
    wrong: (up, face) => `${up} statt ${face}`,
    asAsked: "richtig",
    seat: "so aufsetzen",
    turn: "so drehen",
    now: "jetzt",
    nowOf: (whose) => `jetzt, ${whose}`,
    upNow: (up, face) => `${up} liegt jetzt oben, ${face} soll oben liegen`,
    isUp: (face) => `${face} oben`,
  },

  // ---- at rest

  stored: {
    title: "Diese Station",
    nothing: "Noch ist keine Kampagne und kein Lauf gespeichert.",
    more: (count) => `und ${count} weitere`,
    campaigns: "Kampagnen",
    toRuns: "ihre Läufe ansehen",
    units: "Prüflinge",
    toUnits: "beurteilen und übergeben",
    name: "Name", state: "Zustand", begun: "Begonnen", runs: "Läufe", serial: "Seriennummer", type: "Typ", lastRun: "Letzter Lauf",
  },
  start: {
    title: "Neue Kampagne",
    queueTitle: "Kampagne einreihen",
    procedure: "Prüfablauf",
    file: "Datei mit dem Prüfablauf",
    name: "Name der Kampagne",
    slot: (name) => `Steckplatz ${name}: Seriennummer`,
    review: "Was diese Kampagne wäre",
    send: "Starten",
    queue: "In die Warteschlange",
    about: "Alles wird geprüft, bevor sich etwas bewegt. Eine Kampagne in der Warteschlange beginnt, wenn die vor ihr mit allen Prüflingen fertig sind; endet eine davon anders, wartet sie auf jemanden. Im Terminal:",
    givesUp: (name) => `„Starten“ gibt ${name} auf: Sie kann danach nicht fortgesetzt werden.`,
    unknown: { procedures: "Die Station sagt nicht, welche Prüfabläufe sie hat", types: "Die Station sagt nicht, welche Typen sie kennt", stored: "Die Station sagt nicht, welche Steckplätze sie hat" },
    mistakes: (file) => `${file} (mit Fehlern)`,
    choose: "Wählen …",
    own: "Eine eigene Datei …",
    change: "Seine Sollwerte ändern",
    gone: (file) => `${file} ist weg: einen anderen Prüfablauf wählen`,
    typeOf: (serial) => `Typ von Prüfling ${serial}`,
    enter: (serial) => `Prüfling ${serial} eintragen als`,
    runs: (count) => plural(count, { one: `${count} Lauf`, other: `${count} Läufe` }),
    visits: (count) => plural(count, { one: `je ${count} Plateau`, other: `je ${count} Plateaus` }),
    visitsOf: (counts) => `${counts.slice(0, -1).join(", ")} und ${counts.at(-1)} Plateaus`,
    positions: (count) => plural(count, { one: `${count} Lage`, other: `${count} Lagen` }),
    at: (temp) => `bei ${temp} °C`,
    range: (lowest, highest) => `von ${lowest} bis ${highest} °C`,
    takes: (time) => `dauert etwa ${time}`,
    simulated: (simulated, real) => `dauert etwa ${simulated} simulierte Zeit, ${real} wirkliche Zeit`,
    simulatedByHand: (simulated) => `dauert etwa ${simulated} simulierter Zeit, dazu die Zeit für jedes Drehen`,
    ends: (time) => `; Ende bei sofortigem Start: ${time}`,
    writes: (size) => `schreibt etwa ${size}`,
    free: (size) => `; ${size} sind frei`,
    turns: (count, every) => `Von Hand gedreht: Jemand dreht die Vorrichtung ${count}-mal, etwa alle ${every}, bis zum Ende. Kommt niemand, wartet die Kampagne.`,
    turnsSimulated: (count, every) => `Von Hand gedreht: Jemand dreht die Vorrichtung ${count}-mal, etwa alle ${every} simulierter Zeit, bis zum Ende. Kommt niemand, wartet die Kampagne.`,
    turnsClosed: (temps, from, to) => `Bei ${temps} °C bei geschlossener Tür drehen: durch die Durchführung der Kammer, mit ihrem Handschuh oder einer Welle. Hat Ihre keine? Dann einen Prüfablauf zwischen ${from} und ${to} °C wählen.`,
    noUnit: "Noch keine Seriennummer: die von mindestens einem Prüfling eingeben.",
    noHindrance: "Hindert den Start nicht: ",
    last: (serials) => `Wie beim letzten Mal: ${serials}`,
    refused: "Abgelehnt: ",
    toRecords: "Den neuen Kalibrierschein eintragen oder das Prüfmittel ausmustern: Prüfmittel",
    holds: (slot, serial, type) => `Steckplatz ${slot}: ${serial}, Typ ${type}`,
    look: "Steckplätze abfragen",
    looking: "Wird abgefragt, einige Sekunden …",
    waitsForLook: "Starten: wartet auf die Abfrage der Steckplätze",
  },
  found: {
    unit: (serial, product, firmware) => [serial, product, firmware && `Firmware ${firmware}`].filter(Boolean).join(", "),
    right: (unit) => `✓ ${unit}`,
    wrong: (unit) => `✗ Hier steckt ${unit}: ein anderer Prüfling als in diesem Feld.`,
    new: (unit) => `Hier steckt ${unit}.`,
    take: (serial) => `${serial} übernehmen`,
    anonymous: "Sendet Daten, sagt aber nicht, wer er ist: andere Art Prüfling oder andere Baudrate?",
    silent: "Keine Antwort: Ist der Prüfling eingeschaltet?",
    output: (number) => ` Ausgang ${number} speist ihn und wird erst beim Start einer Kampagne eingeschaltet. Bis dahin die Nummer von seinem Schild ablesen; die Kampagne fragt den Prüfling selbst.`,
    failed: "Nicht abzufragen:",
  },

  // ---- devices

  chart: { title: "Temperaturen", label: "Temperaturen über der Zeit", chamber: "Kammer", setPoint: "Sollwert", at: (time) => `Zeit: ${time}`, after: (span) => `nach ${span}`, keys: "Die Pfeiltasten bewegen einen Zeiger." },
  chamber: {
    title: "Temperaturkammer",
    air: "°C Luft",
    setPoint: "Sollwert",
    output: "Stellgröße",
    stopped: ", aus",
    fixture: "Vorrichtung",
    alarms: "Alarme",
    byHand: "von Hand gedreht",
    notConnected: "nicht verbunden",
    notAsked: "wird jetzt nicht abgefragt",
    moving: "bewegt sich",
    noAnswer: "antwortet nicht",
    silent: (span) => `stumm seit ${span}`,
    connected: "verbunden",
  },
  unit: {
    label: (serial) => `Prüfling ${serial}`,
    slot: (name) => `Steckplatz ${name}`,
    noLink: "keine Verbindung",
    states: { closed: "aus", silent: "sendet nichts", configuring: "startet", streaming: "an", failed: "ausgefallen" },
    dropped: "ausgelassen: in diesem Lauf nicht aufgezeichnet",
    stable: "✓ stabil",
    settling: "noch nicht stabil",
    slope: "Anstieg, K/min",
    position: "Lage",
    samples: "Messwerte",
    lost: "Verlorene Pakete",
    gyro: "Drehrate, °/s",
    accel: "Beschl., m/s²",
    noiseTip: "Allan-Abweichung dessen, was in diesem Lauf in Ruhe aufgezeichnet wurde",
    noiseAt: "Rauschen bei",
    gyroNoise: "Drehrate, m°/s",
    accelNoise: "Beschl., mm/s²",
    simulated: "simuliert",
  },
  noise: {
    title: "Rauschen",
    unit: "Prüfling",
    sensors: "Sensoren",
    gyros: "Drehraten",
    accels: "Beschleunigungen",
    empty: "In diesem Lauf noch nichts. Das Rauschen erscheint, sobald ein Prüfling einige Sekunden in Ruhe aufgezeichnet wurde; was früher aufgezeichnet wurde, steht im Bericht des Prüflings.",
    tooShort: (samples) => `Noch zu wenig: ${samples} Messwerte in Ruhe. Das Rauschen erscheint nach einigen Sekunden in Ruhe.`,
    failed: "Das Rauschen lässt sich nicht lesen und wird mit der nächsten Aufzeichnung neu abgefragt: ",
    reach: (tau) => `Die Mittelungszeiten reichen bis ${tau} s; für längere eine längere Ruhe aufzeichnen (static-allan.toml).`,
    limit: {
      gyro: (type, value) => `Grenzwert der Vorprüfung für Drehratensensoren des Typs ${type}: ${value} °/s/√Hz.`,
      accel: (type, value) => `Grenzwert der Vorprüfung für Beschleunigungssensoren des Typs ${type}: ${value} m/s²/√Hz.`,
    },
    noLimit: {
      gyro: (type) => `Der Typ ${type} nennt keinen Grenzwert für das Rauschen seiner Drehratensensoren: Die Vorprüfung beurteilt es nicht. noise_max_dps_rthz in ${type}.toml setzt einen.`,
      accel: (type) => `Der Typ ${type} nennt keinen Grenzwert für das Rauschen seiner Beschleunigungssensoren: Die Vorprüfung beurteilt es nicht. noise_max_mps2_rthz in ${type}.toml setzt einen.`,
    },
    about: "Allan-Abweichung (überlappend) dessen, was in diesem Lauf in Ruhe aufgezeichnet wurde. Weißes Rauschen folgt den gestrichelten Linien mit der Steigung −½.",
    samples: (count, rate) => `${count} Messwerte mit ${rate} Hz.`,
    label: { gyro: "Allan-Abweichung der Drehratensensoren über der Mittelungszeit", accel: "Allan-Abweichung der Beschleunigungssensoren über der Mittelungszeit" },
    ordinate: (unit) => `Allan-Abweichung, ${unit}`,
    abscissa: "Mittelungszeit τ, s",
    at: (tau) => `bei ${tau} s`,
    allowed: "vom Typ erlaubt",
  },
  log: { title: "Letzte Ereignisse", empty: "Seit dem Start von soakd hat keine Kampagne und kein Gerät etwas gemeldet. Was vorher geschah, und durch wen:", toEvents: "Ereignisse" },
};
