#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tuples/tuple.h"

namespace rubicon::tuples::dds {

/// Of what stands in frames, interests and presence (docs/ecology.md). Who has another one is seen, but not talked to.
inline constexpr std::uint16_t kProtocolVersion = 1;

/// One start of a component, as its presence says.
struct Appearance {
  OwnerId id{};
  std::uint64_t incarnation = 0;
  std::uint16_t version = 0;  ///< 0 = never told
  bool present = false;
  std::string summary;
};

/// What was met, for those who look for what is wrong. Those that went make room.
class Appearances {
 public:
  static constexpr std::size_t kMost = 1000;

  void note(Appearance news) {
    const std::pair name(news.id, news.incarnation);
    const auto known = all_.find(name);
    if (known != all_.end() && !news.present) {
      known->second.present = false;
    } else if (known != all_.end() || (news.present && has_room())) {
      all_[name] = std::move(news);
    }
  }
  std::vector<Appearance> all() const {
    std::vector<Appearance> list;
    for (const auto& entry : all_) list.push_back(entry.second);
    return list;
  }

 private:
  bool has_room() {
    if (all_.size() < kMost) return true;
    return std::erase_if(all_, [](const auto& entry) { return !entry.second.present; }) > 0;
  }

  std::map<std::pair<OwnerId, std::uint64_t>, Appearance> all_;
};

}  // namespace rubicon::tuples::dds
