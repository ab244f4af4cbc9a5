// SPDX-License-Identifier: Apache-2.0
// An epoch of hybrid learning allocates no memory: fifty epochs allocate as often as five hundred.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <new>

#include "anfis/train/learner.h"
#include "sample_models.h"
#include "support.h"

namespace {

bool counting = false;
std::size_t allocations = 0;

}  // namespace

#ifdef SOAK_LINKED_WITH_SANITIZER  // whose allocator takes a function to call, and bears no other malloc()
extern "C" int __sanitizer_install_malloc_and_free_hooks(  // NOLINT(bugprone-reserved-identifier)
    void (*on_malloc)(const volatile void*, std::size_t), void (*on_free)(const volatile void*));
namespace {
void count_allocation(const volatile void* /*block*/, std::size_t /*size*/) {
  if (counting) ++allocations;
}
void ignore_release(const volatile void* /*block*/) {}
[[maybe_unused]] const int installed = __sanitizer_install_malloc_and_free_hooks(count_allocation, ignore_release);
}  // namespace
#else
// Eigen allocates with malloc(): glibc's own is reached below the replacement.
extern "C" void* __libc_malloc(std::size_t size);  // NOLINT(bugprone-reserved-identifier)
extern "C" void* malloc(std::size_t size) noexcept {
  if (counting) ++allocations;
  return __libc_malloc(size);
}
#endif

namespace soak::anfis {
namespace {

/// Number of calls of malloc(), which operator new and Eigen use, while `work` runs.
template <class Work>
std::size_t allocations_of(Work&& work) {
  allocations = 0;
  counting = true;
  work();
  counting = false;
  return allocations;
}

std::size_t training_allocations(const Model& initial, const TrainingData& data, HybridOptions options, int epochs,
                                 const TrainingData* checking) {
  options.epochs = epochs;
  std::size_t made = 0;
  const std::size_t count = allocations_of([&] {
    const auto training = train_hybrid(initial, data, options, checking);
    made = training ? training->summary.history.size() : 0;
  });
  EXPECT_EQ(made, static_cast<std::size_t>(epochs));
  return count;
}

void expect_none_per_epoch(const Model& initial, const TrainingData& data, const HybridOptions& options,
                           const TrainingData* checking, const std::string& what) {
  const std::size_t few = training_allocations(initial, data, options, 50, checking);
  const std::size_t many = training_allocations(initial, data, options, 500, checking);
  EXPECT_GT(few, 10U) << what;  // the counter counts
  EXPECT_EQ(many, few) << what;
}

TEST(NoAllocation, TheCounterSeesEigenAndTheStandardLibrary) {
  EXPECT_GE(allocations_of([] { EXPECT_EQ(std::vector<double>(1000).size(), 1000U); }), 1U);
  EXPECT_GE(allocations_of([] { EXPECT_EQ(Eigen::VectorXd::Zero(1000).eval().size(), 1000); }), 1U);
}

TEST(NoAllocation, InAnEpochOfAnyShapeTNormOrderOrPartition) {
  for (const test::Sample& sample : test::all_samples()) {
    // Inside its bounds this one has rank 16 of 18 consequents: the general solver may allocate (ConsequentSolver).
    if (sample.what == "grid triangle product order 1") continue;
    expect_none_per_epoch(sample.model, sample.data, {}, nullptr, sample.what);
  }
}

TEST(NoAllocation, InAnEpochWithCheckingDataWeightsAndGroups) {
  for (const Shape shape : kShapes) {
    const TrainingData data = test::drift_problem(1, 4).data, check = test::drift_problem(1, 3).data;
    expect_none_per_epoch(test::grid(data, 6, shape), data, {}, &check, std::string(name(shape)));
  }
}

TEST(NoAllocation, InAnEpochWithSmoothness) {
  const TrainingData data = test::drift_problem(1, 4).data;
  for (const Shape shape : kShapes) {
    expect_none_per_epoch(test::grid(data, 6, shape), data, {.smoothness = 1e-4}, nullptr, std::string(name(shape)));
  }
}

TEST(NoAllocation, InAnEpochOfSequentialLeastSquaresWithoutBounds) {
  const TrainingData data = test::gyro_drift(true);
  const HybridOptions options{.limits = PremiseLimits::none, .solver = ConsequentSolver::sequential};
  expect_none_per_epoch(test::grid(data, 4), data, options, nullptr, "sequential");
}

}  // namespace
}  // namespace soak::anfis
