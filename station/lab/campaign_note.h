// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace soak::station {

/// What is known of a campaign when soakd ends without having brought it to its end: the one fact from which the next
/// soakd decides whether the chamber may be driven without a person.
struct CampaignNote {
  std::string campaign = {};
  /// It was carried out (not paused, asking nobody) when soakd ended, it had come on since it was started or resumed,
  /// and its procedure has on_restart = "resume".
  bool goes_on = false;
  bool outputs_off =
      false;  ///< heating and cooling had to stop at once: the chamber is not driven even to be made safe
  std::string outcome = {};  ///< what the campaign is in the safe state: "aborted" or "failed"; else empty
  std::string reason = {};   ///< of the outcome
  std::string user = {};     ///< who asked for it; empty where the station decided

  bool operator==(const CampaignNote&) const = default;
};

/// A note as a file holds it.
struct FoundNote {
  CampaignNote note = {};
  double noted_utc_s = 0.0;  ///< when it was known to be so, at last
};

/// Nothing goes on by itself after a break that was longer, by the host's clock: somebody may use the chamber
/// meanwhile.
constexpr double kLongestBreak_s = 12.0 * 3600.0;

/// What a predecessor left; an empty note, with which nothing goes on, where there is none or it cannot be read.
[[nodiscard]] FoundNote read_campaign_note(const std::filesystem::path& path);

/// Whether a campaign that was cut short at `noted_utc_s` may still go on by itself. A time in the future (a clock that
/// was set) is no better than one too long ago.
[[nodiscard]] bool is_recent_break(double noted_utc_s, double now_utc_s);

/// Keeps the note in a file of its own beside the catalog: the catalog may be locked, and what waits for it is lost
/// with a killed soakd. What a predecessor left stays as it is, with its time, until something else is kept or it is
/// withdrawn. Written, synced and renamed by a thread of its own, so that neither a slow disk delays the
/// chamber's commands nor a blocked engine an abort. What cannot be written is tried again every second; meanwhile the
/// old note is taken away where that can be done. While the campaign may go on by itself its time is renewed. Any
/// thread may call; all but wait_until_kept() return at once.
class CampaignNoteKeeper {
 public:
  static constexpr std::chrono::minutes kRenewal{10};

  explicit CampaignNoteKeeper(std::filesystem::path path, std::chrono::milliseconds renewal = kRenewal);
  CampaignNoteKeeper(const CampaignNoteKeeper&) = delete;
  CampaignNoteKeeper& operator=(const CampaignNoteKeeper&) = delete;
  /// Writes what is not written yet, in one try.
  ~CampaignNoteKeeper();

  /// What the file held at the beginning.
  [[nodiscard]] const FoundNote& found() const { return found_; }
  void keep(CampaignNote note);
  /// Nothing may go on by itself, whatever is kept from now on, until allow(). `outputs_off`: nor may heating and
  /// cooling be switched on, even to make the chamber safe.
  void withdraw(bool outputs_off = false);
  void allow();
  /// Whether the file holds the last note; waits for that.
  [[nodiscard]] bool wait_until_kept(std::chrono::milliseconds longest) const;
  /// Why the file does not hold the last note, though it has had two seconds; empty where it does.
  [[nodiscard]] std::string trouble() const;

 private:
  using Clock = std::chrono::steady_clock;

  void work();
  /// To be called with the lock held, after a change.
  void note_change();
  /// The note as it may stand in the file.
  [[nodiscard]] std::optional<CampaignNote> allowed() const;
  [[nodiscard]] std::string write(const CampaignNote& note) const;

  std::filesystem::path path_;
  std::chrono::milliseconds renewal_;
  FoundNote found_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::optional<CampaignNote> wanted_;
  std::optional<CampaignNote> kept_;  ///< as it stands in the file; nothing while it is being written
  Clock::time_point behind_since_{};  ///< where that is another
  bool is_withdrawn_ = false;
  bool is_too_hot_ = false;
  std::string trouble_;
  bool ends_ = false;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace soak::station
