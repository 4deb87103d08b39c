#include "transport/machine_sockets.h"

#include <fmt/format.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "transport/asio_scheduler.h"
#include "transport/host_names.h"

namespace rubicon::transport {

namespace asio = boost::asio;

namespace {

/// Lives as long as a wait is pending, which may be longer than the watch.
struct Waits : std::enable_shared_from_this<Waits> {
  Waits(const asio::any_io_executor& executor, int number, DescriptorCallbacks c)
      : descriptor(executor, number), calls(std::move(c)) {}

  void await(asio::posix::descriptor_base::wait_type what, const std::function<void()> DescriptorCallbacks::*call) {
    descriptor.async_wait(what, [self = shared_from_this(), call](const boost::system::error_code& error) {
      if (!error && self->alive) (self->calls.*call)();
    });
  }

  asio::posix::stream_descriptor descriptor;
  DescriptorCallbacks calls;
  bool alive = true;
};

class AsioWatch final : public DescriptorWatch {
 public:
  AsioWatch(const asio::any_io_executor& executor, int descriptor, DescriptorCallbacks calls)
      : waits_(std::make_shared<Waits>(executor, descriptor, std::move(calls))) {}
  ~AsioWatch() override {
    waits_->alive = false;
    waits_->descriptor.release();
  }
  AsioWatch(const AsioWatch&) = delete;
  AsioWatch& operator=(const AsioWatch&) = delete;

  void await_readable() override {
    waits_->await(asio::posix::descriptor_base::wait_read, &DescriptorCallbacks::readable);
  }
  void await_room() override { waits_->await(asio::posix::descriptor_base::wait_write, &DescriptorCallbacks::room); }

 private:
  std::shared_ptr<Waits> waits_;
};

}  // namespace

WatchDescriptor asio_watch(asio::any_io_executor executor) {
  return [executor = std::move(executor)](int descriptor, DescriptorCallbacks calls) {
    return std::make_unique<AsioWatch>(executor, descriptor, std::move(calls));
  };
}

WatchDescriptor asio_watch(Loop& loop) {
  return asio_watch(loop.context().get_executor());
}

namespace {

/// Maximum number of threads that wait for a name server.
constexpr int kMaxThreads = 16;

using Addresses = Result<std::vector<std::string>>;

/// Held by the caller; destroying it cancels the call. Used on the loop's thread only.
class PendingLookup final : public Lookup {
 public:
  explicit PendingLookup(std::shared_ptr<LookupDone> done) : done_(std::move(done)) {}
  ~PendingLookup() override { *done_ = nullptr; }
  PendingLookup(const PendingLookup&) = delete;
  PendingLookup& operator=(const PendingLookup&) = delete;

 private:
  std::shared_ptr<LookupDone> done_;
};

void complete(const std::shared_ptr<LookupDone>& done, Addresses addresses) {
  if (const auto call = std::exchange(*done, nullptr)) call(std::move(addresses));
}

}  // namespace

/// Passes results from the threads to the loop, until the loop ends.
struct NameLookup::Replies {
  explicit Replies(asio::any_io_executor e) : executor(std::move(e)) {}

  void post(std::shared_ptr<LookupDone> done, Addresses addresses) {
    const std::scoped_lock lock(mutex);
    if (!executor) return;
    asio::post(*executor, [done = std::move(done), addresses = std::move(addresses)]() mutable {
      complete(done, std::move(addresses));
    });
  }

  std::mutex mutex;
  std::optional<asio::any_io_executor> executor;  ///< until the loop ends
  std::atomic<int> threads{0};
};

NameLookup::NameLookup(const asio::any_io_executor& executor) : replies_(std::make_shared<Replies>(executor)) {}

NameLookup::~NameLookup() {
  const std::scoped_lock lock(replies_->mutex);
  replies_->executor.reset();
}

std::unique_ptr<Lookup> NameLookup::look_up(const std::string& host, LookupDone done) {
  auto call = std::make_shared<LookupDone>(std::move(done));
  auto pending = std::make_unique<PendingLookup>(call);
  boost::system::error_code error;
  const auto numeric = asio::ip::make_address(host, error);
  if (!error) {
    replies_->post(std::move(call), std::vector<std::string>{numeric.to_string()});
    return pending;
  }
  if (replies_->threads.fetch_add(1) >= kMaxThreads) {
    --replies_->threads;
    replies_->post(std::move(call),
                   fail(ErrorCode::kBusy, fmt::format("host {}: too many host names are being looked up", host)));
    return pending;
  }
  try {
    // The loop's thread keeps the call alive until its answer is posted, so it is never destroyed on the other one.
    std::thread([replies = replies_, host, call]() mutable {
      auto addresses = resolve(host);
      --replies->threads;
      replies->post(std::move(call), std::move(addresses));
    }).detach();
  } catch (const std::system_error& refused) {
    --replies_->threads;
    replies_->post(std::move(call), fail(ErrorCode::kIo, fmt::format("host {}: cannot start a thread to look it up: {}",
                                                                     host, refused.what())));
  }
  return pending;
}

}  // namespace rubicon::transport
