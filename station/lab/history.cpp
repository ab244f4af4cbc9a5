// SPDX-License-Identifier: Apache-2.0
#include "station/lab/history.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "station/io/output.h"

namespace soak::station {
namespace {

constexpr std::size_t kMostPoints = 4096;

}  // namespace

void History::begin(std::vector<std::string> serials) {
  const std::lock_guard lock(mutex_);
  serials_ = std::move(serials);
  points_.clear();
  spacing_s_ = 1.0;
}

void History::add(double t_s, std::optional<double> chamber_c, std::optional<double> set_point_c,
                  const std::vector<std::optional<double>>& units_c) {
  const std::lock_guard lock(mutex_);
  if (!points_.empty() && t_s - points_.back().t_s < spacing_s_) return;
  points_.push_back({t_s, chamber_c, set_point_c, units_c});
  if (points_.size() < kMostPoints) return;
  for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = std::move(points_[2 * i]);
  points_.resize((points_.size() + 1) / 2);
  spacing_s_ *= 2.0;
}

nlohmann::json History::document(double after_s) const {
  const std::lock_guard lock(mutex_);
  nlohmann::json t_s = nlohmann::json::array();
  nlohmann::json chamber_c = nlohmann::json::array();
  nlohmann::json set_point_c = nlohmann::json::array();
  std::vector<nlohmann::json> units(serials_.size(), nlohmann::json::array());
  for (const Point& point : points_) {
    if (point.t_s <= after_s) continue;
    t_s.push_back(point.t_s);
    chamber_c.push_back(number_or_null(point.chamber_c));
    set_point_c.push_back(number_or_null(point.set_point_c));
    for (std::size_t u = 0; u < units.size(); ++u) {
      units[u].push_back(u < point.units_c.size() ? number_or_null(point.units_c[u]) : nlohmann::json());
    }
  }
  nlohmann::json named = nlohmann::json::object();
  for (std::size_t u = 0; u < units.size(); ++u) named[serials_[u]] = std::move(units[u]);
  return {{"t_s", std::move(t_s)},
          {"chamber_c", std::move(chamber_c)},
          {"set_point_c", std::move(set_point_c)},
          {"units", std::move(named)}};
}

}  // namespace soak::station
