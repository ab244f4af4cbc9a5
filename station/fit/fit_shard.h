// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/fit/fit_batch.h"
#include "station/fit/shard_file.h"

/// Many machines fit the units of one catalog, each its part, into result shards; the station joins them.
namespace soak::station {

/// A shard that was written.
struct FittedShard {
  std::string sha256;            ///< ShardReader::sha256()
  std::vector<BatchUnit> units;  ///< of the part, in the order of serial numbers
};

/// What became of a unit of a shard.
[[nodiscard]] ShardResult result_of(const BatchUnit& unit);

/// Fits the units of a part into a result shard, which replaces `file` once it is whole. The catalog is only read; it
/// must be one that nobody writes (Catalog::open_unchanged()). Fails as fit_batch() and ShardWriter do; a unit that
/// cannot be fitted is an entry of the shard.
[[nodiscard]] base::Result<FittedShard> fit_shard(const db::Catalog& catalog, const ShardPart& part,
                                                  BatchOptions options, const std::filesystem::path& file,
                                                  const std::function<bool(double)>& progress);

/// A unit whose model a shard had.
struct MergedModel {
  std::string unit;
  std::int32_t version = 0;
  bool was_there = false;  ///< to the last byte: nothing was done
};

/// A shard that the catalog has now.
struct MergedShard {
  ShardPart part;
  std::string sha256;
  std::vector<MergedModel> models;
  std::vector<std::string> up_to_date;  ///< units whose model was made of the same, when the shard was fitted
  std::vector<std::string> waiting;     ///< units for 'soak fit --all' when all shards are merged
  std::vector<std::string> failed;      ///< "unit SN: reason"
};

/// Stores all models of a shard as they were fitted, and logs it; or none. The same shard again changes nothing.
/// Refuses (bad_input) a shard of another version of Soak; a unit or a run that the catalog does not have; a model that
/// the catalog would not get from the same fit now (runs, voids, references, type file, newer model: fit_inputs.h); and
/// a version that the catalog has with another content. Refuses (corrupt) a damaged shard.
[[nodiscard]] base::Result<MergedShard> merge_shard(db::Catalog& catalog, const std::filesystem::path& file,
                                                    const std::string& user);

}  // namespace soak::station
