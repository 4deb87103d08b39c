#include "transport/poll_sockets.h"

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <thread>
#include <type_traits>
#include <utility>

#include "transport/asio_tcp.h"
#include "transport/asio_udp.h"
#include "transport/local_sockets.h"
#include "transport/mosquitto_line.h"
#include "transport/name_lookup.h"

namespace rubicon::transport {

namespace asio = boost::asio;

namespace {

/// Calls that wait in the loop keep it, and with it the sockets that they hold.
struct Waiter {
  explicit Waiter(PollLoop& l) : loop(l) {}
  asio::io_context context;
  PollLoop& loop;
};

/// Runs on the loop what the sockets of an io_context have to report.
class LoopExecutor {
 public:
  explicit LoopExecutor(std::shared_ptr<Waiter> waiter) : waiter_(std::move(waiter)) {}

  asio::execution_context& query(asio::execution::context_t) const noexcept { return waiter_->context; }
  static constexpr asio::execution::blocking_t query(asio::execution::blocking_t) noexcept {
    return asio::execution::blocking.never;
  }
  LoopExecutor require(asio::execution::blocking_t::never_t) const { return *this; }

  template <class Call>
  void execute(Call&& call) const {
    auto kept = std::make_shared<std::decay_t<Call>>(std::forward<Call>(call));
    waiter_->loop.post([kept = std::move(kept)] { (*kept)(); });
  }

  bool operator==(const LoopExecutor& other) const noexcept { return waiter_ == other.waiter_; }
  bool operator!=(const LoopExecutor& other) const noexcept { return waiter_ != other.waiter_; }

 private:
  std::shared_ptr<Waiter> waiter_;
};

}  // namespace

WatchDescriptor poll_watch(PollLoop& loop) {
  return [&loop](int descriptor, DescriptorCalls calls) { return loop.watch(descriptor, std::move(calls)); };
}

/// What the sockets of IP need.
struct PollSockets::Threaded {
  explicit Threaded(PollLoop& loop) : waiter(std::make_shared<Waiter>(loop)) {}
  ~Threaded();

  std::shared_ptr<Waiter> waiter;
  asio::any_io_executor executor{LoopExecutor(waiter)};
  asio::executor_work_guard<asio::io_context::executor_type> work{waiter->context.get_executor()};
  std::unique_ptr<NameLookup> names = std::make_unique<NameLookup>(executor);
  std::thread thread{[context = &waiter->context] { context->run(); }};
};

/// What the closed sockets still have to report goes to the loop, which drops it: in the io_context it would hold what
/// holds that io_context.
PollSockets::Threaded::~Threaded() {
  names.reset();
  work.reset();
  auto& context = waiter->context;
  context.stop();
  thread.join();
  context.restart();
  context.poll();
}

PollSockets::PollSockets(PollLoop& loop) : loop_(loop) {}
PollSockets::~PollSockets() = default;

PollSockets::Threaded& PollSockets::threaded() {
  if (!threaded_) threaded_ = std::make_unique<Threaded>(loop_);
  return *threaded_;
}

Result<std::unique_ptr<FileSource>> PollSockets::open_file(const std::string& path) {
  return fail(ErrorCode::kUnsupported, path + ": files are not supported here");
}

Result<std::unique_ptr<UdpSocket>> PollSockets::open_udp(const UdpOptions& options, UdpCalls calls) {
  return open_asio_udp(threaded().executor, options, std::move(calls));
}

Result<std::unique_ptr<TcpStream>> PollSockets::open_tcp(const TcpOptions& options, TcpCalls calls) {
  return open_asio_tcp(threaded().executor, options, std::move(calls));
}

Result<std::unique_ptr<TcpListener>> PollSockets::listen_tcp(const Endpoint& local, TcpAccept accept,
                                                             ListenerFailed failed) {
  return listen_asio_tcp(threaded().executor, local, std::move(accept), std::move(failed));
}

Result<std::unique_ptr<LocalStream>> PollSockets::open_local(const std::string& path, LocalCalls calls) {
  return open_local_socket(poll_watch(loop_), path, std::move(calls));
}

Result<std::unique_ptr<LocalListener>> PollSockets::listen_local(const std::string& path, LocalAccept accept) {
  return listen_local_socket(poll_watch(loop_), loop_, path, std::move(accept));
}

Result<std::unique_ptr<MqttLine>> PollSockets::open_mqtt(const MqttOptions& options, MqttCalls calls) {
  if (!mqtt_) mqtt_ = std::make_unique<MosquittoLines>(loop_);
  return mqtt_->open(options, std::move(calls));
}

std::unique_ptr<Lookup> PollSockets::look_up(const std::string& host, LookupDone done) {
  return threaded().names->look_up(host, std::move(done));
}

}  // namespace rubicon::transport
