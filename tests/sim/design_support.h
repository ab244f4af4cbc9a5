// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "hal/sim/programs/programs.h"
#include "tests/sim/support.h"

namespace soak::hal::sim::test {

/// Columns of a CSV text by name.
struct Table {
  std::vector<std::string> names;
  std::vector<std::map<std::string, std::string>> rows;

  [[nodiscard]] double number(std::size_t row, const std::string& name) const { return std::stod(rows[row].at(name)); }
};

inline std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

inline Table table_of(const std::string& csv) {
  Table table;
  std::istringstream stream(csv);
  std::string line;
  std::getline(stream, line);
  table.names = fields_of(line);
  while (std::getline(stream, line)) {
    const std::vector<std::string> fields = fields_of(line);
    std::map<std::string, std::string> row;
    for (std::size_t i = 0; i < table.names.size(); ++i) row[table.names[i]] = fields.at(i);
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// What soaksim-campaign writes with tables added to lab.toml.
struct DesignedFiles {
  ProgramOutcome outcome;
  std::string csv;  ///< of unit SIM-0001
  nlohmann::json truth;
};

inline DesignedFiles designed_files(const std::string& added_toml, std::vector<std::string> more = {}) {
  const TemporaryFolder folder;
  const std::filesystem::path config = folder.path() / "lab.toml";
  const std::filesystem::path truth = folder.path() / "hidden" / "truth.json";
  std::filesystem::create_directory(truth.parent_path());
  std::ofstream(config) << content_of(kShippedConfig) << "\n" << added_toml;
  std::vector<std::string> arguments = {
      "--out",        (folder.path() / "out").string(), "--units", "1", "--truth", truth.string(), "--config",
      config.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  DesignedFiles files;
  files.outcome = run_campaign_program(arguments);
  if (files.outcome.exit_status != 0) return files;
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path() / "out")) {
    count += entry.is_regular_file() ? 1 : 0;
  }
  if (count != 1) throw std::runtime_error("more than the recording lies beside the recording");
  files.csv = content_of(folder.path() / "out" / "campaign" / "SIM-0001.csv");
  files.truth = nlohmann::json::parse(content_of(truth));
  return files;
}

/// A table [[hidden]].
inline std::string hidden(const std::string& effect, const std::string& size, int seed = 1) {
  return "[[hidden]]\neffect = \"" + effect + "\"\n" + size + "\nseed = " + std::to_string(seed) + "\n";
}

}  // namespace soak::hal::sim::test
