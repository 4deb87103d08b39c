#pragma once

#include "networks/knx/wire/frame.h"

namespace rubicon::networks::knx::line {

/// Cuts a stream of bytes into frames by their total length (knx.md, section 3). Holds at most one frame that is not
/// complete.
class FrameStream {
 public:
  /// No frame of the services over TCP is nearly as long: one that says so is none.
  static constexpr std::size_t kLongestFrame = 2048;

  /// Takes more bytes; only after next() has given nothing.
  void append(ByteView bytes);
  /// The next whole frame, good until the next call to this; empty if there is none yet. kInvalid: the stream cannot be
  /// trusted any more.
  Result<ByteView> next();
  void clear();

 private:
  Bytes buffer_;
  std::size_t begin_ = 0;
};

}  // namespace rubicon::networks::knx::line
