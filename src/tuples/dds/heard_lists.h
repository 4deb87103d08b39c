#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"

namespace rubicon::tuples::dds {

/// Lists of revoked certificates that other members publish, on their way to the check of their signature. A check
/// costs processor time, so each member gets a few at once and one each kPause afterwards; meanwhile its last list
/// waits.
class HeardLists {
 public:
  static constexpr int kAtOnce = 4;
  static constexpr Duration kPause = std::chrono::seconds(1);
  /// Further members share one allowance.
  static constexpr std::size_t kMaxMembers = 256;

  /// Gets a list with the member that published it.
  using Check = std::function<void(std::string list, const std::string& member)>;

  /// `check` runs inside hear() or in a later turn. The scheduler must outlive the object.
  HeardLists(Scheduler& scheduler, Check check) : scheduler_(scheduler), check_(std::move(check)) {}

  void hear(const std::string& member, std::string_view list);

 private:
  struct Heard {
    std::string list, member;
  };
  struct Allowance {
    SteadyTime spent_until{};
    std::optional<Heard> waiting;
  };
  bool spend(Allowance& allowance) const;
  void check_waiting();

  Scheduler& scheduler_;
  Check check_;
  std::map<std::string, Allowance> members_;
  Timer timer_;
};

}  // namespace rubicon::tuples::dds
