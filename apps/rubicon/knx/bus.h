#pragma once

#include <memory>
#include <string>

#include "apps/rubicon/tool_line.h"
#include "networks/knx/tool_requests.h"

namespace rubicon::cli::knx {

/// How `monitor`, `read`, `write` and `capture` reach the bus.
struct BusOptions {
  std::string direct;  ///< HOST or HOST:PORT of a KNXnet/IP interface; empty = through the running island
  bool tcp = false;    ///< with `direct`: by TCP, else UDP; always with `keyring`
  /// With `direct`: a keyring of ETS, the file with its password (empty = RUBICON_KNX_PASSWORD), the interface that
  /// is meant if the keyring has several, and the tunnel to take (empty = that of the smallest user number).
  std::string keyring, password_file, server, tunnel_address;
  std::string group_keys;  ///< with `direct`: a file with keys of groups
  NetworkChoice network{"knx"};
};

/// docs/knx.md, "Tools". Events are received telegrams.
inline constexpr ToolTags kBusTags{networks::knx::kRequestTag, networks::knx::kReplyTag, networks::knx::kTelegramTag};

/// nullptr: the error was printed, and `code` is the exit code.
std::unique_ptr<ToolLine> open_bus(const Settings& settings, const BusOptions& options, std::string_view command,
                                   int& code);

/// A tunnel of our own to BusOptions::direct; waits until it is there. nullptr: why not was said.
std::unique_ptr<ToolLine> open_direct(const Settings& settings, const BusOptions& options, int& code);

}  // namespace rubicon::cli::knx
