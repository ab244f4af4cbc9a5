// SPDX-License-Identifier: Apache-2.0
#include "station/lab/run_sealer.h"

#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

#include "station/io/data_folder.h"

namespace soak::station {
namespace {

/// What was thrown on the thread (no memory) comes back as an error. `work` is given the thread's own connection.
template <class Result, class Work>
Result with_own_catalog(const std::filesystem::path& data_folder, const std::function<void()>& before_work,
                        const Work& work) {
  try {
    if (before_work) before_work();
    auto catalog = reopen_catalog(data_folder);
    if (!catalog) return base::forward_error(catalog);
    return work(*catalog);
  } catch (const std::exception& thrown) {
    return base::fail(base::ErrorKind::internal, std::string("the run cannot be read back: ") + thrown.what());
  }
}

/// A thread of its own; where the system gives none, the work is done at once.
template <class Work>
auto start_thread(Work work) {
  try {
    return std::async(std::launch::async, work);
  } catch (const std::system_error&) {
    std::packaged_task<decltype(work())()> task(work);
    auto result = task.get_future();
    task();
    return result;
  }
}

template <class Result>
bool is_ready(const std::future<Result>& work) {
  return work.valid() && work.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

void RunSealer::begin(RunRecorder run, RunEnd end) {
  run_id_ = run.info().run_id;
  label_ = run.info().label;
  run_ = std::make_shared<RunRecorder>(std::move(run));
  end_ = std::move(end);
  retry();
}

void RunSealer::retry() {
  work_ = start_thread([folder = data_folder_, before = before_work, run = run_, end = end_] {
    return with_own_catalog<base::Status>(folder, before, [&](db::Catalog& catalog) -> base::Status {
      if (const auto rows = run->finish(catalog, end); !rows) return base::forward_error(rows);
      return {};
    });
  });
}

std::optional<RunSealer::Sealed> RunSealer::take() {
  if (!is_ready(work_)) return std::nullopt;
  base::Status status = work_.get();
  Sealed sealed{run_id_, label_, end_, run_->rejected(), std::move(status)};
  if (sealed.status) run_.reset();
  return sealed;
}

void RunSealer::begin_lost_runs(const std::string& aborted_campaign) {
  lost_runs_ = start_thread([folder = data_folder_, before = before_work, aborted_campaign] {
    return with_own_catalog<base::Result<std::vector<LostRun>>>(
        folder, before, [&](db::Catalog& catalog) { return enter_lost_runs(catalog, aborted_campaign); });
  });
}

std::optional<base::Result<std::vector<LostRun>>> RunSealer::take_lost_runs() {
  if (!is_ready(lost_runs_)) return std::nullopt;
  return lost_runs_.get();
}

}  // namespace soak::station
