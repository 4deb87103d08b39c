#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

/// True for `1/0/1`, `1/-/-`, `1/519`, `2567`: digits or `-`, at most three parts, at most 32 characters. Values are
/// not checked.
bool looks_like_address(std::string_view text);

/// Finds the notation that most addresses of a file have.
class NotationDetector {
 public:
  /// Ignores text that does not look like an address and, unless `free_too`, plain numbers such as `2567`.
  void add(std::string_view address, bool free_too);
  wire::Notation winner() const;

 private:
  std::array<std::size_t, 3> votes_{};  ///< by number of slashes
};

/// Builds a list from the entries of any kind of file: checks addresses and types, keeps the first of duplicates, and
/// reports what it changes or refuses. The list must outlive it.
class GroupListBuilder {
 public:
  GroupListBuilder(GroupList& list, wire::Notation notation);

  /// The address of an entry; nullopt, with an error in the report, if it is not an address.
  std::optional<wire::GroupAddress> address(std::size_t line, std::string_view text);
  /// The same for a number, as projects have it in any notation.
  std::optional<wire::GroupAddress> address_of_number(std::size_t line, std::string_view text);
  /// `DPST-9-1`, `DPT-9 DPT-7`, blank: the type, or its main type if the sub type is unknown. Adds
  /// a text to `changes` for what it cannot use.
  std::optional<dpt::DptId> type(std::string_view text, std::vector<std::string>& changes) const;
  /// The text of a field, cut to kMaxFieldBytes.
  std::string field(std::string_view what, std::string_view utf8, std::vector<std::string>& changes) const;
  /// Adds the entry; `changes` become one warning. The name may be empty; `secured`: whether the file has its key.
  void add(GroupEntry entry, const std::vector<std::string>& changes);

  /// True, with an error in the report, if the list has kMaxGroupAddresses.
  bool full(std::size_t line);
  wire::Notation notation() const { return notation_; }

 private:
  GroupList& list_;
  wire::Notation notation_;
  std::unordered_map<std::uint16_t, std::size_t> lines_;  ///< by address
};

/// `a; b; c`.
std::string joined(const std::vector<std::string>& texts);

}  // namespace rubicon::networks::knx::groups
