#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_set>

namespace rubicon::networks::knx::project {

/// Bytes that one project may keep in memory while it is read: of names, texts and ids, and of what holds them. Each of
/// 65,535 addresses may have a name of 200 bytes, and be linked to two objects.
inline constexpr std::size_t kMaxKept = std::size_t{96} << 20U;

/// Keeps each text of a project once, and counts all that is kept of it. The documents of a project share one, so that
/// no combination of them takes more than the bound.
class KeptTexts {
 public:
  explicit KeptTexts(std::size_t most = kMaxKept) : most_(most) {}
  KeptTexts(const KeptTexts&) = delete;
  KeptTexts& operator=(const KeptTexts&) = delete;

  /// A copy that lives as long as this object; empty if it is beyond the bound.
  std::string_view keep(std::string_view text);
  /// Counts bytes that are kept elsewhere. False if they are beyond the bound: then they must not be kept.
  bool charge(std::size_t bytes);
  /// Something was beyond the bound: the project is to be refused.
  bool is_exceeded() const { return exceeded_; }
  /// The sentence for that.
  std::string why() const;

 private:
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;
  };

  std::unordered_set<std::string, Hash, std::equal_to<>> texts_;  ///< its elements never move
  std::size_t most_, used_ = 0;
  bool exceeded_ = false;
};

}  // namespace rubicon::networks::knx::project
