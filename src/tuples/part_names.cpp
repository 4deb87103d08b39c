#include "tuples/part_names.h"

#include "base/assert.h"

namespace rubicon::tuples {

PartNames::PartNames() {
  RUBICON_ASSERT(acquire("*") == kAnyPart);
  RUBICON_ASSERT(acquire("**") == kAnyRest);
}

PartId PartNames::find(std::string_view text) const {
  const auto found = ids_.find(text);
  return found == ids_.end() ? kNoPart : found->second;
}

PartId PartNames::acquire(std::string_view text) {
  PartId part = find(text);
  if (part == kNoPart) {
    if (free_.empty()) {
      part = static_cast<PartId>(entries_.size());
      entries_.emplace_back();
    } else {
      part = free_.back();
      free_.pop_back();
    }
    entries_[part].text = text;
    ids_.emplace(entries_[part].text, part);
  }
  ++entries_[part].uses;
  return part;
}

void PartNames::release(PartId part) {
  auto& entry = entries_[part];
  RUBICON_DEBUG_ASSERT(entry.uses > 0);
  if (--entry.uses > 0) return;
  ids_.erase(entry.text);
  entry.text = std::string();
  free_.push_back(part);
}

}  // namespace rubicon::tuples
