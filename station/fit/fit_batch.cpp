// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fit_batch.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <utility>

#include "calib/model/model_document.h"
#include "station/fit/fit_inputs.h"
#include "station/fit/fit_unit.h"
#include "station/fit/fleet_hysteresis.h"

namespace soak::station {
namespace {

/// What became of a unit in its turn.
enum class Turn { done, deferred };

/// A thread's own connection, and what it knows of check standards.
struct Worker {
  explicit Worker(db::Catalog opened) : catalog(std::move(opened)), checks(catalog) {}
  db::Catalog catalog;
  CheckWarnings checks;
};

class Batch {
 public:
  Batch(const db::Catalog& catalog, const std::vector<std::string>& serials, const BatchOptions& options,
        const std::function<bool(double)>& progress)
      : catalog_(catalog), options_(options), progress_(progress) {
    for (const std::string& serial : serials) units_.push_back({.serial = serial, .failure = {}});
  }

  BatchResult run() {
    base::Status ended = fit_all();
    return {std::move(units_), std::move(ended)};
  }

 private:
  base::Status fit_all() {
    std::vector<std::size_t> all(units_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    auto first = in_parallel(all, [this](Worker& worker, std::size_t i) { return fit_or_defer(worker, i); });
    if (!first) return first;
    const std::vector<std::size_t> last = std::exchange(deferred_, {});
    if (options_.shard) {
      for (const std::size_t i : last) units_[i].waits_for_fleet = true;
      return {};
    }
    for (const std::size_t i : last) without_.insert(units_[i].serial);
    return in_parallel(last, [this](Worker& worker, std::size_t i) { return fit_with_fleet(worker, i); });
  }

  /// `take_turn` with each of the units, on the first free thread. Fails where the batch ended before its time.
  template <class TakeTurn>
  base::Status in_parallel(const std::vector<std::size_t>& units, const TakeTurn& take_turn) {
    const auto most = options_.jobs > 0 ? static_cast<std::size_t>(options_.jobs)
                                        : std::max<std::size_t>(1, std::thread::hardware_concurrency());
    threads_per_unit_ = static_cast<int>(std::max<std::size_t>(1, most / std::max<std::size_t>(1, units.size())));
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
      auto own = options_.shard ? db::Catalog::open_unchanged(catalog_.data_folder())
                                : db::Catalog::open(catalog_.data_folder());
      if (!own) return end_with(own.error());
      Worker worker(*std::move(own));
      worker.catalog.act_as(options_.user);
      for (std::size_t k = next++; k < units.size() && goes_on(); k = next++) {
        note(units[k], guarded([&] { return take_turn(worker, units[k]); }));
      }
    };
    std::vector<std::jthread> pool;
    for (std::size_t t = 1; t < std::min(most, units.size()); ++t) pool.emplace_back(work);
    work();
    pool.clear();
    return end_;
  }

  /// A unit on which a library throws does not take the others with it.
  template <class Work>
  static base::Result<Turn> guarded(const Work& work) {
    try {
      return work();
    } catch (const std::exception& error) {
      return base::fail(base::ErrorKind::internal, error.what());
    }
  }

  void end_with(const base::Error& error) {
    const std::lock_guard lock(mutex_);
    if (end_) end_ = tl::unexpected<base::Error>(error);
  }

  bool goes_on() {
    const std::lock_guard lock(mutex_);
    return end_.has_value() && tell_progress();
  }

  /// With the lock held.
  bool tell_progress() {
    if (!progress_(done_ / static_cast<double>(units_.size())) && end_) {
      end_ = base::fail(base::ErrorKind::internal,
                        options_.shard ? "interrupted; no shard was written"
                                       : "interrupted; the models of the units fitted so far are stored, and the next "
                                         "'soak fit --all' goes on with the others",
                        "fit");
    }
    return end_.has_value();
  }

  void note(std::size_t unit, const base::Result<Turn>& turn) {
    const std::lock_guard lock(mutex_);
    const bool is_deferred = turn && *turn == Turn::deferred;
    if (is_deferred) deferred_.push_back(unit);
    // A unit that takes two turns is half done after the first.
    done_ += is_deferred || without_.contains(units_[unit].serial) ? 0.5 : 1.0;
    units_[unit].done = turn && !is_deferred;
    // What failed because the user stopped the batch is no failure of the unit.
    if (tell_progress() && !turn) units_[unit].failure = turn.error();
  }

  /// What a unit would be fitted to, and the newest model if that was made of the same.
  struct Inputs {
    std::vector<calib::ModelTerm> terms;
    FitInputs seen;
    std::optional<calib::Calibration> newest;
  };

  base::Result<Inputs> inputs_of(const db::Catalog& catalog, const std::string& serial) const {
    const auto unit = catalog.unit(serial);
    if (!unit) return base::forward_error(unit);
    Inputs inputs;
    auto terms = accepted_terms(catalog, serial, *unit ? (*unit)->epoch : 0);
    if (!terms) return base::forward_error(terms);
    inputs.terms = *std::move(terms);
    auto digest = fit_inputs_now(catalog, serial, options_.campaign, inputs.terms, options_.fit);
    if (!digest) return base::forward_error(digest);
    inputs.seen = *std::move(digest);
    const auto model = catalog.model(serial);
    if (!model) return base::forward_error(model);
    if (!*model) return inputs;
    const auto origin = catalog.model_origin(serial, (*model)->version);
    if (!origin) return base::forward_error(origin);
    if (!*origin || (*origin)->inputs_sha256 != inputs.seen.sha256) return inputs;
    auto calibration = calib::calibration_of((*model)->document);
    if (!calibration) return base::forward_error(calibration);
    inputs.newest = *std::move(calibration);
    return inputs;
  }

  base::Result<PreparedFit> prepare(Worker& worker, const std::string& serial, const Inputs& inputs) const {
    std::vector<calib::Warning> warnings;
    auto input = load_unit(worker.catalog, serial, options_.campaign, warnings);
    if (!input) return base::forward_error(input);
    return prepare_fit(worker.catalog, *std::move(input), inputs.terms, worker.checks, std::move(warnings));
  }

  base::Result<Turn> fit(Worker& worker, const PreparedFit& prepared, const Inputs& inputs) {
    auto model = fitted_model(prepared, options_.fit, FitWork{threads_per_unit_});
    if (!model) return base::forward_error(model);
    const auto stored = options_.shard ? options_.shard(worker.catalog, *model, inputs.seen)
                                       : store_model(worker.catalog, *model, inputs.seen);
    if (stored) return Turn::done;
    // Where one model cannot be stored no other can: the time of the rest is saved.
    end_with(stored.error());
    return base::forward_error(stored);
  }

  base::Result<Turn> fit_or_defer(Worker& worker, std::size_t i) {
    const auto inputs = inputs_of(worker.catalog, units_[i].serial);
    if (!inputs) return base::forward_error(inputs);
    if (inputs->newest) {
      if (asked_fleet(*inputs->newest)) return Turn::deferred;
      units_[i].up_to_date = true;
      return Turn::done;
    }
    const auto prepared = prepare(worker, units_[i].serial, *inputs);
    if (!prepared) return base::forward_error(prepared);
    if (asks_fleet(prepared->rows)) return Turn::deferred;
    return fit(worker, *prepared, *inputs);
  }

  base::Result<Turn> fit_with_fleet(Worker& worker, std::size_t i) {
    const auto inputs = inputs_of(worker.catalog, units_[i].serial);
    if (!inputs) return base::forward_error(inputs);
    if (inputs->newest) {
      const auto shown = fleet(worker.catalog, inputs->newest->unit_type, inputs->newest->simulated);
      if (!shown) return base::forward_error(shown);
      units_[i].up_to_date = agrees(*inputs->newest, *shown);
      if (units_[i].up_to_date) return Turn::done;
    }
    auto prepared = prepare(worker, units_[i].serial, *inputs);
    if (!prepared) return base::forward_error(prepared);
    const auto shown = fleet(worker.catalog, prepared->rows.unit_type, prepared->rows.simulated);
    if (!shown) return base::forward_error(shown);
    take_from_fleet(*shown, prepared->rows);
    return fit(worker, *prepared, *inputs);
  }

  /// What the units show that do not ask themselves; looked up once.
  base::Result<FleetHysteresis> fleet(const db::Catalog& catalog, const std::string& type, bool simulated) {
    const std::lock_guard lock(fleet_mutex_);
    const auto known = fleets_.find({type, simulated});
    if (known != fleets_.end()) return known->second;
    const auto shown = hysteresis_of_fleet(catalog, type, simulated, without_);
    if (!shown) return base::forward_error(shown);
    return fleets_.emplace(std::pair(type, simulated), *shown).first->second;
  }

  const db::Catalog& catalog_;
  const BatchOptions& options_;
  const std::function<bool(double)>& progress_;
  std::vector<BatchUnit> units_;  ///< each written by the thread that has its turn
  int threads_per_unit_ = 1;
  std::mutex mutex_;  ///< of the members below
  std::vector<std::size_t> deferred_;
  double done_ = 0.0;              ///< units
  base::Status end_;               ///< why the batch ends before its time
  std::set<std::string> without_;  ///< units that ask the fleet: of the second round, read only
  std::mutex fleet_mutex_;
  std::map<std::pair<std::string, bool>, FleetHysteresis> fleets_;  ///< by type, and whether it is simulated
};

}  // namespace

BatchResult fit_batch(const db::Catalog& catalog, const std::vector<std::string>& units, const BatchOptions& options,
                      const std::function<bool(double)>& progress) {
  return Batch(catalog, units, options, progress).run();
}

}  // namespace soak::station
