// SPDX-License-Identifier: Apache-2.0
// What the view of the event log says, in English. The events are the station's own words.

export const text = {
  title: "Events: who did what when",
  kind: "Kind",
  all: "all",
  about: "About",
  aboutHint: "unit, run, campaign…",
  routine: "also routine lines: position, power, segment, step",
  by: "By",
  byHint: "name",
  from: "From",
  to: "To",
  show: "Show",
  clear: "Clear",
  none: "No event is like that. “About” takes what the column shows, a run’s label alone, or a serial number, “By” the whole name. Routine lines are left out unless they are ticked.",
  time: "Time",
  what: "What",
  older: "Older",
  nobody: "nobody named",
  station: "the station",
  /** A run by its label, instead of its number. */
  run: (label, campaign) => `${label} of ${campaign}`,
  /** The same as somebody writes it: label and campaign. */
  runWritten: /^(.+?) of (.+)$/,
  certificateWritten: /^.+, certificate (.+)$/,
  certificate: (name, certificate) => `${name}, certificate ${certificate}`,
  /** How often the same happened one after the other. */
  times: (count) => ` (${count} times)`,
  /** Kinds of events; others are written as the station names them, with spaces. */
  kinds: {
    alarm_sent: "alarm message", backup_made: "backup", calibration_exported: "export", campaign: "campaign", campaign_aborted: "campaign aborted",
    campaign_begun: "campaign begun", campaign_failed: "campaign failed", campaign_finished: "campaign finished", campaign_interrupted: "campaign interrupted",
    campaign_paused: "campaign paused", campaign_running: "campaign running", device: "device", epoch_begun: "repair or change", gap_accepted: "effect accepted",
    job_ended: "job ended", job_started: "job started", key_made: "key made", model_added: "model made", model_released: "model released", model_verified: "model verified",
    nothing_to_void: "void without data", procedure_made: "procedure made", prompt: "question to the operator", reference: "reference", reference_added: "certificate entered", run: "run",
    run_added: "run stored", segment: "segment", station_changed: "settings changed", station_change_undone: "settings taken back", station_set_up: "station set up", step: "step", unit: "unit", unit_added: "unit added",
    check_standard_added: "check standard named", gap_withdrawn: "effect withdrawn", noise_exported: "noise values exported", reference_retired: "certificate retired",
    reference_withdrawn: "certificate withdrawn", samples_dropped: "samples dropped", shard_merged: "models of another machine", verification: "verification", voided: "voided",
    account: "account", alarm: "alarm", alarm_not_sent: "alarm message not sent", chamber: "chamber", check_standard: "check standard", check_standard_ended: "check standard named no more",
    journal: "record of the campaign", logged_in: "logged in", logged_out: "logged out", login_limited: "log-in blocked for a while", login_refused: "log-in refused", model_fitted: "model fitted",
    model_withdrawn: "model withdrawn", position: "position", power: "power", reference_waived: "waiver for an expired certificate", run_warning: "warning about a run", storage: "storage",
  },
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
