#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>

#include "rubicon/time.hpp"
#include "tuples/peis/node.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

/// Set to anything but empty, `no` and `nil` it ends a kernel (peis.md, section 1.11); never a component of ours.
inline constexpr std::string_view kQuitKey = "kernel.do-quit";

/// The tuples that each component publishes about itself (peis.md, section 1.11). Kernels alone see them.
class KernelTuples {
 public:
  struct Tuple {
    std::string value;
    std::uint32_t number = 0;
    WallTime written{};
  };

  /// Their keys, as in kernel.all-keys.
  static constexpr std::string_view kNames =
      "kernel.id kernel.name kernel.hostname kernel.user kernel.version kernel.do-quit kernel.all-keys "
      "kernel.subscribers kernel.traffic kernel.step-time kernel.connections kernel.routingTable";

  /// Whether the key, in any case, is one of these.
  static bool owns(std::string_view key);

  /// Sets a tuple; false: it had that value.
  bool set(std::string_view key, std::string value, WallTime now);
  const std::map<std::string, Tuple, std::less<>>& all() const { return tuples_; }

 private:
  std::map<std::string, Tuple, std::less<>> tuples_;
};

/// PUSH_TUPLE of one of them.
Bytes write_kernel_tuple(OwnerId self, std::string_view key, const KernelTuples::Tuple& tuple);

// Values of the tuples.

/// `((<peer> <bytes/s in> <bytes/s out> <type> <loss>)...)`: rates since `before`, over `span`.
std::string connections_text(const std::vector<LinkState>& links, const std::vector<LinkState>& before, Duration span);
/// `(<bytes/s in> <bytes/s out>)`
std::string traffic_text(const std::vector<LinkState>& links, const std::vector<LinkState>& before, Duration span);
/// `(\n (<id> <hops> <via>)\n)\n`
std::string routing_text(const std::vector<RouteState>& routes);

}  // namespace rubicon::tuples::peis
