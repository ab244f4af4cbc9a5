// SPDX-License-Identifier: Apache-2.0
// Tables 4.1 and 7.2 to 7.6 of the thesis: what wavelets and an ANFIS take off a filter's errors in outages of 30 s.
// The ANFIS has learnt by heart (the truth of the very outages), or artificial outages of the same drive, or those of
// other drives. Simulated drives of three units; with a drive file as argument that recording too. `anfis_steps` is
// §7.2 to the letter, which no program offers: docs/nav.md says why.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "nav/filter/filter_run.h"
#include "nav/learned/anfis_pipeline.h"
#include "nav/outages/outage_runner.h"
#include "nav/prefilter/wmra_pipeline.h"
#include "station/nav/drive_file.h"
#include "station/nav/outage_batch.h"
#include "station/nav/simulated_drive.h"

namespace soak::station {
namespace {

using nav::OutageErrors;
using nav::OutageResult;
using nav::Pipeline;

constexpr double kLength_s = 30.0;
constexpr double kFirst_s = 120.0;
constexpr int kDrives = 4;
/// On each drive, as many as in table 7.3.
constexpr std::size_t kOutages = 10;
constexpr int kDrivesToLearnFrom = 8;
/// Of the drives that are judged, and of those that teach. `soak nav compare` takes a thousand times its seed and the
/// few after that: these lie between.
constexpr std::uint64_t kSeed = 52'417'500;
constexpr std::uint64_t kSeedToLearnFrom = 52'418'500;

nav::Drive drive_of(const nav::UnitErrors& errors, std::uint64_t seed) {
  DriveRequest request;
  request.errors = errors;
  request.temperature = {-10.0, 50.0, 200.0};
  request.thermal = example_curve;
  request.seed = seed;
  return simulated_drive(request);
}

std::vector<nav::Drive> teachers_of(const nav::UnitErrors& errors) {
  std::vector<nav::Drive> drives;
  for (int d = 0; d < kDrivesToLearnFrom; ++d) {
    drives.push_back(drive_of(errors, kSeedToLearnFrom + static_cast<std::uint64_t>(d)));
  }
  return drives;
}

/// The errors of the filter alone in an outage, against the truth.
nav::ErrorWindow errors_against_truth(const nav::Drive& drive, const nav::Outage& outage) {
  const nav::FilterSetup setup = nav::set_up(raw_filter(), nav::with_outage(drive, outage)).value();
  nav::FilterRun run(setup.drive, setup.start, setup.options);
  nav::ErrorWindow window{outage.begin_s, {}};
  for (const nav::TruthPoint& truth : drive.truth) {
    if (truth.t_s <= outage.begin_s || truth.t_s > outage.end_s) continue;
    run.advance_to(truth.t_s);
    nav::ErrorRow row{truth.t_s, {}, {}};
    row.inputs = nav::error_inputs(setup.drive, run.filter(), truth.t_s, truth.t_s - setup.drive.gnss.back().t_s);
    row.error << nav::offset_m(truth.position, run.filter().antenna()),
        run.filter().antenna_velocity_mps() - truth.velocity_mps;
    window.rows.push_back(row);
  }
  return window;
}

/// Learnt from the very outages that it will be judged by, with as many rules as their rows carry.
nav::ErrorModel learnt_by_heart(const nav::Drive& drive, const std::vector<nav::Outage>& outages) {
  std::vector<nav::ErrorWindow> windows;
  for (const nav::Outage& outage : outages) windows.push_back(errors_against_truth(drive, outage));
  // A rule has 12 consequents, which may be 3/4 of the rows that are not held out: 16 rows a rule, a quarter held out,
  // and some to spare as outages are held out whole.
  const std::size_t rows = windows.size() * windows.front().rows.size();
  nav::ErrorLearning learning;
  learning.every = 1;
  learning.rules = {static_cast<int>(std::min<std::size_t>(20, rows / 26))};
  learning.consequent_threshold = 0.0;
  anfis::VariableProjectionOptions refinement;
  refinement.evaluations = 60;
  learning.refinement = refinement;
  return nav::learn_errors(windows, learning).value();
}

/// What each fix takes out of the filter [AH05 §7.2.1: X⁽⁺⁾ − X⁽⁻⁾], as the error of a filter that lacks this fix. And
/// the same of one that lacks the fix before, too: else the time would be a constant, which is no input.
std::vector<nav::ErrorWindow> steps_of(const nav::Drive& drive) {
  const nav::FilterSetup setup = nav::set_up(raw_filter(), drive).value();
  const auto& fixes = setup.drive.gnss;
  const double interval_s = (fixes.back().t_s - fixes.front().t_s) / static_cast<double>(fixes.size() - 1);
  std::vector<double> begins_s;
  for (const nav::GnssFix& fix : fixes) {
    if (fix.t_s >= setup.start.t_s + kLength_s) begins_s.push_back(fix.t_s);
  }
  begins_s.resize(begins_s.size() - 2);
  return nav::error_windows(setup, begins_s, 2.0 * interval_s);
}

nav::ErrorModel learnt_steps(const std::vector<nav::Drive>& drives) {
  std::vector<nav::ErrorWindow> windows;
  for (const nav::Drive& drive : drives) {
    auto found = steps_of(drive);
    std::move(found.begin(), found.end(), std::back_inserter(windows));
  }
  nav::ErrorLearning learning;
  learning.every = 1;
  return nav::learn_errors(windows, learning).value();
}

/// Each second of an outage the filter is given its own position and velocity, less what a fix is expected to take out,
/// as a measurement without error [AH05 §7.2.1: R = 0]; 1 mm and 1 mm/s, so that its covariance can be inverted.
Pipeline anfis_steps(const nav::ErrorModel& model) {
  constexpr double kStep_s = 1.0;
  return {"anfis_steps", "", [model](const nav::Drive& seen, std::span<const double> t_s) {
            const nav::FilterSetup setup = nav::set_up(raw_filter(), seen).value();
            nav::FilterRun run(setup.drive, setup.start, setup.options);
            double next_s = seen.gnss.back().t_s + kStep_s;
            const Eigen::Vector3d no_error = Eigen::Vector3d::Constant(1e-3);
            std::vector<nav::Solution> solutions;
            for (const double wanted_s : t_s) {
              for (; next_s <= wanted_s; next_s += kStep_s) {
                run.advance_to(next_s);
                nav::NavigationFilter& filter = run.filter();
                const auto inputs = nav::error_inputs(setup.drive, filter, next_s, kStep_s);
                const nav::ErrorOutputs step = nav::expected_error(model, inputs).error;
                filter.update_computed({next_s, nav::moved(filter.antenna(), -step.head<3>()), no_error,
                                        filter.antenna_velocity_mps() - step.tail<3>(), no_error});
              }
              run.advance_to(wanted_s);
              solutions.push_back({run.filter().antenna(), run.filter().antenna_velocity_mps()});
            }
            return base::Result<std::vector<nav::Solution>>(std::move(solutions));
          }};
}

/// Results of one list of pipelines on all drives.
struct Column {
  std::vector<Pipeline> pipelines;
  std::vector<OutageResult> results;
};

void run_into(Column& column, const nav::Drive& drive, const std::vector<nav::Outage>& outages) {
  std::vector<OutageTask> tasks;
  for (const nav::Outage& outage : outages) tasks.push_back({0, outage});
  auto results = run_outages({&drive, 1}, tasks, column.pipelines, 0, [](double) { return true; }).value();
  std::move(results.begin(), results.end(), std::back_inserter(column.results));
}

/// 1 less the ratio of the mean horizontal RMSE to that of the first pipeline, outages paired.
nav::Estimate rmse_gain(const Column& column, std::size_t pipeline) {
  return nav::bootstrap(
      column.results.size(),
      [&](std::span<const std::size_t> drawn) {
        double sum_m = 0.0;
        double first_m = 0.0;
        for (const std::size_t i : drawn) {
          sum_m += column.results[i].pipelines[pipeline].horizontal_rmse_m;
          first_m += column.results[i].pipelines.front().horizontal_rmse_m;
        }
        return 1.0 - sum_m / first_m;
      },
      1);
}

std::string with_interval(const nav::Estimate& estimate, double factor) {
  return fmt::format("{:.1f} [{:.1f}, {:.1f}]", factor * estimate.value, factor * estimate.low, factor * estimate.high);
}

/// Mean magnitudes over outages along north, east, up, as the rows of the thesis' tables.
std::string along_axes(const Column& column, std::size_t pipeline, Eigen::Vector3d OutageErrors::* member) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const OutageResult& result : column.results) sum += (result.pipelines[pipeline].*member).cwiseAbs();
  sum /= static_cast<double>(column.results.size());
  return fmt::format("{:.2f}/{:.2f}/{:.2f}", sum.y(), sum.x(), sum.z());
}

void print(const char* title, const Column& column) {
  constexpr std::string_view kRow = "  {:<16} {:<20} {:<22} {:<20} {:<22} {:<20} {:<20} {:<15} {}\n";
  fmt::print("{}, {} outages\n", title, column.results.size());
  fmt::print(kRow, "pipeline", "RMSE m [95 %]", "less than raw %", "final m [95 %]", "less than raw %", "RMSE N/E/U m",
             "final N/E/U m", "RMSE N/E/U m/s", "final N/E/U m/s");
  const auto summaries = nav::summarize(column.results, column.pipelines, 1);
  for (std::size_t p = 0; p < column.pipelines.size(); ++p) {
    fmt::print(kRow, column.pipelines[p].name, with_interval(summaries[p].horizontal_rmse_m, 1.0),
               with_interval(rmse_gain(column, p), 100.0), with_interval(summaries[p].horizontal_final_m, 1.0),
               with_interval(summaries[p].gain, 100.0), along_axes(column, p, &OutageErrors::position_rmse_m),
               along_axes(column, p, &OutageErrors::position_final_m),
               along_axes(column, p, &OutageErrors::velocity_rmse_mps),
               along_axes(column, p, &OutageErrors::velocity_final_mps));
  }
  std::fflush(stdout);
}

/// `physics` as it stands, beside it the same without calibration.
std::vector<Pipeline> held_out_pipelines(const nav::ErrorModel& model,
                                         const std::optional<nav::Correction>& calibration) {
  std::vector<Pipeline> pipelines = standard_pipelines(calibration);
  if (calibration) {
    pipelines.push_back(standard_pipelines({}).back());
    pipelines.back().name = "physics, raw";
  }
  const std::vector<std::string> names = {"wmra", "anfis_position", "anfis_updates"};
  auto further = further_pipelines(names, model);
  std::move(further.begin(), further.end(), std::back_inserter(pipelines));
  return pipelines;
}

/// The pipelines that stay as they have learnt and are always believed.
std::vector<Pipeline> believing_pipelines(const nav::ErrorModel& model) {
  return {nav::filter_pipeline(raw_filter()), nav::wmra_batch(raw_filter()),
          nav::anfis_position(raw_filter(), model, nav::Learning::off_line),
          nav::anfis_updates(raw_filter(), model, nav::Learning::off_line)};
}

void compare(const std::string& title, const std::vector<nav::Drive>& drives, std::size_t number,
             const std::vector<nav::Drive>& teachers, const std::optional<nav::Correction>& calibration) {
  Column by_heart;
  Column same_drive;
  Column held_out{held_out_pipelines(learnt_errors(teachers).value(), calibration), {}};
  held_out.pipelines.push_back(anfis_steps(learnt_steps(teachers)));
  for (const nav::Drive& drive : drives) {
    const auto outages = nav::spread_outages(drive, kFirst_s, kLength_s, number).value();
    by_heart.pipelines = believing_pipelines(learnt_by_heart(drive, outages));
    run_into(by_heart, drive, outages);
    same_drive.pipelines = believing_pipelines(learnt_errors({&drive, 1}).value());
    same_drive.pipelines.push_back(anfis_steps(learnt_steps({drive})));
    run_into(same_drive, drive, outages);
    run_into(held_out, drive, outages);
  }
  print((title + ": by heart (truth of the same outages)").c_str(), by_heart);
  print((title + ": same drive (its artificial outages, before and after)").c_str(), same_drive);
  print((title + ": held out").c_str(), held_out);
}

void compare_simulated(const nav::UnitErrors& errors) {
  std::vector<nav::Drive> drives;
  for (int d = 0; d < kDrives; ++d) drives.push_back(drive_of(errors, kSeed + static_cast<std::uint64_t>(d)));
  // The calibration leaves one hundredth of the curve, as in soak nav compare.
  const auto calibration =
      curve_correction([](calib::Sensor sensor, double temp_c) { return 0.99 * example_curve(sensor, temp_c); });
  compare("errors of " + errors.name, drives, kOutages, teachers_of(errors), calibration);
}

int run(int argc, char** argv) {
  for (const nav::UnitErrors& errors : {nav::ahrs400ca(), nav::motionpak2(), nav::isi()}) compare_simulated(errors);
  // Options of Google Benchmark go to all programs.
  if (argc < 2 || !std::string_view(argv[1]).ends_with(".toml")) return 0;
  const auto drive = read_drive(argv[1]);
  if (!drive) {
    fmt::print(stderr, "{}: {}\n", drive.error().where, drive.error().message);
    return 2;
  }
  compare(drive->name, {*drive}, kOutages, teachers_of(nav::ahrs400ca()), {});
  return 0;
}

}  // namespace
}  // namespace soak::station

int main(int argc, char** argv) { return soak::station::run(argc, argv); }
