// SPDX-License-Identifier: Apache-2.0
#include "station/config/unit_type_json.h"

#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "station/config/unit_type_file.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

nlohmann::json axes_document(const calib::UnitType& type) {
  return type.axes ? nlohmann::json(*type.axes) : nlohmann::json();
}

nlohmann::json thermometers_document(const calib::UnitType& type) {
  if (!type.thermometers) return {};
  return *type.thermometers == calib::Thermometers::one ? "one" : "per_sensor";
}

}  // namespace

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

nlohmann::json types_document(const std::filesystem::path& folder) {
  std::set<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == ".toml") files.insert(entry->path());
  }
  nlohmann::json document = {
      {"folder", folder.string()}, {"types", nlohmann::json::array()}, {"troubles", nlohmann::json::array()}};
  for (const std::filesystem::path& file : files) {
    const auto type = read_unit_type(file);
    type ? document["types"].push_back(type_document(*type)) : document["troubles"].push_back(type.error().message);
  }
  return document;
}

}  // namespace soak::station
