#include "transport/poll_loop.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/scheduler.h"
#include "base/virtual_scheduler.h"
#include "rubicon/result.hpp"
#include "transport/descriptor_watch.h"
#include "transport/machine_sockets.h"

namespace rubicon::transport {

namespace {

constexpr int kMaxReady = 256;  ///< descriptors of one turn

/// What is awaited of a descriptor. An event that is no longer awaited turns itself off.
class PollWatch final : public DescriptorWatch {
 public:
  PollWatch(int all, std::map<int, PollWatch*>& watches, int descriptor, DescriptorCallbacks calls)
      : all_(all), watches_(watches), descriptor_(descriptor), callbacks_(std::move(calls)) {
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
    if ((due & EPOLLOUT) != 0) callbacks_.room();
    if (!alive.ended() && (due & EPOLLIN) != 0) callbacks_.readable();
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
  DescriptorCallbacks callbacks_;
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

  /// Repeats while timers are due, so that data that arrived before a timer is handled before it.
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

std::unique_ptr<DescriptorWatch> PollLoop::watch(int descriptor, DescriptorCallbacks calls) {
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

namespace asio = boost::asio;

namespace {

/// Calls that wait in the loop keep it, and with it the sockets that they hold.
struct Waiter {
  explicit Waiter(PollLoop& l) : loop(l) {}
  asio::io_context context;
  PollLoop& loop;
};

/// Runs on the loop what the sockets of an io_context have to report.
class LoopExecutor {
 public:
  explicit LoopExecutor(std::shared_ptr<Waiter> waiter) : waiter_(std::move(waiter)) {}

  asio::execution_context& query(asio::execution::context_t) const noexcept { return waiter_->context; }
  static constexpr asio::execution::blocking_t query(asio::execution::blocking_t) noexcept {
    return asio::execution::blocking.never;
  }
  LoopExecutor require(asio::execution::blocking_t::never_t) const { return *this; }

  template <class Call>
  void execute(Call&& call) const {
    auto kept = std::make_shared<std::decay_t<Call>>(std::forward<Call>(call));
    waiter_->loop.post([kept = std::move(kept)] { (*kept)(); });
  }

  bool operator==(const LoopExecutor& other) const noexcept { return waiter_ == other.waiter_; }
  bool operator!=(const LoopExecutor& other) const noexcept { return waiter_ != other.waiter_; }

 private:
  std::shared_ptr<Waiter> waiter_;
};

}  // namespace

WatchDescriptor poll_watch(PollLoop& loop) {
  return [&loop](int descriptor, DescriptorCallbacks calls) { return loop.watch(descriptor, std::move(calls)); };
}

/// What the sockets of IP need.
struct PollSockets::Threaded {
  explicit Threaded(PollLoop& loop) : waiter(std::make_shared<Waiter>(loop)) {}
  ~Threaded();

  std::shared_ptr<Waiter> waiter;
  asio::any_io_executor executor{LoopExecutor(waiter)};
  asio::executor_work_guard<asio::io_context::executor_type> work{waiter->context.get_executor()};
  std::unique_ptr<NameLookup> names = std::make_unique<NameLookup>(executor);
  std::thread thread{[context = &waiter->context] { context->run(); }};
};

/// What the closed sockets still have to report goes to the loop, which drops it: in the io_context it would hold what
/// holds that io_context.
PollSockets::Threaded::~Threaded() {
  names.reset();
  work.reset();
  auto& context = waiter->context;
  context.stop();
  thread.join();
  context.restart();
  context.poll();
}

PollSockets::PollSockets(PollLoop& loop) : loop_(loop) {}
PollSockets::~PollSockets() = default;

PollSockets::Threaded& PollSockets::threaded() {
  if (!threaded_) threaded_ = std::make_unique<Threaded>(loop_);
  return *threaded_;
}

Result<std::unique_ptr<FileSource>> PollSockets::open_file(const std::string& path) {
  return fail(ErrorCode::kUnsupported, path + ": files are not supported here");
}

Result<std::unique_ptr<UdpSocket>> PollSockets::open_udp(const UdpOptions& options, UdpCallbacks calls) {
  return open_asio_udp(threaded().executor, options, std::move(calls));
}

Result<std::unique_ptr<TcpStream>> PollSockets::open_tcp(const TcpOptions& options, TcpCallbacks calls) {
  return open_asio_tcp(threaded().executor, options, std::move(calls));
}

Result<std::unique_ptr<TcpListener>> PollSockets::listen_tcp(const Endpoint& local, TcpAccept accept,
                                                             ListenerFailed failed) {
  return listen_asio_tcp(threaded().executor, local, std::move(accept), std::move(failed));
}

Result<std::unique_ptr<LocalStream>> PollSockets::open_local(const std::string& path, LocalCallbacks calls) {
  return open_local_socket(poll_watch(loop_), path, std::move(calls));
}

Result<std::unique_ptr<LocalListener>> PollSockets::listen_local(const std::string& path, LocalAccept accept) {
  return listen_local_socket(poll_watch(loop_), loop_, path, std::move(accept));
}

Result<std::unique_ptr<MqttLine>> PollSockets::open_mqtt(const MqttOptions& options, MqttCallbacks calls) {
  if (!mqtt_) mqtt_ = std::make_unique<MosquittoLines>(loop_);
  return mqtt_->open(options, std::move(calls));
}

std::unique_ptr<Lookup> PollSockets::look_up(const std::string& host, LookupDone done) {
  return threaded().names->look_up(host, std::move(done));
}

}  // namespace rubicon::transport
