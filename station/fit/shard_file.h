// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash.h"
#include "base/result.h"

/// Result shards: what one of several tasks fitted, in a file of its own (docs/file-formats.md).
namespace soak::station {

/// One of `of` parts of all units. Each unit is in exactly one of them.
struct ShardPart {
  int shard = 1;  ///< 1 to `of`
  int of = 1;
};

/// The part that `text` names: "3/8", or "slurm" for the task of a Slurm job array, by its environment
/// (SLURM_ARRAY_TASK_ID, _MIN, _MAX, _COUNT). Refuses (bad_input) any other text, and an array with gaps. The message
/// follows the option's name.
[[nodiscard]] base::Result<ShardPart> parse_shard_part(const std::string& text);

/// Of what a shard is a part, and how it was fitted.
struct ShardHead {
  ShardPart part;
  std::string software;                 ///< version of the program
  std::string user;                     ///< who fitted
  std::optional<std::string> campaign;  ///< only runs of this one
  std::optional<int> rules;             ///< of the ANFIS; absent = auto
};

/// What became of a unit.
enum class ShardResult {
  fitted,           ///< the entry has its model
  up_to_date,       ///< its newest model was made of the same
  waits_for_fleet,  ///< it takes what other units show of hysteresis, and those may be in other shards
  failed,           ///< the entry has the reason
};
[[nodiscard]] std::string_view name_of(ShardResult result);

/// A unit of a shard.
struct ShardEntry {
  std::string unit;
  ShardResult result = ShardResult::fitted;
  std::int32_t version = 0;     ///< of the model: the next one in the catalog that was read
  std::int32_t epoch = 0;       ///< of the unit
  double created_utc_s = 0.0;   ///< of the model
  std::string inputs_sha256{};  ///< of all that the fit took (fit_inputs.h)
  std::string document{};       ///< the model as the catalog stores it
  std::string failure{};        ///< why the unit could not be fitted
};

/// Writes a shard. It has its name once it is whole; if it is never finished nothing is left but, where the process was
/// killed, a file with ".tmp-" in its name.
class ShardWriter {
 public:
  /// Fails (bad_input) where the file cannot be created.
  [[nodiscard]] static base::Result<ShardWriter> create(const std::filesystem::path& file, const ShardHead& head);
  ShardWriter(ShardWriter&& other) noexcept;
  ShardWriter(const ShardWriter&) = delete;
  ShardWriter& operator=(const ShardWriter&) = delete;
  ShardWriter& operator=(ShardWriter&&) = delete;
  ~ShardWriter();

  /// Fails (internal) where the disk does.
  [[nodiscard]] base::Status add(const ShardEntry& entry);
  /// Ends the shard, gives it its name and forces it to the disk. Returns its SHA-256, as ShardReader::sha256(). Fails
  /// (internal) where the disk does.
  [[nodiscard]] base::Result<std::string> finish();

 private:
  ShardWriter(std::filesystem::path file, std::filesystem::path temporary);
  base::Status write_line(const std::string& line);

  std::filesystem::path file_;
  std::filesystem::path temporary_;  ///< empty once it has its name
  std::ofstream out_;
  base::Sha256 hash_;
  std::size_t entries_ = 0;
};

/// A whole shard. It stays the one that was opened, also where a task replaces the file. Memory: one entry at a time.
class ShardReader {
 public:
  /// Reads all of the file once. Fails (bad_input) where it cannot be read, is no shard, or one of a newer format;
  /// (corrupt) where its end is missing or its SHA-256 is another one.
  [[nodiscard]] static base::Result<ShardReader> open(const std::filesystem::path& file);

  [[nodiscard]] const ShardHead& head() const { return head_; }
  /// Of all its lines but the last, which states it.
  [[nodiscard]] const std::string& sha256() const { return sha256_; }
  /// Hands over the units in the order of the file; ends with the first failure of `visit`. Fails (corrupt) for an
  /// entry that lacks something.
  [[nodiscard]] base::Status for_each(const std::function<base::Status(const ShardEntry&)>& visit);

 private:
  explicit ShardReader(std::filesystem::path file) : file_(std::move(file)), in_(file_, std::ios::binary) {}

  std::filesystem::path file_;
  std::ifstream in_;
  ShardHead head_;
  std::string sha256_;
  std::size_t entries_ = 0;
};

}  // namespace soak::station
