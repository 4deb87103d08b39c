#include "transport/cross_thread_queue.h"

#include <fcntl.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <utility>

namespace rubicon::transport {

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

}  // namespace rubicon::transport
