// SPDX-License-Identifier: Apache-2.0
// What the view of references, unit types, key and alarm messages says, in English.

import { plural } from "./format.mjs";

const unitOf = (name) => (name.endsWith("_scale_ppm") ? "ppm" : name.startsWith("gyro") ? "°/s" : "m/s²");

const ALL_AXES = { gyro: "gyros, bias", accel: "accelerometers, bias", gyro_scale_ppm: "gyros, scale", accel_scale_ppm: "accelerometers, scale" };

export const text = {
  /** On a narrow screen, above a table. */
  wider: "→ The table goes on to the right: swipe it.",
  references: {
    title: "References",
    about: "Certificates of what the laboratory measures with. A campaign begins only with references that are valid, or waived with a signature.",
    none: "No certificate is entered. Campaigns run all the same, but no result says how uncertain fixture, gravity, supply and rate are.",
    kind: "Kind",
    name: "Name",
    certificate: "Certificate",
    state: "State",
    due: "Due",
    correction: "Correction",
    uncertainty: "Standard uncertainty",
    actions: "Actions",
    kinds: {
      chamber_probe: "Probe of the chamber's air", fixture_squareness: "Squareness of the fixture", level: "Level of the base", gravity: "Local gravity", supply: "Power supply",
      rate: "Rate of the table",
    },
    retire: "Retire…",
    retireIt: (name) => `Retire ${name}`,
    entered: (name) => `${name} is entered.`,
    retired: (name) => `${name} is retired.`,
  },
  standings: { valid: "valid", due_soon: "due soon", expired: "expired", superseded: "superseded", retired: "retired", withdrawn: "withdrawn" },
  standing: {
    days: (standing, days) => `${standing}: ${plural(days, { one: `${days} day`, other: `${days} days` })}`,
    waived: (signer) => `expired, waived by ${signer}`,
    damaged: "expired, its waiver is DAMAGED",
    expiredHint: "No campaign begins with it: enter its next certificate, or have a waiver signed in a terminal (soak reference waive).",
    waivedHint: "Campaigns begin with it all the same, and results name the waiver. It ends when the next certificate is entered or the reference is retired.",
  },
  entry: {
    title: "Enter a certificate",
    name: "Name in the laboratory",
    certificate: "Certificate number",
    issued: "Issued",
    dueHint: "From the day on which it is due, no campaign begins with it until its next certificate is entered. A waiver, signed in a terminal (soak reference waive), lets campaigns begin all the same: for this certificate alone, and until the next one is entered or the reference is retired.",
    uncertainty: "Expanded uncertainty,",
    factor: "Its coverage factor k (the certificate says it, mostly 2)",
    user: "Your name, for the record",
    send: "Enter",
    gravity: (unit) => `Local gravity, ${unit}`,
    correction: (unit, meaning) => `Correction, ${unit}: ${meaning}`,
    /** What the correction of a kind is; a kind without one has none. */
    corrections: { chamber_probe: "added to what the probe says", level: "level error", supply: "added to what the supply says", rate: "added to the rate table's rate" },
  },
  retire: {
    title: "Retire this reference?",
    about: (kind, name, certificate) => `${kind} “${name}”, certificate ${certificate}: it is out of use from now on. Results name it, and that it was retired.`,
    looking: "Looking for releases that rest on it…",
    nothingLost: "No released unit rests on it.",
    lost: (count) => plural(count, { one: `${count} released unit rests on it and becomes “do not hand over”, until it is verified again or fitted again with newer runs:`, other: `${count} released units rest on it and become “do not hand over”, until they are verified again or fitted again with newer runs:` }),
    unit: (serial, model) => `${serial}, model ${model}`,
    notKnown: (message) => `Which released units rest on it is not known: ${message}`,
    reason: "Reason, for the record",
    keep: "Keep it",
    send: "Retire",
  },
  newUnit: {
    title: "New unit",
    serial: "Serial number",
    type: "Type",
    choose: "Choose…",
    send: "Add",
    added: (type) => ` is added, type ${type}.`,
  },
  types: {
    title: "Unit types",
    about: "What it is",
    rating: "Rating",
    limits: "Largest error that a verification accepts",
    file: "Each is a file in",
    read: ". The station reads it when a campaign starts, and for each verification.",
    change: "How to change a limit, step by step",
    /** Where all three axes have the same: `kind` is "gyro", "accel_scale_ppm". */
    allAxes: (kind, value) => `${ALL_AXES[kind]} ${value} ${unitOf(kind)}`,
    troubles: "Files that are wrong",
    range: (low, high) => `${low} to ${high} °C`,
    notStated: "not stated",
    /** `name` as a type's file has it: "gyro_x", "gyro_x_scale_ppm". */
    limit: (name, value) => `${name.replace("_scale_ppm", " scale").replace("_", " ")} ${value} ${unitOf(name)}`,
    noLimits: "none: a verification judges nothing",
  },
  key: {
    title: "Key that calibration files are signed with",
    none: "The station has none. Whoever gets a signed file can tell that it came from here, and unchanged. From a terminal:",
    owner: "Owner of the key, for those who verify",
    ownerHint: "Laboratory 1, 2027",
    make: "Make the key",
    of: (owner, id) => `${owner}, key ${id}. `,
    download: "Download the public key",
    give: ": give it to those who verify. The secret one stays in the station's data folder.",
  },
  station: {
    title: "Settings of the station",
    about: "Chamber, fixture, power switch, slots, place and room, and who is told of alarms. The station begins anew with what is changed, so this is not done during a campaign.",
    change: "Change settings of the station",
    role: "An engineer changes them.",
  },
  alarms: {
    title: "Who is told of alarms",
    none: "Nobody: this page alone shows them. Mailboxes and a webhook are entered under “Settings of the station” below:",
    how: "how",
    ways: "Mail and webhook",
    test: "Send a test",
    sending: "Sending…",
    to: { mail: "Mail to", webhook: "Webhook at" },
    nothingSent: "nothing sent since soakd was started",
    lastSent: (time) => `last sent ${time}`,
    waiting: (count) => `, ${count} waiting`,
    lastTest: (time, user) => `Last test ${time}, by ${user}: `,
    tookTest: "the server took it",
    taken: (ways) => `The server has taken it: ${ways}. Look whether it arrives.`,
  },
};
