#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace rubicon::transport {

/// How other threads hand calls to the thread that runs an io_context. Through a pipe: Linux lets whom a write to a
/// pipe wakes run where the writer runs (a synchronous wake-up, since 6.13 through epoll too), which spares an idle
/// machine waking a second processor for every message; the io_context's own eventfd has no such wish. Between bursts
/// of calls it keeps the context from running out of work.
class Doorbell : public std::enable_shared_from_this<Doorbell> {
 public:
  using Call = std::function<void()>;

  /// nullptr when the process has no descriptors left. `run` makes one handed call, on the context's thread.
  static std::shared_ptr<Doorbell> make(boost::asio::io_context& context, std::function<void(const Call&)> run);
  explicit Doorbell(boost::asio::io_context& context) : pipe_(context) {}
  Doorbell(const Doorbell&) = delete;
  Doorbell& operator=(const Doorbell&) = delete;
  ~Doorbell();

  /// From any thread. Calls are made in the order they came.
  void post(Call call);
  /// On the context's thread: no call is made any more.
  void close();

 private:
  void listen();
  void answer();

  boost::asio::posix::stream_descriptor pipe_;
  int write_end_ = -1;
  std::function<void(const Call&)> run_;
  std::array<char, 64> rings_{};
  std::mutex mutex_;
  std::vector<Call> calls_;
};

}  // namespace rubicon::transport
