// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/result.h"
#include "station/jobs/job_runner.h"
#include "station/setup/settings_change.h"

namespace soak::station {

/// The station that serves, for whoever changes its settings.
struct StationInUse {
  std::function<base::Status()> hold;  ///< nothing begins any more; refuses while something is under way
  std::function<void()> end_hold;      ///< it may again
  std::function<void()> begin_anew;    ///< the station ends, and begins with the file as it is now
  std::function<void(const std::string& text, const std::string& user)> note;  ///< in the event log
};

/// Changes of a station's configuration from its page (docs/http-api.md, "Settings of the station"). It outlives the
/// station, which begins anew with each of them; one with which it does not begin is taken back. Any thread may call.
class SettingsDesk {
 public:
  /// `file`: the configuration.
  explicit SettingsDesk(std::filesystem::path file) : file_(std::move(file)) {}

  /// GET /api/v1/station.
  [[nodiscard]] base::Result<nlohmann::json> document() const;
  /// What would change, and the mistakes in it. Refuses (bad_input) what setup_form_of() refuses, and (where ==
  /// "state") a file that is another one by now, or cannot be changed here.
  [[nodiscard]] base::Result<nlohmann::json> check(const nlohmann::json& body) const;
  /// Sends a test over each way that was entered.
  [[nodiscard]] base::Result<nlohmann::json> tell(const nlohmann::json& body);
  /// Writes the file, where neither campaign nor job is under way; answered() lets the station begin anew. Refuses as
  /// check() does, the first mistake, nothing to change, and what `jobs` and StationInUse::hold refuse.
  [[nodiscard]] base::Result<nlohmann::json> write(const nlohmann::json& body, JobRunner& jobs);
  /// Whoever had the file written has the answer.
  void answered();

  /// A station is about to serve with that text of the file, and may ask from here on.
  void open(StationInUse station, std::string text);
  /// It does: what was written before is good.
  void serves();
  /// It ends: what is being sent is broken off.
  void close();
  /// Whether a file was written that no station serves with yet.
  [[nodiscard]] bool is_changing() const;
  /// Puts the file back that was there before the change, since the station does not begin with that, unless somebody
  /// else has changed it since; who made it.
  [[nodiscard]] base::Result<std::string> take_back(const std::string& why);

 private:
  struct Change {
    std::string old_text;
    std::string new_text;
    std::string user;
  };
  struct Trouble {
    double utc_s = 0.0;
    std::string user;
    std::string text;
  };
  /// The file and what is entered in it.
  struct Present {
    std::string text;
    SetupForm form;
  };
  struct Entered {
    Present present;
    SetupForm form;
    SettingsDraft draft;
  };

  [[nodiscard]] base::Result<Present> present() const;
  /// Refuses (bad_input) a text that is not the one that the station works with, or is about to.
  [[nodiscard]] base::Status check_is_served(const std::string& text) const;
  [[nodiscard]] base::Result<Entered> entered(const nlohmann::json& body) const;
  [[nodiscard]] base::Status write_draft(const Entered& entered, const std::string& user);
  [[nodiscard]] std::filesystem::path folder() const { return file_.parent_path(); }

  std::filesystem::path file_;
  std::mutex write_turn_;
  std::mutex tell_turn_;
  std::atomic<bool> stop_ = false;  ///< what is being sent
  mutable std::mutex mutex_;        ///< of what follows
  StationInUse station_;
  std::string served_text_;  ///< of the file, as the station works with it
  std::optional<Change> change_;
  std::optional<Trouble> trouble_;  ///< of the last change
};

}  // namespace soak::station
