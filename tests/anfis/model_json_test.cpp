// SPDX-License-Identifier: Apache-2.0
#include "anfis/persist/model_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "anfis/train/learner.h"
#include "sample_models.h"
#include "support.h"

namespace soak::anfis {
namespace {

Model trained(Shape shape, int order) {
  const TrainingData data = test::drift_problem(1, 4).data;
  return train_hybrid(test::grid(data, 6, shape, order), data, {.epochs = 5})->model;
}

// Two inputs, kAny, dropped gains, names, the minimum, every shape.
Model rich_model() {
  Model model;
  model.t_norm = TNorm::minimum;
  model.inputs = {{"temperature", {20.0, 50.0}, -30.0, 70.0, {}},
                  {"rate \"of\" change", {0.1, 1.0 / 3.0}, -1.0, 1.0, {}}};
  model.output = {1e-300, 1e-7};
  model.inputs[0].memberships = {bell(0.1, 1.0 / 3.0, -0.7), gaussian(0.3, 0.2), {Shape::triangle, {-0.1, 0.0, 1e100}}};
  model.inputs[1].memberships = {{Shape::two_sided_gaussian, {0.1, -0.2, 0.3, 0.4}},
                                 {Shape::trapezoid, {-5e-324, 0.1, 0.1, 0.7}}};
  model.rules = {
      {{0, kAny}, {0.1, 0.0}, -0.3, {1}}, {{2, 1}, {0.0, 0.0}, 0.7, {0, 1}}, {{kAny, 0}, {1e-17, 2.5}, 0.0, {}}};
  return model;
}

TEST(ModelJson, ReadsBackExactlyTheSameNumbersFromText) {
  std::vector<Model> models = {rich_model()};
  for (const Shape shape : kShapes) {
    for (const int order : {0, 1}) models.push_back(trained(shape, order));
  }
  for (const Model& model : models) {
    const auto json = model_to_json(model);
    ASSERT_TRUE(json) << json.error().message << json.error().where;
    const auto back = model_from_json(nlohmann::json::parse(json->dump()));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(*back, model);
  }
}

TEST(ModelJson, RefusesToWriteWhatIsNotFinite) {
  Model model = trained(Shape::bell, 1);
  model.rules[2].gains[0] = std::nan("");
  EXPECT_EQ(model_to_json(model).error().where, "rules[2].gains[0]");
}

bool refused(nlohmann::json bad, void (*change)(nlohmann::json&)) {
  change(bad);
  const auto model = model_from_json(bad);
  return !model && model.error().kind == base::ErrorKind::corrupt;
}

TEST(ModelJson, RefusesDocumentsThatAreNotAModel) {
  const nlohmann::json good = *model_to_json(trained(Shape::bell, 1));
  EXPECT_FALSE(refused(good, [](auto&) {}));
  EXPECT_TRUE(refused(good, [](auto& j) { j = 3; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["format"] = "other"; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["version"] = 3; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["version"] = 1; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["t_norm"] = "sum"; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["inputs"][0]["memberships"][1]["shape"] = "pentagon"; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["inputs"][0]["memberships"][0]["width"] = -1; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["inputs"][0]["memberships"][0].erase("slope"); }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["inputs"][0]["memberships"].erase(5); }));  // rule 5 asks for it
  EXPECT_TRUE(refused(good, [](auto& j) { j["rules"] = 7; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["rules"][0]["gains"] = nullptr; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["rules"][0]["gains"] = {1.0, 2.0}; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["rules"][0]["premise"][0] = "first"; }));
}

TEST(ModelJson, RefusesDocumentsWithAMemberMissing) {
  const nlohmann::json good = *model_to_json(trained(Shape::bell, 1));
  for (const char* member : {"t_norm", "order", "inputs", "output", "rules", "format", "version"}) {
    nlohmann::json bad = good;
    bad.erase(member);
    const auto model = model_from_json(bad);
    ASSERT_FALSE(model) << member;
    EXPECT_EQ(model.error().kind, base::ErrorKind::corrupt) << member;
  }
  for (const char* member : {"centre", "half_range", "min", "max", "memberships"}) {
    nlohmann::json bad = good;
    bad["inputs"][0].erase(member);
    EXPECT_FALSE(model_from_json(bad)) << member;
  }
  for (const char* member : {"premise", "gains", "offset"}) {
    nlohmann::json bad = good;
    bad["rules"][2].erase(member);
    EXPECT_FALSE(model_from_json(bad)) << member;
  }
}

// Numbers that fit no int must not come back as other ones.
TEST(ModelJson, RefusesWholeNumbersThatAreNone) {
  const nlohmann::json good = *model_to_json(trained(Shape::bell, 1));
  EXPECT_TRUE(refused(good, [](auto& j) { j["order"] = 1.5; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["rules"][0]["premise"][0] = 4294967296; }));
  EXPECT_TRUE(refused(good, [](auto& j) { j["rules"][0]["premise"][0] = 0.5; }));
}

nlohmann::json nested(int depth) {
  std::string text(static_cast<std::size_t>(depth), '[');
  text += std::string(static_cast<std::size_t>(depth), ']');
  return nlohmann::json::parse(text);
}

TEST(ModelJson, RefusesForeignValuesWithoutRepeatingThem) {
  nlohmann::json good = *model_to_json(test::grid_sample(Shape::bell, TNorm::product, 1).model);
  for (const char* member : {"version", "order", "t_norm"}) {
    nlohmann::json bad = good;
    bad[member] = nested(100000);  // to print it would exhaust the stack
    const auto model = model_from_json(bad);
    ASSERT_FALSE(model) << member;
    EXPECT_LT(model.error().message.size(), 300U) << member;
  }
  nlohmann::json bad = good;
  bad["rules"][0]["premise"][0] = nested(100000);
  EXPECT_FALSE(model_from_json(bad));
  bad = good;
  bad["version"] = std::string("\xff");  // no UTF-8
  EXPECT_FALSE(model_from_json(bad));
}

TEST(ModelJson, RefusesListsThatAreNone) {
  const nlohmann::json good = *model_to_json(test::scatter_sample(Shape::bell, TNorm::product, 1).model);
  const auto refused = [&](auto&& change) {
    nlohmann::json bad = good;
    change(bad);
    const auto model = model_from_json(bad);
    return !model && model.error().kind == base::ErrorKind::corrupt;
  };
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["premise"] = 0; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["premise"] = {{"a", 0}}; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["premise"][0] = -1; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["premise"][0] = 18446744073709551615U; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"] = {{"a", j["rules"][0]}}; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["dropped"] = nullptr; }));
  EXPECT_TRUE(refused([](auto& j) { j["version"] = 2.0; }));
}

}  // namespace
}  // namespace soak::anfis
