// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "station/commands/command.h"
#include "station/fit/fit_shard.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

/// soak merge SHARD...
struct MergeCommand final : CatalogCommand {
  std::vector<std::string> files;

  void declare(OptionList& options) override {
    options.add("files SHARD", &files, "Result shards that 'soak fit --all --shard' wrote").required();
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// What became of a file.
struct MergedFile {
  std::string file;
  base::Result<MergedShard> shard;
};

nlohmann::json models_json(const std::vector<MergedModel>& models, bool were_there) {
  nlohmann::json list = nlohmann::json::array();
  for (const MergedModel& model : models) {
    if (model.was_there == were_there) list.push_back({{"unit", model.unit}, {"model", model.version}});
  }
  return list;
}

nlohmann::json file_json(const MergedFile& merged) {
  if (!merged.shard) {
    const base::Error& error = merged.shard.error();
    return {{"file", merged.file}, {"ok", false}, {"code", static_cast<int>(error.kind)}, {"reason", error.message}};
  }
  const MergedShard& shard = *merged.shard;
  return {{"file", merged.file},
          {"ok", true},
          {"shard", shard.part.shard},
          {"of", shard.part.of},
          {"sha256", shard.sha256},
          {"merged", models_json(shard.models, false)},
          {"already", models_json(shard.models, true)},
          {"up_to_date", shard.up_to_date},
          {"waiting", shard.waiting},
          {"failed", shard.failed}};
}

std::string file_text(const MergedFile& merged) {
  if (!merged.shard) return fmt::format("{}: NOT MERGED\n", merged.file);
  const MergedShard& shard = *merged.shard;
  const auto already = std::ranges::count(shard.models, true, &MergedModel::was_there);
  return fmt::format("{}: shard {} of {}: {} models merged, {} were there already, {} units up to date\n", merged.file,
                     shard.part.shard, shard.part.of, static_cast<std::ptrdiff_t>(shard.models.size()) - already,
                     already, shard.up_to_date.size());
}

/// Which shards were not given; empty where all were.
std::string missing_shards(int of, const std::set<int>& given) {
  constexpr std::size_t kMostNamed = 10;
  std::vector<int> named;
  for (int shard = 1; shard <= of && named.size() < kMostNamed; ++shard) {
    if (!given.contains(shard)) named.push_back(shard);
  }
  if (named.empty()) return {};
  const std::size_t others = static_cast<std::size_t>(of) - given.size() - named.size();
  return fmt::format("of {} shards these were not given: {}{}", of, fmt::join(named, ", "),
                     others > 0 ? fmt::format(" and {} others", others) : "");
}

/// What is still to be done: shards that were not given, units that wait, units that failed.
std::vector<std::string> remarks(const std::vector<MergedFile>& all) {
  std::vector<std::string> lines;
  std::map<int, std::set<int>> given;  // shards, by how many there are in all
  std::size_t waiting = 0;
  for (const MergedFile& merged : all) {
    if (!merged.shard) continue;
    given[merged.shard->part.of].insert(merged.shard->part.shard);
    waiting += merged.shard->waiting.size();
    for (const std::string& failure : merged.shard->failed) lines.push_back("not fitted: " + failure);
  }
  for (const auto& [of, shards] : given) {
    if (auto missing = missing_shards(of, shards); !missing.empty()) lines.push_back(std::move(missing));
  }
  if (waiting > 0) {
    lines.push_back(fmt::format(
        "{} units take what the fleet shows of hysteresis: when all shards are merged, 'soak fit --all' fits "
        "them",
        waiting));
  }
  return lines;
}

base::Status verdict(const std::vector<MergedFile>& all) {
  std::string message;
  std::size_t failures = 0;
  auto kind = base::ErrorKind::internal;
  for (const MergedFile& merged : all) {
    if (merged.shard) continue;
    const base::Error& error = merged.shard.error();
    if (failures++ == 0) kind = error.kind;
    message += fmt::format("\n  {}: {}", merged.file, error.message);
  }
  if (failures == 0) return {};
  return base::fail(kind, fmt::format("{} of {} shards were not merged, and nothing of them was stored:{}", failures,
                                      all.size(), message));
}

base::Status MergeCommand::run_with(db::Catalog& catalog, Output& output) {
  if (catalog.read_only()) {
    return base::fail(base::ErrorKind::internal, "this folder cannot be written, so no model could be stored",
                      catalog.data_folder().string());
  }
  std::vector<MergedFile> all;
  nlohmann::json shards = nlohmann::json::array();
  for (const std::string& file : files) {
    all.push_back({file, merge_shard(catalog, file, user_name())});
    shards.push_back(file_json(all.back()));
  }
  if (output.json()) {
    if (auto printed = output.print_json({{"shards", std::move(shards)}, {"remarks", remarks(all)}}); !printed) {
      return printed;
    }
  } else {
    for (const MergedFile& merged : all) output.print(file_text(merged));
  }
  for (const std::string& remark : remarks(all)) output.note("note: " + remark);
  return verdict(all);
}

}  // namespace

CommandGroup merge_commands() {
  return {"",
          "",
          {{"merge", "Join result shards of 'soak fit --all --shard' into the catalog, each wholly or not at all",
            "soak merge shards/*.soakshard", std::make_shared<MergeCommand>(), true,
            "A shard that is merged already changes nothing. Refused are damaged shards, and models that a fit of this "
            "data folder would not give now."}}};
}

}  // namespace soak::station
