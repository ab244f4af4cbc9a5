// SPDX-License-Identifier: Apache-2.0
#include "station/config/station_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "base/text.h"
#include "base/units.h"
#include "settings/reader.h"
#include "station/config/config_place.h"
#include "station/config/unit_type_file.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

using settings::Table;

constexpr settings::Limits kPort = {1, 65535};
constexpr settings::Limits kBaud = {300, 4000000};

/// An error of another file, in one message of this one.
std::string foreign(const base::Error& error) {
  return error.where.empty() ? error.message : fmt::format("{}: {}", error.where, error.message);
}

std::filesystem::path path_in(const settings::Table& table, std::string_view key, const std::filesystem::path& folder) {
  const std::string text = table.text(key);
  return text.empty() ? std::filesystem::path() : (folder / text).lexically_normal();
}

/// Whether the table names a serial device; one that names both or neither way is a mistake.
bool wants_serial(const settings::Table& table) {
  const bool serial = table.has("device");
  if (serial == table.has("host")) {
    table.refuse("host", "an address needs either host and port (TCP) or device and baud (serial)");
  }
  return serial;
}

/// The address that a section gives instead of that of its map; of a serial line what it does not say is as the map
/// says.
hal::ControllerAddress read_address(const Table& table, const hal::DeviceMap& map) {
  const bool modbus = map.protocol == hal::MapProtocol::modbus;
  if (!wants_serial(table)) {
    const auto* tcp = std::get_if<hal::TcpAddress>(&map.link.address);
    std::optional<int> usual_port = tcp ? std::optional(tcp->port) : std::nullopt;
    if (modbus) usual_port = 502;
    return hal::TcpAddress{table.text("host", ""), table.whole("port", kPort, usual_port)};
  }
  const auto* stated = std::get_if<hal::SerialAddress>(&map.link.address);
  hal::SerialAddress line = stated ? *stated : hal::SerialAddress{.device = "", .baud = 9600};
  line.device = table.text("device");
  line.baud = table.whole("baud", kBaud, line.baud);
  if (!modbus) return line;
  // libmodbus takes any other for 9600.
  const std::vector<int> bauds = {1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200};
  if (std::find(bauds.begin(), bauds.end(), line.baud) == bauds.end()) {
    table.refuse("baud", fmt::format("'baud' must be one of {}", fmt::join(bauds, ", ")));
  }
  line.parity = table.choice<char>("parity", {{"N", 'N'}, {"E", 'E'}, {"O", 'O'}}, line.parity);
  line.stop_bits = table.whole("stop_bits", {1, 2}, line.stop_bits);
  return line;
}

/// The map that a section names, with the section's address.
hal::DeviceMap read_controller(const settings::Table& table, std::string_view kind,
                               const std::filesystem::path& folder) {
  const auto file = path_in(table, "map", folder);
  hal::DeviceMap map;
  if (!file.empty()) {
    auto read = hal::read_device_map(file.string(), hal::MapUse::device);
    if (!read) table.refuse("map", foreign(read.error()));
    if (read) map = *std::move(read);
  }
  map.link.address = read_address(table, map);
  if (map.protocol == hal::MapProtocol::modbus) map.link.unit = table.whole("unit", {0, 255}, map.link.unit);
  if (!map.kind.empty() && map.kind != kind) {
    table.refuse("map", fmt::format("'{}' is the map of a {}, not of a {}", file.string(), map.kind, kind));
  }
  return map;
}

std::array<std::string, 3> read_axes(const settings::Table& table, std::array<std::string, 3> axes) {
  if (!table.has("axes")) return axes;
  const auto labels = table.texts("axes");
  const bool three = labels.size() == axes.size();
  if (three) std::copy(labels.begin(), labels.end(), axes.begin());
  if (!three || !is_right_handed(axes)) {
    table.refuse("axes", "'axes' must be three of +X, -X, +Y, -Y, +Z, -Z that form a right-handed frame");
  }
  return axes;
}

/// "2639:0013": vendor and product as lsusb prints them.
void read_usb_ids(const settings::Table& table, hal::UsbAddress& usb) {
  const std::string text = table.text("usb");
  const std::string_view digits = text;
  const auto vendor = base::bytes_of_hex<2>(digits.substr(0, 4));
  const auto product = base::bytes_of_hex<2>(digits.substr(std::min<std::size_t>(digits.size(), 5)));
  if (!vendor || !product || digits[4] != ':') {
    table.refuse("usb", "'usb' must be vendor and product in hexadecimal, four digits each, as in \"2639:0013\"");
    return;
  }
  usb.vendor = static_cast<std::uint16_t>((*vendor)[0] << 8U | (*vendor)[1]);
  usb.product = static_cast<std::uint16_t>((*product)[0] << 8U | (*product)[1]);
}

hal::UsbAddress read_usb(const settings::Table& table) {
  hal::UsbAddress usb;
  read_usb_ids(table, usb);
  usb.serial = table.text("usb_serial", "");
  usb.path = table.text("usb_path", "");
  usb.baud = table.whole("baud", kBaud, usb.baud);
  return usb;
}

hal::UnitAddress read_unit_address(const settings::Table& table) {
  constexpr std::array<std::string_view, 3> kWays = {"host", "device", "usb"};
  const auto ways = std::count_if(kWays.begin(), kWays.end(), [&](std::string_view way) { return table.has(way); });
  if (ways != 1) {
    table.refuse("host", "an address needs one of host and port (TCP), device and baud (serial), usb");
  }
  if (table.has("usb")) return read_usb(table);
  if (table.has("device")) return hal::SerialAddress{table.text("device"), table.whole("baud", kBaud, 115200)};
  const std::optional<int> no_host = table.has("host") ? std::nullopt : std::optional(0);
  return hal::TcpAddress{table.text("host", ""), table.whole("port", kPort, no_host)};
}

Slot read_slot(const settings::Table& table) {
  using enum hal::UnitDecoder;
  Slot slot;
  slot.name = table.text("name");
  slot.address = read_unit_address(table);
  slot.decoder = table.choice<hal::UnitDecoder>(
      "decoder", {{"xsens", xsens}, {"ahrs400", ahrs400}, {"vectornav", vectornav}}, slot.decoder);
  slot.axes = read_axes(table, slot.axes);
  slot.power_output = table.optional_whole("power_output", {1, 1000});
  slot.supply.voltage_v = table.optional_number("supply_v", {0.1, 100.0});
  slot.supply.limit_a = table.optional_number("supply_limit_a", {0.001, 100.0});
  slot.unit = table.text("unit", "");
  slot.unit_type = table.text("unit_type", "");
  return slot;
}

/// The key that a slot's address is blamed on.
std::string_view address_key(const settings::Table& table) {
  if (table.has("usb")) return "usb";
  return table.has("device") ? "device" : "port";
}

/// What two slots cannot share.
class Taken {
 public:
  void check(const settings::Table& table, const Slot& slot) {
    claim(table, "name", slot.name);
    claim(table, address_key(table), hal::text_of(slot.address));
    check_usb(table, slot);
    claim(table, "unit", slot.unit);
    if (slot.power_output) claim(table, "power_output", std::to_string(*slot.power_output));
  }

 private:
  void claim(const settings::Table& table, std::string_view key, const std::string& value) {
    if (!table.has(key) || value.empty() || taken_.insert({std::string(key), value}).second) return;
    table.refuse(key, fmt::format("two slots have the {} '{}'", key == address_key(table) ? "address" : key, value));
  }

  /// Two devices of one kind must be told apart.
  void check_usb(const settings::Table& table, const Slot& slot) {
    const auto* usb = std::get_if<hal::UsbAddress>(&slot.address);
    if (usb == nullptr) return;
    const auto is_any = [](const hal::UsbAddress& address) { return address.serial.empty() && address.path.empty(); };
    for (const hal::UsbAddress& other : usb_) {
      const bool same_kind = other.vendor == usb->vendor && other.product == usb->product;
      if (!same_kind || !(is_any(other) || is_any(*usb))) continue;
      table.refuse("usb", "two slots have USB devices of this kind: give each its usb_serial or usb_path");
    }
    usb_.push_back(*usb);
  }

  std::set<std::pair<std::string, std::string>> taken_;
  std::vector<hal::UsbAddress> usb_;
};

void read_unit_type_folder(const settings::Table& root, const std::filesystem::path& folder, StationConfig& config) {
  const auto table = root.table("unit_types");
  config.unit_types = table ? path_in(*table, "folder", folder) : default_unit_type_folder();
}

/// The names of all types; a folder that cannot be read is a mistake.
std::set<std::string> type_names(const settings::Table& root, const StationConfig& config) {
  std::set<std::string> names;
  const auto types = read_unit_types(config.unit_types);
  if (!types) {
    root.refuse("unit_types", foreign(types.error()));
    return names;
  }
  for (const calib::UnitType& type : *types) names.insert(type.name);
  return names;
}

void refuse_unknown_types(const settings::Table& root, const std::vector<settings::Table>& tables,
                          const StationConfig& config) {
  const auto names_a_type = [](const Slot& slot) { return !slot.unit_type.empty(); };
  if (std::none_of(config.slots.begin(), config.slots.end(), names_a_type)) return;
  const auto names = type_names(root, config);
  if (names.empty()) return;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::string& type = config.slots[i].unit_type;
    if (type.empty() || names.contains(type)) continue;
    tables[i].refuse("unit_type", fmt::format("there is no unit type '{}' in '{}'", type, config.unit_types.string()));
  }
}

void read_slots(const settings::Table& root, StationConfig& config) {
  const auto tables = root.tables("slot");
  if (tables.empty()) root.refuse("slot", "there is no [[slot]]: a station needs at least one");
  Taken taken;
  for (const settings::Table& table : tables) {
    config.slots.push_back(read_slot(table));
    taken.check(table, config.slots.back());
    if (config.slots.back().power_output && !root.has("power")) {
      table.refuse("power_output", "'power_output' needs a section [power]");
    }
    for (const char* key : {"supply_v", "supply_limit_a"}) {
      if (table.has(key) && !table.has("power_output")) {
        table.refuse(key, fmt::format("'{}' belongs to an output: 'power_output' is missing", key));
      }
    }
  }
  refuse_unknown_types(root, tables, config);
}

void read_place(const Table& root, StationConfig& config) {
  const Table site = root.section("site");
  config.site.latitude_deg = site.optional_number("latitude_deg", {-90.0, 90.0});
  config.site.height_m = site.optional_number("height_m", {-1000.0, 10000.0});
  config.site.azimuth_deg = site.optional_number("azimuth_deg", {-360.0, 360.0});
  config.site.gravity_mps2 = site.optional_number("gravity_mps2", {9.7, 9.9});
  const Table room = root.section("room");
  config.room_c = room.number("temp_c", {0.0, 50.0}, config.room_c);
  config.dew_point_assumed = !room.has("dew_point_c");
  config.dew_point_c = room.number("dew_point_c", {-50.0, 50.0}, std::min(config.dew_point_c, config.room_c));
  if (config.dew_point_c > config.room_c) {
    room.refuse("dew_point_c", "'room.dew_point_c' cannot lie above the temperature of the room");
  }
}

/// Names as a browser sends them, without port: "lab-pc", "soak.lab.example".
std::vector<std::string> read_host_names(const settings::Table& root) {
  std::vector<std::string> names = root.texts("allowed_hosts");
  for (std::string& name : names) {
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool sound = !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '-' || c == '.';
    });
    if (sound) continue;
    root.refuse("allowed_hosts",
                "'allowed_hosts' must list names without port, as in [\"lab-pc\", \"soak.example.org\"]");
    return {};
  }
  return names;
}

void read_service(const settings::Table& root, const std::filesystem::path& folder, StationConfig& config) {
  config.listen = root.text("listen", config.listen);
  const auto colon = config.listen.rfind(':');
  const auto port = colon == std::string::npos ? std::nullopt : base::parse_int(config.listen.substr(colon + 1));
  if (colon == 0 || !port || *port < 0 || *port > 65535) {
    root.refuse("listen", "'listen' must be HOST:PORT, as in \"127.0.0.1:8088\"");
  }
  if (root.has("allowed_hosts")) config.allowed_hosts = read_host_names(root);
  if (root.has("data")) config.data = path_in(root, "data", folder);
  if (const auto tls = root.table("tls")) {
    config.tls_certificate = path_in(*tls, "certificate", folder);
    config.tls_key = path_in(*tls, "key", folder);
  }
  config.clock_rate = root.section("clock").number("rate", {0.001, 1e6}, config.clock_rate);
}

/// "1-4.2" or "usb1", as the kernel names sockets.
bool is_hub_path(std::string_view path) {
  const auto is_number = [](std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
  };
  if (path.starts_with("usb")) return is_number(path.substr(3));
  const auto dash = path.find('-');
  if (dash == std::string_view::npos || !is_number(path.substr(0, dash))) return false;
  std::string_view ports = path.substr(dash + 1);
  for (auto dot = ports.find('.'); dot != std::string_view::npos; dot = ports.find('.')) {
    if (!is_number(ports.substr(0, dot))) return false;
    ports.remove_prefix(dot + 1);
  }
  return is_number(ports);
}

hal::UsbHubs read_usb_hubs(const settings::Table& table) {
  hal::UsbHubs hubs{table.texts("usb_hubs")};
  const bool sound = !hubs.paths.empty() && std::ranges::all_of(hubs.paths, is_hub_path);
  const bool distinct = std::set(hubs.paths.begin(), hubs.paths.end()).size() == hubs.paths.size();
  if (!sound || !distinct) {
    table.refuse(
        "usb_hubs",
        "'usb_hubs' must list the ports that USB hubs are plugged into, each once, as in [\"1-4\", \"1-4.3\"]");
  }
  return hubs;
}

UnitPowerSource read_unit_power(const settings::Table& table, const std::filesystem::path& folder) {
  if (table.has("from")) {
    (void)table.choice<bool>("from", {{"chamber", true}});
    return PowerFromChamber();
  }
  if (table.has("usb_hubs")) return read_usb_hubs(table);
  return read_controller(table, "power", folder);
}

void read_controllers(const settings::Table& root, const std::filesystem::path& folder, StationConfig& config) {
  if (const auto table = root.table("chamber", settings::kRequired))
    config.chamber = read_controller(*table, "chamber", folder);
  if (const auto table = root.table("fixture")) config.fixture = read_controller(*table, "fixture", folder);
  if (const auto table = root.table("power")) config.power = read_unit_power(*table, folder);
  if (const auto table = root.table("purge")) config.purge_below_c = table->number("below_c", {-100.0, 50.0});
}

double dot(const calib::Vector3& a, const calib::Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Up in the fixture's axes where it leans from the direction of a label (DeviceMap::leans_deg).
calib::Vector3 leaned(calib::Vector3 up, const std::array<double, 2>& lean_deg) {
  if (lean_deg[0] == 0.0 && lean_deg[1] == 0.0) return up;
  const std::size_t axis = up[0] != 0.0 ? 0 : up[1] != 0.0 ? 1 : 2;
  up[(axis + 1) % 3] = std::tan(lean_deg[0] * base::kRadPerDeg);
  up[(axis + 2) % 3] = std::tan(lean_deg[1] * base::kRadPerDeg);
  const double length = std::sqrt(dot(up, up));
  for (double& part : up) part /= length;
  return up;
}

/// Heading of a horizontal axis of the fixture that stands with `up` upwards, clockwise from the axis after the
/// vertical one, degrees.
double heading_on_fixture(const calib::Vector3& up, const calib::Vector3& axis) {
  const calib::Vector3 forward = {std::abs(up[2]), std::abs(up[0]), std::abs(up[1])};
  const calib::Vector3 left = {up[1] * forward[2] - up[2] * forward[1], up[2] * forward[0] - up[0] * forward[2],
                               up[0] * forward[1] - up[1] * forward[0]};
  return std::atan2(-dot(axis, left), dot(axis, forward)) * base::kDegPerRad;
}

/// An address that something else has already.
struct SharedPort {
  std::string section;  ///< of the configuration: "fixture", "power", "slot"
  std::string text;     ///< for people: which address, of whom, and whose it is
};

std::vector<std::pair<std::string, hal::DeviceMap>> controllers_of(const StationConfig& config) {
  std::vector<std::pair<std::string, hal::DeviceMap>> controllers = {{"chamber", config.chamber}};
  if (config.fixture) controllers.emplace_back("fixture", *config.fixture);
  if (const auto* power = std::get_if<hal::DeviceMap>(&config.power)) controllers.emplace_back("power", *power);
  return controllers;
}

/// What makes two addresses one, whatever else stands in them: the serial port, or host and port; empty for others.
template <class Address>
std::string place_of(const Address& address) {
  if (const auto* serial = std::get_if<hal::SerialAddress>(&address)) return serial->device;
  const auto* tcp = std::get_if<hal::TcpAddress>(&address);
  return tcp ? fmt::format("{}:{}", tcp->host, tcp->port) : std::string();
}

/// Everything at an address that chamber, fixture or power has: requests of the one would run into the answers of the
/// other, and what is meant for a unit would reach a controller. Several controllers behind one gateway (Modbus TCP)
/// may have its address; two slots at one are not among them.
std::vector<SharedPort> shared_ports(const StationConfig& config) {
  std::map<std::string, std::string> owners;
  std::vector<SharedPort> shared;
  for (const auto& [section, map] : controllers_of(config)) {
    const std::string place = place_of(map.link.address);
    if (place.empty() || owners.try_emplace(place, section).second) continue;
    if (!std::holds_alternative<hal::SerialAddress>(map.link.address)) continue;
    shared.push_back({section, fmt::format("the serial port '{}' of the {} is already used by the {}", place, section,
                                           owners.at(place))});
  }
  for (const Slot& slot : config.slots) {
    const std::string place = place_of(slot.address);
    const auto owner = place.empty() ? owners.end() : owners.find(place);
    if (owner == owners.end()) continue;
    shared.push_back({"slot", fmt::format("the address '{}' of slot {} is already that of the {}", place, slot.name,
                                          owner->second)});
  }
  return shared;
}

}  // namespace

base::Result<StationConfig> parse_station_config(std::string_view text, const std::filesystem::path& file) {
  return settings::read(text, file.string(), [&](const Table& root) {
    StationConfig config;
    config.file = file.string();
    const auto folder = file.parent_path();
    read_service(root, folder, config);
    read_controllers(root, folder, config);
    read_unit_type_folder(root, folder, config);
    read_slots(root, config);
    for (const SharedPort& port : shared_ports(config)) root.refuse(port.section, port.text);
    read_place(root, config);
    config.alarms = read_alarm_config(root, folder);
    return config;
  });
}

base::Result<hal::DeviceMap> parse_controller(std::string_view text, std::string_view kind,
                                              const std::filesystem::path& file) {
  return settings::read(text, file.string(), [&](const Table& root) {
    const auto table = root.table(kind, settings::kRequired);
    return table ? read_controller(*table, kind, file.parent_path()) : hal::DeviceMap();
  });
}

base::Result<std::vector<Slot>> parse_slots(std::string_view text, const std::filesystem::path& file) {
  return settings::read(text, file.string(), [&](const Table& root) {
    StationConfig config;
    read_unit_type_folder(root, file.parent_path(), config);
    read_slots(root, config);
    return config.slots;
  });
}

base::Result<AlarmConfig> parse_alarms(std::string_view text, const std::filesystem::path& file) {
  return settings::read(text, file.string(),
                        [&](const Table& root) { return read_alarm_config(root, file.parent_path()); });
}

base::Result<StationConfig> read_station_config(const std::filesystem::path& file) {
  const auto text = settings::read_text(file.string());
  if (!text) return base::forward_error(text);
  return parse_station_config(*text, file);
}

base::Result<StationConfig> find_station_config(const std::filesystem::path& file, std::string_view data_option) {
  const auto place = place_of_config(file, data_option);
  if (!place) return base::forward_error(place);
  if (!place->is_there) return tl::unexpected<base::Error>(no_config_at(*place));
  auto config = read_station_config(place->file);
  if (!config) return base::forward_error(config);
  if (config->data.empty()) config->data = place->data;
  const auto folder = data_folder(data_option.empty() ? config->data.string() : data_option);
  if (!folder) return base::forward_error(folder);
  config->data = *folder;
  return config;
}

hal::UnitLink link_of(const Slot& slot, const calib::UnitType& type) {
  hal::UnitLink link;
  link.address = slot.address;
  link.decoder = slot.decoder;
  link.ranges.rate_dps = type.gyro_range_dps.value_or(0.0);
  link.ranges.accel_g = type.accel_range_mps2.value_or(0.0) / base::kStandardGravity_mps2;
  return link;
}

calib::Position unit_position(const Slot& slot, std::string_view fixture_up, std::optional<double> azimuth_deg,
                              const std::array<double, 2>& lean_deg) {
  const auto up = calib::position_named(fixture_up);
  if (!up || !is_right_handed(slot.axes)) return {};
  const calib::Vector3 true_up = leaned(up->up, lean_deg);
  calib::Position position;
  for (std::size_t axis = 0; axis < slot.axes.size(); ++axis) {
    const calib::Vector3 direction = calib::position_named(slot.axes[axis])->up;
    const double part = dot(direction, up->up);
    position.up[axis] = dot(direction, true_up);
    if (part == 0.0) continue;
    position.label = {part > 0.0 ? '+' : '-', static_cast<char>('X' + axis)};
    const auto next = calib::position_named(slot.axes[(axis + 1) % 3])->up;
    if (azimuth_deg) position.azimuth_deg = *azimuth_deg + heading_on_fixture(up->up, next);
  }
  return position;
}

std::vector<calib::Position> positions_of(const Slot& slot, const StationConfig& config) {
  std::vector<calib::Position> positions;
  if (!config.fixture) return positions;
  const hal::DeviceMap& map = *config.fixture;
  for (std::size_t i = 0; i < map.positions.size(); ++i) {
    const auto lean = map.leans_deg.find(map.positions[i]);
    const bool leans = lean != map.leans_deg.end();
    const bool heads = i < map.azimuths_deg.size();
    if (!leans && !heads) continue;
    calib::Position position =
        unit_position(slot, map.positions[i], heads ? std::optional(map.azimuths_deg[i]) : std::nullopt,
                      leans ? lean->second : std::array<double, 2>{});
    if (!position.label.empty()) positions.push_back(std::move(position));
  }
  return positions;
}

}  // namespace soak::station
