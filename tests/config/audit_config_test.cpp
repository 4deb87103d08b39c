#include "config/rights_config.h"

#include <gmock/gmock.h>

#include "config/yaml.h"

namespace rubicon::config {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

AuditSetup audit_of(const std::string& text, base::ConfigErrors& errors) {
  const auto root = parse_yaml(text, "home.yaml");
  EXPECT_TRUE(root);
  ConfigReader reader(root.value(), "", errors);
  return read_audit(reader);
}

std::string wrong_audit(const std::string& section) {
  base::ConfigErrors errors;
  std::ignore = audit_of("audit: " + section + "\n", errors);
  return errors.text();
}

TEST(AuditConfig, WithoutTheSectionIsAsUsual) {
  base::ConfigErrors errors;
  EXPECT_EQ(audit_of("a: 1\n", errors), AuditSetup{});
  EXPECT_EQ(AuditSetup{}.size, 100'000'000U);
}

TEST(AuditConfig, ReadsAllKeys) {
  base::ConfigErrors errors;
  const auto setup =
      audit_of("audit: {file: home.audit, hide: [proxy.*.*.actuator.alarm-*.command], size: 5MB}\n", errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  EXPECT_EQ(setup.file, "home.audit");
  EXPECT_THAT(setup.hide, ElementsAre("proxy.*.*.actuator.alarm-*.command"));
  EXPECT_EQ(setup.size, 5'000'000U);
}

TEST(AuditConfig, SaysWhatIsWrongWithItsPlace) {
  EXPECT_THAT(wrong_audit("{file: ''}"), HasSubstr("home.yaml:1:"));
  EXPECT_THAT(wrong_audit("{file: ''}"), HasSubstr("audit.file: empty path, expected a file"));
  EXPECT_THAT(wrong_audit("{hide: ['a..b']}"), HasSubstr("audit.hide"));
  EXPECT_THAT(wrong_audit("{size: 10kB}"), HasSubstr("audit.size"));
  EXPECT_THAT(wrong_audit("{files: x}"), HasSubstr("file"));
}

}  // namespace
}  // namespace rubicon::config
