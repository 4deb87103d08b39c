#include "trust/documents.h"

#include <fmt/format.h>

#include <ctime>
#include <optional>

#include "base/printable.h"
#include "trust/id_ranges.h"

namespace rubicon::trust {

namespace {

constexpr std::string_view kGovernance = R"(<?xml version="1.0" encoding="UTF-8"?>
<dds><domain_access_rules><domain_rule>
<domains><id_range><min>0</min><max>230</max></id_range></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>SIGN</rtps_protection_kind>
<topic_access_rules>
{}{}</topic_access_rules>
</domain_rule></domain_access_rules></dds>
)";

constexpr std::string_view kTopicRule = R"(<topic_rule><topic_expression>{}</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection>
<enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control>
<enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>{}</metadata_protection_kind>
<data_protection_kind>NONE</data_protection_kind></topic_rule>
)";

constexpr std::string_view kPermissions = R"(<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="{name}">
<subject_name>{subject}</subject_name>
<validity><not_before>2020-01-01T00:00:00Z</not_before><not_after>{ends}</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<publish><topics><topic>rubicon_presence</topic><topic>rubicon_interests</topic></topics>
<partitions>{own}</partitions></publish>
<publish><topics><topic>rubicon_frames</topic></topics>
<partitions>{to_others}</partitions></publish>
<subscribe><topics><topic>rubicon_presence</topic><topic>rubicon_interests</topic></topics>
<partitions><partition>*</partition></partitions></subscribe>
<subscribe><topics><topic>rubicon_frames</topic></topics>
<partitions>{from_others}</partitions></subscribe>
</allow_rule><default>DENY</default></grant></permissions></dds>
)";

constexpr std::string_view kAnyId = "????????";

/// `2028-01-01T00:00:00Z`.
std::string xml_time(WallTime time) {
  const std::time_t seconds = std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

/// The content of the only element of this name; nullopt: none, or several.
std::optional<std::string_view> only_element(std::string_view xml, std::string_view name) {
  const auto begin = fmt::format("<{}>", name), end = fmt::format("</{}>", name);
  const auto first = xml.find(begin);
  if (first == xml.npos || xml.find(begin, first + 1) != xml.npos) return {};
  const auto content = xml.substr(first + begin.size());
  const auto last = content.find(end);
  if (last == content.npos) return {};
  return content.substr(0, last);
}

}  // namespace

std::string xml_escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&apos;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

std::string governance_xml() {
  // A writer of frames has one reader. Presence and interests have many, who share the key of the writer: only the
  // authentication of origins keeps one of them from writing to the others as that writer.
  return fmt::format(kGovernance, fmt::format(kTopicRule, "rubicon_frames", "ENCRYPT"),
                     fmt::format(kTopicRule, "*", "ENCRYPT_WITH_ORIGIN_AUTHENTICATION"));
}

Result<std::string> permissions_xml(const tuples::Member& member, const std::string& subject) {
  std::string own, to_others, from_others;
  for (const auto& range : member.ids) {
    const auto pattern = id_pattern(range);
    if (!pattern) return fail(pattern.error());
    own += fmt::format("<partition>{}</partition>", *pattern);
    to_others += fmt::format("<partition>{}.{}</partition>", *pattern, kAnyId);
    from_others += fmt::format("<partition>*.{}</partition>", *pattern);
  }
  return fmt::format(kPermissions, fmt::arg("name", xml_escaped(member.name)),
                     fmt::arg("subject", xml_escaped(subject)), fmt::arg("ends", xml_time(member.expires)),
                     fmt::arg("own", own), fmt::arg("to_others", to_others), fmt::arg("from_others", from_others));
}

Result<void> check_permissions(std::string_view xml, const Certificate& certificate, WallTime now,
                               std::string_view where) {
  const auto subject = only_element(xml, "subject_name");
  const auto ends = only_element(xml, "not_after");
  if (!subject || !ends)
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected permissions with one subject and one end", where));
  if (*subject != xml_escaped(certificate.subject()))
    return fail(ErrorCode::kInvalid, fmt::format("{}: these are the permissions of {}: expected those of {}", where,
                                                 base::one_line(*subject), certificate.subject()));
  if (*ends > xml_time(now)) return {};  // the form sorts as the times do
  return fail(ErrorCode::kExpired, fmt::format("{}: the permissions of {} ended at {}, and the clock says {}", where,
                                               certificate.subject(), base::one_line(*ends), date_text(now)));
}

}  // namespace rubicon::trust
