// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/fine_temperature.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "calib/gap/campaign/detail/thermal_nodes.h"

namespace soak::calib::gap {
namespace {

constexpr double kWorst_c = 0.1;      ///< RMS error of a temperature that counts as fine
constexpr double kSlow_c = 0.1;       ///< way from row to row up to which a change of step tells the temperature
constexpr double kHole_s = 300.0;     ///< without air
constexpr double kLeastChanges = 20;  ///< of step
constexpr double kSameThermometer_c = 1e-6;

bool reaches_plateaus(const LoggedRun& run) {
  return std::any_of(run.run.segments.begin(), run.run.segments.end(),
                     [](const Segment& segment) { return segment.plateau_c.has_value(); });
}

bool one_thermometer(const LoggedCampaign& campaign) {
  if (campaign.type.thermometers == Thermometers::per_sensor) return false;
  for (const LoggedRun& run : campaign.runs) {
    for (const Segment& segment : run.run.segments) {
      for (const Block& block : segment.blocks) {
        for (std::size_t s = 0; s < kSensorCount; ++s) {
          const bool own = std::abs(block.sensor_temp_c[s] - block.temp_c) > kSameThermometer_c;
          if (block.sensor[s].count > 0 && own) return false;
        }
      }
    }
  }
  return true;
}

/// Rows of a log with air and temperature; nothing where the air has holes, or moves in steps.
std::optional<AirAndUnit> both_of(const RunLog& log) {
  if (log.chamber_c.empty()) return std::nullopt;
  AirAndUnit both;
  for (std::size_t k = 0; k < log.t_s.size(); ++k) {
    if (!std::isfinite(log.chamber_c[k]) || !std::isfinite(log.temp_c[k])) continue;
    if (!both.t_s.empty() && log.t_s[k] - both.t_s.back() > kHole_s) return std::nullopt;
    both.t_s.push_back(log.t_s[k]);
    both.air_c.push_back(log.chamber_c[k]);
    both.unit_c.push_back(log.temp_c[k]);
  }
  if (both.t_s.empty()) return std::nullopt;
  const SampleFacts air = sample_facts(both.air_c);
  if (air.step && *air.step >= kCoarseStep_c) return std::nullopt;
  return both;
}

/// The first of the boundaries between two steps, as their readings lie on the lattice: readings of bins that hold two
/// of them scatter about the others' phase.
double boundary_of(const std::vector<AirAndUnit>& runs, double step_c) {
  std::complex<double> sum;
  for (const AirAndUnit& run : runs) {
    for (const double c : run.unit_c) sum += std::polar(1.0, 2.0 * std::numbers::pi * c / step_c);
  }
  return (std::arg(sum) / (2.0 * std::numbers::pi) + 0.5) * step_c;
}

/// What changes of step say of a temperature history. Changes of one boundary that follow each other count as one.
class Changes {
 public:
  Changes(double step_c, double boundary_c) : step_c_(step_c), boundary_c_(boundary_c) {}

  void add(const AirAndUnit& run, const std::vector<double>& history_c) {
    std::optional<double> last;
    for (std::size_t k = 1; k < history_c.size(); ++k) {
      const auto boundary = between(run.unit_c[k - 1], run.unit_c[k]);
      if (!boundary || std::abs(history_c[k] - history_c[k - 1]) > kSlow_c) continue;
      if (last && std::abs(*boundary - *last) > 0.5 * step_c_) close();
      last = boundary;
      const auto [low, high] = std::minmax(history_c[k - 1], history_c[k]);
      off_ += std::clamp(*boundary, low, high) - *boundary;
      together_ += 1.0;
    }
    close();
  }

  [[nodiscard]] double count() const { return count_; }
  [[nodiscard]] double rms() const { return std::sqrt(squares_ / count_); }

 private:
  /// The boundary that lies between two readings, if there is one only.
  [[nodiscard]] std::optional<double> between(double a_c, double b_c) const {
    const auto [low, high] = std::minmax(a_c, b_c);
    const double below = std::ceil((low - boundary_c_) / step_c_);
    const double above = std::floor((high - boundary_c_) / step_c_);
    if (below != above) return std::nullopt;
    return boundary_c_ + below * step_c_;
  }

  void close() {
    if (together_ == 0.0) return;
    squares_ += off_ * off_ / (together_ * together_);
    count_ += 1.0;
    off_ = together_ = 0.0;
  }

  double step_c_;
  double boundary_c_;
  double off_ = 0.0;
  double together_ = 0.0;
  double squares_ = 0.0;
  double count_ = 0.0;
};

/// RMS, over all rows, of how far a temperature history lies outside the step that the thermometer shows.
double outside_c(const std::vector<AirAndUnit>& runs, const ThermalNodes& nodes, double step_c) {
  double squares = 0.0;
  double rows = 0.0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (std::size_t k = 0; k < runs[r].unit_c.size(); ++k) {
      const double out = std::max(0.0, std::abs(nodes.unit_c[r][k] - runs[r].unit_c[k]) - 0.5 * step_c);
      squares += out * out;
      rows += 1.0;
    }
  }
  return std::sqrt(squares / rows);
}

/// Error of the temperature history; nothing where too little tells it.
std::optional<double> error_of(const std::vector<AirAndUnit>& runs, const ThermalNodes& nodes, double step_c) {
  Changes changes(step_c, boundary_of(runs, step_c));
  for (std::size_t r = 0; r < runs.size(); ++r) changes.add(runs[r], nodes.unit_c[r]);
  if (changes.count() < kLeastChanges) return std::nullopt;
  return std::max(changes.rms(), outside_c(runs, nodes, step_c));
}

/// Mean of the log over a block, or between the rows about its middle; the block's own where the log is empty.
double mean_over(const RunLog& log, const Block& block) {
  double sum = 0.0;
  double count = 0.0;
  std::optional<std::size_t> before;
  std::optional<std::size_t> after;
  for (std::size_t k = 0; k < log.t_s.size(); ++k) {
    if (!std::isfinite(log.temp_c[k])) continue;
    if (std::abs(log.t_s[k] - block.t_s) <= 0.5 * block.duration_s) {
      sum += log.temp_c[k];
      count += 1.0;
    }
    if (log.t_s[k] <= block.t_s) before = k;
    if (log.t_s[k] > block.t_s && !after) after = k;
  }
  if (count > 0.0) return sum / count;
  if (!before || !after) return before ? log.temp_c[*before] : after ? log.temp_c[*after] : block.temp_c;
  const double share = (block.t_s - log.t_s[*before]) / (log.t_s[*after] - log.t_s[*before]);
  return std::lerp(log.temp_c[*before], log.temp_c[*after], share);
}

}  // namespace

void refine_logs(LoggedCampaign& campaign) {
  const auto step_c = campaign.thermometer.step;
  if (!step_c || *step_c < kCoarseStep_c) return;
  if (campaign.runs.empty() || !std::all_of(campaign.runs.begin(), campaign.runs.end(), reaches_plateaus)) return;
  if (!one_thermometer(campaign)) return;
  std::vector<AirAndUnit> runs;
  for (const LoggedRun& run : campaign.runs) {
    auto both = both_of(run.log);
    if (!both) return;
    runs.push_back(*std::move(both));
  }
  const auto nodes = fit_thermal_nodes(runs, *step_c);
  if (!nodes) return;
  const auto error_c = error_of(runs, *nodes, *step_c);
  if (!error_c || !(*error_c <= kWorst_c)) return;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    RunLog& log = campaign.runs[r].log;
    std::size_t row = 0;
    for (std::size_t k = 0; k < log.t_s.size(); ++k) {
      const bool fitted = row < runs[r].t_s.size() && log.t_s[k] == runs[r].t_s[row];
      log.temp_c[k] = fitted ? nodes->unit_c[r][row++] : std::numeric_limits<double>::quiet_NaN();
    }
  }
  campaign.fine_temperature = FineTemperature{*step_c, *error_c, nodes->tau_s};
  campaign.thermometer.step.reset();
}

void refine_blocks(LoggedCampaign& campaign) {
  if (!campaign.fine_temperature) return;
  for (LoggedRun& run : campaign.runs) {
    for (Segment& segment : run.run.segments) {
      for (Block& block : segment.blocks) {
        block.temp_c = mean_over(run.log, block);
        block.sensor_temp_c.fill(block.temp_c);
      }
    }
  }
}

}  // namespace soak::calib::gap
