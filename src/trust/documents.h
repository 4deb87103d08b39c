#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/certificate.h"
#include "tuples/member.h"

namespace rubicon::trust {

/// The governance of a realm (DDS Security 1.1, section 9.4.1.2): all is encrypted, none takes part without a
/// certificate.
std::string governance_xml();

/// The permissions of a member (section 9.4.1.3): its own ids as source, everything of others that is for it. The ids
/// are in the partitions of the endpoints. kUnsupported: a range that no pattern can express.
Result<std::string> permissions_xml(const tuples::Member& member, const std::string& subject);

/// Whether a permissions document, whose signature is good, is for this certificate and valid now.
Result<void> check_permissions(std::string_view xml, const Certificate& certificate, WallTime now,
                               std::string_view where);

/// The text with `&`, `<`, `>`, `"` and `'` as entities of XML.
std::string xml_escaped(std::string_view text);

}  // namespace rubicon::trust
