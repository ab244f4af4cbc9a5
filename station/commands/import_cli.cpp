// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <memory>

#include "station/commands/frame.h"
#include "station/commands/import_command.h"

namespace soak::station::cli {
namespace {

/// An option that takes a finite number of `low` to `high`.
void add_number(CLI::App& command, const std::string& name, std::optional<double>& value,
                const std::string& description, const std::string& unit, double low, double high) {
  const auto check = [low, high](const std::string& text) -> std::string {
    double number = NAN;
    if (CLI::detail::lexical_cast(text, number) && number >= low && number <= high) return {};
    return "'" + text + "' is not a number from " + std::to_string(low) + " to " + std::to_string(high);
  };
  command.add_option(name, value, description)->type_name(unit)->check(check);
}

}  // namespace

void register_import(CLI::App& program, Request& request) {
  const auto options = std::make_shared<ImportCommand>();
  CLI::App* command =
      add_command(program, request, "import", "Store the recording of a unit from a file: CSV, or the bytes it sent",
                  "soak import soak_run_1.csv --unit SN0042 --campaign acceptance --latitude-deg 48.1", true);
  command
      ->add_option("file", options->file, "CSV file (docs/csv-format.md), or with --decoder a log of the unit's bytes")
      ->required()
      ->type_name("FILE");
  command->add_option("--unit", options->import.unit, "Serial number of the unit")->required()->type_name("SN");
  command->add_option("--campaign", options->import.campaign, "Campaign that the runs belong to")
      ->type_name("NAME")
      ->capture_default_str();
  command
      ->add_option("--procedure", options->import.procedure,
                   "Procedure of a new campaign; 'verification' keeps its runs out of fits")
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--type", options->import.unit_type, "Type of a new unit (else generic)")->type_name("NAME");
  calib::Site& site = options->import.site;
  add_number(*command, "--latitude-deg", site.latitude_deg, "Latitude of the station, south negative", "DEG", -90, 90);
  add_number(*command, "--height-m", site.height_m, "Height above sea level", "M", -500, 9000);
  add_number(*command, "--azimuth-deg", site.azimuth_deg, "Heading of the fixture, clockwise from north", "DEG", -360,
             360);
  add_number(*command, "--gravity-mps2", site.gravity_mps2, "Local gravity (else from latitude and height)", "M/S2",
             9.7, 9.9);
  command->add_option("--columns", options->columns, "Columns map for foreign headers, units and separators")
      ->type_name("FILE.toml");
  command
      ->add_option("--decoder", options->decoder,
                   "The file holds the bytes that a unit sent: xsens, ahrs400, vectornav")
      ->type_name("NAME")
      ->check(CLI::IsMember({"xsens", "ahrs400", "vectornav"}));
  add_number(*command, "--rate-hz", options->rate_hz, "Packets a second that such a unit was set to (else 100)", "HZ",
             1, 10000);
  command->add_flag("--skip-bad", options->skip_bad, "Leave bad rows out and list them");
  command->add_flag("--simulated", options->import.simulated, "Mark the runs as simulated");
  command->add_flag("--references", options->import.references,
                    "It was made with this station's references (docs/records.md): an expired one refuses it");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_import(*options, output); };
  });
}

}  // namespace soak::station::cli
