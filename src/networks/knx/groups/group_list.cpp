#include <fmt/format.h>

#include <algorithm>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list_builder.h"
#include "networks/knx/groups/readers.h"

namespace rubicon::networks::knx::groups {

namespace {

/// `Main.Middle.1/0/1<TAB>name<TAB>EIS ...`: one of the first lines after the project's name looks like this.
bool is_esf(std::string_view text) {
  for (int i = 0; i < 50 && !text.empty(); ++i) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    const auto tab = std::min(line.find('\t'), line.size());
    const auto second = std::min(line.find('\t', tab + 1), line.size());
    const auto type = line.substr(std::min(second + 1, line.size()));
    if (i > 0 && (type.starts_with("EIS ") || type.starts_with("Uncertain ("))) return true;
    const auto first = line.substr(0, tab);
    const auto dot = first.rfind('.');
    const auto address = dot == first.npos ? std::string_view() : first.substr(dot + 1);
    if (i > 0 && tab < line.size() && address.find('/') != address.npos && looks_like_address(address)) return true;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

constexpr std::string_view kExpected =
    "expected group addresses exported from ETS as CSV, XML or ESF, in UTF-8, UTF-16 or Windows-1252";

GroupList read_lines(std::string_view text) {
  return is_esf(text) ? read_esf(text) : read_csv(text);
}

GroupList refused(std::string why) {
  GroupList list;
  list.report.refuse(0, std::move(why));
  return list;
}

}  // namespace

GroupList read_group_list(std::string_view text) {
  if (text.size() > kMaxListBytes) return refused("larger than 64 MiB: file refused");
  if (const auto name = name_of_foreign(text); !name.empty()) return refused(fmt::format("{}, {}", name, kExpected));
  auto content = text;
  if (content.starts_with(kUtf8Mark)) content.remove_prefix(kUtf8Mark.size());
  content.remove_prefix(std::min(content.find_first_not_of(" \t\r\n"), content.size()));
  if (content.empty()) return refused("empty, expected an ETS export of group addresses");
  const auto wide = utf16_of(text);
  // A parser of XML follows the declaration in the document.
  if (content.starts_with('<') || (wide && content.substr(0, 8).find('<') != content.npos)) return read_xml(text);
  if (wide) {
    const auto converted = from_utf16(text, *wide);
    return converted ? read_lines(*converted) : refused(converted.error().text);
  }
  if (const auto zero = text.find('\0'); zero != text.npos)
    return refused(fmt::format("byte {} is zero, so this is no text, {}", zero + 1, kExpected));
  return read_lines(text);
}

}  // namespace rubicon::networks::knx::groups
