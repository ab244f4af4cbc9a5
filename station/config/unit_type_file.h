// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"

namespace soak::station {

/// Reads procedures/units/NAME.toml (docs/procedures.md describes it); the name in it is that of the file. All mistakes
/// at once, one per line, each with "`file`:line".
[[nodiscard]] base::Result<calib::UnitType> parse_unit_type(std::string_view text, const std::string& file);
[[nodiscard]] base::Result<calib::UnitType> read_unit_type(const std::filesystem::path& file);

/// The types of a folder, in the order of their names. A file that is wrong is an error.
[[nodiscard]] base::Result<std::vector<calib::UnitType>> read_unit_types(const std::filesystem::path& folder);

/// What is known of the type with that name: its file in the default folder, or the name alone where there is none.
[[nodiscard]] base::Result<calib::UnitType> known_unit_type(const std::string& name);

/// The same for a unit that is entered: refuses (bad_input, at --type) a name that has no file, with those that have
/// one. "generic" needs none.
[[nodiscard]] base::Result<calib::UnitType> stated_unit_type(const std::string& name);

/// `unit_type_unknown` where the type of a unit has no file (it was entered elsewhere, or by an older version): what
/// the file would say is missing from everything that is done with the unit.
[[nodiscard]] std::vector<calib::Warning> unit_type_warnings(const std::string& name);

/// Reads a file that holds a table [limits] and nothing else: gyro, accel (all three axes), gyro_x ... accel_z (one
/// axis, which wins) in deg/s and m/s², and each of these with _scale_ppm behind it, in ppm. Refuses all mistakes at
/// once, each with its line. A unit type's file may hold the same table.
[[nodiscard]] base::Result<calib::Limits> read_limits(const std::filesystem::path& path);

/// Limits of a verification and where they come from; no source: none are known.
struct KnownLimits {
  calib::Limits limits;
  std::optional<std::string> source;
};

/// The limits that the file of this type states.
[[nodiscard]] base::Result<KnownLimits> limits_of_type(const std::string& name);

/// Limits under the keys of one axis, in deg/s, m/s² and ppm: what read_limits() reads back.
[[nodiscard]] std::map<std::string, double> stated_limits(const calib::Limits& limits);

/// Whether three of the labels "+X" ... "-Z" form a right-handed frame, in this order.
[[nodiscard]] bool is_right_handed(const std::array<std::string, 3>& labels);

/// Names the folder of unit types. `soakd` sets it to that of its configuration, for all that it does and for the
/// programs that it starts.
inline constexpr const char* kUnitTypesVariable = "SOAK_UNIT_TYPES";

/// $SOAK_UNIT_TYPES, else $SOAK_PROCEDURES/units, else share/soak/procedures/units beside the bin/ that the program was
/// installed in, else that of the checkout which it was built from; need not exist.
[[nodiscard]] std::filesystem::path default_unit_type_folder();

/// The folder of procedures, with the maps of chambers and fixtures beside them, absolute: $SOAK_PROCEDURES, else the
/// shipped one; need not exist.
[[nodiscard]] std::filesystem::path shipped_procedures();

}  // namespace soak::station
