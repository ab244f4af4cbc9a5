// SPDX-License-Identifier: Apache-2.0
#include "station/config/unit_type_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <system_error>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/sensor.h"
#include "settings/reader.h"

namespace soak::station {
namespace {

using settings::Table;

constexpr settings::Limits kTemp_c = {-273.15, 1000.0};
constexpr settings::Limits kPositive = {1e-12, 1e9};
constexpr std::string_view kGeneric = "generic";
constexpr std::string_view kScaleSuffix = "_scale_ppm";

using PerSensor = std::array<std::optional<double>, calib::kSensorCount>;

std::string_view shared_limit_key(calib::Sensor sensor) { return calib::is_gyro(sensor) ? "gyro" : "accel"; }

/// The limits of all sensors whose keys end in `suffix`, as they stand there.
PerSensor read_limit_keys(const settings::Table& table, std::string_view suffix) {
  PerSensor limits;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto common = table.optional_number(fmt::format("{}{}", shared_limit_key(sensor), suffix), kPositive);
    const auto own = table.optional_number(fmt::format("{}{}", calib::name_of(sensor), suffix), kPositive);
    limits[calib::index_of(sensor)] = own ? own : common;
  }
  return limits;
}

/// Names the keys that there are beside each that there is not.
void refuse_unknown_limits(const settings::Table& table) {
  for (const std::string& key : table.keys()) {
    std::string_view stem = key;
    if (stem.ends_with(kScaleSuffix)) stem.remove_suffix(kScaleSuffix.size());
    if (stem == "gyro" || stem == "accel" || calib::sensor_named(stem)) continue;
    table.refuse(key, fmt::format("unknown limit '{}'; known: gyro, accel, gyro_x, gyro_y, gyro_z, accel_x, accel_y, "
                                  "accel_z (deg/s, m/s2), each also with the suffix {}",
                                  key, kScaleSuffix));
  }
}

calib::Limits read_limits_table(const settings::Table& table) {
  calib::Limits limits;
  limits.bias = read_limit_keys(table, "");
  limits.scale_ppm = read_limit_keys(table, kScaleSuffix);
  for (const calib::Sensor sensor : calib::kSensors) {
    if (auto& limit = limits.bias[calib::index_of(sensor)]) *limit /= calib::printed_per_si(sensor);
  }
  refuse_unknown_limits(table);
  return limits;
}

void read_type_axes(const settings::Table& root, calib::UnitType& type) {
  if (!root.has("axes")) return;
  const auto labels = root.texts("axes");
  std::array<std::string, 3> axes;
  if (labels.size() == axes.size()) std::copy(labels.begin(), labels.end(), axes.begin());
  if (labels.size() != axes.size() || !is_right_handed(axes)) {
    root.refuse("axes", "'axes' must be three of +X, -X, +Y, -Y, +Z, -Z that form a right-handed frame");
  }
  type.axes = axes;
}

void read_rating(const settings::Table& table, calib::UnitType& type) {
  type.temp_min_c = table.number("temp_min_c", kTemp_c);
  type.temp_max_c = table.number("temp_max_c", kTemp_c);
  if (table.has("temp_min_c") && table.has("temp_max_c") && *type.temp_min_c >= *type.temp_max_c) {
    table.refuse("temp_max_c", "'rating.temp_max_c' must lie above temp_min_c");
  }
}

void read_gyro(const settings::Table& table, calib::UnitType& type) {
  type.gyro_range_dps = table.optional_number("range_dps", kPositive);
  type.gyro_lsb_dps = table.optional_number("lsb_dps", kPositive);
  type.gyro_noise_max_dps_rthz = table.optional_number("noise_max_dps_rthz", kPositive);
  type.gyro_bias_max_dps = table.optional_number("bias_max_dps", kPositive);
  type.gyro_bias_per_k_dps = table.optional_number("bias_per_k_dps", kPositive);
  type.gyro_scale_per_k_ppm = table.optional_number("scale_per_k_ppm", kPositive);
  type.gyro_hysteresis_dps = table.optional_number("hysteresis_dps", kPositive);
}

void read_accel(const settings::Table& table, calib::UnitType& type) {
  type.accel_range_mps2 = table.optional_number("range_mps2", kPositive);
  type.accel_lsb_mps2 = table.optional_number("lsb_mps2", kPositive);
  type.accel_noise_max_mps2_rthz = table.optional_number("noise_max_mps2_rthz", kPositive);
  type.accel_bias_max_mps2 = table.optional_number("bias_max_mps2", kPositive);
  type.accel_bias_per_k_mps2 = table.optional_number("bias_per_k_mps2", kPositive);
  type.accel_scale_per_k_ppm = table.optional_number("scale_per_k_ppm", kPositive);
  type.accel_hysteresis_mps2 = table.optional_number("hysteresis_mps2", kPositive);
}

void read_thermometers(const settings::Table& table, calib::UnitType& type) {
  if (table.has("kind")) {
    type.thermometers = table.choice<calib::Thermometers>(
        "kind", {{"one", calib::Thermometers::one}, {"per_sensor", calib::Thermometers::per_sensor}});
  }
  type.temp_lsb_c = table.optional_number("lsb_c", kPositive);
  type.temp_repeatability_c = table.optional_number("repeatability_c", kPositive);
}

void read_type(const settings::Table& root, const std::string& stem, calib::UnitType& type) {
  type.name = root.text("name");
  if (root.has("name") && type.name != stem) {
    root.refuse("name", fmt::format("the name '{}' differs from the file name, '{}'", type.name, stem));
  }
  type.description = root.text("description", "");
  type.sign_at_rest = root.whole("sign_at_rest", {-1, 1}, type.sign_at_rest);
  if (type.sign_at_rest == 0) root.refuse("sign_at_rest", "'sign_at_rest' must be 1 or -1");
  type.warm_up_s = root.optional_number("warm_up_s", {0.0, 86400.0});
  read_type_axes(root, type);
  if (const auto rating = root.table("rating")) read_rating(*rating, type);
  read_gyro(root.section("gyro"), type);
  read_accel(root.section("accel"), type);
  read_thermometers(root.section("thermometers"), type);
  type.constants_within_c = root.section("constants").optional_number("within_c", {0.0, 100.0}).value_or(0.0);
  type.limits = read_limits_table(root.section("limits"));
}

calib::Vector3 cross(const calib::Vector3& a, const calib::Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Names of the files in the default folder; none where it cannot be read.
std::vector<std::string> known_names() {
  std::vector<std::string> names;
  std::error_code failure;
  for (std::filesystem::directory_iterator entry(default_unit_type_folder(), failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry->path().extension() == ".toml") names.push_back(entry->path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool is_known(const std::vector<std::string>& names, std::string_view name) {
  return name == kGeneric || std::binary_search(names.begin(), names.end(), name);
}

}  // namespace

base::Result<calib::Limits> read_limits(const std::filesystem::path& path) {
  return settings::read_file(path.string(), [](const settings::Table& root) {
    return read_limits_table(root.section("limits", settings::kRequired));
  });
}

base::Result<KnownLimits> limits_of_type(const std::string& name) {
  const auto type = known_unit_type(name);
  if (!type) return base::forward_error(type);
  if (type->limits == calib::Limits{}) return KnownLimits{};
  return KnownLimits{type->limits, "unit type " + type->name};
}

std::map<std::string, double> stated_limits(const calib::Limits& limits) {
  std::map<std::string, double> stated;
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    const std::string name(calib::name_of(sensor));
    if (limits.bias[s]) stated[name] = *limits.bias[s] * calib::printed_per_si(sensor);
    if (limits.scale_ppm[s]) stated[name + std::string(kScaleSuffix)] = *limits.scale_ppm[s];
  }
  return stated;
}

bool is_right_handed(const std::array<std::string, 3>& labels) {
  std::array<calib::Vector3, 3> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto direction = calib::position_named(labels[i]);
    if (!direction) return false;
    axes[i] = direction->up;
  }
  return cross(axes[0], axes[1]) == axes[2];
}

base::Result<calib::UnitType> parse_unit_type(std::string_view text, const std::string& file) {
  return settings::read(text, file, [&](const Table& root) {
    calib::UnitType type;
    read_type(root, std::filesystem::path(file).stem().string(), type);
    return type;
  });
}

base::Result<calib::UnitType> read_unit_type(const std::filesystem::path& file) {
  const auto text = settings::read_text(file.string());
  if (!text) return base::forward_error(text);
  return parse_unit_type(*text, file.string());
}

base::Result<std::vector<calib::UnitType>> read_unit_types(const std::filesystem::path& folder) {
  std::error_code failure;
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry->path().extension() == ".toml") files.push_back(entry->path());
  }
  if (failure) {
    return base::bad_input(fmt::format("cannot read the folder of unit types ({}); name another with --types, "
                                       "$SOAK_PROCEDURES or, for soakd, [unit_types] folder",
                                       failure.message()),
                           folder.string());
  }
  std::sort(files.begin(), files.end());
  std::vector<calib::UnitType> types;
  for (const auto& file : files) {
    auto type = read_unit_type(file);
    if (!type) return base::forward_error(type);
    types.push_back(std::move(*type));
  }
  return types;
}

base::Result<calib::UnitType> known_unit_type(const std::string& name) {
  const std::filesystem::path file = default_unit_type_folder() / (name + ".toml");
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) return read_unit_type(file);
  calib::UnitType type;
  type.name = name;
  return type;
}

base::Result<calib::UnitType> stated_unit_type(const std::string& name) {
  std::vector<std::string> names = known_names();
  if (is_known(names, name)) return known_unit_type(name);
  if (std::ranges::find(names, kGeneric) == names.end()) names.emplace_back(kGeneric);
  return base::bad_input(fmt::format("there is no unit type '{}'; known: {} ('soak type list'). To add a type, create "
                                     "the file {}, or put it in units/ of the folder that $SOAK_PROCEDURES names",
                                     name, fmt::join(names, ", "), (default_unit_type_folder() / "NAME.toml").string()),
                         "--type");
}

std::vector<calib::Warning> unit_type_warnings(const std::string& name) {
  if (is_known(known_names(), name)) return {};
  return {{"unit_type_unknown",
           fmt::format(
               "the unit's type '{}' has no file in {}: its limits, ratings, thermometers and sign_at_rest are unknown",
               name, default_unit_type_folder().string())}};
}

std::filesystem::path default_unit_type_folder() {
  if (const char* types = std::getenv(kUnitTypesVariable); types != nullptr && *types != '\0') return types;
  return shipped_procedures() / "units";
}

std::filesystem::path shipped_procedures() {
  const char* procedures = std::getenv("SOAK_PROCEDURES");
  const bool is_set = procedures != nullptr && *procedures != '\0';
  return std::filesystem::absolute(is_set ? std::string(procedures)
                                          : std::string(settings::shipped("procedures", SOAK_PROCEDURES_FOLDER)));
}

}  // namespace soak::station
