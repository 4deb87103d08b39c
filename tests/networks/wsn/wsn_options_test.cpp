#include "networks/wsn/wsn_options.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "networks/wsn/mote_messages.h"
#include "support/config_text.h"

namespace rubicon::networks::wsn {
namespace {

using ::testing::HasSubstr;

struct Read {
  WsnOptions options;
  std::string errors;
};

Read read(std::string_view json, std::uint32_t island = 42, const std::string& directory = {}, bool closed = false) {
  const auto node = support::config_of(json);
  ConfigErrors errors;
  ConfigReader reader(node, "networks.wsn", errors);
  const TypeCatalogue types;
  Read out{read_wsn_options({.id = "wsn",
                             .island = IslandId{island},
                             .options = reader,
                             .types = types,
                             .directory = directory,
                             .closed = closed}),
           {}};
  reader.finish();
  out.errors = errors.text();
  return out;
}

TEST(WsnOptions, TheDefaultSourceIsTheForwarderOfTheOriginal) {
  const auto [options, errors] = read("{}");
  EXPECT_EQ(errors, "");
  EXPECT_EQ(to_string(options.source), "sf@localhost:9002");
  EXPECT_FALSE(options.share) << "a forwarder shares already";
}

TEST(WsnOptions, ASinkWithItsOwnLineIsSharedOnLoopback) {
  for (const auto* source : {"serial@/dev/ttyUSB0:telosb", "network@127.0.0.1:19202"}) {
    const auto [options, errors] = read(fmt::format(R"({{"source": "{}"}})", source));
    EXPECT_EQ(errors, "");
    ASSERT_TRUE(options.share);
    EXPECT_EQ(transport::to_string(options.share->listen), "127.0.0.1:9002");
    EXPECT_FALSE(options.share->may_configure);
  }
}

TEST(WsnOptions, OfAnIslandForMembersOnlyASinkIsSharedIfTheFileSaysSo) {
  EXPECT_FALSE(read(R"({"source": "serial@/dev/a:57600"})", 42, {}, true).options.share);
  EXPECT_TRUE(read(R"({"source": "serial@/dev/a:57600", "share": 9002})", 42, {}, true).options.share);
}

TEST(WsnOptions, ShareIsNoAPortOrAnAddressAndAPort) {
  EXPECT_FALSE(read(R"({"source": "serial@/dev/a:57600", "share": "no"})").options.share);
  EXPECT_EQ(transport::to_string(read(R"({"share": "0.0.0.0:9100"})").options.share->listen), "0.0.0.0:9100");
  EXPECT_EQ(transport::to_string(read(R"({"share": "[::1]:9100"})").options.share->listen), "[::1]:9100");
  EXPECT_EQ(transport::to_string(read(R"({"share": 0})").options.share->listen), "127.0.0.1:0");
  EXPECT_THAT(read(R"({"share": "65536"})").errors, HasSubstr("expected no, a port"));
  EXPECT_THAT(read(R"({"share": "all"})").errors, HasSubstr("'all'"));
  for (const std::string wrong : {"::1:9100", "[::1:9100", ":9100", "0.0.0.0:", "0.0.0.0:65536"})
    EXPECT_THAT(read(R"({"share": ")" + wrong + "\"}").errors, HasSubstr("'" + wrong + "', expected no, a port, or"));
}

TEST(WsnOptions, ShareTakes64ClientsUnlessItSaysOtherwise) {
  const auto usual = read(R"({"share": 9100})").options.share;
  EXPECT_EQ(usual->clients, 64u);
  EXPECT_EQ(usual->island, 42);
  EXPECT_EQ(read(R"({"share": 9100, "share-clients": 3})").options.share->clients, 3u);
  EXPECT_THAT(read(R"({"share": 9100, "share-clients": 0})").errors, HasSubstr("networks.wsn.share-clients"));
}

TEST(WsnOptions, WrongOnesNameTheirKey) {
  EXPECT_THAT(read(R"({"source": "usb@/dev/x"})").errors, HasSubstr("networks.wsn.source"));
  EXPECT_THAT(read(R"({"board": "TELOSC"})").errors, HasSubstr("networks.wsn.board"));
  EXPECT_THAT(read(R"({"boards": {"0": "SE1000"}})").errors, HasSubstr("1 to 65532"));
  EXPECT_THAT(read(R"({"boards": {"4": "SE"}})").errors, HasSubstr("networks.wsn.boards.4"));
  EXPECT_THAT(read(R"({"island-check": "10ms"})").errors, HasSubstr("at least 1s"));
  EXPECT_THAT(read("{}", 70000).errors, HasSubstr("islands 1 to 65532"));
  EXPECT_THAT(read(R"({"source": "serial@/dev/a:9600+file@x", "record": "y"})").errors,
              HasSubstr("expected one of them"));
}

TEST(WsnOptions, FilesStandBesideTheConfiguration) {
  const auto options = read(R"({"source": "file@a.log", "record": "b.log"})", 42, "/srv/rubicon").options;
  EXPECT_EQ(options.source.path, "/srv/rubicon/a.log");
  EXPECT_EQ(options.source.record, "/srv/rubicon/b.log");
}

TEST(WsnOptions, ARecordingIsNotPlayedIntoItself) {
  namespace fs = std::filesystem;
  for (const auto* wrong :
       {R"({"source": "file@a.log+file@./a.log"})", R"({"source": "file@a.log", "record": "a.log"})",
        R"({"source": "file@a.log", "record": "/srv/none/../rubicon/a.log"})",
        R"({"source": "file@/srv/rubicon/a.log+file@a.log"})"})
    EXPECT_THAT(read(wrong, 42, "/srv/rubicon").errors, HasSubstr("a file other than the one that is played")) << wrong;
  EXPECT_EQ(read(R"({"source": "file@a.log", "record": "b/a.log"})", 42, "/srv/rubicon").errors, "");
  auto folder = (fs::temp_directory_path() / "rubicon_options_XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  std::ofstream(folder + "/a.log") << "";
  fs::create_symlink("a.log", folder + "/link");
  EXPECT_THAT(read(R"({"source": "file@a.log", "record": "link"})", 42, folder).errors, HasSubstr("a file other than"));
  fs::remove_all(folder);
}

TEST(MoteTags, AreReadAsTheyAreWritten) {
  EXPECT_EQ(parse_tag("mote/3/6/17").value(), (MoteTag{MoteTag::Kind::kNet, 3, 6, 17, false, std::nullopt}));
  EXPECT_EQ(parse_tag("mote/3/6/17/reliable").value(), (MoteTag{MoteTag::Kind::kNet, 3, 6, 17, true, std::nullopt}));
  EXPECT_EQ(parse_tag("mote/3/6/17/reliable/65534").value(), (MoteTag{MoteTag::Kind::kNet, 3, 6, 17, true, 65534}));
  EXPECT_EQ(parse_tag("mote/am/11").value(), (MoteTag{MoteTag::Kind::kAm, 0, 0, 11, false, std::nullopt}));
  EXPECT_EQ(parse_tag("mote/json").value().kind, MoteTag::Kind::kJson);
  for (const auto* wrong : {"mote", "mote/", "mote/3/6", "mote/3/6/256", "mote/3/6/-1", "mote/03/6/1", "mote/3/6/1/",
                            "mote/3/6/1/unreliable", "mote/3/6/1/reliable/65536", "mote/3/6/1/reliable/1/2", "mote/am",
                            "mote/am/x", "mote/json/x"})
    EXPECT_FALSE(parse_tag(wrong)) << wrong;
}

TEST(MoteAddresses, AreNumbersOfMotes) {
  EXPECT_EQ(mote_address("7"), 7);
  EXPECT_EQ(mote_address("65532"), 65532);
  EXPECT_EQ(receiver_address("7"), 7);
  EXPECT_EQ(receiver_address(""), 65535);
  EXPECT_EQ(mote_address(""), std::nullopt);
  for (const auto* wrong : {"0", "65533", "65534", "65535", "-1", "7 ", "07", "x", "65536"}) {
    EXPECT_EQ(mote_address(wrong), std::nullopt) << wrong;
    EXPECT_EQ(receiver_address(wrong), std::nullopt) << wrong;
  }
}

}  // namespace
}  // namespace rubicon::networks::wsn
