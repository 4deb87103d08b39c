#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "state/state_store.h"

namespace rubicon::state {

/// The lines of an export of a state file (docs/state.md, "The form of an export"), without their line ends.
std::string export_head(IslandId island);
std::string export_line(const state::KnownDevice& device);
std::string export_end(std::uint64_t devices);

/// Longest line of an export that is read, in bytes.
inline constexpr std::size_t kMaxExportLine = 8 << 20;

/// Takes the lines of an export one by one; errors name the line and what was expected there.
class ExportReader {
 public:
  /// The device of the line; none for the first and the last line of an export. After an error the next line may still
  /// be right.
  Result<std::optional<state::KnownDevice>> line(std::string_view text);
  /// kInvalid: the export was cut off.
  Result<void> end() const;

  /// Known after the first line.
  std::optional<IslandId> island() const { return island_; }

 private:
  Error wrong(std::string_view what) const;
  Result<void> head(std::string_view text);

  std::optional<IslandId> island_;
  std::uint64_t lines_ = 0, devices_ = 0;
  bool ended_ = false;
};

}  // namespace rubicon::state
