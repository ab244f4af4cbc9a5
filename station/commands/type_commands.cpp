// SPDX-License-Identifier: Apache-2.0
#include "station/commands/type_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "station/config/unit_type_file.h"

namespace soak::station {
namespace {

struct Types {
  std::filesystem::path folder;
  std::vector<calib::UnitType> types;
};

base::Result<Types> types_in(const std::string& option) {
  const std::filesystem::path folder = option.empty() ? default_unit_type_folder() : std::filesystem::path(option);
  auto types = read_unit_types(folder);
  if (!types) return base::forward_error(types);
  return Types{folder, std::move(*types)};
}

nlohmann::json axes_document(const calib::UnitType& type) {
  return type.axes ? nlohmann::json(*type.axes) : nlohmann::json();
}

nlohmann::json thermometers_document(const calib::UnitType& type) {
  if (!type.thermometers) return {};
  return *type.thermometers == calib::Thermometers::one ? "one" : "per_sensor";
}

nlohmann::json type_document(const calib::UnitType& type) {
  return {{"name", type.name},
          {"description", type.description},
          {"temp_min_c", number_or_null(type.temp_min_c)},
          {"temp_max_c", number_or_null(type.temp_max_c)},
          {"sign_at_rest", type.sign_at_rest},
          {"axes", axes_document(type)},
          {"warm_up_s", number_or_null(type.warm_up_s)},
          {"thermometers", thermometers_document(type)},
          {"temp_lsb_c", number_or_null(type.temp_lsb_c)},
          {"temp_repeatability_c", number_or_null(type.temp_repeatability_c)},
          {"gyro_range_dps", number_or_null(type.gyro_range_dps)},
          {"gyro_lsb_dps", number_or_null(type.gyro_lsb_dps)},
          {"gyro_noise_max_dps_rthz", number_or_null(type.gyro_noise_max_dps_rthz)},
          {"gyro_bias_max_dps", number_or_null(type.gyro_bias_max_dps)},
          {"accel_range_mps2", number_or_null(type.accel_range_mps2)},
          {"accel_lsb_mps2", number_or_null(type.accel_lsb_mps2)},
          {"accel_noise_max_mps2_rthz", number_or_null(type.accel_noise_max_mps2_rthz)},
          {"accel_bias_max_mps2", number_or_null(type.accel_bias_max_mps2)},
          {"limits", stated_limits(type.limits)}};
}

std::string rating_text(const calib::UnitType& type) {
  if (!type.temp_min_c || !type.temp_max_c) return "not stated";
  return fmt::format("{:g} to {:g} °C", *type.temp_min_c, *type.temp_max_c);
}

std::string value_text(const nlohmann::json& value) {
  if (value.is_null()) return "-";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

base::Status run_type_list(const TypeListCommand& command, Output& output) {
  const auto found = types_in(command.folder);
  if (!found) return base::forward_error(found);
  nlohmann::json list = nlohmann::json::array();
  std::vector<std::vector<std::string>> table = {{"type", "rating"}};
  for (const calib::UnitType& type : found->types) {
    list.push_back({{"name", type.name},
                    {"temp_min_c", number_or_null(type.temp_min_c)},
                    {"temp_max_c", number_or_null(type.temp_max_c)}});
    table.push_back({type.name, rating_text(type)});
  }
  if (output.json()) return output.print_json({{"folder", found->folder.string()}, {"types", list}});
  output.print(text_table(table));
  return {};
}

base::Status run_type_show(const TypeShowCommand& command, Output& output) {
  const auto type = find_unit_type(command.folder, command.name);
  if (!type) return base::forward_error(type);
  const nlohmann::json document = type_document(*type);
  if (output.json()) return output.print_json({{"type", document}});
  std::string text;
  for (const auto& [key, value] : document.items()) text += fmt::format("{:<26} {}\n", key, value_text(value));
  output.print(text);
  return {};
}

base::Result<calib::UnitType> find_unit_type(const std::string& folder, const std::string& name) {
  auto found = types_in(folder);
  if (!found) return base::forward_error(found);
  const auto type = std::find_if(found->types.begin(), found->types.end(),
                                 [&](const calib::UnitType& candidate) { return candidate.name == name; });
  if (type == found->types.end()) {
    return base::bad_input(fmt::format("there is no unit type '{}': 'soak type list' shows them", name),
                           found->folder.string());
  }
  return std::move(*type);
}

}  // namespace soak::station
