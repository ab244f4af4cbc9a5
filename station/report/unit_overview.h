// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// All units with the number of their runs and their newest model, those recorded last first; the campaigns that can
/// judge them (docs/schema/http-units.schema.json, but for what the release rule and the jobs say).
[[nodiscard]] base::Result<nlohmann::json> units_overview(const db::Catalog& catalog);

/// A unit with what is stored of its newest model, read and not calculated but for `impact`: curves, errors, warnings
/// with remedies; and the campaigns whose runs that model has not seen (docs/schema/http-unit.schema.json, but for what
/// jobs know). Refuses (bad_input, where == "unit") an unknown unit; (corrupt) a damaged model.
[[nodiscard]] base::Result<nlohmann::json> unit_overview(const db::Catalog& catalog, const std::string& serial);

/// One version of a unit's model as unit_overview() has the newest, without warnings: {unit, model}
/// (docs/schema/http-model.schema.json). Refuses (bad_input, where == "unit") an unknown unit; (bad_input,
/// where == "version") a version that there is not; (corrupt) a damaged model.
[[nodiscard]] base::Result<nlohmann::json> model_overview(const db::Catalog& catalog, const std::string& serial,
                                                          std::int32_t version);

/// A version of a unit's model, decoded.
struct ModelCalibration {
  std::int32_t version = 0;
  calib::Calibration calibration;
};

/// Of a version of a unit's model, the newest where none is named. Refuses (bad_input, where == "unit") an unknown unit
/// and one without a model, (where == "version") a version that there is not; (corrupt) a damaged model.
[[nodiscard]] base::Result<ModelCalibration> calibration_of_model(const db::Catalog& catalog, const std::string& serial,
                                                                  std::optional<std::int32_t> version);

/// What was withdrawn since of what a model rests on, in words; empty where nothing was.
[[nodiscard]] base::Result<std::string> doubt_of(const db::Catalog& catalog, const calib::Calibration& calibration);

/// The same of the newest model of a unit; empty, too, where there is none.
[[nodiscard]] base::Result<std::string> doubt_of_model(const db::Catalog& catalog, const std::string& serial);

/// Whether something of a unit's runs, of one campaign or of all, was withdrawn since a time.
[[nodiscard]] base::Result<bool> withdrawn_since_start(const db::Catalog& catalog, const std::string& unit,
                                                       const std::optional<std::string>& campaign, double utc_s);

/// Whether runs of a unit that count were entered since a time; `only_fitted`: runs that a fit takes.
[[nodiscard]] base::Result<bool> recorded_since(const db::Catalog& catalog, const std::string& unit, double utc_s,
                                                bool only_fitted);

}  // namespace soak::station
