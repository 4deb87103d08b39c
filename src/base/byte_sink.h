#pragma once

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::base {

/// Receives bytes in order: a file opened for appending, a vector in tests.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Appends all bytes. After an error a part of them may have been appended.
  virtual Result<void> append(ByteView bytes) = 0;
};

}  // namespace rubicon::base
