#pragma once

#include <limits>

#include "base/bytes.h"
#include "model/message.h"

namespace rubicon::model {

constexpr OwnerId kHome{6541};
constexpr OwnerId kLab{12};

inline Message message_with(Body body) {
  return {kHome, 7, 1, {kHome, "wsn-1", "7"}, {kLab, "", ""}, std::move(body)};
}

inline Capability light_capability() {
  Capability light;
  light.point = {Kind::kSensor, TypeId{1}, "window"};
  light.type_name = "light";
  light.access = Access::kRead;
  light.unit = "lx";
  light.minimum = 0;
  light.maximum = 1847.5;
  light.deadline = std::chrono::seconds(3);
  light.initial = std::int64_t{-5};
  return light;
}

/// Of an open type (docs/types.md).
inline Capability open_capability() {
  Capability hush;
  hush.point = {Kind::kProperty, open_type("hush_mode"), "siren-1"};
  hush.type_name = "hush_mode";
  hush.access = Access::kReadWrite;
  hush.words = {{0, "loud"}, {1, "quiet"}};
  hush.data = DataType::kEnumeration;
  hush.report = Report::kEvent;
  return hush;
}

/// One of each kind, every field filled.
inline std::vector<Message> every_kind() {
  Capability dimmer;
  dimmer.point = {Kind::kActuator, TypeId{0x219}, "1"};
  dimmer.access = Access::kReadWrite;
  dimmer.reports = false;
  dimmer.sampled = true;
  const PointId rate{Kind::kProperty, TypeId{0x600}, ""};
  const WallTime when{std::chrono::microseconds(1'700'000'000'123'456)};
  return {message_with(Join{"mote",
                            "Kitchen mote",
                            "TelosB",
                            {light_capability(), dimmer, open_capability()},
                            false,
                            "kitchen",
                            "interview failed"}),
          message_with(KeepAlive{}),
          message_with(Leave{"battery empty"}),
          message_with(Updates{{{light_capability().point, 686.6, when}, {rate, std::int64_t{1000}, {}}}, false}),
          message_with(Actuate{UINT64_MAX, dimmer.point, 12.5, std::chrono::seconds(5)}),
          message_with(Sample{3, {light_capability().point, rate}, std::chrono::milliseconds(250)}),
          message_with(SetProperty{4, rate, std::int64_t{500}}),
          message_with(Acknowledge{5, Outcome::kUndeliverable, "no such island"}),
          message_with(
              State{LineState::kUp, "opened", {{"bad-frames", 3}, {"readings", UINT64_MAX}}, {{"server", "hall"}}}),
          message_with(Opaque{"chat", {0x00, 0xff, 0x68}}),
          message_with(Probe{Join{"mote", "", "TelosB", {light_capability()}, true}}),
          message_with(Unreachable{"no answer to 3 pings"})};
}

}  // namespace rubicon::model
