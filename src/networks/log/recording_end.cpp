#include "networks/log/recording_end.h"

#include "recording/file_tail.h"

namespace rubicon::networks::log {

std::optional<RecordTime> end_of_recording(transport::Transports& transports, const std::string& path) {
  const auto file = transports.open_file(path);
  if (!file) return std::nullopt;
  const auto read = [&file](std::uint64_t offset, std::span<std::uint8_t> into) -> Result<std::size_t> {
    if (auto there = (*file)->seek(offset); !there) return fail(there.error());
    return (*file)->read(into);
  };
  const auto tail = recording::find_tail((*file)->size(), read);
  if (!tail || !tail->last) return std::nullopt;
  return tail->last->time_since_epoch();
}

}  // namespace rubicon::networks::log
