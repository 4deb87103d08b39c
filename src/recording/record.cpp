#include "recording/record.h"

namespace rubicon::recording {

std::string_view to_string(RecordKind kind) {
  switch (kind) {
    case RecordKind::kSet: return "set";
    case RecordKind::kDeleted: return "deleted";
    case RecordKind::kExpired: return "expired";
    case RecordKind::kPresent: return "present";
    case RecordKind::kMark: return "mark";
  }
  return "unknown";
}

}  // namespace rubicon::recording
