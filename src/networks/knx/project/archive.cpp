#include "networks/knx/project/archive.h"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <array>

#include "networks/knx/project/zip_source.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::project {

namespace {

constexpr std::size_t kPiece = 65'536;
constexpr std::uint16_t kStored = 0, kDeflated = 8;

/// Frees what it holds of an entry, also on the way of an error.
struct CloseFile {
  void operator()(zip_file_t* file) const { ::zip_fclose(file); }
};
using OpenedFile = std::unique_ptr<zip_file_t, CloseFile>;

Archive::Protection protection_of(std::uint16_t method) {
  switch (method) {
    case ZIP_EM_NONE: return Archive::Protection::kNone;
    case ZIP_EM_TRAD_PKWARE: return Archive::Protection::kZipCrypto;
    case ZIP_EM_AES_128:
    case ZIP_EM_AES_192:
    case ZIP_EM_AES_256: return Archive::Protection::kAes;
    default: return Archive::Protection::kOther;
  }
}

/// True for a path that leads out of the folder it is unpacked to, on any system.
bool leads_out(std::string_view name) {
  if (name.empty() || name.front() == '/' || name.front() == '\\') return true;
  if (name.size() > 1 && name[1] == ':') return true;
  while (true) {
    const auto end = std::min(name.find_first_of("/\\"), name.size());
    if (name.substr(0, end) == "..") return true;
    if (end == name.size()) return false;
    name.remove_prefix(end + 1);
  }
}

Error beyond(std::string what) {
  return {ErrorCode::kOutOfRange, std::move(what)};
}

/// libzip's error while an entry is opened or unpacked.
Error entry_error(const Archive::Entry& entry, zip_error_t* error) {
  const auto name = model::quoted(entry.name);
  switch (::zip_error_code_zip(error)) {
    case ZIP_ER_NOPASSWD: return {ErrorCode::kRefused, fmt::format("entry {} is protected by a password", name)};
    case ZIP_ER_WRONGPASSWD: return {ErrorCode::kRefused, fmt::format("the password does not open entry {}", name)};
    case ZIP_ER_READ: return {ErrorCode::kIo, fmt::format("entry {} cannot be read", name)};
    default: break;
  }
  return {ErrorCode::kInvalid,
          fmt::format("entry {} cannot be unpacked ({}): the archive is damaged", name, ::zip_error_strerror(error))};
}

/// The password as libzip takes it: with a zero at its end.
secure::Secret terminated(const secure::Secret& password) {
  secure::Secret text(password.size() + 1);
  std::copy(password.view().begin(), password.view().end(), text.span().begin());
  return text;
}

}  // namespace

void Archive::Close::operator()(zip* archive) const {
  ::zip_discard(archive);
}

Result<Archive> Archive::open(std::unique_ptr<transport::FileSource> file, const ArchiveLimits& limits) {
  if (file->size() > limits.bytes)
    return fail(beyond(fmt::format("has {} bytes, expected at most {}", file->size(), limits.bytes)));
  const auto end = read_archive_end(*file);
  if (!end) return fail(end.error());
  if (end->entries > limits.entries)
    return fail(beyond(fmt::format("has {} entries, expected at most {}", end->entries, limits.entries)));
  if (end->directory > limits.directory)
    return fail(
        beyond(fmt::format("its list of entries has {} bytes, expected at most {}", end->directory, limits.directory)));
  zip_error_t error;
  ::zip_error_init(&error);
  auto* source = zip_source_of(std::move(file), &error);
  auto* opened = source == nullptr ? nullptr : ::zip_open_from_source(source, ZIP_RDONLY, &error);
  const std::string why = opened == nullptr ? ::zip_error_strerror(&error) : "";
  if (opened == nullptr && source != nullptr) ::zip_source_free(source);
  ::zip_error_fini(&error);
  if (opened == nullptr) return fail(ErrorCode::kInvalid, fmt::format("cut or damaged zip archive ({})", why));
  Archive archive(opened, limits);
  if (auto listed = archive.list(); !listed) return fail(listed.error());
  return archive;
}

Result<void> Archive::list() {
  const auto count = ::zip_get_num_entries(zip_.get(), 0);
  if (count < 0 || static_cast<std::uint64_t>(count) > limits_.entries)
    return fail(beyond(fmt::format("has {} entries, expected at most {}", count, limits_.entries)));
  std::uint64_t unpacked = 0;
  for (std::uint64_t index = 0; index < static_cast<std::uint64_t>(count); ++index) {
    auto entry = entry_at(index);
    if (!entry) return fail(entry.error());
    if (entry->unpacked > limits_.unpacked - unpacked)
      return fail(beyond(fmt::format("unpacks to more than {} bytes", limits_.unpacked)));
    unpacked += entry->unpacked;
    if (!by_name_.try_emplace(entry->name, entries_.size()).second)
      return fail(ErrorCode::kInvalid, fmt::format("has entry {} twice", model::quoted(entry->name)));
    entries_.push_back(std::move(*entry));
  }
  return {};
}

Result<Archive::Entry> Archive::entry_at(std::uint64_t index) const {
  zip_stat_t found;
  constexpr auto kNeeded =
      ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  if (::zip_stat_index(zip_.get(), index, 0, &found) != 0 || (found.valid & kNeeded) != kNeeded)
    return fail(ErrorCode::kInvalid, fmt::format("its entry {} cannot be read", index + 1));
  if (leads_out(found.name))
    return fail(ErrorCode::kInvalid, fmt::format("its entry {} is named {}, expected a relative path without '..'",
                                                 index + 1, model::quoted(found.name)));
  return Entry{found.name,       index, found.comp_size, found.size, protection_of(found.encryption_method),
               found.comp_method};
}

const Archive::Entry* Archive::find(std::string_view name) const {
  const auto found = by_name_.find(std::string(name));
  return found == by_name_.end() ? nullptr : &entries_[found->second];
}

Result<void> Archive::check(const Entry& entry) const {
  const auto name = model::quoted(entry.name);
  if (entry.method != kStored && entry.method != kDeflated)
    return fail(ErrorCode::kInvalid, fmt::format("entry {} has compression method {}, expected deflate (8) or none (0)",
                                                 name, entry.method));
  if (entry.protection == Protection::kOther)
    return fail(ErrorCode::kInvalid, fmt::format("entry {} is encrypted, expected ZipCrypto or WinZip AES", name));
  if (entry.unpacked > limits_.ratio_from && entry.unpacked / limits_.ratio >= std::max<std::uint64_t>(entry.packed, 1))
    return fail(beyond(fmt::format("entry {} has {} bytes and unpacks to {}, more than {} times as much", name,
                                   entry.packed, entry.unpacked, limits_.ratio)));
  return {};
}

Result<void> Archive::read(const Entry& entry, const secure::Secret* password, const Take& take) const {
  if (auto sound = check(entry); !sound) return sound;
  const auto text = password == nullptr ? secure::Secret() : terminated(*password);
  const char* given = password == nullptr ? nullptr : text.text().data();
  const OpenedFile file(::zip_fopen_index_encrypted(zip_.get(), entry.index, 0, given));
  if (!file) return fail(entry_error(entry, ::zip_get_error(zip_.get())));
  secure::Secret piece(kPiece);
  std::uint64_t done = 0;
  while (true) {
    const auto count = ::zip_fread(file.get(), piece.span().data(), kPiece);
    if (count < 0) return fail(entry_error(entry, ::zip_file_get_error(file.get())));
    if (count == 0) return {};
    done += static_cast<std::uint64_t>(count);
    if (done > entry.unpacked)
      return fail(beyond(fmt::format("entry {} unpacks to more than the {} bytes that the archive states",
                                     model::quoted(entry.name), entry.unpacked)));
    const auto more = take(piece.text().substr(0, static_cast<std::size_t>(count)));
    if (!more) return fail(more.error());
    if (!*more) return {};
  }
}

Result<Archive> Archive::open_inner(const Entry& entry) const {
  if (entry.unpacked > limits_.inner_archive)
    return fail(beyond(fmt::format("entry {} has {} bytes, expected at most {}", model::quoted(entry.name),
                                   entry.unpacked, limits_.inner_archive)));
  Bytes content;
  content.reserve(static_cast<std::size_t>(entry.unpacked));
  auto unpacked = read(entry, nullptr, [&](std::string_view piece) -> Result<bool> {
    const auto bytes = base::as_bytes(piece);
    content.insert(content.end(), bytes.begin(), bytes.end());
    return true;
  });
  if (!unpacked) return fail(unpacked.error());
  auto inner = open(file_of(std::move(content)), limits_);
  if (!inner) return fail(inner.error().code, fmt::format("{}: {}", entry.name, inner.error().text));
  return inner;
}

}  // namespace rubicon::networks::knx::project
