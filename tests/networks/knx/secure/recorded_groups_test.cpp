#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include "base/text.h"
#include "networks/knx/secure/guard_bench.h"

namespace rubicon::networks::knx::secure {
namespace {

using Drop = GroupGuard::Drop;
using wire::CemiCode;

constexpr const char* kKeyOf127 = "74aaab666da92fde085e6c6ee65bb69b";
constexpr const char* kKeyOf201 = "1ae100e83d88ab1989042186c7ccb11e";

using Row = std::vector<std::string>;

/// The rows of a recorded session; empty if it is not beside the source tree.
std::vector<Row> rows_of(const std::string& name) {
  std::ifstream file(shared_data("knx-secure/secure/" + name));
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    Row row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, '\t');) row.push_back(cell);
    row.resize(7);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The cEMI frame of a TUNNELLING_REQUEST.
Bytes cemi_of(const std::string& request) {
  return hex(request.substr(20));
}

std::string field(const std::string& note, const std::string& name) {
  const auto at = note.find(name + "=");
  if (at == note.npos) return {};
  const auto from = at + name.size() + 1;
  return note.substr(from, note.find(' ', from) - from);
}

GroupKeys recorded_keys() {
  auto keys = one_group(key_of(kKeyOf127));
  keys.groups[wire::GroupAddress(0x1001)] = {key_of(kKeyOf201), {kOwn, kOther, wire::IndividualAddress(0x110c)}};
  return keys;
}

/// Sends the telegram of a recorded frame again, with the same sequence number.
std::string protected_again(const Bytes& cemi, const GroupGuard::Peeked& peeked) {
  GuardBench bench;
  bench.time.set_wall({});
  bench.disk.store_own(peeked.sequence - 1);
  auto& guard = bench.start(recorded_keys(), peeked.telegram.source);
  return base::to_hex(guard.protect(CemiCode(cemi[0]), peeked.telegram, peeked.telegram.source).value());
}

/// Two tunnels; each hears what the other sends.
struct Ends {
  Ends() {
    first.start(recorded_keys(), kOwn);
    second.start(recorded_keys(), kOther);
  }
  GroupGuard& receiver_of(const wire::DataFrame& frame) { return *(frame.source == kOwn ? second : first).guard; }
  GuardBench first, second;
};

TEST(RecordedGroups, IntermediateValuesAreReproduced) {
  Ccm ccm;
  std::size_t checked = 0;
  for (const auto& row : rows_of("data-secure-group.tsv")) {
    const auto& note = row[4].empty() ? row[3] : row[4];
    if (field(note, "ds_apdu").empty()) continue;
    const auto apdu = hex(field(note, "ds_apdu"));
    wire::DataFrame frame;
    frame.source = wire::IndividualAddress(*base::parse_hex_number<std::uint16_t>(field(note, "ds_src")));
    frame.destination = *base::parse_hex_number<std::uint16_t>(field(note, "ds_dst"));
    frame.tpdu = apdu;
    const auto scf = *base::parse_hex_number<std::uint8_t>(field(note, "ds_scf"));
    const auto sequence = *base::parse_number<std::uint64_t>(field(note, "ds_sequence"));
    const auto sealed = seal(ccm, key_of(kKeyOf127), frame, scf, sequence);
    EXPECT_EQ(base::to_hex(*sealed), field(note, "ds_tpdu"));
    ++checked;
  }
  if (checked == 0) GTEST_SKIP() << "no ../shared/data/knx-secure beside the source tree";
  EXPECT_EQ(checked, 8U);
}

TEST(RecordedGroups, GoodTelegramsAreOpenedSentAgainByteForByteAndConfirmed) {
  Ends ends;
  std::size_t received = 0, sent = 0;
  Bytes request;
  for (const auto& row : rows_of("data-secure-group.tsv")) {
    if (row[1] != "plain" || row[2] != "TUNNELLING_REQUEST") continue;
    const auto cemi = cemi_of(row[3]);
    const auto frame = wire::read_data_frame(cemi).value();
    const auto peeked = ends.first.guard->peek(frame);
    ASSERT_TRUE(peeked) << row[3];
    if (frame.code == CemiCode::kDataRequest) request = cemi;
    if (frame.code == CemiCode::kDataConfirmation) {
      EXPECT_TRUE(wire::confirms(cemi, request)) << row[3];
    }
    if (frame.tpdu[2] == control::kEncrypted) {
      EXPECT_EQ(protected_again(cemi, *peeked), base::to_hex(cemi));
      ++sent;
    }
    if (frame.code != CemiCode::kDataIndication) continue;
    const auto telegram = ends.receiver_of(frame).open(frame);
    ASSERT_TRUE(telegram) << telegram.error().why;
    EXPECT_EQ(*telegram, peeked->telegram);
    ++received;
  }
  if (received == 0) GTEST_SKIP() << "no ../shared/data/knx-secure beside the source tree";
  EXPECT_EQ(received, 8U);
  EXPECT_EQ(sent, 21U);
}

struct Verdict {
  const char* label;
  std::optional<Drop> drop;
};
const Verdict kVerdicts[]{{"good", std::nullopt},
                          {"replay: same sequence", Drop::kOldSequence},
                          {"older sequence", Drop::kOldSequence},
                          {"wrong group key", Drop::kWrongMac},
                          {"MAC changed", Drop::kWrongMac},
                          {"plain write to a secured group", Drop::kPlain},
                          {"tool access bit", Drop::kToolAccess}};

TEST(RecordedGroups, EachRefusedTelegramIsDroppedForItsReason) {
  Ends ends;
  std::string label;
  std::size_t checked = 0;
  for (const auto& row : rows_of("data-secure-refused.tsv")) {
    if (row[1] == "C") label = row[4];
    if (row[1] != "plain" || row[2] != "TUNNELLING_REQUEST") continue;
    const auto cemi = cemi_of(row[3]);
    if (cemi[0] != 0x29) continue;
    const auto verdict = std::find_if(std::begin(kVerdicts), std::end(kVerdicts),
                                      [&](const auto& one) { return label.starts_with(one.label); });
    ASSERT_NE(verdict, std::end(kVerdicts)) << label;
    const auto result = ends.second.guard->open(wire::read_data_frame(cemi).value());
    EXPECT_EQ(result.has_value(), !verdict->drop) << label;
    if (!result && verdict->drop) {
      EXPECT_EQ(result.error().drop, *verdict->drop) << label << result.error().why;
    }
    ++checked;
  }
  if (checked == 0) GTEST_SKIP() << "no ../shared/data/knx-secure beside the source tree";
  EXPECT_EQ(checked, 8U);
  EXPECT_EQ(ends.second.count("data-secure-received"), 2U);
  EXPECT_EQ(ends.second.count("data-secure-old"), 2U);
  EXPECT_EQ(ends.second.count("data-secure-wrong-mac"), 2U);
}

TEST(RecordedGroups, TelegramsOfAnotherClientAreOpenedAndMadeByteForByte) {
  Ends ends;
  std::size_t secured = 0, plain = 0;
  for (const auto& row : rows_of("xknx-sessions.tsv")) {
    if (!row[3].ends_with("TUNNELLING_REQUEST")) continue;
    const auto cemi = cemi_of(row[5]);
    const auto frame = wire::read_data_frame(cemi).value();
    const auto peeked = ends.first.guard->peek(frame);
    ASSERT_TRUE(peeked) << row[5];
    if (peeked->secured) {
      EXPECT_EQ(protected_again(cemi, *peeked), base::to_hex(cemi));
    }
    if (frame.code != CemiCode::kDataIndication) continue;
    const auto telegram = ends.receiver_of(frame).open(frame);
    ASSERT_TRUE(telegram) << telegram.error().why;
    ++(peeked->secured ? secured : plain);
  }
  if (secured == 0) GTEST_SKIP() << "no ../shared/data/knx-secure beside the source tree";
  EXPECT_EQ(secured, 10U);
  EXPECT_EQ(plain, 1U) << "to a group without a key";
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
