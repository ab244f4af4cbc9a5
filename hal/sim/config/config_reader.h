// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/sim/config/range.h"

namespace soak::hal::sim {

/// Reads values out of a TOML text and keeps the first mistake with its line; after it every value is a zero, so that a
/// caller can read all keys in a row and ask once, with finish(). Keys are written "table.key".
class ConfigReader {
 public:
  /// Limits that a number must keep, both ends allowed.
  struct Limits {
    double low;
    double high;
  };

  ConfigReader(std::string_view text, std::string file);
  ~ConfigReader();
  ConfigReader(const ConfigReader&) = delete;
  ConfigReader& operator=(const ConfigReader&) = delete;

  [[nodiscard]] double number(std::string_view key, Limits limits);
  [[nodiscard]] std::int64_t whole(std::string_view key, Limits limits);
  /// Pair [low, high] with low ≤ high.
  [[nodiscard]] Range range(std::string_view key, Limits limits);
  /// As range(), both ends whole.
  [[nodiscard]] Range whole_range(std::string_view key, Limits limits);
  /// At least one number.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, Limits limits);
  /// At least one text.
  [[nodiscard]] std::vector<std::string> texts(std::string_view key);
  [[nodiscard]] std::string text(std::string_view key);
  [[nodiscard]] std::optional<double> optional_number(std::string_view key, Limits limits);
  [[nodiscard]] std::optional<std::string> optional_text(std::string_view key);
  [[nodiscard]] std::optional<bool> optional_flag(std::string_view key);
  /// As texts(), but empty where the key is absent.
  [[nodiscard]] std::vector<std::string> optional_texts(std::string_view key);
  /// Whether there is a table of that name.
  [[nodiscard]] bool has(std::string_view table) const;
  /// Tables in an array [[name]], whose keys are written "name[0].key"; 0 where it is absent.
  [[nodiscard]] std::size_t table_count(std::string_view name);

  /// Records a mistake in the value of a key that was read.
  void refuse(std::string_view key, std::string message);

  /// Success, or the first mistake; a key that nobody asked for is one.
  [[nodiscard]] base::Status finish();

 private:
  struct Document;
  std::unique_ptr<Document> document_;
};

}  // namespace soak::hal::sim
