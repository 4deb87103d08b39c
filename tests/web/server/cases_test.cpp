#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "base/text.h"
#include "web/server/served.h"

namespace rubicon::web::server {
namespace {

using testing::HasSubstr;
using testing::Not;

struct HttpCase {
  std::string name, setup, request;
  std::vector<std::string> has, has_not;
};

/// `\xNN` and `{N*text}`, the innermost first.
std::string expanded(std::string text) {
  for (auto at = text.find("\\x"); at != text.npos; at = text.find("\\x", at + 1))
    text.replace(at, 4, 1, static_cast<char>(base::parse_hex_number<std::uint8_t>(text.substr(at + 2, 2)).value()));
  for (auto begin = text.rfind('{'); begin != text.npos; begin = begin == 0 ? text.npos : text.rfind('{', begin - 1)) {
    const auto star = text.find('*', begin), end = text.find('}', begin);
    if (star == text.npos || end == text.npos || star > end) continue;
    const auto count = base::parse_number<int>(text.substr(begin + 1, star - begin - 1));
    if (!count) continue;
    std::string repeated;
    for (int i = 0; i < *count; ++i) repeated += text.substr(star + 1, end - star - 1);
    text.replace(begin, end - begin + 1, repeated);
  }
  return text;
}

std::vector<HttpCase> read_cases() {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/web/http.cases");
  std::vector<HttpCase> cases;
  for (std::string line; std::getline(file, line);) {
    const auto rest = line.size() > 2 ? line.substr(2) : std::string();
    if (line.starts_with("= ")) cases.push_back({rest, {}, {}, {}, {}});
    if (cases.empty()) continue;
    auto& one = cases.back();
    if (line.starts_with("@ ")) one.setup = rest;
    if (line.starts_with(">- ")) one.request += line.substr(3);
    if (line == ">" || line.starts_with("> ")) one.request += expanded(rest) + "\r\n";
    if (line.starts_with("* ")) {  // `* N SIZE`: N chunks of a body
      int count = 0, size = 0;
      std::istringstream(rest) >> count >> size;
      for (int i = 0; i < count; ++i) {
        std::ostringstream chunk;
        chunk << std::hex << size << "\r\n" << std::string(static_cast<std::size_t>(size), 'x') << "\r\n";
        one.request += chunk.str();
      }
    }
    if (line.starts_with("< ")) one.has.push_back(rest);
    if (line.starts_with("! ")) one.has_not.push_back(rest);
  }
  return cases;
}

access::Token token(const std::string& name, Role role) {
  return {name, role, access::sha256(std::string(access::to_string(role)) + "-token")};
}

class HttpCases : public ServedTest {
 protected:
  void serve_for(const std::string& setup) {
    access::AccessRules rules;
    rules.needs_token = setup.find("tokens") != setup.npos;
    if (setup.find("hall") != setup.npos) rules.origins.hosts = {"hall.lan"};
    if (setup.find("origin") != setup.npos) rules.origins.origins = {"https://hall.lan"};
    serve(rules);
    access->take({token("viewer", Role::kView), token("worker", Role::kCommand), token("owner", Role::kAdmin)});
  }
};

TEST_F(HttpCases, AreAnsweredAsTheirFileSays) {
  const auto cases = read_cases();
  ASSERT_GT(cases.size(), 60U);
  for (const auto& one : cases) {
    SCOPED_TRACE(one.name);
    serve_for(one.setup);
    ASSERT_FALSE(one.has.empty());
    const auto program = client();
    program->send(one.request);
    ASSERT_TRUE(program->gets("\r\n\r\n")) << program->received;
    world.settle();
    EXPECT_THAT(program->received.substr(0, 13), HasSubstr(" " + one.has.front() + " "));
    for (const auto& part : one.has) EXPECT_THAT(program->received, HasSubstr(part));
    for (const auto& part : one.has_not) EXPECT_THAT(program->received, Not(HasSubstr(part)));
  }
}

}  // namespace
}  // namespace rubicon::web::server
