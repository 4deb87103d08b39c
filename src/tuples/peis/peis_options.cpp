#include "tuples/peis/peis_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "base/host_port.h"
#include "transport/host_name.h"
#include "transport/resolve.h"

namespace rubicon::tuples::peis {

using namespace std::chrono_literals;

namespace {

constexpr std::size_t kLongestHost = 253;  // RFC 1035, 2.3.4

}  // namespace

Result<std::string> connect_target(std::string_view url) {
  constexpr std::string_view kScheme = "tcp://";
  const auto where = url.substr(url.starts_with(kScheme) ? kScheme.size() : 0);
  const auto parsed = base::parse_host_port(where, kFirstListenPort);
  const auto is_of_names = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
  };
  if (parsed && !parsed->host.empty() && parsed->host.size() <= kLongestHost &&
      std::all_of(parsed->host.begin(), parsed->host.end(), is_of_names))
    return std::string(where);
  return fail(ErrorCode::kInvalid, "expected tcp://host:port, the host as a name or an IPv4 address");
}

bool leaves_loopback(const std::vector<std::string>& interfaces, std::string_view target) {
  const auto where = base::parse_host_port(target, kFirstListenPort);
  return interfaces == std::vector<std::string>{"lo"} && where && transport::is_numeric_address_text(where->host) &&
         !transport::is_loopback_address(where->host);
}

PeisMachine PeisMachine::own() {
  auto name = transport::host_name();
  name = name.substr(0, std::min(name.find('.'), kMaxNameLength));
  if (name.empty()) name = "localhost";
  const auto process = transport::own_process();  // `pid 4711 of anna`
  const auto of = process.find(" of ");
  return {transport::ipv4_interfaces(), std::move(name), transport::host_id("host"), std::to_string(::getpid()),
          of == process.npos ? std::string() : process.substr(of + 4)};
}

Result<std::vector<transport::Interface>> select_interfaces(const PeisOptions& options,
                                                            const std::vector<transport::Interface>& present) {
  if (options.lease < 500ms || options.lease > 60s)
    return fail(ErrorCode::kOutOfRange, "PEIS: lease: expected 500 ms to 60 s");
  std::vector<transport::Interface> selected;
  for (const auto& name : options.interfaces) {
    const auto before = selected.size();
    for (const auto& interface : present) {
      if (interface.name == name && interface.is_up && !interface.address.empty()) selected.push_back(interface);
    }
    if (selected.size() == before)
      return fail(ErrorCode::kNotFound, fmt::format("PEIS: no interface '{}' is up with an IPv4 address", name));
  }
  if (selected.empty() || selected.size() > kMaxAddresses)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("PEIS: {} addresses on the interfaces, expected 1 to {}", selected.size(), kMaxAddresses));
  return selected;
}

}  // namespace rubicon::tuples::peis
