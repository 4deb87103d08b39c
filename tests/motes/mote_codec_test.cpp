#include "motes/mote_codec.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace rubicon::motes {
namespace {

/// A case: packets in hex with the codec's settings in front of them, and the text they become.
struct Case {
  Calibration calibration;
  std::optional<std::uint16_t> island;
  std::vector<Bytes> packets;
  std::string expected;
};

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string cases_folder() {
  return RUBICON_SOURCE_DIR "/tests/cases/motes/";
}

Case read_case(const std::string& name) {
  Case out;
  std::istringstream lines(read_file(cases_folder() + name + ".hex"));
  for (std::string line; std::getline(lines, line);) {
    const auto after = [&line](std::string_view key) { return line.substr(key.size()); };
    if (line.starts_with("#")) continue;
    if (line.starts_with("board: "))
      out.calibration.board = parse_board(after("board: ")).value();
    else if (line.starts_with("units: "))
      out.calibration.units = parse_units(after("units: ")).value();
    else if (line.starts_with("island: "))
      out.island = static_cast<std::uint16_t>(std::stoi(after("island: ")));
    else
      out.packets.push_back(base::from_hex(line).value());
  }
  out.expected = read_file(cases_folder() + name + ".txt");
  return out;
}

std::string spelled(const TypeCatalogue& types, const model::PointId& point) {
  const Type* type = types.find(point.type);
  return fmt::format("{}-{}", type == nullptr ? "?" : type->name, point.instance);
}

std::string describe(const TypeCatalogue& types, const model::Message& message) {
  std::string text;
  if (message.destination.island != model::kNoOwner)
    text += fmt::format("to {}{}: ", model::number(message.destination.island), message.destination.device);
  const std::string& device = message.source.device;
  if (const auto* join = std::get_if<model::Join>(&message.body)) {
    text += fmt::format("join {}{}{}:", device, join->model.empty() ? "" : " ", join->model);
    for (const auto& capability : join->capabilities)
      text += fmt::format(" {}{}", capability.point.kind == Kind::kActuator ? "actuator:" : "",
                          spelled(types, capability.point));
  } else if (const auto* updates = std::get_if<model::Updates>(&message.body)) {
    text += fmt::format("updates {}:", device);
    for (const auto& reading : updates->readings)
      text += fmt::format(" {}={}", spelled(types, reading.point), model::to_text(reading.value));
  } else if (const auto* opaque = std::get_if<model::Opaque>(&message.body)) {
    text += fmt::format("opaque {} {} {}", device, opaque->type, base::to_hex(opaque->bytes));
  } else {
    text += fmt::format("{} {}", model::to_string(message.kind()), device);
  }
  return text + "\n";
}

std::string describe(const TypeCatalogue& types, const Result<MoteEvents>& events) {
  if (!events) return "error " + events.error().text + "\n";
  std::string text;
  if (events->foreign_island) text += fmt::format("foreign {}\n", *events->foreign_island);
  for (const model::Message& message : events->messages) text += describe(types, message);
  if (events->ack)
    text += fmt::format("ack mote {} app {} seq {:04x} status {}\n", events->ack->mote, events->ack->application,
                        events->ack->ack.sequence, events->ack->ack.status);
  if (events->wants_ack)
    text += fmt::format("wants-ack mote {} app {} seq {:04x}\n", events->wants_ack->mote,
                        events->wants_ack->application, events->wants_ack->sequence);
  return text;
}

std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(cases_folder())) {
    if (entry.path().extension() == ".hex") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class MoteCodecCase : public testing::TestWithParam<std::string> {};

TEST_P(MoteCodecCase, BecomesTheExpectedMessages) {
  const TypeCatalogue types;
  const Case golden = read_case(GetParam());
  MoteCodec codec(types, {golden.calibration, golden.island});
  std::string text;
  for (const Bytes& packet : golden.packets) text += describe(types, codec.decode(packet));
  EXPECT_EQ(text, golden.expected);
}

INSTANTIATE_TEST_SUITE_P(Golden, MoteCodecCase, testing::ValuesIn(case_names()),
                         [](const auto& parameter) { return parameter.param; });

TEST(MoteCodec, UsesOnlyTypesOfTheCatalogue) {
  const TypeCatalogue types;
  for (const Board board : {Board::kStandard, Board::kSe1000, Board::kIris}) {
    for (const Units units : {Units::kPhysical, Units::kRaw}) {
      for (const MoteSensor& sensor : sensors_in_mask(0x1fff, {board, units}))
        EXPECT_NE(types.find(sensor.type), nullptr) << sensor.type;
    }
  }
  EXPECT_NE(types.find("led"), nullptr);
  EXPECT_NE(types.find("relay"), nullptr);
}

TEST(MoteCodec, GivesValuesThatFitTheirTypes) {
  const TypeCatalogue types;
  for (const Board board : {Board::kStandard, Board::kEm1000, Board::kSe1000, Board::kIris, Board::kMicaz}) {
    for (const Units units : {Units::kPhysical, Units::kRaw}) {
      const Calibration calibration{board, units};
      for (const MoteSensor& sensor : sensors_in_mask(0x1fff, calibration)) {
        for (const unsigned count : {0u, 1u, 500u, 1022u, 1200u, 4095u}) {
          const auto value = convert(sensor, static_cast<std::uint16_t>(count), calibration, std::nullopt);
          const Type* type = types.find(sensor.type);
          if (!value || type == nullptr) continue;
          const auto fits = TypeCatalogue::check(*type, *value);
          EXPECT_TRUE(fits.has_value()) << sensor.type << " " << count << ": " << fits.error().text;
        }
      }
    }
  }
}

/// More motes than a codec remembers.
struct ManyMotes : testing::Test {
  static Bytes packet_from(std::size_t mote, const Record& record) {
    const auto bytes = encode_record(record);
    return packet_of(NetMessage{11, kBaseMote, 11, static_cast<std::uint16_t>(mote), 0, 1, 0, kTransportConnectionless,
                                kApplicationControl, bytes});
  }
  bool report(std::size_t mote) {
    RawUpdates updates;
    updates.readings.push_back({1, {300}});
    return codec.decode(packet_from(mote, updates)).has_value();
  }
  /// The address in the record counts.
  bool join(std::size_t mote, std::size_t source) {
    return codec.decode(packet_from(source, Joined{11, static_cast<std::uint16_t>(mote), 1, 1, 0})).has_value();
  }
  std::size_t known() const {
    std::size_t count = 0;
    for (std::uint16_t mote = 0; mote < kBaseMote; ++mote) count += codec.knows(mote) ? 1U : 0U;
    return count;
  }

  static constexpr std::size_t kFirst = 100, kEnd = kFirst + MoteCodec::kMaxMotes;
  const TypeCatalogue types;
  MoteCodec codec{types, {}};
};

TEST_F(ManyMotes, TheOneHeardLongestAgoMakesRoomUnlessItJoined) {
  ASSERT_TRUE(join(kFirst, kFirst));
  for (auto mote = kFirst + 1; mote < kEnd; ++mote) ASSERT_TRUE(report(mote));
  ASSERT_TRUE(report(kFirst + 1));
  EXPECT_FALSE(report(4000)) << "it may be noise";
  EXPECT_FALSE(codec.knows(4000));
  EXPECT_TRUE(join(5000, 5000));
  EXPECT_TRUE(codec.knows(5000));
  EXPECT_TRUE(codec.knows(kFirst)) << "it joined";
  EXPECT_TRUE(codec.knows(kFirst + 1));
  EXPECT_FALSE(codec.knows(kFirst + 2));
  EXPECT_EQ(known(), MoteCodec::kMaxMotes);
}

TEST_F(ManyMotes, MotesThatWereReplacedMakeRoomToo) {
  for (auto mote = kFirst; mote < kEnd; ++mote) ASSERT_TRUE(join(mote, kFirst));
  EXPECT_TRUE(join(5000, kFirst));
  EXPECT_TRUE(codec.knows(5000));
  EXPECT_FALSE(codec.knows(kFirst));
  EXPECT_EQ(known(), MoteCodec::kMaxMotes);
}

}  // namespace
}  // namespace rubicon::motes
