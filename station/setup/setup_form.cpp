// SPDX-License-Identifier: Apache-2.0
#include "station/setup/setup_form.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "station/setup/setup_secrets.h"

namespace soak::station {
namespace {

/// Lines of a configuration under a common beginning of their fields' names.
class Lines {
 public:
  void plain(const std::string& line) { add("", line); }
  /// "[chamber]"; what follows belongs to `field`.
  void head(const std::string& line, const std::string& field) {
    if (!text_.fields.empty()) plain("");
    section_ = field;
    add(field, line);
  }
  void text(std::string_view key, std::string_view value) { put(key, key, toml_quoted(value)); }
  void texts(std::string_view key, const std::vector<std::string>& values) {
    std::string list;
    for (const std::string& value : values) list += (list.empty() ? "" : ", ") + toml_quoted(value);
    put(key, key, "[" + list + "]");
  }
  void number(std::string_view key, std::optional<double> value) {
    if (value) put(key, key, fmt::format("{}", *value));
  }
  void whole(std::string_view key, std::optional<int> value) {
    if (value) put(key, key, fmt::format("{}", *value));
  }
  /// The file that holds the member `name`, which is a secret.
  void secret(std::string_view key, std::string_view name, std::string_view file) { put(key, name, toml_quoted(file)); }
  /// A key that is entered for all sections of its kind at once.
  void common(std::string_view key, std::string_view value, std::string_view field) {
    put(key, "", toml_quoted(value));
    text_.fields.back() = field;
  }
  [[nodiscard]] SetupText take() { return std::move(text_); }

 private:
  void put(std::string_view key, std::string_view name, const std::string& value) {
    add(fmt::format("{}.{}", section_, name), fmt::format("{} = {}", key, value));
  }
  void add(std::string field, const std::string& line) {
    text_.toml += line + '\n';
    text_.fields.push_back(std::move(field));
  }

  SetupText text_;
  std::string section_;
};

void write_address(Lines& lines, const EnteredAddress& address) {
  if (address.device) {
    lines.text("device", *address.device);
    lines.whole("baud", address.baud);
    return;
  }
  lines.text("host", address.host);
  lines.whole("port", address.port);
}

void write_controller(Lines& lines, std::string_view section, const EnteredController& controller) {
  lines.head(fmt::format("[{}]", section), std::string(section));
  lines.text("map", controller.map);
  write_address(lines, controller.address);
  if (controller.address.device && controller.parity) lines.text("parity", *controller.parity);
  if (controller.address.device) lines.whole("stop_bits", controller.stop_bits);
  lines.whole("unit", controller.unit);
}

void write_power(Lines& lines, const EnteredPower& power) {
  if (!power.from && !power.usb_hubs) return write_controller(lines, "power", power.controller);
  lines.head("[power]", "power");
  if (power.from) return lines.text("from", *power.from);
  lines.texts("usb_hubs", *power.usb_hubs);
}

void write_slots(Lines& lines, const SetupForm& form) {
  for (std::size_t i = 0; i < form.slots.size(); ++i) {
    const EnteredSlot& slot = form.slots[i];
    lines.head("[[slot]]", fmt::format("slots.{}", i));
    lines.text("name", slot.name);
    write_address(lines, slot.address);
    lines.common("decoder", form.decoder, "decoder");
    if (!slot.unit.empty()) lines.text("unit", slot.unit);
    if (!form.unit_type.empty()) lines.common("unit_type", form.unit_type, "unit_type");
    lines.whole("power_output", slot.power_output);
    lines.number("supply_v", slot.supply_v);
    lines.number("supply_limit_a", slot.supply_limit_a);
  }
}

void write_site(Lines& lines, const EnteredSite& site) {
  lines.head("[site]", "site");
  lines.number("latitude_deg", site.latitude_deg);
  lines.number("height_m", site.height_m);
  lines.number("gravity_mps2", site.gravity_mps2);
}

void write_room(Lines& lines, const EnteredRoom& room) {
  lines.head("[room]", "room");
  lines.number("temp_c", room.temp_c);
  lines.number("dew_point_c", room.dew_point_c);
}

void write_mail(Lines& lines, const EnteredMail& mail) {
  lines.head("[alarms.mail]", "mail");
  lines.text("host", mail.host);
  lines.text("security", mail.security);
  lines.whole("port", mail.port);
  lines.text("from", mail.from);
  lines.texts("to", mail.to);
  if (!mail.user.empty()) lines.text("user", mail.user);
  if (const auto file = password_file_of(mail); !file.empty()) lines.secret("password_file", "password", file);
}

void write_webhook(Lines& lines, const EnteredWebhook& webhook) {
  lines.head("[alarms.webhook]", "webhook");
  if (webhook.url_is_open) {
    lines.text("url", webhook.url);
  } else {
    lines.secret("url_file", "url", url_file_of(webhook));
  }
  if (const auto file = token_file_of(webhook); !file.empty()) lines.secret("token_file", "token", file);
}

void write_alarms(Lines& lines, const SetupForm& form) {
  if (form.mail) write_mail(lines, *form.mail);
  if (form.webhook) write_webhook(lines, *form.webhook);
}

void write_purge(Lines& lines, double below_c) {
  lines.head("[purge]", "purge");
  lines.number("below_c", below_c);
}

}  // namespace

std::string toml_quoted(std::string_view text) {
  constexpr unsigned char kFirstPlain = 0x20;
  constexpr unsigned char kDelete = 0x7F;
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (byte < kFirstPlain || byte == kDelete) {
      quoted += fmt::format("\\u{:04X}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

SetupText setup_text(const SetupForm& form) {
  Lines lines;
  lines.plain("# The station, as it was set up in the browser. docs/station-config.md describes every key;");
  lines.plain(
      "# `soak doctor --config station.toml --data .`, called in this folder, checks the file and what is stored");
  lines.plain("# here. soakd reads the file when it starts.");
  write_controller(lines, "chamber", form.chamber);
  if (form.fixture) write_controller(lines, "fixture", *form.fixture);
  if (form.power) write_power(lines, *form.power);
  if (form.purge_below_c) write_purge(lines, *form.purge_below_c);
  if (form.site) write_site(lines, *form.site);
  if (form.room) write_room(lines, *form.room);
  write_alarms(lines, form);
  write_slots(lines, form);
  return lines.take();
}

SetupText controller_text(std::string_view section, const EnteredController& controller) {
  Lines lines;
  write_controller(lines, section, controller);
  return lines.take();
}

SetupText slots_text(const SetupForm& form) {
  Lines lines;
  write_slots(lines, form);
  return lines.take();
}

SetupText alarms_text(const SetupForm& form) {
  Lines lines;
  write_alarms(lines, form);
  return lines.take();
}

}  // namespace soak::station
