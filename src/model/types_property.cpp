#include "model/type_tables.h"

namespace rubicon::model {

namespace {

using enum DataType;
using enum Report;

// id, name, quantity, unit, data, minimum, maximum, report, words
constexpr Type kPropertyTypes[] = {
    {TypeId(0x0600), "rate", "sampling period", "ms", kInteger, 10.0, 86400000.0, kState, ""},
    {TypeId(0x0601), "dutyCycle", "duty cycle", "%", kReal, 0.0, 100.0, kState, ""},
    {TypeId(0x0602), "mask", "mask of transducers", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0603), "threshold", "threshold", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0604), "deadBand", "dead band", "1", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x0605), "offset", "offset of a measured value", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0606), "scale", "factor of a measured value", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0607), "label", "label", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0608), "activityLabel", "activity going on", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0609), "group", "group", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x060a), "room", "room", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x060b), "firmware", "firmware version", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x060c), "hardware", "hardware version", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x060d), "serialNumber", "serial number", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x060e), "manufacturer", "manufacturer", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x060f), "modelName", "model", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0610), "interval", "reporting interval", "s", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x0611), "transitionTime", "transition time", "s", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x0612), "powerOnBehaviour", "state after power on", "1", kEnumeration, -kNone, kNone, kState,
     "off,on,previous,toggle"},
    {TypeId(0x0613), "sensitivity", "sensitivity", "1", kEnumeration, -kNone, kNone, kState, "low,medium,high"},
    {TypeId(0x0614), "calibration", "calibration", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0615), "childLock", "child lock", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0616), "ledIndication", "indicator lamp", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0617), "minimumLevel", "lower limit", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0618), "maximumLevel", "upper limit", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0619), "txPower", "transmit power", "dB[mW]", kReal, -100.0, 50.0, kState, ""},
    {TypeId(0x061a), "radioChannel", "radio channel", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x061b), "lineState", "state of the line", "1", kEnumeration, -kNone, kNone, kState,
     "down,connecting,up,ended,refused"},
    {TypeId(0x061c), "reason", "reason", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x061d), "batteryType", "battery type", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x061e), "mode", "mode", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x061f), "powerOnColourTemperatureMired",
     "reciprocal colour temperature after power on, 65535 = the one before", "1", kReal, 0.0, 65535.0, kState, ""},
    {TypeId(0x0620), "powerOutageMemory", "return to the state before a power failure", "1", kBoolean, -kNone, kNone,
     kState, ""},
    {TypeId(0x0621), "temperatureCalibration", "correction of a measured temperature", "K", kReal, -kNone, kNone,
     kState, ""},
    {TypeId(0x0622), "humidityCalibration", "correction of a measured humidity", "%", kReal, -100.0, 100.0, kState, ""},
    {TypeId(0x0623), "minimumTemperatureSetpoint", "lowest temperature setpoint", "Cel", kReal, -50.0, 150.0, kState,
     ""},
    {TypeId(0x0624), "maximumTemperatureSetpoint", "highest temperature setpoint", "Cel", kReal, -50.0, 150.0, kState,
     ""},
    {TypeId(0x0625), "temperatureDeadBand", "dead band of a thermostat", "K", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x0626), "windowDetection", "detection of open windows", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0627), "valveDetection", "detection of the valve", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0628), "frostProtection", "frost protection", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0629), "keypadLockout", "locked keys", "1", kEnumeration, -kNone, kNone, kState, ""},
    {TypeId(0x062a), "switchType", "kind of the connected switch", "1", kEnumeration, -kNone, kNone, kState, ""},
    {TypeId(0x062b), "indicatorMode", "mode of the indicator lamp", "1", kEnumeration, -kNone, kNone, kState, ""},
    {TypeId(0x062c), "backlightMode", "mode of the backlight", "1", kEnumeration, -kNone, kNone, kState, ""},
    {TypeId(0x062d), "deviceMode", "operating mode, words of the device", "1", kEnumeration, -kNone, kNone, kState, ""},
    {TypeId(0x062e), "holdTime", "time for which a detector holds its state", "s", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x062f), "temperatureUnit", "unit of the display", "1", kEnumeration, -kNone, kNone, kState,
     "celsius,fahrenheit"},
    {TypeId(0x0630), "doNotDisturb", "lamp stays off after power on", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0631), "schedule", "schedule", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0632), "autoLock", "lock that locks by itself", "1", kBoolean, -kNone, kNone, kState, ""},
};

}  // namespace

std::span<const Type> property_types() {
  return kPropertyTypes;
}

}  // namespace rubicon::model
