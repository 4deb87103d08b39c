#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/byte_sink.h"
#include "rubicon/result.hpp"
#include "transport/serial.h"
#include "transport/tcp.h"
#include "transport/udp.h"

namespace rubicon::transport {

/// A file being read from front to back in pieces.
class FileSource {
 public:
  virtual ~FileSource() = default;
  /// Fills `into` from the present position; 0 = end of file. kIo on failure.
  virtual Result<std::size_t> read(std::span<std::uint8_t> into) = 0;
  virtual Result<void> seek(std::uint64_t offset) = 0;
  virtual std::uint64_t size() const = 0;
};

/// A file that grows at its end; nobody else can open it so meanwhile. Destroyed = closed. When the disk has what the
/// operating system took is left to that: to wait for it would hold up the loop for seconds.
class AppendFile : public base::ByteSink {
 public:
  /// Not buffered: what it took, the operating system has. kIo when the disk is full; then a part may stand in the file
  /// (size() tells).
  Result<void> append(ByteView bytes) override = 0;
  virtual std::uint64_t size() const = 0;
  /// Cuts the file off.
  virtual Result<void> truncate(std::uint64_t size) = 0;
};

/// Everything through which bytes enter and leave the process. Networks get it from their host, so that tests can hand
/// them lines of memory.
class Transports {
 public:
  virtual ~Transports() = default;
  /// kNotFound or kIo with the path in the text; a directory is refused.
  virtual Result<std::unique_ptr<FileSource>> open_file(const std::string& path) = 0;
  /// A bound socket; kBusy if the port is taken, else kIo, with the port in the text.
  /// By default there are none: kUnsupported.
  virtual Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCalls calls);
  /// A connection that is being made: whether it came about is told by the calls. kInvalid if the remote end is not
  /// numeric, kIo if the system gives no socket. By default there are none: kUnsupported.
  virtual Result<std::unique_ptr<TcpStream>> open_tcp(const TcpOptions& options, TcpCalls calls);
  /// Listens on a numeric address and a port; port 0 = any free one. Connections are accepted from then on; a system
  /// that has no room for one (descriptors) leaves it waiting. `failed` is called, in a later turn, when the port is
  /// lost. kBusy if the port is taken, kInvalid if the address is not numeric, else kIo. By default there are none:
  /// kUnsupported.
  virtual Result<std::unique_ptr<TcpListener>> listen_tcp(const Endpoint& local, TcpAccept accept,
                                                          ListenerFailed failed = nullptr);
  /// A serial line, for us alone. `connected` is called in a later turn. kNotFound if there is no such device, kBusy if
  /// somebody else has it, kInvalid for a baud rate the system does not know or what is no serial line, kIo, each with
  /// the path in the text. By default there are none: kUnsupported.
  virtual Result<std::unique_ptr<ByteStream>> open_serial(const SerialOptions& options, StreamCalls calls);
  /// Our end of a new pseudo-terminal, whose other end others open as a serial line under `link` (a symbolic link that
  /// is made here and removed with the stream; one that a dead program left behind is replaced). Who opens and closes
  /// the other end goes unnoticed; what is sent while nobody has it open may be lost. `connected` is called in a later
  /// turn. kBusy if another program's pseudo-terminal has that link, kDuplicate if something else is called so,
  /// kInvalid for what is no path, else kIo. By default there are none: kUnsupported.
  virtual Result<std::unique_ptr<ByteStream>> make_pty(const std::string& link, StreamCalls calls);
  /// Asks for the addresses of a host, IPv4 ones first, never empty. `done` is called once, in a later turn;
  /// kUnreachable if there are none. Destroying the answer ends the wait, and `done` is not called.
  /// Only for those who have sockets: asserted.
  virtual std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done);

  // Files that are written; kUnsupported where there are none.
  /// Opens a file at its end, makes an empty one if it is not there (its folder must be). kBusy if somebody else
  /// appends to it; never truncates.
  virtual Result<std::unique_ptr<AppendFile>> open_append(const std::string& path);
  /// kDuplicate if there is something called `to`: never over another file, also one that comes meanwhile.
  virtual Result<void> rename_file(const std::string& from, const std::string& to);
  virtual Result<void> remove_file(const std::string& path);
  /// Names of the regular files in a folder, sorted; an empty path is the working directory.
  virtual Result<std::vector<std::string>> list_folder(const std::string& path);
};

}  // namespace rubicon::transport
