// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"
#include "db/catalog/catalog.h"
#include "db/run/run_file.h"

namespace soak::station {

/// Packets of a unit that were lost, by its own counter, on the way to the rows of [from_s, to_s] (device time): each
/// before a row in it. A run file tells of them by events of this kind.
struct PacketLoss {
  std::string unit = {};
  double from_s = 0.0;
  double to_s = 0.0;
  std::uint64_t packets = 0;
};
inline constexpr std::string_view kLostPacketsEvent = "lost_packets";
/// The event's text (JSON).
[[nodiscard]] std::string text_of(const PacketLoss& loss);
/// Adds the finding `lost_packets` to each of the unit's segments that a loss touches.
void mark_losses(std::span<const PacketLoss> losses, std::vector<calib::Segment>& segments);

/// What the catalog gets to know of one unit's part of a run file.
struct RunRecord {
  db::RunRow row;
  std::vector<calib::Segment> segments;
  std::vector<std::string> warnings;
};

/// Reads and segments a unit's samples, and passes the segments through the data gate (calib/segments/data_gate.h) with
/// what is known of the unit's type; the warnings hold a summary of the findings. Left to the caller are `epoch`, the
/// name and the hashes of the file. A run at another clock rate than 1 counts as simulated.
[[nodiscard]] base::Result<RunRecord> describe_run(const db::RunFileReader& file, std::string_view unit,
                                                   const calib::UnitType& type);

/// The same of a run that soakd recorded, whose channel `visit` numbers the visits. One segment's rows are in memory at
/// a time, where the run has set points and positions (calib/segments/long_run.h): memory does not grow with the run.
/// `may_read_in_parts` false: all rows at once, with the same result.
[[nodiscard]] base::Result<RunRecord> describe_recorded_run(const db::RunFileReader& file, std::string_view unit,
                                                            const calib::UnitType& type, bool may_read_in_parts = true);

struct RecordedUnit {
  std::string serial;
  std::string type = "generic";              ///< of a unit that is new to the catalog
  calib::UnitType facts{};                   ///< what is known of the type: for the data gate
  std::vector<calib::Position> positions{};  ///< of the six, those whose azimuth is known: for a run's recorder
  bool supply_is_measured = false;           ///< there will be readings of its supply
  std::optional<std::int32_t> epoch{};       ///< that it had when the run began; absent = that of the catalog
};

/// Rows of a unit whose segments shall not be used.
struct Withdrawal {
  std::string unit;
  std::optional<std::pair<double, double>> span;  ///< first and last device time, s; absent = there were no rows
  std::string reason;
};

/// A sealed run file that the station has recorded, on its way into the catalog.
struct SealedRun {
  std::filesystem::path path;  ///< in the folder `runs`
  std::string sha256;          ///< of the file
  std::vector<RecordedUnit> units;
  std::vector<Withdrawal> withdrawals;
  std::optional<std::string> void_reason;           ///< withdraws the whole run
  std::map<std::string, std::string> void_units{};  ///< serial number → why: withdraws that unit's part
  /// A part that has a segment which nothing withdraws is kept: the reason becomes RunRow::cut_short, and nothing is
  /// void but the segments of `withdrawals`.
  bool keeps_parts = false;
};

/// Enters a run: units and campaign where they are new, one row per unit that has samples, its segments with the data
/// gate's findings, what segmentation and gate warn of as events, and void records (user "soakd") for the segments that
/// a withdrawal touches and for the whole run where there is a reason; all or nothing. A withdrawal that touches none
/// is logged. A unit that was repaired while the run was recorded keeps the epoch in which the run began. Also for a
/// file that was interrupted (RunFileWriter::seal_interrupted). Reads the whole file.
[[nodiscard]] base::Result<std::vector<db::RunRow>> enter_run(db::Catalog& catalog, const SealedRun& run);

}  // namespace soak::station
