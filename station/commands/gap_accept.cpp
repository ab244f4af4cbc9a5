// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calib/forward/mechanisms.h"
#include "calib/gap/report/acceptance.h"
#include "calib/gap/report/gap_json.h"
#include "calib/model/model_term_json.h"
#include "station/commands/gap_commands.h"
#include "station/fit/accepted_terms.h"
#include "station/fit/fit_job.h"
#include "station/fit/fit_unit.h"
#include "station/gap/gap_search.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

std::string who(const std::string& given) { return given.empty() ? user_name() : given; }

/// Fits `parent` again, freed of `terms`, and logs why.
base::Result<calib::UnitModel> refit(db::Catalog& catalog, const db::ModelRow& parent,
                                     const std::vector<calib::ModelTerm>& terms, const std::string& event_kind,
                                     const std::string& event_text) {
  auto model = fit_again(catalog, parent, terms);
  if (!model) return model;
  const auto logged = catalog.log_event(
      {now_utc_s(), event_kind, parent.unit, fmt::format("model {}: {}", model->version, event_text)});
  if (!logged) return base::forward_error(logged);
  return model;
}

std::string parameters_text(const calib::TermPart& part) {
  std::string text;
  for (const calib::TermParameter& parameter : part.parameters) {
    text += fmt::format("{}{} = {:.4g}", text.empty() ? "" : ", ", parameter.name, parameter.value);
    if (parameter.unit != "1") text += " " + parameter.unit;
  }
  return text;
}

std::string describe(const calib::ModelTerm& term) {
  std::string text = fmt::format("  {}{}\n", term.name, term.lab_only ? " (lab only)" : " (in the calibration file)");
  for (const calib::TermPart& part : term.parts) {
    std::string sensors;
    for (const calib::Sensor sensor : part.sensors) {
      sensors += (sensors.empty() ? "" : ", ") + std::string(calib::name_of(sensor));
    }
    text += fmt::format("    {}: {}\n", sensors, parameters_text(part));
  }
  return text;
}

base::Status print(const calib::UnitModel& model, std::int32_t parent, Output& output) {
  for (const calib::Warning& warning : model.warnings) output.note("warning: " + warning.text);
  if (output.json()) {
    return output.print_json({{"unit", model.unit},
                              {"parent", parent},
                              {"model", model.version},
                              {"terms", calib::terms_json(model.terms)}});
  }
  std::string text = fmt::format("unit {}: model {} follows model {}; it carries {}\n", model.unit, model.version,
                                 parent, model.terms.empty() ? "no accepted effect" : "these accepted effects:");
  for (const calib::ModelTerm& term : model.terms) text += describe(term);
  if (!model.terms.empty())
    text += fmt::format("'soak gap show --unit {}' shows the gap before and after\n", model.unit);
  output.print(text);
  return {};
}

/// What is named again is what is still missing: a second term of one name would hide that the first is wrong.
base::Status refuse_twice(const std::string& unit, const std::vector<calib::ModelTerm>& carried,
                          const std::vector<calib::ModelTerm>& found) {
  for (const calib::ModelTerm& term : found) {
    const bool known = std::any_of(carried.begin(), carried.end(),
                                   [&](const calib::ModelTerm& other) { return other.name == term.name; });
    if (known) {
      return base::bad_input(
          fmt::format("the model carries {0} already, and the runs show more of it: withdraw it ('soak gap withdraw "
                      "--unit {1} --effect {0} --reason ...'), then find and accept anew",
                      term.name, unit));
    }
  }
  return {};
}

}  // namespace

base::Status run_gap_accept(const GapAcceptCommand& command, Output& output) {
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  auto search = search_gap(*catalog, command.unit, command.campaign);
  if (!search) return base::forward_error(search);
  auto found = calib::gap::accepted_terms(search->campaign, search->report, command.effects);
  if (!found) return base::forward_error(found);
  if (auto twice = refuse_twice(command.unit, search->terms, *found); !twice) return twice;
  calib::forward::centre(search->campaign, *found);
  std::string names;
  for (const calib::ModelTerm& term : *found) names += (names.empty() ? "" : ", ") + term.name;
  std::vector<calib::ModelTerm> terms = search->terms;
  std::move(found->begin(), found->end(), std::back_inserter(terms));
  auto stored = catalog->add_gap_report(
      {command.unit, search->model.version, now_utc_s(), calib::gap::gap_json(search->report).dump()});
  if (!stored) return stored;
  const auto model =
      refit(*catalog, search->model, terms, "gap_accepted", fmt::format("{} accepted by {}", names, who(command.user)));
  if (!model) return base::forward_error(model);
  return print(*model, search->model.version, output);
}

base::Status run_gap_withdraw(const GapWithdrawCommand& command, Output& output) {
  if (command.reason.empty()) return base::bad_input("a withdrawal needs a reason", "--reason");
  if (auto plain = check_text_line(command.reason, "--reason"); !plain) return plain;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto unit = catalog->unit(command.unit);
  if (!unit) return base::forward_error(unit);
  if (!*unit) {
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", command.unit));
  }
  auto terms = accepted_terms(*catalog, command.unit, (*unit)->epoch);
  if (!terms) return base::forward_error(terms);
  const auto left = std::erase_if(*terms, [&](const calib::ModelTerm& term) { return term.name == command.effect; });
  if (left == 0) {
    return base::bad_input(
        fmt::format("the newest model of unit {} carries no accepted effect '{}'; 'soak gap show' lists them",
                    command.unit, command.effect));
  }
  const auto parent = catalog->model(command.unit);
  if (!parent) return base::forward_error(parent);
  const auto model = refit(*catalog, **parent, *terms, "gap_withdrawn",
                           fmt::format("{} withdrawn by {}: {}", command.effect, who(command.user), command.reason));
  if (!model) return base::forward_error(model);
  return print(*model, (*parent)->version, output);
}

}  // namespace soak::station
