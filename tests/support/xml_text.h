#pragma once

#include <string>
#include <string_view>

namespace rubicon::support {

/// The text as the value of an XML attribute in double quotes (XML 1.0, section 3.3.3).
std::string xml_attribute(std::string_view text);

}  // namespace rubicon::support
