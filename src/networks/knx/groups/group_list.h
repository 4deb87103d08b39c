#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/dpt/dpt.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::groups {

/// Bounds of a group address list; beyond them it is refused, or the rest of it is left out and the report says so.
inline constexpr std::size_t kMaxListBytes = 64UL * 1024 * 1024;
inline constexpr std::size_t kMaxGroupAddresses = 65'535;
inline constexpr std::size_t kMaxFieldBytes = 4096;
/// A report keeps so many errors and so many warnings, and two notes an address; the others are counted.
inline constexpr std::size_t kMaxFindings = 10'000;
inline constexpr std::size_t kMaxNotes = 2 * kMaxGroupAddresses;

/// One group address as a project's export has it.
struct GroupEntry {
  wire::GroupAddress address{};
  wire::Notation notation = wire::Notation::kThreeLevel;
  std::string name, main_group, middle_group, description;  ///< UTF-8, at most 4 KiB each; line breaks are `\n`
  std::optional<dpt::DptId> dpt{};
  std::uint8_t size_bits = 0;  ///< what an ESF says besides the type; 0 = not said
  bool central = false, unfiltered = false;
  std::string security = "Auto";             ///< `Auto`, `On`, `Off`
  std::vector<wire::GroupAddress> listen{};  ///< ESF: more addresses that its objects hear
  std::size_t line = 0;                      ///< where it begins in the file, from 1

  friend bool operator==(const GroupEntry&, const GroupEntry&) = default;
};

/// One line of an import's report. Note: a guess or a fact worth knowing. Warning: taken, but not as it stands. Error:
/// not taken.
struct Finding {
  enum class Level : std::uint8_t { kNote, kWarning, kError };
  Level level = Level::kNote;
  std::size_t line = 0;  ///< 0 = not about a line
  std::optional<wire::GroupAddress> address{};
  std::string text;

  friend bool operator==(const Finding&, const Finding&) = default;
};

/// What became of a file.
struct Report {
  std::string source;  ///< the file's name
  std::string form;    ///< `ETS CSV 3/1`, `ETS XML`, `ESF`
  bool refused = false;
  std::size_t taken = 0, untyped = 0, main_type_only = 0, doubled = 0, out_of_range = 0;
  std::size_t paired = 0, kinds_by_name = 0;                        ///< guesses
  std::size_t added = 0, renamed = 0, unchanged = 0, vanished = 0;  ///< of a merge
  bool merged = false;
  std::size_t notes = 0, warnings = 0, errors = 0;
  std::vector<Finding> findings;  ///< by line, bounded as said above
  wire::Notation notation = wire::Notation::kThreeLevel;

  void add(Finding finding);
  void note(std::size_t line, std::optional<wire::GroupAddress> address, std::string text);
  void warning(std::size_t line, std::optional<wire::GroupAddress> address, std::string text);
  void error(std::size_t line, std::optional<wire::GroupAddress> address, std::string text);
  /// Nothing is imported: `text` is all that is left to say.
  void refuse(std::size_t line, std::string text);
};

std::string_view to_string(Finding::Level level);

/// The report for people: counts first, then a line each for errors, warnings and notes, in the order of the file.
std::string report_text(const Report& report);

/// The addresses of one file. Refused files have none.
struct GroupList {
  std::vector<GroupEntry> entries;  ///< in the order of the file, no address twice
  Report report;
};

}  // namespace rubicon::networks::knx::groups
