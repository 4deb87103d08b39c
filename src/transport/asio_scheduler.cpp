#include "transport/asio_scheduler.h"

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/timer_heap.h"
#include "transport/cross_thread_queue.h"

namespace rubicon::transport {

namespace asio = boost::asio;

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
    armed_for = *next;
    alarm.expires_at(*next);
    alarm.async_wait([self = shared_from_this()](boost::system::error_code error) {
      if (!error) self->run_due();
    });
  }

  /// What the call of a timer posts runs before the next timer, as in virtual time. What that posts in turn runs before
  /// it too, but in a turn of its own: sockets get theirs between.
  void run_due() {
    if (!alive) return;
    armed_for = SteadyTime::max();
    const SteadyTime now = std::chrono::steady_clock::now();
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

}  // namespace rubicon::transport
