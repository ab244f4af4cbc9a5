// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace soak::station {

/// Temperatures over the process time of a campaign, for pages: at most some 4000 points, thinned evenly as they grow.
/// Any thread may read.
class History {
 public:
  /// Forgets everything; the units of the points to come.
  void begin(std::vector<std::string> serials);
  /// Adds a point where the last one is old enough.
  void add(double t_s, std::optional<double> chamber_c, std::optional<double> set_point_c,
           const std::vector<std::optional<double>>& units_c);
  /// {"t_s", "chamber_c", "set_point_c", "units"} of the points after `after_s`.
  [[nodiscard]] nlohmann::json document(double after_s) const;

 private:
  struct Point {
    double t_s;
    std::optional<double> chamber_c;
    std::optional<double> set_point_c;
    std::vector<std::optional<double>> units_c;
  };

  mutable std::mutex mutex_;
  std::vector<std::string> serials_;
  std::vector<Point> points_;
  double spacing_s_ = 1.0;
};

}  // namespace soak::station
