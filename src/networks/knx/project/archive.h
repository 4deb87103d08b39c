#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "networks/knx/secure/key.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

struct zip;

namespace rubicon::networks::knx::project {

/// Bounds of an archive (knx.md, section 13.4): beyond them it is refused before anything is unpacked.
struct ArchiveLimits {
  std::uint64_t bytes = std::uint64_t{512} << 20U;  ///< of the file
  std::size_t entries = 10'000;
  std::uint64_t directory = std::uint64_t{8} << 20U;       ///< bytes of the list of entries
  std::uint64_t unpacked = std::uint64_t{1} << 30U;        ///< of all entries together
  std::uint64_t ratio = 300;                               ///< unpacked to packed bytes of one entry ...
  std::uint64_t ratio_from = std::uint64_t{1} << 20U;      ///< ... that unpacks to more than this
  std::uint64_t inner_archive = std::uint64_t{64} << 20U;  ///< of an archive within it, which is held in memory
};

/// A zip archive that comes from outside, read by libzip (docs/decisions/020-knx-projects.md). Nothing is written to
/// disk. Names of entries are relative, without `..`, and no name stands twice.
class Archive {
 public:
  enum class Protection : std::uint8_t { kNone, kZipCrypto, kAes, kOther };

  struct Entry {
    std::string name;
    std::uint64_t index = 0, packed = 0, unpacked = 0;
    Protection protection = Protection::kNone;
    std::uint16_t method = 0;  ///< of compression (APPNOTE.TXT, section 4.4.5)
  };

  /// Gets an entry in pieces; false: no more is needed.
  using Take = std::function<Result<bool>(std::string_view piece)>;

  /// kInvalid: no archive, cut, or a name that is refused; kOutOfRange: beyond the limits; kIo.
  static Result<Archive> open(std::unique_ptr<transport::FileSource> file, const ArchiveLimits& limits = {});

  const std::vector<Entry>& entries() const { return entries_; }
  /// nullptr if there is none of this name.
  const Entry* find(std::string_view name) const;

  /// Unpacks an entry. kRefused: the password is wrong or missing (nullptr); kInvalid: damaged, or of a kind that is
  /// not read; kOutOfRange: beyond the limits; else the error of `take`.
  Result<void> read(const Entry& entry, const secure::Secret* password, const Take& take) const;
  /// Unpacks an archive that is an entry of this one.
  Result<Archive> open_inner(const Entry& entry) const;

 private:
  struct Close {
    void operator()(zip* archive) const;
  };

  Archive(zip* archive, const ArchiveLimits& limits) : zip_(archive), limits_(limits) {}
  Result<void> list();
  Result<Entry> entry_at(std::uint64_t index) const;
  Result<void> check(const Entry& entry) const;

  std::unique_ptr<zip, Close> zip_;
  ArchiveLimits limits_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::size_t> by_name_;
};

}  // namespace rubicon::networks::knx::project
