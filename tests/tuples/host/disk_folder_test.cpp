#include "tuples/host/folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <fstream>

#include "rubicon/tuple_space.hpp"
#include "support/collecting_log.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/poll_loop.h"
#include "tuples/component.h"
#include "tuples/host/host_ecology.h"

namespace rubicon::tuples::host {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr OwnerId kHome{6541}, kAtHand{70001};

/// One of the two loops with the sockets of the machine.
struct AnyLoop {
  virtual ~AnyLoop() = default;
  virtual Scheduler& scheduler() = 0;
  virtual transport::Transports& transports() = 0;
  virtual void turn() = 0;
};

struct LoopOfDaemon final : AnyLoop {
  Scheduler& scheduler() override { return loop.scheduler(); }
  transport::Transports& transports() override { return local; }
  void turn() override { loop.context().run_one_for(10ms); }
  transport::Loop loop;
  transport::LocalTransports local{loop};
};

struct LoopOfClient final : AnyLoop {
  Scheduler& scheduler() override { return *loop; }
  transport::Transports& transports() override { return sockets; }
  void turn() override {
    loop->wait(10ms);
    loop->poll();
  }
  std::unique_ptr<transport::PollLoop> loop = std::move(*transport::PollLoop::make());
  transport::PollSockets sockets{*loop};
};

struct FolderOnDisk : testing::TestWithParam<bool> {
  Result<std::unique_ptr<Folder>> open(const std::string& space = "default") {
    return open_disk_folder({path, false}, space, loop->scheduler(), loop->transports());
  }
  std::unique_ptr<HostEcology> enter() {
    return std::move(*HostEcology::open(std::move(*open()), {}, loop->scheduler(), log));
  }
  /// Runs the loop until that is so; 30 s are a failure.
  bool until(const std::function<bool()>& reached) {
    const auto end = std::chrono::steady_clock::now() + 30s;
    while (!reached() && std::chrono::steady_clock::now() < end) loop->turn();
    return reached();
  }
  static mode_t mode_of(const std::string& file) {
    struct stat found {};
    return ::lstat(file.c_str(), &found) == 0 ? found.st_mode & 07777 : 0;
  }

  FolderOnDisk() { std::filesystem::create_directory(around); }
  ~FolderOnDisk() override { std::filesystem::remove_all(around); }

  /// Short, because a path of a socket has 107 bytes at most.
  const std::filesystem::path around = std::filesystem::temp_directory_path() / fmt::format("rh{}", ::getpid());
  std::string path = around / "meet";
  support::CollectingLog log;
  std::unique_ptr<AnyLoop> loop =
      GetParam() ? std::unique_ptr<AnyLoop>(std::make_unique<LoopOfClient>()) : std::make_unique<LoopOfDaemon>();
};
INSTANTIATE_TEST_SUITE_P(On, FolderOnDisk, testing::Bool(),
                         [](const auto& of) { return of.param ? "TheLoopOfAClient" : "TheLoopOfADaemon"; });

TEST_P(FolderOnDisk, IsMadeForItsUserAloneWhateverTheUmask) {
  const auto before = ::umask(0);
  auto folder = std::move(*open());
  const auto listener = std::move(*folder->open("00000000000000aa", [](auto) { return transport::LocalCallbacks{}; }));
  ::umask(before);
  EXPECT_EQ(mode_of(path), 0700U);
  EXPECT_EQ(mode_of(path + "/default"), 0700U);
  EXPECT_EQ(mode_of(path + "/default/00000000000000aa.sock"), 0660U);
  EXPECT_TRUE(folder->is_open());
  EXPECT_THAT(*folder->doors(), ElementsAre(Door{"00000000000000aa", path + "/default", true}));
}

TEST_P(FolderOnDisk, RefusesAFolderThatOthersMayWriteToOrThatIsALinkOrAFile) {
  std::filesystem::create_directory(path);
  ::chmod(path.c_str(), 0777);
  EXPECT_THAT(open().error().text, HasSubstr("has permissions 777, expected 700"));
  std::filesystem::remove(path);
  std::filesystem::create_directory(around / "elsewhere");
  std::filesystem::create_directory_symlink(around / "elsewhere", path);
  const auto linked = open();
  EXPECT_EQ(linked.error().code, ErrorCode::kRefused);
  EXPECT_THAT(linked.error().text, HasSubstr("is a symbolic link: remove it, or set RUBICON_FOLDER"));
  std::filesystem::remove(path);
  std::ofstream(path) << "x";
  EXPECT_THAT(open().error().text, HasSubstr("is not a folder"));
}

TEST_P(FolderOnDisk, RefusesASpaceThatIsNoNameAndAPathThatIsTooLong) {
  EXPECT_THAT(open("../x").error().text,
              HasSubstr("'../x' is not a space, expected 1 to 40 characters of A-Z a-z 0-9 . _ -, the first no dot"));
  EXPECT_FALSE(open(""));
  path = around / std::string(100, 'd');
  auto folder = std::move(*open());
  const auto listener = folder->open("00000000000000aa", [](auto) { return transport::LocalCallbacks{}; });
  EXPECT_EQ(listener.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(listener.error().text, HasSubstr("the path of a socket has at most 107 bytes"));
}

TEST_P(FolderOnDisk, AnIdIsLockedOnceAndTheErrorNamesWhoHasIt) {
  auto one = std::move(*open()), other = std::move(*open());
  auto lock = std::move(*one->lock(kHome));
  const auto second = other->lock(kHome);
  EXPECT_EQ(second.error().code, ErrorCode::kDuplicate);
  EXPECT_THAT(second.error().text, HasSubstr("component 6541 runs already: tuples_host_tes"));
  EXPECT_THAT(second.error().text, HasSubstr("pid " + std::to_string(::getpid()) + " of "));
  lock.reset();
  EXPECT_TRUE(other->lock(kHome));
}

TEST_P(FolderOnDisk, ALockThatIsALinkIsRefusedAndOneThatWasRemovedLocksNothing) {
  auto folder = std::move(*open());
  std::ofstream(around / "victim") << "x";
  std::filesystem::create_symlink(around / "victim", path + "/default/70001.lock");
  EXPECT_EQ(folder->lock(kAtHand).error().code, ErrorCode::kRefused);
  const auto lock = std::move(*folder->lock(kHome));
  std::filesystem::remove(path + "/default/6541.lock");
  const auto again = std::move(*folder->lock(kHome));
  EXPECT_EQ(folder->lock(kHome).error().code, ErrorCode::kDuplicate) << "the new file is locked";
}

TEST_P(FolderOnDisk, FilesThatAreNoSocketsAndSocketsOfTheDeadAreNobody) {
  auto folder = std::move(*open());
  std::ofstream(path + "/default/00000000000000bb.sock") << "x";
  const auto left = path + "/default/00000000000000cc.sock";
  const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  left.copy(static_cast<char*>(address.sun_path), left.size());
  ASSERT_EQ(::bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(dead);
  const auto lock = path + "/default/70009.lock";
  std::ofstream(lock) << "x";
  auto ecology = enter();
  const auto link = std::move(*ecology->join(kAtHand));
  const TupleSpace space(kAtHand, loop->scheduler(), *link);
  EXPECT_TRUE(until([&] { return ecology->knows_all(); }));
  EXPECT_THAT(space.peers(), testing::IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(left)) << "what a killed process left is removed";
  EXPECT_FALSE(std::filesystem::exists(lock)) << "and its lock";
  EXPECT_TRUE(log.lines.empty()) << log.lines.front();
}

/// Who looks for left locks holds each for a moment: of many that start at once, some would find their own taken.
TEST_P(FolderOnDisk, AStartTouchesNoLocksWhereNobodyWasKilled) {
  const auto folder = std::move(*open());
  const auto lock = path + "/default/70009.lock";
  std::ofstream(lock) << "x";
  const auto ecology = enter();
  EXPECT_TRUE(until([&] { return ecology->knows_all(); }));
  EXPECT_TRUE(std::filesystem::exists(lock));
}

TEST_P(FolderOnDisk, ComponentsMeetOnSocketsAndTheEndOfOneIsKnown) {
  auto one = enter(), other = enter();
  auto island = std::move(*one->join(kHome));
  auto home = std::make_unique<TupleSpace>(kHome, loop->scheduler(), *island);
  ASSERT_TRUE(home->set("lamp", "on"));
  const std::string largest(std::size_t{1} << 20, 'x');
  ASSERT_TRUE(home->set("picture", largest));
  const auto tool = std::move(*other->join(kAtHand));
  TupleSpace space(kAtHand, loop->scheduler(), *tool);
  const auto all = space.subscribe(pattern("**"), {}, [](const Event&) {});
  EXPECT_TRUE(until([&] { return space.get(kHome, "lamp") && space.get(kHome, "picture"); }));
  EXPECT_EQ(space.get(kHome, "picture")->value, largest);
  std::vector<PeerEvent> events;
  const auto watch = space.watch_peers([&](OwnerId, PeerEvent event) { events.push_back(event); });
  home.reset();
  island.reset();
  one.reset();
  EXPECT_TRUE(until([&] { return !events.empty(); }));
  EXPECT_THAT(events, ElementsAre(PeerEvent::kLeft));
}

}  // namespace
}  // namespace rubicon::tuples::host
