#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "transport/descriptor_watch.h"
#include "transport/mqtt.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// A serial line of the machine whose calls run on this executor; its io_context must outlive it. As
/// Transports::open_serial.
Result<std::unique_ptr<ByteStream>> open_asio_serial(const boost::asio::any_io_executor& executor,
                                                     const SerialOptions& options, StreamCallbacks calls);

/// As Transports::make_pty.
Result<std::unique_ptr<ByteStream>> make_asio_pty(const boost::asio::any_io_executor& executor, const std::string& link,
                                                  StreamCallbacks calls);

/// A connection of the machine whose calls run on this executor; its io_context must outlive it. As
/// Transports::open_tcp.
Result<std::unique_ptr<TcpStream>> open_asio_tcp(const boost::asio::any_io_executor& executor,
                                                 const TcpOptions& options, TcpCallbacks calls);

/// A port of the machine whose calls run on this executor; its io_context must outlive it. As Transports::listen_tcp.
Result<std::unique_ptr<TcpListener>> listen_asio_tcp(const boost::asio::any_io_executor& executor,
                                                     const Endpoint& local, TcpAccept accept, ListenerFailed failed);

/// What to do with a datagram after send() failed with this error (errno; 0 = none).
enum class AfterSend : std::uint8_t {
  kSent,
  kWait,  ///< the socket's buffer is full: wait until it is writable
  kDrop,  ///< a queue of the system is full (ENOBUFS): the socket counts as writable, so waiting would be a busy loop
  kRefused
};
AfterSend after_send(int error);

/// A socket of the machine whose calls run on this executor; its io_context must outlive it. As Transports::open_udp.
Result<std::unique_ptr<UdpSocket>> open_asio_udp(const boost::asio::any_io_executor& executor,
                                                 const UdpOptions& options, UdpCallbacks calls);

class Loop;

/// Watches descriptors in the io_context of the executor, which outlives the watches.
WatchDescriptor asio_watch(boost::asio::any_io_executor executor);
/// The loop must outlive what it makes.
WatchDescriptor asio_watch(Loop& loop);

/// Looks up host names on threads of its own, so that neither the loop nor the end of the process waits for a name
/// server. Must be destroyed before the io_context of its executor; this drops the pending lookups.
class NameLookup {
 public:
  /// The calls run on this executor.
  explicit NameLookup(const boost::asio::any_io_executor& executor);
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

  /// As Transports::look_up; kBusy if too many lookups are pending.
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done);

 private:
  struct Replies;
  std::shared_ptr<Replies> replies_;
};

/// As Transports::open_local(). The loop behind `watch` outlives the stream.
Result<std::unique_ptr<LocalStream>> open_local_socket(const WatchDescriptor& watch, const std::string& path,
                                                       LocalCallbacks calls);
/// As Transports::listen_local(). The loop behind `watch` and the scheduler outlive the listener and its streams.
Result<std::unique_ptr<LocalListener>> listen_local_socket(const WatchDescriptor& watch, Scheduler& scheduler,
                                                           const std::string& path, LocalAccept accept);

class MqttHome;

/// MQTT lines on libmosquitto, each with a thread of its own: the library blocks while it looks a name up and connects,
/// and takes longer in one call than a loop may stop. Must be destroyed before the loop, and after the lines.
class MosquittoLines {
 public:
  /// The scheduler must accept calls from other threads.
  explicit MosquittoLines(Scheduler& scheduler);
  /// Waits up to a second for connections of destroyed lines, until they are closed in order.
  ~MosquittoLines();
  MosquittoLines(const MosquittoLines&) = delete;
  MosquittoLines& operator=(const MosquittoLines&) = delete;

  /// As Transports::open_mqtt.
  Result<std::unique_ptr<MqttLine>> open(const MqttOptions& options, MqttCallbacks calls);

 private:
  Scheduler& scheduler_;
  std::shared_ptr<MqttHome> home_;
};

}  // namespace rubicon::transport
