#pragma once

#include <optional>

#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// A package as it came; the body refers to the stream that it was read from.
struct Package {
  PackageHeader header;
  ByteView body;
};

/// Cuts the bytes of one direction of a connection into the connect message and packages (peis.md, section 3.4). Holds
/// at most what was appended last and one incomplete package before it.
class PackageStream {
 public:
  /// Adds received bytes; only after next() or connect() has returned nullopt. Ends the views of all packages.
  void append(ByteView bytes);

  /// The connect message that the initiator sends first; nullopt while it is incomplete. Any error is final: the
  /// connection must be closed.
  Result<std::optional<ConnectMessage>> connect();
  /// The next whole package, valid until append(); nullopt while it is incomplete. Any error is final.
  Result<std::optional<Package>> next();

  /// Bytes of an incomplete package.
  std::size_t pending() const { return buffer_.size() - begin_; }

 private:
  ByteView rest() const { return ByteView(buffer_).subspan(begin_); }

  Bytes buffer_;
  std::size_t begin_ = 0;
  std::optional<Error> fault_;
};

}  // namespace rubicon::tuples::peis
