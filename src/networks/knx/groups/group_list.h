#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/dpt/dpt.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::groups {

/// Bounds of a group address list. A longer file is refused; further addresses and longer fields are cut, with a
/// finding.
inline constexpr std::size_t kMaxListBytes = 64UL * 1024 * 1024;
inline constexpr std::size_t kMaxGroupAddresses = 65'535;
inline constexpr std::size_t kMaxFieldBytes = 4096;
/// A report keeps this many errors, this many warnings and two notes per address; further findings are only counted.
inline constexpr std::size_t kMaxFindings = 10'000;
inline constexpr std::size_t kMaxNotes = 2 * kMaxGroupAddresses;

/// How the devices of an installation use a group address, by the flags of their communication objects.
enum class Use : std::uint8_t {
  kUnknown,    ///< no device is known to use it
  kCommanded,  ///< devices take what is written to it, and none reports a value of its own on it
  kReported,   ///< devices report their values on it, and none takes what is written to it
  kShared,     ///< both: a sensor and a user of its values, or a button and a lamp
};

/// One group address of an ETS export.
struct GroupEntry {
  wire::GroupAddress address{};
  wire::Notation notation = wire::Notation::kThreeLevel;
  std::string name, main_group, middle_group, description;  ///< UTF-8, at most 4 KiB each; line breaks are `\n`
  std::optional<dpt::DptId> dpt{};
  std::uint8_t size_bits = 0;  ///< of an ESF, which has it besides the type; 0 = unknown
  bool central = false, unfiltered = false;
  std::string security = "Auto";  ///< `Auto`, `On`, `Off`
  bool secured = false;  ///< it takes secured telegrams only: it is `On`, or not `Off` and the list has its key
  std::vector<wire::GroupAddress> listen{};  ///< ESF: further addresses that its objects listen to
  Use use = Use::kUnknown;
  std::optional<wire::GroupAddress> state{};  ///< reports its state, as functions and objects of a project say
  std::string function{}, room{};             ///< `Ceiling light`, `First floor / Kitchen`
  std::size_t line = 0;                       ///< its first line in the file, from 1

  friend bool operator==(const GroupEntry&, const GroupEntry&) = default;
};

/// One line of the report of an import. Note: something inferred or worth knowing. Warning: imported with a change.
/// Error: not imported.
struct Finding {
  enum class Level : std::uint8_t { kNote, kWarning, kError };
  Level level = Level::kNote;
  std::size_t line = 0;  ///< 0 = the finding concerns no line
  std::optional<wire::GroupAddress> address{};
  std::string text;

  friend bool operator==(const Finding&, const Finding&) = default;
};

/// The outcome of an import.
struct Report {
  std::string source;  ///< the file's name
  std::string form;    ///< `ETS CSV 3/1`, `ETS XML`, `ESF`, `project of ETS 6 (schema 23)`
  bool refused = false;
  std::size_t taken = 0, untyped = 0, main_type_only = 0, doubled = 0, out_of_range = 0;
  std::size_t secured = 0;
  std::size_t paired = 0, kinds_by_name = 0;                        ///< inferred from names
  std::size_t paired_by_project = 0, kinds_by_project = 0;          ///< by flags of objects and roles in functions
  std::size_t added = 0, renamed = 0, unchanged = 0, vanished = 0;  ///< of a merge
  bool merged = false;
  std::size_t notes = 0, warnings = 0, errors = 0;
  std::vector<Finding> findings;  ///< by line, bounded by kMaxFindings and kMaxNotes
  wire::Notation notation = wire::Notation::kThreeLevel;

  void add(Finding finding);
  void note(std::size_t line, std::optional<wire::GroupAddress> address, std::string text);
  void warning(std::size_t line, std::optional<wire::GroupAddress> address, std::string text);
  void error(std::size_t line, std::optional<wire::GroupAddress> address, std::string text);
  /// Refuses the file: `text` is the only finding.
  void refuse(std::size_t line, std::string text);
};

std::string_view to_string(Finding::Level level);

/// The report as text: counts first, then one line for each finding, in the order of the file.
std::string report_text(const Report& report);

/// The addresses of one file. Refused files have none.
struct GroupList {
  std::vector<GroupEntry> entries;  ///< in the order of the file, without duplicates
  /// Projects: an address that is not secured here is plain. Lists have no keys, so that `Auto` leaves it open there.
  bool knows_plain = false;
  Report report;
};

/// The group addresses in the text of a file. An error in a line does not affect other lines; a file that is not a list
/// of this kind is refused (`report.refused`). Nothing but `text` is read.

/// ETS group address export as CSV: names in one to three columns, addresses in one to three; tab, semicolon or comma;
/// with or without header.
GroupList read_csv(std::string_view text);
/// ETS group address export as XML (http://knx.org/xml/ga-export/01). UTF-8, UTF-16, ISO-8859-1, Windows-1252; a
/// document with a document type declaration is refused.
GroupList read_xml(std::string_view text);
/// OPC export of ETS (.esf). It has main types only.
GroupList read_esf(std::string_view text);

/// Recognises the format by content: XML, ESF, else CSV. Refuses text that is too large, empty or of another kind.
GroupList read_group_list(std::string_view text);

}  // namespace rubicon::networks::knx::groups
