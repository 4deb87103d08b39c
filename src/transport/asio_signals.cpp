#include "transport/asio_signals.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <utility>

namespace rubicon::transport {

struct Signals::Impl {
  explicit Impl(boost::asio::io_context& context) : set(context) {}
  boost::asio::signal_set set;
};

Signals::Signals(Loop& loop, const std::vector<int>& numbers, std::function<void()> call)
    : impl_(std::make_unique<Impl>(loop.context())) {
  for (const int number : numbers) impl_->set.add(number);
  impl_->set.async_wait([call = std::move(call)](const boost::system::error_code& error, int) {
    if (!error) call();
  });
}

Signals::~Signals() = default;

}  // namespace rubicon::transport
