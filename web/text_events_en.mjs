// SPDX-License-Identifier: Apache-2.0
// What the view of the event log says, in English. The events are the station's own words.

export const text = {
  title: "Events: who did what when",
  kind: "Kind",
  all: "all",
  about: "About",
  aboutHint: "unit, run, campaign",
  by: "By",
  byHint: "name",
  from: "From",
  to: "To",
  show: "Show",
  clear: "Clear",
  none: "No event is like that. “About” and “By” must be the whole name.",
  time: "Time",
  what: "What",
  older: "Older",
  notRecorded: "not recorded",
  chain: {
    title: "Is the log as it was written?",
    check: "Check the chain",
    about: "Every event carries a hash of all before it. The check reads the whole log and says whether one was changed or taken away. From a terminal:",
    reading: "Reading the whole log…",
    /** @type {(count: string, end: string | null) => string} `end`: hash of the last event, null in a log without any */
    whole: (count, end) => `${count} events, none changed or missing. End of the chain: ${end ?? "none"}`,
    notChecked: "Not checked: ",
  },
};
