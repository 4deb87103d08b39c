#pragma once

#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "model/message.h"
#include "rubicon/result.hpp"

namespace rubicon::state {

using PointIds = std::vector<std::pair<model::PointId, std::string>>;

/// What changes only with a new announcement, in the CBOR of docs/gateway.cddl: a Join without its name and id, which
/// stand in columns, and the key parts of the points as an Updates whose values they are. Devices of one kind say the
/// same bytes.
struct AnnouncementBytes {
  Bytes capabilities;
  Bytes point_ids;
};

/// Writes announcements; refuses what could not be read back.
class AnnouncementWriter {
 public:
  /// kOutOfRange or kInvalid: beyond the bounds of the form; the text names the field.
  Result<AnnouncementBytes> write(const model::Join& join, const PointIds& point_ids);

 private:
  Result<void> try_out(const Bytes& bytes);

  std::unordered_set<std::string> sound_;  ///< read back before; bounded
};

/// Reads announcements; each different one only once.
class AnnouncementReader {
 public:
  /// nullptr: not the form. The answer is valid until the next call.
  const model::Join* join(ByteView bytes);
  const PointIds* point_ids(ByteView bytes);

 private:
  std::unordered_map<std::string, model::Join> joins_;
  std::unordered_map<std::string, PointIds> point_ids_;
};

}  // namespace rubicon::state
