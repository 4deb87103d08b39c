#include "recorder/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/clocks.h"
#include "recording/recording_reader.h"

namespace rubicon::recorder {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxTwins = 99;

struct NameParts {
  std::string folder, stem, extension;
};

NameParts parts_of(const std::string& path) {
  const fs::path whole(path);
  return {whole.parent_path().string(), whole.stem().string(), whole.extension().string()};
}

/// `20260131T120000.000000Z`.
std::string time_part(WallTime time) {
  // A damaged clock may give times that no calendar has.
  constexpr WallTime kLast{std::chrono::microseconds(253'402'300'799'999'999)};
  time = std::clamp(time, WallTime{}, kLast);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{}.{:06}Z", base::utc_text(time, "%Y%m%dT%H%M%S"), (time - seconds).count());
}

bool is_time_part(std::string_view text) {
  constexpr std::string_view kForm = "00000000T000000.000000Z";
  if (text.size() < kForm.size()) return false;
  const auto fits = [](char form, char c) { return form == '0' ? c >= '0' && c <= '9' : c == form; };
  if (!std::equal(kForm.begin(), kForm.end(), text.begin(), fits)) return false;
  text.remove_prefix(kForm.size());
  if (text.empty()) return true;
  return text.size() > 1 && text[0] == '-' && text.find_first_not_of("0123456789", 1) == text.npos;
}

bool is_rotated(const NameParts& parts, std::string_view name) {
  const auto before = parts.stem + "-";
  if (name.size() < before.size() + parts.extension.size()) return false;
  if (!name.starts_with(before) || !name.ends_with(parts.extension)) return false;
  name.remove_prefix(before.size());
  name.remove_suffix(parts.extension.size());
  return is_time_part(name);
}

}  // namespace

std::string rotated_name(const std::string& path, WallTime first) {
  const auto parts = parts_of(path);
  const auto name = fmt::format("{}-{}{}", parts.stem, time_part(first), parts.extension);
  return parts.folder.empty() ? name : parts.folder + "/" + name;
}

RecordingFile::RecordingFile(transport::Transports& transports, std::string path, recording::FileHead identity,
                             config::Rotation rotation)
    : transports_(transports), path_(std::move(path)), identity_(std::move(identity)), rotation_(rotation) {}

Result<RecordingFile::Opened> RecordingFile::open(WallTime first) {
  auto file = transports_.open_append(path_);
  if (!file) return fail(file.error());
  file_ = std::move(*file);
  auto opened = file_->size() == 0 ? begin(first) : resume(first);
  if (!opened) {
    file_.reset();
    return opened;
  }
  opened_size_ = file_->size();
  snapshot_size_ = 0;
  return opened;
}

Result<RecordingFile::Opened> RecordingFile::begin(WallTime first) {
  created_ = identity_.created = first;
  if (auto written = append(recording::encode_head(identity_)); !written) return fail(written.error());
  return Opened{true, 0};
}

Result<RecordingFile::Opened> RecordingFile::resume(WallTime first) {
  auto source = transports_.open_file(path_);
  if (!source) return fail(source.error());
  const auto read = [&source](std::uint64_t offset, std::span<std::uint8_t> into) -> Result<std::size_t> {
    if (auto there = (*source)->seek(offset); !there) return fail(there.error());
    return (*source)->read(into);
  };
  const auto tail = recording::find_tail(file_->size(), read);
  if (!tail) return fail(tail.error().code, fmt::format("{}: {}", path_, tail.error().text));
  const auto cut = file_->size() - tail->sound;
  if (tail->has_head && (tail->head.island != identity_.island || tail->head.prefix != identity_.prefix)) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is a recording of island {} with prefix {}, expected island {} with prefix {}", path_,
                            number(tail->head.island), model::quoted(tail->head.prefix), number(identity_.island),
                            identity_.prefix));
  }
  if (cut > 0) {
    if (auto done = file_->truncate(tail->sound); !done) return fail(done.error());
  }
  if (!tail->has_head) {
    auto begun = begin(first);
    if (begun) begun->cut = cut;
    return begun;
  }
  // A head with a wrong time, even a hostile one, neither causes a rotation at once nor prevents it.
  created_ = std::clamp(tail->head.created, std::min(WallTime{}, first), first);
  return Opened{false, cut};
}

Result<void> RecordingFile::append(ByteView block) {
  const auto before = file_->size();
  auto written = file_->append(block);
  if (written) return written;
  std::ignore = file_->truncate(before);
  file_.reset();
  return written;
}

bool RecordingFile::rotation_due(WallTime now) const {
  if (!file_) return false;
  if (rotation_.every && now - created_ >= std::chrono::floor<std::chrono::microseconds>(*rotation_.every)) return true;
  if (!rotation_.size || file_->size() < *rotation_.size) return false;
  return file_->size() - opened_size_ >= 2 * snapshot_size_;
}

Result<void> RecordingFile::rotate() {
  file_.reset();
  const auto name = rotated_name(path_, created_);
  auto renamed = transports_.rename_file(path_, name);
  const auto extension = parts_of(name).extension;
  for (int twin = 2; !renamed && renamed.error().code == ErrorCode::kDuplicate && twin <= kMaxTwins; ++twin) {
    const auto stem = name.substr(0, name.size() - extension.size());
    renamed = transports_.rename_file(path_, fmt::format("{}-{}{}", stem, twin, extension));
  }
  return renamed;
}

Result<void> RecordingFile::remove_old() {
  if (!rotation_.keep) return {};
  const auto parts = parts_of(path_);
  auto names = transports_.list_folder(parts.folder);
  if (!names) return fail(names.error());
  std::erase_if(*names, [&parts](const std::string& name) { return !is_rotated(parts, name); });
  Result<void> done;
  for (std::size_t i = 0; i + *rotation_.keep < names->size(); ++i) {
    const auto& name = (*names)[i];
    if (auto removed = transports_.remove_file(parts.folder.empty() ? name : parts.folder + "/" + name); !removed)
      done = removed;
  }
  return done;
}

}  // namespace rubicon::recorder
