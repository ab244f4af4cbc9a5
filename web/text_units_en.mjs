// SPDX-License-Identifier: Apache-2.0
// What the views of units say, in English.

import { FIGURE_WORDS } from "./figure_words.mjs";
import { plural } from "./format.mjs";

/** What the runs of a campaign are to a model, behind their number. */
const USES = { verification: "", calibration: ", calibration: the next fit takes it", fitted: ", calibration: the model was fitted to it" };

/** What to do about a warning where the station's own words name a command in a terminal, and the page has a button. @type {Record<string, string>} */
const CLICKS = {
  not_in_model: "Click Fit, then verify the new model and make its report.",
  voided_since: "Click Fit, then verify the new model and make its report.",
  runs_left_since: "Click Search under Gap: it shows whether the effect is still found without them.",
  copied_runs: "No action needed, they count once. To be rid of the copies, open the run in Campaigns and click Void this run.",
  check_standard_out_of_control: "Find what changed in the station before you hand anything over; Help has it under Check standards.",
};

export const text = {
  list: {
    title: "Units",
    find: "Find",
    findHint: "serial, type",
    none: "No unit is known yet: record or import a run.",
    noneFits: "No unit fits.",
    count: (count) => plural(count, { one: `${count} unit`, other: `${count} units` }),
    unit: "Unit",
    verdict: "Verdict",
    type: "Type",
    model: "Model",
    runs: "Runs",
    lastRun: "Last run",
    noModel: "none yet",
  },
  unit: {
    back: "← Units",
    unnamed: "Unit",
    next: "What to do next",
    simulated: "SIMULATED",
    type: "Type",
    model: "Model",
    runs: "Runs",
    epoch: "Epoch",
    released: "Released",
    notReleased: "not yet",
    goodUntil: (day) => `yes; expires on ${day}`,
    noExpiry: "yes; no date of expiry",
    againstTheRule: "yes, against the rule of release: do not hand it over",
    exported: "Exported",
    /** Why an epoch began. */
    epochSince: (epoch, time, why) => `${epoch}, since ${time}: ${why}`,
    toFit: (runs, count) => `${runs}, ${count} for a fit`,
    notExported: "not yet",
    exportedBy: (time, user) => `${time} by ${user}`,
  },
  states: { fitted: "fitted", verified: "verified", released: "released", withdrawn: "withdrawn" },
  /** Behind the state of a model that breaks the rule of release by now. */
  blocked: { verified: "verified, not to be released", released: "released, do not hand over" },
  verdicts: { pass: "PASS", marginal: "MARGINAL", fail: "FAIL", not_measured: "NOT MEASURED", none: "NOT JUDGED", withdrawn: "WITHDRAWN" },
  why: {
    noModel: "There is no model of this unit yet.",
    withdrawn: (version, time, user, reason) => `Model ${version} was withdrawn on ${time} by ${user}: ${reason}. Nobody may use it, and files made from it must not be used.`,
    notVerified: (version) => `Model ${version} has not been verified here.`,
    verifiedElsewhere: (version) => `Model ${version} was verified, but not from this page: its numbers are in its report.`,
    by: (version, campaign, user) => `Model ${version} against campaign ${campaign}, by ${user}`,
    /** @returns {import("./dom.mjs").Part[]} */
    stale: (why, verdict, by) => ["The last verification does not hold any more: ", why, `. It was ${verdict}: ${by}.`],
    noLimits: (by, type) => `${by}: no limits are set for the type ${type}, so nothing was judged.`,
    judged: { pass: "all sensors are within their limits", fail: "beyond the limits", marginal: "too near to the limits to tell", info: "not measured" },
  },
  next: {
    record: "Record a campaign with it, or import its recordings.",
    fit: "Fit it.",
    /** @type {(campaign: string, runs: number, of: number | null) => string} `runs`: of the campaign, that a fit may take */
    recordRuns: (campaign, runs, of) => `Wait: campaign ${campaign} still records it. ${runs}${of === null ? "" : ` of ${of}`} ${plural(of ?? runs, { one: "run", other: "runs" })} recorded so far; fit it when the campaign has ended.`,
    /** @type {(campaign: string, runs: number, of: number | null, toFit: number) => string} the same of one that somebody has to resume; `toFit`: runs of all campaigns */
    recordStopped: (campaign, runs, of, toFit) => `Campaign ${campaign}, which records it, has stopped, ${runs}${of === null ? "" : ` of ${of}`} ${plural(of ?? runs, { one: "run", other: "runs" })} recorded: resume it on Station, then fit.${toFit === 0 ? "" : " Fit below uses the runs that are there."}`,
    /** @type {(campaign: string, runs: number, of: number | null) => string} of a model that was fitted before its campaign is over */
    moreRuns: (campaign, runs, of) => `Wait: campaign ${campaign} still records it, ${runs}${of === null ? "" : ` of ${of}`} ${plural(of ?? runs, { one: "run", other: "runs" })} so far. When it has ended, fit again with all runs, then verify and release.`,
    /** @type {(campaign: string, runs: number, of: number | null) => string} beside what is to be done next: of one that somebody has to resume */
    moreRunsStopped: (campaign, runs, of) => `Campaign ${campaign}, which records it, has stopped, ${runs}${of === null ? "" : ` of ${of}`} ${plural(of ?? runs, { one: "run", other: "runs" })} recorded. To have the others too, resume it on Station; then fit again with all runs.`,
    /** In front of what the station says is wrong. */
    fitAgain: "Do not hand it over. Fit it again, then verify and release it:",
    /** Behind what only some roles may do. */
    byEngineer: "An engineer does that; your account may not.",
    byOperator: "An operator or an engineer does that; your account only looks.",
    changed: "Record it as it is now with a calibration procedure, then fit it: it was repaired or changed after this model.",
    changedFit: "Fit it again: it was repaired or changed after this model, and runs of it as it is now are there.",
    withdrawn: "Fit it again: data of this model were withdrawn.",
    verify: "Verify it with a run that the fit has not seen.",
    /** Behind that, where nobody has searched. */
    gapFirst: " Before that, search its gap below: what is accepted there makes a new model, which is verified itself.",
    /** @type {(campaign: string, runs: number, of: number | null) => string} */
    checkRuns: (campaign, runs, of) => `Wait: campaign ${campaign} still runs, ${runs}${of === null ? "" : ` of ${of}`} check ${plural(of ?? runs, { one: "run", other: "runs" })} recorded. ${runs === 0 ? "Then verify." : "Verify below uses those that are there."}`,
    /** @type {(campaign: string, runs: number, of: number | null) => string} the same of one that somebody has to resume */
    checkStopped: (campaign, runs, of) => `Campaign ${campaign} has stopped, ${runs}${of === null ? "" : ` of ${of}`} check ${plural(of ?? runs, { one: "run", other: "runs" })} recorded: resume it on Station.${runs === 0 ? "" : " Verify below uses those that are there."}`,
    toStation: "Station",
    recordFresh: "Record a run that the fit has not seen with a verification procedure, then verify it.",
    newCampaign: "New campaign",
    how: "How",
    fail: "Do not hand it over: it exceeds its limits. The report shows where.",
    marginal: "Do not hand it over as passed: limit and error are nearer to each other than the verification can tell. Record one more run with a verification procedure and verify it again.",
    notJudged: (type) => `State limits of the type ${type}, or verify it over the whole range: it is not judged yet.`,
    grave: "Do not hand it over before the first warning below is settled.",
    release: "Release it.",
    releaseAgain: "Release it again: it failed a verification after its release, and the last one says PASS.",
    releaseGapOpen: "Release it. What the gap search found is not in its model: look at Gap below before.",
    /** In front of what the station says is in the way. */
    notReleased: "It may not be released:",
    notGoodAnyMore: "Do not hand it over: it is released, and does not keep the rule of release any more:",
    retired: "Fit it again: this model is withdrawn, nobody may use it.",
    export: "Export it.",
    nothing: "Nothing: it is verified, released and exported.",
    gapOpen: "It is verified, released and exported. What the gap search found is not in its model: see Gap below.",
  },
  /** What is in the way of a release. */
  obstacles: {
    neverVerified: "it was never verified",
    notPassed: (campaign, verdict) => `its last verification, against campaign ${campaign}, says ${verdict}`,
    /** `runs`: [label, campaign] of each */
    leftOut: (runs) => `runs for calibration are not in it: ${runs.map(([label, campaign]) => `${label} of campaign ${campaign}`).join(", ")}: fit again with all of them`,
    beforeRepair: "it is of the unit before it was repaired or changed: record it again, then fit it",
    gone: (count) => `${count} of the runs that it was fitted to were withdrawn or are gone: fit again`,
    checkWithdrawn: (campaign) => `runs of campaign ${campaign} were withdrawn after it was verified against them: verify it again`,
    /** `runs`: "R01, R02" */
    voided: (runs) => `runs that it was fitted to were withdrawn since, whole or in part: ${runs}: fit again`,
    withdrawn: "it is withdrawn: fit again",
    checkSimulated: (campaign) => `it was measured, and runs of campaign ${campaign} are SIMULATED: verify it against measured runs`,
    releaseAgain: (day, verdict) => `a verification on ${day}, after its release, said ${verdict}: release it again`,
    kinds: {
      chamber_probe: "probe of the chamber's air", fixture_squareness: "squareness of the fixture", level: "level of the base", gravity: "local gravity", supply: "power supply",
      rate: "rate of the table",
    },
    reference: (kind, name, certificate) => `${name} (${kind}, certificate ${certificate})`,
    due: (reference, day) => `${reference} was due on ${day}: record with a newer certificate and fit again`,
    entryWithdrawn: (reference, day, user, reason, isCorrected, remedy) =>
      `the entry of ${reference} was withdrawn on ${day} by ${user} (${reason}); its values still apply here, ${isCorrected ? "the corrected entry applies from the next fit on" : "and no entry corrects it"}: ${remedy}`,
    retired: (reference, day, user, reason, remedy) => `${reference} was used for it and was retired on ${day} by ${user} (${reason}): ${remedy}`,
    expired: (reference, day, remedy) => `${reference} was used for it, expired on ${day} and has no newer certificate: ${remedy}`,
    remedies: { "fit again": "fit again", "verify it against newer runs": "verify it against newer runs" },
  },
  /** Why what was found does not hold any more, by what the station says; other sentences are its own. @type {Record<string, string>} */
  stale: {
    "the unit was fitted again since": "the unit was fitted again since", "the unit was repaired or changed since": "the unit was repaired or changed since",
    "the model was withdrawn since": "the model was withdrawn since", "data of its campaign were withdrawn since": "data of its campaign were withdrawn since",
    "data were withdrawn since": "data were withdrawn since", "runs were added since": "runs were added since",
  },
  judged: {
    title: "Worst errors and limits, by sensor",
    heads: ["Curve", "Worst error", "Uncertainty U (95 %)", "Limit", "Unit", "At, °C", "Verdict"],
    about: "Passed is what stays within its limit with U added, failed what is beyond it with U taken off. The nearest to its limit stands first.",
    curve: (sensor, isScale) => (isScale ? `${sensor}, scale` : sensor),
    beyond: (curve, worst, guard, limit, unit, temp) => `Farthest beyond its limit: ${curve}, ${worst} ± ${guard} ${unit} at ${temp} °C, limit ${limit} ${unit}.`,
    nearest: (curve, worst, guard, limit, unit, temp) => `Nearest to its limit: ${curve}, ${worst} ± ${guard} ${unit} at ${temp} °C, limit ${limit} ${unit}.`,
  },
  repair: {
    button: "Repaired or changed…",
    title: (serial) => `Unit ${serial} was repaired or changed`,
    about: "From now on it counts as another unit. No fit uses the runs so far any more, and its model may not be exported: record it again, then fit it. Nothing is deleted. This cannot be taken back.",
    reason: "What was done",
    user: "Your name",
    keep: "Cancel",
    send: "It was repaired or changed",
  },
  withdraw: {
    button: "Withdraw model…",
    title: (serial) => `Withdraw a model of unit ${serial}`,
    about: "Nobody may use it any more: it is not exported, released or handed over. Files of it that are in use already have to be called back by you. Nothing is deleted. This cannot be taken back.",
    version: "Model",
    reason: "Why",
    user: "Your name",
    keep: "Cancel",
    send: "Withdraw it",
  },
  handOver: {
    button: "Hand over what is released",
    simulated: "Also models of SIMULATED data",
    done: (count) => plural(count, { one: `${count} file and its signed manifest are in the archive.`, other: `${count} files and their signed manifest are in the archive.` }),
  },
  batch: {
    title: "All units at once",
    fit: "Fit all",
    toFit: (count) => plural(count, { one: `${count} unit has runs for a fit.`, other: `${count} units have runs for a fit.` }),
    leftAlone: "Those with nothing new are left alone.",
    verify: "Verify all",
    campaign: "Campaign that no fit has seen",
    noCampaign: "No unit that has a model has a run with a verification procedure.",
    /** `open`: null: it is over; else whether it has `stopped` before its end. */
    campaignUnits: (campaign, count, open = null) =>
      `${campaign} (${plural(count, { one: `${count} unit`, other: `${count} units` })}${open === null ? "" : open.stopped ? ", stopped before its end" : ", still running"})`,
    last: (job) => `Last: ${job}`,
    /** What became of a fit, after how many units. */
    fitted: (fitted, same, failed) => `${fitted} fitted, ${same} with nothing new, ${failed} not fitted.`,
    noRuns: (count) => plural(count, { one: `${count} has no run for a fit and was left alone.`, other: `${count} have no run for a fit and were left alone.` }),
    /** `isKnown`: whether what was fitted before has been told. */
    fitCancelled: (isKnown) => `${isKnown ? "That" : "What was fitted before that"} is stored; Fit all goes on with the others.`,
    judged: (counts) => `Judged: ${counts}.`,
    notVerified: (count) => plural(count, { one: `${count} unit could not be verified.`, other: `${count} units could not be verified.` }),
    skipped: (count) => plural(count, { one: `${count} unit was left out.`, other: `${count} units were left out.` }),
    /** Behind the serial number, before the reason. */
    whyNotVerified: ", not verified: ",
    whySkipped: ", left out: ",
    why: (version) => (version === null ? ": " : `, model ${version}: `),
  },
  sure: { keep: "Cancel" },
  releaseAll: {
    button: "Release what may be released",
    ask: {
      title: (count) => plural(count, { one: "Release this model?", other: `Release these ${count} models?` }),
      text: "What is released may be handed over from then on, in your name. A release does not look at the gap search.",
      unit: (serial, version, { again, searched }) => `${serial}, model ${version}${again ? ", again: it failed a verification after its release" : ""}${searched ? "" : ". Nobody has searched its gap."}`,
      send: "Release",
    },
    waiting: (count) => plural(count, { one: `${count} model may be released.`, other: `${count} models may be released.` }),
    blocked: (count) => plural(count, { one: ` ${count} more is verified, but something is in the way: see its page.`, other: ` ${count} more are verified, but something is in the way: see their pages.` }),
    /** Of those that may be released. */
    notSearched: (count) => plural(count, { one: ` Nobody has searched the gap of ${count} of them: a release does not look at it.`, other: ` Nobody has searched the gap of ${count} of them: a release does not look at it.` }),
    done: (released, units) => `${released} of ${plural(units, { one: `${units} newest model`, other: `${units} newest models` })} ${plural(released, { one: "was", other: "were" })} released when it had ended.`,
    /** @type {(released: number, units: number) => string} of one that did not come to its end */
    cutShort: (released, units) => `Up to there ${released} of the ${plural(units, { one: `${units} model that it came to is`, other: `${units} models that it came to are` })} released.`,
    notReleased: (version) => `, model ${version}, may not be released: `,
    againstTheRule: (version) => `, model ${version}, is released, but must not be handed over: `,
  },
  jobs: {
    title: "Jobs",
    noRunsToFit: "No run of it as it is now is there for a fit.",
    campaign: "Campaign that the fit has not seen",
    noCampaign: "There is none: every run is in the model. Record one in a campaign of its own.",
    /** Instead of that, while a campaign records its first check run. */
    beingChecked: (campaign) => `None yet: campaign ${campaign} is recording the first one.`,
    /** `use`: "verification"; "calibration", not fitted yet; "fitted". */
    campaignRuns: (campaign, count, use) => `${campaign} (${plural(count, { one: `${count} run`, other: `${count} runs` })}${USES[use]})`,
    /** A campaign of which more runs will come; `of`: how many it has, null: not known; `stopped`: somebody has to resume it. */
    campaignOpen: (campaign, count, { of, stopped }, use) =>
      `${campaign} (${stopped ? "stopped" : "still running"}: ${of === null ? plural(count, { one: `${count} run`, other: `${count} runs` }) : `${count} of ${of} runs`} recorded${USES[use]})`,
    format: "Format",
    version: "Model",
    newestVersion: (version) => `${version}, the newest`,
    releasedVersion: (version) => `${version}, older, released`,
    olderVersion: (version, state) => `${version}, older, ${state}`,
    sign: "Sign it",
    noKey: "Sign it: the station has no key yet, Records makes one",
    signWith: (key) => `Sign it with key ${key}`,
    /** In front of why the station does not say whether it has a key. */
    keyUnknown: "Sign it: ",
    simulated: (version) => `Although model ${version} is of SIMULATED data`,
    tickSimulated: (version) => `Export: model ${version} is of SIMULATED data. Tick “Although model ${version} is of SIMULATED data” first, if that is what you want.`,
    /** Before a file leaves that nobody vouches for. */
    askUnreleased: {
      title: (version) => `Export model ${version}, which is not released?`,
      text: (file, isSigned) => `Nobody vouches for it. The file is marked as not released, its name too (${file}), and devices refuse it unless they are told to take it.${isSigned ? " It is signed all the same: the signature says where it comes from, not that it may be used." : ""}`,
      send: "Export it, marked",
    },
    deviceIds: "Device id (CAL_ACC0_ID, comma, CAL_GYRO0_ID if another)",
    deviceIdsHint: "1310988",
    noDeviceIds: "Without it the parameters do nothing until the id is set in PX4.",
    wrongDeviceIds: "The device id must be one or two whole numbers from 1 to 2147483647, with a comma between them.",
    /** What a cubic over temperature loses: in the range, over all sensors. */
    cubic: {
      title: (share, sensor) => share === 0 ? "The cubic stays inside the 95 % band of the curve everywhere." : `The cubic leaves the 95 % band of the curve in up to ${share} % of the range (${sensor}).`,
      heads: ["Sensor", "Unit", "RMS", "Worst", "At, °C", "95 % band there", "Outside the band"],
      label: "Loss of the cubic by sensor",
    },
    /** Why Verify and Release are off, and Export, too, where `isExportOff`. */
    beforeRepair: (version, isExportOff) => `${isExportOff ? "Verify, Release and Export" : "Verify and Release"} are off: model ${version} is of the unit before it was repaired or changed. Record it again, then fit it.`,
    /** In front of which conditions. */
    againstTheRule: (version) => `Export is off: model ${version} is released, and does not keep the rule of release any more: `,
    /** In front of what the station says is in the way of a release. */
    notReleased: "Not to be released yet: ",
    cancel: "Cancel",
    ended: "Jobs that have ended, newest first",
    none: "No job of this unit is kept.",
    refused: (what) => `${what}: `,
    asked: (what) => `${what}: asked for`,
    download: (file) => `Download ${file}`,
    running: (what, since, user) => `${what}; for ${since} now, started by ${user}.`,
    allUnits: "all units",
    ofUnit: (serial) => `unit ${serial}`,
    ofRuns: "all runs for calibration",
    ofModel: (version) => `model ${version}`,
    newestModels: "their newest models",
    releasedModels: "their released models",
    ofCampaign: (campaign) => `campaign ${campaign}`,
    /** Behind the verdict of a verification that does not count any more. */
    noMore: (verdict) => `${verdict}, void`,
    judgedAgain: "It was verified again since: the newer verdict counts.",
    /** In front of why, in the station's words. */
    voidVerdict: "This verdict does not hold any more: ",
    states: { done: "done", failed: "failed", cancelled: "cancelled" },
    as: (format) => `, as ${format}`,
    signed: (key) => (key ? `, signed with key ${key}` : ", signed"),
    made: (version) => `; made model ${version}`,
    madeFrom: (version) => `Made from model ${version}.`,
    madeBeforeVerdict: (version, verdict) => `Made from model ${version} before its last verification, which says ${verdict}: make it again before you use it.`,
    madeBeforeRepair: (version) => `Made from model ${version}, of the unit before it was repaired or changed: void since, do not use it.`,
    madeBeforeVoid: (version) => `Made from model ${version}. Data that this rests on were withdrawn since: void, do not use it.`,
    /** A verdict that does not hold any more. */
    voidSince: (verdict) => `${verdict}, void since`,
    madeFromOlder: (version, newest) => `Made from model ${version}; the newest is ${newest}.`,
    madeFromWithdrawn: (version) => `Made from model ${version}, which is withdrawn: do not use it.`,
    madeBeforeRelease: (version) => `Made from model ${version} before that was released: the file is marked as not released.`,
    /** What each kind is called on a button, while it runs, and afterwards. */
    verbs: { fit: "Fit", verify: "Verify", report: "Report", release: "Release", export: "Export", gap_find: "Search", gap_accept: "Accept", gap_show: "Compare" },
    doing: {
      fit: "Fitting", fit_all: "Fitting", verify: "Verifying", verify_all: "Verifying", report: "Writing the report", release: "Releasing", release_all: "Releasing", export_all: "Packing the archive", report_campaign: "Writing the report", export: "Exporting", gap_find: "Searching for what the model lacks",
      gap_accept: "Fitting again with the accepted effects", gap_show: "Comparing before and after",
    },
    /** What a job does now, in its own sentence. */
    steps: {
      reading: "Reading the recordings.", fitting: "Fitting the sensors.", searching: "Looking for effects in what the model leaves.",
      resting: "Looking at the unit's longest rest.", verifying: "Comparing the model with the check runs.", report: "Drawing the curves and the noise.",
      exporting: "Writing the file.",
    },
    nouns: {
      fit: "Fit", fit_all: "Fit", verify: "Verification", verify_all: "Verification", report: "Report", release: "Release", release_all: "Release", export_all: "Hand-over", report_campaign: "Report", export: "Export", gap_find: "Gap search", gap_accept: "Accepted", gap_show: "Before and after",
    },
  },
  /** What the formats are for, by their names in the interface, in the order in which they are offered. */
  formats: {
    blob: "Calibration file (.soakcal)", c: "C header (.h)", json: "JSON", px4: "PX4 parameters", ardupilot: "ArduPilot parameters", kalibr: "Kalibr noise values",
  },
  warnings: {
    title: "Warnings",
    none: "No warning asks for anything.",
    more: (count) => `${count} more with nothing to do`,
    /** What a warning is called by its code; "" where the station's own words are enough. */
    name: (code) => "",
    /** @type {(code: string, own: string) => import("./dom.mjs").Part} what is wrong; `own`: in the station's words */
    text: (code, own) => ({ english: own }),
    /** @type {(code: string, own: string) => import("./dom.mjs").Part} what to do; `own`: in the station's words */
    remedy: (code, own) => (Object.hasOwn(CLICKS, code) ? CLICKS[code] : own),
  },
  sensors: {
    name: (sensor) => sensor.replace("_", " "),
    curves: "Curves",
    older: "Beside an older model",
    noOlder: "none",
    version: (version) => `model ${version}`,
    bias: (sensor) => `Bias of ${sensor}`,
    figures: FIGURE_WORDS,
    residuals: (sensor) => `Residuals of ${sensor}: points minus curve`,
    scale: (sensor) => `Scale error of ${sensor}`,
    noScale: {
      gyro: "Scale: not known. It takes positions in which the fixture turns at known rates.",
      accel: "Scale: not known. It takes positions with this axis up and down.",
    },
    reading: "The points of the runs are being read …",
    noPoints: "The points of the runs cannot be shown any more: the runs are withdrawn or gone.",
    /** In front of what the station says. */
    failed: "The points of the runs cannot be shown: ",
    olderMean: "its 95 %, mean curve",
    /** @type {(difference: string, unit: string, temp: string, band: string) => string} `band`: the wider 95 % band there */
    difference: (difference, unit, temp, band) => `Largest difference between the two: ${difference} ${unit} at ${temp} °C, where the wider 95 % band is ±${band} ${unit}.`,
    /** What stands in front of it. */
    differenceOf: { bias: "Bias: ", scale: "Scale: " },
    same: "The two curves are the same.",
    notTogether: "The two curves have no temperature in common.",
    curve: "Curve",
    rules: (count) => `ANFIS, ${plural(count, { one: `${count} rule`, other: `${count} rules` })}`,
    /** A curve other than ANFIS, by its name in the interface. */
    kind: (name) => name,
    residualFit: "Residual of the fit",
    residualHeldOut: "Residual, held-out runs",
    runToRun: "Run to run",
    notKnown: "not known",
    span: "Span",
    range: (low, high) => `${low} to ${high} °C`,
    widest: "95 % band, widest",
  },
  noise: {
    title: "Noise at rest",
    bySensor: "Noise by sensor",
    reading: "The noise is being worked out …",
    failed: "The noise cannot be shown: ",
    none: "Not known: no run of the unit as it is now has a rest with its samples. Record static-allan.toml.",
    /** @type {(run: string, campaign: string, duration: string, position: string, temp: string) => string} */
    from: (run, campaign, duration, position, temp) => `From the longest rest of the unit: run ${run} of campaign ${campaign}, ${duration}${position && ` in ${position}`} at ${temp} °C.`,
    simulated: " SIMULATED.",
    kinds: { gyro: "Gyros", accel: "Accelerometers" },
    figure: { gyro: "Allan deviation of the gyros", accel: "Allan deviation of the accelerometers" },
    verdicts: {
      inside: (kind, type, limit) => `${kind}: inside the limit. The type ${type} allows ${limit}.`,
      outside: (kind, type, limit, sensors) => `${kind}: outside the limit (${sensors}). The type ${type} allows ${limit}.`,
      no_limit: (kind, type) => `${kind}: no limit. The type ${type} states none.`,
      not_known: (kind, type, limit) => `${kind}: cannot be told from this rest: record a longer one (static-allan.toml). The type ${type} allows ${limit}.`,
    },
    short: { inside: "inside", outside: "outside", no_limit: "no limit", not_known: "cannot be told" },
    heads: ["Sensor", "Verdict", "White noise (95 %)", "Limit"],
    between: (low, high) => ` (${low} to ${high})`,
    below: (high) => `none seen, below ${high}`,
    about: "White noise falls along the dashed limit’s slope. Above the dashed line a sensor is noisier than its type allows, as long as its line falls like that; what stays flat or rises at long times is slow wander, which no limit is about.",
  },
  impact: {
    title: (version) => `What the calibration of model ${version} buys in navigation`,
    notKnown: "Not known: the sensors were not calibrated at two common temperatures.",
    heads: ["Sensor", "Bias changes by", "Bias left (95 %)", "30 s, without", "30 s, with", "60 s, without", "60 s, with"],
    bySensor: "Position errors by sensor",
    intervals: { pi95: "a fresh power-on", ci95: "mean curve alone: may be far too small" },
    about: (from, to) => `Position error from each sensor's bias alone without satellite navigation, from ${from} °C at power-on to ${to} °C; the bias at power-on is known, the sensor's axis lies horizontally.`,
    ofModel: (version) => `Model ${version}:`,
    drives: ({ drives, outages, seconds, without, corrected, less, between }) =>
      `With a navigation filter, in ${outages} outages of ${seconds} s on ${drives} simulated drives with this unit's curves: ${without} off at the end of an outage without the calibration, ${corrected} with it, `
      + `a gain of ${less} %${between === null ? "" : ` (95 %: ${between.join(" to ")} %)`}. Noise in these drives is that of an AHRS400CA for every unit, not that of this unit’s type.`,
    noDrives: "Drives with a navigation filter are not simulated, as the calibration does not state its uncertainty.",
    drivesFailed: (message) => `Drives with a navigation filter could not be simulated: ${message}.`,
    more: "Each outage, and more ways to navigate:",
  },
};
