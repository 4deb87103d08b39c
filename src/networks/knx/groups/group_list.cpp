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

GroupList refused(std::string why) {
  GroupList list;
  list.report.refuse(0, std::move(why));
  return list;
}

}  // namespace

GroupList read_group_list(std::string_view text) {
  if (text.size() > kMaxListBytes) return refused("larger than 64 MiB: file refused");
  auto content = text;
  if (content.starts_with(kUtf8Mark)) content.remove_prefix(kUtf8Mark.size());
  content.remove_prefix(std::min(content.find_first_not_of(" \t\r\n"), content.size()));
  if (content.empty()) return refused("empty, expected an ETS export of group addresses");
  if (content.starts_with("PK\x03\x04"))
    return refused("an archive, expected group addresses exported from ETS as CSV, XML or ESF");
  const bool utf16 = content.starts_with("\xff\xfe") || content.starts_with("\xfe\xff");
  if (content.starts_with('<') || (utf16 && content.substr(0, 8).find('<') != content.npos)) return read_xml(text);
  if (utf16) return refused("UTF-16, expected UTF-8 or Windows-1252");
  return is_esf(content) ? read_esf(text) : read_csv(text);
}

}  // namespace rubicon::networks::knx::groups
