#include <algorithm>
#include <chrono>

#include "ecology/trust/measurements.h"
#include "ecology/trust/realm.h"
#include "trust/operations.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::bench::trust {

namespace {

using std::chrono::milliseconds;

constexpr const char* kClock = "bench.clock";
constexpr milliseconds kTick{2}, kBetweenRenewals{2000};
constexpr int kRenewals = 3;

void renew_once(Node& node, const Meeting& meeting, int days) {
  const auto now = std::chrono::time_point_cast<WallTime::duration>(std::chrono::system_clock::now());
  const auto issued = rubicon::trust::renew(meeting.trust, rubicon::trust::kLocalMember, days, now);
  if (!issued) give_up(issued.error().text);
  const auto renewed = dynamic_cast<tuples::dds::DdsEcology&>(node.ecology()).renew();
  if (!renewed || !*renewed) give_up("the certificate is not renewed");
}

double gap_once(const Plan& plan, const std::string& folder) {
  auto meeting = plan.new_meeting();
  meeting.trust = folder;
  auto owner = start_role("renewer", meeting, Json::object());
  auto reader = start_role("reader", meeting, Json::object());
  (void)result_of(owner);
  return result_of(reader).at("longest_gap_s");
}

}  // namespace

/// Sets a tuple each kTick; its certificate is renewed some times.
Json renewer(const Meeting& meeting, const Json&) {
  Node node(kFirst, meeting);
  std::uint64_t count = 0;
  Timer tick;
  std::function<void()> set = [&] {
    (void)node.space().set(kClock, value_of(++count));
    tick = node.scheduler().after(kTick, set);
  };
  set();
  node.await(kSecond);
  node.rest(kBetweenRenewals);
  for (int i = 0; i < kRenewals; ++i) {
    renew_once(node, meeting, 100 + i);
    node.rest(kBetweenRenewals);
  }
  return Json::object();
}

/// The longest time between two values of that tuple.
Json reader(const Meeting& meeting, const Json&) {
  Node node(kSecond, meeting);
  node.await(kFirst);
  SteadyTime last{};
  double longest = 0;
  const auto all = node.space().subscribe({kFirst, kClock}, {}, [&](const tuples::Event& event) {
    if (event.kind != tuples::EventKind::kSet) return;
    const auto now = node.scheduler().now();
    if (last != SteadyTime{}) longest = std::max(longest, seconds_between(last, now));
    last = now;
  });
  node.rest((kRenewals + 1) * kBetweenRenewals);
  if (last == SteadyTime{}) give_up("no value came");
  return {{"longest_gap_s", longest}};
}

void measure_renewal(const Plan& plan, Report& report) {
  const Realm realm;
  std::vector<double> gaps;
  for (int i = 0; i < (plan.is_quick ? 1 : plan.rounds); ++i) gaps.push_back(gap_once(plan, realm.folder()));
  report.figure("renewal_gap_s", rounded(median(gaps), 2));
  report.target("renewal_gap_s", "below 1", median(gaps) < 1);
  report.detail("renewal_gap_s", gaps);
}

}  // namespace rubicon::bench::trust
