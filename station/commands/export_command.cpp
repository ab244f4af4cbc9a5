// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/sha256.h"
#include "calib/calibration_file.h"
#include "calib/export_c.h"
#include "calib/export_json.h"
#include "calib/model_document.h"
#include "station/commands/calibration_commands.h"
#include "station/csv/text_file.h"
#include "station/data_folder.h"
#include "station/identity.h"

namespace soak::station {
namespace {

base::Result<std::string> render(const calib::Calibration& calibration, const std::string& format) {
  if (format == "json") return calib::export_json(calibration);
  if (format == "c") return calib::export_c(calibration);
  if (format != "blob") {
    return base::bad_input(fmt::format("unknown format '{}'; known: blob, c, json", format), "--format");
  }
  const auto bytes = calib::encode(calibration);
  if (!bytes) return base::forward_error(bytes);
  return std::string(bytes->begin(), bytes->end());
}

base::Result<calib::Calibration> load_model(const db::Catalog& catalog, const ExportCommand& command) {
  const auto unit = catalog.unit(command.unit);
  if (!unit) return base::forward_error(unit);
  if (!*unit)
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", command.unit));
  const auto row = catalog.model(command.unit, command.model);
  if (!row) return base::forward_error(row);
  if (!*row) {
    return base::bad_input(command.model ? fmt::format("unit {} has no model version {}", command.unit, *command.model)
                                         : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first",
                                                       command.unit, command.unit));
  }
  auto calibration = calib::calibration_of((*row)->document);
  if (!calibration) return base::forward_error(calibration);
  if ((*row)->epoch != (*unit)->epoch) {
    return base::bad_input(fmt::format("model {} of unit {} belongs to epoch {}, the unit is in epoch {}: fit again",
                                       (*row)->version, command.unit, (*row)->epoch, (*unit)->epoch));
  }
  if (calibration->simulated && !command.simulated) {
    return base::bad_input(
        fmt::format("model {} of unit {} comes from SIMULATED data; --simulated exports it all the same",
                    (*row)->version, command.unit));
  }
  return calibration;
}

}  // namespace

base::Status run_export(const ExportCommand& command, Output& output) {
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto calibration = load_model(*catalog, command);
  if (!calibration) return base::forward_error(calibration);
  const auto content = render(*calibration, command.format);
  if (!content) return base::forward_error(content);
  if (const auto written = write_text_file(command.file, *content); !written) return written;

  base::Sha256 hash;
  hash.update(*content);
  const std::string sha256 = base::to_hex(hash.finish());
  const std::string path = std::filesystem::absolute(command.file).string();
  auto recorded =
      catalog->add_calibration({command.unit, calibration->model_version, now_utc_s(), command.format, sha256, path});
  if (!recorded) return recorded;
  if (output.json()) {
    return output.print_json({{"unit", command.unit},
                              {"model", calibration->model_version},
                              {"format", command.format},
                              {"file", path},
                              {"bytes", content->size()},
                              {"sha256", sha256},
                              {"simulated", calibration->simulated}});
  }
  output.print(fmt::format("{}: unit {}, model {}, {} bytes{}\n", command.file, command.unit,
                           calibration->model_version, content->size(), calibration->simulated ? ", SIMULATED" : ""));
  return {};
}

}  // namespace soak::station
