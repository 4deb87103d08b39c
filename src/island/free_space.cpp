#include "island/free_space.h"

#include <filesystem>
#include <system_error>

namespace rubicon::island {

namespace {

namespace fs = std::filesystem;

constexpr Duration kPause = std::chrono::seconds(10);

std::optional<std::uint64_t> free_bytes(const std::string& folder) {
  constexpr std::uint64_t kFine = 1'000'000, kCoarse = 100'000'000, kMuch = 1'000'000'000;
  std::error_code error;
  const auto space = fs::space(folder, error);
  if (error) return std::nullopt;
  const std::uint64_t free = space.available;
  return free - free % (free < kMuch ? kFine : kCoarse);
}

}  // namespace

std::optional<std::uint64_t> FreeSpace::beside(const std::string& file) {
  const auto parent = fs::path(file).parent_path();
  const auto folder = parent.empty() ? std::string(".") : parent.string();
  const auto now = scheduler_.now();
  const auto [entry, fresh] = known_.try_emplace(folder);
  auto& known = entry->second;
  if (!fresh && now - known.looked < kPause) return known.bytes;
  known = {now, free_bytes(folder)};
  return known.bytes;
}

}  // namespace rubicon::island
