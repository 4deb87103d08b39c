#pragma once

#include <memory>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/descriptor_watch.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// A loop for programs that have an event loop of their own: one file descriptor signals that there is work. One thread
/// at a time uses it: the one that called poll() or wait() last. post() may be called from any thread.
class PollLoop final : public base::Scheduler {
 public:
  /// kIo if the system has no descriptors left.
  static Result<std::unique_ptr<PollLoop>> make();
  ~PollLoop() override;

  /// Readable (epoll, poll, select) when poll() has work. Owned by the loop.
  int descriptor() const;
  /// Runs what is due, without waiting. Calls posted meanwhile run the next time. Must not be called by one of the
  /// calls that it makes.
  void poll();
  /// Waits until there is work, at most for the timeout.
  void wait(Duration timeout);
  /// Ends wait(). May be called from any thread and from signal handlers.
  void wake();

  /// Its calls come from poll(), before those of timers. The loop outlives the watch.
  std::unique_ptr<DescriptorWatch> watch(int descriptor, DescriptorCallbacks calls);

  SteadyTime now() const override;
  WallTime wall_now() const override;
  void post(std::function<void()> call) override;
  Timer at(SteadyTime when, std::function<void()> call) override;
  bool on_loop_thread() const override;

 private:
  struct Impl;
  explicit PollLoop(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

class MosquittoLines;

/// PollLoop::watch(). The loop must outlive what it makes.
WatchDescriptor poll_watch(PollLoop& loop);

/// Sockets, names and MQTT lines of the machine for a PollLoop; files are not supported. All calls run on the loop. A
/// thread, which the first socket of IP and the first name start, waits for these and moves their bytes; local sockets
/// need none.
class PollSockets final : public Transports {
 public:
  /// The loop must outlive it; it must outlive its sockets.
  explicit PollSockets(PollLoop& loop);
  ~PollSockets() override;

  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;
  Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCallbacks calls) override;
  Result<std::unique_ptr<TcpStream>> open_tcp(const TcpOptions& options, TcpCallbacks calls) override;
  Result<std::unique_ptr<TcpListener>> listen_tcp(const Endpoint& local, TcpAccept accept,
                                                  ListenerFailed failed = nullptr) override;
  Result<std::unique_ptr<LocalStream>> open_local(const std::string& path, LocalCallbacks calls) override;
  Result<std::unique_ptr<LocalListener>> listen_local(const std::string& path, LocalAccept accept) override;
  Result<std::unique_ptr<MqttLine>> open_mqtt(const MqttOptions& options, MqttCallbacks calls) override;
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done) override;

 private:
  struct Threaded;
  Threaded& threaded();

  PollLoop& loop_;
  std::unique_ptr<Threaded> threaded_;
  std::unique_ptr<MosquittoLines> mqtt_;  ///< made when first needed
};

}  // namespace rubicon::transport
