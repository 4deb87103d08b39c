#include "transport/poll_loop.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/lifetime.h"
#include "base/timer_heap.h"
#include "rubicon/result.hpp"
#include "transport/own_descriptor.h"

namespace rubicon::transport {

namespace {

constexpr int kMaxReady = 256;  ///< descriptors of one turn

/// What is awaited of a descriptor. An event that nobody awaits any more turns itself off.
class PollWatch final : public DescriptorWatch {
 public:
  PollWatch(int all, std::map<int, PollWatch*>& watches, int descriptor, DescriptorCalls calls)
      : all_(all), watches_(watches), descriptor_(descriptor), calls_(std::move(calls)) {
    watches_[descriptor_] = this;
    control(EPOLL_CTL_ADD);
  }
  ~PollWatch() override {
    control(EPOLL_CTL_DEL);
    watches_.erase(descriptor_);
  }
  PollWatch(const PollWatch&) = delete;
  PollWatch& operator=(const PollWatch&) = delete;

  void await_readable() override { await(EPOLLIN); }
  void await_room() override { await(EPOLLOUT); }

  /// A call may destroy this.
  void ready(std::uint32_t events) {
    if ((events & (EPOLLERR | EPOLLHUP)) != 0) events |= EPOLLIN | EPOLLOUT;
    const auto due = events & awaited_;
    awaited_ &= ~due;
    const auto alive = lifetime_.watch();
    if ((due & EPOLLOUT) != 0) calls_.room();
    if (!alive.ended() && (due & EPOLLIN) != 0) calls_.readable();
    if (!alive.ended() && (watched_ & ~awaited_) != 0) watch_for(awaited_);
  }

 private:
  void await(std::uint32_t event) {
    awaited_ |= event;
    if ((watched_ & event) == 0) watch_for(watched_ | event);
  }
  void watch_for(std::uint32_t events) {
    watched_ = events;
    control(EPOLL_CTL_MOD);
  }
  void control(int operation) const {
    epoll_event event{};
    event.events = watched_;
    event.data.fd = descriptor_;
    ::epoll_ctl(all_, operation, descriptor_, &event);
  }

  int all_;
  std::map<int, PollWatch*>& watches_;
  int descriptor_;
  DescriptorCalls calls_;
  std::uint32_t awaited_ = 0, watched_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace

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

  std::map<int, PollWatch*> watches{};

  bool watch(int descriptor) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.fd = descriptor;
    return ::epoll_ctl(all.get(), EPOLL_CTL_ADD, descriptor, &event) == 0;
  }

  /// As long as timers are due, so that what arrived before them counts before them.
  void run_all_ready() {
    constexpr int kMaxRounds = 64;
    for (int round = 0; run_ready() && round < kMaxRounds; ++round) {
      const auto next = timers.next();
      if (!next || *next > std::chrono::steady_clock::now()) return;
    }
  }

  /// False: nothing was ready.
  bool run_ready() {
    if (watches.empty()) return false;
    bool any = false;
    std::array<epoll_event, kMaxReady> ready;
    const int count = ::epoll_wait(all.get(), ready.data(), kMaxReady, 0);
    for (int i = 0; i < count; ++i) {
      const auto& one = ready[static_cast<std::size_t>(i)];
      const auto found = watches.find(one.data.fd);
      if (found == watches.end()) continue;
      any = true;
      found->second->ready(one.events);
    }
    return any;
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
  impl_->run_all_ready();
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

std::unique_ptr<DescriptorWatch> PollLoop::watch(int descriptor, DescriptorCalls calls) {
  return std::make_unique<PollWatch>(impl_->all.get(), impl_->watches, descriptor, std::move(calls));
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
