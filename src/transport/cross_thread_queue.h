#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

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

}  // namespace rubicon::transport
