// SPDX-License-Identifier: Apache-2.0
#include "station/lab/start_check.h"
#include "tests/errors.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using Axes = std::array<std::string, 3>;

constexpr const char* kProcedure = R"(name = "short"
purpose = "calibration"
kind = "soak"
runs = 2
[temperatures]
list_c = [0, 20]
[positions]
order = ["+X", "-X"]
[preflight]
position_s = 20
)";

const std::string kRating = "[rating]\ntemp_min_c = -40\ntemp_max_c = 85\n";

class StartCheck : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-start-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
    auto opened = db::Catalog::open(folder / "data");
    ASSERT_TRUE(opened) << opened.error().message;
    catalog = std::make_unique<db::Catalog>(*std::move(opened));
    config.unit_types = folder / "units";
    fs::create_directory(config.unit_types);
    add_type("plain", kRating);
    config.slots = {slot("A"), slot("B")};
    request.procedure_text = kProcedure;
    request.procedure_file = "short.toml";
    request.campaign = "c1";
    request.units = {{"A", "SN1"}};
    request.user = "eva";
  }
  void TearDown() override { fs::remove_all(folder); }

  static Slot slot(std::string name) {
    Slot slot;
    slot.name = std::move(name);
    slot.unit_type = "plain";
    return slot;
  }

  void add_type(const std::string& name, const std::string& text) const {
    std::ofstream(config.unit_types / (name + ".toml")) << "name = \"" << name << "\"\n" << text;
  }

  [[nodiscard]] base::Result<CheckedStart> check() const { return check_start(request, config, *catalog); }

  /// The request as it has been checked; throws where it is refused.
  [[nodiscard]] CheckedStart checked() const {
    auto result = check();
    if (!result) throw std::runtime_error(result.error().message);
    return *std::move(result);
  }

  /// Message of the refusal; "" where there is none.
  [[nodiscard]] std::string refusal() const {
    const auto result = check();
    if (result) return "";
    EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
    return result.error().message;
  }

  /// Where the refused mistake is; "" where nothing is refused.
  [[nodiscard]] std::string refused_at() const {
    const auto result = check();
    return result ? "" : result.error().where;
  }

  fs::path folder;
  std::unique_ptr<db::Catalog> catalog;
  StationConfig config;
  StartRequest request;
};

TEST_F(StartCheck, AnAhrs400NeedsTheRangesOfItsLabelInTheUnitType) {
  config.slots[0].decoder = hal::UnitDecoder::ahrs400;
  EXPECT_TRUE(base::mentions(refusal(), {"gyro.range_dps", "accel.range_mps2"}));
  add_type("plain", std::string(kRating) + "[gyro]\nrange_dps = 100\n[accel]\nrange_mps2 = 19.6133\n");
  EXPECT_EQ(refusal(), "");
}

TEST_F(StartCheck, TakesASoundRequest) {
  const CheckedStart start = checked();
  ASSERT_EQ(start.units.size(), 1U);
  EXPECT_EQ(start.units[0].serial, "SN1");
  EXPECT_EQ(start.units[0].slot.name, "A");
  EXPECT_EQ(start.units[0].type.name, "plain");
  ASSERT_EQ(start.plan.runs.size(), 3U);
  EXPECT_TRUE(start.plan.runs[0].preflight);
}

TEST_F(StartCheck, TakesTheConfiguredUnitsWhereTheRequestNamesNone) {
  request.units.clear();
  EXPECT_EQ(refused_at(), "--unit");
  config.slots[1].unit = "SN7";
  const CheckedStart start = checked();
  ASSERT_EQ(start.units.size(), 1U);
  EXPECT_EQ(start.units[0].serial, "SN7");
  EXPECT_EQ(start.units[0].slot.name, "B");
}

TEST_F(StartCheck, RefusesWhatNoLaboratoryCouldDo) {
  request.units = {{"A", "SN1"}, {"B", "SN1"}};
  EXPECT_TRUE(base::holds(refusal(), "SN1") && base::holds(refusal(), "slot A") && base::holds(refusal(), "slot B"))
      << refusal();
  request.units = {{"Q", "SN1"}};
  EXPECT_TRUE(base::holds(refusal(), "'Q'")) << refusal();
  request.units = {{"A", ""}};
  EXPECT_EQ(refused_at(), "--unit");
  request.units = {{"A", "SN1"}};
  request.campaign = "";
  EXPECT_EQ(refused_at(), "--name");
  request.campaign = "c1";
  request.procedure_text = "name = 3\n";
  EXPECT_TRUE(base::holds(refusal(), "short.toml:1")) << refusal();
}

TEST_F(StartCheck, AReviewTellsTheMistakesOfEachPartAndKeepsWhatIsSound) {
  request.units = {{"A", "SN1"}, {"B", "SN2"}, {"Q", "SN3"}};
  config.slots[1].unit_type = "";
  request.campaign = "";
  ReviewedStart reviewed = review_start(request, config, *catalog);
  EXPECT_TRUE(reviewed.procedure);
  ASSERT_EQ(reviewed.units.size(), 1U);
  EXPECT_EQ(reviewed.units[0].serial, "SN1");
  ASSERT_EQ(reviewed.mistakes.size(), 3U);
  EXPECT_EQ(reviewed.mistakes[0].where, "--name");
  EXPECT_EQ(reviewed.mistakes[1].where, "unit SN2");
  EXPECT_TRUE(base::holds(reviewed.mistakes[2].message, "'Q'")) << reviewed.mistakes[2].message;
  request.procedure_text = "name = 3\n";
  reviewed = review_start(request, config, *catalog);
  EXPECT_FALSE(reviewed.procedure);
  EXPECT_EQ(reviewed.units.size(), 1U);
  EXPECT_EQ(reviewed.mistakes.size(), 4U);
}

TEST_F(StartCheck, RefusesATurnOfTheFixtureThatTheRunFilesCouldNotSay) {
  request.procedure_text = kProcedure;
  request.procedure_text.replace(request.procedure_text.find("[preflight]"), 0, "turned_deg = 90\n");
  EXPECT_TRUE(base::holds(refusal(), "azimuths_deg")) << refusal();
  config.fixture.emplace();
  EXPECT_TRUE(base::holds(refusal(), "azimuths_deg")) << refusal();
  config.fixture->azimuths_deg = {0, 90, 90, 90, 270, 90};
  EXPECT_EQ(checked().plan.procedure.turned_deg, 90.0);
}

TEST_F(StartCheck, RefusesAUnitThatCannotBearTheTemperatures) {
  add_type("tender", "[rating]\ntemp_min_c = 5\ntemp_max_c = 60\n");
  config.slots[0].unit_type = "tender";
  EXPECT_TRUE(base::holds(refusal(), "'tender'")) << refusal();
  add_type("unrated", "");
  config.slots[0].unit_type = "unrated";
  EXPECT_TRUE(base::holds(refusal(), "'unrated'")) << refusal();
}

TEST_F(StartCheck, TheCatalogKnowsTheTypeBetterThanTheSlot) {
  add_type("known", kRating);
  ASSERT_TRUE(catalog->ensure_unit("SN1", "known"));
  EXPECT_EQ(checked().units[0].type.name, "known");
  request.units = {{"A", "SN2"}};
  EXPECT_EQ(checked().units[0].type.name, "plain");
  config.slots[0].unit_type = "";
  EXPECT_TRUE(base::holds(refusal(), "SN2")) << refusal();
}

TEST_F(StartCheck, TheAxesThatADeviceSendsAreComposedWithTheSlots) {
  add_type("turned", "axes = [\"-Y\", \"+X\", \"+Z\"]\n" + kRating);
  config.slots[0].unit_type = "turned";
  EXPECT_EQ(checked().units[0].slot.axes, (Axes{"-Y", "+X", "+Z"})) << "mounted straight";
  // The body's y along the fixture's -X: what the device calls x, -y of the body, is along +X.
  config.slots[0].axes = {"+Y", "-X", "+Z"};
  EXPECT_EQ(checked().units[0].slot.axes, (Axes{"+X", "+Y", "+Z"}));
}

TEST_F(StartCheck, EverySensorReadsWhatItsBodyAxisWouldRead) {
  const std::vector<Axes> frames = {
      {"+X", "+Y", "+Z"}, {"-Y", "+X", "+Z"}, {"+Z", "+X", "+Y"}, {"+X", "-Y", "-Z"}, {"-Z", "-Y", "-X"}};
  for (const Axes& sent : frames) {
    add_type("turned", "axes = [\"" + sent[0] + "\", \"" + sent[1] + "\", \"" + sent[2] + "\"]\n" + kRating);
    for (const Axes& mounted : frames) {
      config.slots[0].unit_type = "turned";
      config.slots[0].axes = mounted;
      const Slot own = checked().units[0].slot;
      for (const std::string_view up : calib::kSixPositionLabels) {
        const auto body = unit_position(config.slots[0], up).up;
        const auto device = unit_position(own, up).up;
        for (std::size_t i = 0; i < 3; ++i) {
          const auto axis = static_cast<std::size_t>(sent[i][1] - 'X');
          EXPECT_EQ(device[i], sent[i][0] == '-' ? -body[axis] : body[axis]) << sent[i] << " " << up;
        }
      }
    }
  }
}

TEST_F(StartCheck, AFarChamberIsRefusedOnlyWhereThePreflightComesFirst) {
  const CheckedStart start = checked();
  EXPECT_TRUE(check_room(start, 0, 25.0, 25.0));
  EXPECT_TRUE(check_room(start, 0, 25.0, 34.9));
  EXPECT_TRUE(check_room(start, 0, 25.0, 15.1));
  for (const double air_c : {35.1, 14.9, -30.0}) {
    const auto refused = check_room(start, 0, 25.0, air_c);
    ASSERT_FALSE(refused) << air_c;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(refused.error().where, "state");
  }
  EXPECT_TRUE(base::holds(check_room(start, 0, 25.0, -30.0).error().message, "-30.0 °C"));
  EXPECT_FALSE(check_room(start, start.plan.runs[0].last_step, 25.0, -30.0));
  EXPECT_TRUE(check_room(start, start.plan.runs[1].first_step, 25.0, -30.0)) << "a campaign that is resumed";
  request.procedure_text = std::string(kProcedure).replace(std::string(kProcedure).find("= 20\n"), 5, "= 0\n");
  EXPECT_TRUE(check_room(checked(), 0, 25.0, -30.0)) << "no pre-flight";
}

TEST_F(StartCheck, ADiskThatIsTooSmallForWhatIsLeftIsRefused) {
  CheckedStart start = checked();
  EXPECT_TRUE(check_disk(start, 0, folder));
  start.plan.steps[0].estimate_s = 1e15;
  const auto refused = check_disk(start, 0, folder);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(refused.error().where, folder.string());
  EXPECT_TRUE(base::holds(refused.error().message, " MB")) << refused.error().message;
  EXPECT_TRUE(check_disk(start, 1, folder)) << "that step is done";
}

TEST_F(StartCheck, ACampaignWithoutTheStationsCheckStandardIsNoted) {
  const auto note = [&] { return note_on_check_standards(*catalog, checked()).value(); };
  EXPECT_FALSE(note()) << "the station has none";
  ASSERT_TRUE(catalog->ensure_unit("CS1", "plain"));
  const std::string id =
      catalog->add_check_standard({.unit = "CS1", .since_utc_s = 1.0, .reason = "test", .user = "eva"}).value();
  ASSERT_TRUE(note());
  EXPECT_TRUE(base::holds(*note(), "CS1")) << *note();
  request.units["B"] = "CS1";
  EXPECT_FALSE(note());
  request.units.erase("B");
  request.procedure_text.replace(request.procedure_text.find("calibration"), 11, "verification");
  EXPECT_FALSE(note()) << "no chart holds it";
  request.procedure_text = kProcedure;
  ASSERT_TRUE(catalog->end_check_standard(id, {.reason = "dropped", .user = "eva", .utc_s = 2.0}));
  EXPECT_FALSE(note()) << "it has ended";
}

TEST_F(StartCheck, TheJournalGivesBackTheRequest) {
  db::CampaignRow row;
  row.name = request.campaign;
  row.document = start_document(request, checked(), {"a note"}).dump();
  const auto back = request_of(row);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->procedure_text, request.procedure_text);
  EXPECT_EQ(back->procedure_file, request.procedure_file);
  EXPECT_EQ(back->campaign, "c1");
  EXPECT_EQ(back->units, request.units);
  EXPECT_EQ(back->user, "eva");
  for (const char* damaged : {"", "{}", "[1", R"({"procedure_text": 3})"}) {
    row.document = damaged;
    const auto refused = request_of(row);
    ASSERT_FALSE(refused) << damaged;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::corrupt);
  }
}

class Resume : public StartCheck {
 protected:
  void SetUp() override {
    StartCheck::SetUp();
    prepare();
    start = checked();
    row.name = "c1";
    row.procedure = "short";
    row.document = start_document(request, start, {}).dump();
    row.created_utc_s = 1700000000.0;
    ASSERT_TRUE(catalog->begin_campaign(row));
  }

  void complete(std::size_t first, std::size_t last, const std::string& outcome = "done", int attempt = 0) {
    for (std::size_t i = first; i <= last; ++i) {
      db::StepRow step;
      step.campaign = "c1";
      step.index = static_cast<std::int32_t>(i);
      step.attempt = attempt;
      step.outcome = outcome;
      ASSERT_TRUE(catalog->complete_step(step)) << i;
    }
  }

  /// The first step of the way back.
  [[nodiscard]] base::Result<std::size_t> first_step(double room_c = 25.0) const {
    const auto way = way_to_resume(*catalog, row, room_c);
    if (!way) return base::forward_error(way);
    return way->steps.front();
  }

  /// Changes the request before it is checked.
  virtual void prepare() {}

  CheckedStart start;
  db::CampaignRow row;
};

class TurnedResume : public Resume {
 protected:
  void prepare() override {
    request.procedure_text.replace(request.procedure_text.find("[preflight]"), 0, "turned_deg = 90\n");
    config.fixture.emplace().azimuths_deg = {0, 90, 90, 90, 270, 90};
  }
};

TEST_F(TurnedResume, OfACampaignThatIsOverButForTheFixtureMeasuresNothingAgain) {
  const std::size_t last = start.plan.steps.size() - 1;
  complete(0, last - 2);
  EXPECT_EQ(first_step(), last - 1);
  complete(last - 1, last - 1);
  EXPECT_EQ(first_step(), last);
  complete(last, last);
  EXPECT_EQ(first_step(), last) << "only the campaign's own end is missing";
}

TEST_F(Resume, GoesOnWithTheFirstRunThatDidNotComeToItsEnd) {
  const auto& runs = start.plan.runs;
  EXPECT_EQ(first_step(), 0U);
  complete(runs[0].first_step, runs[0].last_step);
  EXPECT_EQ(first_step(), runs[1].first_step);
  complete(runs[1].first_step, runs[1].last_step - 1);
  EXPECT_EQ(first_step(), runs[1].last_step) << "nothing is left but to switch the units off";
  complete(runs[1].last_step, runs[1].last_step, "failed");
  EXPECT_EQ(first_step(), runs[1].last_step) << "failed";
  complete(runs[1].last_step, runs[1].last_step, "done", 1);
  EXPECT_EQ(first_step(), runs[2].first_step);
  complete(runs[2].first_step, runs[2].last_step);
  EXPECT_EQ(first_step(), runs[2].last_step) << "only the campaign's own end is missing";
}

TEST_F(Resume, RefusesAProcedureThatMakesAnotherPlanToday) {
  const auto refused = [&](double room_c) {
    const auto step = first_step(room_c);
    return !step && step.error().kind == base::ErrorKind::bad_input && step.error().where == "state";
  };
  ASSERT_EQ(first_step(), 0U);
  // The first ramp of a run goes up from here, and down from 25 °C.
  EXPECT_TRUE(refused(-10.0));
  auto document = nlohmann::json::parse(row.document);
  document["procedure_text"] = std::string(kProcedure) + "[stability]\nafter_turn_s = 45\n";
  row.document = document.dump();
  EXPECT_TRUE(refused(25.0));
  document["procedure_text"] = kProcedure;
  document["plan_sha256"] = std::string(64, '0');
  row.document = document.dump();
  EXPECT_TRUE(refused(25.0));
  document.erase("plan_sha256");
  row.document = document.dump();
  EXPECT_TRUE(refused(25.0));
}

}  // namespace
}  // namespace soak::station
