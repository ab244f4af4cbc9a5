// SPDX-License-Identifier: Apache-2.0
#include "station/http/setup_body.h"

#include <fmt/format.h>

#include <cstddef>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "station/config/unit_type_file.h"
#include "station/http/members.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

constexpr std::size_t kMostSlots = 64;
constexpr std::size_t kLongestSecret = 2000;  ///< addresses of webhooks carry signatures

/// An object within the body. The first refusal is kept for the end, so that members can be asked for in a row.
class Entered {
 public:
  /// `name`: of the object in the body, "slots.0"; empty = the body itself.
  Entered(const json& object, std::string name, std::optional<base::Error>& refusal)
      : object_(object), name_(std::move(name)), refusal_(refusal) {
    if (!object.is_object()) refuse({base::ErrorKind::bad_input, "the member is not an object", ""});
  }

  void only(std::initializer_list<std::string_view> known) {
    if (!object_.is_object()) return;
    if (auto members = only_members(object_, known); !members) refuse(members.error());
  }
  /// Empty where it is absent.
  std::string line(const std::string& member) {
    if (!has(member)) return "";
    auto value = line_member(object_, member, "");
    if (!value) refuse(value.error());
    return value ? *std::move(value) : std::string();
  }
  std::optional<std::string> optional_line(const std::string& member) {
    return has(member) ? std::optional(line(member)) : std::nullopt;
  }
  /// A line that nobody else may read: a refusal does not repeat it. Empty where it is absent.
  std::string secret(const std::string& member) {
    if (!has(member)) return "";
    auto value = text_member(object_, member, "");
    if (!value) refuse(value.error());
    if (!value) return "";
    const bool fits = value->size() <= kLongestSecret && (value->empty() || check_text_line(*value, member));
    if (!fits) refuse({base::ErrorKind::bad_input, "not one line of plain text, or a very long one", member});
    return fits ? *std::move(value) : std::string();
  }
  std::optional<double> number(const std::string& member) {
    if (!has(member)) return std::nullopt;
    const json& value = object_.at(member);
    if (!value.is_number()) refuse({base::ErrorKind::bad_input, "not a number", member});
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
  }
  std::optional<int> whole(const std::string& member) {
    if (!has(member)) return std::nullopt;
    const auto value = count_member(object_, member);
    if (!value) refuse(value.error());
    return value ? *value : std::nullopt;
  }
  /// The objects of a list, none where it is absent.
  std::vector<Entered> objects(const std::string& member) {
    std::vector<Entered> found;
    if (!has(member)) return found;
    const json& list = object_.at(member);
    if (!list.is_array() || list.size() > kMostSlots) {
      refuse({base::ErrorKind::bad_input, fmt::format("not a list of at most {} objects", kMostSlots), member});
      return found;
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
      found.emplace_back(list[i], fmt::format("{}.{}", full(member), i), refusal_);
    }
    return found;
  }
  std::vector<std::string> lines(const std::string& member) {
    std::vector<std::string> values;
    if (!has(member)) return values;
    const json& list = object_.at(member);
    if (!list.is_array()) refuse({base::ErrorKind::bad_input, "the member is not a list", member});
    for (const json& one : list.is_array() ? list : json::array()) {
      json object = json::object();
      object[member] = one;
      const auto value = line_member(object, member, "");
      if (!value) refuse(value.error());
      if (value) values.push_back(*value);
    }
    return values;
  }
  [[nodiscard]] bool has(const std::string& member) const {
    return object_.is_object() && object_.contains(member) && !object_.at(member).is_null();
  }
  Entered inner(const std::string& member) { return Entered(object_.at(member), full(member), refusal_); }
  void refuse(base::Error error) {
    if (refusal_) return;
    error.where = full(error.where);
    refusal_ = std::move(error);
  }

 private:
  [[nodiscard]] std::string full(const std::string& member) const {
    if (name_.empty() || member.empty()) return name_ + member;
    return name_ + "." + member;
  }

  const json& object_;
  std::string name_;
  std::optional<base::Error>& refusal_;
};

EnteredAddress address_in(Entered& entered) {
  return {entered.optional_line("device"), entered.whole("baud"), entered.line("host"), entered.whole("port")};
}

/// The file of a map that is chosen by its name; empty where none is.
std::string map_in(Entered& entered, std::string_view section, const KeptMaps& kept) {
  std::string name = entered.line("map");
  if (name.empty()) return name;
  if (const auto* map = kept.find(section); map != nullptr && map->choice == name) return map->text;
  const std::filesystem::path folder = shipped_maps(section);
  std::error_code failure;
  for (std::filesystem::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry->path().filename() == name) return entry->path().string();
  }
  entered.refuse({base::ErrorKind::bad_input, fmt::format("there is no map '{}' in {}", name, folder.string()), "map"});
  return "";
}

EnteredController controller_members(Entered& entered, std::string_view section, const KeptMaps& kept) {
  EnteredController controller;
  controller.map = map_in(entered, section, kept);
  controller.address = address_in(entered);
  controller.unit = entered.whole("unit");
  controller.parity = entered.optional_line("parity");
  controller.stop_bits = entered.whole("stop_bits");
  return controller;
}

EnteredController controller_in(Entered entered, std::string_view section, const KeptMaps& kept) {
  entered.only({"map", "device", "baud", "host", "port", "unit", "parity", "stop_bits"});
  return controller_members(entered, section, kept);
}

EnteredPower power_in(Entered entered, const KeptMaps& kept) {
  entered.only({"from", "usb_hubs", "map", "device", "baud", "host", "port", "unit", "parity", "stop_bits"});
  EnteredPower power;
  power.from = entered.optional_line("from");
  if (entered.has("usb_hubs")) power.usb_hubs = entered.lines("usb_hubs");
  power.controller = controller_members(entered, "power", kept);
  return power;
}

EnteredSlot slot_in(Entered& entered) {
  entered.only({"name", "device", "baud", "host", "port", "unit", "power_output", "supply_v", "supply_limit_a"});
  return {entered.line("name"),          address_in(entered),        entered.line("unit"),
          entered.whole("power_output"), entered.number("supply_v"), entered.number("supply_limit_a")};
}

std::optional<double> purge_in(Entered entered) {
  entered.only({"below_c"});
  return entered.number("below_c");
}

EnteredSite site_in(Entered entered) {
  entered.only({"latitude_deg", "height_m", "gravity_mps2"});
  return {entered.number("latitude_deg"), entered.number("height_m"), entered.number("gravity_mps2")};
}

EnteredRoom room_in(Entered entered) {
  entered.only({"temp_c", "dew_point_c"});
  return {entered.number("temp_c"), entered.number("dew_point_c")};
}

EnteredMail mail_in(Entered entered) {
  entered.only({"host", "security", "port", "from", "to", "user", "password"});
  return {entered.line("host"), entered.line("security"), entered.whole("port"),     entered.line("from"),
          entered.lines("to"),  entered.line("user"),     entered.secret("password")};
}

EnteredWebhook webhook_in(Entered entered) {
  entered.only({"url", "token"});
  return {.url = entered.secret("url"), .token = entered.secret("token")};
}

}  // namespace

std::filesystem::path shipped_maps(std::string_view section) {
  return shipped_procedures() / (section == "power" ? "power" : std::string(section) + "s");
}

KeptMaps::KeptMaps(const SetupForm& form, const std::filesystem::path& folder) {
  add("chamber", form.chamber.map, folder);
  if (form.fixture) add("fixture", form.fixture->map, folder);
  if (form.power) add("power", form.power->controller.map, folder);
}

void KeptMaps::add(const std::string& section, const std::string& text, const std::filesystem::path& folder) {
  if (text.empty()) return;
  const std::filesystem::path file = (folder / text).lexically_normal();
  const bool is_shipped = file.parent_path() == shipped_maps(section).lexically_normal();
  maps_[section] = {is_shipped ? file.filename().string() : text, text, file, is_shipped};
}

const KeptMaps::Map* KeptMaps::find(std::string_view section) const {
  const auto found = maps_.find(section);
  return found == maps_.end() ? nullptr : &found->second;
}

Result<SetupForm> setup_form_of(const json& body, const KeptMaps& kept) {
  std::optional<base::Error> refusal;
  Entered entered(body, "", refusal);
  entered.only({"chamber", "fixture", "power", "purge", "unit_type", "decoder", "slots", "site", "room", "mail",
                "webhook", "user"});
  SetupForm form;
  if (entered.has("chamber")) form.chamber = controller_in(entered.inner("chamber"), "chamber", kept);
  if (entered.has("fixture")) form.fixture = controller_in(entered.inner("fixture"), "fixture", kept);
  if (entered.has("power")) form.power = power_in(entered.inner("power"), kept);
  if (entered.has("purge")) form.purge_below_c = purge_in(entered.inner("purge"));
  if (entered.has("site")) form.site = site_in(entered.inner("site"));
  if (entered.has("room")) form.room = room_in(entered.inner("room"));
  if (entered.has("mail")) form.mail = mail_in(entered.inner("mail"));
  if (entered.has("webhook")) form.webhook = webhook_in(entered.inner("webhook"));
  form.unit_type = entered.line("unit_type");
  form.decoder = entered.line("decoder");
  (void)entered.line("user");
  for (Entered& slot : entered.objects("slots")) form.slots.push_back(slot_in(slot));
  if (refusal) return tl::unexpected<base::Error>(*std::move(refusal));
  return form;
}

Result<EnteredController> controller_of(const json& body, const std::string& section) {
  std::optional<base::Error> refusal;
  Entered entered(body, "", refusal);
  if (!entered.has(section)) return base::bad_input("the member is missing", section);
  EnteredController controller = controller_in(entered.inner(section), section, {});
  if (refusal) return tl::unexpected<base::Error>(*std::move(refusal));
  return controller;
}

}  // namespace soak::station
