#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "state/state_store.h"

namespace rubicon::state {

// An export of a state file as lines of JSON (docs/state.md, "The form of an export"), without line ends.
std::string export_head(IslandId island);
std::string export_line(const KnownDevice& device);
std::string export_end(std::uint64_t devices);

/// Longest line that is accepted, in bytes.
inline constexpr std::size_t kMaxExportLine = 8 << 20;

/// Reads the lines of an export one by one; errors name the line and what was expected.
class ExportReader {
 public:
  /// The device of the line; nullopt for the first and the last line. After an error the next line may be correct.
  Result<std::optional<KnownDevice>> line(std::string_view text);
  /// kInvalid: the export is incomplete.
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
