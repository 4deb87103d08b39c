#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

/// `1/0/1`, `1/-/-`, `1/519`, `2567`: digits or `-`, at most three parts, at most 32 characters. Says nothing of
/// bounds.
bool looks_like_address(std::string_view text);

/// Which notation most addresses of a file are in.
class NotationDetector {
 public:
  /// Takes `2567` and whatever does not look like an address for no vote, unless `free_too`.
  void add(std::string_view address, bool free_too);
  wire::Notation winner() const;

 private:
  std::array<std::size_t, 3> votes_{};  ///< by number of slashes
};

/// What all kinds of files have in common: takes entries into a list, checks addresses and types, keeps the first of
/// doubled ones and reports what it changes or refuses. The list must outlive it.
class GroupListBuilder {
 public:
  GroupListBuilder(GroupList& list, wire::Notation notation);

  /// The address of an entry; reports why not. Nothing is taken yet.
  std::optional<wire::GroupAddress> address(std::size_t line, std::string_view text);
  /// `DPST-9-1`, `DPT-9 DPT-7`, blank: the type, or its main type if the sub type is unknown; adds doubts.
  std::optional<dpt::DptId> type(std::string_view text, std::vector<std::string>& doubts) const;
  /// A field's text, cut to its bound with a doubt.
  std::string field(std::string_view what, std::string_view utf8, std::vector<std::string>& doubts) const;
  /// Takes it; all doubts make one warning. `name` may be empty.
  void take(GroupEntry entry, const std::vector<std::string>& doubts);

  /// The bound of addresses is reached: the rest of the file is left out (reported once).
  bool full(std::size_t line);
  wire::Notation notation() const { return notation_; }

 private:
  GroupList& list_;
  wire::Notation notation_;
  std::unordered_map<std::uint16_t, std::size_t> lines_;  ///< of the addresses taken
};

/// `a; b; c`.
std::string joined(const std::vector<std::string>& texts);

}  // namespace rubicon::networks::knx::groups
