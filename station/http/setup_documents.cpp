// SPDX-License-Identifier: Apache-2.0
#include "station/http/setup_documents.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "station/alarms/alarm_message.h"
#include "station/alarms/delivery.h"
#include "station/config/unit_type_file.h"
#include "station/io/host.h"
#include "station/setup/setup_choices.h"
#include "station/setup/setup_secrets.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

json port_choices() {
  json ports = json::array();
  for (const SerialPort& port : serial_ports("/dev", "/sys/class/tty")) {
    ports.push_back({{"device", port.device}, {"node", port.node}});
  }
  return ports;
}

Result<json> type_choices() {
  const auto types = read_unit_types(default_unit_type_folder());
  if (!types) return base::forward_error(types);
  json list = json::array();
  for (const calib::UnitType& type : *types) {
    list.push_back({{"name", type.name}, {"description", type.description}});
  }
  return list;
}

/// Maps of one kind that can be chosen.
json maps_of(const std::string& section, const KeptMaps& kept) {
  json maps = map_choices(shipped_maps(section));
  const auto* own = kept.find(section);
  if (own == nullptr || own->is_shipped) return maps;
  if (json choice = map_choice(own->file, own->choice); !choice.is_null()) maps.push_back(std::move(choice));
  return maps;
}

template <class Value>
void put(json& object, const char* member, const std::optional<Value>& value) {
  if (value) object[member] = *value;
}

void put_address(json& object, const EnteredAddress& address) {
  if (address.device) {
    object["device"] = *address.device;
    put(object, "baud", address.baud);
    return;
  }
  object["host"] = address.host;
  put(object, "port", address.port);
}

json controller_document(const std::string& section, const EnteredController& controller, const KeptMaps& kept) {
  const auto* map = kept.find(section);
  json object = {{"map", map == nullptr ? controller.map : map->choice}};
  put_address(object, controller.address);
  put(object, "unit", controller.unit);
  put(object, "parity", controller.parity);
  put(object, "stop_bits", controller.stop_bits);
  return object;
}

json power_document(const EnteredPower& power, const KeptMaps& kept) {
  if (power.from) return {{"from", *power.from}};
  if (power.usb_hubs) return {{"usb_hubs", *power.usb_hubs}};
  return controller_document("power", power.controller, kept);
}

json slot_document(const EnteredSlot& slot) {
  json object = {{"name", slot.name}};
  put_address(object, slot.address);
  if (!slot.unit.empty()) object["unit"] = slot.unit;
  put(object, "power_output", slot.power_output);
  put(object, "supply_v", slot.supply_v);
  put(object, "supply_limit_a", slot.supply_limit_a);
  return object;
}

json mail_document(const EnteredMail& mail) {
  json object = {{"host", mail.host}, {"security", mail.security}, {"from", mail.from}, {"to", mail.to}};
  put(object, "port", mail.port);
  if (!mail.user.empty()) object["user"] = mail.user;
  return object;
}

void put_place(json& document, const SetupForm& form) {
  if (form.site) {
    json site = json::object();
    put(site, "latitude_deg", form.site->latitude_deg);
    put(site, "height_m", form.site->height_m);
    put(site, "gravity_mps2", form.site->gravity_mps2);
    document["site"] = std::move(site);
  }
  if (form.room) {
    json room = json::object();
    put(room, "temp_c", form.room->temp_c);
    put(room, "dew_point_c", form.room->dew_point_c);
    document["room"] = std::move(room);
  }
  if (form.purge_below_c) document["purge"] = {{"below_c", *form.purge_below_c}};
}

}  // namespace

Result<json> setup_choices(const std::filesystem::path& file, const KeptMaps& kept) {
  auto types = type_choices();
  if (!types) return types;
  return json{{"file", file.string()},
              {"chambers", maps_of("chamber", kept)},
              {"fixtures", maps_of("fixture", kept)},
              {"powers", maps_of("power", kept)},
              {"ports", port_choices()},
              {"types", *std::move(types)}};
}

json setup_check_document(const std::string& text, const std::vector<SetupMistake>& mistakes) {
  json list = json::array();
  for (const SetupMistake& mistake : mistakes) {
    list.push_back({{"field", mistake.field}, {"message", mistake.message}});
  }
  return {{"text", text}, {"mistakes", std::move(list)}};
}

json answers_document(const SetupForm& form, const KeptMaps& kept) {
  json document = {{"chamber", controller_document("chamber", form.chamber, kept)},
                   {"unit_type", form.unit_type},
                   {"decoder", form.decoder}};
  if (form.fixture) document["fixture"] = controller_document("fixture", *form.fixture, kept);
  if (form.power) document["power"] = power_document(*form.power, kept);
  put_place(document, form);
  json slots = json::array();
  for (const EnteredSlot& slot : form.slots) slots.push_back(slot_document(slot));
  document["slots"] = std::move(slots);
  if (form.mail) document["mail"] = mail_document(*form.mail);
  if (form.webhook) document["webhook"] = json::object();
  return document;
}

Result<json> send_entered(const SetupForm& form, const std::optional<AlarmConfig>& known, const std::string& user,
                          const std::atomic<bool>& stop) {
  if (!form.mail && !form.webhook) return base::bad_input("neither mail nor webhook is entered", "mail");
  auto alarms = entered_alarms(form);
  if (!alarms) return base::forward_error(alarms);
  if (known && known->mail && alarms->mail) alarms->mail->certificate = known->mail->certificate;
  if (known && known->webhook && alarms->webhook) alarms->webhook->certificate = known->webhook->certificate;
  const AlarmMessage message = message_of("test", fmt::format("A test by {}: nothing is wrong", user), place_now(""));
  json ways = json::array();
  for (const auto& delivery : deliveries_of(*alarms, alarm_secrets_of(form))) {
    const base::Status sent = delivery->send(message, stop);
    ways.push_back({{"way", delivery->way()},
                    {"to", delivery->destination()},
                    {"trouble", sent ? json() : json(one_line(sent.error().message))}});
  }
  return json{{"ways", std::move(ways)}};
}

}  // namespace soak::station
