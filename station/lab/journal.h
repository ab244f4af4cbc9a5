// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Writes what happens in a campaign into the catalog, in the order in which it is given, over a connection and from a
/// thread of its own: another program that holds the catalog's lock for longer than the busy time-out delays what is
/// written, never the one who gives it. What waits goes into one transaction, as far as kMostInBatch. What cannot be
/// written is tried again every second. Any thread may call.
class Journal {
 public:
  /// Names an entry; rises from one to the next.
  using Ticket = std::uint64_t;

  /// The catalog's campaign_state of a campaign.
  struct State {
    std::string campaign;
    std::string state;
    std::string reason;
    std::string user = {};  ///< who asked for it; empty where the station decided
  };

  enum class Written : std::uint8_t {
    not_yet,
    yes,
    refused,  ///< the catalog does not take it, whenever it is tried
  };

  struct Standing {
    std::size_t queued = 0;       ///< entries that are not written yet
    std::uint64_t discarded = 0;  ///< events that found no room since this program began
    double behind_s = 0.0;        ///< age of the oldest entry in the queue, host time
    std::string trouble;          ///< why the last try failed; empty after one that did not
  };

  /// Events that wait at most; further ones are not kept. Steps and states always find room: a campaign gives one and
  /// waits for it.
  static constexpr std::size_t kMostEvents = 20'000;

  static constexpr std::size_t kMostInBatch = 256;

  /// Opens the catalog of a data folder once more. `written`: called from the thread after each transaction.
  [[nodiscard]] static base::Result<std::unique_ptr<Journal>> open(const std::filesystem::path& data_folder,
                                                                   std::function<void()> written,
                                                                   std::size_t most_events = kMostEvents);
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  ~Journal() { end(); }
  /// Ends the thread and leaves what is not written yet; waits for a write that is under way, at most for the busy
  /// time-out.
  void end();

  Ticket add(db::EventRow event) { return add_entry(std::move(event)); }
  Ticket add(db::StepRow step) { return add_entry(std::move(step)); }
  Ticket add(State state) { return add_entry(std::move(state)); }

  /// What became of a step or a state.
  [[nodiscard]] Written written(Ticket ticket) const;
  /// Why the last step or state was refused.
  [[nodiscard]] std::string refusal() const;
  [[nodiscard]] Standing standing() const;
  /// Waits until all is written; false where it takes longer.
  [[nodiscard]] bool wait_until_written(std::chrono::milliseconds longest) const;

 private:
  using Row = std::variant<db::EventRow, db::StepRow, State>;
  struct Entry {
    Ticket ticket;
    Row row;
    std::chrono::steady_clock::time_point given;
  };

  Journal(db::Catalog catalog, std::function<void()> written, std::size_t most_events);
  Ticket add_entry(Row row);
  void work();
  /// False at the end. `most`: entries in the next batch.
  [[nodiscard]] bool write_batch(std::size_t& most);
  /// The oldest entries, at most `most`, as soon as there is one; none at the end.
  [[nodiscard]] std::vector<Entry> next_batch(std::size_t most) const;
  /// Writes them in one transaction, all or none. `at`: the entry that failed.
  [[nodiscard]] base::Status enter_all(const std::vector<Entry>& entries, std::size_t& at);
  /// The oldest entries are written.
  void note_written(std::size_t count);
  void note_refused(std::string why);
  void note_trouble(std::string why);
  void note_discarded();

  db::Catalog catalog_;
  std::function<void()> tell_;
  std::size_t most_events_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Entry> queue_;
  Ticket last_ = 0;
  std::set<Ticket> refused_;  ///< of steps and states
  std::string refusal_;
  std::string trouble_;
  std::uint64_t discarded_ = 0;
  std::uint64_t discarded_noted_ = 0;  ///< of them, those that an event tells of
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace soak::station
