#pragma once

#include <cstdint>

#include "frame/figures.h"

namespace rubicon::bench::knx {

struct Plan {
  int rounds = 5;
  int telegrams = 20'000;               ///< a round
  int writes = 200;                     ///< a seed of the loss measurement
  int decodes = 5'000'000;              ///< a data point type
  int addresses = 10'000;               ///< of the import
  int project_addresses = 2000;         ///< of a project
  std::size_t program_bytes = 100'000;  ///< of each of its 125 application programs
  std::size_t large_project_mb = 100;   ///< of the project whose memory is measured
};

/// Confirmed telegrams a second of a bare stop-and-wait loop on blocking sockets, through knxd at this port.
double floor_telegrams(int telegrams, std::uint16_t port);

/// Telegrams a second of OpenSSL alone: what request and confirmation of a secure tunnel cost at both ends.
double floor_wrappers(int telegrams);

// Each adds its figures. The first two need knxd in a private network.
void measure_telegrams(const Plan& plan, Json& out);
void measure_loss(const Plan& plan, Json& out);
void measure_dpt(const Plan& plan, Json& out);
/// A tunnel through KNX IP Secure beside the same tunnel over plain TCP, in a private network.
void measure_secure(const Plan& plan, Json& out);
void measure_import(const Plan& plan, Json& out);
void measure_projects(const Plan& plan, Json& out);

}  // namespace rubicon::bench::knx
