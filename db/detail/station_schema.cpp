// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "db/catalog/detail/event_chain.h"
#include "db/catalog/detail/run_digest.h"
#include "db/catalog/detail/seals.h"
#include "db/detail/schema.h"

namespace soak::db::schema {
namespace {

/// docs/file-formats.md is the description of this text.
constexpr const char* kStationV1 = R"sql(
-- Sensor statistics are SI: gyro_* in rad/s, accel_* in m/s2, their variances in the square of that. Other columns carry
-- their unit in the name. NULL stands for "not known" or "not a number". segment_dps shows the rates in deg/s.

CREATE TABLE unit_type (
  name TEXT PRIMARY KEY              -- file in procedures/units, or "generic"
) WITHOUT ROWID;

CREATE TABLE unit (
  serial TEXT PRIMARY KEY,
  type   TEXT NOT NULL REFERENCES unit_type (name),
  epoch  INTEGER NOT NULL DEFAULT 0 CHECK (epoch >= 0)   -- rises with each repair or re-flash
) WITHOUT ROWID;

CREATE TABLE campaign (
  name      TEXT PRIMARY KEY,
  procedure TEXT NOT NULL
) WITHOUT ROWID;

-- Campaigns that this station carries out; campaigns of imported runs have no row.
CREATE TABLE journal (
  campaign      TEXT PRIMARY KEY REFERENCES campaign (name),
  document      TEXT NOT NULL,       -- JSON: plan, units and slots
  state         TEXT NOT NULL CHECK (state IN ('running', 'paused', 'interrupted', 'finished', 'aborted', 'failed')),
  reason        TEXT NOT NULL,
  created_utc_s REAL NOT NULL,
  updated_utc_s REAL NOT NULL
);
-- One chamber: at most one campaign is open.
CREATE UNIQUE INDEX journal_open ON journal ((state IN ('running', 'paused'))) WHERE state IN ('running', 'paused');

-- Steps of a campaign's plan that came to their end.
CREATE TABLE step (
  ordinal       INTEGER PRIMARY KEY, -- order of arrival
  campaign      TEXT NOT NULL REFERENCES journal (campaign),
  step_index    INTEGER NOT NULL CHECK (step_index >= 0),   -- in the plan
  attempt       INTEGER NOT NULL CHECK (attempt >= 0),
  started_utc_s REAL NOT NULL,
  ended_utc_s   REAL NOT NULL,
  outcome       TEXT NOT NULL,
  text          TEXT NOT NULL,
  run_id        TEXT NOT NULL,       -- of the run file that was open; empty = none
  UNIQUE (campaign, step_index, attempt)
);

-- One unit's part of one run; a run file may hold several units.
CREATE TABLE run (
  run_id         TEXT NOT NULL,      -- UUIDv7
  unit           TEXT NOT NULL REFERENCES unit (serial),
  campaign       TEXT NOT NULL REFERENCES campaign (name),
  label          TEXT NOT NULL,
  procedure      TEXT NOT NULL,
  -- What may be done with it: only those for calibration enter a fit.
  purpose        TEXT NOT NULL CHECK (purpose IN ('calibration', 'verification', 'diagnosis')),
  epoch          INTEGER NOT NULL,
  created_utc_s  REAL NOT NULL,
  clock_rate     REAL NOT NULL,
  simulated      INTEGER NOT NULL CHECK (simulated IN (0, 1)),
  sealed         INTEGER NOT NULL CHECK (sealed IN (0, 1)),
  file_name      TEXT NOT NULL,      -- relative to the folder runs
  file_sha256    TEXT NOT NULL,
  content_sha256 TEXT NOT NULL,
  latitude_deg   REAL,
  height_m       REAL,
  azimuth_deg    REAL,
  gravity_mps2   REAL,
  row_count      INTEGER NOT NULL,
  duration_s     REAL NOT NULL,
  PRIMARY KEY (run_id, unit),
  UNIQUE (campaign, unit, label)
) WITHOUT ROWID;
CREATE INDEX run_by_unit ON run (unit, created_utc_s);

-- Statistics of one segment. up_x ... rate_dps describe the position where its direction is known.
CREATE TABLE segment (
  run_id         TEXT NOT NULL,
  unit           TEXT NOT NULL,
  visit          INTEGER NOT NULL,   -- ordinal of the plateau in the run, from 0
  position       TEXT NOT NULL,      -- label; empty = one attitude throughout
  attempt        INTEGER NOT NULL,   -- repetition of the position within the visit, from 0
  phase          TEXT NOT NULL CHECK (phase IN ('soak', 'ramp')),
  sweep          TEXT NOT NULL CHECK (sweep IN ('unknown', 'up', 'down')),
  plateau_c      REAL,
  position_label TEXT,
  up_x REAL, up_y REAL, up_z REAL,   -- unit vector that points up, in body axes
  azimuth_deg    REAL,
  rate_dps       REAL,
  t_start_s      REAL NOT NULL,
  t_end_s        REAL NOT NULL,
  temp_c         REAL,
  temp_rate_kpmin REAL,
  gyro_x_temp_c REAL, gyro_y_temp_c REAL, gyro_z_temp_c REAL,
  accel_x_temp_c REAL, accel_y_temp_c REAL, accel_z_temp_c REAL,
  gyro_x_count INTEGER NOT NULL, gyro_x_mean REAL, gyro_x_variance REAL, gyro_x_se REAL,
  gyro_y_count INTEGER NOT NULL, gyro_y_mean REAL, gyro_y_variance REAL, gyro_y_se REAL,
  gyro_z_count INTEGER NOT NULL, gyro_z_mean REAL, gyro_z_variance REAL, gyro_z_se REAL,
  accel_x_count INTEGER NOT NULL, accel_x_mean REAL, accel_x_variance REAL, accel_x_se REAL,
  accel_y_count INTEGER NOT NULL, accel_y_mean REAL, accel_y_variance REAL, accel_y_se REAL,
  accel_z_count INTEGER NOT NULL, accel_z_mean REAL, accel_z_variance REAL, accel_z_se REAL,
  PRIMARY KEY (run_id, unit, visit, position, attempt),
  FOREIGN KEY (run_id, unit) REFERENCES run (run_id, unit)
) WITHOUT ROWID;

-- Statistics of blocks of fixed length inside a segment.
CREATE TABLE block (
  run_id     TEXT NOT NULL,
  unit       TEXT NOT NULL,
  visit      INTEGER NOT NULL,
  position   TEXT NOT NULL,
  attempt    INTEGER NOT NULL,
  ordinal    INTEGER NOT NULL,       -- 0, 1, 2, ... within the segment
  t_s        REAL NOT NULL,          -- middle, device time
  duration_s REAL NOT NULL,
  temp_c     REAL,
  temp_rate_kpmin REAL,
  gyro_x_temp_c REAL, gyro_y_temp_c REAL, gyro_z_temp_c REAL,
  accel_x_temp_c REAL, accel_y_temp_c REAL, accel_z_temp_c REAL,
  gyro_x_count INTEGER NOT NULL, gyro_x_mean REAL, gyro_x_variance REAL, gyro_x_se REAL,
  gyro_y_count INTEGER NOT NULL, gyro_y_mean REAL, gyro_y_variance REAL, gyro_y_se REAL,
  gyro_z_count INTEGER NOT NULL, gyro_z_mean REAL, gyro_z_variance REAL, gyro_z_se REAL,
  accel_x_count INTEGER NOT NULL, accel_x_mean REAL, accel_x_variance REAL, accel_x_se REAL,
  accel_y_count INTEGER NOT NULL, accel_y_mean REAL, accel_y_variance REAL, accel_y_se REAL,
  accel_z_count INTEGER NOT NULL, accel_z_mean REAL, accel_z_variance REAL, accel_z_se REAL,
  PRIMARY KEY (run_id, unit, visit, position, attempt, ordinal),
  FOREIGN KEY (run_id, unit, visit, position, attempt) REFERENCES segment (run_id, unit, visit, position, attempt)
) WITHOUT ROWID;

-- What the data gate found in the samples of a segment: 'reject' keeps the segment, or that sensor of it, out of fits.
CREATE TABLE finding (
  run_id   TEXT NOT NULL,
  unit     TEXT NOT NULL,
  visit    INTEGER NOT NULL,
  position TEXT NOT NULL,
  attempt  INTEGER NOT NULL,
  ordinal  INTEGER NOT NULL,         -- 0, 1, 2, ... within the segment
  code     TEXT NOT NULL CHECK (code <> ''),
  severity TEXT NOT NULL CHECK (severity IN ('warn', 'reject')),
  sensor   TEXT,                     -- NULL = the whole segment
  text     TEXT NOT NULL,
  PRIMARY KEY (run_id, unit, visit, position, attempt, ordinal),
  FOREIGN KEY (run_id, unit, visit, position, attempt) REFERENCES segment (run_id, unit, visit, position, attempt)
) WITHOUT ROWID;

-- A record withdraws a run of a unit, a visit of it (visit), a position of that (position) or one attempt (attempt).
CREATE TABLE void (
  void_id  TEXT PRIMARY KEY,         -- UUIDv7
  run_id   TEXT NOT NULL,
  unit     TEXT NOT NULL,
  visit    INTEGER,
  position TEXT CHECK (position IS NULL OR visit IS NOT NULL),
  attempt  INTEGER CHECK (attempt IS NULL OR position IS NOT NULL),
  reason   TEXT NOT NULL CHECK (reason <> ''),
  user     TEXT NOT NULL CHECK (user <> ''),
  utc_s    REAL NOT NULL,
  FOREIGN KEY (run_id, unit) REFERENCES run (run_id, unit)
);
CREATE INDEX void_by_run ON void (run_id, unit);

CREATE TABLE model (
  unit          TEXT NOT NULL REFERENCES unit (serial),
  version       INTEGER NOT NULL CHECK (version >= 1),
  epoch         INTEGER NOT NULL,
  created_utc_s REAL NOT NULL,
  sha256        TEXT NOT NULL,       -- of the document
  document      TEXT NOT NULL,       -- JSON of the whole model
  PRIMARY KEY (unit, version)
);

-- What was found missing in a model, as `soak gap find` said it.
CREATE TABLE gap_report (
  gap_report_id TEXT PRIMARY KEY,     -- UUIDv7
  unit          TEXT NOT NULL,
  model_version INTEGER NOT NULL,
  created_utc_s REAL NOT NULL,
  document      TEXT NOT NULL,
  FOREIGN KEY (unit, model_version) REFERENCES model (unit, version)
);
CREATE INDEX gap_report_of_unit ON gap_report (unit);

-- Calibration files that were exported.
CREATE TABLE calibration (
  calibration_id TEXT PRIMARY KEY,   -- UUIDv7
  unit           TEXT NOT NULL,
  model_version  INTEGER NOT NULL,
  created_utc_s  REAL NOT NULL,
  format         TEXT NOT NULL,
  sha256         TEXT NOT NULL,
  path           TEXT NOT NULL,
  FOREIGN KEY (unit, model_version) REFERENCES model (unit, version)
);

CREATE TABLE event (
  ordinal  INTEGER PRIMARY KEY,      -- order of arrival at this station
  event_id TEXT NOT NULL UNIQUE,     -- UUIDv7
  utc_s    REAL NOT NULL,
  kind     TEXT NOT NULL,
  subject  TEXT NOT NULL,
  text     TEXT NOT NULL
);

-- The register of references: a row is a certificate. The newest one of a kind and name stands for it. Units by kind:
-- chamber_probe K, fixture_squareness rad, level rad, gravity m/s2, supply V, rate ppm.
CREATE TABLE reference (
  record_id            TEXT PRIMARY KEY,    -- UUIDv7
  kind                 TEXT NOT NULL CHECK (kind IN ('chamber_probe', 'fixture_squareness', 'level', 'gravity', 'supply', 'rate')),
  name                 TEXT NOT NULL CHECK (name <> ''),
  certificate          TEXT NOT NULL CHECK (certificate <> ''),
  correction           REAL,                -- added to what the reference says; gravity: the value itself
  standard_uncertainty REAL NOT NULL CHECK (standard_uncertainty >= 0),
  issued_utc_s         REAL NOT NULL,
  due_utc_s            REAL NOT NULL CHECK (due_utc_s > issued_utc_s),
  user                 TEXT NOT NULL CHECK (user <> ''),
  entered_utc_s        REAL NOT NULL
);

-- References that are not used any more.
CREATE TABLE reference_retirement (
  record_id TEXT PRIMARY KEY REFERENCES reference (record_id),
  reason    TEXT NOT NULL CHECK (reason <> ''),
  user      TEXT NOT NULL CHECK (user <> ''),
  utc_s     REAL NOT NULL
);

-- Entries of the register that are wrong: they count as never made.
CREATE TABLE reference_withdrawal (
  record_id TEXT PRIMARY KEY REFERENCES reference (record_id),
  reason    TEXT NOT NULL CHECK (reason <> ''),
  user      TEXT NOT NULL CHECK (user <> ''),
  utc_s     REAL NOT NULL
);

-- Signed permissions to use an expired reference; docs/records.md says what is signed.
CREATE TABLE waiver (
  waiver_id  TEXT PRIMARY KEY,              -- UUIDv7
  record_id  TEXT NOT NULL REFERENCES reference (record_id),
  reason     TEXT NOT NULL CHECK (reason <> ''),
  signer     TEXT NOT NULL CHECK (signer <> ''),
  public_key TEXT NOT NULL,                 -- Ed25519, 64 hexadecimal digits
  signature  TEXT NOT NULL,                 -- 128 hexadecimal digits
  utc_s      REAL NOT NULL
);

-- Which references a campaign was measured with.
CREATE TABLE campaign_reference (
  ordinal   INTEGER PRIMARY KEY,            -- order of arrival
  campaign  TEXT NOT NULL REFERENCES campaign (name),
  record_id TEXT NOT NULL REFERENCES reference (record_id),
  waiver_id TEXT REFERENCES waiver (waiver_id),
  utc_s     REAL NOT NULL                   -- of this note
);
CREATE INDEX campaign_reference_by_campaign ON campaign_reference (campaign);

-- Units by which the station itself is judged.
CREATE TABLE check_standard (
  check_standard_id TEXT PRIMARY KEY,       -- UUIDv7
  unit        TEXT NOT NULL REFERENCES unit (serial),
  since_utc_s REAL NOT NULL,
  reason      TEXT NOT NULL CHECK (reason <> ''),
  user        TEXT NOT NULL CHECK (user <> '')
);
CREATE TABLE check_standard_end (
  check_standard_id TEXT PRIMARY KEY REFERENCES check_standard (check_standard_id),
  reason TEXT NOT NULL CHECK (reason <> ''),
  user   TEXT NOT NULL CHECK (user <> ''),
  utc_s  REAL NOT NULL
);

-- Segments that no record withdraws, means and standard errors in the units of the pages.
CREATE VIEW segment_dps AS
SELECT run_id, unit, visit, position, attempt, phase, sweep, plateau_c, t_start_s, t_end_s, temp_c,
       gyro_x_mean * 57.29577951308232 AS gyro_x_mean_dps, gyro_x_se * 57.29577951308232 AS gyro_x_se_dps,
       gyro_y_mean * 57.29577951308232 AS gyro_y_mean_dps, gyro_y_se * 57.29577951308232 AS gyro_y_se_dps,
       gyro_z_mean * 57.29577951308232 AS gyro_z_mean_dps, gyro_z_se * 57.29577951308232 AS gyro_z_se_dps,
       accel_x_mean AS accel_x_mean_mps2, accel_x_se AS accel_x_se_mps2,
       accel_y_mean AS accel_y_mean_mps2, accel_y_se AS accel_y_se_mps2,
       accel_z_mean AS accel_z_mean_mps2, accel_z_se AS accel_z_se_mps2
FROM segment
WHERE NOT EXISTS (SELECT 1 FROM void
                  WHERE void.run_id = segment.run_id AND void.unit = segment.unit
                    AND (void.visit IS NULL OR void.visit = segment.visit)
                    AND (void.position IS NULL OR void.position = segment.position)
                    AND (void.attempt IS NULL OR void.attempt = segment.attempt));

CREATE VIEW run_overview AS
SELECT datetime(created_utc_s, 'unixepoch') AS created_utc, campaign, unit, label, purpose, epoch, row_count,
       duration_s / 3600 AS hours, simulated, sealed, run_id, file_name,
       EXISTS (SELECT 1 FROM void
               WHERE void.run_id = run.run_id AND void.unit = run.unit AND void.visit IS NULL) AS voided
FROM run
ORDER BY created_utc_s, run_id, unit;
)sql";

constexpr const char* kStationV2 = R"sql(
-- SHA-256 of the row itself and of its rows in segment, block and finding (docs/file-formats.md).
ALTER TABLE run ADD COLUMN numbers_sha256 TEXT NOT NULL DEFAULT '';
-- Why the run ended before its last visit, and the run id of the run that was cut short and goes on here.
ALTER TABLE run ADD COLUMN cut_short TEXT NOT NULL DEFAULT '';
ALTER TABLE run ADD COLUMN continues TEXT NOT NULL DEFAULT '';

-- Who did it (empty = not known), and the SHA-256 of the event and all before it (docs/file-formats.md).
DROP TRIGGER event_keeps_rows;
DROP TRIGGER event_keeps_all;
DROP TRIGGER event_replaces_none;
ALTER TABLE event ADD COLUMN user TEXT NOT NULL DEFAULT '';
ALTER TABLE event ADD COLUMN chain_sha256 TEXT NOT NULL DEFAULT '';

-- How many rows a table has and a digest of them all; of event the end of its chain (docs/file-formats.md).
CREATE TABLE seal (
  name      TEXT PRIMARY KEY,
  row_count INTEGER NOT NULL,
  sha256    TEXT NOT NULL
) WITHOUT ROWID;

-- Runs whose samples were dropped to make room: the run file is gone, what the catalog knows of it stays.
CREATE TABLE sample_drop (
  drop_id TEXT PRIMARY KEY,          -- UUIDv7
  run_id  TEXT NOT NULL,
  source  TEXT NOT NULL,             -- of the file, as it said
  bytes   INTEGER NOT NULL CHECK (bytes >= 0),
  reason  TEXT NOT NULL CHECK (reason <> ''),
  user    TEXT NOT NULL CHECK (user <> ''),
  utc_s   REAL NOT NULL
);
)sql";

constexpr const char* kStationV3 = R"sql(
-- Where a model came from; one whose origin nobody stated has no row.
CREATE TABLE model_origin (
  unit          TEXT NOT NULL,
  version       INTEGER NOT NULL,
  software      TEXT NOT NULL CHECK (software <> ''),   -- that fitted it
  user          TEXT NOT NULL,       -- who fitted it; empty = not known
  inputs_sha256 TEXT NOT NULL CHECK (length(inputs_sha256) = 64),   -- of all that the fit took
  PRIMARY KEY (unit, version),
  FOREIGN KEY (unit, version) REFERENCES model (unit, version)
);

-- A change of the state of a model; the last one counts. A model without any is 'fitted'.
CREATE TABLE model_state (
  model_state_id TEXT PRIMARY KEY,   -- UUIDv7
  unit          TEXT NOT NULL,
  model_version INTEGER NOT NULL,
  state         TEXT NOT NULL CHECK (state IN ('fitted', 'verified', 'released', 'withdrawn')),
  reason        TEXT NOT NULL CHECK (reason <> ''),
  user          TEXT NOT NULL CHECK (user <> ''),
  utc_s         REAL NOT NULL,
  FOREIGN KEY (unit, model_version) REFERENCES model (unit, version)
);
CREATE INDEX model_state_of_model ON model_state (unit, model_version);

-- What a verification said of a model.
CREATE TABLE verification (
  verification_id TEXT PRIMARY KEY,  -- UUIDv7
  unit          TEXT NOT NULL,
  model_version INTEGER NOT NULL,
  utc_s         REAL NOT NULL,
  user          TEXT NOT NULL CHECK (user <> ''),
  verdict       TEXT NOT NULL CHECK (verdict IN ('pass', 'marginal', 'fail', 'info')),
  document      TEXT NOT NULL,       -- JSON
  FOREIGN KEY (unit, model_version) REFERENCES model (unit, version)
);
CREATE INDEX verification_of_model ON verification (unit, model_version);

CREATE INDEX sample_drop_of_run ON sample_drop (run_id);
)sql";

/// Tables whose rows are only ever added, with the column that numbers them.
constexpr std::pair<std::string_view, std::string_view> kAppendOnlyV1[] = {
    {"event", "event_id"},
    {"void", "void_id"},
    {"gap_report", "gap_report_id"},
    {"reference", "record_id"},
    {"reference_retirement", "record_id"},
    {"reference_withdrawal", "record_id"},
    {"waiver", "waiver_id"},
    {"campaign_reference", "ordinal"},
    {"check_standard", "check_standard_id"},
    {"check_standard_end", "check_standard_id"},
};

/// Triggers that refuse a change of any row: UPDATE, DELETE, and an INSERT OR REPLACE, which deletes without asking the
/// others.
std::string keep_rows(std::string_view table, std::string_view key) {
  return fmt::format(
      R"sql(
CREATE TRIGGER {0}_keeps_rows BEFORE UPDATE ON {0} BEGIN SELECT raise(ABORT, '{0} is append-only'); END;
CREATE TRIGGER {0}_keeps_all BEFORE DELETE ON {0} BEGIN SELECT raise(ABORT, '{0} is append-only'); END;
CREATE TRIGGER {0}_replaces_none BEFORE INSERT ON {0}
WHEN EXISTS (SELECT 1 FROM {0} WHERE {1} = NEW.{1} OR rowid = NEW.rowid)
BEGIN SELECT raise(ABORT, '{0} is append-only'); END;
)sql",
      table, key);
}

/// What version 2 reckons from the rows that are there.
void finish_v2(SQLite::Database& database) {
  catalog::store_all_numbers_sha256(database);
  catalog::chain_all_events(database);
  database.exec(keep_rows("event", "event_id"));
  database.exec(keep_rows("sample_drop", "drop_id"));
  catalog::make_seals(database, 2);
}

void finish_v3(SQLite::Database& database) {
  database.exec(keep_rows("model_state", "model_state_id"));
  database.exec(keep_rows("verification", "verification_id"));
  catalog::make_seals(database, 3);
}

std::vector<Step> all_station_steps() {
  std::string v1 = kStationV1;
  for (const auto& [table, key] : kAppendOnlyV1) v1 += keep_rows(table, key);
  return {{1, std::move(v1)}, {2, kStationV2, finish_v2}, {3, kStationV3, finish_v3}};
}

}  // namespace

const std::vector<Step>& station_steps() {
  static const std::vector<Step> kSteps = all_station_steps();
  return kSteps;
}

}  // namespace soak::db::schema
