#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string_view>

#include "base/scheduler.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/node_links.h"
#include "tuples/peis/routes.h"

namespace rubicon::tuples::peis {

/// Who may say what of a host: hellos and deaths that came a way which cannot bring them. Those that may be true are
/// refused only if nothing showed that in time. Bounded.
class Forgeries {
 public:
  /// All must outlive it.
  Forgeries(NodeContext& context, const Hosts& hosts, const Routes& routes)
      : context_(context), hosts_(hosts), routes_(routes) {}

  /// Whether the package must not count.
  bool is_forged(const NodeLink& link, const Package& package);
  /// Counts `what` of that source, with a line in the log.
  void refuse(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what);

 private:
  /// A message in the name of a neighbour that came by another one.
  struct Doubt {
    SteadyTime due{};
    std::function<bool()> is_true;
    std::function<void()> refuse;
  };

  bool speaks_for(const NodeLink& link, OwnerId source) const;
  bool is_forged_death(const NodeLink& link, const Package& package);
  void doubt(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what,
             std::function<bool()> is_true);
  void judge();

  NodeContext& context_;
  const Hosts& hosts_;
  const Routes& routes_;
  std::deque<Doubt> doubts_;
  Timer due_;
};

}  // namespace rubicon::tuples::peis
