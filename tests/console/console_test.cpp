#include "console/console.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <csignal>
#include <string>
#include <vector>

namespace rubicon::console {
namespace {

using namespace std::chrono_literals;

/// A pipe with both ends, closed at the end of the test.
struct Pipe {
  Pipe() { EXPECT_EQ(::pipe(ends.data()), 0); }
  ~Pipe() {
    close_reader();
    close_writer();
  }
  void close_reader() { close(0); }
  void close_writer() { close(1); }
  void close(std::size_t end) {
    if (ends[end] >= 0) ::close(ends[end]);
    ends[end] = -1;
  }
  void put(const std::string& text) { EXPECT_EQ(::write(ends[1], text.data(), text.size()), ssize_t(text.size())); }
  std::string take_all() {
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    std::string all;
    std::array<char, 65536> buffer;
    for (auto count = ::read(ends[0], buffer.data(), buffer.size()); count > 0;
         count = ::read(ends[0], buffer.data(), buffer.size())) {
      all.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return all;
  }

  std::array<int, 2> ends{-1, -1};
};

class Console : public testing::Test {
 protected:
  /// Runs until the condition holds; the bound is for a broken build only.
  template <class Condition>
  void run_until(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (!condition() && std::chrono::steady_clock::now() < end) {
      context_.restart();
      context_.run_one_for(10ms);
    }
    EXPECT_TRUE(condition());
  }

  ConsoleReader::Callbacks calls() {
    ConsoleReader::Callbacks calls;
    calls.line = [this](std::string_view line) { lines_.emplace_back(line); };
    calls.too_long = [this] { lines_.emplace_back("(too long)"); };
    calls.end = [this] { ended_ = true; };
    calls.pause = [this] { return paused_; };
    return calls;
  }

  boost::asio::io_context context_;
  Pipe pipe_;
  std::vector<std::string> lines_;
  bool ended_ = false, paused_ = false, closed_ = false;
};

TEST_F(Console, WritesLinesInOrder) {
  ConsoleWriter writer(context_, pipe_.ends[1], [] {});
  writer.answer("one");
  EXPECT_TRUE(writer.event("two"));
  run_until([&] { return writer.empty(); });
  EXPECT_EQ(pipe_.take_all(), "one\ntwo\n");
}

TEST_F(Console, ASlowReaderCostsEventsButNeverBlocksNorGrows) {
  ConsoleWriter writer(context_, pipe_.ends[1], [] {});
  for (int i = 0; i < 30'000; ++i) {
    writer.event("a line of a fast event " + std::to_string(i));
    context_.restart();
    context_.poll();
  }
  EXPECT_TRUE(writer.crowded());
  EXPECT_GT(writer.dropped(), 10'000U);
  std::string all;
  run_until([&] {
    all += pipe_.take_all();
    return writer.empty();
  });
  all += pipe_.take_all();
  EXPECT_EQ(all.find("a line of a fast event 0\n"), 0U);
  EXPECT_EQ(30'000U - static_cast<std::size_t>(std::count(all.begin(), all.end(), '\n')), writer.dropped());
}

TEST_F(Console, LongLinesAreBoundedByTheirBytes) {
  ConsoleWriter writer(context_, pipe_.ends[1], [] {});
  for (int i = 0; i < 40; ++i) writer.event(std::string(1024 * 1024, 'x'));
  EXPECT_GE(writer.dropped(), 23U);
}

TEST_F(Console, AnswersAreNeverDropped) {
  ConsoleWriter writer(context_, pipe_.ends[1], [] {});
  for (std::size_t i = 0; i < ConsoleWriter::kMaxLines + 5; ++i) writer.answer("x");
  EXPECT_FALSE(writer.event("one too many"));
  std::string all;
  run_until([&] {
    all += pipe_.take_all();
    return writer.empty();
  });
  all += pipe_.take_all();
  EXPECT_EQ(all.size(), 2 * (ConsoleWriter::kMaxLines + 5));
}

TEST_F(Console, AClosedReaderIsTold) {
  ::signal(SIGPIPE, SIG_IGN);
  ConsoleWriter writer(context_, pipe_.ends[1], [this] { closed_ = true; });
  pipe_.close_reader();
  writer.answer("nobody hears this");
  run_until([this] { return closed_; });
  EXPECT_TRUE(writer.empty());
  writer.answer("nor this");
  EXPECT_TRUE(writer.empty());
}

TEST_F(Console, LeavesTheFlagsOfTheDescriptorAlone) {
  ConsoleWriter writer(context_, pipe_.ends[1], [] {});
  writer.answer("x");
  run_until([&] { return writer.empty(); });
  EXPECT_EQ(::fcntl(pipe_.ends[1], F_GETFL) & O_NONBLOCK, 0);
}

TEST_F(Console, CallsWhenAllIsWritten) {
  ConsoleWriter writer(context_, pipe_.ends[1], [] {});
  bool empty = false;
  writer.answer("x");
  writer.when_empty([&] { empty = true; });
  EXPECT_FALSE(empty);
  run_until([&] { return empty; });
}

TEST_F(Console, ReadsLinesHoweverTheyArrive) {
  ConsoleReader reader(context_, pipe_.ends[0], 100, calls());
  pipe_.put("one\ntw");
  run_until([this] { return lines_.size() == 1; });
  pipe_.put("o\n\nlast");
  pipe_.close_writer();
  run_until([this] { return ended_; });
  EXPECT_EQ(lines_, (std::vector<std::string>{"one", "two", "", "last"}));
}

TEST_F(Console, CutsLinesThatAreTooLong) {
  ConsoleReader reader(context_, pipe_.ends[0], 10, calls());
  pipe_.put("0123456789\n0123456789X\nok\n");
  pipe_.close_writer();
  run_until([this] { return ended_; });
  EXPECT_EQ(lines_, (std::vector<std::string>{"0123456789", "(too long)", "ok"}));
}

TEST_F(Console, ReadsNothingWhilePaused) {
  paused_ = true;
  ConsoleReader reader(context_, pipe_.ends[0], 100, calls());
  pipe_.put("one\n");
  context_.run_for(50ms);
  EXPECT_TRUE(lines_.empty());
  paused_ = false;
  run_until([this] { return lines_.size() == 1; });
}

TEST_F(Console, TakesFilesAndDevicesThatNobodyCanWaitFor) {
  const int null = ::open("/dev/null", O_RDWR);
  ConsoleWriter writer(context_, null, [] {});
  writer.answer("x");
  ConsoleReader reader(context_, null, 100, calls());
  run_until([&] { return writer.empty() && ended_; });
  ::close(null);
}

}  // namespace
}  // namespace rubicon::console
