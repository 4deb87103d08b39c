#pragma once

#include <string>
#include <vector>

namespace rubicon::daemon {

/// `rubicon-proxy state FILE ...`, docs/state.md. All give an exit code: kExitOk, or kExitFailed with the reason on
/// standard error and the file as it was.

/// A table of the devices.
int show_state(const std::string& file);
/// JSON lines to a file, to standard output if `out` is empty.
int export_state(const std::string& file, const std::string& out);
/// Merges an export (`-` = standard input) into the file, which is made if there is none: all of it or nothing.
/// `force`: also that of another island.
int import_state(const std::string& file, const std::string& from, bool force);
/// Each as NETWORK/ADDRESS or as the key part NETWORK.ID.
int forget_state(const std::string& file, const std::vector<std::string>& devices);

}  // namespace rubicon::daemon
