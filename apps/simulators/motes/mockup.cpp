#include "apps/simulators/motes/mockup.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "motes/mote_records.h"

namespace rubicon::motes_simulator {

MessageMemory::Room MessageMemory::room() {
  Room room{};
  const bool stale = std::uniform_real_distribution<>(0, 1)(rng_) < stale_;
  if (!stale || last_.empty()) return room;
  const auto from = static_cast<std::ptrdiff_t>(rng_() % last_.size());
  const auto count = std::min<std::ptrdiff_t>(std::ssize(last_) - from, std::ssize(room));
  std::copy_n(last_.begin() + from, count, room.end() - count);
  std::copy_n(last_.begin(), std::ssize(room) - count, room.begin());
  return room;
}

Bytes MessageMemory::wrap(motes::NetMessage& message, const Room& room) {
  message.record = room;
  last_ = motes::encode_net(message);
  return last_;
}

Bytes MessageMemory::build(motes::NetMessage message) {
  RUBICON_ASSERT(message.record.size() <= kRecordRoom);
  auto into = room();
  std::copy(message.record.begin(), message.record.end(), into.begin());
  return wrap(message, into);
}

Bytes MessageMemory::build_ack(motes::NetMessage message) {
  RUBICON_ASSERT(message.record.size() < kRecordRoom);
  auto into = room();
  const auto next = std::copy(message.record.begin(), message.record.end(), into.begin());
  *next = static_cast<std::uint8_t>(0x60U + rng_() % 16U);
  return wrap(message, into);
}

namespace {

constexpr std::uint8_t kPeriodic = 1;
constexpr std::uint8_t kActuate = 2;
constexpr std::uint8_t kDemoData = 34;
constexpr std::uint8_t kReadUpdates = 36;
constexpr std::uint16_t kLight = 0x0001;
constexpr std::uint16_t kTemperature = 0x0002;
constexpr std::uint16_t kLed = 1;
/// A command without its period (wsn.md 9.4: about 50 ms, about 170 readings between two reports).
constexpr std::uint32_t kFloodPeriod = 51;
constexpr unsigned kFloodReadings = 110;
constexpr unsigned kFloodSpread = 120;

}  // namespace

Duration tinyos_ms(std::uint32_t count) {
  return Duration(std::chrono::nanoseconds(1'000'000'000ULL * count / 1024));
}

Mockup::Mockup(MockupOptions options, Sensors& sensors, TinyosRandom& random, Scheduler& scheduler, Callbacks callbacks)
    : options_(options), sensors_(sensors), random_(random), scheduler_(scheduler), callbacks_(std::move(callbacks)) {}

void Mockup::reset() {
  timer_.cancel();
  updates_timer_.cancel();
  actuators_.clear();
  for (auto& sensor : measuring_) sensor.cancel();
  mask_ = 0;
  measured_ = {};
}

bool Mockup::take(const motes::NetMessage& message) {
  if (message.application == motes::kApplicationMockup) return take_mockup(message);
  if (message.application != motes::kApplicationControl || !options_.updates || message.record[0] != kReadUpdates)
    return false;
  read_updates(message);
  return true;
}

bool Mockup::take_mockup(const motes::NetMessage& message) {
  switch (message.record[0]) {
    case kPeriodic: periodic(message); return true;
    case kReadUpdates:  // one reading, period and mask ignored, no report (wsn.md 9.4)
      read(kLight | kTemperature);
      return true;
    case kActuate:
      if (options_.obey) actuate(message.record);
      return options_.obey;
    default: return false;
  }
}

void Mockup::periodic(const motes::NetMessage& message) {
  base::ByteReader reader(message.record);
  reader.skip(1);
  mask_ = reader.u16_be();
  const auto period = reader.u16_be();  // 0 if it is not there
  requester_ = {message.source_island, message.source_mote};
  period_ = tinyos_ms(period == 0 ? kFloodPeriod : period);
  due_ = scheduler_.now();
  schedule(timer_, due_, period_, period == 0 ? &Mockup::flood_tick : &Mockup::tick);
}

void Mockup::schedule(Timer& timer, SteadyTime& due, Duration period, void (Mockup::*then)()) {
  due += period;
  timer = scheduler_.at(due, [this, then] { (this->*then)(); });
}

/// A tick starts a measurement and sends its report without waiting for the values. So a report carries what the
/// previous tick measured, and the first one after a command stale values (wsn.md 9.4). Sensors that need no time are
/// measured in the same tick. With mask 0 reports are sent too.
void Mockup::tick() {
  schedule(timer_, due_, period_, &Mockup::tick);
  read(mask_);
  report();
}

void Mockup::flood_tick() {
  schedule(timer_, due_, period_, &Mockup::flood_tick);
  const unsigned readings = kFloodReadings + random_.next() % kFloodSpread;
  const bool at_once = options_.sensor_time == Duration::zero();
  if (at_once && (mask_ & kLight) != 0) sensors_.skip(kLightSensor, readings);
  if (at_once && (mask_ & kTemperature) != 0) sensors_.skip(kTemperatureSensor, readings);
  for (unsigned i = 0; i < readings; ++i) random_.next();  // for messages that find the queue full
  read(mask_);
  report();
}

std::uint16_t Mockup::reading(std::size_t sensor) {
  const unsigned count = sensors_.read(sensor, scheduler_.now());
  const auto led = actuators_.find(kLed);
  const bool lit = sensor == kLightSensor && led != actuators_.end() && led->second != 0;
  return static_cast<std::uint16_t>(lit ? count + kLedLight : count);
}

void Mockup::read(std::uint16_t mask) {
  if ((mask & kLight) != 0) measure(kLightSensor);
  if ((mask & kTemperature) != 0) measure(kTemperatureSensor);
}

/// A sensor that is measuring ignores further requests.
void Mockup::measure(std::size_t sensor) {
  auto& measuring = measuring_.at(sensor);
  if (measuring.pending()) return;
  if (options_.sensor_time == Duration::zero()) {
    measured_.at(sensor) = reading(sensor);
    return;
  }
  measuring = scheduler_.after(options_.sensor_time, [this, sensor] { measured_.at(sensor) = reading(sensor); });
}

/// The released firmware fills in light and temperature only (wsn.md 7.1); the rest is stale memory.
void Mockup::report() {
  base::ByteWriter record;
  record.u8(kDemoData).u16_be(measured_[kLightSensor]).u16_be(measured_[kTemperatureSensor]);
  callbacks_.send(requester_, motes::kApplicationMockup, record.view());
}

void Mockup::actuate(ByteView record) {
  base::ByteReader reader(record);
  reader.skip(1);
  const auto actuator = reader.u16_be();
  const auto value = static_cast<std::int32_t>(reader.u32_be());
  if (!reader.ok() || actuators_.size() > 16) return;
  actuators_[actuator] = value;
  callbacks_.actuated(actuator, value);
}

void Mockup::read_updates(const motes::NetMessage& message) {
  base::ByteReader reader(message.record);
  reader.skip(1);
  const auto period = reader.u16_be();
  updates_mask_ = reader.u16_be();
  if (!reader.ok() || period == 0) return;
  updates_for_ = {message.source_island, message.source_mote};
  updates_period_ = tinyos_ms(period);
  updates_due_ = scheduler_.now();
  schedule(updates_timer_, updates_due_, updates_period_, &Mockup::updates_tick);
}

void Mockup::updates_tick() {
  schedule(updates_timer_, updates_due_, updates_period_, &Mockup::updates_tick);
  motes::RawUpdates updates;
  for (std::size_t i = 0; i < kSensors.size(); ++i) {
    const auto& place = kSensors[i];
    if ((place.transducer & updates_mask_ & options_.transducers) == 0) continue;
    if (place.word == 0) updates.readings.push_back({place.transducer, {}});
    updates.readings.back().words.push_back(reading(i));
  }
  if (updates.readings.empty()) return;
  const auto record = motes::encode_record(updates);
  callbacks_.send(updates_for_, motes::kApplicationControl, record);
}

}  // namespace rubicon::motes_simulator
