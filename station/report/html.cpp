// SPDX-License-Identifier: Apache-2.0
#include "station/report/html.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

#include "base/text.h"

namespace soak::station::html {
namespace {

using nlohmann::json;

constexpr std::string_view kUnknown = "–";
constexpr int kDigits = 3;
/// Powers of ten between which numbers are written out.
constexpr int kLeastExponent = -5;
constexpr int kMostExponent = 8;

std::string with_true_minus(std::string text) {
  if (text.starts_with('-')) text.replace(0, 1, "−");
  return text;
}

std::string superscript(int number) {
  constexpr std::string_view kDigitTexts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : std::to_string(number)) text += c == '-' ? "⁻" : kDigitTexts[c - '0'];
  return text;
}

std::string data_element(double value, const std::string& shown) {
  return fmt::format("<data value=\"{}\">{}</data>", base::shortest(value), shown);
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      case '\'':
        html += "&#39;";
        break;
      case '\n':
        html += ' ';
        break;
      default: {
        const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
        html += control ? std::string("\uFFFD") : std::string(1, c);
      }
    }
  }
  return html;
}

std::string number_text(double value) {
  if (value == 0.0) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
  if (exponent < kLeastExponent || exponent > kMostExponent) {
    return with_true_minus(fmt::format("{:.2f}", value / std::pow(10.0, exponent))) + "×10" + superscript(exponent);
  }
  return with_true_minus(fmt::format("{:.{}f}", value, std::max(0, kDigits - 1 - exponent)));
}

std::string number(double value) { return data_element(value, number_text(value)); }

std::string number(double value, int decimals) {
  return data_element(value, with_true_minus(fmt::format("{:.{}f}", value, decimals)));
}

std::string number(const json& value) {
  return value.is_number() ? number(value.get<double>()) : std::string(kUnknown);
}

std::string text_of(const json& object, std::string_view key) {
  const json& value = member(object, key);
  if (value.is_null()) return std::string(kUnknown);
  if (value.is_string()) return escaped(value.get<std::string>());
  return escaped(value.dump());
}

const json& member(const json& object, std::string_view key) {
  static const json kNull;
  const auto found = object.is_object() ? object.find(std::string(key)) : object.end();
  return found == object.end() ? kNull : *found;
}

std::string date_time(const json& utc_s) {
  if (!utc_s.is_number()) return std::string(kUnknown);
  return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(static_cast<std::time_t>(std::floor(utc_s.get<double>()))));
}

std::string duration(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

std::string unit_text(std::string_view unit) {
  std::string text = escaped(unit);
  if (text == "deg") return "°";
  const auto replace = [&](std::string_view from, std::string_view to) {
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
      text.replace(at, from.size(), to);
    }
  };
  replace("deg/", "°/");
  replace("m/s2", "m/s²");
  replace("sqrt(Hz)", "√Hz");
  replace("sqrt(s)", "√s");
  return text;
}

std::string said(std::string_view text) {
  constexpr std::string_view kBegin = " ('soak ";
  constexpr std::string_view kEnd = "')";
  std::string plain(text);
  for (auto at = plain.find(kBegin); at != std::string::npos; at = plain.find(kBegin)) {
    const auto end = plain.find(kEnd, at);
    if (end == std::string::npos) break;
    plain.erase(at, end + kEnd.size() - at);
  }
  return unit_text(plain);
}

Cell text_cell(std::string_view text) { return {escaped(text)}; }

Cell row_heading(std::string_view text) { return {.html = escaped(text), .heading = true}; }

Cell number_cell(const json& value) { return {.html = number(value), .number = true}; }

Cell html_cell(std::string html, bool number) { return {.html = std::move(html), .number = number}; }

Table::Table(std::string_view caption, const std::vector<std::string>& headings, Narrow narrow)
    : narrow_(narrow), head_(fmt::format("<caption>{}</caption>\n<thead><tr>", escaped(caption))) {
  for (const std::string& heading : headings) {
    headings_.push_back(escaped(heading));
    head_ += fmt::format("<th scope=\"col\">{}</th>", headings_.back());
  }
  head_ += "</tr></thead>\n";
}

void Table::row(const std::vector<Cell>& cells) {
  rows_ += "<tr>";
  std::size_t column = 0;
  for (const Cell& cell : cells) {
    const std::string style = std::string(cell.number ? "n " : "") + cell.style;
    std::string attribute = style.empty() ? "" : fmt::format(" class=\"{}\"", style);
    if (narrow_ == Narrow::stacks) attribute += fmt::format(" data-heading=\"{}\"", headings_.at(column));
    ++column;
    rows_ += cell.heading ? fmt::format("<th scope=\"row\"{}>{}</th>", attribute, cell.html)
                          : fmt::format("<td{}>{}</td>", attribute, cell.html);
  }
  rows_ += "</tr>\n";
}

std::string Table::html() const {
  const std::string begin = narrow_ == Narrow::stacks ? "<table class=\"stacks\">\n" : "<table>\n";
  return "<div class=\"wide\">" + begin + head_ + "<tbody>\n" + rows_ + "</tbody></table></div>\n";
}

std::string facts(const std::vector<std::pair<std::string, std::string>>& list) {
  std::string html = "<dl class=\"facts\">\n";
  for (const auto& [term, text] : list) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", escaped(term), text);
  }
  return html + "</dl>\n";
}

}  // namespace soak::station::html
