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
#include "station/report/gap_text.h"
#include "station/report/gap_words.h"
#include "station/report/page.h"
#include "station/report/term_text.h"

namespace soak::station {
namespace {

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

base::Status GapFind::run_with(db::Catalog& catalog, Output& output) {
  auto search = search_gap(catalog, unit, campaign, [&](std::string_view what) { output.begin(what); });
  if (!search) return base::forward_error(search);
  output.begin("resting");
  if (const auto beside = set_beside_rest(catalog, *search); !beside) return base::forward_error(beside);
  const nlohmann::json document = calib::gap::gap_json(search->report);
  if (auto stored = catalog.add_gap_report({unit, search->model.version, now_utc_s(), document.dump()}); !stored) {
    return stored;
  }
  for (const std::string& sentence : search->warnings) output.note("warning: " + sentence);
  if (output.json()) return output.print_json(document);
  output.print(find_text(search->report, search->terms));
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

/// The sizes of each term, as size_lines() has them.
base::Result<std::vector<std::vector<std::string>>> sizes_of(const db::Catalog& catalog, const std::string& unit,
                                                             const std::vector<calib::ModelTerm>& terms) {
  std::vector<std::vector<std::string>> sizes;
  for (const calib::ModelTerm& term : terms) {
    auto lines = size_lines(catalog, unit, term);
    if (!lines) return base::forward_error(lines);
    sizes.push_back(*std::move(lines));
  }
  return sizes;
}

/// What `gap accept` says first; `added`: the new terms.
base::Result<ThreeSentences> accepted_sentences(const db::Catalog& catalog, const calib::UnitModel& model,
                                                const std::vector<calib::ModelTerm>& added) {
  const auto sizes = sizes_of(catalog, model.unit, added);
  if (!sizes) return base::forward_error(sizes);
  std::vector<std::string_view> in_the_lab;
  for (const calib::ModelTerm& term : added) {
    if (term.lab_only) in_the_lab.push_back(term.name);
  }
  return ThreeSentences{
      fmt::format("Unit {}: model {} now takes this off: {}.", model.unit, model.version, terms_words(added, *sizes)),
      fmt::format(
          "Whether that is right is not proved yet: only a run that no fit has seen shows it{}.",
          in_the_lab.empty() ? "" : fmt::format("; the unit itself cannot correct {}", fmt::join(in_the_lab, ", "))),
      fmt::format("Next: record one with a procedure whose purpose is verification, then 'soak gap show --unit {}'.",
                  model.unit)};
}

/// What `gap withdraw` says first.
ThreeSentences withdrawn_sentences(const calib::UnitModel& model, std::int32_t parent, const std::string& effect) {
  return {
      fmt::format("Unit {}: model {} does not contain {} any more.", model.unit, model.version, effect),
      fmt::format("Its curves were fitted again to readings that hold the effect; model {} stays as it was.", parent),
      fmt::format("Next: 'soak gap find --unit {}' shows what the model lacks now.", model.unit)};
}

/// A new version, and what is told of it.
struct NewVersion {
  const calib::UnitModel& model;
  std::int32_t parent = 0;
  ThreeSentences sentences;
  std::vector<NotAdded> not_added;  ///< effects that were named and are not among the new terms
};

base::Status print_new_version(const db::Catalog& catalog, const NewVersion& made, Output& output) {
  const calib::UnitModel& model = made.model;
  for (const calib::Warning& warning : model.warnings) output.note("warning: " + warning.text);
  if (output.json()) {
    nlohmann::json left = nlohmann::json::array();
    for (const NotAdded& entry : made.not_added) left.push_back({{"name", entry.name}, {"why", entry.why}});
    return output.print_json({{"unit", model.unit},
                              {"parent", made.parent},
                              {"model", model.version},
                              {"terms", calib::terms_json(model.terms)},
                              {"not_added", std::move(left)}});
  }
  const auto sizes = sizes_of(catalog, model.unit, model.terms);
  if (!sizes) return base::forward_error(sizes);
  std::string text = fmt::format(
      "{}\n\nmodel {} follows model {}; it contains {}\n{}", fmt::join(made.sentences, "\n"), model.version,
      made.parent,
      model.terms.empty() ? "no accepted effect" : "these accepted effects:", terms_text(model.terms, *sizes));
  for (const NotAdded& entry : made.not_added) text += fmt::format("not added: {}: {}\n", entry.name, entry.why);
  if (!model.terms.empty()) text += "\n" + parameter_table(model.terms);
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
  auto search = search_gap(catalog, unit, campaign, [&](std::string_view what) { output.begin(what); });
  if (!search) return base::forward_error(search);
  using calib::gap::Accepted;
  if (const auto beside = set_beside_rest_as_found(catalog, *search); !beside) return base::forward_error(beside);
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
  terms.insert(terms.end(), found->begin(), found->end());
  auto stored =
      catalog.add_gap_report({unit, search->model.version, now_utc_s(), calib::gap::gap_json(search->report).dump()});
  if (!stored) return stored;
  output.begin("fitting");
  const auto model =
      refit(catalog, search->model, terms, "gap_accepted", fmt::format("{} accepted by {}", names, user_name(user)));
  if (!model) return base::forward_error(model);
  const auto sentences = accepted_sentences(catalog, *model, *found);
  if (!sentences) return base::forward_error(sentences);
  return print_new_version(catalog, {*model, search->model.version, *sentences, not_added}, output);
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
  const std::int32_t version = (*parent)->version;
  return print_new_version(catalog, {*model, version, withdrawn_sentences(*model, version, effect), {}}, output);
}

base::Status GapShow::run_with(db::Catalog& catalog, Output& output) {
  const auto comparison = compare_gap(catalog, unit, model, campaign);
  if (!comparison) return base::forward_error(comparison);
  const auto sizes = sizes_of(catalog, unit, comparison->terms);
  if (!sizes) return base::forward_error(sizes);
  const ThreeSentences sentences = sentences_of(*comparison, terms_words(comparison->terms, *sizes));
  if (!file.empty()) {
    const std::string page = gap_page(*comparison, sentences, "soak " + software_version(), now_utc_s());
    if (const auto written = write_text_file(file, page); !written) return written;
  }
  for (const std::string& sentence : comparison->simulated_after.not_evaluated) output.note("warning: " + sentence);
  if (output.json()) return output.print_json(comparison_json(*comparison));
  output.print(show_text(*comparison, sentences, *sizes));
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
