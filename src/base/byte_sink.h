#pragma once

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::base {

/// Where bytes are put for good, in order: a file being appended to, a vector in tests.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Takes all of them, or says why not; then a part may have been taken.
  virtual Result<void> append(ByteView bytes) = 0;
};

}  // namespace rubicon::base
