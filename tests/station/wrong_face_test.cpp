// SPDX-License-Identifier: Apache-2.0
// A unit that was turned by hand to a wrong face: whoever stands beside it is told at once.
#include <gtest/gtest.h>

#include "station/lab/steps.h"
#include "tests/station/lab_bench.h"

namespace soak::station {
namespace {

using lab_bench::LabBench;

class WrongFace : public LabBench {
 protected:
  static constexpr float kGravity_mps2 = 9.80665F;

  std::unique_ptr<StepTask> move_to(const std::string& position) {
    Step step;
    step.kind = StepKind::move;
    step.position = position;
    station_->campaign.plan.runs.emplace_back();
    stream_.rows_per_poll = 10;
    EXPECT_TRUE(station_->poll());
    return make_task(station_->campaign.plan, step);
  }

  /// So many device seconds of polls, or fewer where the step ends or asks.
  StepState follow(StepTask& task, double seconds) {
    for (int i = 0; i < static_cast<int>(10.0 * seconds); ++i) {
      EXPECT_TRUE(station_->poll());
      const StepState state = task.poll(*station_).state;
      if (state != StepState::running || asks()) return state;
    }
    return StepState::running;
  }

  bool asks() const { return station_->prompts.open().has_value(); }
  bool confirm() { return station_->prompts.answer(station_->prompts.open()->id); }
};

TEST_F(WrongFace, IsAskedForAgainWithinSeconds) {
  const auto task = move_to("+X");
  stream_.accel_mps2 = {0.0F, kGravity_mps2, 0.0F};
  ASSERT_EQ(follow(*task, 1.0), StepState::running);
  ASSERT_TRUE(asks() && confirm());
  ASSERT_EQ(task->poll(*station_).state, StepState::running);
  ASSERT_FALSE(asks());
  const double confirmed_s = station_->now_s();
  ASSERT_EQ(follow(*task, 100.0), StepState::running);
  ASSERT_TRUE(asks()) << "+Y is up";
  EXPECT_LT(station_->now_s() - confirmed_s, 4.0) << "it rests for 2 s";
  EXPECT_EQ(station_->units.front()->attitude().up_axis(), "+Y");
  stream_.accel_mps2 = {kGravity_mps2, 0.0F, 0.0F};
  ASSERT_TRUE(confirm());
  EXPECT_EQ(follow(*task, 10.0), StepState::done);
}

TEST_F(WrongFace, AQuestionIsAnsweredOnceThoughTwoWindowsConfirmIt) {
  const auto task = move_to("+X");
  ASSERT_EQ(follow(*task, 1.0), StepState::running);
  ASSERT_TRUE(confirm());
  EXPECT_FALSE(confirm());
}

TEST_F(WrongFace, TheQuestionSaysWithoutItsSentenceWhatIsAsked) {
  const auto task = move_to("-Z");
  ASSERT_EQ(follow(*task, 1.0), StepState::running);
  ASSERT_TRUE(asks());
  EXPECT_EQ(station_->prompts.open()->code, "position");
  EXPECT_EQ(std::get<std::string>(station_->prompts.open()->about.at("position")), "-Z");
  EXPECT_EQ(std::get<std::vector<std::string>>(station_->prompts.open()->about.at("wrong")),
            std::vector<std::string>{});
  stream_.accel_mps2 = {0.0F, kGravity_mps2, 0.0F};
  ASSERT_TRUE(confirm());
  ASSERT_EQ(task->poll(*station_).state, StepState::running);
  ASSERT_EQ(follow(*task, 100.0), StepState::running);
  ASSERT_TRUE(asks());
  EXPECT_EQ(std::get<std::vector<std::string>>(station_->prompts.open()->about.at("wrong")),
            std::vector{station_->units.front()->serial()});
}

TEST_F(WrongFace, ATiltedUnitIsNotToldThatItsRightFaceIsAWrongOne) {
  const auto task = move_to("+X");
  stream_.accel_mps2 = {0.97F * kGravity_mps2, 0.24F * kGravity_mps2, 0.0F};  // 14 degrees
  ASSERT_EQ(follow(*task, 1.0), StepState::running);
  ASSERT_TRUE(asks() && confirm());
  ASSERT_EQ(task->poll(*station_).state, StepState::running);
  ASSERT_EQ(follow(*task, 100.0), StepState::running);
  ASSERT_TRUE(asks());
  const std::string text = station_->prompts.open()->text;
  EXPECT_EQ(text.find("where +X is expected"), std::string::npos) << text;
}

TEST_F(WrongFace, IsNotToldWhileTheUnitTurns) {
  const auto task = move_to("+X");
  ASSERT_EQ(follow(*task, 1.0), StepState::running);
  ASSERT_TRUE(asks() && confirm());
  ASSERT_EQ(task->poll(*station_).state, StepState::running);
  for (int turn = 0; turn < 10; ++turn) {
    stream_.accel_mps2 = turn % 2 == 0 ? std::array{0.0F, kGravity_mps2, 0.0F} : std::array{kGravity_mps2, 0.0F, 0.0F};
    ASSERT_EQ(follow(*task, 1.5), StepState::running);
    ASSERT_FALSE(asks());
  }
}

}  // namespace
}  // namespace soak::station
