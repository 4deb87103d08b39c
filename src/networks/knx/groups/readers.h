#pragma once

#include <string_view>

#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

/// Text of a file -> its group addresses. Good lines are taken whatever stands in the others; only what makes the whole
/// file unreadable refuses it (`report.refused`). None reads anything but `text`.

/// ETS group address export as CSV: names in one to three columns, addresses in one to three; tab, semicolon or comma;
/// with or without header.
GroupList read_csv(std::string_view text);
/// ETS group address export as XML (http://knx.org/xml/ga-export/01). UTF-8, UTF-16, ISO-8859-1, Windows-1252; a
/// document type declaration refuses it.
GroupList read_xml(std::string_view text);
/// OPC export of ETS (.esf). Its types are main types at best.
GroupList read_esf(std::string_view text);

/// By content: an XML document, an ESF, else CSV. Refuses what is too large, empty or of another kind.
GroupList read_group_list(std::string_view text);

}  // namespace rubicon::networks::knx::groups
