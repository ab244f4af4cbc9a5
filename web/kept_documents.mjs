// SPDX-License-Identifier: Apache-2.0
// As documents.mjs: a fleet, the event log, and what a laboratory keeps (types, procedures, references); who asks, and what
// the check of a campaign says.

/** @typedef {import("./documents.mjs").Verdict} Verdict */
/** @typedef {import("./documents.mjs").Void} Void */

/**
 * @typedef {object} FleetUnit
 * @property {string} unit
 * @property {number} epoch
 * @property {{version: number, epoch: number, created_utc_s: number} | null} model
 * @property {number | null} before version
 * @property {string | null} trouble
 * @property {Verdict | null} verdict
 */

/**
 * @typedef {object} FleetLine one unit's curve among the others
 * @property {string} unit
 * @property {(number | null)[] | null} values
 * @property {number | null} distance
 * @property {number | null} farthest_c
 * @property {boolean} outlier
 * @property {{temp_c: number, change: number, band: number, beyond_band: boolean} | null} drift
 */

/**
 * @typedef {object} FleetCurve
 * @property {number[]} temp_c
 * @property {(number | null)[]} median
 * @property {(number | null)[]} spread
 * @property {FleetLine[]} units
 */

/** @typedef {{unit: "deg/s" | "m/s2", bias: FleetCurve, scale: FleetCurve | null}} FleetSensor */

/**
 * @typedef {object} Fleet
 * @property {string} type
 * @property {{outlier_distance: number, fewest_units: number}} rule
 * @property {FleetUnit[]} units
 * @property {number} not_listed
 * @property {Record<string, FleetSensor>} sensors
 */

/**
 * @typedef {object} Event of the event log
 * @property {number} number
 * @property {number} utc_s
 * @property {string} utc
 * @property {string} kind
 * @property {string} subject
 * @property {string | null} user
 * @property {string} text
 * @property {string} chain_sha256
 */

/**
 * @typedef {object} Audit
 * @property {Event[]} events
 * @property {boolean} has_older
 * @property {string[]} kinds
 * @property {string[]} users
 */

/**
 * @typedef {object} Chain
 * @property {boolean} ok
 * @property {number | null} events
 * @property {string | null} chain_sha256
 * @property {string | null} problem
 * @property {string | null} where
 */

/**
 * @typedef {object} UnitType
 * @property {string} name
 * @property {string} description
 * @property {number | null} temp_min_c
 * @property {number | null} temp_max_c
 * @property {-1 | 1} sign_at_rest
 * @property {string[] | null} axes
 * @property {number | null} warm_up_s
 * @property {"one" | "per_sensor" | null} thermometers
 * @property {number | null} temp_lsb_c
 * @property {number | null} temp_repeatability_c
 * @property {number | null} gyro_range_dps
 * @property {number | null} gyro_lsb_dps
 * @property {number | null} gyro_noise_max_dps_rthz
 * @property {number | null} gyro_bias_max_dps
 * @property {number | null} accel_range_mps2
 * @property {number | null} accel_lsb_mps2
 * @property {number | null} accel_noise_max_mps2_rthz
 * @property {number | null} accel_bias_max_mps2
 * @property {Record<string, number>} limits
 */

/**
 * @typedef {object} Procedure to choose from; the optional members are absent where there is a trouble
 * @property {string} file
 * @property {string} name
 * @property {string | null} trouble
 * @property {string} text
 * @property {string} [description]
 * @property {string} [purpose]
 * @property {string} [kind]
 * @property {number} [runs]
 * @property {number} [estimate_s]
 * @property {Changeable} [changeable] of one that is asked for by its file
 */

/**
 * @typedef {object} Changeable what of a procedure can be changed, as it is; null where its kind has no such thing
 * @property {number[]} set_points_c
 * @property {number} runs
 * @property {number | null} dwell_s
 * @property {number | null} minimum_soak_s
 * @property {number | null} reference_c
 */

/** @typedef {{waiver_id: string, reason: string, signer: string, utc_s: number, public_key: string, signature: string, good: boolean}} Waiver */

/**
 * @typedef {object} Reference an entry of the register
 * @property {string} record_id
 * @property {"chamber_probe" | "fixture_squareness" | "level" | "gravity" | "supply" | "rate"} kind
 * @property {string} name
 * @property {string} certificate
 * @property {string} issued
 * @property {string} due
 * @property {"K" | "deg" | "m/s2" | "V" | "ppm"} unit
 * @property {number | null} correction
 * @property {number} standard_uncertainty
 * @property {"valid" | "due_soon" | "expired" | "superseded" | "retired" | "withdrawn"} standing
 * @property {number} days_left
 * @property {string} user
 * @property {number} entered_utc_s
 * @property {Void | null} retired
 * @property {Void | null} withdrawn
 * @property {Waiver[]} waivers
 * @property {string[]} campaigns
 */

/**
 * @typedef {object} CampaignCheck what POST /api/v1/campaign/check answers
 * @property {{name: string, description: string, purpose: string, runs: number, visits: number[], turns: number, set_points_c: number[], positions: string[], estimate_s: number} | null} procedure
 * @property {{slot: string, serial: string, type: string}[]} units
 * @property {{needed_bytes: number | null, free_bytes: number | null}} disk
 * @property {{message: string, where: string}[]} mistakes
 * @property {string[]} notes
 */

/**
 * @typedef {object} SlotFinding what POST /api/v1/campaign/look says of a slot
 * @property {string} slot
 * @property {number | null} power_output
 * @property {"identified" | "anonymous" | "silent" | "failed"} answer
 * @property {string | null} serial
 * @property {string | null} product
 * @property {string | null} firmware
 * @property {string | null} trouble
 */

/**
 * @typedef {object} SetupMap a controller that a station can be set up with
 * @property {string} file
 * @property {string} name
 * @property {"modbus" | "text"} protocol
 * @property {number | null} port where nothing else is entered, as the next two
 * @property {number} baud
 * @property {number | null} unit
 */

/**
 * @typedef {object} SetupChoices what a station can be set up with
 * @property {string} file that is to be written
 * @property {SetupMap[]} chambers
 * @property {SetupMap[]} fixtures
 * @property {SetupMap[]} powers relays and supplies
 * @property {{device: string, node: string}[]} ports serial ports of the machine
 * @property {{name: string, description: string}[]} types
 */

/**
 * @typedef {object} StationSettings what the station works with, and whether the page can change it
 * @property {string} file
 * @property {string} revision of the file
 * @property {string | null} obstacle why the page cannot change it
 * @property {boolean} changing whether the station is about to begin with what was written last
 * @property {{utc_s: number, user: string, text: string} | null} trouble why it could not begin with the last change
 * @property {any} answers as the body of station/check
 * @property {{password: boolean, url: boolean, token: boolean} | null} kept which secrets there are
 * @property {SetupChoices} choices
 */

/**
 * @typedef {object} SetupCheck
 * @property {string} text
 * @property {{field: string, message: string}[]} mistakes
 */

/**
 * @typedef {object} Survey what a controller has answered when it was tried
 * @property {string} name
 * @property {string} address
 * @property {boolean} sound
 * @property {{kind: "probe" | "quantity" | "alarm", name: string, place: string, value: number | null, text: string | null, active: boolean | null, trouble: string | null}[]} entries
 */

/**
 * @typedef {object} StationKey public part of the key that the station signs with
 * @property {string} key_id
 * @property {string} public_key
 * @property {string} comment
 * @property {string} file
 */

/**
 * @typedef {object} AlarmWay how people are told of alarms
 * @property {"mail" | "webhook"} way
 * @property {string} to
 * @property {number} waiting
 * @property {string | null} trouble
 * @property {number | null} sent_utc_s
 * @property {{utc_s: number, user: string, trouble: string | null} | null} test
 */

/**
 * @typedef {object} Session
 * @property {boolean} accounts whether there are any
 * @property {string | null} name
 * @property {"viewer" | "operator" | "engineer" | null} role
 */

/**
 * @typedef {object} RowColumns points of runs beside a curve
 * @property {string[]} runs
 * @property {number} total
 * @property {{run: number[], sweep: string[], temp_c: number[], value: number[], residual: number[], shape_residual: number[]}} points lists of equal length
 */

/** @typedef {{limit: number | null, rows: RowColumns | null, scale_rows: RowColumns | null, fresh: RowColumns | null}} SensorRows */

/**
 * @typedef {object} ModelRows the points behind the curves of a model
 * @property {string} unit
 * @property {number} model
 * @property {Record<string, SensorRows>} sensors
 */

/**
 * @typedef {object} SensorNoise of a sensor at rest, beside what its type allows
 * @property {"deg/s" | "m/s2"} unit
 * @property {"inside" | "outside" | "no_limit" | "not_known"} verdict
 * @property {number | null} limit
 * @property {{value: number | null, ci95: (number | null)[]} | null} density
 * @property {number | null} rate_hz
 * @property {number | null} samples
 * @property {string | null} reason
 * @property {number[]} tau_s
 * @property {(number | null)[]} oadev
 * @property {(number | null)[][]} ci95
 */

/**
 * @typedef {object} UnitNoise
 * @property {string} unit
 * @property {string} type
 * @property {{run: string, campaign: string, content_sha256: string, simulated: boolean, visit: number, position: string, plateau_c: number | null,
 *   temp_c: number | null, duration_s: number} | null} segment
 * @property {string | null} reason
 * @property {Record<string, SensorNoise>} sensors
 */

export {};

// What a search for the gap has found (gap-find.schema.json).
/**
 * @typedef {object} BiasStep of a bias, in one run
 * @property {string} run
 * @property {string} sensor
 * @property {number} t_s
 * @property {number} since_start_s
 * @property {number} last_before_s
 * @property {number} temp_c
 * @property {number} size
 * @property {"deg/s" | "m/s2"} unit
 */
/**
 * @typedef {object} Structure of what no effect explains
 * @property {string} axis
 * @property {string} [kind] this and what follows is absent in reports kept before there were kinds
 * @property {string} [usual]
 * @property {string} [look]
 * @property {number | null} [closer_plateaus_k]
 * @property {number | null} [runs]
 * @property {BiasStep[]} [steps]
 * @property {number} p_adjusted
 * @property {string[]} sensors
 */
/**
 * @typedef {object} SlowNoise of a sensor
 * @property {string} sensor
 * @property {"deg/s" | "m/s2"} unit
 * @property {number} within_run
 * @property {number} share_minutes
 * @property {number} share_hours
 * @property {{value: number, ci95: [number, number], tau_s: number, campaign: string, run: string, duration_s: number} | null} bias_instability
 */
/**
 * @typedef {object} GapFind
 * @property {string} unit
 * @property {number} model
 * @property {"none" | "named" | "unknown" | "cannot_judge"} verdict
 * @property {string} reason
 * @property {{code: string, text: string}[]} [notes] absent in reports kept before there were notes
 * @property {"run" | "branch" | "half"} held_out
 * @property {any[]} effects
 * @property {any[]} suspects
 * @property {Structure | null} residual_structure
 * @property {SlowNoise[]} [slow_noise] absent in reports kept before it was listed
 * @property {{name: string, why: string}[]} not_testable
 * @property {any[]} rejected_by_gate
 * @property {Record<string, number>} detection_limit
 * @property {Record<string, {before_rms: number, after_rms: number, floor_rms: number, closed_fraction: number | null, closed_ci95: [number, number] | null}>} gap
 * @property {any} [map] null: cannot_judge, or no plateaus
 * @property {any} [locked_run]
 */
