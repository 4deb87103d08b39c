#include "client/ecology_options.h"

#include <fmt/format.h>

#include <random>

namespace rubicon::client {

namespace {

constexpr std::uint32_t kFirstId = 65536;

}  // namespace

OwnerId random_component_id() {
  std::random_device source;
  return OwnerId(std::uniform_int_distribution<std::uint32_t>(kFirstId, 0xffffffff)(source));
}

Result<void> check(const Options& options) {
  const auto id = number(options.id);
  if (id != 0 && id < kFirstId)
    return fail(ErrorCode::kInvalid,
                fmt::format("component id {}: expected a number above 65535, the others are islands", id));
  if (options.domain > tuples::dds::kMaxDomain)
    return fail(ErrorCode::kInvalid,
                fmt::format("domain {}: expected 0 to {}", options.domain, tuples::dds::kMaxDomain));
  if (options.tcp && options.peers.empty() && options.port == 0)
    return fail(ErrorCode::kInvalid, "tcp needs peers (host:port) or a port: it discovers no components by itself");
  if (options.interfaces.empty())
    return fail(ErrorCode::kInvalid, "interfaces: expected at least one, `lo` for this host only");
  return {};
}

tuples::dds::DdsOptions dds_options(const Options& options) {
  tuples::dds::DdsOptions dds;
  dds.domain = options.domain;
  dds.interfaces = options.interfaces;
  dds.peers = options.peers;
  dds.tag = options.tag;
  dds.lease = options.lease;
  dds.transport = options.tcp ? tuples::dds::DdsTransport::kTcp : tuples::dds::DdsTransport::kUdp;
  dds.port = options.port;
  dds.trust_lan = options.trust_lan;
  return dds;
}

}  // namespace rubicon::client
