#pragma once

#include <string_view>

#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

/// The group addresses in the text of a file. An error in a line does not affect other lines; a file that is not a list
/// of this kind is refused (`report.refused`). Nothing but `text` is read.

/// ETS group address export as CSV: names in one to three columns, addresses in one to three; tab, semicolon or comma;
/// with or without header.
GroupList read_csv(std::string_view text);
/// ETS group address export as XML (http://knx.org/xml/ga-export/01). UTF-8, UTF-16, ISO-8859-1, Windows-1252; a
/// document with a document type declaration is refused.
GroupList read_xml(std::string_view text);
/// OPC export of ETS (.esf). It has main types only.
GroupList read_esf(std::string_view text);

/// Recognises the format by content: XML, ESF, else CSV. Refuses text that is too large, empty or of another kind.
GroupList read_group_list(std::string_view text);

}  // namespace rubicon::networks::knx::groups
