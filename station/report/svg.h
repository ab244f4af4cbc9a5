// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace soak::station::svg {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// From what is drawn to pixels, linear or logarithmic. `low` < `high`; logarithmic: both positive.
struct Scale {
  double low = 0.0;
  double high = 1.0;
  double from = 0.0;  ///< pixel of `low`
  double to = 1.0;    ///< pixel of `high`
  bool logarithmic = false;

  /// Pixel of the value, which is clamped to low...high first.
  [[nodiscard]] double operator()(double value) const;
};

/// Numbers of one, two or five times a power of ten within low...high, about `count` of them.
[[nodiscard]] std::vector<double> ticks(double low, double high, int count);
/// Powers of ten within low...high; with 2 and 5 times those where there are few.
[[nodiscard]] std::vector<double> log_ticks(double low, double high);

enum class Mark { dot, up, down, square, ring };

struct Box {
  double left = 0.0;
  double top = 0.0;
  double right = 0.0;
  double bottom = 0.0;
};

/// One pair of axes and what is drawn between them. What lies outside is drawn at the edge. Classes are those of the
/// style sheet.
class Panel {
 public:
  Panel(const Box& box, Scale x, Scale y);

  /// Grid lines and numbers, the names of the axes; `x_name` empty: the numbers of the abscissa are left out too.
  void axes(std::string_view x_name, std::string_view y_name);
  /// Between two lines with common abscissae.
  void band(const std::vector<Point>& low, const std::vector<Point>& high, std::string_view style);
  void line(const std::vector<Point>& points, std::string_view style);
  void marks(const std::vector<Point>& points, Mark mark, std::string_view style);
  /// Across the whole panel at y.
  void level(double y, std::string_view style);

  [[nodiscard]] std::string svg() const { return svg_; }

 private:
  Box box_;
  Scale x_;
  Scale y_;
  std::string svg_;
};

/// What stands under a drawing: HTML.
struct LegendEntry {
  std::string swatch;  ///< class
  std::string text;    ///< escaped here
};

/// A drawing with what those are told who cannot see it. `id` is unique on the page.
struct Drawing {
  std::string id{};
  std::string title{};
  std::string description{};
  double width = 0.0;
  double height = 0.0;
  std::string content{};  ///< of panels
  std::vector<LegendEntry> legend{};
};
[[nodiscard]] std::string figure(const Drawing& drawing);

}  // namespace soak::station::svg
