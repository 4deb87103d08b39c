#include "transport/doorbell.h"

#include <fcntl.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <cerrno>
#include <utility>

namespace rubicon::transport {

std::shared_ptr<Doorbell> Doorbell::make(boost::asio::io_context& context, std::function<void(const Call&)> run) {
  int ends[2] = {};
  if (::pipe2(ends, O_NONBLOCK | O_CLOEXEC) != 0) return nullptr;
  auto bell = std::make_shared<Doorbell>(context);
  bell->pipe_.assign(ends[0]);
  bell->write_end_ = ends[1];
  bell->run_ = std::move(run);
  bell->listen();
  return bell;
}

Doorbell::~Doorbell() {
  if (write_end_ >= 0) ::close(write_end_);
}

/// One ring for all calls that wait: the pipe never fills.
void Doorbell::post(Call call) {
  {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
    if (calls_.size() > 1) return;
  }
  while (::write(write_end_, "", 1) < 0 && errno == EINTR) {
  }
}

void Doorbell::close() {
  run_ = nullptr;
  pipe_.cancel();  // others may still ring: both ends go with the last of them
}

void Doorbell::listen() {
  pipe_.async_read_some(boost::asio::buffer(rings_), [self = shared_from_this()](const auto& error, std::size_t) {
    if (error || !self->run_) return;
    self->answer();
    if (self->run_) self->listen();
  });
}

void Doorbell::answer() {
  std::vector<Call> calls;
  {
    const std::lock_guard lock(mutex_);
    calls.swap(calls_);
  }
  const auto run = run_;  // a call may close us
  for (auto& call : calls) {
    if (run_) run(std::exchange(call, nullptr));
  }
}

}  // namespace rubicon::transport
