#include "networks/knx/groups/kind_of_type.h"

#include <array>

namespace rubicon::networks::knx::groups {

namespace {

struct Rule {
  std::uint16_t main, first, last;
  Kind kind;
};
constexpr Kind kSensor = Kind::kSensor, kActuator = Kind::kActuator;
constexpr std::uint16_t kAll = dpt::DptId::kMainOnly;

/// The first matching rule decides; types without a rule are sensors (4, 6, 8, 10 to 16, 19, 24 to 29, ...).
constexpr std::array kRules{
    Rule{1, 5, 6, kSensor},           // alarm, binary value
    Rule{1, 11, 11, kSensor},         // state
    Rule{1, 14, 14, kSensor},         // input source
    Rule{1, 18, 19, kSensor},         // occupancy, window and door
    Rule{1, 1200, 1201, kSensor},     // consumer or producer, direction of energy
    Rule{1, 0, kAll, kActuator},      // switches and everything like them
    Rule{2, 0, kAll, kActuator},      // forced control
    Rule{3, 0, kAll, kActuator},      // relative dimming, blinds
    Rule{5, 4, 6, kSensor},           // percent of 255, factor, tariff
    Rule{5, 10, 10, kSensor},         // counter
    Rule{5, 0, kAll, kActuator},      // brightness, position, angle, fan stage
    Rule{7, 600, 600, kActuator},     // colour temperature
    Rule{17, 0, kAll, kActuator},     // scenes
    Rule{18, 0, kAll, kActuator},     //
    Rule{20, 6, 7, kSensor},          // area of application, class of alarm
    Rule{20, 11, 12, kSensor},        // classes of errors
    Rule{20, 14, 14, kSensor},        // wind force
    Rule{20, 20, 21, kSensor},        // type of actuator, clouds
    Rule{20, 100, 101, kSensor},      // fuel, burner
    Rule{20, 113, 114, kSensor},      // status of the setpoint, kind of meter
    Rule{20, 120, 120, kSensor},      // kind of damper
    Rule{20, 610, 610, kSensor},      // load found
    Rule{20, 1001, 1001, kSensor},    // additional information
    Rule{20, 1004, 1004, kSensor},    // medium
    Rule{20, 1200, 1221, kSensor},    // meters, charging stations
    Rule{20, 60102, 60102, kSensor},  // HVAC status
    Rule{20, 0, kAll, kActuator},     // modes
    Rule{21, 2, 2, kActuator},        // device control
    Rule{21, 100, 101, kActuator},    // forcing signals
    Rule{21, 1010, 1010, kActuator},  // activation of channels
    Rule{22, 1010, 1010, kActuator},  //
    Rule{30, 1010, 1010, kActuator},  //
    Rule{23, 2, 2, kSensor},          // reaction to an alarm
    Rule{23, 0, kAll, kActuator},     // two-bit actions
    Rule{206, 0, kAll, kActuator},    // the next mode
    Rule{213, 0, kAll, kActuator},    // sets of setpoints
    Rule{222, 0, kAll, kActuator},    //
    Rule{275, 0, kAll, kActuator},    //
    Rule{225, 1, 2, kActuator},       // scaling in a time
    Rule{232, 0, kAll, kActuator},    // colours
    Rule{236, 0, kAll, kActuator},    // mode with priority
    Rule{238, 1, 1, kActuator},       // configuration of scenes
    Rule{239, 0, kAll, kActuator},    // scaling with a flag
    Rule{240, 0, kAll, kActuator},    // position of blind and slat
    Rule{242, 0, kAll, kActuator},    // colours, and how they change
    Rule{243, 0, kAll, kActuator},    //
    Rule{249, 0, kAll, kActuator},    //
    Rule{250, 0, kAll, kActuator},    //
    Rule{251, 0, kAll, kActuator},    //
    Rule{252, 0, kAll, kActuator},    //
    Rule{253, 0, kAll, kActuator},    //
    Rule{254, 0, kAll, kActuator},    //
};

}  // namespace

Kind kind_of_type(std::optional<dpt::DptId> type) {
  if (!type) return kSensor;
  for (const auto& rule : kRules) {
    if (rule.main == type->main && type->sub >= rule.first && type->sub <= rule.last) return rule.kind;
  }
  return kSensor;
}

}  // namespace rubicon::networks::knx::groups
