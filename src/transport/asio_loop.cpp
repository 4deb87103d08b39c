#include "transport/asio_loop.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>

#include "transport/asio_parts.h"

namespace rubicon::transport {

namespace asio = boost::asio;

AsioLoop::AsioLoop() : parts_(std::make_unique<Parts>()) {}
AsioLoop::~AsioLoop() = default;

SteadyTime AsioLoop::now() const { return std::chrono::steady_clock::now(); }

WallTime AsioLoop::wall_now() const {
  return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
}

void AsioLoop::post(std::function<void()> call) { asio::post(parts_->context, std::move(call)); }

Timer AsioLoop::at(SteadyTime when, std::function<void()> call) {
  auto timer = parts_->heap.add(when, std::move(call));
  parts_->arm();
  return timer;
}

bool AsioLoop::on_loop_thread() const { return std::this_thread::get_id() == parts_->thread; }

void AsioLoop::run() {
  parts_->thread = std::this_thread::get_id();
  const auto guard = asio::make_work_guard(parts_->context);
  parts_->context.run();
}

void AsioLoop::stop() { parts_->context.stop(); }

void AsioLoop::on_signals(std::initializer_list<int> signals, std::function<void(int)> call) {
  parts_->on_signal = std::move(call);
  parts_->signals.emplace(parts_->context);
  for (const int signal : signals) parts_->signals->add(signal);
  parts_->wait_signal();
}

void AsioLoop::Parts::wait_signal() {
  signals->async_wait([this](const boost::system::error_code& error, int signal) {
    if (error) return;
    wait_signal();
    on_signal(signal);
  });
}

void AsioLoop::Parts::arm() {
  const auto next = heap.next();
  if (!next || *next >= armed) return;
  armed = *next;
  timer.expires_at(armed);
  timer.async_wait([this](const boost::system::error_code& error) {
    if (!error) run_due();
  });
}

void AsioLoop::Parts::run_due() {
  armed = SteadyTime::max();
  const auto now = SteadyTime(std::chrono::steady_clock::now());
  // Bounded, so that timers that arm themselves for now leave room for lines and posts.
  for (int count = 0; count < 1000; ++count) {
    auto call = heap.take_due(now);
    if (!call) break;
    call();
  }
  arm();
}

}  // namespace rubicon::transport
