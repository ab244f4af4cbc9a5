// SPDX-License-Identifier: Apache-2.0
#include "station/http/settings_desk.h"

#include <fmt/format.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "settings/reader.h"
#include "station/config/station_config.h"
#include "station/http/members.h"
#include "station/http/setup_documents.h"
#include "station/io/host.h"
#include "station/setup/setup_answers.h"
#include "station/setup/setup_secrets.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

tl::unexpected<base::Error> refused_now(std::string message) { return base::bad_input(std::move(message), "state"); }

/// Why the page cannot change this station: said with the file, which somebody has to edit.
std::string obstacle_of(const base::Error& error, const std::filesystem::path& file) {
  return fmt::format("{}: {}", error.where.empty() ? file.string() : error.where, error.message);
}

json kept_document(const SetupForm& form) {
  return {{"password", form.mail && !password_file_of(*form.mail).empty()},
          {"url", form.webhook.has_value()},
          {"token", form.webhook && !token_file_of(*form.webhook).empty()}};
}

/// A file is changed with an editor where soakd may not write into its folder or, of a link, into the one that it leads
/// to.
base::Status check_may_write(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path folder = std::filesystem::weakly_canonical(file, ignored).parent_path();
  const std::filesystem::path own = std::filesystem::absolute(file, ignored).parent_path();
  if (::access(folder.c_str(), W_OK) == 0 && ::access(own.c_str(), W_OK) == 0) return {};
  return base::bad_input("soakd may not write into the folder of this file: whoever may changes it with an editor",
                         file.string());
}

}  // namespace

Result<SettingsDesk::Present> SettingsDesk::present() const {
  auto text = settings::read_text(file_.string());
  if (!text) return base::forward_error(text);
  if (auto may = check_may_write(file_); !may) return base::forward_error(may);
  auto form = answers_in(*text, file_);
  if (!form) return base::forward_error(form);
  return Present{*std::move(text), *std::move(form)};
}

base::Status SettingsDesk::check_is_served(const std::string& text) const {
  const std::lock_guard lock(mutex_);
  if (text == (change_ ? change_->new_text : served_text_)) return {};
  return base::bad_input(
      "it was changed since soakd began to work with it, and what was changed is not in use: restart soakd, then "
      "change it here",
      file_.string());
}

Result<json> SettingsDesk::document() const {
  auto now = present();
  if (auto served = now ? check_is_served(now->text) : base::Status(); !served) now = base::forward_error(served);
  const KeptMaps maps = now ? KeptMaps(now->form, folder()) : KeptMaps();
  auto choices = setup_choices(file_, maps);
  if (!choices) return choices;
  const std::lock_guard lock(mutex_);
  json trouble;
  if (trouble_) trouble = {{"utc_s", trouble_->utc_s}, {"user", trouble_->user}, {"text", trouble_->text}};
  return json{{"file", file_.string()},
              {"revision", now ? json(revision_of(now->text)) : json()},
              {"obstacle", now ? json() : json(obstacle_of(now.error(), file_))},
              {"changing", change_.has_value()},
              {"trouble", std::move(trouble)},
              {"answers", now ? answers_document(now->form, maps) : json()},
              {"kept", now ? kept_document(now->form) : json()},
              {"choices", *std::move(choices)}};
}

Result<SettingsDesk::Entered> SettingsDesk::entered(const json& body) const {
  if (!body.is_object()) return base::bad_input("the body is not an object", "body");
  const auto revision = text_member(body, "revision", std::nullopt);
  if (!revision) return base::forward_error(revision);
  json answers = body;
  answers.erase("revision");
  auto now = present();
  const KeptMaps maps = now ? KeptMaps(now->form, folder()) : KeptMaps();
  auto form = setup_form_of(answers, maps);
  if (!form) return base::forward_error(form);
  if (!now) return refused_now(obstacle_of(now.error(), file_));
  if (*revision != revision_of(now->text)) {
    return refused_now(fmt::format("{} was changed by somebody else meanwhile: open this page again", file_.string()));
  }
  if (auto served = check_is_served(now->text); !served) return refused_now(obstacle_of(served.error(), file_));
  std::vector<SetupMistake> mistakes = keep_secrets(*form, now->form, folder());
  SettingsDraft draft = draft_settings(now->text, file_, now->form, *form);
  // What cannot be read is what is wrong there, not that it is missing.
  for (SetupMistake& mistake : mistakes) {
    std::erase_if(draft.mistakes, [&](const SetupMistake& other) { return other.field == mistake.field; });
    draft.mistakes.push_back(std::move(mistake));
  }
  return Entered{*std::move(now), *std::move(form), std::move(draft)};
}

Result<json> SettingsDesk::check(const json& body) const {
  const auto now = entered(body);
  if (!now) return base::forward_error(now);
  return setup_check_document(now->draft.differences, now->draft.mistakes);
}

Result<json> SettingsDesk::tell(const json& body) {
  if (auto known = only_members(body, {"mail", "webhook", "user"}); !known) return base::forward_error(known);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  auto form = setup_form_of(body);
  if (!form) return base::forward_error(form);
  const auto now = present();
  if (!now) return refused_now(obstacle_of(now.error(), file_));
  const auto mistakes = keep_secrets(*form, now->form, folder());
  if (!mistakes.empty()) return base::bad_input(mistakes[0].message, mistakes[0].field);
  const auto config = parse_station_config(now->text, file_);
  if (!config) return base::forward_error(config);
  const std::unique_lock turn(tell_turn_, std::try_to_lock);
  if (!turn.owns_lock() || stop_) return refused_now("a test is being sent already: try again when that is over");
  return send_entered(*form, config->alarms, *user, stop_);
}

Result<json> SettingsDesk::write(const json& body, JobRunner& jobs) {
  const std::lock_guard turn(write_turn_);
  const auto now = entered(body);
  if (!now) return base::forward_error(now);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  const auto& mistakes = now->draft.mistakes;
  if (!mistakes.empty()) return base::bad_input(mistakes[0].message, mistakes[0].field);
  if (now->draft.toml == now->present.text && now->draft.new_secrets.empty()) {
    return refused_now("nothing was changed: the file says so already");
  }
  if (is_changing()) return refused_now("the station is about to begin anew with other settings: wait some seconds");
  if (auto free = jobs.hold(); !free) return base::forward_error(free);
  auto written = station_.hold();
  if (written) {
    written = write_draft(*now, *user);
    if (!written) station_.end_hold();
  }
  if (!written) jobs.end_hold();
  if (!written) return base::forward_error(written);
  return json{{"file", file_.string()}, {"revision", revision_of(now->draft.toml)}};
}

base::Status SettingsDesk::write_draft(const Entered& entered, const std::string& user) {
  // Whatever somebody saved while work was being held is not written over.
  if (const auto text = settings::read_text(file_.string()); !text || *text != entered.present.text) {
    return refused_now(fmt::format("{} was changed by somebody else meanwhile: open this page again", file_.string()));
  }
  if (auto written = write_settings(file_, entered.present.text, entered.draft); !written) return written;
  {
    const std::lock_guard lock(mutex_);
    change_ = Change{entered.present.text, entered.draft.toml, user};
    trouble_.reset();
  }
  station_.note(fmt::format("settings changed on the page: {}", entered.draft.summary), user);
  log_line(fmt::format("wrote {}, the one before is {}", file_.string(), file_before(file_).string()));
  return {};
}

void SettingsDesk::answered() {
  if (is_changing()) station_.begin_anew();
}

void SettingsDesk::open(StationInUse station, std::string text) {
  {
    const std::lock_guard lock(mutex_);
    served_text_ = std::move(text);
  }
  station_ = std::move(station);
  stop_ = false;
}

void SettingsDesk::close() { stop_ = true; }

void SettingsDesk::serves() {
  const std::lock_guard lock(mutex_);
  change_.reset();
}

bool SettingsDesk::is_changing() const {
  const std::lock_guard lock(mutex_);
  return change_.has_value();
}

Result<std::string> SettingsDesk::take_back(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (const auto text = settings::read_text(file_.string()); text && *text == change_->new_text) {
    std::error_code failure;
    const auto mode = std::filesystem::status(file_, failure).permissions();
    if (failure) return base::fail(base::ErrorKind::internal, failure.message(), file_.string());
    if (auto back = write_with_mode(file_, change_->old_text, mode); !back) return base::forward_error(back);
  }
  std::string user = std::exchange(change_, std::nullopt)->user;
  trouble_ = Trouble{now_utc_s(), user, why};
  return user;
}

}  // namespace soak::station
