#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>

#include "base/assert.h"
#include "base/text.h"
#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "web/access/access.h"
#include "web/files/page.h"
#include "web/server/http_text.h"

namespace rubicon::fuzz::web_request_fuzz {

namespace {

using namespace rubicon::web;

/// The first line is a target, the second a body, the others are fields of the head.
Request request_in(std::string_view text) {
  Request request;
  const auto line = [&text] {
    const auto end = std::min(text.find('\n'), text.size());
    const auto one = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return one;
  };
  const auto target = line();
  request.method = target.size() % 2 == 0 ? "GET" : "POST";
  if (auto parsed = server::parse_target(target)) {
    RUBICON_ASSERT(parsed->path.starts_with('/'));
    for (const auto& [name, value] : parsed->query) RUBICON_ASSERT(base::is_utf8(name) && base::is_utf8(value));
    request.path = parsed->path;
    request.query = parsed->query;
  }
  request.body = line();
  while (!text.empty()) {
    const auto field = line();
    const auto colon = std::min(field.find(':'), field.size());
    request.headers.emplace_back(field.substr(0, colon), field.substr(std::min(colon + 1, field.size())));
  }
  request.caller.peer = "127.0.0.1";
  return request;
}

/// Whatever a request says, what is answered has no field of its making.
void check_head(const Response& response) {
  const auto head = server::head_text(response, {}, {});
  RUBICON_ASSERT(head.ends_with("\r\n\r\n") && head.find("\r\n\r\n") == head.size() - 4);
  for (const char c : head) RUBICON_ASSERT(c != '\0');
}

}  // namespace

FUZZ_TARGET(web_request) {
  static VirtualScheduler time;
  static access::Access access(time, {.needs_token = true, .origins = {{"hall.lan"}, {"https://hall.lan"}}});
  auto request = request_in({reinterpret_cast<const char*>(data), size});
  if (const auto refused = access.admit(request, false)) {
    check_head(*refused);
  } else {
    RUBICON_ASSERT(request.caller.role == Role::kNone);  // there is no token
  }
  check_head(access.session(request, true));
  check_head({.headers = access.origin_fields(request)});
  if (request.path.empty()) return 0;
  const auto name = files::name_in(request.path);
  RUBICON_ASSERT(name.find("..") != 0 && name.find("/.") == name.npos);
  check_head(files::answer(request, {.name = name, .bytes = "x", .hash = "h", .gzip = size % 2 == 0}));
  std::ignore = access::parse_tokens({reinterpret_cast<const char*>(data), size});
  return 0;
}

}  // namespace rubicon::fuzz::web_request_fuzz
