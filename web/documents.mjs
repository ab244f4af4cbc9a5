// SPDX-License-Identifier: Apache-2.0
// The documents of the station's HTTP interface (docs/http-api.md, docs/schema) as types, for `tsc --project web`. Nothing of this
// is code: no module imports it but in comments, and it is not part of soakd.

/** @typedef {"idle" | "preflight" | "running" | "waiting" | "paused" | "stopping" | "interrupted" | "finished" | "aborted" | "failed"} State */

/**
 * @typedef {object} Campaign of the status
 * @property {string} name
 * @property {string} procedure
 * @property {"calibration" | "verification" | "diagnosis"} purpose
 * @property {string} run_label
 * @property {number} run from 1
 * @property {number} runs
 * @property {number} step from 0
 * @property {number} steps
 * @property {string} step_kind
 * @property {string} step_text
 * @property {string | null} step_trouble
 * @property {boolean} on_way_back
 * @property {number} progress 0 to 1
 * @property {number} remaining_s process time
 * @property {number} started_utc_s
 */

/**
 * @typedef {object} LiveUnit a unit of the campaign as it is now
 * @property {string} slot
 * @property {string} serial
 * @property {string} type
 * @property {string} state
 * @property {string | null} dropped
 * @property {boolean | null} powered
 * @property {number | null} supply_v
 * @property {number | null} supply_a
 * @property {boolean} simulated
 * @property {number | null} temp_c
 * @property {number | null} slope_kpmin
 * @property {number | null} slope_half_width_kpmin
 * @property {boolean} stable
 * @property {string | null} position
 * @property {{up: string | null, expected: string | null, right: boolean | null} | null} attitude
 * @property {number} samples
 * @property {number} lost
 * @property {number[] | null} gyro_dps
 * @property {number[] | null} accel_mps2
 * @property {{tau_s: number, gyro_dps: number[] | null, accel_mps2: number[] | null}} noise
 */

/**
 * @typedef {object} Alarm what needs somebody
 * @property {string} code
 * @property {string | null} about
 * @property {"alarm" | "warning"} level
 * @property {string} title
 * @property {string | null} detail
 * @property {string} action
 * @property {{text: string, utc_s: number} | null} deadline
 * @property {boolean} calls
 */

/**
 * @typedef {object} Status
 * @property {State} state
 * @property {string | null} reason
 * @property {Campaign | null} campaign
 * @property {string | null} resumable
 * @property {boolean} resumes_by_itself
 * @property {{campaigns: {name: string, procedure: string, user: string, queued_utc_s: number, estimate_s: number}[],
 *   waits_for: "campaign" | "time" | "somebody" | null, begins_utc_s: number | null, trouble: string | null}} queue
 * @property {Alarm[]} alarms
 * @property {{causes: string[], for_s: number, gives_up_in_s: number} | null} suspension
 * @property {{outcome: "aborted" | "failed" | "interrupted", needs_somebody: boolean} | null} ending
 * @property {{queued: number, discarded: number, trouble: string | null}} journal
 * @property {{folder: string, trouble: string | null}} data
 * @property {{id: number, text: string, code: string, about: Record<string, any>} | null} prompt
 * @property {{description: string, connected: boolean, air_c: number | null, set_point_c: number | null, output_percent: number | null,
 *   air_rh_percent: number | null, running: boolean | null, alarms: string[], age_s: number | null}} chamber
 * @property {{description: string, connected: boolean, position: string | null, moving: boolean | null}} fixture
 * @property {LiveUnit[]} units
 * @property {{temp_c: number, dew_point_c: number, dew_point_assumed: boolean}} room
 * @property {{rate: number, process_s: number, utc_s: number}} clock
 * @property {boolean} simulated
 * @property {string} version
 */

/**
 * @typedef {object} Step of a plan
 * @property {string} kind
 * @property {number} run
 * @property {number} temp_c
 * @property {string} sweep
 * @property {string} position
 * @property {number} seconds
 * @property {boolean} after_turn
 * @property {number} estimate_s
 * @property {number | null} visit
 */

/**
 * @typedef {object} Plan
 * @property {{name: string, runs: number, set_points_c: number[], positions: string[], dwell_s: number, end_c: number}} procedure
 * @property {{label: string, preflight: boolean, first_step: number, last_step: number}[]} runs
 * @property {Step[]} steps
 * @property {number} first_step number of the first of `steps`, those around the step that was asked for
 * @property {number} later_s what all steps after these are expected to take
 * @property {{visit: number, temp_c: number, step: number | null, left_s: number | null}[]} plateaus of the same run; the step of the first recording, and what all from there on takes
 * @property {{step: number, after_s: number} | null} warm_end of the same run, and what comes after it takes
 * @property {number} estimate_s
 */

/** @typedef {{t_s: number[], chamber_c: (number | null)[], set_point_c: (number | null)[], units: Record<string, (number | null)[]>}} History */

/** @typedef {{number: number, utc_s: number, kind: string, subject: string, text: string}} LogEntry */

/**
 * @typedef {object} Noise
 * @property {string} unit
 * @property {number} rate_hz
 * @property {number} samples
 * @property {number[]} tau_s
 * @property {Record<string, {unit: string, oadev: (number | null)[], mdev: (number | null)[]}>} sensors
 */

/**
 * @typedef {object} StoredCampaign
 * @property {string} name
 * @property {string | null} procedure
 * @property {State | null} state
 * @property {string | null} reason
 * @property {number | null} begun_utc_s
 * @property {number} runs
 * @property {string[]} units
 */

/**
 * @typedef {object} Stored
 * @property {{name: string, unit: string, unit_type: string, last_unit: string}[]} slots
 * @property {{serial: string, type: string, runs: number, newest_run_utc_s: number | null}[]} units
 * @property {StoredCampaign[]} campaigns
 */

/** @typedef {{reason: string, user: string, utc_s: number}} Void */

/**
 * @typedef {object} Run
 * @property {string} unit
 * @property {string} campaign
 * @property {string} run label
 * @property {string} run_id
 * @property {string} procedure
 * @property {"calibration" | "verification" | "diagnosis"} purpose
 * @property {number} epoch
 * @property {number} created_utc_s
 * @property {number} clock_rate
 * @property {number} rows
 * @property {number} duration_s
 * @property {boolean} sealed
 * @property {boolean} voided
 * @property {string | null} cut_short
 * @property {string | null} continues
 * @property {boolean} simulated
 * @property {{reason: string, user: string, utc_s: number, bytes: number} | null} samples_dropped
 * @property {{recorded: number, withdrawn: number, rejected: number}} segments
 * @property {Void | null} void
 */

/** @typedef {{name: string, source_name: string, unit: string, values: number, rate_hz: number | null}} Channel */

/**
 * @typedef {object} RunDetail
 * @property {Run} run
 * @property {string} source
 * @property {{name: string, rows: number, first_s: number | null, last_s: number | null, channels: Channel[]}[]} streams
 * @property {any[]} segments http-run.schema.json
 * @property {any[]} voids
 */

/** @typedef {{run_id: string, unit: string, stream: string, from_s: number, to_s: number, rows: number, kind: "samples" | "buckets", t_s: number[] | null, channels: any[]}} Series */

/** @typedef {"pass" | "marginal" | "fail" | "info" | "not_measured"} Verdict */

/**
 * @typedef {object} Job
 * @property {number} id
 * @property {"fit" | "verify" | "report" | "release" | "fit_all" | "verify_all" | "release_all" | "export_all" | "report_campaign" | "export" | "gap_find" | "gap_accept" | "gap_show"} kind
 * @property {string} unit "" of several
 * @property {number | null} [model] that it works on; absent in jobs kept before jobs said it
 * @property {string | null} campaign
 * @property {string | null} format
 * @property {string[] | null} [effects] absent in jobs kept before there were gap jobs
 * @property {boolean | null} [sign] absent in jobs kept before files were signed here
 * @property {string} user
 * @property {"running" | "done" | "failed" | "cancelled"} state
 * @property {number | null} [progress] 0 to 1, where it is said
 * @property {string | null} [doing] what it does now, where it is said
 * @property {number} started_utc_s
 * @property {number | null} ended_utc_s
 * @property {number | null} exit_status
 * @property {string | null} message
 * @property {any} result of what soak printed (of an export as px4 or ardupilot with `cubic`, a CubicLoss for each sensor); null where it printed nothing
 * @property {{name: string, bytes: number} | null} file
 */

/**
 * @typedef {object} CubicLoss what a cubic over temperature loses against the curve of a sensor
 * @property {"deg/s" | "m/s2"} unit
 * @property {number} rms
 * @property {number} worst
 * @property {number} worst_temp_c
 * @property {number} ci95_at_worst
 * @property {number} beyond_ci95 share of the range
 */

/**
 * @typedef {object} UnitLine
 * @property {string} unit
 * @property {string} type
 * @property {number} epoch
 * @property {number} runs
 * @property {number} to_fit
 * @property {number | null} newest_run_utc_s
 * @property {{version: number, epoch: number, created_utc_s: number, state: Model["state"]} | null} model
 * @property {string | null} trouble
 * @property {Verdict | null} verdict
 * @property {{obstacles: string[], expires: string | null} | null} release
 * @property {boolean} gap_searched
 */

/**
 * @typedef {object} Sensor of a model
 * @property {"deg/s" | "m/s2"} unit
 * @property {string | null} deployed
 * @property {string | null} scale_deployed
 * @property {number | null} rules
 * @property {number | null} train_rmse
 * @property {number | null} check_rmse
 * @property {number | null} check_rmse_shape
 * @property {number | null} run_to_run_sigma
 * @property {boolean | null} relative
 * @property {string[] | null} runs
 * @property {number} temp_min_c
 * @property {number} temp_max_c
 * @property {{temp_c: number, bias: number, ci95: number, pi95: number | null, scale_ppm?: number | null, scale_ci95_ppm?: number | null}[]} curve
 */

/**
 * @typedef {object} Warning
 * @property {string} code
 * @property {string} text
 * @property {string} remedy
 * @property {"grave" | "act" | "none"} urgency
 * @property {string[]} sensors
 */

/**
 * @typedef {object} Term an effect that a model carries
 * @property {string} name
 * @property {boolean} lab_only
 * @property {string[]} sizes
 */

/**
 * @typedef {object} SensorImpact of one sensor's bias
 * @property {string} sensor
 * @property {"deg/s" | "m/s2"} unit
 * @property {number} change
 * @property {number | null} left
 * @property {"pi95" | "ci95" | null} left_interval
 * @property {{without: number, with: number | null}} after_30_s_m
 * @property {{without: number, with: number | null}} after_60_s_m
 */

/**
 * @typedef {object} Impact what the calibration buys without satellite navigation
 * @property {number} from_c
 * @property {number} to_c
 * @property {SensorImpact[]} free_inertial
 * @property {{code: string, text: string}[]} warnings
 */

/** @typedef {{value: number, ci95: number[] | null}} MeanOverOutages */

/** @typedef {{horizontal_rmse_m: MeanOverOutages, horizontal_final_m: MeanOverOutages}} OutageErrors */

/**
 * @typedef {object} UnitDrives what a navigation filter loses in outages on simulated drives
 * @property {number} drives
 * @property {number} outages
 * @property {number} length_s
 * @property {OutageErrors} without
 * @property {OutageErrors} with
 * @property {MeanOverOutages} gain
 */

/** @typedef {{unit: string, model: number, impact: (Impact & {drives: UnitDrives | null}) | null}} ImpactOfUnit */

/**
 * @typedef {object} Model of a unit
 * @property {number} version
 * @property {number} epoch
 * @property {number} created_utc_s
 * @property {Term[]} terms
 * @property {"fitted" | "verified" | "released" | "withdrawn"} state
 * @property {{reason: string, user: string, utc_s: number} | null} withdrawn
 * @property {boolean} simulated
 * @property {Impact | null} impact
 * @property {Record<string, Sensor>} sensors
 */

/** @typedef {{job: Job, stale: string | null}} Kept what a job found, and why it does not hold any more */

/**
 * @typedef {object} Unit
 * @property {string} unit
 * @property {string} type
 * @property {number} epoch
 * @property {number} runs
 * @property {number} to_fit
 * @property {number | null} newest_run_utc_s
 * @property {Model | null} model
 * @property {Warning[]} warnings
 * @property {{campaign: string, runs: number, purpose: "verification" | "calibration"}[]} verify_with
 * @property {{campaign: string, runs: number}[]} fitted_to
 * @property {{campaign: string, runs: number}[]} fit_campaigns
 * @property {{version: number, epoch: number, state: Model["state"], void: string | null}[]} versions
 * @property {number[]} released_before
 * @property {number[]} simulated_before
 * @property {Kept & {warnings: Warning[]} | null} verification
 * @property {{find: Kept | null, show: Kept | null}} gap
 * @property {{obstacles: string[], expires: string | null} | null} release
 * @property {Job | null} exported
 */

// Of a fleet, the event log and what a laboratory keeps: kept_documents.mjs.
/** @typedef {import("./kept_documents.mjs").Fleet} Fleet */
/** @typedef {import("./kept_documents.mjs").Audit} Audit */
/** @typedef {import("./kept_documents.mjs").Chain} Chain */
/** @typedef {import("./kept_documents.mjs").UnitType} UnitType */
/** @typedef {import("./kept_documents.mjs").Procedure} Procedure */
/** @typedef {import("./kept_documents.mjs").Reference} Reference */
/** @typedef {import("./kept_documents.mjs").CampaignCheck} CampaignCheck */
/** @typedef {import("./kept_documents.mjs").SlotFinding} SlotFinding */
/** @typedef {import("./kept_documents.mjs").GapFind} GapFind */
/** @typedef {import("./kept_documents.mjs").SlowNoise} SlowNoise */
/** @typedef {import("./kept_documents.mjs").BiasStep} BiasStep */
/** @typedef {import("./kept_documents.mjs").Session} Session */
/** @typedef {import("./kept_documents.mjs").AlarmWay} AlarmWay */
/** @typedef {import("./kept_documents.mjs").StationKey} StationKey */
/** @typedef {import("./kept_documents.mjs").SetupChoices} SetupChoices */
/** @typedef {import("./kept_documents.mjs").StationSettings} StationSettings */
/** @typedef {import("./kept_documents.mjs").RowColumns} RowColumns */
/** @typedef {import("./kept_documents.mjs").ModelRows} ModelRows */
/** @typedef {import("./kept_documents.mjs").SensorRows} SensorRows */
/** @typedef {import("./kept_documents.mjs").UnitNoise} UnitNoise */
/** @typedef {import("./kept_documents.mjs").SensorNoise} SensorNoise */

/**
 * What GET /api/v1/NAME answers.
 * @typedef {object} PlainAnswers where NAME is one word
 * @property {Status} status
 * @property {Plan | null} plan
 * @property {History} history
 * @property {Stored} stored
 * @property {Noise} noise
 * @property {{entries: LogEntry[]}} log
 * @property {{runs: Run[], not_listed: number}} runs
 * @property {RunDetail} run
 * @property {{units: UnitLine[], check_campaigns: {campaign: string, units: number}[]}} units
 * @property {Unit} unit
 * @property {{unit: string, model: Model}} model
 * @property {ImpactOfUnit} impact
 * @property {{jobs: Job[], not_listed: number}} jobs
 * @property {Job} job
 * @property {Fleet} fleet
 * @property {Audit} audit
 * @property {{folder: string, types: UnitType[], troubles: string[]}} types
 * @property {{procedures: Procedure[]}} procedures
 * @property {{references: Reference[]}} references
 * @property {Session} session
 * @property {{ways: AlarmWay[]}} alarms
 * @property {{key: StationKey | null}} key
 * @property {SetupChoices} setup
 * @property {StationSettings} station
 */

/** @typedef {PlainAnswers & {"run/series": Series, "audit/check": Chain, "references/released": {released: {unit: string, model: number}[]}, "model/rows": ModelRows, "unit/noise": UnitNoise}} Answers */

/**
 * The answer to a path with or without parameters.
 * @template {string} P
 * @typedef {P extends `${infer Name}?${string}` ? (Name extends keyof Answers ? Answers[Name] : unknown) : (P extends keyof Answers ? Answers[P] : unknown)} AnswerTo
 */

export {};
