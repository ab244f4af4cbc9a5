// SPDX-License-Identifier: Apache-2.0
#include "station/records/calibration_reader.h"

#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "calib/deploy/calibration_file.h"
#include "station/fit/reference_rule.h"
#include "station/report/runs_of_model.h"

namespace soak::station {

base::Result<LoadedCalibration> read_calibration(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return base::bad_input("is a folder, not a calibration file", path.string());
  }
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return base::bad_input("cannot be read: give the path of a calibration file made by 'soak export'", path.string());
  LoadedCalibration loaded;
  loaded.bytes.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  auto decoded = calib::decode(loaded.bytes);
  if (!decoded) {
    base::Error error = decoded.error();
    error.where = error.where.empty() ? path.string() : path.string() + ", " + error.where;
    return tl::unexpected<base::Error>(std::move(error));
  }
  loaded.calibration = *std::move(decoded);
  return loaded;
}

base::Result<std::vector<calib::Warning>> withdrawn_since(const db::Catalog& catalog,
                                                          const calib::Calibration& calibration) {
  const auto runs = runs_of_model(catalog, calibration);
  if (!runs) return base::forward_error(runs);
  std::vector<calib::Warning> warnings;
  for (const calib::Warning& warning : runs->warnings) {
    if (warning.code == "voided_since") warnings.push_back(warning);
  }
  const auto since = reference_warnings(catalog, calibration.references);
  if (!since) return base::forward_error(since);
  warnings.insert(warnings.end(), since->begin(), since->end());
  return warnings;
}

}  // namespace soak::station
