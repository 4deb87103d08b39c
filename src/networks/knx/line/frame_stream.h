#pragma once

#include "networks/knx/wire/frame.h"

namespace rubicon::networks::knx::line {

/// Cuts a stream of bytes into frames by their total length (knx.md, section 3). Holds at most one
/// incomplete frame.
class FrameStream {
 public:
  /// Far longer than any frame of the services over TCP: a header with a larger length is an error.
  static constexpr std::size_t kMaxFrame = 2048;

  /// Adds received bytes; only after next() has returned an empty view.
  void append(ByteView bytes);
  /// The next whole frame, valid until the next call to this; empty if it is incomplete. kInvalid: the stream is broken
  /// and must be closed.
  Result<ByteView> next();
  void clear();

 private:
  Bytes buffer_;
  std::size_t begin_ = 0;
};

}  // namespace rubicon::networks::knx::line
