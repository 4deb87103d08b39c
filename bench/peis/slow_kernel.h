#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "frame/figures.h"
#include "tuples/peis/connection.h"

namespace rubicon::bench::peis {

/// Subscribes to the tuples of kFirst as a kernel does, and reads with a kernel's limits: whole packages only, 9 in a
/// step of 2 ms, acknowledged after 100 packages or 0.2 s (peis.md, sections 3.6, 3.10, 6.2). In blocking calls.
class SlowKernel {
 public:
  /// Connects to the component on port 8000. Throws if there is none within 10 s.
  SlowKernel(std::string network, std::size_t keys);
  ~SlowKernel();
  SlowKernel(const SlowKernel&) = delete;
  SlowKernel& operator=(const SlowKernel&) = delete;

  /// Until the owner has set its last value and a second passed.
  Json run();

 private:
  void connect();
  void send(tuples::peis::PackageHeader header, const std::vector<std::uint8_t>& body);
  void send_link(tuples::peis::Port port, const std::vector<std::uint8_t>& body);
  void send_direct(tuples::peis::Port port, const std::vector<std::uint8_t>& body, bool wants_ack);
  void introduce();
  void subscribe(const std::string& key);
  bool read_package();
  void take(const tuples::peis::Package& package);
  void take_push(ByteView body);
  void acknowledge();
  void leave();
  std::uint32_t next_id() { return ++last_id_; }

  std::string network_;
  std::vector<std::uint64_t> numbers_;  ///< last value of each tuple
  int socket_ = -1;
  std::uint32_t last_id_ = 1, counter_ = 0;
  std::unordered_set<std::uint32_t> seen_;
  std::vector<std::uint32_t> acks_;
  Clock::time_point next_acks_{};
  std::uint64_t values_ = 0, resends_ = 0;
  int most_waiting_ = 0;
  bool is_over_ = false;
};

}  // namespace rubicon::bench::peis
