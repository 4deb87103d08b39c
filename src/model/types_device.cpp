#include "model/type_tables.h"

namespace rubicon::model {

namespace {

using enum DataType;
using enum Report;

// id, name, quantity, unit, data, minimum, maximum, report, words
constexpr Type kMoteTypes[] = {
    {TypeId(0x0001), "light", "illuminance", "lx", kReal, 0.0, 1000000.0, kState, ""},
    {TypeId(0x0002), "temperature", "temperature", "Cel", kReal, -273.15, 2000.0, kState, ""},
    {TypeId(0x0003), "humidity", "relative humidity", "%", kReal, 0.0, 100.0, kState, ""},
    {TypeId(0x0004), "accelerationRaw", "acceleration, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0005), "accelerationVarianceRaw", "acceleration variance, counts", "1", kInteger, 0.0, 65535.0, kState,
     ""},
    {TypeId(0x0006), "accelerationVariance", "acceleration variance", "1", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x000a), "motion", "motion", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x000b), "microphone", "sound level", "V", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x000c), "magnetic", "magnetic contact", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x000d), "rssi", "received signal strength", "dB[mW]", kReal, -150.0, 50.0, kState, ""},
    {TypeId(0x000e), "rssiDeviation", "signal strength deviation", "dB", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x000f), "rssiRaw", "received signal strength, radio units", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0010), "rssiRawDeviation", "signal strength deviation, radio units", "1", kReal, 0.0, kNone, kState, ""},
    {TypeId(0x0011), "rssiScaled", "received signal strength, rescaled", "1", kReal, -1.0, 1.0, kState, ""},
    {TypeId(0x0012), "led", "indicator lamps", "1", kInteger, 0.0, 255.0, kState, ""},
    {TypeId(0x0013), "relay", "relay", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0014), "lightRaw", "illuminance, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0015), "temperatureRaw", "temperature, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0016), "humidityRaw", "relative humidity, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x001c), "pirRaw", "motion, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x001d), "microphoneRaw", "sound level, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x001e), "magneticRaw", "magnetic contact, counts", "1", kInteger, 0.0, 65535.0, kState, ""},
};

}  // namespace

std::span<const Type> mote_types() {
  return kMoteTypes;
}

namespace {

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

namespace {

// id, name, quantity, unit, data, minimum, maximum, report, words
constexpr Type kRegisterTypes[] = {
    {TypeId(0x0100), "digitalInput", "digital input", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0101), "analogueInput", "analogue input", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0102), "unsigned1BitInput", "input register", "1", kInteger, 0.0, 1.0, kState, ""},
    {TypeId(0x0103), "unsigned2BitInput", "input register", "1", kInteger, 0.0, 3.0, kState, ""},
    {TypeId(0x0104), "unsigned4BitInput", "input register", "1", kInteger, 0.0, 15.0, kState, ""},
    {TypeId(0x0105), "unsigned8BitInput", "input register", "1", kInteger, 0.0, 255.0, kState, ""},
    {TypeId(0x0106), "unsigned16BitInput", "input register", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0107), "unsigned24BitInput", "input register", "1", kInteger, 0.0, 16777215.0, kState, ""},
    {TypeId(0x0108), "unsigned32BitInput", "input register", "1", kInteger, 0.0, 4294967295.0, kState, ""},
    {TypeId(0x0109), "unsigned64BitInput", "input register", "1", kInteger, 0.0, kNone, kState, ""},
    {TypeId(0x010a), "signed8BitInput", "input register", "1", kInteger, -128.0, 127.0, kState, ""},
    {TypeId(0x010b), "signed16BitInput", "input register", "1", kInteger, -32768.0, 32767.0, kState, ""},
    {TypeId(0x010c), "signed32BitInput", "input register", "1", kInteger, -2147483648.0, 2147483647.0, kState, ""},
    {TypeId(0x010d), "signed64BitInput", "input register", "1", kInteger, -kNone, kNone, kState, ""},
    {TypeId(0x010e), "float16BitInput", "input register", "1", kReal, -671088.64, 670433.28, kState, ""},
    {TypeId(0x010f), "float32BitInput", "input register", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0110), "textInput", "input text", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0111), "bytesInput", "input bytes", "1", kBytes, -kNone, kNone, kState, ""},
    {TypeId(0x0112), "structuredInput", "input record", "1", kJson, -kNone, kNone, kState, ""},
    {TypeId(0x0113), "enumerationInput", "input code", "1", kEnumeration, 0.0, 65535.0, kState, ""},
    {TypeId(0x0114), "bitsetInput", "input flags", "1", kJson, -kNone, kNone, kState, ""},
    {TypeId(0x0140), "digitalOutput", "digital output", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0141), "analogueOutput", "analogue output", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0142), "unsigned1BitOutput", "output register", "1", kInteger, 0.0, 1.0, kState, ""},
    {TypeId(0x0143), "unsigned2BitOutput", "output register", "1", kInteger, 0.0, 3.0, kState, ""},
    {TypeId(0x0144), "unsigned4BitOutput", "output register", "1", kInteger, 0.0, 15.0, kState, ""},
    {TypeId(0x0145), "unsigned8BitOutput", "output register", "1", kInteger, 0.0, 255.0, kState, ""},
    {TypeId(0x0146), "unsigned16BitOutput", "output register", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0147), "unsigned24BitOutput", "output register", "1", kInteger, 0.0, 16777215.0, kState, ""},
    {TypeId(0x0148), "unsigned32BitOutput", "output register", "1", kInteger, 0.0, 4294967295.0, kState, ""},
    {TypeId(0x0149), "unsigned64BitOutput", "output register", "1", kInteger, 0.0, kNone, kState, ""},
    {TypeId(0x014a), "signed8BitOutput", "output register", "1", kInteger, -128.0, 127.0, kState, ""},
    {TypeId(0x014b), "signed16BitOutput", "output register", "1", kInteger, -32768.0, 32767.0, kState, ""},
    {TypeId(0x014c), "signed32BitOutput", "output register", "1", kInteger, -2147483648.0, 2147483647.0, kState, ""},
    {TypeId(0x014d), "signed64BitOutput", "output register", "1", kInteger, -kNone, kNone, kState, ""},
    {TypeId(0x014e), "float16BitOutput", "output register", "1", kReal, -671088.64, 670433.28, kState, ""},
    {TypeId(0x014f), "float32BitOutput", "output register", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0150), "textOutput", "output text", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0151), "bytesOutput", "output bytes", "1", kBytes, -kNone, kNone, kState, ""},
    {TypeId(0x0152), "structuredOutput", "output record", "1", kJson, -kNone, kNone, kState, ""},
    {TypeId(0x0153), "enumerationOutput", "output code", "1", kEnumeration, 0.0, 65535.0, kState, ""},
    {TypeId(0x0154), "bitsetOutput", "output flags", "1", kJson, -kNone, kNone, kState, ""},
};

}  // namespace

std::span<const Type> register_types() {
  return kRegisterTypes;
}

}  // namespace rubicon::model
