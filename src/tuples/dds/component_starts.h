#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rubicon/tuple.hpp"

namespace rubicon::tuples::dds {

/// Version of frames, interests and presence (docs/ecology.md). Components with another one are seen but ignored.
inline constexpr std::uint16_t kProtocolVersion = 3;

/// One start (incarnation) of a component, from its presence.
struct ComponentStart {
  OwnerId id{};
  std::uint64_t incarnation = 0;
  std::uint16_t version = 0;  ///< 0 = not known
  bool present = false;
  std::string summary;
};

/// The starts that were observed, for diagnostics: those that are present, and the last that ended.
class ComponentStarts {
 public:
  static constexpr std::size_t kMax = 1000, kMaxGone = 100;

  void note(ComponentStart news) {
    const std::pair name(news.id, news.incarnation);
    const auto known = all_.find(name);
    if (news.present) {
      if (known != all_.end() || all_.size() < kMax) all_[name] = std::move(news);
    } else if (known != all_.end() && std::exchange(known->second.present, false)) {
      gone_.push_back(name);
      if (gone_.size() > kMaxGone) forget(gone_.front());
    }
  }
  std::vector<ComponentStart> all() const {
    std::vector<ComponentStart> list;
    for (const auto& entry : all_) list.push_back(entry.second);
    return list;
  }

 private:
  using Name = std::pair<OwnerId, std::uint64_t>;

  void forget(const Name& name) {
    const auto known = all_.find(name);
    if (known != all_.end() && !known->second.present) all_.erase(known);
    gone_.pop_front();
  }

  std::map<Name, ComponentStart> all_;
  std::deque<Name> gone_;  ///< in the order in which they ended
};

}  // namespace rubicon::tuples::dds
