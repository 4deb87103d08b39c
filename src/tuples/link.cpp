#include "tuples/link.h"

#include <fmt/format.h>

#include "base/text.h"

namespace rubicon::tuples {

namespace {

constexpr char kMark = '~';  // no character of host names and host ids
constexpr std::size_t kMaxHost = 64;

}  // namespace

std::string marked_host(std::string_view host, OwnerId carrier) {
  const auto mark = fmt::format("{}{}", kMark, number(carrier));
  return std::string(host.substr(0, kMaxHost - mark.size())) + mark;
}

OwnerId carrier_of(std::string_view host) {
  const auto mark = host.rfind(kMark);
  if (mark == host.npos) return model::kNoOwner;
  return OwnerId(base::parse_number<std::uint32_t>(host.substr(mark + 1)).value_or(number(model::kNoOwner)));
}

std::string_view real_host(std::string_view host) {
  return carrier_of(host) == model::kNoOwner ? host : host.substr(0, host.rfind(kMark));
}

}  // namespace rubicon::tuples
