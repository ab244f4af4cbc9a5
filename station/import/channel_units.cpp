// SPDX-License-Identifier: Apache-2.0
#include "station/import/channel_units.h"

#include "base/units.h"

namespace soak::station {
namespace {

double same(double value) { return value; }
double rps_from_dps(double value) { return value * base::kRadPerDeg; }
double rps_from_degph(double value) { return value * base::kRadPerDeg / 3600.0; }
double dps_from_rps(double value) { return value * base::kDegPerRad; }
double dps_from_degph(double value) { return value / 3600.0; }
double mps2_from_g(double value) { return value * base::kStandardGravity_mps2; }
double mps2_from_mg(double value) { return value * base::kStandardGravity_mps2 / 1000.0; }
double celsius_from_kelvin(double value) { return value - base::kZeroCelsius_k; }
double celsius_from_fahrenheit(double value) { return (value - 32.0) / 1.8; }

Conversion common_conversion(std::string_view unit) {
  if (unit == "g") return mps2_from_g;
  if (unit == "mg") return mps2_from_mg;
  if (unit == "k") return celsius_from_kelvin;
  if (unit == "f") return celsius_from_fahrenheit;
  return same;
}

}  // namespace

Conversion conversion_to_si(std::string_view unit) {
  if (unit == "dps") return rps_from_dps;
  if (unit == "degph") return rps_from_degph;
  return common_conversion(unit);
}

Conversion conversion_to_csv(std::string_view unit) {
  if (unit == "rps") return dps_from_rps;
  if (unit == "degph") return dps_from_degph;
  return common_conversion(unit);
}

}  // namespace soak::station
