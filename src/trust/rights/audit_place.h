#pragma once

#include <string>

#include "base/own_file.h"

namespace rubicon::trust::rights {

/// The place of an audit: the newest lines are in `file`, older ones in `file.1` and so on.

/// Gives a file its name again that a crash left under the one of check_place().
void restore(const std::string& file);

/// Whether the system lets this file be renamed, as rotation needs it: renames it and back. kRefused: no, and why.
Result<void> check_place(const std::string& file);

/// Renames `file` to `file.1`, the one before to `file.2`, up to `file.<older>`, whose content is lost, and returns a
/// new `file`, which is open for appending. Nothing is renamed where the new one cannot be made.
Result<base::OwnFile> rotate(const std::string& file, int older);

}  // namespace rubicon::trust::rights
