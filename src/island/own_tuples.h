#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// A tuple that the island owns because its start said so: `--tuple KEY=VALUE`.
struct OwnTuple {
  std::string key, value;
};

/// Reads `KEY=VALUE` one by one (the value may be empty and hold further equals signs). kInvalid for what is none,
/// names a key twice, or names a key that the island keeps itself (below `prefix`, GATEWAY, ROAMING).
Result<std::vector<OwnTuple>> read_own_tuples(const std::vector<std::string>& texts, std::string_view prefix);

/// Keeps them in the space: text/plain, without expiry, and others may set them (as the original's command line does).
class OwnTuples {
 public:
  OwnTuples(TupleSpace& space, std::vector<OwnTuple> tuples) : space_(space), tuples_(std::move(tuples)) {}

  /// Publishes all of them.
  void start();

 private:
  TupleSpace& space_;
  std::vector<OwnTuple> tuples_;
  std::vector<tuples::Handle> judges_;
};

}  // namespace rubicon::island
