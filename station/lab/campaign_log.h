// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "db/catalog/catalog.h"
#include "station/lab/journal.h"

/// What a campaign tells people: events, temperatures over time, the question that is open.
namespace soak::station {

/// What happened: to the catalog's append-only log, to the program's own log, and to those who listen. Any thread may
/// read.
class EventLog {
 public:
  /// Writes into the catalog at once.
  explicit EventLog(db::Catalog& catalog);
  /// Hands what happens to the journal, and waits for nothing.
  explicit EventLog(Journal& journal);

  /// `kind`: "campaign", "step", "device", "alarm", "unit", "segment"...; `subject`: what it is about; `user`: who
  /// asked for it, empty where the station did it by itself.
  void add(const std::string& kind, const std::string& subject, const std::string& text, const std::string& user = {});
  /// {"entries": [...]}: those with a number above `after`, at most 500, the newest where there are more.
  [[nodiscard]] nlohmann::json document(std::int64_t after) const;

 private:
  struct Entry {
    std::int64_t number;
    db::EventRow row;
  };

  explicit EventLog(std::function<void(const db::EventRow&)> store);

  std::function<void(const db::EventRow&)> store_;
  mutable std::mutex mutex_;
  std::deque<Entry> entries_;
  std::int64_t last_number_;  ///< begins at the host's clock: numbers rise from one soakd to the next
};

/// Temperatures over the process time of a campaign, for pages: at most some 8000 numbers, of more than 29 units at
/// most 256 points, thinned evenly as they grow. Any thread may read.
class TemperatureLog {
 public:
  /// Forgets everything; the units of the points to come.
  void begin(std::vector<std::string> serials);
  /// Adds a point where the last one is old enough.
  void add(double t_s, std::optional<double> chamber_c, std::optional<double> set_point_c,
           const std::vector<std::optional<double>>& units_c);
  /// {"t_s", "chamber_c", "set_point_c", "units"} of the points after `after_s`; temperatures to 0.01 °C.
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

/// The one question that the operator has to answer before the campaign goes on.
class Prompts {
 public:
  using Detail = std::variant<double, std::string, std::vector<std::string>>;
  /// What is asked: `text` for people, in English; `code` and `about` for whoever says it in another language.
  struct Question {
    std::string text;
    std::string code;                          ///< one of those in docs/http-api.md
    std::map<std::string, Detail> about = {};  ///< the members that go with the code, by name
  };
  struct Prompt : Question {
    std::int64_t id = 0;
  };

  void ask(Question question);
  /// Whether the open prompt was answered; closes it then.
  [[nodiscard]] bool take_answer();
  /// Answers the prompt of that number; false where it is not the open one.
  bool answer(std::int64_t id);
  void withdraw() { open_.reset(); }
  [[nodiscard]] const std::optional<Prompt>& open() const { return open_; }

 private:
  std::optional<Prompt> open_;
  bool answered_ = false;
  std::int64_t last_id_ = 0;
};

}  // namespace soak::station
