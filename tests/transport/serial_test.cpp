#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// An empty folder, for as long as this lives.
class Folder {
 public:
  Folder() {
    auto name = (std::filesystem::temp_directory_path() / "rubicon_serial_XXXXXX").string();
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string path(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// One end of a line and all that it received.
struct SerialEnd {
  std::string heard;
  int connected = 0;
  std::vector<Error> failures;
  std::unique_ptr<ByteStream> stream;

  StreamCallbacks calls() {
    return {[this] { ++connected; }, [this](ByteView bytes) { heard += base::as_text(bytes); },
            [this](Error error) { failures.push_back(std::move(error)); }};
  }
  Result<void> keep(Result<std::unique_ptr<ByteStream>> made) {
    if (!made) return fail(made.error());
    stream = std::move(*made);
    return {};
  }
  Result<void> open(Transports& transports, const std::string& path, unsigned baud = 115200) {
    return keep(transports.open_serial({path, baud}, calls()));
  }
  Result<void> plug(Transports& transports, const std::string& path) {
    return keep(transports.make_pty(path, calls()));
  }
  void send(std::string_view text) { EXPECT_TRUE(stream->send(base::as_bytes(text))); }
};

/// A device (a pseudo-terminal, or one of memory) and the program that has its line open.
class Serial : public ::testing::TestWithParam<bool> {
 protected:
  Serial() {
    if (GetParam()) {
      world = std::make_unique<MachineWorld>();
      path = folder.path("sink");
    } else {
      world = std::make_unique<MemoryWorld>();
    }
  }
  Transports& transports() { return world->transports(); }
  void connect() {
    ASSERT_TRUE(device.plug(transports(), path));
    ASSERT_TRUE(program.open(transports(), path));
    EXPECT_EQ(program.connected, 0) << "never from inside the call";
    ASSERT_TRUE(world->until([&] { return program.connected == 1 && device.connected == 1; }));
  }

  Folder folder;
  std::string path = "/dev/ttyUSB0";
  std::unique_ptr<World> world;
  SerialEnd device, program;
};

TEST_P(Serial, EveryByteGoesBothWaysUnchanged) {
  connect();
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all.push_back(static_cast<char>(byte));
  device.send(all);
  program.send(all);
  ASSERT_TRUE(world->until([&] { return device.heard.size() >= 256 && program.heard.size() >= 256; }));
  EXPECT_EQ(device.heard, all);
  EXPECT_EQ(program.heard, all);
}

TEST_P(Serial, WhatIsSentBeforeTheLineIsThereWaitsForIt) {
  ASSERT_TRUE(device.plug(transports(), path));
  ASSERT_TRUE(program.open(transports(), path));
  program.send("early");
  EXPECT_EQ(program.stream->queued(), 5u);
  ASSERT_TRUE(world->until([&] { return device.heard == "early"; }));
  EXPECT_EQ(program.stream->queued(), 0u);
}

TEST_P(Serial, WhatTheDeviceSentBeforeItWasOpenedIsNotReceived) {
  ASSERT_TRUE(device.plug(transports(), path));
  ASSERT_TRUE(world->until([&] { return device.connected == 1; }));
  device.send("old");
  ASSERT_TRUE(world->until([&] { return device.stream->queued() == 0; }));
  ASSERT_TRUE(program.open(transports(), path));
  ASSERT_TRUE(world->until([&] { return program.connected == 1; }));
  device.send("new");
  ASSERT_TRUE(world->until([&] { return program.heard.size() >= 3; }));
  EXPECT_EQ(program.heard, "new");
}

TEST_P(Serial, AnUnpluggedDeviceIsReportedOnceAndNothingIsSentAfterIt) {
  connect();
  device.stream.reset();
  ASSERT_TRUE(world->until([&] { return !program.failures.empty(); }));
  ASSERT_THAT(program.failures, SizeIs(1));
  EXPECT_EQ(program.failures[0].code, ErrorCode::kUnreachable);
  EXPECT_EQ(program.failures[0].text, path + ": unplugged or closed");
  EXPECT_EQ(program.stream->send(base::as_bytes("x")).error().code, ErrorCode::kUnreachable);
  SerialEnd next;
  const auto gone = next.open(transports(), path);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(gone.error().text, HasSubstr(path));
}

TEST_P(Serial, APluggedDeviceIsThereAgain) {
  connect();
  device.stream.reset();
  ASSERT_TRUE(world->until([&] { return !program.failures.empty(); }));
  SerialEnd again, reopened;
  ASSERT_TRUE(again.plug(transports(), path));
  ASSERT_TRUE(reopened.open(transports(), path));
  again.send("hello");
  ASSERT_TRUE(world->until([&] { return reopened.connected == 1; }));
  again.send("hello");
  reopened.send("back");
  EXPECT_TRUE(world->until([&] { return again.heard == "back" && reopened.heard.ends_with("hello"); }));
}

TEST_P(Serial, ADeviceDoesNotNoticeWhoOpensAndClosesItsLine) {
  connect();
  for (int i = 0; i < 3; ++i) {
    program.stream.reset();
    program = SerialEnd();
    ASSERT_TRUE(program.open(transports(), path));
    ASSERT_TRUE(world->until([&] { return program.connected == 1; }));
    device.send("x");
    ASSERT_TRUE(world->until([&] { return program.heard == "x"; }));
  }
  EXPECT_THAT(device.failures, IsEmpty());
}

TEST_P(Serial, OnlyOneProgramHasALine) {
  connect();
  SerialEnd second;
  const auto refused = second.open(transports(), path);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_THAT(refused.error().text, HasSubstr(path));
  program.stream.reset();
  EXPECT_TRUE(second.open(transports(), path));
}

TEST_P(Serial, UnknownBaudRatesAreRefusedAndTheOthersTaken) {
  ASSERT_TRUE(device.plug(transports(), path));
  for (const unsigned baud : {0u, 1u, 56700u, 115201u, 4294967295u}) {
    const auto refused = program.open(transports(), path, baud);
    ASSERT_FALSE(refused) << baud;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
    EXPECT_THAT(refused.error().text, HasSubstr(path));
  }
  for (const unsigned baud : {1200u, 19200u, 57600u, 115200u, 230400u, 460800u, 921600u, 4000000u}) {
    SerialEnd other;
    EXPECT_TRUE(other.open(transports(), path, baud)) << baud;
  }
}

TEST_P(Serial, AHeldLineLosesNothingAndPushesBack) {
  connect();
  program.stream->hold(true);
  const std::string block(1024, 'x');
  std::size_t taken = 0;
  Result<void> sent;
  for (int i = 0; i < 5000 && (sent = device.stream->send(base::as_bytes(block))); ++i) {
    taken += block.size();
    ASSERT_TRUE(world->until([] { return true; }));
  }
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kBusy);
  EXPECT_THAT(sent.error().text, HasSubstr(path));
  EXPECT_GT(device.stream->queued(), ByteStream::kMaxQueued - block.size());
  EXPECT_THAT(program.heard, IsEmpty());
  program.stream->hold(false);
  ASSERT_TRUE(world->until([&] { return program.heard.size() >= taken; }));
  EXPECT_EQ(program.heard.size(), taken);
  EXPECT_EQ(device.stream->queued(), 0u);
}

TEST_P(Serial, TheStreamMayBeDestroyedWhileItIsCalled) {
  for (int when = 0; when < 3; ++when) {
    SerialEnd plugged;
    ASSERT_TRUE(plugged.plug(transports(), path));
    std::unique_ptr<ByteStream> mortal;
    int called = 0;
    const auto die = [&](int now) {
      if (now == when) ++called, mortal.reset();
    };
    StreamCallbacks calls{[&] { die(0); }, [&](ByteView) { die(1); }, [&](const Error&) { die(2); }};
    mortal = std::move(transports().open_serial({path, 115200}, std::move(calls))).value();
    plugged.send("x");
    ASSERT_TRUE(world->until([&] { return plugged.connected == 1; }));
    if (when == 1) plugged.send("x");
    if (when == 2) plugged.stream.reset();
    ASSERT_TRUE(world->until([&] { return called == 1; })) << when;
    EXPECT_EQ(mortal, nullptr);
  }
}

TEST_P(Serial, WhatIsNoPathOfADeviceIsNotFound) {
  for (const auto& nowhere : {folder.path("nothing"), std::string(), std::string("a\0b", 3)}) {
    const auto refused = program.open(transports(), nowhere);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kNotFound);
  }
}

INSTANTIATE_TEST_SUITE_P(On, Serial, ::testing::Bool(),
                         [](const auto& machine) { return std::string(machine.param ? "TheMachine" : "Memory"); });

TEST(MachineSerial, WhatIsNoSerialLineIsInvalidAndDoesNotBlock) {
  Folder folder;
  MachineWorld world;
  const auto fifo = folder.path("fifo");
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  for (const auto& path : {fifo, folder.path(""), std::string("/dev/null")}) {
    SerialEnd program;
    const auto refused = program.open(world.local, path);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
    EXPECT_EQ(refused.error().text, path + ": is not a serial line");
  }
}

TEST(MachineSerial, ALineIsRawAndAsFastAsAsked) {
  Folder folder;
  MachineWorld world;
  SerialEnd device, program;
  const auto path = folder.path("sink");
  ASSERT_TRUE(device.plug(world.local, path));
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(descriptor, 0) << "another program can open the pseudo-terminal";
  termios settings{};
  ASSERT_EQ(::tcgetattr(descriptor, &settings), 0);
  settings.c_cflag |= HUPCL;
  ASSERT_EQ(::tcsetattr(descriptor, TCSANOW, &settings), 0);
  ASSERT_TRUE(program.open(world.local, path, 57600));
  ASSERT_EQ(::tcgetattr(descriptor, &settings), 0);
  ::close(descriptor);
  EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B57600));
  EXPECT_EQ(::cfgetispeed(&settings), static_cast<speed_t>(B57600));
  EXPECT_EQ(settings.c_cflag & (CSIZE | PARENB | CSTOPB | CRTSCTS | CLOCAL | CREAD),
            static_cast<tcflag_t>(CS8 | CLOCAL | CREAD));
  EXPECT_EQ(settings.c_cflag & HUPCL, 0u) << "closing a line must not reset the board behind it";
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), 0u);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF | ICRNL), 0u);
  EXPECT_EQ(settings.c_oflag & OPOST, 0u);
}

TEST(MachineSerial, ADeviceWithoutAReaderForLongIsReceivedOnceAProgramOpensIt) {
  Folder folder;
  MachineWorld world;
  SerialEnd device, program;
  ASSERT_TRUE(device.plug(world.local, folder.path("sink")));
  ASSERT_TRUE(world.until([&] { return device.connected == 1; }));
  const std::string block(1024, 'x');
  while (device.stream->send(base::as_bytes(block)))
    ;
  ASSERT_TRUE(program.open(world.local, folder.path("sink")));
  ASSERT_TRUE(world.until([&] { return device.stream->queued() == 0 && !program.heard.empty(); }));
  program.heard.clear();
  device.send("new");
  EXPECT_TRUE(world.until([&] { return program.heard.ends_with("new"); }));
}

TEST(MachinePty, TheLinkIsThereAsLongAsTheDevice) {
  namespace fs = std::filesystem;
  Folder folder;
  MachineWorld world;
  const auto path = folder.path("sink");
  SerialEnd device, next;
  ASSERT_TRUE(device.plug(world.local, path));
  const auto first = fs::read_symlink(path).string();
  EXPECT_TRUE(first.starts_with("/dev/pts/"));
  const auto refused = next.plug(world.local, path);
  ASSERT_FALSE(refused) << "the device behind it lives";
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_EQ(refused.error().text, path + ": cannot make a pseudo-terminal: another program has one there");
  EXPECT_EQ(fs::read_symlink(path).string(), first);
  ASSERT_TRUE(next.open(world.local, path)) << "it is a line as before";
  next.stream.reset();
  device.stream.reset();
  EXPECT_FALSE(fs::is_symlink(path));
  ASSERT_TRUE(device.plug(world.local, path));
  fs::remove(path);
  ASSERT_TRUE(next.plug(world.local, path));
  const auto second = fs::read_symlink(path).string();
  device.stream.reset();
  EXPECT_EQ(fs::read_symlink(path).string(), second) << "it is not ours any more";
}

/// A terminal that is no simulator's: the program that made the link before is gone, and the system gave its number
/// away.
TEST(MachinePty, ALinkToAnotherTerminalIsReplaced) {
  namespace fs = std::filesystem;
  Folder folder;
  MachineWorld world;
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::array<char, 128> name{};
  ASSERT_EQ(::grantpt(master) | ::unlockpt(master) | ::ptsname_r(master, name.data(), name.size()), 0);
  fs::create_symlink(name.data(), folder.path("sink"));
  SerialEnd device;
  EXPECT_TRUE(device.plug(world.local, folder.path("sink")));
  EXPECT_NE(fs::read_symlink(folder.path("sink")).string(), name.data());
  ::close(master);
}

/// A killed maker leaves its link, and the next one gets the same number of the system.
TEST(MachinePty, ALinkToTheVeryTerminalThatIsOursNowIsOurs) {
  namespace fs = std::filesystem;
  Folder folder;
  MachineWorld world;
  std::string number;
  {
    SerialEnd killed;
    ASSERT_TRUE(killed.plug(world.local, folder.path("sink")));
    number = fs::read_symlink(folder.path("sink")).string();
  }
  fs::create_symlink(number, folder.path("sink"));
  SerialEnd next;
  const auto made = next.plug(world.local, folder.path("sink"));
  EXPECT_TRUE(made) << made.error().text;
}

TEST(MachinePty, SaysWhyThereIsNone) {
  Folder folder;
  MachineWorld world;
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &old), 0);
  const int free = ::dup(0);
  ASSERT_GE(free, 0);
  ::close(free);
  const rlimit none{static_cast<rlim_t>(free), old.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  SerialEnd device;
  const auto refused = device.plug(world.local, folder.path("sink"));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &old), 0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_THAT(refused.error().text, HasSubstr(folder.path("sink") + ": cannot make a pseudo-terminal: Too many open"));
}

TEST(MachinePty, ALinkThatADeadMakerLeftIsReplacedAndNothingElseIs) {
  namespace fs = std::filesystem;
  Folder folder;
  MachineWorld world;
  SerialEnd device;
  fs::create_symlink("/dev/pts/987654", folder.path("left"));
  EXPECT_TRUE(device.plug(world.local, folder.path("left")));
  fs::create_symlink("/dev/null", folder.path("other"));
  fs::create_directory(folder.path("directory"));
  for (const auto* name : {"other", "directory"}) {
    const auto refused = device.plug(world.local, folder.path(name));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kDuplicate);
    EXPECT_THAT(refused.error().text, HasSubstr(folder.path(name)));
  }
  EXPECT_EQ(fs::read_symlink(folder.path("other")).string(), "/dev/null");
  EXPECT_EQ(device.plug(world.local, folder.path("no/such")).error().code, ErrorCode::kIo);
  EXPECT_EQ(device.plug(world.local, "").error().code, ErrorCode::kInvalid);
}

TEST(MachineSerial, WithoutALoopThereAreNoLines) {
  EXPECT_EQ(LocalTransports().open_serial({}, {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(LocalTransports().make_pty("x", {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(MemoryTransports().open_serial({}, {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(MemoryTransports().make_pty("x", {}).error().code, ErrorCode::kUnsupported);
}

TEST(MemorySerial, ATestSeesHowALineWasOpenedAndCutsItsBytesIntoPieces) {
  MemoryWorld world;
  SerialEnd device, program;
  auto& lines = world.memory.serial();
  device.stream = lines.plug("/dev/ttyUSB0", device.calls());
  EXPECT_TRUE(lines.is_plugged("/dev/ttyUSB0"));
  EXPECT_EQ(lines.opened("/dev/ttyUSB0"), nullptr);
  std::vector<std::string> pieces;
  auto calls = program.calls();
  calls.received = [&](ByteView bytes) { pieces.emplace_back(base::as_text(bytes)); };
  program.stream = std::move(world.memory.open_serial({"/dev/ttyUSB0", 57600}, std::move(calls))).value();
  ASSERT_NE(lines.opened("/dev/ttyUSB0"), nullptr);
  EXPECT_EQ(lines.opened("/dev/ttyUSB0")->baud, 57600u);
  lines.segment = 2;
  device.send("abcde");
  world.time.run_for(1s);
  EXPECT_THAT(pieces, ElementsAre("ab", "cd", "e"));
  EXPECT_EQ(world.memory.make_pty("/dev/ttyUSB0", {}).error().code, ErrorCode::kDuplicate);
}

}  // namespace
}  // namespace rubicon::transport
