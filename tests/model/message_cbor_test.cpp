#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "model/cbor_messages.h"

namespace rubicon::model {
namespace {

using testing::HasSubstr;

Bytes hex(std::string_view text) {
  auto bytes = base::from_hex(text);
  EXPECT_TRUE(bytes) << text;
  return bytes.value_or(Bytes{});
}

Message back(const Message& message) {
  auto read = from_cbor(to_cbor(message));
  EXPECT_TRUE(read) << read.error().text;
  return read.value_or(Message{});
}

Value value_back(const Value& value) {
  const auto message = back(message_with(Actuate{1, {Kind::kActuator, TypeId{2}, "1"}, value}));
  return std::get<Actuate>(message.body).value;
}

/// The error text for a message whose form is given as JSON.
std::string refusal(const nlohmann::json& form) {
  const auto read = from_cbor(nlohmann::json::to_cbor(form));
  return read ? "accepted" : read.error().text;
}

nlohmann::json form_of(std::string_view kind, nlohmann::json body) {
  return {{"v", 1}, {"origin", 5}, {"to", {{"island", 12}}}, {"kind", kind}, {"body", std::move(body)}};
}

// Golden bytes: RFC 8949 by hand, keys sorted.
constexpr std::string_view kGoldenJoin =
    "a8 64626f6479 a3"                                                   // body: map of 3
    "6c6361706162696c6974696573 81 a9"                                   // capabilities: one map of 9
    "66616363657373 6472656164 6b646561646c696e652d6d73 190bb8"          // access read, deadline-ms 3000
    "67696e697469616c 24 68696e7374616e6365 6677696e646f77"              // initial -5, instance window
    "646b696e64 6673656e736f72 636d6178 fa44e6f000 636d696e fa00000000"  // kind sensor, max 1847.5, min 0.0
    "6474797065 01 64756e6974 626c78"                                    // type 1, unit lx
    "656865617264 f5 646e616d65 674b69746368656e"                        // heard true, name Kitchen
    "6466726f6d a3 66646576696365 6137 6669736c616e64 19198d 676e6574776f726b 6577736e2d31"  // from 6541/wsn-1/7
    "64686f7073 01 646b696e64 646a6f696e 666e756d626572 07 666f726967696e 19198d"  // hops, kind join, number, origin
    "62746f a1 6669736c616e64 0c 6176 01";                                         // to 12, v 1

constexpr std::string_view kGoldenUpdates =
    "a8 64626f6479 a1 687265616469 6e6773 82"                                             // body: readings, two
    "a5 68696e7374616e6365 6131 646b696e64 6673656e736f72"                                // instance 1, kind sensor
    "6774696d652d7573 1b00060a24181e4000 6474797065 02 6576616c7565 fb40357ae147ae147b"   // time-us, type 2, 21.48
    "a4 68696e7374616e6365 6131 646b696e64 6673656e736f72 6474797065 0a 6576616c7565 f5"  // motion true
    "6466726f6d a3 66646576696365 6137 6669736c616e64 19198d 676e6574776f726b 6577736e2d31"
    "64686f7073 01 646b696e64 6775706461746573 666e756d626572 07 666f726967696e 19198d"
    "62746f a1 6669736c616e64 0c 6176 01";

constexpr std::string_view kGoldenActuate =
    "a8 64626f6479 a5 68696e7374616e6365 6131 646b696e64 686163747561746f72"  // instance 1, kind actuator
    "6772657175657374 18c8 6474797065 190219 6576616c7565 183c"               // request 200, type 0x219, value 60
    "6466726f6d a3 66646576696365 6137 6669736c616e64 19198d 676e6574776f726b 6577736e2d31"
    "64686f7073 01 646b696e64 6761637475617465 666e756d626572 07 666f726967696e 19198d"
    "62746f a1 6669736c616e64 0c 6176 01";

constexpr std::string_view kGoldenOpaque =
    "a8 64626f6479 a2 656279746573 4568656c6c6f 6474797065 6463686174"              // bytes hello, type chat
    "6466726f6d a1 6669736c616e64 00 64686f7073 00 646b696e64 666f7061717565"       // from 0, hops 0, kind opaque
    "666e756d626572 00 666f726967696e 00 62746f a1 6669736c616e64 19198d 6176 01";  // number, origin 0, to 6541, v 1

constexpr std::string_view kGoldenUnreachable =
    "a8 64626f6479 a1 66726561736f6e 696e6f20616e73776572"                                   // body: reason "no answer"
    "6466726f6d a3 66646576696365 6137 6669736c616e64 19198d 676e6574776f726b 6577736e2d31"  // from 6541/wsn-1/7
    "64686f7073 01 646b696e64 6b756e726561636861626c65 666e756d626572 07 666f726967696e 19198d"
    "62746f a1 6669736c616e64 0c 6176 01";

constexpr std::string_view kGoldenRelayed =
    "a9 64626f6479 a2 656279746573 4568656c6c6f 6474797065 6463686174"       // bytes hello, type chat
    "6466726f6d a1 6669736c616e64 1a00011170 64686f7073 01"                  // from component 70000, hops 1
    "646b696e64 666f7061717565 666e756d626572 00 666f726967696e 1a00011170"  // kind opaque, number 0, origin 70000
    "6673656e646572 a3 6669736c616e64 02 646e616d65 65726f626f74"            // sender: island 2, name robot
    "65726f6c6573 81 6570616e656c"                                           // roles [panel]
    "62746f a1 6669736c616e64 19198d 6176 01";                               // to 6541, v 1

Message golden_relayed() {
  Message message{
      OwnerId{70000}, 0, 1, {OwnerId{70000}, "", ""}, {kHome, "", ""}, Opaque{"chat", {'h', 'e', 'l', 'l', 'o'}}};
  message.sender = Sender{"robot", {"panel"}, OwnerId{2}};
  return message;
}

Message golden_join() {
  auto light = light_capability();
  light.type_name.clear();
  return message_with(Join{"", "Kitchen", "", {light}, true});
}

Message golden_updates() {
  const WallTime when{std::chrono::microseconds(1'700'000'000'000'000)};
  return message_with(
      Updates{{{{Kind::kSensor, TypeId{2}, "1"}, 21.48, when}, {{Kind::kSensor, TypeId{0x00a}, "1"}, true, {}}}});
}

Message golden_actuate() {
  return message_with(Actuate{200, {Kind::kActuator, TypeId{0x219}, "1"}, std::int64_t{60}});
}

Message golden_opaque() {
  return {kNoOwner, 0, 0, {}, {kHome, "", ""}, Opaque{"chat", {'h', 'e', 'l', 'l', 'o'}}};
}

TEST(MessageCbor, WritesTheGoldenBytes) {
  EXPECT_EQ(base::to_hex(to_cbor(golden_join())), base::to_hex(hex(kGoldenJoin)));
  EXPECT_EQ(base::to_hex(to_cbor(golden_updates())), base::to_hex(hex(kGoldenUpdates)));
  EXPECT_EQ(base::to_hex(to_cbor(golden_actuate())), base::to_hex(hex(kGoldenActuate)));
  EXPECT_EQ(base::to_hex(to_cbor(golden_opaque())), base::to_hex(hex(kGoldenOpaque)));
  EXPECT_EQ(base::to_hex(to_cbor(message_with(Unreachable{"no answer"}))), base::to_hex(hex(kGoldenUnreachable)));
}

TEST(MessageCbor, ARelayedMessageNamesItsSender) {
  EXPECT_EQ(base::to_hex(to_cbor(golden_relayed())), base::to_hex(hex(kGoldenRelayed)));
  EXPECT_EQ(from_cbor(hex(kGoldenRelayed))->sender, golden_relayed().sender);
  EXPECT_FALSE(back(golden_opaque()).sender);
}

TEST(MessageCbor, ASenderWithoutNameOrWithLongOrManyRolesIsRefused) {
  const auto with = [](nlohmann::json sender) {
    auto form = form_of("keepalive", nlohmann::json::object());
    form["sender"] = std::move(sender);
    return refusal(form);
  };
  EXPECT_EQ(with({{"name", "robot"}, {"roles", {"panel"}}}), "accepted");
  EXPECT_THAT(with({{"roles", {"panel"}}}), HasSubstr("sender.name: expected the name of a member"));
  EXPECT_THAT(with({{"name", std::string(65, 'x')}}), HasSubstr("sender.name: expected a text of at most 64 bytes"));
  EXPECT_THAT(with({{"name", "robot"}, {"roles", "panel"}}), HasSubstr("sender.roles: expected a list"));
  EXPECT_THAT(with({{"name", "robot"}, {"roles", {""}}}), HasSubstr("sender.roles"));
  EXPECT_THAT(with({{"name", "robot"}, {"roles", std::vector<std::string>(33, "panel")}}), HasSubstr("sender.roles"));
  EXPECT_THAT(with("robot"), HasSubstr("sender is not a map"));
}

TEST(MessageCbor, ReadsTheGoldenBytes) {
  const auto join = from_cbor(hex(kGoldenJoin));
  ASSERT_TRUE(join) << join.error().text;
  EXPECT_EQ(join->source, (Address{kHome, "wsn-1", "7"}));
  const auto& capability = std::get<Join>(join->body).capabilities.at(0);
  EXPECT_EQ(capability.maximum, 1847.5);
  EXPECT_EQ(capability.deadline, Duration(std::chrono::seconds(3)));

  const auto updates = from_cbor(hex(kGoldenUpdates));
  ASSERT_TRUE(updates) << updates.error().text;
  const auto& readings = std::get<Updates>(updates->body).readings;
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings[0].value, Value(21.48));
  EXPECT_EQ(base::to_seconds(readings[0].user_time), 1.7e9);
  EXPECT_EQ(readings[1].value, Value(true));
  EXPECT_EQ(readings[1].user_time, WallTime{});

  const auto actuate = from_cbor(hex(kGoldenActuate));
  ASSERT_TRUE(actuate) << actuate.error().text;
  EXPECT_EQ(std::get<Actuate>(actuate->body).request, 200U);
  EXPECT_EQ(std::get<Actuate>(actuate->body).value, Value(std::int64_t{60}));

  const auto unreachable = from_cbor(hex(kGoldenUnreachable));
  ASSERT_TRUE(unreachable) << unreachable.error().text;
  EXPECT_EQ(std::get<Unreachable>(unreachable->body).reason, "no answer");
}

TEST(MessageCbor, EveryKindComesBackAsItWas) {
  const auto messages = every_kind();
  ASSERT_EQ(messages.size(), std::variant_size_v<Body>);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const auto& sent = messages[i];
    const auto read = back(sent);
    EXPECT_EQ(read.kind(), static_cast<MessageKind>(i));
    EXPECT_EQ(read.origin, sent.origin);
    EXPECT_EQ(read.number, sent.number);
    EXPECT_EQ(read.hops, sent.hops);
    EXPECT_EQ(read.source, sent.source);
    EXPECT_EQ(read.destination, sent.destination);
    EXPECT_EQ(to_cbor(read), to_cbor(sent)) << to_string(sent.kind());
  }
}

TEST(MessageCbor, AJoinKeepsAllItsFields) {
  const auto read = back(every_kind()[0]);
  const auto& join = std::get<Join>(read.body);
  EXPECT_EQ(join.device_type, "mote");
  EXPECT_EQ(join.name, "Kitchen mote");
  EXPECT_EQ(join.model, "TelosB");
  EXPECT_FALSE(join.heard);
  EXPECT_EQ(join.id, "kitchen");
  EXPECT_EQ(join.problem, "interview failed");
  ASSERT_EQ(join.capabilities.size(), 3U);
  EXPECT_EQ(join.capabilities[0], light_capability());
  EXPECT_EQ(join.capabilities[1].access, Access::kReadWrite);
  EXPECT_FALSE(join.capabilities[1].reports);
  EXPECT_TRUE(join.capabilities[1].sampled);
  EXPECT_FALSE(join.capabilities[1].minimum);
  EXPECT_FALSE(join.capabilities[1].deadline);
  EXPECT_EQ(join.capabilities[2], open_capability());
}

TEST(MessageCbor, TheAreaOfADeviceTravels) {
  Join join;
  join.area = "First floor / Kitchen";
  EXPECT_EQ(std::get<Join>(back(message_with(join)).body).area, "First floor / Kitchen");
}

TEST(MessageCbor, WordsOfAPointAndWhatIsWrongWithAReadingTravel) {
  Capability mode = light_capability();
  mode.words = {{0, "auto"}, {20, "no demand"}};
  const auto joined = back(message_with(Join{"", "", "", {mode}, true}));
  EXPECT_EQ(std::get<Join>(joined.body).capabilities.at(0), mode);
  const auto updated = back(message_with(Updates{{{mode.point, {}, {}, "1 octet, expected 2"}}}));
  EXPECT_EQ(std::get<Updates>(updated.body).readings.at(0).why, "1 octet, expected 2");
  const auto refused = back(message_with(State{LineState::kRefused, "full", {}}));
  EXPECT_EQ(std::get<State>(refused.body).line, LineState::kRefused);
}

TEST(MessageCbor, AnOlderIslandsMessageIsOfAUsableDeviceThatWasHeard) {
  const auto join = from_cbor(hex(kGoldenJoin));
  const auto updates = from_cbor(hex(kGoldenUpdates));
  ASSERT_TRUE(join && updates);
  EXPECT_EQ(std::get<Join>(join->body).problem, "");
  EXPECT_EQ(std::get<Join>(join->body).capabilities.at(0).data, std::nullopt);
  EXPECT_EQ(std::get<Join>(join->body).capabilities.at(0).report, Report::kState);
  EXPECT_TRUE(std::get<Updates>(updates->body).heard);
}

TEST(MessageCbor, TheSmallerKindsKeepAllTheirFields) {
  const auto sent = every_kind();
  EXPECT_FALSE(std::get<Updates>(back(sent[3]).body).heard);
  EXPECT_EQ(std::get<Unreachable>(back(sent[11]).body).reason, "no answer to 3 pings");
  EXPECT_EQ(std::get<Leave>(back(sent[2]).body).reason, "battery empty");
  const auto sample_message = back(sent[5]);
  const auto& sample = std::get<Sample>(sample_message.body);
  EXPECT_EQ(sample.request, 3U);
  EXPECT_EQ(sample.points, std::get<Sample>(sent[5].body).points);
  EXPECT_EQ(sample.period, std::chrono::milliseconds(250));
  const auto acknowledge_message = back(sent[7]);
  const auto& acknowledge = std::get<Acknowledge>(acknowledge_message.body);
  EXPECT_EQ(acknowledge.request, 5U);
  EXPECT_EQ(acknowledge.outcome, Outcome::kUndeliverable);
  EXPECT_EQ(acknowledge.text, "no such island");
  const auto state_message = back(sent[8]);
  const auto& state = std::get<State>(state_message.body);
  EXPECT_EQ(state.line, LineState::kUp);
  EXPECT_EQ(state.reason, "opened");
  EXPECT_EQ(state.counters, std::get<State>(sent[8].body).counters);
  EXPECT_EQ(state.texts.at("server"), "hall");
  const auto opaque_message = back(sent[9]);
  EXPECT_EQ(std::get<Opaque>(opaque_message.body).type, "chat");
  EXPECT_EQ(std::get<Opaque>(opaque_message.body).bytes, (Bytes{0x00, 0xff, 0x68}));
}

TEST(MessageCbor, EveryValueComesBackAsItWas) {
  const Value values[] = {{},
                          true,
                          false,
                          std::int64_t{0},
                          std::int64_t{INT64_MIN},
                          std::int64_t{INT64_MAX},
                          0.1,
                          21.0,
                          -1e300,
                          std::numeric_limits<double>::denorm_min(),
                          std::string(),
                          std::string("gr\xc3\xbcn"),
                          Json{R"({"x":[1,2]})"}};
  for (const auto& value : values) EXPECT_EQ(value_back(value), value) << to_text(value);
}

TEST(MessageCbor, AValueThatIsNoNumberTravelsAsNothing) {
  EXPECT_EQ(value_back(std::numeric_limits<double>::quiet_NaN()), Value());
  EXPECT_EQ(value_back(std::numeric_limits<double>::infinity()), Value());
}

TEST(MessageCbor, AnInfiniteBoundTravelsAsNone) {
  auto light = light_capability();
  light.minimum = -std::numeric_limits<double>::infinity();
  const auto join = back(message_with(Join{"", "", "", {light}, true}));
  EXPECT_FALSE(std::get<Join>(join.body).capabilities.at(0).minimum);
}

TEST(MessageCbor, AShortDeadlineNeverTurnsIntoNever) {
  auto light = light_capability();
  light.deadline = std::chrono::microseconds(300);
  const auto join = back(message_with(Join{"", "", "", {light}, true}));
  EXPECT_EQ(std::get<Join>(join.body).capabilities.at(0).deadline, Duration(std::chrono::milliseconds(1)));
}

TEST(MessageCbor, ADeadlineOfAYearTravels) {
  auto light = light_capability();
  light.deadline = std::chrono::hours(24 * 366);
  const auto join = back(message_with(Join{"", "", "", {light}, true}));
  EXPECT_EQ(std::get<Join>(join.body).capabilities.at(0).deadline, light.deadline);
}

TEST(MessageCbor, EveryTruncationIsRefused) {
  for (const auto& message : every_kind()) {
    const auto whole = to_cbor(message);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_FALSE(from_cbor(ByteView(whole).first(length))) << to_string(message.kind()) << " cut to " << length;
    }
  }
}

TEST(MessageCbor, BytesBehindTheMessageAreRefused) {
  auto bytes = hex(kGoldenOpaque);
  bytes.push_back(0);
  EXPECT_FALSE(from_cbor(bytes));
}

TEST(MessageCbor, DeepNestingIsRefusedBeforeItIsParsed) {
  const auto read = from_cbor(Bytes(200'000, 0x81));
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().text,
            "message: not CBOR of definite lengths, text keys and at most 8 levels, at byte 10 of 200000");
}

TEST(MessageCbor, FormsThatTheFormDoesNotUseAreRefused) {
  const std::string_view forms[] = {"bf617601ff",                // map of indefinite length
                                    "a161767f6131ff",            // text of indefinite length
                                    "a161769f01ff",              // list of indefinite length
                                    "a16176c001",                // a tag
                                    "a10101",                    // a key that is no text
                                    "a16176f800",                // simple value in two bytes
                                    "a16176f7",                  // undefined
                                    "a161761c",                  // reserved length
                                    "a161763bffffffffffffffff",  // below -2^63
                                    "bbffffffffffffffff",
                                    "9b7fffffffffffffff",
                                    "5bffffffffffffffff00"};
  for (const auto form : forms) EXPECT_FALSE(from_cbor(hex(form))) << form;
}

TEST(MessageCbor, ANumberBelow64BitsDoesNotTurnIntoAnother) {
  auto form = base::to_hex(hex(kGoldenActuate));
  const std::string value = "6576616c7565183c";
  const auto at = form.find(value);
  ASSERT_NE(at, form.npos);
  form.replace(at, value.size(), "6576616c75653bffffffffffffffff");
  EXPECT_FALSE(from_cbor(hex(form)));
}

TEST(MessageCbor, AnErrorNamesTheFieldAndWhatWasExpected) {
  using nlohmann::json;
  EXPECT_EQ(refusal(json(5)), "message:  is not a map");
  EXPECT_EQ(refusal({{"v", 2}}), "message: v: expected version 1");
  EXPECT_EQ(refusal(json::object()), "message: v: expected version 1");
  EXPECT_EQ(refusal({{"v", 1}, {"origin", -1}}), "message: origin: expected a whole number from 0 to 4294967295");
  EXPECT_EQ(refusal({{"v", 1}, {"hops", 256}}), "message: hops: expected a whole number from 0 to 255");
  EXPECT_EQ(refusal({{"v", 1}, {"from", 3}}), "message: from is not a map");
  EXPECT_EQ(refusal({{"v", 1}, {"to", {{"device", 3}}}}), "message: to.device: expected a text of at most 255 bytes");
  EXPECT_EQ(refusal({{"v", 1}}), "message: kind: expected a known word");
  EXPECT_EQ(refusal(form_of("leave", {{"reason", std::string(4097, 'x')}})),
            "message: body.reason: expected a text of at most 4096 bytes");
  EXPECT_EQ(refusal(form_of("opaque", {{"bytes", "text"}})), "message: body.bytes: expected a byte string");
  EXPECT_EQ(refusal(form_of("state", {{"line", "sideways"}})), "message: body.line: expected a known word");
  EXPECT_EQ(refusal(form_of("state", {{"line", "up"}, {"counters", {{"a", -1}}}})),
            "message: body.counters: expected whole numbers from 0");
  EXPECT_EQ(refusal(form_of("state", {{"line", "up"}, {"texts", {{"a", 1}}}})),
            "message: body.texts: expected a map of names to texts of at most 64 KiB");
  EXPECT_EQ(refusal(form_of("state", {{"line", "up"}, {"counters", 1}})),
            "message: body.counters: expected a map of names to numbers");
}

TEST(MessageCbor, AnErrorInAListNamesTheEntry) {
  using nlohmann::json;
  const json good{{"kind", "sensor"}, {"type", 1}, {"instance", "1"}, {"value", 1.5}};
  auto bad = good;
  bad["type"] = 70000;
  EXPECT_EQ(refusal(form_of("updates", {{"readings", {good, bad}}})),
            "message: body.readings[1].type: expected a whole number from 0 to 65535");
  EXPECT_EQ(refusal(form_of("updates", {{"readings", {good, 5}}})), "message: body.readings[1] is not a map");
  EXPECT_EQ(refusal(form_of("updates", {{"readings", good}})),
            "message: body.readings: expected a list of at most 4096 maps");
  bad = good;
  bad["value"] = json::array({1});
  EXPECT_THAT(refusal(form_of("updates", {{"readings", {bad}}})), HasSubstr("body.readings[0].value: expected null"));
  bad["value"] = {{"json", "{broken"}};
  EXPECT_THAT(refusal(form_of("updates", {{"readings", {bad}}})), HasSubstr("body.readings[0].value: expected null"));
  bad["value"] = UINT64_MAX;
  EXPECT_EQ(refusal(form_of("updates", {{"readings", {bad}}})),
            "message: body.readings[0].value: expected a whole number of 64 bits");
  bad["value"] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(form_of("updates", {{"readings", {bad}}})),
            "message: body.readings[0].value: expected a finite number");
}

TEST(MessageCbor, AnErrorInACapabilityNamesTheField) {
  const auto with = [](const char* key, nlohmann::json value) {
    nlohmann::json capability{{"kind", "sensor"}, {"type", 1}, {"instance", "1"}};
    capability[key] = std::move(value);
    return refusal(form_of("join", {{"capabilities", {capability}}}));
  };
  const std::string at = "message: body.capabilities[0].";
  EXPECT_EQ(with("kind", "wheel"), at + "kind: expected sensor, actuator or property");
  EXPECT_EQ(with("access", "none"), at + "access: expected read, write or read-write");
  EXPECT_EQ(with("min", "low"), at + "min: expected a finite number");
  EXPECT_EQ(with("reports", 1), at + "reports: expected true or false");
  EXPECT_EQ(with("data", "number"), at + "data: expected a known word");
  EXPECT_EQ(with("report", "often"), at + "report: expected state or event");
  EXPECT_EQ(with("deadline-ms", -1), at + "deadline-ms: expected a whole number from 0 to 3200000000000");
}

TEST(MessageCbor, KeysOfNewerIslandsAreIgnored) {
  auto form = form_of("leave", {{"reason", "gone"}, {"farewell", {{"song", "yes"}}}});
  form["priority"] = 3;
  const auto read = from_cbor(nlohmann::json::to_cbor(form));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(std::get<Leave>(read->body).reason, "gone");
}

TEST(MessageCbor, BeyondTheBoundsIsRefused) {
  const auto big = from_cbor(to_cbor(message_with(Opaque{"film", Bytes(kMaxMessageBytes)})));
  ASSERT_FALSE(big);
  EXPECT_EQ(big.error().code, ErrorCode::kOutOfRange);
  EXPECT_THAT(big.error().text, HasSubstr("at most 262144 are allowed"));

  Sample many;
  many.points.assign(kMaxMessageEntries, {Kind::kSensor, TypeId{1}, "1"});
  EXPECT_TRUE(from_cbor(to_cbor(message_with(many))));
  many.points.push_back(many.points.front());
  EXPECT_FALSE(from_cbor(to_cbor(message_with(many))));
}

TEST(MessageCbor, TheThreeMediaTypesAreKnown) {
  EXPECT_TRUE(is_message_media_type("application/rubicon+cbor"));
  EXPECT_TRUE(is_message_media_type("rubicon/application"));
  EXPECT_TRUE(is_message_media_type("application/rubicon"));
  EXPECT_FALSE(is_message_media_type("application/cbor"));
  EXPECT_FALSE(is_message_media_type(""));
}

TEST(MessageCbor, ReadsWhatAScriptBuildsByHand) {
  const std::string command = "python3 " RUBICON_SOURCE_DIR "/tests/apps/rubicon-proxy/post_message.py 6541 chat hello";
  auto* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::array<char, 4096> buffer{};
  const auto size = std::fread(buffer.data(), 1, buffer.size(), pipe);
  ASSERT_EQ(pclose(pipe), 0);
  std::string_view line(buffer.data(), size);
  ASSERT_TRUE(line.starts_with("post ") && line.ends_with('\n')) << line;
  EXPECT_EQ(line.substr(5, line.size() - 6), base::to_hex(hex(kGoldenOpaque)));
  const auto read = from_cbor(hex(line.substr(5, line.size() - 6)));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->destination, (Address{kHome, "", ""}));
  EXPECT_EQ(base::as_text(std::get<Opaque>(read->body).bytes), "hello");
}

}  // namespace
}  // namespace rubicon::model
