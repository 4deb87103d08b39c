#include "motes/learning_records.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <set>

#include "motes/serial_lines.h"

namespace rubicon::motes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string encoded(std::string_view name, const FieldValues& values) {
  const auto bytes = encode_learning(name, values);
  return bytes ? base::to_hex(*bytes) : bytes.error().text;
}

struct Layout {
  std::string name;
  std::uint8_t type;
  FieldValues values;
  Bytes bytes;
};

/// Without the records of matrices and outputs, and those around a record.
std::vector<Layout> command_layouts() {
  return {
      {"Command", 0x0b, {{"command", {8}}, {"counter", {258}}, {"delay", {1000}}}, hex("08 0102 03e8")},
      {"SerialData",
       0x0c,
       {{"island", {11}},
        {"mote", {5}},
        {"counter", {7}},
        {"temp", {6500}},
        {"humid", {1200}},
        {"light", {300}},
        {"rssi", {65535}}},
       hex("0b 0005 0007 1964 04b0 012c ffff")},
      {"SynData", 0x0d, {{"floats", {0.75, -1.5, 0, 0, 0, 0, 0, 0, 0, 0}}}, padded("0000403f 0000c0bf", 32, "")},
      {"NetIdCmd", 0x11, {{"command", {1}}, {"netId", {300}}, {"seq", {0xbeef}}}, hex("01 012c beef")},
      {"BroadcastCmd", 0x12, {{"type", {8}}, {"clock", {500}}, {"seq", {7}}}, hex("08 01f4 0007")},
      {"SynCreateCmd",
       0x13,
       {{"type", {9}},
        {"srcIsland", {11}},
        {"srcMote", {2}},
        {"destIsland", {12}},
        {"destMote", {3}},
        {"srcNetId", {300}},
        {"destNetId", {301}},
        {"srcCount", {2}},
        {"srcNeurons", {1, 258}},
        {"destCount", {1}},
        {"destNeurons", {4}},
        {"params", {-2}},
        {"seq", {0x1234}}},
       padded("09 000b 0002 000c 0003 012c 012d 02 0001 0102", 16, "01 0004") + padded("", 18, "fe 1234")},
  };
}

/// So many numbers, all zero but some.
std::vector<double> mostly_zero(std::size_t count, const std::map<std::size_t, double>& others) {
  std::vector<double> numbers(count);
  for (const auto& [at, number] : others) numbers[at] = number;
  return numbers;
}

std::vector<Layout> other_layouts() {
  return {
      {"LearningModuleCmd",
       0x14,
       {{"type", {12}},
        {"netId", {300}},
        {"seq", {7}},
        {"rows", {2}},
        {"cols", {3}},
        {"size", {6}},
        {"weights", mostly_zero(92, {{0, 0x12}, {91, 255}})}},
       padded("0c 012c 0007 02 03 06 12", 90, "ff")},
      {"LearningModuleFloatCmd",
       0x15,
       {{"type", {22}},
        {"netId", {1}},
        {"seq", {2}},
        {"rows", {1}},
        {"cols", {1}},
        {"size", {4}},
        {"floats", mostly_zero(23, {{0, 1}, {22, -1.5}})}},
       padded("16 0001 0002 01 01 04 0000803f", 84, "0000c0bf")},
      {"LearningModuleDown",
       0x18,
       {{"type", {24}}, {"netId", {300}}, {"size", {23}}, {"floats", mostly_zero(23, {{1, 0.75}})}},
       padded("18 012c 17 00000000 0000403f", 84, "")},
      {"LearningOutput",
       0x19,
       {{"type", {25}}, {"count", {2}}, {"floats", {0.75, -1.5}}},
       padded("19 02 0000403f 0000c0bf", 88, "")},
      {"Connless",
       0x1b,
       {{"type", {1}},
        {"island", {11}},
        {"mote", {2}},
        {"reliable", {1}},
        {"seq", {0x1234}},
        {"nbytes", {4}},
        {"payload", std::vector<double>(100, 170)}},
       hex("01 0b 0002 01 1234 04") + Bytes(100, 0xaa)},
      {"RAddr", 0x1f, {{"pid", {11}}, {"devid", {65533}}}, hex("000b fffd")},
      {"Complete",
       0x21,
       {{"destIsland", {11}},
        {"destMote", {2}},
        {"srcIsland", {11}},
        {"srcMote", {65533}},
        {"reliable", {0}},
        {"seq", {0x1234}},
        {"nbytes", {7}},
        {"transId", {3}},
        {"appId", {5}},
        {"type", {1}},
        {"mask", {0x43}},
        {"period", {1000}}},
       hex("000b 0002 000b fffd 00 1234 07 03 05 01 0043 03e8")},
  };
}

/// A record of each layout of wsn.md 7.2, the bytes put together by hand.
std::vector<Layout> layouts() {
  auto all = command_layouts();
  for (auto& layout : other_layouts()) all.push_back(std::move(layout));
  return all;
}

TEST(LearningRecords, EveryLayoutHasTheBytesComputedByHand) {
  for (const Layout& layout : layouts()) EXPECT_EQ(encoded(layout.name, layout.values), base::to_hex(layout.bytes));
  EXPECT_EQ(layouts().size(), learning_records().size()) << "a layout without a test";
}

TEST(LearningRecords, EveryLayoutIsReadBackAndTheStaleBytesBehindItIgnored) {
  for (const Layout& layout : layouts()) {
    const auto values = decode_learning(layout.type, layout.bytes);
    ASSERT_TRUE(values.has_value()) << values.error().text;
    EXPECT_EQ(*values, layout.values) << layout.name;
    const auto padded_values = decode_learning(layout.type, layout.bytes + hex("beef0064"));
    ASSERT_TRUE(padded_values.has_value()) << layout.name;
    EXPECT_EQ(*padded_values, layout.values) << layout.name;
  }
}

TEST(LearningRecords, FieldsLieBehindEachOtherAndFillTheirRecord) {
  std::set<std::string_view> names;
  std::set<int> types;
  for (const LearningRecord& record : learning_records()) {
    EXPECT_TRUE(names.insert(record.name).second && types.insert(record.type).second) << record.name;
    std::size_t end = 0;
    for (const RecordField& field : record.fields) {
      EXPECT_EQ(field.offset, end) << record.name << " " << field.name;
      const std::size_t size = field.kind == FieldKind::kFloat ? 4 : field.kind == FieldKind::kU16 ? 2 : 1;
      end += size * field.count;
      EXPECT_TRUE(field.counted_by.empty() || record.find(field.counted_by) != nullptr);
    }
    EXPECT_EQ(record.size, end) << record.name;
    EXPECT_LE(record.size, 108u) << record.name;
  }
}

TEST(LearningRecords, ADecimalBecomesTheNearestFloatLittleEndian) {
  EXPECT_EQ(encoded("LearningOutput", {{"floats", {0.1}}}).substr(0, 12), "1901cdcccc3d");
  const auto values = decode_learning(0x19, hex("1901cdcccc3d"));
  ASSERT_TRUE(values.has_value());
  EXPECT_EQ(values->at("floats"), std::vector<double>{0.1F});
}

TEST(LearningRecords, AnOutputIsReadWithoutThePaddingBehindItsFloats) {
  const auto values = decode_learning(0x19, hex("19 02 0000403f 0000c0bf"));
  ASSERT_TRUE(values.has_value());
  EXPECT_THAT(values->at("floats"), ElementsAre(0.75, -1.5));
  EXPECT_THAT(decode_learning(0x19, hex("19 00"))->at("floats"), testing::IsEmpty());
}

TEST(LearningRecords, CountsAndOwnTypesMayBeLeftOut) {
  EXPECT_EQ(encoded("LearningOutput", {{"floats", {0.75, -1.5}}}),
            base::to_hex(padded("19 02 0000403f 0000c0bf", 88, "")));
  EXPECT_EQ(encoded("LearningOutput", {}), base::to_hex(padded("19", 97, "")));
  EXPECT_EQ(encoded("LearningModuleCmd",
                    {{"type", {13}}, {"netId", {1}}, {"seq", {2}}, {"rows", {3}}, {"cols", {4}}, {"size", {0}}}),
            base::to_hex(padded("0d 0001 0002 03 04 00", 92, "")));
}

TEST(LearningRecords, NamesAreKnownWithAndWithoutMsg) {
  EXPECT_EQ(find_learning_record("NetIdCmdMsg"), find_learning_record("NetIdCmd"));
  EXPECT_EQ(find_learning_record("CommandMsg")->type, 0x0b);
  EXPECT_EQ(find_learning_record("netidcmd"), nullptr);
  EXPECT_EQ(find_learning_record(""), nullptr);
}

TEST(LearningRecords, WhatDoesNotFitIsRefusedWithRecordFieldAndRange) {
  FieldValues values{{"command", {1}}, {"netId", {300}}, {"seq", {7}}};
  const auto with = [&](std::string_view field, std::vector<double> numbers) {
    FieldValues changed = values;
    changed.insert_or_assign(std::string(field), std::move(numbers));
    return encoded("NetIdCmd", changed);
  };
  EXPECT_EQ(with("netId", {65536}), "mote record NetIdCmd: netId is 65536, expected a whole number from 0 to 65535");
  EXPECT_EQ(with("netId", {-1}), "mote record NetIdCmd: netId is -1, expected a whole number from 0 to 65535");
  EXPECT_EQ(with("command", {1.5}), "mote record NetIdCmd: command is 1.5, expected a whole number from 0 to 255");
  EXPECT_EQ(with("command", {std::nan("")}),
            "mote record NetIdCmd: command is nan, expected a whole number from 0 to 255");
  EXPECT_EQ(with("netId", {}), "mote record NetIdCmd: netId has 0 elements, expected one number");
  EXPECT_EQ(with("netId", {1, 2}), "mote record NetIdCmd: netId has 2 elements, expected one number");
  EXPECT_EQ(with("clock", {1}), "mote record NetIdCmd: unknown field \"clock\", expected command, netId, seq");
  values.erase("seq");
  EXPECT_EQ(encoded("NetIdCmd", values), "mote record NetIdCmd: seq is missing, expected a number from 0 to 65535");
  EXPECT_EQ(encoded("Nonsense", {}), "unknown mote record \"Nonsense\"");
}

TEST(LearningRecords, ArraysAreBoundedAndTheirCountMustBeTrue) {
  EXPECT_EQ(encoded("LearningOutput", {{"floats", std::vector<double>(25)}}),
            "mote record LearningOutput: floats has 25 elements, expected at most 24");
  EXPECT_EQ(encoded("LearningOutput", {{"count", {3}}, {"floats", {1, 2}}}),
            "mote record LearningOutput: count is 3, expected 2, the number of elements");
  EXPECT_THAT(encoded("LearningOutput", {{"floats", {1e39}}}),
              HasSubstr("floats is 1e+39, expected a number from -3.4"));
  EXPECT_THAT(encoded("LearningOutput", {{"floats", {std::nan("")}}}), HasSubstr("floats is nan"));
  EXPECT_THAT(encoded("SynCreateCmd", {{"srcNeurons", std::vector<double>(11)}}), HasSubstr("type is missing"));
  EXPECT_EQ(encoded("SynData", {{"floats", std::vector<double>(11)}}),
            "mote record SynData: floats has 11 elements, expected at most 10");
}

TEST(LearningRecords, APrefixIsReadOnlyWhereAnArrayEndsIt) {
  for (const Layout& layout : layouts()) {
    const RecordField& last = find_learning_record(layout.type)->fields.back();
    for (std::size_t length = 0; length < layout.bytes.size(); ++length) {
      const auto values = decode_learning(layout.type, ByteView(layout.bytes).first(length));
      const bool enough = last.is_array() && length >= last.offset + (last.counted_by.empty() ? 0 : 8);
      ASSERT_EQ(values.has_value(), enough) << layout.name << " " << length;
      if (values) continue;
      EXPECT_THAT(values.error().text, HasSubstr("mote record " + layout.name + ": cut short in "));
    }
  }
}

TEST(LearningRecords, ACountBeyondItsArrayIsRefused) {
  EXPECT_EQ(decode_learning(0x19, padded("19 19", 96, "")).error().text,
            "mote record LearningOutput: count is 25, expected at most 24");
  Bytes create = layouts()[5].bytes;
  create[13] = 11;
  EXPECT_EQ(decode_learning(0x13, create).error().text,
            "mote record SynCreateCmd: srcCount is 11, expected at most 10");
}

TEST(LearningRecords, AnyBytesAreSurvivedByEveryLayout) {
  std::mt19937 random(7);
  for (int round = 0; round < 5000; ++round) {
    Bytes bytes(random() % 120);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const auto type = static_cast<std::uint8_t>(random() % 40);
    const auto values = decode_learning(type, bytes);
    if (!values) continue;
    for (const auto& [name, numbers] : *values)
      EXPECT_LE(numbers.size(), find_learning_record(type)->find(name)->count);
  }
}

const LearningRecord* found_in(std::uint16_t to, std::uint8_t transport, std::uint8_t application, const Bytes& bytes) {
  return learning_record_in({11, to, 11, 5, 0, 1, 0, transport, application, bytes});
}

TEST(LearningRecords, AreKnownByTheirFirstByteAndDirection) {
  const auto name = [](const LearningRecord* record) { return record != nullptr ? record->name : "none"; };
  EXPECT_EQ(name(found_in(5, 3, 6, hex("01012cbeef"))), "NetIdCmd");
  EXPECT_EQ(name(found_in(5, 3, 6, hex("1901"))), "NetIdCmd") << "a command to a mote: ONLINE_INCR_FEEDBACK";
  EXPECT_EQ(name(found_in(kBaseMote, 3, 6, hex("1901"))), "LearningOutput");
  EXPECT_EQ(name(found_in(kBaseMote, 3, 6, hex("18"))), "LearningModuleDown");
  EXPECT_EQ(name(found_in(kBaseMote, 3, 6, hex("01"))), "none");
  EXPECT_EQ(name(found_in(kBroadcast, 3, 6, hex("0801f40007"))), "BroadcastCmd");
  for (const char* first : {"09", "0a", "0b"}) EXPECT_EQ(name(found_in(5, 3, 6, hex(first))), "SynCreateCmd");
  for (const char* first : {"0c", "10", "12", "14", "16", "1c"})
    EXPECT_EQ(name(found_in(5, 3, 6, hex(first))), "LearningModuleCmd");
  for (const char* first : {"00", "1d", "ff"}) EXPECT_EQ(name(found_in(5, 3, 6, hex(first))), "none");
  EXPECT_EQ(name(found_in(5, 1, 11, hex("00"))), "SynData");
  EXPECT_EQ(name(found_in(5, 3, 5, hex("01"))), "none");
  EXPECT_EQ(name(found_in(5, 3, 6, {})), "none");
}

TEST(LearningRecords, AMatrixIsCutIntoChunksAndAnExactMultipleEndsWithAnEmptyOne) {
  const std::map<std::size_t, std::vector<std::size_t>> expected{
      {0, {0}}, {1, {1}}, {91, {91}}, {92, {92, 0}}, {93, {92, 1}}, {184, {92, 92, 0}}, {200, {92, 92, 16}}};
  for (const auto& [size, sizes] : expected) {
    Bytes matrix(size);
    for (std::size_t i = 0; i < size; ++i) matrix[i] = static_cast<std::uint8_t>(i);
    std::vector<std::size_t> found;
    Bytes again;
    for (const ByteView chunk : matrix_chunks(matrix)) {
      found.push_back(chunk.size());
      again.insert(again.end(), chunk.begin(), chunk.end());
    }
    EXPECT_EQ(found, sizes) << size;
    EXPECT_EQ(again, matrix) << size;
  }
}

}  // namespace
}  // namespace rubicon::motes
