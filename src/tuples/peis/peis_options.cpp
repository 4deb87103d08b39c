#include "tuples/peis/peis_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include "transport/host_name.h"

namespace rubicon::tuples::peis {

using namespace std::chrono_literals;

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
