#include "transport/asio_watch.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <utility>

#include "transport/asio_scheduler.h"

namespace rubicon::transport {

namespace asio = boost::asio;

namespace {

/// Lives as long as a wait is pending, which may be longer than the watch.
struct Waits : std::enable_shared_from_this<Waits> {
  Waits(const asio::any_io_executor& executor, int number, DescriptorCalls c)
      : descriptor(executor, number), calls(std::move(c)) {}

  void await(asio::posix::descriptor_base::wait_type what, const std::function<void()> DescriptorCalls::*call) {
    descriptor.async_wait(what, [self = shared_from_this(), call](const boost::system::error_code& error) {
      if (!error && self->alive) (self->calls.*call)();
    });
  }

  asio::posix::stream_descriptor descriptor;
  DescriptorCalls calls;
  bool alive = true;
};

class AsioWatch final : public DescriptorWatch {
 public:
  AsioWatch(const asio::any_io_executor& executor, int descriptor, DescriptorCalls calls)
      : waits_(std::make_shared<Waits>(executor, descriptor, std::move(calls))) {}
  ~AsioWatch() override {
    waits_->alive = false;
    waits_->descriptor.release();
  }
  AsioWatch(const AsioWatch&) = delete;
  AsioWatch& operator=(const AsioWatch&) = delete;

  void await_readable() override { waits_->await(asio::posix::descriptor_base::wait_read, &DescriptorCalls::readable); }
  void await_room() override { waits_->await(asio::posix::descriptor_base::wait_write, &DescriptorCalls::room); }

 private:
  std::shared_ptr<Waits> waits_;
};

}  // namespace

WatchDescriptor asio_watch(asio::any_io_executor executor) {
  return [executor = std::move(executor)](int descriptor, DescriptorCalls calls) {
    return std::make_unique<AsioWatch>(executor, descriptor, std::move(calls));
  };
}

WatchDescriptor asio_watch(Loop& loop) {
  return asio_watch(loop.context().get_executor());
}

}  // namespace rubicon::transport
