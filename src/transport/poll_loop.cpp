#include "transport/poll_loop.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/timer_heap.h"
#include "rubicon/result.hpp"
#include "transport/own_descriptor.h"

namespace rubicon::transport {

struct PollLoop::Impl {
  OwnDescriptor wake{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  OwnDescriptor alarm{::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)};
  OwnDescriptor all{::epoll_create1(EPOLL_CLOEXEC)};
  std::mutex mutex;
  std::vector<std::function<void()>> posted;  ///< guarded by the mutex
  bool woken = false;                         ///< guarded by the mutex: `wake` was written for the posted calls
  std::vector<std::function<void()>> batch;
  base::TimerHeap timers;
  bool polling = false;
  SteadyTime armed_for = SteadyTime::max();
  std::atomic<std::thread::id> thread{std::this_thread::get_id()};

  bool watch(int descriptor) {
    epoll_event event{};
    event.events = EPOLLIN;
    return ::epoll_ctl(all.get(), EPOLL_CTL_ADD, descriptor, &event) == 0;
  }

  void run_batch() {
    {
      const std::lock_guard lock(mutex);
      batch.swap(posted);
      woken = false;
    }
    for (auto& call : batch) std::exchange(call, nullptr)();
    batch.clear();
  }

  /// What the call of a timer posts runs before the next timer, as in virtual time.
  void run_due() {
    const SteadyTime now = std::chrono::steady_clock::now();
    if (now >= armed_for) armed_for = SteadyTime::max();
    while (auto call = timers.take_due(now)) {
      call();
      run_batch();
    }
    arm();
  }

  void arm() {
    const auto next = timers.next();
    if (!next || *next >= armed_for) return;
    armed_for = *next;
    constexpr std::int64_t kNanos = 1'000'000'000;
    const auto at = std::max<std::int64_t>(next->time_since_epoch().count(), 1);
    itimerspec when{};
    when.it_value = {at / kNanos, at % kNanos};
    ::timerfd_settime(alarm.get(), TFD_TIMER_ABSTIME, &when, nullptr);
  }
};

Result<std::unique_ptr<PollLoop>> PollLoop::make() {
  auto impl = std::make_unique<Impl>();
  if (!impl->watch(impl->wake.get()) || !impl->watch(impl->alarm.get()))
    return fail(ErrorCode::kIo, std::string("making a loop: ") + std::strerror(errno));
  return std::unique_ptr<PollLoop>(new PollLoop(std::move(impl)));
}

PollLoop::PollLoop(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PollLoop::~PollLoop() = default;

int PollLoop::descriptor() const {
  return impl_->all.get();
}

void PollLoop::poll() {
  RUBICON_ASSERT(!std::exchange(impl_->polling, true));  // poll() was called by one of its own calls
  impl_->thread = std::this_thread::get_id();
  std::uint64_t count = 0;
  std::ignore = ::read(impl_->wake.get(), &count, sizeof count);
  impl_->run_batch();
  // Reading the alarm disarms it, whether or not a timer is due.
  if (::read(impl_->alarm.get(), &count, sizeof count) > 0) impl_->armed_for = SteadyTime::max();
  impl_->run_due();
  impl_->polling = false;
}

void PollLoop::wait(Duration timeout) {
  impl_->thread = std::this_thread::get_id();
  pollfd one{impl_->all.get(), POLLIN, 0};
  const auto millis = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  ::poll(&one, 1, static_cast<int>(std::clamp<std::int64_t>(millis, 0, 60'000)));
}

SteadyTime PollLoop::now() const {
  return std::chrono::steady_clock::now();
}

WallTime PollLoop::wall_now() const {
  return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
}

void PollLoop::post(std::function<void()> call) {
  const std::lock_guard lock(impl_->mutex);
  impl_->posted.push_back(std::move(call));
  if (std::exchange(impl_->woken, true)) return;
  wake();
}

void PollLoop::wake() {
  const std::uint64_t one = 1;
  std::ignore = ::write(impl_->wake.get(), &one, sizeof one);
}

Timer PollLoop::at(SteadyTime when, std::function<void()> call) {
  auto timer = impl_->timers.add(when, std::move(call));
  impl_->arm();
  return timer;
}

bool PollLoop::on_loop_thread() const {
  return impl_->thread.load(std::memory_order_relaxed) == std::this_thread::get_id();
}

}  // namespace rubicon::transport
