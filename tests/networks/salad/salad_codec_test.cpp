#include "networks/salad/salad_codec.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace rubicon::networks::salad {
namespace {

std::string unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\') {
      out += text[i];
    } else if (text[++i] == 'x') {
      out += static_cast<char>(base::from_hex(text.substr(i + 1, 2)).value().front());
      i += 2;
    } else {
      out += text[i] == 'n' ? '\n' : text[i] == 'r' ? '\r' : text[i] == 't' ? '\t' : text[i];
    }
  }
  return out;
}

struct Case {
  std::string datagram, readings, faults;
  std::size_t buffer = 0;
  int line = 0;
};

std::vector<Case> cases() {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/salad/datagrams.tsv");
  std::vector<Case> all;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.empty() || line.starts_with("# ")) continue;
    std::istringstream columns(line);
    Case one;
    std::string buffer;
    std::getline(columns, one.datagram, '\t');
    std::getline(columns, buffer, '\t');
    std::getline(columns, one.readings, '\t');
    std::getline(columns, one.faults, '\t');
    one.datagram = one.datagram == "-" ? "" : unescaped(one.datagram);
    one.buffer = std::stoul(buffer);
    one.line = number;
    all.push_back(one);
  }
  return all;
}

class SaladDatagram : public ::testing::TestWithParam<Case> {};

TEST_P(SaladDatagram, GivesItsReadingsAndItsFaults) {
  const auto read = read_datagram(base::as_bytes(GetParam().datagram), GetParam().buffer);
  std::string readings, faults;
  for (const auto& item : read.items)
    readings += fmt::format("{}{}={}", readings.empty() ? "" : " ", item.id, model::to_text(item.value));
  for (const auto& [fault, times] : read.faults)
    faults += fmt::format("{}{}:{}", faults.empty() ? "" : " ", to_string(fault).substr(8), times);
  EXPECT_EQ(readings.empty() ? "-" : readings, GetParam().readings);
  EXPECT_EQ(faults.empty() ? "-" : faults, GetParam().faults);
}

INSTANTIATE_TEST_SUITE_P(Line, SaladDatagram, ::testing::ValuesIn(cases()),
                         [](const auto& one) { return std::to_string(one.param.line); });

TEST(SaladRequest, TheStartDatagramIsTheMeasuredOne) {
  EXPECT_EQ(base::to_hex(base::as_bytes(kStartUpdates)), "2353414c414423303a313a323a3023454e4423");
  EXPECT_EQ(kStopUpdates, "#SALAD#0:0:2:0#END#");
}

TEST(SaladRequest, ACommandIsTheMeasuredOne) {
  EXPECT_EQ(actuate("1/1/1", 1), "#SALAD#2:1/1/1:1:0#END#");
  EXPECT_EQ(actuate("LG", 10), "#SALAD#2:LG:10:0#END#");
  EXPECT_EQ(actuate("LG", -7), "#SALAD#2:LG:-7:0#END#");
}

TEST(SaladRequest, IsReadAtTheOtherEnd) {
  EXPECT_EQ(read_request(base::as_bytes(kStartUpdates))->kind, Request::Kind::kStart);
  EXPECT_EQ(read_request(base::as_bytes(kStopUpdates))->kind, Request::Kind::kStop);
  const auto command = read_request(base::as_bytes("#SALAD#2:1/1/1:-10:0#END#"));
  ASSERT_TRUE(command);
  EXPECT_EQ(command->actuator, "1/1/1");
  EXPECT_EQ(command->value, -10);
  for (const auto* text : {"", "#SALAD#", "#SALAD#:0#END#", "#SALAD#2:LG:0#END#", "#SALAD#2:LG:x:0#END#",
                           "#SALAD#3:LG:1:0#END#", "#SALAD#2:LG:1:0", "#SALAD#0:2:2:0#END#", "SALAD"}) {
    EXPECT_FALSE(read_request(base::as_bytes(text))) << text;
  }
}

TEST(SaladRequest, WhatIsWrittenIsReadBack) {
  const std::vector<Item> items{{1, std::int64_t{1}}, {13, 0.5}, {65535, std::int64_t{-4}}};
  const auto text = write_datagram(items);
  EXPECT_EQ(text, "#SALADST#1;1:13;0.5:65535;-4#END#");
  EXPECT_EQ(read_datagram(base::as_bytes(text), 2048).items, items);
}

}  // namespace
}  // namespace rubicon::networks::salad
