#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "transport/asio_scheduler.h"

namespace rubicon::transport {

/// Calls `call` on the loop's thread at each of these signals (SIGTERM, ...). Until this is destroyed the signals do
/// not end the process.
class Signals {
 public:
  Signals(Loop& loop, const std::vector<int>& numbers, std::function<void()> call);
  ~Signals();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace rubicon::transport
