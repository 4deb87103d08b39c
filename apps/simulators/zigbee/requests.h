#pragma once

#include <string>
#include <string_view>

#include "apps/simulators/zigbee/world.h"

namespace rubicon::zigbee_simulator {

/// Answers `bridge/request/<what>` (zigbee.md, section 8). What a bridge does not know is not answered.
class Requests {
 public:
  explicit Requests(World& world) : world_(world) {}

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
};

}  // namespace rubicon::zigbee_simulator
