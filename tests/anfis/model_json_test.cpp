// SPDX-License-Identifier: Apache-2.0
#include "anfis/model_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "anfis/hybrid_learning.h"
#include "support.h"

namespace soak::anfis {
namespace {

Model trained(Membership membership, int order) {
  HybridOptions options;
  options.membership = membership;
  options.order = order;
  options.epochs = 5;
  return train_hybrid(test::drift_problem(1, 4).data, options)->model;
}

TEST(ModelJson, ReadsBackExactlyTheSameNumbersFromText) {
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    for (const int order : {0, 1}) {
      const Model model = trained(membership, order);
      const auto json = model_to_json(model);
      ASSERT_TRUE(json);
      const auto back = model_from_json(nlohmann::json::parse(json->dump()));
      ASSERT_TRUE(back) << back.error().message;
      EXPECT_EQ(*back, model);
    }
  }
}

TEST(ModelJson, ReadsVersionOneAsItWasWritten) {
  const auto model = model_from_json(nlohmann::json::parse(R"({"format": "soak-anfis-model", "version": 1,
      "membership": "bell", "order": 1, "input": {"centre": 20, "half_range": 50, "min": -30, "max": 70},
      "output": {"centre": 0.5, "half_range": 2},
      "rules": [{"width": 1, "slope": 2, "centre": 0, "gain": 3, "offset": 0.25}]})"));
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_DOUBLE_EQ(evaluate(*model, 45.0), 0.5 + 2.0 * (3.0 * 0.5 + 0.25));
}

TEST(ModelJson, RefusesToWriteWhatIsNotFinite) {
  Model model = trained(Membership::bell, 1);
  model.rules[2].gain = std::nan("");
  EXPECT_EQ(model_to_json(model).error().where, "rules[2]");
}

TEST(ModelJson, RefusesDocumentsThatAreNotAModel) {
  const nlohmann::json good = *model_to_json(trained(Membership::bell, 1));
  const auto refused = [&](auto&& change) {
    nlohmann::json bad = good;
    change(bad);
    const auto model = model_from_json(bad);
    return !model && model.error().kind == base::ErrorKind::corrupt;
  };
  EXPECT_FALSE(refused([](auto&) {}));
  EXPECT_TRUE(refused([](auto& j) { j = 3; }));
  EXPECT_TRUE(refused([](auto& j) { j["format"] = "other"; }));
  EXPECT_TRUE(refused([](auto& j) { j["version"] = 2; }));
  EXPECT_TRUE(refused([](auto& j) { j["membership"] = "triangle"; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"] = 7; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["gain"] = nullptr; }));
  EXPECT_TRUE(refused([](auto& j) { j["rules"][0]["width"] = -1; }));
  for (const char* member : {"membership", "order", "input", "output", "rules", "format", "version"}) {
    EXPECT_TRUE(refused([&](auto& j) { j.erase(member); })) << member;
  }
}

}  // namespace
}  // namespace soak::anfis
