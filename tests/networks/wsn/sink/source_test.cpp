#include "networks/wsn/sink/sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::networks::wsn::sink {
namespace {

using testing::HasSubstr;
using Kind = Source::Kind;

Source read(std::string_view text) {
  const auto source = parse_source(text);
  EXPECT_TRUE(source.has_value()) << text << ": " << source.error().text;
  return source.value_or(Source{});
}

Error refused(std::string_view text) {
  const auto source = parse_source(text);
  EXPECT_FALSE(source.has_value()) << text << " was read as " << to_string(*source);
  return source ? Error{} : source.error();
}

TEST(SourceString, KnowsEveryPlatformOfTheOriginal) {
  const std::vector<std::pair<std::string, unsigned>> rows{
      {"mica", 19200},      {"mica2", 57600},    {"mica2dot", 19200}, {"telos", 115200},  {"telosb", 115200},
      {"tinynode", 115200}, {"tmote", 115200},   {"micaz", 57600},    {"eyesIFX", 57600}, {"intelmote2", 115200},
      {"iris", 57600},      {"shimmer", 115200}, {"ucmini", 115200}};
  for (const auto& [platform, baud] : rows) {
    const auto source = read("serial@/dev/ttyUSB0:" + platform);
    EXPECT_EQ(source.kind, Kind::kSerial);
    EXPECT_EQ(source.path, "/dev/ttyUSB0") << platform;
    EXPECT_EQ(source.baud, baud) << platform;
  }
}

TEST(SourceString, TakesANumberForTheBaudRate) {
  EXPECT_EQ(read("serial@/dev/ttyS0:38400").baud, 38400U);
}

TEST(SourceString, ReadsDevicePathsWithColons) {
  const auto source = read("serial@/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0:telosb");
  EXPECT_EQ(source.path, "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0");
  EXPECT_EQ(source.baud, 115200U);
}

TEST(SourceString, ReadsStreamsInBothSpellings) {
  for (const auto* text : {"network@10.0.0.9:19202", "network@10.0.0.9,19202", "10.0.0.9,19202"}) {
    const auto source = read(text);
    EXPECT_EQ(source.kind, Kind::kStream) << text;
    EXPECT_EQ(source.host, "10.0.0.9") << text;
    EXPECT_EQ(source.port, 19202) << text;
  }
}

TEST(SourceString, ReadsForwardersAndFiles) {
  const auto forwarder = read("sf@sink-host.example:9002");
  EXPECT_EQ(forwarder.kind, Kind::kForwarder);
  EXPECT_EQ(forwarder.host, "sink-host.example");
  EXPECT_EQ(forwarder.port, 9002);
  const auto file = read("file@/var/log/motes:old.log");
  EXPECT_EQ(file.kind, Kind::kFile);
  EXPECT_EQ(file.path, "/var/log/motes:old.log");
}

TEST(SourceString, ReadsIpv6InBrackets) {
  EXPECT_EQ(read("sf@[::1]:9002").host, "::1");
  EXPECT_EQ(read("network@[fe80::1%eth0],19202").host, "fe80::1%eth0");
  EXPECT_EQ(to_string(read("sf@[::1]:9002")), "sf@[::1]:9002");
}

TEST(SourceString, RecordsToAFileBehindEitherSign) {
  for (const auto* text : {"serial@/dev/ttyUSB0:telosb+file@/var/x.log", "serial@/dev/ttyUSB0:telosb>>file@/var/x.log",
                           "serial@/dev/ttyUSB0:telosb >> file@/var/x.log"}) {
    const auto source = read(text);
    EXPECT_EQ(source.record, "/var/x.log") << text;
    EXPECT_EQ(to_string(source), "serial@/dev/ttyUSB0:115200") << text;
  }
  EXPECT_EQ(read("file@a.log+file@b.log").record, "b.log");
}

TEST(SourceString, IsReadBackFromItsOwnSpelling) {
  for (const auto* text :
       {"serial@/dev/ttyUSB0:57600", "network@host:1", "network@[::1]:65535", "sf@localhost:9002", "file@x"}) {
    EXPECT_EQ(to_string(read(text)), text);
  }
}

struct Refusal {
  std::string_view text;
  ErrorCode code;
  std::vector<std::string> says;
};

TEST(SourceString, SaysWhatIsWrongWhereAndWhatWasExpected) {
  constexpr auto kBad = ErrorCode::kInvalid;
  constexpr auto kNot = ErrorCode::kUnsupported;
  const std::vector<Refusal> refusals{
      {"", kBad, {"position 1", "\"\"", "serial@DEVICE:BAUD", "sf@HOST:PORT"}},
      {"/dev/ttyUSB0", kBad, {"position 1", "/dev/ttyUSB0", "serial@DEVICE:BAUD"}},
      {"bluetooth@x", kBad, {"bluetooth@x", "expected", "network@HOST:PORT"}},
      {"SERIAL@/dev/ttyUSB0:telosb", kBad, {"SERIAL@", "expected"}},
      {"serial@/dev/ttyUSB0", kBad, {"position 8", "/dev/ttyUSB0", "DEVICE:BAUD"}},
      {"serial@:telosb", kBad, {"position 8", "DEVICE:BAUD"}},
      {"serial@/dev/ttyUSB0:TelosB", kBad, {"position 21", "\"TelosB\"", "baud rate"}},
      {"serial@/dev/ttyUSB0:0", kBad, {"position 21", "baud rate"}},
      {"serial@/dev/ttyUSB0:", kBad, {"position 21", "baud rate"}},
      {"serial@/dev/ttyUSB0:-9600", kBad, {"-9600"}},
      {"serial@/dev/ttyUSB0:56700", kBad, {"position 21", "\"56700\"", "57600"}},
      {"serial@/dev/ttyUSB0:1", kBad, {"position 21", "baud rate"}},
      {"serial@/dev/ttyUSB0:99999999999", kBad, {"99999999999", "4000000"}},
      {"sf@host", kBad, {"position 4", "HOST:PORT with a port"}},
      {"sf@host,9002", kBad, {"HOST:PORT"}},
      {"sf@host:", kBad, {"position 9", "port of 1 to 65535"}},
      {"sf@host:0", kBad, {"\"0\"", "port of 1 to 65535"}},
      {"sf@host:65536", kBad, {"\"65536\"", "port of 1 to 65535"}},
      {"sf@host:http", kBad, {"\"http\"", "port"}},
      {"sf@:9002", kBad, {"position 4", "host name"}},
      {"sf@::1:9002", kBad, {"position 4", "brackets"}},
      {"sf@fe80::1:9002", kBad, {"brackets"}},
      {"sf@[::1]", kBad, {"HOST:PORT"}},
      {"sf@[::1:9002", kBad, {"HOST:PORT"}},
      {"sf@[]:9002", kBad, {"HOST:PORT"}},
      {"sf@[localhost]:9002", kBad, {"HOST:PORT", "brackets"}},
      {"sf@[::1]:0", kBad, {"position 10", "\"0\"", "port of 1 to 65535"}},
      {"sf@[fe80::1%a!]:9002", kBad, {"position 4", "host name or address"}},
      {"network@host:1,2", kBad, {"position 9", "HOST:PORT"}},
      {"network@a,b:1", kBad, {"position 9", "\"a,b\"", "host name"}},
      {"sf@[::1]x:9002", kBad, {"HOST:PORT"}},
      {"network@a b:1", kBad, {"\"a b\"", "host name"}},
      {"file@", kBad, {"position 6", "path"}},
      {"tossim-serial@localhost", kNot, {"tossim-serial@localhost", "network@HOST:PORT"}},
      {"tossim-radio", kNot, {"tossim-radio", "network@HOST:PORT"}},
      {"peis@6541:wsn", kNot, {"peis@6541:wsn", "share:", "sf@HOST:PORT"}},
      {"log@x.log", kNot, {"log@x.log", "file@PATH", "type `log`"}},
      {"sf@h:1+peis@wsn", kNot, {"position 8", "peis@wsn", "use `share:` of the network to offer the sink"}},
      {"sf@h:1+serial@/dev/x:telosb", kBad, {"position 8", "one source"}},
      {"sf@h:1>>network@h:2", kBad, {"position 9", "one source"}},
      {"sf@h:1+tossim-serial", kBad, {"one source"}},
      {"sf@h:1+log@x", kBad, {"log@x", "file@PATH", "record"}},
      {"sf@h:1+", kBad, {"position 8", "\"\"", "file@PATH"}},
      {"sf@h:1+file@", kBad, {"position 13", "path"}},
      {"sf@h:1+file@a+file@b", kBad, {"position 15", "file@b", "one file"}},
      {"file@a+file@a", kBad, {"a file other than the one that is played"}},
      {"file@/data/a+b.log", kBad, {"position 14", "b.log", "a path cannot contain them"}},
      {"sf@h:1+file@/data/a>>b", kBad, {"position 22", "a path cannot contain them"}},
  };
  for (const auto& [text, code, says] : refusals) {
    const auto error = refused(text);
    EXPECT_EQ(error.code, code) << text;
    for (const auto& part : says) EXPECT_THAT(error.text, HasSubstr(part)) << text;
  }
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
