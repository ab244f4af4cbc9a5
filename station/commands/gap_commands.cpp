// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <cstdint>
#include "calib/forward/mechanisms.h"
#include "calib/gap/report/gap_report.h"
#include "calib/model/deployed_terms.h"
#include "calib/model/document_parts.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/fit/fit_unit.h"
#include "station/gap/gap_comparison.h"
#include "station/gap/gap_search.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/io/text_file.h"
#include "station/report/page.h"
#include "station/report/term_text.h"

namespace soak::station {
namespace {

using calib::gap::GapReport;
using calib::gap::NamedEffect;

/// What all gap commands take.
struct GapCommand : CatalogCommand {
  std::string unit;
  std::optional<std::string> campaign;

  void declare_unit(OptionList& options) { options.add("--unit SN", &unit, "Serial number of the unit").required(); }
  void declare_campaign(OptionList& options) {
    options.add("--campaign NAME", &campaign, "Use only runs of this campaign");
  }
};

void declare_gap_user(OptionList& options, std::string& user) {
  options.add("--user NAME", name_reader(user), "Name for the log (default: the user that runs the program)");
}

/// A named effect that does not go into the model.
struct NotAdded {
  std::string name;
  std::string why;  ///< a sentence
};

/// soak gap find: looks for what the unit's newest model lacks in the runs that a fit uses, less the effects that the
/// model contains already, and stores the report in the catalog. Fails (bad_input) for a unit without a model.
struct GapFind final : GapCommand {
  void declare(OptionList& options) override {
    declare_unit(options);
    declare_campaign(options);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak gap accept: finds the gap as GapFind does, adds the effects that it names to the terms of the unit's model, and
/// fits a new version to readings corrected for all of them. Says which it does not add, and why. Fails (bad_input) if
/// no effect is named, if none can be added, or if one is wanted that is not named or cannot be added.
struct GapAccept final : GapCommand {
  std::vector<std::string> effects;  ///< empty = all that are named
  bool suspect = false;              ///< suspects may be taken too
  std::string user;                  ///< empty = the user that runs the program

  void declare(OptionList& options) override {
    declare_unit(options);
    declare_campaign(options);
    options.add("--effect NAME", &effects, "Only this one of the effects that are named (may be repeated)");
    options.add("--suspect", &suspect, "Take the effect of --effect also where it is only suspected").needs("--effect");
    declare_gap_user(options, user);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak gap withdraw: fits a new version of the unit's model without an effect that was accepted. Fails (bad_input) for
/// an effect that the newest model does not contain.
struct GapWithdraw final : GapCommand {
  std::string effect;
  std::string reason;
  std::string user;  ///< empty = the user that runs the program

  void declare(OptionList& options) override {
    declare_unit(options);
    options.add("--effect NAME", &effect, "Name of the effect").required();
    options.add("--reason TEXT", &reason, "Reason, for the log").required();
    declare_gap_user(options, user);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak gap show: simulates the unit's runs with a model before and after its accepted effects and shows how far each
/// is from what was measured, on runs that the model was fitted to and on fresh ones. Fails (bad_input) for a unit
/// without a model.
struct GapShow final : GapCommand {
  std::optional<std::int32_t> model;  ///< absent = the newest
  std::string file;                   ///< empty = text only

  void declare(OptionList& options) override {
    declare_unit(options);
    options.add("--model V", &model, "Model version (default: the newest)").range(1, 1000000);
    declare_campaign(options);
    options.add("-o,--output FILE.html", &file, "Also write a page with pictures to this file");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// "moisture (odds 1 to 40)"; "3 to 1" for one that is the likelier.
std::string rival_text(const calib::gap::Rival& rival) {
  if (!rival.odds) return std::string(rival.effect->name);
  constexpr double kLeast = 1e-6;
  if (*rival.odds < kLeast) return fmt::format("{} (odds below 1 to a million)", rival.effect->name);
  if (*rival.odds > 1.0) return fmt::format("{} (odds {:.2g} to 1)", rival.effect->name, *rival.odds);
  return fmt::format("{} (odds 1 to {:.2g})", rival.effect->name, 1.0 / *rival.odds);
}

std::string effect_text(const NamedEffect& effect, const std::string& next_experiment) {
  std::string text = fmt::format("  {}\n    {}\n    probability that noise alone looks like this: {:.2g}\n",
                                 size_text(effect.effect->name, effect.magnitude.value, effect.magnitude.unit,
                                           effect.candidate.shape, sensors_text(effect.sensors)),
                                 effect.effect->physics, effect.p_adjusted);
  if (!effect.rivals.empty()) {
    std::vector<std::string> rivals;
    for (const calib::gap::Rival& rival : effect.rivals) rivals.push_back(rival_text(rival));
    text += fmt::format("    nearly as good: {}\n", fmt::join(rivals, ", "));
  }
  if (!next_experiment.empty()) {
    text += fmt::format("    next experiment: {}\n", next_experiment);
  }
  return text;
}

std::string gap_table(const GapReport& report) {
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "before", "after", "noise floor", "closed", "95 %", "detectable"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& gap = report.gap[calib::index_of(sensor)];
    const auto& limit = report.detection_limit[calib::index_of(sensor)];
    if (!gap) continue;
    const double factor = calib::printed_per_si(sensor);
    table.push_back({std::string(calib::name_of(sensor)), std::string(calib::printed_unit(sensor)),
                     fmt::format("{:.3g}", gap->before_rms * factor), fmt::format("{:.3g}", gap->after_rms * factor),
                     fmt::format("{:.3g}", gap->floor_rms * factor),
                     gap->closed_fraction ? fmt::format("{:.0f} %", 100.0 * *gap->closed_fraction)
                     : report.judged_on == calib::gap::JudgedOn::runs ? "too small to tell"
                                                                      : "-",
                     gap->closed_ci95 ? fmt::format("{:.0f}..{:.0f} %", 100.0 * gap->closed_ci95->first,
                                                    100.0 * gap->closed_ci95->second)
                                      : "-",
                     limit ? fmt::format("{:.2g}", *limit * factor) : "-"});
  }
  return text_table(table);
}

std::string_view judged_on_text(calib::gap::JudgedOn judged_on) {
  return judged_on == calib::gap::JudgedOn::runs       ? "runs"
         : judged_on == calib::gap::JudgedOn::branches ? "branches"
                                                       : "half the difference between branches";
}

/// What the data gate rejected, a line for each run and sensor.
std::string rejected_text(const GapReport& report) {
  std::string text;
  for (const calib::gap::GateRejection& entry : report.rejections) {
    text += fmt::format("rejected by the data gate: run {}{}: {} of {} segments ({}): {}\n", entry.run,
                        entry.sensor ? fmt::format(", {}", calib::name_of(*entry.sensor)) : "", entry.segments,
                        entry.of, entry.code, entry.why);
  }
  return text;
}

/// The reason without the notes, which come after the table.
std::string plain_reason(const GapReport& report) {
  std::string reason = report.reason;
  for (const calib::Warning& note : report.notes) {
    const std::size_t at = reason.find("; " + note.text);
    if (at != std::string::npos) reason.erase(at, note.text.size() + 2);
  }
  return reason;
}

std::string gap_report_text(const GapReport& report) {
  std::string text = fmt::format("unit {}, model {}: {}\n{}\n", report.unit, report.model,
                                 calib::gap::name_of(report.conclusion), plain_reason(report));
  for (std::size_t e = 0; e < report.effects.size(); ++e) {
    text += effect_text(report.effects[e], report.next.at(e).text);
  }
  if (!report.suspects.empty()) {
    text += "possible, but not certain enough to be named:\n";
    for (const NamedEffect& effect : report.suspects) text += effect_text(effect, "");
  }
  if (report.conclusion != calib::gap::Conclusion::cannot_judge) {
    text += fmt::format("\ngap on {} that were not used for the fit (RMS of {} means):\n{}",
                        judged_on_text(report.judged_on),
                        report.judged_on == calib::gap::JudgedOn::runs ? "one-minute" : "30-second", gap_table(report));
  }
  for (const calib::Warning& note : report.notes) text += fmt::format("note: {}\n", note.text);
  for (const auto& entry : report.not_testable) text += fmt::format("not testable: {}: {}\n", entry.name, entry.why);
  return text + rejected_text(report);
}

base::Status GapFind::run_with(db::Catalog& catalog, Output& output) {
  const auto search = search_gap(catalog, unit, campaign);
  if (!search) return base::forward_error(search);
  const nlohmann::json document = calib::gap::gap_json(search->report);
  if (auto stored = catalog.add_gap_report({unit, search->model.version, now_utc_s(), document.dump()}); !stored) {
    return stored;
  }
  for (const std::string& sentence : search->not_taken_off) output.note("warning: " + sentence);
  if (output.json()) return output.print_json(document);
  output.print(gap_report_text(search->report));
  return {};
}

/// Fits `parent` again to readings corrected for `terms`, and logs why.
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

/// The size of each term, and where it is corrected.
base::Result<std::string> terms_text(const db::Catalog& catalog, const std::string& unit,
                                     const std::vector<calib::ModelTerm>& terms) {
  std::string text;
  for (const calib::ModelTerm& term : terms) {
    const auto lines = size_lines(catalog, unit, term);
    if (!lines) return base::forward_error(lines);
    for (const std::string& line : *lines) {
      text += fmt::format("  {}{}\n", line, term.lab_only ? " (lab only)" : " (in the calibration file)");
    }
  }
  return text;
}

/// `not_added`: effects that were named and are not among the new terms.
base::Status print_new_version(const db::Catalog& catalog, const calib::UnitModel& model, std::int32_t parent,
                               const std::vector<NotAdded>& not_added, Output& output) {
  for (const calib::Warning& warning : model.warnings) output.note("warning: " + warning.text);
  if (output.json()) {
    nlohmann::json left = nlohmann::json::array();
    for (const NotAdded& entry : not_added) left.push_back({{"name", entry.name}, {"why", entry.why}});
    return output.print_json({{"unit", model.unit},
                              {"parent", parent},
                              {"model", model.version},
                              {"terms", calib::terms_json(model.terms)},
                              {"not_added", std::move(left)}});
  }
  std::string text = fmt::format("unit {}: model {} follows model {}; it contains {}\n", model.unit, model.version,
                                 parent, model.terms.empty() ? "no accepted effect" : "these accepted effects:");
  const auto terms = terms_text(catalog, model.unit, model.terms);
  if (!terms) return base::forward_error(terms);
  text += *terms;
  for (const NotAdded& entry : not_added) text += fmt::format("not added: {}: {}\n", entry.name, entry.why);
  if (!model.terms.empty()) {
    text += fmt::format("'soak gap show --unit {}' shows the gap before and after\n\n{}", model.unit,
                        parameter_table(model.terms));
  }
  output.print(text);
  return {};
}

/// An effect that is found again was estimated wrongly, and a second term of that name would hide it: it moves from the
/// terms to those that are not added, which are returned.
std::vector<NotAdded> leave_contained(const std::string& unit, const std::vector<calib::ModelTerm>& carried,
                                      std::vector<calib::ModelTerm>& found) {
  std::vector<NotAdded> not_added;
  for (const calib::ModelTerm& known : carried) {
    const auto again = std::erase_if(found, [&](const calib::ModelTerm& term) { return term.name == known.name; });
    if (again == 0) continue;
    not_added.push_back(
        {known.name, fmt::format("the model already contains {0}, but the runs show more of it: withdraw it ('soak gap "
                                 "withdraw --unit {1} --effect {0} --reason ...'), then find and accept it again",
                                 known.name, unit)});
  }
  return not_added;
}

/// Each later fit takes accepted terms off the samples of all runs of the unit.
base::Status check_samples_are_there(const db::Catalog& catalog, const std::string& serial) {
  const auto row = find_unit(catalog, serial);
  if (!row) return base::forward_error(row);
  const auto runs = catalog.runs({.unit = serial, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  for (const db::RunRow& run : *runs) {
    if (!run.samples_dropped || run.voided || run.epoch != row->epoch || run.purpose == "diagnosis") continue;
    return base::bad_input(
        fmt::format("a term is taken off the samples of all runs of unit {}, and those of run '{}' were dropped. "
                    "Exclude such runs first: 'soak runs void {} --unit {} --reason TEXT'",
                    serial, run.label, run.run_id, serial),
        serial);
  }
  return {};
}

base::Status GapAccept::run_with(db::Catalog& catalog, Output& output) {
  auto search = search_gap(catalog, unit, campaign);
  if (!search) return base::forward_error(search);
  using calib::gap::Accepted;
  auto found = calib::gap::accepted_terms(search->campaign, search->report, effects,
                                          suspect ? Accepted::suspected : Accepted::named);
  if (!found) return base::forward_error(found);
  const std::vector<NotAdded> not_added = leave_contained(unit, search->terms, *found);
  // Who asks for an effect by name wants that one, not the rest.
  if (found->empty() || (!effects.empty() && !not_added.empty())) return base::bad_input(not_added.back().why);
  calib::forward::centre(search->campaign, *found);
  calib::keep_in_the_lab_what_no_file_carries(*found);
  std::string names;
  for (const calib::ModelTerm& term : *found) names += (names.empty() ? "" : ", ") + term.name;
  if (auto there = check_samples_are_there(catalog, unit); !there) return there;
  std::vector<calib::ModelTerm> terms = search->terms;
  std::move(found->begin(), found->end(), std::back_inserter(terms));
  auto stored =
      catalog.add_gap_report({unit, search->model.version, now_utc_s(), calib::gap::gap_json(search->report).dump()});
  if (!stored) return stored;
  const auto model =
      refit(catalog, search->model, terms, "gap_accepted", fmt::format("{} accepted by {}", names, user_name(user)));
  if (!model) return base::forward_error(model);
  return print_new_version(catalog, *model, search->model.version, not_added, output);
}

base::Status GapWithdraw::run_with(db::Catalog& catalog, Output& output) {
  if (auto plain = check_text_line(reason, "--reason"); !plain) return plain;
  const auto row = find_unit(catalog, unit);
  if (!row) return base::forward_error(row);
  auto terms = accepted_terms(catalog, unit, row->epoch);
  if (!terms) return base::forward_error(terms);
  const auto left = std::erase_if(*terms, [&](const calib::ModelTerm& term) { return term.name == effect; });
  if (left == 0) {
    return base::bad_input(fmt::format(
        "the newest model of unit {} contains no accepted effect '{}': 'soak gap show' lists them", unit, effect));
  }
  const auto parent = catalog.model(unit);
  if (!parent) return base::forward_error(parent);
  const auto model = refit(catalog, **parent, *terms, "gap_withdrawn",
                           fmt::format("{} withdrawn by {}: {}", effect, user_name(user), reason));
  if (!model) return base::forward_error(model);
  return print_new_version(catalog, *model, (*parent)->version, {}, output);
}

std::vector<std::string> comparison_row(calib::Sensor sensor, const SensorComparison& figures, const std::string& runs,
                                        const std::string& closed) {
  const double factor = calib::printed_per_si(sensor);
  const auto text = [&](double value) { return fmt::format("{:.3g}", value * factor); };
  return {std::string(calib::name_of(sensor)),
          std::string(calib::printed_unit(sensor)),
          runs,
          text(figures.before_rms),
          text(figures.after_rms),
          figures.floor_rms ? text(*figures.floor_rms) : "-",
          text(figures.noise_rms),
          closed};
}

std::string closed_text(const SensorComparison& figures) {
  return figures.closed_fraction ? fmt::format("{:.0f} %", 100.0 * *figures.closed_fraction) : "too small to tell";
}

/// What fresh runs say of the sensor in which the gap has changed most, of those that an effect acts on.
std::string result_text(const GapComparison& comparison) {
  const auto ratio = [](const SensorComparison& fresh) {
    return std::abs(std::log(fresh.after_rms / fresh.before_rms));
  };
  std::optional<calib::Sensor> most;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& fresh = comparison.fresh[calib::index_of(sensor)];
    const bool acted_on = std::ranges::any_of(
        comparison.terms, [&](const calib::ModelTerm& term) { return term.part_of(sensor) != nullptr; });
    if (!fresh || !acted_on) continue;
    if (!most || ratio(*fresh) > ratio(*comparison.fresh[calib::index_of(*most)])) most = sensor;
  }
  if (!most) return {};
  const SensorComparison& fresh = *comparison.fresh[calib::index_of(*most)];
  const double factor = calib::printed_per_si(*most);
  const std::string floor = fresh.floor_rms ? fmt::format(" (floor {:.3g})", *fresh.floor_rms * factor) : "";
  return fmt::format("on fresh runs the gap of {} went from {:.3g} to {:.3g} {}{}: the largest change\n",
                     calib::name_of(*most), fresh.before_rms * factor, fresh.after_rms * factor,
                     calib::printed_unit(*most), floor);
}

/// Length of the blocks that are compared, in words.
std::string_view block_words(const GapComparison& comparison) {
  return comparison.at_plateaus ? "one-minute" : "30-second";
}

base::Result<std::string> comparison_text(const db::Catalog& catalog, const GapComparison& comparison) {
  std::string text = fmt::format("unit {}: measurement minus simulation, with model {} and with model {}\n",
                                 comparison.unit, comparison.before, comparison.model);
  if (comparison.terms.empty()) text += "the model contains no accepted effect: before and after are the same\n";
  const auto terms = terms_text(catalog, comparison.unit, comparison.terms);
  if (!terms) return base::forward_error(terms);
  text += *terms + result_text(comparison) + "\n";
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "runs", "before", "after", "floor", "noise", "closed"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    if (comparison.fitted[s]) table.push_back(comparison_row(sensor, *comparison.fitted[s], "fitted", "-"));
    if (comparison.fresh[s])
      table.push_back(comparison_row(sensor, *comparison.fresh[s], "fresh", closed_text(*comparison.fresh[s])));
  }
  text += fmt::format(
      "{}RMS of {} blocks about each run's own mean. fresh: runs that neither model was fitted to; floor: what noise "
      "and\nrun-to-run scatter would leave with a perfect model (fitted runs lie below it, because the fit follows "
      "part of their noise)\n",
      text_table(table), block_words(comparison));
  for (const std::string& sentence : remarks(comparison)) text += sentence + "\n";
  return text;
}

base::Status GapShow::run_with(db::Catalog& catalog, Output& output) {
  const auto comparison = compare_gap(catalog, unit, model, campaign);
  if (!comparison) return base::forward_error(comparison);
  if (!file.empty()) {
    const std::string page = gap_page(*comparison, "soak " + software_version(), now_utc_s());
    if (const auto written = write_text_file(file, page); !written) return written;
  }
  for (const std::string& sentence : comparison->simulated_after.not_evaluated) output.note("warning: " + sentence);
  if (output.json()) return output.print_json(comparison_json(*comparison));
  const auto text = comparison_text(catalog, *comparison);
  if (!text) return base::forward_error(text);
  output.print(*text);
  return {};
}

}  // namespace

CommandGroup gap_commands() {
  return {"gap",
          "Difference between simulation and measurement, and which effect causes it",
          {{"find", "Find the effect that a unit's model lacks", "soak gap find --unit SN0042",
            std::make_shared<GapFind>()},
           {"accept", "Add the effects that were found to the model: a new version", "soak gap accept --unit SN0042",
            std::make_shared<GapAccept>()},
           {"withdraw", "Remove an accepted effect from the model: a new version",
            "soak gap withdraw --unit SN0042 --effect temperature_rate --reason 'longer soak: it was hysteresis'",
            std::make_shared<GapWithdraw>()},
           {"show", "Simulate the runs with the model before and after the accepted effects",
            "soak gap show --unit SN0042 -o gap.html", std::make_shared<GapShow>()}}};
}

}  // namespace soak::station
