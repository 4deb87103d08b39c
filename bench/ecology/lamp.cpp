#include <fmt/format.h>

#include <map>
#include <set>

#include "base/config_reader.h"
#include "client/remote_set_tracker.h"
#include "components/roles.h"
#include "config/yaml.h"
#include "ecology/measurements.h"
#include "frame/running_island.h"
#include "island/island.h"
#include "network/network.h"
#include "transport/local_transports.h"

namespace rubicon::bench {

namespace {

constexpr int kSwitchers = 8;
constexpr std::uint32_t kFirstSwitcher = 1'090'000;
/// Each command has a value of its own, by which the lamp knows it.
constexpr std::int64_t kValuesEach = 1'000'000;
constexpr std::size_t kUnderWay = 8;
constexpr OwnerId kLampIsland{6541};
constexpr std::string_view kLampType = "unsigned32BitOutput";

/// How often each value came.
std::map<std::int64_t, int>& seen_by_lamp() {
  static std::map<std::int64_t, int> seen;
  return seen;
}

/// One lamp that counts what it is set to, and reports it at once.
class CountingLamp final : public network::Network {
 public:
  CountingLamp(network::NetworkHost& host, const TypeCatalogue& types) : host_(host) {
    level_.point = {model::Kind::kActuator, types.find(kLampType)->id, "1"};
    level_.access = model::Access::kReadWrite;
  }
  Result<void> open() override {
    host_.deliver("", model::State{.line = model::LineState::kUp, .reason = {}, .counters = {}});
    model::Join join;
    join.name = "Lamp";
    join.capabilities = {level_};
    host_.deliver("hall", join);
    return {};
  }
  Result<void> send(const Message& message) override {
    const auto* actuate = std::get_if<model::Actuate>(&message.body);
    if (!actuate) return fail(ErrorCode::kUnsupported, "it can be set only");
    ++seen_by_lamp()[std::get<std::int64_t>(actuate->value)];
    host_.deliver("hall", model::Acknowledge{actuate->request, model::Outcome::kSent, {}});
    host_.deliver("hall", model::Updates{{model::Reading{level_.point, actuate->value, {}}}});
    return {};
  }

 private:
  network::NetworkHost& host_;
  model::Capability level_;
};

constexpr network::NetworkType kLamp{
    .name = "lamp",
    .summary = "a lamp that counts",
    .sample_config = "",
    .make = [](const network::NetworkConfig& config, network::NetworkHost& host)
        -> Result<std::unique_ptr<network::Network>> { return std::make_unique<CountingLamp>(host, config.types); }};

/// Sends its commands, so many under way, and knows the final states of each.
class Switcher {
 public:
  Switcher(Node& node, std::int64_t first, std::int64_t count) : node_(node), next_(first), end_(first + count) {}

  Json run() {
    const auto begin = node_.scheduler().now();
    more();
    node_.run(std::chrono::minutes(5));
    return {{"states", states_}, {"seconds", seconds_between(begin, node_.scheduler().now())}};
  }

 private:
  void more() {
    while (next_ < end_ && under_way_.size() < kUnderWay) {
      const auto value = next_++;
      const auto ended = [this, value](const client::Outcome& outcome) { end(value, outcome.state); };
      under_way_[value] = std::make_unique<client::RemoteSetTracker>(
          node_.scheduler(), node_.space(), kLampIsland,
          fmt::format("proxy.lamp-1.hall.actuator.{}-1.command", kLampType), std::to_string(value), ended,
          std::chrono::seconds(30), std::chrono::seconds(30));
    }
    if (under_way_.empty()) node_.finish();
  }
  /// A tracker reports its end, so it is destroyed in a later turn.
  void end(std::int64_t value, const std::string& state) {
    states_[std::to_string(value)].push_back(state);
    node_.scheduler().post([this, value] {
      under_way_.erase(value);
      more();
    });
  }

  Node& node_;
  std::int64_t next_, end_;
  std::map<std::int64_t, std::unique_ptr<client::RemoteSetTracker>> under_way_;
  std::map<std::string, std::vector<std::string>> states_;
};

/// What all said together.
struct Account {
  std::map<std::string, int> ends;
  std::uint64_t seen = 0, confirmed = 0;
  std::uint64_t seen_and_open = 0;     ///< executed, and replaced by a newer one before it was confirmed, or not known
  std::uint64_t without_one_end = 0;   ///< no final state, or several
  std::uint64_t twice = 0;             ///< executed again
  std::uint64_t confirmed_unseen = 0;  ///< the lamp knows nothing of it
  std::uint64_t seen_and_denied = 0;   ///< executed, though its commander was told that it was not

  void add(std::int64_t value, const std::vector<std::string>& states, const Json& lamp) {
    static const std::set<std::string> kNotExecuted{"refused", "failed", "expired", "no-such-owner"};
    if (states.size() != 1) return void(++without_one_end);
    ++ends[states.front()];
    const auto times = lamp.value(std::to_string(value), 0);
    const bool was_confirmed = states.front() == "confirmed";
    seen += static_cast<std::uint64_t>(times > 0);
    twice += static_cast<std::uint64_t>(times > 1);
    confirmed += static_cast<std::uint64_t>(was_confirmed);
    confirmed_unseen += static_cast<std::uint64_t>(was_confirmed && times == 0);
    const bool was_denied = kNotExecuted.contains(states.front());
    seen_and_denied += static_cast<std::uint64_t>(times > 0 && was_denied);
    seen_and_open += static_cast<std::uint64_t>(times > 0 && !was_denied && !was_confirmed);
  }
  std::uint64_t faults() const { return without_one_end + twice + confirmed_unseen + seen_and_denied; }
};

}  // namespace

Json lamp(const Meeting& meeting, const Json&) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  const auto ecology = open_engine(meeting, loop, nowhere());
  base::ConfigErrors errors;
  const auto tree = must(config::parse_yaml("island: {id: 6541, name: lamp}\nnetworks: {lamp-1: {type: lamp}}\n", ""));
  auto config = island::read_island_config(tree, std::span(&kLamp, 1), errors);
  const auto island =
      must(island::Island::make(std::move(config), loop.scheduler(), transports, nowhere(), *ecology, errors, nullptr));
  island->start();
  int left = 0, lost = 0;
  const auto watch = island->space().watch_peers([&](OwnerId, tuples::PeerEvent event) {
    lost += static_cast<int>(event == tuples::PeerEvent::kLost);
    if (event == tuples::PeerEvent::kLeft && ++left == kSwitchers) loop.stop();
  });
  loop.run();
  Json seen = Json::object();
  for (const auto& [value, times] : seen_by_lamp()) seen[std::to_string(value)] = times;
  return {{"seen", seen}, {"lost", lost}};
}

Json switcher(const Meeting& meeting, const Json& options) {
  const std::uint32_t number = options.at("number");
  Node node(OwnerId(kFirstSwitcher + number), meeting);
  node.await(kLampIsland);
  return Switcher(node, kValuesEach * (number + 1), options.at("count")).run();
}

void measure_lamp(const Plan& plan, Report& report) {
  const int each = plan.is_quick ? 50 : 1250;
  const auto meeting = plan.new_meeting();
  auto lit = start_role("lamp", meeting, Json::object());
  std::vector<Child> all;
  all.reserve(kSwitchers);
  for (int i = 0; i < kSwitchers; ++i) all.push_back(start_role("switcher", meeting, {{"number", i}, {"count", each}}));
  const auto said = results_of(all);
  const auto told = result_of(lit);
  Account account;
  for (std::size_t i = 0; i < said.size(); ++i) {
    const auto states = said[i].at("states").get<std::map<std::string, std::vector<std::string>>>();
    for (int n = 0; n < each; ++n) {
      const auto value = kValuesEach * (static_cast<std::int64_t>(i) + 1) + n;
      const auto found = states.find(std::to_string(value));
      account.add(value, found == states.end() ? std::vector<std::string>() : found->second, told.at("seen"));
    }
  }
  report.figure("lamp_seen", account.seen);
  report.figure("lamp_confirmed", account.confirmed);
  report.figure("lamp_seen_and_open", account.seen_and_open);
  report.figure("lamp_faults", account.faults());
  report.target("lamp_faults", "0", account.faults() == 0);
  report.target("lamp_seen", "confirmed and open ones together",
                account.seen == account.confirmed + account.seen_and_open);
  report.detail("lamp_seen",
                {{"method", fmt::format("{} programs send {} commands each, {} under way, to one lamp that counts what "
                                        "it is set to and reports it; each has one final state at its commander",
                                        kSwitchers, each, kUnderWay)},
                 {"ends", account.ends},
                 {"lost_peers", told.at("lost")},
                 {"without_one_end", account.without_one_end},
                 {"twice", account.twice},
                 {"confirmed_unseen", account.confirmed_unseen},
                 {"seen_and_denied", account.seen_and_denied},
                 {"seconds", rounded(median_of(said, "seconds"), 1)}});
}

}  // namespace rubicon::bench
