// SPDX-License-Identifier: Apache-2.0
#include "station/report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "station/report/html.h"

namespace soak::station::svg {
namespace {

constexpr double kFewDecades = 1.7;  ///< with no more of them 2 and 5 are marked too

/// A coordinate: a tenth of a pixel is finer than any printer.
std::string px(double value) {
  std::string text = fmt::format("{:.1f}", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "-0" ? "0" : text;
}

/// As many decimals as the step needs.
std::string tick_text(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  std::string text = fmt::format("{:.{}f}", std::abs(value) < step * 1e-6 ? 0.0 : value, decimals);
  if (text.starts_with('-')) text.replace(0, 1, "−");
  return text;
}

std::string log_tick_text(double value) {
  if (value >= 1e-4 && value < 1e5) return fmt::format("{:g}", value);
  std::string text = fmt::format("{:.0e}", value);
  const auto minus = text.find('-');
  if (minus != std::string::npos) text.replace(minus, 1, "−");
  return text;
}

struct Tick {
  double value;
  std::string text;
};

std::vector<Tick> ticks_of(const Scale& scale, int count) {
  std::vector<Tick> list;
  const std::vector<double> values =
      scale.logarithmic ? log_ticks(scale.low, scale.high) : ticks(scale.low, scale.high, count);
  const double step = values.size() > 1 ? values[1] - values[0] : 1.0;
  for (const double value : values) {
    list.push_back({value, scale.logarithmic ? log_tick_text(value) : tick_text(value, step)});
  }
  return list;
}

std::string line_element(double x1, double y1, double x2, double y2) {
  return fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>", px(x1), px(y1), px(x2), px(y2));
}

std::string text_element(double x, double y, std::string_view anchor, std::string_view text) {
  return fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>", px(x), px(y), anchor, html::escaped(text));
}

std::string mark_path(Mark mark) {
  switch (mark) {
    case Mark::up:
      return "m0-3.4l3 5.4h-6z";
    case Mark::down:
      return "m0 3.4l3-5.4h-6z";
    case Mark::square:
      return "m-2.6-2.6h5.2v5.2h-5.2z";
    case Mark::ring:
      return "m-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0z";
    default:
      return "m-2.4 0a2.4 2.4 0 1 0 4.8 0a2.4 2.4 0 1 0-4.8 0z";
  }
}

}  // namespace

double Scale::operator()(double value) const {
  const double inside = std::clamp(value, low, high);
  const double share = logarithmic ? std::log(inside / low) / std::log(high / low) : (inside - low) / (high - low);
  return from + share * (to - from);
}

std::vector<double> ticks(double low, double high, int count) {
  // The largest 1, 2, 5 × 10^k that gives no fewer than two thirds of the count.
  const double most = 1.5 * (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  const double mantissa = most >= 5.0 * power ? 5.0 : most >= 2.0 * power ? 2.0 : 1.0;
  const double step = mantissa * power;
  std::vector<double> found;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) found.push_back(k * step);
  return found;
}

std::vector<double> log_ticks(double low, double high) {
  const bool few = std::log10(high / low) <= kFewDecades;
  std::vector<double> found;
  for (double k = std::floor(std::log10(low)); k <= std::log10(high); k += 1.0) {
    for (const double mantissa : {1.0, 2.0, 5.0}) {
      const double value = mantissa * std::pow(10.0, k);
      if ((few || mantissa == 1.0) && value >= low && value <= high) found.push_back(value);
    }
  }
  return found;
}

Panel::Panel(const Box& box, Scale x, Scale y) : box_(box), x_(x), y_(y) {
  x_.from = box.left;
  x_.to = box.right;
  y_.from = box.bottom;
  y_.to = box.top;
}

void Panel::axes(std::string_view x_name, std::string_view y_name) {
  constexpr double kPixelsPerTick = 36.0;
  svg_ += "<g class=\"grid\">";
  for (const Tick& tick : ticks_of(y_, static_cast<int>(std::max(2.0, (box_.bottom - box_.top) / kPixelsPerTick)))) {
    svg_ += line_element(box_.left, y_(tick.value), box_.right, y_(tick.value));
    svg_ += text_element(box_.left - 6, y_(tick.value) + 4, "end", tick.text);
  }
  for (const Tick& tick : ticks_of(x_, 8)) {
    svg_ += line_element(x_(tick.value), box_.top, x_(tick.value), box_.bottom + 4);
    if (!x_name.empty()) svg_ += text_element(x_(tick.value), box_.bottom + 17, "middle", tick.text);
  }
  if (!x_name.empty()) svg_ += text_element((box_.left + box_.right) / 2, box_.bottom + 34, "middle", x_name);
  svg_ += text_element(4, box_.top - 9, "start", y_name);
  svg_ += "</g>\n";
}

void Panel::band(const std::vector<Point>& low, const std::vector<Point>& high, std::string_view style) {
  std::string path;
  for (const Point& p : low) path += (path.empty() ? "M" : "L") + px(x_(p.x)) + " " + px(y_(p.y));
  for (auto p = high.rbegin(); p != high.rend(); ++p) path += "L" + px(x_(p->x)) + " " + px(y_(p->y));
  if (!path.empty()) svg_ += fmt::format("<path class=\"band {}\" d=\"{}Z\"/>\n", style, path);
}

void Panel::line(const std::vector<Point>& points, std::string_view style) {
  std::string path;
  for (const Point& p : points) path += (path.empty() ? "M" : "L") + px(x_(p.x)) + " " + px(y_(p.y));
  if (!path.empty()) svg_ += fmt::format("<path class=\"line {}\" d=\"{}\"/>\n", style, path);
}

void Panel::marks(const std::vector<Point>& points, Mark mark, std::string_view style) {
  std::string path;
  for (const Point& p : points) path += "M" + px(x_(p.x)) + " " + px(y_(p.y)) + mark_path(mark);
  if (!path.empty()) svg_ += fmt::format("<path class=\"mark {}\" d=\"{}\"/>\n", style, path);
}

void Panel::level(double y, std::string_view style) {
  svg_ += fmt::format("<path class=\"line {}\" d=\"M{} {}H{}\"/>\n", style, px(box_.left), px(y_(y)), px(box_.right));
}

std::string figure(const Drawing& drawing) {
  std::string html = fmt::format(
      "<figure>\n<svg role=\"img\" viewBox=\"0 0 {0} {1}\" aria-labelledby=\"{2}-t {2}-d\">\n<title "
      "id=\"{2}-t\">{3}</title>\n<desc id=\"{2}-d\">{4}</desc>\n{5}"
      "</svg>\n",
      px(drawing.width), px(drawing.height), drawing.id, html::escaped(drawing.title),
      html::escaped(drawing.description), drawing.content);
  html += fmt::format("<figcaption><b>{}</b>", html::escaped(drawing.title));
  if (!drawing.legend.empty()) {
    html += "<ul class=\"legend\">";
    for (const LegendEntry& entry : drawing.legend) {
      html += fmt::format("<li><span class=\"swatch {}\"></span>{}</li>", entry.swatch, html::escaped(entry.text));
    }
    html += "</ul>";
  }
  return html + "</figcaption>\n</figure>\n";
}

}  // namespace soak::station::svg
