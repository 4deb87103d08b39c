#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon-proxy/daemon.h"
#include "island/island_config.h"
#include "rubicon/result.hpp"

namespace rubicon::daemon {

/// Says an error on standard error; the exit code that it means.
int report(const Error& error);

/// File -> configuration with the overrides applied. What is wrong with its content stands in `errors`; the result is
/// an error if it cannot be read at all.
Result<island::IslandConfig> load_island(const std::string& file, const std::vector<std::string>& overrides,
                                         base::ConfigErrors& errors);

/// The same for the content of that file.
Result<island::IslandConfig> load_island_text(std::string_view text, const std::string& file,
                                              const std::vector<std::string>& overrides, base::ConfigErrors& errors);

/// What `rubicon-proxy check` was asked for.
struct CheckOptions {
  std::string file;
  std::vector<std::string> overrides{};
  /// Also what a reload would do to an island that runs with this file; empty = the copy kept beside the state file.
  std::optional<std::string> against{};
  bool elsewhere = false;  ///< the island runs on another host, so it does not matter what this host lacks
};

/// Says what is wrong with a configuration, or that it is right; its exit code.
int check(const CheckOptions& options);

}  // namespace rubicon::daemon
