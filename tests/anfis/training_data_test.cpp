// SPDX-License-Identifier: Apache-2.0
#include "anfis/data/training_data.h"

#include <gtest/gtest.h>

#include <cmath>

namespace soak::anfis {
namespace {

TrainingData four_rows() {
  return {{0.0, 1.0, 2.0, 2.0}, {5.0, 6.0, 8.0, 1.0}, {1.0, 1.0, 3.0, 1.0}, {1, 1, 2, 2}, 0.5};
}

TEST(TrainingData, RefusesWhatCannotBeLearnedFromAndSaysWhere) {
  const auto where_of = [](std::size_t parameters, auto&& change) {
    TrainingData data = four_rows();
    change(data);
    const auto status = validate(data, parameters);
    return status ? std::string("accepted") : status.error().where;
  };
  EXPECT_EQ(where_of(3, [](auto&) {}), "accepted");
  EXPECT_EQ(where_of(4, [](auto&) {}), "x");
  EXPECT_EQ(where_of(1, [](auto& d) { d.x = {2.0, 2.0, 2.0, 2.0}; }), "x");
  EXPECT_EQ(where_of(0, [](auto& d) { d = {}; }), "x");
  EXPECT_EQ(where_of(0, [](auto& d) { d.y.pop_back(); }), "y");
  EXPECT_EQ(where_of(0, [](auto& d) { d.weight.pop_back(); }), "weight");
  EXPECT_EQ(where_of(0, [](auto& d) { d.group.pop_back(); }), "group");
  EXPECT_EQ(where_of(0, [](auto& d) { d.group.clear(); }), "group");
  EXPECT_EQ(where_of(0, [](auto& d) { d.y[2] = std::nan(""); }), "row 2");
  EXPECT_EQ(where_of(0, [](auto& d) { d.weight[1] = 0.0; }), "row 1");
  EXPECT_EQ(where_of(0, [](auto& d) { d.group_variance = -1.0; }), "group_variance");
}

TEST(TrainingData, ShapeErrorRemovesEachGroupsWeightedMean) {
  TrainingData data = four_rows();
  // group 1: residuals 1, 3 about 2; group 2: residuals 10, 14 with weights 3, 1 about 11
  EXPECT_NEAR(shape_rmse(data, {1.0, 3.0, 10.0, 14.0}), std::sqrt((1.0 + 1.0 + 3.0 + 9.0) / 6.0), 1e-14);
  data.group_variance = 0.0;
  EXPECT_NEAR(shape_rmse(data, {1.0, 3.0, 10.0, 14.0}), std::sqrt((1.0 + 9.0 + 300.0 + 196.0) / 6.0), 1e-13);
}

TEST(TrainingData, SelectsRowsWithAllTheirColumns) {
  const TrainingData kept = select_rows(four_rows(), {false, true, true, false});
  EXPECT_EQ(kept.x, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(kept.y, (std::vector<double>{6.0, 8.0}));
  EXPECT_EQ(kept.weight, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(kept.group, (std::vector<int>{1, 2}));
  EXPECT_EQ(kept.group_variance, 0.5);
}

TrainingData two_inputs() {
  TrainingData data{{0.0, 1.0, 2.0, 1.0, 0.0, 1.0, 2.0, 3.0}, {1.0, 2.0, 3.0, 4.0}};
  data.inputs = 2;
  return data;
}

TEST(TrainingData, OfTwoInputsHasOneRowPerPair) {
  const TrainingData data = two_inputs();
  ASSERT_EQ(data.rows(), 4U);
  EXPECT_EQ(data.row(1)[0], 2.0);
  EXPECT_EQ(data.row(3)[1], 3.0);
  EXPECT_EQ(distinct_inputs(data), 3U);  // rows 0 and 2 are the same
  const TrainingData kept = select_rows(data, {false, true, false, true});
  EXPECT_EQ(kept.inputs, 2U);
  EXPECT_EQ(kept.x, (std::vector<double>{2.0, 1.0, 2.0, 3.0}));
}

TEST(TrainingData, OfTwoInputsAreRefusedWhereOneIsConstantOrARowIncomplete) {
  TrainingData data = two_inputs();
  EXPECT_TRUE(validate(data, 3));
  EXPECT_FALSE(validate(data, 4));
  data.x[7] = 1.0;
  ASSERT_FALSE(validate(data, 0));
  EXPECT_EQ(validate(data, 0).error().where, "x");
  data.x.pop_back();
  EXPECT_EQ(validate(data, 0).error().where, "x");
  data.inputs = 0;
  EXPECT_EQ(validate(data, 0).error().where, "x");
}

}  // namespace
}  // namespace soak::anfis
