// SPDX-License-Identifier: Apache-2.0
#include "station/io/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <ctime>
#include <nlohmann/json.hpp>
#include <ostream>
#include <utility>

#include "base/text.h"

namespace soak::station {
namespace {

volatile std::sig_atomic_t interrupt_flag = 0;

void note_interrupt(int) { interrupt_flag = 1; }

bool all_finite(const nlohmann::json& node) {
  if (node.is_number_float()) return std::isfinite(node.get<double>());
  return !node.is_structured() || std::all_of(node.begin(), node.end(), all_finite);
}

std::string dumped(const nlohmann::json& document) {
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Columns of a terminal that UTF-8 text takes (one per code point).
std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// Without a terminal.
constexpr std::chrono::minutes kLineInterval{1};

/// ", done at about 14:05" if the work goes on as it did; empty while too little is done to tell.
std::string finish(std::chrono::duration<double> elapsed, double share) {
  constexpr double kToTell = 0.02;
  constexpr std::chrono::seconds kSoonest{10};
  if (share < kToTell || elapsed < kSoonest) return {};
  const auto left = std::chrono::duration_cast<std::chrono::system_clock::duration>(elapsed * (1.0 / share - 1.0));
  const std::time_t at = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now() + left);
  std::tm local{};
  ::localtime_r(&at, &local);
  return fmt::format(", done at about {:02}:{:02}", local.tm_hour, local.tm_min);
}

}  // namespace

void Output::print(std::string_view text) { out_ << text; }

void Output::flush() { out_.flush(); }

base::Status Output::print_json(const nlohmann::json& document) {
  if (!all_finite(document)) {
    return base::fail(base::ErrorKind::internal, "a result is not a finite number, so it has no JSON form");
  }
  out_ << dumped(document) << '\n';
  return {};
}

base::Status Output::print_json_list(std::string_view key, std::size_t count,
                                     const std::function<base::Result<nlohmann::json>(std::size_t)>& element) {
  out_ << fmt::format("{{\n\"{}\": [", key);
  for (std::size_t i = 0; i < count; ++i) {
    const auto document = element(i);
    if (!document) return base::forward_error(document);
    out_ << (i > 0 ? ",\n" : "\n");
    if (auto printed = print_json(*document); !printed) return printed;
  }
  out_ << "]\n}\n";
  return {};
}

void Output::note(std::string_view text) {
  end_progress();
  err_ << program_ << ": " << text << '\n';
}

void Output::print_error(const base::Error& error) {
  end_progress();
  if (json_) {
    const nlohmann::json document = {
        {"error", {{"code", static_cast<int>(error.kind)}, {"message", error.message}, {"where", error.where}}}};
    err_ << dumped(document) << '\n';
  } else if (error.where.empty()) {
    err_ << program_ << ": " << error.message << '\n';
  } else {
    err_ << program_ << ": " << error.where << ": " << error.message << '\n';
  }
}

std::function<bool(double)> Output::progress(std::string_view what) {
  using Clock = std::chrono::steady_clock;
  const auto begun = Clock::now();
  return [this, name = std::string(what), begun, told = begun, last = -1](double share) mutable {
    const double done = std::clamp(share, 0.0, 1.0);
    const int percent = static_cast<int>(100.0 * done);
    const auto now = Clock::now();
    if (tells_each_percent_) {
      if (std::exchange(last, percent) != percent) {
        err_ << fmt::format("{}: {}: {} %\n", program_, name, percent) << std::flush;
      }
      return !interrupted();
    }
    if (progress_bar_ && percent != last) {
      last = percent;
      bar_is_drawn_ = true;
      const auto filled = static_cast<std::size_t>(percent) * 40 / 100;
      err_ << fmt::format("\r{} [{:<40}] {:3} %{}", name, std::string(filled, '='), percent, finish(now - begun, done))
           << std::flush;
    }
    if (!progress_bar_ && !json_ && now - told >= kLineInterval) {
      told = now;
      err_ << fmt::format("{}: {}: {} %{}\n", program_, name, percent, finish(now - begun, done)) << std::flush;
    }
    return !interrupted();
  };
}

void Output::begin(std::string_view what) {
  if (tells_each_percent_) err_ << fmt::format("{}: {}: ...\n", program_, what) << std::flush;
}

void Output::end_progress() {
  if (bar_is_drawn_) err_ << '\n';
  bar_is_drawn_ = false;
}

void catch_signals() {
  struct sigaction action{};
  action.sa_handler = note_interrupt;
  // A second Ctrl-C ends the program the hard way.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool interrupted() { return interrupt_flag != 0; }

nlohmann::json number_or_null(double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(); }

nlohmann::json number_or_null(const std::optional<double>& value) {
  return value ? number_or_null(*value) : nlohmann::json();
}

std::string text_table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - width(row[i]), ' ');
      const bool right = base::parse_double(row[i]).has_value();
      line += (i > 0 ? "  " : "") + (right ? padding + row[i] : row[i] + padding);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

}  // namespace soak::station
