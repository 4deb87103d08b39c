#include "tuples/dds/trust/trusted_members.h"

#include <fmt/format.h>

#include <sstream>

namespace rubicon::tuples::dds {

namespace {

using trust::guard::Subject;

std::string permissions_xml(const Subject& subject, const std::string& grant) {
  constexpr auto kState = "<topics><topic>rubicon_presence</topic><topic>rubicon_interests</topic></topics>";
  constexpr auto kFrames = "<topics><topic>rubicon_frames</topic></topics>";
  const auto rule = [&grant](const char* kind, const char* topics, const std::string& form) {
    std::string partitions;
    std::istringstream patterns(grant);
    for (std::string one; std::getline(patterns, one, ',');)
      partitions += fmt::format("<partition>{}</partition>", fmt::format(fmt::runtime(form), one));
    return fmt::format("<{0}>{1}<partitions>{2}</partitions></{0}>\n", kind, topics, partitions);
  };
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="{0}"><subject_name>CN={0},O={1}</subject_name>
<validity><not_before>2020-01-01T00:00:00Z</not_before><not_after>2099-01-01T00:00:00Z</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
{2}{3}{4}{5}</allow_rule><default>DENY</default></grant></permissions></dds>
)",
      subject.name, subject.organization, rule("publish", kState, "{}"), rule("publish", kFrames, "{}.????????"),
      rule("subscribe", kState, "*"), rule("subscribe", kFrames, "*.{}"));
}

}  // namespace

std::string TrustedMembers::documents(const Person& who, const Realm& realm) const {
  const Subject subject{.name = who.name, .uris = {"rubicon:" + who.ids}, .serial = who.serial};
  const auto certified = trust::guard::make_member(realm.identity, subject);
  const trust::guard::Documents made{realm.identity.certificate_pem(),
                                     certified.certificate_pem(),
                                     certified.key_pem(),
                                     realm.permissions.certificate_pem(),
                                     trust::guard::signed_text(realm.permissions, trust::guard::governance_xml()),
                                     trust::guard::signed_text(realm.permissions, permissions_xml(subject, who.grant))};
  made.write_to(folder_ / who.name);
  return folder_ / who.name;
}

std::unique_ptr<support::Process> TrustedMembers::member(const Person& who, std::uint32_t id,
                                                         const std::string& folder) const {
  return std::make_unique<Process>(std::vector<std::string>{
      RUBICON_BINARY_DIR "/bin/dds-member", "honest", std::to_string(id), folder, RUBICON_GUARD, who.name, who.ids});
}

std::unique_ptr<support::Process> TrustedMembers::liar(const Person& who) const {
  return std::make_unique<Process>(std::vector<std::string>{RUBICON_BINARY_DIR "/bin/dds-member", "liar",
                                                            std::to_string(kMalloryId), documents(who), RUBICON_GUARD,
                                                            who.name, who.ids});
}

bool TrustedMembers::until(Process& process, const std::string& condition) {
  process.write("until " + condition + "\n");
  return process.line_with("yes " + condition).has_value();
}

std::string TrustedMembers::ask(Process& process, const std::string& question) {
  process.write(question + "\n");
  const auto first = question.substr(0, question.find(' '));
  const auto line = process.line_with(first + " ").value_or("");
  return line.substr(std::min(line.size(), first.size() + 1));
}

void TrustedMembers::meet(Process& home, Process& desk) {
  ASSERT_TRUE(until(home, fmt::format("peer {} desk", kDeskId))) << home.errors();
  ASSERT_TRUE(until(desk, "peer 7 home")) << desk.errors();
}

}  // namespace rubicon::tuples::dds
