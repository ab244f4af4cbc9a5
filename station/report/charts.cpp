// SPDX-License-Identifier: Apache-2.0
#include "station/report/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "station/report/html.h"
#include "station/report/svg.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;
using svg::Mark;
using svg::Panel;
using svg::Point;

constexpr double kWidth = 520.0;
constexpr double kHeight = 340.0;
constexpr double kLeft = 66.0;
constexpr double kRight = kWidth - 12.0;
constexpr double kTop = 26.0;
constexpr double kBottom = kHeight - 42.0;
constexpr std::size_t kColours = 8;
constexpr std::size_t kMostInLegend = 12;
/// A band wider than this times what else there is to see is cut off at the frame.
constexpr double kWidestBand = 3.0;

/// Grows to hold what it is told.
class Range {
 public:
  void take(double value) {
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  void take_all(const std::vector<Point>& points) {
    for (const Point& point : points) take(point.y);
  }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double span() const { return high_ - low_; }
  /// With some room at both ends.
  [[nodiscard]] svg::Scale scale() const {
    if (low_ > high_) return {0.0, 1.0};
    const double room = span() > 0.0 ? 0.06 * span() : std::max(std::abs(low_) * 0.1, 1e-6);
    return {low_ - room, high_ + room};
  }

 private:
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

std::vector<Point> curve_points(const json& sensor, const char* key) {
  std::vector<Point> points;
  for (const json& point : sensor["fit"]["curve"]) {
    if (point[key].is_number()) points.push_back({point["temp_c"], point[key]});
  }
  return points;
}

std::vector<Point> shifted(const std::vector<Point>& points, const std::vector<Point>& by, double sign) {
  std::vector<Point> result;
  for (std::size_t i = 0; i < by.size(); ++i) result.push_back({points[i].x, points[i].y + sign * by[i].y});
  return result;
}

std::vector<Point> zeros(const std::vector<Point>& points) {
  std::vector<Point> result;
  for (const Point& point : points) result.push_back({point.x, 0.0});
  return result;
}

std::vector<Point> row_points(const json& rows, const char* key) {
  std::vector<Point> points;
  for (const json& row : member(rows, "points")) points.push_back({row["temp_c"], row[key]});
  return points;
}

/// Takes a band where it leaves the rest to be seen.
void take_band(Range& range, const std::vector<Point>& low, const std::vector<Point>& high) {
  Range band = range;
  band.take_all(low);
  band.take_all(high);
  if (range.span() <= 0.0 || band.span() <= kWidestBand * range.span()) range = band;
}

void draw_bands(Panel& panel, const std::vector<Point>& curve, const std::vector<Point>& ci95,
                const std::vector<Point>& pi95) {
  panel.band(shifted(curve, pi95, -1.0), shifted(curve, pi95, 1.0), "pi95");
  panel.band(shifted(curve, ci95, -1.0), shifted(curve, ci95, 1.0), "ci95");
}

Mark mark_of(const json& sweep) { return sweep == "up" ? Mark::up : sweep == "down" ? Mark::down : Mark::dot; }

/// The rows, one path for each run and sweep.
void draw_rows(Panel& panel, const json& rows, const char* key) {
  std::map<std::pair<std::size_t, std::string>, std::vector<Point>> groups;
  for (const json& row : member(rows, "points")) {
    groups[{row["run"], row["sweep"]}].push_back({row["temp_c"], row[key]});
  }
  for (const auto& [group, points] : groups) panel.marks(points, mark_of(group.second), colour(group.first));
}

void draw_fresh(Panel& panel, const json& fresh) { panel.marks(row_points(fresh, "residual"), Mark::square, "fresh"); }

svg::Scale temperature_scale(const json& sensor) {
  const double low = sensor["fit"]["temp_min_c"];
  const double high = sensor["fit"]["temp_max_c"];
  const double room = std::max(1.0, 0.02 * (high - low));
  return {low - room, high + room};
}

void add_runs(std::vector<svg::LegendEntry>& legend, const json& rows) {
  const json& runs = member(rows, "runs");
  for (std::size_t r = 0; r < std::min(runs.size(), kMostInLegend); ++r) {
    legend.push_back({"run " + colour(r), runs[r].get<std::string>()});
  }
  if (runs.size() > kMostInLegend)
    legend.push_back({"none", fmt::format("and {} runs more", runs.size() - kMostInLegend)});
  if (runs.empty()) return;
  legend.push_back({"none", "▲ heating ▼ cooling"});
  const std::size_t shown = member(rows, "points").size();
  const std::size_t total = rows["total"];
  if (shown < total) legend.push_back({"none", fmt::format("{} of {} rows drawn", shown, total)});
}

std::vector<svg::LegendEntry> band_legend(const std::vector<Point>& pi95) {
  std::vector<svg::LegendEntry> legend = {{"line curve", "deployed curve"}, {"band ci95", "95 %, mean curve"}};
  if (!pi95.empty()) legend.push_back({"band pi95", "95 %, one fresh power-on"});
  return legend;
}

std::string finished(svg::Drawing drawing, const std::string& content) {
  drawing.width = kWidth;
  drawing.height = kHeight;
  drawing.content = content;
  return svg::figure(drawing);
}

std::string unit_of(const json& sensor) { return html::unit_text(sensor["unit"].get<std::string>()); }

double largest(const std::vector<Point>& points) {
  double value = 0.0;
  for (const Point& point : points) value = std::max(value, std::abs(point.y));
  return value;
}

/// Residuals, bands and, where they are not far beyond, limits.
svg::Scale residual_scale(const json& sensor, const std::vector<Point>& ci95, const std::vector<Point>& pi95) {
  const std::vector<Point> zero = zeros(ci95);
  Range range;
  range.take(0.0);
  range.take_all(row_points(sensor["rows"], "residual"));
  range.take_all(row_points(sensor["fresh"], "residual"));
  take_band(range, shifted(zero, pi95, -1.0), shifted(zero, pi95, 1.0));
  take_band(range, shifted(zero, ci95, -1.0), shifted(zero, ci95, 1.0));
  if (const json& limit = sensor["limit"]; limit.is_number()) {
    take_band(range, {{0.0, -limit.get<double>()}}, {{0.0, limit.get<double>()}});
  }
  return range.scale();
}

bool shows_limit(const json& limit, const svg::Scale& scale) {
  return limit.is_number() && scale.low <= -limit.get<double>() && limit.get<double>() <= scale.high;
}

/// Both panels of the residual chart.
std::string residual_panels(const json& sensor, const svg::Scale& scale) {
  const json& rows = sensor["rows"];
  const std::vector<Point> ci95 = curve_points(sensor, "ci95");
  const std::vector<Point> zero = zeros(ci95);
  const double middle = (kTop + kBottom) / 2.0;
  Panel top({kLeft, kTop, kRight, middle - 14.0}, temperature_scale(sensor), scale);
  draw_bands(top, zero, ci95, curve_points(sensor, "pi95"));
  top.axes("", "row − curve, " + unit_of(sensor));
  top.level(0.0, "curve");
  if (const json& limit = sensor["limit"]; shows_limit(limit, scale)) {
    top.level(limit.get<double>(), "limit");
    top.level(-limit.get<double>(), "limit");
  }
  draw_rows(top, rows, "residual");
  draw_fresh(top, sensor["fresh"]);

  Range shape;
  shape.take(0.0);
  shape.take_all(row_points(rows, "shape_residual"));
  Panel bottom({kLeft, middle + 26.0, kRight, kBottom}, temperature_scale(sensor), shape.scale());
  bottom.axes("temperature, °C", "the same, each run's own offset removed, " + unit_of(sensor));
  bottom.level(0.0, "curve");
  draw_rows(bottom, rows, "shape_residual");
  return top.svg() + bottom.svg();
}

bool has_points(const json& document) { return member(document, "tau_s").is_array(); }

std::vector<Point> allan_points(const json& document) {
  std::vector<Point> points;
  const json& tau_s = document["tau_s"];
  for (std::size_t i = 0; i < tau_s.size(); ++i) {
    const json& value = document["oadev"][i];
    if (value.is_number() && value.get<double>() > 0.0) points.push_back({tau_s[i], value});
  }
  return points;
}

/// An end of the interval of the deviation: 0 the lower, 1 the upper. What is not known is passed over.
std::vector<Point> interval_points(const json& document, std::size_t end) {
  std::vector<Point> points;
  const json& tau_s = document["tau_s"];
  for (std::size_t i = 0; i < tau_s.size(); ++i) {
    const json& interval = document["ci95"][i];
    if (!interval[0].is_number() || !interval[1].is_number()) continue;
    points.push_back({tau_s[i], std::max(interval[end].get<double>(), 1e-12)});
  }
  return points;
}

svg::Scale log_scale(const std::vector<Point>& points, double Point::* coordinate, double room) {
  svg::Scale scale{std::numeric_limits<double>::infinity(), 0.0, 0.0, 1.0, true};
  for (const Point& point : points) {
    scale.low = std::min(scale.low, point.*coordinate / room);
    scale.high = std::max(scale.high, point.*coordinate * room);
  }
  scale.high = std::max(scale.high, scale.low * 10.0);
  return scale;
}

std::string chart_id(std::string_view name, std::string_view what) { return fmt::format("{}-{}", name, what); }

}  // namespace

std::string colour(std::size_t index) { return fmt::format("c{}", index % kColours); }

std::string curve_chart(std::string_view name, const json& sensor) {
  const std::vector<Point> curve = curve_points(sensor, "bias");
  const std::vector<Point> ci95 = curve_points(sensor, "ci95");
  const std::vector<Point> pi95 = curve_points(sensor, "pi95");
  Range range;
  range.take_all(curve);
  range.take_all(row_points(sensor["rows"], "value"));
  take_band(range, shifted(curve, pi95, -1.0), shifted(curve, pi95, 1.0));
  take_band(range, shifted(curve, ci95, -1.0), shifted(curve, ci95, 1.0));
  Panel panel({kLeft, kTop, kRight, kBottom}, temperature_scale(sensor), range.scale());
  draw_bands(panel, curve, ci95, pi95);
  panel.axes("temperature of the unit, °C", "bias, " + unit_of(sensor));
  draw_rows(panel, sensor["rows"], "value");
  panel.line(curve, "curve");
  svg::Drawing drawing{chart_id(name, "curve"), fmt::format("{}: bias over temperature", name)};
  drawing.description = fmt::format(
      "Deployed curve from {:.3g} {} at {:.1f} °C to {:.3g} at {:.1f} °C, largest half-width of its 95 % band {:.3g}.",
      curve.front().y, unit_of(sensor), curve.front().x, curve.back().y, curve.back().x, largest(ci95));
  drawing.legend = band_legend(pi95);
  add_runs(drawing.legend, sensor["rows"]);
  return finished(std::move(drawing), panel.svg());
}

std::string residual_chart(std::string_view name, const json& sensor) {
  if (sensor["rows"].is_null() && sensor["fresh"].is_null()) return {};
  svg::Drawing drawing{chart_id(name, "residuals"), fmt::format("{}: what the curve leaves over", name)};
  if (!sensor["rows"].is_null()) {
    drawing.description = fmt::format(
        "Residuals of {} rows, RMS {:.3g} {}, largest {:.3g} in run {}; with each run's offset removed RMS {:.3g}.",
        sensor["rows"]["total"].get<std::size_t>(), sensor["rows"]["rmse_abs"].get<double>(), unit_of(sensor),
        sensor["rows"]["worst_abs"].get<double>(), sensor["rows"]["worst_run"].get<std::string>(),
        sensor["rows"]["rmse_shape"].get<double>());
  }
  if (!sensor["fresh"].is_null()) drawing.legend.push_back({"square fresh", "fresh run, in no fit"});
  const svg::Scale scale = residual_scale(sensor, curve_points(sensor, "ci95"), curve_points(sensor, "pi95"));
  if (shows_limit(sensor["limit"], scale)) {
    drawing.legend.push_back({"line limit", "limit"});
  } else if (sensor["limit"].is_number()) {
    drawing.legend.push_back({"none", fmt::format("limit ±{:.3g}: beyond the drawing", sensor["limit"].get<double>())});
  }
  return finished(std::move(drawing), residual_panels(sensor, scale));
}

std::string scale_chart(std::string_view name, const json& sensor) {
  const std::vector<Point> curve = curve_points(sensor, "scale_ppm");
  if (curve.empty()) return {};
  const std::vector<Point> ci95 = curve_points(sensor, "scale_ci95_ppm");
  Range range;
  range.take_all(curve);
  range.take_all(row_points(sensor["scale_rows"], "value"));
  take_band(range, shifted(curve, ci95, -1.0), shifted(curve, ci95, 1.0));
  Panel panel({kLeft, kTop, kRight, kBottom}, temperature_scale(sensor), range.scale());
  draw_bands(panel, curve, ci95, {});
  panel.axes("temperature of the unit, °C", "scale error, ppm");
  draw_rows(panel, sensor["scale_rows"], "value");
  panel.line(curve, "curve");
  svg::Drawing drawing{chart_id(name, "scale"), fmt::format("{}: scale error over temperature", name)};
  drawing.description = fmt::format("Deployed curve from {:.4g} ppm at {:.1f} °C to {:.4g} ppm at {:.1f} °C.",
                                    curve.front().y, curve.front().x, curve.back().y, curve.back().x);
  drawing.legend = band_legend({});
  return finished(std::move(drawing), panel.svg());
}

std::string allan_chart(std::string_view kind, const json& sensors) {
  std::vector<Point> all;
  for (const auto& [name, document] : sensors.items()) {
    if (!name.starts_with(kind) || !has_points(document)) continue;
    const std::vector<Point> points = allan_points(document);
    all.insert(all.end(), points.begin(), points.end());
  }
  if (all.empty()) return {};
  const bool gyro = kind == "gyro";
  Panel panel({kLeft, kTop, kRight, kBottom}, log_scale(all, &Point::x, 1.0), log_scale(all, &Point::y, 1.4));
  panel.axes("averaging time τ, s", fmt::format("Allan deviation, {}", gyro ? "deg/s" : "m/s²"));
  svg::Drawing drawing{chart_id(kind, "allan"),
                       fmt::format("Allan deviation of the {}", gyro ? "gyros" : "accelerometers")};
  std::size_t index = 0;
  for (const auto& [name, document] : sensors.items()) {
    if (!name.starts_with(kind) || !has_points(document)) continue;
    panel.band(interval_points(document, 0), interval_points(document, 1), colour(index));
    panel.line(allan_points(document), colour(index));
    drawing.legend.push_back({"line " + colour(index), name});
    ++index;
  }
  drawing.legend.push_back({"none", "shaded: 95 %"});
  drawing.description =
      "Overlapping Allan deviation over averaging time, both axes logarithmic; the table has the noise "
      "coefficients.";
  return finished(std::move(drawing), panel.svg());
}

}  // namespace soak::station
