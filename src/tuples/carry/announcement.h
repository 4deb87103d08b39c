#pragma once

#include <map>
#include <string>
#include <string_view>

namespace rubicon::tuples::carry {

/// What a carrier says of itself in its summary, so that of several that carry the same one does: by pair of engines
/// (`dds-mqtt`, in the order of the alphabet) the digest of its rules.
using Announcement = std::map<std::string, std::string>;

std::string pair_name(std::string_view one, std::string_view other);
/// The summary with the member `carries`; unchanged if it would be too long, or is no object.
std::string with_announcement(std::string summary, const Announcement& carries);
/// Empty: it carries nothing.
Announcement announcement_of(std::string_view summary);

}  // namespace rubicon::tuples::carry
