// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

/// What a program leaves behind.
struct ProgramOutcome {
  int exit_status = 0;  ///< 0 done, else the value of the base::ErrorKind
  std::string output;   ///< for standard output
  std::string errors;   ///< for standard error
};

/// Outcome of a program `name` that could not do its work.
[[nodiscard]] ProgramOutcome failed_program(std::string_view name, const base::Error& error);

/// The options of a command line, each "--name value" once. All errors are bad_input.
class ProgramOptions {
 public:
  /// Refuses options other than `names`, options without a value and options given twice. An option among `lists` takes
  /// all values up to the next option.
  [[nodiscard]] static base::Result<ProgramOptions> parse(const std::vector<std::string>& arguments,
                                                          const std::vector<std::string_view>& names,
                                                          const std::vector<std::string_view>& lists = {});

  /// Value of an option; nothing where it was not given.
  [[nodiscard]] std::optional<std::string> text(std::string_view name) const;
  /// As text(), but an absent or empty value is refused: the option is `meaning`.
  [[nodiscard]] base::Result<std::string> required(std::string_view name, std::string_view meaning) const;
  [[nodiscard]] base::Result<std::optional<std::int64_t>> whole(std::string_view name, std::int64_t low,
                                                                std::int64_t high) const;
  /// Values of an option of the list kind.
  [[nodiscard]] base::Result<std::vector<std::int64_t>> wholes(std::string_view name, std::int64_t low,
                                                               std::int64_t high) const;

  /// The same as they stand.
  [[nodiscard]] std::vector<std::string> texts(std::string_view name) const;

  /// Replaces `target` by the value of an option, where that is given.
  template <class Whole>
  [[nodiscard]] base::Status override_whole(std::string_view name, std::int64_t low, std::int64_t high,
                                            Whole& target) const {
    const auto value = whole(name, low, high);
    if (!value) return base::forward_error(value);
    if (const auto& given = *value) target = static_cast<Whole>(*given);
    return {};
  }

 private:
  std::map<std::string, std::vector<std::string>, std::less<>> values_;
};

/// Largest seed that a command line takes.
inline constexpr std::int64_t kMaxSeed = std::numeric_limits<std::int64_t>::max();

/// lab.toml, or the file that --config names, with --seed and --units in place of its own.
[[nodiscard]] base::Result<CampaignConfig> configured(const ProgramOptions& options, int max_units);

/// All of soaksim-campaign but its streams; `arguments` without the program's name.
[[nodiscard]] ProgramOutcome run_campaign_program(const std::vector<std::string>& arguments);

/// All of soaksim but its streams and signals: serves the laboratory until `stop_fd` becomes readable. `announce` gets
/// the line for standard output when all listens and station.toml is written.
[[nodiscard]] ProgramOutcome run_soaksim(const std::vector<std::string>& arguments, int stop_fd,
                                         const std::function<void(const std::string&)>& announce);

/// All of soaksim-truth but its streams: what is true of the units of soaksim.
[[nodiscard]] ProgramOutcome run_soaksim_truth(const std::vector<std::string>& arguments);

}  // namespace soak::hal::sim
