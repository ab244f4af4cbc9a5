// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace soak::station {

/// What is known of a campaign when soakd ends without having brought it to its end: the one fact from which the next
/// soakd decides whether the chamber may be driven without a person.
struct CampaignNote {
  std::string campaign = {};
  /// It was carried out (not paused, asking nobody) when soakd ended, it had come on since it was started or resumed,
  /// and its procedure has on_restart = "resume".
  bool goes_on = false;
  std::string outcome = {};  ///< what the campaign is to be in the safe state: "aborted" or "failed"; else empty
  std::string reason = {};   ///< of the outcome
  std::string user = {};     ///< who asked for it; empty where the station decided

  bool operator==(const CampaignNote&) const = default;
};

/// Keeps the note in a file of its own beside the catalog: the catalog may be locked, and what waits for it is lost
/// with a killed soakd.
class CampaignNoteFile {
 public:
  explicit CampaignNoteFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// What the predecessor left; an empty note, with which nothing goes on, where there is none or it cannot be read.
  [[nodiscard]] CampaignNote read() const;
  /// Returns once it survives a loss of power. Where it cannot be written (a full disk) the file is taken away: nothing
  /// goes on by itself then.
  void keep(const CampaignNote& note) const;

 private:
  std::filesystem::path path_;
};

}  // namespace soak::station
