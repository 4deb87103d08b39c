#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "transport/asio_scheduler.h"

namespace rubicon::transport {

/// Calls on the loop's thread for the first of these signals (SIGTERM, ...); until destroyed they end nothing.
class Signals {
 public:
  Signals(Loop& loop, const std::vector<int>& numbers, std::function<void()> call);
  ~Signals();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::transport
