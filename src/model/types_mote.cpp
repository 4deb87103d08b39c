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

}  // namespace rubicon::model
