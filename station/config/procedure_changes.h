// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/config/procedure.h"

namespace soak::station {

/// What can be changed in a procedure without an editor; absent = as it is. Each has the name that the interface gives
/// it (docs/http-api.md), at which it is refused.
struct ProcedureChanges {
  std::optional<std::vector<double>> set_points_c;  ///< of one run, in order, without the reference plateau's visits
  std::optional<int> runs;                          ///< passes over them
  std::optional<double> dwell_s;                    ///< recorded in each position
  std::optional<double> minimum_soak_s;             ///< at each set point, before anything is recorded
};

/// A new procedure that shall be like another one.
struct NewProcedure {
  std::string from;  ///< file of the other one
  std::string name;
  ProcedureChanges changes;
  std::string origin;  ///< who makes it when, for the comment in its first line: "2026-11-28 07:48 UTC by Eva"
};

/// What of a procedure can be changed, as it is: an object with the members of ProcedureChanges, null where its kind
/// has no such thing, and `reference_c`.
[[nodiscard]] nlohmann::json changeable_document(const Procedure& procedure);

/// "6 set points from -20 to 60 °C, 3 runs": what is changed, for people.
[[nodiscard]] std::string changes_text(const ProcedureChanges& changes);

/// The text of the new procedure: that of the other one, `source`, comments and all other keys included, with its name,
/// a description that says what is changed, and the changes. Set points become a list. Refuses (bad_input): a name that
/// check_procedure_name() refuses; "from", a source that is no procedure; the name of a change that its kind does not
/// have, or with which the text would be none: what parse_procedure() says of it. "set_points_c" where nothing is
/// changed.
[[nodiscard]] base::Result<std::string> changed_procedure(std::string_view source, const NewProcedure& made);

/// Refuses (bad_input, where == "name") what is more, or less, than 1 to 60 letters of a to z, digits, - and _, the
/// first one a letter or digit: it becomes the name of a file.
[[nodiscard]] base::Status check_procedure_name(const std::string& name);

/// The text of a procedure that a person can choose. Refuses (bad_input, where == "from") any other name of a file: no
/// path leads out of the folders.
[[nodiscard]] base::Result<std::string> offered_procedure(const std::vector<std::filesystem::path>& folders,
                                                          const std::string& file);

/// Refuses (bad_input, where == "name") a name that a procedure in one of the folders has as that of its file: none is
/// written over, none hidden.
[[nodiscard]] base::Status check_procedure_is_new(const std::vector<std::filesystem::path>& folders,
                                                  const std::string& name);

/// Writes NAME.toml into the first of the folders, which is created where it is missing. Refuses as
/// check_procedure_is_new() does, also what appeared just now.
[[nodiscard]] base::Result<std::filesystem::path> add_procedure(const std::vector<std::filesystem::path>& folders,
                                                                const std::string& name, std::string_view text);

}  // namespace soak::station
