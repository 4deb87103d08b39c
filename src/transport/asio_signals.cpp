#include "transport/asio_signals.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <utility>

namespace rubicon::transport {

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
