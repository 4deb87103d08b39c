#pragma once

#include <functional>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "transport/interfaces.h"

namespace rubicon::transport {

/// The network interfaces of a host in memory. Must outlive its watches.
class MemoryInterfaces {
 public:
  explicit MemoryInterfaces(base::Scheduler& scheduler) : scheduler_(scheduler) {}
  MemoryInterfaces(const MemoryInterfaces&) = delete;
  MemoryInterfaces& operator=(const MemoryInterfaces&) = delete;

  /// Those that watch hear of it in a later turn.
  void set(std::vector<Interface> there) {
    there_ = std::move(there);
    for (auto* watch : watches_) watch->soon = scheduler_.after({}, watch->changed);
  }
  const std::vector<Interface>& there() const { return there_; }
  WatchInterfaces watch() {
    return [this](std::function<void()> changed) -> Result<std::unique_ptr<InterfaceWatch>> {
      return std::make_unique<Watch>(*this, std::move(changed));
    };
  }

 private:
  struct Watch final : InterfaceWatch {
    Watch(MemoryInterfaces& a_host, std::function<void()> call) : host(a_host), changed(std::move(call)) {
      host.watches_.insert(this);
    }
    ~Watch() override { host.watches_.erase(this); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    std::vector<Interface> interfaces() const override { return host.there_; }

    MemoryInterfaces& host;
    std::function<void()> changed;
    base::Timer soon;
  };

  base::Scheduler& scheduler_;
  std::vector<Interface> there_;
  std::set<Watch*> watches_;
};

}  // namespace rubicon::transport
