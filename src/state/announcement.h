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

/// An announcement in the CBOR of docs/gateway.cddl: a Join without name and id, which have columns of their own, and
/// the ids of the points in keys as values of an Updates. Devices of the same kind have the same bytes.
struct AnnouncementBytes {
  Bytes capabilities;
  Bytes point_ids;
};

/// Encodes announcements; refuses those that could not be read back.
class AnnouncementWriter {
 public:
  /// kOutOfRange or kInvalid: it exceeds the limits of the encoding; the text names the field.
  Result<AnnouncementBytes> write(const model::Join& join, const PointIds& point_ids);

 private:
  Result<void> check(const Bytes& bytes);

  std::unordered_set<std::string> sound_;  ///< already checked; bounded
};

/// Decodes announcements, equal ones only once.
class AnnouncementReader {
 public:
  /// nullptr: the bytes are no announcement. The result is valid until the next call.
  const model::Join* join(ByteView bytes);
  const PointIds* point_ids(ByteView bytes);

 private:
  std::unordered_map<std::string, model::Join> joins_;
  std::unordered_map<std::string, PointIds> point_ids_;
};

}  // namespace rubicon::state
