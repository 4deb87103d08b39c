#include "tuples/distant/frame_ages.h"

#include <algorithm>

namespace rubicon::tuples::distant {

FrameTimes FrameAges::next(Duration now, bool asks) const {
  if (!heard_) return {now, {}, {}, asks};
  return {now, heard_->sent, now - heard_->at, asks};
}

void FrameAges::arrived(const FrameTimes& times, Duration now) {
  heard_ = Heard{times.sent, now};
  if (lead_ && now - times.sent < lead_->least - slack(*lead_, now)) lead_.reset();  // the own clock stood still
  if (!times.echo) return;
  const Lead found{*times.echo + times.held - times.sent, *times.echo};
  if (!lead_ || found.least - slack(found, now) >= lead_->least - slack(*lead_, now)) lead_ = found;
}

std::optional<Duration> FrameAges::age(Duration sent, Duration now) const {
  if (!lead_ || slack(*lead_, now) > kMaxSlack) return std::nullopt;
  return std::max(now - sent - lead_->least + slack(*lead_, now), Duration(0));
}

}  // namespace rubicon::tuples::distant
