#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/simulators/zigbee/bridge_topics.h"
#include "apps/simulators/zigbee/radio.h"
#include "apps/simulators/zigbee/registry.h"

namespace rubicon::zigbee_simulator {

class World;

/// The pairing of devices: they wait until joining is permitted, and their interviews send the recorded messages in
/// the recorded order.
class Interviews {
 public:
  /// All must outlive it.
  Interviews(const BridgeState& state, Registry& registry, BridgeTopics& topics, Radio& radio, Delays& delays)
      : state_(state), registry_(registry), topics_(topics), radio_(radio), delays_(delays) {}

  /// The device pairs now if joining is permitted, else it waits.
  void add(RadioDevice& device, bool fails);
  /// Joining is permitted: all that wait begin.
  void open();
  void forget(const std::string& address);
  /// The interview of a known device runs again.
  void repeat(RadioDevice& device);

 private:
  struct Candidate {
    std::string address;
    bool fails = false;
  };

  void begin(RadioDevice& device, bool fails);
  void ask(RadioDevice& device, bool fails, int question);
  void succeed(RadioDevice& device);
  void fail_now(RadioDevice& device);
  void configure(RadioDevice& device);

  const BridgeState& state_;
  Registry& registry_;
  BridgeTopics& topics_;
  Radio& radio_;
  Delays& delays_;
  std::vector<Candidate> waiting_;
};

/// Answers `bridge/request/<what>` (zigbee.md, section 8). What a bridge does not know is not answered.
class Requests {
 public:
  /// All must outlive it. `world`: what changes the bridge itself.
  Requests(World& world, BridgeState& state, Registry& registry, BridgeTopics& topics, Delays& delays,
           Interviews& interviews)
      : world_(world), state_(state), registry_(registry), topics_(topics), delays_(delays), interviews_(interviews) {}

  void received(std::string_view what, std::string_view payload);

 private:
  using Json = nlohmann::json;
  using Answer = Result<Json>;  ///< the data of the response, or the error text
  using Call = Answer (Requests::*)(const Json&);

  static const std::map<std::string_view, Call>& calls();
  void respond(std::string_view what, const Json& request, const Answer& answer);
  void draw_map(const Json& request);

  Answer permit_join(const Json& request);
  Answer rename_device(const Json& request);
  Answer remove_device(const Json& request);
  Answer device_options(const Json& request);
  Answer interview(const Json& request);
  Answer configure_reporting(const Json& request);
  Answer bridge_options(const Json& request);
  Answer add_group(const Json& request);
  Answer remove_group(const Json& request);
  Answer rename_group(const Json& request);
  Answer add_member(const Json& request);
  Answer remove_member(const Json& request);
  Answer remove_from_all(const Json& request);
  Answer check_health(const Json& request);
  Answer check_coordinator(const Json& request);
  Answer restart(const Json& request);

  Result<RadioDevice*> device_of(const Json& request, const char* member);
  Result<DeviceGroup*> group_of(const Json& request, const char* member);

  World& world_;
  BridgeState& state_;
  Registry& registry_;
  BridgeTopics& topics_;
  Delays& delays_;
  Interviews& interviews_;
};

}  // namespace rubicon::zigbee_simulator
