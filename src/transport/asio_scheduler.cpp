#include "transport/asio_scheduler.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/virtual_scheduler.h"

namespace rubicon::transport {

/// Passes calls from other threads to the thread that runs an io_context. It wakes the context through a pipe, because
/// Linux wakes the reader of a pipe on the writer's CPU (a synchronous wake-up, since 6.13 through epoll too): on an
/// idle machine no second CPU has to wake up for each message, as the eventfd of the io_context would cause. While it
/// is open the context has work, so that its run() does not return.
class CrossThreadQueue : public std::enable_shared_from_this<CrossThreadQueue> {
 public:
  using Call = std::function<void()>;

  /// Runs a call on the context's thread. False: other work waits for its turn, the next call runs after it.
  using Run = std::function<bool(const Call&)>;

  /// nullptr if the process has no file descriptors left.
  static std::shared_ptr<CrossThreadQueue> make(boost::asio::io_context& context, Run run);
  explicit CrossThreadQueue(boost::asio::io_context& context) : pipe_(context) {}
  CrossThreadQueue(const CrossThreadQueue&) = delete;
  CrossThreadQueue& operator=(const CrossThreadQueue&) = delete;
  ~CrossThreadQueue();

  /// From any thread. Calls run in the order of posting.
  void post(Call call);
  /// To be called on the context's thread: drops the calls that did not run yet.
  void close();

 private:
  void wait_for_wake_up();
  void run_calls();
  void run_later();

  boost::asio::posix::stream_descriptor pipe_;
  int write_end_ = -1;
  Run run_;
  std::array<char, 64> wake_ups_{};
  std::mutex mutex_;
  std::vector<Call> calls_;
  std::deque<Call> taken_;  ///< from calls_, by the context's thread
  bool later_ = false;      ///< run_calls() is posted
};

std::shared_ptr<CrossThreadQueue> CrossThreadQueue::make(boost::asio::io_context& context, Run run) {
  int ends[2] = {};
  if (::pipe2(ends, O_NONBLOCK | O_CLOEXEC) != 0) return nullptr;
  auto queue = std::make_shared<CrossThreadQueue>(context);
  queue->pipe_.assign(ends[0]);
  queue->write_end_ = ends[1];
  queue->run_ = std::move(run);
  queue->wait_for_wake_up();
  return queue;
}

CrossThreadQueue::~CrossThreadQueue() {
  if (write_end_ >= 0) ::close(write_end_);
}

/// One byte wakes the reader for all queued calls, so that the pipe never fills up.
void CrossThreadQueue::post(Call call) {
  {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
    if (calls_.size() > 1) return;
  }
  while (::write(write_end_, "", 1) < 0 && errno == EINTR) {
  }
}

void CrossThreadQueue::close() {
  run_ = nullptr;
  taken_.clear();
  pipe_.cancel();  // other threads may still post: the pipe is closed with the last owner of this
}

void CrossThreadQueue::wait_for_wake_up() {
  pipe_.async_read_some(boost::asio::buffer(wake_ups_), [self = shared_from_this()](const auto& error, std::size_t) {
    if (error || !self->run_) return;
    self->run_calls();
    if (self->run_) self->wait_for_wake_up();
  });
}

void CrossThreadQueue::run_calls() {
  {
    const std::lock_guard lock(mutex_);
    for (auto& call : calls_) taken_.push_back(std::move(call));
    calls_.clear();
  }
  const auto run = run_;  // a call may close this
  while (run_ && !taken_.empty()) {
    const auto call = std::move(taken_.front());
    taken_.pop_front();
    if (!run(call) && !taken_.empty()) return run_later();
  }
}

/// Behind what the context has to do by now.
void CrossThreadQueue::run_later() {
  if (std::exchange(later_, true)) return;
  boost::asio::post(pipe_.get_executor(), [self = shared_from_this()] {
    self->later_ = false;
    if (self->run_) self->run_calls();
  });
}

namespace asio = boost::asio;

/// Between two times at which timers run that were not due before. To set the alarm is two system calls, which take 10
/// us on a virtual machine: without a pause, 70 % of what 40,000 devices at rest took of a core was for the alarm.
constexpr Duration kMinPause = std::chrono::microseconds(500);

/// Shared with the calls that wait in the io_context, which may run after the scheduler was destroyed.
struct AsioScheduler::Impl : std::enable_shared_from_this<AsioScheduler::Impl> {
  explicit Impl(asio::io_context& c) : context(c), alarm(c), thread(std::this_thread::get_id()) {}

  void post(std::function<void()> call) {
    posted.push_back(std::move(call));
    if (std::exchange(batch_asked, true)) return;
    asio::post(context, [self = shared_from_this()] { self->run_batch(); });
  }

  void run_batch() {
    batch_asked = false;
    batch.clear();
    batch.swap(posted);
    for (std::size_t i = 0; i < batch.size() && alive; ++i) std::exchange(batch[i], nullptr)();
    batch.clear();
  }

  /// Runs a call outside of any batch, then the calls that it posts, after those that wait. Nothing more if it posts
  /// none: a turn of long work that waits is not for each timer to run. False if calls were posted that wait for their
  /// turn.
  bool run_with_posts(const std::function<void()>& call) {
    const auto waiting = posted.size();
    const bool asked = std::exchange(batch_asked, true);
    call();
    batch_asked = asked;
    if (posted.size() == waiting) return true;
    run_batch();
    return posted.empty();
  }

  void arm() {
    const auto next = timers.next();
    if (!next || *next >= armed_for) return;
    if (*next <= std::chrono::steady_clock::now()) return run_due_later(*next);
    const auto when = std::max(*next, last_due + kMinPause);
    if (when >= armed_for) return;
    armed_for = when;
    alarm.expires_at(when);
    alarm.async_wait([self = shared_from_this()](boost::system::error_code error) {
      if (!error) self->run_due();
    });
  }

  /// Behind what waits in the context, without the alarm: where one processor does much, each sleep costs milliseconds.
  void run_due_later(SteadyTime when) {
    armed_for = when;
    asio::post(context, [self = shared_from_this()] { self->run_due(); });
  }

  /// What the call of a timer posts runs before the next timer, as in virtual time. What that posts in turn runs before
  /// it too, but in a turn of its own: sockets get theirs between.
  void run_due() {
    if (!alive) return;
    armed_for = SteadyTime::max();
    const SteadyTime now = last_due = std::chrono::steady_clock::now();
    for (auto call = timers.take_due(now); call && run_with_posts(call) && alive;) call = timers.take_due(now);
    if (alive) arm();
  }

  asio::io_context& context;
  asio::steady_timer alarm;
  std::shared_ptr<CrossThreadQueue>
      cross_thread;  ///< nullptr if no descriptors were left: other threads then post through the context
  std::atomic<std::thread::id> thread;
  base::TimerHeap timers;
  SteadyTime armed_for = SteadyTime::max();
  SteadyTime last_due{};  ///< when timers ran last
  std::vector<std::function<void()>> posted, batch;
  bool batch_asked = false;
  bool alive = true;
};

AsioScheduler::AsioScheduler(asio::io_context& context) : impl_(std::make_shared<Impl>(context)) {
  impl_->cross_thread =
      CrossThreadQueue::make(context, [impl = impl_](const auto& call) { return impl->run_with_posts(call); });
}

AsioScheduler::~AsioScheduler() {
  impl_->alive = false;
  impl_->alarm.cancel();
  if (impl_->cross_thread) impl_->cross_thread->close();
  impl_->posted.clear();
}

SteadyTime AsioScheduler::now() const {
  return std::chrono::steady_clock::now();
}

WallTime AsioScheduler::wall_now() const {
  return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
}

void AsioScheduler::post(std::function<void()> call) {
  if (on_loop_thread()) return impl_->post(std::move(call));
  if (impl_->cross_thread) return impl_->cross_thread->post(std::move(call));
  asio::post(impl_->context, [impl = impl_, call = std::move(call)] {
    if (impl->alive) impl->run_with_posts(call);
  });
}

Timer AsioScheduler::at(SteadyTime when, std::function<void()> call) {
  RUBICON_DEBUG_ASSERT(on_loop_thread());
  Timer timer = impl_->timers.add(when, std::move(call));
  impl_->arm();
  return timer;
}

bool AsioScheduler::on_loop_thread() const {
  return impl_->thread.load(std::memory_order_relaxed) == std::this_thread::get_id();
}

void AsioScheduler::adopt_thread() {
  impl_->thread = std::this_thread::get_id();
}

struct Loop::Impl {
  asio::io_context context{1};
  AsioScheduler scheduler{context};
};

Loop::Loop() : impl_(std::make_unique<Impl>()) {}
Loop::~Loop() = default;

AsioScheduler& Loop::scheduler() {
  return impl_->scheduler;
}

asio::io_context& Loop::context() {
  return impl_->context;
}

void Loop::run() {
  impl_->scheduler.adopt_thread();
  {
    const auto busy = asio::make_work_guard(impl_->context);
    impl_->context.run();
  }
  impl_->context.restart();  // the end of the last work stops the context again
}

void Loop::stop() {
  impl_->context.stop();
}

struct Signals::Impl : std::enable_shared_from_this<Signals::Impl> {
  Impl(boost::asio::io_context& context, std::function<void()> c) : set(context), call(std::move(c)) {}

  void wait() {
    set.async_wait([weak = weak_from_this()](const boost::system::error_code& error, int) {
      const auto self = weak.lock();  // also while the call destroys the Signals
      if (error || !self) return;
      self->wait();
      self->call();
    });
  }

  boost::asio::signal_set set;
  std::function<void()> call;
};

Signals::Signals(Loop& loop, const std::vector<int>& numbers, std::function<void()> call)
    : impl_(std::make_shared<Impl>(loop.context(), std::move(call))) {
  for (const int number : numbers) impl_->set.add(number);
  impl_->wait();
}

Signals::~Signals() = default;

}  // namespace rubicon::transport
