// SPDX-License-Identifier: Apache-2.0
#include "station/setup/setup_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

#include "settings/reader.h"
#include "station/config/alarm_config.h"
#include "station/config/station_config.h"
#include "station/setup/setup_secrets.h"

namespace soak::station {
namespace {

using settings::Table;

/// The text has been judged already: any number is within its limits.
constexpr settings::Limits kNoLimits = {-1e9, 1e9};

constexpr const char* kSecondPasswordFile = "mail-2.password";
constexpr const char* kSecondUrlFile = "webhook-2.url";
constexpr const char* kSecondTokenFile = "webhook-2.token";

std::optional<std::string> optional_text(const Table& table, std::string_view key) {
  return table.has(key) ? std::optional(table.text(key)) : std::nullopt;
}

EnteredAddress address_in(const Table& table) {
  return {optional_text(table, "device"), table.optional_whole("baud", kNoLimits), table.text("host", ""),
          table.optional_whole("port", kNoLimits)};
}

EnteredController controller_in(const Table& table) {
  return {table.text("map"), address_in(table), table.optional_whole("unit", kNoLimits), optional_text(table, "parity"),
          table.optional_whole("stop_bits", kNoLimits)};
}

EnteredPower power_in(const Table& table) {
  EnteredPower power;
  power.from = optional_text(table, "from");
  if (table.has("usb_hubs")) power.usb_hubs = table.texts("usb_hubs");
  if (!power.from && !power.usb_hubs) power.controller = controller_in(table);
  return power;
}

EnteredSlot slot_in(const Table& table) {
  return {table.text("name"),
          address_in(table),
          table.text("unit", ""),
          table.optional_whole("power_output", kNoLimits),
          table.optional_number("supply_v", kNoLimits),
          table.optional_number("supply_limit_a", kNoLimits)};
}

EnteredMail mail_in(const Table& table) {
  EnteredMail mail;
  mail.host = table.text("host");
  mail.security = table.text("security", "starttls");
  mail.port = table.optional_whole("port", kNoLimits);
  mail.from = table.text("from");
  mail.to = table.texts("to");
  mail.user = table.text("user", "");
  mail.password_file = table.text("password_file", "");
  return mail;
}

EnteredWebhook webhook_in(const Table& table) {
  EnteredWebhook webhook;
  webhook.url = table.text("url", "");
  webhook.url_is_open = !webhook.url.empty();
  webhook.url_file = table.text("url_file", "");
  webhook.token_file = table.text("token_file", "");
  return webhook;
}

void add_place(const Table& root, SetupForm& form) {
  if (const auto site = root.table("site")) {
    form.site =
        EnteredSite{site->optional_number("latitude_deg", kNoLimits), site->optional_number("height_m", kNoLimits),
                    site->optional_number("gravity_mps2", kNoLimits)};
  }
  if (const auto room = root.table("room")) {
    form.room =
        EnteredRoom{room->optional_number("temp_c", kNoLimits), room->optional_number("dew_point_c", kNoLimits)};
  }
  if (const auto purge = root.table("purge")) form.purge_below_c = purge->number("below_c", kNoLimits);
}

/// Refuses what the form, which has one type and one protocol for all slots, cannot show.
base::Status add_slots(const Table& root, SetupForm& form, const std::filesystem::path& file) {
  for (const Table& table : root.tables("slot")) {
    const std::string type = table.text("unit_type", "");
    const std::string decoder = table.text("decoder", "xsens");
    const bool is_first = form.slots.empty();
    if (is_first) form.unit_type = type;
    if (is_first) form.decoder = decoder;
    const std::string name = table.text("name");
    if (type != form.unit_type || decoder != form.decoder) {
      return base::bad_input(
          fmt::format("slot {} is for units of another type or protocol than slot {}", name, form.slots[0].name),
          file.string());
    }
    if (table.has("usb")) {
      return base::bad_input(fmt::format("the unit in slot {} is found by the numbers of its USB adapter", name),
                             file.string());
    }
    form.slots.push_back(slot_in(table));
  }
  return {};
}

/// A name of ours for a secret, of another file than the one that is in use: the file of before still finds its own.
std::string fresh_name(const std::filesystem::path& folder, const std::string& in_use, const char* usual,
                       const char* second) {
  std::error_code unknown;
  const auto place = [&](const std::filesystem::path& name) {
    return std::filesystem::weakly_canonical(folder / name, unknown).lexically_normal();
  };
  return !in_use.empty() && place(in_use) == place(usual) ? second : usual;
}

/// Reads what is kept in a file; a mistake of that field where it cannot be.
std::string kept_in(const std::filesystem::path& file, const char* field, std::vector<SetupMistake>& mistakes) {
  auto line = read_secret_line(file);
  if (line) return *std::move(line);
  mistakes.push_back({field, fmt::format("{}: {}", line.error().where, line.error().message)});
  return {};
}

void keep_password(EnteredMail& mail, const std::optional<EnteredMail>& before, const std::filesystem::path& folder,
                   std::vector<SetupMistake>& mistakes) {
  const std::string in_use = before ? password_file_of(*before) : "";
  mail.password_file.clear();
  if (!mail.password.empty()) {
    mail.password_file = fresh_name(folder, in_use, kMailPasswordFile, kSecondPasswordFile);
  } else if (!in_use.empty() && !mail.user.empty() && before->host == mail.host && before->user == mail.user) {
    mail.password = kept_in(folder / in_use, "mail.password", mistakes);
    mail.password_file = in_use;
  }
}

void keep_webhook(EnteredWebhook& webhook, const std::optional<EnteredWebhook>& before,
                  const std::filesystem::path& folder, std::vector<SetupMistake>& mistakes) {
  const EnteredWebhook known = before.value_or(EnteredWebhook());
  const bool is_kept = webhook.url.empty() && before.has_value();
  if (is_kept && known.url_is_open) {
    webhook.url = known.url;
    webhook.url_is_open = true;
  } else if (is_kept) {
    webhook.url = kept_in(folder / known.url_file, "webhook.url", mistakes);
    webhook.url_file = known.url_file;
  } else {
    webhook.url_file = fresh_name(folder, known.url_file, kWebhookUrlFile, kSecondUrlFile);
  }
  if (!webhook.token.empty()) {
    webhook.token_file = fresh_name(folder, known.token_file, kWebhookTokenFile, kSecondTokenFile);
  } else if (is_kept && !known.token_file.empty()) {
    webhook.token = kept_in(folder / known.token_file, "webhook.token", mistakes);
    webhook.token_file = known.token_file;
  }
}

}  // namespace

base::Result<SetupForm> answers_in(std::string_view text, const std::filesystem::path& file) {
  if (const auto config = parse_station_config(text, file); !config) return base::forward_error(config);
  const auto reader = settings::Reader::parse(text, file.string());
  if (!reader) return base::forward_error(reader);
  const Table& root = reader->root();
  SetupForm form;
  form.chamber = controller_in(root.section("chamber"));
  if (const auto table = root.table("fixture")) form.fixture = controller_in(*table);
  if (const auto table = root.table("power")) form.power = power_in(*table);
  add_place(root, form);
  if (const auto alarms = root.table("alarms")) {
    if (const auto mail = alarms->table("mail")) form.mail = mail_in(*mail);
    if (const auto webhook = alarms->table("webhook")) form.webhook = webhook_in(*webhook);
  }
  if (auto slots = add_slots(root, form, file); !slots) return base::forward_error(slots);
  return form;
}

std::vector<SetupMistake> keep_secrets(SetupForm& form, const SetupForm& before, const std::filesystem::path& folder) {
  std::vector<SetupMistake> mistakes;
  if (form.mail) keep_password(*form.mail, before.mail, folder, mistakes);
  if (form.webhook) keep_webhook(*form.webhook, before.webhook, folder, mistakes);
  return mistakes;
}

}  // namespace soak::station
