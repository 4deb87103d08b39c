#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "transport/interfaces.h"
#include "tuples/judge.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// How the components of a process take part in a PEIS network.
struct PeisOptions {
  std::string network = "default";               ///< 1 to 63 bytes; components of other networks are not seen
  std::uint16_t listen = kFirstListenPort;       ///< each component takes the first free port from here on; 0 = any
  std::vector<std::string> connect;              ///< HOST or HOST:PORT of components to stay connected with, at most 64
  bool multicast = true;                         ///< announce this host, and search for others
  std::vector<std::string> interfaces = {"lo"};  ///< names, at most 16; `lo` alone = this host only
  base::Duration lease = std::chrono::seconds(2);  ///< components of ours lose this one after such a silence
  bool trust_lan = false;                          ///< accept remote sets from other hosts; without a judge only
  std::shared_ptr<Judge> judge = nullptr;          ///< what the member `peis`, which all others are, may do; null: all

  friend bool operator==(const PeisOptions&, const PeisOptions&) = default;
};

/// `tcp://HOST:PORT`, `HOST:PORT` or `HOST` as an entry of PeisOptions::connect. kInvalid: it is none of them.
Result<std::string> connect_target(std::string_view url);
/// Whether a connection with this entry of PeisOptions::connect would leave the host although `lo` is the only
/// interface. The addresses of a name are not looked up; the connection checks them.
bool leaves_loopback(const std::vector<std::string>& interfaces, std::string_view target);

/// The machine, as components show it to others.
struct PeisMachine {
  std::vector<transport::Interface> interfaces;
  std::string host_name;  ///< without its domain; kernels use loopback only between equal ones
  std::string host_id;    ///< PeerIdentity::host
  std::string process;    ///< process id
  std::string user;

  /// This one.
  static PeisMachine own();
};

/// The interfaces that the options name, in their order. kNotFound: there is none of that name with an IPv4 address,
/// or it is down; kOutOfRange: too many, or a lease that is not 500 ms to 60 s.
Result<std::vector<transport::Interface>> select_interfaces(const PeisOptions& options,
                                                            const std::vector<transport::Interface>& present);

}  // namespace rubicon::tuples::peis
