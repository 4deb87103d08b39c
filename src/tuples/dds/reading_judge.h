#pragma once

#include <fmt/format.h>

#include "tuples/judge.h"

namespace rubicon::tuples::dds {

/// The judge of a process that has trust but no rights of its own, such as a tool: every member may read, and send
/// messages to it, which are answers and what it asked for; no member may set, or have messages relayed.
class ReadingJudge final : public Judge {
 public:
  Access access(const Member&, std::string_view) const override { return {}; }
  bool sees_all(const Member&) const override { return true; }
  Result<void> may_set(const Member& who, const RemoteSet& set) const override {
    if (set.key == "GATEWAY" || set.key.starts_with("RUBICON_GATEWAY")) return {};
    return fail(ErrorCode::kRefused,
                fmt::format("{} may not set {}: this program takes no commands", who.name, set.key));
  }
  Result<void> may_send(const Member& who, std::string_view where) const override {
    if (where == "own") return {};
    return fail(ErrorCode::kRefused,
                fmt::format("{} may not send to {}: this program relays nothing", who.name, where));
  }
  Result<void> may_by_names(const Member& who, Act act, std::span<const std::string> names) const override {
    if (act == Act::kSend) return may_send(who, names.front());
    RemoteSet set;
    set.key = names.front();
    return may_set(who, set);
  }
  Handle speak_for(const Member&, OwnerId, std::uint64_t) override { return {}; }
  const Member* spoken_for(OwnerId, std::uint64_t) const override { return nullptr; }
  void answered(const Member&, std::string_view, const RemoteSet&, const Reply&) override {}
  void record(const Member&, const Wish&, const Result<void>&) override {}
};

}  // namespace rubicon::tuples::dds
