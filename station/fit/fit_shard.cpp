// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fit_shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <utility>

#include "base/hash.h"
#include "base/text.h"
#include "calib/model/model_document.h"
#include "station/fit/fit_inputs.h"
#include "station/fit/fit_unit.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

/// Whether a unit is in that part: by its serial number alone, so neither the order nor the other units matter.
bool is_in_part(std::string_view serial, const ShardPart& part) {
  base::Sha256 hash;
  hash.update(serial);
  const base::Sha256Digest digest = hash.finish();
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < sizeof number; ++i) number = (number << 8U) | digest[i];
  return number % static_cast<std::uint64_t>(part.of) == static_cast<std::uint64_t>(part.shard - 1);
}

base::Result<std::vector<std::string>> serials_of(const db::Catalog& catalog, const ShardPart& part) {
  const auto units = catalog.units();
  if (!units) return base::forward_error(units);
  std::vector<std::string> serials;
  for (const db::UnitRow& unit : *units) {
    if (is_in_part(unit.serial, part)) serials.push_back(unit.serial);
  }
  return serials;
}

/// The model as the catalog would have stored it.
base::Result<ShardEntry> fitted_entry(const db::Catalog& catalog, calib::UnitModel& model, const FitInputs& inputs) {
  const auto newest = catalog.model(model.unit);
  if (!newest) return base::forward_error(newest);
  model.version = *newest ? (*newest)->version + 1 : 1;
  model.created_utc_s = inputs.seen_utc_s;
  auto document = calib::model_document(model);
  if (!document) return base::forward_error(document);
  ShardEntry entry;
  entry.unit = model.unit;
  entry.version = model.version;
  entry.epoch = model.epoch;
  entry.created_utc_s = model.created_utc_s;
  entry.inputs_sha256 = inputs.sha256;
  entry.document = *std::move(document);
  return entry;
}

/// The entry of a unit that was not fitted.
ShardEntry other_entry(const BatchUnit& unit) {
  ShardEntry entry;
  entry.unit = unit.serial;
  entry.result = result_of(unit);
  if (!unit.failure) return entry;
  const base::Error& error = *unit.failure;
  entry.failure = error.where.empty() ? error.message : fmt::format("{}: {}", error.where, error.message);
  return entry;
}

/// They go to the terminal. A reason may have several lines.
bool is_plain(const ShardEntry& entry) {
  std::string failure = entry.failure;
  std::ranges::replace(failure, '\n', ' ');
  return base::is_plain_line(entry.unit) && base::is_plain_line(failure);
}

/// A shard on its way into a catalog.
class Merge {
 public:
  Merge(db::Catalog& catalog, std::filesystem::path file, ShardReader reader)
      : catalog_(catalog), file_(std::move(file)), reader_(std::move(reader)) {}

  base::Result<MergedShard> run(const std::string& user) {
    const ShardHead& head = reader_.head();
    if (head.software != software_version()) {
      return refuse(fmt::format("was fitted by Soak {}, and this is {}: fit it again with this one", head.software,
                                software_version()));
    }
    merged_.part = head.part;
    merged_.sha256 = reader_.sha256();
    // In one transaction: what is voided between check and store would go unseen.
    auto stored = catalog_.all_or_nothing([&]() -> base::Status {
      auto checked = reader_.for_each([this](const ShardEntry& entry) { return check(entry); });
      return checked ? store(user) : checked;
    });
    if (!stored) return base::forward_error(stored);
    return std::move(merged_);
  }

 private:
  [[nodiscard]] tl::unexpected<base::Error> refuse(std::string message) const {
    return base::bad_input(std::move(message), file_.string());
  }

  base::Status check(const ShardEntry& entry) {
    if (!is_plain(entry)) {
      return base::corrupt("an entry of the shard holds a serial number or a reason that is no plain text",
                           file_.string());
    }
    switch (entry.result) {
      case ShardResult::fitted:
        return check_model(entry);
      case ShardResult::up_to_date:
        merged_.up_to_date.push_back(entry.unit);
        return {};
      case ShardResult::waits_for_fleet:
        merged_.waiting.push_back(entry.unit);
        return {};
      case ShardResult::failed:
        merged_.failed.push_back(fmt::format("unit {}: {}", entry.unit, entry.failure));
        return {};
    }
    return {};
  }

  base::Status check_model(const ShardEntry& entry) {
    const auto unit = catalog_.unit(entry.unit);
    if (!unit) return base::forward_error(unit);
    if (!*unit)
      return refuse(fmt::format("unit {} is not in this data folder: the shard is another station's", entry.unit));
    const auto same = catalog_.model(entry.unit, entry.version);
    if (!same) return base::forward_error(same);
    if (*same && (*same)->document != entry.document) {
      return refuse(fmt::format("this data folder has another model {} of unit {}; fit the shard again from a new copy",
                                entry.version, entry.unit));
    }
    merged_.models.push_back({entry.unit, entry.version, same->has_value()});
    if (*same) return {};
    if (auto ours = check_runs(entry); !ours) return ours;
    return check_inputs(entry, **unit);
  }

  /// The document must be of what the entry says, and of runs of this catalog.
  [[nodiscard]] base::Status check_runs(const ShardEntry& entry) const {
    const auto calibration = calib::calibration_of(entry.document);
    if (!calibration) return base::forward_error(calibration);
    if (calibration->unit != entry.unit || calibration->model_version != entry.version ||
        calibration->epoch != entry.epoch) {
      return base::corrupt(
          fmt::format("the model in the entry of unit {} is of another unit, version or epoch", entry.unit),
          file_.string());
    }
    const auto runs = catalog_.runs({.unit = entry.unit, .campaign = {}, .run = {}});
    if (!runs) return base::forward_error(runs);
    std::set<std::string> known;
    for (const db::RunRow& run : *runs) known.insert(run.content_sha256);
    for (const std::string& hash : calibration->run_hashes) {
      if (known.contains(hash)) continue;
      return refuse(fmt::format("unit {} was fitted to a run that is not in this data folder (content SHA-256 {})",
                                entry.unit, hash));
    }
    return {};
  }

  /// The same fit, made here and now, must take the same.
  [[nodiscard]] base::Status check_inputs(const ShardEntry& entry, const db::UnitRow& unit) const {
    const auto newest = catalog_.model(entry.unit);
    if (!newest) return base::forward_error(newest);
    const std::int32_t next = *newest ? (*newest)->version + 1 : 1;
    if (next != entry.version) {
      return refuse(
          fmt::format("model {} of unit {} would be number {} here: models were added since the data folder "
                      "was copied; fit the shard again from a new copy",
                      entry.version, entry.unit, next));
    }
    const auto terms = accepted_terms(catalog_, entry.unit, unit.epoch);
    if (!terms) return base::forward_error(terms);
    const ShardHead& head = reader_.head();
    const auto inputs = fit_inputs_now(catalog_, entry.unit, head.campaign, *terms, {head.rules});
    if (!inputs) return base::forward_error(inputs);
    if (inputs->sha256 == entry.inputs_sha256) return {};
    return refuse(fmt::format(
        "a fit of unit {} would take something else here: its epoch, runs, voids, references, accepted "
        "effects or the file of its type have changed since the data folder was copied, or $SOAK_PROCEDURES "
        "names another folder; fit the shard again from a new copy",
        entry.unit));
  }

  /// Inside the transaction.
  base::Status store(const std::string& user) {
    // The models are of who fitted them.
    catalog_.act_as(reader_.head().user);
    std::size_t stored = 0;
    auto next = merged_.models.begin();
    auto all = reader_.for_each([&](const ShardEntry& entry) -> base::Status {
      if (entry.result != ShardResult::fitted) return {};
      if ((next++)->was_there) return {};
      ++stored;
      const auto version = catalog_.add_model(
          entry.unit, entry.epoch, entry.created_utc_s, [&](std::int32_t) { return entry.document; },
          db::ModelOrigin{reader_.head().software, entry.inputs_sha256});
      if (!version) return base::forward_error(version);
      if (*version == entry.version) return {};
      return refuse(
          fmt::format("unit {} stands in the shard twice, or was fitted meanwhile; nothing was merged", entry.unit));
    });
    catalog_.act_as(user);
    if (!all || stored == 0) return all;
    return catalog_.log_event({now_utc_s(), "shard_merged", file_.filename().string(),
                               fmt::format("shard {} of {}, SHA-256 {}, {} models fitted by {}", merged_.part.shard,
                                           merged_.part.of, merged_.sha256, stored, reader_.head().user),
                               user});
  }

  db::Catalog& catalog_;
  std::filesystem::path file_;
  ShardReader reader_;
  MergedShard merged_;
};

}  // namespace

ShardResult result_of(const BatchUnit& unit) {
  if (unit.failure) return ShardResult::failed;
  if (unit.waits_for_fleet) return ShardResult::waits_for_fleet;
  return unit.up_to_date ? ShardResult::up_to_date : ShardResult::fitted;
}

base::Result<FittedShard> fit_shard(const db::Catalog& catalog, const ShardPart& part, BatchOptions options,
                                    const std::filesystem::path& file, const std::function<bool(double)>& progress) {
  const auto serials = serials_of(catalog, part);
  if (!serials) return base::forward_error(serials);
  auto writer =
      ShardWriter::create(file, {part, software_version(), options.user, options.campaign, options.fit.rules});
  if (!writer) return base::forward_error(writer);
  std::mutex mutex;
  options.shard = [&](db::Catalog& own, calib::UnitModel& model, const FitInputs& inputs) -> base::Status {
    const auto entry = fitted_entry(own, model, inputs);
    if (!entry) return base::forward_error(entry);
    const std::lock_guard lock(mutex);
    return writer->add(*entry);
  };
  BatchResult batch = fit_batch(catalog, *serials, options, progress);
  if (!batch.ended) return base::forward_error(batch.ended);
  for (const BatchUnit& unit : batch.units) {
    if (result_of(unit) == ShardResult::fitted) continue;
    if (auto added = writer->add(other_entry(unit)); !added) return base::forward_error(added);
  }
  auto sha256 = writer->finish();
  if (!sha256) return base::forward_error(sha256);
  return FittedShard{*std::move(sha256), std::move(batch.units)};
}

base::Result<MergedShard> merge_shard(db::Catalog& catalog, const std::filesystem::path& file,
                                      const std::string& user) {
  auto reader = ShardReader::open(file);
  if (!reader) return base::forward_error(reader);
  return Merge(catalog, file, *std::move(reader)).run(user);
}

}  // namespace soak::station
