// SPDX-License-Identifier: Apache-2.0
#include "station/setup/setup_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <optional>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "station/io/new_file.h"

namespace soak::station {
namespace {

constexpr const char* kPart = "entered";  ///< stands for the file where a part of one is read

std::string field_of_line(const SetupText& text, std::string_view number) {
  const auto line = base::parse_int(number);
  const bool known = line && *line >= 1 && *line <= static_cast<std::int64_t>(text.fields.size());
  return known ? text.fields[static_cast<std::size_t>(*line) - 1] : std::string();
}

/// "FILE:12: what is wrong" as a mistake; nothing where the line does not begin with the file's name.
std::optional<SetupMistake> mistake_in(std::string_view line, const std::string& file, const SetupText& text) {
  const std::string beginning = file + ":";
  if (!line.starts_with(beginning)) return std::nullopt;
  const std::string_view rest = line.substr(beginning.size());
  const std::size_t colon = rest.find(": ");
  if (colon == std::string_view::npos) return std::nullopt;
  return SetupMistake{field_of_line(text, rest.substr(0, colon)), std::string(rest.substr(colon + 2))};
}

/// All that the parser says of the text, with the fields that were entered in the lines which it names.
std::vector<SetupMistake> mistakes_of(const base::Error& error, const std::string& file, const SetupText& text) {
  std::vector<SetupMistake> mistakes;
  std::string_view rest = error.message;
  const bool is_list = error.where == file && rest.find('\n') != std::string_view::npos;
  if (!is_list) {
    auto one = mistake_in(error.where + ": " + error.message, file, text);
    return {one ? *std::move(one) : SetupMistake{"", error.message}};
  }
  rest.remove_prefix(rest.find('\n') + 1);  // how many they are
  for (std::size_t end = 0; !rest.empty(); rest.remove_prefix(std::min(rest.size(), end + 1))) {
    end = std::min(rest.size(), rest.find('\n'));
    const std::string_view line = rest.substr(0, end);
    if (auto mistake = mistake_in(line, file, text)) {
      mistakes.push_back(*std::move(mistake));
    } else if (!mistakes.empty()) {
      mistakes.back().message += fmt::format("\n{}", line);  // one message may have several lines
    }
  }
  if (mistakes.empty()) mistakes.push_back({"", error.message});
  return mistakes;
}

/// Of each field the first; that something is missing in a section is said where it is known what.
void add_mistake(std::vector<SetupMistake>& mistakes, SetupMistake mistake) {
  const bool is_known = std::ranges::any_of(mistakes, [&](const SetupMistake& other) {
    return other.field == mistake.field || (!mistake.field.empty() && other.field.starts_with(mistake.field + "."));
  });
  if (!is_known) mistakes.push_back(std::move(mistake));
}

/// What the parser takes for a text although nobody has entered anything.
void add_empty(std::vector<SetupMistake>& mistakes, const std::string& field, std::string_view value) {
  if (value.empty()) add_mistake(mistakes, {field, "nothing is entered here"});
}

void add_empty_address(std::vector<SetupMistake>& mistakes, const std::string& owner, const EnteredAddress& address) {
  if (address.device) return add_empty(mistakes, owner + ".device", *address.device);
  add_empty(mistakes, owner + ".host", address.host);
}

std::vector<SetupMistake> empty_in(const std::string& section, const EnteredController& controller) {
  std::vector<SetupMistake> mistakes;
  add_empty(mistakes, section + ".map", controller.map);
  add_empty_address(mistakes, section, controller.address);
  return mistakes;
}

std::vector<SetupMistake> empty_in_slots(const SetupForm& form) {
  std::vector<SetupMistake> mistakes;
  for (std::size_t i = 0; i < form.slots.size(); ++i) {
    const std::string owner = fmt::format("slots.{}", i);
    const EnteredSlot& slot = form.slots[i];
    add_empty(mistakes, owner + ".name", slot.name);
    add_empty_address(mistakes, owner, slot.address);
    if (!slot.address.device && !slot.address.port) add_mistake(mistakes, {owner + ".port", "the port is missing"});
  }
  return mistakes;
}

/// What the parser cannot see, since it stands in files of its own.
std::vector<SetupMistake> wrong_secrets(const SetupForm& form) {
  std::vector<SetupMistake> mistakes;
  if (form.mail && !form.mail->user.empty()) add_empty(mistakes, "mail.password", form.mail->password);
  if (form.mail && !form.mail->password.empty()) add_empty(mistakes, "mail.user", form.mail->user);
  if (!form.webhook) return mistakes;
  add_empty(mistakes, "webhook.url", form.webhook->url);
  const auto fits = check_webhook_url(form.webhook->url, !form.webhook->token.empty());
  if (!fits) add_mistake(mistakes, {"webhook.url", "the address " + fits.error().message});
  return mistakes;
}

/// Two names of one serial port are one port.
bool is_same_port(const std::optional<std::string>& a, const std::optional<std::string>& b) {
  if (!a || !b || a->empty() || b->empty()) return false;
  std::error_code failure;
  return *a == *b || std::filesystem::equivalent(*a, *b, failure);
}

/// A host as it is known to everybody: names in small letters, this computer by its address.
std::string host_of(const EnteredAddress& address) {
  std::string host = address.host;
  std::ranges::transform(host, host.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return host == "localhost" ? "127.0.0.1" : host;
}

/// Whether both are at one place: one serial port, or one port of one host.
bool is_same_place(const EnteredAddress& a, const EnteredAddress& b) {
  if (a.device || b.device) return is_same_port(a.device, b.device);
  return !a.host.empty() && host_of(a) == host_of(b) && a.port.value_or(kModbusPort) == b.port.value_or(kModbusPort);
}

/// The controller that is at that place: its section; empty where none is.
std::string_view controller_at(const SetupForm& form, const EnteredAddress& address) {
  if (is_same_place(address, form.chamber.address)) return "chamber";
  if (form.fixture && is_same_place(address, form.fixture->address)) return "fixture";
  return form.power && is_same_place(address, form.power->controller.address) ? "power" : "";
}

tl::unexpected<base::Error> refused_over(const std::filesystem::path& file) {
  return base::bad_input(fmt::format("there is a file {} already: it is not written over", file.string()), "state");
}

tl::unexpected<base::Error> refused_first(const SetupMistake& mistake) {
  return base::bad_input(mistake.message, mistake.field);
}

}  // namespace

SetupCheck check_setup(const SetupForm& form, const std::filesystem::path& file) {
  const SetupText text = setup_text(form);
  SetupCheck check{text.toml, empty_in("chamber", form.chamber)};
  const auto add = [&](std::vector<SetupMistake> more) {
    for (SetupMistake& mistake : more) add_mistake(check.mistakes, std::move(mistake));
  };
  if (form.fixture) add(empty_in("fixture", *form.fixture));
  const bool has_controller = form.power && !form.power->from && !form.power->usb_hubs;
  if (has_controller) add(empty_in("power", form.power->controller));
  add_empty(check.mistakes, "unit_type", form.unit_type);
  add(empty_in_slots(form));
  add(wrong_secrets(form));
  const auto config = parse_station_config(text.toml, file);
  if (!config) add(mistakes_of(config.error(), file.string(), text));
  return check;
}

base::Result<hal::DeviceMap> entered_controller(std::string_view section, const EnteredController& controller) {
  const std::string name(section);
  if (const auto empty = empty_in(name, controller); !empty.empty()) return refused_first(empty.front());
  const SetupText text = controller_text(section, controller);
  auto map = parse_controller(text.toml, section, kPart);
  if (!map) return refused_first(mistakes_of(map.error(), kPart, text).front());
  return map;
}

base::Result<std::vector<Slot>> entered_slots(const SetupForm& form) {
  if (const auto empty = empty_in_slots(form); !empty.empty()) return refused_first(empty.front());
  SetupForm devices = form;
  for (EnteredSlot& slot : devices.slots) {
    slot.power_output.reset();  // [power] is not among the slots
    slot.supply_v.reset();
    slot.supply_limit_a.reset();
  }
  const SetupText text = slots_text(devices);
  auto slots = parse_slots(text.toml, kPart);
  if (!slots) return refused_first(mistakes_of(slots.error(), kPart, text).front());
  return slots;
}

base::Result<AlarmConfig> entered_alarms(const SetupForm& form) {
  if (const auto wrong = wrong_secrets(form); !wrong.empty()) return refused_first(wrong.front());
  const SetupText text = alarms_text(form);
  auto alarms = parse_alarms(text.toml, kPart);
  if (!alarms) return refused_first(mistakes_of(alarms.error(), kPart, text).front());
  return alarms;
}

base::Status refuse_shared_ports(const SetupForm& form) {
  for (std::size_t i = 0; i < form.slots.size(); ++i) {
    const EnteredAddress& address = form.slots[i].address;
    const std::string_view owner = controller_at(form, address);
    if (owner.empty()) continue;
    return refused_first(
        {fmt::format("slots.{}.{}", i, address.device ? "device" : "port"),
         fmt::format("the {} is at this port: nothing is sent there that is meant for a unit", owner)});
  }
  return {};
}

base::Status write_new_config(const std::filesystem::path& file, std::string_view toml,
                              const std::vector<SetupSecret>& secrets) {
  std::error_code unknown;
  if (std::filesystem::exists(file, unknown)) return refused_over(file);  // its secrets stay as they are, too
  if (auto kept = write_secrets(file.parent_path(), secrets); !kept) return kept;
  const auto written = write_new_text_file(file, toml);
  if (!written) return base::forward_error(written);
  return *written ? base::Status{} : refused_over(file);
}

}  // namespace soak::station
