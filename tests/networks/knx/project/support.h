#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "networks/knx/groups/support.h"
#include "networks/knx/project/project.h"
#include "networks/knx/project/zip_source.h"
#include "support/knx_project.h"

namespace rubicon::networks::knx::project {

inline std::unique_ptr<transport::FileSource> file_with(std::string_view content) {
  const auto bytes = base::as_bytes(content);
  return file_of(Bytes(bytes.begin(), bytes.end()));
}

inline Result<Project> read_bytes(std::string_view content, const std::string& password = "",
                                  const ArchiveLimits& limits = {}) {
  const auto secret = secure::Secret::of_text(password);
  return read_project(file_with(content), "house.knxproj", {password.empty() ? nullptr : &secret, limits});
}

/// The error of a project that must not be read.
inline Error error_of(std::string_view content, const std::string& password = "", const ArchiveLimits& limits = {}) {
  const auto project = read_bytes(content, password, limits);
  return project ? Error{ErrorCode::kBusy, "it was read"} : project.error();
}

inline std::string number_text(std::uint64_t value, std::size_t bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes; ++i) out += static_cast<char>(value >> 8 * i & 0xff);
  return out;
}

}  // namespace rubicon::networks::knx::project
