#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <thread>

#include "base/timer_heap.h"
#include "transport/asio_loop.h"

namespace rubicon::transport {

/// What the adapters of this folder share; nobody else sees Asio.
struct AsioLoop::Parts {
  boost::asio::io_context context{1};
  boost::asio::steady_timer timer{context};
  std::optional<boost::asio::signal_set> signals;
  std::function<void(int)> on_signal;
  base::TimerHeap heap;
  SteadyTime armed = SteadyTime::max();
  std::thread::id thread = std::this_thread::get_id();

  void arm();
  void run_due();
  void wait_signal();
};

}  // namespace rubicon::transport
