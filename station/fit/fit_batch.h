// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/curve_fit.h"
#include "calib/model/unit_model.h"
#include "db/catalog/catalog.h"
#include "station/fit/fit_inputs.h"

namespace soak::station {

/// Where a model goes that was fitted with the thread's own connection to the catalog.
using ModelSink = std::function<base::Status(db::Catalog& catalog, calib::UnitModel& model, const FitInputs& inputs)>;

/// How a batch is fitted.
struct BatchOptions {
  std::optional<std::string> campaign;  ///< only runs of this one
  calib::CurveFitOptions fit;
  int jobs = 0;      ///< threads; 0 = one per core
  std::string user;  ///< who fits
  /// Takes the models instead of the catalog, from any thread. The catalog must then be one that nobody writes
  /// (Catalog::open_unchanged()), and units that take from the fleet are not fitted: other units' models are elsewhere.
  ModelSink shard{};
};

/// What became of one unit.
struct BatchUnit {
  std::string serial;
  bool up_to_date = false;       ///< its newest model was made of the same inputs: it was not fitted again
  bool waits_for_fleet = false;  ///< of a shard: it is fitted when the models of all shards are in one catalog
  bool done = false;             ///< it was fitted, or left alone
  std::optional<base::Error> failure;
};

/// What became of all units, also where the batch ended before its time: it did not come to those that are neither done
/// nor failed.
struct BatchResult {
  std::vector<BatchUnit> units;  ///< in the order given
  base::Status ended;            ///< fails (internal) where it was stopped, and where no catalog can be opened
};

/// Fits many units, as many at a time as there are threads, each thread with a connection of its own to the catalog.
/// Every model is stored as soon as it is there, so that a batch which was killed goes on where it stopped: a unit
/// whose newest model was made of the same inputs (fit_inputs.h) is left alone.
///
/// Units that were recorded one way and take what the fleet shows of hysteresis come last, when all others are fitted;
/// none of them counts for the fleet. So the models depend neither on the number of threads nor on the order.
///
/// `progress` gets the share that is done and returns false to stop; calls come one at a time, from any thread. Memory:
/// that of `jobs` units.
[[nodiscard]] BatchResult fit_batch(const db::Catalog& catalog, const std::vector<std::string>& units,
                                    const BatchOptions& options, const std::function<bool(double)>& progress);

}  // namespace soak::station
