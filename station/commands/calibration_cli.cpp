// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/text.h"
#include "calib/deploy/table_form.h"
#include "station/commands/calibration_commands.h"
#include "station/commands/fit_command.h"
#include "station/commands/frame.h"
#include "station/commands/number_list.h"

namespace soak::station::cli {
namespace {

void add_fit(CLI::App& program, Request& request) {
  const auto options = std::make_shared<FitCommand>();
  const auto rules = std::make_shared<std::string>("auto");
  CLI::App* command =
      add_command(program, request, "fit", "Fit a thermal model per sensor; adds a model version, the old ones stay",
                  "soak fit --unit SN0042 --json", true);
  CLI::Option* unit = command->add_option("--unit", options->unit, "Serial number of the unit")->type_name("SN");
  CLI::Option* all = command->add_flag("--all", options->all, "Fit every unit of the data folder")->excludes(unit);
  unit->excludes(all);
  command->add_option("--campaign", options->campaign, "Only runs of this campaign")->type_name("NAME");
  command->add_option("--rules", *rules, "Number of ANFIS rules, or auto: chosen by folds over runs")
      ->type_name("auto|N")
      ->check([](const std::string& text) {
        const auto number = base::parse_int(text);
        return text == "auto" || (number && *number >= 2 && *number <= 64) ? ""
                                                                           : "must be auto or a number from 2 to 64";
      });
  command->add_option("--jobs", options->jobs, "Threads (else one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  command
      ->add_flag("--chamber-time", options->chamber_time,
                 "Also: what fewer runs, plateaus or one sweep would have given, in how many hours")
      ->needs(unit);
  command->callback([options, rules, unit, all, &request] {
    if (unit->count() + all->count() == 0) throw CLI::RequiredError("--unit SN or --all");
    options->data = request.data;
    if (const auto number = base::parse_int(*rules)) options->rules = static_cast<int>(*number);
    request.action = [options](Output& output) { return run_fit(*options, output); };
  });
}

/// The device ids that PX4 calls the accelerometer and the gyro of a unit; one number is both.
void parse_device_ids(const std::string& list, ExportCommand& options) {
  static constexpr double kLargest = 2147483647.0;
  static const std::string kMustBe = "one or two whole numbers from 1 to 2147483647: ACCEL_ID or ACCEL_ID,GYRO_ID";
  const std::vector<double> ids = parse_number_list("--device-id", list, 1.0, kLargest, kMustBe);
  const bool whole = std::all_of(ids.begin(), ids.end(), [](double id) { return id == std::floor(id); });
  if (!whole || ids.size() > 2) throw CLI::ValidationError("--device-id", "must be " + kMustBe);
  options.accel_id = static_cast<std::int32_t>(ids.front());
  options.gyro_id = static_cast<std::int32_t>(ids.back());
}

void add_export(CLI::App& program, Request& request) {
  const auto options = std::make_shared<ExportCommand>();
  const auto device_ids = std::make_shared<std::string>();
  CLI::App* command = add_command(program, request, "export", "Write a unit's calibration file",
                                  "soak export --unit SN0042 --format blob -o SN0042.soakcal", true);
  command->add_option("--unit", options->unit, "Serial number of the unit")->required()->type_name("SN");
  command
      ->add_option("--format", options->format,
                   "blob: for the deployment runtime; c: the same as a C header; json: for people and scripts; px4, "
                   "ardupilot: parameters of an autopilot; kalibr: noise values of an imu.yaml")
      ->required()
      ->check(CLI::IsMember({"blob", "c", "json", "px4", "ardupilot", "kalibr"}))
      ->type_name("");
  command->add_option("-o,--output", options->file, "File to write")->required()->type_name("FILE");
  command->add_option("--model", options->model, "Model version (else the newest)")->type_name("V");
  command->add_flag("--simulated", options->simulated, "Export a model made from simulated data all the same");
  command
      ->add_option("--table", options->table,
                   "blob, c: every curve as a table of at most N points, for small controllers")
      ->check(CLI::Range(calib::kFewestTablePoints, calib::kMostTablePoints))
      ->type_name("N");
  command->add_option("--sign", options->sign, "blob: sign with this secret key ('soak key new' makes one)")
      ->type_name("KEY");
  command->add_option("--instance", options->instance, "px4, ardupilot: which of the vehicle's units, from 0 (else 0)")
      ->type_name("N");
  command->add_option("--device-id", *device_ids, "px4: CAL_ACCn_ID of the unit, and CAL_GYROn_ID where it is another")
      ->type_name("ACCEL[,GYRO]");
  command->callback([options, device_ids, &request] {
    options->data = request.data;
    if (!device_ids->empty()) parse_device_ids(*device_ids, *options);
    request.action = [options](Output& output) { return run_export(*options, output); };
  });
}

/// SENSOR=T between commas, no sensor twice.
void parse_own_temperatures(const std::string& list, EvalCommand& options) {
  static const std::string kOption = "--own-temp-c";
  static const std::string kMustBe = "a temperature from -273.15 to 1000 for each, such as gyro_x=33,gyro_y=33.5";
  for (std::size_t first = 0; first <= list.size();) {
    const std::size_t last = std::min(list.find(',', first), list.size());
    const std::string part = list.substr(first, last - first);
    const std::size_t equals = std::min(part.find('='), part.size());
    const auto sensor = calib::sensor_named(part.substr(0, equals));
    if (!sensor || equals == part.size()) throw CLI::ValidationError(kOption, "must be " + kMustBe);
    auto& temp_c = options.own_temps_c[calib::index_of(*sensor)];
    if (temp_c) throw CLI::ValidationError(kOption, part.substr(0, equals) + " is given twice");
    const auto values = parse_number_list(kOption, part.substr(equals + 1), -273.15, 1000.0, kMustBe);
    temp_c = values.front();
    first = last + 1;
  }
}

/// Six numbers, gyros in deg/s and accelerometers in m/s².
void parse_sample(const std::string& list, EvalCommand& options) {
  static constexpr double kLargest = 1e9;
  static const std::string kMustBe = "six numbers GX,GY,GZ,AX,AY,AZ, rates in deg/s and accelerations in m/s2";
  const auto values = parse_number_list("--raw", list, -kLargest, kLargest, kMustBe);
  if (values.size() != calib::kSensorCount) throw CLI::ValidationError("--raw", "must be " + kMustBe);
  options.raw.emplace();
  std::copy(values.begin(), values.end(), options.raw->begin());
}

void add_eval(CLI::App& program, Request& request) {
  const auto options = std::make_shared<EvalCommand>();
  const auto list = std::make_shared<std::string>();
  const auto own_temperatures = std::make_shared<std::string>();
  const auto sample = std::make_shared<std::string>();
  CLI::App* command =
      add_command(program, request, "eval", "What a calibration file says, read by the deployment runtime",
                  "soak eval SN0042.soakcal --temp-c -30,25,70", true);
  command->add_option("file", options->file, "Calibration file")->required()->type_name("FILE.blob");
  command->add_option("--temp-c", *list, "Temperatures in °C")->required()->type_name("T[,T...]");
  command
      ->add_option("--own-temp-c", *own_temperatures,
                   "Temperatures of sensors that were calibrated over thermometers of their own")
      ->type_name("SENSOR=T[,...]");
  command
      ->add_option("--raw", *sample,
                   "Also: this sample (deg/s, m/s2) as the runtime corrects it, couplings and all: for test vectors")
      ->type_name("GX,GY,GZ,AX,AY,AZ");
  command->callback([options, list, own_temperatures, sample, &request] {
    if (!own_temperatures->empty()) parse_own_temperatures(*own_temperatures, *options);
    if (!sample->empty()) parse_sample(*sample, *options);
    options->temps_c = parse_number_list("--temp-c", *list, -273.15, 1000.0,
                                         "temperatures from -273.15 to 1000 between commas, such as -30,25,70");
    request.action = [options](Output& output) { return run_eval(*options, output); };
  });
}

void add_verify(CLI::App& program, Request& request) {
  const auto options = std::make_shared<VerifyCommand>();
  CLI::App* command =
      add_command(program, request, "verify", "Compare a calibration file with runs that no fit has seen",
                  "soak verify SN0042.soakcal --campaign check-2027 --limits limits.toml", true);
  command->add_option("file", options->file, "Calibration file")->required()->type_name("FILE.blob");
  command->add_option("--campaign", options->campaign, "Campaign of the fresh runs")->required()->type_name("NAME");
  command
      ->add_option("--limits", options->limits,
                   "Limits per sensor (TOML), in place of those of the unit's type; without any the verdict is info")
      ->type_name("FILE");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_verify(*options, output); };
  });
}

}  // namespace

void register_calibration(CLI::App& program, Request& request) {
  add_fit(program, request);
  add_export(program, request);
  add_eval(program, request);
  add_verify(program, request);
}

}  // namespace soak::station::cli
