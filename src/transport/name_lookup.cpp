#include "transport/name_lookup.h"

#include <fmt/format.h>

#include <atomic>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "transport/resolve.h"

namespace rubicon::transport {

namespace asio = boost::asio;

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
