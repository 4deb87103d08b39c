#include <cmath>

#include "peis/measurements.h"
#include "peis/slow_kernel.h"

namespace rubicon::bench::peis {

namespace {

constexpr std::uint64_t kKernelKeys = 1000;

Json run_once(const Plan& plan, int per_second) {
  const auto meeting = plan.new_meeting();
  auto owner = start_role("paced-writer", meeting,
                          {{"keys", kKernelKeys}, {"per_second", per_second}, {"seconds", plan.is_quick ? 1 : 10}});
  auto reader = start_role("slow-kernel", meeting, {{"keys", kKernelKeys}});
  auto kernel = result_of(reader);
  const auto sets = result_of(owner).at("sets").get<std::uint64_t>();
  std::uint64_t stale = 0;
  const auto& numbers = kernel.at("numbers");
  for (std::uint64_t number = sets - kKernelKeys + 1; number <= sets; ++number)
    stale += numbers[number % kKernelKeys] != number;
  kernel.erase("numbers");
  kernel["sets"] = sets;
  kernel["stale"] = stale;
  kernel["missing"] = static_cast<std::int64_t>(sets) - kernel.at("values").get<std::int64_t>();
  return kernel;
}

}  // namespace

Json slow_kernel(const Meeting& meeting, const Json& options) {
  SlowKernel kernel(meeting.tag, options.at("keys"));
  return kernel.run();
}

void measure_kernel(const Plan& plan, Report& report) {
  const auto whole = run_once(plan, 3000), newest = run_once(plan, 20'000);
  const bool is_whole = whole.at("missing") == 0 && whole.at("stale") == 0;
  const bool is_newest = newest.at("stale") == 0;
  const auto resends = whole.at("resends").get<int>() + newest.at("resends").get<int>();
  report.figure("kernel_missing_at_3000", whole.at("missing"));
  report.figure("kernel_stale_at_20000", newest.at("stale"));
  report.figure("kernel_resends", resends);
  report.target("kernel_missing_at_3000", "0", is_whole);
  report.target("kernel_stale_at_20000", "0", is_newest);
  report.detail("kernel_missing_at_3000",
                {{"method",
                  "1000 tuples set at a rate towards a reader as slow as a kernel: 9 packages each 2 ms, acks after "
                  "100 packages or 0.2 s; missing: values that it did not get; stale: tuples without their last "
                  "value; most_waiting: bytes in its socket when it reads"},
                 {"at_3000", whole},
                 {"at_20000", newest}});
}

}  // namespace rubicon::bench::peis
