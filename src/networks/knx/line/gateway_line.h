#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "networks/knx/line/discovery.h"
#include "networks/knx/line/tunnel_line.h"

namespace rubicon::networks::knx::line {

/// A tunnel of one of several servers, which lead to the same bus.
struct Gateway {
  std::string host;
  std::optional<secure::SessionKeys> secure{};
  std::optional<wire::IndividualAddress> wanted{};
};

struct GatewayOptions {
  TunnelOptions tunnel;           ///< what all have in common; without a local port
  std::vector<Gateway> gateways;  ///< at least two; the host of the first is preferred
  /// How often the preferred server is asked whether it is back, while another one is used; nullopt = never.
  std::optional<Duration> check = std::chrono::minutes(5);
};

/// One tunnel at a time, to the first of several servers that gives one. A server that refuses or does not answer is
/// followed by the next; after the last the line pauses or fails, and the first comes again. While another server than
/// the preferred one is used, the latter is asked for its description; once it answers and gives a tunnel, the line
/// changes to it. Both tunnels are open for a moment then: no telegram is lost, and what both report is taken once.
class GatewayLine final : public Line {
 public:
  GatewayLine(GatewayOptions options, Scheduler& scheduler, transport::Transports& transports, LineCallbacks callbacks);
  ~GatewayLine() override;
  GatewayLine(const GatewayLine&) = delete;
  GatewayLine& operator=(const GatewayLine&) = delete;

  Result<void> open() override { return line_->open(); }
  bool reopen() override { return line_->reopen(); }
  void send(wire::Telegram telegram, SteadyTime expires, SendCallback done) override;
  const LineState& state() const override { return state_; }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  std::unique_ptr<TunnelLine> make(std::size_t gateway, unsigned id, LineCallbacks calls);
  LineCallbacks common_calls(unsigned id);
  std::unique_ptr<TunnelLine> make_main(std::size_t gateway);

  void changed(const LineState& state);
  void failed(Error why);
  void refused(const LineState& state);
  void is_used();
  void choose(std::size_t gateway);
  bool prefers(std::size_t gateway) const;
  std::string tried_text() const;
  void show(LineState state);

  void check_later();
  void ask_preferred();
  void open_preferred();
  void preferred_changed(const LineState& state);
  void give_up_preferred();
  void take_over();
  void end_overlap();
  bool is_known(unsigned id, const wire::DataFrame& frame);

  GatewayOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  LineCallbacks callbacks_;
  LineState state_;
  std::size_t current_ = 0;        ///< of line_
  std::size_t next_gateway_ = 0;   ///< of next_
  std::size_t tried_ = 0;          ///< tried in this round without success
  std::vector<std::string> whys_;  ///< the last failure of each
  bool up_ = false;
  std::string used_;  ///< the host of the last tunnel that was up
  unsigned last_id_ = 0;
  Timer check_, overlap_, drop_;
  std::unique_ptr<Discovery> question_;
  /// A frame that one of two open tunnels reported.
  struct Reported {
    SteadyTime when;
    unsigned id = 0;
    wire::IndividualAddress source{};
    std::uint16_t destination = 0;
    Bytes tpdu;
  };
  std::deque<Reported> reported_;
  std::map<std::string, std::uint64_t> past_;  ///< counters of tunnels that were left
  std::uint64_t changes_ = 0;
  std::unique_ptr<TunnelLine> line_, next_, old_;  ///< in use; opening; left, until its last telegram has an outcome
  unsigned line_id_ = 0, next_id_ = 0;
};

}  // namespace rubicon::networks::knx::line
