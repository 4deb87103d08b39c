#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "networks/knx/secure/frames.h"

namespace rubicon::networks::knx::secure {

/// A line of an annotated session (../shared/data/knx-secure/secure/*.tsv).
struct AnnotatedRow {
  double seconds = 0;
  char direction = ' ';  ///< C or S
  Bytes frame;
  Bytes plain;          ///< of a wrapper; empty if it was not annotated
  std::string mac_cbc;  ///< of a wrapper, before AES-CTR
  std::string note;
};

/// One session of a file with all its keys, in hex.
struct AnnotatedSession {
  std::string file;
  std::map<std::string, std::string> keys;
  std::vector<AnnotatedRow> rows;

  bool has(const std::string& key) const { return keys.contains(key); }
  std::uint16_t id() const;
  /// Number and key of the user who authenticates.
  std::optional<std::uint8_t> user() const;
};

/// The sessions of all files in their order; empty where the data is absent.
std::vector<AnnotatedSession> annotated_sessions();

}  // namespace rubicon::networks::knx::secure
