#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "rubicon/result.hpp"
#include "transport/mqtt.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// Does one job after the other apart from the loop, for work that waits for a disk or computes long.
class Worker {
 public:
  using Job = std::function<void()>;

  /// Runs the jobs that wait, then ends.
  virtual ~Worker() = default;
  /// Appends a job; it runs on the worker's thread, and posts its result to the loop. The queue has no bound: the
  /// caller counts what it gave.
  virtual void run(Job job) = 0;
};

/// A thread of its own, of low priority. `name` shows it in lists of threads: at most 15 characters. kIo: the system
/// has no room for one more.
Result<std::unique_ptr<Worker>> start_worker(const std::string& name);

/// A file that is read in pieces.
class FileSource {
 public:
  virtual ~FileSource() = default;
  /// Fills `into` from the present position; 0 = end of file. kIo on failure.
  virtual Result<std::size_t> read(std::span<std::uint8_t> into) = 0;
  virtual Result<void> seek(std::uint64_t offset) = 0;
  virtual std::uint64_t size() const = 0;
  /// Every user of the machine may read it; false where there are no users.
  virtual bool open_to_all() const { return false; }
  /// Users besides its reader may read or write it. On a disk, private is: the file belongs to this user or to root,
  /// and only that user has permissions; of a file of root the group may read it, as files of systemd's credentials
  /// permit.
  virtual bool open_to_others() const { return open_to_all(); }
};

/// A file opened for appending, by one program at a time. Destroying it closes it. The operating system decides when
/// the bytes reach the disk: waiting for that would block the loop for seconds.
class AppendFile : public base::ByteSink {
 public:
  /// Not buffered here. kIo if the disk is full; a part of the bytes may have been written (see size()).
  Result<void> append(ByteView bytes) override = 0;
  virtual std::uint64_t size() const = 0;
  /// Cuts the file to this size.
  virtual Result<void> truncate(std::uint64_t size) = 0;
};

/// Everything through which bytes enter and leave the process. Networks get it from their host, so that tests can
/// provide in-memory lines. By default all operations but open_file() give kUnsupported.
class Transports {
 public:
  virtual ~Transports() = default;
  /// kNotFound or kIo with the path in the text; a directory is refused.
  virtual Result<std::unique_ptr<FileSource>> open_file(const std::string& path) = 0;
  /// A bound socket; kBusy if the port is taken, else kIo, with the port in the text.
  virtual Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCallbacks calls);
  /// Begins to connect; the calls report the result. kInvalid if the remote end is not numeric, kIo if the system gives
  /// no socket.
  virtual Result<std::unique_ptr<TcpStream>> open_tcp(const TcpOptions& options, TcpCallbacks calls);
  /// Listens on a numeric address and a port; port 0 = any free one. While the system has no descriptors
  /// left, connections wait. `failed` is called, in a later turn, if the port is lost. kBusy if the port is taken,
  /// kInvalid if the address is not numeric, else kIo.
  virtual Result<std::unique_ptr<TcpListener>> listen_tcp(const Endpoint& local, TcpAccept accept,
                                                          ListenerFailed failed = nullptr);
  /// Connects to a Unix stream socket; at once, because the kernel does. kNotFound: there is none; kUnreachable: nobody
  /// listens on it; kBusy: too many connections wait to be accepted, try again a little later; kRefused: no permission;
  /// kInvalid: the path is too long; else kIo.
  virtual Result<std::unique_ptr<LocalStream>> open_local(const std::string& path, LocalCallbacks calls);
  /// Binds and listens at a path where nothing is, and gives its user and group access (0660), whatever the umask. The
  /// socket remains in its folder. kDuplicate: there is something; kInvalid: the path is too long; kRefused: no
  /// permission; else kIo. While the system has no descriptors left, connections wait.
  virtual Result<std::unique_ptr<LocalListener>> listen_local(const std::string& path, LocalAccept accept);
  /// Opens a serial line exclusively. `connected` is called in a later turn. kNotFound if there is no such device,
  /// kBusy if another program has it, kInvalid for an unknown baud rate or a file that is not a serial line, else kIo;
  /// each with the path in the text.
  virtual Result<std::unique_ptr<ByteStream>> open_serial(const SerialOptions& options, StreamCallbacks calls);
  /// Makes a pseudo-terminal, whose other end programs open as a serial line under `link`: a symbolic link that is made
  /// here and removed with the stream; a stale one is replaced. Opening and closing of the other end is not noticed;
  /// bytes sent while it is closed may be lost. `connected` is called in a later turn. kBusy if the pseudo-terminal of
  /// another program has that link, kDuplicate if another file has that name, kInvalid for an invalid path, else kIo.
  virtual Result<std::unique_ptr<ByteStream>> make_pty(const std::string& link, StreamCallbacks calls);
  /// Begins to connect to an MQTT broker; the calls report the result. kInvalid for options that no broker can accept,
  /// kIo if the system gives no thread; kBusy with 256 lines in the process, or while 16 destroyed lines to this
  /// broker still wait for its host.
  virtual Result<std::unique_ptr<MqttLine>> open_mqtt(const MqttOptions& options, MqttCallbacks calls);
  /// Looks up the addresses of a host, IPv4 ones first, never empty. `done` is called once, in a later turn;
  /// kUnreachable if there are none. Destroying the result cancels the call. Only if there are sockets: asserted.
  virtual std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done);

  /// A thread for work that computes long, such as deriving keys from passwords; see transports.h. kIo: the system has
  /// no room for one more.
  virtual Result<std::unique_ptr<Worker>> start_worker(const std::string& name);

  // Writing files.
  /// Opens a file for appending, and creates it if it does not exist (its folder must). kBusy if another program
  /// appends to it. Never truncates.
  virtual Result<std::unique_ptr<AppendFile>> open_append(const std::string& path);
  /// kDuplicate if there is something called `to`: never over another file, also one that comes meanwhile.
  virtual Result<void> rename_file(const std::string& from, const std::string& to);
  virtual Result<void> remove_file(const std::string& path);
  /// Names of the regular files in a folder, sorted; an empty path is the working directory.
  virtual Result<std::vector<std::string>> list_folder(const std::string& path);
};

/// Reads a whole file of the configuration. kOutOfRange if it is longer than `largest` bytes, else the errors of
/// open_file() and read(). Blocks: for start-up and reloads.
Result<std::string> read_text(Transports& transports, const std::string& path, std::size_t largest);

}  // namespace rubicon::transport
